# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Localisation: where a free signal explains the residual best, and when it acts: events.

The free signal is an arbitrary input at one place, estimated in each window.

Slips of a clutch or a loose hub, and bursts of torque, are events, which no motion repeats. Slips
are steps of the twist. A filter in which the zero of the motor's encoder is a state that drifts
shows when it has moved, and by how much, even by a hundredth of the twist. Steps that pay their
price are slips. How one happens is open: no likelihood sees the samples around it; after it the
motor counts on. The sizes are those of the largest likelihood.

Bursts are torque on the arm, such as contacts. The free signal of each window is reduced to one
interval per window, as far as its price allows: that tells about where bursts may be. Begin,
duration and amplitude are those of the largest likelihood of innovations with their torque put in,
which knows no windows, and says what they are worth as for any effect.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, fitted, InnovationFit, JointLikelihood, JointlyFiltered, named_motion)
from gearbox_monitor.diagnosis.joint.windows import StateProblems, WindowRuns
from gearbox_monitor.diagnosis.settings import THRESHOLDS
from gearbox_monitor.kernels.linear_least_squares import covariance, damped_step, Damping, minimise
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.arm_side import burst
from gearbox_monitor.plant.effects.gearbox import slipped
from gearbox_monitor.signals.uniform import UniformRecording

SPACING = 0.04      # s between the peaks of the triangles
ITERATIONS = 10
LEAST_GAIN = 1e-4   # of the cost of a window, for another iteration
# Many attempts: a contact of the gap that is lost makes long steps useless.
RULE = Damping(1e-6, 30.0, 1e-4, attempts=8, absolute=1e-9)
TORQUES = ('motor_side', 'arm_side', 'transmission')   # in the order of Simulator.run's extra
SENSORS = ('motor_sensor', 'arm_sensor')
PLACES = (*TORQUES, *SENSORS)


def torque_places(model: DriveModel) -> tuple[str, ...]:
    """Return the places at which a torque can act in the drive of `model`."""
    # In a rigid drive any torque moves both sides alike.
    return TORQUES if model.transmission.kind != 'rigid' else TORQUES[:1]


@dataclass(frozen=True, eq=False)
class InputEstimate:
    """
    A free signal at one place, fitted to all windows.

    signal [W, H] N m or rad at the peaks of the triangles, precision [W, H, H] its inverse
    covariance by sensor noise; chi2 [W] of the rest; freedom [W]: readings less the numbers that
    the signal and the states amount to, by what the readings say of them.
    """

    signal: Array
    precision: Array
    chi2: Array
    freedom: Array


def triangles(length: int, lead: int, dt: float) -> Array:
    """
    Return the basis [lead + length, H]; before the window's first sample the first one holds.

    Rows sum to 1: linear interpolation between values SPACING s apart.

    Args:
        length: samples of a window.
        lead: samples that a run starts before its window.
        dt: sample time, s.
    """
    count = math.ceil((length - 1) * dt / SPACING - 1e-9) + 1
    at = np.clip((np.arange(lead + length) - lead) * dt, 0.0, None)
    at = np.minimum(at / SPACING, count - 1.0)
    return np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(count)))


class InputEstimator(StateProblems):
    """
    Windows of `runs` with a free signal at one place: theta [W, H + 4] is signal and states.

    count: number H of values of the signal.
    """

    def __init__(self, runs: WindowRuns, place: str) -> None:
        super().__init__(runs.data, runs.model, runs.memory)
        self.states = runs.states
        windows, dt = runs.data.windows, runs.recording.dt
        lead = int((windows.first - windows.begin).max(initial=0))  # of all, after SETTLING
        self.basis = triangles(windows.length, lead, dt)
        self.count = self.basis.shape[1]
        values = runs.recording.torque
        if place in TORQUES:
            # Windows begin in their neighbours: each has a torque of its own.
            self.extra = self.data.simulator.extra[
                windows.begin[:, None] + np.arange(len(self.basis))]
            self.torque = TORQUES.index(place)
        else:
            sensor, channels = SENSORS.index(place), runs.data.channels
            values = runs.recording.y[:, sensor]
            known = np.zeros((windows.length, len(channels), self.count))
            known[:, channels.index(sensor)] = runs.data.white(
                self.basis[None, lead:] / runs.data.sigma[sensor], [sensor])[0]
            self.known = known.reshape(-1, self.count)
        self.scale = max(float(np.std(values)), 1e-9)
        self.steps = np.concatenate([np.full(self.count, 1e-3 * self.scale), self.steps])
        self.gram = np.empty((len(windows), self.count + 4, self.count + 4))

    def residual(self, theta: Array, index: Integers) -> Array:
        """Return the residual [M, L, C] of the windows `index` [M] at `theta` [M, H + 4]."""
        signal, states = np.split(theta, [self.count], axis=1)
        if self.known is not None:
            residual = super().residual(states, index)
            return residual - (signal @ self.known.T).reshape(residual.shape)
        extra = self.extra[index]
        extra[:, :, self.torque] += signal @ self.basis.T
        return self.data.residual(self.model, states, self.memory[index], index, extra)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        self.gram[index], pull = super().linearised(theta, residual, index)
        return self.gram[index], pull

    def solve(self) -> InputEstimate:
        """Return the InputEstimate, by Levenberg-Marquardt with a damping for each window."""
        windows, count = len(self.states), self.count
        ridge = np.zeros(count + 4)
        ridge[:count] = self.scale ** -2  # weak: for values that the readings say nothing of
        both, residual, _ = minimise(
            self, np.hstack([np.zeros((windows, count)), self.states]), RULE, LEAST_GAIN,
            RULE.attempts * ITERATIONS, ITERATIONS, np.tile(ridge, (windows, 1)))
        A = self.gram + np.diag(ridge)
        own, cross, inner = A[:, :count, :count], A[:, :count, count:], A[:, count:, count:]
        precision = own - np.diag(ridge[:count]) - cross @ np.linalg.solve(
            inner + 1e-9 * np.eye(4), cross.transpose(0, 2, 1))
        # What the ridge holds is no unknown.
        share = np.linalg.solve(precision + ridge[0] * np.eye(count), precision)
        freedom = residual.shape[1] - 4.0 - np.einsum('wii->w', share)
        return InputEstimate(both[:, :count], precision,
                             np.einsum('wl,wl->w', residual, residual), freedom)


DECIDING = 10     # windows of a single recording that decide on a place
FEWEST = 6        # windows of each of several recordings


def visible_places(runs: WindowRuns) -> tuple[str, ...]:
    """Return the places that drive and encoders of the recording of `runs` tell apart."""
    recording = runs.recording
    # A motion that is put in takes no offset; one encoder alone takes whatever is asked of it.
    sensors = SENSORS if recording.motor is None else SENSORS[1:]
    both = len(recording.channels) == 2
    if runs.model.transmission.kind != 'rigid':
        return (*TORQUES, *sensors) if both or recording.motor is not None else TORQUES
    # Any torque moves both sides alike.
    return ('motor_side', *sensors) if both else ('motor_side',)


def some_windows(runs: WindowRuns, most: int) -> WindowRuns:
    """
    Return at most so many windows of a recording, evenly spread.

    Where enough windows lack something, only they say where.

    Args:
        runs: of the model that lacks something.
        most: number of windows.
    """
    data = runs.data
    if len(data.windows) <= most:
        return runs
    lacking = np.flatnonzero(runs.chi2 > THRESHOLDS.quiet * data.size)
    if len(lacking) < most:
        lacking = np.arange(len(data.windows))
    return runs.take(lacking[np.linspace(0, len(lacking) - 1, most).round().astype(int)])


def place_in(runs: Sequence[WindowRuns]) -> str:
    """
    Return the place at which a free signal explains most of the gap that `runs` leave.

    Effects of the actuator show as motor_side. What a recording cannot tell apart is what all
    recordings tell.

    Args:
        runs: without effects, of each recording.
    """
    runs = [some_windows(run, max(DECIDING // len(runs), FEWEST)) for run in runs]
    visible = [place for place in PLACES if all(place in visible_places(run) for run in runs)]

    def left(place: str) -> float:
        """Return chi2 per reading, geometric mean of windows: one stuck counts less."""
        estimates = [InputEstimator(run, place).solve() for run in runs]
        return float(np.exp(np.mean(np.log(np.concatenate([
            np.maximum(free.chi2 / free.freedom, 1e-300) for free in estimates])))))
    return min(visible, key=left)


SOFT = 0.2       # of the torque: noise with which a filter follows the motion after a slip
THINNED = 0.02   # s, from value to value of the zero in which steps are looked for
APART = 1.0      # s, between two slips, and from the begin and the end
MOST = 10        # steps that are looked for in a recording
REFITTED = 6     # iterations of a fit with slips, or beside bursts
ROUNDS, REFITS = 3, 2  # searches for slips; fits of their sizes in each
STEP = 1e-4      # rad, of finite differences
NEAR = 0.3       # s, about a step of the zero, where the slip begins
WILD = 9.0       # times the variance of a reading: of one that is not as predicted


@dataclass(frozen=True)
class SlipEvent:
    """One slip: its recording, when in the log (s), size and deviation (rad), + of the motor."""

    recording: str
    t0: float
    size: float
    std: float


def with_slips(data: DriveRecordings, slips: Array, owner: Integers) -> DriveRecordings:
    """
    Return recordings whose motor counts on over slips; `data` knows none.

    Args:
        data: the recordings.
        slips: time (s) and size (rad) of each [B, 2].
        owner: number of its recording [B].
    """
    order = np.lexsort((slips[:, 0], owner))
    return _moved(replace(data, slips=slips[order], slip_owner=owner[order]), -1.0)


def without_slips(data: DriveRecordings) -> DriveRecordings:
    """Return `data` as the recordings were read, with their slips."""
    return data if not len(data.slips) else replace(
        _moved(data, 1.0), slips=data.slips[:0], slip_owner=data.slip_owner[:0])


def _moved(data: DriveRecordings, sign: float) -> DriveRecordings:
    """Return recordings whose motor, and setpoint, is moved by their slips."""
    recordings = []
    for i, r in enumerate(data.recordings):
        t = np.arange(len(r.u)) * r.dt
        angle = sign * sum((slipped({'t0': t0, 'Ds': size}, t) for t0, size in data.slips[
            data.slip_owner == i]), np.zeros(len(t)))
        recordings.append(replace(
            r, y=r.y + angle[:, None] * (1.0, 0.0),
            u=r.u + angle if data.model.controller is not None else r.u))
    return replace(data, recordings=tuple(recordings))


def slipping(data: DriveRecordings, fit: InnovationFit, price: float) -> DriveRecordings | None:
    """
    Return recordings whose motor counts on over more slips than known, None if there are none.

    Slips that are not known enlarge the torque noise, which blurs others; it shrinks as they are
    found.

    Args:
        data: the recordings, with the slips that are known.
        fit: with them.
        price: -2 log L that each slip has to gain.
    """
    bare, known = without_slips(data), len(data.slips)
    for number in range(ROUNDS + 1):
        slips, owner = _steps(bare, fit) if number < ROUNDS else _begun(
            bare, fit, data.slips, data.slip_owner)
        for _ in range(REFITS if len(slips) else 0):
            data = with_slips(bare, slips, owner)
            fit = fitted(data.fine, fit, REFITTED)
            run, J = _columns(data, fit)
            spread = covariance(J.T @ J)
            slips, owner = data.slips.copy(), data.slip_owner
            slips[:, 1] -= spread @ J.T @ run.residual.ravel()
            pays = slips[:, 1] ** 2 > price * np.diag(spread)
            slips, owner = slips[pays], owner[pays]
        data = with_slips(bare, slips, owner)
        if len(slips) <= known:
            return None
    return data


def _columns(data: DriveRecordings, fit: InnovationFit) -> tuple[JointlyFiltered, Array]:
    """Return (the run of `fit`, derivatives [2 N, B] of its residual by the sizes of slips)."""
    run, bare = data.fine.run(fit.model, fit.torque), without_slips(data)
    J = np.empty((run.variance.size, len(data.slips)))
    for k in range(len(data.slips)):
        moved = data.slips.copy()
        moved[k, 1] += STEP
        change = with_slips(bare, moved, data.slip_owner).fine.run(
            fit.model, fit.torque).innovation - run.innovation
        J[:, k] = (change / np.sqrt(run.variance)).ravel() / STEP
    return run, J


def _steps(data: DriveRecordings, fit: InnovationFit) -> tuple[Array, Integers]:
    """Return the steps ([B, 2], owner [B]) of the zeros of recordings."""
    rows, owner = [], []
    model, torque = fit.model, np.maximum(fit.torque, SOFT * data.torque)
    servo = model.folded().controller
    if servo is not None:  # whose reading moves with the zero
        data = replace(data, model=_without_servo(data.model), recordings=tuple(
            replace(r, u=r.with_servo(servo).torque, servo_torque=None) for r in data.recordings))
        model = _without_servo(model)
    for number, part in enumerate(data.fine.parts):
        if len(part.recording.channels) < 2:
            continue
        zero = part.drift(model, torque)
        every = max(1, round(THINNED / part.recording.dt))
        known = np.flatnonzero(np.isfinite(zero))[::every]
        for k, size in _splits(zero[known], round(APART / (every * part.recording.dt))):
            rows.append((known[k] * part.recording.dt, size))
            owner.append(number)
    return np.array(rows).reshape(-1, 2), np.array(owner, int)


def _without_servo(model: DriveModel) -> DriveModel:
    """Return the model of a drive that takes a torque."""
    return replace(model, controller=None, effects=tuple(
        e for e in model.effects if library()[e['id']].location != 'controller'))


def _begun(data: DriveRecordings, fit: InnovationFit, slips: Array, owner: Integers
           ) -> tuple[Array, Integers]:
    """Return slips that begin where the readings cease to be as predicted, close to `slips`."""
    # Counted on later, so that up to its begin each is as predicted.
    late = with_slips(data, slips + (NEAR, 0.0), owner)
    slips = slips.copy()
    for number, run in enumerate(late.fine.run(fit.model, fit.torque).runs):
        dt = data.recordings[number].dt
        square = (run.residual ** 2).max(axis=1)
        odds = run.read.any(axis=1) * (square * (1.0 - 1.0 / WILD) - np.log(WILD))
        for k in np.flatnonzero(owner == number):
            begin = max(0, round((slips[k, 0] - NEAR) / dt))
            rows = odds[begin:round((slips[k, 0] + NEAR) / dt)]
            slips[k, 0] = (begin + 1 + int(np.argmin(np.cumsum(rows)))) * dt
    return slips, owner


def _splits(x: Array, least: int) -> list[tuple[int, float]]:
    """Return (row, size) of the steps of `x` [N] beyond its scatter about them."""
    edges = [0, len(x)]
    for _ in range(MOST):
        gains = [_best_split(x[a:b], least) for a, b in pairwise(edges)]
        best = max(range(len(gains)), key=lambda i: gains[i][0])
        edges = _settled(x, sorted({*edges, edges[best] + gains[best][1]}), least)
    while True:
        levels = [float(np.median(x[a:b])) for a, b in pairwise(edges)]
        scatter = float(np.median(np.abs(x - np.repeat(levels, np.diff(edges)))))
        sizes = np.diff(levels)
        if (np.abs(sizes) > THRESHOLDS.step * scatter).all():
            return list(zip(edges[1:], sizes.tolist()))
        smallest = int(np.argmin(np.abs(sizes)))
        edges = _settled(x, edges[:smallest + 1] + edges[smallest + 2:], least)


def _settled(x: Array, edges: list[int], least: int) -> list[int]:
    """Return `edges` of pieces of `x`, each where it is best between its neighbours."""
    out = list(edges)
    for k in range(1, len(out) - 1):
        out[k] = out[k - 1] + _best_split(x[out[k - 1]:out[k + 1]], least)[1]
    return out


def _best_split(x: Array, least: int) -> tuple[float, int]:
    """Return (decrease of the squares about the means, row) of the best split of `x` [N]."""
    n = len(x)
    k = np.arange(least, n - least + 1)
    if not len(k):
        return 0.0, 0
    total = np.cumsum(x - x.mean())
    gain = total[k - 1] ** 2 * (1.0 / k + 1.0 / (n - k))
    best = int(np.argmax(gain))
    return float(gain[best]), int(k[best])


def slip_events(data: DriveRecordings, fit: InnovationFit) -> tuple[SlipEvent, ...]:
    """Return the slips of `data` in order of time, with deviations of their sizes in `fit`."""
    if not len(data.slips):
        return ()
    _, J = _columns(data, fit)
    std = np.sqrt(np.diag(covariance(J.T @ J)))
    return tuple(SlipEvent(r.name, r.begin + float(t0), float(size), float(s))
                 for r, (t0, size), s in zip((data.recordings[i] for i in data.slip_owner),
                                             data.slips, std))


BURST_ITERATIONS = 8    # of each fit of bursts
ANNEALED = 3      # fits of bursts, each with less torque noise, before one with the least
FORGOTTEN = 3     # s, after which a filter has forgotten a burst
FAR = 1e9         # s, from one recording to the next
LITTLE = 0.02     # of the largest step: of finite differences
EDGES = 5.0       # percent of the time of bursts about either end of a range of the motion
ENOUGH = 0.5      # gain in -2 log L for another iteration
BURST_RULE = Damping(1e-2, 20.0, 1e-3, smallest=1e-9, attempts=5)


@dataclass(frozen=True)
class Burst:
    """One burst: its recording, begin in the log, duration (s), largest torque (N m, signed)."""

    recording: str
    t0: float
    duration: float
    amplitude: float


def with_bursts(evidence: DriveRecordings, theta: Array, owner: Integers) -> DriveRecordings:
    """
    Return the evidence of recordings in which bursts act on the arm.

    Args:
        evidence: the recordings.
        theta: begin (s), duration (s) and amplitude (N m) of each burst [B, 3].
        owner: number of its recording [B].
    """
    # Beside a load that was measured.
    return replace(evidence, recordings=tuple(
        replace(r, arm_torque=(0.0 if r.arm_torque is None else r.arm_torque)
                - torque_of(theta[owner == i], r)) for i, r in enumerate(evidence.recordings)))


def torque_of(theta: Array, recording: UniformRecording) -> Array:
    """Return the torque [N], N m, of the bursts `theta` [B, 3] of a recording."""
    t = np.arange(len(recording.u)) * recording.dt
    return sum((burst(dict(zip(('t0', 'duration', 'amplitude'), row)), t, recording.dt)
                for row in theta), np.zeros(len(t)))


def sharpened(evidence: DriveRecordings, fit: InnovationFit, theta: Array, owner: Integers,
              least: float) -> tuple[Array, InnovationFit]:
    """
    Return (bursts [B, 3], fit beside them) of largest likelihood, searched from `theta` on.

    Torque noise as large as the remainder smooths the likelihood; it shrinks as the bursts fit.

    Args:
        evidence: the recordings.
        fit: that leaves the bursts.
        theta: bursts to begin with, see with_bursts.
        owner: see with_bursts.
        least: gain in -2 log L of the first round, without which the bursts are given up.
    """
    fits, begin = [], evaluated(evidence.fine, fit).deviance
    for cold in (False,) * ANNEALED + (True,):
        torque = evidence.fine.least_noise if cold else fit.torque
        theta = _likeliest(evidence, replace(fit, torque=torque), theta, owner)
        fit = fitted(with_bursts(evidence, theta, owner).fine, fit, REFITTED)
        fits.append((theta, fit))
        if begin - fit.deviance < least:
            break
    return min(fits, key=lambda pair: pair[1].deviance)


def _likeliest(evidence: DriveRecordings, fit: InnovationFit, theta: Array,
               owner: Integers) -> Array:
    """Return the bursts [B, 3] of largest likelihood beside `fit` as it is, from `theta` on."""
    model, damping = fit.model, BURST_RULE.start
    shortest = min(recording.dt for recording in evidence.recordings)
    amplitude = LITTLE * evidence.torque

    def beside(theta: Array) -> tuple[Array, JointlyFiltered]:
        """Return bursts and the filter with them, which begins as without."""
        torques = (torque_of(theta[owner == i], part.recording)
                   for i, part in enumerate(evidence.fine.parts))
        loaded = JointLikelihood([part.changed(simulator=part.simulator.loaded(torque))
                                  for part, torque in zip(evidence.fine.parts, torques)])
        return theta, loaded.run(model, fit.torque)

    def moved_by(theta: Array, reach: Array, change: Array) -> tuple[Array, JointlyFiltered]:
        """Return where a step leads to, at most `reach` [B, 3] away."""
        theta = theta - np.clip(change.reshape(-1, 3), -reach, reach)
        theta[:, 1] = np.maximum(theta[:, 1], shortest)
        return beside(theta)
    run = beside(theta)[1]
    times = np.concatenate([number * FAR + np.repeat(np.arange(len(recording.u)) * recording.dt, 2)
                            for number, recording in enumerate(evidence.recordings)])
    for _ in range(BURST_ITERATIONS):
        reach = np.full(theta.shape, SPACING)
        reach[:, 2] = np.maximum(np.abs(theta[:, 2]), amplitude)
        steps, J = LITTLE * reach, np.zeros((run.variance.size, theta.size))
        for members in _apart(theta, owner):
            begins = owner[members] * FAR + theta[members, 0] - SPACING
            cause = np.searchsorted(begins, times) - 1
            for i in range(3):
                moved = theta.copy()
                moved[members, i] += steps[members, i]
                change = (beside(moved)[1].innovation - run.innovation) / np.sqrt(run.variance)
                for number, member in enumerate(members):
                    J[cause == number, 3 * member + i] = (
                        change.ravel()[cause == number] / steps[member, i])
        enough = run.deviance - ENOUGH
        step = damped_step(
            J.T @ J, J.T @ run.residual.ravel(), partial(moved_by, theta, reach),
            partial(_gain, enough), damping, BURST_RULE)
        if step is None:
            break
        (theta, run), damping = step
    return theta


def follows_motion(whole: JointLikelihood, fit: InnovationFit, theta: Array, owner: Integers
                   ) -> bool:
    """
    Return whether bursts fill the time in which one quantity of the motion is in one range.

    Bursts at times of their own leave the range that the quantity has during several of them to
    most other times, too.

    Args:
        whole: likelihood of the recordings.
        fit: of the model without bursts.
        theta: bursts, see with_bursts.
        owner: see with_bursts.
    """
    if len(theta) < 2:
        return False
    acts: list[Flags] = []
    moved: dict[str, list[Array]] = {}
    for i, (part, states) in enumerate(zip(whole.parts, whole.smoothed(
            evaluated(whole, fit).run))):
        index = np.flatnonzero(np.isfinite(states[:, 0]))
        acts.append(torque_of(theta[owner == i], part.recording)[index] != 0.0)
        for name, x in named_motion(part.recording, states, index).items():
            moved.setdefault(name, []).append(x)
    inside = np.concatenate(acts)
    if not inside.any():
        return False
    for name in moved.keys() - {'time'}:
        x = np.concatenate(moved[name])
        low, high = np.percentile(x[inside], (EDGES, 100.0 - EDGES))
        elsewhere = ((x > low) & (x < high) & ~inside).sum()
        if elsewhere < THRESHOLDS.followed * inside.sum():
            return True
    return False


def _gain(enough: float, trial: tuple[Array, JointlyFiltered]) -> float:
    """Return by how much a trial is below a -2 log L that is enough."""
    return enough - trial[1].deviance


def _apart(theta: Array, owner: Integers) -> list[Integers]:
    """Return numbers of bursts in the order of time, in groups, FORGOTTEN apart."""
    begins = owner * FAR + theta[:, 0]
    order = np.argsort(begins)
    groups = next(count for count in range(1, len(order) + 1)
                  if (begins[order[count:]] - begins[order[:-count]] > FORGOTTEN).all())
    return [order[first::groups] for first in range(groups)]


def pulses_in(runs: WindowRuns, price: float) -> Array:
    """
    Return the bursts [B, 3] that free runs lack, see with_bursts.

    Args:
        runs: free runs over the windows of one recording.
        price: chi2 that a burst must gain in addition to the price of its place.
    """
    if 'arm_side' not in visible_places(runs):
        return np.zeros((0, 3))
    bursts, windows, gains = rectangles(InputEstimator(runs, 'arm_side').solve(), price)
    bursts[:, 0] += runs.data.windows.first[windows] * runs.recording.dt
    # Windows overlap: one burst is found in several of them, best in the middle of one.
    apart: list[int] = []
    for number in np.argsort(-gains):
        if (np.abs(bursts[apart, 0] - bursts[number, 0]) > THRESHOLDS.longest_burst).all():
            apart.append(int(number))
    return bursts[sorted(apart)]


def rectangles(free: InputEstimate, price: float) -> tuple[Array, Integers, Array]:
    """
    Return the bursts in a free-form torque to first order, their windows and gains in chi2.

    At most one in each window: that of the largest likelihood ratio (Willsky and Jones, 1976),
    the torque elsewhere being 0.

    Args:
        free: free-form input estimate.
        price: chi2 that a burst must gain in addition to the price of its place.

    Returns:
        Bursts [B, 3], their begin from that of the window, the numbers [B] of the windows, and
        the gains [B].
    """
    values = free.signal.shape[1]
    price += 2.0 * float(np.log(values * (values + 1) / 2))
    bursts, windows, gains = [], [], []
    for window, (precision, signal) in enumerate(zip(free.precision, free.signal)):
        force = precision @ signal
        highest, amplitude, begin, end = price, 0.0, 0, 0
        for first in range(values):
            longest = round(THRESHOLDS.longest_burst / SPACING)
            for last in range(first, min(first + longest, values)):
                run = slice(first, last + 1)
                along, power = float(force[run].sum()), float(precision[run, run].sum())
                if along ** 2 > highest * power:
                    highest, amplitude = along ** 2 / power, along / power
                    begin, end = first, last + 1
        if end:
            windows.append(window)
            gains.append(highest)
            bursts.append(((begin - 0.5) * SPACING, (end - begin) * SPACING, amplitude))
    return np.array(bursts).reshape(-1, 3), np.array(windows, int), np.array(gains)
