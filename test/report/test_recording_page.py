# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a recording: what is gathered, live or replayed, and the page in a browser."""
import json
from types import SimpleNamespace

from live import PARAMETERS, RATE, T0, worn, write_inputs, write_live
import numpy as np
from pages import overflowing, requests
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report import recording_page
from gearbox_monitor.report.chart import LoopSlice, Plane, plane_view
from gearbox_monitor.report.timeline import (
    Envelope, loop_of, RecordingFacts, State, Timeline, WindowBacklash)

SECONDS = 24
LOST = (29 * RATE // 2, 31 * RATE // 2)  # samples without the arm


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Return a folder with a bag of inputs, one with what an estimator said, and its options."""
    folder, samples = tmp_path_factory.mktemp('life'), worn(SECONDS, LOST)
    (folder / 'params.yaml').write_text(yaml.safe_dump(
        {'estimator': {'ros__parameters': PARAMETERS}}))
    (folder / 'drive.yaml').write_text(yaml.safe_dump(DriveModel().to_dict()))
    with BagWriter(folder / 'inputs') as writer:
        write_inputs(writer, samples)
    with BagWriter(folder / 'live <b>') as writer:
        write_inputs(writer, samples)
        write_live(writer, samples)
    return folder


@pytest.fixture(scope='module')
def pages(bags):
    """Return {bag: figures of its page}; the pages are in the folder `bags`."""
    told = {}
    for name, options in (('live <b>', []), ('inputs', [
            '--model', str(bags / 'drive.yaml'), '--params', str(bags / 'params.yaml')])):
        assert main(['report', str(bags / name), *options, '--out', str(bags / f'{name}.html'),
                     '--json', str(bags / f'{name}.json')]) == 0
        told[name] = json.loads((bags / f'{name}.json').read_text())
    return told


def test_live_and_replayed_say_the_same(pages):
    live, again = pages['live <b>'], pages['inputs']
    for figures in pages.values():
        assert figures['samples'] == RATE * SECONDS and figures['loops'] == 3
        assert figures['headline'].startswith('Backlash has grown by ')
        assert figures['within_2_sigma']['motor'] == pytest.approx(0.954, abs=0.01)
        assert figures['nis_over_dof'] == pytest.approx(1.0, abs=0.05)
        assert figures['counts']['missing arm positions'] == LOST[1] - LOST[0]
        assert figures['alerts'][0]['component'] == 'backlash'
        assert figures['alerts'][0]['t'] == pytest.approx(18.0, abs=6.0)
        assert figures['levels']['input']['ERROR'] == 0.0
    assert live['within_2_sigma'] == again['within_2_sigma']
    assert live['gap_rad'] == pytest.approx(again['gap_rad'], abs=1e-12)
    assert [a['message'] for a in live['alerts']] == [a['message'] for a in again['alerts']]
    for name, shares in again['levels'].items():
        assert live['levels'][name]['OK'] == pytest.approx(shares['OK'], abs=0.1)


def test_page_holds_it_all(bags, pages):
    html = (bags / 'live <b>.html').read_text(encoding='utf-8')
    assert len(html) < 2e6 and '<b>' not in html and 'live &lt;b&gt;' in html
    for words in ('One loop per 10 s',
                  'plan a service', 'missing arm positions',
                  'drift_window', 'gear_ratio', 'estimator, kernels', '0.0.9', 'backlash: OK'):
        assert words in html
    drawn = html.split('<pre>')[0].split('</style>')[1]
    assert 'nan' not in drawn.lower().replace('nano', '')
    for word in ('http:', 'https:', 'url(', '@import', ' src='):
        assert word not in html


def test_an_hour_makes_a_small_page():
    """Its size depends on the time and on the events, not on the samples."""
    random, line = np.random.default_rng(1), Timeline(60.0)
    for minute in range(60):
        stamps = T0 + (minute * 6000 + np.arange(6000)) * 10_000_000
        noise = random.standard_normal((6, 6000))
        line.add_inputs(stamps, noise[0])
        ones = np.ones(6000)
        line.add_estimates(SimpleNamespace(
            stamp_ns=stamps, innovation_motor=noise[0], innovation_std_motor=ones,
            innovation_arm=noise[1], innovation_std_arm=ones, nis=noise[3] ** 2, dof=ones,
            tau_k=noise[2], tau_k_std=ones, smoothed=np.empty((0, 20)),
            smoothed_stamp_ns=stamps[:0]), 1.0)
        line.add_loop(stamps, noise[4], noise[5], noise[4] + noise[3])
        for k in range(6):
            line.add_window(stamps[1000 * k], WindowBacklash(0.0, 0.2, 0.01, 0.2, True))
        for k in range(60):  # levels that change every second
            line.add_states(stamps[100 * k], (
                State(k % 3, name, 'far too often' * 5)
                for name in (*recording_page.TRUST, *recording_page.WEAR)))
    line.finish()
    assert len(line.loops) == 60 and line.last == pytest.approx(3599.99, abs=1e-3)
    html = recording_page.recording_page(
        line, RecordingFacts(DriveModel(), Monitor(DriveModel()).parameters), 'hour',
        'BAG')
    assert len(html.encode()) < 10e6


# ---------------------------------------------------------------------- parts


def test_envelope_keeps_extremes_however_long_it_gets():
    random = np.random.default_rng(1)
    t = np.sort(random.uniform(0.0, 500.0, 20000))
    signal = random.standard_normal(len(t))
    signal[::7] = np.nan
    envelope = Envelope(1)
    for part in np.array_split(np.arange(len(t)), 13):
        envelope.add(t[part], signal[part])
    low, high, mean = envelope.of(0)
    assert 1500 < len(envelope.t) <= 3000
    at = (t / envelope.width).astype(int)
    for k in (0, 17, 800, len(low) - 1):
        here = signal[at == k]
        assert low[k] == np.nanmin(here) and high[k] == np.nanmax(here)
        assert mean[k] == pytest.approx(np.nanmean(here))
    assert np.nanmin(low) == np.nanmin(signal) and np.nanmax(high) == np.nanmax(signal)
    assert np.isnan(envelope.of(0)[0]).sum() == len(low) - len(np.unique(at[~np.isnan(signal)]))


def test_branches_of_a_loop_are_its_two_sides():
    t = np.linspace(0.0, 20.0 * np.pi, 20000)
    t = t[np.abs(np.sin(t) - 0.3) > 0.1]  # a range of the twist that the motion leaves out
    twist, rate = np.sin(t), np.cos(t)
    loop = loop_of(0.0, 10.0, twist, rate, 3.0 * twist + 0.5 * np.sign(rate))
    for (x, y), side in ((loop.up, 0.5), (loop.down, -0.5)):
        assert np.isfinite(x).sum() > 25 and np.isnan(y).any()
        assert y == pytest.approx(3.0 * x + side, abs=1e-6, nan_ok=True)
    view = plane_view(Plane('', [LoopSlice('', loop.cloud, (loop.up, loop.down))], '', ''))
    assert view['slices'][0]['lines'].count('M') == 4  # no line across it


def test_steps_by_stamps():
    line = Timeline(60.0)
    stamps = T0 + np.concatenate([np.arange(0, 2000, 10), np.arange(2500, 5001, 10)]) * 1_000_000
    for part in np.array_split(stamps, 7):
        line.add_inputs(part, np.zeros(len(part)))
    line.finish()
    low, high, mean = line.steps.of(0)
    assert np.nanmin(low) == pytest.approx(0.01) == pytest.approx(np.nanmedian(mean))
    assert line.steps.t[np.nanargmax(high)] == pytest.approx(2.5, abs=0.01)
    assert np.nanmax(high) == pytest.approx(0.51)


FACTS = RecordingFacts(DriveModel(), EstimatorParameters())


@pytest.mark.parametrize('code, kind', [('alone', ''), ('learning', ''), ('unchanged', 'good')])
def test_without_an_earlier_baseline_a_recording_is_grey(code, kind):
    line, facts = Timeline(60.0), FACTS
    line.add_inputs(T0 + np.arange(10) * 1_000_000_000, np.zeros(10))
    line.add_window(T0, WindowBacklash(0.0, 0.2, 1e-3, 0.2, True))
    for k in range(10):
        line.add_states(T0 + k * 1_000_000_000, (
            State(0, 'model', 'fits'), State(0, 'backlash', 'backlash 0.2 rad; more', (code,))))
    line.finish()
    assert recording_page.headline(line, facts) == ('Backlash 0.2 rad.', kind)
    steps = ' '.join(recording_page.next_steps(line, facts, 'a/bag'))
    assert ('accept a/bag' in steps) == (not kind)


@pytest.mark.parametrize('later', [0, 3_600_000_000_000])  # ns: the driver's clock is slow
def test_a_page_tells_what_a_live_node_refused(tmp_path, later):
    """A replay sees the samples alone, not who published them: its page alone was green."""
    samples = worn(12, rate=0.0)
    with BagWriter(tmp_path / 'bag') as writer:
        write_inputs(writer, samples, later)
        write_live(writer, samples, refused=(4, 10), later=later)
    assert main(['report', str(tmp_path / 'bag'), '--out', str(tmp_path / 'page.html'), '--json',
                 str(tmp_path / 'page.json')]) == 0
    told = json.loads((tmp_path / 'page.json').read_text())
    assert told['headline'] == ('The estimates were trusted 45 % of the time: two publishers '
                                'deliver the joint.')
    assert told['levels']['live node']['ERROR'] == pytest.approx(0.5, abs=0.1)
    assert 'live node: ' in (tmp_path / 'page.html').read_text()


def test_headline_names_what_is_most_wrong():
    line = Timeline(60.0)
    line.add_inputs(T0 + np.arange(10) * 1_000_000_000, np.zeros(10))
    for k in range(10):
        line.add_states(T0 + k * 1_000_000_000, (
            State(0, 'observability', 'seen'),
            State(2 * (k > 4), 'prediction error', 'far too large: check it'),
            State(1, 'model', 'nothing came', ('no_data_yet',)),
            State(1, 'backlash', 'nothing seen', ('backlash_unmeasured',))))
        if k == 5:  # the alarm is the newest state, of no length: trusted all of the time
            assert recording_page.headline(line, FACTS) == (
                'The estimates are not trusted at the end: far too large; they were 100 % of the '
                'time.', 'error')
            assert 'diagnose a/bag' in ' '.join(recording_page.next_steps(line, FACTS, 'a/bag'))
    line.finish()
    assert recording_page.trusted_share(line.spans) == pytest.approx(5.0 / 9.0)
    line.add_states(T0 + 9_000_000_000, (State(1, 'backlash', 'not compared', ('not_compared',)),))
    assert recording_page.headline(line, FACTS) == (
        'The estimates were trusted 56 % of the time: far too large.', 'error')
    grown = 'backlash has grown: service it; and more'
    line.add_states(T0 + 9_000_000_000, (State(2, 'backlash', grown, ('gap_3',)),))
    assert recording_page.headline(line, FACTS) == ('Backlash has grown: service it.', 'error')


# ---------------------------------------------------------------------- command and browser


def test_bad_input(bags, pages, tmp_path, capsys):
    for options, says in (
            (['--out', str(bags / 'inputs.html')], 'exists, expected a new file'),
            (['--out', str(tmp_path / 'no/page.html')], 'no such folder, expected a new name'),
            (['--filter', 'kalman'], "filter: 'kalman'"),
            (['--topic', '/nothing'], 'no topic /nothing')):
        assert main(['report', str(bags / 'inputs'), *options]) == 2
        assert says in capsys.readouterr().err


@pytest.mark.parametrize('width', [1400, 700, 390])
def test_nothing_is_cut_off(bags, pages, browser, width):
    assert overflowing(browser, (bags / 'live <b>.html').as_uri(), width) == []


def test_the_newest_state_is_stated():
    """An OK that lasts has the newest message, not that of the change to OK."""
    line = Timeline(60.0)
    line.add_inputs(T0 + np.arange(3) * 1_000_000_000, np.zeros(3))
    for k, words in enumerate(('no baseline (1 of 3 windows)', 'gap +0.1 % over the baseline')):
        line.add_states(T0 + k * 1_000_000_000, (State(0, 'backlash', words),))
    assert [s.message for s in line.spans['backlash'].states] == ['gap +0.1 % over the baseline']


def test_warning_and_error_differ():
    """The headline of each has its own kind and word."""
    for level in (1, 2):
        line = Timeline(60.0)
        line.add_inputs(T0 + np.arange(3) * 1_000_000_000, np.zeros(3))
        line.add_states(T0, (State(level, 'backlash', 'backlash has grown', ('gap_2',)),))
        line.finish()
        html = recording_page.recording_page(
            line, RecordingFacts(DriveModel(), Monitor(DriveModel()).parameters), 'worn',
            'a/bag')
        kind = ('good', 'warn', 'error')[level]
        assert f'class="verdict {kind}"' in html and f'class="badge">{kind.upper()}<' in html
        assert 'gearbox_monitor accept a/bag' in html


@pytest.mark.parametrize('width', [1280, pytest.param(390, marks=pytest.mark.system)])
def test_page_in_a_browser(bags, pages, browser, width):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By
    browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': width, 'height': 900, 'deviceScaleFactor': 1, 'mobile': False})
    address = (bags / 'live <b>.html').as_uri()
    browser.get('about:blank')
    requests(browser)
    browser.get(address)

    def find(selector):
        return browser.find_elements(By.CSS_SELECTOR, selector)

    def shown(figure):
        return [float(v) for v in figure.get_attribute('data-shown').split()]
    assert browser.execute_script('return document.documentElement.scrollWidth') <= width

    # One loop after the other.
    plane, = find('figure.plane')
    slices = plane.find_elements(By.CSS_SELECTOR, 'g.slice')
    assert len(slices) == 3
    later = plane.find_element(By.CSS_SELECTOR, '[data-pick="1"]')
    for name in ('0 to 10 s', '10 to 20 s', '20 to 24 s'):
        later.click()
        assert plane.find_element(By.TAG_NAME, 'output').text == name
        chosen, = plane.find_elements(By.CSS_SELECTOR, 'g.slice.on')
        assert chosen.get_attribute('data-name') == name
        assert chosen.find_element(By.CSS_SELECTOR, 'path.cloud').is_displayed()
    # Both axes of the loop zoom.
    whole = [float(plane.get_attribute(f'data-{side}')) for side in ('left', 'right', 'low',
                                                                     'high')]
    plane.find_element(By.CSS_SELECTOR, '[data-zoom=in]').click()
    left, right, low, high = shown(plane)
    assert right - left == pytest.approx(0.5 * (whole[1] - whole[0]))
    assert high - low == pytest.approx(0.5 * (whole[3] - whole[2]))
    plot = plane.find_element(By.CSS_SELECTOR, '.plot')
    browser.execute_script('arguments[0].scrollIntoView({block: "center"})', plot)
    ActionChains(browser).move_to_element(plot).click_and_hold().move_by_offset(
        60, 50).release().perform()
    narrow = shown(plane)
    assert left < narrow[0] < narrow[1] < right and low < narrow[2] < narrow[3] < high
    assert plot.find_elements(By.CSS_SELECTOR, '.yts span')
    ActionChains(browser).move_to_element(plot).double_click().perform()
    assert shown(plane) == pytest.approx(whole)

    # All charts over time zoom together.
    charts = find('figure.chart')
    assert len(charts) == 5
    charts[0].find_element(By.CSS_SELECTOR, '[data-zoom=in]').click()
    begin, end = shown(charts[0])
    assert end - begin == pytest.approx(0.5 * SECONDS, rel=0.01)
    assert all(shown(chart) == [begin, end] for chart in charts)
    charts[3].find_element(By.CSS_SELECTOR, '[data-zoom=all]').click()
    assert shown(charts[0]) == pytest.approx([0.0, SECONDS], abs=0.01)
    assert find('.mk')[0].is_displayed()
    lane = charts[1].find_elements(By.CSS_SELECTOR, '.plot')[0]
    browser.execute_script('arguments[0].scrollIntoView({block: "center"})', lane)
    ActionChains(browser).move_to_element(lane).perform()
    assert 'observability OK' in charts[1].find_element(By.CSS_SELECTOR, '.readout').text
    for summary in find('summary'):
        summary.click()
    assert all(part.get_attribute('open') for part in find('details'))
    assert browser.execute_script('return document.documentElement.scrollWidth') <= width
    for media in ('print', 'screen'):
        browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': media})
        assert plane.find_element(By.CSS_SELECTOR, '.pick').is_displayed() == (media == 'screen')
    assert browser.get_log('browser') == []
    assert [url for url in requests(browser) if not url.startswith(('data:', address))] == []
