# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Models of drives: from a model file, one joint of a simulator's file, or the catalogue."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.parameter_ranges import Combination, ParameterRanges
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import InputError, most_similar, refusal, unknown
from gearbox_monitor.files import user_files
from gearbox_monitor.files.user_files import config_path, load_yaml
from gearbox_monitor.plant.drive import DriveModel, expect_model, model_from_dict
from gearbox_monitor.plant.effects.arm_side import ARM_COULOMB
from gearbox_monitor.presentation import FileLimits, ModelOrigin, NO_LIMIT, said, Saved, Shown
from gearbox_monitor.simulators.drive_patch import patched, patched_urdf
from gearbox_monitor.simulators.file_edits import Patch
from gearbox_monitor.simulators.mjcf import Exported, model_values, refused, values_of
from gearbox_monitor.simulators.mjcf_file import (
    drive_of, MjcfDrive, model_of, read_file, read_mjcf, values_in)
from gearbox_monitor.simulators.xml_edit import difference

SIMULATORS, MODEL_FILES = ('.xml', '.urdf'), ('.yaml', '.yml')


def load_model(path: str | Path, joint: str | None = None, *, arm_joint: str | None = None,
               keyframe: str | None = None, actuator: str | None = None,
               root: str | Path | None = None,
               values: str | Path | Mapping[str, Any] | None = None) -> DriveModel:
    """
    Return the model of a drive in a model file, or of one joint in a simulator's file.

    Args:
        path: of a model file (YAML), or an MJCF or URDF file.
        joint: joint of the simulator's file that the motor drives; None for a model file.
        arm_joint: joint of the arm in the simulator's file, None where it is the same.
        keyframe: posture in which inertia and weight are taken, a key of an MJCF file.
        actuator: actuator of the joint, where several act on it.
        root: folder below which the files lie that the simulator's file includes, None for its
            own folder.
        values: further values, not in the simulator's file, or a YAML file of them. Without
            `tolerance`, values of a simulator's file count as 5 % off.

    Returns:
        The model. What it has no key for (ranges of setpoints and of the joint) goes with it, and
        with models derived from it, to `load_recording`.

    Raises:
        InputError: naming file, key, value and the expectation.

    >>> from gearbox_monitor.files.user_files import config_path
    >>> load_model(config_path('drive.yaml')).transmission.kind
    'dead_zone'
    """
    path = expect_path(path, 'path', 'a model file, or an MJCF or URDF file')
    if joint is None:
        if path.suffix.lower() in SIMULATORS:
            raise InputError(f'{path}: the file of a simulator, expected joint (--joint): '
                             'the joint of the drive in it')
        if values is not None:
            raise InputError(f'values: without joint (--joint), expected the file of a simulator, '
                             f'not {path}')
        return replace(user_files.load_model(path), origin=ModelOrigin(path.name))
    if path.suffix.lower() in MODEL_FILES:
        raise InputError(f'{path}: a model file, expected the file of a simulator with joint '
                         '(--joint)')
    drive = read_mjcf(path, joint, arm_joint, keyframe, actuator, root)
    model = model_of(drive, {'tolerance': SETTINGS.tolerance, **_given(values)})
    return replace(model, origin=ModelOrigin(path.name, _limits(drive, model)))


def _limits(drive: MjcfDrive, model: DriveModel) -> FileLimits:
    """Return the FileLimits of a `drive` in a simulator's file, which makes a `model`."""
    own, setpoints = drive.actuator, NO_LIMIT
    if own is not None and own.setpoint and model.controller:
        low, high = sorted(bound / own.gear for bound in own.control)
        setpoints = low, high
    return FileLimits(tuple(drive.notes), setpoints, drive.motor.travel)


def expect_path(value: object, name: str, what: str) -> Path:
    """Return `value`, called `name`, as the Path of `what`. Raises InputError for another type."""
    if isinstance(value, (str, Path)) and str(value):
        if gone := refusal(Path(value).suffix.lower()):
            raise InputError(f'{value}: {gone}')
        return Path(value)
    raise InputError(f'{name}: {type(value).__name__} {str(value)[:40]!r}, expected the path of '
                     f'{what}')


def _given(values: str | Path | Mapping[str, Any] | None) -> Mapping[str, Any]:
    """Return the values of a mapping, or of a YAML file."""
    if values is None or isinstance(values, Mapping):
        return values or {}
    content = load_yaml(expect_path(values, 'values', 'a YAML file')).content
    if not isinstance(content, dict):
        raise InputError(f'{values}: {str(content)[:40]!r}, expected keys and values')
    return content


FOLDER = 'actuators'
NAMES = ('ak80_6', 'davinci_backend', 'sts3250', 'tx40_joint1', 'tx40_joint2', 'tx40_joint3',
         'tx40_joint4', 'xl330')


@dataclass(frozen=True)
class CatalogueActuator:
    """
    An actuator of the catalogue.

    model: with the median values, its effort as `description` says. ranges: of the next
    recording. provenance: source, licence, citation, recorded, command. held_out: recordings that
    were not fitted, with the error of the median values on them.
    """

    name: str
    description: str
    model: DriveModel
    ranges: ParameterRanges
    provenance: Mapping[str, str]
    held_out: Mapping[str, Any]


def load_actuator(name: str) -> CatalogueActuator:
    """
    Return an actuator of the catalogue (docs/actuators.md).

    Args:
        name: of the actuator.

    Raises:
        InputError: the catalogue has no such name; the message lists those that it has.

    >>> load_actuator('davinci_backend').provenance['licence']
    'ODbL 1.0'
    """
    if not isinstance(name, str) or name not in NAMES:
        raise InputError(f'actuator: {name!r}, {unknown(str(name), NAMES)}')
    data = load_yaml(config_path(f'{FOLDER}/{name}.yaml')).content
    return CatalogueActuator(
        name, data['description'], model_from_dict(data['model'], name), _ranges(data['ranges']),
        {key: data[key] for key in ('source', 'licence', 'citation', 'recorded', 'command')},
        data['held_out'])


def is_actuator(path: str) -> bool:
    """Return whether `path` names an actuator, perhaps misspelt, and not a file."""
    return bool(most_similar(path, NAMES)) and not Path(path).exists()


def _ranges(data: Mapping[str, Any]) -> ParameterRanges:
    """Return the ranges in an entry."""
    rows = data['parameters']
    logarithmic = tuple(row['distribution'] == 'lognormal' for row in rows.values())
    low, centre, high = (np.array([row[key] for row in rows.values()], float)
                         for key in ('low', 'median', 'high'))
    between = np.array([row.get('between', np.nan) for row in rows.values()], float)
    return ParameterRanges(
        tuple(rows), tuple(row['unit'] for row in rows.values()), logarithmic, centre, low, high,
        between, np.array(data['correlation'], float),
        tuple(Combination(c['exponents'], c['deviation'])
              for c in data['known_only_in_combination']),
        tuple(data['sources']), tuple(data['notes']))


TARGETS = ('mjcf', 'urdf')
OF_MUJOCO = ('friction_law', 'timestep', 'integrator')  # which an MJCF file states
# A gearbox of unknown stiffness: its oscillation takes so many time steps, which every integrator
# of MuJoCo resolves, and is damped so far, as those of real gearboxes.
STEPS_PER_OSCILLATION, DAMPING_RATIO = 20.0, 0.1
STABLE = 2.0  # angular frequency times timestep, up to which a spring does not diverge in Euler


@dataclass(frozen=True, repr=False)
class SimulatorFile(Shown, Saved):
    """
    A model in the terms of a simulator.

    to: one of TARGETS. into: the file that was patched. before: its bytes. patch: its changes.
    notes: on forces that act in the file alone.
    """

    to: str
    into: Path
    before: bytes
    patch: Patch
    notes: tuple[str, ...]

    @property
    def text(self) -> str:
        """The patched file."""
        return self.patch.data.decode('utf-8')

    @property
    def exported(self) -> tuple[Exported, ...]:
        """What each effect and value of the model became."""
        return self.patch.exported

    @property
    def lacking(self) -> tuple[Exported, ...]:
        """What the simulator cannot express."""
        return tuple(refused(self.exported))

    @property
    def diff(self) -> str:
        """The difference to the file that was patched, as `diff -u` shows it."""
        return '\n'.join(difference(str(self.into), self.before, self.patch.data))


def export_model(model: DriveModel, to: str, into: str | Path, *, joint: str,
                 arm_joint: str | None = None, keyframe: str | None = None,
                 actuator: str | None = None, root: str | Path | None = None) -> SimulatorFile:
    """
    Return a model, such as `verdict.model`, in the file of a simulator.

    Args:
        model: of the drive.
        to: mjcf or urdf.
        into: MJCF or URDF file that is patched.
        joint: joint of the motor in that file.
        arm_joint: joint of the arm in an MJCF file, None where it is the same.
        keyframe: posture in which inertia and weight are taken.
        actuator: actuator of the joint, where several act on it.
        root: folder below which the files lie that the file includes.

    Returns:
        The file: `text`, `diff`, `lacking`; `save` writes it.

    Raises:
        InputError: naming what is missing from the file, or unknown to any model.

    >>> from gearbox_monitor.files.user_files import config_path
    >>> model = DriveModel().with_(kind='rigid', position_gain=0.0)
    >>> export_model(model, 'urdf', config_path('arm6.urdf'), joint='joint6').lacking
    ()
    """
    expect_model(model)
    if to not in TARGETS:
        raise InputError(f'to: {to!r}, {unknown(to, TARGETS, "export --to")}')
    path = expect_path(into, 'into', 'an MJCF or URDF file')
    if to == 'urdf':
        data = read_file(path)
        return SimulatorFile(to, path, data, patched_urdf(data, path, joint, model), ())
    values, exported = values_of(model)
    drive = read_mjcf(path, joint, arm_joint, keyframe, actuator, root)
    return SimulatorFile(to, path, drive.document.data, patched(drive, values, exported), (
        *_of_effort(drive, model), *_of_law(model), *_beyond(drive)))


def written_model(file: SimulatorFile, model: DriveModel, **reading: Any) -> DriveModel:
    """
    Return the drive in a file as it was written, without the parts that the file cannot hold.

    Args:
        file: of export_model.
        model: that was written; tolerances and what is recorded are those of it.
        reading: keyframe, actuator and root, see export_model.
    """
    joint, arm_joint = file.patch.joints
    return _in_units(drive_of(
        file.patch.data, file.into, (joint, arm_joint), reading.get('keyframe'),
        reading.get('actuator'), reading.get('root')), model)


def _in_units(drive: MjcfDrive, model: DriveModel) -> DriveModel:
    """Return a `drive` in a file; tolerances and units of efforts are those of `model`."""
    outside = {key: value for key, value in model.to_dict().items() if key not in (
        *model_values(values_in(drive)), 'axis', 'gear_ratio', 'torque_constant', 'controller')}
    if model.controller is None:
        outside['controller'] = None
    if drive.document.root.tag == 'mujoco':
        outside = {k: v for k, v in outside.items() if k not in OF_MUJOCO}
    read = model_of(drive, outside)
    torques = model.effort_scale / read.gear_ratio   # in units of which recordings are read
    return replace(read.with_torque_constant(torques), origin=model.origin)


def with_backlash(into: str | Path, backlash: float, *, joint: str,
                  stiffness: float | None = None, arm_joint: str | None = None,
                  keyframe: str | None = None, actuator: str | None = None,
                  root: str | Path | None = None) -> SimulatorFile:
    """
    Return an MJCF file in which a joint has backlash; all else of the joint stays.

    Args:
        into: MJCF file.
        backlash: full width, rad, or m of a slide.
        joint: that gets it, or the motor's where the file has one of its own.
        stiffness: of the gearbox, N m/rad or N/m; None keeps that of the file, or takes one that
            the timestep of the file resolves.
        arm_joint: joint of the arm, None where it is the same.
        keyframe: posture in which the inertia is taken.
        actuator: actuator of the joint, where several act on it.
        root: folder below which the files lie that the file includes.

    Returns:
        The file; `notes` states a stiffness that was taken.

    Raises:
        InputError: naming the missing part of the file: the motor's inertia, the joint.
    """
    if not 0.0 <= backlash < math.inf:
        raise InputError(f'backlash: {backlash:g}, expected a width of 0 or more, rad or m')
    if stiffness is not None and not 0.0 < stiffness < math.inf:
        raise InputError(f'stiffness: {stiffness:g}, expected more than 0')
    path = expect_path(into, 'into', 'an MJCF file')
    drive, notes = read_mjcf(path, joint, arm_joint, keyframe, actuator, root), list[str]()
    if drive.document.root.tag != 'mujoco':
        raise InputError(f'{path}: a URDF file, which has no backlash, expected MJCF')
    if drive.half_of_inertia:
        raise InputError(f'{path}: joint {joint}: armature: 0, expected the inertia of the motor '
                         'times the square of its gear')
    values = replace(values_in(drive), half_gap=0.5 * backlash, rigid=False)
    unit = 'N/m' if drive.motor.slide else 'N m/rad'
    inertia = 1.0 / (1.0 / values.motor_inertia + 1.0 / values.arm_inertia)
    if stiffness is not None:
        limit = inertia * (STABLE / drive.timestep) ** 2
        if stiffness > limit:
            raise InputError(f'stiffness: {stiffness:g}, expected at most {limit:.3g} {unit}, '
                             f'beyond which a timestep of {drive.timestep:g} s diverges')
        values = replace(values, stiffness=stiffness)
    elif not values.stiffness:
        omega = 2.0 * math.pi / (STEPS_PER_OSCILLATION * drive.timestep)
        values = replace(values, stiffness=inertia * omega ** 2,
                         damping=2.0 * DAMPING_RATIO * inertia * omega)
        notes = [str(said('file_stiffness', stiffness=values.stiffness, unit=unit,
                          timestep=drive.timestep, frequency=omega / 2.0 / math.pi))]
    return SimulatorFile('mjcf', path, drive.document.data, patched(drive, values, ()),
                         tuple(notes))


def _of_effort(drive: MjcfDrive, model: DriveModel) -> Sequence[str]:
    """Return a note where one unit of effort in `model` is another torque than one of control."""
    a = drive.actuator
    if a is None or a.spring or a.damper or math.isclose(
            a.gear * a.gain, model.effort_scale, rel_tol=1e-6):
        return []
    factor = model.effort_scale / (a.gear * a.gain)
    return [str(said('other_effort', effort=model.effort_scale, control=a.gear * a.gain,
                     file=drive.path.name, factor=factor, gear=a.gear * factor,
                     actuator=a.name or drive.motor.name))]


def _of_law(model: DriveModel) -> Sequence[str]:
    """Return a note where MuJoCo has no friction with the law of the model."""
    law, friction = model.friction_law, any(
        e['id'] == ARM_COULOMB.id for e in model.effects) or model.coulomb_friction > 0.0
    if law.constraint or not friction:
        return []
    return [str(said('other_law', law='arctangent' if law.kind == 'atan' else law.kind))]


def _beyond(drive: MjcfDrive) -> Sequence[str]:
    """Return notes about forces on the joints that no model has."""
    return [str(said('goes_on', joint=row.joint, row=row, file=drive.path.name))
            for row in drive.refusals()]
