# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a watch: each finding at its joint, the same live and offline, on any screen."""
from dataclasses import replace
import itertools
import re

import numpy as np
from pages import overflowing
import pytest

from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.report.chart import Box, Dot, HEIGHT, LETTER, LINE, sketch, WIDTH
from gearbox_monitor.report.live_page import LivePage, WatchNews
from gearbox_monitor.report.watch_page import watch_page
from gearbox_monitor.report.watch_words import watch_data
from gearbox_monitor.robot.chain import chain_of
from gearbox_monitor.robot.description import parse
from gearbox_monitor.watch.fold import begin
from gearbox_monitor.watch.record import (
    Change, FRICTION, HeldLoad, ROTOR, SCALE, SECOND, StateHealth, WATCH, WEIGHT)

ARM = config_path('arm6.urdf').read_text(encoding='utf-8')
NOW = 1_772_438_400 * SECOND
MINUTE = 60 * SECOND
POSTURE = 0.3, -0.4, 1.0, 0.2, 0.7, 0.0
FOUND = 'joint2: friction +34 ± 5 % since 2026-03-02 07:45:00 UTC.'


def load(mass, since, over=0):
    return HeldLoad('flange', mass, 0.1, (0.0, 0.03, 0.08), (0.01,) * 3, NOW - since * MINUTE,
                    NOW - over * MINUTE if over else 0)


def found(names=('joint1', 'joint2', 'joint3', 'joint4', 'joint5', 'joint6')):
    """Return data and description of an arm that rubs at its second joint and holds 2 kg."""
    description = ARM
    for k, name in enumerate(names, 1):
        description = description.replace(f'"joint{k}"', f'"{name}"')
    watch = begin(description)
    joints = [replace(
        joint, position=q, level=Level.OK, states=tuple(
            StateHealth(kind, -0.021, 0.006, joint.name != names[3])
            for kind in (FRICTION, SCALE, ROTOR, WEIGHT))) for joint, q in zip(
                watch.joints, POSTURE)]
    rubs = Change(FRICTION, names[1], 0.34, 0.05, NOW - 15 * MINUTE, NOW - 13 * MINUTE)
    joints[1] = replace(joints[1], level=Level.WARN, states=(
        StateHealth(FRICTION, 0.34, 0.05, True), *joints[1].states[1:]))
    joints[4] = replace(joints[4], level=None, why='has not moved yet')
    watch = replace(
        watch, phase=WATCH, stamp_ns=NOW, joints=tuple(joints), level=Level.WARN,
        changes=(replace(rubs, place=names[2], over_ns=NOW - 10 * MINUTE), rubs),
        payloads=(load(2.0, 5),), earlier=(load(0.0, 20, 12), load(3.0, 12, 5)))
    return watch_data(watch), description


def test_each_finding_is_at_its_joint_and_the_answer_comes_first():
    html = watch_page(*found(), 'Watch')
    body = re.sub('</?span[^>]*>', '', html[html.index('<main>'):])
    order = [body.index(words) for words in (
        FOUND, '2.00 ± 0.10 kg at flange', '<svg', '<table', 'Changes', 'watch/tare')]
    assert order == sorted(order)
    at = dict(re.findall(r'<circle class="joint (\w+)" cx="[\d.]+" cy="([\d.]+)"', body))
    texts = re.findall(r'<text class="(\w+)" .*?y="([\d.]+)".*?>([^<]+)</text>', body)
    for role, name, words in (('hit', 'joint2', 'friction +34 ± 5 %'),
                              ('held', 'joint6', '+2.00 ± 0.10 kg')):
        (k, _), = [(k, t) for k, t in enumerate(texts) if t[0] == role]
        assert [t[2] for t in texts[k - 1:k + 1]] == [name, words]
        assert abs(float(texts[k][1]) - float(at[role])) < 2.0 * LINE
    cells = re.findall(r'<td[^>]*>(?:<span[^>]*>)?([^<]+)', body)
    row = cells.index('joint2')
    assert cells[row:row + 7] == ['joint2', 'WARN', '+34 ± 5', *3 * ['-2.1 ± 0.6'],
                                  'friction +34 ± 5 % since 2026-03-02 07:45:00 UTC']
    assert cells[cells.index('joint5') + 1] == 'not judged: has not moved yet'
    assert cells[cells.index('joint4') + 2] == '-'
    lanes = re.findall(r'class="ylabel">([^<]+)', body)
    assert lanes == ['joint3: friction +34 ± 5 %', 'joint2: friction +34 ± 5 %', 'flange (kg)']


def test_words_in_the_sketch_neither_cover_each_other_nor_leave_it():
    chain, rng = chain_of(parse(ARM, 'arm')), np.random.default_rng(4)
    for _ in range(60):
        dots = {link.joint: Dot(link.joint * int(rng.integers(1, 3)), ['friction +34 ± 5 %'] * int(
            rng.integers(0, 3)), needed=False) for link in chain.links}
        view = sketch(chain, rng.uniform(-2.0, 2.0, 6), dots)
        boxes = []
        for item in view['dots']:
            if text := item['text']:
                width = LETTER * max(len(words) for _, words in text['lines'])
                left = text['x'] - width if text['left'] else text['x']
                top = text['lines'][0][0] - 0.8 * LINE
                boxes.append(Box(left, top, left + width, top + LINE * len(text['lines'])))
        assert len(boxes) > 2 and not any(a.hits(b) for a, b in itertools.combinations(boxes, 2))
        assert all(0.0 <= b.left and b.right <= WIDTH and 0.0 <= b.top and b.bottom <= HEIGHT
                   for b in boxes)


def test_live_is_offline_and_what_is_old_is_grey():
    data, description = found()
    page, news = LivePage(), WatchNews('watch', 10.0, data, description)
    live = page.parts([], '/estimator', 11.0, news)
    assert live['watch'] in watch_page(data, description, 'Watch') and not live['summary']
    for time_s, problem, words in ((11.0, 'no joint_states', 'No joint_states.'),
                                   (40.0, '', 'Watch has been silent for 30 s.')):
        html = page.parts([], '', time_s, replace(news, problem=problem))['watch']
        assert words in html and 'class="old"' in html and 'friction +34' in html
    for strange in ('text', {}, {'level': 7}, {**data, 'joints': {'joint1': None}}):
        html = page.parts([], '', 11.0, replace(news, data=strange))['watch']
        assert ('findings of another kind' if strange else 'The watch starts.') in html
    html = page.parts([], '', 11.0, replace(news, description='<robot'))['watch']
    assert '<table' in html and 'class="robot"' not in html


LONG = tuple(f'{part}_joint' for part in (
    'shoulder_pan', 'shoulder_lift', 'elbow', 'wrist_1', 'wrist_2', 'wrist_3'))


@pytest.mark.parametrize('width, height', [(390, 844), (1400, 900)])
def test_page_in_a_browser(browser, tmp_path, width, height):
    """All that matters is on the first screen."""
    for names in ((), LONG):
        file = tmp_path / f'{len(names)}.html'
        file.write_text(watch_page(*found(*([names] if names else [])), 'Watch'))
        assert overflowing(browser, file.as_uri(), width) == []
        bottom = browser.execute_script(
            'return document.querySelector(arguments[0]).getBoundingClientRect().bottom',
            'table' if names and width < 600 else '.xlabel')
        assert bottom <= height, names
