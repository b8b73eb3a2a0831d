# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The parameters of the nodes as frozen dataclasses; each field carries its row of the table.

One truth for node declarations, YAML files, validation, attributes and docs. Standard deviations
of process noise are spectral: per square root of a second, so that the sample rate can change
without retuning.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
import math
from pkgutil import iter_modules
from typing import Any, Self, TypeAlias, TypeVar

import gearbox_monitor
from gearbox_monitor.errors import InputError, Problems, unknown
from gearbox_monitor.plant.drive import DriveModel, expect_model
from gearbox_monitor.plant.faults import KINDS as EXCITATIONS

# When a change takes effect: at once; with a restart of the filter; or never while it runs.
AT_ONCE, RESTART, FIXED = 'at once', 'restart', 'fixed'
# A filter is registered by its file; listing the files imports none of them.
FILTER_NAMES = tuple(sorted(module.name for module in iter_modules(
    [f'{path}/estimation/filters' for path in gearbox_monitor.__path__])))
# What a filter takes for the law of tau_K.
TAU_K_MODELS = RANDOM_WALK, ELASTIC, LEARNED, MIXED = (
    'random_walk', 'elastic', 'learned', 'mixed')
CURVES = ELASTIC, LEARNED

# What a robot carries changes often: filters, windows and alarms go on as if nothing had happened.
PAYLOAD = frozenset(('payload_mass', 'payload_tolerance', 'payload_position', 'payload_link'))

ParameterValue: TypeAlias = bool | int | float | str | tuple[str, ...] | tuple[float, ...]


@dataclass(frozen=True)
class ParameterRow:
    """One row: `low` and `high` bound numbers, `choices` strings."""

    name: str
    default: object
    unit: str
    description: str
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    change: str = FIXED

    @property
    def kind(self) -> type:
        """The type of the value: bool, int, float, str, or tuple (of str or float)."""
        return type(self.default)

    @property
    def item_kind(self) -> type:
        """The type of a number or text in the value: of its items, if it is a tuple."""
        return type(self.default[0]) if isinstance(self.default, tuple) else self.kind

    def check(self, value: object, source: str) -> ParameterValue:
        """Return `value` in the parameter's type; raises InputError that names `source`."""
        is_sequence = isinstance(value, (list, tuple))
        items = tuple(value) if isinstance(value, (list, tuple)) else (value,)
        if is_sequence != (self.kind is tuple) or not all(map(self._allows, items)):
            raise InputError(f'{source}: {self.name}: {value!r}, expected {self.expected()}')
        checked = tuple(map(float, items)) if self.item_kind is float else items
        return checked if is_sequence else checked[0]

    def _allows(self, item: object) -> bool:
        """Return whether the number or text `item` has the right type and is within bounds."""
        if isinstance(item, bool) or self.item_kind is bool:
            return type(item) is self.item_kind
        if isinstance(item, int) or isinstance(item, float) and self.item_kind is float:
            return self.item_kind in (int, float) and self.low <= item <= self.high
        return isinstance(item, str) and self.item_kind is str and (
            not self.choices or item in self.choices)

    def expected(self) -> str:
        """Return what a value must be, in words."""
        if self.choices:
            return 'one of ' + ', '.join(self.choices)
        word = {bool: 'true or false', int: 'a whole number', float: 'a number',
                str: 'a text', tuple: 'a list'}[self.kind]
        if self.kind is tuple:
            word += ' of numbers' if self.item_kind is float else ' of texts'
        bounds = [f'>= {self.low:g}'] if self.low > -math.inf else []
        bounds += [f'<= {self.high:g}'] if self.high < math.inf else []
        unit = f' ({self.unit})' if self.unit not in ('', '-') else ''
        return ' '.join([word, ' and '.join(bounds)]).strip() + unit


Table: TypeAlias = tuple[ParameterRow, ...]
Default = TypeVar('Default', bound=ParameterValue)


def row(default: Default, unit: str, description: str, *, low: float = -math.inf,
        high: float = math.inf, choices: tuple[str, ...] = (), change: str = FIXED) -> Default:
    """
    Return a dataclass field with its row of the table, see ParameterRow.

    Args:
        default: value if none is given; its type is the type of the parameter.
        unit: '-' for a ratio, '' if the value is no quantity.
        description: one sentence for docs and `ros2 param describe`.
        low: smallest number allowed.
        high: largest number allowed.
        choices: texts allowed; empty: any.
        change: AT_ONCE, RESTART or FIXED.

    Returns:
        The field; typed as `default`, as dataclasses.field is.

    """
    return field(default=default, metadata={'row': ParameterRow(
        '', default, unit, description, low, high, choices, change)})


@dataclass(frozen=True, eq=False)
class ParameterSet:
    """Parameters of a node: immutable, complete and checked when they are made."""

    def __post_init__(self) -> None:
        """Raise InputError for a value of a wrong type or out of range."""
        checked = check_values(table_of(type(self)), self.to_dict(), 'parameters')
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, object], source: str = 'parameters') -> Self:
        """
        Return the parameters in `mapping`, with defaults for names that are missing.

        Raises InputError that names `source` and all unknown names, wrong types and values out of
        range.
        """
        return cls(**check_values(table_of(cls), mapping, source))

    @classmethod
    def of(cls, parameters: 'Self | Mapping[str, object] | None',
           source: str = 'parameters') -> Self:
        """Return `parameters` as they are, or made of a mapping; see from_mapping for `source`."""
        if isinstance(parameters, Mapping):
            return cls.from_mapping(parameters, source)
        return cls() if parameters is None else parameters

    def replace(self, **changes: object) -> Self:
        """Return a checked copy with `changes`. Raises InputError."""
        return self.from_mapping({**self.to_dict(), **changes})

    def to_dict(self) -> dict[str, Any]:
        """Return {name: value} of plain values: sequences as lists, as YAML and ROS take them."""
        return {f.name: list(value) if isinstance(value, tuple) else value
                for f in fields(self) for value in [getattr(self, f.name)]}

    def changes(self) -> dict[str, Any]:
        """Return {name: value} of those that differ from their defaults, as `to_dict` does."""
        return {name: value for name, value in self.to_dict().items()
                if getattr(self, name) != getattr(type(self), name)}


# Limits of one change, each at least as large as the previous one.
LIMITS_IN_ORDER = (('gap_notice', 'gap_warn', 'gap_error'), ('stiffness_warn', 'stiffness_error'),
                   ('friction_warn', 'friction_error'))


@dataclass(frozen=True)
class EstimatorParameters(ParameterSet):
    """Parameters of the estimator, and of all that computes with a filter."""

    filter: str = row('ekf', '', 'filter that estimates the torque', choices=FILTER_NAMES)
    model: str = row('', '', 'model file of the drive; empty for the packaged drive.yaml')
    motor_joint: str = row('motor', '', 'name of the motor in joint_states')
    arm_joint: str = row(
        'arm', '', 'name of the arm in joint_states; empty: no arm encoder, torque and backlash '
        'are estimated from the motor alone')
    arm_topic: str = row(
        '', '', 'topic of the arm encoder if it has its own messages (sensor_msgs/JointState); '
        'may be joint_states; empty: with the motor')
    pair_tolerance: float = row(
        0.0005, 's', 'with arm_topic: largest distance of the stamps of motor and arm in one '
        'sample; less than half the sample period. At speed v it looks like a twist of v times '
        'the distance', low=0.0, high=1.0)
    gearbox_serial: str = row('gearbox', '', 'hardware_id in diagnostics')
    arm_load: str = row(
        'unknown', '', 'load on the arm besides effects of the model file: none, an unknown load '
        '(estimated), or a measured one (effort of the arm joint); model: as the model file '
        'states, or robot_description gives it',
        choices=('none', 'unknown', 'measured', 'model'))
    robot_description: str = row(
        '', '', 'with arm_load model: URDF of the robot that gives the load on the arm_joint, a '
        'file or, beginning with topic:, a topic (topic:/robot_description); empty: none')
    robot_tolerance: float = row(
        0.1, '-', 'robot_description: how far mass and inertia of each link may be off, either '
        'way', low=0.0, high=1.0, change=AT_ONCE)
    robot_error_time: float = row(
        1.0, 's', 'robot_description: how long an error of the load lasts', low=1e-3,
        high=1e4, change=AT_ONCE)
    robot_acceleration_time: float = row(
        0.005, 's', 'robot_description: time constant of the filter for accelerations, which are '
        'late by three times as much; longer with coarse encoders', low=1e-4, high=1.0,
        change=RESTART)
    robot_gravity: tuple[float, ...] = row(
        (0.0, 0.0, -9.80665), 'm/s^2', 'robot_description: gravity in the frame of the base',
        low=-1e3, high=1e3, change=AT_ONCE)
    payload_mass: float = row(
        0.0, 'kg', 'robot_description: mass that the robot carries now', low=0.0, high=1e6,
        change=AT_ONCE)
    payload_tolerance: float = row(
        0.0, 'kg', 'robot_description: how far payload_mass may be off, either way', low=0.0,
        high=1e6, change=AT_ONCE)
    payload_position: tuple[float, ...] = row(
        (0.0, 0.0, 0.0), 'm', 'robot_description: centre of the payload in the frame of '
        'payload_link', low=-1e3, high=1e3, change=AT_ONCE)
    payload_link: str = row(
        '', '', 'robot_description: link that carries the payload; empty: the last one that '
        'moves', change=AT_ONCE)
    effort_is: str = row(
        'unknown', '', 'what the effort of the motor is: a torque; a current, converted by '
        'torque_constant of the model file; gravity_compensated: a torque without the weight, '
        'which robot_description adds; unknown: not stated, converted by torque_constant',
        choices=('torque', 'current', 'gravity_compensated', 'unknown'))
    effort_delay: int = row(
        0, 'samples', 'effort stamped t_k acts on [t_k+d, t_k+d+1); -1: it acted on the previous '
        'sample', low=-1, high=50)
    max_gap: float = row(
        0.25, 's', 'longest gap (between stamps, without torque or without measurement) that '
        'prediction bridges; a longer one restarts the filter', low=1e-3, high=60.0)
    smoother_lag: float = row(
        0.1, 's', 'lag of the smoothed output; 0 switches it off', low=0.0, high=1.0)
    narrow_std: bool = row(
        True, '', 'state less deviation of tau_K where innovations show that it wanders less than '
        'q_std_tau_k lets it')
    r_std_motor: float = row(
        5e-3, 'rad', 'noise of the motor encoder, arm side', low=1e-9, high=1e3, change=AT_ONCE)
    r_std_arm: float = row(
        5e-3, 'rad', 'noise of the arm encoder', low=1e-9, high=1e3, change=AT_ONCE)
    q_std_motor_position: float = row(
        0.0, 'rad/sqrt(s)', 'process noise of the motor position', low=0.0, high=1e6,
        change=AT_ONCE)
    q_std_arm_position: float = row(
        0.0, 'rad/sqrt(s)', 'process noise of the arm position', low=0.0, high=1e6, change=AT_ONCE)
    q_std_motor_speed: float = row(
        0.4, 'rad/s/sqrt(s)', 'process noise of the motor speed', low=0.0, high=1e6,
        change=AT_ONCE)
    q_std_arm_speed: float = row(
        0.4, 'rad/s/sqrt(s)', 'process noise of the arm speed', low=0.0, high=1e6, change=AT_ONCE)
    q_std_tau_k: float = row(
        8.0, 'N m/sqrt(s)', 'process noise of tau_K', low=0.0, high=1e9, change=AT_ONCE)
    q_std_tau_k_speed: float = row(
        0.0, 'N m/sqrt(s) per rad/s', 'additional process noise of tau_K per motor speed, added '
        'to q_std_tau_k in quadrature', low=0.0, high=1e9, change=AT_ONCE)
    q_std_tau_arm: float = row(
        8.0, 'N m/sqrt(s)', 'process noise of the unknown load on the arm', low=0.0, high=1e9,
        change=AT_ONCE)
    tau_k_model: str = row(
        RANDOM_WALK, '', 'law of tau_K: a random walk (the paper); the curve of the model file '
        'over the twist plus a random walk (elastic); the same with stiffness, gap and hysteresis '
        'learned online; all three, mixed by their likelihood', choices=TAU_K_MODELS,
        change=RESTART)
    q_std_tau_k_deviation: float = row(
        1.0, 'N m/sqrt(s)', 'elastic, learned: process noise of the deviation of tau_K from the '
        'curve', low=0.0,
        high=1e9, change=AT_ONCE)
    q_std_curve: float = row(
        1e-3, '1/sqrt(s)', 'learned: process noise of stiffness, gap and hysteresis, relative to '
        'their initial standard deviations', low=0.0, high=1e3, change=AT_ONCE)
    p0_std_curve: float = row(
        1.0, '-', 'learned: initial standard deviation of stiffness, gap and hysteresis, relative '
        'to the model file', low=1e-6, high=10.0, change=RESTART)
    tau_k_stiffness: float = row(
        0.0, 'N m/rad', "k_p in tau_K' = k_p (x3 - x4) + w; 0 is the paper's random walk", low=0.0,
        high=1e12, change=AT_ONCE)
    tau_k_model_std: float = row(
        0.0, 'N m', 'error of tau_K that neither noise nor the tolerances of the model file '
        'explain, added to its stated standard deviation in quadrature', low=0.0, high=1e9,
        change=AT_ONCE)
    friction_error_std: float = row(
        0.0, 'N m', 'standard deviation of a friction error as a state (Ornstein-Uhlenbeck); 0: '
        'no such state', low=0.0, high=1e9, change=RESTART)
    friction_error_time: float = row(
        0.7, 's', 'correlation time of that friction error', low=1e-4, high=1e4, change=RESTART)
    p0_std_speed: float = row(
        30.0, 'rad/s', 'initial standard deviation of the speeds; at least the speed of the drive '
        'at a start, otherwise the filter takes that speed for a torque', low=1e-9,
        high=1e6, change=RESTART)
    p0_std_torque: float = row(
        5.0, 'N m', 'initial standard deviation of tau_K and load', low=1e-9, high=1e9,
        change=RESTART)
    p0_std_tau_k_deviation: float = row(
        0.0, 'N m', 'elastic, learned: initial standard deviation of the deviation of tau_K from '
        'the curve; 0: p0_std_torque', low=0.0, high=1e9, change=RESTART)
    friction_linearisation: str = row(
        'tangent', '', 'EKF: friction linearised at the estimate, or over the uncertainty of the '
        'motor speed', choices=('tangent', 'statistical'), change=AT_ONCE)
    ukf_alpha: float = row(
        1.0, '-', 'UKF, SRUKF: spread of the sigma points; small values cost accuracy', low=1e-4,
        high=10.0, change=AT_ONCE)
    ukf_beta: float = row(
        2.0, '-', 'UKF, SRUKF: weight of the centre in the covariance', low=0.0, high=100.0,
        change=AT_ONCE)
    ukf_kappa: float = row(
        0.0, '-', 'UKF, SRUKF: spread, added to the number of states', low=0.0, high=100.0,
        change=AT_ONCE)
    adapt: tuple[str, ...] = row(
        ('q_std_tau_k', 'r_std_motor', 'r_std_arm'), '', 'AEKF: parameters to adapt from their '
        'configured values: q_std_tau_k, r_std_motor, r_std_arm, viscous_friction, '
        'coulomb_friction, tau_k_stiffness; [""]: none', change=RESTART)
    adapt_friction_sharpness: float = row(
        1.0, 's/rad', 'AEKF: sharpness of its Coulomb friction, at most that of the model',
        low=1e-3, high=1e9, change=RESTART)
    adapt_forgetting_start: float = row(
        0.995, '-', 'AEKF: initial forgetting factor per measured sample', low=0.5, high=1.0,
        change=RESTART)
    adapt_forgetting: float = row(
        0.9998, '-', 'AEKF: final forgetting factor; 1 / (1 - factor) samples count',
        low=0.5, high=1.0, change=RESTART)
    adapt_forgetting_rate: float = row(
        0.9995, '-', 'AEKF: transition to the final factor, over 1 / (1 - rate) samples', low=0.0,
        high=1.0, change=RESTART)
    drift_window: float = row(
        10.0, 's', 'length of a window in which backlash is measured', low=0.5, high=600.0)
    gap_notice: float = row(
        0.005, '-', 'relative growth of the gap below which nothing is reported (seasons, '
        'wear-in), even if it is significant', low=0.0, high=10.0, change=AT_ONCE)
    gap_warn: float = row(
        0.10, '-', 'relative growth of the gap that requires planning a service', low=0.0,
        high=10.0, change=AT_ONCE)
    gap_error: float = row(
        0.25, '-', 'relative growth of the gap that is an error, and the limit of the forecast',
        low=0.0, high=10.0, change=AT_ONCE)
    gap_limit: float = row(
        0.0, 'rad', 'gap that is an error regardless of the baseline; 0: none', low=0.0, high=1e3,
        change=AT_ONCE)
    stiffness_warn: float = row(
        0.10, '-', 'relative loss of stiffness, change of torque gain or growth of hysteresis '
        'over load that requires planning a service', low=0.0, high=10.0,
        change=AT_ONCE)
    stiffness_error: float = row(
        0.25, '-', 'the same for an error', low=0.0, high=10.0, change=AT_ONCE)
    friction_warn: float = row(
        0.20, '-', 'relative change of friction that requires planning a service; a quarter of it '
        'is reported once significant', low=0.0, high=10.0, change=AT_ONCE)
    friction_error: float = row(
        0.50, '-', 'the same for an error', low=0.0, high=100.0, change=AT_ONCE)
    false_alarm_interval: float = row(
        3.15e7, 's', 'mean running time between two false alarms of backlash and friction '
        'together; a shorter time detects changes sooner', low=600.0, high=1e12, change=AT_ONCE)
    baseline_file: str = row(
        '', '', 'healthy backlash: read at the start, written by ~/save_baseline; empty: the '
        'first windows are the baseline')
    baseline_windows: int = row(
        720, '', 'number of trusted windows that each operating point learns as healthy; tests '
        'begin after 3', low=3, high=1000000, change=AT_ONCE)
    angle_bin: float = row(
        3.2, 'rad', 'width of an operating point in mean arm angle; 0: all angles share a '
        'baseline', low=0.0, high=1e6, change=AT_ONCE)
    speed_bin: float = row(
        2.0, '-', 'width of an operating point in rms motor speed, a factor; 1: all speeds share '
        'a baseline', low=1.0, high=1e6, change=AT_ONCE)
    load_bin: float = row(
        2.0, '-', 'the same for the rms of tau_K', low=1.0, high=1e6, change=AT_ONCE)
    temperature_bin: float = row(
        5.0, 'K', 'width of an operating point in temperature; 0: all temperatures share a '
        'baseline', low=0.0, high=1e4, change=AT_ONCE)
    temperature_topic: str = row(
        '', '', 'topic with the temperature of the gearbox (sensor_msgs/Temperature); empty: none')
    drift_state_file: str = row(
        '', '', 'file that preserves baselines, test and alarms over a restart, '
        'written after each window; empty: none')
    snapshot_period: float = row(
        10.0, 's', 'period of the snapshots for replay', low=0.1, high=3600.0)
    model_gap_after: float = row(
        60.0, 's', 'window of the model mismatch: prediction errors biased or not white for more '
        'than half of it', low=5.0, high=3600.0, change=AT_ONCE)
    keep_minutes: float = row(
        5.0, 'min', 'length of joint_states in memory for ~/keep_recording, 6 MB for 5 min at 1 '
        'kHz; 0: none', low=0.0, high=60.0)
    keep_folder: str = row(
        '', '', 'folder for recordings of the last keep_minutes: at each ERROR of backlash or '
        'friction, and with ~/keep_recording; empty: where the node was started, with '
        '~/keep_recording only')
    keep_newest: int = row(
        20, '', 'number of recordings in keep_folder; older ones are deleted', low=1,
        high=100_000)
    name_changes: bool = row(
        True, '', 'after an alert or a lasting model mismatch, name what changed against the '
        'baseline recording, in a child process of the lowest priority; costs nothing meanwhile')
    name_changes_after: float = row(
        60.0, 's', 'time for which a model mismatch lasts before it is named', low=5.0,
        high=86400.0)
    name_changes_cpu: float = row(
        300.0, 's', 'largest CPU time of a child that names a change; 10 to 40 s are usual',
        low=1.0, high=86400.0)
    name_changes_memory: int = row(
        2000, 'MB', 'largest address space of that child', low=100, high=1_000_000)

    def __post_init__(self) -> None:
        """Raise InputError for a value of a wrong type or out of range, or limits out of order."""
        super().__post_init__()
        for names in LIMITS_IN_ORDER:
            for low, high in pairwise(names):
                if getattr(self, low) > getattr(self, high):
                    raise InputError(f'parameters: {high}: {getattr(self, high):g}, expected a '
                                     f'number >= {low} ({getattr(self, low):g})')


@dataclass(frozen=True)
class RobotParameters(ParameterSet):
    """Parameters of an estimator for several gearboxes of a robot."""

    gearboxes: tuple[str, ...] = row(
        ('',), '', 'names of the gearboxes of a robot; each has a block of this name with its own '
        'parameters, the other parameters are common; [""]: one gearbox without a name')


@dataclass(frozen=True)
class ModelParameters(ParameterSet):
    """
    Values of the model file that can be changed while the estimator runs.

    Their defaults are those of the model file (here: of the packaged one). No other value of it is
    both free and used by the filters.
    """

    motor_inertia: float = row(
        0.006442, 'kg m^2', 'inertia of the motor, on the arm side', low=1e-12, high=1e6,
        change=RESTART)
    arm_inertia: float = row(0.023454, 'kg m^2', 'inertia of the arm', low=1e-12, high=1e6,
                             change=RESTART)
    damping: float = row(
        0.01, 'N m s/rad', 'damping between motor and arm', low=0.0, high=1e9, change=RESTART)
    viscous_friction: float = row(
        0.1, 'N m s/rad', 'viscous friction of the motor', low=-1e9, high=1e9, change=RESTART)
    coulomb_friction: float = row(
        0.27, 'N m', 'Coulomb friction of the motor', low=0.0, high=1e9, change=RESTART)
    friction_sharpness: float = row(
        100.0, 's/rad', 'sharpness of the Coulomb friction around standstill', low=1e-9, high=1e9,
        change=RESTART)
    position_gain: float = row(
        0.01, 'N m/rad', 'gain of a position loop inside the drive', low=0.0, high=1e9,
        change=RESTART)
    torque_offset: float = row(
        0.0, 'N m', 'added to the commanded torque', low=-1e9, high=1e9, change=RESTART)


@dataclass(frozen=True)
class PlantParameters(ParameterSet):
    """Parameters of the simulated plant; those of its model default to the model file."""

    model: str = row('', '', 'model file of the drive; empty for the packaged drive.yaml')
    motor_joint: str = row('motor', '', 'name of the motor in joint_states')
    arm_joint: str = row('arm', '', 'name of the arm in joint_states')
    rate: float = row(1000.0, 'Hz', 'samples per simulated second', low=100.0, high=2000.0)
    speed: float = row(
        1.0, '-', 'simulated seconds per second; 0: as fast as possible. Any other speed than 1 '
        'publishes /clock', low=0.0, high=1000.0)
    publish_clock: bool = row(False, '', 'publish /clock in real time, too')
    duration: float = row(
        0.0, 's', 'simulated time after which the plant ends; 0: never', low=0.0, high=1e7)
    wait_for_subscribers: int = row(
        0, '', 'start once joint_states and the truth have this many subscribers together, and '
        'they have acknowledged the first sample', low=0, high=100)
    seed: int = row(0, '', 'seed of the noise', low=0, high=2**31 - 1)
    torque_source: str = row(
        'excitation', '', 'source of the torque: the excitation, or effort_command, held until '
        'the next one', choices=('excitation', 'topic'))
    command_timeout: float = row(
        0.5, 's', 'simulated time after which a torque from effort_command ends; 0: never',
        low=0.0, high=3600.0, change=AT_ONCE)
    excitation: str = row(
        'multisine', '', 'signal of the torque on the arm side', choices=EXCITATIONS,
        change=AT_ONCE)
    amplitudes: tuple[float, ...] = row(
        (6.0, 2.0), 'N m', 'amplitudes of the excitation, arm side', low=-1e6, high=1e6,
        change=AT_ONCE)
    frequencies: tuple[float, ...] = row(
        (0.9, 2.3), 'Hz', 'frequencies of the excitation', low=0.0, high=1000.0, change=AT_ONCE)
    period: float = row(
        20.0, 's', 'time of a chirp there and back', low=0.1, high=1e5, change=AT_ONCE)
    process_noise: tuple[float, ...] = row(
        (0.0, 0.0, 0.4, 0.4), 'rad/sqrt(s), rad/s/sqrt(s)', 'noise on motor and arm position, '
        'motor and arm speed', low=0.0, high=1e6, change=AT_ONCE)
    measurement_noise: tuple[float, ...] = row(
        (0.005, 0.005), 'rad', 'noise of motor (arm side) and arm encoder', low=0.0, high=1e3,
        change=AT_ONCE)
    stiffness: float = row(
        25.0, 'N m/rad', 'stiffness of the transmission in contact; default: model file', low=1e-9,
        high=1e12, change=AT_ONCE)
    half_gap: float = row(
        0.1, 'rad', 'half of the backlash before it grows; default: model file', low=0.0, high=1e3,
        change=AT_ONCE)
    viscous_friction: float = row(
        0.1, 'N m s/rad', 'viscous friction of the motor; default: model file', low=-1e9,
        high=1e9, change=AT_ONCE)
    coulomb_friction: float = row(
        0.27, 'N m', 'Coulomb friction of the motor; default: model file', low=0.0, high=1e9,
        change=AT_ONCE)
    gap_growth_rate: float = row(
        0.0, '1/s', 'the gap is half_gap (1 + rate (t - start))', low=0.0, high=1e3,
        change=AT_ONCE)
    gap_growth_start: float = row(
        0.0, 's', 'simulated time at which the gap begins to grow', low=0.0, high=1e7,
        change=AT_ONCE)
    gap_growth_max: float = row(
        10.0, '-', 'relative growth at which the gap stops growing', low=0.0, high=1e3,
        change=AT_ONCE)
    fault_start: float = row(
        0.0, 's', 'simulated time at which the faults below begin', low=0.0, high=1e7,
        change=AT_ONCE)
    fault_duration: float = row(
        0.0, 's', 'duration of the faults; 0: unlimited', low=0.0, high=1e7, change=AT_ONCE)
    fault_frozen: str = row(
        'none', '', 'encoders whose last reading persists',
        choices=('none', 'motor', 'arm', 'both'), change=AT_ONCE)
    fault_lost: str = row(
        'none', '', 'encoders without readings (NaN)', choices=('none', 'motor', 'arm', 'both'),
        change=AT_ONCE)
    fault_delay: tuple[float, ...] = row(
        (0.0, 0.0), 's', 'delay of the readings of motor and arm, in whole samples', low=0.0,
        high=1.0, change=AT_ONCE)
    fault_scale: tuple[float, ...] = row(
        (1.0, 1.0), '-', 'readings of motor and arm over true position', low=-10.0, high=10.0,
        change=AT_ONCE)
    fault_noise: tuple[float, ...] = row(
        (1.0, 1.0), '-', 'factor on measurement_noise of motor and arm', low=0.0, high=1e4,
        change=AT_ONCE)
    fault_outlier_rate: tuple[float, ...] = row(
        (0.0, 0.0), '-', 'share of the readings of motor and arm that are outliers', low=0.0,
        high=1.0, change=AT_ONCE)
    fault_outlier_size: tuple[float, ...] = row(
        (0.0, 0.0), 'rad', 'error of the outliers of motor (arm side) and arm, of either sign',
        low=0.0, high=1e3, change=AT_ONCE)
    fault_torque: float = row(
        1.0, '-', 'torque that acts over torque commanded', low=-10.0, high=10.0, change=AT_ONCE)
    fault_viscous_friction: float = row(
        1.0, '-', 'factor on viscous_friction', low=0.0, high=100.0, change=AT_ONCE)
    fault_coulomb_friction: float = row(
        1.0, '-', 'factor on coulomb_friction', low=0.0, high=100.0, change=AT_ONCE)
    fault_stiffness: float = row(
        1.0, '-', 'factor on stiffness', low=1e-3, high=100.0, change=AT_ONCE)
    fault_gap: float = row(
        1.0, '-', 'factor on the gap', low=0.0, high=100.0, change=AT_ONCE)
    effects: tuple[str, ...] = row(
        ('',), '', 'effects besides those of the model file, each a text like "stribeck Cs=0.1 '
        'vs=0.2", "" for none; ids and parameters: docs/effects.md', change=AT_ONCE)
    load_gravity: float = row(
        0.0, 'N m', 'load on the arm: G sin(arm position)', low=-1e6, high=1e6, change=AT_ONCE)
    load_coulomb: float = row(
        0.0, 'N m', 'load on the arm: Coulomb friction', low=0.0, high=1e6, change=AT_ONCE)
    load_constant: float = row(
        0.0, 'N m', 'load on the arm: a constant torque', low=-1e6, high=1e6, change=AT_ONCE)
    measure_arm_load: bool = row(
        False, '', 'publish the load on the arm as effort of the arm joint instead of NaN',
        change=AT_ONCE)


@dataclass(frozen=True)
class ArmPlantParameters(ParameterSet):
    """Parameters of the simulated arm."""

    rate: float = row(1000.0, 'Hz', 'samples per second', low=100.0, high=2000.0)
    duration: float = row(
        0.0, 's', 'time after which the arm ends; 0: never', low=0.0, high=1e7)
    wait_for_subscribers: int = row(
        0, '', 'start once joint_states and the truth have this many subscribers together, and '
        'they have acknowledged the first sample', low=0, high=100)
    seed: int = row(1, '', 'seed of the tolerances of the arm and of the noise', low=0,
                    high=2**31 - 1)
    faulty_joint: int = row(
        1, '', 'number of the joint whose gap grows, or that rubs', low=1, high=6)
    gap_growth_rate: float = row(
        0.0, '1/s', 'the gap of that joint is its gap at the start times (1 + rate (t - start)); '
        '0: no fault', low=0.0, high=1e3)
    gap_growth_start: float = row(
        0.0, 's', 'time at which the gap begins to grow', low=0.0, high=1e7)
    rubbing: float = row(
        0.0, 'N m', 'more Coulomb friction of that joint', low=0.0, high=1e3, change=AT_ONCE)
    payload: float = row(
        0.0, 'kg', 'what the arm carries at its flange', low=0.0, high=10.0, change=AT_ONCE)
    encoders: str = row(
        'both', '', 'arm: each joint has position and effort, as of most robots; both: motors '
        'beside the joints have the effort', choices=('both', 'arm'))


@dataclass(frozen=True)
class RecorderParameters(ParameterSet):
    """Parameters of the recorder."""

    output: str = row(
        'gearbox_%Y_%m_%d-%H_%M_%S', '', 'bag directory to create, a strftime pattern; it must '
        'not exist')
    topics: tuple[str, ...] = row(
        ('joint_states', 'paired_joint_states', 'transmission_state', 'transmission_state_stddev',
         'transmission_state_smoothed', 'innovations', 'innovations_stddev',
         'estimated_joint_states', '/diagnostics', 'drift_alerts', 'estimator/snapshot',
         'plant/transmission_state'),
        '', 'topics to record, of any type; relative names are in the namespace of the node')
    compression: str = row('zstd', '', 'compression of the bag', choices=('none', 'lz4', 'zstd'))
    max_bag_size: int = row(
        0, 'bytes', 'largest size of a file of the bag; 0: no limit',
        low=0, high=10**15)
    max_bag_duration: float = row(
        0.0, 's', 'longest duration of a file of the bag; 0: no limit',
        low=0.0, high=1e9)
    sync_period: float = row(
        0.25, 's', 'period of syncs to the medium, against power cuts; 0: left to the operating '
        'system', low=0.0, high=60.0)
    queue_depth: int = row(
        4000, 'messages', 'length of the queue per topic; 4000 are 4 s at 1 kHz',
        low=1, high=1_000_000)
    low_space: int = row(
        500, 'MB', 'free disk space below which the recorder warns', low=0, high=1_000_000_000)
    gearbox_serial: str = row('gearbox', '', 'hardware_id in diagnostics, not empty')


@dataclass(frozen=True)
class WatchParameters(ParameterSet):
    """Parameters of the node that watches a whole robot."""

    state_file: str = row(
        '', '', 'file that keeps what is known of the robot; empty: NAMESPACE.watch.state in '
        '$ROS_HOME, else in ~/.ros')


def table_of(parameters: type[ParameterSet]) -> Table:
    """Return the rows of the class `parameters`, in the order of its fields."""
    return tuple(replace(f.metadata['row'], name=f.name) for f in fields(parameters))


ROBOT = table_of(RobotParameters)
ESTIMATOR, MODEL = table_of(EstimatorParameters), table_of(ModelParameters)
# All that a parameter file may give to the estimator.
SETTINGS = ESTIMATOR + MODEL
PLANT, RECORDER = table_of(PlantParameters), table_of(RecorderParameters)
ARM_PLANT, WATCH_NODE = table_of(ArmPlantParameters), table_of(WatchParameters)
# The parameters of the plant that replace values of its model file.
PLANT_MODEL = ('stiffness', 'half_gap', 'viscous_friction', 'coulomb_friction')


def check_values(table: Table, values: Mapping[str, object], source: str) -> dict[str, Any]:
    """
    Return `values` in the types of their rows.

    Args:
        table: the rows of the parameters allowed.
        values: {name: value} of some of them.
        source: file or node that a problem names.

    Returns:
        {name: value} of the same names.

    Raises:
        InputError: for all unknown names, wrong types and values out of range together.

    """
    rows, problems = {row.name: row for row in table}, Problems()
    checked = {}
    for name, value in values.items():
        with problems:
            if name not in rows:
                raise InputError(f'{source}: {name}: unknown parameter, {unknown(name, rows)}')
            checked[name] = rows[name].check(value, source)
    problems.raise_all()
    return checked


def values_of(parameters: object) -> dict[str, Any]:
    """Return {name: value} of parameters, complete, a mapping or None. Raises InputError."""
    if isinstance(parameters, EstimatorParameters):
        return parameters.to_dict()
    if isinstance(parameters, (Mapping, type(None))):
        return dict(parameters or {})
    raise InputError(f'parameters: {type(parameters).__name__} {str(parameters)[:40]!r}, expected '
                     'EstimatorParameters, names with values, or the path of a parameter file')


def with_model_values(model: DriveModel, parameters: object) -> tuple[DriveModel, dict[str, Any]]:
    """Return (`model` with the values of MODEL in `parameters`, the other values)."""
    values = values_of(parameters)
    names = {row.name for row in MODEL}
    changes = {name: value for name, value in values.items() if name in names}
    return (model.with_(**changes) if changes else model,
            {name: value for name, value in values.items() if name not in names})


def resolve(model: DriveModel, parameters: EstimatorParameters | Mapping[str, object] | None,
            source: str = 'parameters') -> tuple[DriveModel, EstimatorParameters]:
    """
    Return the drive and the complete parameters that an estimator computes with.

    Args:
        model: the drive.
        parameters: complete, or {name: value} of SETTINGS; values of MODEL replace the model's.
        source: file or node that a problem names.

    Returns:
        The model with these values, and the parameters of the estimator.

    Raises:
        InputError: for all unknown names, wrong types and values out of range together.

    """
    expect_model(model)
    if isinstance(parameters, EstimatorParameters):
        return model, parameters
    model, values = with_model_values(model, parameters)
    return model, EstimatorParameters.from_mapping(values, source)
