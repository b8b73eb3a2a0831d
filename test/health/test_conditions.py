# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Conditions and the aggregator's configuration agree with the monitor."""
from pathlib import Path

from drives import driven, samples_of
import pytest
import yaml

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.checks import innovation, observability
from gearbox_monitor.health.monitor import COMPONENTS, CONDITIONS, Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.report.sentences import TABLE
from gearbox_monitor.ros.diagnostic_keys import DIAGNOSTIC_KEYS

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope='module')
def monitor():
    """Return a Monitor that has judged 8 s of a healthy drive."""
    monitor = Monitor(DriveModel())
    monitor.run(samples_of(driven(DriveModel(), 8.0)))
    return monitor


def test_every_condition_names_values_that_are_published(monitor):
    assert {c.component for c in CONDITIONS} >= {
        'input', 'observability', 'prediction error', 'covariance'}
    for c in CONDITIONS:
        words = TABLE[c.code]
        assert c.level > Level.OK and words.when and words.window and words.remedy
        values = monitor.outcomes[c.component].values
        if c in (observability.TWO_PUBLISHERS, observability.LOST):  # the node publishes them
            values = {**values, **dict.fromkeys(
                row.key for row in DIAGNOSTIC_KEYS if row.component == 'input')}
        for key in (*c.value, *c.threshold):
            # Only filters that adapt or learn publish what they do.
            assert key in values or key.startswith(('adapted_...', 'learned_')), key


def test_every_threshold_is_in_a_condition(monitor):
    told = {key for c in CONDITIONS for key in c.threshold}
    for name in ('observability', 'prediction error', 'covariance'):
        assert monitor.outcomes[name].level == Level.OK
        published = monitor.outcomes[name].values
        assert {key for key in published if key.endswith(('_threshold', '_bound'))} <= told


def test_every_refused_sample_has_a_condition():
    counters = [name for _, names in observability.REFUSED for name in names]
    others = {sample_loop.REASONS[sample_loop.START]}
    assert sorted(counters) == sorted(set(sample_loop.REASONS.values()) - others)


INPUTS = [
    ({}, Level.OK, 'samples/s'), ({'zero stamps': 2}, Level.WARN, '2 zero stamps: stamp each'),
    ({'missing arm positions': 3, 'missing efforts': 1}, Level.WARN,
     '1 missing efforts, 3 missing arm positions: publish effort')]


def test_input():
    for new, level, word in INPUTS:
        outcome = observability.judge_input(new, 5, {'rate_hz': 5.0})
        assert outcome.level == level and word in outcome.message
        unusable = observability.judge_input(new, 0, {'rate_hz': 0.0})
        assert unusable.level == Level.ERROR
        assert unusable.message.endswith(outcome.message.partition(': ')[2]) or not new


def test_thresholds_in_words_are_those_in_force():
    assert f'{innovation.MEAN_LIMIT:.2f}' in TABLE['biased'].when
    assert f'{innovation.LJUNG_BOX_LIMIT:.1f}' in TABLE['coloured'].when


def aggregated():
    text = (ROOT / 'config/diagnostic_aggregator.yaml').read_text(encoding='utf-8')
    parameters = yaml.safe_load(text)['analyzers']['ros__parameters']
    return [value for value in parameters.values() if isinstance(value, dict)]


def test_aggregator_finds_every_component_once():
    names = [f'estimator: {name}' for name in COMPONENTS] + ['recorder: recording']
    groups = aggregated()
    for name in names:
        # Not by `expected`: version 4 of the aggregator refuses a group of nothing else.
        assert sum(name.startswith(tuple(group['startswith'])) for group in groups) == 1, name
    for group in groups:
        assert group['type'] == 'diagnostic_aggregator/GenericAnalyzer' and group['path']
        assert group['timeout'] > 2.0  # the nodes publish every second
        # Missing ones are errors.
        assert group.get('expected', group['startswith']) == [
            name for name in group['startswith'] if name != 'estimator: diagnosis']  # may be off
        assert group['path'] == 'Recorder' or set(group['expected']) <= set(names)
