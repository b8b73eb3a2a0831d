# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command that finds the motion a diagnosis asks for, ready to be run."""
from collections.abc import Mapping, Sequence
import math
from pathlib import Path
import shlex
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.isolability import twins
from gearbox_monitor.kernels.sensor_noise import noise_levels
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.arm_side import LOAD_TORQUE
from gearbox_monitor.plant.effects.encoder import ENCODER_OFFSET
from gearbox_monitor.plant.effects.gearbox import BACKLASH_GAP
from gearbox_monitor.plant.effects.motor_side import (
    COULOMB_ASYMMETRY, MOTOR_INERTIA, MOTOR_VISCOUS)
from gearbox_monitor.signals.recording import UniformRecording
from gearbox_monitor.signals.smoothed_motion import SmoothedMotion

# Warnings of the check about a motion, and effects that then look alike.
UNEXCITED = (('never crosses the gap', (BACKLASH_GAP.id, ENCODER_OFFSET.id)),
             ('offset and load cannot be distinguished', (COULOMB_ASYMMETRY.id, LOAD_TORQUE.id)),
             ('hardly accelerates', (MOTOR_INERTIA.id, MOTOR_VISCOUS.id)))


def suggestion(data: Mapping[str, Any], recordings: Sequence[UniformRecording],
               model_file: str | Path, out: str | Path | None = None) -> list[str]:
    """
    Return the command that finds a more informative motion.

    Args:
        data: plain data of a verdict.
        recordings: those it is about: their torque, speed and travel are the limits.
        model_file: of the drive.
        out: directory with verdict.json, None if it is not written.

    Returns:
        Parts of the command line, none if no motion would be more informative.

    """
    effects = library()
    alike = twins(alone=all(len(r.channels) == 1 for r in recordings))
    pairs = [(a, b) for a in data.get('params') or {} for b in data.get('confusable') or ()
             if a in effects and b in effects and (a, b) not in alike]
    unexcited = [pair for words, pair in UNEXCITED
                 if any(words in warning for warning in data.get('warnings') or ())]
    if pairs and out:
        question = shlex.quote(str(out))
    elif pairs or unexcited:
        question = '--pair ' + ' '.join((pairs or unexcited)[0])
    else:
        return []
    limits = zip(('torque', 'speed', 'travel'), _reached(recordings))
    return [f'gearbox_monitor suggest {question}', f'--model {shlex.quote(str(model_file))}',
            *(f'--max-{name} {_below(value)}' for name, value in limits),
            '--out motion.yaml', '--csv motion.csv']


def _reached(recordings: Sequence[UniformRecording]) -> Array:
    """Return the largest torque, speed and travel from the start: N m, rad/s, rad."""
    rows = []
    for r in recordings:
        smooth = SmoothedMotion(r, noise_levels(r.y)[0])
        rows.append((np.abs(r.torque).max(), np.abs(smooth.v).max(),
                     np.abs(smooth.p - smooth.p[0]).max()))
    reached: Array = np.asarray(rows).max(axis=0)
    return reached


def _below(value: float) -> str:
    """Return `value` rounded down to two digits: the drive has done that, not more."""
    digits = 1 - math.floor(math.log10(value))
    return f'{math.floor(value * 10.0 ** digits) / 10.0 ** digits:g}'
