# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Many bags: each has its row, whatever it is and whatever dies; the same command resumes."""
import json
import os
from pathlib import Path
import re
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
from gearbox_monitor.fleet import job
from gearbox_monitor.fleet.fleet_run import gearboxes
from gearbox_monitor.fleet.job import analyse
from gearbox_monitor.health.backlash.features import Backlash, combine
from gearbox_monitor.health.health_record import HealthSettings, Window
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plain_data import to_data
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.replay import replay
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report.fleet_page import fleet_csv, fleet_page

ROOT = Path(__file__).parents[2]
DAY = 86400
T0 = 1_700_000_000
GROWTH = 0.03  # of the gap, from bag to bag of sn1


@pytest.fixture(scope='module')
def archive(tmp_path_factory):
    """Return a folder of 29 bags: ten that measure two gearboxes, ten damaged ones."""
    folder = tmp_path_factory.mktemp('archive')
    for serial, growth in (('sn1', GROWTH), ('0002', 0.0)):
        for k in range(5):
            model = DriveModel().with_(half_gap=0.1 * (1.0 + growth * k))
            write_example_bag(folder / serial / f'run_{k}', model,
                              ExampleMotion(12.0, 250.0, T0 + 30 * DAY * k), 10 * k + len(serial),
                              f'/arm_{serial}/joint_states')
    for k in range(8):
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


def command(archive, *words):
    """Start the installed command in its own session, where a folder has the package's name."""
    (archive.parent / 'gearbox_monitor').mkdir(exist_ok=True)
    (archive.parent / 'bin').mkdir(exist_ok=True)
    script = archive.parent / 'bin/command.py'
    script.write_text('from gearbox_monitor.cli.main import main\n'
                      'if __name__ == "__main__":\n    raise SystemExit(main())\n')
    return subprocess.Popen(
        [sys.executable, script, 'fleet', archive, *map(str, words)], cwd=archive.parent,
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


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
    assert set(odd) == {*reasons, 'cut.mcap', 'copy'} and len(rows) == summary['bags'] == 29
    assert all(row['status'] == 'done' for path, row in rows.items() if '/odd/' not in path)
    for name, reason in reasons.items():
        assert odd[name]['status'] == 'failed' and reason in odd[name]['reason'], odd[name]
        assert odd[name]['reason'].startswith(f'{archive}/odd/{name}')
        assert odd[name]['retry'] == (reason == 'not a file')
    assert odd['cut.mcap']['status'] == 'done' and 'was cut off' in odd['cut.mcap']['notes']
    assert 500 < odd['cut.mcap']['samples'] < rows[f'{archive}/sn1/run_0']['samples'] == 3000
    assert odd['copy']['status'] == 'duplicate' and odd['copy']['gap'] is None
    assert odd['copy']['duplicate_of'] == f'{archive}/0002/run_1'
    assert {status: summary[status] for status in ('done', 'failed', 'duplicate', 'skipped')} == {
        'done': 19, 'failed': 9, 'duplicate': 1, 'skipped': 0}
    assert {path.name for path in out.iterdir()} == {
        'bags.parquet', 'parts', 'fleet.html', 'fleet.csv'}
    assert len(list((out / 'parts').iterdir())) == 29 - summary['to_be_tried_again'] == 27


def test_a_row_holds_what_a_replay_gives(archive, whole):
    path = f'{archive}/sn1/run_3'
    row = rows_of(whole[0])[path]
    with open_bag(path) as reader:
        result = replay(reader)
    windows = result.monitor.all_features()
    for name in ('gap', 'stiffness'):
        expected = combine(windows, name)
        assert (row[name], row[f'{name}_std']) == (expected.value, expected.std)
    assert row['gap'] == pytest.approx(0.2 * (1 + 3 * GROWTH), rel=0.02)
    assert (row['windows'], row['separable'], row['version']) == (1, True, __version__)
    assert row['start'].timestamp() == pytest.approx(T0 + 90 * DAY, abs=1.0)
    assert (row['gearbox'], row['named'], row['date']) == ('arm_sn1', True, '2024-02-12')
    assert 'the bag records no model' in row['notes']


def test_the_page_shows_the_worst_first(whole):
    """Bags 30 days apart, of one window each: the change is stated, and what is sure is raised."""
    out, summary = whole
    boxes = {box['gearbox']: box for box in summary['gearboxes'] if box['points']}
    assert set(boxes) == {'arm_sn1', 'arm_0002'}
    worst, good = boxes['arm_sn1'], boxes['arm_0002']
    gap = worst['features']['gap']
    assert gap['level'] == pytest.approx(0.2 * (1.0 + 4 * GROWTH), rel=0.02)
    assert abs(good['features']['gap']['change']) < 3 * good['features']['gap']['change_std']
    assert good['alerts'] == {} and good['bags'] == 5 and len(worst['recordings']) == 6
    html = (out / 'fleet.html').read_text(encoding='utf-8')
    assert html.count('<figure') == 2 and 'letter.mcap' in html and 'stiffness (N m/rad)' in html
    for word in ('http:', 'https:', 'url(', '@import', ' src='):
        assert word not in html.replace('http://www.w3.org', '')


def test_a_folder_of_bags_without_names_is_asked_about(archive, tmp_path, capsys):
    """Never one verdict over a mixture: exit code 3, and no page."""
    out, folder = tmp_path / 'out', tmp_path / 'mixed'
    for k in range(3):
        shutil.copytree(archive / f'short/run_{k}', folder / f'run_{k}')
    assert main(['fleet', str(folder), '--out', str(out)]) == 3
    told = capsys.readouterr().err.splitlines()[-1]
    assert '3 bags name no gearbox: which gearbox made which bag?' in told
    assert not (out / 'fleet.html').exists()
    code, summary = fleet(capsys, archive / 'short/run_1', archive / 'short/run_2', '--out',
                          tmp_path / 'two')
    assert code == 0 and [box['gearbox'] for box in summary['gearboxes']] == ['short']


# ---------------------------------------------------------------------- resuming


def test_an_interrupted_run_goes_on(archive, whole, tmp_path):
    """Killed, then interrupted by Ctrl-C, then run to its end: each bag was analysed once."""
    out = tmp_path / 'out'
    done = {}
    for number in (signal.SIGKILL, signal.SIGINT):
        process = command(archive, '--out', out, '--workers', 2)
        until(lambda: len(parts(out)) >= len(done) + 5, 'five bags')
        children = []
        # Between two bags a worker has ended before the next one begins.
        until(lambda: len(children) >= 3 or children.extend(
            {child for generation in below(process.pid) for child in generation}.difference(
                children)), 'its processes')
        # As a terminal does: Ctrl-C goes to all processes.
        (os.kill if number == signal.SIGKILL else os.killpg)(process.pid, number)
        errors = process.communicate(timeout=60)[1]
        until(lambda: not any(Path(f'/proc/{child}').exists() for child in children), 'their end')
        assert done.items() <= parts(out).items() and len(parts(out)) < 27
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
    words = (archive / 'short', '--out', out, '--workers', 2, '--gearbox', '/(short)')
    with monkeypatch.context() as patch:
        patch.setattr(job, 'analyse', deadly)
        code, summary = fleet(capsys, *words, '--max-seconds', 8, '--max-memory', 512)
    assert (code, summary['done'], summary['failed']) == (1, 5, 3)
    assert [(Path(entry['path']).name, entry['reason'].partition(': ')[2], entry['retry'])
            for entry in summary['failures']] == [
        ('run_1', 'its worker died (killed, or out of memory)', True),
        ('run_2', 'took more than 8 s (--max-seconds)', True),
        ('run_3', 'out of memory (--max-memory)', True)]
    code, summary = fleet(capsys, *words)
    assert (code, summary['done'], summary['skipped'], summary['failed']) == (0, 3, 5, 0)


def test_a_dask_cluster_gives_the_same_table(archive, whole, tmp_path, capsys):
    out, lost = tmp_path / 'out', tmp_path / 'lost'
    with local_cluster(2) as cluster:
        address = cluster.scheduler_address
        code, summary = fleet(capsys, archive, '--out', out, '--scheduler', address)
        assert (code, summary['done']) == (1, 19)
        assert (out / 'bags.parquet').read_bytes() == (whole[0] / 'bags.parquet').read_bytes()

        def lose():
            until(lambda: parts(lost), 'a first bag')
            # As it may end in order: clients hear no more, and are left waiting.
            cluster.loop.add_callback(cluster.scheduler.report, {'op': 'close'})
            cluster.close()
        thread = threading.Thread(target=lose)
        thread.start()
        assert main(['fleet', str(archive / 'short'), '--out', str(lost), '--scheduler',
                     address]) == 2
        thread.join()
    error, = capsys.readouterr().err.splitlines()
    assert 'the scheduler is lost; what is done is kept' in error
    assert 1 <= len(parts(lost)) < 8


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


WRONG = [
    (['nowhere'], 'nowhere: no such file or directory, expected a bag'),
    (['ODD/nothing'], 'nothing: holds no bag, expected'),
    (['s3://bucket/bags'], 's3://bucket/bags: gone since 0.3; name a path: mount the archive'),
    (['ODD', '--workers', '0'], '--workers: 0, expected a whole number >= 1'),
    (['ODD', '--workers', '2', '--scheduler', 'tcp://x:1'],
     '--workers and --scheduler exclude each other'),
    (['ODD', '--scheduler', 'here'], '--scheduler: here: missing port number'),
    (['ODD', '--gearbox', '('], "--gearbox: '(': missing )"),
    (['ODD', '--model', 'none.yaml'], 'none.yaml: No such file or directory'),
    (['ODD', '--out', 'ODD'], 'odd: holds other files, expected a new folder'),
    (['ODD', '--out', 'OLD'], 'old/features: gone since 0.3; choose a new --out'),
]


def expect_one_line(archive, tmp_path, capsys, words, message):
    (tmp_path / 'old/features').mkdir(parents=True)
    (tmp_path / 'old/bags.parquet').touch()
    words = [word.replace('ODD', str(archive / 'odd')).replace('OLD', str(tmp_path / 'old'))
             for word in words]
    if '--out' not in words:
        words += ['--out', str(tmp_path / 'out')]
    assert main(['fleet', *words]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 1 and message in errors[0], errors


def test_bad_input_is_one_line(archive, new_folder, capsys):
    for words, message in WRONG:
        expect_one_line(archive, new_folder(), capsys, words, message)


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


SETTINGS = HealthSettings.of(EstimatorParameters(), DriveModel())


def bag_row(gearbox, day, gaps, separable=True, **features):
    """Return the row of a bag of windows with these `gaps` (relative), 1 % of noise each."""
    windows = [Window(Backlash(
        (T0 + day * DAY + 10 * k) * 10 ** 9, 0.2 * gap, 0.002, **{
            'stiffness': 25.0, 'stiffness_std': 0.2, 'lost_motion': 0.25 * gap,
            'lost_motion_std': 0.002, 'angle': 0.0, 'speed': 18.0, 'load': 3.6, 'flank': 0.4,
            'separable': separable, 'viscous': 0.0, 'viscous_std': 0.001, 'coulomb': 0.0,
            'coulomb_std': 0.001, **features})) for k, gap in enumerate(gaps)]
    return {
        'status': 'done', 'gearbox': gearbox, 'path': f'{gearbox}/{day}', 'unit': 'rad',
        'named': True, 'start': (T0 + day * DAY) * 10 ** 9,
        'judged': json.dumps([to_data((SETTINGS, tuple(windows))), None]),
        **job._features([window.features for window in windows]), 'trust': 'OK',
        'model_level': 'OK', 'notes': '',
        'not_excited': None if windows else 'stands still'}


def history(growth, days=20, seed=0, windows=2, **features):
    """Return rows of bags whose gap is 1 + growth(day), and other features by functions, too."""
    rng = np.random.default_rng(seed)
    return [bag_row('elbow', day, 1.0 + growth(day) + 0.002 * rng.standard_normal(windows),
                    **{name: of(day) for name, of in features.items()}) for day in range(days)]


def test_jumps_are_jumps_ramps_reach_their_limit_and_all_features_are_watched():
    jump, = gearboxes(history(lambda day: 0.16 * (day >= 12)))
    assert jump['level'] == 'WARN' and 'backlash has grown by 16' in jump['summary']
    since = jump['alerts']['gap']['since_ns'] * 1e-9 - T0
    assert 11 * DAY <= since <= 12 * DAY + 60 and jump['features']['gap']['limit_ns'] == []
    changes = [point['changes']['gap'] for point in jump['points']]
    assert max(map(abs, changes[:12])) < 0.02 and min(changes[12:]) > 0.14
    ramp, = gearboxes(history(lambda day: 0.006 * max(day - 8, 0), 30))
    expected, earliest, latest = ramp['features']['gap']['limit_ns']
    true = (T0 + (8 + 0.25 / 0.006) * DAY) * 1e9
    assert earliest < true < (latest or np.inf) and abs(expected - true) < 5e9 * DAY
    soft, = gearboxes(history(lambda day: 0.0, stiffness=lambda day: 25.0 - 9.0 * (day >= 10)))
    assert soft['level'] == 'ERROR' and 'stiffness has dropped by 36' in soft['summary']
    calm, = gearboxes(history(lambda day: 0.0))
    assert calm['level'] == 'OK' and 'no wear detected' in calm['summary']
    passing, = gearboxes(history(lambda day: 0.5 * (8 <= day < 11)))
    assert passing['level'] == 'OK' and not passing['alerts']
    rows = fleet_csv([jump, ramp, soft]).splitlines()
    assert re.search(r',2023-\d\d-\d\d,202\d-\d\d-\d\d,202\d-\d\d-\d\d,$', rows[2])
    assert rows[1].endswith(',,,') and rows[3].endswith(',,,')


def test_one_bag_or_one_without_trust_is_grey_and_never_ok():
    box, = gearboxes(history(lambda day: 0.0, days=1))
    assert box['level'] is None and 'no earlier recording to compare with' in box['summary']
    idle, = gearboxes([bag_row('idle', 0, [])])
    assert idle['level'] is None and not idle['points']
    dead = history(lambda day: 0.0)  # an encoder, at the end of the newest bag
    dead[-1]['trust'] = 'ERROR'
    box, = gearboxes(dead)
    assert box['level'] is None and box['summary'].startswith('the estimates are not trusted')


def test_a_service_begins_a_new_baseline_and_is_a_mark():
    """Worn by 30 %, repaired to 90 % of the first baseline: growth since then is growth."""
    rows = history(lambda day: 0.3 * (5 <= day < 10) + (-0.1 if day >= 10 else 0.0)
                   + 0.12 * (day >= 16), 22)
    date = (T0 + 9 * DAY + DAY // 2) * 10 ** 9
    box, = gearboxes(rows, {'elbow': [(date, 'gear replaced')]})
    assert box['marks'] == [[date, 'serviced, gear replaced']]
    assert box['level'] == 'WARN' and box['features']['gap']['change'] == pytest.approx(
        1.02 / 0.9 - 1.0, abs=0.01)
    assert '>2023-11-24</span> gear replaced' in fleet_page([box], [], {'done': 22}, 0)
    before, = gearboxes([row for row in rows if row['start'] < date])
    assert before['level'] == 'ERROR' and before['marks'] == []


def test_a_smaller_backlash_that_lasts_is_a_second_baseline():
    """Retightened by 10 % without a word: growth of 11 % since then is no return to health."""
    box, = gearboxes(history(lambda day: (-0.1 if day >= 8 else 0.0) + 0.1 * (day >= 14), 20))
    assert box['level'] == 'WARN' and 'backlash has grown by 11' in box['summary']
    assert len(box['marks']) == 1 and 'smaller than before' in box['marks'][0][1]


SERVICES = [
    ('elbow', 'expected GEARBOX DATE NOTE'), ('elbow yesterday it broke', "line 1: 'elbow yes")]


def test_services_are_read_by_line(archive, tmp_path, capsys):
    for line, expected in SERVICES:
        file = tmp_path / 'services.txt'
        file.write_text(line)
        assert main(['fleet', f'{archive}/sn1', '--out', str(tmp_path / 'out'), '--serviced',
                     str(file)]) == 2
        assert expected in capsys.readouterr().err
