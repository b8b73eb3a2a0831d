# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What changed between two recordings: planted pairs of a drive of its own."""
from dataclasses import replace
import math

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.diagnose import diagnose_change
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import Controller, DriveModel
from gearbox_monitor.signals.examine import admitted

FILE = DriveModel()
DT, SECONDS, SUBSTEPS = 4e-3, 4.2, 32


def drive(seed, gap=0.1, friction=1.0, stiffness=25.0, noise=0.002, seconds=SECONDS):
    """Return a recording of the paper's drive, integrated by semi-implicit Euler."""
    random = np.random.default_rng(seed)
    t = np.arange(round(seconds / DT)) * DT
    u = sum(a * np.sin(2.0 * math.pi * f * t + random.uniform(0.0, 6.0))
            for a, f in ((4.0, 0.5), (2.0, 1.3), (1.0, 3.1)))
    y, (x1, x2, v1, v2), h = np.empty((len(t), 2)), (0.0,) * 4, DT / SUBSTEPS
    for k, torque in enumerate(u.tolist()):
        y[k] = x1, x2
        for _ in range(SUBSTEPS):
            twist = x1 - x2
            load = stiffness * (twist - min(max(twist, -gap), gap)) + 0.01 * (v1 - v2)
            drag = friction * (0.1 * v1 + 0.27 * 2.0 / math.pi * math.atan(100.0 * v1))
            v1 += h / 0.006442 * (torque - 0.01 * x1 - drag - load)
            v2 += h / 0.023454 * load
            x1, x2 = x1 + h * v1, x2 + h * v2
    y += noise * random.standard_normal(y.shape)
    return admitted(t, u, y, None, f'run {seed}', FILE, 'drive.yaml')[0]


@pytest.fixture(scope='module')
def healthy():
    return drive(1)


@pytest.mark.parametrize(('values', 'changed'), [
    ({'gap': 0.12}, {'b': 0.2}),
    pytest.param({'friction': 1.5}, {'Cv': 0.5, 'Cc': 0.5}, marks=pytest.mark.system),
    pytest.param({'stiffness': 21.25}, {'K': -0.15}, marks=pytest.mark.system),
    ({}, {})])
def test_what_was_planted_is_named(healthy, values, changed):
    verdict = diagnose_change(healthy, drive(2, **values), FILE)
    rows = {v.name: v for f in verdict.findings for v in f.values}
    assert set(rows) == set(changed)
    for name, size in changed.items():
        relative, std = rows[name].relative, rows[name].relative_std
        assert relative == pytest.approx(size, abs=0.01) and std < 0.02
        assert rows[name].before == {'b': 0.1, 'K': 25.0, 'Cv': 0.1, 'Cc': 0.27}[name]
    assert verdict.verdict == ('effect' if changed else 'none')
    assert verdict.held and verdict.holds is not bool(changed)
    assert verdict.to_dict()['model_holds'] is verdict.holds


@pytest.mark.system
def test_a_slip_over_which_a_check_counted_on_is_named():
    earlier, later = (drive(seed, seconds=8.0) for seed in (1, 2))
    finding, = diagnose_change(earlier, replace(later, slip=(3.9, 0.3)), FILE).findings
    assert finding.effect == 'slip' and finding.values[0].now == pytest.approx(0.3, abs=0.002)


@pytest.mark.system
def test_an_error_of_the_model_file_is_no_change(healthy):
    """The file is wrong in one value all along: the change is of another one, from its own."""
    wrong = FILE.with_values({'stiffness': 21.0})
    verdict = diagnose_change(healthy, drive(3, gap=0.12), wrong)
    (finding,) = verdict.findings
    (value,) = finding.values
    assert (finding.effect, finding.place) == ('backlash_gap', 'transmission')
    assert value.relative == pytest.approx(0.2, abs=0.01)
    assert verdict.effects_before == ('stiffness',)
    assert not verdict.held and not verdict.holds
    same = diagnose_change(healthy, drive(4), wrong)
    assert (same.verdict, same.findings, same.held, same.holds) == ('none', (), False, False)


@pytest.mark.system
def test_a_change_of_the_value_that_was_wrong_counts_from_the_drive(healthy):
    wrong = FILE.with_values({'stiffness': 21.0})
    verdict = diagnose_change(healthy, drive(5, stiffness=21.0), wrong)
    (finding,) = verdict.findings
    assert finding.effect == 'stiffness'
    assert finding.values[0].relative == pytest.approx(-0.16, abs=0.01)


def test_a_drive_without_recorded_torque_is_refused(healthy):
    with pytest.raises(InputError, match='expected a drive whose torque is recorded'):
        diagnose_change(healthy, healthy, replace(FILE, controller=Controller()))
