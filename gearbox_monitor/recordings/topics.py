# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The table of published signals: which column of an estimate stands in which message field.

One truth for the live node, replay, plots and docs. All topics carry sensor_msgs/JointState with
the stamp of the measurement (smoothed: of the time it is about). Units: rad, rad/s, N m.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.estimation import rts_smoother, sample_loop
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.kernels.types import Array, Integers

TRANSMISSION = 'transmission'
MOTOR, ARM = 'motor', 'arm'


@dataclass(frozen=True)
class Signal:
    """
    One topic: `joints` and, for each field, one column per joint (empty: field not sent).

    Columns are those of an estimate row, or of a smoothed row where `smoothed`. A motor or arm
    whose position is NaN was not measured and is left out. `deviation`: values are standard
    deviations. `gated`: columns of deviations; the position is the test ratio of its column, the
    square over that of `gate` deviations.
    """

    topic: str
    joints: tuple[str, ...]
    position: tuple[int, ...]
    velocity: tuple[int, ...] = ()
    effort: tuple[int, ...] = ()
    smoothed: bool = False
    deviation: bool = False
    gated: tuple[int, ...] = ()

    def positions(self, rows: Array) -> Array:
        """Return the values of the field position [..., J] for `rows` [..., M]."""
        values: Array = rows[..., self.position]
        if self.gated:
            values = np.square(values / (LIMITS.gate * rows[..., self.gated]))
        return values

    def scale(self, joint: str, gear_ratio: float) -> float:
        """Return the factor from the arm side to messages of the `joint`."""
        if joint != MOTOR or self.gated:
            return 1.0
        return abs(gear_ratio) if self.deviation else gear_ratio


SIGNALS = (
    Signal('transmission_state', (TRANSMISSION,), (sample_loop.E_TWIST,),
           (sample_loop.E_TWIST_RATE,), (sample_loop.E_TAU_K,)),
    Signal('transmission_state_stddev', (TRANSMISSION,), (sample_loop.E_TWIST_STD,),
           (sample_loop.E_TWIST_RATE_STD,), (sample_loop.E_STD + sample_loop.E_TAU_K,),
           deviation=True),
    Signal('transmission_state_smoothed', (TRANSMISSION,), (rts_smoother.S_TWIST,),
           (rts_smoother.S_TWIST_RATE,), (rts_smoother.S_TAU_K,), smoothed=True),
    Signal('innovations', (MOTOR, ARM),
           (sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM)),
    Signal('innovations_stddev', (MOTOR, ARM),
           (sample_loop.E_INNOVATION_STD_MOTOR, sample_loop.E_INNOVATION_STD_ARM), deviation=True),
    Signal('innovation_test_ratios', (MOTOR, ARM),
           (sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM),
           gated=(sample_loop.E_INNOVATION_STD_MOTOR, sample_loop.E_INNOVATION_STD_ARM)),
    Signal('estimated_joint_states', (MOTOR, ARM), (sample_loop.E_X1, sample_loop.E_X2),
           (sample_loop.E_X3, sample_loop.E_X4)),
)
JOINT_STATES = 'joint_states'
JOINT_SETPOINTS = 'joint_setpoints'
PAIRED_JOINT_STATES = 'paired_joint_states'  # motor and arm, where they come on two topics
PLANT_TRANSMISSION_STATE = 'plant/transmission_state'
DIAGNOSTICS = '/diagnostics'
DRIFT_ALERTS = 'drift_alerts'
SNAPSHOT = 'snapshot'
DIAGNOSIS = 'diagnosis'
# Of a whole robot: geometry_msgs/InertiaStamped, and JointState of all joints, with deviations.
ROBOT_DESCRIPTION, FINDINGS = 'robot_description', '~/findings'
PAYLOAD, PAYLOAD_STD = 'payload', 'payload_stddev'


def joint_values(signal: Signal, row: Sequence[float] | Array, names: Mapping[str, str],
                 gear_ratio: float) -> tuple[list[str], list[float], list[float], list[float]]:
    """
    Return what the message of `signal` holds for one row.

    Args:
        signal: a row of SIGNALS.
        row: of an estimate, or a smoothed row if signal.smoothed.
        names: {MOTOR: ..., ARM: ...}, the joints' names in messages.
        gear_ratio: position and velocity of the motor joint are multiplied by it.

    Returns:
        Joint names, position (rad), velocity (rad/s), effort (N m); without joints whose position
        is NaN.

    """
    joints: list[str] = []
    position: list[float] = []
    velocity: list[float] = []
    effort = [float(row[c]) for c in signal.effort]
    for i, joint in enumerate(signal.joints):
        value = row[signal.position[i]]
        if value != value and joint != TRANSMISSION:
            continue
        if signal.gated:
            value = np.square(value / (LIMITS.gate * row[signal.gated[i]]))  # ** of a float is pow
        scale = signal.scale(joint, gear_ratio)
        joints.append(names.get(joint, joint))
        position.append(float(value) * scale)
        if signal.velocity:
            velocity.append(float(row[signal.velocity[i]]) * scale)
    return joints, position, velocity, effort


def signal_values(signal: Signal, estimates: Estimates, gear_ratio: float
                  ) -> tuple[Integers, dict[str, Array]]:
    """
    Return what the messages of `signal` hold for all estimates; see joint_values.

    Args:
        signal: a row of SIGNALS with J joints.
        estimates: M of them.
        gear_ratio: position and velocity of the motor joint are multiplied by it.

    Returns:
        Stamps [M] ns and {field: [M, J]}; values of joints that were not measured are NaN.

    """
    stamps = estimates.smoothed_stamp_ns if signal.smoothed else estimates.stamp_ns
    rows = estimates.smoothed if signal.smoothed else estimates.rows
    scale = np.array([signal.scale(joint, gear_ratio) for joint in signal.joints])
    values = {'position': signal.positions(rows) * scale}
    if signal.velocity:
        values['velocity'] = rows[:, signal.velocity] * scale
    if signal.effort:
        values['effort'] = rows[:, signal.effort]
    return stamps, values
