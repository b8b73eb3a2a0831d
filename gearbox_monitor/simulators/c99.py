# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A filter with its model as C99 for the firmware of a drive.

The kernels of the node are translated once more, with the numbers of the model as constants and
with what the node holds in arrays as members of a struct. The files in firmware/ are the interface
around them, and the arithmetic that a processor may lack.
"""
from collections.abc import Callable
import math
from pathlib import Path
import re
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import COLUMNS
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.filter_kind import Belief, filter_kind, Scratch
from gearbox_monitor.estimation.filter_setup import described
from gearbox_monitor.estimation.process_model import FRICTION_AT, STATISTICAL, X3, X4
from gearbox_monitor.estimation.sample_loop import LoopSettings, LoopState, Output, Stream
from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.checks.innovation import ErrorWatch, N_SUMS, watch
from gearbox_monitor.health.elastic_regression import (
    add_row, certainty, D_FRICTION, D_RATE, D_TORQUE, D_TWIST, D_U, D_X2, D_X3, D_X4, HALF_GAP,
    N_CARRIED, N_DATA, N_SHAPE, S_GROUP, STIFFNESS, Sums)
from gearbox_monitor.kernels.kernel import inline
from gearbox_monitor.kernels.translate.frame import plain
from gearbox_monitor.kernels.translate.program import Program
from gearbox_monitor.kernels.translate.statements import Function
from gearbox_monitor.kernels.translate.values import (
    Array as ArrayType, constant, ELEMENTS, real, stored, Tuple, type_of, Value, View)
from gearbox_monitor.kernels.types import AnyArray, Array, Layout, Values
from gearbox_monitor.parameters import EstimatorParameters, MIXED
from gearbox_monitor.plant.drive import ALPHA, CC, DriveModel, LAW
from gearbox_monitor.plant.transmission import side

_PREFIX = re.compile('[a-z][a-z0-9_]{0,30}')
_TEMPLATES = Path(__file__).with_name('firmware')
_CODE = """
void gm_init(gm_filter *f)
{
    int i;
@INIT@
}

int gm_step(gm_filter *f, int64_t stamp, const gm_sample *in, gm_output *out)
{
    gm_real inputs[2] = {in->torque, in->load}, outputs[2] = {in->motor, in->arm};
    gm_real *row = &out->x1;
    int64_t code = 0;
    out->flags = (uint32_t)@STEP@;
    return (int)code;
}
"""
_WINDOW = """
void gm_window_begin(gm_window *w, const gm_real *theta, int32_t group)
{
    int i;
@INIT@
    for (i = 0; theta && i < GM_FITTED; i++)
        w->theta[i] = theta[i];
    w->carried[@GROUP@] = (gm_real)(group > 0 ? group : 1);
}

void gm_window_add(gm_window *w, const gm_filter *filter, const gm_output *out)
{
    gm_filter *f = (gm_filter *)filter;
    gm_real *row = (gm_real *)&out->x1;
    @ADD@;
}
"""


class Firmware(NamedTuple):
    """A filter in C99: texts of source and header, and notes, such as on effects left out."""

    source: str
    header: str
    notes: tuple[str, ...]


def firmware(model: DriveModel, parameters: EstimatorParameters | Values | None = None,
             header: str = 'filter.h', prefix: str = 'gm') -> Firmware:
    """
    Return the filter that an Estimator runs, without its smoother, as C99.

    Args:
        model: of the drive.
        parameters: of the estimator, as an Estimator takes them.
        header: name of the header file.
        prefix: that the names of functions and types begin with, `gm` for gm_step; in capitals of
            macros.

    Returns:
        The Firmware.

    Raises:
        InputError: names the parameter that has no form in C.

    """
    if not _PREFIX.fullmatch(prefix):
        raise InputError(f'--prefix: {prefix[:40]!r}, expected up to 31 lower-case letters, '
                         'digits and _, a letter first')
    estimator = Estimator(model, unsmoothed(parameters))
    _expect_known(estimator)
    texts = _texts(estimator)
    title = f'{model.origin.name}: {estimator.parameters.filter.upper()}, tau_K as ' \
            f'{estimator.parameters.tau_k_model}. Written by gearbox_monitor {__version__}.'
    for i, text in enumerate(texts):
        text = text.replace('@HEADER@', header).replace('@TITLE@', title.replace('*/', '* /'))
        if prefix != 'gm':
            text = re.sub(r'\bgm_', f'{prefix}_', text)
            text = re.sub(r'\bGM_', f'{prefix.upper()}_', text)
        texts[i] = text
    return Firmware(texts[0], texts[1], tuple(estimator.warnings))


def _expect_known(estimator: Estimator) -> None:
    """Raise InputError unless the firmware can run what the `estimator` runs."""
    p = estimator.parameters
    for name, value, bad, expected in (
            ('filter', p.filter, filter_kind(p.filter).adaptation is not None,
             'one that does not adapt'),
            ('tau_k_model', p.tau_k_model, p.tau_k_model == MIXED,
             'random_walk, elastic or learned'),
            ('robot_description', p.robot_description[:40], described(p),
             'none: the load by it takes the whole robot')):
        if bad:
            raise InputError(f'{name}: {value}, with --to c expected {expected}')


@inline
def _unknown(x: float) -> float:
    """Stand in for a logarithm: log-likelihoods compare models, for which a drive has no use."""
    return math.nan


def _step_of(loop: Any) -> Callable[..., int]:
    """Return the kernel of one sample of a `loop`, which also returns the flags of `watch`."""
    @inline
    def step(layout: Layout, settings: LoopSettings, p: Array, stream: Stream, state: LoopState,
             belief: Belief, scratch: Scratch, output: Output, judge: ErrorWatch) -> int:
        loop(layout, settings, p, stream, state, belief, scratch, output)
        return watch(output.estimates[0], output.codes[0], stream.stamps[0],
                     state.gate[sample_loop.STARTED], judge)
    return step


@inline
def _add(n: int, p: Array, P: Array, estimate: Array, sums: Sums) -> None:
    """Add an `estimate` of `n` states, whose covariance is `P`, to a window."""
    row, x3 = sums.row, estimate[X3]
    row[D_TWIST], row[D_RATE] = estimate[sample_loop.E_TWIST], estimate[sample_loop.E_TWIST_RATE]
    row[D_X2], row[D_X4], row[D_X3] = estimate[sample_loop.E_X2], estimate[X4], x3
    row[D_FRICTION], row[D_U] = side(p[ALPHA] * x3, p[LAW]), -estimate[sample_loop.E_U]
    row[D_TORQUE] = estimate[sample_loop.E_TAU_K]
    if p[FRICTION_AT] > 0.0:
        row[D_TORQUE] += estimate[sample_loop.E_TAU_E]
    variance = P[X3 * n + X3] + P[X4 * n + X4] - 2.0 * P[X3 * n + X4]
    doubt = LIMITS.deviations * math.sqrt(max(variance, 0.0))
    add_row(sums, certainty(x3, doubt) if p[CC] != 0.0 and doubt > 0.0 else 1.0)


class _Struct:
    """Arrays of the node as members of a C struct: `members` {name: its first content}."""

    def __init__(self, variable: str) -> None:
        self._variable = variable
        self.members: dict[str, AnyArray] = {}

    def place(self, value: Any, name: str = '') -> Value:
        """Return arrays in `value`, whose own name this is, as members; else constants."""
        if isinstance(value, np.ndarray):
            self.members[name] = value
            return _view(f'{self._variable}->{name}', value)
        if isinstance(value, tuple):
            fields = zip(value, type(value)._fields)  # type: ignore[attr-defined]
            return Tuple([self.place(item, field) for item, field in fields], type(value))
        return constant(value)

    def declarations(self) -> str:
        """Return the members in C."""
        return '\n'.join(f'    {_c_type(array)} {name}[{max(array.size, 1)}];'
                         for name, array in self.members.items())

    def content(self) -> str:
        """Return the statements that fill the members: with zeros, then with what is none."""
        lines = [f'    for (i = 0; i < (int)sizeof *{self._variable}; i++)',
                 f'        ((unsigned char *){self._variable})[i] = 0;']
        for name, array in self.members.items():
            if not array.any():
                continue
            numbers = [real(v) if type(v) is float else str(v) for v in array.ravel().tolist()]
            usual = max(numbers, key=numbers.count)
            lines += [f'    for (i = 0; i < {len(numbers)}; i++)',
                      f'        {self._variable}->{name}[i] = {usual};']
            lines += [f'    {self._variable}->{name}[{i}] = {number};'
                      for i, number in enumerate(numbers) if number != usual]
        return '\n'.join(lines)


def _c_type(array: AnyArray) -> str:
    c_type = ELEMENTS[array.dtype.str[1:]][0]
    return 'gm_real' if c_type == 'real' else c_type


def _view(c: str, like: AnyArray) -> View:
    """Return the C array at the pointer `c`, of the shape of `like`."""
    return View(ArrayType(like.dtype.str[1:], like.ndim), c, [str(n) for n in like.shape])


def _call(program: Program, function: Any, values: list[Value]) -> str:
    """Return the C of a call of a kernel."""
    types = tuple(map(type_of, values))
    made: Function = program.instance(plain(function), types)
    return f'{made.name}(' + ', '.join(
        made.expression(value, kind) for value, kind in zip(values, types) if stored(kind)) + ')'


def _texts(estimator: Estimator) -> list[str]:
    """Return source and header of the filter of an `estimator`."""
    program, of_filter = Program('gm_real', {math.log: _unknown}), _Struct('f')
    # What the node changes while it steps is in memory; all else is folded.
    p = of_filter.place(estimator.packed, 'p') if estimator.packed[STATISTICAL] else (
        program.known(estimator.packed))
    one = np.zeros(1, np.int64)
    values = [
        program.known(estimator.states), program.known(estimator.settings), p,
        Tuple([_view('&stamp', one), _view('inputs', np.zeros((1, 2))),
               _view('outputs', np.zeros((1, 2)))], Stream),
        *map(of_filter.place, (estimator._state, estimator._belief, estimator._scratch)),
        Tuple([_view('&code', one), _view('row', np.zeros((1, sample_loop.N_ESTIMATE))),
               _view('0', one[:0]), _view('0', np.zeros((0, 0)))], Output),
        of_filter.place(ErrorWatch(np.zeros((2, N_SUMS)), np.zeros(2, np.int64)))]
    code = _CODE.replace('@STEP@', _call(program, _step_of(sample_loop.run), values))
    code = code.replace('@INIT@', of_filter.content())
    window = ''
    if estimator.parameters.arm_joint:
        of_window, theta = _Struct('w'), np.zeros(N_SHAPE)
        shape = estimator.drive.transmission
        theta[STIFFNESS], theta[HALF_GAP] = shape.stiffness, shape.half_gap
        sums = of_window.place(Sums(
            theta, np.zeros((N_SHAPE, N_SHAPE)), np.zeros(N_SHAPE), np.zeros((3, N_SHAPE)),
            np.zeros(N_DATA), np.zeros(N_CARRIED)))
        added = _call(program, _add, [
            program.known(len(estimator.names)), p, _view('f->P', estimator._belief.P),
            _view('row', np.zeros(sample_loop.N_ESTIMATE)), sums])
        code += _WINDOW.replace('@INIT@', of_window.content()).replace('@ADD@', added).replace(
            '@GROUP@', str(S_GROUP))
        window = (_TEMPLATES / 'window.h').read_text(encoding='utf-8').replace(
            '/*MEMBERS*/', of_window.declarations()).replace('@PARAMETERS@', str(N_SHAPE))
    names = sorted(COLUMNS, key=COLUMNS.__getitem__)
    header = (_TEMPLATES / 'filter.h').read_text(encoding='utf-8')
    for mark, text in (('CONFIG', _config(estimator)), ('STATE', of_filter.declarations()),
                       ('OUTPUT', '\n'.join(f'    gm_real {name};' for name in names)),
                       ('WINDOW', window)):
        header = header.replace(f'/*{mark}*/', text)
    arithmetic = (_TEMPLATES / 'arithmetic.h').read_text(encoding='utf-8')
    return [f'/* SPDX-License-Identifier: Apache-2.0\n *\n * @TITLE@\n */\n#include "@HEADER@"\n'
            f'{arithmetic}\n{program.text()}{code}', header]


def _config(estimator: Estimator) -> str:
    """Return the #define lines of the header."""
    model, parameters = estimator.model, estimator.parameters
    rows = (
        ('N', len(estimator.names), 'states: ' + ', '.join(estimator.names)),
        ('EFFORT_SCALE', float(model.effort_scale), 'N m on the arm side per unit of effort'),
        ('GEAR_RATIO', float(model.gear_ratio), 'motor angle over that on the arm side'),
        ('DELAY', parameters.effort_delay, 'of the torque, samples'),
        ('LOAD_MEASURED', int(estimator.settings.load_measured), 'whether the load is measured'))
    return '\n'.join(f'#define GM_{name} {value!r} /* {words} */' for name, value, words in rows)
