# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One sample in, one estimate out: same bits however it is fed, whatever comes in."""
from dataclasses import replace
import json

from drives import part_of
from filter_choice import EACH_FILTER
import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Sample, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import S_TAU_K
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.health_record import ERRORS_LARGER, TRUSTED
from gearbox_monitor.health.monitor import COMPONENTS, Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate


MODEL = DriveModel()
NOISE = Noise((0.0, 0.0, 0.4, 0.4), (0.005, 0.005))
START = 1_700_000_000_000_000_000
MS = 1_000_000
SECOND = 1_000_000_000
# Columns that are NaN where something is absent; all others are always finite.
ABSENT = {sample_loop.E_TAU_ARM, sample_loop.E_TAU_E, sample_loop.E_STD + 5, sample_loop.E_STD + 6,
          sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM, sample_loop.E_WHITE_1,
          sample_loop.E_WHITE_2, sample_loop.E_LOAD}
LEARNED = range(sample_loop.E_STIFFNESS, sample_loop.E_LEARNED_WEIGHT + 1)  # by other models
ALWAYS = [c for c in range(sample_loop.N_ESTIMATE) if c not in (*ABSENT, *LEARNED)]


def drive(seconds, dt=1e-3, model=MODEL, seed=1, measured=False):
    """Return (Samples, Trajectory) of a simulated drive."""
    t = dt * np.arange(round(seconds / dt))
    out = simulate(model, Excitation().torque(t), dt, NOISE, seed)
    load = out.tau_arm if measured else np.full(len(t), np.nan)
    stamps = START + np.arange(len(t)) * round(dt * 1e9)
    return Samples(stamps, np.stack([out.u, load], axis=1), out.y), out


def one(samples, k):
    return Sample(int(samples.stamp_ns[k]), tuple(samples.u[k]), tuple(samples.y[k]))


def rms(a):
    return float(np.sqrt(np.mean(np.square(a))))


def corrupted(seed, n=3000):
    """Return Samples with all sorts of bad input at random places."""
    rng = np.random.default_rng(seed)
    samples, _ = drive(n * 1e-3)
    stamps, u, y = samples.stamp_ns.copy(), samples.u.copy(), samples.y.copy()
    for _ in range(12):
        k, length = int(rng.integers(n)), int(rng.integers(1, 60))
        where, joint = slice(k, k + length), int(rng.integers(2))
        kind = rng.integers(14)
        if kind == 0:
            y[where, joint] = np.nan
        elif kind == 1:
            y[where] = np.nan
        elif kind == 2:
            y[k, joint] = rng.choice([np.inf, -np.inf])
        elif kind == 3:
            u[where, 0] = rng.choice([np.nan, np.inf])
        elif kind == 4:
            stamps[where] = 0
        elif kind == 5:
            stamps[where] = stamps[k]
        elif kind == 6:
            stamps[where] -= int(rng.integers(1, 5 * SECOND))
        elif kind == 7:
            stamps[k:] += int(rng.choice([100 * MS, 2 * SECOND, 3600 * SECOND]))
        elif kind == 8:
            stamps[k:] -= int(rng.choice([5 * MS, 10 * SECOND]))
        elif kind == 9:
            stamps[k] += int(rng.integers(1, 10 ** 12))
        elif kind == 10:
            stamps[k:] += np.arange(n - k) * 9 * MS  # a tenth of the rate
        elif kind == 11:
            y[k, joint] = rng.choice([1e9, -1e200, 1e308])
        elif kind == 12:
            stamps[where] = -stamps[where]
        else:
            u[k, 0] = rng.choice([1e6, 1e200])
    return Samples(stamps, u, y)


def same(a, b):
    np.testing.assert_array_equal(a, b)  # NaN equals NaN


def state_of(monitor):
    snapshot = monitor.snapshot()
    return {k: snapshot[k] for k in ('z', 'P', 'clock', 'efforts', 'counts', 'gate')}


def test_step_by_step_equals_run():
    for seed in range(2):
        samples = corrupted(seed)
        whole, single, chunked = Monitor(MODEL), Monitor(MODEL), Monitor(MODEL)
        expected = whole.run(samples)
        rows, stamps, smoothed, smoothed_stamps = [], [], [], []
        for k in range(len(samples.stamp_ns)):
            estimate = single.step(one(samples, k))
            if estimate is None:
                assert expected.codes[k] != sample_loop.ESTIMATE
                continue
            rows.append(estimate.row)
            stamps.append(estimate.stamp_ns)
            smoothed += [row for _, row in estimate.smoothed]
            smoothed_stamps += [stamp for stamp, _ in estimate.smoothed]
        same(rows, expected.rows)
        same(stamps, expected.stamp_ns)
        same(smoothed, expected.smoothed)
        same(smoothed_stamps, expected.smoothed_stamp_ns)
        edges = np.sort(np.random.default_rng(seed).integers(0, 3000, 20))
        parts = [chunked.run(part_of(samples, a, b))
                 for a, b in zip([0, *edges], [*edges, len(samples.stamp_ns)])]
        same(np.concatenate([p.rows for p in parts]), expected.rows)
        same(np.concatenate([p.smoothed for p in parts]), expected.smoothed)
        for other in (single, chunked):
            assert state_of(other) == state_of(whole)
            assert repr(other.outcomes) == repr(whole.outcomes)  # NaN compares by its text


def test_nothing_non_finite_and_nothing_lost():
    for seed in range(4):
        samples = corrupted(seed)
        good, _ = drive(4.0, seed=2)
        after = Samples(good.stamp_ns + 10 ** 13, good.u, good.y)
        monitor = Monitor(MODEL)
        for part in (samples, after):
            estimates = monitor.run(part)
            rows = estimates.rows
            assert np.isfinite(rows[:, ALWAYS]).all() and not np.isinf(rows).any()
            assert np.isfinite(estimates.smoothed).all()
            assert len(rows) == (estimates.codes == sample_loop.ESTIMATE).sum()
            seen = part.y[estimates.codes == sample_loop.ESTIMATE]
            innovations = [sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM]
            same(np.isfinite(rows[:, innovations]),
                 np.abs(seen) <= sample_loop.HUGE)
            for outcome in monitor.outcomes.values():
                for name, value in outcome.values.items():
                    assert not isinstance(value, float) or np.isfinite(value), name
        assert monitor.counts[:sample_loop.NON_FINITE].sum() == monitor.input_count == 7000
        # A new time is taken up after two samples; one second later the torque is right again.
        assert len(rows) >= 3997
        assert rms(estimates.nis[1000:]) < 4.0
        assert monitor.outcomes['input'].level <= Level.WARN


def test_snapshot_goes_on_bit_for_bit():
    for at in (1, 1111):
        samples = corrupted(at)
        parameters = {'arm_load': 'none', 'friction_error_std': 0.1, 'effort_delay': 3,
                      'tau_k_stiffness': 1.0}
        live = Monitor(MODEL, parameters)
        live.run(part_of(samples, 0, at))
        for changes in ({}, {'q_std_tau_k': 12.0, 'r_std_arm': 0.01}, {'p0_std_torque': 2.0}):
            live.set_parameters(changes)
            text = live.snapshot()
            assert all(isinstance(value, str) for value in text.values())
            other = Monitor.restore(text)
            assert other.parameters == live.parameters and other.model == live.model
            a, b = part_of(samples, at, at + 600), part_of(samples, at + 600, 3000)
            first, second = live.run(a), other.run(a)
            same(first.rows, second.rows)
            same(first.codes, second.codes)
            # The restored one lacks the rows from before the snapshot, nothing else.
            tail = len(second.smoothed)
            same(first.smoothed[len(first.smoothed) - tail:], second.smoothed)
            same(first.smoothed_stamp_ns[len(first.smoothed) - tail:], second.smoothed_stamp_ns)
            later = live.run(b), other.run(b)
            same(later[0].rows, later[1].rows)
            same(later[0].smoothed, later[1].smoothed)
            assert state_of(live) == state_of(other) and live.input_count == other.input_count


def test_smoothed_rows_after_a_snapshot():
    for at in (1018, 1099):
        samples, _ = drive(2.0)
        live = Monitor(MODEL)
        live.run(part_of(samples, 0, at))
        other = Monitor.restore(live.snapshot())
        first, second = live.run(part_of(samples, at, 2000)), other.run(part_of(samples, at, 2000))
        expected = first.smoothed_stamp_ns >= samples.stamp_ns[at - 1]
        same(first.smoothed_stamp_ns[expected], second.smoothed_stamp_ns)
        same(first.smoothed[expected], second.smoothed)


def test_a_snapshot_keeps_what_earlier_windows_told_of_the_torque():
    samples, _ = drive(26.0)
    live = Monitor(MODEL)
    live.run(samples)
    snapshot = live.snapshot()
    kept = json.loads(snapshot['monitor'])[-1]
    assert [len(values) for values in kept] == [0, 0, 2]  # of whole windows, one after the other
    assert json.loads(Monitor.restore(snapshot).snapshot()['monitor'])[-1] == kept


def test_a_window_that_began_before_a_snapshot_is_not_kept_as_a_whole_one():
    samples, _ = drive(24.0)
    live = Monitor(MODEL)
    live.run(part_of(samples, 0, 9000))
    restored = Monitor.restore(live.snapshot())
    restored.run(part_of(samples, 9000, 24000))
    stamps = [stamp for stamp, _ in json.loads(restored.snapshot()['monitor'])[-1][2]]
    assert len(stamps) == 1 and stamps[0] - START >= 19 * SECOND


def test_windows_are_kept_from_the_begin_when_the_clock_was_set_back():
    samples, _ = drive(14.0)
    live = Monitor(MODEL)
    live.run(samples)
    live.run(replace(samples, stamp_ns=samples.stamp_ns - 3600 * SECOND))
    stamps = [stamp for stamp, _ in json.loads(live.snapshot()['monitor'])[-1][2]]
    assert len(stamps) == 2 and stamps[1] < stamps[0]


def test_every_step_is_smoothed_once():
    for lag, dt in ((0.1, 0.01), (0.02, 5e-4), (1.0, 5e-4)):
        samples, _ = drive(4.0, dt)
        estimates = Monitor(MODEL, {'smoother_lag': lag}).run(samples)
        same(estimates.smoothed_stamp_ns, samples.stamp_ns[:len(estimates.smoothed)])
        assert len(estimates.smoothed) * dt >= 4.0 - 1.6 * lag - 2 * dt
        assert not len(Monitor(MODEL, {'smoother_lag': 0.0}).run(samples).smoothed)


def test_parameters_while_running():
    samples, _ = drive(3.0)
    monitor = Monitor(MODEL)
    monitor.run(part_of(samples, 0, 1000))
    before = state_of(monitor)
    for bad in ({'q_std_tau_k': -1.0}, {'q_std_tau_k': float('nan')}, {'no_such': 1},
                {'filter': 'crystal ball'}, {'r_std_arm': 'small'}):
        with pytest.raises(InputError, match=next(iter(bad))):
            monitor.set_parameters(bad)
    assert state_of(monitor) == before
    monitor.set_parameters({'q_std_tau_k': 20.0})
    assert state_of(monitor)['P'] == before['P']
    estimates = monitor.run(part_of(samples, 1000, 2000))
    assert len(estimates.rows) == 1000  # no restart
    monitor.set_parameters({'p0_std_torque': 1.0})
    assert len(monitor.run(part_of(samples, 2000, 3000)).rows) == 999


@pytest.mark.parametrize('phase, expected', [
    (0, [1137, 2000, 4000, 6000]), (300, [1137, 1300, 2300, 4000, 4300, 6000, 6300])])
def test_evaluations_come_at_their_phase_of_the_second(phase, expected, monkeypatch):
    """The first one a second after a start; a snapshot carries the phase, a reset keeps it."""
    samples, _ = drive(7.0)
    evaluated, evaluate = [], Monitor._evaluate
    monkeypatch.setattr(Monitor, '_evaluate', lambda self, stamp_ns: (
        evaluated.append((stamp_ns - int(samples.stamp_ns[0])) // MS), evaluate(self, stamp_ns)))
    monitor = Monitor(MODEL, phase_ns=phase * MS)
    monitor.run(part_of(samples, 137, 3000))
    restored = Monitor.restore(monitor.snapshot())
    restored.run(part_of(samples, 3000, 5000))
    restored.reset()
    restored.run(part_of(samples, 5000, 7000))
    assert evaluated == expected


@pytest.mark.parametrize('arm_joint', ['arm', pytest.param('', marks=pytest.mark.system)])
def test_a_change_between_two_evaluations_is_the_same_step_by_step(arm_joint):
    """What the monitor has not taken yet belongs to the time before the change."""
    samples, _ = drive(24.0)
    if not arm_joint:
        samples.y[:, 1] = np.nan
    single, whole = (Monitor(MODEL, {'drift_window': 5.0, 'arm_joint': arm_joint})
                     for _ in range(2))
    for begin, end, changes in ((0, 8345, {'q_std_tau_k': 20.0}), (8345, 17432, None),
                                (17432, 24000, {})):
        for k in range(begin, end):
            single.step(one(samples, k))
        whole.run(part_of(samples, begin, end))
        assert repr(single.outcomes) == repr(whole.outcomes) and whole.windows
        assert repr(single.windows) == repr(whole.windows)
        for monitor in (single, whole):
            if changes is None:
                monitor.reset()
            elif changes:
                monitor.set_parameters(changes)
    assert single.snapshot() == whole.snapshot()


DAMAGES = [
    {'z': '["nonsense"]'}, {'P': '[]'}, {'gate': '[1]'}, {'model': '{"motor_inertia": 0}'},
    {'parameters': '{"a": 1}'}, {'clock': None}]


def test_damaged_snapshot():
    for change in DAMAGES:
        snapshot = {**Monitor(MODEL).snapshot(), **change}
        with pytest.raises(InputError):
            Monitor.restore(snapshot, 'file.yaml')
        del snapshot['z']
        with pytest.raises(InputError):
            Monitor.restore(snapshot, 'file.yaml')


def test_effort_delay():
    samples, out = drive(5.0)
    reference = Monitor(MODEL).run(samples)
    for delay in (-1, 2, 50):
        shifted = np.roll(samples.u, -delay, axis=0)
        estimates = Monitor(MODEL, {'effort_delay': delay}).run(
            Samples(samples.stamp_ns, shifted, samples.y))
        same(estimates.u[60:-60], reference.u[60:-60])


def spoil(name):
    """Return (samples of 9 s at 1 kHz, spoilt from 3 s on, {reason: count}, level of input)."""
    good, _ = drive(9.0)
    stamps, u, y = good.stamp_ns.copy(), good.u.copy(), good.y.copy()
    k = 3000
    expected, drop = {}, None
    if name == 'nan motor':
        y[k:k + 1500, 0] = np.nan
        expected = {sample_loop.MOTOR_MISSING: 1500}
    elif name == 'nan arm':
        y[k:k + 1500, 1] = np.nan
        expected = {sample_loop.ARM_MISSING: 1500}
    elif name == 'inf':
        y[k:k + 1500, 0] = np.inf
        expected = {sample_loop.NON_FINITE: 1500, sample_loop.MOTOR_MISSING: 1500}
    elif name == 'both missing short':
        y[k:k + 200] = np.nan
        expected = {sample_loop.MOTOR_MISSING: 200, sample_loop.ARM_MISSING: 200}
    elif name == 'both missing long':
        y[k:k + 1500] = np.nan
        expected = {sample_loop.NO_MEASUREMENT: 1250, sample_loop.START: 2}
    elif name == 'effort short':
        u[k:k + 200] = np.nan
        expected = {sample_loop.EFFORT_HELD: 200}
    elif name == 'effort long':
        u[k:k + 1500] = np.nan
        expected = {sample_loop.NO_EFFORT: 1250, sample_loop.EFFORT_HELD: 1500,
                    sample_loop.START: 2}
    elif name == 'zero':
        stamps[k:k + 200] = 0
        expected = {sample_loop.ZERO_STAMP: 200}
    elif name == 'duplicate':
        stamps[k:k + 200] = stamps[k - 1]
        expected = {sample_loop.DUPLICATE: 200}
    elif name == 'backward':
        stamps[k:k + 1500:2] -= 5 * SECOND
        expected = {sample_loop.BACKWARD: 750}
    elif name == 'jump single':
        stamps[k:k + 1500:300] += 3600 * SECOND
        expected = {sample_loop.JUMP: 5}
    elif name == 'jump for good':
        stamps[k:] += 3600 * SECOND
        expected = {sample_loop.JUMP: 2, sample_loop.START: 2}
    elif name == 'set back for good':
        stamps[k:] -= 3600 * SECOND
        expected = {sample_loop.BACKWARD: 2, sample_loop.START: 2}
    elif name == 'dropout short':
        drop = slice(k, k + 100)
        expected = {sample_loop.SAMPLES_MISSED: 100}
    elif name == 'dropout long':
        drop = slice(k, k + 2000)
        expected = {sample_loop.JUMP: 2, sample_loop.START: 2}
    elif name == 'tenth of the rate':
        drop = [i for i in range(k, 6000) if i % 10]
    if drop is not None:
        stamps, u, y = (np.delete(a, drop, axis=0) for a in (stamps, u, y))
    return Samples(stamps, u, y), expected


SPOILT = ['nan motor', 'nan arm', 'inf', 'both missing short', 'both missing long',
          'effort short', 'effort long', 'zero', 'duplicate', 'backward', 'jump single',
          'jump for good', 'set back for good', 'dropout short', 'dropout long',
          'tenth of the rate']


def expect_what_is_counted(name):
    samples, expected = spoil(name)
    monitor, raw = Monitor(MODEL), []
    judge = monitor._check_input
    monitor._check_input = lambda *a: raw.append(judge(*a)) or raw[-1]
    estimates = monitor.run(samples)
    assert np.isfinite(estimates.rows[:, ALWAYS]).all() and not np.isinf(estimates.rows).any()
    for reason, count in expected.items():
        assert monitor.counts[reason] == pytest.approx(count, abs=2), sample_loop.REASONS[reason]
    unexpected = set(sample_loop.REASONS) - set(expected) - {
        sample_loop.START, sample_loop.EFFORT_HELD, sample_loop.MOTOR_MISSING,
        sample_loop.ARM_MISSING, sample_loop.SAMPLES_MISSED}
    assert not monitor.counts[list(unexpected)].any()
    assert monitor.counts[:sample_loop.NON_FINITE].sum() == len(samples.stamp_ns)
    # Seen while it lasts, with its reason in words; good again at the end.
    bad = [outcome for outcome in raw if outcome.level > Level.OK]
    assert bad and raw[-1].level == Level.OK
    reasons = ' '.join(outcome.message for outcome in bad)
    for reason in expected:
        assert reason == sample_loop.START or sample_loop.REASONS[reason] in reasons
    # A second of good data later the prediction errors are those of before.
    nis = estimates.nis
    assert nis[-2500:].mean() == pytest.approx(2.0, abs=0.25)


def test_bad_stream():
    for name in SPOILT:
        expect_what_is_counted(name)


def test_all_refused_is_counted():
    samples, _ = drive(2.0)
    for stamps, u, reason in (
            (np.zeros(2000, np.int64), samples.u, sample_loop.ZERO_STAMP),
            (samples.stamp_ns, np.full((2000, 2), np.nan), sample_loop.NO_EFFORT)):
        monitor = Monitor(MODEL)
        estimates = monitor.run(Samples(stamps, u, samples.y))
        assert not len(estimates.rows) and monitor.counts[reason] == 2000
        assert all(outcome.level > Level.OK for outcome in monitor.outcomes.values())


def test_empty_and_before_the_first():
    monitor = Monitor(MODEL)
    estimates = monitor.run(Samples(np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2))))
    assert estimates.rows.shape == (0, sample_loop.N_ESTIMATE) and len(estimates.codes) == 0
    assert set(monitor.outcomes) == set(COMPONENTS)
    assert all(f.level == Level.WARN for f in monitor.outcomes.values())
    assert monitor.stamp_ns == 0 and monitor.estimator.period == 0.0


LOADS = {
    'none': [],
    'constant': [{'id': 'load_torque', 'TL': 1.6}],
    'gravity': [{'id': 'gravity', 'G': 2.3}],
    'coulomb': [{'id': 'arm_coulomb', 'Cac': 1.65}],
    'all': [{'id': 'gravity', 'G': 1.2}, {'id': 'arm_coulomb', 'Cac': 0.9},
            {'id': 'load_torque', 'TL': 0.7}],
}


def loaded(effects, measured=False, seeds=(1, 2, 3)):
    """Return (mean NIS, tau_K error, load rms over tau_K rms) over seeds of 10 s."""
    nis, error, share = [], [], []
    for seed in seeds:
        samples, out = drive(10.0, model=MODEL.with_(effects=effects), seed=seed,
                             measured=measured)
        mode = {'arm_load': 'measured'} if measured else {}
        estimates = Monitor(MODEL, mode).run(samples)
        nis.append(estimates.nis[500:].mean())
        error.append(rms((estimates.tau_k - out.tau_k[1:])[500:]))
        share.append(rms(out.tau_arm) / rms(out.tau_k))
    return np.mean(nis), np.mean(error), np.mean(share)


def test_unknown_arm_load():
    """An unmodelled load of half the torque: NIS as predicted, tau_K hardly worse."""
    _, reference, _ = loaded(LOADS['none'])
    for name, effects in LOADS.items():
        nis, error, share = loaded(effects)
        assert name == 'none' or share == pytest.approx(0.5, abs=0.06), name
        assert 1.85 <= nis <= 2.1, (name, nis)
        assert error <= 1.05 * reference, (name, error / reference)


def test_measured_arm_load():
    for name in ('gravity', 'all'):
        _, unknown, _ = loaded(LOADS[name])
        nis, known, _ = loaded(LOADS[name], measured=True)
        assert 1.85 <= nis <= 2.1 and known <= 1.01 * unknown, name
    # Without the load's measurement there is no estimate; it is said, not guessed.
    samples, _ = drive(1.0)
    monitor = Monitor(MODEL, {'arm_load': 'measured'})
    assert not len(monitor.run(samples).rows) and monitor.counts[sample_loop.NO_EFFORT] == 1000


@pytest.mark.system
def test_loads_that_the_model_has():
    """With its effects on the arm in the model the filter does as on a drive without them."""
    def scores(model, samples, out):
        estimates = Monitor(model, {'arm_load': model.arm_load}).run(samples)
        at = np.searchsorted(samples.stamp_ns, estimates.smoothed_stamp_ns)
        smoothed = estimates.smoothed[:, S_TAU_K] - out.tau_k[at]
        return (estimates.nis[500:].mean(), rms((estimates.tau_k - out.tau_k[1:])[500:]),
                rms(smoothed[500:]))

    plain = MODEL.with_(arm_load='none')
    _, reference, smoothed_reference = scores(plain, *drive(10.0))
    for name, effects in LOADS.items():
        model = plain.with_(effects=effects)
        given = drive(10.0, model=model)
        nis, error, smoothed = scores(model, *given)
        assert 1.85 <= nis <= 2.1, (name, nis)
        assert error < 1.05 * reference and smoothed < 1.1 * smoothed_reference, name
        if effects:
            nis, _, smoothed = scores(plain, *given)
            assert nis > 20.0 and smoothed > 1.5 * smoothed_reference, (name, nis, smoothed)


@pytest.mark.system
def test_the_arm_alone_tells_the_torque_where_the_load_is_known():
    def error(effects, known):
        model = MODEL.with_(effects=effects, arm_load='none')
        samples, out = drive(10.0, model=model)
        samples.y[2000:, 0] = np.nan  # the motor's encoder is lost
        estimates = Monitor(known, {'arm_load': 'none'}).run(samples)
        return rms((estimates.tau_k - out.tau_k[1:])[2500:])

    reference = error([], MODEL)
    for name in ('gravity', 'coulomb', 'all'):
        knowing = error(LOADS[name], MODEL.with_(effects=LOADS[name]))
        assert knowing < 1.1 * reference < 1.5 * reference < error(LOADS[name], MODEL), name


def test_a_weight_of_the_model_acts_besides_the_measured_load():
    """A short run of the filter alone; the monitor and both loads behind the marker."""
    samples, _ = drive(2.0, model=MODEL.with_(effects=LOADS['gravity']))
    samples.u[:, 1] = 0.0
    nis = []
    for effects in ([], LOADS['gravity']):
        engine = Estimator(MODEL.with_(effects=effects), {'arm_load': 'measured'})
        nis.append(engine.run(samples).nis[500:].mean())
    assert 'besides the measured load on the arm: gravity' in engine.warnings[0]
    assert nis[0] > 2.0 * nis[1] and 1.8 < nis[1] < 2.2


@pytest.mark.system
def test_loads_of_the_model_act_besides_the_measured_one():
    constant, gravity = LOADS['constant'], LOADS['gravity']
    samples, out = drive(10.0, model=MODEL.with_(effects=constant + gravity))
    samples.u[:, 1] = constant[0]['TL']
    nis = {}
    for effects in ([], gravity, constant + gravity):
        monitor = Monitor(MODEL.with_(effects=effects), {'arm_load': 'measured'})
        nis[len(effects)] = monitor.run(samples).nis[500:].mean()
        assert len(monitor.estimator.warnings) == (1 if effects else 0)
    assert 1.85 <= nis[1] <= 2.1 and min(nis[0], nis[2]) > 20.0
    assert ('besides the measured load on the arm: load_torque, gravity'
            in monitor.estimator.warnings[0])


def test_loads_of_the_model_in_replay():
    model = MODEL.with_(effects=[*LOADS['all'], {'id': 'arm_viscous', 'Cav': 0.1}])
    samples, _ = drive(0.6, model=model)
    live = Monitor(model, {'arm_load': 'none'})
    live.run(part_of(samples, 0, 300))
    snapshot = json.loads(json.dumps(live.snapshot()))
    rows = live.run(part_of(samples, 300, 600)).rows
    again = Monitor.restore(snapshot).run(part_of(samples, 300, 600)).rows
    np.testing.assert_array_equal(again, rows)


def test_no_arm_load_for_the_papers_plant():
    samples, out = drive(10.0)
    estimates = Monitor(MODEL, {'arm_load': 'none'}).run(samples)
    assert 1.85 <= estimates.nis[500:].mean() <= 2.1
    assert np.isnan(estimates.tau_arm).all() and np.isnan(estimates.tau_arm_std).all()
    at = np.searchsorted(samples.stamp_ns, estimates.smoothed_stamp_ns)
    error = rms((estimates.tau_k - out.tau_k[1:])[500:])
    assert rms((estimates.smoothed[:, S_TAU_K] - out.tau_k[at])[500:]) < 0.7 * error


def test_nothing_alarms_without_a_fault():
    samples, _ = drive(30.0)
    monitor = Monitor(MODEL)
    for k in range(0, 30000, 500):
        monitor.run(part_of(samples, k, k + 500))
        if k > 3000:
            levels = {c: monitor.outcomes[c].level for c in COMPONENTS
                      if c not in ('backlash', 'friction')}
            assert not any(levels.values()), (k, levels)
    assert monitor.outcomes['backlash'].level == Level.OK


def test_each_half_octave_of_prediction_errors_is_a_trust_of_its_own():
    samples, out = drive(11.0)
    noise, trusts = samples.y - out.x[:, :2], []
    for factor in (1.0, 1.3, 1.6, 2.0):
        monitor = Monitor(MODEL, {'drift_window': 5.0})
        monitor.run(Samples(samples.stamp_ns, samples.u, samples.y + (factor - 1.0) * noise))
        trusts += [window.trust for window in monitor.judged]
    assert trusts == [TRUSTED, ERRORS_LARGER, ERRORS_LARGER - 1, ERRORS_LARGER - 3]


@pytest.mark.parametrize('name', EACH_FILTER)
def test_divergence_is_named_and_the_filter_starts_anew(name):
    stamps = 1_000_000_000 + 1_000_000 * np.arange(300, dtype=np.int64)
    samples = Samples(stamps, np.zeros((300, 2)), np.zeros((300, 2)))
    monitor, one = (Monitor(DriveModel(), {'filter': name}) for _ in range(2))
    monitor.run(part_of(samples, 0, 100))
    monitor.estimator._belief.z[0] = np.nan  # nothing that comes in does this any more
    estimates = monitor.run(part_of(samples, 100, 300))
    told, = monitor.estimator.divergences
    assert (told.step, told.stamp_ns) == (100, stamps[100])
    assert 'not finite' in told.reason
    assert f'stamp {1.1:.9f} s' in monitor.estimator.divergence_notes()[0]
    assert estimates.stamp_ns[-1] == stamps[-1] and np.isfinite(estimates.tau_k).all()
    for k in range(300):
        if k == 100:
            one.estimator._belief.z[0] = np.nan
        one.step(Sample(int(stamps[k]), (0.0, 0.0), (0.0, 0.0)))
    assert list(one.estimator.divergences) == [told]


def test_lost_positive_definiteness_is_told_with_its_eigenvalue():
    monitor = Monitor(DriveModel(), {'filter': 'ukf'})
    for k in range(20):
        if k == 10:
            monitor.estimator._belief.P[0] = -1.0
        monitor.step(Sample(1_000_000_000 + 1_000_000 * k, (0.0, 0.0), (0.0, 0.0)))
    told, = monitor.estimator.divergences
    assert told.reason == 'the covariance is not positive definite'
    assert told.smallest_eigenvalue <= -1.0


KNOWN_OR_NOT = [
    {'id': 'gravity', 'G': 0.5}, {'id': 'arm_coulomb', 'Cac': 0.5},
    {'id': 'arm_viscous', 'Cav': 0.1}, {'id': 'load_torque', 'TL': 0.5},
    {'id': 'load_friction', 'Cl': 0.2}, {'id': 'torque_offset', 'u0': 0.5},
    {'id': 'motor_viscous', 'Cv': 0.2}, {'id': 'motor_coulomb', 'Cc': 0.5},
    {'id': 'motor_inertia', 'm1': 0.01}, {'id': 'arm_inertia', 'm2': 0.04},
    {'id': 'transmission_damping', 'D': 0.1}, {'id': 'stribeck', 'Cs': 0.2, 'vs': 0.5},
    {'id': 'actuator_lag', 'T': 0.01}]


def test_an_effect_is_used_or_said_to_be_left_out():
    for effect in KNOWN_OR_NOT:
        samples, _ = drive(0.4)
        plain = Monitor(MODEL, {'arm_load': 'none'})
        given = Monitor(replace(MODEL, effects=(effect,)), {'arm_load': 'none'})
        # Friction that is left out still asks for finer steps.
        used = np.median(np.abs(plain.run(samples).tau_k - given.run(samples).tau_k)) > 0.02
        told = any(effect['id'] in warning for warning in given.estimator.warnings)
        assert used != told
