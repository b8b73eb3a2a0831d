# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What goes into a watch and what comes out: blocks of samples, and one frozen value, Watch.

Every limit of the watch is here, with its reason. States have levels, which drift, and steps that
last. Each state has a few coefficients. The last blocks, three to nine, are compared with the
level that those before them had. A step is taken for sure only by odds against all states and
times at which one may begin, and it may rest on no single block. The errors of blocks correlate:
posture and load stay.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.robot.conventions import NamedReading, ReadingScore, RobotReading
from gearbox_monitor.diagnosis.robot.knowledge import Knowledge, ServoKnowledge, States, Visits
from gearbox_monitor.diagnosis.robot.likelihood import Prior
from gearbox_monitor.diagnosis.robot.robot_log import RawLog, TORQUE
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plain_data import classes_of
from gearbox_monitor.presentation import Saved, Shown
from gearbox_monitor.signals.recording import Convention

SECOND = 1_000_000_000
DATED = 10 ** 9 * 86400 * 365  # ns from which a stamp is a date
FRICTION, SCALE, ROTOR, WEIGHT, RIPPLE, TILT = KINDS = (
    'friction', 'torque_scale', 'rotor', 'weight', 'ripple', 'tilt')


@dataclass(frozen=True)
class KindLimits:
    """
    What is known of the states of a kind before any is seen.

    jump: deviation of a change; drift: of what temperature and wear do in the root of an hour;
    apart: of the healthy states of two days; limit: size of a change that is an alarm; slow: of
    one without a jump, from the state that was learnt. Friction, torque scale, weight and rotor
    are shares of what the joint has; tilt is m/s^2 of gravity, ripple a share of the effort.
    """

    jump: float
    drift: float
    apart: float
    limit: float
    slow: float


@dataclass(frozen=True)
class WatchSettings:
    """Limits of the watch, by the room's modules; `kinds` are those of each kind of state."""

    # Blocks: length; how much later its last message may come; by how much a clock is set back
    # that starts a new block (s).
    block: float = 20.0
    late: float = 1.0
    back: float = 60.0
    # Motion: s over which a speed is taken; share of a block from which it has motion.
    speed_step: float = 0.1
    share: float = 0.1
    # Learning: blocks of a part of the knowledge; parts that it rests on; power that a block may
    # leave unexplained, over the median one's; blocks alike in this; s in which a joint must have
    # moved; blocks with motion after which the others wait no longer for it.
    part: int = 3
    parts: int = 3
    alike: float = 6.0
    least: int = 7
    moved: float = 15.0
    patience: int = 15
    # Estimates of a block: friction less than this share of a joint's effort was not learnt;
    # shares that no change exceeds, so that coefficients which a block does not show stay finite;
    # candidates that are fitted whole if they gain `clipped` for each coefficient.
    least_friction: float = 1e-3
    widest: float = 10.0
    fitted: int = 8
    # Steps begin in as many blocks as are learnt from. Blocks that one must have lasted, and
    # with a state before it; blocks between two changes of any state, as expected;
    # probability of one that is taken; deviance by which its state explains more than any
    # other; share of the evidence that remains without any one block.
    lasting: int = 3
    often: float = 20000.0
    sure: float = 0.99
    lead: float = 6.0
    alone: float = 0.5
    # Scatter of blocks about a level, over the variance that they state: before any is seen, the
    # blocks that this belief is worth, the blocks of its memory, and its least value (other
    # postures differ by more); largest squared deviation that counts; correlation of the errors
    # of two blocks, which share posture and load.
    scatter: float = 1.0
    belief: float = 4.0
    memory: float = 60.0
    calm: float = 0.2
    clipped: float = 9.0
    correlation: float = 0.5
    # Changes: share of its limit that the deviation of a state may have where it is judged;
    # deviations by which an alarm exceeds its limit (99 %, one side); share of its limit
    # below which a change has ended.
    power: float = 0.3
    certain: float = 2.33
    over: float = 0.5
    # Loads: deviations by which a mass was taken or put down; chi squared of mass and first
    # moments from which another load is held; share of link and load by which all torques
    # together may be off without a sign; earlier loads that are remembered.
    noticed: float = 5.0
    taken: float = 35.0
    scaled: float = 0.02
    remembered: int = 40
    kinds: Mapping[str, KindLimits] = field(default_factory=lambda: MappingProxyType({
        # Friction of gears halves between a cold and a warm robot, within an hour or two.
        FRICTION: KindLimits(0.5, 0.1, 0.03, 0.15, 0.5),
        SCALE: KindLimits(0.3, 0.002, 0.005, 0.06, 0.1),
        ROTOR: KindLimits(0.3, 0.01, 0.02, 0.05, 0.2),
        WEIGHT: KindLimits(0.5, 0.005, 0.01, 0.1, 0.2),
        RIPPLE: KindLimits(0.1, 0.003, 0.005, 0.02, 0.05),
        TILT: KindLimits(1.0, 0.01, 0.02, 0.2, 0.4)}))

    @property
    def recent(self) -> int:
        """Blocks in which a step may have begun."""
        return self.part * self.parts

    @property
    def block_ns(self) -> int:
        """Length of a block, ns."""
        return round(self.block * SECOND)


WATCH_SETTINGS = WatchSettings()


Deviation: TypeAlias = tuple[Array, Array]   # values [k] and covariance [k, k]


@dataclass(frozen=True, eq=False)
class Levels:
    """
    What is known of F states with up to W coefficients.

    level [F, W], covariance [F, W, W]: by the blocks before the recent ones; scatter [F], seen
    [F]: squared deviation of those blocks from the level, over what each states, and their number;
    values [T, F, W], precision [T, F, W, W]: of recent blocks, 0 where one shows nothing; gains
    [T, F]: deviance that each state alone explains; begin_ns [T]: of these blocks. jump, drift
    [F, W]: deviation of a step, of a change in an hour.
    """

    level: Array
    covariance: Array
    scatter: Array
    seen: Array
    values: Array
    precision: Array
    gains: Array
    begin_ns: tuple[int, ...]
    jump: Array
    drift: Array


class LevelStep(NamedTuple):
    """
    A step that is sure: of which state, since when, and the level before [W].

    rival: the state that explains nearly as much, None if none does.
    """

    state: int
    since_ns: int
    before: Array
    rival: int | None = None


def levels_of(jump: Array, drift: Array, apart: Array) -> Levels:
    """
    Return the Levels of states that are as learnt.

    Args:
        jump: deviation [F, W] of a step.
        drift: of a change in an hour.
        apart: of what was learnt; 0: no coefficient.
    """
    count, width = apart.shape
    covariance = np.where(apart > 0.0, apart ** 2, 1.0)[:, :, None] * np.eye(width)
    return Levels(np.zeros_like(apart), covariance, np.full(count, WATCH_SETTINGS.scatter),
                  np.zeros(count), np.zeros((0, count, width)),
                  np.zeros((0, count, width, width)), np.zeros((0, count)), (), jump, drift)


def level_of(levels: Levels, state: int, width: int) -> Deviation:
    """Return mean and covariance of a state with `width` coefficients in its `levels`."""
    return levels.level[state, :width], levels.covariance[state, :width, :width]


def now(levels: Levels, state: int, width: int) -> Deviation:
    """Return mean and covariance of a state, `width` numbers, in the recent blocks of `levels`."""
    precision = levels.precision[:, state, :width, :width]
    score = np.einsum('tij,tj->i', precision, levels.values[:, state, :width])
    covariance = np.linalg.inv(precision.sum(axis=0) + 1e-12 * np.eye(width))
    inflation = _inflation(len(precision)) * levels.scatter[state]
    return covariance @ score, covariance * inflation


def with_block(levels: Levels, deviations: Sequence[Deviation | None], gains: Array,
               begin_ns: int) -> Levels:
    """
    Return the levels after a block.

    Args:
        levels: before it.
        deviations: of each state from its level; None where the block does not show it.
        gains: deviance [F] that each state alone would explain.
        begin_ns: of the block.
    """
    count, width = levels.level.shape
    values, precision = np.zeros((count, width)), np.zeros((count, width, width))
    for f, estimate in enumerate(deviations):
        if estimate is not None:
            k = len(estimate[0])
            values[f, :k] = levels.level[f, :k] + estimate[0]
            precision[f, :k, :k] = np.linalg.inv(estimate[1])
    out = replace(levels, values=np.r_[levels.values, values[None]],
                  precision=np.r_[levels.precision, precision[None]],
                  gains=np.r_[levels.gains, gains[None]],
                  begin_ns=(*levels.begin_ns, begin_ns))
    return _aged(out) if len(out.begin_ns) > WATCH_SETTINGS.recent else out


def step_in(levels: Levels) -> LevelStep | None:
    """
    Return the step that the recent blocks in `levels` make sure, if there is one.

    The usual scatter of the states decides whether something stepped. The state that stepped is
    the one that explains most of the blocks since then, less the deviance that its freedom costs
    (Occam factor): a weight can imitate any rotor.
    """
    s, blocks = WATCH_SETTINGS, len(levels.begin_ns)
    if blocks < s.lasting:
        return None
    odds = np.array([_evidence(levels, np.ones(age))[0] for age in range(1, blocks + 1)])
    odds[:, levels.seen < s.lasting] = -np.inf
    age = 1 + int(np.unravel_index(np.argmax(odds), odds.shape)[0])
    gain = levels.gains[-age:].sum(axis=0) - _evidence(levels, np.ones(age))[1]
    f = int(np.argmax(gain))
    prior = math.log(s.often * len(levels.level))
    unsure = odds[age - 1, f] - prior < math.log(s.sure / (1.0 - s.sure))
    second = int(np.argsort(gain)[-2])
    ambiguous = gain[f] - gain[second] < s.lead
    if age < s.lasting or unsure or (ambiguous and age < s.recent):
        return None
    least = min(float(_evidence(levels, np.arange(age) != t)[0][f]) for t in range(age))
    return LevelStep(f, levels.begin_ns[-age], levels.level[f], second if ambiguous else None) if (
        least > s.alone * odds[age - 1, f]) else None


def stepped(levels: Levels, step: LevelStep) -> Levels:
    """Return the levels after a step, which makes the recent values of all other states void."""
    level, covariance = levels.level.copy(), levels.covariance.copy()
    f, begin = step.state, levels.begin_ns.index(step.since_ns)
    own = replace(levels, values=levels.values[begin:], precision=levels.precision[begin:])
    width = int(np.sum(levels.jump[f] > 0.0))
    level[f, :width], covariance[f, :width, :width] = now(own, f, width)
    return replace(levels, level=level, covariance=covariance, values=levels.values[:0],
                   precision=levels.precision[:0], gains=levels.gains[:0], begin_ns=())


def _inflation(blocks: float) -> float:
    """Return how many times as uncertain `blocks` are as if they erred independently."""
    return 1.0 + WATCH_SETTINGS.correlation * max(blocks - 1.0, 0.0)


def _evidence(levels: Levels, use: Array) -> tuple[Array, Array]:
    """
    Return the evidence for a step of each state [F] in the last blocks, of those in `use` [T].

    It is the log likelihood ratio, and the deviance that the freedom costs (the Occam factor).
    """
    share = use / (_inflation(float(np.sum(use))) * levels.scatter[:, None])     # [F, T]
    precision = levels.precision[-len(use):]
    information = np.einsum('ft,tfij->fij', share, precision)
    score = np.einsum('ft,tfij,tfj->fi', share, precision,
                      levels.values[-len(use):] - levels.level)
    still = levels.covariance       # what is not known of the level is no step
    eye = np.eye(still.shape[1])

    def gain_and_cost(prior: Array) -> Array:
        inner = np.linalg.inv(prior) + information
        gain = np.einsum('fi,fi->f', score, np.linalg.solve(inner, score[..., None])[..., 0])
        return np.array([gain, np.linalg.slogdet(eye + prior @ information)[1]])
    gain, cost = gain_and_cost(still + eye * levels.jump[:, :, None] ** 2) - gain_and_cost(still)
    return 0.5 * (gain - cost), cost


def _aged(levels: Levels) -> Levels:
    """Return `levels` with their oldest block in the level, which drifts."""
    s = WATCH_SETTINGS
    hours = max(levels.begin_ns[1] - levels.begin_ns[0], 0) / SECOND / 3600.0
    eye = np.eye(levels.level.shape[1])
    before = levels.covariance + eye * levels.drift[:, :, None] ** 2 * hours
    own = levels.precision[0]
    shown = np.trace(own, axis1=1, axis2=2) > 0.0
    error = levels.values[0] - levels.level
    inner = np.linalg.inv(eye + own @ before) @ own     # inverse of the innovation's covariance
    width = np.maximum((levels.jump > 0.0).sum(axis=1), 1)
    whole = np.einsum('fi,fij,fj->f', error, inner, error) / width
    square = np.minimum(whole, s.clipped)
    seen = levels.seen + shown
    gain = np.where(shown, 1.0 / np.minimum(seen + s.belief, s.memory), 0.0)
    scatter = np.maximum(levels.scatter + gain * (square - levels.scatter), s.calm)
    # A block far off the level counts less: what did not last does not belong to the level.
    outlying = np.maximum(whole / (s.clipped * scatter), 1.0) ** 2
    information = own / (outlying * scatter * _inflation(2.0))[:, None, None]
    covariance = np.linalg.inv(np.linalg.inv(before) + information)
    level = levels.level + np.einsum('fij,fjk,fk->fi', covariance, information, error)
    return replace(levels, level=level, covariance=covariance, scatter=scatter, seen=seen,
                   values=levels.values[1:], precision=levels.precision[1:],
                   gains=levels.gains[1:],
                   begin_ns=levels.begin_ns[1:])


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
