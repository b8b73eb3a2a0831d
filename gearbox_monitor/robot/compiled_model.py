# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
What acts on joints in a model that MuJoCo has compiled: all of it is read, or refused by name.

`undecided` lists what is refused; `actuator_law` reads an actuator. A test holds both against all
arrays of mujoco.MjModel.

Masses, centres, inertias and limits in a robot's file that no robot has are found without any log:
each body is compared with its neighbours and with the lengths of the robot. Bodies that are fixed
to each other count as one.
"""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.robot.chain import body_of, Link
from gearbox_monitor.robot.description import expanded_root, MOVABLE

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
    bias: of its force before the gear: constant, over length and speed; dynamics: of MuJoCo.
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
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    dynamics: str = 'none'


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
        _control(m, i), lag, _delay(m, i), setpoint, speed=bool(not setpoint and damper),
        bias=(bias[0], bias[1], bias[2]), dynamics=kind_of(mujoco.mjtDyn, m.actuator_dyntype[i]))


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
        0.0 if passive else _delay(m, i), passive=passive, dynamics='dcmotor',
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


@dataclass(frozen=True)
class PlausibleLimits:
    """
    Bounds of plausible values: they find errors of units and points, not placeholders.

    light: mass over those of both neighbours; a link of 0.05 would break. speck: mass of a last
    link over that of its carrier, with less than `grain` kg. heavy: mass over its neighbours.
    far: distance of a centre from the axis, and radius of an inertia, over the longest link. A
    wrong unit of mass or inertia makes the radius 31 times as large, one of length 1000 times;
    placeholders in published arms reach 2. short: m; a link of less length may be the cross of
    two axes. absent: kg, no mass at all.
    """

    light: float = 0.05
    speck: float = 1e-3
    grain: float = 1e-3
    heavy: float = 300.0
    far: float = 4.0
    short: float = 0.02
    absent: float = 1e-9


LIMITS = PlausibleLimits()


@dataclass(frozen=True)
class _Body:
    """
    Bodies that move as one: name and mass kg, number of the carrier, numbers of those it carries.

    length: largest distance of its joints, m; off: of its centre from the axis, m, NaN without a
    hinge; radius: largest of gyration, m.
    """

    name: str
    mass: float
    carrier: int
    carried: Sequence[int]
    length: float
    off: float
    radius: float


def implausible_links(links: Sequence[Link]) -> list[str]:
    """Return a line for each of the `links` of a robot that cannot be true, with a remedy."""
    bodies = []
    for i, link in enumerate(links):
        carried = [k for k, other in enumerate(links) if other.parent == i]
        off, radius = np.nan, 0.0
        if link.mass > LIMITS.absent:
            _, centre, inertia = body_of(link.theta)
            radius = float(np.sqrt(np.linalg.eigvalsh(inertia)[-1] / link.mass))
            if not link.slides:
                off = float(np.linalg.norm(np.cross(link.axis, centre)))
        length = max([0.0, *(float(np.linalg.norm(links[k].origin)) for k in carried)])
        bodies.append(_Body(link.name, link.mass, link.parent, carried, length, off, radius))
    longest = max([0.0, *(body.length for body in bodies)])
    return [line for body in bodies for line in _of_mass(body, bodies) + _of_size(body, longest)]


def implausible_limits(urdf: str | bytes, source: str) -> list[str]:
    """Return a line for each limit of 0 in a `urdf` called `source`; to MuJoCo it is no limit."""
    lines = []
    for joint in expanded_root(urdf, source).findall('joint'):
        if joint.get('type') not in MOVABLE:
            continue
        where = f'joint {joint.get("name", "")}'
        for limit in joint.findall('limit'):
            lines += [f'{where}: {key} limit 0: state what the drive gives'
                      for key in ('effort', 'velocity') if _is_zero(limit.get(key, ''))]
            if joint.get('type') != 'continuous' and all(
                    _is_zero(limit.get(key, '0')) for key in ('lower', 'upper')):
                lines.append(f'{where}: range 0 to 0: state the travel, or type="continuous"')
    return lines


def _is_zero(value: str) -> bool:
    """Return whether a `value` of an attribute is the number 0."""
    try:
        return float(value) == 0.0
    except ValueError:
        return False


def _of_mass(body: _Body, bodies: Sequence[_Body]) -> list[str]:
    """Return what is wrong with the mass of a `body` among its neighbours."""
    mass, limits, kg = body.mass, LIMITS, 'check the unit (kg) and the point'
    carrier = bodies[body.carrier].mass if body.carrier >= 0 else 0.0
    carried = max([0.0, *(bodies[c].mass for c in body.carried)])
    if mass <= limits.absent:
        return []
    if (mass < limits.light * min(carrier, carried) and body.length > limits.short) or (
            not body.carried and mass < min(limits.grain, limits.speck * carrier)):
        return [f'link {body.name}: mass {mass:.3g} kg: it hangs on {carrier:.3g} kg and carries '
                f'{carried:.3g} kg: too light for a link of {1e3 * body.length:.0f} mm; {kg}'
                if body.carried else
                f'link {body.name}: mass {mass:.3g} kg on a link of {carrier:.3g} kg: {kg}']
    neighbours = max(carrier, carried)
    if limits.absent < neighbours < mass / limits.heavy:
        return [f'link {body.name}: mass {mass:.4g} kg, its neighbours {neighbours:.3g} kg or '
                f'less: {kg}']
    return []


def _of_size(body: _Body, longest: float) -> list[str]:
    """Return what is wrong with centre and inertia of a `body` of a robot with such lengths."""
    if longest < LIMITS.short:
        return []
    lines, bound = [], LIMITS.far * longest
    if body.off > bound:
        lines.append(f'link {body.name}: centre of mass {body.off:.3g} m from its axis, the '
                     f'longest link has {longest:.3g} m: check the unit (m) and the origin of '
                     '<inertial>')
    if body.radius > bound:
        lines.append(f'link {body.name}: inertia of a body {body.radius:.3g} m in radius, the '
                     f'longest link has {longest:.3g} m: check the unit (kg m^2) and the mass')
    return lines


def implausible_ranges(m: Any) -> list[str]:
    """Return a line for each joint of `m` that may not move or take no torque."""
    kinds, lines = mujoco_module().mjtJoint, []
    for j in range(m.njnt):
        if m.jnt_type[j] not in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE)):
            continue
        where = f'joint {name_of(m, "joint", j)}'
        low, high = (float(x) for x in m.jnt_range[j])
        if m.jnt_limited[j] and low >= high:
            lines.append(f'{where}: range {low:g} to {high:g}: state the travel, or no limit')
        if m.jnt_actfrclimited[j] and not np.any(m.jnt_actfrcrange[j]):
            lines.append(f'{where}: torque limit 0: state what the drive gives, or no limit')
    return lines
