# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Models of drives: from a model file, one joint of a simulator's file, or the catalogue."""
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.parameter_ranges import (
    Combination, LEVELS, NORMAL, ParameterRanges)
from gearbox_monitor.errors import InputError, most_similar, unknown
from gearbox_monitor.files import yaml_files
from gearbox_monitor.files.opening import config_path
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.origin import FileLimits, ModelOrigin, NO_LIMIT
from gearbox_monitor.removed import refusal
from gearbox_monitor.simulators.mjcf_file import MjcfDrive, model_of, read_mjcf

SIMULATORS, MODEL_FILES = ('.xml', '.urdf'), ('.yaml', '.yml')


def load_model(path: str | Path, joint: str | None = None, *, arm_joint: str | None = None,
               keyframe: str | None = None, actuator: str | None = None,
               root: str | Path | None = None,
               values: str | Path | Mapping[str, Any] | None = None) -> DriveModel:
    """
    Return the model of a drive in a model file, or of one joint in a simulator's file.

    Args:
        path: of a model file (YAML), or an MJCF or URDF file.
        joint: joint of the simulator's file that the motor drives; None for a model file.
        arm_joint: joint of the arm in the simulator's file, None where it is the same.
        keyframe: posture in which inertia and weight are taken, a key of an MJCF file.
        actuator: actuator of the joint, where several act on it.
        root: folder below which the files lie that the simulator's file includes, None for its
            own folder.
        values: values that the simulator's file lacks, or a YAML file of them.

    Returns:
        The model. What it has no key for (ranges of setpoints and of the joint) goes with it, and
        with models derived from it, to `load_recording`.

    Raises:
        InputError: naming file, key, value and what was expected.

    >>> from gearbox_monitor.files.opening import config_path
    >>> load_model(config_path('drive.yaml')).transmission.kind
    'dead_zone'
    """
    path = expect_path(path, 'path', 'a model file, or an MJCF or URDF file')
    if joint is None:
        if path.suffix.lower() in SIMULATORS:
            raise InputError(f'{path}: the file of a simulator, expected joint (--joint): '
                             'the joint of the drive in it')
        if values is not None:
            raise InputError(f'values: without joint (--joint), expected the file of a simulator, '
                             f'not {path}')
        return replace(yaml_files.load_model(path), origin=ModelOrigin(path.name))
    if path.suffix.lower() in MODEL_FILES:
        raise InputError(f'{path}: a model file, expected the file of a simulator with joint '
                         '(--joint)')
    drive = read_mjcf(path, joint, arm_joint, keyframe, actuator, root)
    model = model_of(drive, _given(values))
    return replace(model, origin=ModelOrigin(path.name, _limits(drive, model)))


def _limits(drive: MjcfDrive, model: DriveModel) -> FileLimits:
    """Return the FileLimits of a `drive` in a simulator's file, which makes a `model`."""
    own, setpoints = drive.actuator, NO_LIMIT
    if own is not None and own.law is not None and own.law.setpoint and model.controller:
        low, high = sorted(bound / own.gear for bound in own.law.control)
        setpoints = low, high
    return FileLimits(tuple(drive.notes), setpoints, drive.motor.travel)


def expect_path(value: object, name: str, what: str) -> Path:
    """Return `value`, called `name`, as the Path of `what`. Raises InputError for another type."""
    if isinstance(value, (str, Path)) and str(value):
        if gone := refusal(Path(value).suffix.lower()):
            raise InputError(f'{value}: {gone}')
        return Path(value)
    raise InputError(f'{name}: {type(value).__name__} {str(value)[:40]!r}, expected the path of '
                     f'{what}')


def _given(values: str | Path | Mapping[str, Any] | None) -> Mapping[str, Any]:
    """Return the values of a mapping, or of a YAML file."""
    if values is None or isinstance(values, Mapping):
        return values or {}
    content = load_yaml(expect_path(values, 'values', 'a YAML file')).content
    if not isinstance(content, dict):
        raise InputError(f'{values}: {str(content)[:40]!r}, expected keys and values')
    return content


FOLDER = 'actuators'
NAMES = ('ak80_6', 'davinci_backend', 'sts3250', 'tx40_joint1', 'tx40_joint2', 'tx40_joint3',
         'tx40_joint4', 'xl330')


@dataclass(frozen=True)
class CatalogueActuator:
    """
    An actuator of the catalogue.

    model: with the median values, its effort as `description` says. ranges: of the next
    recording. provenance: source, licence, citation, recorded, command. held_out: recordings that
    were not fitted, with the error of the median values on them.
    """

    name: str
    description: str
    model: DriveModel
    ranges: ParameterRanges
    provenance: Mapping[str, str]
    held_out: Mapping[str, Any]


def load_actuator(name: str) -> CatalogueActuator:
    """
    Return an actuator of the catalogue (docs/actuators.md).

    Args:
        name: of the actuator.

    Raises:
        InputError: the catalogue has no such name; the message lists those that it has.

    >>> load_actuator('davinci_backend').provenance['licence']
    'ODbL 1.0'
    """
    if not isinstance(name, str) or name not in NAMES:
        raise InputError(f'actuator: {name!r}, {unknown(str(name), NAMES)}')
    data = load_yaml(config_path(f'{FOLDER}/{name}.yaml')).content
    return CatalogueActuator(
        name, data['description'], model_from_dict(data['model'], name), _ranges(data['ranges']),
        {key: data[key] for key in ('source', 'licence', 'citation', 'recorded', 'command')},
        data['held_out'])


def is_actuator(path: str) -> bool:
    """Return whether `path` names an actuator, perhaps misspelt, and not a file."""
    return bool(most_similar(path, NAMES)) and not Path(path).exists()


def _ranges(data: Mapping[str, Any]) -> ParameterRanges:
    """Return the ranges in an entry; beyond low and high they go on as a normal does."""
    rows = data['parameters']
    logarithmic = tuple(row['distribution'] == 'lognormal' for row in rows.values())
    low, centre, high = (np.array([row[key] for row in rows.values()], float)
                         for key in ('low', 'median', 'high'))
    between = np.array([row.get('between', np.nan) for row in rows.values()], float)
    ends = [np.where(logarithmic, np.log(np.where(logarithmic, v, 1.0)), v)
            for v in (low, centre, high)]
    steps = scipy.special.ndtri(LEVELS)[:, None] / NORMAL
    quantiles = ends[1] + np.where(steps < 0.0, steps * (ends[1] - ends[0]),
                                   steps * (ends[2] - ends[1]))
    return ParameterRanges(
        tuple(rows), tuple(row['unit'] for row in rows.values()), logarithmic, centre, low, high,
        between, np.array(data['correlation'], float),
        tuple(Combination(c['exponents'], c['deviation'])
              for c in data['known_only_in_combination']),
        tuple(data['sources']), tuple(data['notes']), quantiles)
