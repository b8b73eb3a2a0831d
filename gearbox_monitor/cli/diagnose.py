# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Say why a drive moves otherwise than its model: the place, the effect, its size, what it closes.

The model is run freely over windows of 1 s of the recording. What is left against both encoders is
the gap. Every effect of the library (docs/effects.md) is fitted on the first windows, the ranking
is tested on the last ones. Only torque and positions and the model file are read, nothing else in
the recording. Record 10 to 14 s at 1 kHz in which the drive reverses often and loads both flanks.

BAG is a bag, or a CSV file with the columns t,u,motor,arm[,arm_torque] (s, N m, rad, N m, all on
the arm side; u may be a current, see torque_constant in the model file). Several recordings of one
drive are judged together. arm_torque, or effort[arm] in the bag, is used as the known load where
the model file has arm_load: measured.

usage examples:
  gearbox_monitor diagnose BAG --model drive.yaml
  gearbox_monitor diagnose BAG --model drive.yaml --out found     # and the model that closes it,
                                                                  # and a page about all of it
  gearbox_monitor diagnose BAG --model drive.yaml --validate BAG2 --json verdict.json
  gearbox_monitor diagnose run1.csv run2.csv --model drive.yaml --exclude lugre viscous_drift
  gearbox_monitor diagnose BAG --model drive.yaml --json - | jq .effect

exit code: 0 no gap found (verdict none), 1 a gap found (effect or unknown), 2 bad usage or input.
"""
import json
import math
import os
from pathlib import Path
import sys

import numpy as np
from tqdm import tqdm

from gearbox_monitor import __version__
from gearbox_monitor.bag.csv import read_csv
from gearbox_monitor.bag.joint_input import find_input
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.replay import read_samples
from gearbox_monitor.cli.diagnose_report import text
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import expect_folder_of, load_model, save_model
from gearbox_monitor.identification.diagnose import diagnose
from gearbox_monitor.kernels.jit import COMPILED
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.quality.admission import admitted
from gearbox_monitor.report import overlay_plot
from gearbox_monitor.report.diagnosis_evidence import gather
from gearbox_monitor.report.diagnosis_page import diagnosis_page, PageContext
from gearbox_monitor.report.suggestion import suggestion
from gearbox_monitor.report.words import headline
from gearbox_monitor.ros.processes import cores

DRAWN = ('report.html', 'overlay.png', 'where.png', 'ranking.png')
CSV = ('.csv', '.tsv', '.txt', '.csv.gz', '.tsv.gz', '.txt.gz')
FIELDS = {'t': 'stamp', 'u': 'effort of the motor', 'motor': 'position of the motor',
          'arm': 'position of the arm', 'arm_torque': 'effort of the arm'}


def add_drive(parser):
    """Declare the model file and where in a bag the readings stand."""
    parser.add_argument('--model', metavar='FILE', required=True, help='model file of the drive')
    parser.add_argument('--topic', default='joint_states', help='topic of the inputs, in bags')
    parser.add_argument('--motor-joint', metavar='NAME', default='motor',
                        help='name of the motor joint, in bags (default: motor)')
    parser.add_argument('--arm-joint', metavar='NAME', default='arm',
                        help='name of the arm joint, in bags (default: arm)')


def add_inputs(parser):
    """Declare recordings of one drive and what add_drive does."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='bag directory, .mcap file or CSV file; several of one drive at once')
    add_drive(parser)


def add_arguments(parser):
    """Declare the options."""
    add_inputs(parser)
    parser.add_argument('--validate', metavar='BAG2',
                        help='second recording of the drive, to test the result on')
    parser.add_argument('--out', metavar='DIR',
                        help='write verdict.json, report.html, pictures and, where an effect '
                        'was named, drive.closed.yaml: the model with it')
    parser.add_argument('--json', metavar='FILE',
                        help='write the verdict as JSON; - prints it, and nothing else')
    parser.add_argument('--exclude', metavar='ID', nargs='+', default=[],
                        help='effects that are not tried: what only they explain is unknown')
    parser.add_argument('--only', metavar='ID', nargs='+', help='effects that are tried, no other')
    parser.add_argument('--seed', metavar='N', type=int, default=0,
                        help='of the intervals (default: 0); same seed, same answer')
    parser.add_argument('--jobs', metavar='N', type=int, default=cores(),
                        help='threads (default: one per core); does not change the answer')


def run(args):
    """Run the command; returns the exit code."""
    if args.jobs < 1:
        raise InputError(f'--jobs: {args.jobs}, expected a whole number >= 1')
    if args.seed < 0:
        raise InputError(f'--seed: {args.seed}, expected a whole number >= 0')
    only = _ids('--only', args.only) if args.only else None
    exclude = _ids('--exclude', args.exclude)
    if not [i for i in (only or library()) if i not in exclude]:
        raise InputError('--exclude: no effect is left, expected at least one to try')
    targets = _targets(args)
    model = load_model(args.model)
    paths = [*args.bag, *([args.validate] if args.validate else [])]
    recordings, notes = [], []
    for path in paths:
        recording, said = load(path, model, args)
        recordings.append(recording)
        notes += [f'{Path(path).name}: {note}' if len(paths) > 1 else note for note in said]
    if not COMPILED:
        print('diagnose: without numba this takes about a hundred times longer', file=sys.stderr)
    validate = recordings.pop() if args.validate else None
    with tqdm(total=100, desc='diagnose', disable=None, leave=False,
              bar_format='{percentage:3.0f} %|{bar:20}| {elapsed} {desc}') as bar:
        verdict = diagnose(recordings, model, validate=validate, only=only, exclude=exclude,
                           seed=args.seed, jobs=args.jobs, progress=shown_by(bar))
    data = plain(verdict.to_dict())
    data['warnings'] = [*notes, *(data.get('warnings') or [])]
    closed = verdict.model if data['verdict'] == 'effect' else None
    command = suggestion(data, recordings, args.model, args.out)
    drawn = {}
    if args.out:
        drawn = draw(verdict, data, recordings, model, command, args)
    written = write(targets, data, closed, drawn, args)
    if args.json == '-':
        print(dump(data))
    else:
        print(text(data, recordings, model, written, args.validate, command))
    return 0 if data['verdict'] == 'none' else 1


def _ids(option, words):
    """Return the ids in `words`, also those joined by commas. Raises InputError."""
    known = library()
    ids = [word for words_ in words for word in words_.split(',') if word]
    for name in ids:
        if name not in known:
            raise InputError(f'{option}: unknown effect {name!r}, expected ids of '
                             f'{", ".join(known)}')
    return tuple(dict.fromkeys(ids))


def shown_by(bar):
    """Return progress(done, total, text) that moves `bar`, never back."""
    def progress(done, total, text=''):
        if text:
            bar.set_description_str(text[:40], refresh=False)
        bar.update(max(0.0, 100.0 * done / max(total, 1) - bar.n))
    return progress


# ---------------------------------------------------------------------- input


def load(path, model, args):
    """
    Return (gap.recording.Recording, notes) of the bag or CSV file `path`, checked.

    Raises InputError, also where no verdict on the drive is possible from it.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f'{path}: no such file or directory, expected a bag or a CSV file')
    reads = _read_csv if path.is_file() and path.name.lower().endswith(CSV) else _read_bag
    t, u, y, arm_torque, place, notes = reads(path, model, args)
    recording, told = admitted(t, u, y, arm_torque, str(path), place, model, Path(args.model).name)
    return recording, [*notes, *told]


def _read_csv(path, model, _):
    """Return t, u, y, arm_torque, place, notes of a CSV file."""
    columns = read_csv(path)
    return (columns.t, columns.u * model.torque_constant,
            np.column_stack([columns.motor, columns.arm]), columns.arm_torque, columns.place,
            list(columns.notices))


def _read_bag(path, model, args):
    """Return t (ns), u, y, arm_torque, place, notes of a bag: of its measurement topic alone."""
    with open_bag(path) as reader:
        topic = find_input(reader, args.topic).topic
        samples = read_samples(reader, args.motor_joint, args.arm_joint, model, topic).samples
        notes = [reader.notice] if reader.notice else []

    def place(row, field):
        return f'{topic}, sample {row}, {FIELDS[field]}'
    return samples.stamp_ns, samples.u[:, 0], samples.y, samples.u[:, 1], place, notes


# ---------------------------------------------------------------------- output


def plain(value):
    """Return `value` of plain Python types; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def dump(data):
    """Return `data` as JSON."""
    return json.dumps(data, indent=2, allow_nan=False)


def draw(verdict, data, recordings, model, command, args):
    """
    Return {file of --out: HTML or Figure} about a Verdict and its plain `data`.

    command: see report.suggestion.
    """
    found = gather(verdict, recordings, model, args.jobs)
    title = headline(data)
    drawn = {
        'report.html': diagnosis_page(data, found, recordings, PageContext(
            data['verdict'] == 'effect', args.validate, command)),
        'overlay.png': overlay_plot.windows_figure(found.overlay, found.windows, title,
                                                   on_axis('rad', model.axis)),
        'where.png': overlay_plot.maps_figure(found, title)}
    if data['gains']:
        drawn['ranking.png'] = overlay_plot.ranking_figure(data['gains'], data['effect'], title)
    return drawn


def _targets(args):
    """Return {what: Path} of the files to write. Raises InputError where one exists."""
    targets = {}
    if args.json and args.json != '-':
        targets['json'] = Path(args.json)
    if args.out:
        targets['verdict'] = Path(args.out) / 'verdict.json'
        targets['model'] = Path(args.out) / 'drive.closed.yaml'
        targets.update((name, Path(args.out) / name) for name in DRAWN)
    for path in targets.values():
        if path.exists():
            raise InputError(f'{path}: exists, expected a new file')
    expect_folder_of(args.out)
    expect_folder_of(args.json)
    if args.out and Path(args.out).exists() and not Path(args.out).is_dir():
        raise InputError(f'{args.out}: is a file, expected a directory')
    return targets


def write(targets, data, closed, drawn, args):
    """
    Write the files `targets` of _targets, all of them or none; returns their Paths.

    closed: DriveModel with the effect, or None; drawn: see draw. Raises InputError.
    """
    comment = [f'Written by gearbox_monitor {__version__} diagnose from '
               f'{", ".join(args.bag)} and {args.model}.', headline(data)]
    parts, made = [], None
    try:
        if args.out and not Path(args.out).exists():
            made = Path(args.out)
            made.mkdir()
        for what, path in targets.items():
            if what == 'model' and closed is None or what in DRAWN and what not in drawn:
                continue
            part = path.with_name(f'.{path.name}.{os.getpid()}.part')
            parts.append((part, path))
            if what == 'model':
                save_model(part, closed, comment)
            elif what.endswith('.png'):
                drawn[what].savefig(part, dpi=110, format='png')
            else:
                part.write_text(drawn.get(what) or dump(data) + '\n', encoding='utf-8')
        for part, path in parts:
            os.replace(part, path)
        made = None
    except OSError as error:
        raise InputError(f'{error.filename}: {error.strerror}, expected a new, writable file') \
            from None
    finally:
        for part, _ in parts:
            part.unlink(missing_ok=True)
        if made is not None and made.is_dir() and not any(made.iterdir()):
            made.rmdir()
    return [path for _, path in parts]
