# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A baseline beside the diagnosis of real pairs: least squares of the torque, ranked by BIC.

Each effect alone is fitted to the torque that the model leaves, as a user of a toolbox for
identification would do it: noise of one size per joint, of a drive per band; no tolerance, no
function without a law. The Bayesian information criterion (Schwarz, 1978) chooses one of them, or
none. Of a single drive, waves over the angle are left out: their order would be a search of its
own.
"""
from collections.abc import Mapping, Sequence
from dataclasses import replace
import math
from pathlib import Path

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel, Starts
from gearbox_monitor.diagnosis.joint.drive_recordings import evidence_of
from gearbox_monitor.diagnosis.joint.innovations import fitted, unfitted
from gearbox_monitor.diagnosis.joint.torque_domain import driven
from gearbox_monitor.diagnosis.robot.candidates import Candidate, library as effects_of_robot
from gearbox_monitor.diagnosis.robot.likelihood import RobotLikelihood
from gearbox_monitor.diagnosis.robot.rows import rows_of
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.knowledge_file import load_knowledge
from gearbox_monitor.library.recording import load_recording
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.effect import SETPOINT
from gearbox_monitor.recordings.from_bag import load_log, load_values, robot_model
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import UniformRecording
from gearbox_monitor.simulators.robot_model import read_robot

Cause = tuple[str, str]  # effect, joint or link; '' of a single drive


def ranked_of_robot(logs: Sequence[str], model: str | Path, values: str | None,
                    knowledge: str | None, recorded: Mapping[str, str]
                    ) -> list[tuple[Cause, float]]:
    """
    Return [(cause, gain in BIC over none)] of a robot, the largest first.

    Args:
        logs: bags or tables.
        model: URDF or MJCF file.
        values: file of the option --values, None for none.
        knowledge: file of learn, None for none.
        recorded: {joint: its name in the logs}, where they differ.
    """
    file = read_robot(model)
    stated = load_values(values, file)
    taught = load_knowledge(knowledge, file.digest) if knowledge else None
    robot = robot_model(file, stated, taught is not None)
    rows = [rows_of(load_log(path, file, robot, stated, recorded), robot,
                    taught.shapes if taught else (), taught.mean if taught else None)
            for path in logs]
    evidence = RobotLikelihood(rows, taught.prior if taught else None)
    out: dict[Cause, float] = {}
    for candidate in effects_of_robot(rows):
        cause = candidate.effect, candidate.place
        out[cause] = max(out.get(cause, -math.inf), _gain(evidence, candidate))
    return _ordered(out)


def _gain(evidence: RobotLikelihood, candidate: Candidate) -> float:
    """Return by how much BIC falls with a candidate, its coefficients by least squares."""
    parts = [(evidence.at[j].y, x[evidence.at[j].order]) for j, x in candidate.columns.items()]
    scales = [max(float(np.sqrt(np.mean(y * y))), 1e-9) for y, _ in parts]
    columns = np.concatenate([x / s for (_, x), s in zip(parts, scales)])
    values = np.linalg.lstsq(columns, np.concatenate([y / s for (y, _), s in zip(parts, scales)]),
                             rcond=None)[0]
    count = sum(len(a.y) for a in evidence.at)
    gain = sum(len(y) * math.log(float(y @ y) / max(float(np.sum((y - x @ values) ** 2)), 1e-300))
               for y, x in parts if y.any())
    return float(gain - candidate.width * math.log(count))


def ranked_of_drive(logs: Sequence[str], model: DriveModel) -> list[tuple[Cause, float]]:
    """
    Return [(cause, gain in BIC over none)] of a drive, the largest first.

    Args:
        logs: bags or CSV files.
        model: of the drive.
    """
    if model.controller is not None:
        raise InputError('the torque of a servo is not recorded: no least squares')
    recordings = [_recording(path, model) for path in logs]
    starts = Starts(model, recordings)
    none = _criterion(recordings, [starts.none()])
    out = {}
    for name, effect in EFFECTS.items():
        if effect.column and effect.column.needs != SETPOINT and not effect.periodic:
            out[name, ''] = none - _criterion(recordings, starts.candidates(name))
    return _ordered(out)


def _criterion(recordings: Sequence[UniformRecording], candidates: Sequence[CandidateModel]
               ) -> float:
    """Return the smallest BIC of some candidates by the balance of torques."""
    model = replace(candidates[0].nominal, driven_by='position')
    likelihood = evidence_of([driven(r, model) for r in recordings], model, ()).fine
    return min(fitted(likelihood, unfitted(likelihood, candidate)).deviance
               + len(candidate.ids) * math.log(likelihood.readings) for candidate in candidates)


def _recording(path: str, model: DriveModel) -> UniformRecording:
    """Return the recording in a file with the joints motor and arm."""
    samples = load_recording(path, model).readings
    return admitted(samples.stamp_ns, samples.u[:, 0], samples.y, samples.u[:, 1], path,
                    model, 'model')[0]


def _ordered(gains: Mapping[Cause, float]) -> list[tuple[Cause, float]]:
    """Return what has a finite gain, the largest first."""
    return sorted(((c, g) for c, g in gains.items() if math.isfinite(g)), key=lambda x: -x[1])
