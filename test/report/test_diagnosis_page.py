# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a diagnosis in a real browser, and what is drawn in it."""
from dataclasses import replace
import json

import numpy as np
from pages import overflowing, requests
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import load_model
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.report import diagnosis_page
from gearbox_monitor.report.chart import Axis

MODEL = DriveModel()
TRUE = {'id': 'arm_coulomb', 'Cac': 0.05}


def record(path, effects, seed=1):
    t = np.arange(2500) * 2e-3
    u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1 + 0.1 * seed)).torque(t)
    x = simulate(replace(MODEL, effects=effects), u, 2e-3).x[:, :2]
    y = x + 0.002 * np.random.default_rng(seed).standard_normal(x.shape)
    np.savetxt(path, np.column_stack([t, u, y]), '%.9g', ',', header='t,u,motor,arm', comments='')


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with recordings, drive.yaml and, in out, all that diagnose writes."""
    folder = tmp_path_factory.mktemp('report')
    (folder / 'drive.yaml').write_text(yaml.safe_dump(MODEL.to_dict()))
    record(folder / 'worn & <b>old.csv', (TRUE,))
    record(folder / 'worn2.csv', (TRUE,), seed=2)
    record(folder / 'good.csv', ())
    assert main(['diagnose', str(folder / 'worn & <b>old.csv'), '--model',
                 str(folder / 'drive.yaml'), '--out', str(folder / 'out'), '--validate',
                 str(folder / 'worn2.csv'), '--only', 'arm_coulomb', 'stribeck', '--jobs',
                 '1']) == 1
    return folder


# ---------------------------------------------------------------------- page


def test_all_of_it_is_written(folder):
    assert sorted(p.name for p in (folder / 'out').iterdir()) == [
        'drive.closed.yaml', 'report.html', 'verdict.json']
    html = (folder / 'out/report.html').read_text(encoding='utf-8')
    assert 1e5 < len(html) < 5e6
    assert '<b>' not in html and 'worn &amp; &lt;b&gt;old.csv' in html
    assert 'arm side: Coulomb friction 0.0' in html and 'validation, ' in html
    assert 'nan' not in html.lower().split('<pre>')[0]
    for word in ('http:', 'https:', 'url(', '@import', ' src='):
        assert word not in html.replace('http://www.w3.org', '')


def test_no_gap_has_a_page_too(folder, tmp_path, capsys):
    out = tmp_path / 'out'
    assert main(['diagnose', str(folder / 'good.csv'), '--model', str(folder / 'drive.yaml'),
                 '--out', str(out), '--only', 'arm_coulomb', '--jobs', '1']) == 0
    shown = capsys.readouterr().out
    assert 'No gap' in shown and 'arm encoder' not in shown
    assert load_model(out / 'drive.closed.yaml') == load_model(folder / 'drive.yaml')
    assert json.loads((out / 'verdict.json').read_text())['verdict'] == 'none'
    html = (out / 'report.html').read_text(encoding='utf-8')
    assert 'No gap: nothing differs' in html and 'Missing torque' not in html


def test_one_encoder_has_no_charts_of_what_it_does_not_measure(folder, tmp_path, capsys):
    both = np.genfromtxt(folder / 'worn & <b>old.csv', delimiter=',', skip_header=1)
    np.savetxt(tmp_path / 'one.csv', both[:2000, :3], '%.9g', ',', header='t,u,motor', comments='')
    main(['diagnose', str(tmp_path / 'one.csv'), '--model', str(folder / 'drive.yaml'), '--out',
          str(tmp_path / 'out'), '--only', 'arm_coulomb', '--jobs', '1', '-v'])
    assert 'arm 0' not in capsys.readouterr().out
    html = (tmp_path / 'out/report.html').read_text(encoding='utf-8').split('<pre>{')[0]
    assert 'motor, angle' in html and 'arm, angle' not in html
    assert html.count('<details class="fold">') == 1  # which effect


@pytest.mark.parametrize('width', [1400, 390])
def test_nothing_is_cut_off(folder, browser, width):
    assert overflowing(browser, (folder / 'out/report.html').as_uri(), width) == []
    assert f'gearbox_monitor export {folder}/out/drive.closed.yaml' in browser.page_source


@pytest.mark.parametrize('width', [1280, pytest.param(390, marks=pytest.mark.system)])
def test_page_in_a_browser(folder, browser, width):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By
    browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': width, 'height': 900, 'deviceScaleFactor': 1, 'mobile': False})
    address = (folder / 'out/report.html').as_uri()
    browser.get('about:blank')
    requests(browser)  # those of the browser's own first page
    browser.get(address)

    def find(selector):
        return browser.find_elements(By.CSS_SELECTOR, selector)
    assert browser.execute_script('return document.documentElement.scrollWidth') <= width

    tabs = find('.tabbar button')
    assert len(tabs) >= 2
    for k, tab in enumerate(tabs):
        tab.click()
        assert [part.is_displayed() for part in find('.tab')] == [
            i == k for i in range(len(tabs))]
        figure = [f for f in find('.tab figure.chart') if f.is_displayed()][0]
        whole = figure.get_attribute('data-from'), figure.get_attribute('data-to')

        def shown():
            return [float(v) for v in figure.get_attribute('data-shown').split()]
        figure.find_element(By.CSS_SELECTOR, '[data-zoom=in]').click()
        begin, end = shown()
        assert end - begin == pytest.approx(0.5 * (float(whole[1]) - float(whole[0])))
        assert figure.find_elements(By.CSS_SELECTOR, '.xt span')
        for what in ('left', 'right', 'out', 'in', 'all'):
            figure.find_element(By.CSS_SELECTOR, f'[data-zoom={what}]').click()
        assert shown() == pytest.approx([float(v) for v in whole])
        plot = figure.find_element(By.CSS_SELECTOR, '.plot')
        ActionChains(browser).move_to_element(plot).click_and_hold().move_by_offset(
            60, 0).release().perform()
        begin, end = shown()
        assert end - begin < 0.3 * (float(whole[1]) - float(whole[0]))
        readout = figure.find_element(By.CSS_SELECTOR, '.readout').text
        assert 'recording' in readout and 'nominal model' in readout and 'time (s)' in readout
        ActionChains(browser).move_to_element(plot).double_click().perform()
        assert shown() == pytest.approx([float(v) for v in whole])
    for summary in find('summary'):
        summary.click()
    assert all(part.get_attribute('open') for part in find('details'))
    assert browser.execute_script('return document.documentElement.scrollWidth') <= width
    for link in find('nav a'):
        link.click()
        assert browser.current_url.startswith(address + '#')
    for feature in ('dark', 'light'):
        browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {
            'features': [{'name': 'prefers-color-scheme', 'value': feature}]})
    assert browser.get_log('browser') == []
    assert [url for url in requests(browser)
            if not url.startswith(('data:', address))] == []


def test_ticks_are_round():
    assert Axis(0.0, 1.0).ticks() == [
        (pytest.approx(0.2 * k), f'{0.2 * k:.1f}') for k in range(6)]
    values, texts = zip(*Axis(-0.031, 0.002).ticks())
    digits = len(texts[0].partition('.')[2])
    assert digits == 3 and values[-1] == 0.0 and len(values) >= 3


def test_curves_to_draw():
    assert diagnosis_page.smoothed(np.ones(100), 1e-3) == pytest.approx(1.0)
    drawn = diagnosis_page.clipped_to_range(np.array([0.5, 1e9, np.nan]),
                                         np.array([0.0, 1.0, 0.5]))
    assert drawn[0] == 0.5 and np.isnan(drawn[1:]).all()
