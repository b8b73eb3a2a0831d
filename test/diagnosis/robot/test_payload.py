# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot holds and who pushes it: a six-axis arm whose torques follow from its equations."""
import csv
import json

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from gearbox_monitor import load_robot, track_payload
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import config_path
from gearbox_monitor.library.robot import payload_tracker
from gearbox_monitor.robot.chain import inertial

MASS, CENTRE = 2.0, np.array([0.01, -0.03, 0.08])
TAKEN, PUSHED, END = 8.0, 13.0, 16.0  # s
PUSH = np.array([0.0, 15.0, 0.0, 0.0, 3.0, 0.0])
STEP = 0.01


def torques(chain, t, q, thetas):
    """Return what the joints need to move as q [N, J] with inertial parameters [J, 10]."""
    curve = CubicSpline(t, q)
    momentum, load = np.zeros_like(q), np.zeros_like(q)
    for r in chain.regressors(q, curve(t, 1)):
        momentum[:, r.joint] += r.p @ thetas[r.link]
        load[:, r.joint] += (r.g - r.k) @ thetas[r.link]
    return CubicSpline(t, momentum)(t, 1) + load


def moved(t):
    """Return positions [N, 6] of an arm whose joints all move and reverse."""
    rng = np.random.default_rng(4)
    f, phase = rng.uniform(0.15, 0.6, (6, 2)), rng.uniform(0.0, 6.28, (6, 2))
    return sum((0.35 / (k + 1) * np.sin(2 * np.pi * f[:, k] * t[:, None] + phase[:, k])
                for k in range(2)), np.array([0.0, -0.6, 0.8, 0.2, 0.5, 0.0]))


@pytest.fixture(scope='module')
def arm():
    return load_robot(config_path('arm6.urdf'))


@pytest.fixture(scope='module')
def log(arm):
    """Return (stamps ns, positions, efforts): a load is taken at TAKEN, a push comes later."""
    chain, t = arm.file.chain, np.arange(0.0, END, STEP)
    q, carries = moved(t), chain.theta.copy()
    carries[-1] = carries[-1] + inertial(MASS, CENTRE, np.zeros((3, 3)))
    u = np.where((t < TAKEN)[:, None], torques(chain, t, q, chain.theta),
                 torques(chain, t, q, carries))
    u -= np.where((t >= PUSHED) & (t < PUSHED + 1.0), 1.0, 0.0)[:, None] * PUSH
    rng = np.random.default_rng(5)
    return (np.round(t * 1e9).astype(np.int64), q + rng.normal(0.0, 2e-5, q.shape),
            u + rng.normal(0.0, 0.2, u.shape))


def tracked(arm, stamps, q, u, **options):
    tracker = payload_tracker(arm, **options)
    return [e for stamp, x, y in zip(stamps.tolist(), q, u) for e in tracker.take(stamp, x, y)]


@pytest.fixture(scope='module')
def estimates(arm, log):
    return tracked(arm, *log)


def at(estimates, seconds):
    return min(estimates, key=lambda e: abs(e.stamp_ns - seconds * 1e9))


def test_a_load_that_is_taken_is_measured_and_dated(estimates):
    before, after = at(estimates, TAKEN - 0.5), at(estimates, PUSHED - 0.5)
    assert abs(before.mass) < 3.0 * before.mass_std and before.since_ns == 0
    assert after.mass_std < 0.2 and abs(after.mass - MASS) < 2.0 * after.mass_std
    assert np.all(np.abs(after.centre - CENTRE) < 3.0 * after.centre_std)
    assert np.all(after.centre_std < 0.02)
    assert abs(after.since_ns * 1e-9 - TAKEN) < 0.5


def test_a_push_is_external_torque_of_the_joints_that_it_turns_and_no_load(estimates):
    during = [e for e in estimates if PUSHED + 0.2 < e.stamp_ns * 1e-9 < PUSHED + 0.8]
    push = np.mean([e.external for e in during], axis=0)
    std = np.median([e.external_std for e in during], axis=0)
    assert np.all(np.abs(push - PUSH) < 3.0 * std) and push[1] > 10.0 * std[1]
    last = estimates[-1]
    assert abs(last.mass - MASS) < 3.0 * last.mass_std
    assert np.all(np.abs(last.external) < 4.0 * last.external_std)


def test_the_stated_deviations_hold(estimates):
    quiet = [e for e in estimates if not TAKEN - 0.5 < e.stamp_ns * 1e-9 < TAKEN + 1.5
             and not PUSHED - 0.2 < e.stamp_ns * 1e-9 < PUSHED + 1.2]
    z = np.array([e.external / e.external_std for e in quiet])
    assert 0.3 < np.sqrt(np.mean(z ** 2)) < 1.2


def test_after_tare_a_load_is_what_is_held_beyond_the_state_of_that_time(arm, log, estimates):
    tracker, out = payload_tracker(arm), []
    for stamp, x, y in zip(log[0].tolist(), *log[1:]):
        if stamp == 6_000_000_000:
            tracker.tare()
        out += tracker.take(stamp, x, y)
    empty, loaded = at(out, 6.4), at(out, PUSHED - 0.5)
    assert abs(empty.mass) < 3.0 * empty.mass_std
    assert empty.mass_std < 0.7 * at(estimates, 6.4).mass_std
    assert abs(loaded.mass - MASS) < 3.0 * loaded.mass_std


def test_stamps_count_from_the_first_and_late_or_broken_samples_change_nothing(arm, log):
    stamps, q, u = (x[:500] for x in log)
    whole = tracked(arm, stamps, q, u)
    late = np.r_[0:300, 295, 300:400, 400:500]
    broken = u[late].copy()
    broken[300, 3] = np.nan
    shifted = tracked(arm, stamps[late] + 1_700_000_000_000_000_123, q[late], broken)
    assert len(whole) == len(shifted) > 20
    for one, two in zip(whole, shifted):
        assert one.stamp_ns + 1_700_000_000_000_000_123 == two.stamp_ns
        assert one.mass == two.mass and (one.external == two.external).all()


def test_after_the_clock_was_set_back_nothing_is_known_of_the_load(arm, log):
    """Also where it began empty: meanwhile it may have taken one."""
    stamps, q, u = (x[int(TAKEN / STEP):int(TAKEN / STEP) + 400] for x in log)
    tracker = payload_tracker(arm, empty=True)
    for k in range(300):
        tracker.take(10 ** 12 + 10_000_000 * k, log[1][k], log[2][k])
    out = [e for stamp, x, y in zip(stamps.tolist(), q, u) for e in tracker.take(stamp, x, y)]
    assert abs(out[-1].mass - MASS) < 3.0 * out[-1].mass_std < 1.5


def test_after_a_gap_it_goes_on_with_what_it_knows(arm, log, estimates):
    stamps, q, u = log
    keep = np.r_[0:int(11.0 / STEP), int(11.6 / STEP):int(12.4 / STEP)]
    out = tracked(arm, stamps[keep], q[keep], u[keep])
    assert not [e for e in out if 10.8 < e.stamp_ns * 1e-9 < 11.8]
    first = next(e for e in out if e.stamp_ns * 1e-9 >= 11.8)
    assert abs(first.mass - MASS) < 2.0 * first.mass_std < 0.4


def test_at_rest_friction_may_be_anything_up_to_coulombs(arm, log):
    """What only leans on resting joints is not known better than their friction is."""
    stamps, q, u = (x[:800] for x in log)
    moves = np.minimum(np.arange(800), 300)
    rest = tracked(arm, stamps, q[moves], u[moves])
    assert rest[-1].mass_std > 0.9 * at(rest, 3.3).mass_std
    assert tracked(arm, stamps, q[np.zeros(800, int)], u[np.zeros(800, int)]) == []


def test_replay_of_a_robot_says_what_it_held_and_writes_a_table(tmp_path, arm, log, capsys):
    stamps, q, u = log
    path, table = tmp_path / 'log.csv', tmp_path / 'held.csv'
    names = ['t', *(f'q_{j}' for j in arm.joints), *(f'tau_{j}' for j in arm.joints)]
    np.savetxt(path, np.column_stack([stamps * 1e-9, q, u]), '%.17g', ',',
               header=','.join(names), comments='')
    assert main(['replay', str(path), '--model', str(config_path('arm6.urdf')), '--csv',
                 str(table), '--json']) == 0
    data = json.loads(capsys.readouterr()[0])
    assert ' kg held at ' in data['summary'] and 'since 8.' in data['summary']
    assert 'largest external torque' in data['summary'] and 'N m at joint2' in data['summary']
    with open(table, newline='', encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    track = track_payload(path, arm)
    assert [float(row['mass']) for row in rows] == track.mass.tolist()
    assert data['summary'] == str(track) and data['last']['mass'] == track.mass[-1]


WRONG_OPTIONS = [
    (['--filter', 'ekf'], '--filter: of the estimator of a drive'),
    (['--link', 'flang'], "link: did you mean 'flange'?"),
    (['--out', 'bag'], 'expected FILE.csv')]


def test_wrong_options_of_a_robot_are_one_line(tmp_path, arm, capsys):
    for options, words in WRONG_OPTIONS:
        path = tmp_path / 'log.csv'
        names = ['t', *(f'{x}_{j}' for x in ('q', 'tau') for j in arm.joints)]
        rest = ',0' * (len(names) - 1)
        path.write_text(','.join(names) + '\n' + ''.join(
            f'{0.01 * k:.2f}{rest}\n' for k in range(500)))
        assert main(['replay', str(path), '--model', str(config_path('arm6.urdf')), *options]) == 2
        error = capsys.readouterr().err
        assert words in error and len(error.splitlines()) == 1


def test_a_log_too_short_for_an_estimate_is_refused(tmp_path, arm, log):
    stamps, q, u = (x[:100] for x in log)
    path = tmp_path / 'short.csv'
    names = ['t', *(f'q_{j}' for j in arm.joints), *(f'tau_{j}' for j in arm.joints)]
    np.savetxt(path, np.column_stack([stamps * 1e-9, q, u]), '%.17g', ',',
               header=','.join(names), comments='')
    with pytest.raises(InputError, match='0.99 s in 1 parts, expected one part'):
        track_payload(path, arm)
