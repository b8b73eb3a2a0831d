# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Tuning through the command line and its parts; no ROS, no truth needed."""
import json
import math

from drives import samples_of
import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.estimation import noise_search
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.score import run_score, score, settled
from gearbox_monitor.estimation.tune import tune, tuned
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.write import BagWriter

JOINT_STATE = 'sensor_msgs/msg/JointState'
T0 = 1_700_000_000_000_000_000
DT = 1e-3
R = (0.0658, 0.0833)
DRIVE = DriveModel().with_(kind='play', stiffness=5.0, half_gap=0.3, hysteresis_width=0.3)


def simulated(seed, n=6000, rest=0, r=R):
    u = Excitation().torque(DT * np.arange(n))
    u[:rest] = 0.0
    process = (0.0, 0.0, 0.0, 0.0) if rest else (0.066, 0.083, 0.387, 0.478)
    return simulate(DRIVE, u, DT, Noise(process, r), seed)


def write(path, drive):
    stamps = T0 + np.arange(len(drive.u)) * 1_000_000
    ours = encode_joint_states(stamps, ['motor', 'arm'], drive.y,
                               effort=np.column_stack([drive.u, np.full(len(stamps), np.nan)]))
    truth = encode_joint_states(stamps, ['transmission'], drive.x[:, :1] - drive.x[:, 1:2],
                                effort=drive.tau_k[:, None])
    with BagWriter(path) as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        writer.add_topic('/plant/transmission_state', JOINT_STATE)
        for k, stamp in enumerate(stamps.tolist()):
            writer.write('/joint_states', stamp, ours[k])
            writer.write('/plant/transmission_state', stamp, truth[k])
    return path


def params(path, **values):
    path.write_text(yaml.safe_dump({'estimator': {'ros__parameters': {
        'arm_load': 'none', **values}}}))
    return str(path)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp('tune') / 'bag', simulated(3))


def test_noise_from_fourth_differences_is_model_free():
    y = simulated(1).y
    assert noise_search.noise_of(y[:, 0]) == pytest.approx(R[0], rel=0.04)
    grid = np.round(np.cumsum(np.full(5000, 0.001)) / 0.05) * 0.05  # slow, on a coarse grid
    assert noise_search.noise_of(grid) == pytest.approx(0.05 / np.sqrt(12.0))


def test_rest_is_found_where_it_is_and_only_there():
    moving, resting = simulated(2), simulated(2, rest=1500)
    stamps = samples_of(moving).stamp_ns
    assert noise_search.at_rest(stamps, moving.y) is None
    spiky = resting.y.copy()
    spiky[700, 0] += 30.0 * R[0]
    noise, seconds = noise_search.at_rest(stamps, spiky)
    assert noise == pytest.approx(R, rel=0.06)
    assert 0.6 <= seconds <= 1.6
    drifting = resting.y + np.linspace(0.0, 60.0, len(stamps))[:, None]  # 10 rad/s
    assert noise_search.at_rest(stamps, drifting) is None


@pytest.mark.system
def test_one_command_writes_what_replay_loads(bag, tmp_path, capsys, monkeypatch):
    """Far-off starts give the same file; the truth is not read."""
    read = []
    original = BagReader.joint_states
    monkeypatch.setattr(BagReader, 'joint_states', lambda self, topic, names: (
        read.append(topic), original(self, topic, names))[1])
    found = []
    for k, scale in enumerate((1.0 / 30.0, 30.0)):
        start = params(tmp_path / f'start{k}.yaml', q_std_tau_k=9.0 * scale)
        out = tmp_path / f'out{k}.yaml'
        assert main(['fit', 'noise', str(bag), '--params', start, '--out', str(out),
                     '--fix-speeds', '--json']) == 0
        told = json.loads(capsys.readouterr().out)
        found.append(told['parameters'])
        assert told['after']['loglik'] > told['before']['loglik']
    assert set(read) == {'/joint_states'}
    for name, value in found[0].items():
        assert value == pytest.approx(found[1][name], rel=0.03)  # the stated tolerance
    assert told['starts_met'] == 3 and told['spread'] < 0.03
    assert found[0]['r_std_motor'] == pytest.approx(R[0], rel=0.04)
    assert found[0]['r_std_arm'] == pytest.approx(R[1], rel=0.04)
    assert 6.0 < found[0]['q_std_tau_k'] < 13.0
    written = yaml.safe_load(out.read_text())['estimator']['ros__parameters']
    assert written['arm_load'] == 'none' and written['q_std_tau_k'] == found[1]['q_std_tau_k']
    assert told['tau_k_model'] == written['tau_k_model'] == 'mixed'  # nobody has stated a law
    walk = params(tmp_path / 'walk.yaml', **found[1])
    replayed = []
    for file in (str(out), walk):
        assert main(['replay', str(bag), '--params', file, '--json']) == 0
        replayed.append(json.loads(capsys.readouterr().out))
        assert replayed[-1]['nis'] == pytest.approx(2.0, abs=0.1)
    errors = [data['tau_k_error'] for data in replayed]
    assert errors[0] < 0.3 * errors[1]


def test_tuned_on_one_seed_good_on_others():
    """Limits a little wider than those of 20 runs of 20 s: these are few and short."""
    parameters = tuned(DRIVE, {'arm_load': 'none'}, [samples_of(simulated(11, 10000))])
    for seed in (21, 22):
        drive = simulated(seed, 10000)
        samples = samples_of(drive)
        estimates = Estimator(DRIVE, parameters).run(samples)
        result = score(estimates)
        error = estimates.tau_k - drive.tau_k[np.isin(samples.stamp_ns, estimates.stamp_ns)]
        assert np.sqrt(np.mean(error[settled(estimates.stamp_ns)] ** 2)) < 1.25
        assert result.rms[0] < 0.073 and result.rms[1] < 0.088 and 1.9 < result.nis < 2.12


def test_rest_gives_r():
    samples = samples_of(simulated(5, rest=1500))
    motion = noise_search.describe(samples.stamp_ns, samples.u[:, 0], samples.y)
    assert motion.standstill_seconds > 0.5
    assert motion.standstill_noise == pytest.approx(R, rel=0.08)
    samples = samples_of(simulated(5))
    motion = noise_search.describe(samples.stamp_ns, samples.u[:, 0], samples.y)
    assert motion.standstill_noise is None


@pytest.mark.system
def test_rest_gives_r_by_the_command(tmp_path, capsys):
    bag = write(tmp_path / 'bag', simulated(5, rest=1500))
    assert main(['fit', 'noise', str(bag), '--params', params(tmp_path / 'start.yaml'),
                 '--fix-speeds', '--json', '--out', str(tmp_path / 'out.yaml')]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['noise_from'] == 'standstill' and told['rest_seconds'] > 0.5
    assert told['parameters']['r_std_motor'] == pytest.approx(R[0], rel=0.08)


def test_parameters_are_never_less_likely_than_those_before():
    """The encoders are much quieter at rest than in motion: R at rest is the wrong one."""
    samples = samples_of(simulated(2, n=6000, rest=1500))
    y = samples.y.copy()
    y[:1500] = y[0] + 0.02 * (y[:1500] - y[:1500].mean(axis=0))
    quiet = Samples(*(column[::5] for column in (samples.stamp_ns, samples.u, y)))
    start = EstimatorParameters(arm_load='none', r_std_motor=R[0], r_std_arm=R[1],
                                q_std_tau_k=9.0)
    data = tune(DriveModel(), start, [quiet], speeds=False)
    assert data['noise_from'] == 'likelihood' and not data['kept']
    assert data['after']['loglik'] >= data['before']['loglik']


def test_all_recordings_count_together():
    """Of two with different noise, R is the root mean square."""
    start = EstimatorParameters(arm_load='none')
    recordings = [samples_of(simulated(seed, n=5500, r=(k * R[0], k * R[1])))
                  for seed, k in ((21, 1.0), (22, 2.0))]
    found = tune(DRIVE, start, recordings, speeds=False)
    assert found['noise_from'] == 'likelihood' and not found['diverged_evaluations']
    for name, r in zip(noise_search.R_NAMES, R):
        assert found['parameters'][name] == pytest.approx(math.sqrt(2.5) * r, rel=0.04)


def test_search_survives_a_filter_that_cannot_run():
    """A criterion of -inf on half of the plane is a penalty, and counted."""
    def evaluate(trial, coarse):
        x, nothing = np.log([trial['q_std_tau_k']]), np.full(1, np.nan)
        if x > 1.0:
            return noise_search.Trial(-np.inf, 1, nothing, nothing, nothing)
        return noise_search.Trial(-50.0 * float(x @ x), 0, 10.0 * x, np.ones(1), 10.0 * x)

    found = noise_search.search(evaluate, {'q_std_tau_k': 2.0})
    assert found.parameters['q_std_tau_k'] == pytest.approx(1.0, rel=0.01)
    assert found.failed > 0


def test_one_more_parameter_is_searched_within_its_grid():
    """Bounds are 1/1000 and 30 times the guess; what is above 30 cannot run."""
    for best, expected in ((0.37, 0.37), (20.0, 20.0), (1e-6, 0.002)):
        def evaluate(trial):
            assert trial['r_std_motor'] == 0.005
            v = trial['q_std_tau_k_deviation']
            return math.nan if v > 30.0 else -10.0 * math.log(v / best) ** 2, v > 30.0
        others = noise_search.Tuned({'r_std_motor': 0.005}, 1.0, {'r_std_motor': 0.1}, 40, 2)
        result = noise_search.with_another(others, evaluate, 'q_std_tau_k_deviation', 2.0)
        assert result.parameters['r_std_motor'] == 0.005 and result.error == others.error
        assert result.parameters['q_std_tau_k_deviation'] == pytest.approx(expected, rel=0.12)
        assert result.evaluations > 40 and result.failed >= 2


def test_a_rough_criterion_is_climbed_near_the_optimum():
    """Ripples of 5 units on a paraboloid: the end is no worse than the start, and near it."""
    def evaluate(trial):
        x = np.array([math.log(trial['a'] / 2.0), math.log(trial['b'] / 3.0)])
        return float(-0.5 * x @ x / 0.01 + 5.0 * np.sin(200.0 * x.sum())), False
    start = noise_search.Tuned({'a': 2.0, 'b': 3.0}, 0.0, {'a': 0.1, 'b': 0.1}, 7)
    result = noise_search.polished(start, evaluate)
    assert result.value == evaluate(result.parameters)[0] > evaluate(start.parameters)[0] + 3.0
    assert abs(math.log(result.parameters['a'] / 2.0)) < 0.2
    assert result.evaluations == 7 + 2 * noise_search.TRIALS


def test_a_filter_that_cannot_run_scores_worst():
    drive = simulated(1, 1500)
    samples = samples_of(drive)
    broken = Samples(samples.stamp_ns, samples.u, np.full_like(samples.y, np.nan))
    assert run_score(DRIVE, {'arm_load': 'none'}, broken).criterion == noise_search.DIVERGED


WRONG = [
    (['--filter', 'kalman'], "filter: 'kalman', expected one of aekf, ekf"),
    (['--params', 'zero_r'], 'r_std_motor: 0.0, expected a number >= 1e-09'),
    (['--params', 'zero_q'], 'q_std_tau_k: 0, expected > 0'),
    (['--params', 'zero_q', '--out', 'there.yaml'], 'exists, expected a new file'),
    (['--out', 'missing/out.yaml'], 'no such folder'),
]


def test_bad_input_is_one_line(bag, tmp_path, capsys, monkeypatch):
    for options, words in WRONG:
        monkeypatch.chdir(tmp_path)
        (tmp_path / 'there.yaml').touch()
        params(tmp_path / 'zero_r', r_std_motor=0.0)
        params(tmp_path / 'zero_q', q_std_tau_k=0.0)
        assert main(['fit', 'noise', str(bag), '--out', 'out.yaml', *options]) == 2
        said = capsys.readouterr().err
        assert words in said and said.count('\n') == 1
        assert not (tmp_path / 'out.yaml').exists()


USELESS = [
    (2000, 1.0, 'too short to tune; expected at least 5 s'), (6000, 0.0, 'no excitation')]


def test_useless_recordings_are_refused(tmp_path, capsys):
    for n, torque, words in USELESS:
        u = torque * Excitation().torque(DT * np.arange(n))
        bag = write(tmp_path / words, simulate(DRIVE, u, DT, Noise(measurement=R), seed=1))
        assert main(['fit', 'noise', str(bag), '--out', str(tmp_path / 'out.yaml')]) == 2
        said = capsys.readouterr().err
        assert words in said and str(bag) in said and said.count('\n') == 1
