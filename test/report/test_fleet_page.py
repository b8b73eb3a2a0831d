# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a fleet, of rows as fleet.fleet_run makes them."""
import csv
import re

import numpy as np
from pages import overflowing
import pytest

from gearbox_monitor.report.fleet_page import fleet_csv, fleet_page, headline

DAY = 86_400_000_000_000
T0 = 1_768_435_200_000_000_000  # 2026-01-15


def box(name, gap, level, summary='backlash has grown', bags=5):
    """Return what gearboxes() gives of a gearbox whose backlash became `gap` (rad)."""
    known = dict.fromkeys(('level', 'level_std', 'baseline', 'baseline_std', 'change',
                           'change_std'), 0.0)
    feature = {**known, 'rate': 0.0, 'rate_std': 0.0, 'limit_ns': []}
    change = gap / 0.2 - 1.0
    return {'gearbox': name, 'level': level, 'summary': summary, 'feature': 'gap', 'unit': 'rad',
            'features': {**dict.fromkeys(('lost_motion', 'stiffness', 'friction', 'hysteresis'),
                                         feature),
                         'gap': {**feature, 'level': gap, 'level_std': 2e-4, 'baseline': 0.2,
                                 'change': change, 'change_std': 1e-3}},
            'limit': 0.25, 'marks': [], 'alerts': {}, 'bags': bags, 'first': T0,
            'last': T0 + 30 * bags * DAY, 'trust': 'OK', 'model_level': 'OK', 'not_excited': '',
            'points': [{'start': T0 + 30 * k * DAY, 'means': {'gap': (0.2 + k * 0.01, 2e-4)},
                        'changes': {'gap': 0.05 * k}} for k in range(bags)]}


def page(*boxes):
    return fleet_page(boxes, (), {'done': sum(box['bags'] for box in boxes)}, 0)


def test_kind_of_the_headline():
    for level, kind in [('OK', 'good'), ('WARN', 'warn'), ('ERROR', 'error')]:
        html = page(box('SN1', 0.23, level))
        assert f'class="verdict {kind}"' in html
        assert ('Inspect SN1' in html) == (kind != 'good') and 'What to do next' in html
        # 1 % of the method, as accept states it.
        assert '0.230 ± 0.002 rad' in html


def test_what_is_not_compared_is_never_good():
    grey, good = box('SN1', 0.2, None, bags=1), box('SN2', 0.2, 'OK')
    assert 'class="badge"' not in page(grey) and 'No gearbox could be compared' in page(grey)
    assert 'class="badge"' not in page(good, grey)
    assert headline([good, grey]) == 'No wear detected in 1 gearbox; 1 not compared.'
    html = fleet_page([good], (), {'done': 5, 'failed': 1}, 0)  # of which gearbox, nobody knows
    assert 'class="badge"' not in html and 'gearbox. 1 bag could not be evaluated.' in html
    worst = box('SN3', 0.3, 'ERROR', 'stiffness has dropped by 36.0 %')
    assert headline([worst, good]) == 'SN3: stiffness has dropped by 36.0 %.'


def test_a_joint_of_a_robot_is_drawn_over_its_bags():
    points = [{'start': T0 + k * DAY, 'states': {'friction': {
        'size': 0.17 * k, 'std': 0.05, 'judged': True}}} for k in range(3)]
    joint = {'robot': 'arm7', 'joint': 'joint3', 'level': 'WARN', 'summary': 'friction +34 ± 5 %',
             'states': points[-1]['states'], 'bags': 3, 'first': T0, 'last': T0 + 2 * DAY,
             'points': points}
    html = fleet_page([joint], (), {'done': 3}, 0, robots=True)
    assert 'class="verdict warn"' in html and 'friction (%)' in html and 'joint3 of arm7' in html


def test_the_shop_reads_who_what_since_until_and_serviced():
    worn = box('SN1', 0.23, 'WARN', 'backlash has grown by +15 %')
    worn['alerts'] = {'gap.cusum': {'since_ns': T0 + 20 * DAY}}
    worn['marks'] = [(T0 - 40 * DAY, 'new gear'), (T0 - 10 * DAY, 'grease, "X2"')]
    worn['features']['gap']['limit_ns'] = [T0 + 200 * DAY, T0 + 90 * DAY]
    rows = list(csv.reader(fleet_csv([worn, box('SN2', 0.2, 'OK')]).splitlines()))
    assert rows[1] == ['SN1', 'WARN', 'backlash has grown by +15 %', '2026-02-04', '2026-08-03',
                       '2026-04-15', '2026-01-05 grease, "X2"']
    assert rows[2][3:] == [''] * 4
    html = page(worn)
    assert html.index('2026-08-03') < html.index('id="s2"')
    assert 'href="fleet.csv"' in html and 'class="mark good"' in html


def test_equal_growth_is_equally_high_in_all_charts():
    small, large = box('SN1', 0.23, 'OK'), box('SN2', 0.23, 'OK')
    for feature in (large['features']['gap'], *(p['means'] for p in large['points'])):
        for key in ('baseline', 'level', 'gap'):
            if key in feature:
                feature[key] = (10.0 * np.array(feature[key])).tolist()
    ends = [tuple(map(float, pair)) for pair in re.findall(
        r'data-low="([^"]+)" data-high="([^"]+)"', page(small, large))]
    assert np.array(ends[1]) == pytest.approx(10.0 * np.array(ends[0]))


@pytest.mark.parametrize('width', [1400, 700, 390])
def test_nothing_is_cut_off(browser, tmp_path, width):
    file = tmp_path / 'fleet.html'
    name = 'line_7_cell_12_robot_3_joint_5_gearbox_SN0815_of_2019'
    file.write_text(page(box(name, 0.25, 'ERROR'), box('b', 0.2, None, bags=1)))
    assert overflowing(browser, file.as_uri(), width) == []
