# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The notice that model mismatch: with an effect, not without, not for noise."""
from drives import driven, part_of, samples_of
import numpy as np

from gearbox_monitor.estimation.estimates import Sample, Samples
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.checks import innovation
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise

SECOND = 1_000_000_000
DT = 2e-3
PARAMETERS = {'arm_load': 'none', 'model_gap_after': 10.0}


def samples(seconds, effects=(), noise=(5e-3, 5e-3)):
    return samples_of(driven(DriveModel(effects=tuple(effects)), seconds,
                             Noise((0.0, 0.0, 0.4, 0.4), noise), dt=DT), DT)


def history(monitor, data, part=500):
    """Return the outcomes on the model after every second of `data`."""
    found = []
    for k in range(0, len(data.stamp_ns), part):
        monitor.run(part_of(data, k, k + part))
        found.append(monitor.outcomes['model'])
    return found


OFFSET = ({'id': 'torque_offset', 'u0': 0.6},)
COGGING = ({'id': 'cogging', 'N': 6, 'A': 0.6, 'phi': 0.0},)


def test_lasting_gap_of_the_model_is_told():
    for effects in (OFFSET, COGGING):
        found = history(Monitor(DriveModel(), PARAMETERS), samples(20.0, effects))
        # The first 3 s are not judged; more than 5 s of systematic errors; three evaluations more.
        levels = [f.level for f in found]
        assert set(levels[4:9]) == {Level.OK} and set(levels[12:]) == {Level.WARN}
        assert 'model mismatch: call ~/keep_recording' in found[-1].message
        assert found[-1].values['systematic_s'] > found[-1].values['systematic_s_threshold'] == 5.0


def test_noise_of_a_motor_encoder_is_no_gap():
    for arm_load in ('none', 'unknown'):
        monitor = Monitor(DriveModel(), {**PARAMETERS, 'arm_load': arm_load})
        found = history(monitor, samples(25.0, noise=(8e-3, 5e-3)))
        assert {f.level for f in found[4:]} == {Level.OK}
        assert monitor.outcomes['prediction error'].level > Level.OK


def test_gap_that_ends_is_forgotten_and_a_lost_encoder_is_no_gap():
    data = samples(40.0, OFFSET)
    fine = samples(40.0)
    y = np.concatenate([data.y[:9000], fine.y[9000:]])
    found = history(Monitor(DriveModel(), PARAMETERS), Samples(data.stamp_ns, data.u, y))
    assert found[17].level == Level.WARN and found[-1].level == Level.OK
    y = fine.y.copy()
    y[5000:, 0] = np.nan
    found = history(Monitor(DriveModel(), PARAMETERS), Samples(fine.stamp_ns, fine.u, y))
    assert {f.level for f in found[4:]} == {Level.OK}


def test_step_by_step_is_the_same():
    data = samples(14.0, OFFSET)
    whole, single = (Monitor(DriveModel(), PARAMETERS) for _ in range(2))
    whole.run(data)
    for stamp, u, y in zip(data.stamp_ns.tolist(), data.u.tolist(), data.y.tolist()):
        single.step(Sample(stamp, tuple(u), tuple(y)))
    assert whole.outcomes == single.outcomes and whole.outcomes['model'].level == Level.WARN


def test_seconds_are_those_of_the_window():
    systematic = innovation.Systematic()
    for k in range(100):
        systematic.add(k * SECOND, k % 2 == 0)
    assert systematic.seconds(99 * SECOND, 10.0) == 5
    assert systematic.seconds(98 * SECOND, 60.0) == 5  # what was beyond it is forgotten
    assert systematic.seconds(5 * SECOND, 60.0) == 0  # the clock was set back
    assert not innovation.systematic({'window_samples': 3})
