# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Where the gap lies, how far it closes, what a recording can separate, and what is decided."""
from dataclasses import replace
import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from gearbox_monitor.diagnosis.hypothesis import Remains
from gearbox_monitor.diagnosis.joint import (
    diagnose, effect_scan, localisation, windows as closed_model)
from gearbox_monitor.diagnosis.joint.candidates import sine_and_cosine
from gearbox_monitor.diagnosis.joint.decision import decide, standard_errors, unshaped
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.effect_scan import _begun, scan
from gearbox_monitor.diagnosis.joint.innovation_evidence import InnovationEvidence
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, fitted, InnovationFit, JointLikelihood, spectrum, unfitted)
from gearbox_monitor.diagnosis.joint.localisation import InputEstimator, rectangles
from gearbox_monitor.diagnosis.joint.shooting import shooting_windows
from gearbox_monitor.diagnosis.joint.windows import typical_misfit
from gearbox_monitor.diagnosis.settings import CONTEST
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels import elementary
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.signals.uniform import Doubt, UniformRecording

DT, SIGMA = 0.002, np.array([0.002, 0.002])
CASES = {
    'stribeck': ({'Cs': 0.15, 'vs': 0.5}, 'motor_side'),
    'torque_gain': ({'g': 0.08}, 'motor_side'),  # where a torque acts that the command lacks
    'backlash_gap': ({'b': 0.115}, 'transmission'),
    'arm_encoder_eccentricity': ({'A': 0.02, 'phi': 0.7}, 'arm_sensor'),
}


def record(effects, seconds=3, seed=1, std=SIGMA, u=None, model=None, dt=DT):
    """Return a recording of the paper's drive with `effects` under a sum of sines."""
    t = np.arange(round(seconds / dt)) * dt
    if u is None:
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 3)
        u = sum(a * np.sin(2 * np.pi * f * t + p)
                for a, f, p in zip((0.6, 0.4, 0.3), (0.45, 1.1, 2.3), phase))
    model = model_from_dict({**(model or {}), 'effects': effects}, 'test')
    path = simulate(model, u, dt, Noise(measurement=tuple(std)), seed)
    return UniformRecording(t, u, path.y, dt)


def evidence_of(*recordings, ids=(), model=None):
    """Return the DriveRecordings of recordings under the model of the package."""
    return DriveRecordings(recordings, model or DriveModel(), SIGMA, tuple(ids))


def without(evidence):
    """Return the fit without effects."""
    return fitted(evidence.fine, unfitted(evidence.fine, evidence.starts.none()))


def from_truth(evidence, name, values):
    """Return the fit of effect `name` that begins at its true `values`."""
    candidate = evidence.starts.candidates(name)[0]
    if 'phi' in values:
        values = sine_and_cosine(name, values)
    z = np.array([s if c.owner < 0 else np.log(values[c.name]) if c.log else values[c.name]
                  for c, s in zip(candidate.coordinates, candidate.start())])
    return fitted(evidence.fine, InnovationFit(candidate, z, evidence.fine.first_noise))


@pytest.fixture(scope='module')
def cases():
    """Return {id: (DriveRecordings, fit without, fit of the id)} of all cases."""
    out = {}
    for name, (values, _) in CASES.items():
        evidence = evidence_of(record([{'id': name, **values}], 3), ids=[name])
        out[name] = evidence, without(evidence), from_truth(evidence, name, values)
    return out


@pytest.mark.parametrize('name', CASES)
def test_a_right_model_leaves_noise_alone(cases, name):
    """Torque noise, functions and memory tell the model without the effect from that with it."""
    evidence, none, fit = cases[name]
    contested = InnovationEvidence(evidence)
    lacking, enough = (contested.remains(contested.hypothesis(f), thorough=True)
                       for f in (none, fit))
    assert enough.worth < CONTEST.margin
    assert typical_misfit(evidence.runs(fit)) == pytest.approx(1.0, abs=0.04)
    # No torque noise is needed: it has annealed to what a free run cannot show.
    assert (fit.torque < 20.0 * evidence.fine.least_noise).all()
    assert lacking.torque > 100.0 and lacking.follows > CONTEST.margin > enough.follows


@pytest.mark.parametrize('effects, allowed', [
    ([], True), ([{'id': 'motor_viscous', 'Cv': 1.3 * DriveModel().viscous_friction}], False)])
def test_a_filter_that_lost_the_hidden_side_is_no_error_of_the_model(effects, allowed):
    """It begins in the wrong place of the gap, sure of it; beside a recording of both sides."""
    gap = {'transmission': {'kind': 'dead_zone', 'half_gap': 0.3, 'stiffness': 10.0}}
    recording = record(effects, 6, model=gap)
    evidence = evidence_of(replace(recording, y=recording.y[:, [0, 0]], channels=(0,)),
                           recording, model=model_from_dict(gap, 'test'))
    whole = evidence.fine
    part, other = whole.parts
    states = whole.smoothed(whole.run(evidence.model, whole.least_noise))[0][part.begin, :4]
    states[1, 1] += 0.1
    lost = JointLikelihood([part.begun(states, np.full(4, 1e-3)), other])
    fit = fitted(lost, unfitted(lost, evidence.starts.none()))
    evidence.__dict__['fine'] = lost
    quiet = lost.run(fit.model, evidence.allowed_noise)
    assert quiet.deviance - evaluated(lost, fit).deviance > 1e4
    assert (evidence.unexplained_by_free_runs(fit) < CONTEST.margin) == allowed


@pytest.mark.parametrize('alone', [True, False])
def test_one_encoder_does_not_tell_a_late_torque_from_a_late_reading(alone):
    """A drive at rest moves as late as its torque comes."""
    late = record([{'id': 'actuator_delay', 'T': 0.01}], std=(0.0, 0.0))
    assert late.y[5:, 0] == pytest.approx(record([], std=(0.0, 0.0)).y[:-5, 0], abs=1e-6)
    evidence = evidence_of(replace(late, channels=(0,) if alone else (0, 1)),
                           ids=['actuator_delay', 'motor_encoder_delay'])
    for name, other in (evidence.ids, evidence.ids[::-1]):
        fit = unfitted(evidence.fine, evidence.starts.candidates(name)[0])
        alike = effect_scan.rivals(evidence, fit, [replace(fit, deviance=0.0)], {})
        assert alike == {name: [other] * alone}


@pytest.mark.parametrize('name', CASES)
def test_a_free_signal_finds_the_place(cases, name):
    evidence, none, _ = cases[name]
    assert localisation.place_in(evidence.runs(unshaped(none))) == CASES[name][1]


@pytest.mark.parametrize('name', CASES)
def test_the_true_effect_closes_the_gap(cases, name):
    evidence, none, fit = cases[name]
    before, after = (evidence.runs(f) for f in (none, fit))
    closure = closed_model.closure(before, after, True, seed=3)
    assert closure['gap_before'] > 1.05
    assert closure['gap_after'] == pytest.approx(1.0, abs=0.03)
    low, high = closure['closed_fraction_ci']
    assert low <= 1.0 <= high and low <= closure['closed_fraction'] <= high
    truth, (values,) = CASES[name][0], fit.candidate.values(fit.z)[1]
    errors, _ = standard_errors(evidence.fine, fit)
    for parameter, value in truth.items():
        assert abs(values[parameter] - value) < 4.0 * errors[name][parameter], parameter
    assert closure == closed_model.closure(before, after, True, seed=3)
    json.dumps(closure, allow_nan=False)


@pytest.mark.system
def test_recordings_with_other_encoders_are_evaluated_each_with_its_own():
    """One with both encoders, one with the motor's alone: no reading is made up."""
    effect = [{'id': 'torque_gain', 'g': 0.08}]
    both, motor = record(effect), record(effect, seed=2)
    motor = replace(motor, y=motor.y[:, [0, 0]], channels=(0,))
    together = evidence_of(both, motor, ids=['torque_gain'])
    assert together.fine.readings == evidence_of(both).fine.readings + evidence_of(
        motor).fine.readings
    data = diagnose.diagnose([both, motor], DriveModel(), only=['torque_gain']).data
    assert (data['verdict'], data['effect']) == ('effect', 'torque_gain')
    assert data['params']['torque_gain']['g'] == pytest.approx(0.08, rel=0.02)
    assert data['gap_after'] == pytest.approx(1.0, abs=0.05)
    assert [gap['reading'] for gap in data['gaps']] == ['motor', 'arm']


@pytest.mark.system
def test_a_remainder_of_recordings_one_of_which_shows_no_candidate():
    """The motor's encoder alone shows no eccentricity of the arm's: that is no bad input."""
    effect = [{'id': 'torque_gain', 'g': 0.08}]
    both, motor = record(effect, 3), record(effect, 3, seed=2)
    motor = replace(motor, y=motor.y[:, [0, 0]], channels=(0,))
    verdict = diagnose.diagnose([both, motor], DriveModel(), only=['arm_encoder_eccentricity'])
    assert verdict.verdict in ('unknown', 'incomplete') and verdict.remainder is not None


def test_nothing_runs_from_one_recording_into_the_next():
    """The second begins elsewhere: no speed or start knows of the first."""
    free = {'position_gain': 0.0}
    model = model_from_dict(free, 'test')
    first, second = record([], model=free), record([], seed=2, model=free)
    moved = replace(second, y=second.y + 40.0)
    evidence = evidence_of(first, moved, model=model)
    assert evidence.starts.scales.speed < 1.05 * max(
        evidence_of(r).starts.scales.speed for r in (first, second))
    assert diagnose.diagnose([first, moved], model, only=['torque_gain']).verdict == 'none'


def test_evidence_of_one_encoder_begins_where_it_moves():
    """At rest, nothing tells where the other side is in the gap."""
    u = np.concatenate([np.zeros(round(1.5 / DT)), record([], 3).u])
    both = record([], 4.5, u=u)
    arm = replace(both, y=both.y[:, [1, 1]], channels=(1,))
    begin_both, begin_arm = (evidence_of(r).segments[0].span.start * DT for r in (both, arm))
    assert begin_both < 0.3 and 1.4 < begin_arm < 2.2
    assert evidence_of(both, arm).segments[1].span.start * DT == begin_arm
    alone = evidence_of(arm)
    runs = alone.runs(unfitted(alone.fine, alone.starts.none()))
    written = closed_model.file_closure([arm], DriveModel(), SIGMA, runs, runs)
    assert written['gap_after'] == pytest.approx(written['gap_before'], rel=0.02)


def test_validation_on_a_second_recording():
    effect = {'id': 'arm_coulomb', 'Cac': 0.05}
    result = closed_model.validate(record([effect], seed=9), DriveModel(),
                                   model_from_dict({'effects': [effect]}, 'test'), SIGMA)
    assert result['gap_after'] == pytest.approx(1.0, abs=0.03) and result['gap_before'] > 1.3
    before, after = result['free_run']['before'], result['free_run']['after']
    assert after['motor'] < 0.2 * before['motor'] and after['arm'] < 0.2 * before['arm']


def test_confusable_lists_what_little_evidence_leaves_open():
    ids = ['torque_offset', 'coulomb_asymmetry', 'gravity', 'motor_inertia']
    decision = decide(evidence_of(record([{'id': 'torque_offset', 'u0': 0.02}], 3), ids=ids))
    table = effect_scan.separations(decision.recordings, decision.fit, decision.fits, {})
    d, shares = table['torque_offset']
    assert d > 100 and shares['coulomb_asymmetry'] < 0.05 < shares['gravity']
    names = effect_scan.rivals(decision.recordings, decision.fit, decision.fits, table)
    assert 'coulomb_asymmetry' in names['torque_offset']
    assert 'motor_inertia' not in names['torque_offset']


def test_an_effect_is_confused_with_its_own_rivals_only():
    """A torque offset is asymmetric friction; the weight beside it is neither."""
    effects = [{'id': 'torque_offset', 'u0': 0.05}, {'id': 'gravity', 'G': 0.3}]
    recording = record(effects, 2)
    verdict = diagnose.diagnose([recording], DriveModel(), only=[
        'torque_offset', 'coulomb_asymmetry', 'gravity'])
    rivals = {f.effect: f.confusable for f in verdict.findings}
    assert rivals == {'torque_offset': ('coulomb_asymmetry',), 'gravity': ()}
    assert verdict.confusable == ['coulomb_asymmetry']


@pytest.mark.system
def test_an_effect_that_explains_a_part_is_named_with_what_remains():
    """Two effects of which one is not among the candidates: a finding and a remainder."""
    effects = [{'id': 'torque_gain', 'g': 0.2}, {'id': 'stribeck', 'Cs': 0.05, 'vs': 0.5}]
    verdict = diagnose.diagnose([record(effects, 4)], DriveModel(),
                                only=['torque_gain', 'arm_inertia'])
    data = verdict.to_dict()
    assert (data['verdict'], data['effect'], data['location']) == (
        'incomplete', 'torque_gain', 'actuator')
    finding, = verdict.findings
    assert finding.values['g'] == pytest.approx(0.2, abs=0.05) and 0.3 < finding.share < 1.0
    assert data['remainders'][0]['location'] == 'motor_side'
    assert data['remainders'][0]['over'] == 'speed of the motor'
    assert 1.05 < data['gap_after'] < data['gap_before']
    json.dumps(data, allow_nan=False)


def test_a_torque_scale_says_what_else_it_may_be_called(cases):
    data = diagnose.diagnose([record([{'id': 'torque_gain', 'g': 0.08}])], DriveModel(),
                             only=['torque_gain', 'gravity']).data
    assert 'multiplied by 0.92' in data['equivalent'][0]


@pytest.mark.parametrize('ids', [
    ['lugre', 'motor_viscous'], pytest.param(['lugre'], marks=pytest.mark.system)])
def test_an_effect_without_a_scale_ends_in_a_verdict(ids):
    """LuGre beside a model without Coulomb friction has no gain: it is ranked all the same."""
    model = {'coulomb_friction': 0.0}
    recording = record([{'id': 'motor_viscous', 'Cv': 0.13}], 3, model=model)
    data = diagnose.diagnose([recording], model_from_dict(model, 'test'), only=ids).data
    assert data['verdict'] in ('effect', 'incomplete', 'unknown')
    assert all(np.isfinite(gain) for gain in data['gains'].values())
    json.dumps(data, allow_nan=False)


@pytest.mark.system
def test_a_frozen_encoder_ends_in_a_verdict():
    recording = record([])
    y = recording.y.copy()
    y[1000:, 1] = y[1000, 1]
    data = diagnose.diagnose([replace(recording, y=y)], DriveModel(),
                             only=['torque_gain', 'gravity']).data
    assert data['verdict'] in ('incomplete', 'unknown')
    assert data['remainders'][0]['location'] == 'arm_sensor'
    json.dumps(data, allow_nan=False)


def test_windows_that_lack_something_say_where():
    evidence = evidence_of(record([], 8))
    run, = evidence.runs(without(evidence))
    lacking = np.array([0.0, 9.0, 0.0, 9.0, 9.0, 0.0, 9.0, 9.0])[:len(run.data.windows)]
    run = replace(run, residual=np.sqrt(lacking)[:, None, None] * np.ones_like(run.residual))
    chosen = localisation.some_windows(run, 3)
    assert len(chosen.data.windows) == 3 and (chosen.chi2 > 0.0).all()
    # Too few of them: all windows take part.
    assert (localisation.some_windows(run, 6).chi2 == 0.0).any()


@pytest.mark.parametrize('place', ['motor_side', 'arm_sensor'])
def test_windows_side_by_side_do_not_touch_each_other(place):
    """They begin in their neighbours, whose free torque is another."""
    evidence = evidence_of(record([], 4))
    run, = evidence.runs(without(evidence))
    estimator, order = InputEstimator(run, place), np.arange(len(run.data.windows))
    theta = np.hstack([np.random.default_rng(1).normal(size=(len(order), estimator.count)),
                       run.states])
    together, order = estimator.residual(theta, order), np.array([2, 0, 2])
    # Lanes of another number may round otherwise.
    np.testing.assert_allclose(estimator.residual(theta[order], order), together[order],
                               rtol=1e-9, atol=1e-9)


def test_a_window_in_which_nothing_moves_has_no_pulse():
    """Its readings say nothing of a torque: the precision of all values is 0."""
    free = SimpleNamespace(signal=np.ones((2, 5)), precision=np.stack([
        np.zeros((5, 5)), 100.0 * np.eye(5)]))
    bursts, windows, _ = rectangles(free, 1.0)
    assert windows.tolist() == [1]
    assert bursts[:, 1:] == pytest.approx(np.array([[5 * localisation.SPACING, 1.0]]))


@pytest.mark.system
def test_a_doubt_about_signs_must_be_likelier_than_any_effect():
    """The same doubt about a recording as it is, with a gain, and with the sign turned."""
    right = record([{'id': 'torque_gain', 'g': 0.3}])
    doubt = Doubt('the sign of the torque u is wrong', torque=-1.0)
    data = diagnose.diagnose([replace(right, doubt=doubt)], DriveModel(),
                             only=['torque_gain']).data
    assert data['effect'] == 'torque_gain'
    assert any('the verdict explains the recording better' in w for w in data['warnings'])
    turned = replace(right, u=-right.u, name='turned', doubt=doubt)
    with pytest.raises(InputError, match='turned: the sign of the torque u is wrong'):
        diagnose.diagnose([turned], DriveModel(), only=['motor_viscous'])


@pytest.mark.parametrize('law', ['mujoco'])
def test_the_law_of_friction_is_doubted_once(law):
    """MuJoCo's constraint against an arctangent in the model file is no effect and no unknown."""
    true = {'friction_law': {'kind': law}, 'timestep': 0.001, 'integrator': 'rk4'}
    recording = record([], 3, std=(5e-4, 5e-4), model=true)
    data = diagnose.diagnose([recording], DriveModel(), only=['motor_viscous', 'stribeck']).data
    assert data['verdict'] == 'none', data['effect']
    assert any(f'follows the law {law}' in warning for warning in data['warnings'])


def test_noise_on_a_lattice_is_that_of_encoder_and_rounding():
    """The step is in standard deviations of the noise; motion crosses many of them."""
    for step in (0.05, 0.5, 1.0, 2.0):
        t = np.arange(12_000) * DT
        y = 3.0 * np.sin(8.0 * t) + 0.01 * np.random.default_rng(1).standard_normal(len(t))
        quantum = 0.01 * step
        coarse = quantum * np.rint(y / quantum)
        levels, steps = elementary.noise_levels(np.column_stack([coarse, y]))
        assert levels[0] == pytest.approx(0.01 * np.sqrt(1.0 + step ** 2 / 12.0), rel=0.04)
        assert levels[1] == pytest.approx(0.01, rel=0.04)
        assert steps == pytest.approx([quantum, 0.0])


@pytest.mark.system
def test_steps_above_the_noise_of_an_encoder_are_no_unknown_effect():
    """In slow motion their error lasts: it is not white, and no model explains it."""
    t = np.arange(3000) * DT
    wave = np.sin(2 * np.pi * 0.3 * t)
    recording = record([], 6, std=(0.0045, 0.0045),
                       u=0.6 * np.sign(wave) * np.minimum(1.0, 4.0 * np.abs(wave)))
    recording.y[:, 0] = 0.04 * np.rint(recording.y[:, 0] / 0.04)
    data = diagnose.diagnose([recording], DriveModel(), only=[
        'motor_encoder_quantisation', 'arm_coulomb', 'torque_offset']).data
    assert data['effect'] == 'motor_encoder_quantisation', data['misfit']
    assert data['params']['motor_encoder_quantisation']['q'] == pytest.approx(0.04)
    data = diagnose.diagnose([recording], DriveModel(), only=['arm_coulomb', 'torque_offset'],
                             exclude=['motor_encoder_quantisation']).data
    assert data['verdict'] == 'unknown' and data['location'] == 'motor_sensor', data['warnings']


@pytest.mark.system
def test_an_effect_that_shows_at_the_end_alone_is_seen():
    u = record([], 8).u * np.where(np.arange(4000) < 3000, 1.0, 2.0)
    limit = 1.1 * np.abs(u[:3000]).max()
    assert limit < np.abs(u).max()
    data = diagnose.diagnose([record([{'id': 'saturation', 'umax': limit}], u=u, seconds=8)],
                             DriveModel(), only=['saturation', 'motor_viscous']).data
    assert data['effect'] == 'saturation'
    assert data['params']['saturation']['umax'] == pytest.approx(limit, rel=0.01)


@pytest.mark.system
def test_bursts_are_named_with_their_times():
    """Two of 44 ms in 6 s, hardly above the noise."""
    bursts = [{'id': 'disturbance', 't0': t0, 'duration': 0.044, 'amplitude': amplitude}
              for t0, amplitude in ((1.62, -0.0144), (4.9, 0.0173))]
    data = diagnose.diagnose([replace(record(bursts, 6), begin=20.0)], DriveModel(),
                             only=['disturbance', 'motor_viscous']).data
    assert data['effect'] == 'disturbance'
    assert data['gains']['disturbance'] < data['findings'][0]['evidence']  # of a part, once
    assert sorted(b['t0'] for b in data['bursts']) == pytest.approx([21.62, 24.9], abs=0.08)
    assert data['findings'][0]['values']['t0'] == pytest.approx(24.9, abs=0.08)


def test_the_order_of_a_small_periodic_effect_is_found():
    evidence = evidence_of(record([{'id': 'cogging', 'A': 0.001, 'N': 36, 'phi': -1.8}], 6),
                           ids=['cogging'])
    proposal = scan(evidence.fine, evidence.starts, without(evidence), ['cogging'])[0]
    assert (proposal.name, proposal.order) == ('cogging', 36)


def test_a_wave_of_less_than_a_period_is_no_candidate():
    t = np.arange(2000) * DT
    evidence = evidence_of(record([], 4, u=0.5 * np.sin(9.0 * t)), ids=['cogging'])
    travel = np.ptp(evidence.recordings[0].y[:, 0])
    assert min(evidence.starts.orders) * travel >= 2.0 * np.pi > (
        min(evidence.starts.orders) - 1) * travel


def scattered(effects, torque_noise=0.005, seconds=8, seed=3):
    """Return (recording, DriveModel told) of a drive with torque noise, nominal within 1.5 %."""
    told = model_from_dict({'tolerance': 0.015}, 'test')
    scatter = np.random.default_rng(seed).normal(0.0, 0.015, 3)
    own = model_from_dict({'effects': [
        {'id': i, p: v * (1.0 + f)} for (i, p, v), f in zip((
            ('arm_inertia', 'm2', told.arm_inertia),
            ('motor_coulomb', 'Cc', told.coulomb_friction),
            ('stiffness', 'K', told.transmission.stiffness)), scatter)
        if i not in {e['id'] for e in effects}] + effects}, 'test')
    r = record([], seconds, seed)
    noise = np.random.default_rng(seed + 1).normal(0.0, torque_noise, len(r.u))
    path = simulate(own, r.u + noise, DT, Noise(measurement=tuple(SIGMA)), seed)
    return UniformRecording(r.t, r.u, path.y, DT), told


@pytest.mark.parametrize('effects, expected', [
    ([], None),
    ([{'id': 'motor_viscous', 'Cv': 0.088}], 'motor_viscous'),
    ([{'id': 'load_torque', 'TL': 0.05}, {'id': 'backlash_gap', 'b': 0.113}],
     'load_torque+backlash_gap'),
])
@pytest.mark.system
def test_a_value_far_beyond_its_tolerance_is_an_effect(effects, expected):
    recording, told = scattered(effects)
    data = diagnose.diagnose([recording], told, only=[
        'motor_viscous', 'backlash_gap', 'load_torque', 'torque_gain', 'disturbance'], jobs=2).data
    assert data['verdict'] == ('effect' if expected else 'none')
    assert sorted((data['effect'] or '').split('+')) == sorted((expected or '').split('+'))
    for effect in effects:
        for parameter, value in effect.items():
            if parameter != 'id':
                assert data['params'][effect['id']][parameter] == pytest.approx(value, rel=0.05)
    assert all(abs(shift) < 4.0 for shift in data['nominal_shift'].values())


def test_what_follows_the_torque_is_at_the_actuator():
    decision = decide(evidence_of(record([{'id': 'torque_gain', 'g': 0.2}], 3),
                                  ids=['arm_inertia']))
    assert decision.remains and decision.place == 'actuator'


@pytest.mark.parametrize('gain, named', [(2.0, ()), (0.4, ('torque_gain',))])
def test_a_value_at_a_bound_of_physics_is_no_finding(gain, named):
    """A gain of three is none of an actuator's: something else is named, or nothing."""
    decision = decide(evidence_of(record([{'id': 'torque_gain', 'g': gain}], 2),
                                  ids=['torque_gain']))
    assert decision.ids == named and decision.remains == (not named)


@pytest.mark.system
def test_a_command_from_before_the_recording_is_no_evidence():
    t = np.arange(4500) * DT
    sines = sum(a * np.sin(2 * np.pi * f * t)
                for a, f in ((1.2, 0.5), (0.6, 1.3), (0.3, 3.2)))
    u = sines + np.where((1.3 * t) % 1.0 < 0.5, 2.0, -2.0)  # jumps
    lag, late = 0.02, 579                                   # samples: 4 ms after a jump
    whole = record([{'id': 'actuator_lag', 'T': lag}], u=u, seconds=9, std=(2e-4, 2e-4))
    kept = UniformRecording(t[:-late], u[late:], whole.y[late:], DT)
    data = diagnose.diagnose([kept], DriveModel(), only=['actuator_lag', 'actuator_delay',
                                                         'motor_inertia']).data
    assert (data['verdict'], data['effect']) == ('effect', 'actuator_lag')
    assert data['params']['actuator_lag']['T'] == pytest.approx(lag, rel=0.01)


SETTLED = [
    (4.0, 0.0, 4, 500), (6.5, 0.1, 6, 500), (4.95, 0.1, 4, 500), (4.05, 0.1, 4, 493)]


def test_windows_after_settling_are_as_many():
    for seconds, settling, count, length in SETTLED:
        n = round(seconds / DT)
        recording = UniformRecording(np.arange(n) * DT, np.zeros(n), np.zeros((n, 2)), DT)
        windows = shooting_windows(recording, 1.0, settling)
        assert (len(windows), windows.length) == (count, length)
        assert windows.first[0] == round(settling / DT)


LASTS = 0.1  # s
REAL = DriveModel().with_(kind='rigid', position_gain=0.0, tolerance=0.02,
                          process_torque_time=1.0)


def lasting_record(effects, size, seconds=6.0):
    """Return a recording in which torque of `size` (N m rms) that lasts LASTS is unexplained."""
    dt, noise = 0.005, np.random.default_rng(4)
    t = np.arange(0.0, seconds, dt)
    u = np.sign(np.sin(1.6 * t)) + 0.3 * np.sin(8.2 * t)
    fade = np.exp(-dt / LASTS)
    lasting = lfilter([size * np.sqrt(1.0 - fade ** 2)], [1.0, -fade],
                      noise.standard_normal(len(t)))
    x = simulate(REAL.with_(effects=effects), u + lasting, dt).x[:, :1]
    return UniformRecording(
        t, u, np.repeat(x + 2e-4 * noise.standard_normal(x.shape), 2, axis=1), dt, channels=(0,))


def test_an_effect_is_not_what_lasts_beside_the_model_without_it():
    """A model file that was fitted without an effect takes its strokes for lasting torque."""
    recording = lasting_record(({'id': 'viscous_asymmetry', 'Cva': 0.04},), 0.1)
    evidence = diagnose.evidence_of([recording], REAL, ['viscous_asymmetry'])
    decision = decide(evidence)
    assert decision.ids == ('viscous_asymmetry',)
    assert decision.recordings.model.process_torque_time == LASTS
    (_, (effect,)), (errors, _) = (decision.fit.candidate.values(decision.fit.z),
                                   standard_errors(decision.recordings.fine, decision.fit))
    assert abs(effect['Cva'] - 0.04) < 2.5 * errors['viscous_asymmetry']['Cva'] < 0.01


def test_long_steps_that_show_are_shortened():
    """A drive that is stiffer at large torque needs shorter steps only where that acts."""
    u = record([], 8).u * np.where(np.arange(4000) < 3100, 1.0, 8.0)
    std = 0.01 * SIGMA
    hardening = {'id': 'hardening', 'K3': 1e3}
    evidence = replace(evidence_of(record([hardening], 8, std=std, u=u), ids=['hardening']),
                       sigma=std)
    fit = from_truth(evidence, 'hardening', hardening)
    contested = InnovationEvidence(evidence)
    h = contested.hypothesis(replace(fit, torque=evidence.fine.least_noise))
    assert contested.settled(h, Remains(100.0, 0.0)).data.finer > 1


def test_an_effect_begins_with_what_imitated_it_taken_back():
    """All values of the model take up a torque scale, and give way to it in one step."""
    evidence = evidence_of(record([{'id': 'torque_gain', 'g': -0.075}], dt=1e-3),
                           model=DriveModel().with_(tolerance=0.015), ids=['torque_gain'])
    none = fitted(evidence.coarse, unfitted(evidence.coarse, evidence.starts.none()))
    assert np.abs(none.z).max() > 0.07
    (proposal,) = scan(evidence.coarse, evidence.starts, none, ['torque_gain'])
    begun = _begun(evidence, none, 0, proposal)
    assert none.deviance - begun.deviance > 0.8 * proposal.gain > 50.0
    assert np.abs(begun.z[:-1]).max() < 0.02 and begun.z[-1] == pytest.approx(-0.075, abs=0.01)


@pytest.mark.parametrize('changed', [
    {'id': 'gravity', 'G': 0.6, 'phi': 0.1}, {'id': 'arm_viscous', 'Cav': 0.08},
    {'id': 'motor_viscous', 'Cv': 0.0}, {'id': 'saturation', 'umax': 0.9}])
def test_a_change_of_what_the_model_has_begins_there(changed):
    """As in a simulator's file; friction may vanish, a limit come from beyond all torque."""
    has = ({'id': 'gravity', 'G': 0.68, 'phi': 0.0}, {'id': 'arm_viscous', 'Cav': 0.05},
           {'id': 'saturation', 'umax': 20.0})
    truth = [*(e for e in has if e['id'] != changed['id']), changed]
    evidence = evidence_of(record(truth, 2), model=DriveModel().with_(effects=has),
                           ids=['gravity', 'arm_viscous', 'motor_viscous', 'saturation'])
    none = fitted(evidence.coarse, unfitted(evidence.coarse, evidence.starts.none()))
    proposal = scan(evidence.coarse, evidence.starts, none, evidence.ids)[0]
    assert proposal.name == changed['id']
    begun = _begun(evidence, none, 0, proposal)
    assert none.deviance - begun.deviance > 0.8 * proposal.gain
    fit = fitted(evidence.fine, begun, 12)
    values = fit.candidate.values(fit.z)[1][0]
    assert values == pytest.approx({k: v for k, v in changed.items() if k != 'id'}, abs=2e-3)
    contested = InnovationEvidence(evidence)
    assert contested.remains(contested.hypothesis(fit), True).worth < CONTEST.margin


def test_two_changes_one_of_what_the_model_has():
    has, scale = {'id': 'gravity', 'G': 0.68, 'phi': 0.0}, {'id': 'torque_gain', 'g': 0.06}
    evidence = evidence_of(record([{**has, 'G': 0.6}, scale], 3), model=DriveModel().with_(
        effects=(has,)), ids=['gravity', 'torque_gain', 'arm_inertia'])
    decision = decide(evidence)
    assert set(decision.ids) == {'gravity', 'torque_gain'} and not decision.remains
    assert decision.values['gravity']['G'] == pytest.approx(0.6, abs=3e-3)
    assert decision.values['torque_gain']['g'] == pytest.approx(0.06, abs=3e-3)


def test_the_interval_of_the_closed_fraction_covers_the_error_of_the_noise():
    """A right model leaves nothing: what its fraction is off 1 by is sigma's error, and chance."""
    windows, length, covered = 12, 500, []
    signal = np.sin(np.linspace(0.0, 20.0, windows * length))[:, None]
    for seed in range(60):
        noise = np.random.default_rng(seed).standard_normal((windows * length, 2))
        sigma, _ = elementary.noise_levels(noise)
        left, before = (x.reshape(windows, length, 2) for x in (
            noise / sigma, (noise + signal) / sigma))
        power, _, high = spectrum(left, DT)
        power = power[:, high].mean(axis=(1, 2))
        low, high = closed_model._interval(
            *((x ** 2).mean(axis=(1, 2)) for x in (before, left)), power / power.mean(), left.size,
            np.random.default_rng(seed))
        covered.append(low <= 1.0 <= high)
    assert 0.8 <= np.mean(covered) <= 0.98  # of 90 %


@pytest.mark.parametrize('gap, stated', [(1.01, False), (1.2, True)])
def test_a_gap_that_may_be_none_has_no_closed_fraction(gap, stated):
    """Dividing by nothing bounds nothing: the windows' misfits scatter by 10 %."""
    random = np.random.default_rng(5)
    noise = random.uniform(0.8, 1.2, 12)
    interval = closed_model._interval(gap ** 2 * noise, np.ones(12), np.ones(12), 24_000, random)
    assert (interval is not None) == stated
    if stated:
        low, high = interval
        assert 0.5 < low < 1.0 < high < 1.5
