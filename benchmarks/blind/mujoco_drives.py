# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Drives in MuJoCo with a known deviation from their MJCF file, and their sealed labels.

The nominal model of a recording is the file robot.xml beside it: half of them are drives of a
motor, a gearbox and an arm with two encoders, half are joints of real robots (real_joints) with
one. The deviation is one of MuJoCo's own features, or lies outside of the library: a payload that
swings, a hard stop, a contact.
"""
from collections.abc import Callable, Mapping, Sequence
import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.blind import real_joints
from benchmarks.blind.draw import log_uniform, OF_COULOMB, SMOOTH
from benchmarks.blind.mjcf_parts import actuator_attributes, outside_of
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.compiled_model import mujoco_module

DT, SECONDS = 2e-3, 10.0
G = 9.81
MASS = 3.0                   # kg, of the arm
WINDOW = 250                 # samples over which the nominal model is compared with the truth
EVIDENCE = (2.0, 60.0)       # its misfit there, in standard deviations of the noise
TRIES = 60
INTEGRATORS = ('Euler', 'implicitfast', 'RK4')
# id of the library -> (value that it changes, range of its size: see changed()).
INSIDE = {
    'motor_inertia': ('m1', (0.05, 0.7)), 'motor_viscous': ('Cv', (0.05, 1.0)),
    'motor_coulomb': ('Cc', (0.05, 0.8)), 'arm_viscous': ('Cav', (0.002, 0.1)),
    'arm_coulomb': ('Cac', (0.01, 0.3)), 'gravity': ('G', (0.05, 1.5)),
    'arm_inertia': ('m2', (0.05, 1.2)), 'backlash_gap': ('b', (0.05, 0.8)),
    'stiffness': ('K', (0.1, 0.8)), 'torque_gain': ('gain', (0.02, 0.4)),
    'saturation': ('limit', (0.1, 0.6)), 'actuator_lag': ('lag', (0.002, 0.03)),
    'actuator_delay': ('delay', (0.002, 0.018))}
ADDED = ('Cav', 'Cac', 'G', 'lag', 'delay')  # in their own unit, the others by a factor
OUTSIDE = {'payload': (0.05, 0.5), 'hard_stop': (0.5, 0.95), 'contact': (0.5, 0.95)}
CONFLICTS = ({'actuator_lag', 'actuator_delay'}, {'setpoint_lag', 'setpoint_delay'})
# What one drive can have: of two masses, of a real robot with a motor, with a servo.
DRIVES = (INSIDE, {**real_joints.BOTH, **real_joints.OF_MOTORS},
          {**real_joints.BOTH, **real_joints.OF_SERVOS})
HELD = 0.5            # s, before a recording
LEAST_MOTION = 1e-3  # rad, rms: below, nothing is shown
SHARES = {'none': 0.30, 'pair': 0.10, 'outside': 0.12}  # the others are single effects

Values = Mapping[str, Any]


class Label(NamedTuple):
    """What was drawn: values of the file and of the truth, both as in xml_of."""

    ids: list[str]
    nominal: dict[str, Any]
    truth: dict[str, Any]
    sigma: list[float]
    evidence: float


def names_of(v: Values) -> Mapping[str, tuple[str, tuple[float, float]]]:
    """Return the effects that a drive with the values `v` can have, as INSIDE."""
    return real_joints.names_of(v) if 'robot' in v else INSIDE


def drawn_nominal(random: np.random.Generator) -> dict[str, Any]:
    """Return values of a drive that `random` spreads around the paper's."""
    values = {'m1': 0.006442, 'm2': 0.023454, 'Cv': 0.1, 'Cc': 0.27}
    values = {k: v * log_uniform(random, 0.7, 1.4) for k, v in values.items()}
    values |= {'D': 0.01 * log_uniform(random, 0.5, 5.0), 'K': log_uniform(random, 5.0, 60.0),
               'b': log_uniform(random, 0.02, 0.4),
               'G': log_uniform(random, 0.2, 1.0) if random.uniform() < 0.5 else 0.0}
    rounded: dict[str, Any] = {k: float(f'{v:.4g}') for k, v in values.items()}
    return {**rounded, 'Cav': 0.0, 'Cac': 0.0, 'phi': 0.0, 'gain': 1.0, 'limit': math.inf,
            'lag': 0.0, 'delay': 0.0, 'timestep': float(random.choice([1e-3, 2e-3])),
            'integrator': str(random.choice(INTEGRATORS)), 'outside': None}


def xml_of(v: Values) -> str:
    """Return the MJCF file of a drive with the values `v`, friction by MuJoCo's defaults."""
    if 'robot' in v:
        return real_joints.xml_of(v)
    centre = v['G'] / (MASS * G)
    own = v['m2'] - MASS * centre * centre
    ahead, below = centre * math.sin(v['phi']), centre * math.cos(v['phi'])
    name, size = v['outside'] or ('', 0.0)
    outside = outside_of(name, size, 1e-4, 1e-5)
    late = actuator_attributes(v['lag'], v['delay'], v['limit'], v['timestep'])
    return f"""<mujoco model="drive">
  <compiler angle="radian"/>
  <option timestep="{v['timestep']}" integrator="{v['integrator']}"/>
  <worldbody>
    {outside.world}
    <body name="rotor">
      <joint name="motor" axis="0 1 0" armature="{v['m1']:.9g}" damping="{v['Cv']:.9g}"
             frictionloss="{v['Cc']:.9g}"/>
      <inertial pos="0 0 0" mass="1e-6" diaginertia="1e-12 1e-12 1e-12"/>
    </body>
    <body name="link">
      <joint name="arm" axis="0 1 0" damping="{v['Cav']:.9g}"
             frictionloss="{v['Cac']:.9g}"{outside.joint}/>
      <inertial pos="{-ahead:.9g} 0 {-below:.9g}" mass="{MASS}"
                diaginertia="{own:.9g} {own:.9g} {own:.9g}"/>
      {outside.body}
    </body>
  </worldbody>
  <tendon>
    <fixed name="gearbox" springlength="{-v['b']:.9g} {v['b']:.9g}" stiffness="{v['K']:.9g}"
           damping="{v['D']:.9g}">
      <joint joint="motor" coef="1"/>
      <joint joint="arm" coef="-1"/>
    </fixed>
  </tendon>
  <actuator>
    <general name="motor" joint="motor" gainprm="{v['gain']:.9g}" {late}/>
  </actuator>
</mujoco>
"""


def changed(nominal: Values, name: str, size: float, sign: float, peak: float) -> dict[str, Any]:
    """
    Return the values of a drive with an effect.

    Args:
        nominal: values of the drive.
        name: id of the effect.
        size: drawn from its range.
        sign: -1 or 1.
        peak: of the effort, N m, or of the arm's position, rad, for what is outside.

    Returns:
        The values.
    """
    if name in OUTSIDE:
        amount = size if name == 'payload' else size * peak
        return {**nominal, 'outside': (name, amount)}
    key, _ = names_of(nominal)[name]
    if 'robot' in nominal:
        return real_joints.changed(nominal, key, size, sign, peak)
    if name == 'saturation':
        value = (1.0 - size) * peak
    elif key in ADDED:
        value = max(0.0, nominal[key] + (size * sign if key == 'G' else size))
    else:
        value = nominal[key] * ((1.0 + size) if sign > 0 else 1.0 / (1.0 + size))
    return {**nominal, key: float(f'{value:.6g}')}


def encoders(v: Values) -> int:
    """Return the number of encoders of a drive with the values `v`."""
    return 1 if 'robot' in v else 2


def simulated(v: Values, u: Array, states: Array | None = None, length: int = 0
              ) -> tuple[Array, Array]:
    """
    Return positions and speeds of motor and arm, or of the one joint, in MuJoCo.

    Args:
        v: values of the drive.
        u: input [N]: torque on the motor, N m, or setpoint, rad.
        states: positions and speeds [N, 2 E] at which parts of `length` samples begin; None: one
            run from rest.
        length: see states.

    Returns:
        Positions [N, E], rad, and speeds [N, E], rad/s, of the E encoders.
    """
    mujoco = mujoco_module()
    m = mujoco.MjModel.from_xml_string(xml_of(v))
    data, n = mujoco.MjData(m), round(DT / m.opt.timestep)
    e = encoders(v)
    if v.get('kp'):  # held at its first setpoint, until lag and delay have it
        for _ in range(round(HELD / m.opt.timestep)):
            data.qpos[0], data.qvel[0], data.ctrl[0] = u[0], 0.0, u[0]
            mujoco.mj_step(m, data)
        data.qpos[0], data.qvel[0] = u[0], 0.0
    q, w = np.empty((len(u), e)), np.empty((len(u), e))
    for k, control in enumerate(u / v.get('gear', 1.0)):
        if states is not None and k % length == 0:
            data.qpos[:e], data.qvel[:e] = states[k, :e], states[k, e:]
        q[k], w[k] = data.qpos[:e], data.qvel[:e]
        data.ctrl[0] = control
        mujoco.mj_step(m, data, nstep=n)
    return q, w


def _torque(random: np.random.Generator) -> Array:
    """Return a torque [N] that moves the drive to and fro: a few sines."""
    t = np.arange(round(SECONDS / DT)) * DT
    rates = [log_uniform(random, 0.4, 4.0) for _ in range(random.integers(2, 5))]
    parts = random.uniform(0.4, 1.0, len(rates))
    parts *= random.uniform(4.0, 9.0) / parts.sum()
    u: Array = np.round(sum(a * np.cos(2.0 * np.pi * f * t + random.uniform(-0.3, 0.3))
                            for a, f in zip(parts, rates)), 6)
    return u


def _drawn(ids: Sequence[str], random: np.random.Generator, real: bool, smooth: bool
           ) -> tuple[dict[str, Any], Array] | None:
    """Return values and controls [N] of a nominal drive, None where the motion does not suit."""
    if real:
        kind = next((name for name in ids if name not in real_joints.BOTH), '')
        nominal = real_joints.nominal(random, kind)
        if not {*ids} <= {*real_joints.names_of(nominal), *OUTSIDE}:
            return None
        u = real_joints.inputs(nominal, random, np.arange(round(SECONDS / DT)) * DT)
    else:
        nominal, u = drawn_nominal(random), _torque(random)
        if smooth:
            nominal['Cc'] = 0.0
    q, w = simulated(nominal, u)
    if real:
        nominal['scale'] = real_joints.scaled(nominal, u, q[:, 0], w[:, 0])
    elif np.ptp(q[:, 0] - q[:, 1]) < 2.2 * nominal['b']:
        return None
    return (nominal, u) if np.isfinite(q).all() and np.abs(q).max() <= 60.0 else None


def make(ids: Sequence[str], seed: Sequence[int], real: bool = False,
         smooth: bool = False) -> tuple[dict[str, Any], Label] | None:
    """
    Draw a recording.

    Args:
        ids: effects that it has.
        seed: of all random numbers.
        real: whether the nominal drive is a joint of a real robot.
        smooth: whether another drive has no Coulomb friction.

    Returns:
        (recording, Label), None where the motion does not suit.
    """
    random = np.random.default_rng(seed)
    drawn = _drawn(ids, random, real, smooth)
    if drawn is None:
        return None
    nominal, u = drawn
    plain, speeds = simulated(nominal, u)
    if plain.std(axis=0).min() < LEAST_MOTION:
        return None
    effort = real_joints.efforts(nominal, u, plain[:, 0], speeds[:, 0]) if real else u
    sigma = log_uniform(random, 0.002, 0.02) * plain.std(axis=0)
    sigma = np.array([float(f'{s:.4g}') for s in sigma])
    truth, q, w = nominal, plain, speeds
    for name in ids:
        low, high = OUTSIDE[name] if name in OUTSIDE else names_of(nominal)[name][1]
        peak = float(plain[:, -1].max()) if name in OUTSIDE else float(np.abs(effort).max())
        before = truth
        truth = changed(before, name, log_uniform(random, low, high),
                        float(random.choice([-1.0, 1.0])), peak)
        q, w = simulated(truth, u)
        if not np.isfinite(q).all() or np.abs(q).max() > 60.0:
            return None
        # what this effect alone makes of the motion
        again, _ = simulated(before, u, np.column_stack([q, w]), WINDOW)
        evidence = float(np.sqrt(np.mean(((again - q) / sigma) ** 2)))
        if not EVIDENCE[0] <= evidence <= EVIDENCE[1]:
            return None
    if not ids:
        evidence = 0.0
    y = q + sigma * random.standard_normal(q.shape)
    return ({'u': u, 'y': y, 'xml': xml_of(nominal), 'input': 'setpoint' if nominal.get('kp')
             else 'u'},
            Label(list(ids), nominal, truth, sigma.tolist(), evidence))


def plan(n: int, random: np.random.Generator, effects: Sequence[str]) -> list[list[str]]:
    """Return the ids of each of `n` recordings, singles and pairs of `effects`, in any order."""
    def cycle(names: Sequence[str], count: int) -> list[list[str]]:
        rows = [names[i] for _ in range(count) for i in random.permutation(len(names))]
        return [[name] for name in rows[:count]]
    counts = {kind: max(1, round(share * n)) for kind, share in SHARES.items()}
    pairs: list[list[str]] = []
    while len(pairs) < counts['pair']:
        ids = [str(i) for i in random.choice(list(effects), 2, replace=False)]
        if set(ids) not in CONFLICTS and any({*ids} <= {*kind} for kind in DRIVES):
            pairs.append(ids)
    rows = [*([[]] * counts['none']), *pairs, *cycle(list(OUTSIDE), counts['outside']),
            *cycle(list(effects), max(1, n - sum(counts.values())))]
    return [rows[i] for i in random.permutation(len(rows))]


def generate(n: int, folder: Path, seed: int, sealed: Path,
             progress: Callable[[int, int], object]) -> list[str]:
    """
    Write recordings below folder/recordings, and their labels.

    Args:
        n: number of recordings.
        folder: new directory.
        seed: of all random numbers.
        sealed: file of the labels.
        progress: called with the numbers of recordings done and in all.

    Returns:
        Names of the recordings.
    """
    random = np.random.default_rng([seed, 25])
    labels: dict[str, Any] = {}
    rows = [(ids, False) for ids in plan(n - n // 2, random, list(INSIDE))]
    rows += [(ids, True) for ids in plan(n // 2, random, list(real_joints.INSIDE))]
    for number, (ids, real) in enumerate(rows):
        name = random.bytes(6).hex()
        smooth = number % SMOOTH == 0 and not {*ids} & OF_COULOMB
        drawn = next((made for attempt in range(TRIES)
                      if (made := make(ids, [seed, len(labels), attempt], real, smooth))), None)
        if drawn is None:
            raise RuntimeError(f'{"+".join(ids)}: not drawn in {TRIES} tries')
        recording, label = drawn
        place = folder / 'recordings' / name
        place.mkdir(parents=True)
        t = np.arange(len(recording['u'])) * DT
        np.savetxt(place / 'recording.csv', np.column_stack([t, recording['u'], recording['y']]),
                   '%.9g', ',', header=','.join(('t', recording['input'], 'motor', 'arm')[
                       :2 + recording['y'].shape[1]]), comments='')
        (place / 'robot.xml').write_text(recording['xml'], encoding='utf-8')
        labels[name] = label._asdict()
        progress(len(labels), len(rows))
    sealed.write_text(json.dumps(labels, indent=1) + '\n', encoding='utf-8')
    return list(labels)
