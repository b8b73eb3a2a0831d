# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Every effect, condition and level explains itself, and the command finds it by its names."""
import re

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.plant.effects import Effect, EFFECTS, Parameter
from gearbox_monitor.report.explanation import (
    ALL_CONDITIONS, explained_effect, explanations, OF_CONDITION, OF_EFFECT, OF_LEVEL, rivals)


def explain(capsys, *words):
    code = main(['explain', *words])
    return code, capsys.readouterr()


def test_everything_has_all_headings():
    listed = list(explanations())
    assert len(listed) == len(EFFECTS) + len(ROBOT_EFFECTS) + len(ALL_CONDITIONS) + len(Level)
    for names, one in listed:
        assert tuple(one.parts) in (OF_EFFECT, OF_CONDITION, OF_LEVEL), names
        assert all(part and all(line.strip(' .') for line in part) for part in one.parts.values())


def test_an_effect_holds_its_text():
    for effect in EFFECTS.values():
        assert effect.noun and effect.shows.endswith('.')
        assert re.fullmatch(r'\d\.\d+\.0', effect.since)
        assert effect.shows[0].isupper() and not effect.noun[0].isspace()
        for other in rivals(effect.id):
            assert other in EFFECTS and effect.id in rivals(other)  # confusion goes both ways


def test_a_plugin_explains_itself_without_its_words():
    said = explained_effect(Effect('arm_spring', 'arm_side', 'tau_arm += S x2', (
        Parameter('S', 'N m/rad', low=0.0),), torques=lambda *arguments: (0.0, 0.0, 0.0)))
    assert 'tau_arm += S x2' in said.parts['What it is'] and said.parts['Since'] == ('a plug-in',)
    assert all(line.strip(' .') for part in said.parts.values() for line in part)


def test_the_command_explains_an_effect(capsys):
    code, shown = explain(capsys, 'Stribeck')
    assert code == 0 and max(map(len, shown.out.splitlines())) <= 80
    for words in ('What it is', 'lugre: slow reversals', 'URDF: none: no parameter',
                  '0.1.0'):
        assert words in shown.out


NAMED = [
    (['prediction', 'errors', 'biased'], 'WARN of prediction error'),
    (['ljung_box'], 'prediction errors not white'), (['covariance'], 'adaptation at its bound'),
    (['warn'], 'nothing was judged yet'), (['repeated', 'stamps'], 'WARN of input'),
    (['payload'], 'a link of a robot')]


def test_conditions_keys_components_and_levels_are_names(capsys):
    for words, says in NAMED:
        code, shown = explain(capsys, *words)
        assert code == 0 and says in ' '.join(shown.out.split())


def test_a_near_miss_is_suggested_and_the_list_has_all(capsys):
    code, shown = explain(capsys, 'stribek')
    assert code == 2 and shown.err.strip().endswith("did you mean 'stribeck'?")
    code, shown = explain(capsys, 'qqqqq')
    assert code == 2 and shown.err.count('\n') == 1 and len(shown.err) < 120
    code, shown = explain(capsys)
    words = set(shown.out.replace(',', ' ').split())
    assert code == 0 and {*EFFECTS, *(e.id for e in ROBOT_EFFECTS), 'WARN'} <= words
