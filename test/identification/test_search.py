# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Where the gap lies, how far it closes, and what a recording can separate."""
from dataclasses import replace
import json
from types import SimpleNamespace

import numpy as np
import pytest

from gearbox_monitor.identification import (
    adequacy, closed_model, diagnose, gauss_newton, isolability, localisation,
    selection, shooting, verdict, window_states)
from gearbox_monitor.identification.candidates import sine_and_cosine
from gearbox_monitor.identification.disturbance_pulses import (
    at_ends_of_travel, disturbance_fit)
from gearbox_monitor.identification.innovation_selection import InnovationEvidence
from gearbox_monitor.identification.input_estimation import SPACING
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.residual_dependence import (
    ResidualDependence, strongest_dependence)
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.smoothed_windows import fit_none
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels import sensor_noise
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.quality.recording import UniformRecording

DT, SIGMA = 0.001, (0.002, 0.002)
CASES = {
    'stribeck': ({'Cs': 0.15, 'vs': 0.5}, 'motor_side'),
    'torque_gain': ({'g': 0.08}, 'actuator'),
    'arm_coulomb': ({'Cac': 0.03}, 'arm_side'),
    'backlash_gap': ({'b': 0.115}, 'transmission'),
    'arm_encoder_eccentricity': ({'A': 0.02, 'phi': 0.7}, 'arm_sensor'),
}


def record(effects, seconds=5, seed=1, std=SIGMA, u=None):
    """Return a Recording of the paper's drive with `effects` under a sum of sines."""
    t = np.arange(round(seconds / DT)) * DT
    if u is None:
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, 3)
        u = sum(a * np.sin(2 * np.pi * f * t + p)
                for a, f, p in zip((0.6, 0.4, 0.3), (0.45, 1.1, 2.3), phase))
    model = model_from_dict({'effects': effects}, 'test')
    path = simulate(model, u, DT, Noise(measurement=std), seed)
    return UniformRecording(t, u, path.y, DT)


@pytest.fixture(scope='module')
def searches():
    """Return {id: (Search, none, Fitted of the id, from the truth on)} of all cases."""
    out = {}
    for name, (values, _) in CASES.items():
        search = Search(record([{'id': name, **values}]), DriveModel(), SIGMA, [name])
        out[name] = search, fit_none(search), fitted_from(search, name, values)
    return out


def fitted_from(search, name, values):
    """Return the Fitted of effect `name` that begins at its true `values`."""
    candidate = search.starts.candidates(name)[0]
    if 'phi' in values:
        values = sine_and_cosine(name, values)
    point = search.fitted[''].point.at(np.array(
        [np.log(values[c.name]) if c.log else values[c.name] for c in candidate.coordinates]))
    for _ in range(3):
        point = window_states.rescue(search.long, candidate, window_states.solved(
            search.long, candidate, point))
    return search.as_fitted(candidate, gauss_newton.fit(search.long, candidate, point, 6))


def test_a_start_that_one_fit_has_serves_the_others():
    search = Search(record([]), DriveModel(), SIGMA, ['stiffness'])
    none = fit_none(search)
    search.keep(fitted_from(search, 'stiffness', {'K': 25.0}))
    states, good = none.point.states.copy(), none.point.chi2
    states[2, 2] += 0.005  # rad/s: not enough to stand out
    spoiled = search.long.evaluate(none.candidate, replace(none.point, states=states))
    assert good[2] + 20.0 < spoiled.chi2[2] < 1.1 * search.long.size
    search.keep(search.as_fitted(none.candidate, spoiled))
    InnovationEvidence(search).share_starts()
    np.testing.assert_allclose(search.fitted[''].point.chi2, good, atol=1.0)


@pytest.mark.parametrize('name', [name for name in CASES if name != 'arm_coulomb'])
def test_a_free_signal_finds_the_place(searches, name):
    search, none, _ = searches[name]
    found = localisation.places(search, none)
    location = CASES[name][1]
    assert found['location'] == location, found['places']
    assert found['place'] == ('motor_side' if location == 'actuator' else location)
    assert found['places'][found['place']]['explained'] > 0.8
    assert all(0.0 <= v['explained'] <= 1.0 for v in found['places'].values())
    for shares in found['region'].values():
        assert sum(shares['time'].values()) == pytest.approx(1.0)
    if name == 'stribeck':
        assert found['region']['speed']['signal']['high'] < 0.2
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize('name', CASES)
def test_the_true_effect_closes_the_gap(searches, name):
    search, none, fitted = searches[name]
    found = closed_model.closure(search, none, fitted, seed=3)
    assert found['gap_before'] > 1.05
    assert found['gap_after'] == pytest.approx(1.0, abs=0.03)
    assert found['closed_fraction'] == pytest.approx(1.0, abs=0.15)
    low, high = found['closed_fraction_ci']
    assert low <= 1.0 <= high and low <= found['closed_fraction'] <= high
    assert not found['at_bound']
    truth, (given,) = CASES[name][0], fitted.candidate.values(fitted.point.z)[1]
    for parameter, value in truth.items():
        error = found['standard_errors'][name][parameter]
        assert abs(given[parameter] - value) < 4.5 * error, parameter
    assert found == closed_model.closure(search, none, fitted, seed=3)
    json.dumps(found, allow_nan=False)


def test_without_an_effect_there_is_nothing_to_close():
    search = Search(record([]), DriveModel(), SIGMA, [])
    found = closed_model.closure(search, fit_none(search), None)
    assert found['closed_fraction'] is None and found['closed_fraction_ci'] is None
    assert found['gap_before'] == pytest.approx(1.0, abs=0.03)


def test_a_wrong_effect_does_not_close_the_gap(searches):
    search, none, _ = searches['arm_encoder_eccentricity']
    wrong = search.starts.candidates('motor_viscous')[0]
    point = search.long.evaluate(wrong, none.point.at(wrong.start()))
    found = closed_model.closure(search, none, search.as_fitted(wrong, point))
    assert found['closed_fraction'] < 0.1 and found['closed_fraction_ci'][1] < 0.3


def test_validation_on_a_second_recording():
    effect = {'id': 'arm_coulomb', 'Cac': 0.05}
    found = closed_model.validate(record([effect], seed=9), DriveModel(),
                                  model_from_dict({'effects': [effect]}, 'test'), SIGMA)
    assert found['gap_after'] == pytest.approx(1.0, abs=0.03) and found['gap_before'] > 1.3
    before, after = found['free_run']['before'], found['free_run']['after']
    assert after['motor'] < 0.2 * before['motor'] and after['arm'] < 0.2 * before['arm']


def test_one_speed_cannot_tell_viscous_from_coulomb_friction():
    """Forth and back at one speed, Cv and Cc act alike; at several speeds they do not."""
    t = np.arange(4000) * DT
    ids = ['motor_coulomb', 'motor_viscous', 'gravity', 'torque_offset', 'coulomb_asymmetry']
    slow = 0.5 * np.sign(np.sin(2 * np.pi * 0.5 * t))
    levels = np.repeat([0.35, -0.6, 1.5, 0.4] * 4, 250)
    found = []
    for u in (slow, levels):
        search = Search(record([], 4, u=u), DriveModel(), SIGMA, ids)
        fit_none(search)
        names, s2 = isolability.matrix(search, ids)
        assert np.diag(s2) == pytest.approx(0.0, abs=1e-6)
        found.append({(a, b): s2[i, j] for i, a in enumerate(names)
                      for j, b in enumerate(names)})
    pair = ('motor_coulomb', 'motor_viscous')
    assert found[0][pair] < 0.03 and found[1][pair] > 10 * found[0][pair]
    for table in found:
        assert table['motor_coulomb', 'gravity'] > 0.1
        assert table['torque_offset', 'coulomb_asymmetry'] < 0.02


def test_confusable_lists_what_little_evidence_leaves_open():
    ids = ['torque_offset', 'coulomb_asymmetry', 'gravity', 'motor_inertia']
    search = Search(record([{'id': 'torque_offset', 'u0': 0.02}], 4), DriveModel(), SIGMA, ids)
    best = InnovationEvidence(search).convincing_single()
    found = isolability.separations(search, best)
    d, table = found['torque_offset']
    assert d > 100 and table['coulomb_asymmetry'] < 0.05 < table['gravity']
    names = isolability.confusable(search, best, found)
    assert 'coulomb_asymmetry' in names and 'motor_inertia' not in names


def test_a_parameter_at_its_bound_is_no_discovery():
    """Friction that has drifted from the first moment on is plain friction, if hardly worse."""
    search = Search(record([]), DriveModel(), SIGMA, ['viscous_drift', 'motor_viscous'])
    fit_none(search)
    none = search.fitted['']
    for name in search.ids:
        candidate = search.starts.candidates(name)[0]
        search.keep(CandidateFit(candidate, replace(none.point, z=candidate.start()), 0.0))
    drift, plain = (search.fitted[name] for name in ('viscous_drift', 'motor_viscous'))
    drift = replace(drift, score=-5.0)
    assert selection.simpler(search, drift) is drift
    # Of the logarithm of the time constant, too.
    drift = replace(drift, point=replace(drift.point, z=np.full(len(drift.point.z), -50.0)))
    assert drift.candidate.at_bound(drift.point.z)
    search.keep(drift)
    assert selection.simpler(search, drift) is plain
    better = search.keep(replace(drift, score=-20.0))
    assert selection.simpler(search, better) is better
    search.keep(drift)
    search.keep(replace(plain, point=replace(  # as good, but another motion
        plain.point, residual=plain.point.residual + 1.0)))
    assert selection.simpler(search, drift) is drift


@pytest.mark.system
@pytest.mark.parametrize('effects, finer, verdict', [
    ([{'id': 'transmission_damping', 'D': 0.0108}], 1, 'unknown'),
    ([{'id': 'transmission_damping', 'D': 0.0108}], 4, 'effect'),
    ([], 1, 'unknown'), ([], 4, 'none')])
def test_steps_too_long_for_the_readings_are_no_unknown_effect(
        monkeypatch, effects, finer, verdict):
    monkeypatch.setattr(shooting, 'STEP_EIGENVALUE', 2.7)  # hardly stable
    monkeypatch.setattr('gearbox_monitor.identification.search.FINER', finer)
    u = 2.0 * record([], seed=3).u
    model = model_from_dict({'effects': effects}, 'test')
    y = simulate(model, np.repeat(u, 16), DT / 16).y[::16]
    y += 2e-4 * np.random.default_rng(3).standard_normal(y.shape)
    data = diagnose.diagnose([UniformRecording(np.arange(len(u)) * DT, u, y, DT)], DriveModel(),
                             only=['transmission_damping', 'torque_gain']).data
    assert data['verdict'] == verdict
    assert data['effect'] == ('transmission_damping' if verdict == 'effect' else None)


@pytest.mark.parametrize('step', [0.05, 0.5, 1.0, 2.0])
def test_noise_on_a_lattice_is_that_of_encoder_and_rounding(step):
    """The step is in standard deviations of the noise; motion crosses many of them."""
    t = np.arange(12_000) * DT
    y = 3.0 * np.sin(8.0 * t) + 0.01 * np.random.default_rng(1).standard_normal(len(t))
    quantum = 0.01 * step
    levels, found = sensor_noise.noise_levels(np.column_stack([quantum * np.rint(y / quantum), y]))
    assert levels[0] == pytest.approx(0.01 * np.sqrt(1.0 + step ** 2 / 12.0), rel=0.04)
    assert levels[1] == pytest.approx(0.01, rel=0.04)
    assert found == pytest.approx([quantum, 0.0])


@pytest.mark.system
def test_steps_above_the_noise_of_an_encoder_are_no_unknown_effect():
    """In slow motion their error lasts: it is not white, and no model explains it."""
    t = np.arange(6000) * DT
    wave = np.sin(2 * np.pi * 0.3 * t)
    found = record([], 6, std=(0.0045, 0.0045),
                   u=0.6 * np.sign(wave) * np.minimum(1.0, 4.0 * np.abs(wave)))
    found.y[:, 0] = 0.04 * np.rint(found.y[:, 0] / 0.04)
    data = diagnose.diagnose([found], DriveModel(), only=[
        'motor_encoder_quantisation', 'arm_coulomb', 'torque_offset']).data
    assert data['effect'] == 'motor_encoder_quantisation', data['misfit']
    assert data['params']['motor_encoder_quantisation']['q'] == pytest.approx(0.04)
    assert data['misfit']['structure'] > THRESHOLDS.structure
    data = diagnose.diagnose([found], DriveModel(), only=['arm_coulomb', 'torque_offset'],
                             exclude=['motor_encoder_quantisation']).data
    assert data['verdict'] == 'unknown' and data['location'] == 'motor_sensor', data['warnings']


@pytest.mark.system
def test_an_effect_that_shows_in_held_out_windows_alone_is_found():
    u = record([], 8).u * np.where(np.arange(8000) < 6000, 1.0, 2.0)
    limit = 1.1 * np.abs(u[:6000]).max()
    assert limit < np.abs(u).max()
    data = diagnose.diagnose([record([{'id': 'saturation', 'umax': limit}], u=u, seconds=8)],
                             DriveModel(), only=['saturation', 'motor_viscous']).data
    assert data['effect'] == 'saturation'
    assert data['params']['saturation']['umax'] == pytest.approx(limit, rel=0.01)
    assert 'only the held-out windows show the model error' in ' '.join(data['warnings'])


@pytest.mark.system
def test_what_training_windows_let_pass_is_judged_on_all():
    """A weight that none of the candidates is, hardly above the noise."""
    found = record([{'id': 'gravity', 'G': 0.0003}], seed=3)
    search = Search(found, DriveModel(), SIGMA, ['motor_viscous'])
    none = fit_none(search)
    assert not adequacy.incomplete(search, none)
    law = adequacy.residual_law(*adequacy.on_all(search, none))
    assert law.place == 'arm_side' and law.gain > 2.0 * THRESHOLDS.dependence
    data = diagnose.diagnose([found], DriveModel(), only=['motor_viscous']).data
    assert data['verdict'] == 'unknown' and data['location'] == 'arm_side', data['misfit']
    assert data['misfit']['follows']['over'] == 'angle of the arm in its turn'


@pytest.mark.system
def test_bursts_hardly_above_the_noise_are_found():
    """Two of 44 ms in 6 s; worth 100 in chi2 each."""
    bursts = [{'id': 'disturbance', 't0': t0, 'duration': 0.044, 'amplitude': amplitude}
              for t0, amplitude in ((1.62, -0.008), (4.9, 0.0096))]
    data = diagnose.diagnose([record(bursts, 6)], DriveModel(),
                             only=['disturbance', 'motor_viscous']).data
    assert data['effect'] == 'disturbance' and data['gains']['disturbance'] < 250.0


@pytest.mark.system
@pytest.mark.parametrize('steady', [False, True])
def test_a_load_that_swings_all_the_time_is_no_bursts(steady):
    """So weak that most windows look as if nothing were missing. Or stronger, and but twice."""
    t = 0.02 * np.arange(400)
    amplitude = (1.0 if steady else 6.0) * 0.0035 * np.sin(2 * np.pi * 3.0 * t)
    here = np.full(len(t), True) if steady else np.abs(t % 4.0 - 2.0) < 0.1
    loads = [{'id': 'disturbance', 't0': t0, 'duration': 0.02, 'amplitude': a}
             for t0, a in zip(t[here], amplitude[here])]
    search = Search(record(loads, 8), DriveModel(), SIGMA, ['disturbance'])
    fit_none(search)
    found = disturbance_fit(search)
    assert (found is None) == steady


def test_the_order_of_a_small_periodic_effect_is_found():
    search = Search(record([{'id': 'cogging', 'A': 0.001, 'N': 36, 'phi': -1.8}], 6),
                    DriveModel(), SIGMA, ['cogging'])
    fit_none(search)
    search.find_orders()
    assert search.found_orders('cogging')[0] == 36


@pytest.mark.parametrize('name, values, place, over', [
    ('stribeck', {'Cs': 0.003, 'vs': 0.5}, 'motor_side', 'speed of the motor'),
    ('torque_gain', {'g': 0.002}, 'actuator', 'torque'),
    ('arm_coulomb', {'Cac': 0.0005}, 'arm_side', 'speed of the arm'),
    ('gravity', {'G': 0.002, 'phi': 0.0}, 'arm_side', 'angle of the arm in its turn'),
    ('backlash_gap', {'b': 0.1005}, 'transmission', 'twist'),
    ('arm_encoder_eccentricity', {'A': 0.001, 'phi': 0.7}, 'arm_sensor',
     'angle of the arm in its turn')])
def test_what_is_left_is_a_function_of_the_motion(name, values, place, over):
    """Of effects that raise chi2 by a few percent."""
    search = Search(record([{'id': name, **values}]), DriveModel(), SIGMA, [name])
    none = fit_none(search)
    found = strongest_dependence(search, none)
    assert (found.place, found.over) == (place, over) and found.gain > 3.0 * THRESHOLDS.dependence
    assert strongest_dependence(search, fitted_from(search, name, values)).gain < 30.0


def test_noise_above_a_tenth_of_the_torque_is_no_noise():
    """A filter takes any error of the model for it; the model file may state more."""
    recording = record([])
    limit = 0.1 * np.std(recording.u)
    for stated in (0.0, 2.0 * limit):
        model = DriveModel(tolerance=0.015, process_torque=stated)
        search = Search(recording, model, SIGMA, [])
        none = fit_none(search)
        assert not adequacy.leaves_more_than_noise(search, replace(none, s=0.9 * limit))
        noisier = replace(none, s=1.1 * limit)
        assert adequacy.leaves_more_than_noise(search, noisier) != bool(stated)


def test_noise_of_the_readings_is_no_law():
    random = np.random.default_rng(1)
    u = np.concatenate([np.full(random.integers(150, 1000), 2.1 * (-1) ** k) for k in range(40)])
    model = model_from_dict({
        'damping': 0.2588, 'motor_inertia': 0.004656, 'arm_inertia': 0.02905,
        'viscous_friction': 0.0756, 'coulomb_friction': 0.293,
        'transmission': {'kind': 'dead_zone', 'stiffness': 17.25, 'half_gap': 0.048}}, 'test')
    u, std = u[:12000], (0.048, 0.048)
    path = simulate(model, u, DT, Noise(measurement=std), 1)
    search = Search(UniformRecording(DT * np.arange(len(u)), u, path.y, DT), model, std,
                    ['stribeck'])
    none = fit_none(search)
    read = strongest_dependence(search, none)
    assert read.over == 'rate of the twist' and read.gain > THRESHOLDS.dependence
    assert strongest_dependence(search, none, modelled=True).gain < 20.0
    assert adequacy.residual_law(search, none) is None


def test_a_memory_that_is_stuck_is_freed():
    effect = {'h': 0.012, 'ds': 0.05}
    search = Search(record([{'id': 'hysteresis_branch', **effect}]), DriveModel(), SIGMA,
                    ['hysteresis_branch'])
    fit_none(search)
    right = fitted_from(search, 'hysteresis_branch', effect)
    memory = right.point.memory.copy()
    memory[:, 3] = -np.sign(memory[:, 3])
    stuck = window_states.solved(search.long, right.candidate,
                                 replace(right.point, memory=memory))
    assert stuck.chi2.sum() > right.point.chi2.sum() + 100.0
    freed = window_states.rescue(search.long, right.candidate, stuck)
    freed = gauss_newton.fit(search.long, right.candidate, freed, 4)
    assert freed.chi2.sum() < right.point.chi2.sum() + 5.0


def scattered(effects, torque_noise=0.005, seconds=8, seed=3):
    """Return (Recording, DriveModel told) of a drive with torque noise, nominal within 1.5 %."""
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
    path = simulate(own, r.u + noise, DT, Noise(measurement=SIGMA), seed)
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
    found = diagnose.diagnose([recording], told, only=[
        'motor_viscous', 'backlash_gap', 'load_torque', 'torque_gain', 'disturbance'], jobs=2).data
    assert found['verdict'] == ('effect' if expected else 'none')
    assert sorted((found['effect'] or '').split('+')) == sorted((expected or '').split('+'))
    for effect in effects:
        for parameter, value in effect.items():
            if parameter != 'id':
                assert found['params'][effect['id']][parameter] == pytest.approx(value, rel=0.05)
    assert all(abs(shift) < 4.0 for shift in found['nominal_shift'].values())


def test_what_explains_nearly_all_of_the_gap_is_where_the_unknown_is(searches):
    search, none, right = searches['torque_gain']
    assert verdict.nearly_known(search, right) == 'actuator'
    assert verdict.nearly_known(search, none) is None
    half = search.long.evaluate(right.candidate, right.point.at(0.5 * right.point.z))
    assert verdict.nearly_known(search, CandidateFit(right.candidate, half)) is None


@pytest.mark.parametrize('law, left, rest, expected', [
    (None, {'arm_side': 1.0}, 1.0, 'arm_side'),
    ('actuator', {'motor_side': 1.005, 'arm_side': 1.0}, 1.05, 'actuator'),
    ('actuator', {'motor_side': 1.005, 'arm_side': 1.0}, 1.2, 'arm_side'),
    ('actuator', {'motor_side': 1.02, 'arm_side': 1.0}, 1.05, 'arm_side'),
    ('transmission', {'transmission': 1.0, 'arm_side': 1.0}, 1.0, 'transmission'),
])
def test_what_is_left_decides_between_places_that_explain_as_much(law, left, rest, expected):
    places = {'location': 'arm_side', 'places': {p: {'left': v} for p, v in left.items()}}
    law = law and ResidualDependence(law, 'speed', 100.0)
    assert verdict.unknown_place(places, law, rest) == expected


@pytest.mark.parametrize('when, sign, low, high', [
    ('end', -1.0, 0.0, 0.01),    # pushed back where the travel ends
    ('end', 1.0, 0.9, 1.0),      # pushed on
    ('middle', -1.0, 0.2, 0.9)])
def test_bursts_at_the_ends_of_travel_are_no_disturbance(when, sign, low, high):
    dt, count = 2e-3, round(SPACING / 2e-3)
    t = np.arange(8 * 25 * count) * dt
    arm = np.sin(np.arange(8 * 25 * count) * 2 * np.pi / (25 * count))  # a window: a period
    signal, runs = np.zeros((8, 25)), np.zeros((8, 25), bool)
    h = 6 if when == 'end' else 12
    signal[2:4, h], runs[2:4, h] = sign, True
    search = SimpleNamespace(
        recording=SimpleNamespace(dt=dt), fitted={'': SimpleNamespace(
            candidate=SimpleNamespace(model=lambda z: None), point=SimpleNamespace(z=None))},
        long=SimpleNamespace(windows=SimpleNamespace(first=np.arange(8) * 25 * count),
                             positions=lambda *_: np.column_stack([t, arm])))
    p = at_ends_of_travel(search, SimpleNamespace(signal=signal), runs)
    assert low <= p <= high


def test_a_command_from_before_the_recording_is_no_evidence():
    t = np.arange(9000) * DT
    sines = sum(a * np.sin(2 * np.pi * f * t)
                for a, f in ((1.2, 0.5), (0.6, 1.3), (0.3, 3.2)))
    u = sines + np.where((1.3 * t) % 1.0 < 0.5, 2.0, -2.0)  # jumps
    lag, late = 0.02, 1157                                  # samples: 3 ms after a jump
    whole = record([{'id': 'actuator_lag', 'T': lag}], u=u, seconds=9, std=(2e-4, 2e-4))
    kept = UniformRecording(t[:-late], u[late:], whole.y[late:], DT)
    data = diagnose.diagnose([kept], DriveModel(), only=['actuator_lag', 'actuator_delay',
                                                         'motor_inertia']).data
    assert (data['verdict'], data['effect']) == ('effect', 'actuator_lag')
    assert data['params']['actuator_lag']['T'] == pytest.approx(lag, rel=0.01)


@pytest.mark.parametrize('seconds, settling, count, length', [
    ((4.0, 6.5), 0.0, 10, 1000), ((4.0, 6.5), 0.1, 10, 975), ((4.95,), 0.1, 4, 1000)])
def test_windows_after_settling_are_as_many(seconds, settling, count, length):
    ends = np.cumsum([round(s / DT) for s in seconds])
    n, cuts = int(ends[-1]), (0, *ends[:-1].tolist())
    recording = UniformRecording(np.arange(n) * DT, np.zeros(n), np.zeros((n, 2)), DT, cuts=cuts)
    windows = shooting.shooting_windows(recording, 1.0, settling)
    assert (len(windows), windows.length) == (count, length)
    assert np.isin(np.add(cuts, round(settling / DT)), windows.first).all()
    parts = windows.parted(4)
    assert (parts.first[::4] == windows.first).all() and (parts.begin[::4] == windows.begin).all()
    assert (np.diff(parts.first.reshape(-1, 4), axis=1) == length // 4).all()


@pytest.mark.parametrize('score, preferred, expected', [
    (10.0, True, ('effect', 'effect')), (10.0, False, ('', 'map')), (90.0, True, ('', 'map'))])
def test_a_map_gives_way_to_effects_that_explain_more(score, preferred, expected):
    """By score, and on readings that were not fitted."""
    none, effect, mapped = (
        SimpleNamespace(name=name, candidate=SimpleNamespace(ids=ids), score=value)
        for name, ids, value in (('', (), 200.0), ('effect', ('effect',), score),
                                 ('map', ('torque_map',), 50.0)))
    evidence = SimpleNamespace(
        search=SimpleNamespace(fitted={'': none, 'effect': effect},
                               model=SimpleNamespace(effects=())),
        holds=lambda fit, base: preferred or base is none,
        mapped=lambda base: mapped if base is none else None)
    assert tuple(fit.name for fit in selection.parts(evidence, effect)) == expected
