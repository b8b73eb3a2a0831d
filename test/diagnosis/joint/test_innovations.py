# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""The grey-box likelihood against filterpy, frozen-gain filters and known effects."""
from dataclasses import replace

from filterpy.kalman import KalmanFilter
import numpy as np
import pytest
from scipy.linalg import expm

from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.diagnosis.joint.effect_scan import joined, scan
from gearbox_monitor.diagnosis.joint.innovations import (
    annealed, BEGIN, evaluated, FIRST_NOISE, fitted, halves, InnovationFit, InnovationLikelihood,
    JointLikelihood, MEMORY_MOVE, MOST, schedule, SPEED_ERROR, STRAY)
from gearbox_monitor.plant import effects
from gearbox_monitor.plant.drive import Controller, DriveModel, Transmission
from gearbox_monitor.plant.effects.registry import INTEGRAL, MEMORIES
from gearbox_monitor.plant.simulate import advance, N_STATE, PackedDrive, Plant, ProcessNoise
from gearbox_monitor.signals.uniform import UniformRecording

DT, SIGMA = 1e-3, np.array([1e-3, 2e-3])
LINEAR = DriveModel(coulomb_friction=0.0, transmission=Transmission(half_gap=0.0))
BLUNT = DriveModel(friction_sharpness=20.0)  # its motion needs no steps below a sample


def recorded(model, seconds, seed=0):
    """Return a UniformRecording of `model`, simulated on steps of 0.1 ms."""
    t = np.arange(round(seconds / DT)) * DT
    u = 2.0 * np.sin(5.0 * t) + 1.5 * np.sin(14.0 * t + 1.0)
    run = Plant(model).run(np.repeat(u, 10), 0.1 * DT)
    noise = np.random.default_rng(seed).standard_normal((len(t), 2))
    return UniformRecording(t, u, run.x[::10, :2] + SIGMA * noise, DT)


def likelihood_of(recording, model, spans=None):
    return InnovationLikelihood(recording, model, SIGMA, spans or [slice(0, len(recording.u))])


def test_linear_drive_has_the_innovations_of_filterpy_and_its_smoothed_states():
    recording = recorded(LINEAR, 0.4)
    likelihood = likelihood_of(recording, LINEAR)
    torque = np.array([0.3, 0.1])
    run = likelihood.run(LINEAR, torque)
    k, d = LINEAR.transmission.stiffness, LINEAR.damping
    inertia = np.array([LINEAR.motor_inertia, LINEAR.arm_inertia])
    A = np.zeros((5, 5))
    A[:2, 2:4] = np.eye(2)
    A[2, :4] = np.array([-k - LINEAR.position_gain, k, -d - LINEAR.viscous_friction,
                         d]) / inertia[0]
    A[3, :4] = np.array([k, -k, d, -d]) / inertia[1]
    A[2, 4] = 1.0 / inertia[0]
    step = expm(A * DT)
    F, B = step[:4, :4], step[:4, 4]
    Q = np.zeros((4, 4))
    for i in range(2):
        v = (torque[i] / inertia[i] * 0.5 * (1.0 + F[2 + i, 2 + i]) * DT) ** 2
        Q[np.ix_([i, 2 + i], [i, 2 + i])] = v * np.array([[DT ** 2 / 3, DT / 2], [DT / 2, 1.0]])
    begin, end = likelihood.begin[0], likelihood.end[0]
    filter_ = KalmanFilter(dim_x=4, dim_z=2)
    filter_.F, filter_.Q, filter_.H, filter_.R = F, Q, np.eye(2, 4), np.diag(SIGMA ** 2)
    filter_.x, filter_.P = run.start.states[0, :4], run.start.covariance
    deviance, means, covariances = 0.0, [filter_.x], [filter_.P]
    for at in range(begin, end - 1):
        filter_.predict(u=recording.u[at], B=B)
        filter_.update(recording.y[at + 1])
        deviance += filter_.y @ filter_.SI @ filter_.y + np.log(np.linalg.det(filter_.S))
        means.append(filter_.x.copy())
        covariances.append(filter_.P.copy())
        assert run.trace.innovation[at, 0] == pytest.approx(filter_.y[0], abs=1e-7)
    assert run.trace.begin[begin:end, 0, :4] == pytest.approx(np.array(means), abs=1e-4)
    # Per reading as filtered() counts it; the second half of the recording is as well.
    own = (run.residual ** 2 - 1.0 + np.log(run.trace.variance / SIGMA ** 2))[begin:end - 1]
    count = 2 * (end - begin - 1)
    assert own.sum() == pytest.approx(
        deviance - count - (end - begin - 1) * np.log(SIGMA ** 2).sum(), abs=1e-2)
    # Rauch, Tung and Striebel: filterpy's smoother knows no input.
    own_smooth, smooth = likelihood.smoothed(run), means[-1]
    for at in range(end - 2, begin - 1, -1):
        gain = covariances[at - begin] @ F.T @ np.linalg.inv(
            F @ covariances[at - begin] @ F.T + Q)
        mean = means[at - begin]
        smooth = mean + gain @ (smooth - F @ mean - B * recording.u[at])
        assert own_smooth[at, :4] == pytest.approx(smooth, abs=1e-4)


def test_a_rigid_drive_is_one_inertia_to_the_filter():
    """With white torque noise, and with torque that lasts and readings every 20 ms."""
    for lasting in (0.0, 0.05):
        model = replace(LINEAR, transmission=Transmission(kind='rigid'),
                        process_torque_time=lasting)
        recording = recorded(model, 0.8)
        run = likelihood_of(recording, model).run(model, [0.3, 0.1])
        inertia = model.motor_inertia + model.arm_inertia
        fade = np.exp(-DT / lasting) if lasting else 0.0
        step = expm(DT * np.array([
            [0.0, 1.0, 0.0], [-model.position_gain / inertia, -model.viscous_friction / inertia,
                              1.0 / inertia], [0.0, 0.0, 0.0]]))
        filter_ = KalmanFilter(dim_x=3, dim_z=2)
        filter_.F = np.array([*step[:2], [0.0, 0.0, fade]])
        filter_.H = np.array([[1.0, 0.0, 0.0]] * 2)
        filter_.R, filter_.Q = np.diag(SIGMA ** 2), np.zeros((3, 3))
        if lasting:
            filter_.Q[2, 2] = 0.3 ** 2 * (1.0 - fade ** 2)
        else:
            v = (0.3 / inertia * 0.5 * (1.0 + step[1, 1]) * DT) ** 2
            filter_.Q[:2, :2] = v * np.array([[DT ** 2 / 3, DT / 2], [DT / 2, 1.0]])
        filter_.x = np.array([*run.start.states[0, [0, 2]], 0.0])
        filter_.P = np.zeros((3, 3))
        filter_.P[:2, :2] = run.start.covariance[np.ix_([0, 2], [0, 2])]
        if lasting:
            filter_.P[2, 2] = run.start.covariance[4, 4]
        for at in range(run.data.end[0] - 1):
            filter_.predict(u=recording.u[at], B=step[:, 2] * [1.0, 1.0, 0.0])
            assert run.trace.begin[at + 1, 0, 0] == pytest.approx(
                run.trace.begin[at + 1, 0, 1], abs=1e-9)
            if lasting and (at + 1) % 20:
                assert run.trace.slope[at].tolist() == [0.0, 0.0]
                continue
            filter_.update(recording.y[at + 1])
            assert run.trace.innovation[at, 0] == pytest.approx(filter_.y[0], abs=1e-7)
            assert run.trace.begin[at + 1, 0, [0, 2]] == pytest.approx(filter_.x[:2], abs=1e-4)


def test_other_noise_and_inputs_change_a_linear_drive_as_a_new_run_does():
    recording = recorded(LINEAR, 0.4)
    likelihood = likelihood_of(recording, LINEAR)
    run = likelihood.run(LINEAR, [0.3, 0.1])
    deviance, innovation, variance = likelihood.with_noise(run, [0.1, 0.2])
    other = likelihood.run(LINEAR, [0.1, 0.2])
    assert deviance == pytest.approx(other.deviance, rel=1e-6)
    assert innovation == pytest.approx(other.trace.innovation, abs=1e-8)
    assert variance == pytest.approx(other.trace.variance, rel=1e-6)
    for effect in ({'id': 'torque_offset', 'u0': 0.1}, {'id': 'load_torque', 'TL': 0.1},
                   {'id': 'encoder_offset', 'c': 0.01}):
        model = replace(LINEAR, effects=(effect,))
        change = likelihood.run(model, [0.3, 0.1]).trace.innovation - run.trace.innovation
        assert likelihood.change(run, model) == pytest.approx(change, abs=1e-3 * change.std())


def test_parts_of_a_recording_know_nothing_of_each_other():
    recording = recorded(BLUNT, 0.9)
    spans = [slice(0, 300), slice(300, 550), slice(600, 900)]
    torque = np.array([0.3, 0.1])
    runs = [likelihood_of(recording, BLUNT, part).begun(
        [[*recording.y[span.start], 0.0, 0.0] for span in part], np.full(4, 0.5)).run(
            BLUNT, torque) for part in (spans, *([span] for span in spans))]
    assert runs[0].deviance == pytest.approx(sum(run.deviance for run in runs[1:]), rel=1e-9)
    for span, run in zip(spans, runs[1:]):
        np.testing.assert_allclose(runs[0].trace.innovation[span], run.trace.innovation[span],
                                   rtol=0.0, atol=1e-12)


def parabolas(dt, count, off=0.0):
    """Return readings [count, 2]: parabolas, and `off` them a wave to which none is a bit like."""
    t = np.arange(count) * dt
    wave = off * np.tile([1.0, -3.0, 3.0, -1.0], count // 4 + 1)[:count]
    return np.column_stack([0.3 - 2.0 * t + 40.0 * t ** 2 + wave,
                            0.1 + 1.5 * t - 30.0 * t ** 2 - 0.5 * wave])


def test_parts_begin_where_the_parabola_of_their_first_readings_does():
    """As uncertain as the worst of them; four readings at least, none of the next part."""
    dt, spans = 0.02, [slice(5, 9), slice(20, 40)]
    y = np.full((40, 2), 9.0)
    y[5:9], y[20:24] = parabolas(dt, 4), 2.0 * parabolas(dt, 4, 5e-3)
    recording = UniformRecording(np.arange(40) * dt, np.arange(40) % 3 - 1.0, y, dt)
    likelihood = likelihood_of(recording, BLUNT, spans)
    states = likelihood.run(BLUNT, np.full(2, 0.1)).start.states
    at = [0.3, 0.1, -2.0, 1.5]
    assert states[0, :4] == pytest.approx(at)
    wave = 2.0 * np.array([5e-3, -2.5e-3])
    assert states[1, :4] == pytest.approx(2.0 * np.array(at))
    variance = np.maximum(SIGMA ** 2, 5.0 * wave ** 2)
    expected = [*(4.0 * variance + 1e-10),
                *(SPEED_ERROR ** 2 + variance / (0.25 * BEGIN) ** 2)]
    assert likelihood.begin_variance == pytest.approx(expected)
    assert likelihood_of(recording, BLUNT, spans[:1]).begin_variance[:2] == pytest.approx(
        4.0 * SIGMA ** 2 + 1e-10)
    y = np.concatenate([parabolas(DT, 40), np.full((50, 2), 9.0)])
    many = likelihood_of(UniformRecording(np.arange(90) * DT, np.arange(90) % 3 - 1.0, y, DT),
                         BLUNT)
    assert many.begin_variance[:2] == pytest.approx(4.0 * SIGMA ** 2 + 1e-10)
    for rigid, columns in (((0, 1), [0, 1]), ((1,), [1])):
        one = InnovationLikelihood(replace(recording, channels=rigid), BLUNT.with_(kind='rigid'),
                                   SIGMA, spans)
        states = one.run(one.nominal, np.full(2, 0.1)).start.states
        mean = np.array(at).reshape(2, 2)[:, columns].mean(axis=1)
        assert states[0, :4] == pytest.approx(np.repeat(mean, 2))
        worst = np.array(expected).reshape(2, 2)[:, columns].max(axis=1)
        assert one.begin_variance == pytest.approx(np.repeat(worst, 2))


@pytest.mark.parametrize('channel', [0, 1])
def test_a_hidden_side_may_be_a_twist_and_its_whole_speed_off(channel):
    dt = 0.02
    y = parabolas(dt, 40)[:, [channel, channel]]
    u = 3.0 * (np.arange(40) % 2)
    recording = UniformRecording(np.arange(40) * dt, u, y, dt, channels=(channel,))
    likelihood = likelihood_of(recording, BLUNT)
    extra = likelihood.begin_variance - likelihood_of(
        replace(recording, channels=(0, 1)), BLUNT).begin_variance
    gear = BLUNT.transmission
    expected = np.zeros(4)
    expected[[1 - channel, 3 - channel]] = [
        (gear.half_gap + 1.5 / gear.stiffness) ** 2, np.var(np.gradient(y[:, 0], dt))]
    assert extra == pytest.approx(expected, abs=1e-12)


def test_torque_noise_is_of_the_size_of_torque_and_inertia():
    """The least moves an inertia in 1 s by a share of the encoders' noise, as its double sum."""
    recording = recorded(BLUNT, 0.5)
    likelihood = likelihood_of(recording, BLUNT)
    torque = np.std(recording.u)
    assert likelihood.first_noise == pytest.approx([FIRST_NOISE * torque] * 2)
    assert likelihood.most_noise == pytest.approx(MOST * torque)
    idle = likelihood_of(replace(recording, u=0.0 * recording.u), BLUNT)
    assert idle.first_noise == pytest.approx([FIRST_NOISE * 1e-3] * 2)
    assert idle.most_noise == pytest.approx(MOST * 1e-3)
    count = round(1.0 / DT)
    moves = DT * DT * np.sqrt(np.sum(np.arange(count) ** 2.0))  # rad, of 1 N m on 1 kg m^2
    inertia = np.array([BLUNT.motor_inertia, BLUNT.arm_inertia])
    assert likelihood.least_noise * moves / inertia == pytest.approx(STRAY * SIGMA[0], rel=2e-3)
    arm = InnovationLikelihood(replace(recording, channels=(1,)), BLUNT, SIGMA, [slice(0, 500)])
    assert arm.least_noise * moves / inertia == pytest.approx(STRAY * SIGMA[1], rel=2e-3)
    rigid = likelihood_of(recording, BLUNT.with_(kind='rigid'))
    assert rigid.least_noise * moves / inertia.sum() == pytest.approx(STRAY * SIGMA[0], rel=2e-3)


def test_beside_torque_that_lasts_readings_are_some_20_ms_apart():
    for dt, every in ((1e-3, 20), (8e-3, 2), (0.05, 1)):
        recording = replace(recorded(BLUNT, 0.2), dt=dt)
        likelihood = likelihood_of(recording, replace(BLUNT, process_torque_time=0.3),
                                   [slice(0, 101), slice(101, 150)])
        assert likelihood.every == every and likelihood.fade == pytest.approx(np.exp(-dt / 0.3))
        assert likelihood.readings == 2 * (148 // every)
        one = replace(recording, channels=(1,))
        assert likelihood_of(one, BLUNT, [slice(0, 101), slice(101, 150)]).readings == 148
        assert likelihood_of(one, BLUNT).changed(every=3).readings == 199 // 3
        assert likelihood_of(one, BLUNT).fade == 0.0


def test_each_memory_of_the_drive_is_estimated_on_its_own_scale():
    recording = recorded(BLUNT, 0.1)
    torque = np.std(recording.u)

    def begun(model):
        """Return {place: standard deviation} of the memories."""
        start = likelihood_of(recording, model).run(model, np.full(2, 0.1)).start
        sizes = np.sqrt(np.diag(start.covariance))[4:]
        assert start.places[:4].tolist() == [0, 1, 2, 3]
        assert start.moves[4:] == pytest.approx(MEMORY_MOVE * sizes)
        return dict(zip(start.places[4:].tolist(), sizes))
    assert begun(BLUNT) == {}
    lugre = {'id': 'lugre', 'Cs': 0.1, 'vs': 0.5, 'sigma0': 90.0, 'sigma1': 0.5}
    loop = {'id': 'hysteresis_bouc_wen', 'Th': 0.2, 'dh': 0.02}
    lasting = replace(BLUNT, effects=(lugre, loop), process_torque_time=0.3)
    assert begun(lasting) == pytest.approx({
        N_STATE: torque, 4 + MEMORIES['lugre']: BLUNT.coulomb_friction / 90.0,
        4 + MEMORIES['hysteresis_bouc_wen']: 1.0})
    for changes, memories in (({'ki': 2.0}, [0]), ({'delay': 2e-3}, [1, 2, 3]),
                              ({'rate': 200.0}, [1, 2, 3]), ({}, [])):
        servo = replace(BLUNT, controller=Controller(kp=2.0, kd=0.1, **changes))
        assert begun(servo) == pytest.approx({4 + INTEGRAL + i: torque for i in memories})


def test_the_motion_of_a_run_is_that_of_its_parts():
    recording = recorded(LINEAR, 0.2)
    likelihood = likelihood_of(recording, LINEAR, [slice(20, 90), slice(110, 200)])
    run = likelihood.run(LINEAR, np.full(2, 0.1))
    motion = likelihood.motion(run)
    index = np.r_[20:89, 110:199]
    assert motion['time'] == pytest.approx(index * DT)
    np.testing.assert_array_equal(motion['torque'], recording.u[index])
    np.testing.assert_array_equal(motion['speed of the motor'], run.trace.begin[index, 0, 2])
    assert np.abs(motion['angle of the motor'] - recording.y[index, 0]).max() < 6e-3
    assert np.abs(motion['angle of the arm'] - recording.y[index, 1]).max() < 12e-3
    np.testing.assert_array_equal(
        motion['twist'], motion['angle of the motor'] - motion['angle of the arm'])
    np.testing.assert_array_equal(motion['speed of the arm'], run.trace.begin[index, 0, 3])


def test_parts_are_halved_in_the_middle_of_each():
    assert halves([slice(3, 10), slice(20, 30)]) == [
        slice(3, 6), slice(6, 10), slice(20, 25), slice(25, 30)]


def test_recordings_of_one_drive_count_together_each_with_its_own_encoders():
    first, second = recorded(LINEAR, 0.2), recorded(LINEAR, 0.3, seed=5)
    second = replace(second, u=2.0 * second.u[::2], y=second.y[::2], dt=2.0 * DT, channels=(1,))
    parts = [InnovationLikelihood(first, LINEAR, SIGMA, [slice(0, 120), slice(120, 200)]),
             InnovationLikelihood(second, LINEAR, 0.3 * SIGMA, [slice(10, 150)])]
    both, noise = JointLikelihood(parts), np.array([0.3, 0.1])
    assert both.readings == 2 * 198 + 139
    assert both.most_noise == parts[1].most_noise > parts[0].most_noise
    assert both.first_noise.tolist() == parts[1].first_noise.tolist()
    assert both.least_noise.tolist() == parts[1].least_noise.tolist()
    assert (parts[0].least_noise > parts[1].least_noise).all()
    run, runs = both.run(LINEAR, noise), [part.run(LINEAR, noise) for part in parts]
    assert run.deviance == pytest.approx(sum(own.deviance for own in runs), rel=1e-12)
    for name in ('innovation', 'variance', 'read', 'residual'):
        np.testing.assert_array_equal(
            getattr(run, name), np.concatenate([getattr(own, name) for own in runs]))
    moved = LINEAR.with_(viscous_friction=0.11)
    np.testing.assert_array_equal(both.change(run, moved), np.concatenate(
        [part.change(own, moved) for part, own in zip(parts, runs)]))
    other = both.with_noise(run, 2.0 * noise)
    others = [part.with_noise(own, 2.0 * noise) for part, own in zip(parts, runs)]
    assert other[0] == pytest.approx(sum(row[0] for row in others), rel=1e-12)
    for i in (1, 2):
        np.testing.assert_array_equal(other[i], np.concatenate([row[i] for row in others]))
    for own, part, alone in zip(both.smoothed(run), parts, runs):
        np.testing.assert_array_equal(own, part.smoothed(alone))


@pytest.mark.parametrize('kind, size', [('play', 0.02 * BLUNT.transmission.stiffness),
                                        ('passive_play', 0.02), ('dead_zone', None)])
def test_where_in_its_hysteresis_a_drive_begins_is_open(kind, size):
    """As wide as the loop: torque where it adds to the curve, twist where it shifts it."""
    model = BLUNT.with_(kind=kind, hysteresis_width=0.02)
    start = likelihood_of(recorded(BLUNT, 0.1), model).run(model, np.full(2, 0.1)).start
    assert len(start.places) == (4 if size is None else 5)
    if size is not None:
        assert start.covariance[4, 4] == pytest.approx(size ** 2)


FROZEN = [
    ({'id': 'stribeck', 'Cs': 0.1, 'vs': 0.5}, 'vs', 0.02),
    ({'id': 'hysteresis_bouc_wen', 'Th': 0.2, 'dh': 0.02}, 'dh', 0.02),
    ({'id': 'arm_encoder_eccentricity', 'A': 0.05, 'phi': 0.4}, 'phi', 0.02),
    ({'id': 'motor_encoder_eccentricity', 'A': 0.3, 'phi': 0.4}, 'phi', 0.02),
    ({'id': 'viscous_drift', 'r': 4.0, 'T': 0.01}, 'T', 1e-3),
    ({'id': 'actuator_lag', 'T': 0.004}, 'T', 0.02),
    # Corrections move in time as well, which is left out: they are white.
    ({'id': 'motor_encoder_delay', 'T': 0.0034}, 'T', 0.2),
    ({'id': 'arm_encoder_delay', 'T': 0.0034}, 'T', 0.2)]


def expect_sensitivities(effect, name, tolerance):
    late = {'id': 'motor_encoder_delay', 'T': 4e-4}  # that friction drifts shows within a sample
    others = [late] if name == 'T' and effect['id'] == 'viscous_drift' else []
    model, side = replace(BLUNT, effects=(effect, *others)), effect['id'].startswith('arm')
    recording = recorded(model, 0.3)
    likelihood = likelihood_of(recording, model)
    run = likelihood.run(model, [0.05, 0.05])

    def innovations(value):
        """Return the innovations [K, 2] that the gains of `run` lead to."""
        drive = PackedDrive(model.pack(), effects.pack([{**effect, name: value}, *others]),
                            np.zeros(0))
        u = likelihood.simulator.acting(drive.e)
        n, parts = u.shape[1], schedule(drive.e, DT, u.shape[1], (0, 1))
        none = ProcessNoise(np.zeros((1, 4)), np.zeros(4))
        x, out = run.start.states[0].copy(), np.zeros((300, 2))
        for k in range(299):
            at, m = 0.0, 0
            for h, part, end in zip(parts.length, parts.part, parts.ends):
                advance(x, k * DT + at, h, u[k, part:part + 1], (0.0, 0.0, 0.0), none, drive, 0.0)
                at += h
                for i in (0, 1) if end >= 0 else ():
                    if not parts.reads[m, i] or k + 1 + parts.shift[i] >= 300:
                        continue
                    error = (effect['A'] * np.sin(x[i] + value) if name == 'phi' and i == side
                             else 0.0)
                    out[k, i] = recording.y[k + 1 + parts.shift[i], i] - x[i] - error
                    x[run.start.places] += run.trace.gain[k, i] * out[k, i]
                m += end >= 0
        assert n == likelihood.simulator.n
        return out
    step = 1e-5 * effect[name]
    difference = (innovations(effect[name] + step) - innovations(effect[name] - step)) / 2.0
    moved = replace(model, effects=({**effect, name: effect[name] + step}, *others))
    change = likelihood.change(run, moved)
    assert innovations(effect[name]) == pytest.approx(run.trace.innovation, abs=1e-9)
    assert np.abs(change - difference).max() < tolerance * np.abs(difference).max()


def test_sensitivities_are_those_of_a_filter_with_frozen_gains():
    for effect, name, tolerance in FROZEN:
        expect_sensitivities(effect, name, tolerance)


def test_no_other_torque_noise_of_either_side_is_likelier():
    for start in ((1e-3, 3.0), (3.0, 1e-3), (0.05, 0.05)):
        recording = recorded(BLUNT, 0.8)
        stray = np.array([3e-3, 2e-3]) * np.random.default_rng(3).standard_normal((800, 2))
        recording = replace(recording, y=recording.y + np.cumsum(np.cumsum(stray, 0), 0) * 0.02)
        likelihood = likelihood_of(recording, BLUNT)
        none = Starts(BLUNT, [recording]).none()
        fit = evaluated(likelihood, InnovationFit(none, none.start(), np.array(start)))
        torque = annealed(likelihood, fit)
        lowest = likelihood.with_noise(fit.run, torque)[0]
        assert (likelihood.least_noise < torque).all() and (torque < likelihood.most_noise).all()
        for sides in ([True, True], [True, False], [False, True]):
            for factor in (1.0 / 1.5, 1.5):
                trial = np.where(sides, factor, 1.0) * torque
                assert likelihood.with_noise(fit.run, trial)[0] >= lowest - 0.02


def test_late_encoders_are_read_at_their_own_time_within_a_sample():
    e = effects.pack([{'id': 'motor_encoder_delay', 'T': 0.0034}])
    line = schedule(e, DT, 2, (0, 1))
    assert line.shift.tolist() == [3, 0] and line.span == pytest.approx([0.6e-3, 0.4e-3])
    assert line.length == pytest.approx([0.5e-3, 0.1e-3, 0.4e-3])
    assert line.part.tolist() == [0, 1, 1] and line.ends.tolist() == [-1, 0, 1]
    assert line.reads.tolist() == [[1, 0], [0, 1]]
    whole = schedule(effects.pack([{'id': 'arm_encoder_delay', 'T': 0.002}]), DT, 1, (0, 1))
    assert whole.shift.tolist() == [0, 2] and whole.reads.tolist() == [[1, 1]]


SCHEDULES = [
    ((0.0, 0.0), 3, (0, 1), [1.0], [1 / 3, 2 / 3, 1.0], [0, 1, 2], [-1, -1, 0], [[1, 1]], [0, 0]),
    ((3.4, 1.7), 2, (0, 1), [0.3, 0.6, 1.0], [0.3, 0.5, 0.6, 1.0], [0, 0, 1, 1], [0, -1, 1, 2],
     [[0, 1], [1, 0], [0, 0]], [3, 1]),
    ((0.4, 2.4), 1, (0, 1), [0.6, 1.0], [0.6, 1.0], [0, 0], [0, 1], [[1, 1], [0, 0]], [0, 2]),
    ((0.4, 0.2), 1, (1,), [0.8, 1.0], [0.8, 1.0], [0, 0], [0, 1], [[0, 1], [0, 0]], [0, 0]),
    # As good as together: an edge of a part with a reading, both encoders, a whole sample.
    ((1 / 3, 0.0), 3, (0, 1), [2 / 3, 1.0], [1 / 3, 2 / 3, 1.0], [0, 1, 2], [-1, 0, 1],
     [[1, 0], [0, 1]], [0, 0]),
    ((0.5 - 5e-7, 0.5 + 3e-7), 2, (0, 1), [0.5, 1.0], [0.5, 1.0], [0, 1], [0, 1],
     [[1, 1], [0, 0]], [0, 0]),
    ((0.5 - 5e-6, 0.5), 1, (0, 1), [0.5, 0.5 + 5e-6, 1.0], [0.5, 0.5 + 5e-6, 1.0], [0, 0, 0],
     [0, 1, 2], [[0, 1], [1, 0], [0, 0]], [0, 0]),
    ((2.0 - 5e-7, 1.0 + 5e-7), 1, (0, 1), [1.0], [1.0], [0], [0], [[1, 1]], [2, 1]),
    ((2.0 - 5e-6, 1.0 + 5e-6), 1, (0, 1), [5e-6, 1.0 - 5e-6, 1.0], [5e-6, 1.0 - 5e-6, 1.0],
     [0, 0, 0], [0, 1, 2], [[1, 0], [0, 1], [0, 0]], [1, 1])]


def test_steps_of_a_sample_end_where_torque_changes_and_encoders_read():
    """All in samples."""
    for late, parts, channels, segments, edges, part, ends, reads, shift in SCHEDULES:
        dt = 2e-3
        e = effects.pack([{'id': f'{side}_encoder_delay', 'T': T * dt}
                          for side, T in zip(('motor', 'arm'), late) if T])
        line = schedule(e, dt, parts, channels)
        assert line.span / dt == pytest.approx(np.diff([0.0, *segments]), abs=9e-7)
        assert line.length / dt == pytest.approx(np.diff([0.0, *edges]), abs=9e-7)
        assert line.part.tolist() == part and line.ends.tolist() == ends
        assert line.reads.tolist() == reads and line.shift.tolist() == shift


def test_the_true_effect_is_proposed_and_fitted_from_nothing_and_the_noise_vanishes():
    truth = {'id': 'hysteresis_bouc_wen', 'Th': 0.15, 'dh': 0.03}
    recording = recorded(replace(BLUNT, effects=(truth,)), 3.0, seed=2)
    likelihood = likelihood_of(recording, BLUNT, [slice(0, 2500)])
    starts = Starts(BLUNT, [recording])
    none = starts.none()
    without = fitted(likelihood, InnovationFit(none, none.start(), np.full(2, 0.1)))
    proposals = scan(likelihood, starts, without, [truth['id'], 'arm_coulomb', 'gravity',
                                                   'torque_gain', 'cogging'])
    assert proposals[0].name == truth['id']
    begun = min((evaluated(likelihood, trial).alone() for trial in joined(
        starts, without, proposals[0])), key=lambda f: f.deviance)
    fit = fitted(likelihood, begun, 20)
    _, (values,) = fit.candidate.values(fit.z)
    assert values['Th'] == pytest.approx(truth['Th'], rel=0.05)
    assert values['dh'] == pytest.approx(truth['dh'], rel=0.2)
    assert fit.deviance < without.deviance - 100.0
    assert fit.torque[0] < 0.02 < without.torque.max()
    # What is left is noise: as many squares as readings, within three standard deviations.
    run = likelihood.run(fit.model, fit.torque)
    assert run.residual[run.trace.slope != 0.0].var() == pytest.approx(
        1.0, abs=3.0 * np.sqrt(2.0 / likelihood.readings))


def test_noise_that_is_not_free_stays_below_all_bounds_while_values_move():
    recording = recorded(replace(BLUNT, viscous_friction=0.15), 1.0, seed=3)
    likelihood = likelihood_of(recording, BLUNT)
    candidate = Starts(BLUNT, [recording]).candidates('motor_viscous')[0]
    torque = 1e-3 * likelihood.least_noise
    fit = fitted(likelihood, InnovationFit(candidate, candidate.start(), torque),
                 free_noise=False)
    np.testing.assert_array_equal(fit.torque, torque)
    assert candidate.values(fit.z)[1][0]['Cv'] == pytest.approx(0.15, rel=0.02)
