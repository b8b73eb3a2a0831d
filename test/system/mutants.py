# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Mutants: one wrong operator or number at a time, which the tests of its module should notice.

A copy of the checkout gets one change: < for >=, + for -, * for /, and for or, a condition turned
round, a number twice as large or one more. The tests of the module run on it; a mutant that they
pass survives, and is printed with its line. Fields of a class stay as they are, and constants of a
module that are numbers alone: another limit, start or step of a search is another decision, no
error.

usage examples:
  python test/system/mutants.py --n 4
  python test/system/mutants.py --rooms filters alerts --n 20 --seed 7
"""
import ast
from collections.abc import Mapping
import os
from pathlib import Path
import random
import shutil
import subprocess
import sys
import tempfile
from types import MappingProxyType

from script import run_script

from benchmarks.harness import bar_lines, BarTable, require_whole
from gearbox_monitor.errors import InputError

ROOT = Path(__file__).parents[2]
PARTS = ('gearbox_monitor', 'benchmarks', 'test', 'config', 'docs', 'setup.cfg', 'setup.py',
         'package.xml', 'README.md', 'CONTRIBUTING.md', 'ruff.toml')
KILLED = 0.9   # share that the tests should notice
TIMEOUT = 900  # s: a mutant that never ends is noticed
TRACES = 'test_traces.py::test_traces_are_the_stored_ones'


def by_module(folder: str, modules: str, *tests: str) -> dict[str, tuple[str, ...]]:
    """Return {module: tests} of the `modules` of a folder."""
    return {f'{folder}/{module}.py': tests for module in modules.split()}


# Room -> {module: its tests, files or folders, the quickest first}.
ROOMS = MappingProxyType({
    'filters': {
        **by_module('estimation/filters', 'ekf', f'{TRACES}[filters]',
                    'estimation/test_filter.py', 'test_laws.py'),
        **by_module('estimation/filters', 'aekf', f'{TRACES}[filters]', 'estimation/test_aekf.py',
                    'test_laws.py'),
        **by_module('estimation/filters', 'ukf srukf', f'{TRACES}[filters]',
                    'estimation/test_sigma_filters.py', 'test_laws.py'),
        **by_module('estimation', 'process_model rts_smoother', f'{TRACES}[filters]',
                    'test_laws.py', 'estimation/test_filter.py', 'estimation/test_smoother.py',
                    'estimation/test_consider.py', 'estimation/test_sigma_filters.py')},
    'likelihood': {
        'estimation/innovation_filter.py': ('estimation/test_innovation_filter.py',
                                            'diagnosis/joint/test_innovations.py'),
        'diagnosis/joint/innovations.py': ('diagnosis/joint/test_innovations.py',
                                           'diagnosis/joint/test_innovation_fit.py',
                                           'diagnosis/joint/test_fit_nominal.py',
                                           'estimation/test_innovation_filter.py',
                                           'diagnosis/joint/test_setpoint.py'),
        'diagnosis/joint/drive_recordings.py': ('diagnosis/joint/test_drive_recordings.py',
                                                'diagnosis/joint/test_decision.py')},
    'contest': by_module('diagnosis', 'contest hypothesis', f'{TRACES}[contest]',
                         'diagnosis/test_contest.py', 'diagnosis/test_question.py'),
    'alerts': {
        **by_module('health', 'judgement alarms backlash/change backlash/wear '
                    'backlash/change_tests', f'{TRACES}[wear]', 'health/test_outcome.py',
                    'health/test_wear.py', 'health/test_change.py', 'health/test_drift.py'),
        **by_module('health', 'backlash/features', f'{TRACES}[windows]', 'health/test_features.py',
                    'health/test_drift.py'),
        **by_module('health/checks', 'innovation row_checks', 'health/test_row_checks.py',
                    'health/test_alarms.py', 'health/test_trust.py')},
    'signals': by_module('signals', 'checks examine finding jumps recording stamps uniform wiring',
                         f'{TRACES}[signals]', 'signals')})
# Of two numbers that are hardly ever equal, < and <= are one.
PAIRS = ((ast.Lt, ast.GtE), (ast.Gt, ast.LtE), (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot),
         (ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.And, ast.Or))
SWAPPED = {**dict(PAIRS), **{b: a for a, b in PAIRS}}


def add_arguments(parser):
    """Declare the options in `parser`."""
    parser.add_argument('--rooms', metavar='ROOM', nargs='+', default=list(ROOMS),
                        help=f'of {", ".join(ROOMS)} (default: all)')
    parser.add_argument('--n', metavar='N', type=int, default=3, help='mutants of each module, '
                        'drawn at random (default: %(default)s)')
    parser.add_argument('--seed', metavar='S', type=int, default=0, help='of the draw')


def is_setting(statement: ast.stmt) -> bool:
    """Return whether `statement` gives names numbers that are written out, or a call of them."""
    if not isinstance(statement, ast.Assign):
        return False
    value = statement.value
    parts = ([*value.args, *(part.value for part in value.keywords)]
             if isinstance(value, ast.Call) else [value])
    try:
        return all(ast.literal_eval(part) is not None for part in parts)
    except ValueError:
        return False


class Mutator(ast.NodeTransformer):
    """Counts the places of a module that can be changed, and changes number `at` of them."""

    def __init__(self, at=-1):
        self.at, self.count, self.line = at, 0, 0

    def chosen(self, node):
        """Return whether `node` is the place to change."""
        self.count += 1
        if self.count - 1 != self.at:
            return False
        self.line = node.lineno
        return True

    def visit_Module(self, node):  # noqa: N802
        """Leave settings as they are."""
        node.body = [statement if is_setting(statement) else self.visit(statement)
                     for statement in node.body]
        return node

    def visit_FunctionDef(self, node):  # noqa: N802
        """Leave decorators, types and defaults as they are."""
        node.body = [self.visit(statement) for statement in node.body]
        return node

    def visit_ClassDef(self, node):  # noqa: N802
        """Leave decorators and fields as they are."""
        node.body = [self.visit(statement) if isinstance(statement, ast.FunctionDef)
                     else statement for statement in node.body]
        return node

    def visit_AnnAssign(self, node):  # noqa: N802
        """Leave the type of a variable as it is."""
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def visit_Compare(self, node):  # noqa: N802
        """Swap the first comparison."""
        self.generic_visit(node)
        if type(node.ops[0]) in SWAPPED and self.chosen(node):
            node.ops[0] = SWAPPED[type(node.ops[0])]()
        return node

    def visit_BinOp(self, node):  # noqa: N802
        """Swap + and -, * and /."""
        self.generic_visit(node)
        if type(node.op) in SWAPPED and self.chosen(node):
            node.op = SWAPPED[type(node.op)]()
        return node

    def visit_BoolOp(self, node):  # noqa: N802
        """Swap and, or."""
        self.generic_visit(node)
        if self.chosen(node):
            node.op = SWAPPED[type(node.op)]()
        return node

    def visit_If(self, node):  # noqa: N802
        """Turn a condition round."""
        self.generic_visit(node)
        if self.chosen(node):
            node.test = ast.copy_location(ast.UnaryOp(ast.Not(), node.test), node.test)
        return node

    def visit_Constant(self, node):  # noqa: N802
        """Double a number, add one to a whole one."""
        if type(node.value) in (int, float) and self.chosen(node):
            whole = isinstance(node.value, int)
            node.value = node.value + 1 if whole else 2.0 * node.value or 1.0
        return node


def mutated(source: str, at: int) -> tuple[str, int]:
    """
    Return (source with place number `at` changed, the line of that place).

    Args:
        source: of a module.
        at: number of a place, below places(source).
    """
    mutator = Mutator(at)
    tree = mutator.visit(ast.parse(source))
    return ast.unparse(ast.fix_missing_locations(tree)) + '\n', mutator.line


def places(source: str) -> int:
    """Return how many places of a module can be changed."""
    mutator = Mutator()
    mutator.visit(ast.parse(source))
    return mutator.count


def noticed(checkout: Path, tests: tuple[str, ...]) -> bool:
    """Return whether a test of `tests` fails in a `checkout`, or does not end."""
    command = [sys.executable, '-m', 'pytest', '-q', '-x', '-p', 'no:cacheprovider',
               *(str(checkout / 'test' / test) for test in tests)]
    env = {**os.environ, 'PYTHONPATH': str(checkout), 'XDG_CACHE_HOME': str(checkout / 'cache')}
    try:
        return subprocess.run(command, cwd=checkout, env=env, timeout=TIMEOUT,
                              capture_output=True).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def survivors(checkout: Path, modules: Mapping[str, tuple[str, ...]], n: int,
              draw: random.Random) -> list[str]:
    """
    Run mutants of some modules; return a line for each and print it if it survives.

    Args:
        checkout: a copy, whose modules are changed and restored.
        modules: {module: its tests}.
        n: mutants of each.
        draw: random numbers.
    """
    out = []
    for module, tests in modules.items():
        path = checkout / 'gearbox_monitor' / module
        source = path.read_text(encoding='utf-8')
        if noticed(checkout, tests):
            raise InputError(f'{", ".join(tests)}: fails as it stands, expected tests that pass')
        for at in sorted(draw.sample(range(places(source)), min(n, places(source)))):
            text, line = mutated(source, at)
            path.write_text(text, encoding='utf-8')
            killed = noticed(checkout, tests)
            out.append('' if killed else f'{module}:{line} place {at}')
            print(f'{module}:{line} place {at}: {"killed" if killed else "SURVIVES"}: '
                  f'{source.splitlines()[line - 1].strip()}', flush=True)
        path.write_text(source, encoding='utf-8')
    return out


def run(args):
    """Run the mutants that `args` asks for; return 1 if too many survive."""
    require_whole('--n', args.n)
    for room in args.rooms:
        if room not in ROOMS:
            raise InputError(f'--rooms: {room!r}, expected some of {", ".join(ROOMS)}')
    bars, draw = BarTable(), random.Random(args.seed)
    with tempfile.TemporaryDirectory() as folder:
        checkout = Path(folder, 'checkout')
        for part in PARTS:
            source = ROOT / part
            if source.is_dir():
                shutil.copytree(source, checkout / part, ignore=shutil.ignore_patterns(
                    '__pycache__', '*.pyc'))
            else:
                shutil.copy(source, checkout / part)
        build = checkout / 'gearbox_monitor/kernels/build.py'  # each mutant of a kernel compiles
        build.write_text(build.read_text().replace("'-O2'", "'-O0'"))
        for room in args.rooms:
            lines = survivors(checkout, ROOMS[room], args.n, draw)
            bars.judge(f'{room}: killed', lines.count('') / len(lines), low=KILLED,
                       count=f'{lines.count("")} of {len(lines)}')
    print('\n'.join(bar_lines(bars.rows)))
    return 0 if all(row['met'] for row in bars.rows) else 1


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
