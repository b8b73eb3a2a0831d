# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The verdict as JSON: keys of the last release stay, findings and remainder say what is known."""
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from test_decision import record

from gearbox_monitor.diagnosis.hypothesis import Finding, kind_of, KINDS
from gearbox_monitor.diagnosis.joint import verdict as verdicts
from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.diagnosis.joint.windows import _gaps
from gearbox_monitor.plant.drive import DriveModel

GOLDEN = json.loads((Path(__file__).parent / 'verdict_keys.json').read_text(encoding='utf-8'))
CASES = {'none': ([], ['torque_gain', 'torque_map']),
         'effect': ([{'id': 'torque_gain', 'g': 0.08}], ['torque_gain', 'gravity']),
         'unknown': ([{'id': 'stribeck', 'Cs': 0.15, 'vs': 0.5}], ['gravity'])}


def kind(value):
    """Return the kind of a JSON value."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return 'number'
    return 'null' if value is None else type(value).__name__


@pytest.mark.parametrize('name', CASES)
def test_keys_of_the_last_release_stay(name):
    effects, only = CASES[name]
    verdict = diagnose([record(effects, 2)], DriveModel(), only=only,
                       validate=record(effects, 2, 7) if name == 'effect' else None)
    data = json.loads(json.dumps(verdict.to_dict(), allow_nan=False))
    assert data['verdict'] == verdict.kind == name and verdict.data == verdict.to_dict()
    for path, expected in GOLDEN[name].items():
        value = data
        for part in path.split('.'):
            value = value[0] if isinstance(value, list) else value
            assert part in value, path
            value = value[part]
        assert kind(value) in (expected, 'null') or expected == 'null', path
    assert [f['effect'] for f in data['findings']] == (
        data['effect'].split('+') if data['effect'] else [])
    assert (data['remainders'] == []) == (name in ('none', 'effect'))


def test_a_verdict_cannot_be_changed():
    verdict = diagnose([record([], 2)], DriveModel(), only=['torque_gain'])
    with pytest.raises(AttributeError):
        verdict.verdict = 'effect'
    finding = Finding('torque_gain', 'actuator', {'g': 0.1}, {'g': None}, 100.0)
    with pytest.raises(TypeError):
        finding.values['g'] = 0.2
    assert finding.undetermined == ('g',)


VERDICTS = [
    (False, False, 'none'), (True, False, 'effect'), (True, True, 'incomplete'),
    (False, True, 'unknown')]


def test_the_kind_follows_from_findings_and_remainder():
    for findings, remainder, expected in VERDICTS:
        assert kind_of(findings, remainder) == expected and expected in KINDS


def test_a_slip_with_a_small_share_is_no_idle_law(monkeypatch):
    """No fit has it among its laws, from which it could be taken."""
    fit = SimpleNamespace(candidate=SimpleNamespace(ids=('stiffness',)))
    decision = SimpleNamespace(remains=True, fit=fit)
    monkeypatch.setattr(verdicts, 'explained_shares', lambda decision: {
        'stiffness': ('motor', 0.9), 'slip': ('motor', 1e-3)})
    assert verdicts.without_idle_laws(decision) is decision


def test_windows_of_several_recordings_differ_in_length():
    """Rates within a per cent are one rate: 1 s is 1000 rows of one recording, 990 of another."""
    def run(rows, residual):
        return SimpleNamespace(
            recording=SimpleNamespace(readings=('motor', 'arm')),
            residual=np.full((3, rows, 1), residual),
            data=SimpleNamespace(channels=(1,)))
    figures = _gaps([run(1000, 3.0), run(990, 3.0)], [run(1000, 1.0), run(990, 1.0)])
    assert figures == [{'reading': 'arm', 'before': 3.0, 'after': 1.0, 'closed': 1.0}]
