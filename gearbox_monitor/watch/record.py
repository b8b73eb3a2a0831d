# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What goes into a watch and what comes out: blocks of samples, and one frozen value, Watch.

Blocks hold the samples of all joints in 20 s, cut by their stamps alone: a live node and a replay
hand over the same messages in other portions, and the watch takes the same to the bit. Watch holds
all knowledge of a robot, by its blocks and its description; files hold its plain form.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math

import numpy as np

from gearbox_monitor.diagnosis.robot.conventions import NamedReading, ReadingScore, RobotReading
from gearbox_monitor.diagnosis.robot.evidence import Prior
from gearbox_monitor.diagnosis.robot.knowledge import (
    Knowledge, ServoKnowledge, States, Visits)
from gearbox_monitor.diagnosis.robot.robot_log import RawLog, TORQUE
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plain_data import classes_of
from gearbox_monitor.presentation import Saved, Shown
from gearbox_monitor.signals.recording import Convention
from gearbox_monitor.watch.levels import Levels
from gearbox_monitor.watch.settings import DATED, SECOND, WATCH_SETTINGS

DESCRIBE, LEARN, WATCH = PHASES = ('describe', 'learn', 'watch')
LENGTHS = tuple(round(seconds * SECOND) for seconds in (
    WATCH_SETTINGS.block, WATCH_SETTINGS.late, WATCH_SETTINGS.back))
Row = tuple[int, Sequence[str], Sequence[float], Sequence[float], Sequence[float]]


@dataclass(frozen=True, eq=False)
class Block:
    """
    Samples of 20 s.

    begin_ns: a multiple of the length of a block; joints: by name in order of the alphabet;
    stamps int64 [N], rising; position, velocity, effort [N, J], NaN where a joint has none.
    """

    begin_ns: int
    joints: tuple[str, ...]
    stamps: Integers
    position: Array
    velocity: Array
    effort: Array

    @property
    def end_ns(self) -> int:
        """Return where the next block begins."""
        return self.begin_ns + WATCH_SETTINGS.block_ns


class Cutter:
    """
    Collects messages and returns each Block as soon as it is whole.

    A block is whole once a stamp is later than its end by `late`. Messages that come later still
    are dropped and counted in `dropped`. Where a clock restarts, as in a simulation, its
    time follows what was taken; where it has a date, messages are dropped until then.
    """

    def __init__(self, after_ns: int = 0) -> None:
        """Begin behind what was taken up to `after_ns`."""
        self.dropped = 0
        self._rows: list[Row] = []
        self._begin: int | None = None
        self._after, self._later = after_ns, 0

    def take(self, stamp_ns: int, names: Sequence[str], position: Sequence[float],
             velocity: Sequence[float], effort: Sequence[float]) -> list[Block]:
        """
        Return the blocks that a message completes, mostly none.

        Args:
            stamp_ns: of the measurement.
            names: of the joints in the message.
            position: of each, rad or m; empty or NaN: none.
            velocity: of each, rad/s or m/s; empty or NaN: none.
            effort: of each, N m, N or A; empty or NaN: none.
        """
        length, late, back = LENGTHS
        out: list[Block] = []
        stamp = stamp_ns + self._later
        if self._begin is not None and stamp < self._begin:
            if self._begin - stamp < (back if stamp_ns >= DATED else late):
                self.dropped += 1
                return out
            out = self.end()
        if self._begin is None:
            if stamp < self._after and stamp_ns >= DATED:
                self.dropped += self._after - stamp > length    # the last block was cut short
                return out
            if stamp < self._after:
                self._later += (self._after // length + 1 - stamp // length) * length
                stamp = stamp_ns + self._later
            self._begin = stamp // length * length
        while stamp >= self._begin + length + late:
            out += self._cut()
            self._begin = self._begin + length if self._rows else stamp // length * length
        self._rows.append((stamp, names, position, velocity, effort))
        return out

    def before(self, first_ns: int) -> list[Block]:
        """Return the remaining blocks if a recording from `first_ns` on does not continue them."""
        overlaps = self._rows and first_ns + self._later <= self._rows[-1][0]
        return self.end() if overlaps and first_ns < DATED else []

    def end(self) -> list[Block]:
        """Return the blocks of the remaining messages, at the end of a recording."""
        out: list[Block] = []
        while self._rows and self._begin is not None:
            out += self._cut()
            self._begin += WATCH_SETTINGS.block_ns
        self._begin = None
        return out

    def _cut(self) -> list[Block]:
        """Return the Block that begins now, if it has samples; keep later rows."""
        assert self._begin is not None
        end = self._begin + WATCH_SETTINGS.block_ns
        rows = sorted((r for r in self._rows if r[0] < end), key=lambda r: r[0])
        self._rows, self._after = [r for r in self._rows if r[0] >= end], end
        return [_block(self._begin, rows)] if rows else []


def _block(begin_ns: int, rows: Sequence[Row]) -> Block:
    """Return the Block of messages in order of their stamps; equal stamps are one sample."""
    joints = sorted({name for _, names, *_ in rows for name in names})
    place = {name: k for k, name in enumerate(joints)}
    stamps, at = np.unique([r[0] for r in rows], return_inverse=True)
    values = np.full((3, len(stamps), len(joints)), np.nan)
    alike: dict[tuple[object, ...], list[int]] = {}     # rows of the same joints and quantities
    for k, (_, names, *columns) in enumerate(rows):
        alike.setdefault((*names, *map(len, columns)), []).append(k)
    for part in alike.values():
        names = rows[part[0]][1]
        where = np.ix_(at[part], np.array([place[name] for name in names]))
        for table, *columns in zip(values, *(rows[k][2:] for k in part)):
            if len(columns[0]) == len(names):
                table[where] = columns
    there = np.isfinite(values).any(axis=(0, 1))    # a recording names joints of all its messages
    return Block(begin_ns, tuple(name for name, x in zip(joints, there) if x),
                 stamps.astype(np.int64), *values[:, :, there])


def raw_log(blocks: Sequence[Block], joints: Mapping[str, str] | Sequence[str], name: str
            ) -> RawLog:
    """
    Return `blocks` as a log of some `joints`, called `name`.

    Args:
        blocks: in order of time.
        joints: of the model; a joint that a block has not is NaN there.
        name: for notes.
    """
    columns: dict[str, dict[str, Array]] = {'position': {}, 'effort': {}}
    for quantity, table in columns.items():
        for joint in joints:
            table[joint] = np.concatenate([
                getattr(b, quantity)[:, b.joints.index(joint)] if joint in b.joints else
                np.full(len(b.stamps), np.nan) for b in blocks])
    stamps = np.concatenate([b.stamps for b in blocks])
    return RawLog(name, (stamps - stamps[0]) / SECOND, columns['position'], columns['effort'],
                  TORQUE)


@dataclass(frozen=True)
class StateHealth:
    """
    A state of a joint or of the robot, against what was learnt.

    kind: one of settings.KINDS. size, std: of the difference, NaN while it is not known, in units
    as of KindLimits. judged: whether a change of its limit would be seen now.
    """

    kind: str
    size: float = math.nan
    std: float = math.nan
    judged: bool = False


@dataclass(frozen=True)
class Change:
    """
    A change of a state that was found, and lasts until it is over.

    kind, place: of what; place is a joint or `base`. size, std: in units as of KindLimits;
    since_ns: where it began; found_ns: where it was found; over_ns: where it ended, 0 while it
    lasts. before [k]: the state before it. order: of a ripple, waves per turn. rival: (kind,
    place) of what would explain it nearly as well, or ().
    """

    kind: str
    place: str
    size: float
    std: float
    since_ns: int
    found_ns: int
    over_ns: int = 0
    before: tuple[float, ...] = ()
    order: int = 0
    rival: tuple[str, ...] = ()


@dataclass(frozen=True)
class HeldLoad:
    """
    What a link holds, against what it held while the watch learnt.

    mass, mass_std: kg; centre, centre_std [3]: m in the frame of `link`, NaN while the mass is not
    sure; since_ns: of its last change; over_ns: of the next one, 0 while it is held.
    """

    link: str
    mass: float
    mass_std: float
    centre: tuple[float, float, float]
    centre_std: tuple[float, float, float]
    since_ns: int
    over_ns: int = 0


@dataclass(frozen=True, eq=False)
class Held:
    """Inertial parameters [10] and covariance [10, 10] of what `link` holds since `since_ns`."""

    link: str
    values: Array
    covariance: Array
    since_ns: int


@dataclass(frozen=True)
class JointWatch:
    """
    What is known of one joint of the description.

    fixed: why it is taken for fixed, '' if it is not. has: quantities that the stream has of it,
    of position, velocity, effort; rate: samples per second. moved: seconds in motion so far.
    position: usual one while it was learnt, rad or m.
    level: None while it is not judged, and `why` says why not. states: friction, torque scale,
    rotor, weight.
    """

    name: str
    fixed: str = ''
    has: tuple[str, ...] = ()
    rate: float = 0.0
    moved: float = 0.0
    position: float = math.nan
    level: Level | None = None
    why: str = ''
    states: tuple[StateHealth, ...] = ()


@dataclass(frozen=True)
class WatchEvent:
    """What happened: `kind` is phase, raised, over or payload; at stamp_ns, in plain words."""

    kind: str
    stamp_ns: int
    place: str
    words: str


@dataclass(frozen=True, eq=False, repr=False)
class Watch(Shown, Saved):
    """
    The state of a watch after the block that ended at `stamp_ns`.

    description: URDF; doubts: its values that cannot be true. phase: one of PHASES. joints: of the
    description. level: of the robot as a whole, None while it is not judged. tilt: of the base.
    changes: newest last, those that are over, too. payloads: of each link that may carry; earlier:
    those before, newest last. readings: conventions by which the stream is read. notes: what was
    left out of the stream, in words. others: joints of the stream that the description has not.
    locked {joint: position}: joints that are taken for fixed. blocks: taken so far.

    kept, knowledge, states, held, baseline, empty: all that the next step depends on.
    """

    description: str
    doubts: tuple[str, ...] = ()
    phase: str = DESCRIBE
    stamp_ns: int = 0
    blocks: int = 0
    joints: tuple[JointWatch, ...] = ()
    level: Level | None = None
    tilt: StateHealth | None = None
    changes: tuple[Change, ...] = ()
    payloads: tuple[HeldLoad, ...] = ()
    earlier: tuple[HeldLoad, ...] = ()
    readings: tuple[NamedReading, ...] = ()
    notes: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    locked: Mapping[str, float] = field(default_factory=dict)
    kept: tuple[Block, ...] = ()
    knowledge: Knowledge | None = None
    states: Levels | None = None
    held: tuple[Held, ...] = ()
    baseline: tuple[tuple[float, ...], ...] = ()
    empty: tuple[Held, ...] = ()

    @property
    def standing(self) -> tuple[Change, ...]:
        """The changes that are not over, the newest last."""
        return tuple(c for c in self.changes if not c.over_ns)


CLASSES = classes_of(
    Block, Change, Convention, Held, JointWatch, Knowledge, Level, Levels, NamedReading, HeldLoad,
    Prior, ReadingScore, RobotReading, ServoKnowledge, StateHealth, States, Visits, Watch)
