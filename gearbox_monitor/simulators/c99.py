# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
An EKF with its model as C99 for the firmware of a drive.

firmware/filter.c and filter.h hold the arithmetic of the kernels; what is written here is what
differs between drives: the states that there are, and the numbers of process_model.pack.
"""
from pathlib import Path
import re
from typing import NamedTuple

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.consider import companions_of
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filter_setup import described
from gearbox_monitor.estimation.process_model import (
    CURVE_COUNT, EIGENVALUE, ENCODER_DELAY_STD, FACTOR_DELAY, FACTOR_GAIN, FACTORS, FRICTION_AT,
    FRICTION_TIME, K_P, LOAD_AT, P0, Q0, Q_TAU_K_SPEED, R1, R2, STATISTICAL, TAU_K_MODEL_STD)
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.parameters import EstimatorParameters, MIXED
from gearbox_monitor.plant.drive import (
    ALPHA, ARM_ALPHA, CAC, CAV, CC, CL, DriveModel, G, HALF_GAP, K_S, KR, LAW, MAX_SUBSTEPS,
    OFFSET, PHI, STIFFNESS, TL, WIDTH)
from gearbox_monitor.plant.transmission import TANH

FILTERS = ('ekf',)  # that C code is written for
_PREFIX = re.compile('[a-z][a-z0-9_]{0,30}')
_TEMPLATES = Path(__file__).with_name('firmware')
_NUMBERS = {
    'stiffness': (STIFFNESS, 'K, N m/rad'), 'half_gap': (HALF_GAP, 'b, rad'),
    'width': (WIDTH, 'of the hysteresis, rad'),
    'hysteresis_stiffness': (K_S, 'of a passive play, N m/rad'),
    'position_gain': (KR, 'N m/rad'), 'torque_offset': (OFFSET, 'N m'),
    'weight': (G, 'of the arm, N m'), 'weight_phase': (PHI, 'rad'),
    'constant_load': (TL, 'on the arm, N m'),
    'side_sharpness': (ALPHA, 's/rad'), 'coulomb_friction': (CC, 'N m'),
    'tau_k_stiffness': (K_P, 'k_p, N m/rad'),
    'friction_error_time': (FRICTION_TIME, 's'),
    'eigenvalue': (EIGENVALUE, 'fastest of the drive, 1/s'),
    'r_motor': (R1, 'variance of the encoder, rad^2'),
    'r_arm': (R2, 'variance of the encoder, rad^2'),
    'tau_k_model_std': (TAU_K_MODEL_STD, 'N m'),
    'encoder_delay_std': (ENCODER_DELAY_STD, 's'),
    'q_tau_k_speed': (Q_TAU_K_SPEED, '(N m)^2 s/rad^2')}


class Firmware(NamedTuple):
    """A filter in C99: text of the source file and of the header that it includes."""

    source: str
    header: str


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
        The texts of both files.

    Raises:
        InputError: names the parameter or value of the model that the C code does not know.

    """
    if not _PREFIX.fullmatch(prefix):
        raise InputError(f'--prefix: {prefix[:40]!r}, expected up to 31 lower-case letters, '
                         'digits and _, a letter first')
    estimator = Estimator(model, parameters)
    _expect_known(estimator)
    title = f'{model.origin.name}: {estimator.parameters.filter.upper()}, tau_K as ' \
            f'{estimator.parameters.tau_k_model}. Written by gearbox_monitor {__version__}.'
    texts = []
    for name, mark, values in (('filter.c', '/*CONSTANTS*/', _constants(estimator)),
                               ('filter.h', '/*CONFIG*/', _config(estimator))):
        text = (_TEMPLATES / name).read_text(encoding='utf-8').replace(mark, values)
        text = text.replace('@HEADER@', header).replace('@TITLE@', title.replace('*/', '* /'))
        if prefix != 'gm':
            text = re.sub(r'\bgm_', f'{prefix}_', text)
            text = re.sub(r'\bGM_', f'{prefix.upper()}_', text)
        texts.append(text)
    return Firmware(*texts)


def _expect_known(estimator: Estimator) -> None:
    """Raise InputError unless the C code knows what the `estimator` runs."""
    p, law = estimator.parameters, estimator.drive.friction_law
    for name, value, bad, expected in (
            ('filter', p.filter, p.filter not in FILTERS, ' or '.join(FILTERS)),
            ('tau_k_model', p.tau_k_model, p.tau_k_model == MIXED,
             'random_walk, elastic or learned'),
            ('robot_description', p.robot_description[:40], described(p),
             'none: the load by it takes the whole robot'),
            ('friction_law.kind', law.kind, law.constraint, 'atan or tanh')):
        if bad:
            raise InputError(f'{name}: {value}, with --to c expected {expected}')


def _config(estimator: Estimator) -> str:
    """Return the #define lines of the header."""
    p, parameters = estimator.packed, estimator.parameters
    loads = bool(p[CAV] or p[CAC] or p[G] or p[TL])
    rows = (
        ('N', len(estimator.names), 'states: ' + ', '.join(estimator.names)),
        ('EFFORT_SCALE', repr(float(estimator.model.effort_scale)),
         'N m on the arm side per unit of effort'),
        ('GEAR_RATIO', repr(float(estimator.model.gear_ratio)),
         'motor angle over that on the arm side'),
        ('MAX_GAP', f'INT64_C({estimator.settings.max_gap})', 'longest dropout bridged, ns'),
        ('DELAY', parameters.effort_delay, 'of the torque, samples'),
        ('ARM_MEASURED', int(bool(parameters.arm_joint)), 'whether the arm has an encoder'),
        ('LOAD_MEASURED', int(estimator.settings.load_measured), 'whether the load is measured'),
        ('COMPANIONS', companions_of(estimator.drive, len(estimator.names)).number,
         'values of the model that have a tolerance'),
        ('CURVE', int(p[CURVE_COUNT]), 'states of the curve of tau_K; -1: random walk'),
        ('LOAD_AT', int(p[LOAD_AT]), 'place of the unknown load in the state, -1: none'),
        ('FRICTION_AT', int(p[FRICTION_AT]), 'place of the friction error, -1: none'),
        ('ARM_LOAD', int(loads), 'whether the model loads the arm'),
        ('ARM_COULOMB', int(p[CAC] != 0.0), ''), ('GRAVITY', int(p[G] != 0.0), ''),
        ('LOAD_FRICTION', int(p[CL] != 0.0), 'whether friction grows with tau_K'),
        ('TANH', int(p[LAW] == TANH), 'law of friction: 1 tanh, 0 arctangent'),
        ('STATISTICAL', int(p[STATISTICAL] > 0.0), 'friction linearised over the uncertainty'),
        ('MAX_SUBSTEPS', MAX_SUBSTEPS, 'RK4 steps in a sample, at most'))
    return '\n'.join(f'#define GM_{name} {value}' + (f' /* {words} */' if words else '')
                     for name, value, words in rows)


def _constants(estimator: Estimator) -> str:
    """Return the constants of the source file."""
    p, n = estimator.packed, len(estimator.names)
    lines = ['/* Constants of the model and the filter. */', 'static const struct {']
    lines += [f'    gm_real {name}; /* {words} */' for name, (_, words) in _NUMBERS.items()]
    lines += ['    gm_real Q[GM_N];  /* spectral density of the process noise, by state */',
              '    gm_real P0[GM_N]; /* variance at a start */', '} C = {']
    lines += [f'    .{name} = {_number(p[place])},' for name, (place, _) in _NUMBERS.items()]
    lines += [f'    .{name} = {{{_row(p[at:at + n])}}},' for name, at in (('Q', Q0), ('P0', P0))]
    lines += ['};', '', '/* The drive, and with each value that has a tolerance off by its '
              'standard deviation. */', 'static const drive DRIVES[GM_COMPANIONS + 1] = {']
    companions = companions_of(estimator.drive, n)
    for lane in range(companions.number + 1):
        factors = companions.factors[:, lane]
        m1, m2, d, cv, cc, cav, cac, cl = (p[place] * factor
                                           for place, factor in zip(FACTORS, factors))
        lines.append('    {' + _row((m1, m2, d, cv, cc, cl, cav, cac, p[ALPHA], p[ARM_ALPHA],
                                     factors[FACTOR_GAIN], factors[FACTOR_DELAY])) + '},')
    return '\n'.join([*lines, '};'])


def _row(values: Array | tuple[float, ...]) -> str:
    return ', '.join(_number(value) for value in values)


def _number(value: float) -> str:
    """Return `value` as C that reads back to the same bits."""
    return f'R({float(value)!r})'
