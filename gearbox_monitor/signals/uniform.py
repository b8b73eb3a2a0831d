# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A recording on a uniform grid of time: torque and both positions.

Defects of real stamps (jitter, single missing samples, dropouts) are repaired where that is
harmless and reported, and refused otherwise.

Its motion passes one low pass: torque and positions, speeds, accelerations.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any, NamedTuple

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.sample_loop import BACKWARD, HUGE, stamp_codes, START
from gearbox_monitor.kernels.elementary import DIFFERENCE_GAIN, quantisation_step, white_noise_std
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import Controller, DriveModel
from gearbox_monitor.presentation import on_axis, Said, said
from gearbox_monitor.signals.finding import LIMITS
from gearbox_monitor.signals.jumps import wild_rows

HELD = ('u', 'setpoint')  # over a sample
SPEED_SPAN = 0.01  # s on either side, over which a servo takes the speed of the motor
UNITS = {'t': 's', 'u': 'N m', 'setpoint': 'rad', 'motor': 'rad', 'arm': 'rad',
         'arm_torque': 'N m'}


class RecordingKind(NamedTuple):
    """What a recording is: whether an encoder may be missing, its axis, setpoint or torque."""

    one_encoder: bool = False
    axis: str = 'rotary'
    setpoint: bool = False


PLAIN = RecordingKind()


@dataclass(frozen=True)
class Doubt:
    """
    How a recording may have to be read, in words; then its columns so: swapped, times a scale.

    scale: of motor and arm, torque: of what drives the model.
    """

    text: str
    swap: bool = False
    scale: tuple[float, float] = (1.0, 1.0)
    torque: float = 1.0


@dataclass(frozen=True)
class UniformRecording:
    """
    Samples [N] of one drive, `dt` s apart, on the arm side.

    t [N] s from 0; u [N] N m, or setpoint of a servo, rad, held from t_k to t_k+1; y [N, 2] rad,
    motor and arm as measured; arm_torque [N] N m or None where not measured; name: what messages
    call it; channels: columns of y that were measured, the other one is a copy; floor: rad, below
    which the noise of the encoders is not, whatever interpolated readings look like; servo_torque
    [N] N m: what a servo commands, None without; shift: sample times by which a torque that is
    sampled acts later, None: it is held from t_k to t_k+1. begin: s, where t is 0 in the source.
    slip: t from which on the motor is counted on over a slip, s, and by how much, rad.

    If the motor's motion drives the model (torque_domain), motor [N, 5] holds it: position, speed,
    acceleration, whether it moves, and u without its noise; y then has u in place of the motor's
    position. doubt: another way to read the recording, which may be the right one, or None.
    """

    t: Array
    u: Array
    y: Array
    dt: float
    arm_torque: Array | None = None
    name: str = ''
    channels: tuple[int, ...] = (0, 1)
    floor: tuple[float, float] = (0.0, 0.0)
    motor: Array | None = None
    servo_torque: Array | None = None
    shift: float | None = None
    doubt: Doubt | None = None
    begin: float = 0.0
    slip: tuple[float, float] | None = None

    def as_read(self) -> 'UniformRecording':
        """Return the recording whose motor is not counted on over a slip."""
        if self.slip is None:
            return self
        at, size = self.slip
        y = self.y.copy()
        y[self.t >= at, 0] += size
        return replace(self, y=y, slip=None)

    def counted_on(self) -> list[Said]:
        """Return the note on a slip over which the motor is counted on, [] without one."""
        return [said('counted_on', size=self.slip[1], at=self.begin + self.slip[0])
                ] if self.slip else []

    def first(self, seconds: float) -> 'UniformRecording':
        """Return its first `seconds` s."""
        n = int(seconds / self.dt)
        return self if n >= len(self.y) else replace(self, t=self.t[:n], u=self.u[:n],
                                                     y=self.y[:n])

    def read_otherwise(self, doubt: Doubt) -> 'UniformRecording':
        """Return the recording as `doubt` reads it."""
        y = self.y[:, ::-1] if doubt.swap else self.y
        return replace(self, u=doubt.torque * self.u, y=y * doubt.scale, doubt=None)

    @property
    def torque(self) -> Array:
        """Torque [N] that is commanded, or that a servo makes of the setpoint, N m."""
        return self.u if self.servo_torque is None else self.servo_torque

    def with_servo(self, controller: Controller | None) -> 'UniformRecording':
        """Return the recording with the torque that `controller` makes of the setpoint u."""
        if controller is None:
            return self
        width = 2 * max(2, round(SPEED_SPAN / self.dt)) + 1
        position = self.y[:, self.channels[0]]
        speed = scipy.signal.savgol_filter(position, width, 2, deriv=1, delta=self.dt)
        return replace(self, servo_torque=controller.torque(self.u, position, speed, self.dt))

    @property
    def positions(self) -> Array:
        """Positions of motor and arm as measured [N, 2], rad."""
        if self.motor is None:
            return self.y
        return np.column_stack([self.motor[:, 0], self.y[:, 1]])

    @property
    def readings(self) -> tuple[str, str]:
        """What the columns of y are called."""
        return ('motor', 'arm') if self.motor is None else ('torque', 'arm')

    @property
    def span(self) -> slice:
        """All samples."""
        return slice(0, len(self.u))

    @property
    def duration(self) -> float:
        """Length of the recording, s."""
        return len(self.t) * self.dt


def physical(values: Array, field: str) -> tuple[Array, Flags]:
    """
    Return values as they count, and which of them are unphysical.

    Args:
        values: of one channel [N]; NaN: not measured.
        field: name of the channel, a key of UNITS.

    Returns:
        The values, NaN in place of those that are infinite, beyond HUGE or outliers of a torque;
        [N], which they are.

    Raises:
        InputError: the channel is memory that nobody wrote.
    """
    wild = np.abs(values) > HUGE
    if field == 'u':
        wild[wild_rows(np.where(wild, np.nan, values))] = True
    values = np.where(wild, np.nan, values) if wild.any() else values
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if 0.0 < largest < np.finfo(np.float32).tiny:
        raise InputError(f'{field}: dead: uninitialised memory, the largest amount is '
                         f'{largest:.2g}, expected numbers in {UNITS[field]}')
    return values, wild


def held_rate(model: DriveModel | None) -> float:
    """
    Return the lowest rate, Hz, at which positions that are held over rows suit a diagnosis.

    Args:
        model: of the drive, None if unknown. The setpoint of a servo is slow, its torque is not.
    """
    torque_driven = model is None or model.controller is None
    return LIMITS.held_rate if torque_driven else LIMITS.diagnosis_slowest


def prepare(t: Array | Integers, u: Array, y: Array, arm_torque: Array | None = None,
            name: str = '', kind: RecordingKind = PLAIN, longest: float = LIMITS.longest
            ) -> tuple[UniformRecording, tuple[Said, ...]]:
    """
    Return (Recording, notices) of samples stamped `t` [N], s, or integer ns; NaN: not measured.

    u [N] N m, y [N, 2] rad, arm_torque [N] N m or None. notices: what was repaired.

    - Stamps: a uniform grid is laid through them. Where the readings say that they were taken at
      the stamped times, positions are interpolated onto the grid; otherwise the stamps have
      jittered on their way and the samples are taken as the grid.
    - Up to LIMITS.max_run samples in a row that are lost or NaN, and single wild readings, are
      interpolated (u is held), up to `max_repaired` of all.
    - At longer gaps the recording is cut. Of stretches of `min_duration` and more, the one in
      which the drive moves most is kept, and of one longer than `longest` so much.

    Raises InputError naming field, time, value and what was expected.

    Args:
        t: stamps [N], s, or integer ns.
        u: torque of the motor [N], N m, or setpoint, rad.
        y: readings of motor and arm [N, 2], rad.
        arm_torque: torque measured on the arm [N], N m, or None.
        name: name of the recording in messages.
        kind: what the recording may lack, and its units.
        longest: length that is kept, s.
    """
    try:
        recording, notices = _prepared(t, u, y, arm_torque, name, kind)
        return _liveliest(recording, notices, longest)
    except InputError as error:
        raise InputError((f'{name}: ' if name else '') + on_axis(str(error), kind.axis)) from None


def _prepared(t: Array | Integers, u: Array, y: Array, arm_torque: Array | None, name: str,
              kind: RecordingKind) -> tuple[UniformRecording, tuple[Said, ...]]:
    """Return what prepare does."""
    driving = 'setpoint' if kind.setpoint else 'u'
    keep, notices = _longest_run(np.asarray(t))
    t, first = _seconds(np.asarray(t)[keep])
    y = np.array(y, float)[keep]
    channels = tuple(i for i in (0, 1) if not kind.one_encoder or np.isfinite(
        y[:, i]).any()) or (0, 1)
    if len(channels) == 1:
        y[:, 1 - channels[0]] = y[:, channels[0]]
    values = {driving: np.array(u, float)[keep], 'motor': y[:, 0], 'arm': y[:, 1]}
    if arm_torque is not None and not np.isnan(np.asarray(arm_torque, float)[keep]).all():
        values['arm_torque'] = np.array(arm_torque, float)[keep]
    t, values = _known(t, first, values, notices)
    gaps = [str(notice) for notice in notices if notice.code == 'gap_of_values']
    try:
        if gaps and (len(t) < 2 or t[-1] - t[0] < LIMITS.min_duration):
            raise InputError(f'{np.ptp(t) if len(t) else 0.0:.3g} s remain, expected at least '
                             f'{LIMITS.min_duration:g} s')
        begin, dt, values, floor = _evened(t, first, values, notices)
    except InputError as error:
        raise InputError('; '.join([*gaps, str(error)])) from None
    return UniformRecording(
        np.arange(len(values[driving])) * dt, values[driving],
        np.column_stack([values['motor'], values['arm']]), dt, values.get('arm_torque'), name,
        channels=channels, floor=floor, begin=begin), tuple(notices)


def _liveliest(recording: UniformRecording, notices: tuple[Said, ...], seconds: float
               ) -> tuple[UniformRecording, tuple[Said, ...]]:
    """Return the newest of the stretches of `seconds` that travel far, and notices on it."""
    r, n, second = recording, int(seconds / recording.dt), max(1, round(1.0 / recording.dt))
    if n >= len(r.y):
        return r, notices
    travel = _travel(r.y[:, r.channels[0]], r.dt)
    begins = np.arange((len(r.y) - n) % second, len(r.y) - n + 1, second)
    far = travel[begins + n] - travel[begins]
    begin = int(begins[far >= LIMITS.far * far.max()][-1])
    part = slice(begin, begin + n)
    arm_torque = None if r.arm_torque is None else r.arm_torque[part]
    return replace(r, t=r.t[:n], u=r.u[part], y=r.y[part], arm_torque=arm_torque,
                   begin=r.begin + begin * r.dt), (*notices, said(
                       'liveliest', seconds=seconds, total=r.duration, begin=begin * r.dt,
                       end=(begin + n) * r.dt))


def _known(t: Array, first: float, values: dict[str, Array], notices: list[Said]
           ) -> tuple[Array, dict[str, Array]]:
    """
    Return (stamps, channels) without unphysical and missing numbers; add to the notices.

    What is missing longer than can be interpolated is a gap of all channels.

    Args:
        t: stamps [N] from 0, s.
        first: of them, s.
        values: {field: [N]} as recorded.
        notices: on what was repaired.
    """
    for field in values:
        values[field], wild = physical(values[field], field)
        if wild.any():
            notices.append(said('huge_values', count=int(wild.sum()), field=field))
    if len(t) < 10:
        raise InputError(f'{len(t)} samples, expected at least {LIMITS.min_duration:g} s of them')
    _check_numbers(t, first, values)
    kept = np.ones(len(t), bool)
    for field, value in values.items():
        own = ~missing_long(value)
        if not own.all():
            kept &= own
            notices.append(said('gap_of_values', count=int((~own).sum()), field=field))
            # Readings at a lower rate than the torque's are no gaps.
            if own.sum() > 1 and usual_step(t[own])[0] > (
                    1.0 + LIMITS.uneven) * usual_step(t)[0]:
                raise InputError(f'{field}: nan in {(~own).sum()} of {len(t)} samples, more than '
                                 f'{LIMITS.max_run} in a row between any two, expected numbers '
                                 f'in {UNITS[field]}')
    t, values = t[kept], {field: value[kept] for field, value in values.items()}
    for field, value in values.items():
        if np.isnan(value).any():
            values[field], count = _fill(t, first, value, field)
            notices.append(said('missing_values', count=count, field=field))
    return t, values


def _evened(t: Array, first: float, values: dict[str, Array], notices: list[Said]
            ) -> tuple[float, float, dict[str, Array], tuple[float, float]]:
    """
    Return (begin of a grid, s, its step, channels on it, floor of both encoders); add to notices.

    Args:
        t: stamps [N] from 0, s, increasing.
        first: of them, s.
        values: {field: [N]}, all known.
        notices: on what was repaired.
    """
    index, dt, jitter = _grid(t)
    if rms_of(jitter) > LIMITS.max_run * dt:
        raise InputError('t: stamps stray from any even spacing by '
                         f'{np.abs(jitter).max():.3g} s, expected one sample rate')
    cuts = np.flatnonzero(np.diff(index) > LIMITS.max_run + 1)
    if len(cuts):
        keep, notice = _stretch(t, first, cuts, dt, values['motor'])
        notices.append(notice)
        t, index, jitter = t[keep], index[keep], jitter[keep]
        values = {field: value[keep] for field, value in values.items()}
    index = index - index[0]
    wander = _wander(jitter, dt)
    lost = _lost(t, index, wander, notices)
    strays, follows = _straying(values, index, jitter - wander, dt, notices)
    times = index * dt + wander + strays
    n = int(index[-1]) + 1
    if wander.any():  # the line through the stamps may begin and end beyond them
        times = times - times[0]
        n = int(times[-1] / dt) + 1
    grid = np.arange(n) * dt
    moved = follows or bool(wander.any())
    floor = [quantisation_step(values[field]) / math.sqrt(12.0) for field in ('motor', 'arm')]
    if moved or lost:
        held = np.clip(np.searchsorted(times, grid + 0.5 * dt, side='right') - 1, 0, None)
        values = {field: value[held] if field in HELD else _cubic(times, value, grid)
                  for field, value in values.items()}
    for k, field in enumerate(('motor', 'arm')):
        if count := _mend_spikes(values[field]):
            notices.append(said('wild_readings', count=count, field=field))
        floor[k] = max(floor[k], _noise_at_speed(values[field]) * moved)
    return float(t[0]), dt, values, (floor[0], floor[1])


def _lost(t: Array, index: Integers, wander: Array, notices: list[Said]) -> int:
    """Return how many samples are lost by their stamps t [N], s; see _absent. Adds notices."""
    n, missing = int(index[-1]) + 1, int(_absent(t, index, wander).sum())
    if missing > LIMITS.max_repaired * n:
        raise InputError(f'{missing} of {n} samples lost by their stamps '
                         f'({100 * missing / n:.1f} %), expected at most '
                         f'{100 * LIMITS.max_repaired:g} %')
    if missing:
        notices.append(said('lost_samples', count=missing, samples=n))
    if wander.any():
        notices.append(said('time_wanders', ms=1e3 * rms_of(wander)))
    return missing


def _straying(values: Mapping[str, Array], index: Integers, jitter: Array, dt: float,
              notices: list[Said]) -> tuple[Array, bool]:
    """Return (by how much readings stray from even times [N], s; whether they do); add notices."""
    rms = rms_of(jitter)
    quiet = rms <= LIMITS.quiet_jitter * dt
    follows = not quiet and _follows_stamps(values, index, jitter, dt)
    if not quiet:
        notices.append(said('jitter_followed' if follows else 'jitter_ignored', ms=1e3 * rms,
                            percent=100 * rms / dt))
    return jitter * follows, follows


def usable_rows(t: Array | Integers) -> tuple[Integers, list[Said]]:
    """
    Return the rows of the samples [K] that count, and notices on the others.

    Of samples with one stamp the first counts; those that replay refuses by their stamps do not.

    Args:
        t: stamps [N], s, or integer ns.
    """
    valid = np.flatnonzero(~_strays(t))
    rows = valid[np.diff(t[valid], prepend=t[valid[:1]] - 1) != 0]
    notices = [said(code, count=before - left, samples=before) for code, before, left in (
        ('unordered', len(t), len(valid)), ('repeated', len(valid), len(rows))) if left < before]
    return rows, notices


def _backward(stamps: Integers) -> tuple[Integers, Integers, Flags]:
    """
    Return (begins, ends [K], restarts [K]) of the runs of `stamps` (ns) that are late.

    Where the filter's loop believes them, the clock has restarted there; others are late alone.
    """
    codes = stamp_codes(stamps, LIMITS.max_gap)
    begins, lengths = _runs(codes == BACKWARD)
    ends = begins + lengths
    return begins, ends, (ends < len(codes)) & (codes[np.minimum(ends, len(codes) - 1)] == START)


def _strays(t: Array | Integers) -> Flags:
    """Return which of the stamps t [N] in ns are none, or late without a restart of the clock."""
    strays = np.zeros(len(t), bool)
    if t.dtype.kind not in 'iu':
        return strays
    strays = np.asarray(t <= 0)
    rows = np.flatnonzero(~strays)
    for begin, end, restarts in zip(*_backward(t[rows].astype(np.int64))):
        strays[rows[begin:end]] |= not restarts
    return strays


def _longest_run(t: Any) -> tuple[slice, list[Said]]:
    """
    Return the longest run of the samples stamped `t` between restarts of the clock, and a notice.

    A clock restarts where stamps go back and stay there, as the filter's loop has it; a single
    late sample is none.
    """
    if not (len(t) and np.isfinite(t).all() and (np.diff(t) < 0).any()):
        return slice(None), []
    stamps = t.astype(np.int64) if t.dtype.kind in 'iu' else np.rint(
        (t - t.min()) * 1e9).astype(np.int64)
    begins, _, restarts = _backward(stamps - stamps.min() + 1_000_000_000)
    edges = sorted({0, *begins[restarts].tolist(), len(t)})
    if len(edges) < 3:
        return slice(None), []
    k = int(np.argmax([float(t[end - 1] - t[begin]) for begin, end in zip(edges, edges[1:])]))
    return slice(edges[k], edges[k + 1]), [said(
        'longest_run', count=len(edges) - 2, first=edges[k], last=edges[k + 1] - 1,
        samples=len(t))]


def _seconds(t: Any) -> tuple[Array, float]:
    """Return (t from 0 in s, first stamp in s); integers are ns."""
    unit = 1e-9 if t.dtype.kind in 'iu' else 1.0
    return (t - t[:1]) * unit, float(t[0]) * unit if len(t) else 0.0


def _check_numbers(t: Array, first: float, values: Mapping[str, Array]) -> None:
    """Raise InputError for what is no finite number or, in t, does not increase."""
    bad = np.flatnonzero(~np.isfinite(t))
    if len(bad):
        raise InputError(f't: {t[bad[0]]} in row {bad[0]}, expected a finite time in s')
    for field, value in values.items():
        if len(value) != len(t):
            raise InputError(f'{field}: {len(value)} values, expected {len(t)} as of t')
        if np.isnan(value).all():
            raise InputError(f'{field}: never measured, expected torque, motor and arm position '
                             'in every sample')
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        row = int(back[0]) + 1
        word = 'repeats' if t[row] == t[row - 1] else 'goes back'
        raise InputError(f't: {first + t[row]:.9g} s {word} after {first + t[row - 1]:.9g} s, '
                         'expected increasing times')


def _runs(flags: Flags) -> tuple[Integers, Integers]:
    """Return (starts, lengths) of the runs of True in flags [N]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2] - edges[::2]


def missing_long(value: Array) -> Flags:
    """Return which of `value` [N] are NaN in runs too long to interpolate, or at an end."""
    missing = np.isnan(value)
    for begin, length in zip(*_runs(missing)):
        if length <= LIMITS.max_run and 0 < begin < len(value) - length:
            missing[begin:begin + length] = False
    return missing


def _fill(t: Array, first: float, value: Array, field: str) -> tuple[Array, int]:
    """Return (value with NaN interpolated, how many); raises InputError where there are many."""
    missing = np.isnan(value)
    count = int(missing.sum())
    if count > LIMITS.max_repaired * len(value):
        raise InputError(
            f'{field} at {first + t[missing.argmax()]:.9g} s: nan ({count} nan of {len(value)}), '
            f'expected numbers in {UNITS[field]}, at most {100 * LIMITS.max_repaired:g} % nan')
    good = ~missing
    if field in HELD:
        last = np.maximum.accumulate(np.where(good, np.arange(len(value)), 0))
        return value[last], count
    value = value.copy()
    value[missing] = _cubic(t[good], value[good], t[missing])
    return value, count


def usual_step(t: Array) -> tuple[float, float]:
    """Return (median, robust deviation) of the steps of stamps `t` [N], s."""
    step = np.diff(t)
    usual = float(np.median(step))
    return usual, 1.4826 * float(np.median(np.abs(step - usual)))


def _grid(t: Array) -> tuple[Integers, float, Array]:
    """
    Return (index [N], dt, jitter [N]): t = index dt + jitter, from 0, index increasing.

    The sample time is that of a line through all stamps, lost samples counted by their length.

    Args:
        t: stamps [N], s, increasing.
    """
    step = np.diff(t)
    dt, spread = usual_step(t)
    count = np.maximum(1.0, np.rint(step / dt))
    # If lateness may have made a step, its length does not show whether a sample is lost.
    doubtful = (step > 1.5 * dt) & ((spread > math.sqrt(2.0) * LIMITS.jitter_notice * dt)
                                    | (step < dt + LIMITS.certain * spread))
    for k in np.flatnonzero(doubtful).tolist():
        # A late stamp is followed by a short step; after a lost sample all stamps stay behind.
        rows_before, rows_after = np.arange(max(k - 6, 0),
                                            k + 1), np.arange(k + 1, min(k + 8, len(t)))
        delay = (np.median(t[rows_after] - dt * rows_after)
                 - np.median(t[rows_before] - dt * rows_before))
        count[k] = max(1.0, np.rint(1.0 + delay / dt))
    index = np.concatenate([[0], np.cumsum(count)])
    slope, start = np.polyfit(index, t, 1)
    return index.astype(np.int64), float(slope), t - start - slope * index


def absent_samples(t: Array) -> Integers:
    """
    Return how many samples are missing by the stamps `t` [N] (s, increasing) between each two.

    A step that is long because a sample is late, or because the loop has no clock, misses none.
    """
    index, dt, jitter = _grid(t)
    return _absent(t, index, _wander(jitter, dt))


def _absent(t: Array, index: Integers, wander: Array) -> Integers:
    """Return the samples missing behind each but the last of `t` [N]; see absent_samples."""
    absent: Integers = np.diff(index) - 1
    if wander.any():  # late by any time; lost is a sample only where the next one was due, too
        usual, spread = usual_step(t)
        due = np.maximum(1.0, np.diff(t) // (usual - spread)) - 1.0
        absent = np.minimum(absent, due.astype(np.int64))
    return absent


def _stretch(t: Array, first: float, cuts: Integers, dt: float, motor: Array
             ) -> tuple[slice, Said]:
    """
    Return (slice, notice) of the stretch between gaps in which the drive moves most.

    Args:
        t: stamps [N], s.
        first: of them all, s.
        cuts: rows behind which gaps are.
        dt: sample time, s.
        motor: readings of the encoder [N], rad.
    """
    edges = np.concatenate([[0], cuts + 1, [len(t)]])
    length = t[edges[1:] - 1] - t[edges[:-1]] + dt
    widest = cuts[np.argmax(t[cuts + 1] - t[cuts])]
    holes = said('holes' if len(cuts) > 1 else 'one_hole', count=len(cuts),
                 longest=t[widest + 1] - t[widest], at=first + t[widest])
    if length.max() < LIMITS.min_duration:
        raise InputError(f'{holes}; the longest stretch without one lasts {length.max():.3g} s, '
                         f'expected at least {LIMITS.min_duration:g} s')
    travel = [_travel(motor[begin:end], dt)[-1] for begin, end in zip(edges, edges[1:])]
    i = int(np.argmax(np.where(length < LIMITS.min_duration, -1.0, travel)))
    keep = slice(edges[i], edges[i + 1])
    return keep, said('stretch', holes=(holes,), first=first + t[keep][0],
                      last=first + t[keep][-1])


def _travel(motor: Array, dt: float) -> Array:
    """Return how far `motor` [N] has travelled [N + 1] (rad) by steps slower than its noise."""
    stride = max(1, round(2.0 * SPEED_SPAN / dt))
    x = np.repeat(motor[::stride], stride)[:len(motor)]
    return np.append(0.0, np.cumsum(np.abs(np.diff(x, prepend=x[:1]))))


def _cubic(times: Array, value: Array, at: Array) -> Array:
    """Return value [N] at `times` (s) on the times `at` by local cubics; the ends are held."""
    k = np.clip(np.searchsorted(times, at) - 2, 0, len(times) - 4)
    at = np.clip(at, times[0], times[-1])
    result = np.zeros(len(at))
    for i in range(4):
        weight = np.ones(len(at))
        for j in range(4):
            if j != i:
                weight *= (at - times[k + j]) / (times[k + i] - times[k + j])
        result += weight * value[k + i]
    return result


def rms_of(values: Array) -> float:
    """Return the root mean square of `values` [N]."""
    return float(np.sqrt(np.mean(values ** 2)))


def _noise_at_speed(value: Array) -> float:
    """
    Return the noise of readings (rad) `value` [N] in the half of the samples that moves most.

    Stamps that stray by r put readings off by r times the speed; at rest nothing shows of it.
    """
    rough, speed = np.diff(value, 4), np.abs(value[3:-1] - value[1:-3])
    return rms_of(rough[speed >= np.median(speed)]) / DIFFERENCE_GAIN


def _wander(jitter: Array, dt: float) -> Array:
    """
    Return the part (s) [N] of the jitter of stamps that lasts: the sample time itself varies.

    A late stamp is late alone, so that a mean over n of them shrinks by the root of n. A mean that
    stays far beyond that is no lateness: a loop without a clock of its own takes what time it
    needs, and its samples lie where the stamps say.

    Args:
        jitter: stamps less even ones, s.
        dt: sample time, s.
    """
    half = max(1, round(0.5 * LIMITS.wander_span / dt))
    n = 2 * half + 1
    if len(jitter) < n:
        return np.zeros(len(jitter))
    slow = np.convolve(np.pad(jitter, half, 'edge'), np.ones(n) / n, 'valid')
    noise = max(LIMITS.quiet_jitter * dt, 4.0 * rms_of(jitter - slow) / math.sqrt(n))
    return slow if rms_of(slow) > noise else np.zeros(len(jitter))


def _follows_stamps(values: Mapping[str, Array], index: Integers, jitter: Array,
                    dt: float) -> bool:
    """
    Return whether the readings were taken at the stamped times rather than evenly.

    A reading taken late by the jitter r differs from its neighbours by speed times r: the slope of
    a regression on it is 1, and 0 if only the stamps were late.
    """
    whole = np.flatnonzero(np.diff(index, 4) == 0)
    whole = whole[index[whole + 4] - index[whole] == 4]  # five samples without a lost one
    numerator = denominator = 0.0
    for field in ('motor', 'arm'):
        value = values[field]
        width = max(1, int(round(0.01 / dt)))
        shift = np.gradient(np.convolve(value, np.ones(2 * width + 1) / (2 * width + 1), 'same'),
                            dt) * jitter
        rough, expected = np.diff(value, 4)[whole], np.diff(shift, 4)[whole]
        # Of a coarse encoder, most differences are 0; of one that is missing, all.
        level = np.median(np.abs(rough)) or np.mean(np.abs(rough))
        if not level > 0.0:
            continue
        weight = 1.0 / level ** 2
        inner = slice(width, -width)  # the mean is none at the ends
        numerator += weight * float(rough[inner] @ expected[inner])
        denominator += weight * float(expected[inner] @ expected[inner])
    return denominator > 0.0 and numerator > 0.5 * denominator


def _mend_spikes(value: Array) -> int:
    """Interpolate single wild readings of value [N] in place; return how many, 0 if too many."""
    # What the four neighbours say of a reading; the cubic through them is (-1 4 4 -1) / 6.
    off = value[2:-2] - (-value[:-4] + 4 * value[1:-3] + 4 * value[3:-1] - value[4:]) / 6
    scale = np.median(np.abs(off)) / 0.6745
    if scale == 0.0:
        return 0
    # A wild reading spoils the cubics of its four neighbours by two thirds at most.
    neighbourhood = np.lib.stride_tricks.sliding_window_view(
        np.pad(np.abs(off), 2), 5).max(axis=1)
    wild = np.flatnonzero((np.abs(off) > LIMITS.spike * scale)
                          & (np.abs(off) == neighbourhood)) + 2
    if not len(wild) or len(wild) > LIMITS.max_repaired * len(value):
        return 0
    # Alone: without it the rest is as smooth as anywhere.
    count = 0
    for k in wild.tolist():
        neighbours = [i for i in range(max(k - 4, 0), min(k + 5, len(value))) if i != k]
        fit = np.polyfit(np.array(neighbours) - k, value[neighbours], 3)
        if (np.abs(np.polyval(fit, np.array(neighbours) - k) - value[neighbours]).max()
                < 0.25 * abs(value[k] - fit[-1])):
            value[k] = fit[-1]
            count += 1
    return count


def at_one_rate(recordings: Sequence[UniformRecording]) -> list[UniformRecording]:
    """
    Return recordings of one drive at the lowest of their rates.

    The rate of a logger that has no clock of its own differs by percents between recordings.
    Readings are interpolated by local cubics; what is held keeps the value in force. Rates that
    differ by more than `rates_alike` remain as they are.

    Args:
        recordings: recordings of one drive, as prepared.
    """
    dt = max(r.dt for r in recordings)
    aligned = []
    for r in recordings:
        if 1e-3 < dt / r.dt - 1.0 <= LIMITS.rates_alike:
            t = np.arange(int((len(r.t) - 1) * r.dt / dt) + 1) * dt
            source = np.minimum((t / r.dt + 1e-6).astype(int), len(r.u) - 1)
            at = np.arange(len(r.t)) * r.dt
            r = replace(
                r, t=t, dt=dt, u=r.u[source],
                y=np.column_stack([_cubic(at, column, t) for column in r.y.T]),
                arm_torque=None if r.arm_torque is None else r.arm_torque[source],
                servo_torque=None if r.servo_torque is None else r.servo_torque[source])
        aligned.append(r)
    return aligned


def expect_one_rate(recordings: Sequence[UniformRecording]) -> None:
    """
    Raise InputError when recordings differ in their rate or in what loads the arm.

    Args:
        recordings: recordings of one drive.
    """
    first = recordings[0]
    for recording in recordings[1:]:
        if abs(recording.dt / first.dt - 1.0) > 1e-3:
            raise InputError(f'{recording.name}: {1 / recording.dt:g} Hz, expected '
                             f'{1 / first.dt:g} Hz as {first.name}')
        if (recording.arm_torque is None) != (first.arm_torque is None):
            raise InputError(f'{recording.name}: arm torque: expected in all recordings or '
                             'in none')


HALF_WIDTHS = (0.006, 0.012, 0.024, 0.048, 0.096)  # s, of the low pass
FITTED = (0.015, 0.03, 0.06, 0.12)  # where the equations of a model are fitted


def constant_runs(x: Array) -> tuple[Integers, Integers]:
    """Return (starts, lengths) of the runs of one value in x [N]."""
    starts = np.append(0, np.flatnonzero(np.diff(x)) + 1)
    return starts, np.diff(np.append(starts, len(x)))


def noise_of(y: Array) -> tuple[float, float]:
    """
    Return (noise, step of the lattice or 0) of readings y [N] (rad), NaN: not measured.

    Where most of them are one value, the encoder has stuck: noise is that of the longest rest.
    """
    readings = y[np.isfinite(y)]
    starts, lengths = constant_runs(readings)
    if len(starts) > 4 and lengths.max() > 0.5 * len(readings):
        k = int(lengths.argmax())
        readings = max(readings[:starts[k]], readings[starts[k] + lengths[k]:], key=len)
    quantum = quantisation_step(readings)
    return white_noise_std(readings, quantum), quantum


class SmoothedMotion:
    """
    Torque and positions smoothed alike, with the positions' derivatives, every few samples.

    u [M] N m; p, v, a [M, 2] rad, rad/s, rad/s^2, exact differences of one low pass; k [M] samples
    they stand at; noise, noise_v, noise_a [2], their remaining noise; kernels [3, 2 n + 1] that
    make p, v and a of positions. Half as wide as the first of `widths` s that the noise allows.
    """

    p: Array
    v: Array
    a: Array
    noise: Array
    noise_v: Array
    noise_a: Array
    kernels: Array

    def __init__(self, recording: UniformRecording, sigma: Array,
                 widths: Sequence[float] = FITTED, whole: bool = False) -> None:
        self.recording, self.sigma, self.dt = recording, sigma, recording.dt
        for half_width in widths:
            self._smooth(half_width)
            channels = list(recording.channels)
            if (self.noise_a <= LIMITS.acceleration_noise * self.a.std(axis=0))[channels].all():
                break
        n = self.kernels.shape[1] // 2
        self.half_width = half_width
        self._decimated = slice(None, None, 1 if whole else max(1, n // 3))
        self.k = np.arange(n, len(recording.y) - n)[self._decimated]
        self.p, self.v, self.a = (x[self._decimated] for x in (self.p, self.v, self.a))
        self.u = self.filtered(recording.torque)

    def _smooth(self, half_width: float) -> None:
        """Smooth positions over `half_width` s."""
        r = self.recording
        n = max(3, round(half_width / r.dt))
        weights = (1.0 - (np.arange(-n, n + 1) / (n + 1)) ** 2) ** 4
        weights /= weights.sum()
        before, at, after = (np.pad(weights, pad) for pad in ((0, 2), (1, 1), (2, 0)))
        self.kernels = np.array([at, (before - after) / (2.0 * r.dt),
                                 (before - 2.0 * at + after) / r.dt ** 2])
        low = convolved(r.y - r.y[0], weights)
        self.p = low[1:-1] + r.y[0]
        self.v = (low[2:] - low[:-2]) / (2.0 * r.dt)
        self.a = (low[2:] - 2.0 * low[1:-1] + low[:-2]) / r.dt ** 2
        self.noise, self.noise_v, self.noise_a = (
            self.sigma * np.linalg.norm(kernel) for kernel in self.kernels)

    def filtered(self, signal: Array) -> Array:
        """Return a `signal` [N] or [N, C] through the low pass of the positions [M]."""
        return convolved(signal, self.kernels[0])[self._decimated]

    @property
    def i(self) -> int:
        """The first encoder that is there: 0 or 1."""
        return self.recording.channels[0]

    @property
    def swing(self) -> tuple[float, float | None]:
        """(middle, swing) of the twist, rad; swing None where it is only noise."""
        low, high = np.percentile(self.p[:, 0] - self.p[:, 1], (1, 99))
        visible = high - low > 2.0 * LIMITS.certain * np.hypot(*self.noise)
        return 0.5 * (low + high), float(high - low) if visible else None

    def direction(self, i: int) -> Array:
        """Return the direction of the speed of side `i` [M], soft where it is within the noise."""
        v, noise = self.v[:, i], float(self.noise_v[i])
        return np.asarray(v / np.sqrt(v * v + (3.0 * noise) ** 2 + 1e-300))


def convolved(signal: Array, weights: Array) -> Array:
    """Return `signal` [N] or [N, C] convolved with weights [M], where they overlap wholly."""
    columns = [np.convolve(column, weights, 'valid') for column in np.atleast_2d(signal.T)]
    return np.stack(columns, axis=1) if signal.ndim > 1 else columns[0]


def reversals(v: Array, slow: float) -> Integers:
    """Return the samples at which the speed v [M] has gone from beyond one `slow` to the other."""
    side = np.sign(v) * (np.abs(v) > slow)
    at = np.flatnonzero(side)
    return at[1:][np.diff(side[at]) != 0]
