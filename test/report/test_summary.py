# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The first sentence of a verdict: what differs, by how much, and what that explains."""
from dataclasses import replace
import math

from gearbox_monitor.diagnosis.hypothesis import Finding, Remainder
from gearbox_monitor.diagnosis.joint.nominal import FittedValue
from gearbox_monitor.diagnosis.joint.verdict import model_values
from gearbox_monitor.health.backlash.features import width_of
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Quantity
from gearbox_monitor.report.sentences import largest_change, of_noise, told
from gearbox_monitor.report.words import (
    finding_words, headline, next_steps, sentence, value_rows)

MODEL = DriveModel(arm_inertia=0.0235, torque_offset=0.2)
HEAVY = Finding('arm_inertia', 'arm_side', {'m2': 0.033}, {'m2': 1e-4}, 900.0, share=0.93)
WEIGHT = Finding('gravity', 'arm_side', {'G': 1.5, 'phi': 0.3}, {'G': 0.01, 'phi': None}, 90.0)
OFFSET = Finding('torque_offset', 'actuator', {'u0': 0.1}, {'u0': 0.01}, 90.0)
RIPPLE = Finding('cogging', 'motor_side', {'A': 0.21, 'N': 6.0, 'phi': 1.0},
                 {'A': None, 'N': 0.0, 'phi': 0.1}, 90.0)
SLIPS = Finding('slip', 'transmission', {'Ds': -0.15, 't0': 12.2}, {'Ds': 2e-4, 't0': None}, 9e3)
REST = Remainder('motor_side', 'motor', 0.01, 'speed of the motor')


def data_of(kind, *findings, remainder=None, drive=MODEL, **more):
    return {'verdict': kind, 'findings': [f.to_dict() for f in findings], 'gap_before': 8.31,
            'gap_after': 0.9871, 'remainders': [remainder.to_dict()] if remainder else [],
            'effect': '+'.join(f.effect for f in findings), 'axis': 'rotary', 'joint': '',
            'model_values': model_values([f.effect for f in findings], drive),
            'logs': ['run1'], 'model': 'drive.yaml', 'options': '', **more}


ANSWERS = [
    (data_of('effect', HEAVY), 'arm side: inertia 0.03300 ± 0.00010 kg m², not 0.0235 kg m² '
     '(+40 %). This explains the whole difference.'),
    (data_of('effect', HEAVY, WEIGHT),
     'arm side: inertia 0.03300 ± 0.00010 kg m², not 0.0235 kg m² (+40 %); arm side: weight '
     '1.500 ± 0.010 N m, none in the model. Together they explain the whole difference.'),
    (data_of('effect', HEAVY, replace(OFFSET, confusable=('coulomb_asymmetry',))),
     'arm side: inertia 0.03300 ± 0.00010 kg m², not 0.0235 kg m² (+40 %); actuator: torque '
     'offset 0.100 ± 0.010 N m beyond the 0.200 N m of the model (or friction that differs by '
     'direction). Together they explain the whole difference.'),
    (data_of('incomplete', HEAVY, remainder=REST),
     'arm side: inertia 0.03300 ± 0.00010 kg m², not 0.0235 kg m² (+40 %). The rest has no known '
     'cause: motor side: 0.0100 rad rms over speed of the motor, by no law of the library.'),
    (data_of('effect', RIPPLE),
     'motor side: cogging torque about 0.21 N m, none in the model, 6 per turn. This explains '
     'the whole difference.'),
    (data_of('effect', Finding('disturbance', 'arm_side', {
        't0': 3.0, 'duration': 0.1, 'amplitude': 2.0}, {}, 9.0), bursts=[1, 2]),
     'arm side: 2 bursts of torque, the largest 2.00 N m at 3.00 s. This explains the whole '
     'difference.'),
    (data_of('effect', SLIPS, slips=[1, 2]),
     'transmission: 2 slips, the largest 0.1500 ± 0.0002 rad at 12.2 s. This explains the whole '
     'difference.'),
    (data_of('unknown', remainder=REST),
     'The log differs from the model file, and no known effect explains it: motor side: '
     '0.0100 rad rms over speed of the motor, by no law of the library.'),
    (data_of('none') | {'gap_before': 0.99},
     'No gap: nothing differs from the model file by more than noise (misfit 0.987, where 1 is '
     'noise alone).')]


def test_the_answer_states_sizes_and_what_they_explain():
    for data, expected in ANSWERS:
        assert headline(data) == expected


def test_an_effect_of_the_model_file_is_compared_with_its_value_there():
    model = DriveModel(effects=({'id': 'gravity', 'G': 1.0, 'phi': 0.0},))
    assert 'weight 1.500 ± 0.010 N m, not 1.00 N m (+50 %)' in headline(data_of(
        'effect', WEIGHT, drive=model))


def test_a_slide_has_masses_and_forces():
    assert 'inertia 0.03300 ± 0.00010 kg, not' in headline(data_of(
        'effect', HEAVY, axis='prismatic'))


QUANTITIES = [
    (Quantity(1.9893, 0.0372, 'kg'), '1.99 ± 0.04 kg'), (Quantity(3.02, 0.0996), '3.02 ± 0.10'),
    (Quantity(-15.03, 0.37, '%'), '-15.0 ± 0.4 %'), (Quantity(0.0, 0.0, '%'), '0.00 %'),
    (Quantity(12345.0, 1234.0), '12300 ± 1200'), (Quantity(-0.001, 0.2, '°'), '0.0 ± 0.2°'),
    (Quantity(0.0234531, 3.8e-7, 'kg m^2'), '0.0234531 ± 0.0000004 kg m²'),
    (Quantity(1.2345e-9, 3e-11), '1.23e-09 ± 3e-11'), (Quantity(0.0330, unit='-'), '0.0330'),
    (Quantity(1234.0), '1234'), (Quantity(2e-7), '2.00e-07'), (Quantity(1e7), '1.00e+07'),
    (Quantity(0.2146, None, 'N m'), 'about 0.21 N m'), (Quantity(2.0, math.inf), 'about 2.0'),
    (Quantity(math.nan, 1.0, 'N m'), 'unknown'), (Quantity(None, 1.0), 'unknown')]


def test_a_quantity_has_the_digits_of_its_deviation():
    for quantity, expected in QUANTITIES:
        assert str(quantity) == expected
    assert f'{Quantity(15.03, 0.37, "%"):+}' == '+15.0 ± 0.4 %'
    data = data_of('effect', replace(HEAVY, values={'m2': 0.0234531}, deviations={'m2': 3.8e-7}))
    row, = value_rows(data)
    assert str(row).startswith('m2 = 0.02345 ± 0.00002 kg m² (model: 0.0235')
    assert str(width_of(0.2, 0.0)) == '0.200 ± 0.002 rad'


def test_a_pure_number_has_no_unit():
    fitted = [FittedValue('torque_gain.g', '-', 0.05, 0.1, 1e-3, True)]
    assert str(largest_change(fitted)) == 'torque_gain.g is 0.1000 ± 0.0010, not 0.0500 (+100 %).'
    likelihood = {'loglik': 1.0, 'nis': 2.0}
    values = {'ukf_beta': 3.0, 'q_std_tau_k': 1e-4}
    assert 'ukf_beta changes most: 3.00, not 2.00 (+50 %).' in told(of_noise({
        'kept': False, 'before': likelihood, 'after': likelihood, 'parameters': values,
        'before_parameters': {'ukf_beta': 2.0, 'q_std_tau_k': 5.0},
        'relative_error': {'q_std_tau_k': 3.4}}))['summary']  # nobody knows it


def test_a_sentence_leaves_ids_as_they_are():
    assert sentence('use it') == 'Use it.'
    assert sentence('motor_coulomb at j1') == 'motor_coulomb at j1.'


def test_next_steps_have_the_names_and_options_of_the_user():
    ours = {'logs': ['run1', 'run2'], 'model': 'my drive.yaml', 'options': '--topic left',
            'closed': 'out/drive.closed.yaml'}
    steps = ' | '.join(next_steps(data_of('effect', HEAVY, **ours)))
    assert ("gearbox_monitor diagnose run1 run2 --model 'my drive.yaml' --topic left "
            '--validate BAG2') in steps
    assert next_steps(data_of('effect', SLIPS, **ours)) == ['check clutch, hub and couplings']
    asked = [{'effect': 'torque_offset', 'place': 'actuator', 'joint': 'motor', 'speed': 1.0,
              'seconds': 40.0, 'evidence': None, 'rival': rival}
             for rival in ('coulomb_asymmetry', 'load_torque')]
    steps = next_steps(data_of('effect', OFFSET, questions=asked, **ours))
    assert steps[0].startswith('torque_offset or coulomb_asymmetry: no motion separates them')
    assert steps[1] == ('to distinguish torque_offset from load_torque, move motor: slow moves '
                        'and dwells, at 0.2 rad/s to 2 rad/s for 40 s')
    assert steps[2] == 'simulate with out/drive.closed.yaml'
    robot = {**ours, 'model': 'arm.urdf', 'joint': '--joint elbow',
             'options': "--joint elbow --values 'my values.yaml'"}
    steps = ' | '.join(next_steps(data_of('effect', HEAVY, **robot)))
    assert 'export out/drive.closed.yaml --to urdf --into arm.urdf --joint elbow |' in steps
    assert ("diagnose run1 run2 --model arm.urdf --joint elbow --values 'my values.yaml' "
            '--validate BAG2') in steps


def test_a_robot_answers_in_the_same_way():
    rubs = Finding('motor_coulomb', 'motor_side', {'Cc': 0.7, 'Cc_change': 0.5},
                   {'Cc': 0.01, 'Cc_change': 0.01}, 90.0, joint='elbow').to_dict()
    assert finding_words(rubs) == (
        'elbow: Coulomb friction +0.500 ± 0.010 N m: 0.700 ± 0.010 N m, not 0.200 N m (+250 %)')
    assert finding_words(rubs, {'gaps': [{'joint': 'elbow', 'axis': 'prismatic'}]}).startswith(
        'elbow: Coulomb friction +0.500 ± 0.010 N: ')
    data = {'verdict': 'effect', 'findings': [rubs], 'remainders': []}
    assert headline(data).endswith('(+250 %). This explains the whole difference.')
    for after, says in ((0.1, 'the whole difference.'), (0.5, 'Tolerances allow the rest.')):
        gap = {'joint': 'elbow', 'before': 1.0, 'after': after, 'evidence': 90.0}
        assert headline({**data, 'gaps': [gap]}).endswith(says)
    servo = Finding('servo_gain', 'controller', {'kp_factor': 0.8}, {'kp_factor': 0.01}, 9.0,
                    joint='wrist').to_dict()
    assert finding_words(servo) == (
        'wrist: proportional gain 0.800 ± 0.010 times the value of the model')
    load = Finding('payload', 'arm_side', {'m': 2.0, 'cx': 0.0, 'cy': 0.0, 'cz': 0.09},
                   {'m': 0.3, 'cx': 0.01, 'cy': 0.01, 'cz': 0.01}, 9.0, link='hand').to_dict()
    rows = {row.name: str(row.size) for row in value_rows({'findings': [load], 'gaps': []})}
    assert rows['m'] == '2.0 ± 0.3 kg' and rows['cz'] == '0.090 ± 0.010 m'  # the page left it out
    quiet = {'verdict': 'none', 'findings': [], 'remainders': [], 'gaps': [
        {'joint': 'elbow', 'before': 0.12}, {'joint': 'wrist', 'before': 0.02}]}
    assert headline(quiet) == (
        'No gap: nothing differs from the model file by more than noise (elbow, the largest: '
        '0.120 N m rms).')
