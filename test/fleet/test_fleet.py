# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Many bags: each has its row, whatever it is and whatever dies; the same command resumes."""
import json
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import threading
import time
import zipfile

from fleet_setup import below, dask_cluster
import fsspec
import numpy as np
import pyarrow as pa
from pyarrow import dataset, parquet
import pytest
import yaml

from gearbox_monitor import __version__
from gearbox_monitor.bag.example_bag import ExampleMotion, write_example_bag
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.replay import replay
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_TAU_K_NOISE_STD, S_TWIST, S_X3, S_X4)
from gearbox_monitor.estimation.sample_loop import N_ESTIMATE
from gearbox_monitor.fleet import executors, job
from gearbox_monitor.fleet.fleet_table import FleetTable
from gearbox_monitor.fleet.job import analyse
from gearbox_monitor.fleet.paths import content_hash
from gearbox_monitor.fleet.trend import gearboxes
from gearbox_monitor.monitoring.backlash.features import Backlash
from gearbox_monitor.monitoring.backlash.recording_windows import RecordingWindows
from gearbox_monitor.monitoring.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.excitation import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.report.fleet_page import headline

ROOT = Path(__file__).parents[2]
DAY = 86400
T0 = 1_700_000_000
GROWTH = 0.03  # of the gap, from bag to bag of sn1
PARTITIONS = dataset.partitioning(pa.schema(
    [('gearbox', pa.string()), ('date', pa.date32())]), flavor='hive')


@pytest.fixture(scope='module')
def archive(tmp_path_factory):
    """Return a folder with ten sound bags of two gearboxes, and what else lies in archives."""
    folder = tmp_path_factory.mktemp('archive')
    for serial, growth in (('sn1', GROWTH), ('0002', 0.0)):
        for k in range(5):
            model = DriveModel().with_(half_gap=0.1 * (1.0 + growth * k))
            write_example_bag(folder / serial / f'run_{k}', model,
                              ExampleMotion(12.0, 500.0, T0 + 30 * DAY * k), 10 * k + len(serial),
                              f'/arm_{serial}/joint_states')
    bad = folder / 'odd'
    bad.mkdir()
    (bad / 'empty.mcap').write_bytes(b'')
    (bad / 'empty_too.mcap').write_bytes(b'')
    (bad / 'letter.mcap').write_text('Dear Sir or Madam')
    (bad / 'notes.txt').write_text('is nobody meant')
    (bad / 'nothing').mkdir()
    whole = (folder / 'sn1/run_0/run_0_0.mcap').read_bytes()
    (bad / 'cut.mcap').write_bytes(whole[:len(whole) // 2])
    (bad / 'stump.mcap').write_bytes(whole[:100])
    shutil.copytree(folder / '0002/run_1', bad / 'copy')
    (bad / 'lost').mkdir()
    shutil.copy(folder / 'sn1/run_1/metadata.yaml', bad / 'lost')
    with BagWriter(bad / 'foreign') as writer:
        writer.add_topic('/chatter', 'std_msgs/msg/String')
        writer.write('/chatter', T0 * 10 ** 9, b'\x00\x01\x00\x00\x03\x00\x00\x00hi\x00')
    (bad / 'link').symlink_to(folder, target_is_directory=True)
    os.mkfifo(bad / 'pipe.mcap')
    return folder


def fleet(capsys, *words):
    """Run the command; return (exit code, summary)."""
    capsys.readouterr()
    code = main(['fleet', *map(str, words), '--json'])
    return code, json.loads(capsys.readouterr().out)


def rows_of(out):
    """Return {path: row} of the table of bags."""
    return {row['path']: row for row in parquet.read_table(out / 'bags.parquet').to_pylist()}


def windows_of(out):
    return dataset.dataset(out / 'features', partitioning=PARTITIONS).to_table().to_pylist()


def command(*words):
    """Start the command in a process of its own, in a session of its own."""
    return subprocess.Popen(
        [sys.executable, '-m', 'gearbox_monitor', 'fleet', *map(str, words)], cwd=ROOT, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def until(condition, what, timeout=120.0):
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, f'{what} did not happen'
        time.sleep(0.01)


def lines_in(out):
    journal = out / 'bags.journal'
    return journal.read_bytes().count(b'}\n') if journal.exists() else 0


@pytest.fixture(scope='module')
def whole(archive, tmp_path_factory, request):
    """Return the folder of a run over the archive, and its summary."""
    out = tmp_path_factory.mktemp('whole') / 'out'
    capture = request.config.pluginmanager.getplugin('capturemanager')
    with capture.global_and_fixture_disabled():
        process = command(archive, '--out', out, '--workers', 2, '--json')
        told, errors = process.communicate(timeout=200)
    assert process.returncode == 1, errors  # the pipe is no file, which may change
    return out, json.loads(told)


# ---------------------------------------------------------------------- what becomes of each bag


def test_each_bag_has_its_row(archive, whole):
    out, told = whole
    rows = rows_of(out)
    odd = {Path(path).name: row for path, row in rows.items() if '/odd/' in path}
    assert len(rows) == told['bags'] == 10 + len(odd)
    assert all(row['status'] == 'done' for path, row in rows.items() if '/odd/' not in path)
    expected = {
        'empty.mcap': 'the file is empty', 'empty_too.mcap': 'the file is empty',
        'letter.mcap': 'not an MCAP file', 'stump.mcap': 'no topic /joint_states',
        'foreign': 'no topic /joint_states, the bag has /chatter', 'lost': 'metadata.yaml names',
        'nothing': 'holds no .mcap or .db3 file', 'pipe.mcap': 'not a file'}
    assert set(odd) == {*expected, 'cut.mcap', 'copy'}
    for name, reason in expected.items():
        assert odd[name]['status'] == 'failed' and reason in odd[name]['reason'], odd[name]
        assert odd[name]['reason'].startswith(f'{archive}/odd/{name}')
        assert odd[name]['retry'] == (name == 'pipe.mcap')
    assert odd['cut.mcap']['status'] == 'done' and 'was cut off' in odd['cut.mcap']['notes']
    assert 1000 < odd['cut.mcap']['samples'] < rows[f'{archive}/sn1/run_0']['samples'] == 6000
    assert odd['copy']['status'] == 'duplicate'
    assert odd['copy']['duplicate_of'] == f'{archive}/0002/run_1'
    assert {status: told[status] for status in ('done', 'failed', 'duplicate', 'skipped')} == {
        'done': 11, 'failed': 8, 'duplicate': 1, 'skipped': 0}
    row = rows[f'{archive}/sn1/run_2']
    assert row['content'] == content_hash(f'{archive}/sn1/run_2') and row['version'] == __version__
    assert row['gap'] == pytest.approx(0.2 * (1 + 2 * GROWTH), rel=0.02)
    assert row['stiffness'] == pytest.approx(25.0, rel=0.1) and row['separable']
    assert 'the bag records no model' in row['notes'] and row['attempts'] == 1


def test_the_dataset_holds_what_a_replay_gives(archive, whole):
    out, _ = whole
    windows = windows_of(out)
    assert {row['gearbox'] for row in windows} == {'arm_sn1', 'arm_0002'}
    ours = [row for row in windows if row['path'] == f'{archive}/sn1/run_3']
    with open_bag(archive / 'sn1/run_3') as reader:
        result = replay(reader)
    fits = RecordingWindows(result.monitor.estimator)
    fits.add(result.estimates)
    expected, = fits.finish()
    assert isinstance(expected, Backlash) and len(ours) == 1
    assert {name: ours[0][name] for name in ('stamp_ns', 'gap', 'gap_std', 'stiffness', 'angle')} \
        == {name: getattr(expected, name) for name in (
            'stamp_ns', 'gap', 'gap_std', 'stiffness', 'angle')}
    assert ours[0]['gap_slopes'] == list(expected.gap_slopes) and ours[0]['excited']
    assert str(ours[0]['date']) == str(ours[0]['stamp'].date()) == '2024-02-12'
    left = {path.name for path in out.iterdir()}
    assert left == {'.lock', 'bags.parquet', 'features', 'fleet.html'}


def test_the_page_shows_the_worst_first(whole):
    out, told = whole
    assert [box['gearbox'] for box in told['gearboxes']] == ['arm_sn1', 'arm_0002']
    worst, good = told['gearboxes']
    assert worst['growth'] == pytest.approx(4 * GROWTH, abs=0.02) and worst['measured'] == 6
    assert abs(good['growth']) < 3 * good['growth_std']
    assert worst['per_year'] == pytest.approx(GROWTH * 365.25 / 30, rel=0.15)
    left, early, late = worst['reach']
    assert early < left < late and left / (30 * DAY) == pytest.approx(
        (0.25 - 4 * GROWTH) / GROWTH, rel=0.25)
    html = (out / 'fleet.html').read_text(encoding='utf-8')
    assert html.index('>arm_sn1<') < html.index('>arm_0002<') and html.count('<figure') == 2
    assert 'Backlash has grown in 1 of 2 gearboxes, most in arm_sn1' in html
    assert 'letter.mcap' in html
    for word in ('http:', 'https:', 'url(', '@import', ' src='):
        assert word not in html.replace('http://www.w3.org', '')


# ---------------------------------------------------------------------- resuming


def test_what_is_done_is_skipped_until_it_changes(archive, tmp_path, capsys):
    ours, out = tmp_path / 'ours', tmp_path / 'out'
    shutil.copytree(archive / 'sn1', ours)
    words = (ours, '--out', out, '--workers', 0)
    assert fleet(capsys, *words)[1]['done'] == 5
    before = rows_of(out)
    assert fleet(capsys, *words)[1]['skipped'] == 5 and rows_of(out) == before
    os.utime(ours / 'run_0/run_0_0.mcap')  # touched: read again, but not analysed
    (ours / 'run_1').rename(ours / 'moved')  # the old path stays, the new one is a copy of it
    shutil.copy(archive / '0002/run_3/run_3_0.mcap', ours / 'run_2/run_2_0.mcap')
    gone = out / before[f'{ours}/run_3']['features']
    gone.unlink()
    code, told = fleet(capsys, *words)
    assert (code, told['done'], told['duplicate'], told['skipped']) == (0, 2, 1, 2)
    rows = rows_of(out)
    assert rows[f'{ours}/moved']['duplicate_of'] == f'{ours}/run_1' and gone.is_file()
    assert rows[f'{ours}/run_2']['gearbox'] == 'arm_0002'
    assert not (out / before[f'{ours}/run_2']['features']).exists()
    assert rows[f'{ours}/run_4'] == before[f'{ours}/run_4']
    params = tmp_path / 'estimator.yaml'
    params.write_text(yaml.safe_dump({'estimator': {'ros__parameters': {'drift_window': 5.0}}}))
    told = fleet(capsys, *words, '--params', params, '--gearbox', r'/(run|moved)')[1]
    assert told['done'] == 5 and told['other_settings'] == 1  # the bag that has moved away
    assert {row['gearbox'] for row in windows_of(out)} == {'run', 'moved', 'arm_sn1'}
    assert len(windows_of(out)) == 5 * 2 + 1


def test_a_full_disk_keeps_what_is_done(archive, tmp_path, capsys):
    out = tmp_path / 'out'
    assert fleet(capsys, archive / 'sn1/run_[01]', '--out', out, '--workers', 0)[1]['done'] == 2
    code = ('import resource, sys\n'
            'resource.setrlimit(resource.RLIMIT_FSIZE, (4000, resource.RLIM_INFINITY))\n'
            'from gearbox_monitor.cli.main import main\n'
            f'sys.exit(main(["fleet", {str(archive / "sn1")!r}, "--out", {str(out)!r}, '
            '"--workers", "0"]))')
    result = subprocess.run([sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 2, result.stderr
    assert 'cannot write' in result.stderr and 'run the same command again' in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert len(rows_of(out)) == 2 and len(windows_of(out)) == 2
    told = fleet(capsys, archive / 'sn1', '--out', out, '--workers', 0)[1]
    assert (told['done'], told['skipped']) == (3, 2)


# ---------------------------------------------------------------------- workers that die


def when(condition, act):
    """Start a thread that calls act() as soon as condition() is true; return it."""
    def watch():
        until(condition, 'the moment')
        act()
    thread = threading.Thread(target=watch)
    thread.start()
    return thread


def test_a_killed_worker_loses_nothing(archive, tmp_path, capsys):
    out = tmp_path / 'out'

    def kill():  # workers are forked from a server, which this process has started
        worker, = (child for generation in below(os.getpid())[1:] for child in generation)
        os.kill(worker, signal.SIGKILL)
    thread = when(lambda: lines_in(out), kill)
    code, told = fleet(capsys, archive / 'sn1', archive / '0002', '--out', out, '--workers', 1)
    thread.join()
    assert (code, told['done']) == (0, 10)
    assert sorted(row['attempts'] for row in rows_of(out).values()) == [1] * 9 + [2]


def deadly(url, settings):
    """Analyse a bag, but die of one of them, as without enough memory."""
    if url.endswith('run_1'):
        os.kill(os.getpid(), signal.SIGKILL)
    return analyse(url, settings)


def test_a_bag_that_kills_its_workers_is_given_up_then_tried_again(
        archive, tmp_path, capsys, monkeypatch):
    out = tmp_path / 'out'
    words = (archive / 'sn1/run_[0-2]', '--out', out, '--workers', 2)
    with monkeypatch.context() as patch:
        patch.setattr(job, 'analyse', deadly)
        code, told = fleet(capsys, *words)
    assert (code, told['done'], told['failed'], told['to_be_tried_again']) == (1, 2, 1, 1)
    row = rows_of(out)[f'{archive}/sn1/run_1']
    assert row['status'] == 'failed' and row['retry'] and row['attempts'] == 3
    assert row['reason'].endswith('run_1: the worker died (killed, or out of memory), 3 times')
    code, told = fleet(capsys, *words)
    assert (code, told['done'], told['skipped'], told['to_be_tried_again']) == (0, 1, 2, 0)


@pytest.mark.system
def test_processes_that_cannot_start_end_the_run(monkeypatch):
    monkeypatch.setattr(executors, '_initialise', deadly)  # it takes other arguments
    pool = executors.PoolExecutor(1)
    try:
        pool.submit('task', os.getpid)
        with pytest.raises(InputError, match='10 processes ended while they started'):
            until(lambda: pool.results(0.1), 'an answer')
    finally:
        pool.close()


def test_ctrl_c_keeps_what_is_done_and_leaves_nobody_behind(archive, tmp_path, capsys):
    out = tmp_path / 'out'
    process = command(archive / 'sn1', '--out', out, '--workers', 1)
    until(lambda: lines_in(out), 'a first bag')
    children = [child for generation in below(process.pid) for child in generation]
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and 'run the same command again' in errors
    assert 'Traceback' not in errors, errors
    until(lambda: not any(Path(f'/proc/{child}').exists() for child in children), 'their end')
    done = sum(row['status'] == 'done' for row in rows_of(out).values())
    assert 1 <= done < 5
    assert fleet(capsys, archive / 'sn1', '--out', out, '--workers', 0)[1]['skipped'] == done


@pytest.mark.system
def test_workers_end_when_their_parent_is_killed(archive, tmp_path):
    out = tmp_path / 'out'
    process = command(archive / 'sn1', '--out', out, '--workers', 2)
    until(lambda: lines_in(out), 'a first bag')
    children = [child for generation in below(process.pid) for child in generation]
    assert len(children) >= 3
    process.kill()
    process.communicate()
    until(lambda: not any(Path(f'/proc/{child}').exists() for child in children), 'their end')
    with FleetTable(out) as table:  # the journal is taken over
        assert sum(row['status'] == 'done' for row in table.rows.values()) >= 1
        with pytest.raises(InputError, match='another fleet run writes to it'):
            with FleetTable(out):
                pass


@pytest.mark.system
def test_on_a_dask_cluster(archive, whole, tmp_path, capsys):
    pytest.importorskip('distributed')
    out = tmp_path / 'out'
    words = (archive / 'sn1', archive / '0002', '--out', out)
    with dask_cluster(tmp_path / 'dask', 2) as (address, processes):
        cluster = executors.DaskExecutor(address)
        cluster.submit('here', os.getpid)
        until(lambda: cluster.results(0.1), 'a worker')
        thread = when(lambda: lines_in(out), lambda: os.kill(
            below(processes[1].pid)[0][0], signal.SIGKILL))
        code, told = fleet(capsys, *words, '--scheduler', address)
        thread.join()
        assert (code, told['done']) == (0, 10)
        ours, known = rows_of(out), rows_of(whole[0])
        assert len(ours) == 10
        for path, row in ours.items():
            for name in ('status', 'gap', 'gap_std', 'stiffness', 'content', 'trust'):
                assert row[name] == known[path][name]
        cluster.submit('asleep', time.sleep, 60.0)
        assert cluster.results(0.1) == []
        processes[0].kill()
        with pytest.raises(InputError, match='the scheduler is lost; what is done is kept'):
            until(lambda: cluster.results(0.1), 'the loss')
        cluster.close()
    assert fleet(capsys, *words, '--workers', 0)[1]['skipped'] == 10


# ---------------------------------------------------------------------- paths and bad input


def test_urls(archive, tmp_path, capsys):
    with zipfile.ZipFile(tmp_path / 'old.zip', 'w') as packed:
        for file in (archive / 'sn1/run_0').iterdir():
            packed.write(file, f'2023/run_0/{file.name}')
        packed.write(archive / 'sn1/run_1/run_1_0.mcap', '2023/loose.mcap')
    out = tmp_path / 'out'
    code, told = fleet(capsys, f'zip://2023::{tmp_path}/old.zip',
                       f'file://{archive}/0002/run_[01]', archive / 'sn1/run_0', '--out', out,
                       '--workers', 2)
    assert code == 0 and (told['done'], told['duplicate']) == (4, 1)
    rows = rows_of(out)
    zipped = f'zip://2023/run_0::{tmp_path}/old.zip'
    assert rows[f'{archive}/sn1/run_0']['duplicate_of'] == zipped
    assert rows[zipped]['bytes'] == (archive / 'sn1/run_0/run_0_0.mcap').stat().st_size
    memory = fsspec.filesystem('memory')
    memory.put(str(archive / 'sn1/run_2'), '/fleet/run_2', recursive=True)
    memory.pipe('/fleet/run_3.mcap', b'no bag')
    code, told = fleet(capsys, 'memory://fleet', '--out', out, '--workers', 0)
    assert (code, told['done'], told['failed']) == (0, 1, 1)
    assert told['failures'][0]['reason'].startswith('memory:///fleet/run_3.mcap: not an MCAP')


@pytest.mark.parametrize('words, told', [
    (['nowhere'], 'nowhere: no such file or directory, expected a bag'),
    (['ODD/nothing'], 'nothing: holds no bag, expected'),
    (['s4://bucket/bags'], 's4://bucket/bags: Protocol not known: s4, expected a path or a URL'),
    (['ODD', '--workers', '-2'], '--workers: -2, expected a whole number >= 0'),
    (['ODD', '--workers', '2', '--scheduler', 'tcp://x:1'],
     '--workers and --scheduler exclude each other'),
    (['ODD', '--scheduler', 'here'], '--scheduler: here: missing port number'),
    (['ODD', '--gearbox', '('], "--gearbox: '(': missing )"),
    (['ODD', '--diagnose', '--only', 'rust'], "effect: 'rust', expected one of"),
    (['ODD', '--model', 'none.yaml'], 'none.yaml: No such file or directory'),
    (['ODD', '--out', 'ODD'], 'odd: holds other files, expected a new folder'),
])
def test_bad_input_is_one_line(archive, tmp_path, capsys, words, told):
    words = [word.replace('ODD', str(archive / 'odd')) for word in words]
    if '--out' not in words:
        words += ['--out', str(tmp_path / 'out')]
    assert main(['fleet', *words]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 1 and told in errors[0], errors


def test_a_damaged_table_is_named(tmp_path):
    (tmp_path / 'bags.parquet').write_text('no table')
    with pytest.raises(InputError, match='bags.parquet: .*expected a table written by fleet'):
        with FleetTable(tmp_path):
            pass


def test_without_its_packages_it_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with pytest.raises(InputError, match='dask.distributed is not installed, expected'):
        executors.DaskExecutor('tcp://127.0.0.1:8786')
    code = ('import sys; sys.modules["pyarrow"] = None\n'
            'from gearbox_monitor.cli.main import main\n'
            'sys.exit(main(["fleet", ".", "--out", "out"]))')
    result = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, capture_output=True,
                            env={**os.environ, 'PYTHONPATH': str(ROOT)}, text=True)
    assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, result.stderr
    assert 'pyarrow is not installed, expected' in result.stderr


# ---------------------------------------------------------------------- what comes of it


def test_diagnosis(tmp_path, capsys):
    model = tmp_path / 'drive.yaml'
    model.write_text(yaml.safe_dump(DriveModel().to_dict()))
    write_example_bag(tmp_path / 'bag', DriveModel().with_(half_gap=0.115),
                      ExampleMotion(8.0, 500.0), noise=Noise((0.0,) * 4, (2e-3, 2e-3)))
    out = tmp_path / 'out'
    code, told = fleet(capsys, tmp_path / 'bag', '--out', out, '--workers', 0, '--model',
                       model, '--diagnose', '--only', 'backlash_gap')
    assert code == 0
    row, = rows_of(out).values()
    assert (row['diagnosis'], row['diagnosis_effect'], row['diagnosis_place']) == (
        'effect', 'backlash_gap', 'transmission')
    assert row['diagnosis_closed'] > 0.9 and told['gearboxes'][0]['diagnosis'] == 'effect'
    assert 'backlash_gap' in (out / 'fleet.html').read_text(encoding='utf-8')


def bag_row(gearbox, day, gap, std, separable=True, **columns):
    row = {'status': 'done', 'gearbox': gearbox, 'path': f'{gearbox}/{day}', 'unit': 'rad',
           'start': (T0 + day * DAY) * 10 ** 9, 'gap': gap, 'gap_std': std, 'gap_error': 0.25,
           'separable': separable, 'lost_motion': 0.3, 'lost_motion_std': 0.01, 'trust': 'OK',
           'model_level': 'OK', 'notes': '', 'not_excited': None, 'diagnosis': None}
    return {**row, **columns}


def test_sure_growth_comes_before_large_growth():
    rng, rows = np.random.default_rng(0), []
    for day in range(40):
        noise = rng.standard_normal(4)
        rows += [bag_row('steady', day, 0.2 + 1e-4 * noise[0], 1e-4),
                 bag_row('grows', day, 0.2 * (1 + 0.001 * day) + 1e-4 * noise[1], 1e-4),
                 # States too little, and differs from bag to bag.
                 bag_row('wild', day, 0.2 * (1 + 0.0012 * day) + 2e-2 * noise[2], 1e-4),
                 # Stands still at first.
                 bag_row('late', day, 0.2 * (1 + 0.02 * max(0, day - 30)) + 1e-4 * noise[3], 1e-4)]
    rows += [bag_row('once', 0, 0.2, 1e-4),
             bag_row('blurred', 0, 0.2, 0.1, False), bag_row('blurred', 9, 0.2, 0.1, False),
             bag_row('idle', 0, None, None, None, lost_motion=None, not_excited='stands still')]
    boxes = {box['gearbox']: box for box in gearboxes(rows)}
    assert list(boxes) == ['late', 'grows', 'steady', 'blurred', 'wild', 'once', 'idle']
    assert boxes['late']['growth'] == pytest.approx(0.02 * 7, abs=0.005)
    assert boxes['grows']['growth'] == pytest.approx(0.001 * 35, abs=3 * boxes['grows'][
        'growth_std'])
    assert boxes['grows']['per_year'] == pytest.approx(0.36525, rel=0.03)
    assert boxes['steady']['reach'] is None and boxes['grows']['reach'][0] > 0
    assert boxes['wild']['growth_std'] > 20 * boxes['grows']['growth_std']
    assert boxes['blurred']['feature'] == 'lost_motion' and boxes['blurred']['growth'] == 0.0
    assert boxes['once']['growth'] is None and boxes['idle']['width'] is None


def test_a_growth_that_ended_is_told_and_forecasts_nothing():
    rng, rows = np.random.default_rng(1), []
    for day in range(20):
        for name, level in (('passing', 1.84 if 8 <= day < 11 else 1.0), ('flat', 1.0),
                            ('step', 1.84 if day >= 8 else 1.0), ('line', 1.0 + 0.02 * day)):
            value = 0.2 * level * (1.0 + 5e-3 * rng.standard_normal())
            rows.append(bag_row(name, day, value, 1e-4))
    boxes = {box['gearbox']: box for box in gearboxes(rows)}
    excursion = boxes['passing']['excursion']
    assert excursion['growth'] == pytest.approx(0.84, abs=0.02) and excursion['bags'] == 3
    assert excursion['growth_std'] < 0.02
    first, last = (bag_row('', day, 0.0, 0.0)['start'] for day in (8, 10))
    assert (excursion['start'], excursion['end']) == (first, last)
    assert abs(boxes['passing']['growth']) < 0.02 and boxes['passing']['reach'] is None
    assert all(boxes[name]['excursion'] is None for name in ('flat', 'step', 'line'))
    assert boxes['line']['reach'] is not None and boxes['flat']['reach'] is None
    text = headline(list(boxes.values()))
    assert 'passing was +8' in text and '(3 bags), which has ended' in text


def test_scatter_alone_makes_neither_forecast_nor_excursion():
    rng, count = np.random.default_rng(2), 300
    boxes = gearboxes(bag_row(f'{n}', day, 0.2 * (1.0 + 0.01 * rng.standard_normal()), 1e-4)
                      for n in range(count) for day in range(6))
    assert sum(box['reach'] is not None for box in boxes) <= 2
    assert sum(box['excursion'] is not None for box in boxes) <= 2


def smoothed_alone(stamps, rows):
    return Estimates(stamps[:0], np.empty((0, N_ESTIMATE)), stamps, rows, stamps[:0])


def test_lost_motion_is_measured_where_no_torque_is_seen():
    """Slow strokes of a drive with friction: the twist follows the direction, the torque is 0."""
    t = np.arange(0.0, 60.0, 0.01)
    speed = np.cos(0.7 * t)
    rows = np.zeros((len(t), N_SMOOTHED))
    rows[:, S_X4], rows[:, S_X3] = speed, speed
    rows[:, S_TWIST], rows[:, S_TAU_K_NOISE_STD] = 0.015 * np.sign(speed), 0.1
    windows = RecordingWindows(Estimator(DriveModel()))
    windows.add(smoothed_alone((t * 1e9).astype(np.int64) + 1, rows))
    fits = windows.finish()
    assert fits and not any(isinstance(fit, Backlash) for fit in fits)
    row = job._features(fits)
    assert row['lost_motion'] == pytest.approx(0.03) and 'gap' not in row
    assert 'torque stays below its noise' in row['not_excited']


def test_windows_come_out_alike_in_any_blocks():
    rng = np.random.default_rng(1)
    with pytest.raises(InputError, match='smoother_lag: 0'):
        RecordingWindows(Estimator(DriveModel(), {'smoother_lag': 0.0}))
    t = np.arange(0.0, 31.0, 4e-3)
    run = simulate(DriveModel(), Excitation().torque(t), 4e-3)
    stamps = np.round(t * 1e9).astype(np.int64)
    stamps[len(t) // 2:] -= 9 * 10 ** 9  # the clock is set back
    monitor = Monitor(DriveModel())
    found = monitor.run(Samples(stamps, np.column_stack([run.u, np.full(len(t), np.nan)]), run.y))
    fits = []
    for cuts in ([], np.sort(rng.integers(0, len(found.smoothed), 40))):
        windows = RecordingWindows(monitor.estimator)
        for part in zip(np.split(found.smoothed_stamp_ns, cuts), np.split(found.smoothed, cuts)):
            windows.add(smoothed_alone(*part))
        fits.append(windows.finish())
    assert fits[0] == fits[1] and len(fits[0]) == 3 and all(
        isinstance(fit, Backlash) for fit in fits[0])


def test_a_task_beyond_its_limits_ends_alone():
    pool, results = executors.PoolExecutor(1, executors.TaskLimits(3.0, 512 << 20)), []
    try:
        for number, task in enumerate(((time.sleep, 1e6), (bytes, 600 << 20), (len, 'abc'))):
            pool.submit(task[0].__name__, *task)
            while len(results) == number:
                results += pool.results(0.1)
    finally:
        pool.close()
    assert results == [
        executors.TaskResult('sleep', died='took more than 3 s (--max-seconds)', given_up=True),
        executors.TaskResult('bytes', died='out of memory (--max-memory)', given_up=True),
        executors.TaskResult('len', 3)]
