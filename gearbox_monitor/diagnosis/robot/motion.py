# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The motion of a robot on a uniform grid: smoothed positions and speeds, input, noise.

Test functions are local cosines, multiplied by a mask that leaves out rest and reversal.
"""
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.robot_log import LogSection, RobotLog
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.linear_least_squares import cosine_basis, motion_mask
from gearbox_monitor.kernels.types import Array, Integers

ORDER = 4  # of the smoother, which runs forwards and backwards


@dataclass(frozen=True, eq=False)
class RobotMotion:
    """
    Uniform samples of one recording, its sections one behind the other.

    t [N] s from the begin; q, v [N, J] smoothed; input [N, J]: torque or setpoint;
    input_speed [N, J]: its derivative. sigma_v [J]: deviation of v;
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
        input_speed = np.gradient(grid.input, 1.0 / rate, axis=0)[middle]
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


COVERED = 0.3  # share of a segment in motion from which its energy counts


@dataclass(frozen=True, eq=False)
class TestFunctions:
    """
    Test functions of one motion, with the masks of its joints.

    value, slope [2 hop, M]: the M functions of a segment and their derivatives, 1/s.
    starts [S]: first sample of each segment; frequency [S M] Hz of each row, band [S M].
    mask, mask_slope [N, J]: 1 where a joint moves, 0 at rest, and its derivative.
    """

    value: Array
    slope: Array
    starts: Integers
    frequency: Array
    band: Integers
    mask: Array
    mask_slope: Array

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.frequency)

    @cached_property
    def share(self) -> Array:
        """Mean square of the mask of each joint [J] in the segments."""
        return self.covered.mean(axis=0)

    @cached_property
    def covered(self) -> Array:
        """Mean square of the mask in each segment [S, J]."""
        return np.stack([self._window @ self.mask[s:s + len(self._window)] ** 2
                         for s in self.starts])

    @cached_property
    def _window(self) -> Array:
        window = self.value[:, 0] ** 2 + self.value[:, 1] ** 2
        return np.asarray(window / window.sum())

    def mean_in_motion(self, x: Array, joint: int) -> Array:
        """Return the mean [S] of `x` [N] over the time of each segment in which `joint` moves."""
        weighted = self.mask[:, joint] ** 2 * x
        total = [self._window @ weighted[s:s + len(self._window)] for s in self.starts]
        return np.array(total) / np.maximum(self.covered[:, joint], 1e-9)

    def _project(self, x: Array, basis: Array) -> Array:
        blocks = np.stack([x[s:s + len(basis)] for s in self.starts])     # S, 2 hop, K
        return np.matmul(basis.T, blocks).reshape(-1, x.shape[1])

    def of(self, x: Array, joint: int) -> Array:
        """Return the integrals [R, K] of phi mu x, `x` [N, K] acting on `joint`."""
        return self._project(x * self.mask[:, joint, None], self.value)

    def series(self, rows: Array) -> Array:
        """Return the series [N] of which `of` made `rows` [R]: they are a tight frame."""
        out, hops = np.zeros(len(self.mask)), len(self.value)
        for start, part in zip(self.starts, rows.reshape(len(self.starts), -1)):
            out[start:start + hops] += self.value @ part
        return out

    def of_rate(self, x: Array, joint: int) -> Array:
        """Return the integrals [R, K] of phi mu dx/dt, by parts: `x` is not differentiated."""
        return -self._project(x * self.mask[:, joint, None], self.slope) \
            - self._project(x * self.mask_slope[:, joint, None], self.value)


def local_cosines(motion: RobotMotion, highest: float) -> TestFunctions:
    """Return the test functions of `motion` up to `highest` Hz."""
    step = motion.step
    hop = int(round(SETTINGS.hop / step))
    count = int(min(highest, 0.4 / step) * 2 * hop * step)
    value, slope = cosine_basis(hop, count)
    starts = np.concatenate([np.arange(s.start, s.stop - 2 * hop + 1, hop)
                             for s in motion.sections])
    frequency = np.tile((np.arange(count) + 0.5) / (2 * hop * step), len(starts))
    mask, mask_slope = _masks(motion)
    return TestFunctions(value, slope / step, starts, frequency,
                         np.digitize(frequency, SETTINGS.bands) - 1, mask, mask_slope)


def _masks(motion: RobotMotion) -> tuple[Array, Array]:
    """
    Return the masks [N, J] and their derivatives, 1/s.

    Static friction is any torque up to Coulomb's: no law can be held against it, nor while a joint
    reverses between two samples. The mask multiplies the test functions, so the weak form stays
    exact.
    """
    slow = np.maximum(3.0 * motion.sigma_v, SETTINGS.slow)
    width = max(1, int(round(SETTINGS.ramp / motion.step)))
    mask, slope = np.empty_like(motion.v), np.empty_like(motion.v)
    for section in motion.sections:
        for j in range(motion.v.shape[1]):
            v = motion.v[section, j]
            reverses = np.diff(np.signbit(v), append=np.signbit(v[-1]))
            still = (np.abs(v) < slow[j]) | reverses | np.roll(reverses, 1)
            mask[section, j] = motion_mask(still, width)
        # Parts need the derivative itself: along a ramp of 3 samples a difference is too small.
        t = motion.t[section]
        slope[section] = scipy.interpolate.CubicSpline(t, mask[section])(t, 1)
    return mask, slope
