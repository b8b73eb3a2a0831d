# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The parameters of the nodes as frozen dataclasses; each field carries its row of parameters.toml.

One truth for node declarations, YAML files, validation, attributes and docs.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib.resources import files
from itertools import pairwise
import math
from pkgutil import iter_modules
import tomllib
from typing import Any, Self, TypeAlias

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
ROW: Any = None  # the default of a field that parameters.toml has
CHOICES = {'filter': FILTER_NAMES, 'tau_k_model': TAU_K_MODELS, 'excitation': EXCITATIONS}


@cache
def _data() -> dict[str, dict[str, Any]]:
    """Return the content of parameters.toml."""
    text = files('gearbox_monitor').joinpath('parameters.toml').read_text(encoding='utf-8')
    return tomllib.loads(text)


def _row(table: str, name: str) -> ParameterRow:
    """Return the row of the parameter `name` in a `table` of parameters.toml."""
    data = dict(_data()[table][name])
    default, choices = data.pop('default'), data.pop('choices', CHOICES.get(name, ()))
    return ParameterRow(name, tuple(default) if isinstance(default, list) else default,
                        data.pop('unit', ''), data.pop('says'), choices=tuple(choices), **data)


@dataclass(frozen=True, eq=False)
class ParameterSet:
    """
    Parameters of a node: immutable, complete and checked when they are made.

    A subclass names its `table` in parameters.toml; each of its fields has a row there.
    """

    def __init_subclass__(cls, table: str) -> None:
        """Take defaults and rows of the fields from parameters.toml."""
        for name in cls.__annotations__:
            row = _row(table, name)
            setattr(cls, name, field(default=row.default, metadata={'row': row}))

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
        checked = check_values(table_of(type(self)), changes, 'parameters')
        return type(self)(**{**self.to_dict(), **checked})

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
class EstimatorParameters(ParameterSet, table='estimator'):
    """Parameters of the estimator, and of all that computes with a filter."""

    filter: str = ROW
    model: str = ROW
    motor_joint: str = ROW
    arm_joint: str = ROW
    arm_topic: str = ROW
    pair_tolerance: float = ROW
    gearbox_serial: str = ROW
    arm_load: str = ROW
    robot_description: str = ROW
    robot_tolerance: float = ROW
    robot_error_time: float = ROW
    robot_acceleration_time: float = ROW
    robot_gravity: tuple[float, ...] = ROW
    payload_mass: float = ROW
    payload_tolerance: float = ROW
    payload_position: tuple[float, ...] = ROW
    payload_link: str = ROW
    effort_is: str = ROW
    effort_delay: int = ROW
    max_gap: float = ROW
    smoother_lag: float = ROW
    narrow_std: bool = ROW
    r_std_motor: float = ROW
    r_std_arm: float = ROW
    q_std_motor_position: float = ROW
    q_std_arm_position: float = ROW
    q_std_motor_speed: float = ROW
    q_std_arm_speed: float = ROW
    q_std_tau_k: float = ROW
    q_std_tau_k_speed: float = ROW
    q_std_tau_arm: float = ROW
    tau_k_model: str = ROW
    q_std_tau_k_deviation: float = ROW
    q_std_curve: float = ROW
    p0_std_curve: float = ROW
    tau_k_stiffness: float = ROW
    tau_k_model_std: float = ROW
    friction_error_std: float = ROW
    friction_error_time: float = ROW
    p0_std_speed: float = ROW
    p0_std_torque: float = ROW
    p0_std_tau_k_deviation: float = ROW
    friction_linearisation: str = ROW
    ukf_alpha: float = ROW
    ukf_beta: float = ROW
    ukf_kappa: float = ROW
    adapt: tuple[str, ...] = ROW
    adapt_friction_sharpness: float = ROW
    adapt_forgetting_start: float = ROW
    adapt_forgetting: float = ROW
    adapt_forgetting_rate: float = ROW
    drift_window: float = ROW
    gap_notice: float = ROW
    gap_warn: float = ROW
    gap_error: float = ROW
    gap_limit: float = ROW
    stiffness_warn: float = ROW
    stiffness_error: float = ROW
    friction_warn: float = ROW
    friction_error: float = ROW
    false_alarm_interval: float = ROW
    baseline_file: str = ROW
    baseline_windows: int = ROW
    angle_bin: float = ROW
    speed_bin: float = ROW
    load_bin: float = ROW
    temperature_bin: float = ROW
    temperature_topic: str = ROW
    drift_state_file: str = ROW
    snapshot_period: float = ROW
    model_gap_after: float = ROW
    keep_minutes: float = ROW
    keep_folder: str = ROW
    keep_newest: int = ROW
    name_changes: bool = ROW
    name_changes_after: float = ROW
    name_changes_cpu: float = ROW
    name_changes_memory: int = ROW

    def __post_init__(self) -> None:
        """Raise InputError for a value of a wrong type or out of range, or limits out of order."""
        super().__post_init__()
        for names in LIMITS_IN_ORDER:
            for low, high in pairwise(names):
                if getattr(self, low) > getattr(self, high):
                    raise InputError(f'parameters: {high}: {getattr(self, high):g}, expected a '
                                     f'number >= {low} ({getattr(self, low):g})')


@dataclass(frozen=True)
class RobotParameters(ParameterSet, table='robot'):
    """Parameters of an estimator for several gearboxes of a robot."""

    gearboxes: tuple[str, ...] = ROW


@dataclass(frozen=True)
class ModelParameters(ParameterSet, table='model'):
    """
    Values of the model file that can be changed while the estimator runs.

    Their defaults are those of the model file (here: of the packaged one). No other value of it is
    both free and used by the filters.
    """

    motor_inertia: float = ROW
    arm_inertia: float = ROW
    damping: float = ROW
    viscous_friction: float = ROW
    coulomb_friction: float = ROW
    friction_sharpness: float = ROW
    position_gain: float = ROW
    torque_offset: float = ROW


@dataclass(frozen=True)
class PlantParameters(ParameterSet, table='plant'):
    """Parameters of the simulated plant; those of its model default to the model file."""

    model: str = ROW
    motor_joint: str = ROW
    arm_joint: str = ROW
    rate: float = ROW
    speed: float = ROW
    publish_clock: bool = ROW
    duration: float = ROW
    wait_for_subscribers: int = ROW
    seed: int = ROW
    excitation: str = ROW
    amplitudes: tuple[float, ...] = ROW
    frequencies: tuple[float, ...] = ROW
    period: float = ROW
    process_noise: tuple[float, ...] = ROW
    measurement_noise: tuple[float, ...] = ROW
    stiffness: float = ROW
    half_gap: float = ROW
    viscous_friction: float = ROW
    coulomb_friction: float = ROW
    gap_growth_rate: float = ROW
    gap_growth_start: float = ROW
    gap_growth_max: float = ROW
    fault_start: float = ROW
    fault_duration: float = ROW
    fault_frozen: str = ROW
    fault_lost: str = ROW
    fault_delay: tuple[float, ...] = ROW
    fault_scale: tuple[float, ...] = ROW
    fault_noise: tuple[float, ...] = ROW
    fault_outlier_rate: tuple[float, ...] = ROW
    fault_outlier_size: tuple[float, ...] = ROW
    fault_torque: float = ROW
    fault_viscous_friction: float = ROW
    fault_coulomb_friction: float = ROW
    fault_stiffness: float = ROW
    fault_gap: float = ROW
    load_gravity: float = ROW
    load_coulomb: float = ROW
    load_constant: float = ROW
    measure_arm_load: bool = ROW


@dataclass(frozen=True)
class ArmPlantParameters(ParameterSet, table='arm_plant'):
    """Parameters of the simulated arm."""

    rate: float = ROW
    duration: float = ROW
    wait_for_subscribers: int = ROW
    seed: int = ROW
    faulty_joint: int = ROW
    gap_growth_rate: float = ROW
    gap_growth_start: float = ROW
    rubbing: float = ROW
    payload: float = ROW
    encoders: str = ROW


@dataclass(frozen=True)
class RecorderParameters(ParameterSet, table='recorder'):
    """Parameters of the recorder."""

    output: str = ROW
    topics: tuple[str, ...] = ROW
    compression: str = ROW
    max_bag_size: int = ROW
    max_bag_duration: float = ROW
    sync_period: float = ROW
    queue_depth: int = ROW
    low_space: int = ROW
    gearbox_serial: str = ROW


@dataclass(frozen=True)
class WatchParameters(ParameterSet, table='watch'):
    """Parameters of the node that watches a whole robot."""

    state_file: str = ROW


def table_of(parameters: type[ParameterSet]) -> Table:
    """Return the rows of the class `parameters`, in the order of its fields."""
    return tuple(f.metadata['row'] for f in fields(parameters))


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
