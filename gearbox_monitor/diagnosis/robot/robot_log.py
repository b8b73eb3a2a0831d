# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A log of all joints of a robot, checked and cut into sections at its gaps."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.presentation import as_written, Said, said
from gearbox_monitor.signals.jumps import (
    JumpFinding, OUTLIER, PERIODS, repeats, SLIP, strangers, TURNS, turns, wild_rows,
    without_jumps)
from gearbox_monitor.signals.recording import AS_RECORDED, Convention, Recording
from gearbox_monitor.signals.stamps import require_stamps

TORQUE, CURRENT, SETPOINT = 'torque', 'current', 'setpoint'
LEAST_SECONDS = 4.0  # a section holds at least one test function and what a smoother loses
LATE = 0.01  # of a log, before the first setpoint of a servo


@dataclass(frozen=True, eq=False)
class LogSection:
    """
    Samples without a gap: t [N] s, position [N, J], input [N, J] (torque or setpoint).

    setpoint [N, J]: of the servos that made the torque, None where it is not known.
    """

    t: Array
    position: Array
    input: Array
    setpoint: Array | None = None


@dataclass(frozen=True, eq=False)
class RobotLog:
    """
    A recording of the joints `joints` in the order of the model.

    kind: of the input: TORQUE (N m), CURRENT (made a torque by constants) or SETPOINT (rad).
    measured: the torque is measured behind the drive's limits, not commanded. rate: usual samples
    per second. notes: what was left out or repaired, with the joint as `place` of its own.
    """

    name: str
    joints: tuple[str, ...]
    kind: str
    sections: tuple[LogSection, ...]
    rate: float
    measured: bool = False
    notes: tuple[Said, ...] = ()

    @property
    def seconds(self) -> float:
        """Time that the sections cover."""
        return float(sum(section.t[-1] - section.t[0] for section in self.sections))

    @property
    def of_servos(self) -> 'RobotLog | None':
        """The log with the setpoints that made its torques as the input, None without them."""
        if any(section.setpoint is None for section in self.sections):
            return None
        return replace(self, kind=SETPOINT, sections=tuple(
            LogSection(s.t, s.position, s.setpoint) for s in self.sections
            if s.setpoint is not None))


@dataclass(frozen=True, eq=False)
class RawLog:
    """
    Columns as a file holds them: t [N] s; by joint of the model position and input [N].

    kind, measured: as of RobotLog. setpoint [N] by joint, empty where the input is one or none is
    used. slips: times at which a position slips, s. turned: joints whose turns were counted on.
    """

    name: str
    t: Array
    position: Mapping[str, Array]
    input: Mapping[str, Array]
    kind: str
    measured: bool = False
    notes: tuple[Said, ...] = ()
    setpoint: Mapping[str, Array] = field(default_factory=dict)
    slips: tuple[float, ...] = ()
    turned: frozenset[str] = frozenset()


def raw_log(recording: Recording, joints: Mapping[str, str], kind: str,
            constants: Mapping[str, float] | None = None) -> RawLog:
    """
    Return the columns of a robot's recording.

    Args:
        recording: of the robot.
        joints: {joint of the model: its name in the recording}, in the order of the model.
        kind: of the input: TORQUE, CURRENT or SETPOINT.
        constants: torque per current, N m/A, of each joint; without them currents stay A.

    Raises:
        InputError: the recording has no joint of that name, or no message is stamped.
    """
    stamps, signals = recording.on_one_clock(list(joints.values()))
    require_stamps(recording.name, stamps)
    by_joint = dict(zip(joints, signals))
    inputs = {joint: s.setpoint if kind == SETPOINT else s.effort
              for joint, s in by_joint.items()}
    if kind == CURRENT and constants is not None:
        inputs = {joint: x * constants[joint] for joint, x in inputs.items()}
    return RawLog(recording.name, (stamps - stamps[:1]) * 1e-9,
                  {joint: s.position for joint, s in by_joint.items()}, inputs, kind,
                  all(s.measured for s in signals), tuple(map(as_written, recording.notes)),
                  {} if kind == SETPOINT else {
                      joint: s.setpoint for joint, s in by_joint.items() if s.has('setpoint')})


def read_by(raw: RawLog, conventions: Mapping[str, Convention]) -> RawLog:
    """Return a log with joints read by `conventions` {joint: Convention}."""
    position, given, setpoint = dict(raw.position), dict(raw.input), dict(raw.setpoint)
    for joint, convention in conventions.items():
        if joint in position:
            position[joint] = convention.position(position[joint])
            given[joint] = convention.position(given[joint]) if raw.kind == SETPOINT else \
                convention.torque(given[joint])
        if joint in setpoint:
            setpoint[joint] = convention.position(setpoint[joint])
    stated = [said('read_as', place=joint, rules=c.rules) for joint, c in conventions.items()
              if c != AS_RECORDED]
    return replace(raw, position=position, input=given, setpoint=setpoint,
                   notes=(*raw.notes, *stated))


def continuous(raw: RawLog) -> RawLog:
    """
    Return a log with turns counted on, without rows of a second publisher, repeats and outliers.

    Notes say what was found of each joint and when; a slip stays as it is, and ends a section.
    """
    notes, slips, turned = list(raw.notes), set[float](), set[str]()
    joints = list(raw.position)
    foreign = strangers(np.column_stack([raw.position[joint] for joint in joints]), raw.t)
    if foreign.any():
        first = float(raw.t[foreign][0] - raw.t[0])
        notes.append(said('foreign_samples', count=int(foreign.sum()), samples=len(foreign),
                          first=first))
    stale = repeats(np.column_stack([*raw.position.values(), *raw.input.values()]))
    if stale.any():
        notes.append(said('repeated_samples', count=int(stale.sum()), samples=len(stale),
                          first=float(raw.t[stale][0] - raw.t[0])))
    keep = ~(foreign | stale)
    t, position, given, setpoint = raw.t[keep], *(dict[str, Array]() for _ in range(3))
    for joint in joints:
        position[joint], found = without_jumps(raw.position[joint][keep], t)
        given[joint] = raw.input[joint][keep].copy()
        wild = wild_rows(given[joint]) if raw.kind != SETPOINT else np.empty(0, np.int64)
        if len(wild):
            notes.append(said('effort_outliers', place=joint, count=len(wild),
                              first=given[joint][wild[0]], at=t[wild[0]] - t[0]))
            given[joint][wild] = np.nan
        for finding in found:
            notes.append(jump(finding, float(t[finding.row] - t[0]), joint))
            if finding.kind == TURNS:
                turned.add(joint)
            if finding.kind == SLIP:
                slips.update(t[finding.rows].tolist())
        turned_by = next((abs(f.size) for f in found if f.kind == TURNS), 0.0)
        if raw.kind == SETPOINT:
            given[joint] = _on_turn_of(position[joint], given[joint], t, turned_by)
        if joint in raw.setpoint:
            setpoint[joint] = _on_turn_of(
                position[joint], raw.setpoint[joint][keep], t, turned_by)
    return replace(raw, t=t, position=position, input=given, setpoint=setpoint,
                   notes=tuple(notes), slips=tuple(sorted(slips)), turned=frozenset(turned))


def _on_turn_of(position: Array, setpoint: Array, t: Array, turned_by: float) -> Array:
    """
    Return the setpoint [N] of a joint on the turn of its position.

    Args:
        position: of the joint [N], rad.
        setpoint: as recorded [N], rad.
        t: their stamps [N], s.
        turned_by: size of the turns that were counted on in the position, 0 without any.
    """
    period, at = turns(setpoint, t)
    period = period if len(at) else turned_by
    if not period:
        return setpoint
    period = min(PERIODS, key=lambda p: abs(p - period))
    return np.asarray(setpoint + period * np.round((position - setpoint) / period))


def jump(finding: JumpFinding, seconds: float, place: str) -> Said:
    """Return a `finding` about the positions of the joint `place`, the first one at `seconds`."""
    times = f'{finding.count} times' if finding.count > 1 else 'once'
    return said({TURNS: 'joint_turns', OUTLIER: 'joint_outliers', SLIP: 'joint_slips'}[
        finding.kind], place=place, size=abs(finding.size), times=times, count=finding.count,
        at=seconds)


def _at_stamps(t: Array, values: Array, rows: Integers, kind: str
               ) -> tuple[Array, Array]:
    """
    Return stamps [M] and values [M, 2J] of `rows` [M], where each column has its own rows.

    Positions by a spline, torques between their neighbours; a setpoint holds until the next one.

    Args:
        t: stamps of all rows [N], s.
        values: positions and inputs [N, 2J], NaN in rows that are not a column's own.
        rows: whose stamps count.
        kind: of the input.
    """
    order = np.argsort(t, kind='stable')
    at, out = t[rows], np.full((len(rows), values.shape[1]), np.nan)
    for column, x in enumerate(values.T):
        own = order[np.isfinite(x[order])]
        own = own[np.diff(t[own], prepend=-np.inf) > 0.0]
        if len(own) < 2:
            continue
        following = np.clip(np.searchsorted(t[own], at), 1, len(own) - 1)
        wide = max(SETTINGS.gap * float(np.median(np.diff(t[own]))), SETTINGS.gap_seconds)
        step = t[own[following]] - t[own[following - 1]]
        bridged = (step <= wide) & (at >= t[own[0]]) & (at <= t[own[-1]])
        if column < values.shape[1] // 2:
            y = scipy.interpolate.CubicSpline(t[own], x[own])(at)
        elif kind == SETPOINT:
            y = x[own[np.searchsorted(t[own], at, 'right') - 1]]
        else:
            y = np.interp(at, t[own], x[own])
        out[bridged, column] = y[bridged]
    return at, out


def _expect_joints(raw: RawLog, joints: Sequence[str]) -> None:
    """Raise InputError unless a log has numbers of all `joints`."""
    for joint in joints:
        if joint not in raw.position or joint not in raw.input:
            kind = 'position' if joint not in raw.position else raw.kind
            raise InputError(
                f'{raw.name}: joint {joint}: no {kind}, expected all joints of the model; the log '
                f'has {", ".join(raw.position) or "none"} (--recorded NAME=LOGNAME maps a name)')
        for signal, column in (('position', raw.position[joint]), (raw.kind, raw.input[joint])):
            if not np.isfinite(column).any():
                raise InputError(f'{raw.name}: joint {joint}: {signal}: none of {len(column)} '
                                 'samples is a number, expected numbers')


def _whole_samples(raw: RawLog, joints: Sequence[str]) -> tuple[Array, Array, list[Said]]:
    """Return stamps [N] and values [N, 2J] of the samples that hold all joints, and notes."""
    values = np.column_stack([raw.position[j] for j in joints] + [raw.input[j] for j in joints])
    notes: list[Said] = []
    stamped = np.isfinite(raw.t)
    t, values = raw.t[stamped], values[stamped]
    own = np.isfinite(values)
    if np.sum(own.all(axis=1)) < 0.5 * own.sum(axis=0).min():
        rarest = int(np.argmin(own.sum(axis=0)))
        rows = np.flatnonzero(own[:, rarest])
        separate = [joint for i, joint in enumerate(joints) if not own[rows, i].all()]
        notes.append(said('own_messages', names=', '.join(separate),
                          clock=joints[rarest % len(joints)]))
        t, values = _at_stamps(t, values, rows, raw.kind)
    good = np.logical_and.reduce(np.isfinite(values), axis=1)
    if not good.all():
        notes.append(said('not_whole', count=int(np.sum(~good)), samples=len(good)))
    t, values = t[good], values[good]
    if len(t) < 3:
        raise InputError(f'{raw.name}: {len(t)} whole samples, expected {LEAST_SECONDS:g} s or '
                         'more')
    return t, values, notes


def _held(raw: RawLog, joints: Sequence[str], t: Array) -> Array | None:
    """
    Return the setpoints [M, J] of servos at `t` [M]: each holds until the next one.

    None where a joint has none, or where its first one comes late.
    """
    out = np.empty((len(t), len(joints)))
    for j, joint in enumerate(joints):
        x = raw.setpoint.get(joint, np.empty(0))
        own = np.flatnonzero(np.isfinite(x) & np.isfinite(raw.t)) if len(x) else np.empty(0, int)
        own = own[np.argsort(raw.t[own], kind='stable')]
        if not len(own) or raw.t[own[0]] - t[0] > LATE * (t[-1] - t[0]):
            return None
        out[:, j] = x[own[np.maximum(np.searchsorted(raw.t[own], t, 'right') - 1, 0)]]
    return out


def _usual_period(name: str, t: Array) -> float:
    """Return the usual time between the stamps `t` [N], s. Raises InputError for a slow log."""
    # The step in which half of the time passes: many stamps on top of each other do not move it.
    steps = np.sort(np.diff(np.maximum.accumulate(t)))
    period = float(steps[np.searchsorted(np.cumsum(steps), 0.5 * steps.sum())])
    if not period > 0.0:
        raise InputError(f'{name}: t: all stamps are the same, expected seconds that rise')
    if round(1.0 / period, 1) < SETTINGS.least_rate:  # stamps of 30 Hz in ns are 29.99999
        raise InputError(
            f'{name}: {1.0 / period:.3g} samples/s, expected {SETTINGS.least_rate:g} or more: '
            'between slower samples a joint moves too far for its speed to be known')
    return period


def checked_log(raw: RawLog, joints: Sequence[str]) -> RobotLog:
    """
    Return the RobotLog of a file's columns.

    Args:
        raw: the columns.
        joints: of the model, in its order.

    Returns:
        The log, in sections without gaps.

    Raises:
        InputError: a joint is missing, values are not finite, or the log is too slow or short.
    """
    _expect_joints(raw, joints)
    t, values, notes = _whole_samples(raw, joints)
    period, latest = _usual_period(raw.name, t), np.maximum.accumulate(t)
    # Stamps on top of each other would tear a spline; those that go back are not in order.
    keep = np.ones(len(t), bool)
    for i in np.flatnonzero(np.diff(t) < SETTINGS.coincident * period) + 1:
        keep[i] = t[i] - latest[i - 1] >= SETTINGS.coincident * period
    dropped = int(np.sum(~keep))
    if dropped:
        notes.append(said('stamped_before', count=dropped, samples=len(t)))
    t, values = t[keep], values[keep]
    gaps = np.flatnonzero(np.diff(t) > max(SETTINGS.gap * period, SETTINGS.gap_seconds)) + 1
    ends = np.union1d(gaps, np.searchsorted(t, raw.slips))
    count, sections, held = len(joints), [], _held(raw, joints, t)
    for rows in np.split(np.arange(len(t)), ends):
        if len(rows) > 3 and t[rows[-1]] - t[rows[0]] >= LEAST_SECONDS:
            sections.append(LogSection(t[rows], values[rows, :count], values[rows, count:],
                                       None if held is None else held[rows]))
    if not sections:
        raise InputError(f'{raw.name}: {t[-1] - t[0]:.3g} s in {len(ends) + 1} parts, expected '
                         f'one part without gaps of {LEAST_SECONDS:g} s or more')
    used = sum(len(section.t) for section in sections)
    if raw.setpoint and held is None:
        notes.append(said('setpoints_unused',
                          why='some joint has none, or none from the beginning'))
    if len(ends):
        code = 'in_parts' if len(gaps) and len(raw.slips) else (
            'after_stamp_gaps' if len(gaps) else 'after_slips')
        notes.append(said(code, gaps=len(gaps), slips=len(raw.slips), used=used, samples=len(t)))
    return RobotLog(raw.name, tuple(joints), raw.kind, tuple(sections), 1.0 / period,
                    raw.measured, (*raw.notes, *notes))
