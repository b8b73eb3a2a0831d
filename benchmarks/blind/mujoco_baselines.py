# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Baselines beside the diagnosis on recordings by MuJoCo: what fits, and what names the cause.

least squares: each effect fitted in MuJoCo itself, one parameter at a time, ranked by the
Bayesian information criterion (Schwarz, 1978), as a user of a system identification toolbox would
do it. friction models: the laws M1 to M6 of Better Actuator Models (Duclusaud et al., arXiv
2410.08650) as friction of the motor in MuJoCo, all parameters of a law fitted at once, ranked by
the same criterion; whatever the gap is, they call it friction. black box: the torque that the
nominal model lacks, regressed on positions, speeds and torque (ridge regression); it names
nothing. All begin windows in smoothed readings, whose errors are taken out to first order.
"""
from collections.abc import Callable, Mapping, Sequence
import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import savgol_filter

from benchmarks.blind import real_joints, window_fit
from benchmarks.blind.mujoco_drives import ADDED, DT, encoders, names_of, Values, xml_of
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.compiled_model import mujoco_module

LENGTH, GAP = 250, 50   # samples of a window, and between windows
SMOOTH = 21             # samples over which readings are smoothed by a cubic
TRAIN = 0.7             # share of the windows that are fitted
STATE_STEPS = 1e-3, 1e-2  # rad, rad/s
STARTS = (0.15, -0.15)  # relative, or in SCALES
SCALES = {'Cav': 0.05, 'Cac': 0.1, 'G': 0.5, 'lag': 0.01, 'delay': 0.01}
EVALUATIONS = 12
RIDGE = 1e-4
# Friction of the motor by the laws of Better Actuator Models -> start: N m, N m s/rad, N m, shares
# of torques (of motor and load), 1/(N m), rad/s, -.
FRICTION = {'base': 0.0, 'viscous': 0.0, 'stribeck': 0.05, 'motor': 0.05, 'load': 0.05,
            'motor_stribeck': 0.05, 'load_stribeck': 0.05, 'motor_square': 1e-3,
            'load_square': 1e-3, 'speed': 0.2, 'curvature': 1.35}
STRIBECK = ('base', 'viscous', 'stribeck', 'speed', 'curvature')
DIRECTIONAL = (*STRIBECK, 'motor', 'load', 'motor_stribeck', 'load_stribeck')
LAWS = {'M1': ('base', 'viscous'), 'M2': STRIBECK, 'M3': ('base', 'viscous', 'motor'),
        'M4': (*STRIBECK, 'motor', 'motor_stribeck'), 'M5': DIRECTIONAL,
        'M6': (*DIRECTIONAL, 'motor_square', 'load_square')}
Acting = Callable[[Any, Any], None]  # changes MjModel and MjData before a step


class Windows(NamedTuple):
    """
    Parts of a recording: u [W, GAP + L] from GAP samples earlier, y [W, L, E] of E encoders.

    starts [W, 2 E]: states where y begins; sigma [E]: noise of the encoders.
    """

    u: Array
    y: Array
    starts: Array
    sigma: Array


def windows_of(u: Array, y: Array) -> Windows:
    """Return the Windows of a recording: input [N] and readings [N, E]."""
    smooth = savgol_filter(y, SMOOTH, 3, axis=0)
    speed = savgol_filter(y, SMOOTH, 3, 1, DT, axis=0)
    # Of a cubic over SMOOTH samples, the residual keeps this share of white noise.
    keep = 1.0 - savgol_filter(np.eye(SMOOTH), SMOOTH, 3, axis=0)[SMOOTH // 2, SMOOTH // 2]
    sigma = (y - smooth)[SMOOTH:-SMOOTH].std(axis=0) / math.sqrt(keep)
    first = np.arange(max(SMOOTH, GAP), len(u) - LENGTH - SMOOTH, LENGTH + GAP)
    index = first[:, None] + np.arange(-GAP, LENGTH)
    return Windows(u[index], y[index[:, GAP:]], np.hstack([smooth[first], speed[first]]), sigma)


def free_runs(v: Values, u: Array, starts: Array, acting: Acting | None = None) -> Array:
    """
    Return positions [W, L, E] of free runs in MuJoCo, NaN of a drive that it refuses.

    Args:
        v: values of the drive.
        u: input [W, GAP + L], N m or rad; in the first GAP samples only the actuator moves.
        starts: states where windows begin [W, 2 E].
        acting: called before each step, after the torque of the actuator is set.
    """
    mujoco, e = mujoco_module(), encoders(v)
    y = np.full((len(u), u.shape[1] - GAP, e), np.nan)
    try:
        m = mujoco.MjModel.from_xml_string(xml_of(v))
    except ValueError:  # an inertia below 0
        return y
    data, n = mujoco.MjData(m), round(DT / m.opt.timestep)
    for w, controls in enumerate(u / v.get('gear', 1.0)):
        mujoco.mj_resetData(m, data)
        for k, control in enumerate(controls, -GAP):
            if k <= 0:
                data.qpos[:], data.qvel[:] = starts[w, :e], starts[w, e:]
            if k >= 0:
                y[w, k] = data.qpos
            data.ctrl[0] = control
            if acting is not None:
                acting(m, data)
            mujoco.mj_step(m, data, nstep=n)
    return y


def _residual(v: Values, part: Windows, acting: Acting | None = None) -> Array:
    y = free_runs(v, part.u, part.starts, acting)
    r: Array = np.nan_to_num((part.y - y) / part.sigma, nan=1e6, posinf=1e6, neginf=-1e6)
    return r.reshape(len(y), -1)


def _spans(v: Values, part: Windows) -> Array:
    """Return orthonormal bases [W, E L, 2 E] of what errors of the starts do to residuals."""
    base = _residual(v, part)
    columns = []
    for step, unit in zip(np.repeat(STATE_STEPS, encoders(v)), np.eye(2 * encoders(v))):
        moved = part._replace(starts=part.starts + step * unit)
        columns.append((_residual(v, moved) - base) / step)
    return np.linalg.qr(np.stack(columns, axis=2))[0]


def _without(r: Array, spans: Array) -> Array:
    """Return residuals `r` [W, E L] without their parts in `spans`."""
    parts: Array = r - np.einsum('wlk,wk->wl', spans, np.einsum('wlk,wl->wk', spans, r))
    return parts


def _misfit(r: Array, spans: Array) -> float:
    r = _without(r, spans)
    return float(np.sqrt(np.sum(r * r) / (r.size - spans.shape[2] * len(r))))


def closed_of(nominal: Values, values: Values, u: Array, y: Array) -> float | None:
    """
    Return the fraction of the nominal misfit that `values` close in MuJoCo, on held-out windows.

    Args:
        nominal: values of the nominal drive.
        values: values to be judged.
        u: input [N], N m or rad.
        y: readings [N, E], rad.
    """
    _, test = _split(windows_of(u, y))
    return window_fit.closed(*(_misfit(_residual(v, test), _spans(v, test))
                               for v in (nominal, values)))


def _closed_by(v: Values, test: Windows, acting: Acting) -> float | None:
    """Return the fraction of the nominal misfit on windows `test` that `acting` closes."""
    spans = _spans(v, test)
    return window_fit.closed(*(_misfit(_residual(v, test, a), spans) for a in (None, acting)))


def _split(part: Windows) -> tuple[Windows, Windows]:
    n = round(TRAIN * len(part.u))
    return tuple(Windows(part.u[s], part.y[s], part.starts[s], part.sigma)
                 for s in (slice(None, n), slice(n, None)))  # type: ignore[return-value]


def _with(v: Values, name: str, x: float, peak: float) -> dict[str, Any]:
    """Return `v` with the parameter of effect `name` moved by `x`."""
    key, _ = names_of(v)[name]
    if key == 'limit':
        return {**v, key: peak * math.exp(min(x, 0.0))}
    if key in v.get('scale', ()):
        return {**v, key: max(0.0, v[key] + v['scale'][key] * x)}
    if key in ADDED:
        return {**v, key: max(0.0, v[key] + SCALES[key] * x)}
    return {**v, key: v[key] * math.exp(x)}


def least_squares_by_bic(v: Values, u: Array, y: Array,
                         names: Sequence[str] = ()) -> dict[str, Any]:
    """
    Return the effect with the best criterion, its values and what it closes.

    Args:
        v: values of the nominal drive.
        u: input [N], N m or rad.
        y: readings [N, E], rad.
        names: effects that are tried; none: all that the drive can have.

    Returns:
        named (an id or none), values, closed: see closed_of.
    """
    train, _ = _split(windows_of(u, y))
    spans, torque = _spans(v, train), u
    if 'robot' in v:
        q, w = (savgol_filter(y[:, 0], SMOOTH, 3, d, DT) for d in range(2))
        torque = real_joints.efforts(v, u, q, w)
    peak = float(np.abs(torque).max())
    plain = _without(_residual(v, train), spans)
    n = plain.size
    best: tuple[float, str, Values] = (n * math.log(np.sum(plain * plain) / n), 'none', v)
    for name in names or names_of(v):
        def lack(x: Array, name: str = name) -> Array:
            return _without(_residual(_with(v, name, x[0], peak), train), spans).ravel()
        for start in STARTS:
            fit = least_squares(lack, [start], diff_step=1e-2, max_nfev=EVALUATIONS,
                                bounds=(-2.5, 2.5))
            score = n * math.log(2.0 * fit.cost / n) + math.log(n)
            if score < best[0]:
                best = score, name, _with(v, name, float(fit.x[0]), peak)
    return {'named': best[1], 'values': dict(best[2]), 'closed': closed_of(v, best[2], u, y)}


def _features(x: Array) -> Array:
    """Return features [.., F] of states x [.., 5]: q1, q2, w1, w2, u."""
    q1, q2, w1, w2, u = np.moveaxis(x, -1, 0)
    twist, slip = q1 - q2, w1 - w2
    return np.stack([
        np.ones_like(u), u, u ** 3, w1, w2, w1 * abs(w1), np.tanh(3.0 * w1), np.tanh(30.0 * w1),
        np.tanh(3.0 * w2), np.tanh(30.0 * w2), np.sin(q2), np.cos(q2), twist, twist ** 3, slip,
        *(np.clip(twist - c, 0.0, None) for c in (0.05, 0.15, 0.3)),
        *(np.clip(twist + c, None, 0.0) for c in (0.05, 0.15, 0.3))], axis=-1)


def black_box(v: Values, u: Array, y: Array) -> dict[str, Any]:
    """
    Return what a regression of the torque that the nominal drive lacks closes; it names nothing.

    Args:
        v: values of the nominal drive.
        u: torque [N], N m.
        y: readings [N, 2], rad.
    """
    mujoco = mujoco_module()
    q, w, a = (savgol_filter(y, SMOOTH, 3, d, DT, axis=0) for d in range(3))
    end = SMOOTH + round(TRAIN * (len(u) - 2 * SMOOTH))
    rows = np.arange(SMOOTH, end)
    m = mujoco.MjModel.from_xml_string(xml_of(v))
    data, lacks = mujoco.MjData(m), np.empty(len(rows))
    for i, k in enumerate(rows):
        data.qpos[:], data.qvel[:], data.ctrl[0] = q[k], w[k], u[k]
        mujoco.mj_forward(m, data)
        lacks[i] = v['m1'] * (a[k, 0] - data.qacc[0]) + v['m2'] * (a[k, 1] - data.qacc[1])
    x = _features(np.column_stack([q[rows], w[rows], u[rows]]))
    scale = np.sqrt(np.mean(x * x, axis=0)) + 1e-12
    x = x / scale
    weights = np.linalg.solve(x.T @ x + RIDGE * len(x) * np.eye(x.shape[1]), x.T @ lacks) / scale
    _, test = _split(windows_of(u, y))
    most = float(np.abs(lacks).max())  # no torque beyond what was seen

    def lacking(m: Any, data: Any) -> None:
        state = np.array([*data.qpos, *data.qvel, data.ctrl[0]])
        data.qfrc_applied[0] = float(np.clip(_features(state) @ weights, -most, most))
    return {'named': None, 'closed': _closed_by(v, test, lacking)}


def friction_by_law(v: Values, law: str, parameters: Array) -> Acting:
    """
    Return what sets the friction of the motor by one of LAWS before each step.

    Args:
        v: values of the drive.
        law: name in LAWS.
        parameters: values of its parameters.
    """
    p = {**dict.fromkeys(FRICTION, 0.0), 'speed': 1.0, 'curvature': 1.0,
         **dict(zip(LAWS[law], parameters.tolist()))}
    if law in ('M3', 'M4'):  # motor and load count alike
        p |= {'load': p['motor'], 'load_stribeck': p['motor_stribeck']}

    def acting(m: Any, data: Any) -> None:
        twist, motor = data.qpos[0] - data.qpos[1], data.ctrl[0] * v['gain']
        load = v['K'] * (twist - min(max(twist, -v['b']), v['b']))
        slow = math.exp(-(abs(data.qvel[0]) / p['speed']) ** p['curvature'])
        friction = (p['base'] + abs(p['motor'] * motor - p['load'] * load) + slow * (
            p['stribeck'] + abs(p['motor_stribeck'] * motor - p['load_stribeck'] * load)))
        if motor * load < 0.0:
            friction += slow * (p['load_square'] * load ** 2 if abs(motor) > abs(load)
                                else p['motor_square'] * motor ** 2)
        m.dof_frictionloss[0], m.dof_damping[0] = friction, p['viscous']
    return acting


def friction_models(v: Values, u: Array, y: Array) -> dict[str, Any]:
    """
    Return what the friction law with the best criterion closes; it names nothing.

    Args:
        v: values of the nominal drive.
        u: torque [N], N m.
        y: readings [N, 2], rad.
    """
    train, test = _split(windows_of(u, y))
    spans, n = _spans(v, train), train.y.size
    start = {**FRICTION, 'base': v['Cc'], 'viscous': v['Cv']}
    best: tuple[float, str, Array] | None = None
    for law, names in LAWS.items():
        def lack(x: Array, law: str = law) -> Array:
            return _without(_residual(v, train, friction_by_law(v, law, x)), spans).ravel()
        x = np.array([start[name] for name in names])
        fit = least_squares(lack, x, diff_step=1e-2, max_nfev=EVALUATIONS,
                            x_scale=np.maximum(np.abs(x), 1e-3), bounds=(0.0, np.inf))
        score = n * math.log(2.0 * fit.cost / n) + len(x) * math.log(n)
        if best is None or score < best[0]:
            best = score, law, fit.x
    assert best is not None
    return {'named': None, 'law': best[1],
            'closed': _closed_by(v, test, friction_by_law(v, *best[1:]))}


BASELINES: Mapping[str, Callable[[Values, Array, Array], dict[str, Any]]] = {
    'least squares, BIC': least_squares_by_bic, 'friction M1 to M6': friction_models,
    'black box': black_box}
