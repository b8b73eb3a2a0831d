# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compile ahead what nodes and commands need, so that no first start waits for it.

Each of them runs on a short example in a process of its own; its machine code goes to the cache
that every start reads. After an upgrade, kernels whose sources are the same stay; on another kind
of processor, none does.

usage examples:
  gearbox_monitor compile                          # all, with the default filter
  gearbox_monitor compile node --params estimator.yaml --model drive.yaml
  gearbox_monitor compile node replay --filter ukf aekf
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
import hashlib
import json
from pathlib import Path
from tempfile import TemporaryDirectory
import time
from typing import Any

from gearbox_monitor.cli import main as command_line
from gearbox_monitor.cli.options import check_filter, estimator_options
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.health.warm_up import warm_up
from gearbox_monitor.kernels.jit import CACHE_FOLDER, CACHE_PROBLEM, COMPILED, KERNELS
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.ros.first_start import in_child

# The command lines of what is compiled; {filter} stands for one of --filter, {name} for a new
# file. `node` is none of them: it takes samples one by one.
EXAMPLE = 'example {name} --rest 1 --seconds 8 --motion varied'
LINES = {
    'node': '', 'example': EXAMPLE, 'replay': 'replay bag --filter {filter} --out {name}',
    'check': 'check bag', 'tune': 'tune bag --filter {filter} --out {name}.yaml',
    'diagnose': 'diagnose bag --model bag.drive.yaml --jobs 1'}
FINDING = 1  # exit code
DONE = 'compiled.json'  # in the cache: what is compiled, and of which sources


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('commands', metavar='FOR', nargs='*',
                        help=f'{", ".join(LINES)} (default: all)')
    parser.add_argument('--filter', metavar='F', nargs='+',
                        help='filters of node, replay and tune (default: as --params, ekf)')
    parser.add_argument('--model', metavar='FILE', help='model file of the drive of the node')
    parser.add_argument('--params', metavar='FILE', help='ROS parameter file of the node')
    parser.set_defaults(topic=JOINT_STATES)


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for name in args.commands:
        if name not in LINES:
            raise InputError(f'FOR: {name!r}, expected one of {", ".join(LINES)}')
    if not COMPILED or CACHE_FOLDER is None:
        raise InputError(CACHE_PROBLEM or 'numba: not in use, expected it')
    parameters, model_file = estimator_options(args)
    filters = [check_filter(name) for name in args.filter or [parameters.get('filter', 'ekf')]]
    model = load_model(model_file or str(config_path('drive.yaml')))
    state = _state()
    done = _done()
    with TemporaryDirectory() as folder:
        for name in args.commands or LINES:
            for kind in filters if name == 'node' or '{filter}' in LINES[name] else ['']:
                settings = EstimatorParameters.from_mapping({**parameters, 'filter': kind}) if (
                    name == 'node') else None
                key = f'{name} {kind}' + (f' {model} {settings}' if settings else '')
                if done.get(key) != state:
                    _compile(name, kind, folder, model, settings)
                    done[key] = state
                    Path(CACHE_FOLDER, DONE).write_text(json.dumps(done), encoding='utf-8')
                else:
                    print(f'{name} {kind}'.rstrip() + ': is compiled')
    sizes = [path.stat().st_size for path in _files()]
    print(f'{CACHE_FOLDER}: {len(sizes)} kernels, {sum(sizes) / 1e6:.0f} MB')
    return 0


def _compile(name: str, kind: str, folder: str, model: DriveModel,
             settings: EstimatorParameters | None) -> None:
    """Run `name` with the filter `kind` in a process of its own that works in `folder`."""
    begin, files = time.monotonic(), len(_files())
    if settings is not None:
        _call(name, folder, warm_up, model, settings)
    else:
        if 'bag' in LINES[name].split() and not Path(folder, 'bag').exists():
            _call('example', folder, _run_line, EXAMPLE.format(name='bag'))
        line = LINES[name].format(filter=kind, name=f'{name}_{kind}')
        _call(name, folder, _run_line, line)
    count = len(_files()) - files
    print(f'{name} {kind}'.rstrip() + f': {count} kernels compiled, '
          f'{time.monotonic() - begin:.1f} s', flush=True)


def _call(name: str, folder: str, function: Callable[..., object], *arguments: Any) -> None:
    """Call `function` for `name` in a process of its own; raise InputError where that fails."""
    child = in_child(function, *arguments, folder=folder)
    if child.returncode:
        lines = child.stderr.decode('utf-8', 'replace').strip().splitlines() or ['']
        raise InputError(f'{name}: ended with exit code {child.returncode}: {lines[-1]}')


def _run_line(line: str) -> int:
    """
    Run a command `line`; return 0, or the exit code of an error: a finding is none.

    A crash raises here, and ends the process with another exit code than 0.
    """
    code = command_line.main(line.split())
    return 0 if code == FINDING else code


def _files() -> list[Path]:
    """Return the files of compiled kernels."""
    return list(Path(CACHE_FOLDER or '').glob('*.nbc'))


def _state() -> str:
    """Return a digest of the sources of the package, and of what makes machine code of them."""
    from numba.core.registry import cpu_target
    processor = cpu_target.target_context.codegen().magic_tuple()
    digest = hashlib.sha256(f'{KERNELS} {processor}'.encode())
    for path in sorted(Path(__file__).parents[1].rglob('*.py')):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _done() -> dict[str, str]:
    """Return the digests of what is compiled already."""
    try:
        content: dict[str, str] = json.loads(Path(CACHE_FOLDER or '', DONE).read_bytes())
        return content
    except (OSError, ValueError):
        return {}
