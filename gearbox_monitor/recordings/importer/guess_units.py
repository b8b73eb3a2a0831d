# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Units, signs, gear ratio and codings of integers that the motion shows of columns with a role.

A velocity is the derivative of a position; an effort does work against friction on the whole.
"""
from collections.abc import Mapping
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.importer.clocks import motion_regressors
from gearbox_monitor.recordings.importer.layout import Series
from gearbox_monitor.recordings.importer.roles import DERIVATIVE, Motion, motion_of
from gearbox_monitor.recordings.importer.unit_table import ANGULAR_SPEED, SPEED, unit_factor

SMOOTHER = 0.3  # path length of a decoded integer to that of the raw one
GEARED = 0.2  # from 1: lost motion and noise make a ratio of 1 look that different
CODINGS = (('twos_complement', 16), ('twos_complement', 32), ('sign_magnitude', 11),
           ('sign_magnitude', 16))


def decoded(column: Series, assumptions: list[str]) -> tuple[Array, dict[str, Any]]:
    """
    Return (values, keys bits and coding) of `column`, in the coding that is smooth.

    assumptions: receives a sentence where a coding was chosen.
    """
    values = column.values.astype(float)
    valid = values[np.isfinite(values)]
    if (valid != np.floor(valid)).any() or valid.min() < 0:
        return values, {}
    best, keys, path = values, {}, float(np.abs(np.diff(valid)).sum())
    for coding, bits in CODINGS:
        half, full = 2.0 ** (bits - 1), 2.0 ** bits
        if valid.max() < half or valid.max() >= full:
            continue
        negative = half - values if coding == 'sign_magnitude' else values - full
        trial = np.where(values >= half, negative, values)
        length = float(np.abs(np.diff(trial[np.isfinite(trial)])).sum())
        if length < SMOOTHER * path:
            best, path = trial, length
            keys = {'bits': bits, **({'coding': coding} if coding == 'sign_magnitude' else {})}
    if keys:
        assumptions.append(f'{column.label}: {keys["bits"]}-bit integers, '
                           f'{keys.get("coding", "twos_complement")}.')
    return best, keys


def scale_of(block: Mapping[str, Any], kind: str) -> float | None:
    """Return the factor to SI of a position's block and joint `kind`, None: unknown counts."""
    factor, complete = unit_factor(block['unit'], 'position', kind) if 'unit' in block else \
        (1.0, True)
    if complete:
        return factor
    count = block.get('counts_per_rev')
    return 2.0 * np.pi / count if count else None


def relate_encoders(data: dict[str, Any], blocks: dict[str, dict[str, Any]],
                    positions: tuple[Array, Array], assumptions: list[str]) -> None:
    """
    Add the sign of the arm, and the gear ratio or the motor's counts per turn of the output.

    Args:
        data: mapping that receives the ratio.
        blocks: {signal: keys}, which receive sign and counts.
        positions: readings [N] of motor and arm, as recorded.
        assumptions: receives a sentence for each key.

    """
    motor, arm = positions
    valid = np.isfinite(motor) & np.isfinite(arm)
    slope = float(np.polyfit(arm[valid], motor[valid], 1)[0])
    if slope < 0.0:
        blocks['arm_position']['sign'] = -1
        assumptions.append('The arm runs against the motor: its sign is -1.')
    scale = [scale_of(blocks[name], data['kind']) for name in ('motor_position', 'arm_position')]
    if scale[1] is not None and scale[0] is None:
        count = abs(slope) * 2.0 * np.pi / scale[1]
        blocks['motor_position']['counts_per_rev'] = float(f'{count:.6g}')
        assumptions.append(f'Motor: {count:.6g} counts per turn of the output, from the motion of '
                           'the arm; lost motion makes it too large, a data sheet knows better.')
    elif scale[0] is not None and scale[1] is not None:
        ratio = abs(slope) * scale[0] / scale[1]
        if abs(ratio - 1.0) > GEARED:
            whole = round(ratio)
            data['gear_ratio'] = float(whole) if whole and abs(ratio / whole - 1.0) < 0.01 else \
                float(f'{ratio:.6g}')
            assumptions.append(f'Gear ratio {data["gear_ratio"]:g}: the motor turns {ratio:.5g} '
                               'times as much as the arm.')


def velocity_units(kind: str, blocks: dict[str, dict[str, Any]], values: Mapping[str, Array],
                   t: Array, assumptions: list[str]) -> None:
    """
    Add the unit of a velocity, or of its position, that their derivative relation shows.

    Args:
        kind: of the joint, rotary or prismatic.
        blocks: {signal: keys}, which receive the unit.
        values: {signal: [N]}, as recorded.
        t: stamps [N] of the rows, s, in any order.
        assumptions: receives a sentence for each unit.

    """
    table = {('velocity', 'rotary'): ANGULAR_SPEED, ('velocity', 'prismatic'): SPEED}
    for side in ('motor', 'arm'):
        name, position = f'{side}_velocity', f'{side}_position'
        if name not in blocks or position not in blocks or 'unit' in blocks[name]:
            continue
        scale = scale_of(blocks[position], kind)
        order = np.argsort(t, kind='stable')
        motion = motion_of(t[order], values[position][order])
        valid = np.isfinite(values[name][order])
        velocity = values[name][order][valid]
        if motion.explained(values[name][order]) < DERIVATIVE:
            continue
        derivative = motion.velocity[valid]
        # The noise of either draws a regression on it towards 0: the gain is between the two.
        product = float(velocity @ derivative)
        if scale is None or product == 0.0:
            continue
        gain = float(np.sign(product) * np.sqrt((derivative @ derivative) /
                                                (velocity @ velocity)))
        doubt = 0.1 + abs(np.log(abs(product / (gain * (velocity @ velocity)))))
        units = table['velocity', kind]
        unit = min(units, key=lambda u: abs(np.log(abs(gain * scale / units[u]))))
        if gain < 0.0:
            blocks[name]['sign'] = -1
        if abs(np.log(abs(gain * scale / units[unit]))) < doubt:
            blocks[name]['unit'] = unit
            assumptions.append(f'{name}: {unit}, as the derivative of {position}.')
        else:
            blocks[name]['scale'] = float(f'{abs(gain) * scale:.4g}')
            assumptions.append(f'{name}: scale {blocks[name]["scale"]:g}, as the derivative of '
                               f'{position}.')


def effort_sign(blocks: dict[str, dict[str, Any]], values: Mapping[str, Array], t: Array,
                assumptions: list[str]) -> None:
    """
    Turn the efforts round that take work out of a drive with friction.

    Args:
        blocks: {signal: keys}, which receive the sign.
        values: {signal: [N]}, as recorded.
        t: stamps [N] of the rows, s, in any order.
        assumptions: receives a sentence for each sign.

    """
    position = next((name for name in ('motor_position', 'arm_position') if name in blocks), None)
    order = np.argsort(t, kind='stable')
    for name in ('motor_effort', 'reference_torque'):
        if name not in blocks or position is None:
            continue
        motion = motion_of(t[order], values[position][order])
        sign = blocks[position].get('sign', 1)
        if sign * _resistance(motion, values[name][order]) < 0.0:
            blocks[name]['sign'] = -1
            assumptions.append(f'{name}: sign -1, or it would take work out of the drive.')


def _resistance(motion: Motion, effort: Array) -> float:
    """
    Return 1.0 if an effort moves a mass against friction, -1.0 if the reverse, else 0.

    Weight and springs are taken out: they give back what they take, but not within each recording.
    """
    columns = motion_regressors(motion.t, motion.position, False)
    valid = np.isfinite(effort)
    columns, y = columns[valid], effort[valid]
    scale = np.abs(columns).max(axis=0) + 1e-300
    inertia, viscous, coulomb, *_ = np.linalg.lstsq(columns / scale, y, rcond=1e-12)[0] / scale
    speed = columns[:, 1]
    friction = (viscous * speed + coulomb * columns[:, 2]) * speed
    if np.sign(inertia) != np.sign(friction.sum()):
        return 0.0
    return float(np.sign(inertia))
