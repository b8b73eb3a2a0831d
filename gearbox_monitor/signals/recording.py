# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A recording of a drive or robot: the signals of its joints, and how a log states them."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from types import MappingProxyType

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel

SIDES = (JOINT, MOTOR, ARM) = ('joint', 'motor', 'arm')
EFFORTS = (CURRENT, UNKNOWN) = ('current', 'unknown')
QUANTITIES = ('position', 'velocity', 'setpoint', 'effort')
NOT_MEASURED = np.empty(0)  # becomes NaN throughout


@dataclass(frozen=True, eq=False)
class JointSignals:
    """
    Signals [N] of one joint, or of one side of its gearbox; NaN: not measured.

    stamp_ns: time of measurement, int64 ns. position, setpoint: rad, of a prismatic joint m;
    velocity: rad/s or m/s; effort: in the unit of `effort_is`. side: of the gearbox on which the
    position is measured, JOINT where there is one position alone. effort_is: CURRENT (A) or
    UNKNOWN, which is taken as the torque or force of the joint. measured: the effort comes from a
    sensor behind the drive, it is not a command.
    """

    stamp_ns: Integers
    position: Array = field(default_factory=NOT_MEASURED.copy)
    velocity: Array = field(default_factory=NOT_MEASURED.copy)
    setpoint: Array = field(default_factory=NOT_MEASURED.copy)
    effort: Array = field(default_factory=NOT_MEASURED.copy)
    side: str = JOINT
    effort_is: str = UNKNOWN
    measured: bool = False

    def __post_init__(self) -> None:
        for name, value, allowed in (('side', self.side, SIDES),
                                     ('effort_is', self.effort_is, EFFORTS)):
            if value not in allowed:
                raise InputError(f'{name}: {value!r}, {unknown(value, allowed)}')
        stamps = np.asarray(self.stamp_ns, np.int64).view()
        for name, values in (('stamp_ns', stamps), *(
                (name, np.asarray(getattr(self, name), float).view()) for name in QUANTITIES)):
            if not values.size:  # a broadcast scalar takes no memory
                values = np.broadcast_to(np.nan, len(stamps))
            if values.shape != stamps.shape:
                raise InputError(f'{name}: shape {values.shape}, expected {stamps.shape} as of '
                                 'the stamps')
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    def has(self, quantity: str) -> bool:
        """Return whether `quantity`, one of QUANTITIES, was ever measured."""
        return bool(np.isfinite(getattr(self, quantity)).any())


@dataclass(frozen=True, eq=False)
class Recording:
    """
    Signals of one drive or robot, by the names that its joints have in the source.

    A drive with two encoders has two entries, one with side MOTOR and one with side ARM. Joints of
    one message share the array of their stamps. name: what messages call the source. notes: what
    was dropped, repaired or assumed on the way here, in sentences.
    """

    name: str
    joints: Mapping[str, JointSignals]
    notes: Sequence[str] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, 'joints', MappingProxyType(dict(self.joints)))
        object.__setattr__(self, 'notes', tuple(self.notes))

    def __getitem__(self, joint: str) -> JointSignals:
        """Return the signals of `joint`. Raises InputError where there is none of that name."""
        if joint not in self.joints:
            raise InputError(f'{self.name}: joint {joint!r}, {unknown(joint, self.joints)}')
        return self.joints[joint]

    def on_side(self, side: str) -> str | None:
        """Return the first joint whose position is measured on `side`, None without one."""
        return next((name for name, s in self.joints.items() if s.side == side), None)

    def on_one_clock(self, joints: Sequence[str]) -> tuple[Integers, list[JointSignals]]:
        """Return (stamps [N], signals) of `joints`. Raises InputError: their stamps differ."""
        signals = [self[joint] for joint in joints]
        for joint, s in zip(joints, signals):
            if not np.array_equal(s.stamp_ns, signals[0].stamp_ns):
                raise InputError(f'{self.name}: joint {joint!r}: other stamps than those of '
                                 f'{joints[0]!r}, expected the same: interpolate it')
        return signals[0].stamp_ns, signals


def drive_samples(recording: Recording, model: DriveModel) -> Samples:
    """
    Return the samples of one drive on the arm side, as filters and the diagnosis take them.

    The motor is the joint on side MOTOR, the arm that on side ARM; where the recording names no
    side, its only joint is the motor. The gear ratio and the torque constant of the model refer
    the motor to the arm side; with a controller in the model its setpoint comes in place of the
    torque.

    Args:
        recording: of the drive.
        model: of the drive.

    Raises:
        InputError: it has no motor and no arm.
    """
    motor, arm = recording.on_side(MOTOR), recording.on_side(ARM)
    if motor is None and arm is None and len(recording.joints) == 1:
        motor = recording.on_side(JOINT)
    if motor is None and arm is None:
        raise InputError(f'{recording.name}: joints {", ".join(recording.joints) or "none"}, '
                         'expected the motor or the arm of one drive')
    names = [name for name in (motor, arm) if name is not None]
    stamps, signals = recording.on_one_clock(names)
    by_name = dict(zip(names, signals))
    u, y = np.full((2, len(stamps), 2), np.nan)
    if motor is not None:
        s = by_name[motor]
        y[:, 0] = s.position / model.gear_ratio
        u[:, 0] = (s.effort * model.effort_scale if model.controller is None
                   else s.setpoint / model.gear_ratio)
    if arm is not None:
        y[:, 1], u[:, 1] = by_name[arm].position, by_name[arm].effort
    return Samples(stamps, u, y)


OPTION = '--convention'
ALL = 'all'
UNITS = {'deg': math.pi / 180.0, 'mrad': 1e-3, 'turns': 2.0 * math.pi, 'mm': 1e-3}
RULES = 'reversed, zero:RAD, effort:FACTOR, ' + ', '.join(UNITS)


@dataclass(frozen=True)
class Convention:
    """
    The reading of one joint: position = sign (unit logged - zero), torque = sign effort logged.

    reversed: the log counts the other way, so that sign is -1. zero: position, rad or m, that the
    log has where the description is at 0. unit: rad or m of one unit of the log. effort: N m or N
    of one unit of the effort; negative where its sign is turned against the position.
    """

    reversed: bool = False
    zero: float = 0.0
    unit: float = 1.0
    effort: float = 1.0

    @property
    def sign(self) -> float:
        """-1 where the log counts the other way."""
        return -1.0 if self.reversed else 1.0

    def position(self, logged: Array) -> Array:
        """Return positions or setpoints [N] as the description counts them."""
        return self.sign * (self.unit * logged - self.zero)

    def torque(self, logged: Array) -> Array:
        """Return efforts [N] as the description counts them."""
        return self.sign * self.effort * logged

    @property
    def rules(self) -> str:
        """The convention as the option takes it."""
        units = {value: word for word, value in UNITS.items() if word != 'mrad'}
        words = [*([units.get(self.unit, 'deg')] if self.unit != 1.0 else []),
                 *(['reversed'] if self.reversed else []),
                 *([f'zero:{self.zero:.4g}'] if self.zero else []),
                 *([f'effort:{self.effort:.4g}'] if self.effort != 1.0 else [])]
        return ','.join(words) or 'as-recorded'


AS_RECORDED = Convention()


def conventions_of(words: Iterable[str], joints: Sequence[str]) -> dict[str, Convention]:
    """
    Return {joint: Convention} of `words` JOINT=RULE[,RULE] of an option.

    Args:
        words: as a user writes them; JOINT may be `all`.
        joints: of the robot.

    Raises:
        InputError: no such joint or rule.
    """
    stated: dict[str, Convention] = {}
    for word in words:
        name, equals, rules = word.partition('=')
        if not equals or not rules:
            raise InputError(f'{OPTION}: {word!r}, expected JOINT=RULE with a rule of {RULES}')
        if name not in (*joints, ALL):
            raise InputError(f'{OPTION}: {name!r}, {unknown(name, (*joints, ALL))}')
        for joint in joints if name == ALL else (name,):
            convention = stated.get(joint, AS_RECORDED)
            for rule in rules.split(','):
                convention = _ruled(convention, rule, f'{OPTION}: {word!r}')
            stated[joint] = convention
    return stated


def _ruled(convention: Convention, rule: str, where: str) -> Convention:
    """Return a convention with one more `rule`. Raises InputError."""
    word, _, number = rule.partition(':')
    if word == 'as-recorded' and not number:
        return convention
    if word == 'reversed' and not number:
        return replace(convention, reversed=True)
    if word in UNITS and not number:
        return replace(convention, unit=UNITS[word])
    if word in ('zero', 'effort'):
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if math.isfinite(value) and (word == 'zero' or value != 0.0):
            return replace(convention, zero=value) if word == 'zero' else replace(
                convention, effort=value)
    raise InputError(f'{where}: {rule!r}, expected a rule of {RULES}')
