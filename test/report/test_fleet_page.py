# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a fleet, of rows as fleet.trend makes them."""
from pages import overflowing
import pytest

from gearbox_monitor.fleet.trend import gearboxes
from gearbox_monitor.report.fleet_page import fleet_page, headline

DAY = 86_400_000_000_000
T0 = 1_768_435_200_000_000_000  # 2026-01-15


def bag(gearbox, days, gap):
    """Return the row of an analysed bag."""
    return {'gearbox': gearbox, 'path': f'/archive/{gearbox}/{days}', 'start': T0 + days * DAY,
            'status': 'done', 'separable': True, 'gap': gap, 'gap_std': 2e-4, 'lost_motion': gap,
            'lost_motion_std': 2e-4, 'unit': 'rad', 'gap_warn': 0.1, 'gap_error': 0.25,
            'trust': 'OK', 'model_level': 'OK', 'not_excited': '', 'diagnosis': '',
            'diagnosis_effect': None, 'diagnosis_reason': '', 'notes': '', 'retry': False}


def page(*bags):
    return fleet_page(gearboxes(list(bags)), bags, {'done': len(bags)}, 0)


@pytest.mark.parametrize('gap,kind', [(0.2, 'good'), (0.23, 'warn'), (0.26, 'error')])
def test_kind_of_the_headline(gap, kind):
    html = page(*(bag('SN1', 30 * k, 0.2 + (gap - 0.2) * k / 4) for k in range(5)),
                *(bag('SN1', 120 + k, gap) for k in range(5)))
    assert f'class="verdict {kind}"' in html
    assert ('Inspect SN1' in html) == (kind != 'good') and 'What to do next' in html
    # 1 % of the method, as accept states it.
    assert f'{gap:.4f}\u00a0±\u00a0{0.01 * gap:.4f}\u00a0rad' in html


def test_one_bag_is_no_verdict():
    html = page(bag('SN1', 0, 0.2))
    assert 'No gearbox was measured twice' in html and 'class="badge"' not in html


@pytest.mark.parametrize('width', [1400, 700, 390])
def test_nothing_is_cut_off(browser, tmp_path, width):
    file = tmp_path / 'fleet.html'
    name = 'line_7_cell_12_robot_3_joint_5_gearbox_SN0815_of_2019'
    file.write_text(page(*(bag(name, 30 * k, 0.2 + 0.01 * k) for k in range(6)), bag('b', 1, 0.2)))
    assert overflowing(browser, file.as_uri(), width) == []


def test_growth_that_is_not_significant_says_what_would_settle_it():
    wide = [{**bag('SN1', 30 * k, gap), 'gap_std': 0.013} for k, gap in enumerate((0.2, 0.236))]
    text = headline(gearboxes(wide))
    assert text.startswith('No significant growth: 1 gearbox was measured more than once.')
    assert '+18.0 ± ' in text and 'of SN1 is not significant: record 2 times as long' in text
