# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the diagnosis of a robot says in words."""

from gearbox_monitor.report.words import headline, question_words, remainder_words

SLIDE = {'gaps': [{'joint': 'lift', 'axis': 'prismatic'}]}
REMAINS = [
    ('speed', {}, 'lift: 1.23 N rms over speed, by no law of the library'),
    ('bursts', {'times': [[3.0, 5.0], [9.0, 11.0]], 'recordings': ['a', 'b']},
     'lift: 1.23 N rms in bursts, at 3 s of a, 9 s of b'),
    (None, {'excess': 9.0},
     'lift: 1.23 N rms without a pattern, 3.00 times the remainder of healthy parts'),
    (None, {'size': 0.0}, 'lift: less than the noise without a pattern')]


def test_what_remains_has_its_size_and_how_it_shows():
    for over, more, words in REMAINS:
        remainder = {'joint': 'lift', 'size': 1.23, 'over': over, **more}
        assert remainder_words(remainder, SLIDE) == words


def test_values_that_the_file_omits_are_named_once_and_last():
    findings = [{'effect': effect, 'joint': joint, 'place': 'motor_side', 'confusable': [],
                 'values': {name: 2.0, f'{name}_change': 2.0},
                 'deviations': {name: 0.1, f'{name}_change': 0.1}}
                for joint in ('lift', 'wrist', 'hand')
                for effect, name in (('motor_viscous', 'Cv'), ('motor_coulomb', 'Cc'))]
    load = {'effect': 'torque_offset', 'joint': 'wrist', 'place': 'actuator', 'confusable': [],
            'values': {'u0': 0.5}, 'deviations': {'u0': 0.01}}
    gaps = [{'joint': joint, 'axis': 'rotary', 'before': 1.0, 'after': 0.0}
            for joint in ('lift', 'wrist', 'hand')]
    data = {'verdict': 'effect', 'findings': [*findings, load], 'remainders': [], 'gaps': gaps}
    assert headline(data) == (
        'wrist: torque offset 0.500 ± 0.010 N m; viscous friction, Coulomb friction of all '
        'joints, none in the model. Together they explain the whole difference.')
    changed = [{**f, 'values': {k: v if k.endswith('_change') else 3.0
                                for k, v in f['values'].items()}} for f in findings]
    assert 'all joints' not in headline({**data, 'findings': changed})


QUESTIONS = [
    ('motor_viscous', 'motor_coulomb', 'to distinguish motor_viscous from motor_coulomb, move '
     'lift: steps to several speeds, at 0.1 m/s to 1 m/s for 40 s (expected evidence 12)'),
    ('torque_offset', 'coulomb_asymmetry', 'torque_offset or coulomb_asymmetry: no motion '
     'separates them: they differ only near standstill'),
    ('payload', 'payload@hand', 'to distinguish payload from payload at hand, move lift alone, '
     'then the joint of hand alone, in two postures a quarter turn apart, at 0.1 m/s to 1 m/s for '
     '40 s (expected evidence 12)'),
    ('motor_coulomb', '', 'move lift alone, to and fro, at 0.1 m/s to 1 m/s for 40 s (expected '
     'evidence 12): it would show Coulomb friction of about 1.0 N at lift')]


def test_a_question_is_answered_by_a_motion():
    for effect, rival, words in QUESTIONS:
        question = {'joint': 'lift', 'place': 'lift', 'effect': effect, 'rival': rival,
                    'speed': 0.5, 'seconds': 40.0, 'evidence': 12.0, 'plausible': 1.0}
        assert question_words(question, SLIDE) == words
