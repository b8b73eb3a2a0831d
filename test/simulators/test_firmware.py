# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The filter in C: same codes and estimates as the Estimator, same flags, no libm."""
import ctypes
import math
from pathlib import Path
import re
import shutil
import subprocess

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, S_MOTOR_SIDE, S_TWIST, S_U, S_X3
from gearbox_monitor.files.opening import config_path
from gearbox_monitor.health.elastic_regression import (
    data_of, ElasticLaw, N_SHAPE, normal_equations)
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.simulators.c99 import firmware

COLUMNS = ('tau_k', 'tau_k_std', 'tau_k_noise_std', 'twist', 'twist_std', 'twist_rate', 'x3',
           'innovation_motor', 'innovation_arm', 'nis')
FLAGS = ('-std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -Wconversion -Wdouble-promotion '
         '-fPIC').split()
FUNCTIONS = """
#include "drive.c"
void values(int n, const double *x, double *out)
{
    for (int i = 0; i < n; i++) {
        out[2 * i] = (double)root((gm_real)x[i]);
#if GM_TANH
        out[2 * i + 1] = (double)sine((gm_real)x[i]);
#else
        out[2 * i + 1] = (double)arc_tangent((gm_real)x[i]);
#endif
    }
}
double friction_share(double v) { return (double)side((gm_real)v); }
"""
OUT = {'smoother_lag': 0.0, 'narrow_std': False}
needs_gcc = pytest.mark.skipif(shutil.which('gcc') is None, reason='gcc is not installed')


def built(folder, model, parameters, real='double'):
    folder.mkdir(exist_ok=True)
    text = firmware(model, parameters, 'drive.h')
    (folder / 'drive.c').write_text(text.source)
    (folder / 'drive.h').write_text(text.header)
    library = folder / f'{real}.so'
    subprocess.run(['gcc', *FLAGS, f'-DGM_REAL={real}', f'-I{folder}', '-shared', '-o', library,
                    folder / 'drive.c', Path(__file__).with_name('firmware_batch.c')], check=True)
    return ctypes.CDLL(str(library))


def functions(folder, model, real):
    """Return a call of the square root, and of the arctangent or (with tanh) sine; and side."""
    built(folder, model, OUT, real)
    (folder / 'functions.c').write_text(FUNCTIONS)
    library = folder / f'functions_{real}.so'
    subprocess.run(['gcc', '-std=c99', '-O2', '-fPIC', '-shared', '-fsanitize=undefined',
                    '-fsanitize=float-cast-overflow', '-fsanitize-undefined-trap-on-error',
                    f'-DGM_REAL={real}', '-o', library, folder / 'functions.c'], check=True)
    compiled = ctypes.CDLL(str(library))
    compiled.friction_share.restype = ctypes.c_double
    compiled.friction_share.argtypes = [ctypes.c_double]

    def values(x):
        x, out = np.ascontiguousarray(x, float), np.zeros((len(x), 2))
        compiled.values(len(x), pointer(x), pointer(out))
        return out.T
    return values, compiled.friction_share


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def fresh(library):
    state = ctypes.create_string_buffer(library.filter_size())
    library.gm_init(state)
    return state


def run(library, stamps, u, y, state=None, window=None):
    n = len(stamps)
    codes, flags = np.zeros(n, np.int32), np.zeros(n, np.int32)
    out, inputs = np.full((n, 13), np.nan), np.ascontiguousarray(np.column_stack([u, y]))
    library.batch(state or fresh(library), window, n, pointer(np.ascontiguousarray(stamps)),
                  pointer(inputs), pointer(codes), pointer(flags), pointer(out))
    return codes, flags, out


def recording(n, seed=0):
    """Return stamps, u, y: motion through the backlash, and rest; encoders of unlike noise."""
    rng, t = np.random.default_rng(seed), 1e-3 * np.arange(n)
    turn = np.where(np.floor(t / 3.0) % 3 == 2, 0.0, 1.0)
    motor = np.cumsum(turn * np.cos(2.0 * np.pi * 0.7 * t)) * 1e-3
    arm = motor - 0.11 * np.tanh(5.0 * np.sin(2.0 * np.pi * 0.7 * t + 0.4))
    u = turn * (0.3 * np.cos(2.0 * np.pi * 0.7 * t) + 0.2)
    y = np.column_stack([motor, arm]) + rng.normal(size=(n, 2)) * (4e-4, 7e-4)
    return (np.round((1.0 + t) * 1e9).astype(np.int64),
            np.column_stack([u, np.full(n, np.nan)]), y)


def damaged(stamps, u, y):
    """Return the recording with dropouts, restarts, bad stamps, missing and impossible values."""
    rng, n = np.random.default_rng(1), len(stamps)
    whole = np.ones(n, bool)
    for length, count in ((60, 5), (1500, 2)):
        for at in rng.integers(0, n, count):
            whole[at:at + length] = False
    for at in rng.integers(0, n, 8):
        y[at:at + 20, at % 2] = np.nan
        u[at + 40:at + 60, 0] = np.nan
        y[at + 90] += 3.0
    y[n // 2], u[n // 3] = (np.inf, 1e12), 1e10
    stamps, u, y = stamps[whole], u[whole], y[whole]
    at = 2 * len(stamps) // 5
    u[at:at + 400, 0] = np.nan
    y[at + 500:at + 900] = np.nan
    at += 1000
    stamps[at:at + 3] = 0, stamps[at - 1], stamps[at - 1] - 5
    stamps[at + 100:at + 140] -= 100_000_000  # late messages, so many that the clock is believed
    stamps[at + 200:] -= 600_000_000
    return stamps, u, y


@needs_gcc
@pytest.mark.parametrize('changes, parameters', [
    ({}, {'effort_delay': 3}),
    pytest.param({'friction_law': {'kind': 'tanh'}, 'effects': [
        {'id': 'gravity', 'G': 0.8, 'phi': 0.2}, {'id': 'arm_coulomb', 'Cac': 0.05}]}, {},
        marks=pytest.mark.system),
    pytest.param({}, {'arm_load': 'unknown', 'friction_error_std': 0.1},
                 marks=pytest.mark.system),
    ({}, {'tau_k_model': 'elastic', 'arm_load': 'none'}), ({}, {'arm_joint': ''})],
    ids=['walk', 'loaded', 'unknown', 'elastic', 'one encoder'])
def test_estimates_are_those_of_the_estimator(tmp_path, changes, parameters):
    model, parameters = DriveModel().with_(**changes), {**OUT, **parameters}
    stamps, u, y = damaged(*recording(30_000))
    if parameters.get('arm_joint') == '':
        y[:, 1] = np.nan
    expected = Estimator(model, parameters).run(Samples(stamps, u, y))
    codes, _, out = run(built(tmp_path, model, parameters), stamps, u, y)
    np.testing.assert_array_equal(codes, expected.codes)
    assert set(codes) == {0, 1, 2, 3, 4, 5, 6, 7, 9}
    columns = COLUMNS if parameters.get('arm_joint', 'arm') else ('tau_k', 'tau_k_std')
    for i, name in enumerate(COLUMNS):
        if name in columns:
            wanted = getattr(expected, name)
            bound = (1e-9 if i < 7 else 1e-8) * np.sqrt(np.nanmean(wanted ** 2))
            np.testing.assert_allclose(out[codes == 0, i], wanted, rtol=0.0, atol=bound,
                                       err_msg=name)


@needs_gcc
@pytest.mark.system
@pytest.mark.parametrize('changes, parameters', [
    pytest.param({}, {'tau_k_model': 'learned'}, marks=pytest.mark.xfail(
        reason='a slope that is learned keeps what rounding decided', strict=True)),
    ({'transmission': {'kind': 'play', 'stiffness': 25.0, 'half_gap': 0.1,
                       'hysteresis_width': 0.02}}, {'tau_k_model': 'elastic'})],
    ids=['learned', 'play'])
def test_with_a_play_rounding_decides_only_about_single_deviations(tmp_path, changes, parameters):
    """Where the twist is at the end of its play, either slope is right: tau_K hardly differs."""
    model, parameters = DriveModel().with_(**changes), {**OUT, **parameters}
    stamps, u, y = damaged(*recording(30_000))
    expected = Estimator(model, parameters).run(Samples(stamps, u, y))
    codes, _, out = run(built(tmp_path, model, parameters), stamps, u, y)
    np.testing.assert_array_equal(codes, expected.codes)
    rms = np.sqrt(np.mean(expected.tau_k ** 2))
    assert np.abs(out[codes == 0, COLUMNS.index('tau_k')] - expected.tau_k).max() < 1e-4 * rms


@needs_gcc
@pytest.mark.system
def test_a_million_samples_agree(tmp_path):
    stamps, u, y = damaged(*recording(1_000_000))
    expected = Estimator(DriveModel(), OUT).run(Samples(stamps, u, y))
    codes, _, out = run(built(tmp_path, DriveModel(), OUT), stamps, u, y)
    np.testing.assert_array_equal(codes, expected.codes)
    for name in ('tau_k', 'tau_k_std'):
        wanted = getattr(expected, name)
        error = np.abs(out[codes == 0, COLUMNS.index(name)] - wanted).max()
        assert error < 1e-9 * np.sqrt(np.mean(wanted ** 2)), (name, error)


@needs_gcc
def test_single_precision_is_off_as_far_as_the_page_says(tmp_path):
    stamps, u, y = recording(30_000)
    expected = Estimator(DriveModel(), OUT).run(Samples(stamps, u, y))
    codes, _, out = run(built(tmp_path, DriveModel(), OUT, 'float'), stamps, u, y)
    np.testing.assert_array_equal(codes, expected.codes)
    error = out[codes == 0, COLUMNS.index('tau_k')] - expected.tau_k
    assert np.abs(error).max() < 0.05 * np.sqrt(np.mean(expected.tau_k ** 2))


@needs_gcc
def test_instances_share_nothing_and_begin_anew(tmp_path):
    library = built(tmp_path, DriveModel(), OUT)
    one, two = recording(4000), recording(4000, seed=5)
    alone = run(library, *one)[2]
    a, b = fresh(library), fresh(library)
    parts = []
    for k in range(0, 4000, 500):
        parts.append(run(library, *(v[k:k + 500] for v in one), a)[2])
        run(library, *(v[k:k + 500] for v in two), b)
    np.testing.assert_array_equal(np.concatenate(parts), alone)
    library.gm_init(b)
    np.testing.assert_array_equal(run(library, *one, b)[2], alone)


@needs_gcc
def test_no_symbol_of_libm_or_heap(tmp_path):
    for name, model in (('a', DriveModel()), ('b', DriveModel().with_(
            friction_law={'kind': 'tanh'}, effects=[{'id': 'gravity', 'G': 1.0}]))):
        for real in ('double', 'float'):
            built(tmp_path / name, model, OUT, real)
            done = subprocess.run(
                ['gcc', *FLAGS, f'-DGM_REAL={real}', '-c', 'drive.c', '-o', 'drive.o'],
                cwd=tmp_path / name, check=True)
            done = subprocess.run(['nm', '-u', 'drive.o'], cwd=tmp_path / name, check=True,
                                  capture_output=True, text=True)
            assert set(done.stdout.split()) - {'U', '_GLOBAL_OFFSET_TABLE_'} <= {
                'memcpy', 'memset', '__stack_chk_fail'}


@needs_gcc
@pytest.mark.parametrize('real, bound', [('double', 4e-16), ('float', 2e-7)])
def test_functions_of_one_number(tmp_path, real, bound):
    """Arctangent and root within two units in the last place, relative; no undefined result."""
    values, share = functions(tmp_path, DriveModel(), real)
    x = np.concatenate([np.geomspace(1e-12, 1e12, 200_001), np.linspace(0.3, 3.0, 100_001)])
    x = x.astype(np.float32).astype(float)
    root, arc = values(x)
    assert np.abs(root / np.sqrt(x) - 1.0).max() < bound
    assert np.abs(arc / [math.atan(v) for v in x] - 1.0).max() < bound
    np.testing.assert_array_equal(values(-x)[1], -arc)
    assert values([math.inf])[1] == pytest.approx(0.5 * math.pi)
    assert np.isnan(values([math.nan])[1])
    values, share = functions(tmp_path / 'weight', DriveModel().with_(
        friction_law={'kind': 'tanh'}, effects=[{'id': 'gravity', 'G': 1.0}]), 'double')
    for reach, off in ((3.0, 4e-16), (1e3, 1e-13)):  # rad: pi times the half turns is rounded
        x = np.linspace(-reach, reach, 100_001)
        assert np.abs(values(x)[1] - np.sin(x)).max() < off
    assert np.isnan(values([1e300, -math.inf, math.nan])[1]).all()
    for v in np.linspace(-30.0, 30.0, 2001):
        assert share(v) == pytest.approx(math.tanh(v), abs=1e-15)
    assert share(math.nan) == -1.0  # defined; the speed itself stays NaN


@needs_gcc
def test_window_sums_are_those_of_the_package(tmp_path):
    model = DriveModel()
    library = built(tmp_path, model, OUT)
    stamps, u, y = recording(6000)
    window = ctypes.create_string_buffer(library.window_size())
    theta = np.array([20.0, 0.08, 0.01, 0.002, 0.01, 0.02, 0.03, 0.0])
    library.gm_window_begin(window, pointer(theta), 7)
    codes, _, out = run(library, stamps, u, y, None, window)
    row = out[codes == 0]
    rows = np.zeros((len(row), N_SMOOTHED))
    rows[:, [S_TWIST, S_MOTOR_SIDE, S_X3, S_U]] = row[:, [3, 10, 6, 11]] * (1.0, 1.0, 1.0, -1.0)
    data = data_of(rows, model)
    ratio = (row[:, 6] / (3.0 * row[:, 12])) ** 2
    m = len(row) // 7
    weights = (0.01 + ratio / (1.0 + ratio))[:7 * m].reshape(m, 7).mean(axis=1)
    normal, right = np.zeros((2, N_SHAPE, N_SHAPE)), np.zeros((2, N_SHAPE))
    law = ElasticLaw(False, True, 0.0, (0.0, 0.0, 0.0), 7, True, m, math.inf)
    normal_equations(np.append(theta, np.zeros(N_SHAPE - 8)), np.arange(N_SHAPE) < 7, law, data,
                     weights, np.ones(m), (normal, right, np.zeros((3, N_SHAPE))), np.zeros(m))
    sums = np.zeros(56)
    library.sums(window, pointer(sums))
    np.testing.assert_allclose(sums[:49].reshape(7, 7), np.tril(normal[0, :7, :7]), rtol=1e-9,
                               atol=1e-9)
    np.testing.assert_allclose(sums[49:], right[0, :7], rtol=1e-9, atol=1e-9)


@needs_gcc
def test_page_runs_as_it_stands(tmp_path, capsys):
    page = (Path(__file__).parents[2] / 'docs' / 'firmware.md').read_text()
    main_c, = re.findall(r'```c\n(.*?)```', page, re.DOTALL)
    compile_line = next(line for line in page.splitlines() if line.startswith('gcc '))
    (tmp_path / 'main.c').write_text(main_c)
    assert main(['export', str(config_path('drive.yaml')), '--to', 'c', '--out',
                 str(tmp_path / 'elbow.c')]) == 0
    subprocess.run(compile_line.split(), cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / 'elbow'], capture_output=True, text=True, check=True)
    assert done.stdout.count('tau_K') == 5


@pytest.mark.parametrize('parameters, name', [
    ({'filter': 'ukf'}, 'filter: ukf'), ({'tau_k_model': 'mixed'}, 'tau_k_model: mixed')])
def test_unknown_to_c_is_refused_by_name(parameters, name):
    with pytest.raises(InputError, match=f'^{name}, with --to c expected'):
        firmware(DriveModel(), parameters)


def test_file_of_a_simulator_is_no_model(tmp_path, capsys):
    (tmp_path / 'robot.xml').write_text('<mujoco/>')
    assert main(['export', str(tmp_path / 'robot.xml'), '--to', 'c', '--out',
                 str(tmp_path / 'x.c')]) == 2
    error, = capsys.readouterr().err.splitlines()
    assert error.endswith('robot.xml: the file of a simulator, with --to c expected a model file')
    assert not (tmp_path / 'x.c').exists()


@needs_gcc
def test_flags_are_those_of_the_monitor(tmp_path):
    model, parameters = DriveModel(), OUT
    stamps, u, y = recording(12_000)
    library, monitor = built(tmp_path, model, parameters), Monitor(model, parameters)
    state, seen = fresh(library), set()
    for k in range(0, 12_000, 1000):
        part = slice(k and k + 1, k + 1001)
        _, flags, _ = run(library, stamps[part], u[part], y[part], state)
        monitor.run(Samples(stamps[part], u[part], y[part]))
        values = monitor.outcomes['prediction error'].values
        if 'mean' not in values:
            continue
        raised = {
            4: values['mean'] > values['mean_threshold'],
            8: values['nis_high'] < values['nis_over_dof'] <= values['nis_gross'],
            16: values['nis_over_dof'] < values['nis_low'],
            32: values['nis_over_dof'] > values['nis_gross'],
            64: not 0.7 <= values['variance_ratio_motor'] <= 1.4,
            128: not 0.7 <= values['variance_ratio_arm'] <= 1.4,
            256: values['test_ratio'] > 1.0}
        assert {bit for bit in raised if flags[-1] & bit} == {b for b, on in raised.items() if on}
        seen |= {(bit, bool(on)) for bit, on in raised.items()}
    assert {on for _, on in seen} == {True, False}
