# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Watch: one frozen value with all knowledge of a watched robot, and its plain form for files.

It rests on blocks of samples and on the description of the robot alone.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field
import math

from gearbox_monitor.diagnosis.robot.conventions import NamedReading, ReadingScore, RobotReading
from gearbox_monitor.diagnosis.robot.evidence import Prior
from gearbox_monitor.diagnosis.robot.knowledge import Knowledge, States, Visits
from gearbox_monitor.health.checks.outcome import Level
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plain_data import classes_of
from gearbox_monitor.presentation import Saved, Shown
from gearbox_monitor.signals.recording import Convention
from gearbox_monitor.watch.block import Block
from gearbox_monitor.watch.levels import Levels

DESCRIBE, LEARN, WATCH = PHASES = ('describe', 'learn', 'watch')


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
    Prior, ReadingScore, RobotReading, StateHealth, States, Visits, Watch)
