# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The table of key/values on /diagnostics and drift_alerts.

Nodes publish by it, in its order; docs/messages.md is made of it. All keys are snake_case.
"""
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from gearbox_monitor.estimation.consider import ERROR_NAMES
from gearbox_monitor.health.backlash.change_tests import ChangeTest, size_name, TESTS
from gearbox_monitor.health.judgement import OF_WINDOWS
from gearbox_monitor.health.monitor import ROW_CHECKS
from gearbox_monitor.parameters import CURVES, ESTIMATOR, RANDOM_WALK
from gearbox_monitor.report.sentences import CHANGES


@dataclass(frozen=True)
class DiagnosticKey:
    """A key of a component, with unit ('-': a number without, '': a text) and meaning."""

    component: str
    key: str
    unit: str
    description: str


def _of(component: str, *rows: tuple[str, str, str]) -> tuple[DiagnosticKey, ...]:
    """Return the keys of `component` with `rows` (key, unit, description)."""
    return tuple(DiagnosticKey(component, *row) for row in rows)


def _of_test(test: ChangeTest) -> tuple[DiagnosticKey, ...]:
    """Return the keys that a `test` on backlash or friction adds to its component."""
    size = size_name(test)
    return _of(
        test.component,
        (f'{test.key}_score', '-', f'odds of "{CHANGES[test.key][0]}", logarithm'),
        (f'{test.key}_score_threshold', '-', 'from `false_alarm_interval`'),
        (f'{size}_warn', '-', 'limit for "plan a service"'), (f'{size}_error', '-', 'its limit'),
        *(() if size == 'growth' else ((size, '-', 'size of the change, while there is one'),)),
        (f'{size}_std', '-', 'its standard deviation'),
        (f'{size}_since', '', 'when it began'))


def _features(component: str) -> Iterator[tuple[str, str, str]]:
    """Yield the rows of the features of `component` in the newest window."""
    for feature in OF_WINDOWS[component]:
        yield feature.name, feature.unit, f'{feature.name} of the newest window'
        yield f'{feature.name}_std', feature.unit, 'its deviation'


_KEPT = ('recording', '', 'outcome of the recording of its newest ERROR, with `keep_folder`')
_POINT = (
    ('operating_point', '', 'its mean angle, rms speed, rms torque (and temperature)'),
    ('baseline_windows', '-', 'windows in its baseline'),
    ('baseline_since', '', 'first window that the baseline rests on'),
    ('cause', '', 'what a comparison with the baseline recording named, while there is an alert'),
    ('trusted', '0/1', 'whether the newest window may enter the baseline'))
_CODES = ('codes', '', 'codes of the phrases of the message, in its order')
_ALL = (('lasts_s', 's', 'how long the level has lasted, unless it is OK; of wear: a silence'),
        _CODES)
DIAGNOSTIC_KEYS = (
    *_of('input', *_ALL,
         ('samples', '-', 'samples received since the start'),
         ('rate_hz', 'Hz', 'usable samples in the last second'),
         ('longest_gap_s', 's', 'longest step between stamps in the last second'),
         ('starts', '-', 'starts of the filter'),
         ('reset_motor_rad', 'rad', 'step of the estimate at the newest restart: motor'),
         ('reset_arm_rad', 'rad', 'the same for the arm'),
         ('reset_tau_k', 'N m', 'the same for tau_K'),
         ('last_refusal', '', 'why samples were refused last'),
         ('zero_stamps', '-', 'refused: without stamp'),
         ('repeated_stamps', '-', 'refused: the stamp repeats the previous one'),
         ('backward_stamps', '-', 'refused: the stamp is older than the previous one'),
         ('stamps_after_a_jump', '-', 'refused: first samples after a jump of the clock'),
         ('samples_without_effort', '-', 'refused: no torque at a start, or for `max_gap`'),
         ('samples_without_measurement', '-', 'refused: no position at a start, or for `max_gap`'),
         ('positions_that_jump', '-', 'refused: implausibly far from the prediction'),
         ('values_that_are_infinite_or_beyond_1e9', '-', 'treated as missing'),
         ('missing_motor_positions', '-', 'bridged by prediction'),
         ('missing_arm_positions', '-', 'bridged by prediction'),
         ('missing_efforts', '-', 'bridged with the previous effort'),
         ('samples_missed_by_stamps', '-', 'missing according to the steps of the stamps'),
         ('filter_restarts_after_divergence', '-', 'the filter failed and restarted'),
         ('messages_without_our_joints', '-', 'name neither joint; published while no samples '
          'arrive'),
         ('messages_unreadable', '-', 'longer than 256 KiB, or not joint states, if any'),
         ('messages_of_two_publishers', '-', 'refused: two publishers deliver a joint, or its '
          'publisher has just changed, if any'),
         ('messages_lost', '-', 'dropped by the network or by the full queue of the node'),
         ('clock_set_back', '-', 'number of times that /clock was set back, if any'),
         ('motor_without_arm', '-', 'two topics: motor messages without partner'),
         ('arm_without_motor', '-', 'two topics: arm messages without partner'),
         ('pair_tolerance_s', 's', 'two topics: `pair_tolerance`'),
         ('nearest_unpaired_s', 's', 'two topics: distance of the nearest stamps')),
    *_of('observability', *_ALL,
         ('information_share_tau_k', '-', 'share of the prior deviation of tau_K that remains '
          'after 0.1 s: 0 known, 1 nothing learnt'),
         ('information_share_threshold', '-', 'ERROR above'),
         ('stated_share_tau_k', '-', 'stated over prior deviation of tau_K'),
         ('stated_share_threshold', '-', 'ERROR above'),
         ('information_share_motor_speed', '-', 'the same for the motor speed; informative'),
         ('information_share_tau_arm', '-', 'the same for an unknown load on the arm; '
          'informative'),
         ('condition_eq6', '-', 's_min / s_max of the Jacobian of [f; h] with respect to (x, p), '
          'equation (6), raw units; informative'),
         ('condition_eq6_scaled', '-', 'the same, unit-free (typical states and derivatives); '
          'informative'),
         ('condition_eq6_p', '-', 'the same with respect to the torques alone; informative'),
         ('signal_eq6_p', '1/sqrt(s)', 'typical tau_K over process noise; informative')),
    *_of('prediction error', *_ALL,
         ('mean', '-', 'largest abs(mean) sqrt(N) of the whitened errors, 0.5 s'),
         ('mean_threshold', '-', 'WARN above'),
         ('ljung_box', '-', 'whiteness over 20 lags, 2 s'),
         ('ljung_box_threshold', '-', 'WARN above, together with `predictable_share`'),
         ('predictable_share', '-', 'sum of squared correlations'),
         ('predictable_share_threshold', '-', 'WARN above, together with `ljung_box`'),
         ('nis_over_dof', '-', 'normalised innovation squared over its degrees of freedom, 2 s'),
         ('nis_low', '-', 'WARN below'), ('nis_high', '-', 'WARN above'),
         ('nis_gross', '-', 'ERROR above'),
         ('variance_ratio_motor', '-', 'measured over predicted variance of the innovations'),
         ('variance_ratio_arm', '-', 'the same for the arm'),
         ('variance_ratio_low', '-', 'WARN below'), ('variance_ratio_high', '-', 'WARN above'),
         ('test_ratio', '-', 'largest innovation over 5 predicted deviations, 1 s'),
         ('test_ratio_threshold', '-', 'WARN above'),
         ('window_samples', '-', 'samples in the window'),
         *(key for check in ROW_CHECKS for key in check.keys),
         *((f'{check.name}_{key}', '-', words) for check in ROW_CHECKS for key, words in (
               ('evaluations', f'evaluations of {check.name}...'),
               ('results', 'evaluations that the motion permitted; only these count')))),
    *_of('covariance', *_ALL,
         ('tau_k_std', 'N m', 'median stated deviation of tau_K'),
         ('tau_k_noise_std', 'N m', 'the same by noise alone, with an exact model'),
         ('reference', 'N m', 'reference value of tau_k_noise_std'),
         ('lower_bound', 'N m', 'WARN below'), ('upper_bound', 'N m', 'WARN above'),
         *((f'adapted_{row.name}', row.unit, 'value in use (AEKF)') for row in ESTIMATOR
           if row.name in ('q_std_tau_k', 'r_std_motor', 'r_std_arm', 'tau_k_stiffness')),
         ('adapted_viscous_friction', 'N m s/rad', 'value in use (AEKF)'),
         ('adapted_coulomb_friction', 'N m', 'value in use (AEKF)'),
         ('adaptation_sensitivity_resets', '-', 'guard: sensitivities reset'),
         ('adaptation_limited_steps', '-', 'guard: steps shortened'),
         ('adaptation_steps_held_at_bound', '-', 'guard: values held at their bound'),
         ('adaptation_unsolvable_steps', '-', 'guard: steps skipped')),
    *_of('model', *_ALL,
         ('systematic_s', 's', 'seconds with biased or coloured innovations'),
         ('systematic_s_threshold', 's', 'WARN above'),
         ('window_s', 's', 'window: `model_gap_after`'),
         ('holds', '0/1', 'whether the model file holds: no lasting gap seen'),
         ('since', '', 'since when it holds or no longer holds, within the present run of the '
          'filter'),
         ('command', '', 'the service call that keeps the recording, while WARN'),
         ('learned_gap_rad', 'rad', 'backlash, with `tau_k_model` learned or mixed'),
         ('learned_gap_std_rad', 'rad', 'its standard deviation'),
         ('learned_stiffness', 'N m/rad', 'stiffness outside the backlash, learned'),
         ('learned_stiffness_std', 'N m/rad', 'its standard deviation'),
         ('learned_hysteresis_rad', 'rad', 'half width of the loop over the twist, learned; '
          '< 0: the torque is higher while the twist grows'),
         ('learned_hysteresis_std_rad', 'rad', 'its standard deviation'),
         *((f'undetected_{name}', 'N m', 'error of tau_K (rms) if this value is off by its '
            'tolerance, which the stated deviation contains') for name in ERROR_NAMES),
         *((f'probability_{name}', '-', 'of this law, with `tau_k_model` mixed')
           for name in (RANDOM_WALK, *CURVES))),
    *_of('backlash', *_ALL,
         ('gap_rad', 'rad', 'backlash of the newest window'),
         ('gap_std_rad', 'rad', 'its deviation'),
         ('gap_arcmin', 'arcmin', 'the backlash in arcmin'),
         *_features('backlash'),
         ('lost_motion_rad', 'rad', 'twist moving up minus twist moving down'),
         ('separable', '0/1', 'whether backlash and compliance are distinguishable'),
         ('flank', '-', 'share of the samples on the less visited flank'),
         ('coverage', '-', 'number of crossings of the backlash'),
         ('baseline_gap_rad', 'rad', 'healthy backlash at this operating point'),
         ('baseline_stiffness', 'N m/rad', 'healthy stiffness at this operating point'),
         ('growth', '-', 'relative growth of the backlash (lost motion): of the newest windows, '
          'or of the change'),
         ('slips', '-', 'slips since the baseline was saved, if any'),
         ('slip_rad', 'rad', 'step of motor against arm at the newest slip'),
         ('slip_rad_std', 'rad', 'its deviation'), ('slip_at', '', 'when it was'),
         ('forecast_s', 's', 'time until the limit is reached'),
         ('forecast_earliest_s', 's', 'its 95 % interval'),
         ('forecast_latest_s', 's', 'its 95 % interval'),
         _KEPT, *_POINT),
    *_of('friction', *_ALL,
         ('viscous_change', 'N m s/rad', 'viscous friction against the model file'),
         ('viscous_change_std', 'N m s/rad', 'its deviation'),
         ('coulomb_change', 'N m', 'Coulomb friction against the model file'),
         ('coulomb_change_std', 'N m', 'its deviation'),
         ('torque_gain_change', '-', 'torque delivered per torque commanded, relative'),
         ('friction_change', '-', 'friction at the speed of the window, against the baseline'),
         ('viscous_growth', '-', 'viscous friction against the baseline'),
         ('viscous_growth_std', '-', 'its deviation'),
         ('coulomb_growth', '-', 'Coulomb friction against the baseline'),
         ('coulomb_growth_std', '-', 'its deviation'),
         *_features('friction'), _KEPT, *_POINT),
    *_of('diagnosis', _CODES,
         ('alert', '', 'what raised the newest one'),
         ('since', '', 'when that began'),
         ('verdict', '', 'on the change: none, effect, incomplete or unknown'),
         ('effect', '', 'ids of the effects that changed'),
         ('model_holds', '0/1', 'whether the model file explains the newest recording'),
         ('baseline_recording', '', 'end of the baseline recording'),
         ('cpu_s', 's', 'CPU time of the child that named it')),
    *_of('recording',
         ('bag', '', 'folder of the bag'),
         ('messages', '-', 'written'), ('bytes', 'bytes', 'written'),
         ('topics_with_messages', '-', 'topics in the bag'),
         ('topics', '-', 'topics to record'),
         ('lost', '-', 'messages that did not arrive, of all topics'),
         ('not_written', '-', 'messages that arrived and could not be written'),
         ('since_last_flush_s', 's', 'time since the last complete sync'),
         ('free_disk_space_mb', 'MB', 'free on the disk of the bag'),
         ('low_space_threshold_mb', 'MB', 'WARN below: `low_space`'),
         ('lost_by_topic', '', 'lost messages of each topic')))
CHANGE_KEYS = tuple(
    row for test in TESTS for row in _of_test(test)
    if (row.component, row.key) not in {(own.component, own.key) for own in DIAGNOSTIC_KEYS})
DIAGNOSTIC_KEYS += CHANGE_KEYS
_PLACES = {(row.component, row.key): place for place, row in enumerate(DIAGNOSTIC_KEYS)}


def published(component: str, values: Mapping[str, object]) -> list[tuple[str, str]]:
    """Return (key, text) of the `values` of `component`, in the order of the table."""
    keys = sorted(values, key=lambda key: _PLACES.get((component, key), len(_PLACES)))
    return [(key, f'{value:.6g}' if isinstance(value, float) else str(value))
            for key in keys for value in [values[key]]]
