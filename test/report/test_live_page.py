# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The live page: what is drawn of plain arrays, and the page in a browser while parts arrive."""
import http.client
import json
import re
import time
from urllib.parse import urlsplit

import numpy as np
from pages import OVERFLOW, overflowing, requests
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.report.live_page import (
    GearboxHistory, live_frame, live_summary, LivePage)
from gearbox_monitor.report.timeline import State
from gearbox_monitor.ros import live_node
from gearbox_monitor.ros.live_node import EventServer

T0 = 1_700_000_000_000_000_000
MS = 1_000_000


def gearbox(name='elbow', seconds=30, twist=True):
    """Return the history of a gearbox after `seconds` at 1 kHz, taken ten times per second."""
    history = GearboxHistory(name)
    t = np.arange(1000 * seconds) * 1e-3
    torque = 5.0 * np.sin(3.0 * t)
    values = np.column_stack([0.01 * torque if twist else np.full(len(t), np.nan), torque])
    for rows in np.split(np.arange(len(t)), 10 * seconds):
        history.add_motion(T0 + rows * MS, values[rows])
    return history


def test_an_error_is_not_hidden_by_a_notice_of_wear():
    """Wear stands for its symptoms only, in one gearbox and among several."""
    worn, silent = GearboxHistory('elbow'), GearboxHistory('wrist')
    for k in range(5):
        worn.add_status(float(k), 'friction', 1, '30 % more', {'codes': 'friction_2'})
        worn.add_status(float(k), 'model', 2, 'the drive is not the model', {})
        silent.add_status(float(k), 'input', 2, 'no data', {})
    assert worn.worst().component == 'friction'
    summary = live_summary([worn, silent], 'estimator', 4.0)
    assert summary.data['kind'] == 'error'
    assert summary.data['headline'].startswith('wrist: input: no data')
    worn.add_status(5.0, 'input', 2, 'no data', {})
    assert worn.worst().component == 'input'


def judged(history, level=0, component='model'):
    for k in range(700):
        history.add_status(float(k), component, level if k > 650 else 0, 'so it is', {})
        history.add_status(float(k), 'backlash', 0, 'gap', {
            'gap_rad': str(0.2 + 0.001 * (k // 10)), 'gap_std_rad': '0.001', 'separable': 'True',
            'lost_motion_rad': '0.2', 'baseline_gap_rad': '0.2', 'growth_warn': '0.1',
            'growth_error': '0.25'})
    return history


def parts(*histories, time_s=700.0):
    return LivePage().parts(histories, '/estimator', time_s)


def test_motion_is_the_newest_ten_seconds_with_its_extremes():
    history = gearbox()
    motion = history.motion(600)
    assert len(motion.t) <= 610 and motion.t[-1] == 0.0
    assert motion.t[0] == pytest.approx(-10.0) and history.rate() == pytest.approx(1000.0)
    peaks = 5.0 * np.sin(3.0 * np.arange(20_000, 30_000) * 1e-3)
    assert motion.tau_k.max() == peaks.max() and motion.tau_k.min() == peaks.min()
    assert motion.twist == pytest.approx(0.01 * motion.tau_k)


def test_memory_is_bounded():
    history = judged(gearbox())
    for k in range(100):  # at 100 kHz, and levels that change with each message
        history.add_motion(T0 + 10 ** 12 + np.arange(5000) * 10_000 + k * 50 * MS,
                           np.ones((5000, 2)))
        history.add_alert(State(1, 'backlash', 'grown'), 'today')
    for k in range(5000):
        history.add_status(1000.0 + k, 'model', k % 2, '', {})
    assert len(history._stamps) == 20_000 and len(history.alerts) == 20
    assert len(history.levels['model'].begins) <= 602 and len(history.windows) <= 300


def test_a_source_that_begins_again_replaces_what_was():
    history = gearbox()
    history.add_motion(T0 + np.arange(100) * MS, np.ones((100, 2)))
    motion = history.motion(600)
    assert len(motion.t) == 100 and (motion.tau_k == 1.0).all()
    history.add_motion(T0 + np.array([100, 99, 100]) * MS, np.zeros((3, 2)))
    assert history.motion(600).t == pytest.approx([-1e-3, 0.0])


def test_a_dropout_leaves_a_gap_in_the_curve():
    history = gearbox(seconds=4)
    whole = parts(history)['motion0']
    history.add_motion(T0 + (5000 + np.arange(2000)) * MS, np.zeros((2000, 2)))
    line = parts(history)['motion0'].rpartition('data-name="torque"')[2].partition('/>')[0]
    assert line.count('M') == 2
    assert whole.rpartition('data-name="torque"')[2].partition('/>')[0].count('M') == 1


def test_impossible_values_are_drawn_as_none():
    history = gearbox(seconds=4)
    history.add_motion(np.array([T0 + 4000 * MS, T0 + 4001 * MS]),
                       np.array([[np.inf, 1e300], [0.0, np.nan]]))
    history.add_status(0.0, 'covariance', 0, '', {'tau_k_std': 'inf'})
    history.add_status(0.0, 'backlash', 0, '', {'gap_rad': '1e308', 'gap_std_rad': 'x'})
    assert 'Torque over twist' in parts(history)['motion0']


def test_without_an_arm_encoder_the_torque_remains():
    html = parts(gearbox(twist=False))['motion0']
    assert 'The twist is not estimated' in html and 'Torque over time' in html
    assert 'class="plane' not in html and '<dt>twist' not in html


def test_the_headline_is_the_worst_of_all_and_silence_is_an_error():
    assert 'Waiting for diagnostics of /estimator' in parts(gearbox())['summary']
    assert 'class="verdict good"' in parts(judged(gearbox()))['summary']
    html = parts(judged(gearbox()), judged(gearbox('wrist <b>'), 2))['summary']
    assert 'class="verdict error"' in html and 'wrist &lt;b&gt;: model: so it is' in html
    assert 'silent for 21 s' in parts(judged(gearbox()), time_s=720.0)['summary']


def test_wear_comes_before_its_symptoms():
    history = judged(gearbox(), 2, 'prediction error')
    grown = 'backlash has grown by 41.0 ± 0.3 % since 10:00: service the gearbox'
    late = '; backlash not compared since 10:05: still'
    history.add_status(700.0, 'backlash', 1, grown + late, {'codes': 'gap_2 not_compared'})
    other = judged(gearbox('wrist'), 2, 'model')
    html = parts(other, history)
    said = re.sub('</?span[^>]*>', '', html['summary'])
    assert f'elbow: backlash: {grown} (1 more gearbox).' in said
    still = 'backlash not compared since 10:05: standing still'
    history.add_status(701.0, 'backlash', 1, still, {'codes': 'not_compared'})
    assert 'prediction error: so it is' in parts(history)['summary']


def test_a_sample_that_is_lost_is_no_number():
    history = gearbox(seconds=4)
    history.add_motion(T0 + np.array([4500]) * MS, np.full((1, 2), np.nan))
    html = parts(history)['motion0'].partition('<svg')[0]
    assert 'N m' in html and 'nan' not in html


def test_what_only_diagnostics_change_is_drawn_when_they_do():
    history, page = judged(gearbox()), LivePage()
    first, second = (page.parts([history], '', 700.0)['condition0'] for _ in range(2))
    assert first is second
    history.add_alert(State(2, 'backlash', 'grown'), 'today')
    assert 'today: backlash ERROR: grown' in page.parts([history], '', 700.0)['condition0']


# ---------------------------------------------------------------------- served


@pytest.fixture
def server():
    server = EventServer(live_frame(), '127.0.0.1', 0)
    yield server
    if not server.ended:
        server.close()


def wait(condition, what='it'):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end, f'{what} did not happen'
        time.sleep(0.05)


def got(server, path, host=None):
    """Return the response to a request for `path`."""
    connection = http.client.HTTPConnection(urlsplit(server.address).netloc, timeout=20)
    connection.request('GET', path, headers={'Host': host} if host else {})
    return connection.getresponse()


def event(response):
    """Return the parts of the next event."""
    while not (line := response.readline()).startswith(b'data: '):
        assert line
    return json.loads(line[6:])


def test_an_event_holds_what_changed_and_a_slow_client_gets_the_newest(server):
    response = got(server, '/events')
    wait(lambda: server.clients == 1)
    server.publish({'a': '1', 'b': '1'})
    assert event(response) == {'a': '1', 'b': '1'}
    server.publish({'a': '1', 'b': '2'})
    assert event(response) == {'b': '2'}
    for k in range(50_000):
        server.publish({'a': str(k)})
    newest = {}
    while newest.get('a') != '49999':
        newest = event(response)


def test_requests_that_are_refused(server, monkeypatch, capfd):
    page = got(server, '/')
    assert page.status == 200 and b'<div id="live">' in page.read()
    assert "connect-src 'self'" in page.headers['Content-Security-Policy']
    assert got(server, '/', host='localhost:1').status == 200
    assert got(server, '/events', host='evil.example:80').status == 403
    assert got(server, '/../etc/passwd').status == 404
    monkeypatch.setattr(live_node, 'MAX_CLIENTS', 1)
    first = got(server, '/events')
    wait(lambda: server.clients == 1)
    assert got(server, '/events').status == 503
    first.close()  # a client that goes makes room, and no noise
    wait(lambda: server.clients == 0, 'end of the client')
    assert capfd.readouterr() == ('', '')
    with pytest.raises(InputError, match=r'127.0.0.1:\d+: Address already in use, expected'):
        EventServer(('', ''), '127.0.0.1', urlsplit(server.address).port)
    with pytest.raises(InputError, match='no.such.name.invalid:0: .*, expected an address'):
        EventServer(('', ''), 'no.such.name.invalid', 0)


@pytest.mark.parametrize('width', [1400, 390])
def test_page_in_a_browser(browser, server, width):
    """It draws, nothing is cut off, nobody else is asked; a lost connection is said."""
    requests(browser)
    overflowing(browser, server.address, width)
    wait(lambda: server.clients == 1)
    page = LivePage()
    name = 'line_7_cell_12_robot_3_joint_5_gearbox_SN0815_of_2019'
    histories = [judged(gearbox(name), 2), gearbox('wrist')]
    server.publish(page.parts(histories, '/estimator', 700.0))

    def texts(selector):  # in one script: the page may redraw between two commands
        return browser.execute_script(
            'return Array.from(document.querySelectorAll(arguments[0]), e => e.textContent)',
            selector)
    wait(lambda: texts('#live h2') == [name, 'wrist'], 'drawing')
    assert browser.execute_script(OVERFLOW) == []
    histories[1].add_motion(np.array([T0 + 30_000 * MS]), np.array([[0.0, 1.25]]))
    server.publish(page.parts(histories, '/estimator', 700.0))
    wait(lambda: '1.25 N m' in texts('#motion1 dd'), 'new figure')
    assert len(browser.find_elements('css selector', '#motion0 path.mean')) == 5
    assert not [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE']
    assert {urlsplit(address).netloc for address in requests(browser)
            if address.startswith('http')} == {urlsplit(server.address).netloc}
    server.close()
    wait(lambda: texts('#lost')[0].startswith('No connection since'), 'notice')
    assert browser.execute_script(OVERFLOW) == []
