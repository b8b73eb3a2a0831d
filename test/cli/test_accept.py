# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Acceptance of a gearbox from a bag, through the command line."""
import json

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.cli.replay import judge, limit_of
from gearbox_monitor.errors import InputError
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.write import BagWriter

NOISE = Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3))


def write(path, model, scale=1.0, seconds=14.0):
    t = 1e-3 * np.arange(round(seconds * 1e3))
    out = simulate(model, scale * Excitation().torque(t), 1e-3, NOISE, seed=2)
    return _written(path, t, out.y, np.column_stack([out.u, np.full(len(t), np.nan)]))


def _written(path, t, y, effort):
    stamps = 1_700_000_000_000_000_000 + np.round(t * 1e9).astype(np.int64)
    messages = encode_joint_states(stamps, ['motor', 'arm'], y, effort=effort)
    with BagWriter(path) as writer:
        writer.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for stamp, message in zip(stamps, messages):
            writer.write('/joint_states', int(stamp), message)
    return str(path)


@pytest.mark.parametrize('seconds, slip, scale, limit, code, words', [
    (52.0, 0.15, 1.0, '0.22', 1, 'Fail: slip of 0.150'),
    (32.0, 0.15, 1.0, '0.22', 3, 'Undecided: motor and arm slipped by 0.150'),
    (32.0, 0.0, 1.02, '0.3', 3, 'Undecided: encoders disagree: check gear_ratio, scale')])
def test_no_gearbox_passes_with_a_slip_or_contradiction(
        tmp_path, capsys, seconds, slip, scale, limit, code, words):
    """Its backlash is within the limit before and after; one window after it is not sure."""
    t = 2e-3 * np.arange(round(seconds * 500))
    out = simulate(DriveModel(), Excitation().torque(t), 2e-3, NOISE, seed=2)
    y = out.y * [1.0, scale]
    y[:, 0] += slip * np.clip((t - 14.0) / 0.08, 0.0, 1.0)
    bag = _written(tmp_path / 'bag', t, y, np.column_stack([out.u, np.full(len(t), np.nan)]))
    assert main(['accept', bag, '--max-gap', limit]) == code
    assert ' '.join(capsys.readouterr().out.split()).startswith(words)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp('accept') / 'bag', DriveModel())


SHOWN = {'': '0.002 rad', 'deg': '0.12 deg', 'arcmin': '7 arcmin'}  # the deviation of the backlash


@pytest.mark.parametrize('limits, code, verdict', [
    (['--max-gap', '12.6deg', '--min-stiffness', '20'], 0, 'pass'),
    (['--max-gap', '600arcmin'], 1, 'fail'),
    (['--max-gap', '0.22', '--min-stiffness', '35'], 1, 'fail')])
def test_verdicts(bag, capsys, limits, code, verdict):
    assert main(['accept', bag, *limits]) == code
    shown = capsys.readouterr().out
    assert shown.startswith(verdict.capitalize())
    unit = limits[1].lstrip('0.123456789') if limits[0] == '--max-gap' else ''
    assert f'± {SHOWN[unit]}' in shown
    assert main(['accept', bag, *limits, '--json']) == code
    told = json.loads(capsys.readouterr().out)
    assert told['verdict'] == verdict
    assert told['gap_rad'] == pytest.approx(0.2, rel=0.025)
    assert told['gap_arcmin'] == pytest.approx(0.2 * 10800 / np.pi, rel=0.025)
    assert told['stiffness'] == pytest.approx(25.0, rel=0.1)


def test_motor_encoder_alone(bag, tmp_path, capsys):
    """No loop is seen behind a hidden arm."""
    params = tmp_path / 'one.yaml'
    params.write_text("estimator: {ros__parameters: {arm_joint: ''}}")
    assert main(['accept', bag, '--params', str(params), '--max-gap', '0.22', '--json']) == 0
    data = json.loads(capsys.readouterr().out)
    assert 'hysteresis' not in data and data['gap_rad'] == pytest.approx(0.2, rel=0.05)


def test_not_excited(tmp_path, capsys):
    still = write(tmp_path / 'still', DriveModel(), scale=0.0, seconds=6.0)
    assert main(['accept', still, '--max-gap', '1.0', '--json']) == 3
    told = json.loads(capsys.readouterr().out)
    assert told['verdict'] == 'not excited' and 'stands still' in told['reason']


BAD_OPTIONS = [
    (['--max-gap', '-1'], '--max-gap'), (['--max-gap', '3 inches'], '--max-gap'),
    (['--max-gap', 'nan'], '--max-gap'), ([], 'no limit'),
    (['--max-gap', '1', '--confidence', '1'], '--confidence'),
    (['--min-stiffness', 'inf'], '--min-stiffness')]


def test_bad_options(bag, capsys):
    for options, word in BAD_OPTIONS:
        assert main(['accept', bag, *options]) == 2
        error = capsys.readouterr().err
        assert word in error and error.count('\n') == 1


def test_a_limit_has_the_unit_of_its_axis():
    assert limit_of('60 arcmin') == ('arcmin', pytest.approx(np.radians(1.0)))
    assert limit_of('2e-3') == ('', 0.002)
    assert limit_of('210mm') == ('mm', pytest.approx(0.21))
    assert limit_of('50um') == ('um', pytest.approx(5e-5))
    with pytest.raises(InputError):
        limit_of('1e')


def test_an_angle_is_no_limit_of_a_prismatic_axis(bag, tmp_path, capsys):
    (tmp_path / 'axis.yaml').write_text('axis: prismatic')
    assert main(['accept', bag, '--model', str(tmp_path / 'axis.yaml'), '--max-gap', '220mm']) == 0
    assert '220 mm' in capsys.readouterr().out
    for axis, limit in (('axis.yaml', '12.6deg'), (None, '220mm')):
        model = ['--model', str(tmp_path / axis)] if axis else []
        assert main(['accept', bag, *model, '--max-gap', limit]) == 2
        assert limit in capsys.readouterr().err


@pytest.mark.parametrize('by_arm', [True, False])
def test_a_locked_input_gives_backlash_and_stiffness(tmp_path, capsys, by_arm):
    """A lost-motion test: the torque on the output, or that which holds the input, is measured."""
    gap, stiffness, noise, rng = 0.03, 400.0, 3e-5, np.random.default_rng(1)
    t = np.arange(0.0, 40.0, 2e-3)
    torque = 12.0 * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * t / 8.0))
    twist = torque / stiffness + np.tanh(torque / 0.2) * gap / 2.0
    friction = 0.3 * np.sign(np.gradient(torque))
    y = np.column_stack([np.full(len(t), 0.4), 0.4 - twist]) + rng.normal(0.0, noise, (len(t), 2))
    measured = torque + friction + rng.normal(0.0, 0.02, len(t))
    effort = np.column_stack([np.zeros(len(t)), -measured] if by_arm else
                             [measured, np.full(len(t), np.nan)])
    path = _written(tmp_path / 'bag', t, y, effort)
    assert main(['accept', path, '--max-gap', '0.033', '--min-stiffness', '360',
                 '--json']) == 0
    data = json.loads(capsys.readouterr().out)
    assert data['gap_rad'] == pytest.approx(gap, rel=0.03)
    assert data['stiffness'] == pytest.approx(stiffness, rel=0.05)
    assert main(['accept', path, '--max-gap', '0.027']) == 1
    capsys.readouterr()
    silent = _written(tmp_path / 'silent', t, y, np.full((len(t), 2), np.nan))
    assert main(['accept', silent, '--max-gap', '0.033']) == 3
    assert 'the input stands still' in capsys.readouterr().out


def window(gap, separable=True, **more):
    return Backlash(0, gap, 0.002, 5.0, 0.05, 0.0, 0.01, coverage=10.0, separable=separable,
                    **more)


def test_a_close_call_is_no_verdict():
    limits = {'max_gap': 1.0, 'min_stiffness': None}
    assert judge([window(1.0)] * 3, limits, 0.95)['verdict'] == 'undecided'
    assert judge([window(0.9)] * 3, limits, 0.95)['verdict'] == 'pass'
    assert judge([window(1.1), NotExcited(0, 'x')], limits, 0.95)['verdict'] == 'fail'
    # Not separable: the lost motion bounds the gap, so it can pass but not fail.
    for lost, verdict in ((0.9, 'pass'), (1.1, 'not excited')):
        found = judge([window(0.5, False, lost_motion=lost, lost_motion_std=0.001)], limits, 0.95)
        assert found['verdict'] == verdict and 'distinguish' in found['reason']
    stiff = {'max_gap': None, 'min_stiffness': 4.0}
    assert judge([window(0.5, False)], stiff, 0.95)['verdict'] == 'not excited'
    assert judge([window(0.5)], stiff, 0.95)['verdict'] == 'pass'
