# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Laws of tau_K: the curve with its slopes, what is learnt of it, and what is refused."""

from drives import driven, part_of, samples_of
import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import model_bank
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.sample_loop import START
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise
from gearbox_monitor.plant.transmission import (
    DEAD_ZONE, elastic_torque, PASSIVE_PLAY, PLAY, play, transmission_torque)

NOISE = Noise((0.0, 0.0, 0.2, 0.2), (1e-3, 1e-3))
TUNED = {'arm_load': 'none', 'r_std_motor': 1e-3, 'r_std_arm': 1e-3, 'q_std_motor_speed': 0.2,
         'q_std_arm_speed': 0.2}
SHAPES = {'dead zone': {}, 'play': {'kind': 'play', 'hysteresis_width': 0.03},
          'passive play': {'kind': 'passive_play', 'hysteresis_width': 0.03,
                           'hysteresis_stiffness': 4.0}}


def recorded(model, seconds):
    """Return (Samples at 1 kHz, true tau_K [N])."""
    run = driven(model, seconds, NOISE)
    return samples_of(run, begin_ns=1_000_000), run.tau_k


CURVES = [
    (DEAD_ZONE, 0.0, 0.0), (PLAY, 0.2, 0.0), (PASSIVE_PLAY, 0.15, 3.0)]


def test_curve_is_that_of_the_simulator():
    for kind, width, added in CURVES:
        t = np.linspace(0.0, 10.0, 2000)
        twist = 0.8 * np.sin(3.0 * t) + 0.3 * np.sin(17.0 * t)
        state, memory, extremes = 0.0, 0.0, []
        for value in twist.tolist():
            expected, state = transmission_torque(value, state, kind, 5.0, 0.3, width, added)
            torque, _ = elastic_torque(value, memory, (5.0, 1.5, 5.0 * width, added))
            memory, _ = play(value, memory, width)
            assert torque == pytest.approx(expected, abs=1e-12)
            extremes.append(torque)
        assert min(extremes) < -2.0 and max(extremes) > 2.0


def test_negative_hysteresis_is_the_upper_branch_while_the_twist_grows():
    for growing in (1.0, -1.0):
        torque, _ = elastic_torque(growing * 1.0, 0.0, (5.0, 1.5, -1.0, 0.0))
        assert torque == pytest.approx(growing * 5.0 * (1.0 + 0.2 - 0.3))


@pytest.mark.system
def test_learns_the_curve_from_wrong_starts():
    """Errors are a fraction of the random walk's; values and deviations are right."""
    samples, tau_k = recorded(DriveModel(), 10.0)
    second = slice(5000, None)

    def error(model, **parameters):
        estimates = Estimator(model, {**TUNED, 'smoother_lag': 0.0, **parameters}).run(samples)
        return estimates, (estimates.tau_k - tau_k[1:])[second]

    _, walk = error(DriveModel(), q_std_tau_k=30.0)
    for stiffness, half_gap in ((17.5, 0.13), (50.0, 0.05)):
        model = DriveModel().exact().with_(stiffness=stiffness, half_gap=half_gap)
        estimates, miss = error(model, tau_k_model='learned', q_std_tau_k_deviation=0.1)
        assert miss.std() < walk.std() / 3
        for name, truth in (('stiffness', 25.0), ('half_gap', 0.1), ('hysteresis', 0.0)):
            value = getattr(estimates, name)[-1]
            std = getattr(estimates, f'{name}_std')[-1]
            assert abs(value - truth) < 4.0 * std, name
        # The filter lets tau_K wander from the curve, this plant does not: it may state more.
        stated = estimates.tau_k_std[second]
        assert (np.abs(miss) < stated).mean() > 0.62 and np.median(stated) < walk.std() / 10


@pytest.mark.parametrize('name', [
    'elastic', *(pytest.param(name, marks=pytest.mark.system) for name in ('learned', 'mixed'))])
def test_smoothed_torque_is_nearer_than_the_filtered(name):
    model = DriveModel().with_(**SHAPES['play'])
    samples, tau_k = recorded(model, 3.0)
    parameters = {**TUNED, 'tau_k_model': name, 'smoother_lag': 0.05}
    found = Estimator(model, parameters).run(samples)
    at = np.searchsorted(samples.stamp_ns, found.smoothed_stamp_ns)
    assert len(at) > 2900
    assert (found.smoothed_tau_k - tau_k[at])[500:].std() < (found.tau_k - tau_k[1:])[500:].std()


@pytest.mark.system
def test_mixture_is_that_of_its_filters():
    """Weights by Bayes' rule, mean and deviation of the mixture; the walk leads."""
    samples, tau_k = recorded(DriveModel(), 4.0)
    model = DriveModel().exact().with_(stiffness=20.0, half_gap=0.12)
    gone = slice(2000, 2010)
    samples.y[gone], samples.u[3000:3500] = np.nan, 0.0
    parameters = {**TUNED, 'smoother_lag': 0.0}
    own = [Estimator(model, {**parameters, 'tau_k_model': name}).run(samples)
           for name in ('random_walk', 'elastic', 'learned')]
    mixed = Estimator(model, {**parameters, 'tau_k_model': 'mixed'}).run(samples)
    weights = np.full(3, 1.0 / 3.0)
    for k in range(len(mixed.rows)):
        stay = np.exp(-mixed.dt[k] / 100.0)
        prior = stay * weights + (1.0 - stay) / 3.0
        likelihood = np.exp([e.loglik[k] - own[0].loglik[k] for e in own])
        evidence = prior @ likelihood
        weights = prior * likelihood / evidence
        assert mixed.loglik[k] - own[0].loglik[k] == pytest.approx(np.log(evidence), abs=1e-9)
        assert mixed.learned_weight[k] == pytest.approx(weights[2], rel=1e-6)
        for mean, std in (('tau_k', 'tau_k_std'), ('twist', 'twist_std')):
            of_each = np.array([getattr(e, mean)[k] for e in own])
            variance = np.array([getattr(e, std)[k] for e in own]) ** 2
            assert getattr(mixed, mean)[k] == pytest.approx(weights @ of_each, abs=1e-9)
            assert getattr(mixed, std)[k] == pytest.approx(np.sqrt(
                weights @ (variance + of_each ** 2) - (weights @ of_each) ** 2), rel=1e-5)
    np.testing.assert_array_equal(mixed.stiffness, own[2].stiffness)
    assert np.isnan(mixed.innovation_motor[gone.start - 1:gone.stop - 1]).all()


def test_wrong_curve_is_no_worse_than_the_random_walk():
    """The flanks lie 0.1 rad off centre, as wide as the gap is: no curve offered has that."""
    samples, tau_k = recorded(DriveModel(), 6.0)
    samples.y[:, 1] += 0.1
    model, rms = DriveModel().exact().with_(stiffness=60.0, half_gap=0.02), {}
    for name in ('random_walk', 'elastic', 'mixed'):
        parameters = {
            **TUNED, 'q_std_tau_k': 30.0, 'smoother_lag': 0.0, 'tau_k_model': name}
        estimates = Estimator(model, parameters).run(samples)
        rms[name] = (estimates.tau_k - tau_k[1:])[500:].std()
    assert rms['elastic'] > 1.2 * rms['random_walk'] and rms['mixed'] < 1.02 * rms['random_walk']


def test_lost_curve_begins_again_at_the_same_sample_however_the_stream_is_cut(monkeypatch):
    monkeypatch.setattr(model_bank, 'LOST', -1.0)  # lost every second
    samples, tau_k = recorded(DriveModel(), 3.0)
    parameters = {**TUNED, 'smoother_lag': 0.0, 'tau_k_model': 'mixed'}
    estimates = Estimator(DriveModel().exact(), parameters).run(samples)
    pieces, rows = Estimator(DriveModel().exact(), parameters), []
    for cut in range(0, len(tau_k), 700):
        rows.append(pieces.run(part_of(samples, cut, cut + 700)).rows)
        pieces = Estimator.restore(pieces.snapshot())
    np.testing.assert_array_equal(np.concatenate(rows), estimates.rows)
    assert pieces.members[-1].counts[START] == 4 and pieces.counts[START] == 1


def test_without_an_arm_encoder_nothing_is_mixed():
    walk, mixed = (Estimator(DriveModel(), {**TUNED, 'arm_joint': '', 'tau_k_model': name})
                   for name in ('random_walk', 'mixed'))
    assert not mixed.members and mixed.names == walk.names
    np.testing.assert_array_equal(mixed.packed, walk.packed)
    laws = Estimator(DriveModel(), {'filter': 'aekf', 'tau_k_model': 'mixed'}).members
    assert [law.parameters.filter for law in laws] == ['ekf', 'ekf']


NOT_OFFERED = [
    ({'filter': 'aekf'}, 'tau_k_model: learned, expected random_walk with filter aekf'),
    ({'tau_k_stiffness': 2.0}, 'tau_k_stiffness: 2, expected 0 with tau_k_model learned'),
    ({'arm_joint': ''}, 'tau_k_model: learned, expected random_walk where no arm is measured')]


def test_combinations_that_are_not_offered():
    for changes, message in NOT_OFFERED:
        with pytest.raises(InputError, match=message):
            Estimator(DriveModel(), {'tau_k_model': 'learned', **changes})
