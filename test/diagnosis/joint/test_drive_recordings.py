# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What recordings say before any fit: scales, encoder noise, and the torque noise allowed."""
from dataclasses import replace
import math
from types import SimpleNamespace

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint import drive_recordings
from gearbox_monitor.diagnosis.joint.drive_recordings import evidence_of, silent
from gearbox_monitor.diagnosis.joint.innovations import InnovationFit
from gearbox_monitor.diagnosis.settings import THRESHOLDS
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.uniform import UniformRecording

DT, SIGMA = 1e-3, np.array([1e-3, 3e-3])
MODEL = DriveModel()


def recording(size=1.0, quantum=0.0, seed=0, count=2000):
    """Return 2 s; `size`: of the motion, `quantum`: step of the motor encoder, rad."""
    t = np.arange(count) * DT
    motion = size * np.column_stack([np.sin(9.0 * t), 0.8 * np.sin(9.0 * t + 0.1)])
    y = motion + SIGMA * np.random.default_rng(seed).standard_normal(motion.shape)
    if quantum:
        y[:, 0] = quantum * np.rint(y[:, 0] / quantum)
    return UniformRecording(t, 3.0 * size * np.sin(7.0 * t), y, DT)


def evidence(*recordings, model=MODEL, ids=('gravity',)):
    return evidence_of(recordings, model, ids)


def test_scales_are_those_of_all_recordings_together():
    both = evidence(recording(), recording(2.0))
    torque = np.concatenate([r.torque for r in both.recordings])
    assert both.torque == pytest.approx(np.std(torque))
    twist = np.std(recording(2.0).y @ [1.0, -1.0])
    np.testing.assert_allclose(both.scales, [both.torque, twist], rtol=1e-6)
    np.testing.assert_allclose(both.sigma, SIGMA, rtol=0.1)
    steady = replace(recording(), y=np.outer(3.0 * recording().t, (1.0, 1.0)))
    what, (speed, seconds) = replace(both, recordings=(recording(), steady)).asked('gravity')
    usual = np.quantile(np.abs(np.diff(recording().y[::10, 0])), 0.9) / (10.0 * DT)
    assert speed == pytest.approx(max(usual, 3.0)) and seconds == pytest.approx(4.0, abs=0.01)
    assert what == ('gravity', 'arm_side', 'motor')


def test_the_noise_of_an_encoder_is_the_largest_of_the_recordings_that_read_it():
    """Where none does, that of the copy in the first one; so are the steps."""
    quiet, loud = recording(quantum=1e-4), recording()
    loud = replace(loud, y=loud.y + 4.0 * SIGMA[0] * np.random.default_rng(9).standard_normal(
        loud.y.shape))
    arm = replace(loud, channels=(1,))
    for recordings, expected in (((quiet, loud), [17.0, 25.0]), ((loud, quiet), [17.0, 25.0]),
                                 ((quiet, arm), [1.0, 25.0]), ((arm, quiet), [1.0, 25.0]),
                                 ((arm,), [17.0, 25.0])):
        judged = evidence_of(recordings, MODEL, ())
        assert (judged.sigma / SIGMA[0]) ** 2 == pytest.approx(expected, rel=0.25)
        coarse = any(own is quiet for own in recordings)
        assert judged.quantum == pytest.approx([1e-4 if coarse else 0.0, 0.0])
    assert judged.jobs == 1 and judged.progress is silent


def test_all_readings_after_settling_are_evidence():
    judged = evidence(recording(count=4500), recording(seed=2, count=1500))
    assert [part.span for part in judged.segments] == [slice(180, 4500), slice(180, 1500)]
    assert judged.fine.readings == 2 * (6000 - 360 - 4)


def test_steps_are_as_fine_as_asked_for_and_laws_then_race_on_usual_ones():
    """A tenth of the sample rate: otherwise a step is a sample."""
    slow = recording()
    slow = replace(slow, u=slow.u[::10], y=slow.y[::10], t=slow.t[::10], dt=10.0 * DT)
    judged = evidence(slow, recording(seed=3))
    finer = replace(judged, finer=3)
    steps = {name: [part.simulator.n for part in getattr(of, kind).parts]
             for name, of, kind in (('coarse', judged, 'coarse'), ('fine', judged, 'fine'),
                                    ('short', finer, 'fine'), ('rough', finer, 'coarse'))}
    assert steps['coarse'] < steps['rough'] == steps['fine']
    assert steps['short'] == [3 * n for n in steps['fine']]
    assert judged.step == min(0.01 / steps['fine'][0], 1e-3 / steps['fine'][1])
    assert finer.step == pytest.approx(judged.step / 3.0)


def test_of_a_hidden_side_that_moves_on_its_own_states_come_from_free_runs():
    one = replace(recording(), channels=(0,))
    assert evidence(one).hides(one) and not evidence(one).hides(recording())
    rigid = evidence(one, model=MODEL.with_(kind='rigid'))
    assert not rigid.hides(one)
    judged = evidence(one)
    none = judged.starts.none()
    heavy = judged.starts.candidates('motor_inertia')[0]
    value = heavy.start()
    value[[c.owner == 0 for c in heavy.coordinates]] = 0.02
    by = {name: replace(judged, reference=fit).fine.parts[0].begin_variance for name, fit in (
        ('nominal', None), ('none', InnovationFit(none, none.start(), np.ones(2))),
        ('heavy', InnovationFit(heavy, value, np.ones(2))))}
    assert by['nominal'].tolist() == by['none'].tolist() != by['heavy'].tolist()


def test_coloured_noise_has_a_level_and_a_correlation():
    white = evidence(recording())
    assert white.correlation is None and white.level.tolist() == white.sigma.tolist()
    coloured = replace(white, colour=np.array([[0.6, 4.0], [0.0, 1.0]]))
    assert coloured.level == pytest.approx(white.sigma * np.array([2.0, 1.0]))
    assert coloured.correlation.tolist() == [0.6, 0.0]
    assert coloured.fine.parts[0].colour.tolist() == coloured.colour.tolist()
    assert coloured.noise_time == [pytest.approx(DT / -math.log(0.6)), None]


def test_a_score_counts_what_is_free_in_the_effects():
    judged = evidence(recording())
    wave = judged.starts.candidates('gravity')[0]
    fit = InnovationFit(wave, wave.start(), np.ones(2), 7.0)
    assert judged.score(fit) == pytest.approx(
        7.0 + wave.n_effect * np.log(judged.fine.readings)) and wave.n_effect > 0


def test_a_motion_that_is_put_in_is_weighed_by_its_torque():
    assert not evidence(recording()).balances
    assert replace(evidence(recording()), recordings=(
        replace(recording(), motor=np.zeros((2000, 5))),)).balances


ALLOWED = [
    ({}, 0.0), ({'tolerance': 0.1}, THRESHOLDS.torque_noise),
    ({'process_torque': 1e-3}, THRESHOLDS.torque_noise),
    ({'process_torque_time': 0.5}, THRESHOLDS.lasting_torque)]


def test_torque_noise_is_allowed_where_the_model_file_says_that_it_is_not_exact():
    for changes, share in ALLOWED:
        judged = evidence(recording(), model=MODEL.with_(**changes))
        assert judged.noisy == (share > 0.0)
        np.testing.assert_allclose(judged.allowed_noise, np.maximum(
            judged.fine.least_noise, share * judged.torque))
    np.testing.assert_allclose(
        evidence(recording(), model=MODEL.with_(process_torque=5.0)).allowed_noise, 5.0)


def test_what_a_blow_leaves_of_a_recording_and_what_is_left_of_its_torque(monkeypatch):
    """Parts between slips, of 0.2 s at least; torque beyond its share as a variance too large."""
    judged = evidence(recording())
    span = slice(180, 2000)
    for times, expected in (
            ((), [span]), ((0.25, 0.5, 1.0, 1.5), [span]),
            ((0.6, 1.2), [slice(180, 500), slice(1600, 2000)])):
        slips = np.array([(t0, 0.1) for t0 in times]).reshape(-1, 2)
        slipping = replace(judged, slips=slips, slip_owner=np.zeros(len(slips), int))
        assert slipping._between_slips(0, span) == expected
    share = THRESHOLDS.lasting_torque * judged.scales
    for sizes, beyond in ((((1.0, 0.1), (math.sqrt(7.0), 0.1)), 3.0 - math.log(4.0)),
                          (((0.9, 0.2), (0.9, 0.2)), 0.0)):
        runs = [SimpleNamespace(left=share * size) for size in sizes]
        monkeypatch.setattr(drive_recordings, 'evaluated', lambda *_, runs=runs: SimpleNamespace(
            run=SimpleNamespace(runs=runs)))
        assert judged.beyond_share(None) == pytest.approx(judged.fine.readings * beyond)


def test_an_encoder_is_rough_by_its_step_in_deviations_of_its_noise():
    """In units of the threshold; 4 deviations of the white noise are 2.6 of it with rounding."""
    for step, rough in ((0.5, False), (2.0, True)):
        quantum = step * THRESHOLDS.rough_lattice * SIGMA[0]
        assert evidence(recording(quantum=quantum)).rough == rough


def test_a_map_of_the_torque_is_tried_where_it_is_asked_for_and_the_model_has_none():
    asked = ('gravity', 'torque_map')
    other = MODEL.with_(effects=[{'id': 'gravity', 'G': 1.0}])
    tried = evidence(recording(), ids=asked)
    assert tried.with_map and tried.ids == ('gravity',)
    assert evidence(recording(), model=other, ids=asked).with_map
    assert not evidence(recording()).with_map
