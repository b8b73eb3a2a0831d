# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A diagnosis in the simulator of the user, and what is read of each joint of a file."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import importlib
import inspect
import math
from pathlib import Path
import sys
import traceback
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.shooting import Simulator
from gearbox_monitor.diagnosis.joint.windows import closed_of, gap_of, ModelRun, Overlay, overlay
from gearbox_monitor.errors import InputError, refusal
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import arm_side, EFFECTS, library
from gearbox_monitor.plant.simulate import (
    equivalent_torque, PackedDrive, plugin_of, read_all, Schedule)
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.robot.compiled_model import kind_of, mujoco_module, name_of, scalar_joints
from gearbox_monitor.signals.uniform import UniformRecording
from gearbox_monitor.simulators.mjcf_file import (
    drive_in, MjcfDrive, posture_of, RobotFile, values_in)

STEPS = (1e-4, 1e-3)   # rad and rad/s: differences that make a slope
ITERATIONS = 40        # residuals of a fit
GAIN = 1e-3            # least relative gain of an iteration worth another
CONFIRMED = 0.3        # share of the windows that run in the user's simulator, its last ones


FIXED = ('torque', 'start', 'dt')
VALUES = ('motor_inertia', 'arm_inertia', 'damping', 'viscous_friction', 'coulomb_friction',
          'friction_sharpness', 'position_gain', 'stiffness', 'half_gap')
EFFECT_VALUES = {effect.id: effect.parameters[0].name for effect in (
    arm_side.ARM_VISCOUS, arm_side.ARM_COULOMB, arm_side.GRAVITY)}
PARAMETERS = (*VALUES, *EFFECT_VALUES)
SHARE = 0.01     # by which a value is changed for a slope
HUGE = 1e9      # residual of what is not finite
AT_START = 1e-6  # rad: how far the first position may be off the start


@dataclass(frozen=True)
class UserSimulator:
    """The function `run`, called `name` in messages, and the PARAMETERS that it takes."""

    name: str
    run: Callable[..., Any]
    takes: tuple[str, ...]

    def positions(self, torque: Array, start: Array, dt: float, model: DriveModel) -> Array:
        """
        Return positions of motor and arm [N, 2], rad.

        Args:
            torque: on motor and arm [N, 2], held over a sample, N m.
            start: positions and speeds of motor and arm [4], rad and rad/s.
            dt: length of a sample, s.
            model: whose values the simulator takes.

        Raises:
            InputError: the function raises an exception, or returns something else.
        """
        values = {name: value_of(model, name) for name in self.takes}
        try:
            returned = self.run(torque.copy(), start.copy(), dt, **values)
        except Exception as error:  # of the user's code
            place = traceback.extract_tb(error.__traceback__)[-1]
            raise InputError(f'--simulator {self.name}: {type(error).__name__}: {error} '
                             f'({place.filename}, line {place.lineno}), expected positions'
                             ) from error
        try:
            y = np.asarray(returned, float)
            shape: Any = y.shape
        except (TypeError, ValueError):
            shape = type(returned).__name__
        if shape != torque.shape:
            raise InputError(f'--simulator {self.name}: returned {shape}, expected an array '
                             f'{torque.shape} of positions of motor and arm')
        return y

    def probe(self, recording: UniformRecording, model: DriveModel) -> None:
        """
        Run the nominal simulator over the first second of a recording.

        Args:
            recording: of the drive.
            model: the nominal model.

        Raises:
            InputError: it does not do what it should.
        """
        n = min(len(recording.u), max(2, round(1.0 / recording.dt)))
        y = recording.y[0, [recording.channels[0], recording.channels[-1]]]
        torque = np.column_stack([recording.u[:n], np.zeros(n)])
        ran = self.positions(torque, np.array([*y, 0.0, 0.0]), recording.dt, model.folded())
        if not np.isfinite(ran).all():
            k = int(np.argmin(np.isfinite(ran).all(axis=1)))
            raise InputError(f'--simulator {self.name}: sample {k}: position {ran[k].tolist()}, '
                             'expected finite numbers')
        if np.abs(ran[0] - y).max() > AT_START:
            raise InputError(f'--simulator {self.name}: first position {ran[0].tolist()}, '
                             f'expected the start {y.tolist()}: positions are those before each '
                             'step')


def user_simulator(name: str) -> UserSimulator:
    """
    Return the simulator `name`, module:function, from the working directory or installed.

    Raises InputError.
    """
    module, _, function = name.partition(':')
    where = f'--simulator {name}'
    if gone := refusal(Path(module).suffix):
        raise InputError(f'{where}: {gone}')
    if not module or not function:
        raise InputError(f'{where}: expected module:function, such as my_arm:simulate')
    if '' not in sys.path:
        sys.path.insert(0, '')
    try:
        run = getattr(importlib.import_module(module), function, None)
    except ModuleNotFoundError as error:
        missing = error.name if error.name != module else f'{module}.py'
        raise InputError(f'{where}: no module {missing}, expected it in the working directory or '
                         'installed') from None
    except Exception as error:  # of the user's code
        raise InputError(f'{where}: {type(error).__name__}: {error}, expected a module to '
                         'import') from error
    if not callable(run):
        raise InputError(f'{where}: no function {function} in {module}, expected one')
    try:
        parameters = list(inspect.signature(run).parameters.values())
    except ValueError:
        parameters = []
    expected = f'expected ({", ".join(FIXED)}, names among {", ".join(PARAMETERS)})'
    if len(parameters) < len(FIXED):
        raise InputError(f'{where}: takes {len(parameters)} arguments, {expected}')
    names = parameters[len(FIXED):]
    wrong = [str(p) for p in names if p.name not in PARAMETERS and p.default is p.empty]
    if wrong:
        raise InputError(f'{where}: argument {wrong[0]}, {expected}')
    return UserSimulator(name, run, tuple(p.name for p in names if p.name in PARAMETERS))


def value_of(model: DriveModel, name: str) -> float:
    """Return the parameter `name`, one of PARAMETERS, of a folded `model`."""
    if name in VALUES:
        return model.value(name)
    return float(sum(e[EFFECT_VALUES[name]] for e in model.effects
                     if e['id'] == name and not e.get('phi')))


def expressed(nominal: DriveModel, closed: DriveModel, takes: tuple[str, ...]) -> DriveModel:
    """
    Return the model that a simulator is: the nominal one with what it `takes` of the closed one.

    Args:
        nominal: model of the simulator.
        closed: model with the effects.
        takes: those of PARAMETERS that the simulator takes.

    Returns:
        The mechanics alone: actuator and servo are not the simulator's.
    """
    model, closed = nominal.folded(), closed.folded()
    effects = [e for e in model.effects
               if e['id'] not in takes and library()[e['id']].location != 'actuator']
    effects += [{'id': name, EFFECT_VALUES[name]: value_of(closed, name)}
                for name in takes if name in EFFECT_VALUES]
    values = {name: closed.value(name) for name in takes if name in VALUES}
    return replace(model.with_values(values), torque_offset=0.0, effects=tuple(effects))


def passed(nominal: DriveModel, closed: DriveModel, takes: tuple[str, ...]) -> dict[str, str]:
    """
    Return how effects of a closed model reach the simulator.

    Args:
        nominal: model of the simulator.
        closed: model with the effects.
        takes: those of PARAMETERS that the simulator takes.

    Returns:
        {id: parameter, torque or reading}.
    """
    ways = {}
    for effect in closed.effects:
        name = effect['id']
        entry = EFFECTS.get(name)
        if effect in nominal.effects or entry is None:
            continue
        value = entry.replaces or name
        ways[name] = ('reading' if entry.location.endswith('sensor') else
                      'parameter' if value in takes and not effect.get('phi') else 'torque')
    return ways


def confirmation(simulator: UserSimulator, recording: UniformRecording,
                 models: tuple[DriveModel, DriveModel], sigma: Array,
                 progress: Callable[[int, int], object]) -> dict[str, Any]:
    """
    Return how far a closed model closes the gap in the user's simulator, beside our own.

    On the last of the windows; each starts where it fits best.

    Args:
        simulator: the user's.
        recording: of the drive, driven by a torque.
        models: nominal and closed.
        sigma: noise of the encoders [2], rad.
        progress: function (done, total).

    Returns:
        {'name', 'passed' {id: parameter, torque or reading}, 'gap_before', 'gap_after',
        'closed_fraction', 'here' {the same three}, 'values' {id: {parameter: [value, standard
        deviation]}} that fit in the user's simulator}.

    Raises:
        InputError: a model has an effect of a plug-in, or the simulator fails.
    """
    if any(plugin_of(model)[0] for model in models):
        raise InputError(f'--simulator {simulator.name}: the model has an effect of a plug-in, '
                         'expected effects of the library')
    laid = overlay(recording, dict(zip(('nominal', 'closed'), models)), sigma)
    windows = np.arange(len(laid.windows))[-max(1, round(CONFIRMED * len(laid.windows))):]
    gaps, ours, size = [], [], laid.windows.length * len(laid.channels)
    for k, (run, model) in enumerate(zip(laid.runs, models)):
        fits = []
        for w in windows:
            fits.append(_fitted(simulator, laid, int(w), run, (models[0], model)))
            progress(k * len(windows) + len(fits), 2 * len(windows))
        gaps.append(gap_of(np.array([2.0 * fit.cost for fit in fits]), size))
        ours.append(gap_of(run.chi2[windows], size))
    figures, own = ({'gap_before': g[0], 'gap_after': g[1], 'closed_fraction': closed_of(*g)}
                    for g in (gaps, ours))
    return {'name': simulator.name, 'passed': passed(*models, simulator.takes), **figures,
            'here': own, 'values': _values(simulator, laid, windows, models, fits)}


def _values(simulator: UserSimulator, laid: Overlay, windows: Integers,
            models: tuple[DriveModel, DriveModel], fits: Sequence[Any]
            ) -> dict[str, dict[str, list[float]]]:
    """Return {id: {parameter: [value, standard deviation]}}: a Gauss-Newton step in theirs."""
    nominal, closed = models
    free = [(i, p.name) for i, e in enumerate(closed.effects) if e not in nominal.effects
            for p in library()[e['id']].parameters
            if not (p.whole or p.listed or p.choices) and e.get(p.name)]
    normal, pull = np.zeros((len(free),) * 2), np.zeros(len(free))
    for w, fit in zip(windows, fits):
        r, span = fit.fun, np.linalg.qr(fit.jac)[0]
        columns = np.column_stack([_residual_of(
            simulator, laid, int(w), laid.runs[1], (nominal, _scaled(closed, i, name)))(fit.x) - r
            for i, name in free]) / SHARE if free else np.zeros((len(r), 0))
        columns -= span @ (span.T @ columns)  # the start is free
        normal, pull = normal + columns.T @ columns, pull + columns.T @ r
    errors = covariance(normal)
    change = -errors @ pull
    chi2 = max(1.0, sum(2.0 * fit.cost for fit in fits) / sum(len(fit.fun) for fit in fits))
    deviation = np.sqrt(chi2 * np.diag(errors))
    values: dict[str, dict[str, list[float]]] = {}
    for (i, name), x, d in zip(free, change, deviation):
        effect = closed.effects[i]
        if d == 0.0:  # it moves no reading, such as the step of an encoder
            continue
        values.setdefault(effect['id'], {})[name] = [
            float(effect[name] * (1.0 + x)), float(abs(effect[name]) * d)]
    return values


def _scaled(model: DriveModel, index: int, name: str) -> DriveModel:
    """Return `model` with a parameter of an effect a little larger."""
    effects = list(model.effects)
    effects[index] = {**effects[index], name: effects[index][name] * (1.0 + SHARE)}
    return replace(model, effects=tuple(effects))


def _states(run: ModelRun, w: int, model: DriveModel) -> Array:
    """Return the state [4] where window `w` of a run begins."""
    states: Array = run.begin.states[w]
    return states[[0, 0, 2, 2]] if model.transmission.kind == 'rigid' else states


def _fitted(simulator: UserSimulator, laid: Overlay, w: int, run: ModelRun,
            models: tuple[DriveModel, DriveModel]) -> Any:
    """Return the fit of the start of window `w` in the user's simulator, by scipy."""
    residual = _residual_of(simulator, laid, w, run, models)
    start = min((_states(one, w, models[0]) for one in (laid.runs[0], run)),
                key=lambda s: float(np.sum(residual(s) ** 2)))
    return fitted_start(residual, start, np.repeat(STEPS, 2))


def fitted_start(residual_of: Callable[[Array], Array], start: Array, steps: Array) -> Any:
    """
    Return the fit of a start [n] by scipy.

    Args:
        residual_of: function of a start that runs a window: residual, in standard deviations.
        start: where the search begins.
        steps: differences that make a slope [n].
    """
    def slopes(start: Array) -> Array:
        return np.column_stack([
            (residual_of(start + step) - residual_of(start - step)) / (2.0 * step.sum())
            for step in np.diag(steps)])
    return scipy.optimize.least_squares(residual_of, start, slopes, method='lm', x_scale='jac',
                                        ftol=GAIN, max_nfev=ITERATIONS)


def _residual_of(simulator: UserSimulator, laid: Overlay, w: int, run: ModelRun,
                 models: tuple[DriveModel, DriveModel]) -> Callable[[Array], Array]:
    """Return the function from a start of a window to its residual; models: nominal, of `run`."""
    nominal, model = models
    recording, windows = laid.recording, laid.windows
    span = slice(int(windows.begin[w]), int(windows.first[w]) + windows.length)
    ours = Simulator(recording, nominal)
    e = model.pack_effects()
    theirs = expressed(nominal, model, simulator.takes)
    none = np.zeros(0)
    torque = equivalent_torque(
        Schedule(np.arange(span.start, span.stop) * recording.dt, ours.acting(e)[span],
                 ours.extra[span], recording.dt),
        np.concatenate([_states(run, w, nominal), run.begin.memory[w]]),
        PackedDrive(model.pack(), e, none),
        PackedDrive(theirs.pack(), theirs.pack_effects(), none))
    channels = list(laid.channels)

    def residual(start: Array) -> Array:
        """Return the residual of a start, in standard deviations."""
        q = simulator.positions(torque, start, recording.dt, theirs)
        y = np.empty((windows.length, 2))
        read_all(np.hstack([q, np.gradient(q, recording.dt, axis=0)]), len(q) - len(y),
                 recording.dt, e, y)
        r: Array = ((laid.measured[w] - y) / laid.sigma)[:, channels].ravel()
        return np.nan_to_num(r, nan=HUGE, posinf=HUGE, neginf=-HUGE)
    return residual


NONE, TORQUE, SPEED, SERVO = ('none', 'torque', 'speed', 'position')  # what a control is
# value of a JointReading -> its unit on a rotary axis
UNITS = {
    'inertia': 'kg m^2', 'armature': 'kg m^2', 'viscous_friction': 'N m s/rad',
    'coulomb_friction': 'N m', 'weight': 'N m', 'stiffness': 'N m/rad', 'offset': 'N m',
    'gear': '-', 'gain': 'N m per unit of control', 'kp': 'N m/rad', 'kd': 'N m s/rad',
    'limit': 'N m', 'lag': 's', 'delay': 's', 'low': 'rad', 'high': 'rad'}


@dataclass(frozen=True)
class JointReading:
    """
    What is read of a joint: its values, SI units on the joint's side, or why it is refused.

    kind: hinge, slide, ball or free; control: what its actuator takes, of NONE, TORQUE, SPEED,
    SERVO; values {name of UNITS: number}, without those that are off; refusals: one line each;
    notes: what was taken for granted.
    """

    name: str
    kind: str
    control: str
    values: dict[str, float]
    refusals: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def read(self) -> bool:
        """Whether commands take the joint."""
        return not self.refusals

    def units(self) -> dict[str, str]:
        """Return {name of a value: its unit}."""
        axis = 'prismatic' if self.kind == 'slide' else 'rotary'
        return {name: on_axis(UNITS[name], axis) for name in self.values}


def joint_readings(file: RobotFile, keyframe: str | None = None) -> list[JointReading]:
    """
    Return what is read of each joint of a robot's file.

    Args:
        file: compiled.
        keyframe: posture in which the others rest, None for that of the file.

    Returns:
        JointReadings, in the order of the file.

    Raises:
        InputError: no such keyframe.

    """
    m, readings = file.compiled, []
    scalar = scalar_joints(m)
    if scalar:
        posture_of(m, keyframe, file.path)
    for joint in range(m.njnt):
        name = name_of(m, 'joint', joint)
        kind = kind_of(mujoco_module().mjtJoint, m.jnt_type[joint])
        if joint not in scalar:
            readings.append(JointReading(name, kind, NONE, {}, (
                f'type: {kind}, expected hinge or slide',), ()))
        elif not m.joint(joint).name:
            readings.append(JointReading(name, kind, NONE, {}, (
                'name: has none, expected one for --joint',), ()))
        else:
            readings.append(_reading(file, name, kind, keyframe))
    return readings


def _reading(file: RobotFile, name: str, kind: str, keyframe: str | None) -> JointReading:
    try:
        drive = drive_in(file, (name, None), keyframe)
    except InputError as error:
        return JointReading(name, kind, NONE, {}, tuple(
            problem.removeprefix(f'{file.path}: ').removeprefix(f'joint {name}: ')
            for problem in error.args), ())
    refusals = tuple(map(str, drive.refusals()))
    notes = tuple(note.partition(f'joint {name}: ')[2] for note in drive.notes
                  if f'joint {name}: ' in note)
    return JointReading(name, kind, _control(drive), _drive_values(drive), refusals, notes)


def _control(drive: MjcfDrive) -> str:
    own = drive.actuator
    if own is None:
        return NONE
    return SERVO if own.setpoint else SPEED if own.speed else TORQUE


def _drive_values(drive: MjcfDrive) -> dict[str, float]:
    """Return the values of a drive that are not off."""
    values, joint, own = values_in(drive), drive.motor, drive.actuator
    readings = {
        'inertia': joint.inertia, 'armature': joint.armature,
        'viscous_friction': values.motor_damping, 'coulomb_friction': values.motor_friction,
        'weight': abs(values.weight or 0.0), 'stiffness': values.motor_stiffness,
        'offset': values.offset, 'lag': values.lag, 'delay': values.delay,
        'limit': values.servo.limit if values.servo else values.limit}
    if own is not None:
        readings['gear'] = own.gear
        if not own.setpoint:
            readings['gain'] = own.gain
    if values.servo is not None:
        readings |= {'kp': values.servo.kp, 'kd': values.servo.kd}
    low, high = joint.travel
    numbers: dict[str, Any] = {name: float(v) for name, v in readings.items()
                               if math.isfinite(v) and abs(v) > 1e-12}
    if math.isfinite(low) and math.isfinite(high):
        numbers |= {'low': low, 'high': high}
    return numbers
