# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Random robots that MuJoCo simulates, with a known change: the truth for tests of the balance.

Serial arms, legs, SCARA arms with a prismatic axis and a torso with two arms; 2 to 7 joints. The
plant has MuJoCo's own integrator and solver of friction (real sticking), an encoder, stamps and
torque readings with noise. In pairs the real robot has friction that no file knows (Stribeck,
load, angle, ripple, power laws), and other masses and rotors than the file. `oracle` is the torque
a change takes at every sample: what a judge who knows the truth would look for.
"""
from dataclasses import dataclass, field

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_log import checked_log, RawLog

mujoco = __import__('mujoco')
STEP, CONTROL = 1e-3, 2
JOINT_KINDS = ('motor_coulomb', 'motor_viscous', 'quadratic_friction', 'stribeck', 'torque_offset',
               'load_friction', 'motor_inertia', 'torque_gain', 'actuator_delay', 'gravity',
               'cogging', 'saturation', 'end_spring')
ROTARY = ('gravity', 'cogging')
LINK_KINDS = ('payload', 'payload', 'base_tilt')
OUTSIDE = ('bursts', 'hysteresis', 'friction_jump', 'swinging')


@dataclass
class Case:
    """A robot, its file, a change and what is needed to log it."""

    seed: int
    kind: str
    xml: str
    joints: list
    links: list
    sizes: np.ndarray           # rms torque of each joint
    truth: list = field(default_factory=list)
    real: dict = field(default_factory=dict)
    rate: float = 100.0
    uneven: bool = False
    slides: tuple = ()
    encoder: float = 2e-4
    noise: float = 0.01
    servo: np.ndarray | None = None   # gains of the last log over those of the file
    inertia: np.ndarray | None = None  # that the file's gains go by


def _body(rng, names, axis, size, slide=False, at=(0, 0, 0), inner=''):
    (name, joint), (length, mass) = names, size
    r = length / 6
    a, b = mass * (length ** 2 / 12 + r * r / 4), mass * r * r / 2
    centre = f'{rng.uniform(-.02, .02):.4f} {rng.uniform(-.02, .02):.4f} {length / 2:.4f}'
    kind = 'slide' if slide else 'hinge'
    place = ' '.join(f'{x:.4f}' for x in at)
    return (f'<body name="{name}" pos="{place}"><inertial pos="{centre}" '
            f'mass="{mass:.4f}" diaginertia="{a:.6f} {a * 1.03:.6f} {b:.6f}"/>'
            f'<joint name="{joint}" type="{kind}" axis="{axis}" FRICTION_{joint}/>{inner}</body>')


def _robot(rng):
    """Return (kind, worldbody, joints, links)."""
    kind = str(rng.choice(['arm', 'arm', 'leg', 'scara', 'torso']))
    scale = float(np.exp(rng.uniform(np.log(.5), np.log(2.0))))
    if kind == 'scara':
        rows = [('0 0 1', .35, 4, False), ('0 0 1', .3, 2.5, False), ('0 0 1', .15, 1.2, True)]
        offsets = [(0, 0, .3), (.35, 0, 0), (.3, 0, 0)]
    elif kind == 'leg':
        rows = [('1 0 0', .15, 2, False), ('0 1 0', .35, 3, False), ('0 1 0', .35, 1.5, False)]
        offsets = [(0, 0, 1), (0, .08, 0), (0, 0, .35)]
    else:
        n = int(rng.integers(2, 8)) if kind == 'arm' else int(rng.integers(2, 4))
        axes = ['0 0 1', '0 1 0', '0 1 0', '0 0 1', '0 1 0', '0 0 1', '0 1 0']
        first = int(rng.integers(2))
        rows = [(axes[(i + first) % 7], .38 * .82 ** i, 4.5 * .62 ** i, False) for i in range(n)]
        offsets = [(0, 0, .2)] + [(0, .05 * (-1) ** i, rows[i][1]) for i in range(n - 1)]

    def serial(prefix, base=None):
        inner = ''
        for i in reversed(range(len(rows))):
            axis, length, mass, slide = rows[i]
            at = base if i == 0 and base is not None else np.array(offsets[i]) * scale
            inner = _body(rng, (f'{prefix}link{i}', f'{prefix}j{i}'), axis,
                          (length * scale, mass * scale ** 2), slide, at, inner)
        names = [f'{prefix}j{i}' for i in range(len(rows))]
        return inner, names
    if kind != 'torso':
        body, joints = serial('')
        if kind == 'leg':
            body = body.replace('<body', '<body quat="0 1 0 0"', 1)
        return kind, body, joints
    arms = [serial(p, np.array([0, y, .4]) * scale) for p, y in (('l_', .2), ('r_', -.2))]
    body = _body(rng, ('waist', 'waist_j'), '0 0 1', (.45 * scale, 8 * scale ** 2), False,
                 (0, 0, .5), arms[0][0] + arms[1][0])
    return kind, body, ['waist_j', *arms[0][1], *arms[1][1]]


def make(seed, pair=False, change=None, rate=None):
    """Return the Case of a seed; change: None draws one, else a list of kinds."""
    rng = np.random.default_rng(seed)
    kind, body, joints = _robot(rng)
    base = ('<mujoco><compiler angle="radian"/><default>'
            '<joint solreffriction="0.002 1"/></default>'
            f'<option timestep="{STEP}" integrator="implicitfast"><flag contact="disable"/>'
            '</option><worldbody>{}</worldbody></mujoco>')
    bare = body
    for j in joints:
        bare = bare.replace(f'FRICTION_{j}/', 'armature="0.01"/')
    model = mujoco.MjModel.from_xml_string(base.format(bare))
    data = mujoco.MjData(model)
    sizes = np.zeros(len(joints))
    for _ in range(60):                       # usual torque of each joint
        data.qpos[:] = rng.uniform(-.8, .8, model.nv)
        data.qvel[:], data.qacc[:] = rng.normal(0, .8, model.nv), rng.normal(0, 2, model.nv)
        mujoco.mj_inverse(model, data)
        sizes += data.qfrc_inverse ** 2 / 60
    sizes = np.sqrt(sizes) + .3
    for i, j in enumerate(joints):
        loss, damp = sizes[i] * rng.uniform(.08, .25), sizes[i] * rng.uniform(.05, .2)
        rotor = .02 * sizes[i] * rng.uniform(.5, 2)
        text = f'armature="{rotor:.5f}" damping="{damp:.4f}" frictionloss="{loss:.4f}"/'
        body = body.replace(f'FRICTION_{j}/', text)
    model = mujoco.MjModel.from_xml_string(base.format(body))
    links = [model.body(model.jnt_bodyid[i]).name for i in range(model.njnt)]
    joints = [model.joint(i).name for i in range(model.njnt)]
    order = [int(np.flatnonzero([j == x for x in joints])[0]) for j in joints]
    case = Case(seed, kind, base.format(body), joints, links, sizes[order])
    case.slides = tuple(model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE)
    case.rate = float(rate or rng.choice([50, 100, 100, 200, 500]))
    case.uneven = bool(rng.random() < .4)
    case.encoder = float(10 ** rng.uniform(-4.3, -3.3))
    case.noise = float(rng.uniform(.003, .015))
    n, off = len(joints), .12 if pair else .03
    case.real = {'mass': rng.uniform(-off, off, n) * (rng.random() < (1 if pair else .4)),
                 'rotor': 1 + rng.uniform(-.4, .4, n) * pair, 'friction': None}
    if pair:
        u = rng.uniform
        case.real['friction'] = [
            {'stribeck': u(0, .5), 'vs': u(.04, .2), 'load': u(0, .08), 'angle': u(0, .25),
             'phase': u(0, 6.28), 'ripple': u(0, .25) * (rng.random() < .6),
             'order': int(rng.integers(4, 40)), 'power': u(0, .3)} for _ in joints]
    draw = np.random.default_rng(seed + 10 ** 6)
    if change is None:
        x = draw.random()
        if x < .3:
            change = []
        elif x < .42:
            change = [str(draw.choice(OUTSIDE))]
        elif x < .52:
            change = [str(k) for k in draw.choice(JOINT_KINDS + LINK_KINDS[1:], 2, False)]
        else:
            change = [str(draw.choice(JOINT_KINDS + LINK_KINDS))]
    case.truth = [_change(draw, k, case) for k in change]
    return case


def _change(rng, kind, case):
    """Return a change of this kind at a random place, with its size."""
    n, u = len(case.joints), rng.uniform
    j = int(rng.integers(n))
    if kind in ROTARY and case.slides[j]:    # of a slide they are no effects
        j = 0
    size = case.sizes[j]
    e = {'kind': kind, 'joint': j}
    if kind == 'payload':
        link = int(rng.choice([n - 1, n - 1, rng.integers(n)]))
        return {'kind': kind, 'link': link, 'm': u(.15, .6) * case.sizes[link] / 3,
                'c': u(-.05, .05, 3) + [0, 0, .08]}
    if kind == 'base_tilt':
        return {'kind': kind, 'angle': u(.015, .07), 'phase': u(0, 6.28)}
    e['size'] = {
        'motor_coulomb': rng.choice([-.7, 1]) * u(.06, .15) * size, 'stribeck': u(.08, .2) * size,
        'motor_viscous': rng.choice([-.4, 1]) * u(.06, .2) * size,
        'quadratic_friction': u(.08, .25) * size, 'load_friction': u(.05, .2),
        'torque_offset': rng.choice([-1, 1]) * u(.05, .2) * size,
        'motor_inertia': u(.02, .06) * size, 'torque_gain': rng.choice([-1, 1]) * u(.08, .2),
        'actuator_delay': u(.008, .025), 'gravity': u(.06, .25) * size,
        'cogging': u(.05, .15) * size, 'saturation': u(.6, .85), 'end_spring': u(.4, 1.2) * size,
    }.get(kind, u(.1, .3) * size)
    e['vs'], e['N'], e['phase'] = u(.05, .2), int(rng.integers(3, 30)), u(0, 6.28)
    return e


def _truth(case, changes):
    """Return the real model and the same one without `changes`."""
    out = []
    for active in (changes, []):
        m = mujoco.MjModel.from_xml_string(case.xml)
        for i in range(m.nv):
            b = m.jnt_bodyid[i]
            m.body_mass[b] *= 1 + case.real['mass'][i]
            m.body_inertia[b] *= 1 + case.real['mass'][i]
            m.dof_armature[i] *= case.real['rotor'][i]
        for e in active:
            if e['kind'] == 'payload':
                b = m.jnt_bodyid[e['link']]
                m0, m1 = m.body_mass[b], e['m']
                com = (m0 * m.body_ipos[b] + m1 * e['c']) / (m0 + m1)
                point = lambda m_, x: m_ * (x @ x * np.eye(3) - np.outer(x, x))  # noqa: E731
                full = np.diag(m.body_inertia[b]) + point(m0, m.body_ipos[b] - com) + point(
                    m1, e['c'] - com)
                values, vectors = np.linalg.eigh(full)
                vectors[:, 0] *= np.sign(np.linalg.det(vectors))
                quat = np.zeros(4)
                mujoco.mju_mat2Quat(quat, vectors.ravel())
                m.body_mass[b], m.body_ipos[b], m.body_inertia[b] = m0 + m1, com, values
                m.body_iquat[b] = quat
            elif e['kind'] == 'motor_inertia':
                m.dof_armature[e['joint']] += e['size']
            elif e['kind'] == 'base_tilt':
                s = 9.81 * np.sin(e['angle'])
                m.opt.gravity[:] = s * np.cos(e['phase']), s * np.sin(e['phase']), -9.81
        mujoco.mj_setConst(m, mujoco.MjData(m))
        out.append(m)
    return out


def random_path(rng, n, seconds, slides):
    t = np.arange(0, seconds, STEP)
    middle = rng.uniform(-.4, .4, n)
    width = np.where(slides, .08, rng.uniform(.5, 1.0, n))
    if rng.random() < .6:
        f = rng.uniform(.05, .5, (n, 5, 1))
        a = rng.uniform(.3, 1, (n, 5, 1)) / (1 + 4 * f) * width[:, None, None] * .8
        arg = 2 * np.pi * f * t + rng.uniform(0, 6.28, (n, 5, 1))
        w = 2 * np.pi * f
        return t, (middle[:, None] + (a * np.sin(arg)).sum(1)).T, (a * w * np.cos(arg)).sum(1).T
    q, v, now, at = np.zeros((len(t), n)), np.zeros((len(t), n)), 0.0, middle.copy()
    while now < seconds:
        goal = middle + rng.uniform(-1, 1, n) * width
        far = np.max(np.abs(goal - at) / np.where(slides, .15, 1))
        time = max(far * 1.9 / rng.uniform(.6, 1.8), .4)
        rest = rng.choice([0.0, .3, .8])
        on = (t >= now) & (t < now + time)
        s = (t[on] - now)[:, None] / time
        q[on] = at + (goal - at) * (10 * s ** 3 - 15 * s ** 4 + 6 * s ** 5)
        v[on] = (goal - at) * (30 * s ** 2 - 60 * s ** 3 + 30 * s ** 4) / time
        q[(t >= now + time) & (t < now + time + rest)] = goal
        now, at = now + time + rest, goal
    return t, q, v


def log(case, number, seconds=40.0, changed=True, setpoint=False, name='', both=False):
    """
    Return (RobotLog, (t [N], oracle [E, N, J] of each change), (kp, kd)) of one recording.

    A change with a `start` acts from then on. both: torques and setpoints; case.servo [J] are the
    true gains over those of the model, in a pair over those of the reference.
    """
    setpoint = setpoint or both
    rng = np.random.default_rng(case.seed * 1000 + number)
    changes = case.truth if changed else []
    model, plain = _truth(case, changes)
    nominal = mujoco.MjModel.from_xml_string(case.xml)
    nominal.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    data, file_state = (mujoco.MjData(m) for m in (model, nominal))
    n = model.nv
    slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
    t, r, rd = random_path(rng, n, seconds + 1, slides)
    day = 1 + rng.uniform(-.08, .08, n) * (case.real['friction'] is not None)
    data.qpos[:], data.qvel[:] = r[0], rd[0]
    mujoco.mj_forward(nominal, file_state)
    # Gains from the inertia in the middle posture of the robot's first log: 5 Hz, well damped.
    if case.inertia is None:
        full = np.zeros((n, n))
        file_state.qpos[:] = r.mean(0)
        mujoco.mj_forward(nominal, file_state)
        for row, unit in zip(full, np.eye(n)):
            mujoco.mj_mulM(nominal, file_state, row, unit)
        case.inertia = np.diag(full)
    kp, kd = case.inertia * 31 ** 2, case.inertia * 40
    servo = (1 + rng.uniform(-.15, .15, n)) * setpoint + (not setpoint)
    if both and changed:
        servo = np.where(rng.random(n) < .3, rng.uniform(.6, 1.6, n), 1.0)
    elif both:
        servo = np.ones(n)
    elif case.servo is not None:    # gains that the file lacks are of the robot, not of a day
        servo = case.servo
    if changed or not both:
        case.servo = servo
    if both and case.real['friction'] is not None:  # of a pair, whose file may have other gains
        servo = servo * np.random.default_rng(case.seed).uniform(.7, 1.4, n)
    damping = kd * (np.ones(n) if both else servo)
    loss0, peak = model.dof_frictionloss.copy(), np.zeros(n)
    steps = len(t)
    log_q, log_u = np.empty((steps, n)), np.empty((steps, n))
    oracle = np.zeros((len(changes), steps, n))
    queue, u, load, memory = [np.zeros(n)] * 40, np.zeros(n), np.zeros(n), np.zeros(n)
    bursts = [(rng.uniform(2, seconds - 1), rng.uniform(.1, .4), rng.choice([-1, 1]))
              for _ in range(8)]
    swing = np.zeros(2)
    limit = {e['joint']: e['size'] for e in changes if e['kind'] == 'saturation'}
    start = max((e.get('start', 0.0) for e in changes), default=0.0)  # s: when a load is taken
    for k in range(steps):
        q, v = data.qpos.copy(), data.qvel.copy()
        if k % CONTROL == 0:
            file_state.qpos[:], file_state.qvel[:] = q, 0 if setpoint else v
            mujoco.mj_forward(nominal, file_state)
            if setpoint:
                u = kp * servo * (r[k] - q) - damping * v + file_state.qfrc_bias
            else:
                u = kp * (r[k] - q) + kd * (rd[k] - v) + file_state.qfrc_bias
                u = u + nominal.dof_damping.ravel()[:n] * rd[k]
            queue.append(u.copy())
        log_q[k], log_u[k] = q, u
        if k < 3000:
            peak = np.maximum(peak, np.abs(u))
        act, loss, extra = u.copy(), loss0 * day, np.zeros(n)
        s = np.tanh(v / .02)
        if case.real['friction'] is not None:
            for i, f in enumerate(case.real['friction']):
                loss[i] *= (1 + f['stribeck'] * np.exp(-(v[i] / f['vs']) ** 2)
                            + f['angle'] * np.sin(q[i] + f['phase'])
                            + f['power'] * np.sqrt(abs(v[i])))
                loss[i] += f['load'] * abs(load[i]) * day[i]
                extra[i] -= f['ripple'] * loss0[i] * np.sin(f['order'] * q[i] + f['phase'])
        for e, own in zip(changes, oracle[:, k]):
            kind, j, x = e['kind'], e.get('joint'), e.get('size')
            if kind == 'motor_coulomb':
                x = max(x, -.7 * loss0[j])
                loss[j] += x
                own[j] += x * s[j]
            elif kind == 'stribeck':
                loss[j] += x * np.exp(-(v[j] / e['vs']) ** 2)
                own[j] += x * np.exp(-(v[j] / e['vs']) ** 2) * s[j]
            elif kind == 'load_friction':
                loss[j] += x * abs(load[j])
                own[j] += x * abs(load[j]) * s[j]
            elif kind == 'friction_jump':
                on = t[k] > seconds / 2
                loss[j] += x * on
                own[j] += x * on * s[j]
            elif kind in ('torque_offset',):
                act[j] += x
                own[j] -= x
            elif kind == 'torque_gain':
                act[j] *= 1 + x
                own[j] -= x * u[j]
            elif kind == 'actuator_delay':
                late = queue[-1 - int(round(x / STEP / CONTROL))][j]
                act[j] = late
                own[j] += u[j] - late
            elif kind == 'saturation':
                top = limit[j] * peak[j] if k >= 3000 else np.inf
                act[j] = np.clip(act[j], -top, top)
                own[j] += u[j] - act[j]
            else:
                torque = 0.0
                if kind == 'motor_viscous':
                    torque = max(x, -.8 * model.dof_damping.ravel()[j]) * v[j]
                elif kind == 'quadratic_friction':
                    torque = x * v[j] * abs(v[j])
                elif kind == 'gravity':
                    torque = x * np.sin(q[j] + e['phase'])
                elif kind == 'cogging':
                    torque = x * np.sin(e['N'] * q[j] + e['phase'])
                elif kind == 'end_spring':
                    out = q[j] - r[:, j].mean() - .6 * r[:, j].std()
                    torque = x * max(0.0, out) / r[:, j].std()
                elif kind == 'bursts':
                    torque = sum(w for a, d, w in bursts if a < t[k] < a + d) * 2.5 * x
                elif kind == 'hysteresis':
                    memory[j] += STEP * (v[j] - abs(v[j]) * memory[j] / .15)
                    torque = x * memory[j] / .15
                elif kind == 'swinging':
                    w = 2 * np.pi * 1.1
                    pull = -w * w * (swing[0] + q[j]) - .3 * swing[1]
                    swing += STEP * np.array([swing[1], pull])
                    torque = np.clip(x * (swing[0] + q[j]), -3 * x, 3 * x)
                extra[j] -= torque
                own[j] += torque
        acting = model if t[k] >= start else plain
        acting.dof_frictionloss[:] = np.maximum(loss, 1e-4)
        data.qfrc_applied[:] = extra + act
        mujoco.mj_step(acting, data)
        load = (act + extra - model.dof_frictionloss * s - model.dof_damping.ravel()[:n] * v
                - model.dof_armature * data.qacc)  # what the gear transmits
    period = 1 / case.rate
    when = np.arange(.5, seconds - .1, period)
    if case.uneven:
        when = when + rng.uniform(-.2, .2, len(when)) * period
        when = when[rng.random(len(when)) > .02]
    row = np.clip(np.searchsorted(t, when, 'right') - 1, 0, steps - 1)
    stamps = when + (rng.normal(0, 3e-4, len(when)) if case.uneven else 0) + rng.uniform(0, .002)
    between = lambda x: np.stack([np.interp(when, t, c) for c in x.T], 1)  # noqa: E731
    q = between(log_q) + rng.normal(0, 1, (len(when), n)) * np.where(slides, .1, 1) * case.encoder
    noise = case.noise * np.std(log_u, axis=0)
    torque = log_u[row] + rng.normal(0, 1, (len(when), n)) * noise
    given = [dict(zip(case.joints, x.T)) for x in (between(r), torque)]
    raw = RawLog(name or f'run{number}', stamps, dict(zip(case.joints, q.T)),
                 given[both or not setpoint], 'torque' if both or not setpoint else 'setpoint',
                 setpoint=given[0] if both else {})
    return checked_log(raw, case.joints), (t, oracle), (kp, kd)
