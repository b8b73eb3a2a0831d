# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The sentences of diagnoses: verdicts on a joint and on a robot, and what weakens them."""
from gearbox_monitor.report.sentence import Sentence

# The verdict on one joint: what differs, its size, its share. _1: of one finding, _n: of several.
_NOISE = ' (misfit {misfit}, where 1 is noise alone).'
_REST = ' {part} of the difference; the rest has no known cause ({place}).'
JOINT = {
    'small_residual': Sentence('No effect is found: the residual is as small as on a real drive '
                               'without a known fault' + _NOISE),
    'within_tolerances': Sentence('No gap beyond the tolerances: with values of the model moved '
                                  'within them, noise alone is left' + _NOISE),
    'unshown': Sentence('Undecided: noise alone is left, but this motion would not show a change '
                        'of {changes}.'),
    'no_gap': Sentence('No gap: the model explains the recording down to the noise of the '
                       'encoders' + _NOISE),
    'unexplained': Sentence('The recording differs from the model by {misfit} times the noise, '
                            'and no known effect explains it{place}.'),
    'at': Sentence(': {place}'), 'no_place': Sentence('; its place is not clear either'),
    'acts': Sentence('{effect} acts on the drive.'),
    'effect': Sentence('{owner} {noun} is {size}{doubt}{turns}{nominal}.'),
    'doubt': Sentence(' (not well determined by this recording)'),
    'turns': Sentence(', {count:.0f} per turn'),
    'model_has_none': Sentence('; the model has none'),
    'beyond_model': Sentence(' beyond the {size} of the model'),
    'not_model': Sentence(', not {size} ({change})'),
    'bursts': Sentence('{bursts} of {torque} on the arm, the largest {size} at {time}.'),
    'slipped_1': Sentence('Motor and arm slip by {size} at {time}.'),
    'slipped_n': Sentence('Motor and arm slip {count} times, most by {size} at {time}.'),
    'all_1': Sentence('This explains the whole difference.'),
    'all_n': Sentence('Together they explain the whole difference.'),
    'part_1': Sentence('This explains' + _REST),
    'part_n': Sentence('Together they explain' + _REST),
    'rivals_1': Sentence('This motion does not distinguish it from {rivals}.'),
    'rivals_n': Sentence('This motion does not distinguish them from {rivals}.')}

_SETTLES = ': read so, weight and inertia of the model leave {left} of the effort there, as ' \
    'recorded {recorded} even with any load, friction or mounting; {options} settles it'
ROBOT = {
    'load_moved': Sentence('{place}: the centre of its load moved by {size}'),
    'load_moment': Sentence('a load at {place} whose mass times distance is {size}: this motion '
                            'does not distinguish mass and distance'),
    'load_unknown': Sentence('a load at {place} that this motion does not weigh'),
    'load': Sentence('{size} {side} at {place}, {centre}'),
    'centre': Sentence('centre {size} out'),
    'no_centre': Sentence('this motion does not show where'),
    'tilt': Sentence('the base is tilted by {size} against the model'),
    'inertia': Sentence('{place}: inertia of the link differs from the model'),
    'factor': Sentence('{place}: {noun} {size} times the value of the model{more}'),
    'value': Sentence('{place}: {noun} {size}{more}'),
    'change': Sentence('{place}: {noun} {size:+}{nominal}{more}'),
    'none_in_model': Sentence(', none in the model'),
    'whole': Sentence(': {size}, not {nominal} ({change})'),
    'one_way': Sentence(', {size} more one way than the other'),
    'begins': Sentence(' from {size} on'), 'channel': Sentence(' ({channel})'),
    'remains_bursts': Sentence('{place}: {size} rms in bursts, at {times}'),
    'remains_noise': Sentence('{place}: {size} rms without a pattern, {factor} times the '
                              'remainder of healthy parts'),
    'remains': Sentence('{place}: {size} rms over {over}, by no law of the library'),
    'exchanged': Sentence('{place} are exchanged in the log' + _SETTLES),
    'reversed': Sentence('{place} counts the other way in the log than in the model' + _SETTLES),
    'effort:-1': Sentence('the effort of {place} has the other sign than in the model'
                          + _SETTLES),
    'reversed,effort:-1': Sentence('the position of {place} has the other sign than in the '
                                   'model, the effort has not' + _SETTLES),
    'deg': Sentence('the position of {place} is in degrees' + _SETTLES),
    'mm': Sentence('the position of {place} is in mm' + _SETTLES),
    'zero': Sentence('the log has {place} at {zero:.3g} rad where the model is at 0' + _SETTLES),
    'effort_factor': Sentence('the effort of {place} is {factor:.3g} times the torque of the '
                              'model{sign}, as of another unit or a current' + _SETTLES),
    'other_sign': Sentence(' with the other sign'),
    'read_so': Sentence('{readings}. Read so: {answer}'),
    'as_said': Sentence('The robot is as {reference}: no joint differs by more than noise '
                        '({place}, the largest: {size} rms).'),
    'undecided': Sentence('Nothing differs from {reference} as far as this motion shows: {why}.'),
    'drift_above': Sentence('{place}: friction {size} above the references; usual between '
                            'days: {usual}'),
    'drift_below': Sentence('{place}: friction {size} below the references; usual between '
                            'days: {usual}'),
    'drift_alone': Sentence('{drifts}: another temperature, or wear. Nothing else differs from '
                            '{reference} as far as this motion shows.'),
    'differs': Sentence('The robot differs from {reference}, {cause}: {remainder}.'),
    'no_effect': Sentence('and no known effect explains it'),
    'unvisited': Sentence('or they do not know this motion'),
    'found_all_1': Sentence('{findings}. This explains the whole difference.'),
    'found_all_n': Sentence('{findings}. Together they explain the whole difference.'),
    'found_part': Sentence('{findings}. The rest has no known cause: {remainder}.'),
    'not_explained': Sentence('no reference explains the effort of {joints}'),
    'short_reference': Sentence('the reference is too short to judge the remainder'),
    'not_shown': Sentence('it would not show {change} at {place}{more}')}

# What weakens a verdict, what else its values may be called, why an effect was not tried.
DOUBTS = {
    'noise_lasts': Sentence('the noise of the {side} encoder lasts {ms:.2g} ms, as if it were '
                            'filtered: it is judged with that'),
    'friction_shape': Sentence(
        'friction of the {side} has another shape than in the model file, not another size: '
        'sharpness {sharpness:.3g} instead of {stated:.3g} s/rad'),
    'friction_law': Sentence('friction of the drive follows the law {law}, not {stated} of the '
                             'model file (friction_law)'),
    'file_misses': Sentence(
        'the model file itself misses by {misfit:.3g} standard deviations: values moved within '
        'their tolerances (nominal_shift) explain the recording'),
    'one_encoder': Sentence('one encoder: where an unknown effect acts is a guess, record both to '
                            'know'),
    'at_bounds': Sentence('{names}: at the bound of possible values'),
    'beyond_tolerance': Sentence(
        'nominal values lie far outside their tolerance (most: {name}, {shift:+.1f} tolerances): '
        'the tolerance looks too small, or several values have changed'),
    'all_trained': Sentence(
        'only the held-out windows show the model error: all windows were fitted, so gap_after is '
        'not from unseen ones; validate with a second recording'),
    'torque_lasts': Sentence('unexplained torque lasts {seconds:g} s; the model file states '
                             '{stated:g} s (process_torque_time)'),
    'delay_is_open': Sentence(
        'below 200 Hz, a delay of the torque is known only to half a sample, {ms:.3g} ms: how it '
        'acted between the stamps is open'),
    'differs_between': Sentence('the effect differs between the recordings: each shows it alone, '
                                'and no single value closes the gap in all'),
    'is_quantised': Sentence('readings are quantised: {effect}, which is excluded'),
    'doubt_refuted': Sentence('{doubt}; but the verdict explains the recording better than that'),
    'baseline_allows': Sentence('{effect}: the baseline recording allows it as well'),
    'remainder_as_before': Sentence(
        'the unexplained remainder is no larger than in the baseline recording'),
    'same_scale': Sentence(
        'the same motion results if all inertias, weights, stiffnesses and frictions are '
        'multiplied by {factor:.4g} instead of the torque by {gain:.4g}: only a known load or '
        'torque sensor tells'),
    'same_mass': Sentence('a payload of {mass:.3g} kg has this inertia'),
    'same_load': Sentence('a payload of {mass:.3g} kg at {distance:.3g} m from the axis has this '
                          'inertia and this weight'),
    'same_inertia': Sentence(
        'a payload of {first:.3g} kg at {at:g} m from the axis has this inertia, and so has one '
        'of {second:.3g} kg at {also:g} m'),
    'unjudged': Sentence('{place}: not judged, the model leaves more than half of its effort in '
                         'the references unexplained'),
    'one_reference': Sentence('one reference of {seconds:.0f} s: differences between days are not '
                              'known; taken as {percent:.2g} % of the effort'),
    'other_gain': Sentence('{place}: its servo acts with {factor:.2g} times the gain of the '
                           'model; sizes of torques are in its scale'),
    'held_setpoint': Sentence(
        '{log}: all servos show viscous friction of kp times {ms:+.2g} ms: their torque was '
        'sampled at the {end} of a held setpoint. This is no finding; log its mean over the '
        'period, or setpoints'),
    'little_remains': Sentence('{place}: {size} rms over {over} remains, little compared with '
                               'the torque that the findings explain there'),
    'far_away': Sentence(
        'no reference had such angles and speeds of all joints together: this motion is '
        '{factor:.2g} times as far from them as their own parts are'),
    'not_visited': Sentence('{place}: in {percent:.0f} % of the motion no reference had this '
                            '{variable}'),
    'excluded': Sentence('excluded'),
    'never_shown': Sentence('this drive, its encoders or its model do not show it'),
    'too_slow': Sentence('{rate:.3g} samples/s do not show it'),
    'no_column': Sentence('the balance of torques of one encoder does not show it'),
    'torque_measured': Sentence('the torque is measured behind the drive, not commanded'),
    'needs_torque': Sentence('needs a recorded torque'),
    'needs_setpoints': Sentence('needs setpoints'),
    'rate_or_motion': Sentence('{rate:.3g} samples/s or this motion do not show it'),
    'motion_hides': Sentence('this motion does not show it')}
