# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The sentences of the checks of a recording, and of the notes on how it was read."""
from gearbox_monitor.report.sentence import Sentence
from gearbox_monitor.signals.recording_limits import LIMITS

_ENCODER, _CHECK_MODEL = 'check encoder, cable and driver', \
    'check model file, channels, signs and units'
_LENGTH = f'for drift record {LIMITS.drift_windows_few} windows of {{window:g}} s or more'
_RATES = (f'record {LIMITS.slowest:g} to {LIMITS.fastest:g} Hz, for diagnose {{lowest:g}} to '
          f'{LIMITS.diagnosis_fastest:g} Hz')
_TWICE, _STUCK = 'two publishers on one topic', (
    'the position of the {side} stays exactly the same for {seconds:.3g} s from t = {begin:.4g} s '
    'while the {other} travels {travel:.3g} rad: ')
_RATIO = 'arm moves {ratio:.4g} x the motor, correlation {correlation:.3f}'
_DELAY = '{size} samples of {ms:.3g} ms; effort_delay is {stated}'
_TAKES = f', and takes {LIMITS.delay_earliest} to {LIMITS.delay_latest}'
_LOGGED = 'stamp the torque when it acts: it is logged {count} samples too '
_UNKNOWN = 'not determined: {reason} (correlation {{correlation:.2f}})'
_ACCELERATE = 'accelerate more, quick starts and stops'
_LIKE = 'reads like {} (log of the likelihood ratio {{ratio:.0f}} over {{second}})'

CHECKS = {
    # stamps
    'zero_stamps': Sentence('{count} zero; '), 'repeated_stamps': Sentence('{count} repeated; '),
    'backward_stamps': Sentence('{count} backward; '),
    'clock_restarts': Sentence('{count} restarts of the clock; '),
    **{code: Sentence('{counts}{refused} of {samples} samples are refused', remedy)
       for code, remedy in (
           ('order', 'let one publisher stamp each message with the time of its measurement'),
           ('order_of_runs', 'record each run of a simulation by itself; diagnose uses the '
            'longest one'))},
    'in_order': Sentence('{count}, all increasing{refused}'),
    'after_gaps': Sentence('; {count} are refused after gaps'),
    'rate_of_samples': Sentence('{rate:.5g} Hz', _RATES),
    'held': Sentence('each value is held for {rows} rows: measured at {rate:.4g} Hz, not at '
                     '{stamped:.5g} Hz', _RATES),
    'bursts_of': Sentence(
        '{rate:.4g} samples/s on average, stamped in bursts of {count} on receipt',
        'use stamps: even: gearbox_monitor import BAG --stamps even NEW lays an even grid through '
        'them'),
    'no_jitter': Sentence('below 1 us'),
    'jitter': Sentence('{ms:.2g} ms rms, {percent:.2g} % of the period', 'stamp where the '
                       'encoders are read, not where the message is made or received'),
    'no_gaps': Sentence('none; longest step {ms:.3g} ms'),
    **{code: Sentence('{count} with {lost} samples ({percent:.2g} %), the longest {longest:.3g} s '
                      'at {at:.4g} s{restarts}', remedy) for code, remedy in (
        ('few_gaps', ''), ('gaps', 'look for a busy network or recorder: raise the depth of its '
                           'queue, record locally'))},
    'restart_filter': Sentence('; {count} restart the filter'),
    'length': Sentence('{seconds:.4g} s', 'record 10 s or more'),
    'length_of_drift': Sentence('{seconds:.4g} s', _LENGTH),
    'length_of_all': Sentence('{seconds:.4g} s', f'{_LENGTH}; for all else 10 s or more'),
    'apart': Sentence(
        f'motor and arm are never in one message: {_TWICE}, the motor at {{motor:.4g}} Hz, the '
        'arm at {arm:.4g} Hz',
        'set arm_topic to this topic in the parameter file (docs/ros.md); gearbox_monitor import '
        'BAG --arm-topic joint_states NEW pairs this recording'),
    'foreign': Sentence(
        f'{_TWICE}: the positions jump to {{posture}} rad and back {{count}} times, first at '
        '{first:.4g} s', 'stop the second one, such as a joint_state_publisher next to the '
        'driver, then record'),
    # torque
    'setpoint_read': Sentence('none: the model has a controller, whose setpoint is read',
                              'for estimation record the torque and give a model without '
                              'controller'),
    'setpoint_alone': Sentence('none, but a setpoint is recorded', 'for diagnose give a model '
                               'file with the key controller, for estimation record the torque'),
    **{code: Sentence(says, 'publish the commanded torque as effort of the motor joint')
       for code, says in (('no_torque', 'none'),
                          ('torque_missing', '{percent:.3g} % missing or NaN'))},
    'torque': Sentence('rms {rms:.3g} N m, {low:.3g} to {high:.3g} N m{missing}',
                       'publish effort with every position'),
    'and_missing': Sentence('; {percent:.2g} % missing or NaN'),
    'same_torque': Sentence('{low:.4g} N m throughout',
                            'check that effort is the commanded torque; then move'),
    'at_limits': Sentence(
        'the commanded torque is at its limits {low:.4g} and {high:.4g} N m for {percent:.0f} % '
        'of the time', 'log the torque behind the limiter; if it is logged before, expect the '
        'effect saturation'),
    'torque_sticks': Sentence(
        '{count} times the same value while the {side} moves, {percent:.2g} % of the time; '
        'longest from {begin:.4g} s to {end:.4g} s: {value:.4g} N m{clamped}',
        'check that the drive is on and writes its effort there; leave these times out'),
    'clamped': Sentence(', clamped'),
    'is_setpoint': Sentence(
        'the torque equals the position of the {side} {seconds:.2g} s later (slope {slope:.3f}): '
        'a setpoint', 'log the commanded torque as effort, not the reference position'),
    'delay_short': Sentence('too short', 'record 10 s or more'),
    'delay': Sentence(_DELAY, 'set effort_delay: {rounded} in the parameter file; for diagnose, '
                      'log the torque when it acts'),
    'delay_late': Sentence(_DELAY + _TAKES, _LOGGED + 'late'),
    'delay_early': Sentence(_DELAY + _TAKES, _LOGGED + 'early'),
    **{f'delay_{code}': Sentence(_UNKNOWN.format(reason=reason), _ACCELERATE)
       for code, reason in (('hidden', 'the torque hardly shows in the acceleration'),
                            ('beyond', 'later than any delay that is tried'),
                            ('vague', '{size} samples'))},
    'no_effort_to_compare': Sentence('no torque to compare'),
    'effort_undecided': Sentence('{first} or {second}: undecided (log of the likelihood ratio '
                                 f'{{ratio:.1f}}, {LIMITS.effort_ratio:g} wanted)'),
    'effort_torque': Sentence(_LIKE.format('torque'), 'set effort_is: torque'),
    'effort_gravity_compensated': Sentence(
        _LIKE.format('gravity_compensated'),
        'set effort_is: gravity_compensated, with a robot_description'),
    'effort_current': Sentence(
        _LIKE.format('current') + ': {factor:.2g} times the torque',
        'set torque_constant: {constant:.2g} in the model file, and effort_is: current'),
    # encoders
    'all_readings': Sentence('all there'),
    'readings': Sentence('{percent:.2g} % missing or NaN',
                         'check cable, driver and joint name of this encoder'),
    'no_arm': Sentence('no arm encoder', 'expect torque, trust and backlash; no twist'),
    'never_measured': Sentence('never measured', 'without it there is no estimate; diagnose takes '
                               'one encoder'),
    'nothing_measured': Sentence('never measured', 'without a position there is neither estimate '
                                 'nor diagnosis'),
    'noise': Sentence('{noise:.3g} rad; r_std_{side} is {stated:.3g}',
                      'find R and Q with gearbox_monitor fit noise'),
    'noise_at_rest': Sentence(
        '{noise:.3g} rad at rest ({throughout:.3g} rad throughout); r_std_{side} is {stated:.3g}',
        'find R and Q with gearbox_monitor fit noise'),
    'resolution': Sentence('steps of {step:.3g} rad{swing}', 'read the encoder finer '
                           '(interpolation, both edges), or use one with more lines'),
    'of_swing': Sentence(', {share:.2g} of the swing of the twist'),
    'frozen': Sentence('the position of the {side} never changes: {value:.6g} rad throughout',
                       _ENCODER),
    'sticks_clipped': Sentence(
        _STUCK + 'the reading is clipped, or the joint is at an end stop',
        f'{_ENCODER}; leave end stops out of the motion'),
    'sticks_frozen': Sentence(_STUCK + 'the encoder is frozen', _ENCODER),
    'wild': Sentence('{count} numbers infinite or beyond 1e9, or far beyond all others, the first '
                     '{first:.3g} at {at:.4g} s: they count as not measured',
                     'look for memory that the driver does not write'),
    'reading_wraps': Sentence(
        '{count} jumps of one turn ({size:.4g} rad), the first at {first:.4g} s',
        'count the position over turns (unwrap it) before it is published; the diagnosis counts '
        'them on'),
    'reading_outliers': Sentence('{count}, the first one {size:.4g} rad off at {first:.4g} s',
                                 'check cable, connector and driver of this encoder'),
    'reading_slips': Sentence(
        'the position jumps by {size:.4g} rad at {first:.4g} s and stays there, {count} such '
        'jumps', 'look for an encoder that slips or counts wrong, a hub that has come loose, or a '
        'zero that is set while recording'),
    # motion
    'no_rest': Sentence('none of half a second: fit noise finds the noise in motion'),
    'rest': Sentence('{seconds:.3g} s: fit noise measures the noise there'),
    'travel': Sentence('{travel:.4g} rad'),
    'rests': Sentence(
        'the {side} travels {travel:.3g} rad, {ratio:.1f} times its noise of {noise:.2g} rad: '
        f'expected at least {LIMITS.travel:g} times',
        'move the joint; check unit and joint name of this encoder'),
    'speed': Sentence('rms {rms:.3g}, largest {largest:.3g} rad/s'),
    **{code: Sentence(f'the {{side}} speed {words}', 'move to and fro, else friction that depends '
                      'on the direction, torque offset and load cannot be distinguished')
       for code, words in (('never_reverses', 'never reverses'),
                           ('reverses_once', 'reverses only once'),
                           ('reverses', 'reverses {count} times, {pace:.3g} per minute'))},
    'twist_hidden': Sentence('no twist seen above the noise', 'load the joint to and fro; '
                             'backlash below the noise of the encoders cannot be watched'),
    'traversals': Sentence(
        '{count}, {pace:.3g} per minute; the twist swings {swing:.3g} rad{windows}',
        'load both flanks in every {window:g} s: reverse under load'),
    'in_windows': Sentence('; in {percent:.0f} % of the windows there and back'),
    'excitation': Sentence('condition {condition:.3g} of acceleration, speed, friction, offset',
                           'move at several speeds, in both directions, with quick starts and '
                           'stops'),
    'drive_slips': Sentence('motor and arm slip by {size:.3g} rad at {at:.4g} s, and stay there',
                            'check clutch, hub and couplings; diagnose names it'),
    # signs
    'ratio': Sentence(_RATIO),
    'two_drives': Sentence(f'{_RATIO}: not one drive', 'check the joint names: motor and arm must '
                           'be the two ends of one gearbox'),
    'ratio_negative': Sentence(_RATIO, 'turn the sign of one encoder, or make gear_ratio in the '
                               'model file negative'),
    'ratio_off': Sentence(_RATIO, 'multiply gear_ratio in the model file by {factor:.4g} '
                          '(--model), or check the units'),
    'gain': Sentence('1 N m gives {size}'), 'work': Sentence('net work {size:+} of its amounts'),
    'wrong_way': Sentence(': the wrong way',
                          'turn the sign of the effort, or of the {side} position'),
    'sign_unknown': Sentence(': not determined', 'accelerate more, or move against friction'),
    # the model file, and the diagnosis
    'no_model': Sentence('none', 'use --model to check signs, units and motion against it'),
    'rigid_model': Sentence('transmission.kind is rigid', 'for estimation use the model of a '
                            'drive with two encoders'),
    'accepted': Sentence('accepted without remarks'),
    'remarked': Sentence('accepted; {remarks}', 'see above'),
    'doubted': Sentence('accepted; {remarks}', _CHECK_MODEL),
    'refused': Sentence('refuses it: {remarks}', 'see above'),
    'refused_encoder': Sentence('refuses it: {remarks}',
                                'with one encoder give a model with {expected}'),
    'not_finite': Sentence('a value is not finite, expected numbers throughout'),
    'same_input': Sentence('the {input} is {value:.4g} throughout: expected one that changes'),
    'held_too_long': Sentence(
        '{rate:.4g} samples/s, but positions are held for {rows} rows: measured at {measured:.4g} '
        'Hz, expected {lowest:g} or more, or one row for each measurement'),
    'unusable_rate': Sentence('{rate:.4g} samples/s, expected {slowest:g} to {fastest:g}{hint}'),
    'needs_acceleration': Sentence(
        ' with driven_by: position, which needs the acceleration of the motor; log faster, or '
        f'state driven_by: torque, which takes {LIMITS.diagnosis_slowest:g} or more'),
    'time_unit': Sentence('; is t in {unit}? It must be in s'),
    'too_short': Sentence(f'{{seconds:.3g}} s, expected at least {LIMITS.min_duration:g} s: the '
                          'verdict is tested on windows of 1 s that are not fitted'),
    'short': Sentence('{seconds:.3g} s: few windows are left for the test, intervals will be '
                      'wide; 10 s or more are better'),
    'reads_otherwise': Sentence(
        '{wrong}: with that changed, {changed} stay unexplained instead of {as_is}'),
    'unexplained_parts': Sentence(
        '{torque:.3g} % of the torque and {transmitted:.3g} % of the transmitted torque'),
    'swapped': Sentence('motor and arm positions are swapped'),
    'turned': Sentence('the sign of the {signal} is wrong'),
    'swapped_turned': Sentence(
        'motor and arm positions are swapped and the sign of the {signal} is wrong'),
    'motor_side': Sentence(
        'motor position and torque are on the motor side of a gear of {factor:.3g}:1 (model file: '
        'gear_ratio {ratio:g}; expected both on the arm side)'),
    'other_unit': Sentence('{signal} {factor:.3g} times as large as the model allows (expected '
                           '{unit}){guesses}'),
    'probably': Sentence(', probably {unit}'),
    'perhaps_geared': Sentence(', perhaps for a gear_ratio that is not in the model file'),
    'perhaps_current': Sentence(', or a current (see torque_constant)'),
    'strange_torque': Sentence('the torque that motion and model leave unexplained is '
                               f'{{factor:.3g}} times the commanded one; {_CHECK_MODEL}'),
    'setpoint_turned': Sentence('the sign of the setpoint is wrong: the position runs against it'),
    'setpoint_not_followed': Sentence(
        'the position does not follow the setpoint (correlation {correlation:.2g}); check that it '
        'is the setpoint of this drive'),
    'setpoint_unit': Sentence('the setpoint is {factor:.3g} times the motion that follows it, '
                              'expected both in rad on the arm side'),
    'moves_little': Sentence('the motor moves in {moving} of {seconds} s, expected at least '
                             f'{LIMITS.min_moving}'),
    'one_direction': Sentence(
        'the motor speed never reverses and the teeth stay on one flank: friction, load and '
        'offsets are one number then; expected motion in both directions'),
    'gap_not_crossed': Sentence('the drive never crosses the backlash: its width and an offset '
                                'between the encoders cannot be seen'),
    'no_acceleration': Sentence('the motor hardly accelerates: inertia cannot be seen'),
    # the log of a robot, the errors of filters
    'log_length': Sentence('{seconds:.4g} s of {kind} at {rate:.4g} samples/s in {parts}'),
    'beyond_range': Sentence(
        '{place}: from {low:.4g} to {high:.4g}, {percent:.3g} % beyond the range of the model '
        '({lowest:.4g} to {highest:.4g}){degrees}', 'check zero, direction and unit of the joint '
        '(--convention {place}=zero:RAD, reversed or deg), or the range in the model'),
    'of_degrees': Sentence(', as of degrees: --convention {place}=deg'),
    'conventions_agree': Sentence('direction, zero, unit and order of all joints contradict no '
                                  'weight and inertia of the model'),
    **{f'nis_{size}': Sentence('{topic}: {nis:.3g} over {count} readings, expected 1 ({each})',
                               f'its R and Q state too {much} noise: tune them')
       for size, much in (('small', 'much'), ('large', 'little'))},
    'worst_in_part': Sentence(' (worst in the part from {begin:.0f} s on)'),
    'in_part': Sentence(' (part from {begin:.0f} s on)')}

NOTES = {
    'counted_on': Sentence('motor and arm slip by {size:.3g} rad at {at:.4g} s: the motor is '
                           'counted on over it'),
    'arm_torque_unused': Sentence('the {input} measured on the arm is not used: arm_load in '
                                  '{model} is {load}, not measured'),
    'huge_values': Sentence('{count} values of {field} were infinite or beyond 1e9, or far beyond '
                            'all others: they count as not measured'),
    'missing_values': Sentence('{count} values of {field} were NaN and are interpolated'),
    'lost_samples': Sentence('{count} of {samples} samples lost by their stamps, interpolated'),
    'time_wanders': Sentence('the sample time wanders, stamps by {ms:.3g} ms rms: samples are '
                             'interpolated onto a uniform grid'),
    **{f'jitter_{code}': Sentence(
        f'stamps jitter by {{ms:.3g}} ms rms ({{percent:.0f}} % of the sample time): {how}')
        for code, how in (('followed', 'positions follow the stamps and are interpolated onto a '
                           'uniform grid'),
                          ('ignored', 'positions do not follow the stamps, samples are taken as '
                           'evenly spaced'))},
    'wild_readings': Sentence('{count} single wild readings of {field} are interpolated'),
    'unordered': Sentence('{count} of {samples} samples have no stamp, or an earlier one than '
                          'before: they are left out'),
    'repeated': Sentence('{count} of {samples} stamps repeat the previous one: the first of each '
                         'is used'),
    'longest_run': Sentence('the clock restarts {count} times: only the longest run is used, '
                            'samples {first} to {last} of {samples}'),
    'one_hole': Sentence('1 gap in the stamps, the longest {longest:.3g} s at t = {at:.6g} s'),
    'holes': Sentence('{count} gaps in the stamps, the longest {longest:.3g} s at t = {at:.6g} s'),
    'stretch': Sentence('{holes}; only the stretch from {first:.6g} s to {last:.6g} s is used'),
    # of a robot's log
    'read_as': Sentence('{place}: read as {rules}'),
    'massless': Sentence('{place}: moves no mass in {file}: it is taken for fixed and not judged'),
    'locked_joint': Sentence('{place}: locked at {at:g}; the log has it from {low:.3g} to '
                             '{high:.3g}'),
    'setpoints_unused': Sentence('setpoints are recorded, too: the torques drive the model, they '
                                 'do not'),
    'scaled_current': Sentence('torque is current times its constant: masses come in the scale of '
                               'the constants (m / K)'),
    'foreign_samples': Sentence(
        '{count} of {samples} samples are left out: one and the same posture, the first at '
        f'{{first:.4g}} s, between those of the robot: {_TWICE}, stop the second one'),
    'joint_turns': Sentence('{place}: the position jumps by a turn ({size:.4g}) {times}, first '
                            'at {at:.4g} s: turns are counted on'),
    'joint_outliers': Sentence('{place}: {count} outliers, the first one {size:.4g} off at '
                               '{at:.4g} s: not used'),
    'effort_outliers': Sentence('{place}: {count} outliers of the effort, the first one '
                                '{first:.4g} at {at:.4g} s: not used'),
    'joint_slips': Sentence('{place}: the position jumps by {size:.4g} at {at:.4g} s and stays '
                            'there, {times} in all: an encoder that slips, or a new zero'),
    'own_messages': Sentence('{names}: messages of their own, interpolated to the stamps of '
                             '{clock}'),
    'not_whole': Sentence('{count} of {samples} samples without all joints are left out'),
    'stamped_before': Sentence('{count} of {samples} samples with a stamp at or before another '
                               'one are left out'),
    'after_stamp_gaps': Sentence('{gaps} gaps in the stamps: {used} of {samples} samples are '
                                 'used'),
    'after_slips': Sentence('{slips} slips of positions: {used} of {samples} samples are used'),
    'in_parts': Sentence('{gaps} gaps in the stamps and {slips} slips of positions: {used} of '
                         '{samples} samples are used')}
