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

from fleet_setup import below, local_cluster
import numpy as np
from pyarrow import parquet
import pytest
import yaml

from gearbox_monitor import __version__
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_TAU_K_NOISE_STD, S_TWIST, S_X3, S_X4)
from gearbox_monitor.estimation.sample_loop import N_ESTIMATE
from gearbox_monitor.fleet import job
from gearbox_monitor.fleet.job import analyse
from gearbox_monitor.fleet.trend import gearboxes
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.backlash.recording_windows import combine, RecordingWindows
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.replay import replay
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report.fleet_page import headline

ROOT = Path(__file__).parents[2]
DAY = 86400
T0 = 1_700_000_000
GROWTH = 0.03  # of the gap, from bag to bag of sn1


@pytest.fixture(scope='module')
def archive(tmp_path_factory):
    """Return a folder of 100 bags: ten that measure two gearboxes, ten damaged ones."""
    folder = tmp_path_factory.mktemp('archive')
    for serial, growth in (('sn1', GROWTH), ('0002', 0.0)):
        for k in range(5):
            model = DriveModel().with_(half_gap=0.1 * (1.0 + growth * k))
            write_example_bag(folder / serial / f'run_{k}', model,
                              ExampleMotion(12.0, 500.0, T0 + 30 * DAY * k), 10 * k + len(serial),
                              f'/arm_{serial}/joint_states')
    for k in range(79):
        write_example_bag(folder / f'short/run_{k}', DriveModel(), ExampleMotion(1.0, 250.0), k)
    odd = folder / 'odd'
    odd.mkdir()
    shutil.copytree(folder / '0002/run_1', odd / 'copy')
    (odd / 'notes.txt').write_text('is nobody meant')
    (odd / 'loop').symlink_to(folder, target_is_directory=True)
    (odd / 'empty.mcap').write_bytes(b'')
    (odd / 'empty_too.mcap').write_bytes(b'')
    (odd / 'letter.mcap').write_text('Dear Sir or Madam')
    (odd / 'nothing').mkdir()
    whole = (folder / 'sn1/run_0/run_0_0.mcap').read_bytes()
    (odd / 'cut.mcap').write_bytes(whole[:len(whole) // 2])
    (odd / 'stump.mcap').write_bytes(whole[:100])
    (odd / 'lost').mkdir()
    shutil.copy(folder / 'sn1/run_1/metadata.yaml', odd / 'lost')
    with BagWriter(odd / 'foreign') as writer:
        writer.add_topic('/chatter', 'std_msgs/msg/String')
        writer.write('/chatter', T0 * 10 ** 9, b'\x00\x01\x00\x00\x03\x00\x00\x00hi\x00')
    os.mkfifo(odd / 'pipe.mcap')
    (odd / 'dangling.mcap').symlink_to('nowhere')
    return folder


def fleet(capsys, *words):
    """Run the command; return (exit code, summary)."""
    capsys.readouterr()
    code = main(['fleet', *map(str, words), '--json'])
    return code, json.loads(capsys.readouterr().out)


def rows_of(out):
    """Return {path: row} of the table of bags."""
    return {row['path']: row for row in parquet.read_table(out / 'bags.parquet').to_pylist()}


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


def parts(out):
    """Return {name: when it was written} of the rows of bags that are done."""
    return {part.name: part.stat().st_mtime_ns for part in (out / 'parts').glob('*.parquet')}


@pytest.fixture(scope='module')
def whole(archive, tmp_path_factory, request):
    """Return the folder of a run over the archive, and its summary."""
    out = tmp_path_factory.mktemp('whole') / 'out'
    capture = request.config.pluginmanager.getplugin('capturemanager')
    with capture.global_and_fixture_disabled():
        process = command(archive, '--out', out, '--workers', 2, '--json')
        summary, errors = process.communicate(timeout=300)
    assert process.returncode == 1, errors  # the pipe is no file, which may change
    return out, json.loads(summary)


def test_each_bag_has_its_row(archive, whole):
    out, summary = whole
    rows = rows_of(out)
    odd = {Path(path).name: row for path, row in rows.items() if '/odd/' in path}
    reasons = {
        'empty.mcap': 'the file is empty', 'empty_too.mcap': 'the file is empty',
        'letter.mcap': 'not an MCAP file', 'stump.mcap': 'no topic /joint_states',
        'foreign': 'no topic /joint_states, the bag has /chatter', 'lost': 'metadata.yaml names',
        'nothing': 'holds no .mcap or .db3 file', 'pipe.mcap': 'not a file',
        'dangling.mcap': 'not a file'}
    assert set(odd) == {*reasons, 'cut.mcap', 'copy'} and len(rows) == summary['bags'] == 100
    assert all(row['status'] == 'done' for path, row in rows.items() if '/odd/' not in path)
    for name, reason in reasons.items():
        assert odd[name]['status'] == 'failed' and reason in odd[name]['reason'], odd[name]
        assert odd[name]['reason'].startswith(f'{archive}/odd/{name}')
        assert odd[name]['retry'] == (reason == 'not a file')
    assert odd['cut.mcap']['status'] == 'done' and 'was cut off' in odd['cut.mcap']['notes']
    assert 1000 < odd['cut.mcap']['samples'] < rows[f'{archive}/sn1/run_0']['samples'] == 6000
    assert odd['copy']['status'] == 'duplicate' and odd['copy']['gap'] is None
    assert odd['copy']['duplicate_of'] == f'{archive}/0002/run_1'
    assert {status: summary[status] for status in ('done', 'failed', 'duplicate', 'skipped')} == {
        'done': 90, 'failed': 9, 'duplicate': 1, 'skipped': 0}
    assert {path.name for path in out.iterdir()} == {'bags.parquet', 'parts', 'fleet.html'}
    assert len(list((out / 'parts').iterdir())) == 100 - summary['to_be_tried_again'] == 98


def test_a_row_holds_what_a_replay_gives(archive, whole):
    path = f'{archive}/sn1/run_3'
    row = rows_of(whole[0])[path]
    with open_bag(path) as reader:
        result = replay(reader)
    fits = RecordingWindows(result.monitor.estimator)
    fits.add(result.estimates)
    windows = fits.finish()
    for name in ('gap', 'stiffness'):
        expected = combine(windows, name)
        assert (row[name], row[f'{name}_std']) == (expected.value, expected.std)
    assert row['gap'] == pytest.approx(0.2 * (1 + 3 * GROWTH), rel=0.02)
    assert (row['windows'], row['separable'], row['version']) == (1, True, __version__)
    assert row['start'].timestamp() == pytest.approx(T0 + 90 * DAY, abs=1.0)
    assert (row['gearbox'], row['date']) == ('arm_sn1', '2024-02-12')
    assert 'the bag records no model' in row['notes']


def test_the_page_shows_the_worst_first(whole):
    out, summary = whole
    boxes = [box for box in summary['gearboxes'] if box['measured']]
    assert [box['gearbox'] for box in boxes] == ['arm_sn1', 'arm_0002']
    worst, good = boxes
    assert worst['growth'] == pytest.approx(4 * GROWTH, abs=0.02) and worst['measured'] == 6
    assert abs(good['growth']) < 3 * good['growth_std'] and good['bags'] == 5
    html = (out / 'fleet.html').read_text(encoding='utf-8')
    assert html.index('>arm_sn1<') < html.index('>arm_0002<') and html.count('<figure') == 2
    assert 'Backlash has grown in 1 of 2 gearboxes, most in arm_sn1' in html
    assert 'letter.mcap' in html
    for word in ('http:', 'https:', 'url(', '@import', ' src='):
        assert word not in html.replace('http://www.w3.org', '')


# ---------------------------------------------------------------------- resuming


def test_an_interrupted_run_goes_on(archive, whole, tmp_path):
    """Killed, then interrupted by Ctrl-C, then run to its end: each bag was analysed once."""
    out = tmp_path / 'out'
    done = {}
    for number in (signal.SIGKILL, signal.SIGINT):
        process = command(archive, '--out', out, '--workers', 2)
        until(lambda: len(parts(out)) >= len(done) + 20, 'twenty bags')
        children = [child for generation in below(process.pid) for child in generation]
        assert len(children) >= 3
        # As a terminal does: Ctrl-C goes to all processes.
        (os.kill if number == signal.SIGKILL else os.killpg)(process.pid, number)
        errors = process.communicate(timeout=60)[1]
        until(lambda: not any(Path(f'/proc/{child}').exists() for child in children), 'their end')
        assert done.items() <= parts(out).items() and len(parts(out)) < 98
        done = parts(out)
    assert process.returncode == 130 and 'run the same command again' in errors
    assert 'Traceback' not in errors, errors
    process = command(archive, '--out', out, '--workers', 2, '--json')
    summary = json.loads(process.communicate(timeout=300)[0])
    assert summary['skipped'] == len(done) and done.items() <= parts(out).items()
    assert (out / 'bags.parquet').read_bytes() == (whole[0] / 'bags.parquet').read_bytes()


def test_what_is_done_is_skipped_until_it_changes(archive, tmp_path, capsys):
    ours, out = tmp_path / 'ours', tmp_path / 'out'
    shutil.copytree(archive / 'sn1', ours)
    assert fleet(capsys, ours, '--out', out)[1]['done'] == 5
    before = rows_of(out)
    assert fleet(capsys, ours, '--out', out)[1]['skipped'] == 5 and rows_of(out) == before
    (ours / 'run_1').rename(ours / 'moved')  # its row stays; the new one is a copy of it
    shutil.copy(archive / '0002/run_3/run_3_0.mcap', ours / 'run_2/run_2_0.mcap')
    code, summary = fleet(capsys, ours, '--out', out)
    assert (code, summary['done'], summary['skipped']) == (0, 2, 3)
    rows = rows_of(out)
    assert rows[f'{ours}/run_1']['duplicate_of'] == f'{ours}/moved'
    assert rows[f'{ours}/run_2']['gearbox'] == 'arm_0002' and len(parts(out)) == 6
    assert rows[f'{ours}/run_4'] == before[f'{ours}/run_4']
    params = tmp_path / 'estimator.yaml'
    params.write_text(yaml.safe_dump({'estimator': {'ros__parameters': {'drift_window': 5.0}}}))
    summary = fleet(capsys, ours, '--out', out, '--params', params, '--gearbox',
                    '/(run|moved)')[1]
    assert summary['done'] == 5 and summary['other_settings'] == 1  # the bag that has moved away
    rows = rows_of(out)
    assert {row['gearbox'] for row in rows.values()} == {'run', 'moved', 'arm_sn1'}
    assert rows[f'{ours}/run_4']['windows'] == 2 and len(parts(out)) == 6


def test_a_full_disk_keeps_what_is_done(archive, tmp_path, capsys):
    out = tmp_path / 'out'
    assert fleet(capsys, archive / 'sn1/run_[01]', '--out', out)[1]['done'] == 2
    before = parts(out)
    code = ('import resource, sys\n'
            'resource.setrlimit(resource.RLIMIT_FSIZE, (4000, resource.RLIM_INFINITY))\n'
            'from gearbox_monitor.cli.main import main\n'
            f'sys.exit(main(["fleet", {str(archive / "sn1")!r}, "--out", {str(out)!r}]))')
    result = subprocess.run([sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 2, result.stderr
    assert 'cannot write' in result.stderr and 'run the same command again' in result.stderr
    assert parts(out) == before and len(list((out / 'parts').iterdir())) == 2
    summary = fleet(capsys, archive / 'sn1', '--out', out)[1]
    assert (summary['done'], summary['skipped']) == (3, 2)


# ---------------------------------------------------------------------- workers


def deadly(bag, settings):
    """Analyse a bag; one kills its process, one never ends, and one takes too much memory."""
    name = Path(bag.path).name
    if name == 'run_1':
        os.kill(os.getpid(), signal.SIGKILL)
    elif name == 'run_2':
        job._row = lambda *_: time.sleep(1e6)
    elif name == 'run_3':
        job._analysed = lambda *_: bytes(600 << 20)
    return analyse(bag, settings)


def test_a_bag_that_ruins_its_worker_is_named_and_tried_again(
        archive, tmp_path, capsys, monkeypatch):
    out = tmp_path / 'out'
    words = (archive / 'sn1', '--out', out, '--workers', 2)
    with monkeypatch.context() as patch:
        patch.setattr(job, 'analyse', deadly)
        code, summary = fleet(capsys, *words, '--max-seconds', 8, '--max-memory', 512)
    assert (code, summary['done'], summary['failed']) == (1, 2, 3)
    assert [(Path(entry['path']).name, entry['reason'].partition(': ')[2], entry['retry'])
            for entry in summary['failures']] == [
        ('run_1', 'its worker died (killed, or out of memory)', True),
        ('run_2', 'took more than 8 s (--max-seconds)', True),
        ('run_3', 'out of memory (--max-memory)', True)]
    code, summary = fleet(capsys, *words)
    assert (code, summary['done'], summary['skipped'], summary['failed']) == (0, 3, 2, 0)


def test_a_dask_cluster_gives_the_same_table(archive, whole, tmp_path, capsys):
    out, lost = tmp_path / 'out', tmp_path / 'lost'
    with local_cluster(2) as cluster:
        address = cluster.scheduler_address
        code, summary = fleet(capsys, archive, '--out', out, '--scheduler', address)
        assert (code, summary['done']) == (1, 90)
        assert (out / 'bags.parquet').read_bytes() == (whole[0] / 'bags.parquet').read_bytes()

        def lose():
            until(lambda: parts(lost), 'a first bag')
            cluster.close()
        thread = threading.Thread(target=lose)
        thread.start()
        assert main(['fleet', str(archive / 'short'), '--out', str(lost), '--scheduler',
                     address]) == 2
        thread.join()
    error, = capsys.readouterr().err.splitlines()
    assert 'the scheduler is lost; what is done is kept' in error
    assert 1 <= len(parts(lost)) < 79


def test_only_pyarrow_is_needed_at_home(archive, tmp_path, capsys, monkeypatch):
    code = ('import sys\n'
            'class Missing:\n'
            '    def find_spec(self, name, *_):\n'
            '        if name in sys.argv[1].split(","):\n'
            '            raise ModuleNotFoundError(name, name=name)\n'
            'sys.meta_path.insert(0, Missing())\n'
            'from gearbox_monitor.cli.main import main\n'
            'sys.exit(main(["fleet", sys.argv[2], "--out", "out"]))')
    for missing, expected, message in (
            ('dask,distributed,fsspec,pandas', 0, ''),
            ('pyarrow', 2, 'pyarrow is not installed, expected pip install')):
        result = subprocess.run(
            [sys.executable, '-c', code, missing, archive / 'short/run_0'], cwd=tmp_path,
            env={**os.environ, 'PYTHONPATH': str(ROOT)}, capture_output=True, text=True)
        assert result.returncode == expected and message in result.stderr, result.stderr
    monkeypatch.setitem(sys.modules, 'distributed', None)
    assert main(['fleet', str(archive / 'short'), '--out', str(tmp_path / 'out'), '--scheduler',
                 'tcp://127.0.0.1:8786']) == 2
    assert 'dask.distributed is not installed, expected' in capsys.readouterr().err


# ---------------------------------------------------------------------- bad input


@pytest.mark.parametrize('words, message', [
    (['nowhere'], 'nowhere: no such file or directory, expected a bag'),
    (['ODD/nothing'], 'nothing: holds no bag, expected'),
    (['s3://bucket/bags'], 's3://bucket/bags: gone since 0.3; name a path: mount the archive'),
    (['ODD', '--workers', '0'], '--workers: 0, expected a whole number >= 1'),
    (['ODD', '--workers', '2', '--scheduler', 'tcp://x:1'],
     '--workers and --scheduler exclude each other'),
    (['ODD', '--scheduler', 'here'], '--scheduler: here: missing port number'),
    (['ODD', '--gearbox', '('], "--gearbox: '(': missing )"),
    (['ODD', '--diagnose', '--only', 'rust'], "effect: 'rust', expected one of"),
    (['ODD', '--model', 'none.yaml'], 'none.yaml: No such file or directory'),
    (['ODD', '--out', 'ODD'], 'odd: holds other files, expected a new folder'),
    (['ODD', '--out', 'OLD'], 'old/features: gone since 0.3; choose a new --out'),
])
def test_bad_input_is_one_line(archive, tmp_path, capsys, words, message):
    (tmp_path / 'old/features').mkdir(parents=True)
    (tmp_path / 'old/bags.parquet').touch()
    words = [word.replace('ODD', str(archive / 'odd')).replace('OLD', str(tmp_path / 'old'))
             for word in words]
    if '--out' not in words:
        words += ['--out', str(tmp_path / 'out')]
    assert main(['fleet', *words]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 1 and message in errors[0], errors


def test_a_damaged_part_is_named(archive, tmp_path, capsys):
    words = [str(archive / 'short/run_0'), '--out', str(tmp_path / 'out')]
    assert main(['fleet', *words]) == 0
    part, = (tmp_path / 'out/parts').iterdir()
    part.write_text('no table')
    capsys.readouterr()
    assert main(['fleet', *words]) == 2
    error, = capsys.readouterr().err.splitlines()
    assert part.name in error and 'delete a damaged one' in error


# ---------------------------------------------------------------------- what comes of it


def test_diagnosis(tmp_path, capsys):
    model = tmp_path / 'drive.yaml'
    model.write_text(yaml.safe_dump(DriveModel().to_dict()))
    write_example_bag(tmp_path / 'bag', DriveModel().with_(half_gap=0.115),
                      ExampleMotion(8.0, 500.0), noise=Noise((0.0,) * 4, (2e-3, 2e-3)))
    out = tmp_path / 'out'
    code, summary = fleet(capsys, tmp_path / 'bag', '--out', out, '--model', model, '--diagnose',
                          '--only', 'backlash_gap')
    assert code == 0
    row, = rows_of(out).values()
    assert (row['diagnosis'], row['diagnosis_effect'], row['diagnosis_place']) == (
        'effect', 'backlash_gap', 'transmission')
    assert row['diagnosis_closed'] > 0.9 and summary['gearboxes'][0]['diagnosis'] == 'effect'
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
