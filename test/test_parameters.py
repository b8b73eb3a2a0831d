# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Parameters: one table, typed fields, no misspelt name."""
from dataclasses import FrozenInstanceError
from importlib.resources import files
import math
import tomllib
from typing import get_type_hints

import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import (
    ArmPlantParameters, check_values, ESTIMATOR, EstimatorParameters, FILTER_NAMES,
    ModelParameters, PlantParameters, RecorderParameters, resolve, RobotParameters, SETTINGS,
    table_of, WatchParameters)
from gearbox_monitor.plant.drive import DriveModel

SETS = [ArmPlantParameters, EstimatorParameters, ModelParameters, PlantParameters,
        RecorderParameters, RobotParameters, WatchParameters]


def test_every_field_has_the_type_of_its_row():
    for parameters in SETS:
        hints = get_type_hints(parameters)
        types = {bool: bool, int: int, float: float, str: str}
        for row in table_of(parameters):
            expected = types.get(row.kind) or tuple[row.item_kind, ...]
            assert hints[row.name] == expected, row.name
            assert row.check(row.default, '') == getattr(parameters(), row.name) == row.default
            assert row.item_kind not in (int, float) or math.isfinite(row.high), row.name
    named = {row.name for parameters in SETS for row in table_of(parameters)}
    text = files('gearbox_monitor').joinpath('parameters.toml').read_text(encoding='utf-8')
    assert {name for table in tomllib.loads(text).values() for name in table} == named


@pytest.mark.system
def test_mypy_finds_a_misspelt_name(tmp_path):
    api = pytest.importorskip('mypy.api')
    snippet = tmp_path / 'snippet.py'
    snippet.write_text('from gearbox_monitor.parameters import EstimatorParameters\n'
                       'lag: float = EstimatorParameters().smoother_lag\n'
                       'EstimatorParameters().smother_lag\n'
                       'name: str = EstimatorParameters().smoother_lag\n')
    report, errors, code = api.run([
        '--strict', '--follow-imports=silent', '--cache-dir', str(tmp_path / 'cache'),
        str(snippet)])
    assert code == 1 and not errors
    assert 'snippet.py:3: ' in report and 'has no attribute "smother_lag"' in report
    assert 'snippet.py:4: ' in report and report.count('error:') == 2


def test_a_misspelt_attribute_fails_and_no_value_can_be_set():
    with pytest.raises(AttributeError, match='smother_lag'):
        getattr(EstimatorParameters(), 'smother_lag')  # noqa: B009
    with pytest.raises(FrozenInstanceError):
        EstimatorParameters().smoother_lag = 0.2


def test_all_problems_of_a_mapping_are_named_with_their_source():
    with pytest.raises(InputError) as error:
        EstimatorParameters.from_mapping(
            {'smother_lag': 0.1, 'max_gap': -1, 'filter': 'pf', 'adapt': 'r_std_arm'}, 'a.yaml')
    assert str(error.value).splitlines() == [
        "a.yaml: smother_lag: unknown parameter, did you mean 'smoother_lag'?",
        'a.yaml: max_gap: -1, expected a number >= 0.001 and <= 60 (s)',
        f"a.yaml: filter: 'pf', expected one of {', '.join(FILTER_NAMES)}",
        "a.yaml: adapt: 'r_std_arm', expected a list of texts"]


WRONG_TYPES = [
    {'max_gap': True}, {'max_gap': math.nan}, {'max_gap': 10 ** 400}, {'effort_delay': 1.0},
    {'effort_delay': True}, {'motor_joint': 1}, {'adapt': [1]}, {'adapt': [['r_std_arm']]}]


def test_values_of_a_wrong_type_are_refused():
    for values in WRONG_TYPES:
        with pytest.raises(InputError, match=next(iter(values))):
            EstimatorParameters(**values)
        with pytest.raises(InputError, match=next(iter(values))):
            EstimatorParameters().replace(**values)


def test_numbers_and_sequences_take_the_type_of_their_field():
    plant = PlantParameters(rate=500, amplitudes=[6, 2])
    assert type(plant.rate) is float and plant.amplitudes == (6.0, 2.0)
    assert {type(value) for value in plant.amplitudes} == {float}
    assert plant.to_dict()['amplitudes'] == [6.0, 2.0]
    assert plant.changes() == {'rate': 500.0}
    assert PlantParameters.from_mapping(plant.to_dict()) == plant


def test_a_mapping_may_hold_values_of_the_model():
    model, parameters = resolve(DriveModel(), {'damping': 0.02, 'smoother_lag': 0.2})
    assert model == DriveModel(damping=0.02) and parameters.smoother_lag == 0.2
    assert resolve(model, parameters) == (model, parameters)
    assert resolve(model, None) == (model, EstimatorParameters())


def test_checked_values_are_those_that_were_given():
    assert check_values(SETTINGS, {'damping': 1, 'max_gap': 1}, '') == {
        'damping': 1.0, 'max_gap': 1.0}
    assert len({row.name for row in SETTINGS}) == len(SETTINGS) > len(ESTIMATOR)
