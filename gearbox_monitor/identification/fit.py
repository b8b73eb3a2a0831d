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
Fit a candidate to the windows of a recording: Gauss-Newton with the window states eliminated.

Residuals are in standard deviations of the encoders. Each window has 4 states of its own (motor
and arm position and speed where it begins); the candidate's coordinates are fitted jointly.

data: Data, what is fitted; simulator: runs it; candidate: Candidate, point: Point. model:
DriveModel; states, memory [W, 4]: of drive and effects where windows begin; carry: what they
become one window later; index [M]: numbers of windows; extra: free-form signals. residual [W, 2L]:
in sigmas; chi2 [W]: its squares. train [W]: windows whose fit moves coordinates; weight [W]:
theirs; robust: windows that stand out weigh less; weighing, colour, whiten: noise that is not
white, see gap.lasting, gap.colour (phi [2]) and gap.process_noise. half_gap: rad, on which states
are tried elsewhere. iterations: at most; which: coordinates; stretch: factor on their steps; z
[P]: coordinates.
"""
from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TYPE_CHECKING, TypeAlias

import numpy as np

from gearbox_monitor.identification.candidates import Candidate
from gearbox_monitor.identification.noise import whitened
from gearbox_monitor.identification.recording import Recording
from gearbox_monitor.identification.windows import N_MEMORY, Simulator, Windows
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, MEMORIES

if TYPE_CHECKING:
    from gearbox_monitor.identification.model_error import Weighing

STATE_STEPS = np.array([1e-5, 1e-5, 1e-3, 1e-3])
ROBUST = 2.5   # times the median chi2: windows above count less
WORST = 1e6  # standard deviations
RIVAL = 6.0  # chi2 by which another fit of a window is better, from which on its start is tried
ROUGH, KEPT_STARTS = 2, 3  # iterations from all starts; how many go on
SHARES = (0.1, 0.2, 0.4, 0.7, 1.0)  # of the windows, on which states are found step by step
STUCK = 1.15   # times the median chi2: windows above are tried from elsewhere
UNSET: Any = None  # of a Point that was not evaluated yet
Reduced: TypeAlias = tuple[Array, Array, Array, Array]


@dataclass
class Point:
    """
    Where a fit stands: coordinates z [P], states [W, 4] and memory [W, 4] of the windows.

    residual [W, 2L] in standard deviations, chi2 [W] its square sum, carry [W, 8] the states where
    the next window begins.
    """

    z: Array
    states: Array
    memory: Array
    residual: Array = UNSET
    chi2: Array = UNSET
    carry: Array = UNSET


class Data:
    """Readings of `windows` in units of sigma, and which windows may move the coordinates."""

    def __init__(self, recording: Recording, simulator: Simulator, windows: Windows, sigma: Array,
                 train: Flags | None = None, weighing: 'Weighing | None' = None,
                 colour: Array | None = None) -> None:
        self.weighing, self.colour = weighing, colour
        self.recording, self.simulator, self.windows = recording, simulator, windows
        self.channels = list(recording.channels)
        self.sigma = np.asarray(sigma, float)
        index = windows.first[:, None] + np.arange(windows.length)
        self.y = recording.y[index][:, :, self.channels]
        self.train = np.ones(len(windows), bool) if train is None else train

    @property
    def n_train(self) -> int:
        """Number of readings in the windows that count, as many as they count for."""
        n = int(self.train.sum()) * self.size
        if self.weighing is None:
            return n
        return max(1, round(n * self.weighing.shares[self.channels].mean()))

    @property
    def size(self) -> int:
        """Number of readings in a window: L samples of C encoders."""
        return self.windows.length * len(self.channels)

    def parted(self, residual: Array) -> Array:
        """Return `residual` [W, C L] as [W, L, C]."""
        return residual.reshape(len(residual), self.windows.length, len(self.channels))

    def residual(self, model: DriveModel, states: Array, memory: Array,
                 index: Integers | None = None, extra: Array | None = None) -> tuple[Array, Array]:
        """Return (residual [W, 2L], carry [W, 8]) of the windows `index` (default: all)."""
        windows = self.windows if index is None else self.windows.take(index)
        y, carry = self.simulator.run(windows, model, states, memory, extra)
        measured = self.y if index is None else self.y[index]
        r = (measured - y[:, :, self.channels]) / self.sigma[self.channels]
        # A run that diverges is as bad as can be, and still a number.
        r = self.white(np.clip(np.nan_to_num(r, nan=WORST), -WORST, WORST), self.channels)
        if self.weighing is not None:
            r = self.weighing(r, self)
        return r.reshape(len(y), -1), carry

    def white(self, residual: Array, channels: list[int]) -> Array:
        """Return `residual` [W, L, C], in sigmas of the encoders `channels`, with white noise."""
        return residual if self.colour is None else whitened(residual, self.colour[channels])

    def plain(self) -> 'Data':
        """Return the Data whose residuals count in standard deviations of the noise."""
        if self.weighing is None:
            return self
        return Data(self.recording, self.simulator, self.windows, self.sigma, self.train,
                    colour=self.colour)

    def uncoloured(self) -> 'Data':
        """Return the Data whose residuals are the distances of the readings, in sigmas."""
        return Data(self.recording, self.simulator, self.windows, self.sigma, self.train)

    def evaluate(self, candidate: Candidate, point: Point) -> Point:
        """Fill in residual, chi2 and carry of `point`; return it."""
        point.residual, point.carry = self.residual(
            candidate.model(point.z), point.states, point.memory)
        point.chi2 = _squares(point.residual)
        return point

    def raw_states(self) -> Array:
        """Return states [W, 4] where the windows begin, from straight lines through readings."""
        y, dt, n = self.recording.y, self.recording.dt, len(self.recording.y)
        half = max(2, round(0.006 / dt))
        states = np.empty((len(self.windows), 4))
        for w, k in enumerate(self.windows.begin):
            low, high = max(0, k - half), min(n, k + half + 1)
            t = (np.arange(low, high) - k) * dt
            line = np.polyfit(t, y[low:high], 2 if high - low > 4 else 1)
            states[w, :2], states[w, 2:] = line[-1], line[-2]
        return states


def _squares(residual: Array) -> Array:
    return np.einsum('wl,wl->w', residual, residual)


def carried(memory: Array, carry: Array) -> Array:
    """Return memory [W, 4] with that of each window's predecessor."""
    moved = memory.copy()
    moved[1:] = carry[:-1, 4:]
    return moved


def state_sensitivity(data: Data, model: DriveModel, states: Array, memory: Array, residual: Array,
                      index: Integers | None = None) -> Array:
    """Return d(-residual)/d(states) [W, 2L, 4]."""
    if data.simulator.begins_known:
        return np.zeros((*residual.shape, 4))
    index = np.arange(len(states)) if index is None else index
    # All in one call: the more windows side by side, the faster.
    moved = (states + np.diag(STATE_STEPS)[:, None]).reshape(-1, 4)
    r, _ = data.residual(model, moved, np.tile(memory, (4, 1)), np.tile(index, 4))
    change = residual - r.reshape(4, *residual.shape)
    return np.moveaxis(change / STATE_STEPS[:, None, None], 0, -1)


def solve_states(data: Data, model: DriveModel, states: Array, memory: Array, index: Integers,
                 iterations: int = 6) -> tuple[Array, Array]:
    """
    Fit only the states of the windows `index` [M]; return (states [M, 4], chi2 [M]).

    Levenberg-Marquardt, each window with a damping of its own; those that have arrived wait.
    """
    states, index = states.copy(), np.asarray(index)
    residual, _ = data.residual(model, states, memory, index)
    chi2 = _squares(residual)
    if data.simulator.begins_known:
        return states, chi2
    damping = np.full(len(states), 1e-3)
    A, g = np.empty((len(states), 4, 4)), np.empty((len(states), 4))
    moved = active = np.arange(len(states))
    for _ in range(iterations):
        if len(moved):
            J = state_sensitivity(data, model, states[moved], memory[moved], residual[moved],
                                  index[moved])
            A[moved] = np.einsum('wli,wlj->wij', J, J)
            g[moved] = np.einsum('wli,wl->wi', J, residual[moved])
        damped = A[active]
        diagonal = np.einsum('wii->wi', damped)
        damped[:, range(4), range(4)] += diagonal * damping[active, None] + 1e-9
        trial = states[active] + np.linalg.solve(damped, g[active, :, None])[:, :, 0]
        r, _ = data.residual(model, trial, memory[active], index[active])
        after = _squares(r)
        gain = chi2[active] - after
        better = gain > 0.0
        damping[active] = np.where(better, damping[active] * 0.1,
                                   np.minimum(damping[active] * 20.0, 1e6))
        arrived = np.where(better, gain < 1e-3 * chi2[active], damping[active] > 1.0)
        moved = active[better]
        states[moved], residual[moved], chi2[moved] = trial[better], r[better], after[better]
        moved, active = active[better & ~arrived], active[~arrived]
        if not len(active):
            break
    return states, chi2


def shortened(data: Data, share: float) -> Data:
    """Return Data of the first `share` of each window."""
    if share == 1.0:
        return data
    w = data.windows
    length = max(round(share * w.length), 8)
    return Data(data.recording, data.simulator,
                Windows(w.first, length, w.begin, w.first + length), data.sigma, data.train,
                data.weighing, data.colour)


def grown_states(data: Data, model: DriveModel, memory: Array, index: Integers, half_gap: float,
                 last: float = 1.0) -> Array:
    """
    Return states [M, 4] of the windows `index`, found on their beginnings, which get longer.

    Over a long window states far off lead to runs that have nothing to do with the readings; over
    a short one every start arrives. last: the share of the windows to end with.
    """
    raw = data.raw_states()[index]
    starts = [raw]
    for i, size in ((3, 1.5), (3, -1.5), (1, 0.6 * half_gap), (1, -0.6 * half_gap)):
        moved = raw.copy()
        moved[:, i] += size
        starts.append(moved)
    tried = np.stack(starts, axis=1)
    every = np.repeat(index, tried.shape[1])
    states, chi2 = solve_states(shortened(data, SHARES[0]), model, tried.reshape(-1, 4),
                                memory[every], every)
    best = chi2.reshape(len(index), -1).argmin(axis=1)
    states = states.reshape(len(index), -1, 4)[np.arange(len(index)), best]
    for share in SHARES[1:]:
        if share <= last:
            states, _ = solve_states(shortened(data, share), model, states, memory[index], index)
    return states


def grow(data: Data, candidate: Candidate, point: Point, half_gap: float) -> Point:
    """Return a Point of `candidate` fitted on the windows' beginnings, which get longer."""
    every = np.arange(len(data.windows))
    grown = Point(point.z.copy(), UNSET, point.memory.copy())
    grown.states = grown_states(data, candidate.model(grown.z), grown.memory, every, half_gap,
                                SHARES[0])
    for share in SHARES:
        part = shortened(data, share)
        grown = Point(grown.z, grown.states, grown.memory)
        if share > SHARES[0]:
            grown.states, _ = solve_states(part, candidate.model(grown.z), grown.states,
                                           grown.memory, every)
        fit(part, candidate, grown, 5, robust=True)
    return grown


def rescue(data: Data, candidate: Candidate, point: Point, others: Sequence[Point] = (),
           half_gap: float = 0.05) -> int:
    """
    Try other starts for windows that stand out; return how many became better.

    others: Points of other fits. Where one of them is better, its start is tried, too: one that
    only one candidate has found must not be its merit.
    """
    if data.simulator.begins_known:
        return 0
    better = _try_memories(data, candidate, point)
    stuck = point.chi2 > max(STUCK * float(np.median(point.chi2)), 1.12 * data.size)
    behind = np.zeros(len(stuck), bool)
    for other in others:
        behind |= other.chi2 < point.chi2 - RIVAL
    for windows, anywhere in ((np.flatnonzero(stuck), True),
                              (np.flatnonzero(behind & ~stuck), False)):
        if not len(windows):
            continue
        starts = _rival_states(others, windows)
        if anywhere:
            starts.append(grown_states(data, candidate.model(point.z), point.memory, windows,
                                       half_gap))
            if point.carry is not None:
                starts.append(np.where(windows[:, None] > 0,
                                       point.carry[np.maximum(windows - 1, 0), :4], starts[-1]))
        better += _try_starts(data, candidate, point, windows, np.stack(starts, axis=1))
    if better:
        data.evaluate(candidate, point)
    return better


def _try_memories(data: Data, candidate: Candidate, point: Point) -> int:
    """
    Try other memories of a hysteresis where windows begin; return how many became better.

    What a fit that was still far off handed over may hold a window back for ever.
    """
    starts = {MEMORIES[i]: EFFECTS[i].memory_starts for i in candidate.ids
              if i in MEMORIES and EFFECTS[i].memory_starts}
    every, better = np.arange(len(point.states)), np.zeros(len(point.states), bool)
    for values in zip(*starts.values()):
        memory = point.memory.copy()
        memory[:, list(starts)] = values
        states, chi2 = solve_states(data, candidate.model(point.z), point.states, memory, every)
        use = chi2 < point.chi2 - RIVAL
        point.states[use], point.memory[use], point.chi2[use] = states[use], memory[use], chi2[use]
        better |= use
    return int(better.sum())


def _rival_states(others: Sequence[Point], windows: Integers) -> list[Array]:
    """Return the states [M, 4] of the Points `others` that fit `windows` best, as a list."""
    if not others:
        return []
    found = np.stack([other.chi2[windows] for other in others])
    states = np.stack([other.states[windows] for other in others])
    return [states[best, np.arange(len(windows))]
            for best in np.argsort(found, axis=0)[:KEPT_STARTS]]


def _try_starts(data: Data, candidate: Candidate, point: Point, windows: Integers,
                starts: Array) -> int:
    """Move the states of `windows` [M] to the best of `starts` [M, S, 4]; return how many."""
    model = candidate.model(point.z)
    for iterations, kept in ((ROUGH, KEPT_STARTS), (6 - ROUGH, 1)):
        index = np.repeat(windows, starts.shape[1])
        states, chi2 = solve_states(data, model, starts.reshape(-1, 4), point.memory[index],
                                    index, iterations)
        chi2 = chi2.reshape(len(windows), -1)
        order = np.argsort(chi2, axis=1)[:, :kept]
        starts = np.take_along_axis(states.reshape(len(windows), -1, 4), order[:, :, None], axis=1)
    chi2 = chi2.min(axis=1)
    better = chi2 < point.chi2[windows] * (1 - 1e-4) - 1e-3
    point.states[windows[better]] = starts[better, 0]
    return int(better.sum())


def weights(data: Data, chi2: Array, robust: bool) -> Array:
    """Return the weight [W] of each window on the coordinates."""
    weight = data.train.astype(float)
    if robust:
        median = np.median(chi2[data.train])
        weight *= np.minimum(1.0, ROBUST * median / np.maximum(chi2, 1e-30))
    return weight


@dataclass
class Sensitivity:
    """Derivatives of -residual by states Jx [W, 2L, 4] and coordinates Jz [W, 2L, P]."""

    Jx: Array
    Jz: Array


def coordinate_sensitivity(data: Data, candidate: Candidate, point: Point,
                           which: Iterable[int] | None = None, stretch: float = 1.0) -> Array:
    """Return d(-residual)/dz [W, 2L, P]; memories stay as they are."""
    steps = stretch * data.simulator.stretch * candidate.steps()
    which = range(len(steps)) if which is None else which
    out = np.zeros((*point.residual.shape, len(steps)))
    for i in which:
        moved = point.z.copy()
        moved[i] += steps[i]
        step = steps[i]
        if candidate.bounded(moved)[i] != moved[i]:
            step = -step
            moved[i] = point.z[i] + step
        r, _ = data.residual(candidate.model(moved), point.states, point.memory)
        before = point.residual
        if data.simulator.stretch > 1.0:  # over so long a step, one side alone tells another slope
            moved[i] = point.z[i] - step
            if candidate.bounded(moved)[i] == moved[i]:
                before, _ = data.residual(candidate.model(moved), point.states, point.memory)
                step *= 2.0
        out[:, :, i] = (before - r) / step
    return out


def sensitivity(data: Data, candidate: Candidate, point: Point) -> Sensitivity:
    """Return the Sensitivity at `point`."""
    model = candidate.model(point.z)
    return Sensitivity(
        state_sensitivity(data, model, point.states, point.memory, point.residual),
        coordinate_sensitivity(data, candidate, point))


def normal_equations(s: Sensitivity, residual: Array, weight: Array,
                     whiten: Callable[[Array], Array] | None = None) -> Reduced:
    """
    Return (S [P, P], g [P], X [W, 4, P], x [W, 4]): the reduced normal equations.

    The states' step is x - X dz. weight [W]. whiten(array [W, 2L, ...]) applies the noise model.
    """
    Jx, Jz, r = s.Jx, s.Jz, residual
    if whiten is not None:
        Jx, Jz, r = whiten(Jx), whiten(Jz), whiten(r)
    A = np.einsum('wli,wlj->wij', Jx, Jx)
    A[:, range(4), range(4)] *= 1.0 + 1e-9
    A[:, range(4), range(4)] += 1e-9
    B = np.einsum('wli,wlj->wij', Jx, Jz)
    gx = np.einsum('wli,wl->wi', Jx, r)
    solved = np.linalg.solve(A, np.concatenate([B, gx[:, :, None]], axis=2))
    X, x = solved[:, :, :-1], solved[:, :, -1]
    full = np.einsum('wli,wlj->wij', Jz, Jz) - np.einsum('wki,wkj->wij', B, X)
    g = np.einsum('wli,wl->wi', Jz, r) - np.einsum('wki,wk->wi', B, x)
    return np.einsum('w,wij->ij', weight, full), weight @ g, X, x


def damped_solve(S: Array, g: Array, damping: float) -> Array:
    """Solve S dz = g, scaled by its diagonal, Levenberg-Marquardt damping on it."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(S), 1e-12 * max(np.diag(S).max(initial=0.0), 1e-30)))
    scaled = S * scale[:, None] * scale
    scaled[np.diag_indices_from(scaled)] += damping
    return scale * np.linalg.solve(scaled, scale * g)


def gained(S: Array, g: Array, known: int) -> float:
    """
    Return the gain in chi2 of the coordinates from number `known` on, the first ones free as well.

    S [P, P], g [P]: see normal_equations.
    """
    if len(g) == known:
        return 0.0
    total = damped_solve(S, g, 1e-9) @ g
    before = damped_solve(S[:known, :known], g[:known], 1e-9) @ g[:known] if known else 0.0
    return float(total - before)


def fit(data: Data, candidate: Candidate, point: Point, iterations: int = 4, robust: bool = False,
        refresh: Container[int] = (0, 1, 3), whiten: Callable[[Array], Array] | None = None,
        tolerance: float = 0.05) -> Point:
    """
    Improve `point` in place (z, states, memory); return it.

    refresh: iterations at which the sensitivities are made anew. Stops when a step gains less
    than `tolerance` in chi2.
    """
    if point.residual is None:
        data.evaluate(candidate, point)
    if data.simulator.fit is not None:
        return data.simulator.fit(data, candidate, point, iterations, robust, tolerance)
    damping, s = 1e-6, None
    for k in range(iterations):
        weight = weights(data, point.chi2, robust)
        before = objective(candidate, point, weight, whiten)
        if s is None or k in refresh:
            s = sensitivity(data, candidate, point)
        S, g, X, x = normal_equations(s, point.residual, weight, whiten)
        pull, prior = candidate.prior(point.z)
        S = S + np.diag(prior)
        g = g - pull
        improved = False
        for _ in range(4):
            dz = damped_solve(S, g, damping) if len(g) else np.zeros(0)
            z = candidate.bounded(point.z + dz)
            dz = z - point.z
            trial = Point(z, point.states + x - np.einsum('wij,j->wi', X, dz), point.memory)
            data.evaluate(candidate, trial)
            _keep_states(data, candidate, point, trial)
            if objective(candidate, trial, weight, whiten) < before:
                improved = True
                break
            damping = max(damping * 100.0, 1e-3)
        if not improved:
            if k in refresh:
                break
            s, damping = None, 1e-6
            continue
        damping = max(damping * 0.1, 1e-9)
        gain = before - objective(candidate, trial, weight, whiten)
        for name in ('z', 'states', 'residual', 'chi2', 'carry'):
            setattr(point, name, getattr(trial, name))
        if uses_memory(candidate):
            hand_over(data, candidate, point)
        if gain < tolerance:
            break
    return point


def hand_over(data: Data, candidate: Candidate, point: Point) -> None:
    """Give windows the memory with which their predecessor ends, where they can live with it."""
    moved = data.evaluate(candidate, Point(
        point.z, point.states, carried(point.memory, point.carry)))
    # Near a reversal a little change elsewhere turns a memory over; then the last one is better.
    use = moved.chi2 < point.chi2 + RIVAL
    for name in ('memory', 'residual', 'chi2', 'carry'):
        getattr(point, name)[use] = getattr(moved, name)[use]


def _keep_states(data: Data, candidate: Candidate, point: Point, trial: Point) -> None:
    """Let windows of `trial` that became worse keep their states of `point` where that helps."""
    worse = np.flatnonzero(trial.chi2 > point.chi2)
    if not len(worse) or data.simulator.begins_known:
        return
    residual, carry = data.residual(candidate.model(trial.z), point.states[worse],
                                    point.memory[worse], worse)
    chi2 = _squares(residual)
    use = chi2 < trial.chi2[worse]
    worse = worse[use]
    trial.states[worse], trial.residual[worse] = point.states[worse], residual[use]
    trial.chi2[worse], trial.carry[worse] = chi2[use], carry[use]


def objective(candidate: Candidate, point: Point, weight: Array,
              whiten: Callable[[Array], Array] | None = None) -> float:
    """Return what a fit makes small: weighted chi2 (whitened) and the prior."""
    chi2 = point.chi2 if whiten is None else _squares(whiten(point.residual))
    return float(weight @ chi2) + candidate.penalty(point.z)


def uses_memory(candidate: Candidate) -> bool:
    """Return whether windows hand anything over but their states."""
    return candidate.nominal.transmission.kind in ('play', 'passive_play') or any(
        i in MEMORIES for i in candidate.ids)


def fresh(data: Data, candidate: Candidate, states: Array | None = None) -> Point:
    """Return a Point at the candidate's start; states [W, 4] default to those of the readings."""
    states = data.raw_states() if states is None else states.copy()
    return Point(candidate.start(), states, np.zeros((len(data.windows), N_MEMORY)))


def copied(point: Point, z: Array | None = None) -> Point:
    """Return a copy of `point` (at other coordinates: not evaluated)."""
    moved = replace(point, z=(point.z if z is None else z).copy(), states=point.states.copy(),
                    memory=point.memory.copy())
    if z is not None:
        moved.residual = moved.chi2 = moved.carry = UNSET
    return moved
