# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Every code of the table, and every finding, as a sentence with random numbers."""
from dataclasses import dataclass
import math
from pathlib import Path
import re
from string import Formatter

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import Finding
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import FEATURES, limits_of, TESTS
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.health_record import Alert, FeatureHealth, HealthSettings, Window
from gearbox_monitor.health.judgement import CHANGED, Health, outcomes, sentence as worst, Slip
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.presentation import Quantity, Said
from gearbox_monitor.report.sentences import message, PARTS, phrase, TABLE, title
from gearbox_monitor.report.watch_words import change_words, payload_words
from gearbox_monitor.report.words import finding_words, headline
from gearbox_monitor.watch.record import Change, HeldLoad, KINDS

QUANTITIES = ('size', 'std', 'limit', 'viscous', 'coulomb')
UNITS = ('', '-', 'rad', 'N m', 'kg m^2', '%', '°', 'N m s/rad')
ODD = (0.0, math.nan, math.inf)
LIMITS_OF = limits_of(EstimatorParameters())
# What no sentence may hold: gaps of knowledge as words of a program, and clumsy English.
REFUSED = re.compile(
    r'\b(?:nan|inf|None|beside|lacks?|stands?(?! still)|of which|that of|what)\b|[{}]|\+-'
    r'|-0(?:\.0*)?(?![\d.])'
    r'|± 0(?:\.0*)?(?![\d.])|\. \.|::|  |(?<!\w)(rad|N m|kg|%|N|m) \1(?!\w)')


def expect_good(text, source):
    assert text and not REFUSED.search(text), (source, text)
    for value, deviation in re.findall(r'(?<![\d.e+-])(\d+\.?\d*) ± (\d+\.?\d*)(?![\d.e])', text):
        decimals = [len(part.partition('.')[2]) for part in (value, deviation)]
        assert decimals[0] == decimals[1], (source, text)
        assert len(deviation.replace('.', '').strip('0')) <= 2, (source, text)


def size(rng, value=None):
    """Return (value, deviation) of any kind that a result may hold."""
    value = rng.normal() * 10.0 ** rng.integers(-6, 6) if value is None else value
    kind = rng.integers(5)
    deviation = None if not kind else ODD[rng.integers(3)] if kind == 1 else abs(
        rng.normal()) * 10.0 ** rng.integers(-8, 6)
    return float(value), deviation


def number_of(rng, name, spec, conversion):
    if spec not in ('', '+'):
        return float(abs(rng.normal()))
    if conversion or name not in QUANTITIES:
        return 'name'
    return Quantity(*size(rng), UNITS[rng.integers(len(UNITS))])


def test_every_code_is_a_sentence_with_any_numbers():
    rng = np.random.default_rng(0)
    assert len(TABLE) == sum(map(len, PARTS.values()))  # no code has two sentences
    for code, sentence in TABLE.items():
        assert title(code) and not REFUSED.search(title(code).replace('...', 'n')), code
        for _ in range(20):
            numbers = {name: number_of(rng, name, spec, conversion)
                       for part in (sentence.says, sentence.remedy)
                       for _, name, spec, conversion in Formatter().parse(part) if name}
            said = Said(code, numbers, Level.WARN)
            expect_good(phrase(said).strip(' ,:'), code)
            if sentence.remedy:
                expect_good(message([(said,)]), code)
                assert message([(said._replace(level=Level.OK),)]) == phrase(said)
    assert message([(Said('biased', level=Level.WARN), Said('gross', level=Level.ERROR)),
                    (Said('no_window'),)]) == (
        'prediction errors biased, prediction errors much larger than predicted: do not trust '
        'tau_K; check the encoders first, then the model; no window has ended')


def test_every_code_has_a_page_that_explains_it():
    anchors = {}
    for page in (Path(__file__).parents[2] / 'docs').glob('*.md'):
        heads = re.findall(r'^#+ (.*)', page.read_text(encoding='utf-8'), re.MULTILINE)
        anchors[page.name] = {re.sub(r'[^\w -]', '', head.lower()).replace(' ', '-')
                              for head in heads}
    for code, sentence in TABLE.items():
        page, _, anchor = sentence.page.partition('#')
        assert not anchor or anchor in anchors[page], (code, sentence.page)
        assert page in anchors, (code, sentence.page)


@dataclass(frozen=True, eq=False)
class Told(Health):
    """A Health that knows any features, whatever its windows."""

    features: tuple = ()
    point_windows: int = 0
    coefficients: tuple = ()

    def _baseline(self, column):
        """Return that nothing is known of an operating point: there is none."""
        return math.nan, math.nan


def health_of(rng):
    """Return a Health with random features, alerts and windows."""
    def maybe(value):
        return value if rng.integers(4) else math.nan

    features = tuple(FeatureHealth(
        abs(rng.normal()), abs(rng.normal()), 1.0, 0.1, maybe(0.3 * rng.normal()),
        maybe(abs(rng.normal()) * 10.0 ** rng.integers(-5, 1)), int(rng.integers(2) * 10 ** 9),
        reach=[None, (1e5, 9e4, 2e5), (1e5, 0.0, 2e5)][rng.integers(3)],
        steady=bool(rng.integers(2)), is_open=bool(rng.integers(2)),
        newest=0.1 * rng.integers(2)) for _ in FEATURES)
    tests = rng.choice([test.key for test in TESTS], rng.integers(3), replace=False)
    window = NotExcited(10 ** 9, str(rng.choice(list(PARTS['motion']))), numbers={
        'count': 3, 'std': 0.5}) if rng.integers(2) else Backlash(
        10 ** 9, 0.2, 0.01, 25.0, 1.0, lost_motion=0.21, lost_motion_std=0.01,
        separable=bool(rng.integers(2)))
    backlash = window if isinstance(window, Backlash) else None
    settings = HealthSettings(half_gap=0.1, gap_limit=0.15, limits=LIMITS_OF)
    return Told(
        settings, stamp_ns=10 ** 9, features=features,
        alerts={key: Alert(1, 1, 0.1, maybe(rng.normal()), 0.1, int(rng.integers(1, 4)))
                for key in tests},
        ended={'backlash': (('gap', 0.12), ('', 0.0))} if rng.integers(2) else {},
        window=Window(window), backlash=backlash, friction=backlash,
        compared=bool(rng.integers(2)), over_limit=bool(rng.integers(2)),
        point_windows=int(rng.integers(900)), coefficients=((0.1, 0.02), (-0.1, 0.3)),
        marks=((5 * 10 ** 8, 'serviced'),) if rng.integers(2) else (),
        earlier=bool(rng.integers(2)), slips=(Slip(10 ** 9, 0.1, 0.01),) * int(rng.integers(2)))


def test_any_health_is_told_at_its_level():
    rng = np.random.default_rng(1)
    for _ in range(400):
        health, states = health_of(rng), []
        for component, outcome in outcomes(health).items():
            expect_good(outcome.message, (outcome.codes, health))
            assert not re.search(r'(?<![\d.])0 s\b', outcome.message)
            levels = [said.level for group in outcome.says for said in group]
            assert outcome.level == max(levels) == levels[0] or 'unmeasured' in outcome.codes[0]
            states.append((outcome.level, component, outcome.message, outcome.codes))
        level, words = worst(health)
        assert level == max(state[0] for state in states)
        told = {text.split('; ')[0]: CHANGED & {*codes} for own, _, text, codes in states
                if own == level}  # of one level a change is stated, not what hides another
        assert told[words] or not any(told.values())


def test_any_finding_is_told_with_its_unit():
    rng = np.random.default_rng(2)
    for effect in EFFECTS.values():
        for _ in range(10):
            sizes = {p.name: size(rng) for p in effect.parameters if not p.choices}
            if effect.column is not None and effect.column.states:
                sizes[effect.column.states] = size(rng)
            sizes['N'] = float(rng.integers(1, 90)), 0.0
            finding = Finding(effect.id, effect.location, {k: v for k, (v, _) in sizes.items()},
                              {k: s for k, (_, s) in sizes.items()}, 9.0, joint='joint4')
            data = {'verdict': 'effect', 'findings': [finding.to_dict()], 'axis': 'rotary',
                    'remainders': [], 'model_values': {}}
            expect_good(headline(data), effect.id)
            if effect.column is not None:
                expect_good(finding_words(finding.to_dict()), effect.id)
    for effect in ROBOT_EFFECTS:
        for _ in range(10):
            sizes = {name: size(rng) for name in effect.units}
            expect_good(finding_words({
                'effect': effect.id, 'joint': None, 'link': 'flange',
                'values': {k: v for k, (v, _) in sizes.items()},
                'deviations': {k: s for k, (_, s) in sizes.items()}}), effect.id)


def test_any_change_of_a_robot_is_told():
    rng = np.random.default_rng(3)
    for _ in range(100):
        for kind in KINDS:
            expect_good(change_words(Change(kind, 'joint4', rng.normal(), abs(rng.normal()),
                                            10 ** 9, 10 ** 9, order=int(rng.integers(2)))), kind)
        centre = (math.nan,) * 3 if rng.integers(2) else tuple(rng.normal(size=3).tolist())
        expect_good(payload_words(HeldLoad('flange', rng.normal(), abs(rng.normal()), centre,
                                           centre, 0)), 'payload')
