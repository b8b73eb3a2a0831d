# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The filter in C: the bits of the Estimator and of its checks, no library, any processor."""
import ctypes
from functools import cache
from pathlib import Path
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import COLUMNS, Sample, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, S_MOTOR_SIDE, S_TWIST, S_U, S_X3
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.health.checks.innovation import ErrorWatch, N_SUMS, watch
from gearbox_monitor.health.elastic_regression import (
    data_of, ElasticLaw, HEIGHT, N_SHAPE, normal_equations)
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.simulators.c99 import firmware

# What users of gcc ask for; no instruction for a product and a sum: as on a small processor.
FLAGS = '-std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -ffp-contract=off -fPIC'.split()
NEW = ['-march=x86-64-v3']
SANITIZE = ['-fsanitize=address,undefined', '-fno-sanitize-recover']
OUT = {'smoother_lag': 0.0}
needs_gcc = pytest.mark.skipif(shutil.which('gcc') is None, reason='gcc is not installed')


@cache
def text_of(name):
    """Return the firmware of one of CASES, or of the default drive."""
    changes, parameters = CASES.get(name, ({}, {}))
    return firmware(DriveModel().with_(**changes), {**OUT, **parameters}, 'drive.h')


def built(folder, name, *flags):
    folder.mkdir(exist_ok=True)
    text = text_of(name)
    (folder / 'drive.c').write_text(text.source)
    (folder / 'drive.h').write_text(text.header)
    library = folder / f'drive{len(list(folder.iterdir()))}.so'
    subprocess.run(['gcc', *FLAGS, *flags, f'-I{folder}', '-shared', '-o', library,
                    folder / 'drive.c', Path(__file__).with_name('firmware_batch.c')], check=True)
    return ctypes.CDLL(str(library))


@pytest.fixture(scope='module')
def library(tmp_path_factory):
    """Return that of the default drive and parameters; states are apart from it."""
    return built(tmp_path_factory.mktemp('default'), 'default')


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def fresh(library):
    state = ctypes.create_string_buffer(library.filter_size())
    library.gm_init(state)
    return state


def inputs_of(u, y):
    return np.ascontiguousarray(np.column_stack([u, y]))


def run(library, stamps, u, y, state=None):
    """Return codes [N], flags [N] and rows [N, N_ESTIMATE]."""
    n, columns = len(stamps), sample_loop.N_ESTIMATE
    codes, flags = np.zeros(n, np.int32), np.zeros(n, np.int32)
    out = np.full((n, columns), np.nan)
    library.batch(state or fresh(library), n, pointer(np.ascontiguousarray(stamps)),
                  pointer(inputs_of(u, y)), pointer(codes), pointer(flags), columns, pointer(out))
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


CASES = {
    'walk': ({}, {'effort_delay': 3}),
    'loaded': ({'friction_law': {'kind': 'tanh'}, 'effects': [
        {'id': 'gravity', 'G': 0.8, 'phi': 0.2}, {'id': 'arm_coulomb', 'Cac': 0.05}]}, {}),
    'unknown': ({}, {'arm_load': 'unknown', 'friction_error_std': 0.1}),
    'elastic': ({}, {'tau_k_model': 'elastic', 'arm_load': 'none'}),
    'one encoder': ({}, {'arm_joint': ''}),
    'learned': ({}, {'tau_k_model': 'learned'}),
    'play': ({'transmission': {'kind': 'play', 'stiffness': 25.0, 'half_gap': 0.1,
                               'hysteresis_width': 0.02}}, {'tau_k_model': 'elastic'}),
    'statistical': ({}, {'friction_linearisation': 'statistical'}),
    'constraint': ({'friction_law': {'kind': 'mujoco'}, 'timestep': 1e-3}, {}),
    'ukf': ({}, {'filter': 'ukf'}), 'srukf': ({}, {'filter': 'srukf'})}
USUAL = ('walk', 'loaded', 'ukf')


def expect_equal(library, model, parameters, count):
    """Compare all columns but the log-likelihood, which firmware leaves out, and the flags."""
    stamps, u, y = damaged(*recording(count))
    if parameters.get('arm_joint') == '':
        y[:, 1] = np.nan
    estimator = Estimator(model, parameters)
    expected = estimator.run(Samples(stamps, u, y))
    codes, flags, out = run(library, stamps, u, y)
    np.testing.assert_array_equal(codes, expected.codes)
    assert set(codes) == {0, 1, 2, 3, 4, 5, 6, 7, 9}
    compared = [c for name, c in COLUMNS.items() if name != 'loglik']
    good = codes == sample_loop.ESTIMATE
    if parameters.get('arm_joint') == '':
        compared = [COLUMNS[name] for name in ('x1', 'x3', 'tau_k', 'tau_k_std', 'nis')]
    same = out[good][:, compared].view(np.int64) == expected.rows[:, compared].view(np.int64)
    assert (same | np.isnan(expected.rows[:, compared])).all()
    return stamps, codes, flags, out


@needs_gcc
@pytest.mark.parametrize('name', [
    name if name in USUAL else pytest.param(name, marks=pytest.mark.system) for name in CASES])
def test_estimates_are_the_bits_of_the_estimator(tmp_path, name):
    changes, parameters = CASES[name]
    model, parameters = DriveModel().with_(**changes), {**OUT, **parameters}
    expect_equal(built(tmp_path, name), model, parameters, 20_000)


@needs_gcc
@pytest.mark.system
def test_a_million_samples_are_equal(tmp_path):
    """On an old processor and on a new one."""
    for flags in ([], NEW):
        library = built(tmp_path, 'default', *flags)
        expect_equal(library, DriveModel(), OUT, 1_000_000)


@needs_gcc
def test_flags_are_those_of_the_kernel_on_the_host(library):
    stamps, codes, flags, out = expect_equal(library, DriveModel(), OUT, 20_000)
    carried = ErrorWatch(np.zeros((2, N_SUMS)), np.zeros(2, np.int64))
    estimator = Estimator(DriveModel(), OUT)
    since = []
    _, u, y = damaged(*recording(20_000))
    for k, stamp in enumerate(stamps):
        estimator.run(Samples(stamps[k:k + 1], u[k:k + 1], y[k:k + 1]))
        since.append(estimator.accurate_since_ns)
    wanted = [watch(row, code, stamp, started, carried)
              for row, code, stamp, started in zip(out, codes, stamps, since)]
    np.testing.assert_array_equal(flags, wanted)
    assert set(wanted) > {1}


@needs_gcc
@pytest.mark.system
@pytest.mark.parametrize('name', ['loaded', 'learned', 'statistical', 'ukf', 'srukf'])
def test_sanitizers_find_nothing(tmp_path, name):
    """In a process of its own, as the address sanitizer must come first."""
    text = text_of(name)
    (tmp_path / 'drive.c').write_text(text.source)
    (tmp_path / 'drive.h').write_text(text.header)
    stamps, u, y = damaged(*recording(20_000))
    stamps.tofile(tmp_path / 'stamps')
    inputs_of(u, y).tofile(tmp_path / 'inputs')
    for real in ([], ['-DGM_FLOAT']):
        subprocess.run(['gcc', *FLAGS, *SANITIZE, *real, '-o', 'run', 'drive.c', f'-I{tmp_path}',
                        Path(__file__).with_name('firmware_main.c')], cwd=tmp_path, check=True)
        done = subprocess.run(['./run', 'stamps', 'inputs'], cwd=tmp_path, check=True,
                              capture_output=True, text=True)
        assert int(done.stdout) > 10_000


@needs_gcc
def test_single_precision_is_off_as_far_as_the_page_says(tmp_path):
    stamps, u, y = recording(30_000)
    expected = Estimator(DriveModel(), OUT).run(Samples(stamps, u, y))
    codes, _, out = run(built(tmp_path, 'default', '-DGM_FLOAT'), stamps, u, y)
    np.testing.assert_array_equal(codes, expected.codes)
    error = out[codes == 0, sample_loop.E_TAU_K] - expected.tau_k
    assert np.abs(error).max() < 0.05 * np.sqrt(np.mean(expected.tau_k ** 2))


@needs_gcc
def test_instances_share_nothing_and_begin_anew(library):
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
@pytest.mark.parametrize('name', [
    'loaded', *(pytest.param(name, marks=pytest.mark.system) for name in CASES if name != 'loaded')
])
def test_no_symbol_of_libm_or_heap(tmp_path, name):
    text = text_of(name)
    (tmp_path / 'drive.c').write_text(text.source)
    (tmp_path / 'drive.h').write_text(text.header)
    for real in ([], ['-DGM_FLOAT']):
        subprocess.run(['gcc', *FLAGS, '-Os', *real, '-c', 'drive.c'], cwd=tmp_path, check=True)
        done = subprocess.run(['nm', '-u', 'drive.o'], cwd=tmp_path, check=True,
                              capture_output=True, text=True)
        assert set(done.stdout.split()) - {'U', '_GLOBAL_OFFSET_TABLE_'} <= {
            'memcpy', 'memmove', 'memset', '__stack_chk_fail'}


@pytest.mark.parametrize('processor, real, most', [
    ('cortex_m4+vfp4d16sp', ['-DGM_FLOAT'], 17_500), ('cortex_m7+fp_armv8d16', [], 18_500)])
def test_code_for_a_microcontroller_is_small_and_needs_no_library(tmp_path, processor, real, most):
    """For the default drive, trust flags and backlash window included."""
    pytest.importorskip('ziglang')
    text = text_of('default')
    (tmp_path / 'drive.c').write_text(text.source)
    (tmp_path / 'drive.h').write_text(text.header)
    subprocess.run([sys.executable, '-m', 'ziglang', 'cc', '-target', 'thumb-freestanding-eabihf',
                    f'-mcpu={processor}', '-std=c99', '-Os', '-ffp-contract=off', *real, '-c',
                    'drive.c', '-o', 'drive.o'], cwd=tmp_path, check=True)
    sizes, symbols = (subprocess.run([*command, 'drive.o'], cwd=tmp_path, check=True, text=True,
                                     capture_output=True).stdout
                      for command in (['size'], ['nm', '-u']))
    assert int(sizes.split()[6]) < most
    allowed = '__aeabi_(unwind_cpp_pr[01]|u?l2[fd]|[fd]2u?lz|u?ldivmod)|mem(cpy|move|set)'
    assert all(re.fullmatch(allowed, name) for name in set(symbols.split()) - {'U'})


@needs_gcc
def test_root_and_fused_product_are_those_of_the_processor(tmp_path):
    """Without an instruction for either: denormal, infinite and cancelling ones, too."""
    header = Path(firmware.__code__.co_filename).with_name('firmware') / 'arithmetic.h'
    (tmp_path / 'functions.c').write_text(
        '#include <stdint.h>\ntypedef double gm_real;\n' + header.read_text() + """
void values(int n, const double *x, double *root, double *fused)
{
    for (int i = 0; i < n; i++) {
        root[i] = gm_root(x[3 * i]);
        fused[i] = gm_fma_double(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    }
}
""")
    subprocess.run(['gcc', *FLAGS, '-Wno-builtin-macro-redefined', '-U__SSE2__', '-shared', '-o',
                    'functions.so', 'functions.c'], cwd=tmp_path, check=True)
    rng = np.random.default_rng(0)
    x = rng.standard_normal((40_000, 3)) * 10.0 ** rng.integers(-20, 20, (40_000, 3))
    x[::4, 2] = -x[::4, 0] * x[::4, 1]
    x[1::4, 2] = -x[1::4, 0] * x[1::4, 1] * (1.0 + 1e-9 * rng.standard_normal(10_000))
    x[:8, 0] = 0.0, -0.0, np.inf, np.nan, 5e-324, 2e-308, 1.0, -1.0
    root, fused = np.empty((2, len(x)))
    ctypes.CDLL(str(tmp_path / 'functions.so')).values(len(x), pointer(x), pointer(root),
                                                       pointer(fused))
    with np.errstate(invalid='ignore'):
        np.testing.assert_array_equal(root, np.sqrt(x[:, 0]))
    np.testing.assert_array_equal(fused, [fma(*row) for row in x.tolist()])


@needs_gcc
def test_window_sums_are_those_of_the_package(library):
    model = DriveModel()
    stamps, u, y = recording(6000)
    theta = np.array([20.0, 0.08, 0.01, 0.002, 0.01, 0.02, 0.03])
    sums = np.zeros((HEIGHT, HEIGHT + 1))
    library.window(len(stamps), pointer(stamps), pointer(inputs_of(u, y)), pointer(theta), 7,
                   pointer(sums))
    codes, _, out = run(library, stamps, u, y)
    row = out[codes == 0]
    rows = np.zeros((len(row), N_SMOOTHED))
    rows[:, [S_TWIST, S_MOTOR_SIDE, S_X3, S_U]] = row[:, [
        sample_loop.E_TWIST, sample_loop.E_TAU_K, sample_loop.E_X3, sample_loop.E_U]] * (
            1.0, 1.0, 1.0, -1.0)
    data = data_of(rows, model)
    m = len(row) // 7
    states = Estimator(model, OUT)
    deviations = []
    for k, stamp in enumerate(stamps):
        estimate = states.step(Sample(int(stamp), tuple(u[k]), tuple(y[k])))
        if estimate is not None:
            P = estimate.P
            deviations.append(np.sqrt(P[2, 2] + P[3, 3] - 2.0 * P[2, 3]))
    ratio = (row[:, sample_loop.E_X3] / (3.0 * np.array(deviations))) ** 2
    weights = (0.01 + ratio / (1.0 + ratio))[:7 * m].reshape(m, 7).mean(axis=1)
    normal, right = np.zeros((2, N_SHAPE, N_SHAPE)), np.zeros((2, N_SHAPE))
    law = ElasticLaw(group=7, paired=True, block=m)
    normal_equations(np.append(theta, np.zeros(N_SHAPE - HEIGHT)), np.arange(N_SHAPE) < HEIGHT,
                     law, data, weights, np.ones(m), (normal, right, np.zeros((3, N_SHAPE))),
                     np.zeros(m))
    np.testing.assert_allclose(sums[:, :HEIGHT], np.tril(normal[0, :HEIGHT, :HEIGHT]), rtol=1e-9,
                               atol=1e-9)
    np.testing.assert_allclose(sums[:, HEIGHT], right[0, :HEIGHT], rtol=1e-9, atol=1e-9)


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


UNKNOWN = [
    ({'filter': 'aekf'}, 'filter: aekf'), ({'tau_k_model': 'mixed'}, 'tau_k_model: mixed')]


def test_unknown_to_c_is_refused_by_name():
    for parameters, name in UNKNOWN:
        with pytest.raises(InputError, match=f'^{name}, with --to c expected'):
            firmware(DriveModel(), parameters)


def test_what_the_filter_leaves_out_is_said(tmp_path, capsys):
    (tmp_path / 'drive.yaml').write_text('effects: [{id: cogging, A: 0.1, N: 12, phi: 0.0}]\n')
    assert main(['export', str(tmp_path / 'drive.yaml'), '--to', 'c', '--out',
                 str(tmp_path / 'drive.c')]) == 0
    assert 'note: effects of the model that no filter knows are left out: cogging' in (
        capsys.readouterr().out)


def test_file_of_a_simulator_is_no_model(tmp_path, capsys):
    (tmp_path / 'robot.xml').write_text('<mujoco/>')
    assert main(['export', str(tmp_path / 'robot.xml'), '--to', 'c', '--out',
                 str(tmp_path / 'x.c')]) == 2
    error, = capsys.readouterr().err.splitlines()
    assert error.endswith('robot.xml: the file of a simulator, with --to c expected a model file')
    assert not (tmp_path / 'x.c').exists()


@needs_gcc
def test_flags_are_those_of_the_monitor(library):
    monitor = Monitor(DriveModel(), OUT)
    stamps, u, y = recording(12_000)
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
