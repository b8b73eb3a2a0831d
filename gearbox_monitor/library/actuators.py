# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The catalogue of actuators that were identified from public recordings."""
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.parameter_ranges import (
    Combination, LEVELS, NORMAL, ParameterRanges)
from gearbox_monitor.errors import InputError, most_similar, unknown
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.plant.drive import DriveModel, model_from_dict

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
