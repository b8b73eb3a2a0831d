# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Power: which effects a motion would have shown, had they been there.

Nothing found says something only of what would have been found. The smallest size that pays its
price and the margin follows from the information about it, values with tolerances given way, over
the dispersion by which the contest divides.
"""
import math

from gearbox_monitor.diagnosis.contest import CONTEST
from gearbox_monitor.diagnosis.hypothesis import Hypothesis
from gearbox_monitor.diagnosis.joint.effect_scan import signature
from gearbox_monitor.diagnosis.joint.innovation_evidence import InnovationEvidence
from gearbox_monitor.diagnosis.joint.lawless import Tested
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.arm_side import ARM_INERTIA
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA


def hidden(evidence: InnovationEvidence, none: Hypothesis) -> dict[str, float]:
    """
    Return {effect: smallest size that shows} where a change of plausible size would not show.

    Of friction, gain and inertia.

    Args:
        evidence: of the recordings.
        none: the fit without effects.
    """
    data, share = evidence.data, THRESHOLDS.plausible
    model, tested = data.model, Tested.beside(data.fine, none.fit.fit)
    # What a drive of this torque may have: half of its torque, of its gain, twice its inertia.
    sizes = {MOTOR_COULOMB.id: share * data.torque, TORQUE_GAIN.id: share,
             SERVO_GAIN.id: share * model.value('kp') if model.controller else 0.0,
             MOTOR_INERTIA.id: 2.0 * share * model.motor_inertia,
             ARM_INERTIA.id: 2.0 * share * model.arm_inertia}
    limit = evidence.dispersion * (
        CONTEST.margin + evidence.unit + 2.0 * math.log(evidence.rivals))
    out = {}
    for name in data.ids:
        if sizes.get(name):
            columns, change = signature(data.fine, tested.at, data.starts.candidates(name)[0])
            column = columns[:, :1] / change[0]
            information = float((column * tested.without(column)).sum())
            smallest = math.sqrt(limit / max(information, 1e-300))
            if not smallest < sizes[name]:
                out[name] = smallest
    return out
