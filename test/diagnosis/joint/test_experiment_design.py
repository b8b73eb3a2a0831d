# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Suggested motions: within limits, better than what was there, and diagnosed rightly."""
from dataclasses import replace
import json

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.joint import isolability as motions
from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovation_fit import fitted, InnovationFit
from gearbox_monitor.diagnosis.joint.isolability import (
    DT, Limits, motion_separations, sized, suggest)
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.signals.uniform import UniformRecording

MODEL = DriveModel()
SIGMA = np.array([0.005, 0.005])
LAG = {'id': 'actuator_lag', 'T': 0.0015}
PAIR = ('actuator_lag', 'actuator_delay')


def slow(t):
    return Excitation('multisine', (3.0,), (0.3,)).torque(t)


@pytest.fixture(scope='module')
def found():
    """Return the motions for a lag that slow motion cannot tell from a dead time."""
    few, more = motions.KINDS, motions.CHANGES
    motions.KINDS, motions.CHANGES = few[::10], 3
    try:
        return suggest(MODEL, {'actuator_lag': {'T': LAG['T']}}, [PAIR],
                       Limits(4.0, 25.0, 1.5), SIGMA)
    finally:
        motions.KINDS, motions.CHANGES = few, more


@pytest.mark.system
def test_limits_hold_in_simulation(found):
    best = found[0]
    t, u = best.torque()
    run = simulate(replace(MODEL, effects=(LAG,)), u, DT)
    assert len(t) == 12000 and np.abs(u).max() <= 4.0 + 1e-9
    assert np.abs(run.x[:, 2:]).max() <= 25.0 and np.abs(run.x[:, :2]).max() <= 1.5
    assert [m.least for m in found] == sorted((m.least for m in found), reverse=True)


@pytest.mark.system
def test_the_suggestion_separates_what_slow_motion_does_not(found):
    t = np.arange(12000) * DT
    before, _ = motion_separations(
        MODEL, {'actuator_lag': {'T': LAG['T']}}, slow(t), SIGMA, [PAIR])
    assert before[PAIR] < THRESHOLDS.isolable < found[0].separation[PAIR]


def test_it_is_what_the_evidence_of_fits_says():
    """By its linear prediction: chi2 that a rival leaves where its own fit is free."""
    t = np.arange(12000) * DT
    u = Excitation('multisine', (3.0, 2.0), (0.9, 2.3)).torque(t)
    values = {'Cv': 1.03 * MODEL.viscous_friction}
    pair, exact = ('motor_viscous', 'motor_coulomb'), MODEL.with_(sharpness_tolerance=0.0)
    found, _ = motion_separations(exact, {'motor_viscous': values}, u, SIGMA, [pair])
    run = simulate(replace(MODEL, effects=({'id': 'motor_viscous', **values},)), u, DT)
    evidence = DriveRecordings((UniformRecording(t, u, run.y, DT),), exact, SIGMA, ())
    likelihood, least = evidence.fine, evidence.fine.least_noise
    deviance = {}
    for name in pair:
        candidate = evidence.starts.candidates(name)[0]
        deviance[name] = fitted(likelihood, InnovationFit(candidate, candidate.start(), least), 20,
                                free_noise=False).deviance
    left = deviance['motor_coulomb'] - deviance['motor_viscous']
    assert left == pytest.approx(found[pair], rel=0.2)


def test_a_usual_size_changes_what_the_model_has():
    weight = {'id': 'gravity', 'G': 0.7, 'phi': 0.0}
    t = np.arange(2000) * DT
    model = MODEL.with_(effects=(weight,))
    starts = Starts(model, [UniformRecording(t, slow(t), simulate(model, slow(t), DT).y, DT)])
    (_, (usual,)) = (c := sized(starts, 'gravity')).values(c.start())
    assert usual['G'] != pytest.approx(weight['G'], rel=0.02)


def test_twins_are_not_promised_a_motion():
    with pytest.raises(InputError, match='no pair'):
        suggest(MODEL, {}, [('torque_offset', 'coulomb_asymmetry')], Limits(4.0), SIGMA)


@pytest.mark.system
def test_from_a_verdict_to_parameters_of_the_plant(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(motions, 'KINDS', motions.KINDS[::8])
    monkeypatch.setattr(motions, 'CHANGES', 0)
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'drive.yaml').write_text(yaml.safe_dump(MODEL.to_dict()))
    verdict = {'params': {'actuator_lag': {'T': 0.0015}}, 'confusable': ['actuator_delay'],
               'sigma': [0.005, 0.005]}
    (tmp_path / 'verdict.json').write_text(json.dumps(verdict))
    line = ['suggest', '.', '--model', 'drive.yaml', '--max-torque', '4']
    assert main([*line, '--out', 'motion.yaml', '--csv', 'motion.csv', '--json', '-']) == 0
    best = json.loads(capsys.readouterr()[0])[0]
    plant = yaml.safe_load((tmp_path / 'motion.yaml').read_text())['plant']['ros__parameters']
    assert plant == best['excitation'] and best['least'] > THRESHOLDS.isolable
    t, u = np.loadtxt('motion.csv', delimiter=',', skiprows=1).T
    again = Excitation(plant['excitation'], plant['amplitudes'], plant['frequencies'],
                       plant['period'])
    np.testing.assert_allclose(u, again.torque(t), atol=1e-7)
    for words, part in ((['--max-torque', '0'], '--max-torque: 0'),
                        (['--max-travel', '1e-9'], '--max-travel'),
                        (['--seconds', '1'], '--seconds: 1')):
        assert main([*line, *words]) == 2
        assert part in capsys.readouterr()[1]
    (tmp_path / 'verdict.json').write_text('{}')
    assert main(line) == 2
    assert 'verdict.json: no verdict' in capsys.readouterr()[1]
