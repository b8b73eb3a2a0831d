# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The layers: each module imports only from its own layer or from below.

cli -> ros, fleet, library -> report, recordings, simulators -> files -> diagnosis, health
-> signals -> estimation, parameters -> robot -> plant -> kernels
"""
import ast
import re
import runpy
import subprocess
import sys

from sources import MODULES, nodes, PACKAGE, ROOT

# First part of a module's name below the package -> its height.
LAYERS = {
    'kernels': 0, 'plant': 1, 'robot': 1,
    'parameters': 2, 'estimation': 2,
    'signals': 3,
    'diagnosis': 4, 'health': 4,
    'watch': 4.5,
    'files': 5,
    'report': 6, 'recordings': 6, 'simulators': 6,
    'ros': 7, 'fleet': 7, 'library': 7,
    'cli': 8, '__main__': 9, 'compiled': 9,
}
EVERYWHERE = ('errors', 'plain_data', 'presentation', 'removed', '__init__')
CORE = 4.5  # up to here nothing reads, writes or asks the clock
OUTSIDE_WORLD = {
    'asyncio', 'glob', 'io', 'logging', 'multiprocessing', 'os', 'pathlib', 'shutil', 'signal',
    'socket', 'subprocess', 'sys', 'tempfile', 'threading', 'time', 'yaml'}
ON_DISK = tuple(('kernels', name) for name in (
    'kernel', 'library', 'build')) + (('kernels', 'translate', 'program'),)  # C, machine code
ROS = {'rclpy', 'launch', 'launch_ros', 'ament_index_python', 'builtin_interfaces',
       'rcl_interfaces', 'std_srvs'}


def name_of(path):
    """Return the parts of the module's name below the package, () for the package itself."""
    parts = path.relative_to(PACKAGE).with_suffix('').parts
    return parts[:-1] if parts[-1] == '__init__' else parts


def imported(path):
    """Yield (line, dotted name) of every import in the file, those inside functions, too."""
    for node in nodes(path):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}:{node.lineno}: relative import'
            for alias in node.names:
                yield node.lineno, f'{node.module}.{alias.name}'


def first_part(dotted):
    """Return the layer's name in gearbox_monitor.layer.rest; '__init__' for its attributes."""
    part = (dotted.split('.') + ['__init__'])[1]
    is_module = (PACKAGE / part).is_dir() or (PACKAGE / f'{part}.py').is_file()
    return part if is_module else '__init__'


def test_imports_only_downwards():
    wrong = []
    for path in MODULES:
        name = name_of(path) or ('__init__',)
        assert name[0] in (*LAYERS, *EVERYWHERE), f'{name[0]} has no layer yet: give it one here'
        height = LAYERS.get(name[0], -1)
        for line, dotted in imported(path):
            top, problem = dotted.split('.')[0], ''
            if top == 'gearbox_monitor':
                part = first_part(dotted)
                if part not in EVERYWHERE and LAYERS[part] > height:
                    problem = 'imports upwards'
            elif top in ROS or top.endswith('_msgs'):
                problem = '' if name[0] == 'ros' else 'ROS outside of ros'
            elif 0 <= height <= CORE and name not in ON_DISK and top in OUTSIDE_WORLD:
                problem = 'the core does no I/O'
            if problem:
                wrong.append(f'{path.relative_to(PACKAGE)}:{line}: {dotted}: {problem}')
    assert not wrong, '\n'.join(wrong)


def test_rooms_are_drawn_and_say_what_they_are_and_list_their_public_names():
    """In three sentences: the room, what goes in, what comes out."""
    maps = runpy.run_path(str(ROOT / 'docs/make_map.py'))
    maps['page'].__globals__['nodes'] = nodes  # parsed already
    assert (ROOT / 'docs/map.svg').read_text(encoding='utf-8') == maps['page'](), \
        'run python docs/make_map.py'
    for room, modules in maps['public_names']().items():
        text = (PACKAGE / room / '__init__.py').read_text(encoding='utf-8')
        assert maps['with_list'](text, modules) == text, f'{room}: run python docs/make_map.py'
        words = ast.get_docstring(ast.parse(text)).partition('Public names')[0]
        assert len(re.findall(r'[.](?=\s|$)', words)) >= 3, room


def test_package_imports_no_benchmark():
    """Benchmarks stand beside the package and are not installed with it."""
    assert (PACKAGE.parent / 'benchmarks/__main__.py').is_file()
    wrong = [f'{path.relative_to(PACKAGE)}:{line}: {dotted}'
             for path in MODULES for line, dotted in imported(path)
             if dotted.split('.')[0] == 'benchmarks']
    assert not wrong, '\n'.join(wrong)


def test_core_neither_opens_nor_prints():
    core = [p for p in MODULES if name_of(p) and LAYERS.get(name_of(p)[0], 9) <= CORE]
    assert len(core) > 50
    calls = [(path, node) for path in core for node in nodes(path)
             if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    assert not [f'{path}:{node.lineno}' for path, node in calls
                if node.func.id in ('open', 'print', 'input')]


def test_commands_start_without_slow_parts_of_scipy():
    """`import scipy` loads a part at its first use; `from scipy.signal import` at each start."""
    code = ('import sys\nfrom importlib import import_module\n'
            'from gearbox_monitor.cli.main import COMMANDS\n'
            'for module, _, _ in COMMANDS.values():\n'
            '    import_module(f"gearbox_monitor.cli.{module}")\n'
            'print(*({"scipy.signal", "scipy.stats", "scipy.optimize"} & set(sys.modules)))')
    done = subprocess.run([sys.executable, '-c', code], cwd=PACKAGE.parent, check=True,
                          capture_output=True, text=True)
    assert done.stdout.split() == []


def test_offline_commands_need_no_ros():
    """The core and the commands for analysts import where there is no rclpy."""
    code = ('import sys; sys.modules["rclpy"] = None\n'
            'import gearbox_monitor.health.monitor, gearbox_monitor.recordings.replay\n'
            'import gearbox_monitor.cli.replay, gearbox_monitor.cli.import_\n'
            'from gearbox_monitor.cli.main import main; main(["--help"])')
    subprocess.run([sys.executable, '-c', code], cwd=PACKAGE.parent, check=True,
                   stdout=subprocess.DEVNULL)
