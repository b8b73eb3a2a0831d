# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The motion of a robot on a uniform grid: smoothed positions and speeds, input, noise."""
from dataclasses import dataclass

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.robot_log import LogSection, RobotLog
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array

ORDER = 4  # of the smoother, which runs forwards and backwards


@dataclass(frozen=True, eq=False)
class RobotMotion:
    """
    Uniform samples of one recording, its sections one behind the other.

    t [N] s from the begin; q, v [N, J] smoothed; input [N, J]: torque or setpoint;
    input_speed [N, J]: derivative of a setpoint, else zeros. sigma_v [J]: deviation of v;
    sigma_q [J]: of q as measured. step s; sections: slices of samples without a gap;
    cut_off [J] Hz: of the smoother, None for q and v that are not smoothed.
    """

    t: Array
    q: Array
    v: Array
    input: Array
    input_speed: Array
    sigma_v: Array
    sigma_q: Array
    step: float
    sections: tuple[slice, ...]
    cut_off: Array | None = None


def motion_of(log: RobotLog) -> RobotMotion:
    """
    Return the RobotMotion of a log, smoothed by each joint's own noise floor.

    The cut-off of a joint is where its spectrum meets the floor (Wiener). Both ends of a section
    are cut: a smoother is wrong there.
    """
    rate = min(log.rate, SETTINGS.grid)
    grids = [_on_grid(section, rate, log.rate) for section in log.sections]
    cut, floor = _cut_offs(grids, rate)
    margin = int(np.ceil(2.0 * rate / cut.min()))
    parts, sections, begin = [], [], 0
    for grid in grids:
        if len(grid.t) < 2 * margin + 2.0 * SETTINGS.hop * rate + 2:
            continue
        filters = [scipy.signal.butter(ORDER, f, fs=rate, output='sos') for f in cut]
        smooth = np.column_stack([scipy.signal.sosfiltfilt(filter_, grid.position[:, j])
                                  for j, filter_ in enumerate(filters)])
        middle = slice(margin, len(grid.t) - margin)
        speed = scipy.interpolate.CubicSpline(grid.t, smooth)(grid.t[middle], 1)
        input_speed = np.gradient(grid.input, 1.0 / rate, axis=0)[middle] if (
            log.kind == 'setpoint') else np.zeros_like(speed)
        parts.append((grid.t[middle], smooth[middle], speed, grid.input[middle], input_speed))
        sections.append(slice(begin, begin + len(speed)))
        begin += len(speed)
    if not parts:
        raise InputError(f'{log.name}: no part without gaps is longer than '
                         f'{2 * margin / rate + 2 * SETTINGS.hop:.1f} s, expected a longer log')
    t, q, v, inputs, input_speed = (np.concatenate(x) for x in zip(*parts))
    return RobotMotion(t - log.sections[0].t[0], q, v, inputs, input_speed,
                  np.sqrt(floor * (2.0 * np.pi) ** 2 * cut ** 3 / 3.0),
                  np.sqrt(floor * rate / 2.0), 1.0 / rate, tuple(sections), cut)


def highest_kept(motion: RobotMotion) -> Array:
    """Return the frequencies [J], Hz, up to which the smoother keeps a motion nearly whole."""
    if motion.cut_off is None:
        return np.full(motion.q.shape[1], np.inf)
    return motion.cut_off * (SETTINGS.smoothed / (1.0 - SETTINGS.smoothed)) ** (0.5 / ORDER)


def _on_grid(section: LogSection, rate: float, of_log: float) -> LogSection:
    """Return a section on a uniform grid; of a faster log the means between grid points."""
    t = np.arange(section.t[0], section.t[-1], 1.0 / rate)
    if of_log > 1.5 * rate:
        edges = np.append(t, t[-1] + 1.0 / rate)
        edges[-1] = min(edges[-1], section.t[-1])
        width = np.diff(edges)[:, None]

        def means(x: Array) -> Array:
            """Return the integral of `x` [N, J] between grid points over their distance."""
            whole = scipy.integrate.cumulative_trapezoid(x, section.t, axis=0, initial=0.0)
            at = np.column_stack([np.interp(edges, section.t, c) for c in whole.T])
            return np.diff(at, axis=0) / np.maximum(width, 1e-9)
        good = width[:, 0] > 0.5 / rate
        return LogSection((t + 0.5 / rate)[good], means(section.position)[good],
                     means(section.input)[good])
    onto = np.column_stack([np.interp(t, section.t, c) for c in section.input.T])
    return LogSection(t, scipy.interpolate.CubicSpline(section.t, section.position)(t), onto)


def _cut_offs(grids: list[LogSection], rate: float) -> tuple[Array, Array]:
    """Return cut-off (Hz) and noise floor (1/Hz) of each joint, from its longest section."""
    q = max((grid.position for grid in grids), key=len)
    low, high = SETTINGS.cut_off
    high = min(high, 0.4 * rate)
    length = min(len(q), int(4 * rate))
    f, power = scipy.signal.welch(q - q.mean(axis=0), rate, nperseg=length, axis=0)
    floor = np.median(power[f > 0.35 * rate], axis=0)
    cut = np.empty(q.shape[1])
    for j in range(q.shape[1]):
        audible = f[power[:, j] > 6.0 * floor[j]]
        cut[j] = np.clip(1.3 * audible[-1] if len(audible) else low, low, high)
    return cut, floor


def smooth_sign(v: Array, sigma: Array) -> Array:
    """Return the expected sign of speeds `v` [N, J] +- `sigma` [J]."""
    return scipy.special.erf(v / np.sqrt(2.0) / np.maximum(sigma, SETTINGS.presliding))
