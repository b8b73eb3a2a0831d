# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Backlash of a real drive over its 20 recordings (davinci_backend), as it is and widened.

Widened: from recording 11 on the motor encoder turns so much further while the twist crosses the
dead zone, as it would had the dead zone grown by WIDENED.
"""
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import real, real_fit
from benchmarks.harness import BarTable
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import LAG
from gearbox_monitor.health import judgement
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.features import Backlash, fit, NotExcited
from gearbox_monitor.health.health_record import HealthSettings, Window
from gearbox_monitor.health.judgement import Health, judge
from gearbox_monitor.kernels.types import Array

# What "benchmarks real" finds for this drive on the training runs of split orig.
FITTED = {
    'torque_constant': 0.9302, 'motor_inertia': 8.743e-4, 'coulomb_friction': 0.02259,
    'viscous_friction': -7.869e-4, 'torque_offset': -0.008554, 'q_std_motor_speed': 0.5773,
    'q_std_arm_speed': 0.396, 'q_std_tau_k': 2.717e-4, 'q_std_tau_k_speed': 0.02447,
    'r_std_motor': 1.62e-4, 'r_std_arm': 6.014e-4, 'tau_k_stiffness': 2.447,
    'tau_k_model_std': 0.002928,
}
BURN_IN = 1.0           # s
WIDENED, FROM = 0.05, 10  # from this recording on, counted from 0
LOST_MOTION, SPREAD = (1.65, 1.82), 0.08  # deg: mean; largest minus smallest
# All recordings share one baseline: lost motion hardly depends on speed and load.
ONE_POINT = {'angle_bin': 0.0, 'speed_bin': 1.0, 'load_bin': 1.0}


def widened(y: Array, width: float, growth: float) -> Array:
    """
    Return readings as they would be with a wider dead zone.

    The twist is stretched about its middle within the dead zone and moved beyond it.

    Args:
        y: motor and arm position [N, 2], rad.
        width: of the dead zone, rad.
        growth: relative growth of the dead zone.

    Returns:
        Motor and arm position [N, 2], rad.
    """
    twist = y[:, 0] - y[:, 1]
    middle = 0.5 * (np.quantile(twist, 0.02) + np.quantile(twist, 0.98))
    position = np.clip((twist - middle) / (0.5 * width), -1.0, 1.0)
    return np.column_stack([y[:, 0] + 0.5 * growth * width * position, y[:, 1]])


def window(run: real_fit.DriveRecording, y: Array, arm_step: float,
           number: int) -> Backlash | NotExcited:
    """
    Estimate the backlash of a recording, with readings that may differ from the recorded ones.

    Args:
        run: the recording, N samples.
        y: motor and arm position [N, 2], rad.
        arm_step: resolution of the arm encoder, rad.
        number: of the recording, from 0; it sets the stamp of the window.

    Returns:
        The backlash, or why there is none.
    """
    model, parameters = real_fit.configure(FITTED, arm_step)
    u = np.column_stack([FITTED['torque_constant'] * run.current, np.full(len(y), np.nan)])
    found = Estimator(model, parameters.replace(smoother_lag=LAG, narrow_std=False)).run(
        Samples(run.stamps, u, y))
    late = found.smoothed_stamp_ns >= found.smoothed_stamp_ns[0] + round(BURN_IN * 1e9)
    return fit(found.smoothed[late], model, (number + 1) * 20_000_000_000)


def follow(runs: Iterable[str], windows: Sequence[Backlash | NotExcited],
           arm_step: float) -> list[str]:
    """
    Track the backlash from recording to recording.

    Args:
        runs: names of the recordings.
        windows: backlash of each recording.
        arm_step: resolution of the arm encoder, rad.

    Returns:
        Names of the recordings that raised an alert, in their order.
    """
    model, parameters = real_fit.configure(FITTED, arm_step)
    health = Health(HealthSettings.of(parameters.replace(**ONE_POINT), model))
    alerted: list[str] = []
    was_alerted = False
    for name, window_of_run in zip(runs, windows):
        health = judge(health, Window(window_of_run))
        level = judgement.outcomes(health)['backlash'].level
        is_alerted = level > Level.OK and bool(health.alerts)
        if is_alerted and not was_alerted:
            alerted.append(name)
        was_alerted = is_alerted
    return alerted


def check(folder: str | Path) -> None:
    """Raise InputError unless `folder` holds recordings."""
    if len(real.load_runs(folder)[0]) <= FROM:
        raise InputError(f'{folder}: fewer than {FROM + 1} recordings, expected 00.TXT.gz to '
                         '43.TXT.gz')


def figures(folder: str | Path, bars: BarTable) -> dict[str, Any]:
    """Evaluate the recordings in `folder`: return plain data and add its bars to `bars`."""
    runs, step = real.load_runs(folder)
    healthy = [window(run, run.outputs, step, i) for i, run in enumerate(runs.values())]
    measured = [w for w in healthy if isinstance(w, Backlash)]
    lost_motion = np.degrees([w.lost_motion for w in measured])
    width = float(np.radians(np.nanmean(lost_motion)))
    worn = [window_of_run if i < FROM else
            window(run, widened(run.outputs, width, WIDENED), step, i)
            for i, (run, window_of_run) in enumerate(zip(runs.values(), healthy))]
    alerted, alerted_worn = (follow(runs, windows, step) for windows in (healthy, worn))
    alerted_when_worn = [name for name in alerted_worn if list(runs).index(name) >= FROM]
    grown = np.degrees([w.lost_motion for w in worn[FROM:] if not isinstance(w, NotExcited)])
    result = {
        'runs': list(runs), 'windows': len(measured), 'lost_motion': lost_motion.tolist(),
        'mean': float(np.mean(lost_motion)), 'spread': float(np.ptp(lost_motion)),
        'separable': sum(bool(w.separable) for w in measured),
        'gap': np.degrees([w.gap for w in measured]).tolist(),
        'alerts': alerted, 'alerts_widened': alerted_when_worn,
        'growth_seen': float(np.mean(grown) / np.mean(lost_motion[FROM:]) - 1.0)}
    bars.judge('real: recordings measured', len(measured), low=len(runs))
    bars.judge('real: lost motion, mean (deg)', result['mean'], *LOST_MOTION)
    bars.judge('real: lost motion, spread (deg)', result['spread'], high=SPREAD)
    bars.judge('real: gap distinguished from compliance', result['separable'], high=0)
    bars.judge('real: alerts', len(alerted), high=0)
    bars.judge('real: alerts, gap 5 % wider', len(alerted_when_worn), low=1)
    return result


def table(data: Mapping[str, Any]) -> list[str]:
    """Return the `data` of figures() as lines of at most 80 columns."""
    first_alert = (f'first alert with recording {data["alerts_widened"][0]}'
                   if data['alerts_widened'] else 'no alert')
    return [
        f'Real drive, {data["windows"]} of {len(data["runs"])} recordings, one baseline:',
        f'  lost motion (medians of both directions) {data["mean"]:.3f} deg, '
        f'{min(data["lost_motion"]):.3f} .. {max(data["lost_motion"]):.3f}',
        f'  dead zone distinguished from compliance in {data["separable"]} recordings; alerts: '
        f'{", ".join(data["alerts"]) or "none"}',
        f'  dead zone {100 * WIDENED:.0f} % wider from recording {data["runs"][FROM]} on: lost '
        f'motion {100 * data["growth_seen"]:+.1f} %, {first_alert}']
