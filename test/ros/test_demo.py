# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The demo as a user runs it: real processes, Ctrl-C and accidents at any moment."""
import json
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip('rclpy')
psutil = pytest.importorskip('psutil')

from gearbox_monitor.cli.demo import READY_SECONDS  # noqa: E402
from gearbox_monitor.cli.main import main  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402
from gearbox_monitor.recordings.replay import replay  # noqa: E402
from gearbox_monitor.ros.middleware import own_domain  # noqa: E402

pytestmark = pytest.mark.ros
ROOT = Path(__file__).parents[2]
PATIENCE = 2.0 * READY_SECONDS  # as long as the demo itself waits for nodes that compile


@pytest.fixture
def demo(tmp_path):
    """Start demos in `tmp_path` with the given options; kill what is left of them."""
    started = []

    def start(*options):
        process = subprocess.Popen(
            [sys.executable, '-m', 'gearbox_monitor', 'demo', *options], cwd=tmp_path,
            env={**os.environ, 'PYTHONPATH': str(ROOT)}, text=True, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, start_new_session=True)
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()
        for child in children(process):
            child.kill()


def children(process):
    """Return the node processes of the demo `process`, also when it is gone."""
    found = []
    for candidate in psutil.process_iter():
        try:
            if candidate.environ().get('GEARBOX_MONITOR_PARENT') == str(process.pid):
                found.append(candidate)
        except psutil.Error:
            pass
    return found


def wait_for(condition, what, seconds=PATIENCE):
    """Wait for a condition."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f'{what} did not happen'
        time.sleep(0.05)


def told(errors):
    """Return the lines on stderr but those on the progress."""
    return [line for line in errors.splitlines() if not line.startswith('demo: ')]


def run(demo, folder, *options):
    """Run a demo of 16 s into `folder` and return its summary and its printout."""
    process = demo('--duration', '16', '--out', folder.name, *options)
    output, errors = process.communicate(timeout=400)
    assert process.returncode == 0, output + errors
    assert not children(process)
    assert main(['check', str(folder / 'bag')]) != 2  # rosbags decodes its messages
    data = json.loads((folder / 'summary.json').read_text())
    gearbox = data['joints']['']
    assert gearbox['replay_identical'] == 'yes' and data['problems'] == []
    expected = data['samples_expected']
    assert expected == 8000
    assert expected / 2 < data['samples'] == expected - data['samples_missing']
    assert gearbox['tau_k_error_smoothed'] < 0.1 * gearbox['tau_k_rms']
    assert 1.85 < gearbox['nis'] < 2.15
    assert data['summary'] in (folder / 'report.html').read_text()
    for log in ('plant', 'estimator', 'recorder'):
        assert 'Traceback' not in (folder / f'{log}.log').read_text()
    with open_bag(folder / 'bag') as bag:
        assert not bag.truncated
        live = bag.topics['/transmission_state'][1]
        assert expected / 2 < live == expected - 1 - data['estimates_missing']
    return data, output


def expect_seen(data):
    """Expect an alarm of what was planted alone; see MAX_LOSS for a machine without the time."""
    if data['starved']:
        pytest.skip(f'{data["samples_missing"]} samples and {data["estimates_missing"]} estimates '
                    'are missing: the machine is too busy to see the fault')
    assert data['seen'] == data['planted']


@pytest.mark.system
def test_growing_backlash_raises_its_alarm(demo, tmp_path):
    data, output = run(demo, tmp_path / 'a 100%d')
    assert 'export ROS_DOMAIN_ID=' in output
    assert f'\n{data["summary"]}\n' in output and 'next         ' in output
    assert data['planted'] == ['']
    expect_seen(data)


@pytest.mark.system
def test_sound_gearbox_raises_none(demo, tmp_path):
    data, output = run(demo, tmp_path / 'healthy', '--no-fault', '--json', 'data.json')
    assert json.loads((tmp_path / 'data.json').read_text()) == data
    assert f'\n{data["summary"]}\n' in output
    assert data['planted'] == data['seen'] == data['joints']['']['alarms'] == []


@pytest.mark.system
def test_robot_names_the_joint_of_the_fault(demo, tmp_path):
    process = demo('--robot', '--out', 'arm')
    output, errors = process.communicate(timeout=800)
    assert process.returncode == 0 and not children(process), output + errors
    data = json.loads((tmp_path / 'arm' / 'summary.json').read_text())
    joints = {f'joint{k + 1}' for k in range(6)}
    assert set(data['joints']) == joints and data['problems'] == []
    assert data['planted'] == ['joint1']
    for joint in data['joints'].values():
        assert joint['replay_identical'] == 'yes' and joint['comparison']['identical'] > 5_000
        assert joint['tau_k_error'] < 0.4 * joint['tau_k_rms']
    for command in re.findall(r'gearbox_monitor (replay .*)', output):
        subprocess.run([sys.executable, '-m', 'gearbox_monitor', *command.split()], check=True,
                       cwd=tmp_path, env={**os.environ, 'PYTHONPATH': str(ROOT)}, timeout=300)
    assert len(list((tmp_path / 'arm').glob('report.joint*.html'))) == 6
    expect_seen(data)
    first, last = (data['joints']['joint1']['gap_rad'][k] for k in (0, -1))
    assert first == pytest.approx(0.4e-3, rel=0.1) and last > 1.2 * first
    page = (tmp_path / 'arm' / 'report.html').read_text()
    assert 'joint1: Backlash has grown by' in page


@pytest.mark.system
def test_interrupted_robot_leaves_a_bag_of_all_joints(demo, tmp_path):
    process = demo('--robot', '--out', 'arm')
    bag = tmp_path / 'arm' / 'bag'

    def estimates():
        if not (tmp_path / 'arm' / 'arm_plant.log').exists():
            return 0
        with open_bag(bag) as reader:
            return reader.count('/transmission_state')

    wait_for(lambda: estimates() > 500, 'recording')
    os.killpg(process.pid, signal.SIGINT)
    output, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130 and not told(errors) and not children(process), errors
    with open_bag(bag) as reader:
        assert not reader.truncated
        for k in range(6):
            comparison = replay(reader, topic=f'joint{k + 1}').comparison
            assert comparison.verdict == 'yes' and comparison.compared, comparison


@pytest.mark.parametrize('moment', [
    0.7, *(pytest.param(m, marks=pytest.mark.system) for m in ('recording', 'shut-down'))])
def test_interrupt(demo, tmp_path, moment):
    """Ctrl-C leaves no process, no traceback and, where recording had begun, a whole bag."""
    process = demo('--duration', '60', '--out', 'out')
    out = tmp_path / 'out'
    if isinstance(moment, float):
        time.sleep(moment)
    else:
        wait_for(lambda: sum(file.stat().st_size for file in out.glob('bag/*.mcap')) > 100_000,
                 'recording')  # of samples: what comes before them is a tenth as long
        time.sleep(0.5)
    os.killpg(process.pid, signal.SIGINT)
    if moment == 'shut-down':
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, errors
    assert 'Traceback' not in output and not told(errors), errors
    assert not children(process)
    if not isinstance(moment, float):
        with open_bag(out / 'bag') as bag:
            assert not bag.truncated and bag.topics['/joint_states'][1]
    elif (out / 'bag').exists():
        assert (out / 'bag' / 'metadata.yaml').exists()


def test_killed_demo_takes_its_nodes_along(demo, tmp_path):
    process = demo('--duration', '60', '--out', 'out')
    wait_for(lambda: (tmp_path / 'out' / 'plant.log').exists(), 'start')
    time.sleep(0.3)
    assert len(children(process)) == 3
    process.kill()
    wait_for(lambda: not children(process), 'end of the nodes', 20)
    with open_bag(tmp_path / 'out' / 'bag') as bag:
        assert not bag.truncated


def test_dead_node_is_told(demo, tmp_path):
    process = demo('--duration', '60', '--out', 'out')
    wait_for(lambda: (tmp_path / 'out' / 'estimator.log').exists(), 'start')
    wait_for(lambda: len(children(process)) >= 2, 'nodes')
    next(c for c in children(process) if 'estimator_node' in ' '.join(c.cmdline())).kill()
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1 and 'estimator was ended by signal 9' in errors
    assert not children(process)


def test_bad_input_is_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for options, text in (
            (['--out', '.'], '.: exists, expected a new directory'),
            (['--duration', 'nan'], '--duration: nan, expected 16 to 86400'),
            (['--robot', '--duration', '30'], '--duration: 30, expected 45 to 86400')):
        assert main(['demo', *options]) == 2
        errors = capsys.readouterr().err
        assert text in errors and errors.count('\n') == 1, errors


def test_domains_are_not_shared():
    with own_domain() as first, own_domain() as second:
        assert first != second
