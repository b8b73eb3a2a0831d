# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""Several recordings of one drive: coverage of the range, one answer where a value differs."""
import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.diagnosis.joint.parameter_ranges import between_recordings, pooled
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.signals.examine import admitted

MODEL = DriveModel()


def test_range_covers_the_mean_at_its_odds():
    """Of recordings that differ by more and by less than their errors, which differ, too."""
    for count, between in ((2, 0.0), (2, 5.0), (6, 0.0), (6, 1.0)):
        random = np.random.default_rng([count, round(between)])
        covered = []
        for _ in range(400):
            errors = random.uniform(0.7, 1.4, count)
            values = 3.0 + between * random.standard_normal(count) + (
                errors * random.standard_normal(count))
            result = pooled(values, errors)
            covered.append(result.low <= 3.0 <= result.high)
        assert 0.85 <= np.mean(covered) <= 0.95, (count, between)


@pytest.mark.system
@pytest.mark.parametrize('effect, key, field, value, between', [
    ('backlash_gap', 'b', 'half_gap', 0.12, 0.03),
    ('motor_coulomb', 'Cc', 'coulomb_friction', 0.3, 0.1)])
def test_range_covers_the_mean_of_simulated_runs(effect, key, field, value, between):
    """100 sets of three runs of 4 s, between which the value differs: 90 % within chance."""
    random, covered = np.random.default_rng(7), []
    t = np.arange(2000) * 2e-3
    torque = (0.3 + 0.7 * np.sin(np.pi * t / 4.0) ** 2) * Excitation().torque(t)
    for _ in range(100):
        runs = []
        for true in value * (1.0 + between * random.standard_normal(3)):
            run = simulate(MODEL.with_(**{field: float(true)}), torque, 2e-3,
                           Noise(measurement=(5e-3, 5e-3)), int(random.integers(1 << 30)))
            runs.append(admitted(run.t, run.u, run.y, None, 'run', MODEL, 'model')[0])
        candidate = Starts(MODEL, runs[:1]).candidates(effect)[0]
        result = between_recordings(runs, candidate, candidate.start(), np.full(2, 5e-3))
        covered.append(result[effect][key].low <= value <= result[effect][key].high)
    assert 0.83 <= np.mean(covered) <= 0.97


def test_recordings_without_scatter_have_a_range():
    result = pooled([2.0, 2.0, 2.0], [0.0, 0.0, 0.0])
    assert (result.mean, result.between) == (2.0, 0.0) and result.low <= 2.0 <= result.high


@pytest.mark.system
def test_a_gap_that_differs_between_recordings_is_one_answer():
    def recorded(half_gap, seed):
        t = np.arange(3000) * 2e-3
        torque = (0.3 + 0.7 * np.sin(np.pi * t / 6.0) ** 2) * Excitation().torque(t)
        run = simulate(MODEL.with_(half_gap=half_gap), torque, 2e-3,
                       Noise(measurement=(5e-3, 5e-3)), seed)
        return admitted(run.t, run.u, run.y, None, f'run{seed}', MODEL, 'model')[0]
    true = [0.121, 0.125, 0.13]
    verdict = diagnose([recorded(b, i) for i, b in enumerate(true)], MODEL,
                       only=['backlash_gap', 'stiffness']).to_dict()
    assert verdict['effect'] == 'backlash_gap'
    gap = verdict['between_recordings']['backlash_gap']['b']
    assert gap['recordings'] == pytest.approx(true, abs=5e-4)
    assert gap['low'] < np.mean(true) < gap['high']
    assert gap['between'] == pytest.approx(np.std(true, ddof=1), rel=0.1)
