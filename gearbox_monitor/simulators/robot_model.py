# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Read a whole robot in a simulator's file: a URDF by itself, an MJCF as MuJoCo compiles it.

An open chain of hinges and slides on a fixed base, or a drive in a model file. What is none is
refused by name.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import load_model
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.robot.chain import Chain, chain_of, inertial, Link, PER_LINK
from gearbox_monitor.robot.compiled_model import (
    actuator_law, actuator_losses, actuators_on, at_rest, disabled, ends_of, implausible_limits,
    implausible_links, implausible_ranges, mujoco_module, name_of, scalar_joints, tendon_forces,
    undecided_of_robot, Unread)
from gearbox_monitor.robot.description import LOCKED_IN_VALUES, parse
from gearbox_monitor.robot.dynamics import GRAVITY
from gearbox_monitor.simulators.compiling import compiled_model
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.xml_edit import parse_xml


@dataclass(frozen=True, eq=False)
class ChainFile:
    """
    A robot in a file.

    chain: its balance; kp N m/rad, kd N m s/rad [J] of its position actuators, None where a joint
    has none, and no_servo says which; unread: joints that move no mass, which the chain has not;
    digest: hash of the file and of `locked`; compiled: mujoco.MjModel of an MJCF, None of a URDF;
    root: folder of files that an MJCF names, None for its own; locked {joint: position, rad or m}:
    joints that stand still, which the chain has not. low, high [J]: ends of the range of each
    joint, rad or m, infinite where the file states none. doubts: values that cannot be true.
    drive: of a model file, None for a robot.
    """

    path: Path
    chain: Chain
    kp: Array | None
    kd: Array | None
    digest: str
    compiled: Any = None
    root: Path | None = None
    no_servo: str = ''
    locked: Mapping[str, float] = field(default_factory=dict)
    low: Array = field(default_factory=lambda: np.array([-math.inf]))
    high: Array = field(default_factory=lambda: np.array([math.inf]))
    unread: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    drive: DriveModel | None = None


MODEL_FILES = ('.yaml', '.yml')  # of drives


def read_robot(path: str | Path, root: str | Path | None = None,
               locked: Mapping[str, float] | None = None) -> ChainFile:
    """
    Return a robot's file.

    Args:
        path: of an MJCF or URDF, or of the model of a drive.
        root: folder below which the files lie that an MJCF names, None for its own folder.
        locked: {joint that stands still: its position, rad or m}.

    Returns:
        The ChainFile.

    Raises:
        InputError: it is neither, or no open chain.
    """
    path, locked = Path(path), dict(sorted((locked or {}).items()))
    data = read_file(path)
    if path.suffix.lower() in MODEL_FILES:
        return _of_drive(path, hashlib.sha256(data).hexdigest())
    digest = hashlib.sha256(data + (json.dumps(locked).encode() if locked else b'')).hexdigest()
    element = parse_xml(data, str(path)).root
    if element.tag == 'robot':
        if root is not None:
            raise InputError(f'--root: {root}: of a URDF no other file is read, expected it with '
                             'an MJCF')
        text = data.decode('utf-8', 'replace')
        description = parse(text, str(path), locked, whole=True)
        chain, (low, high) = chain_of(description), description.ranges.T
        unread = tuple(joint.attributes.get('name', '') for joint in element.all('joint')
                       if joint.attributes.get('type') != 'fixed' and not joint.all('mimic'))
        return ChainFile(path, chain, None, None, digest, no_servo='a URDF has no actuators',
                         locked=locked, low=low, high=high, unread=tuple(
                             name for name in unread if name not in (*chain.joints, *locked)),
                         doubts=(
                             *implausible_links(chain.links),
                             *implausible_limits(text, str(path))))
    if element.tag != 'mujoco':
        raise InputError(f'{path}: line {element.line}: <{element.tag}>, expected <mujoco> or '
                         '<robot> of a URDF file')
    folder = Path(root) if root else None
    m = compiled_model(data, path, folder, locked)
    _refuse(m, path)
    kp, kd, missing = servo_of(m)
    limited = m.jnt_limited.astype(bool)
    chain = chain_of_compiled(m, path)
    return ChainFile(path, chain, kp, kd, digest, m, folder, missing, locked,
                     np.where(limited, m.jnt_range[:, 0], -math.inf),
                     np.where(limited, m.jnt_range[:, 1], math.inf),
                     doubts=(*implausible_links(chain.links), *implausible_ranges(m)))


def _of_drive(path: Path, digest: str) -> ChainFile:
    """Return the drive of a model file as a link without mass, whose inertia is its joint's."""
    drive = load_model(path).folded()
    servo = drive.controller
    if servo is not None and (servo.ki or servo.feedforward or servo.feedforward_inertia):
        raise InputError(f'{path}: controller: ki or feedforward, expected kp and kd alone in a '
                         'model that is compared with a reference')
    (weight, phase), gravity = weight_of(drive.effects), float(np.linalg.norm(GRAVITY))
    theta = np.zeros(PER_LINK)
    theta[1:3] = weight / gravity * np.array([math.cos(phase), math.sin(phase)])
    slides = drive.axis == 'prismatic'
    axis = np.array([0.0, 1.0, 0.0] if slides else [0.0, 0.0, 1.0])
    chain = Chain(
        (Link('drive', 'motor', -1, np.eye(3), np.zeros(3), axis, slides, theta),),
        np.array([drive.motor_inertia + drive.arm_inertia]), np.array([drive.viscous_friction]),
        np.array([drive.coulomb_friction]), np.array([gravity, 0.0, 0.0]),
        spring=np.array([drive.position_gain]))
    return ChainFile(
        path, chain, None if servo is None else np.array([servo.kp]),
        None if servo is None else np.array([servo.kd]), digest,
        no_servo='the model has no controller', drive=drive)


def _refuse(m: Any, path: Path) -> None:
    """Raise InputError for what the balance of an open chain does not hold."""
    mujoco = mujoco_module()
    for i in sorted(set(range(m.njnt)) - set(scalar_joints(m))):
        name = m.joint(i).name or m.body(m.jnt_bodyid[i]).name
        raise InputError(f'{path}: joint {name}: free or ball joint, expected hinges and slides '
                         f'on a fixed base, {LOCKED_IN_VALUES}')
    for i in range(m.neq):
        if m.eq_active0[i] and not (disabled(m, 'EQUALITY', 'CONSTRAINT') or _is_rigid(m, i)):
            name = m.equality(i).name or f'equality {i + 1}'
            ends = [int(m.eq_obj1id[i]), int(m.eq_obj2id[i])]
            tied = ', '.join(name_of(m, 'joint', j) for j in ends if j >= 0) if int(
                m.eq_type[i]) == mujoco.mjtEq.mjEQ_JOINT else 'or closes the chain'
            raise InputError(f'{path}: {name}: an active equality couples {tied}, '
                             f'expected an open chain of independent joints, {LOCKED_IN_VALUES}')
    for i in range(m.ntendon):
        acts = tendon_forces(m, i)
        if np.any((m.actuator_trntype == int(mujoco.mjtTrn.mjTRN_TENDON))
                  & (m.actuator_trnid[:, 0] == i)):
            acts.append('actuator')
        if acts:
            wraps = range(int(m.tendon_adr[i]), int(m.tendon_adr[i] + m.tendon_num[i]))
            tied = ', '.join(name_of(m, 'joint', int(m.wrap_objid[w])) for w in wraps
                             if int(m.wrap_type[w]) == mujoco.mjtWrap.mjWRAP_JOINT)
            raise InputError(f'{path}: tendon {name_of(m, "tendon", i)}: {", ".join(acts)}: '
                             f'couples {tied or "joints"}, expected an open chain of independent '
                             f'joints, {LOCKED_IN_VALUES}')
    joints: dict[str, list[str]] = {}   # one line for what acts on several joints alike
    for refusal in undecided_of_robot(m):
        joints.setdefault(str(refusal), []).append(refusal.joint)
    if joints:
        raise InputError(*(f'{path}: joint {", ".join(dict.fromkeys(names))}: {words}'
                           for words, names in joints.items()))
    if np.any(m.body_gravcomp):
        body = name_of(m, 'body', int(np.flatnonzero(m.body_gravcomp)[0]))
        raise InputError(f'{path}: body {body}: gravcomp, expected weights that the joints carry; '
                         'leave it out: the recorded torque holds what compensates them')


def _is_rigid(m: Any, equality: int) -> bool:
    """Return whether an equality ties two bodies that do not move against each other."""
    mujoco = mujoco_module()
    if int(m.eq_type[equality]) not in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
        return False
    first, second = m.body_weldid[list(ends_of(m, equality))]
    return bool(first == second)


def servo_of(m: Any) -> tuple[Array | None, Array | None, str]:
    """Return kp and kd [J] of the position actuators of `m`, or why setpoints are no torques."""
    kp, kd = np.zeros(m.njnt), np.zeros(m.njnt)
    for joint in range(m.njnt):
        name, laws = name_of(m, 'joint', joint), []
        for i in actuators_on(m, joint):
            try:
                laws.append(actuator_law(m, i))
            except Unread as problem:
                return None, None, (f'actuator {name_of(m, "actuator", i)}: {problem.attribute}: '
                                    f'{problem.words}')
        odd = next((law for law in laws if not law.setpoint or law.constant), None)
        if odd is not None or not laws:
            drive = f'actuator {name_of(m, "actuator", odd.index)}' if odd else 'no actuator'
            return None, None, f'joint {name}: {drive}, expected a position actuator'
        kp[joint] = sum(law.spring for law in laws)
        kd[joint] = sum(law.damper for law in laws)
    return kp, kd, ''


def links_of_compiled(m: Any) -> tuple[Link, ...]:
    """
    Return the links of a model `m` that MuJoCo compiled, one of each joint.

    Bodies that are welded to another one belong to its link. A link's frame is its joint's, in the
    posture qpos0.
    """
    mujoco = mujoco_module()
    state = at_rest(m)
    of_body = {0: -1}                       # body -> link that carries it
    frames: list[tuple[Array, Array]] = []  # rotation and origin of links in the world
    rows: list[dict[str, Any]] = []
    theta = np.zeros((m.njnt, PER_LINK))
    for b in range(1, m.nbody):
        parent, turn = of_body[int(m.body_parentid[b])], state.xmat[b].reshape(3, 3)
        for i in range(int(m.body_jntadr[b]), int(m.body_jntadr[b] + m.body_jntnum[b])):
            base, at = frames[parent] if parent >= 0 else (np.eye(3), np.zeros(3))
            anchor = state.xanchor[i]
            rows.append({
                'name': m.body(b).name or f'body{b}', 'joint': m.joint(i).name or f'joint{i}',
                'parent': parent, 'rotation': base.T @ turn, 'origin': base.T @ (anchor - at),
                'axis': turn.T @ state.xaxis[i],
                'slides': bool(m.jnt_type[i] != int(mujoco.mjtJoint.mjJNT_HINGE))})
            frames.append((turn.copy(), anchor.copy()))
            parent = len(rows) - 1
        of_body[b] = parent
        if parent >= 0 and m.body_mass[b] > 0.0:
            base, at = frames[parent]
            axes = base.T @ state.ximat[b].reshape(3, 3)
            theta[parent] += inertial(float(m.body_mass[b]), base.T @ (state.xipos[b] - at),
                                      axes @ np.diag(m.body_inertia[b]) @ axes.T)
    return tuple(Link(**row, theta=x) for row, x in zip(rows, theta))


def chain_of_compiled(m: Any, path: Path) -> Chain:
    """
    Return the Chain of a model that MuJoCo compiled.

    Args:
        m: mujoco.MjModel of hinges and slides.
        path: of its file, for messages.
    """
    if m.njnt == 0:
        raise InputError(f'{path}: no joint, expected at least one hinge or slide')
    losses = np.array([actuator_losses(m, joint) for joint in range(m.njnt)])
    damping = np.where(disabled(m, 'DAMPER'), 0.0, m.dof_damping) + losses[:, 1]
    friction = np.where(disabled(m, 'FRICTIONLOSS', 'CONSTRAINT'), 0.0, m.dof_frictionloss)
    spring = np.where(disabled(m, 'SPRING'), 0.0, m.jnt_stiffness)
    gravity = np.zeros(3) if disabled(m, 'GRAVITY') else np.array(m.opt.gravity)
    return Chain(links_of_compiled(m), m.dof_armature + losses[:, 0], damping, friction, gravity,
                 np.array(m.qpos0), spring, np.array(m.qpos_spring))
