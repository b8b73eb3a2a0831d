# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Read a drive in an MJCF or URDF file: from what MuJoCo compiles of it, whole or refused.

A drive is one joint (motor and arm are rigidly coupled, the motor is its armature), or two joints
that hang on one parent: that of the motor, and that of the arm. A fixed tendon between the two is
the transmission. All other joints rest in the posture. `values_in` makes MjcfValues of it, in
which the writer has a model, too.
"""
import cmath
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from pathlib import Path
import re
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError, refusal, unknown
from gearbox_monitor.files.user_files import read_bytes
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.transmission import FrictionLaw
from gearbox_monitor.presentation import NO_LIMIT
from gearbox_monitor.robot.compiled_model import (
    actuator_law, actuator_losses, ActuatorLaw, actuators_on, at_rest, disabled, DRAG, enabled,
    is_off, kind_of, mujoco_module, name_of, open_loop, Refusal, scalar_joints, undecided, Unread)
from gearbox_monitor.robot.description import parse
from gearbox_monitor.simulators.compiling import compiled_model
from gearbox_monitor.simulators.mjcf import (
    ARM, COGGING, LUGRE, MjcfValues, model_values, MOTOR, Passive, Servo, steady, TENDON)
from gearbox_monitor.simulators.xml_edit import parse_xml, readable_urdf, XmlDocument

INTEGRATOR_OF = {'implicit': 'implicitfast'}  # they differ by damping between joints

MAX_XML = 1 << 26  # bytes of a file
OPEN = 1e-4        # m or rad, of a closed loop of bodies that a posture leaves open
SAME = 1e-6        # relative: limits that differ by less are symmetric
SPOILT = 0.02      # of a joint's inertia: less than half of its usual tolerance of 5 %
ORDERS = (1, 40)   # of cogging, of the library


@dataclass(frozen=True)
class MjcfJoint:
    """
    A joint as MuJoCo compiles it, in SI units.

    inertia: of all that moves with it, without its armature; damping, stiffness: with those of
    actuators, which are actuator_damping, actuator_stiffness; law: of frictionloss, with the
    impedance that counts in the posture; constant: torque of springs and actuators at the
    position 0 and the control 0, N m; springref: rad; travel: range of positions; force: limits
    of the torque of its actuators.
    """

    name: str
    index: int
    armature: float
    inertia: float
    damping: float
    actuator_damping: float
    frictionloss: float
    stiffness: float
    actuator_stiffness: float
    constant: float
    springref: float
    ref: float
    slide: bool
    law: FrictionLaw
    travel: tuple[float, float]
    force: tuple[float, float]


@dataclass(frozen=True)
class MjcfTendon:
    """A fixed tendon over motor (coefficient `sign`) and arm (-`sign`)."""

    name: str
    index: int
    sign: float
    low: float
    high: float
    stiffness: tuple[float, float, float]
    damping: float
    springyield: float = 0.0


@dataclass(frozen=True)
class MjcfDrive:
    """
    A drive in an MJCF file; `arm` and `tendon` are None where motor and arm are one joint.

    hysteresis: a tendon beside the gearbox whose spring yields; passive: torques of actuators
    without control; notes: what was taken for granted, for people; lacking: masses and tensors
    that a URDF does not state, or not as any body has them.
    """

    path: Path
    document: XmlDocument
    compiled: Any
    timestep: float
    degrees: bool
    motor: MjcfJoint
    arm: MjcfJoint | None
    tendon: MjcfTendon | None
    hysteresis: MjcfTendon | None
    actuator: ActuatorLaw | None
    passive: tuple[tuple[Passive, int], ...]
    posture: Array
    keyframe: str | None
    notes: tuple[str, ...] = ()
    lacking: tuple[Refusal, ...] = ()

    @property
    def arm_joint(self) -> MjcfJoint:
        """The joint that moves the arm."""
        return self.arm or self.motor

    @property
    def friction_law(self) -> FrictionLaw:
        """The law of friction of its joints, by the motor where it has friction."""
        motor, arm = self.motor, self.arm_joint
        return motor.law if motor.frictionloss or not arm.frictionloss else arm.law

    @property
    def half_of_inertia(self) -> bool:
        """Whether the motor has no inertia of its own in the file: half of the joint's counts."""
        return self.arm is None and self.motor.armature <= 0.0

    def refusals(self) -> list[Refusal]:
        """Return what acts on the joints of the drive and is not read."""
        joints = [j.index for j in (self.motor, self.arm) if j is not None]
        gearboxes = [t.index for t in (self.tendon, self.hysteresis) if t is not None]
        acting = undecided(self.compiled, joints, at_rest(self.compiled, self.posture), gearboxes)
        if self.document.root.tag == 'robot':  # all equalities are <mimic>
            acting = [r._replace(attribute='mimic') if r.attribute.startswith('equality') else r
                      for r in acting]
        return [*acting, *(self.lacking or _of_drive(self))]


def read_mjcf(path: str | Path, joint: str, arm_joint: str | None = None,
              keyframe: str | None = None, actuator: str | None = None,
              root: str | Path | None = None) -> MjcfDrive:
    """
    Return the drive in an MJCF file.

    Args:
        path: of the file.
        joint: name of the joint that the motor drives.
        arm_joint: name of the joint of the arm, None where it is the same.
        keyframe: posture in which inertia and weight are taken, None for that of the file.
        actuator: name of the actuator, None for the only one on the joint.
        root: folder below which the files lie that it names, None for its own folder.

    Returns:
        The MjcfDrive.

    Raises:
        InputError: no such file, joint, keyframe or actuator, or a drive of another structure.

    """
    path = Path(path)
    return drive_of(read_file(path), path, (joint, arm_joint), keyframe, actuator,
                    Path(root) if root else None)


def read_file(path: Path) -> bytes:
    """Return the bytes of the simulator's file `path`. Raises InputError."""
    if gone := refusal(path.suffix.lower()):
        raise InputError(f'{path}: {gone}')
    try:
        return read_bytes(path, MAX_XML)
    except (OSError, ValueError) as error:
        raise InputError(f'{path}: {getattr(error, "strerror", error)}, expected a readable MJCF '
                         'or URDF file') from None


@dataclass(frozen=True)
class RobotFile:
    """
    A robot's file as MuJoCo compiles it: the document that was compiled, and the notes.

    spoilt: {link of a URDF: by how much its tensor differs from the one in the file, kg m^2}.
    """

    path: Path
    document: XmlDocument
    compiled: Any
    notes: tuple[str, ...] = ()
    spoilt: Mapping[str, float] = field(default_factory=dict)


def compiled_file(data: bytes, path: Path, root: Path | None = None) -> RobotFile:
    """
    Return what MuJoCo compiles of an MJCF or URDF file.

    Args:
        data: bytes of the file.
        path: of the file.
        root: see read_mjcf.

    Returns:
        The RobotFile.

    Raises:
        InputError: it is neither, or MuJoCo refuses it.

    """
    document, notes, spoilt = parse_xml(data, str(path)), list[str](), dict[str, float]()
    if document.root.tag == 'robot':
        data, notes, spoilt = readable_urdf(data, str(path))
    elif document.root.tag != 'mujoco':
        raise InputError(f'{path}: line {document.root.line}: <{document.root.tag}>, expected '
                         '<mujoco>, or <robot> of a URDF file')
    try:
        compiled = compiled_model(data, path, root)
    except InputError as error:
        if document.root.tag == 'robot':
            parse(document.data.decode('utf-8', 'replace'), str(path))  # in the file's own words
            raise InputError(re.sub(r': line \d+:', ':', str(error), count=1)) from None
        raise
    if not compiled.njnt:
        raise InputError(f'{path}: no joint that moves, expected at least one')
    return RobotFile(path, document, compiled, tuple(notes), spoilt)


def drive_of(data: bytes, path: Path, joints: tuple[str, str | None],
             keyframe: str | None = None, actuator: str | None = None,
             root: Path | None = None) -> MjcfDrive:
    """
    Return the drive in the bytes of an MJCF file, see read_mjcf.

    Args:
        data: bytes of the file.
        path: of the file.
        joints: names of the joints of motor and arm.
        keyframe: posture, None for that of the file.
        actuator: name of the actuator, None for the only one on the joint.
        root: folder below which the files lie that it names.

    Returns:
        The MjcfDrive.

    """
    return drive_in(compiled_file(data, path, root), joints, keyframe, actuator)


def drive_in(file: RobotFile, joints: tuple[str, str | None], keyframe: str | None = None,
             actuator: str | None = None) -> MjcfDrive:
    """
    Return the drive in a compiled file, see read_mjcf.

    Args:
        file: the robot's.
        joints: names of the joints of motor and arm.
        keyframe: posture, None for that of the file.
        actuator: name of the actuator, None for the only one on the joint.

    Returns:
        The MjcfDrive.

    """
    document, m, path = file.document, file.compiled, file.path
    posture = posture_of(m, keyframe, path)
    state = at_rest(m, posture)
    numbers = [_number(m, name, path) for name in joints if name]
    if len(numbers) > 1:
        parents = [m.body_parentid[m.jnt_bodyid[j]] for j in numbers]
        if parents[0] != parents[1] or m.jnt_type[numbers[0]] != m.jnt_type[numbers[1]]:
            raise InputError(f'{path}: joint {joints[1]}: moves with '
                             f'{joints[0]} or is of another type, expected two joints of one '
                             'type whose bodies have the same parent')
    tendon, hysteresis = None, None
    if len(numbers) > 1:
        tendons = _tendons(m, numbers)
        tendon = next((t for t in tendons if not t.springyield), None)
        hysteresis = next((t for t in tendons if t.springyield and tendon is not None), None)
    own, joint_laws = _chosen(m, numbers[0], document, actuator)
    passive, notes = _passive(m, numbers, tendon), list(file.notes)
    motor = _joint(m, state, numbers[0], [law for law in joint_laws if not law.passive])
    if own is not None and not own.setpoint:
        motor = replace(motor, damping=motor.damping + own.damper,
                        actuator_damping=motor.actuator_damping + own.damper)
    notes += _remarks(m, motor, own, joint_laws, path)
    loop, gap = open_loop(m, numbers[0], state)
    if gap > OPEN:
        notes.append(f'{path.name}: joint {joints[0]}: equality {loop}: open by {gap:.2g} m in '
                     'this posture, so that it acts on the joint: choose a --keyframe that '
                     'closes it')
    arm = _joint(m, state, numbers[1], []) if len(numbers) > 1 else None
    compiler = [e for e in document.root.walk() if e.tag == 'compiler']
    degrees = all(e.attributes.get('angle', 'degree') == 'degree' for e in compiler)
    return MjcfDrive(path, document, m, float(m.opt.timestep), degrees, motor, arm, tendon,
                     hysteresis, own, tuple(passive), state.qpos.copy(), keyframe, tuple(notes),
                     _lacking(file, motor))


def posture_of(m: Any, keyframe: str | None, path: Path) -> Array | None:
    """
    Return the posture of a keyframe.

    Args:
        m: mujoco.MjModel.
        keyframe: its name, None for none.
        path: of the file, for messages.

    Returns:
        Positions [nq], None without a keyframe.

    Raises:
        InputError: the file has no such keyframe.
    """
    if keyframe is None:
        return None
    mujoco = mujoco_module()
    k = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_KEY, keyframe)
    if k < 0:
        names = [name_of(m, 'key', i) for i in range(m.nkey)]
        raise InputError(f'{path}: keyframe: {keyframe!r} is not in the file, ' + (
            unknown(keyframe, names) if names else 'which has none: leave the option out'))
    posture: Array = m.key_qpos[k].copy()
    return posture


def _number(m: Any, name: str, path: Path) -> int:
    """Return the number of the joint `name`. Raises InputError."""
    mujoco = mujoco_module()
    index = int(mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_JOINT, name))
    if index < 0:
        names = [name_of(m, 'joint', j) for j in scalar_joints(m)]
        raise InputError(f'{path}: joint: {name!r} is not in this file, {unknown(name, names)}')
    if index not in scalar_joints(m):
        raise InputError(f'{path}: joint {name}: type, expected hinge or slide')
    return index


def _joint(m: Any, state: Any, index: int,
           laws: Sequence[ActuatorLaw]) -> MjcfJoint:
    """Return a joint with what the `laws` of its other actuators do at the control 0."""
    mujoco = mujoco_module()
    name = name_of(m, 'joint', index)
    slide = bool(m.jnt_type[index] == int(mujoco.mjtJoint.mjJNT_SLIDE))
    dof, place = m.jnt_dofadr[index], m.jnt_qposadr[index]
    unit, row = np.zeros(m.nv), np.zeros(m.nv)
    unit[dof] = 1.0
    mujoco.mj_mulM(m, state, row, unit)
    rotor, added = actuator_losses(m, index)
    armature = float(m.dof_armature[dof]) + rotor
    damping, springs = float(m.dof_damping[dof]) + added, float(m.jnt_stiffness[index])
    if disabled(m, 'DAMPER'):
        damping = 0.0
    if disabled(m, 'SPRING'):
        springs = 0.0
    dampers, elastic = (math.fsum(getattr(law, name) for law in laws)
                        for name in ('damper', 'spring'))
    friction = float(m.dof_frictionloss[dof])
    if disabled(m, 'FRICTIONLOSS', 'CONSTRAINT'):
        friction = 0.0
    ref = float(m.qpos_spring[place])
    return MjcfJoint(
        name, index, armature,
        float(row[dof] - armature), damping + dampers, added + dampers, friction,
        springs + elastic, elastic, springs * ref + math.fsum(law.constant for law in laws), ref,
        float(m.qpos0[place]), slide, _law(m, dof, float(row[dof])),
        _range(m.jnt_limited[index] and not disabled(m, 'LIMIT', 'CONSTRAINT'),
               m.jnt_range[index]),
        _range(m.jnt_actfrclimited[index], m.jnt_actfrcrange[index]))


def _range(limited: Any, values: Any) -> tuple[float, float]:
    return (float(values[0]), float(values[1])) if limited else NO_LIMIT


def _law(m: Any, dof: int, inertia: float) -> FrictionLaw:
    """Return the law of frictionloss of a degree of freedom with an inertia (kg m^2)."""
    solref, solimp = m.dof_solref[dof].tolist(), m.dof_solimp[dof].tolist()
    if solref[0] > 0.0 and disabled(m, 'REFSAFE'):
        solref = [-1.0, -2.0 / solref[0]]  # as it is, also where the timestep is long
    law = FrictionLaw('mujoco', (solref[0], solref[1]), (solimp[0], solimp[1]))
    if enabled(m, 'DIAGEXACT'):
        return law
    # MuJoCo scales by the inverse inertia in the posture qpos0.
    softness = law.softness * float(m.dof_invweight0[dof]) * inertia
    return replace(law, solimp=(1.0 / (1.0 + softness), solimp[1]))


def _tendons(m: Any, joints: Sequence[int]) -> list[MjcfTendon]:
    """Return the fixed tendons between two joints."""
    mujoco = mujoco_module()
    tendons: list[MjcfTendon] = []
    for i in range(m.ntendon):
        rows = slice(m.tendon_adr[i], m.tendon_adr[i] + m.tendon_num[i])
        if set(m.wrap_objid[rows]) != set(joints) or any(
                m.wrap_type[rows] != int(mujoco.mjtWrap.mjWRAP_JOINT)):
            continue
        sign = dict(zip(m.wrap_objid[rows], m.wrap_prm[rows]))
        if sign[joints[0]] not in (-1.0, 1.0) or sign[joints[1]] != -sign[joints[0]]:
            continue
        name = m.tendon(i).name
        low, high = map(float, m.tendon_lengthspring[i])
        square, cube = map(float, m.tendon_stiffnesspoly[i])
        tendons.append(MjcfTendon(
            name, i, float(sign[joints[0]]), low, high,
            (float(m.tendon_stiffness[i]), square, cube), float(m.tendon_damping[i]),
            float(m.tendon_springyield[i])))
    return tendons


def _chosen(m: Any, joint: int, document: XmlDocument, name: str | None
            ) -> tuple[ActuatorLaw | None, list[ActuatorLaw]]:
    """Return the actuator that drives a joint, and the laws of the others on it."""
    label, where = name_of(m, 'joint', joint), document.name
    if document.root.tag == 'robot':
        return None, []  # a <transmission> lies before what joint_states hold
    names = {i: m.actuator(i).name for i in actuators_on(m, joint) if m.actuator_ctrlnum[i] > 0}
    own = [i for i, word in names.items() if name in (None, word)]
    if name is not None and not own:
        raise InputError(f'{where}: actuator: {name!r} does not act on joint {label}')
    if len(own) > 1:
        raise InputError(f'{where}: joint {label}: has the actuators '
                         f'{", ".join(word or "None" for word in names.values())}, expected one '
                         'chosen with --actuator')
    laws = [_law_of(m, i) for i in actuators_on(m, joint) if i not in own]
    return (_law_of(m, own[0]) if own else None, [law for law in laws if law is not None])


def _law_of(m: Any, i: int) -> ActuatorLaw | None:
    """Return the law of an actuator, None where it is not read, which undecided() names."""
    try:
        return actuator_law(m, i)
    except Unread:
        return None


def _passive(m: Any, joints: Sequence[int], tendon: MjcfTendon | None
             ) -> list[tuple[Passive, int]]:
    """Return the torques of actuators without control, and of what a motor has beside its own."""
    mujoco, out = mujoco_module(), []
    places = dict(zip(joints, (MOTOR, ARM)))
    for i in range(len(m.actuator_trntype)):
        if is_off(m, i) or m.actuator_gaintype[i] != int(mujoco.mjtGain.mjGAIN_DCMOTOR):
            continue
        kind, target = int(m.actuator_trntype[i]), int(m.actuator_trnid[i, 0])
        where = places.get(target) if kind == int(mujoco.mjtTrn.mjTRN_JOINT) else None
        if tendon is not None and kind == int(mujoco.mjtTrn.mjTRN_TENDON) and (
                target == tendon.index):
            where = TENDON
        law = _law_of(m, i) if where is not None else None
        if where is None or law is None:
            continue
        if law.lugre:
            out.append((Passive(where, LUGRE, law.lugre), i))
        if law.cogging:
            # A constant torque is one of the arm; where both are one joint, too.
            place = where if law.cogging[1] else ARM
            out.append((Passive(place, COGGING, law.cogging), i))
    return out


def _remarks(m: Any, motor: MjcfJoint, own: ActuatorLaw | None, laws: Sequence[ActuatorLaw],
             path: Path) -> list[str]:
    """Return notes for people about what was taken for granted of a joint."""
    where, notes = f'{path.name}: joint {motor.name}', []
    if not np.any(m.actuator_ctrlnum[actuators_on(m, motor.index)]):
        notes.append(f'{where}: no actuator acts on it: efforts count as torques on the joint')
    elif own is not None and own.speed:
        notes.append(f'{where}: actuator {own.name}: its control is read as the effort, which '
                     f'makes {own.gain:g} N m before the gear, and its damping as viscous '
                     'friction')
    for law in laws:
        if not law.passive:
            notes.append(f'{where}: actuator {law.name}: its control counts as 0')
    return notes


# ---------------------------------------------------------------------- what is refused of a drive


def _lacking(file: RobotFile, joint: MjcfJoint) -> tuple[Refusal, ...]:
    """Refuse a `joint` of a URDF that moves no mass, or a tensor of no body that matters to it."""
    root = file.document.root
    if root.tag != 'robot':
        return ()
    masses = {link.attributes.get('name', ''): float(mass.attributes.get('value', 0))
              for link in root.all('link') for inertial in link.all('inertial')
              for mass in inertial.all('mass')}
    below, child_of = dict[str, list[str]](), dict[str, str]()
    for element in root.all('joint'):
        parent, child = (element.all(tag)[0].attributes['link'] for tag in ('parent', 'child'))
        below.setdefault(parent, []).append(child)
        child_of[element.attributes.get('name', '')] = child
    if joint.name not in child_of:  # MuJoCo makes several of it
        return (Refusal(joint.name, 'type', 'planar, expected revolute, continuous or prismatic'),)
    moved = [child_of[joint.name]]
    for link in moved:
        moved += below.get(link, [])
    for link in moved:
        if masses.get(link, 0.0) < 0.0:
            return (Refusal(joint.name, 'inertia', f'link {link}: mass {masses[link]:g} kg, '
                            'expected 0 or more'),)
    if not any(masses.get(link) for link in moved):
        return (Refusal(joint.name, 'inertia', f'{", ".join(moved)}: no mass, expected an '
                        '<inertial> in one of these links'),)
    limit = SPOILT * (joint.inertia + joint.armature)
    return tuple(Refusal(joint.name, 'inertia', f'link {link}: a tensor of no body, off by '
                         f'{file.spoilt[link]:.3g} kg m^2, expected principal inertias above 0, '
                         'none above the sum of the others')
                 for link in moved if file.spoilt.get(link, 0.0) > limit)


def _of_drive(drive: MjcfDrive) -> list[Refusal]:
    """Return what a drive of one or two joints has and its model cannot have."""
    m, motor, arm, law = drive.compiled, drive.motor, drive.arm, drive.actuator
    refusals: list[Refusal] = []

    def add(attribute: str, words: str, joint: MjcfJoint = motor) -> None:
        refusals.append(Refusal(joint.name, attribute, words))
    if motor.inertia + motor.armature <= 1e-12:
        add('inertia', f'{motor.inertia + motor.armature:.3g}: it moves nothing, expected a body '
            'with mass, or armature')
    if law is not None:
        _of_law(drive, law, add)
    if arm is not None and arm.stiffness:
        add('stiffness', f'{arm.stiffness:g} on the joint of the arm, expected 0', arm)
    if arm is not None and np.any(m.actuator_ctrlnum[actuators_on(m, arm.index)]):
        add('actuator', 'drives the joint of the arm, expected none there', arm)
    if m.jnt_actgravcomp[motor.index] and m.jnt_actfrclimited[motor.index]:
        add('actgravcomp', 'with a limit of the actuator force, expected one of both')
    for passive, _ in drive.passive:
        low, high = ORDERS
        if passive.kind == COGGING and passive.where != ARM and not (
                low <= passive.numbers[1] <= high and passive.numbers[1] % 1.0 == 0.0):
            add(COGGING, f'{passive.numbers[1]:g} waves in a turn, expected a whole number of '
                f'{low} to {high}')
        if passive.kind == COGGING and passive.where == TENDON:
            add(COGGING, 'on the tendon, expected none')
        if passive.kind == LUGRE and passive.where == ARM:
            add(LUGRE, 'on the joint of the arm, expected it on that of the motor', arm or motor)
        if passive.kind == LUGRE and passive.where == MOTOR and motor.frictionloss:
            add(LUGRE, f'beside frictionloss {motor.frictionloss:g}, expected one of both')
    kinds = [(p.where, p.kind) for p, _ in drive.passive if p.where != ARM]
    if len(set(kinds)) < len(kinds):
        add('dcmotor', 'several with cogging or lugre, expected one of each')
    return refusals


def _of_law(drive: MjcfDrive, law: ActuatorLaw, add: Any) -> None:
    """Call add(attribute, words) with what the law of an actuator has and a model cannot have."""
    motor, part = drive.motor, f'actuator {law.name}'
    force = _within(law.force, motor.force)
    low, high = force[0] - law.constant, force[1] - law.constant
    if not _symmetric(low, high):
        add(f'{part}: forcerange', f'{force[0]:g} {force[1]:g} N m on the joint, expected limits '
            'alike in both directions')
    elif math.isfinite(high) and high <= 0.0:
        add(f'{part}: forcerange', f'{high:g} N m, expected a range around 0')
    if law.setpoint:
        return
    if not _symmetric(*law.control):
        add(f'{part}: ctrlrange', f'{law.control[0]:g} {law.control[1]:g}, expected limits alike '
            'in both directions')
    if law.damper and math.isfinite(high):
        add(f'{part}: forcerange', f'{high:g} N m takes in its damping ({law.damper:g} N m '
            's/rad), expected no limit')
    reach = abs(law.gear) * law.gain * law.control[1]
    if law.lag and high < reach * (1.0 - SAME):
        add(f'{part}: forcerange', f'{high:g} N m behind a lag, expected ctrlrange')
    euler = drive.compiled.opt.integrator == int(mujoco_module().mjtIntegrator.mjINT_EULER)
    if euler and law.damper * drive.timestep > DRAG * (motor.inertia + motor.armature):
        add(f'{part}: kv', f'{law.damper:g} N m s/rad in Euler steps of {drive.timestep:g} s, '
            'expected the integrator implicitfast')


def _within(*ranges: tuple[float, float]) -> tuple[float, float]:
    return max(low for low, _ in ranges), min(high for _, high in ranges)


def _symmetric(low: float, high: float) -> bool:
    if math.isinf(low) or math.isinf(high):
        return math.isinf(low) and math.isinf(high)
    return abs(low + high) <= SAME * max(abs(low), abs(high))


# ---------------------------------------------------------------------- as values of a model


def load_over_position(drive: MjcfDrive, joint: MjcfJoint) -> Array:
    """
    Return the weight on a joint: N m at the positions 0, 90, 180 and 270 degrees [4].

    Args:
        drive: in its posture.
        joint: motor or arm.
    """
    mujoco, m = mujoco_module(), drive.compiled
    state, dof = mujoco.MjData(m), m.jnt_dofadr[joint.index]
    loads = []
    compensated = not (m.jnt_actgravcomp[joint.index] and disabled(m, 'ACTUATION'))
    for quarter in range(4):
        state.qpos[:] = drive.posture
        state.qpos[m.jnt_qposadr[joint.index]] = 0.5 * math.pi * quarter
        mujoco.mj_forward(m, state)
        loads.append(float(state.qfrc_bias[dof]
                           - (state.qfrc_gravcomp[dof] if compensated else 0.0)))
    return np.array(loads)


def weight(drive: MjcfDrive) -> complex:
    """
    Return the weight on the arm's joint of `drive`, a load G sin(x2 + phi), as G e^(j phi), N m.

    x2 is the position that the joint reads.
    """
    if drive.arm_joint.slide:
        return 0j
    loads = load_over_position(drive, drive.arm_joint)
    return complex(loads[1] - loads[3], loads[0] - loads[2]) / 2.0


def values_in(drive: MjcfDrive) -> MjcfValues:
    """
    Return what a drive in a file does, in the quantities in which `values_of` has a model.

    Args:
        drive: in the file; what it has and no model can is its refusals().
    """
    motor, arm, law = drive.motor, drive.arm, drive.actuator
    whole, limit = motor.inertia + motor.armature, _limit(drive, law)
    values = MjcfValues(
        motor.armature, motor.inertia, motor.damping, 0.0, motor.frictionloss, 0.0,
        (100.0, 100.0), drive.friction_law, motor.stiffness, weight(drive), arm is None,
        0.0, 0.0, 0.0, offset=motor.constant, limit=limit,
        passive=tuple(p for p, _ in drive.passive), late=_late(drive))
    mean = float(load_over_position(drive, drive.arm_joint).mean()) if motor.slide else 0.0
    if arm is not None:
        values = replace(
            values, motor_inertia=whole, arm_inertia=arm.inertia + arm.armature,
            arm_damping=arm.damping, arm_friction=arm.frictionloss,
            passive=values.passive + ((steady(-mean),) if mean else ()))
    else:
        values = replace(values, offset=values.offset - mean)
    if drive.half_of_inertia:
        values = replace(values, motor_inertia=0.5 * whole, arm_inertia=0.5 * whole)
    if law is not None:
        values = replace(values, offset=values.offset + law.constant, lag=law.lag, delay=law.delay)
        if law.setpoint:
            values = replace(values, servo=Servo(law.spring, law.damper, limit), limit=math.inf)
    if drive.hysteresis is not None:
        values = replace(values, yielding=(drive.hysteresis.stiffness[0],
                                           drive.hysteresis.springyield))
    if drive.tendon is None:
        return values
    low, high = drive.tendon.low, drive.tendon.high
    zero = -0.5 * drive.tendon.sign * (low + high)
    zero = 0.0 if abs(zero) < 1e-9 else zero
    return replace(values, stiffness=drive.tendon.stiffness[0], cubic=drive.tendon.stiffness[2],
                   half_gap=0.5 * (high - low), damping=drive.tendon.damping, zero=zero,
                   weight=weight(drive) * cmath.rect(1.0, zero))


def _limit(drive: MjcfDrive, law: ActuatorLaw | None) -> float:
    """Return the limit (N m) of the torque on the joint of the motor, beside its constant part."""
    force = _within(law.force if law else NO_LIMIT, drive.motor.force)
    high = force[1] - (law.constant if law else 0.0)
    if law is None or law.setpoint:
        return high
    return min(high, abs(law.gear) * law.gain * law.control[1])


def _late(drive: MjcfDrive) -> tuple[float, float]:
    """Return the delays (s) of the sensors of motor and arm."""
    m, kind = drive.compiled, int(mujoco_module().mjtSensor.mjSENS_JOINTPOS)
    delays = {int(m.sensor_objid[i]): float(m.sensor_delay[i]) for i in range(m.nsensor)
              if m.sensor_type[i] == kind and m.sensor_delay[i] > 0.0}
    arm = delays.get(drive.arm.index, 0.0) if drive.arm else 0.0
    return delays.get(drive.motor.index, 0.0), arm


def model_of(drive: MjcfDrive, given: Mapping[str, Any] | None = None) -> DriveModel:
    """
    Return the model of a drive in a simulator's file.

    Args:
        drive: in the file.
        given: values of a model file that the simulator's file lacks, or that replace its own. A
            transmission makes one joint that of the arm, its armature that of the motor.

    Returns:
        The DriveModel: one joint is a rigid transmission unless one is given.

    Raises:
        InputError: naming what the file lacks, or has and no model can have.

    """
    given, joint = dict(given or {}), drive.motor
    problems = drive.refusals()
    if problems:
        raise InputError(*(f'{drive.path}: joint {row.joint}: {row}' for row in problems))
    _expect_transmission(drive, given)
    values = model_values(values_in(drive))
    if drive.half_of_inertia and 'motor_inertia' in given and 'arm_inertia' not in given:
        values['arm_inertia'] = joint.inertia
    own, effects = drive.actuator, values.pop('effects')
    values |= {'axis': 'prismatic' if joint.slide else 'rotary',
               'gear_ratio': own.gear if own is not None else 1.0}
    if own is not None and not own.setpoint:
        values['torque_constant'] = own.gain
    if drive.document.root.tag == 'mujoco':
        values |= _steps(drive)
    if (given.get('driven_by') == 'position' or given.get('controller', 0) is None):
        # Torques or positions are recorded, whatever follows setpoints in the file.
        values.pop('controller', None)
        effects = [e for e in effects if not e['id'].startswith('setpoint_')]
    if given.get('driven_by') == 'position':  # whatever happens to a torque before it acts
        effects = [e for e in effects if not EFFECTS[e['id']].torque_only]
    replaced = given.get('effects') or []
    names = {e.get('id') for e in replaced if isinstance(e, dict)}
    effects = [*(e for e in effects if e['id'] not in names), *replaced]
    return model_from_dict({**values, **given, 'effects': effects},
                           f'{drive.path} with values' if given else str(drive.path))


def _steps(drive: MjcfDrive) -> dict[str, Any]:
    """Return friction law, timestep and integrator of MuJoCo. Raises InputError."""
    motor, arm, law = drive.motor, drive.arm_joint, drive.friction_law
    if motor.frictionloss and arm.frictionloss and not (
            np.allclose(motor.law.solref, arm.law.solref)
            and np.allclose(motor.law.solimp, arm.law.solimp, rtol=1e-3)):
        raise InputError(f'{drive.path}: joints {motor.name}, {arm.name}: solreffriction, '
                         'solimpfriction differ, expected one law of friction for both')
    name = kind_of(mujoco_module().mjtIntegrator, drive.compiled.opt.integrator)
    if name == 'euler' and disabled(drive.compiled, 'EULERDAMP'):
        name = 'explicit_euler'
    return {'friction_law': {'kind': law.kind, 'solref': law.solref, 'solimp': law.solimp},
            'timestep': drive.timestep, 'integrator': INTEGRATOR_OF.get(name, name)}


def _expect_transmission(drive: MjcfDrive, given: Mapping[str, Any]) -> None:
    """Raise InputError unless a tendon of two joints, or `given` values are a transmission."""
    where = f'{drive.path}: joint {drive.motor.name}'
    if drive.arm is None and 'transmission' in given:
        if drive.half_of_inertia and 'motor_inertia' not in given:
            raise InputError(f'{where}: armature: 0, expected the inertia of the motor times the '
                             'square of its gear, or motor_inertia in a file of --values')
        if 'damping' not in given:
            raise InputError(f'{where}: has no transmission, expected its damping beside '
                             'transmission in the file of --values')
    if drive.arm is None or 'transmission' in given:
        return
    tendon, names = drive.tendon, f'{drive.motor.name}, {drive.arm_joint.name}'
    if tendon is None or not tendon.stiffness[0]:
        raise InputError(f'{drive.path}: joints {names}: no '
                         'fixed tendon with stiffness holds them together, expected one with the '
                         'coefficients 1 and -1')
    m, part = drive.compiled, f'{drive.path}: tendon {tendon.name}'
    if tendon.stiffness[1]:
        raise InputError(f'{part}: stiffness: quadratic part {tendon.stiffness[1]:g}, expected 0')
    for word, value in (('damping', np.any(m.tendon_dampingpoly[tendon.index])),
                        ('frictionloss', m.tendon_frictionloss[tendon.index]),
                        ('armature', m.tendon_armature[tendon.index]),
                        ('limited', m.tendon_limited[tendon.index])):
        if value:
            raise InputError(f'{part}: {word}: acts besides the spring, expected '
                             + ('one number' if word == 'damping' else 'none'))
