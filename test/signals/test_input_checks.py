# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recordings for the diagnosis: what is repaired, what is refused, in which words."""
from dataclasses import replace
from pathlib import Path
import re

import numpy as np
import pytest
from scipy.signal import lfilter

from gearbox_monitor.diagnosis.joint.innovations import noise_floor
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path, load_model
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.recordings.reading import read_mapping, ReadOptions
from gearbox_monitor.recordings.si_signals import signals_of
from gearbox_monitor.signals.examine import admitted, check, READ_OTHERWISE
from gearbox_monitor.signals.uniform import (
    at_one_rate, prepare, RecordingKind, UniformRecording, usable_rows)

DATA = Path(__file__).resolve().parents[3] / 'shared' / 'data' / 'davinci_backend'
MODEL = DriveModel()
SIGMA = np.array([0.004, 0.003])
EFFECTS = {
    'none': (), 'gravity': ({'id': 'gravity', 'G': 3.0},),
    'arm_coulomb': ({'id': 'arm_coulomb', 'Cac': 0.5},),
    'load_torque': ({'id': 'load_torque', 'TL': 0.5},)}
MOTIONS = {
    'multisine': Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1)),
    'chirp': Excitation('chirp', (4.0,), (0.3, 8.0), 12.0),
    'square': Excitation('square', (2.0,), (0.7,)),
    'slow': Excitation('triangle', (1.5,), (0.3,))}


def record(motion='multisine', effects=(), rate=500.0, duration=10.0, model=MODEL, seed=1):
    """Return (t, u, y) of a simulated drive with white noise."""
    t = np.arange(int(duration * rate)) / rate
    u = MOTIONS[motion].torque(t)
    x = simulate(replace(model, effects=effects), u, 1 / rate).x[:, :2]
    return t, u, x + SIGMA * np.random.default_rng(seed).standard_normal(x.shape)


def found(t, u, y, model=MODEL):
    recording, _ = prepare(t, u, y)
    return check(recording, model)


def decides(problem):
    """Return whether a problem refuses a recording, or reads it otherwise."""
    return problem.fatal or problem.fault in (*READ_OTHERWISE, 'implausible')


def fatal(t, u, y, model=MODEL):
    """Return (code, text) of the only problem that decides."""
    problems = [p for p in found(t, u, y, model) if decides(p)]
    assert len(problems) == 1, problems
    return problems[0].fault, problems[0].text


@pytest.fixture(scope='module')
def sound():
    return record(rate=1000.0)


# --- sound recordings ---------------------------------------------------------------------------
def test_sound_recordings_raise_nothing():
    for motion in MOTIONS:
        for effect in EFFECTS:
            t, u, y = record(motion, EFFECTS[effect])
            recording, notices = prepare(t, u, y)
            assert not notices
            assert not [p for p in check(recording, MODEL) if decides(p)]


def test_other_rates():
    for rate in (200.0, 1000.0, 4000.0):
        t, u, y = record(rate=rate)
        recording, _ = prepare(t, u, y)
        assert recording.dt == pytest.approx(1 / rate)
        assert not check(recording, MODEL)


OTHER_DRIVES = [
    {'arm_inertia': 0.035}, {'motor_inertia': 0.0097}, {'coulomb_friction': 0.5},
    {'torque_offset': 0.4},
    {'transmission': replace(MODEL.transmission, stiffness=40.0)},
    {'transmission': replace(MODEL.transmission, half_gap=0.2)}]


def test_a_drive_that_differs_from_the_model_is_no_bad_input():
    for change in OTHER_DRIVES:
        t, u, y = record(model=replace(MODEL, **change))
        for gain in (0.8, 1.0, 1.2):
            assert not found(t, u / gain, y)


def loaded(seed):
    """Return a model and a recording whose drive has gravity, offset or friction of any size."""
    random = np.random.default_rng(seed)
    size = np.exp(random.uniform(np.log(0.2), np.log(8.0), 3))
    model = replace(MODEL, motor_inertia=MODEL.motor_inertia * np.exp(random.normal(0, 0.5)),
                    arm_inertia=MODEL.arm_inertia * np.exp(random.normal(0, 0.5)))
    gravity, offset, friction = (bool(seed >> i & 1) for i in range(3))
    effects = [{'id': 'gravity', 'G': size[0]}] if gravity else []
    effects += [{'id': 'arm_coulomb', 'Cac': size[2]}] if friction else []
    true = replace(model, torque_offset=0.3 * size[1] * offset, effects=tuple(effects),
                   coulomb_friction=model.coulomb_friction + 0.3 * size[1] * friction)
    t = np.arange(4000) * 2e-3
    kind = ('multisine', 'chirp', 'square', 'slow')[seed % 4]
    u = (1.0 + size.max()) * MOTIONS[kind].torque(t)
    y = simulate(true, u, 2e-3).x[:, :2]
    return model, t, u, y + SIGMA * random.standard_normal(y.shape)


@pytest.mark.parametrize('seeds', [range(8), pytest.param(range(8, 200),
                                                          marks=pytest.mark.system)])
def test_loads_of_any_size_are_no_wrong_wiring(seeds):
    for seed in seeds:
        model, t, u, y = loaded(seed)
        assert not [p for p in found(t, u, y, model) if decides(p)], seed


@pytest.mark.parametrize('seeds', [range(8), pytest.param(range(8, 200), marks=(
    pytest.mark.system, pytest.mark.xfail(reason='one of 192 is called a unit', strict=True)))])
def test_swapped_encoders_of_a_loaded_drive_are_named(seeds):
    """But in slow motion against friction, where the torque is the same on both sides."""
    named = []
    for seed in seeds:
        model, t, u, y = loaded(seed)
        codes = {p.fault for p in found(t, u, y[:, ::-1], model) if decides(p)}
        assert codes <= {'swapped'}, seed
        named.append(bool(codes))
    assert np.mean(named) > 0.8, named


def test_encoders_that_share_no_zero(sound):
    t, u, y = sound
    assert not found(t, u, y + [0.0, 2.0])


def test_coarse_encoder_and_dwell_are_neither_frozen_nor_clipped():
    t = np.arange(10000) * 1e-3
    u = np.where(np.mod(t, 3.0) < 1.5, MOTIONS['slow'].torque(t), 0.0)
    y = simulate(MODEL, u, 1e-3).x[:, :2]
    y = 0.002 * np.rint(y / 0.002)
    assert not [p for p in found(t, u, y) if decides(p)]


@pytest.mark.skipif(not DATA.is_dir(), reason='needs ../shared/data/davinci_backend')
def test_a_real_drive_with_coarse_encoder_stiction_and_unknown_load():
    for run in ('00', '12', '43'):
        raw = signals_of(*read_mapping(
            DATA / f'{run}.TXT.gz', ReadOptions('davinci_backend'))[:2])
        model = load_model(config_path('davinci_backend.yaml'))
        y = np.column_stack([raw['motor_position'], raw['arm_position']])
        assert not found(raw.stamp_ns, raw['motor_effort'], y, model)
    # The last one, wired otherwise.
    assert fatal(raw.stamp_ns, -raw['motor_effort'], y, model)[0] == 'sign'
    assert fatal(raw.stamp_ns, raw['motor_effort'], y * [1, 180 / np.pi], model)[0] == 'units'


# --- channels, signs, units ---------------------------------------------------------------------
WIRED = [
    (1, (1, -1), 'sign', 'sign of the arm position is wrong'),
    (1, (-1, 1), 'sign', 'sign of the motor position is wrong'),
    (-1, (1, 1), 'sign', 'sign of the torque u is wrong'),
    (1, (180 / np.pi, 180 / np.pi), 'units', 'both positions are.*in degrees'),
    (1, (1, 180 / np.pi), 'units', 'the arm position is.*in degrees'),
    (1, (180 / np.pi, 1), 'units', 'the motor position is.*in degrees'),
    (1000, (1, 1), 'units', 'the torque u is.*in mN m'),
    (1 / 50, (50, 1), 'units', 'motor side of a gear of [45]')]


def test_signs_and_units_are_named():
    for motion, wired in (('multisine', WIRED), ('chirp', WIRED[::3]), ('square', WIRED[1::3])):
        t, u, y = record(motion)
        for torque, scale, code, text in wired:
            problem = fatal(t, u * torque, y * scale)
            assert problem[0] == code
            assert re.search(text, problem[1]), problem[1]


def test_swapped_channels_are_named():
    for motion in ('multisine', 'chirp', 'square'):
        t, u, y = record(motion, rate=1000.0)
        code, text = fatal(t, u, y[:, ::-1])
        assert code == 'swapped' and 'motor and arm positions are swapped' in text


def test_swapped_channels_are_named_where_smoothing_hides_how_well_the_other_way_fits():
    """So noisy, with so wide a gap that positions are smoothed over a good part of a swing."""
    model = DriveModel(
        motor_inertia=0.006041, arm_inertia=0.03086, damping=0.008718, viscous_friction=0.1137,
        coulomb_friction=0.2796, position_gain=0.01627,
        transmission=Transmission('dead_zone', stiffness=53.47, half_gap=0.2636))
    t = np.arange(10_000) / 1000
    u = 3.0 * MOTIONS['chirp'].torque(t)
    harder = replace(model, effects=({'id': 'hardening', 'K3': 3287.0},))
    y = simulate(harder, u, 1e-3).x[:, :2]
    y += 0.04 * np.random.default_rng(1).standard_normal(y.shape)
    assert fatal(t, u, y[:, ::-1], model)[0] == 'swapped'
    assert not [p for p in found(t, u, y, model) if decides(p)]


def test_gear_ratio_of_the_model_file_is_recognised(sound):
    t, u, y = sound
    code, text = fatal(t, u, y * [35.0, 1.0], replace(MODEL, gear_ratio=35.0))
    assert code == 'units' and 'the gear ratio is applied twice or on the wrong side' in text


@pytest.mark.parametrize('motion', [
    pytest.param('square', marks=pytest.mark.system), 'multisine'])
def test_noise_that_lasts_is_no_wrong_model(motion):
    t, u, y = record(motion)
    noise = np.random.default_rng(2).standard_normal(y.shape)
    noise = lfilter([1.0], [1.0, -0.9], noise, axis=0) * 0.02
    assert not [p for p in found(t, u, y + noise) if decides(p)]
    assert fatal(t, u, (y + noise) * [1.0, -1.0])[0] == 'sign'


def test_unrelated_signals_get_a_word_and_no_wrong_name(sound):
    t, u, y = sound
    problems = found(t, u, y[::-1] * 3.7)
    assert any('leave unexplained' in p.text for p in problems)
    assert not {p.fault for p in problems} & {'sign', 'swapped', 'units'}


def test_a_doubt_is_another_reading_and_refuses_nothing(sound):
    """The diagnosis lets it compete: the recording as it is doubted is the sound one."""
    t, u, y = sound
    recording, notes = admitted(t, u, y * [1.0, -1.0], None, 'bench', MODEL, 'drive.yaml')
    assert not notes and 'sign of the arm position is wrong' in recording.doubt.text
    assert not check(recording.read_otherwise(recording.doubt), MODEL)


# --- each signal --------------------------------------------------------------------------------
def test_clipped_frozen(sound):
    t, u, y = sound
    low, high = np.quantile(y[:, 1], [0.1, 0.9])
    code, text = fatal(t, u, np.column_stack([y[:, 0], np.clip(y[:, 1], low, high)]))
    assert code == 'clipped' and 'position of the arm' in text
    stuck = y.copy()
    stuck[4000:6000, 0] = stuck[4000, 0]
    code, text = fatal(t, u, stuck)
    assert code == 'frozen' and 'the motor stays exactly the same for 2 s from t = 4 s' in text
    code, text = fatal(t, u, y * [0.0, 1.0])
    assert code == 'frozen' and 'position of the motor never changes' in text


def test_limited_torque_command_is_told(sound):
    t, u, _ = sound
    u = np.clip(u, -3.0, 3.0)
    y = simulate(MODEL, u, 1e-3, seed=3).x[:, :2] + SIGMA * np.random.default_rng(0).normal(
        size=(len(u), 2))
    problems = found(t, u, y)
    assert [p.fault for p in problems] == ['torque_limit'] and not problems[0].fatal
    assert '-3 and 3 N m' in problems[0].text


def test_missing_motion_is_named():
    rng = np.random.default_rng(5)
    t = np.arange(8000) * 1e-3
    noise = SIGMA * rng.standard_normal((len(t), 2))
    code, text = fatal(t, 0.1 * np.sin(t), noise)
    assert code == 'unexcited' and 'the motor travels' in text and '10 times' in text
    code, text = fatal(t, 0.0 * t, noise)  # nothing to tell units from
    assert code == 'unexcited' and 'the motor travels' in text
    u = 1.0 + 0.1 * np.sin(2 * np.pi * t)
    model = replace(MODEL, position_gain=0.0, effects=({'id': 'arm_viscous', 'Cav': 0.1},))
    y = simulate(model, u, 1e-3).x[:, :2] + noise
    late = slice(2000, None)  # without the start
    code, text = fatal(t[late], u[late], y[late], model)
    assert code == 'unexcited' and 'never reverses' in text
    u = np.where(t < 2.0, 2.0 * np.sin(2 * np.pi * t), 0.0)
    y = simulate(MODEL, u, 1e-3).x[:, :2] + noise
    code, text = fatal(t, u, y)
    assert code == 'unexcited' and 'moves in 3 of 8 s' in text


def test_length_and_rate(sound):
    t, u, y = sound
    assert fatal(t[:3000], u[:3000], y[:3000])[0] == 'too_short'
    assert [p.fault for p in found(t[:6000], u[:6000], y[:6000])] == ['short']
    assert fatal(t * 100, u, y)[0] == 'rate'
    assert 'is t in ms?' in fatal(t * 1000, u, y)[1]


# --- noise --------------------------------------------------------------------------------------
def test_noise_level_is_that_of_the_noise():
    for motion in MOTIONS:
        _, _, y = record(motion, duration=12.0)
        sigma, quantum = noise_levels(y)
        assert sigma == pytest.approx(SIGMA, rel=0.06)
        assert not quantum.any()


def test_lattice_is_found(sound):
    _, _, y = sound
    q = 2 * np.pi / 8192
    sigma, quantum = noise_levels(np.column_stack([q * np.rint(y[:, 0] / q) - 0.3, y[:, 1]]))
    assert quantum == pytest.approx([q, 0.0])
    assert sigma[0] == pytest.approx(np.hypot(SIGMA[0], q / np.sqrt(12)), rel=0.06)
    assert noise_levels(np.round(y, 6))[1] == pytest.approx([1e-6, 1e-6])


def test_noise_level_on_a_coarse_lattice(sound):
    """The error of a reading, though most fourth differences are of one size."""
    for steps in (1.0, 2.0, 3.3, 4.0, 6.0):
        _, _, y = sound
        q = steps * SIGMA[0]
        coarse = q * np.rint(y / q)
        error = np.hypot(SIGMA[0], q / np.sqrt(12.0))
        assert noise_levels(coarse)[0][0] == pytest.approx(error, rel=0.15)


# --- stamps and missing values ------------------------------------------------------------------
def test_stamps_that_jitter_on_their_way_are_taken_as_even(sound):
    t, u, y = sound
    late = t + np.random.default_rng(2).uniform(-0.3e-3, 0.3e-3, len(t))
    recording, notices = prepare(late, u, y)
    assert np.array_equal(recording.y, y) and recording.dt == pytest.approx(1e-3, rel=1e-5)
    assert len(notices) == 1 and 'taken as evenly spaced' in str(notices[0])


def test_readings_that_follow_their_stamps_are_interpolated():
    t = np.arange(10000) * 1e-3
    position = np.column_stack([np.sin(9 * t), np.cos(7 * t)])
    real = t + np.random.default_rng(2).uniform(-0.3e-3, 0.3e-3, len(t))
    real[0] = 0.0
    y = np.column_stack([np.sin(9 * real), np.cos(7 * real)])
    recording, notices = prepare(real, np.cos(t), y)
    assert 'are interpolated onto a uniform grid' in str(notices[0])
    assert np.abs(recording.y - position[:len(recording.y)])[5:-5].max() < 1e-4


def test_a_loop_without_a_clock_is_sampled_where_its_stamps_say():
    """Its sample time wanders by 3 %; most differences of its coarse readings are 0."""
    n, step = 1500, 2 * np.pi / 4096
    real = np.cumsum(5.3e-3 * (1.0 + 0.03 * np.sin(np.arange(n) / 60.0)))
    real -= real[0]
    coarse = step * np.rint(np.sin(3.0 * real) / step)
    kind = RecordingKind(True, 'rotary', True)
    y = np.column_stack([coarse * np.nan, coarse])
    recording, notices = prepare(real, np.sin(3.0 * real), y, kind=kind)
    assert 'the sample time wanders' in str(notices[0])
    off = recording.y[:, 1] - np.sin(3.0 * recording.t)
    assert np.sqrt(np.mean(off ** 2)) < step / 3.0
    # Interpolated readings look finer than they are.
    sigma, _ = noise_floor(recording, DriveModel())
    assert step / np.sqrt(12.0) <= sigma[1] < 0.5 * step


def test_a_loop_without_a_clock_is_late_and_loses_nothing():
    kind, late = RecordingKind(True, 'rotary', True), np.random.default_rng(3)
    step = 0.02 * late.uniform(0.99, 1.01, 300)
    step[late.choice(300, 12, replace=False)] *= late.uniform(1.55, 1.85, 12)
    real = np.cumsum(step) - step[0]
    y = np.column_stack([np.nan * real, np.sin(5.0 * real)])
    recording, notices = prepare(real, np.sin(5.0 * real), y, kind=kind)
    assert 'the sample time wanders' in str(notices[0]) and 'lost' not in str(notices[0])
    assert np.abs(recording.y[:, 1] - np.sin(5.0 * recording.t)).max() < 1e-3
    keep = np.ones(len(real), bool)
    keep[20::25] = False
    with pytest.raises(InputError, match=r'1[12] of \d+ samples lost by their stamps'):
        prepare(real[keep], real[keep], y[keep], kind=kind)


def test_a_loop_of_any_period_loses_nothing():
    real = np.cumsum(0.02 * np.random.default_rng(0).uniform(0.5, 1.5, 1000))
    y = np.column_stack([np.nan * real, np.sin(5.0 * real)])
    recording, notices = prepare(real, real, y, kind=RecordingKind(True, 'rotary', True))
    assert 'the sample time wanders' in str(notices[0])
    assert 'lost' not in ' '.join(map(str, notices))
    assert np.abs(recording.y[:, 1] - np.sin(5.0 * (recording.t + real[0]))).max() < 1e-3


def test_recordings_of_nearly_one_rate_are_brought_to_the_lower():
    t = np.arange(1200) * 5e-3
    fine = UniformRecording(t, np.cos(t), np.column_stack([np.sin(3 * t)] * 2), 5e-3)
    slow = replace(fine, t=t * 1.05, dt=5.25e-3, y=np.column_stack([np.sin(3 * t * 1.05)] * 2))
    moved, kept = at_one_rate([fine, slow])
    assert kept is slow and moved.dt == slow.dt and moved.t[-1] <= t[-1]
    assert np.abs(moved.y[2:-2, 0] - np.sin(3 * moved.t[2:-2])).max() < 1e-6
    assert at_one_rate([fine, replace(slow, dt=1e-2)])[0] is fine


def test_rounded_stamps_need_no_word(sound):
    t, u, y = sound
    stamp_ns = 1_700_000_000_123_456_789 + np.rint(t * 1e9).astype(np.int64)
    recording, notices = prepare(stamp_ns, u, y)
    assert not notices and recording.dt == pytest.approx(1e-3, rel=1e-9)
    assert np.array_equal(recording.y, y)


def test_single_lost_samples_are_interpolated_many_are_refused(sound):
    t, u, y = sound
    rng = np.random.default_rng(4)
    keep = np.ones(len(t), bool)
    keep[rng.choice(np.arange(10, len(t) - 10), 50, replace=False)] = False
    recording, notices = prepare(t[keep], u[keep], y[keep])
    assert len(recording.t) == len(t) and '50 of 10000 samples lost' in str(notices[0])
    assert np.abs(recording.y - y).max() < 8 * SIGMA.max()
    assert not check(recording, MODEL)
    keep[rng.choice(len(t), 500, replace=False)] = False
    with pytest.raises(InputError, match=r'samples lost by their stamps.*expected at most 1 %'):
        prepare(t[keep], u[keep], y[keep])


def test_gaps(sound):
    t, u, y = sound
    keep = (t < 3.0) | (t > 3.5)
    recording, notices = prepare(t[keep], u[keep], y[keep])
    assert recording.duration == pytest.approx(6.5, abs=0.01)
    assert '1 gap in the stamps, the longest 0.502 s at t = 2.999 s; only' in str(notices[0])
    keep = np.mod(t, 3.0) > 0.5
    with pytest.raises(InputError, match=r'bench: 3 gaps .* 2\.5 s, expected at least 4 s'):
        prepare(t[keep], u[keep], y[keep], name='bench')


def test_nan(sound):
    t, u, y = sound
    y = y.copy()
    y[[100, 2000, 2001], 1] = np.nan
    recording, notices = prepare(t, u, y)
    assert np.isfinite(recording.y).all() and '3 values of arm were NaN' in str(notices[0])
    y[:3, 1] = y[1500:1510, 1] = np.nan
    recording, notices = prepare(t, u, y)  # as without these rows
    assert '13 samples without arm' in str(notices[0]) and '1 gap in the' in str(notices[-1])
    assert recording.begin == pytest.approx(1.51) and recording.u.tolist() == u[1510:].tolist()
    halves = np.where((t < 5.0)[:, None], [1.0, np.nan], [np.nan, 1.0])
    with pytest.raises(InputError, match='samples without motor .* without arm .*; 0 s remain'):
        prepare(t, u, y * halves)
    with pytest.raises(InputError, match='arm: nan in 833. of 10000 samples, more than 3 in a'):
        prepare(t, u, np.where(np.arange(len(t))[:, None] % 6, y * [1.0, np.nan], y))
    y[::50, 1] = np.nan
    with pytest.raises(InputError, match=r'arm at 0\.05 s: nan \(1.. nan of 9.*at most 1 % nan'):
        prepare(t, u, y)
    with pytest.raises(InputError, match='motor: never measured'):
        prepare(t, u, y * [np.nan, 1.0])
    for wild in (np.inf, 6.9e220):
        recording, notices = prepare(t, np.where(np.arange(len(t)) == 7, wild, u), sound[2])
        assert recording.u[7] == u[6]
        assert '1 values of u were infinite or beyond 1e9' in str(notices[0])
    with pytest.raises(InputError, match='u: never measured'):
        prepare(t, np.full(len(t), 6.9e220), sound[2])


def test_stamps_must_increase(sound):
    t, u, y = sound
    t = t.copy()
    t[40] = t[39]
    with pytest.raises(InputError, match=r't: 0\.039 s repeats after 0\.039 s'):
        prepare(t, u, y)
    rows, (notice,) = usable_rows(t)
    assert len(rows) == 9999 and 40 not in rows
    assert str(notice).startswith('1 of 10000 stamps repeat')
    recording, _ = prepare(t[rows], u[rows], y[rows])
    assert len(recording.u) == 10000
    t[40] = t[30]
    with pytest.raises(InputError, match=r't: 0\.03 s goes back after 0\.039 s'):
        prepare(t, u, y)


def test_what_replay_refuses_by_its_stamp_is_left_out(sound):
    t = sound[0]
    stamps = 1_000_000_000 + np.rint(t * 1e9).astype(np.int64)
    stamps[[5, 70]] = 0, stamps[68]
    stamps[5000:] -= stamps[5000] - stamps[0]  # the clock restarts
    rows, (notice,) = usable_rows(stamps)
    assert set(range(len(t))) - set(rows.tolist()) == {5, 70}
    assert str(notice).startswith('2 of 10000 samples have no stamp')


def test_single_wild_readings_are_mended(sound):
    t, u, y = sound
    wild = y.copy()
    wild[[1234, 5000], 0] += [0.5, -1.0]
    recording, notices = prepare(t, u, wild)
    assert '2 single wild readings of motor' in str(notices[0])
    assert np.abs(recording.y - y).max() < 8 * SIGMA.max()


SERVOS = [
    (3.0, 0.1, (2.1, 3.2, 5.3), (0.4, 0.5, 0.2)),
    (0.6, 0.02, (4.3, 6.7, 2.3), (0.6, 0.3, 0.3))]


def test_a_setpoint_faster_than_the_servo_has_sign_and_unit():
    """No lag brings motion and setpoint together: each frequency has its own."""
    for kp, kd, frequencies, amplitudes in SERVOS:
        model = load_model(config_path('drive.yaml')).with_(
            stiffness=6.0, half_gap=0.03, controller={'kp': kp, 'kd': kd, 'torque_limit': 8.0})
        t = np.arange(2000) * 0.01
        setpoint = sum(a * np.sin(2.0 * np.pi * f * t)
                       for a, f in zip(amplitudes, frequencies))
        y = simulate(model, setpoint, 0.01).x[:, :2]
        y = y + 0.003 * np.random.default_rng(1).standard_normal(y.shape)
        recording = UniformRecording(t, setpoint, y, 0.01).with_servo(model.controller)
        assert not [p.fault for p in check(recording, model) if decides(p)]


def test_late_stamps_are_no_lost_samples():
    """Steps of 1.5 sample times come about by jitter of a tenth; a lost sample is one still."""
    for seed in (1, 2, 3):
        t, u, y = record(rate=1000.0, duration=12.0, seed=seed)
        stamps = t + 1e-4 * np.random.default_rng(seed).standard_normal(len(t))
        assert (np.diff(stamps) > 1.5e-3).any()
        recording, notices = prepare(stamps, u, y)
        assert len(recording.u) == len(t)
        assert not any('lost' in str(n) or 'wander' in str(n) for n in notices)
        np.testing.assert_array_equal(recording.y, y)
        kept = np.delete(np.arange(len(t)), 7000)
        recording, notices = prepare(stamps[kept], u[kept], y[kept])
        assert len(recording.u) == len(t)
        assert any('1 of 12000 samples lost' in str(n) for n in notices)
