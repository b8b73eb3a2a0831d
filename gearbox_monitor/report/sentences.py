# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The one table of sentences: the meaning of each code of a result.

The core says codes and numbers (presentation.Said). Texts, pages, JSON and /diagnostics print them
by this table, `explain` prints the table itself.
"""
from collections.abc import Iterable

from gearbox_monitor.estimation.score import LAGS, MIN_SAMPLES
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change_tests import COMPONENTS, limit_names, TESTS, WEAR
from gearbox_monitor.health.checks.innovation import LJUNG_BOX_LIMIT, MEAN_LIMIT
from gearbox_monitor.health.checks.outcome import Group, Level
from gearbox_monitor.presentation import Said
from gearbox_monitor.report.diagnosis_sentences import DOUBTS, JOINT, ROBOT
from gearbox_monitor.report.recording_sentences import CHECKS, NOTES
from gearbox_monitor.report.sentence import Sentence


_SECOND, _CURVE = 'the last second', f'{LIMITS.curve_window:g} s'
_ERRORS, _AT_ONCE = f'{LIMITS.error_window:g} s', '1 s, at once'
_TUNE = 'check friction, inertia and torque scale of the model'
_NIS = 'NIS over its degrees of freedom'
_LEARNED = (f'{{}} from the model file by more than `{{}}`, its deviation < '
            f'{LIMITS.learned_std:g} of it, and more than {LIMITS.learned_deviations:g} '
            'deviations beyond; `tau_k_model` learned, or mixed with a probability of the learned '
            f'curve >= {LIMITS.learned_probability:g}')
_SHARE = (f'is more than {LIMITS.curve_sigma:g} stated standard deviations, and certain, > '
          f'{LIMITS.curve_share:g}')

LEVELS = {
    Level.OK: Sentence('the component was judged and nothing is wrong: its values can be used',
                       'nothing'),
    Level.WARN: Sentence('something is doubtful, or nothing was judged yet: estimates go on, with '
                         'less trust', 'read the message: it names the condition and its remedy'),
    Level.ERROR: Sentence('the values of the component must not be used, or a change of the '
                          'gearbox exceeds its limit',
                          'stop relying on it, and follow the remedy of the message')}

INPUT = {
    'rate': Sentence('{rate:.0f} samples/s'),
    'silent': Sentence(
        'no samples received',
        'check that the source runs and that topic, joint names and domain agree',
        f'no new stamp between two diagnostics (WARN in the first {LIMITS.start_time:g} s before '
        'the first sample ever); all other components then say WARN: no data', _AT_ONCE),
    'unusable': Sentence('{count} samples came, none was usable',
                         'check that the source runs and that its stamps advance'),
    'other_joints': Sentence('{count} messages named neither {motor!r} nor {arm!r} but {names}',
                             'set motor_joint and arm_joint'),
    'arm_alone': Sentence(
        'messages of the arm came on {arm_topic}, none of {motor!r} on {motor_topic}',
        'check motor_joint and its topic'),
    'qos': Sentence('the QoS of {node} on {topic} does not fit ours ({reason})',
                    'change qos_overrides.{topic}'),
    'no_sample': Sentence(
        'no usable sample in the last second',
        'check that the source publishes and that its stamps advance',
        'no sample gave an estimate', _SECOND),
    'no_effort': Sentence(
        '{counts}', 'publish effort of the motor joint with every position', 'any of these',
        _SECOND, 'samples without effort, missing efforts'),
    'bad_stamps': Sentence(
        '{counts}', 'stamp each message with the time of its measurement, from one publisher',
        'any of these', _SECOND,
        'zero stamps, repeated stamps, backward stamps, stamps after a jump'),
    'no_position': Sentence(
        '{counts}', 'check the encoders and the joint names', 'any of these', _SECOND,
        'samples without measurement, missing motor positions, missing arm positions'),
    'position_jumps': Sentence(
        '{counts}',
        'check zero, cables and supply of the encoders; publish positions that do not wrap',
        'any of these', _SECOND, 'positions that jump'),
    'missed': Sentence(
        '{counts}', 'check rate and load of source and network', 'any of these', _SECOND,
        'samples missed (by stamps)'),
    'bad_values': Sentence(
        '{counts}', 'check the computation of the source', 'any of these', _SECOND,
        'values that are infinite or beyond 1e9, filter restarts after divergence'),
    'two_publishers': Sentence(
        '{rivals}', 'stop one of them or remap its topic',
        'the numbers of messages with the joint go back twice within 2 s: two publishers deliver '
        'it; nothing is taken from either until one of them has been silent for 2 s', '2 s, at '
        'once', 'two publishers of one joint'),
    'lost': Sentence(
        '{count} messages lost', 'lower the rate or the load of this machine',
        'sequence numbers are missing between two diagnostics: dropped by the network or by the '
        'full queue of the node', _AT_ONCE, 'messages lost')}

TRUST = {
    'no_data_yet': Sentence('no data yet'), 'no_data': Sentence('no data'),
    'not_evaluated': Sentence('not evaluated: filter restarted or data missing within the last '
                              f'{LIMITS.settle + 1.0:g} s'),
    'no_estimates': Sentence('no estimates'),
    'observable': Sentence('tau_K observable{hidden}'),
    'and_not': Sentence('; not: {names}'),
    'hidden': Sentence(
        'tau_K not observable',
        'do not trust it; check the encoders; with an unknown load at standstill, wait for motion',
        f'more than {LIMITS.untrusted:g} of the prior standard deviation of tau_K remains',
        f'{LIMITS.information_window:g} s'),
    'uncertain': Sentence(
        'uncertainty of tau_K above its initial value',
        'do not trust it; restore the encoder that is lost, or state the load on the arm '
        '(arm_load)',
        f'median standard deviation of tau_K > {LIMITS.unknown:g} of the prior one '
        '(`p0_std_torque`)', f'{LIMITS.information_window:g} s'),
    'as_predicted': Sentence('prediction errors as predicted'),
    'biased': Sentence(
        'prediction errors biased', _TUNE,
        f'largest abs(mean) sqrt(N) of the whitened channels > {MEAN_LIMIT:.2f}',
        f'{LIMITS.mean_window:g} s'),
    'coloured': Sentence(
        'prediction errors not white', _TUNE + ', and the time stamps',
        f'Ljung-Box over {LAGS} lags > {LJUNG_BOX_LIMIT:.1f} and sum of squared correlations > '
        f'{LIMITS.predictable:g} + {LAGS} / N', _ERRORS),
    'larger': Sentence(
        'prediction errors larger than predicted', _TUNE + ', and the encoders; or raise R',
        f'{_NIS} > {LIMITS.nis_high:g} and significantly above 1', _ERRORS),
    'smaller': Sentence(
        'prediction errors smaller than predicted', 'R or Q is too large: tune them',
        f'{_NIS} < {LIMITS.nis_low:g} and significantly below 1', _ERRORS),
    'gross': Sentence(
        'prediction errors much larger than predicted',
        'do not trust tau_K; check the encoders first, then the model',
        f'{_NIS} > {LIMITS.nis_gross:g}', _ERRORS),
    **{f'{joint}_variance': Sentence(
        f'{joint} encoder noise differs from r_std_{joint}',
        f'check the {joint} encoder, or tune r_std_{joint}',
        f'mean squared innovation of the {joint} over predicted variance outside '
        f'{LIMITS.variance_low:g} .. {LIMITS.variance_high:g}', _ERRORS)
        for joint in ('motor', 'arm')},
    'outliers': Sentence(
        'outliers', 'check encoder cables and supply, and for impacts',
        f'largest innovation / ({LIMITS.gate:g} predicted standard deviations) > 1',
        f'{LIMITS.gate_window:g} s'),
    'too_few': Sentence(
        'too few innovations', 'wait; check the rate if it stays',
        f'fewer than {MIN_SAMPLES} samples that gave an estimate', _ERRORS),
    'against_twist': Sentence(
        'torque against twist',
        'check the signs of encoders and torque and whether it is the torque that acts, then the '
        'friction of the model',
        f'smoothed: correlation of tau_K and twist < {LIMITS.correlation:g}, or mean of tau_K '
        f'times twist rate, without the return of a spring, over their rms < {LIMITS.power:g}; '
        f'judged where each moves by {LIMITS.moved:g} of its stated standard deviations',
        f'{LIMITS.passivity_window:g} s'),
    'twist_range': Sentence(
        'twist larger than backlash and stiffness allow',
        'check sign, scale and delay of both encoders and whether motor and arm are swapped; then '
        'stiffness and half_gap of the model',
        f'range of the smoothed twist > {LIMITS.twist_room:g} times the backlash of the model and '
        f'the twist by the range of tau_K, widened by {2 * LIMITS.twist_sure:g} stated standard '
        'deviations', f'{LIMITS.twist_window:g} s'),
    'no_curve': Sentence(
        'no elastic curve explains the torque',
        'check sign, limits and delay of the effort and the signs and order of the encoders',
        f'share of the smoothed tau_K that is more than {LIMITS.curve_sigma:g} stated standard '
        'deviations off the best elastic curve, gain, friction, scale and delay, in more than '
        f'single moments, > {LIMITS.curve_share:g}', _CURVE),
    'other_torque': Sentence(
        'torque disagrees with the twist',
        'check scale of the effort, time stamps and friction of the model; then its stiffness',
        'share of the smoothed tau_K whose error by gain and friction, as the twist shows it, '
        + _SHARE, _CURVE),
    'other_twist': Sentence(
        'encoders disagree', 'check gear_ratio, scale and delay of both encoders',
        'share of the smoothed twist whose error by scale and delay between the encoders '
        + _SHARE, _CURVE),
    'usual': Sentence('uncertainty of tau_K in its usual range'),
    'no_reference': Sentence('reference for the uncertainty of tau_K not complete yet'),
    'below': Sentence(
        'uncertainty of tau_K below its usual range',
        'the filter hardly uses its measurements; check Q and R, or their adaptation',
        'median standard deviation of tau_K by noise < '
        f'{LIMITS.covariance_low:g} of the reference', 'median over 2 s, against its reference'),
    'above': Sentence(
        'uncertainty of tau_K above its usual range',
        'measurements are missing or come slower; check encoders and rate',
        'median standard deviation of tau_K by noise > '
        f'{LIMITS.covariance_high:g} of the reference', 'median over 2 s, against its reference'),
    'at_bound': Sentence(
        'adaptation at its bound: {names}', 'the model or a start value is wrong: check it',
        'an adapted parameter is at its bound (AEKF only)', 'the evaluation',
        'adaptation at its bound')}

MODEL = {
    'holds': Sentence('no lasting error of the model found{hidden}'),
    'load_hides': Sentence(' (with arm_load: unknown most are invisible)'),
    'mismatch': Sentence(
        'model mismatch',
        'call ~/keep_recording, then run the gearbox_monitor diagnose that it answers with; where '
        'that finds no gap, tune the filter',
        f'seconds with prediction errors biased or not white > {LIMITS.systematic_share:g} '
        '`model_gap_after`; seconds with an ERROR of input or observability do not count',
        '`model_gap_after`'),
    'learned_stiffness': Sentence(
        'learned stiffness differs from the model file (x {factor:.2f})',
        'check the scale of the torque and of both encoders, then stiffness in the model file; a '
        'drop over weeks is wear',
        _LEARNED.format('`learned_stiffness` differs', 'stiffness_error'), 'the evaluation',
        'learned stiffness differs from the model file'),
    'learned_gap': Sentence(
        'learned backlash differs from the model file (x {factor:.2f})',
        'check the scale of both encoders, then half_gap in the model file; a growth over weeks '
        'is wear',
        _LEARNED.format('`learned_gap_rad` differs', 'gap_error'), 'the evaluation',
        'learned backlash differs from the model file')}

# What of a gearbox changes: test, phrase, and remedies where it is found, beyond its limit for a
# warning, beyond that for an error.
_WATCH, _ADJUSTED = 'watch it', 'save a baseline if it was adjusted'
CHANGES = {
    'gap': ('backlash has grown by', _WATCH, 'plan a service', 'service the gearbox'),
    'gap_loss': ('backlash has shrunk by', _ADJUSTED, 'check preload and adjustment',
                 'check preload and adjustment now'),
    'lost_motion': ('lost motion has grown by', _WATCH, 'plan a service', 'service the gearbox'),
    'lost_motion_loss': ('lost motion has shrunk by', _ADJUSTED, 'check preload and adjustment',
                         'check preload and adjustment now'),
    'stiffness_loss': ('stiffness has dropped by', _WATCH,
                       'check couplings and mounting, plan a service',
                       'check couplings, mounting and teeth now'),
    'stiffness_growth': ('stiffness has grown by', _WATCH, 'check preload and couplings',
                         'check preload and couplings now'),
    'hysteresis': ('hysteresis over load has grown by', _WATCH, 'check preload and lubrication',
                   'check preload and lubrication now'),
    'hysteresis_down': ('hysteresis over load has dropped by', _WATCH,
                        'check preload and lubrication', 'check preload and lubrication now'),
    'friction': ('friction has grown by', _WATCH, 'check lubrication, bearings, brake',
                 'check lubrication, bearings, brake now'),
    'friction_loss': ('friction has dropped by', _WATCH, 'check preload and lubricant',
                      'check preload and lubricant now'),
    'viscous_share': ('friction has shifted to viscous by', _WATCH, 'check the lubricant',
                      'check the lubricant now'),
    'viscous_share_loss': ('friction has shifted to Coulomb by', _WATCH,
                           'check lubrication, bearings, seals',
                           'check lubrication, bearings, seals now'),
    'torque_gain': ('torque gain has grown by', _WATCH, 'check the torque constant of the drive',
                    'check the torque constant of the drive now'),
    'torque_gain_loss': ('torque gain has dropped by', _WATCH, 'check motor and torque constant',
                         'check motor and torque constant now')}
_MOTIONS = dict(zip(COMPONENTS, ('move so that both flanks are loaded, there and back',
                                 'load a flank and move in both directions')))


def _changes() -> dict[str, Sentence]:
    """Return the sentences on each change: found, worse, an error, over."""
    table = {}
    for test in TESTS:
        phrase, *remedies = CHANGES[test.key]
        for stage, (limit, remedy) in enumerate(zip(limit_names(test), remedies), 1):
            sure = 'significant (false_alarm_interval) and ' if stage == 1 else ''
            also = ', or the backlash > gap_limit' \
                if limit == 'gap_error' and test.key == 'gap' else ''
            table[f'{test.key}_{stage}'] = Sentence(
                f'{phrase} {{size}} since {{since}}{{more}}', remedy,
                f'{sure}change >= {limit}{also}',
                f'since one of the newest {WEAR.horizon} windows' if stage == 1 else
                'since the change', f'{phrase} ... %')
        table[f'{test.key}_over'] = Sentence(
            f'over: {phrase.replace(" has ", " had ")} {{size}}')
    return table


WEAR_SENTENCES = {
    **{f'{component}_unmeasured': Sentence(
        f'{component} not measured yet: {{why}}; a baseline needs {{needed}} windows', remedy,
        'no window since the start showed it', 'drift_window', f'{component} not measured yet')
        for component, remedy in _MOTIONS.items()},
    **_changes(),
    'saved': Sentence('over: saved as the baseline'),
    'over_limit': Sentence('backlash {size} exceeds gap_limit {limit:g} rad',
                           'service the gearbox'),
    'slip': Sentence('slip of {size} at {at}', 'check clutch, hub and couplings'),
    'slip_unsure': Sentence(
        'motor and arm slipped by {size} after {since}, if the next window agrees',
        'record for longer'),
    'open_size': Sentence(', its size not separable from the new motion'),
    'parts': Sentence(' (viscous {viscous:+}, Coulomb {coulomb:+})'),
    'warm_up': Sentence(' (warm-up?)'), 'steady': Sentence(', steady now'),
    'reach': Sentence(', reaches {limit:+} in about {expected} ({earliest} to {latest})'),
    'reach_soon': Sentence(', reaches {limit:+} in {latest} at most'),
    'not_compared': Sentence('{noun} not compared{since}: {why}'),
    'untrusted': Sentence('the estimates are not trusted, see the other indicators'),
    'not_identifiable': Sentence('not identifiable in this motion'),
    'may_hide': Sentence('{noun} {size:+}, not separable from the new motion',
                         'drive the old one'),
    'follows_curve': Sentence(
        'friction not judged: the elastic curve of the model has the earlier backlash'),
    'unresolved': Sentence('{noun}{width}: its change is not known to better than {std}',
                           'repeat the motion of the baseline'),
    'newest': Sentence('{noun}{width}{comma} {size:+} in the newest window: the next one decides'),
    'alone': Sentence('{noun}{width}{model}: no earlier recording to compare with'),
    'as_model': Sentence(', as in the model file'),
    'off_model': Sentence(', {size} {side} the model file'),
    'learning': Sentence('{noun}{width}: learning the baseline{learnt}'),
    'unchanged': Sentence(
        '{noun}{width}{comma} {size:+} against the baseline: no wear detected so far{learnt}'),
    'width': Sentence(' {size}'),
    'learnt': Sentence(' ({count} of {needed} baseline windows)'),
    'mark': Sentence('{since}: {note}')}

MOTION = {
    'no_window': Sentence('no window has ended'),
    'few_samples': Sentence(
        f'too few samples: {{count}}, at least {LIMITS.window_points} are needed'),
    'implausible': Sentence('values that no drive has: the estimate is lost'),
    'no_twist': Sentence('the twist does not change: the drive stands still'),
    'no_load': Sentence(f'the torque stays below its noise ({LIMITS.loaded:g} standard '
                        'deviations): the drive stands still or is not loaded'),
    'one_flank_loaded': Sentence('only one flank is loaded: the torque has to change its sign'),
    'one_flank': Sentence('only one flank is reached'),
    'no_fit': Sentence('the motion does not determine any fit'),
    'few_crossings': Sentence('backlash crossed {count} times in the window, expected '
                              f'{LIMITS.traversals} or more: there and back'),
    'no_stiffness': Sentence('the torque on the flanks does not grow with the twist: the '
                             'stiffness is not seen'),
    'prescribed': Sentence('driven_by: position: behind so much friction the motor does not show '
                           'the backlash'),
    'motor_still': Sentence('the motor stands still'),
    'few_teeth': Sentence(
        f'the teeth crossed the backlash {{count}} times in the window, expected '
        f'{LIMITS.traversals} or more: the torque on the arm has to change its sign'),
    'unclear_reversals': Sentence(
        'the reversals do not show the backlash: standard deviation {std:.0%} of it, expected '
        f'below {LIMITS.hidden_std:.0%}'),
    'locked': Sentence(
        'the input stands still and no torque on the output is measured, nor one that holds the '
        'input: record it as effort of the arm, or of the motor'),
    'locked_flank': Sentence('the input stands still, and the torque on the output does not load '
                             'both flanks: turn the output to and fro')}

NODE = {
    'as_written': Sentence('{text}'),  # by others, or a note in words
    'state_not_kept': Sentence('the state of drift is not kept: {problem}'),
    'unpaired': Sentence('stamps of motor and arm are {apart:.6f} s apart, pair_tolerance is '
                         '{tolerance:g} s'),
    'change_due': Sentence('{change}: recording {seconds:g} s since it came, then its cause is '
                           'named'),
    'change_naming': Sentence('{change}: its cause is being named'),
    'change_problem': Sentence('{over}{change}: {problem}'),
    'change_named': Sentence('{over}{text}{since}'),
    'changes_not_named': Sentence('changes are not named: {why}'),
    'needs_baseline': Sentence(
        'no alert; a baseline recording needs {seconds:g} s of healthy windows'),
    'no_alert': Sentence('no alert, nothing to name')}
PARTS = INPUT, TRUST, MODEL, WEAR_SENTENCES, MOTION, JOINT, ROBOT, DOUBTS, CHECKS, NOTES, NODE
TABLE = {code: sentence for part in PARTS for code, sentence in part.items()}


class _Open:
    """Any number of a template that is shown without numbers."""

    def __getitem__(self, name: str) -> '_Open':
        return self

    def __format__(self, spec: str) -> str:
        return '...'


def title(code: str) -> str:
    """Return the name of a `code`."""
    sentence = TABLE[code]
    return sentence.name or sentence.says.format_map(_Open())


def phrase(said: Said) -> str:
    """Return the phrase of a code, without its remedy; numbers that are Said become phrases."""
    numbers = {name: ''.join(map(phrase, value)) if isinstance(value, tuple)
               and not hasattr(value, '_fields') else value
               for name, value in said.numbers.items()}
    return TABLE[said.code].says.format_map(numbers)


def remedy(said: Said) -> str:
    """Return what to do about what is `said`, '' for nothing."""
    return TABLE[said.code].remedy.format_map(said.numbers)


def message(groups: Iterable[Group]) -> str:
    """
    Return the message of an outcome: its groups with '; ' between them.

    A group has its phrases, then the remedy of the first one at the highest level, unless that is
    OK.
    """
    return '; '.join(map(_group, groups))


def _group(group: Group) -> str:
    text = ', '.join(map(phrase, group))
    gravest = max(group, key=lambda said: said.level, default=None)
    todo = remedy(gravest) if gravest is not None and gravest.level else ''
    return f'{text}: {todo}' if todo else text
