# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
What acts on joints in a model that MuJoCo has compiled: all of it is decided about, by name.

Each array of mujoco.MjModel is read (it becomes a value of a joint or of its actuator), refused
where it acts on the joint and is not its default, or irrelevant for the motion. `undecided` lists
what is refused; `actuator_law` reads an actuator.
"""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.kernels.types import Array, Flags

READ, REFUSED, IRRELEVANT = KINDS = ('read', 'refused', 'irrelevant')
SAME = 1e-9        # relative: what differs by less is equal
LINE_SEARCH = 10   # steps; fewer stop before frictionloss holds: off by mrad (robot_files.py)
DRAG = 1e-3        # largest share of an inertia that a timestep of explicit damping may be
WITHOUT_STATE = 0  # activations of an actuator


class Refusal(NamedTuple):
    """What acts on a `joint` (its name) and is not read: the attribute, and what to do."""

    joint: str
    attribute: str
    words: str

    def __str__(self) -> str:
        return f'{self.attribute}: {self.words}'


class ArrayTreatment(NamedTuple):
    """What becomes of an array of MjModel, or of an option: its kind and the reason."""

    kind: str
    reason: str


def _decided(kind: str, reason: str, names: str) -> dict[str, ArrayTreatment]:
    return {name: ArrayTreatment(kind, reason) for name in names.split()}


# ---------------------------------------------------------------------- the table


DECISIONS: dict[str, ArrayTreatment] = {
    # joints
    **_decided(READ, 'inertia, place and axis of what moves, through the inertia matrix', (
        'jnt_pos jnt_axis body_pos body_quat body_ipos body_iquat body_mass body_inertia '
        'dof_M0 dof_invweight0 body_invweight0 body_subtreemass')),
    **_decided(READ, 'armature: inertia of the motor', 'dof_armature actuator_armature'),
    **_decided(READ, 'weight: force of gravity over the position', 'body_gravcomp '
               'jnt_actgravcomp ngravcomp flg_gravcomp opt.gravity'),
    **_decided(READ, 'spring to the ground', 'jnt_stiffness qpos_spring'),
    **_decided(READ, 'viscous friction', 'dof_damping actuator_damping'),
    **_decided(READ, 'Coulomb friction and its law', 'dof_frictionloss dof_solref dof_solimp'),
    **_decided(READ, 'positions', 'jnt_qposadr jnt_dofadr jnt_bodyid qpos0 key_qpos nkey '
               'dof_bodyid dof_jntid dof_parentid body_parentid body_jntadr body_jntnum '
               'body_dofadr body_dofnum body_rootid body_treeid body_weldid'),
    **_decided(READ, 'range that a recording has to keep to', 'jnt_limited jnt_range'),
    **_decided(READ, 'limit of the torque', 'jnt_actfrclimited jnt_actfrcrange'),
    **_decided(REFUSED, 'hinge and slide are read', 'jnt_type'),
    **_decided(REFUSED, 'terms of higher order', 'jnt_stiffnesspoly dof_dampingpoly '
               'actuator_dampingpoly'),
    **_decided(REFUSED, 'a spring that yields', 'jnt_springyield'),
    **_decided(IRRELEVANT, 'state of springs that yield, which are refused', 'jnt_plasticadr '
               'tendon_plasticadr nplastic key_plastic'),
    **_decided(IRRELEVANT, 'how hard an end stop is: a recording keeps clear of it', 'jnt_solref '
               'jnt_solimp jnt_margin'),
    **_decided(IRRELEVANT, 'sleep and scale of angles, which moves nothing', 'dof_length '
               'tree_sleep_policy'),
    # actuators
    **_decided(READ, 'actuator: its force, limits, lag and delay', (
        'actuator_trntype actuator_trnid actuator_dyntype actuator_gaintype actuator_biastype '
        'actuator_dynprm actuator_gainprm actuator_biasprm actuator_gear actuator_ctrllimited '
        'actuator_ctrlrange actuator_forcelimited actuator_forcerange actuator_delay '
        'actuator_history actuator_ctrlnum actuator_ctrladr actuator_ctrlspec actuator_actnum '
        'actuator_outadr actuator_outnum actuator_group opt.disableactuator jnt_actuatorid')),
    **_decided(REFUSED, 'activations with limits, or that act early', 'actuator_actlimited '
               'actuator_actrange actuator_actearly'),
    **_decided(REFUSED, 'plug-ins', 'actuator_plugin body_plugin plugin nplugin'),
    **_decided(IRRELEVANT, 'of transmissions that are refused', 'actuator_cranklength '
               'actuator_lengthrange actuator_acc0 actuator_length0'),
    **_decided(IRRELEVANT, 'addresses', 'actuator_actadr actuator_historyadr'),
    # tendons and constraints
    **_decided(REFUSED, 'a tendon over the joint, unless it is the gearbox', (
        'tendon_stiffness tendon_stiffnesspoly tendon_damping tendon_dampingpoly '
        'tendon_armature tendon_frictionloss tendon_limited tendon_springyield '
        'tendon_lengthspring tendon_actuatorid')),
    **_decided(IRRELEVANT, 'of tendons that are refused, or how they lie', (
        'tendon_type tendon_adr tendon_num tendon_range tendon_margin tendon_solref_lim '
        'tendon_solimp_lim tendon_solref_fri tendon_solimp_fri tendon_actfrclimited '
        'tendon_actfrcrange tendon_length0 tendon_invweight0 tendon_treenum tendon_treeid '
        'wrap_type wrap_objid wrap_prm ten_J_rownnz ten_J_rowadr ten_J_colind')),
    **_decided(REFUSED, 'a constraint between what the joint moves and the rest', 'eq_type '
               'eq_obj1id eq_obj2id eq_objtype eq_active0'),
    **_decided(IRRELEVANT, 'of constraints that are refused', 'eq_data eq_solref eq_solimp'),
    **_decided(REFUSED, 'deformable bodies', 'nflex'),
    # the options
    **_decided(READ, 'steps', 'opt.timestep opt.integrator disable.EULERDAMP'),
    **_decided(READ, 'switches of forces', (
        'disable.CONSTRAINT disable.EQUALITY disable.FRICTIONLOSS disable.SPRING disable.DAMPER '
        'disable.GRAVITY disable.CLAMPCTRL disable.ACTUATION disable.REFSAFE enable.DIAGEXACT')),
    **_decided(REFUSED, 'a medium that brakes bodies', 'opt.density opt.viscosity'),
    **_decided(IRRELEVANT, 'wind acts through a medium, which is refused', 'opt.wind'),
    **_decided(REFUSED, 'a solver that changes friction, or stops before it holds',
               'opt.noslip_iterations opt.ls_iterations'),
    **_decided(REFUSED, 'bodies that fall asleep', 'enable.SLEEP'),
    **_decided(IRRELEVANT, 'of sleep, which is refused', 'opt.sleep_tolerance'),
    **_decided(IRRELEVANT, 'friction of one joint needs no iterations', (
        'opt.solver opt.iterations opt.tolerance opt.ls_tolerance '
        'opt.noslip_tolerance opt.jacobian disable.WARMSTART disable.ISLAND')),
    **_decided(IRRELEVANT, 'of contacts: a recording keeps clear of them', (
        'opt.cone opt.impratio opt.o_margin opt.o_solref opt.o_solimp opt.o_friction '
        'opt.ccd_iterations opt.ccd_tolerance opt.sdf_initpoints opt.sdf_iterations '
        'disable.LIMIT disable.CONTACT disable.FILTERPARENT disable.MIDPHASE disable.NATIVECCD '
        'disable.MULTICCD enable.OVERRIDE enable.IPC enable.SPECULATIVE flg_surfacevel '
        'flg_adhesion')),
    **_decided(IRRELEVANT, 'what is measured or computed beside the motion', (
        'opt.magnetic disable.SENSOR disable.AUTORESET enable.ENERGY enable.FWDINV '
        'enable.INVDISCRETE')),
    # sensors
    **_decided(READ, 'delay of the reading of a joint', 'sensor_type sensor_objid sensor_delay '
               'sensor_history'),
    **_decided(IRRELEVANT, 'of readings: recordings have their own noise', (
        'sensor_adr sensor_cutoff sensor_datatype sensor_dim sensor_historyadr sensor_interval '
        'sensor_intprm sensor_needstage sensor_noise sensor_objtype sensor_plugin sensor_refid '
        'sensor_reftype')),
    # bodies and shapes
    **_decided(IRRELEVANT, 'of contacts: a recording keeps clear of them', (
        'body_contype body_conaffinity body_margin body_geomadr body_geomnum body_bvhadr '
        'body_bvhnum geom_adhesion geom_condim geom_conaffinity geom_contype geom_dataid '
        'geom_friction geom_gap geom_margin geom_pos geom_quat geom_priority geom_rbound '
        'geom_aabb geom_sameframe geom_size geom_solimp geom_solmix geom_solref geom_surfacevel '
        'geom_type geom_bodyid pair_adhesion pair_dim pair_friction pair_gap pair_geom1 '
        'pair_geom2 pair_margin pair_signature pair_solimp pair_solref pair_solreffriction '
        'exclude_signature npair nexclude')),
    **_decided(IRRELEVANT, 'drag of a medium, which is refused', 'geom_fluid'),
    **_decided(IRRELEVANT, 'shortcuts of the computation', 'body_sameframe body_simple '
               'dof_simplenum dof_Madr dof_treeid tree_bodyadr tree_bodynum tree_dofadr '
               'tree_dofnum'),
    **_decided(IRRELEVANT, 'bodies that are placed from outside', 'body_mocapid nmocap key_mpos '
               'key_mquat'),
    **_decided(IRRELEVANT, 'further values of a keyframe: a recording begins where it begins',
               'key_qvel key_act key_ctrl key_time'),
    **_decided(IRRELEVANT, 'drawing', 'geom_castshadow geom_group geom_matid geom_plugin '
               'geom_rgba jnt_group tendon_group tendon_matid tendon_rgba tendon_width '
               'site_rgba site_group site_matid site_size site_type'),
    **_decided(IRRELEVANT, 'places for what is refused or drawn', 'site_bodyid site_dataid '
               'site_pos site_quat site_sameframe'),
    **_decided(IRRELEVANT, 'data that the simulation does not read', (
        'body_user geom_user jnt_user actuator_user sensor_user site_user tendon_user cam_user '
        'names names_map paths signature stat vis opt')),
    **_decided(IRRELEVANT, 'sizes', (
        'nq nv nu nactuator nout na nbody nbvh nbvhstatic nbvhdynamic noct njnt ntree nM nB nC '
        'nD ngeom nsite ncam nlight nmat ntex neq ntendon nJten nwrap nsensor nnames npaths '
        'nnames_map nJmom nemax njmax nconmax narena nbuffer nuserdata nsensordata nhistory '
        'npluginattr npluginstate nefm0dof nefm0L nefmCvert nJfe')),
}
# First parts of names of what is drawn, is the shape of something, or holds its data.
FAMILIES = {
    'cam_': 'cameras', 'light_': 'lights', 'mat_': 'materials', 'tex_': 'textures',
    'skin_': 'skins', 'bvh_': 'volumes of shapes', 'oct_': 'volumes of shapes',
    'mesh_': 'shapes', 'hfield_': 'shapes', 'numeric_': 'data of the user',
    'text_': 'data of the user', 'tuple_': 'data of the user', 'name_': 'names',
    'plugin_': 'plug-ins, which are refused', 'flex': 'deformable bodies, which are refused',
    'efm0_': 'deformable bodies, which are refused', 'efmC_': 'deformable bodies',
    'B_': 'places in a sparse matrix', 'M_': 'places in a sparse matrix',
    'D_': 'places in a sparse matrix', 'map': 'places in a sparse matrix',
    'nflex': 'sizes', 'nmesh': 'sizes', 'nskin': 'sizes', 'nhfield': 'sizes', 'ntex': 'sizes',
    'nnumeric': 'sizes', 'ntext': 'sizes', 'ntuple': 'sizes', 'nuser_': 'sizes',
    'npolygon': 'sizes'}


def decision(name: str) -> ArrayTreatment | None:
    """Return what is decided about `name` of MjModel, 'opt.x', 'disable.X'; None: nothing."""
    if name in DECISIONS:
        return DECISIONS[name]
    return next((ArrayTreatment(IRRELEVANT, reason) for first, reason in FAMILIES.items()
                 if name.startswith(first)), None)


# ---------------------------------------------------------------------- MuJoCo


def mujoco_module() -> Any:
    """
    Return the module mujoco, whose warnings go nowhere. Raises InputError: it is not installed.

    By itself it appends them to MUJOCO_LOG.TXT in the folder that a user works in. A run that has
    become unstable shows in its numbers.
    """
    try:
        import mujoco
    except ImportError:
        raise InputError(f'mujoco: not installed, expected {installed_by("mujoco")}') from None
    mujoco.set_mju_user_warning(_no_log)
    return mujoco


def _no_log(message: str) -> None:
    """Take a warning of MuJoCo."""


def name_of(m: Any, kind: str, index: int) -> str:
    """Return the name of object `index` of `m`, of a `kind` such as joint, or its number."""
    return getattr(m, kind)(int(index)).name or f'number {int(index)}'


def disabled(m: Any, *flags: str) -> bool:
    """Return whether one of the `flags` of mjtDisableBit, such as 'SPRING', is set in `m`."""
    bits = mujoco_module().mjtDisableBit
    return any(m.opt.disableflags & int(getattr(bits, f'mjDSBL_{flag}')) for flag in flags)


def enabled(m: Any, flag: str) -> bool:
    """Return whether a `flag` of mjtEnableBit, such as 'SLEEP', is set in `m`."""
    bit = getattr(mujoco_module().mjtEnableBit, f'mjENBL_{flag}', 0)
    return bool(m.opt.enableflags & int(bit))


def runge_kutta(m: Any) -> bool:
    """Return whether steps of `m` are of the Runge-Kutta method."""
    return bool(m.opt.integrator == int(mujoco_module().mjtIntegrator.mjINT_RK4))


def scalar_joints(m: Any) -> list[int]:
    """Return the numbers of all hinges and slides of `m`."""
    kinds = mujoco_module().mjtJoint
    return [j for j in range(m.njnt)
            if m.jnt_type[j] in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))]


def moved_by(m: Any, joint: int) -> Flags:
    """Return which bodies of `m` move with a `joint`, all others at rest [nbody]."""
    moved = np.zeros(m.nbody, bool)
    moved[m.jnt_bodyid[joint]] = True
    for body in range(1, m.nbody):
        moved[body] |= moved[m.body_parentid[body]]
    return moved


def at_rest(m: Any, posture: Array | None = None) -> Any:
    """Return an MjData of `m` in a `posture` [nq], None for qpos0, without motion."""
    mujoco = mujoco_module()
    state = mujoco.MjData(m)
    if posture is not None:
        state.qpos[:] = posture
    mujoco.mj_forward(m, state)
    return state


# ---------------------------------------------------------------------- actuators


@dataclass(frozen=True)
class ActuatorLaw:
    """
    Torque of an actuator on a joint, in the joint's coordinates: rad, N m (m, N of a slide).

    torque = clip(gear gain c + constant - spring q - damper q', force), c its control: within
    `control`, late by `delay` s, through a filter of the time constant `lag` s. force, control:
    (low, high), infinite without limits. setpoint: c / gear is a position that it drives to;
    speed: it drives to a speed. cogging: A (N m), N, phi; lugre: sigma0 (N m/rad), sigma1
    (N m s/rad), Coulomb and static friction (N m), Stribeck speed (rad/s). passive: no control.
    """

    index: int
    name: str
    gear: float
    gain: float
    constant: float
    spring: float
    damper: float
    force: tuple[float, float]
    control: tuple[float, float]
    lag: float = 0.0
    delay: float = 0.0
    setpoint: bool = False
    speed: bool = False
    passive: bool = False
    cogging: tuple[float, ...] = ()
    lugre: tuple[float, ...] = ()


class Unread(Exception):
    """An attribute of an actuator that is not read: which, and what to do."""

    def __init__(self, attribute: str, words: str) -> None:
        super().__init__(attribute, words)
        self.attribute, self.words = attribute, words


def is_off(m: Any, actuator: int) -> bool:
    """Return whether an `actuator` of `m` is switched off, by the option or its group."""
    group = int(m.actuator_group[actuator])
    return disabled(m, 'ACTUATION') or (
        0 <= group < 31 and bool(m.opt.disableactuator & (1 << group)))


def actuators_on(m: Any, joint: int) -> list[int]:
    """Return the numbers of the actuators of `m` whose transmission is a `joint`."""
    return [i for i in _attached(m, joint) if not is_off(m, i)]


def _attached(m: Any, joint: int) -> list[int]:
    """Return the numbers of the actuators on a joint, those that are switched off as well."""
    trn = mujoco_module().mjtTrn
    kinds = (int(trn.mjTRN_JOINT), int(trn.mjTRN_JOINTINPARENT))
    return [i for i in range(len(m.actuator_trntype)) if m.actuator_trntype[i] in kinds
            and m.actuator_trnid[i, 0] == joint]


def actuator_losses(m: Any, joint: int) -> tuple[float, float]:
    """
    Return what actuators add to a joint, also while they are switched off.

    Args:
        m: mujoco.MjModel.
        joint: number of the joint.

    Returns:
        Armature (kg m^2) and damping (N m s/rad), both on the side of the joint.
    """
    attached = _attached(m, joint)
    squares = np.array([m.actuator_gear[m.actuator_outadr[i], 0] ** 2 for i in attached])
    damping = 0.0 if disabled(m, 'DAMPER') else float(m.actuator_damping[attached] @ squares)
    return float(m.actuator_armature[attached] @ squares), damping


def actuator_law(m: Any, actuator: int) -> ActuatorLaw:
    """
    Return the law of an actuator on a joint.

    Args:
        m: compiled model.
        actuator: its number, one of actuators_on, or one on a fixed tendon.

    Returns:
        The ActuatorLaw.

    Raises:
        Unread: it does what no law here has.

    """
    mujoco, i = mujoco_module(), actuator
    gain_kind, bias_kind = int(m.actuator_gaintype[i]), int(m.actuator_biastype[i])
    word = kind_of(mujoco.mjtGain, gain_kind)
    if m.actuator_plugin[i] >= 0:
        raise Unread('plugin', 'its torque is code')
    if gain_kind == int(mujoco.mjtGain.mjGAIN_DCMOTOR):
        return _dc_motor(m, i)
    if gain_kind not in (int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtGain.mjGAIN_PID)):
        raise Unread('gaintype', f'{word}, expected fixed')
    if bias_kind not in (int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE)):
        raise Unread('biastype', kind_of(mujoco.mjtBias, bias_kind)
                     + ', expected none or affine')
    bias = [0.0] * 3
    if bias_kind == int(mujoco.mjtBias.mjBIAS_AFFINE):
        bias = [float(v) for v in m.actuator_biasprm[i, :3]]
    gain = float(m.actuator_gainprm[i, 0])
    if gain_kind == int(mujoco.mjtGain.mjGAIN_PID):
        inputs = int(m.actuator_ctrlspec[i])
        if inputs != int(mujoco.mjtCtrlInput.mjINPUT_POS) or m.actuator_actnum[i] != WITHOUT_STATE:
            raise Unread('pid', 'an integral, a slew rate or inputs besides the position, '
                         'expected input="pos" with kp and kv alone')
        gain = -bias[1]
    lag = _lag(m, i)
    gear = _gear(m, i)
    spring, damper = -gear * gear * bias[1], -gear * gear * bias[2]
    setpoint = spring != 0.0
    if spring < 0.0 or damper < 0.0:
        raise Unread('biasprm', f'{bias[1]:g} {bias[2]:g}: drives away, expected none above 0')
    if setpoint and not math.isclose(gain, -bias[1], rel_tol=1e-6):
        raise Unread('gainprm', f'{gain:g} beside biasprm {bias[1]:g}: setpoints in another '
                     'unit than the joint, expected them alike')
    if not setpoint and gain <= 0.0:
        raise Unread('gainprm', f'{gain:g}, expected a number above 0 (a negative gear turns '
                     'the sign)')
    return ActuatorLaw(
        i, m.actuator(i).name, gear, gain, gear * bias[0], spring, damper, _force(m, i, gear),
        _control(m, i), lag, _delay(m, i), setpoint, speed=bool(not setpoint and damper))


def kind_of(enumeration: Any, value: int) -> str:
    """Return the name of a `value` of an `enumeration` of MuJoCo, as 'hinge' of mjJNT_HINGE."""
    return str(enumeration(int(value)).name).partition('_')[2].lower()


def _gear(m: Any, i: int) -> float:
    gear = float(m.actuator_gear[m.actuator_outadr[i], 0])
    if gear == 0.0:
        raise Unread('gear', '0, expected a number other than 0')
    return gear


def _force(m: Any, i: int, gear: float) -> tuple[float, float]:
    if not m.actuator_forcelimited[i]:
        return -math.inf, math.inf
    low, high = sorted(gear * float(v) for v in m.actuator_forcerange[i])
    return low, high


def _control(m: Any, i: int) -> tuple[float, float]:
    place = int(m.actuator_ctrladr[i])
    if disabled(m, 'CLAMPCTRL') or not m.actuator_ctrllimited[place]:
        return -math.inf, math.inf
    low, high = (float(v) for v in m.actuator_ctrlrange[place])
    return low, high


def _lag(m: Any, i: int) -> float:
    """Return the time constant (s) of the filter of an actuator that is exact in each step."""
    dyn, kind = mujoco_module().mjtDyn, int(m.actuator_dyntype[i])
    if kind in (int(dyn.mjDYN_NONE), int(dyn.mjDYN_PID)):
        return 0.0
    if kind not in (int(dyn.mjDYN_FILTER), int(dyn.mjDYN_FILTEREXACT)):
        raise Unread('dyntype', f'{kind_of(dyn, kind)}, expected none, filter or '
                     'filterexact')
    if m.actuator_actlimited[i] or m.actuator_actearly[i]:
        raise Unread('actlimited' if m.actuator_actlimited[i] else 'actearly',
                     'a filter with it, expected one without')
    lag, step = float(m.actuator_dynprm[i, 0]), float(m.opt.timestep)
    exact, rk4 = kind == int(dyn.mjDYN_FILTEREXACT), runge_kutta(m)
    if lag <= 0.0 or exact != rk4:
        return max(0.0, lag)
    if exact:
        # RK4 has its mean slope over the step already, and takes the exact step of that.
        return -step / math.log1p(-math.expm1(-step / lag) ** 2 * lag / step)
    # Steps of Euler: act += h / T (c - act).
    if lag <= step:
        raise Unread('dynprm', f'{lag:g} s in steps of {step:g} s, expected filterexact')
    return -step / math.log1p(-step / lag)


def _delay(m: Any, i: int) -> float:
    """
    Return the mean delay (s) of controls, which are held between steps unless interpolated.

    RK4 reads them at the begin, twice in the middle and at the end of a step.
    """
    delay, step = float(m.actuator_delay[i]), float(m.opt.timestep)
    if not delay:
        return 0.0
    steps = delay / step - np.array([0.0, 0.5, 0.5, 0.5, 0.5, 1.0]
                                   if runge_kutta(m) else [0.0])
    if m.actuator_history[i, 1]:
        return float(np.mean(steps)) * step
    if np.any(np.abs(steps - np.round(steps)) < 1e-6):
        # Which of two samples is read depends on how the time rounds: MuJoCo 4.0 changes over.
        raise Unread('delay', f'{delay:g} s ends at a time at which controls are read, so that '
                     'rounding decides between two of them, expected interp="linear", or a '
                     'quarter of a timestep more')
    return float(np.mean(np.ceil(steps))) * step


def _dc_motor(m: Any, i: int) -> ActuatorLaw:
    spec, inputs = int(m.actuator_ctrlspec[i]), mujoco_module().mjtCtrlInput
    passive = spec == int(inputs.mjINPUT_NONE)
    if not passive and spec != int(inputs.mjINPUT_VOLTAGE):
        raise Unread('input', 'a controller in a dcmotor, expected input="voltage" or "none"')
    prm, dyn, gear = m.actuator_gainprm[i], m.actuator_dynprm[i], _gear(m, i)
    lugre = float(dyn[5])
    if dyn[0] > 0.0 and prm[1] > 0.0:
        raise Unread('inductance', f'time constant {dyn[0]:g} s: current is a state, expected 0')
    if m.actuator_actnum[i] > bool(lugre > 0.0) + bool(dyn[0] > 0.0):
        raise Unread('thermal', 'resistance depends on temperature, expected a constant one')
    constant = float(prm[1])
    gain = constant / max(float(prm[0]), 1e-15)
    bias = [float(v) for v in m.actuator_biasprm[i, :6]]
    size = abs(gear)
    return ActuatorLaw(
        i, m.actuator(i).name, gear, gain, 0.0, 0.0, gear * gear * gain * constant,
        _force(m, i, gear), (-math.inf, math.inf) if passive else _control(m, i), 0.0,
        0.0 if passive else _delay(m, i), passive=passive, speed=False,
        cogging=(gear * bias[0], bias[1] * gear, bias[2]) if bias[0] else (),
        lugre=(gear * gear * lugre, gear * gear * float(dyn[6]), size * bias[3], size * bias[4],
               bias[5] / size) if lugre > 0.0 else ())


# ---------------------------------------------------------------------- what is not read


def _tendon_rows(m: Any, state: Any) -> Array:
    """Return how far each tendon lengthens with each degree of freedom [ntendon, nv]."""
    rows = np.zeros((m.ntendon, m.nv))
    for t in range(m.ntendon):
        place = slice(m.ten_J_rowadr[t], m.ten_J_rowadr[t] + m.ten_J_rownnz[t])
        rows[t, m.ten_J_colind[place]] = np.asarray(state.ten_J).ravel()[place]
    return rows


def undecided(m: Any, joints: Sequence[int], state: Any = None,
              gearboxes: Sequence[int] = ()) -> list[Refusal]:
    """
    Return what acts on joints of a compiled model and is not read, by name.

    Args:
        m: mujoco.MjModel.
        joints: numbers of the joints that move; all others rest.
        state: MjData in the posture in which they are read, None for qpos0.
        gearboxes: numbers of tendons that are the gearbox between two of the joints.

    Returns:
        Refusals, in the order of the joints; none of a model that is read whole. What an actuator
        does is read by actuator_law, and listed here where that raises.

    """
    tendons = _tendon_rows(m, at_rest(m) if state is None else state)
    refusals: list[Refusal] = []
    for joint in joints:
        if joint in scalar_joints(m):
            refusals += _torques_on(m, joint)
            refusals += _steps_of(m, joint)
            refusals += _of_tendons(m, joint, tendons, gearboxes)
            refusals += _of_actuators(m, joint, tendons, gearboxes)
        else:
            kind = kind_of(mujoco_module().mjtJoint, m.jnt_type[joint])
            refusals.append(Refusal(name_of(m, 'joint', joint), 'type',
                                    f'{kind}, expected hinge or slide'))
        refusals += _of_constraints(m, joint, tendons)
    return refusals


def undecided_of_robot(m: Any) -> list[Refusal]:
    """
    Return what acts on the joints of a whole robot and is not in a balance of their torques.

    Recorded torques hold what the actuators on joints do, and a balance has no timesteps: these
    two are not listed. Tendons and equalities couple joints in one way or another: see
    tendon_forces and MjModel.eq_active0.

    Args:
        m: mujoco.MjModel of hinges and slides.

    Returns:
        Refusals, in the order of the joints.
    """
    return [refusal for joint in range(m.njnt)
            for refusal in (*_torques_on(m, joint), *_on_sites(m, joint))]


def _torques_on(m: Any, joint: int) -> Iterator[Refusal]:
    """Yield what acts on a hinge or slide, or on what it moves, and is not read."""
    name, spring = name_of(m, 'joint', joint), m.jnt_stiffnesspoly[joint]
    yields = m.jnt_springyield[joint] if m.jnt_stiffness[joint] or np.any(spring) else 0.0
    rows = [('SPRING', 'stiffness', _higher(spring)),
            ('SPRING', 'springyield', f'{yields:g}: the spring yields, expected 0' * bool(yields)),
            ('DAMPER', 'damping', _higher(m.dof_dampingpoly[m.jnt_dofadr[joint]])),
            *(('DAMPER', f'actuator {name_of(m, "actuator", i)}: damping',
               _higher(m.actuator_dampingpoly[i])) for i in _attached(m, joint))]
    for flag, attribute, words in rows:
        if words and not disabled(m, flag):
            yield Refusal(name, attribute, words)
    both_off = disabled(m, 'SPRING') and disabled(m, 'DAMPER')
    for medium in ('density', 'viscosity'):
        if getattr(m.opt, medium) and not both_off:
            yield Refusal(name, medium, f'{getattr(m.opt, medium):g} in option: a medium brakes '
                          'what the joint moves, expected 0')
    if m.nplugin and np.any(m.body_plugin[moved_by(m, joint)] >= 0):
        yield Refusal(name, 'plugin', 'acts on a body that the joint moves, expected none')
    if m.nflex:
        yield Refusal(name, 'flex', f'{m.nflex} deformable bodies, expected none')


def _higher(poly: Array) -> str:
    """Return what is wrong with coefficients `poly` of higher order, '' if all are 0."""
    return (' '.join(f'{float(v):g}' for v in np.ravel(poly))
            + ' of higher order, expected one number') * bool(np.any(poly))


def _steps_of(m: Any, joint: int) -> Iterator[Refusal]:
    """Yield what makes steps of the simulation differ from the equation of motion."""
    kinds, name = mujoco_module().mjtIntegrator, name_of(m, 'joint', joint)
    friction = m.dof_frictionloss[m.jnt_dofadr[joint]] and not disabled(
        m, 'FRICTIONLOSS', 'CONSTRAINT')
    if friction and m.opt.noslip_iterations > 0:
        yield Refusal(name, 'noslip_iterations', f'{m.opt.noslip_iterations} in option: changes '
                      'frictionloss, expected 0')
    if friction and m.opt.ls_iterations < LINE_SEARCH:
        yield Refusal(name, 'ls_iterations', f'{m.opt.ls_iterations} in option: too few to solve '
                      f'frictionloss, expected {LINE_SEARCH} or more')
    if enabled(m, 'SLEEP'):
        yield Refusal(name, 'sleep', 'enabled in option flag, expected disable')
    steps = int(m.opt.integrator)
    if steps not in (kinds.mjINT_EULER, kinds.mjINT_RK4, kinds.mjINT_IMPLICIT,
                     kinds.mjINT_IMPLICITFAST):
        yield Refusal(name, 'integrator', f'{kind_of(kinds, steps)}, '
                      'expected Euler, RK4, implicit or implicitfast')


def tendon_forces(m: Any, tendon: int) -> list[str]:
    """Return the attributes by which a `tendon` of `m` acts, none if it only measures."""
    return [attribute for attribute, value in (
        ('stiffness', not disabled(m, 'SPRING') and (
            m.tendon_stiffness[tendon] or np.any(m.tendon_stiffnesspoly[tendon]))),
        ('damping', not disabled(m, 'DAMPER') and (
            m.tendon_damping[tendon] or np.any(m.tendon_dampingpoly[tendon]))),
        ('frictionloss', not disabled(m, 'FRICTIONLOSS', 'CONSTRAINT')
         and m.tendon_frictionloss[tendon]),
        ('armature', m.tendon_armature[tendon]),
        ('limited', not disabled(m, 'LIMIT', 'CONSTRAINT') and m.tendon_limited[tendon])) if value]


def _of_tendons(m: Any, joint: int, tendons: Array, gearboxes: Sequence[int]
                ) -> Iterator[Refusal]:
    dof = int(m.jnt_dofadr[joint])
    for t in np.flatnonzero(tendons[:, dof]).tolist():
        acts = tendon_forces(m, t)
        if t in gearboxes or not acts:
            continue
        partners = [name_of(m, 'joint', m.dof_jntid[d]) for d in np.flatnonzero(tendons[t])
                    if d != dof]
        joins = f' joins it to {", ".join(partners[:3])}' if partners else ' acts on it'
        yield Refusal(name_of(m, 'joint', joint), f'tendon {name_of(m, "tendon", t)}',
                      f'{", ".join(acts)}:{joins}, expected none, or the gearbox between --joint '
                      'and --model-arm-joint')


def _of_actuators(m: Any, joint: int, tendons: Array, gearboxes: Sequence[int]
                  ) -> Iterator[Refusal]:
    name, dof = name_of(m, 'joint', joint), int(m.jnt_dofadr[joint])
    direct, pulling = actuators_on(m, joint), mujoco_module().mjtTrn.mjTRN_TENDON
    for i in range(len(m.actuator_trntype)):
        target, element = int(m.actuator_trnid[i, 0]), f'actuator {name_of(m, "actuator", i)}'
        if i in direct:
            try:
                actuator_law(m, i)
            except Unread as problem:
                yield Refusal(name, f'{element}: {problem.attribute}', problem.words)
        elif m.actuator_trntype[i] == pulling and not is_off(m, i) and (
                tendons[target, dof] and target not in gearboxes):
            yield Refusal(name, element, f'pulls at the tendon {name_of(m, "tendon", target)} '
                          'over the joint, expected one on the joint')
    yield from _on_sites(m, joint)


def _on_sites(m: Any, joint: int) -> Iterator[Refusal]:
    """Yield the actuators that act on sites which a joint moves."""
    trn, bodies = mujoco_module().mjtTrn, moved_by(m, joint)
    for i in range(len(m.actuator_trntype)):
        if int(m.actuator_trntype[i]) in (trn.mjTRN_SITE, trn.mjTRN_SLIDERCRANK) and (
                not is_off(m, i) and bodies[m.site_bodyid[m.actuator_trnid[i, 0]]]):
            yield Refusal(name_of(m, 'joint', joint), f'actuator {name_of(m, "actuator", i)}',
                          'acts on a site that the joint moves, expected one on the joint')


def ends_of(m: Any, equality: int) -> tuple[int, int]:
    """Return the two bodies that an `equality` in `m`, of bodies or their sites, ties."""
    ends = int(m.eq_obj1id[equality]), int(m.eq_obj2id[equality])
    if m.eq_objtype[equality] == mujoco_module().mjtObj.mjOBJ_SITE:
        return int(m.site_bodyid[ends[0]]), int(m.site_bodyid[ends[1]])
    return ends


def _of_constraints(m: Any, joint: int, tendons: Array) -> Iterator[Refusal]:
    if disabled(m, 'EQUALITY', 'CONSTRAINT'):
        return
    kinds, own = mujoco_module().mjtEq, moved_by(m, joint)
    name, dof = name_of(m, 'joint', joint), int(m.jnt_dofadr[joint])
    for e in np.flatnonzero(m.eq_active0).tolist():
        kind, ids = int(m.eq_type[e]), (int(m.eq_obj1id[e]), int(m.eq_obj2id[e]))
        element = f'equality {name_of(m, "equality", e)}'
        if kind == kinds.mjEQ_JOINT and joint in ids:
            partners = [name_of(m, 'joint', j) for j in ids if j >= 0 and j != joint]
            yield Refusal(name, element, 'couples it with ' + ', '.join(partners)
                          if partners else 'holds it')
        elif kind == kinds.mjEQ_TENDON and any(t >= 0 and tendons[t, dof] for t in ids):
            yield Refusal(name, element, 'couples the tendon over it')
        elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            first, second = ends_of(m, e)
            if own[first] != own[second]:
                yield Refusal(name, element, f'holds {name_of(m, "body", first)} to '
                              f'{name_of(m, "body", second)}: a closed loop of bodies')


def open_loop(m: Any, joint: int, state: Any) -> tuple[str, float]:
    """
    Return the closed loop of bodies beyond a joint that a posture leaves open furthest.

    Its constraint pulls at both ends, which do not lie in one place, so that a torque remains.

    Args:
        m: mujoco.MjModel.
        joint: number of the joint that carries the loop.
        state: MjData in the posture.

    Returns:
        Name of the equality constraint and how far it is open (m or rad), '' and 0 without one.
    """
    mujoco, own, furthest = mujoco_module(), moved_by(m, joint), ('', 0.0)
    kinds = (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD)
    for row in np.flatnonzero(state.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)):
        e, size = int(state.efc_id[row]), abs(float(state.efc_pos[row]))
        if int(m.eq_type[e]) in kinds and size > furthest[1] and own[list(ends_of(m, e))].all():
            furthest = name_of(m, 'equality', e), size
    return furthest
