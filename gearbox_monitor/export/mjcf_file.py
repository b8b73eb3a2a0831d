# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Read a drive in an MJCF, URDF or SDF file: MuJoCo compiles it, with defaults, classes and geoms.

A drive is one joint (motor and arm are rigidly coupled, the motor is its armature), or two joints
that hang on one parent: that of the motor, and that of the arm. A fixed tendon between the two is
the transmission.
"""
import cmath
from collections.abc import Mapping
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.export.sdf_file import spring_of, urdf_of
from gearbox_monitor.export.xml_edit import parse_xml, XmlDocument, XmlElement
from gearbox_monitor.files.opening import read_bytes
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.effects import arm_side, gearbox
from gearbox_monitor.plant.friction_law import FrictionLaw


INTEGRATOR_OF = {'implicit': 'implicitfast'}  # they differ by damping between joints

MAX_XML = 1 << 26  # bytes of a file


@dataclass(frozen=True)
class MjcfJoint:
    """
    A joint as MuJoCo compiles it, in SI units.

    inertia: of all that moves with it, without its armature; damping: with that of actuators;
    law: of frictionloss, with the impedance that counts in the posture.
    """

    name: str
    element: XmlElement
    index: int
    armature: float
    inertia: float
    damping: float
    actuator_damping: float
    frictionloss: float
    stiffness: float
    ref: float
    slide: bool
    law: FrictionLaw


@dataclass(frozen=True)
class MjcfTendon:
    """A fixed tendon over motor (coefficient `sign`) and arm (-`sign`)."""

    name: str
    element: XmlElement
    index: int
    sign: float
    low: float
    high: float
    stiffness: tuple[float, float, float]
    damping: float


@dataclass(frozen=True)
class MjcfActuator:
    """
    The actuator on the joint of the motor.

    gain, bias: of its force, before the gear; setpoint: it follows one, by its bias.
    """

    name: str
    element: XmlElement
    index: int
    gear: float
    gain: float
    bias: tuple[float, float, float]
    dynamics: str
    setpoint: bool


@dataclass(frozen=True)
class MjcfDrive:
    """A drive in an MJCF file; `arm` and `tendon` are None where motor and arm are one joint."""

    path: Path
    document: XmlDocument
    compiled: Any
    timestep: float
    degrees: bool
    motor: MjcfJoint
    arm: MjcfJoint | None
    tendon: MjcfTendon | None
    actuator: MjcfActuator | None
    posture: Array
    keyframe: str | None

    @property
    def arm_joint(self) -> MjcfJoint:
        """The joint that moves the arm."""
        return self.arm or self.motor


def mujoco_module() -> Any:
    """Return the module mujoco. Raises InputError where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise InputError("mujoco: not installed, expected pip install 'gearbox_monitor[mujoco]'"
                         ) from None
    return mujoco


def compiled_model(data: bytes, path: Path) -> Any:
    """
    Return what MuJoCo compiles of an MJCF file.

    Args:
        data: bytes of the file.
        path: of the file, to whose folder its meshes are relative.

    Returns:
        mujoco.MjModel.

    Raises:
        InputError: MuJoCo refuses the file.

    """
    mujoco = mujoco_module()
    try:
        spec = mujoco.MjSpec.from_string(data.decode('utf-8'), include=_included(data, path))
        spec.modelfiledir = str(path.parent)
        return spec.compile()
    except (ValueError, RuntimeError, UnicodeDecodeError) as error:
        raise InputError(f'{path}: {error}, expected a file that MuJoCo compiles') from None


def _included(data: bytes, path: Path) -> dict[str, bytes]:
    """Return {name: bytes} of the files that an MJCF file includes, relative to its folder."""
    files: dict[str, bytes] = {}
    waiting = [data]
    while waiting:
        for element in parse_xml(waiting.pop(), str(path)).root.walk():
            name = element.attributes.get('file', '') if element.tag == 'include' else ''
            if name and name not in files and (path.parent / name).is_file():
                files[name] = read_file(path.parent / name)
                waiting.append(files[name])
    return files


def read_mjcf(path: str | Path, joint: str, arm_joint: str | None = None,
              keyframe: str | None = None, actuator: str | None = None) -> MjcfDrive:
    """
    Return the drive in an MJCF file.

    Args:
        path: of the file.
        joint: name of the joint that the motor drives.
        arm_joint: name of the joint of the arm, None where it is the same.
        keyframe: posture in which inertia and weight are taken, None for that of the file.
        actuator: name of the actuator, None for the only one on the joint.

    Returns:
        The MjcfDrive.

    Raises:
        InputError: no such file, joint, keyframe or actuator, or a drive of another structure.

    """
    path = Path(path)
    return drive_of(read_file(path), path, (joint, arm_joint), keyframe, actuator)


def read_file(path: Path) -> bytes:
    """Return the bytes of the simulator's file `path`. Raises InputError."""
    try:
        return read_bytes(path, MAX_XML)
    except (OSError, ValueError) as error:
        raise InputError(f'{path}: {getattr(error, "strerror", error)}, expected a readable MJCF, '
                         'URDF or SDF file') from None


def drive_of(data: bytes, path: Path, joints: tuple[str, str | None],
             keyframe: str | None = None, actuator: str | None = None) -> MjcfDrive:
    """
    Return the drive in the bytes of an MJCF file, see read_mjcf.

    Args:
        data: bytes of the file.
        path: of the file.
        joints: names of the joints of motor and arm.
        keyframe: posture, None for that of the file.
        actuator: name of the actuator, None for the only one on the joint.

    Returns:
        The MjcfDrive.

    """
    mujoco = mujoco_module()
    document, spring = parse_xml(data, str(path)), 0.0
    if document.root.tag == 'sdf':
        spring = spring_of(document, joints[0])
        data = urdf_of(document, joints[0]).encode()
        document = parse_xml(data, str(path))
    if document.root.tag not in ('mujoco', 'robot'):
        raise InputError(f'{path}: line {document.root.line}: <{document.root.tag}>, expected '
                         '<mujoco>, <robot> of a URDF file or <sdf>')
    m = compiled_model(data, path)
    state = mujoco.MjData(m)
    if keyframe is not None:
        k = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_KEY, keyframe)
        if k < 0:
            raise InputError(f'{path}: keyframe: {keyframe!r} is not in the file')
        state.qpos[:] = m.key_qpos[k]
    mujoco.mj_forward(m, state)
    motor = _joint(document, m, state, joints[0])
    if spring:
        motor = replace(motor, stiffness=spring)
    arm = _joint(document, m, state, joints[1]) if joints[1] else None
    if arm is not None:
        parents = [m.body_parentid[m.jnt_bodyid[j.index]] for j in (motor, arm)]
        if parents[0] != parents[1] or motor.slide != arm.slide:
            raise InputError(f'{path}: line {arm.element.line}: joint {arm.name}: moves with '
                             f'{motor.name} or is of another type, expected two joints of one '
                             'type whose bodies have the same parent')
    compiler = [e for e in document.root.walk() if e.tag == 'compiler']
    degrees = all(e.attributes.get('angle', 'degree') == 'degree' for e in compiler)
    return MjcfDrive(path, document, m, float(m.opt.timestep), degrees, motor, arm,
                     _tendon(document, m, motor, arm) if arm else None,
                     _actuator(document, m, motor, actuator), state.qpos.copy(), keyframe)


def _named(document: XmlDocument, section: str, name: str, kind: str) -> XmlElement:
    """Return the element `name` in sections of the file. Raises InputError."""
    parts = [document.root] if document.root.tag == 'robot' else document.root.all(section)
    for part in parts:
        for element in part.walk():
            if element.attributes.get('name') == name and (not kind or element.tag == kind):
                return element
    included = any(e.tag == 'include' for e in document.root.walk())
    raise InputError(f'{document.name}: {kind or section}: {name!r} is not in this file'
                     + (' itself, expected it here and not in one that it includes'
                        if included else ''))


def _joint(document: XmlDocument, m: Any, state: Any, name: str) -> MjcfJoint:
    mujoco = mujoco_module()
    element = _named(document, 'worldbody', name, 'joint')
    index = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_JOINT, name)
    kinds = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    if m.jnt_type[index] not in kinds:
        raise InputError(f'{document.name}: line {element.line}: joint {name}: type, expected '
                         'hinge or slide')
    dof = m.jnt_dofadr[index]
    unit, row = np.zeros(m.nv), np.zeros(m.nv)
    unit[dof] = 1.0
    mujoco.mj_mulM(m, state, row, unit)
    own = ((m.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT))
           & (m.actuator_trnid[:, 0] == index))
    added = float(np.sum(m.actuator_damping[own] * m.actuator_gear[own, 0] ** 2))
    return MjcfJoint(
        name, element, index, float(m.dof_armature[dof]),
        float(row[dof] - m.dof_armature[dof]), float(m.dof_damping[dof]) + added, added,
        float(m.dof_frictionloss[dof]), float(m.jnt_stiffness[index]),
        float(m.qpos0[m.jnt_qposadr[index]]), bool(m.jnt_type[index] == kinds[1]),
        _law(m, dof, float(row[dof])))


def _law(m: Any, dof: int, inertia: float) -> FrictionLaw:
    """Return the law of frictionloss of a degree of freedom with an inertia (kg m^2)."""
    solref, solimp = m.dof_solref[dof].tolist(), m.dof_solimp[dof].tolist()
    if solref[0] > 0.0 and m.opt.disableflags & int(mujoco_module().mjtDisableBit.mjDSBL_REFSAFE):
        solref = [-1.0, -2.0 / solref[0]]  # as it is, also where the timestep is long
    law = FrictionLaw('mujoco', (solref[0], solref[1]), (solimp[0], solimp[1]))
    # MuJoCo scales by the inverse inertia in the posture qpos0.
    softness = law.softness * float(m.dof_invweight0[dof]) * inertia
    return replace(law, solimp=(1.0 / (1.0 + softness), solimp[1]))


def _tendon(document: XmlDocument, m: Any, motor: MjcfJoint, arm: MjcfJoint
            ) -> MjcfTendon | None:
    """Return the fixed tendon between the two joints."""
    mujoco = mujoco_module()
    for i in range(m.ntendon):
        rows = slice(m.tendon_adr[i], m.tendon_adr[i] + m.tendon_num[i])
        if set(m.wrap_objid[rows]) != {motor.index, arm.index} or any(
                m.wrap_type[rows] != int(mujoco.mjtWrap.mjWRAP_JOINT)):
            continue
        sign = dict(zip(m.wrap_objid[rows], m.wrap_prm[rows]))
        if m.tendon_springyield[i] or sign[motor.index] not in (-1.0, 1.0) or (
                sign[arm.index] != -sign[motor.index]):
            continue
        name = mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_TENDON, i)
        if not name:
            raise InputError(f'{document.name}: tendon over {motor.name} and {arm.name}: has no '
                             'name, expected one')
        low, high = map(float, m.tendon_lengthspring[i])
        square, cube = map(float, m.tendon_stiffnesspoly[i])
        return MjcfTendon(name, _named(document, 'tendon', name, 'fixed'), i,
                          float(sign[motor.index]), low, high,
                          (float(m.tendon_stiffness[i]), square, cube),
                          float(m.tendon_damping[i]))
    return None


def _actuator(document: XmlDocument, m: Any, motor: MjcfJoint, name: str | None
              ) -> MjcfActuator | None:
    if document.root.tag == 'robot':
        return _transmission_of_urdf(document, motor)
    mujoco = mujoco_module()
    own = [i for i in range(len(m.actuator_trntype))
           if m.actuator_trntype[i] == int(mujoco.mjtTrn.mjTRN_JOINT)
           and m.actuator_trnid[i, 0] == motor.index and m.actuator_ctrlnum[i] == 1]
    names = [mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_ACTUATOR, i) for i in own]
    if name is not None:
        own = [i for i, word in zip(own, names) if word == name]
        if not own:
            raise InputError(f'{document.name}: actuator: {name!r} does not act on joint '
                             f'{motor.name}')
    if len(own) > 1:
        raise InputError(f'{document.name}: joint {motor.name}: has the actuators '
                         f'{", ".join(map(str, names))}, expected one chosen with --actuator')
    if not own:
        return None
    i = own[0]
    elements = [e for part in document.root.all('actuator') for e in part.walk()
                if e.attributes.get('joint') == motor.name
                and e.attributes.get('input') != 'none'
                and (name is None or e.attributes.get('name') == name)]
    if not elements:
        raise InputError(f'{document.name}: the actuator of joint {motor.name} is not in this '
                         'file itself, expected it here and not in one that it includes')
    element = elements[0]
    fixed = m.actuator_gaintype[i] == int(mujoco.mjtGain.mjGAIN_FIXED)
    affine = m.actuator_biastype[i] == int(mujoco.mjtBias.mjBIAS_AFFINE)
    bias = tuple(map(float, m.actuator_biasprm[i, :3])) if affine else (0.0, 0.0, 0.0)
    return MjcfActuator(
        element.attributes.get('name', ''), element, i, float(m.actuator_gear[i, 0]),
        float(m.actuator_gainprm[i, 0]), bias,  # type: ignore[arg-type]
        mujoco.mjtDyn(m.actuator_dyntype[i]).name.removeprefix('mjDYN_').lower(),
        not fixed or bool(bias[1] or bias[2]))


def _transmission_of_urdf(document: XmlDocument, motor: MjcfJoint) -> MjcfActuator | None:
    """Return the transmission of a joint in a URDF file; its reduction is the gear."""
    for element in document.root.all('transmission'):
        for part in element.walk():
            reductions = part.all('mechanicalReduction')
            if reductions and any(joint.attributes.get('name') == motor.name
                                  for joint in element.all('joint')):
                tag = reductions[0]
                text = document.text(tag)
                try:
                    gear = float(text)
                except ValueError:
                    raise InputError(f'{document.name}: line {tag.line}: mechanicalReduction: '
                                     f'{text!r}, expected a number') from None
                return MjcfActuator(motor.name, element, -1, gear, 1.0, (0.0, 0.0, 0.0), 'none',
                                    False)
    return None


def weight(drive: MjcfDrive) -> complex:
    """
    Return the weight on the arm's joint of `drive`, a load G sin(x2 + phi), as G e^(j phi), N m.

    x2 is the position that the joint reads.
    """
    mujoco = mujoco_module()
    m, joint = drive.compiled, drive.arm_joint
    if joint.slide:
        return 0j
    state = mujoco.MjData(m)
    loads = []
    for angle in (0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi):
        state.qpos[:] = drive.posture
        state.qpos[m.jnt_qposadr[joint.index]] = angle
        mujoco.mj_forward(m, state)
        loads.append(float(state.qfrc_bias[m.jnt_dofadr[joint.index]]))
    return complex(loads[1] - loads[3], loads[0] - loads[2]) / 2.0


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
        InputError: naming what the file lacks.

    """
    given, joint = dict(given or {}), drive.motor
    actuator, where = drive.actuator, f'{drive.path}: joint {joint.name}'
    values: dict[str, Any] = {
        'viscous_friction': joint.damping, 'coulomb_friction': joint.frictionloss,
        'position_gain': joint.stiffness, 'axis': 'prismatic' if joint.slide else 'rotary'}
    if drive.document.root.tag == 'mujoco':
        values |= _steps(drive)
    effects: list[dict[str, Any]] = []
    if actuator is not None:
        values['gear_ratio'] = actuator.gear * (1.0 if actuator.setpoint else actuator.gain)
        values['torque_offset'] = actuator.gear * actuator.bias[0]
    elif 'gear_ratio' not in given:
        raise InputError(f'{where}: no actuator acts on it, expected one, or gear_ratio in a file '
                         'of --values')
    if drive.arm is None:
        values |= {'motor_inertia': joint.armature, 'arm_inertia': joint.inertia,
                   'transmission': {'kind': 'rigid'}}
        if joint.armature <= 0.0 and 'motor_inertia' not in given:
            raise InputError(f'{where}: armature: 0, expected the inertia of the motor times the '
                             'square of its gear, or motor_inertia in a file of --values')
        if 'transmission' in given and 'damping' not in given:
            raise InputError(f'{where}: has no transmission, expected its damping beside '
                             'transmission in the file of --values')
    else:
        values |= {'motor_inertia': joint.armature + joint.inertia,
                   'arm_inertia': drive.arm.armature + drive.arm.inertia,
                   'damping': drive.tendon.damping if drive.tendon else 0.0}
        if 'transmission' not in given:
            values['transmission'] = _transmission(drive)
        effects += [{'id': name, key: value} for name, key, value in (
            (arm_side.ARM_VISCOUS.id, 'Cav', drive.arm.damping),
            (arm_side.ARM_COULOMB.id, 'Cac', drive.arm.frictionloss)) if value]
        if drive.tendon and drive.tendon.stiffness[2]:
            effects.append({'id': gearbox.HARDENING.id, 'K3': drive.tendon.stiffness[2]})
    replaced = given.get('effects') or []
    own = {e.get('id') for e in replaced if isinstance(e, dict)}
    load = weight(drive)
    if abs(load.imag) > 1e-6 * abs(load.real) + 1e-9:
        effects.append({'id': arm_side.GRAVITY.id, 'G': abs(load), 'phi': cmath.phase(load)})
    elif abs(load.real) > 1e-9:
        effects.append({'id': arm_side.GRAVITY.id, 'G': load.real})
    effects = [*(e for e in effects if e['id'] not in own), *replaced]
    return model_from_dict({**values, **given, 'effects': effects}, str(drive.path))


def _steps(drive: MjcfDrive) -> dict[str, Any]:
    """Return friction law, timestep and integrator of MuJoCo. Raises InputError."""
    motor, arm = drive.motor, drive.arm_joint
    law = motor.law if motor.frictionloss or not arm.frictionloss else arm.law
    if motor.frictionloss and arm.frictionloss and not (
            np.allclose(motor.law.solref, arm.law.solref)
            and np.allclose(motor.law.solimp, arm.law.solimp, rtol=1e-3)):
        raise InputError(f'{drive.path}: joints {motor.name}, {arm.name}: solreffriction, '
                         'solimpfriction differ, expected one law of friction for both')
    integrator = mujoco_module().mjtIntegrator(drive.compiled.opt.integrator).name
    name = integrator.removeprefix('mjINT_').lower()
    return {'friction_law': {'kind': law.kind, 'solref': law.solref, 'solimp': law.solimp},
            'timestep': drive.timestep, 'integrator': INTEGRATOR_OF.get(name, name)}


def _transmission(drive: MjcfDrive) -> dict[str, Any]:
    """Return {field of Transmission: value} of the tendon of `drive`. Raises InputError."""
    tendon = drive.tendon
    if tendon is None or not tendon.stiffness[0]:
        raise InputError(f'{drive.path}: joints {drive.motor.name}, {drive.arm_joint.name}: no '
                         'fixed tendon with stiffness holds them together, expected one with the '
                         'coefficients 1 and -1')
    if tendon.stiffness[1]:
        raise InputError(f'{drive.path}: line {tendon.element.line}: tendon {tendon.name}: '
                         f'stiffness: quadratic part {tendon.stiffness[1]:g}, expected 0')
    gap = 0.5 * (tendon.high - tendon.low)
    if abs(tendon.high + tendon.low) > 1e-9:
        raise InputError(f'{drive.path}: line {tendon.element.line}: tendon {tendon.name}: '
                         f'springlength: {tendon.low:g} {tendon.high:g}, expected -b b')
    return {'kind': 'dead_zone', 'stiffness': tendon.stiffness[0], 'half_gap': gap}
