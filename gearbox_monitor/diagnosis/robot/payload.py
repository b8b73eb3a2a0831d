# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a moving robot holds, and who pushes it: its balance as a Kalman filter, ten times a second.

Each window multiplies the equation of motion by a Hann window and integrates by parts, so that no
acceleration is formed. What the model leaves is explained by a payload, by errors of the model
(friction, links, rotors, lag; constants that wander slowly) and by noise; what none of them
explains is external torque. While a joint rests, its friction is any torque up to Coulomb's: a
state of its own that begins whenever the joint comes to rest.

A payload that is taken or put down is a jump (Adams and MacKay 2007): filters that forgot the
payload at different times run side by side, each weighted by its likelihood, and what is published
is their mean. A push is no payload as long as no payload explains it: a constant pull straight
down is one, and any push of a robot with few joints looks like one until it ends.
"""
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.knowledge import Knowledge
from gearbox_monitor.diagnosis.robot.motion import RobotMotion, TestFunctions
from gearbox_monitor.diagnosis.robot.robot_effects import centre_of, compact
from gearbox_monitor.diagnosis.robot.rows import RobotModel, Rows, tested
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array, Flags

SECOND = 1_000_000_000


@dataclass(frozen=True)
class PayloadSettings:
    """
    Limits of the tracker, in s unless named otherwise.

    hop: between estimates; half: half width of the Hann window; reach: of the polynomial of
    `degree` in each position, wider than the window, since a polynomial is worst at its ends:
    degree 5 over 0.5 s follows 3 Hz to 1 %. points: of the grid within the window. gap: between
    samples, after which the motion is not continued.
    heaviest kg, farthest m: two standard deviations of what may be held, before it is seen.
    walk: of the payload, share of `heaviest` per square root of a second (a box that is filled).
    friction, rotor: standard deviations before anything is seen without a reference, of Coulomb
    friction and of viscous friction at 1 rad/s, and of the rotor at 20 rad/s^2, in rms torques of
    the joint (friction of gears takes up to a third of the torque). hour: in which friction
    becomes as uncertain as at the beginning (temperature). rest_time: in which the friction of a
    resting joint forgets itself. often: between changes of the payload, as expected. filters: side
    by side, of which the times of their changes go back in steps of equal ratio; spawn: windows
    between them. push: prior probability of a window with external torque, `loud` times the noise.
    memory: windows over which noise is measured, by the
    median: a push that lasts for less than half of it is none; belief: windows that its first
    guess, `guess` rms torques, counts for. block: windows whose mean tells how coloured the noise
    is. settle: windows in motion before the first estimate; smallest: size of a torque of which
    they show little, share of the largest joint's.
    """

    hop: float = 0.1
    half: float = 0.1
    reach: float = 0.25
    degree: int = 5
    points: int = 21
    gap: float = 0.1
    heaviest: float = 10.0
    farthest: float = 0.4
    walk: float = 0.002
    friction: float = 0.3
    rotor: float = 0.3
    hour: float = 3600.0
    rest_time: float = 20.0
    often: float = 30.0
    filters: int = 8
    spawn: int = 3
    push: float = 0.01
    loud: float = 10.0
    memory: int = 600
    belief: float = 10.0
    guess: float = 0.03
    block: int = 30
    settle: int = 20
    smallest: float = 0.1


PAYLOAD_SETTINGS = PayloadSettings()
N_PAYLOAD = 4  # m and m c
MEDIAN = 0.4549  # of chi squared with one degree of freedom
SEEN = 2.0  # deviations from which a mass has a centre to linearise about


@dataclass(frozen=True, eq=False)
class PayloadEstimate:
    """
    What a robot holds and who pushes it, at a time.

    stamp_ns: middle of the window. mass kg, centre [3] m in the frame of the link; deviations,
    NaN below the mass's deviation. since_ns: of the last change of the payload, 0: none
    seen. external [J], external_std [J]: torque on the joints by no model, positive where it helps
    the motor, N m.
    """

    stamp_ns: int
    mass: float
    mass_std: float
    centre: Array
    centre_std: Array
    since_ns: int
    external: Array
    external_std: Array


@dataclass(frozen=True, eq=False)
class _Window:
    """
    A window: y [J] N m, columns h [J, K] of errors, weight [J, 10] of a payload.

    resting: share of the window in which a joint rests [J]; effort, dry friction: N m [J].
    """

    stamp_ns: int
    y: Array
    h: Array
    weight: Array
    resting: Array
    effort: Array
    dry: Array


@dataclass(frozen=True, eq=False)
class _State:
    """Mean [S] and covariance [S, S] of payload, errors and friction at rest."""

    mean: Array
    covariance: Array


@dataclass(frozen=True, eq=False)
class _Held:
    """A filter that forgot the payload at `since_ns`, window number `since`; log of its weight."""

    state: _State
    weight: float
    since_ns: int
    since: int


def _hann() -> tuple[Array, TestFunctions]:
    """Return the grid [N] (s about the middle) and the window on it, of integral 1."""
    half = PAYLOAD_SETTINGS.half
    t = np.linspace(-half, half, PAYLOAD_SETTINGS.points)
    step, phase = float(t[1] - t[0]), np.pi * t / half
    value = 0.5 * (1.0 + np.cos(phase)) / half
    slope = -0.5 * np.sin(phase) * np.pi / half ** 2
    count = len(t)
    return t, TestFunctions(step * value[:, None], step * slope[:, None], np.zeros(1, int),
                            np.zeros(1), np.zeros(1, int), np.ones((count, 1)),
                            np.zeros((count, 1)))


class PayloadTracker:
    """
    Tracks payload and external torque of a `robot`, sample by sample.

    link: name of the one that carries, '' for the last of the chain. knowledge: what healthy
    recordings taught; None, the file with its tolerances. empty: nothing is held at first.
    """

    def __init__(self, robot: RobotModel, link: str = '', knowledge: Knowledge | None = None,
                 empty: bool = False) -> None:
        names = [x.name for x in robot.chain.links]
        if link and link not in names:
            raise InputError(f'link: {unknown(link, names)}')
        self.link = link or names[-1]
        self._robot = replace(robot, learnt=knowledge is not None)
        self._knowledge, self._index = knowledge, names.index(self.link)
        # What differs between healthy parts of the reference differs now, too.
        self._dispersion: Array = np.ones(1) if knowledge is None else knowledge.dispersion
        self._empty = empty
        self._grid, tests = _hann()
        count = len(names)
        self._tests = replace(tests, mask=np.repeat(tests.mask, count, 1),
                              mask_slope=np.repeat(tests.mask_slope, count, 1))
        self._joints = count
        self._begin()

    def _begin(self) -> None:
        """Forget everything."""
        self._samples: deque[tuple[int, Array, Array]] = deque()
        self._origin: int | None = None  # ns: first stamp; windows stand at its multiples of hop
        self._next = 0          # ns after the origin: middle of the next window, 0: none
        self._waiting: list[_Window] = []
        self._held: list[_Held] = []  # the likeliest one first
        self._count = 0               # of windows

    # ------------------------------------------------------------------ samples

    def take(self, stamp_ns: int, position: Sequence[float] | Array,
             effort: Sequence[float] | Array) -> list[PayloadEstimate]:
        """
        Return the estimates that a sample completes: none, or one and rarely more.

        Args:
            stamp_ns: of the measurement.
            position: [J] rad or m, in the order of the model; a sample with NaN is left out.
            effort: [J] N m or N.
        """
        q, u = np.array(position, float), np.array(effort, float)
        if not (np.isfinite(q).all() and np.isfinite(u).all()):
            return []
        samples, s = self._samples, PAYLOAD_SETTINGS
        if self._origin is None:
            self._origin = stamp_ns
        elapsed = stamp_ns - self._origin
        if samples:
            step = (elapsed - samples[-1][0]) / SECOND
            if -s.reach < step <= 0.0:
                return []
            if step <= 0.0 or step > s.gap:
                samples.clear()
                self._next = 0
                if step < 0.0:      # the clock was set back: another motion
                    self._begin()
                    self._empty = False
                    self._origin, elapsed, samples = stamp_ns, 0, self._samples
        samples.append((elapsed, q, u))
        hop, reach = round(s.hop * SECOND), round(s.reach * SECOND)
        if not self._next:
            self._next = -(-(elapsed + reach) // hop) * hop
        out: list[PayloadEstimate] = []
        while elapsed >= self._next + reach:
            window = self._window(self._next)
            self._next += hop
            while samples and samples[0][0] < self._next - reach:
                samples.popleft()
            if window is not None:
                out += self._filtered(replace(window, stamp_ns=self._origin + window.stamp_ns))
        return out

    def tare(self) -> None:
        """State that the robot holds nothing now: what seems held is the model's error."""
        if not self._held:
            self._empty = True
            return
        state = self._held[0].state
        h = np.eye(N_PAYLOAD, len(state.mean))
        noise = np.array([1e-3, *[1e-3 * PAYLOAD_SETTINGS.farthest] * 3]) ** 2
        self._held = [_Held(_updated(state, h, -h @ state.mean, noise)[0], 0.0, 0, self._count)]

    def _window(self, middle: int) -> _Window | None:
        """Return the _Window about `middle` (ns after the origin), None of too few samples."""
        s, samples = PAYLOAD_SETTINGS, []
        for sample in self._samples:
            if abs(sample[0] - middle) <= s.reach * SECOND:
                samples.append(sample)
        if len(samples) < 2 * (s.degree + 1):
            return None
        t = np.array([(stamp - middle) / SECOND for stamp, _, _ in samples])
        q, u = np.array([x for _, x, _ in samples]), np.array([x for _, _, x in samples])
        basis = np.vander(t / s.reach, s.degree + 1, increasing=True)
        inverse = np.linalg.inv(basis.T @ basis)
        coefficients = inverse @ (basis.T @ q)
        residual = q - basis @ coefficients
        sigma = np.sqrt((residual ** 2).sum(axis=0) / (len(t) - s.degree - 1))
        at = np.vander(self._grid / s.reach, s.degree + 1, increasing=True)
        order = np.arange(1, s.degree + 1)
        speed = at[:, :-1] @ (coefficients[1:] * order[:, None]) / s.reach
        step = float(self._grid[1] - self._grid[0])
        # The means of the effort about the points of the grid: nothing is lost of a faster log.
        edges = np.append(self._grid - 0.5 * step, self._grid[-1] + 0.5 * step)
        whole = scipy.integrate.cumulative_trapezoid(u, t, axis=0, initial=0.0)
        effort = np.diff(np.column_stack([np.interp(edges, t, c) for c in whole.T]), axis=0) / step
        motion = RobotMotion(self._grid, at @ coefficients, speed, effort, np.zeros_like(speed),
                             sigma * math.sqrt(inverse[1, 1]) / s.reach, sigma, step,
                             (slice(0, len(self._grid)),))
        knowledge = self._knowledge
        # In a short window the model's torque has the better slope: take the lag as a reading's.
        rows = tested(motion, self._tests, self._robot, knowledge.shapes if knowledge else (),
                      knowledge.mean if knowledge else None, measured=True)
        if not self._held and not self._waiting:
            self._columns(rows)
        h = np.zeros((self._joints, len(self._labels)))
        for k, column in enumerate(rows.nuisance):
            for j, x in column.rows.items():
                h[j, k] = x[0]
        weight = np.zeros((self._joints, 10))
        for j in self._robot.chain.movers[self._index]:
            weight[j] = rows.inertial[self._index, j][0]
        slow = np.abs(speed) < np.maximum(3.0 * motion.sigma_v, SETTINGS.slow)
        hann = self._tests.value[:, 0]
        return _Window(middle, rows.target[:, 0], h, weight, hann @ slow, hann @ effort,
                       np.array([np.abs(m.dry).mean() for m in rows.joints]))

    # ------------------------------------------------------------------ filter

    def _columns(self, rows: Rows) -> None:
        """Take the names of the model's errors, which are those of every window."""
        self._labels = tuple(c.label for c in rows.nuisance)
        self._deviation = np.array([c.deviation for c in rows.nuisance])
        self._wanders: Flags = np.array([c.group is not None for c in rows.nuisance])

    def _start(self, payload: Array) -> None:
        """Begin the filter, about a `payload` [4], with the size of the first torques."""
        s, count, k = PAYLOAD_SETTINGS, self._joints, len(self._labels)
        size = np.sqrt(np.mean([w.effort ** 2 for w in self._waiting], axis=0))
        self._size = np.maximum(size, s.smallest * size.max() + 1e-6)
        mean, covariance = np.zeros(k), np.diag(self._deviation ** 2)
        if self._knowledge is None:
            wide: dict[str, float] = {}
            for name, size in zip(self._robot.chain.joints, self._size):
                wide |= {f'armature {name}': s.rotor / 20.0 * size,
                         f'viscous {name}': s.friction * size,
                         f'coulomb {name}': s.friction * size}
            extra = np.array([wide.get(label, 0.0) for label in self._labels])
            covariance += np.diag(extra ** 2)
        else:
            prior = self._knowledge.prior
            place = {label: i for i, label in enumerate(prior.labels)}
            ours = np.array([i for i, label in enumerate(self._labels) if label in place])
            theirs = np.array([place[self._labels[i]] for i in ours])
            mean[ours] = prior.mean[theirs]
            covariance[np.ix_(ours, ours)] = prior.covariance[np.ix_(theirs, theirs)]
        self._wander = np.where(self._wanders, np.diag(covariance), 0.0) * s.hop / s.hour
        states = N_PAYLOAD + k + count
        whole = np.zeros((states, states))
        whole[N_PAYLOAD:N_PAYLOAD + k, N_PAYLOAD:N_PAYLOAD + k] = covariance
        if not self._empty:
            whole[:N_PAYLOAD, :N_PAYLOAD] = self._open()
        state = _State(np.concatenate([payload, mean, np.zeros(count)]), whole)
        self._held, self._count = [_Held(state, 0.0, 0, 0)], 0
        # Of a window, and as much as makes the means over blocks scatter as they do.
        self._noise: Array = (s.guess * self._size) ** 2
        self._noise_of_means = self._noise
        self._errors: deque[Array] = deque(maxlen=s.memory)
        self._was_resting: Array = np.zeros(count)

    def _open(self) -> Array:
        """Return the covariance [4, 4] of a payload about which nothing is known."""
        heavy = 0.5 * PAYLOAD_SETTINGS.heaviest
        farthest = heavy * 0.5 * PAYLOAD_SETTINGS.farthest
        return np.diag([heavy ** 2, farthest ** 2, farthest ** 2, farthest ** 2])

    def _filtered(self, window: _Window) -> list[PayloadEstimate]:
        """Take a window; return the estimates that are there now."""
        if self._held:
            return [self._step(window)]
        if window.resting.min() > 0.5:
            return []
        self._waiting.append(window)
        if len(self._waiting) < PAYLOAD_SETTINGS.settle:
            return []
        # Twice: the second time linearised about the centre that the first one ends with.
        payload: Array = np.zeros(N_PAYLOAD)
        for _ in range(2):
            self._start(payload)
            estimates = [self._step(w) for w in self._waiting]
            payload = payload if self._empty else self._held[0].state.mean[:N_PAYLOAD]
        self._waiting = []
        return estimates[-1:]

    def _step(self, window: _Window) -> PayloadEstimate:
        s, chance = PAYLOAD_SETTINGS, PAYLOAD_SETTINGS.hop / PAYLOAD_SETTINGS.often
        begins = (window.resting > 0.0) & (self._was_resting == 0.0)
        self._was_resting = window.resting
        states = [replace(x, state=self._predicted(x.state, window, begins),
                        weight=x.weight + math.log1p(-chance)) for x in self._held]
        self._count += 1
        if self._count % s.spawn == 0 and self._count > s.settle:
            states.append(_Held(self._reopened(states[0].state), math.log(s.spawn * chance),
                              window.stamp_ns, self._count))
        error = window.y - self._columns_at(states[0].state, window) @ states[0].state.mean
        self._held = self._thinned(self._weighed(states, window))
        self._measure_noise(error)
        return self._estimate(window)

    def _weighed(self, filters: Sequence[_Held], window: _Window) -> list[_Held]:
        """Return the filters after a window, the likeliest one first, the weights normalised."""
        weighted = []
        for x in filters:
            state, likelihood = self._corrected(x.state, window)
            weighted.append(replace(x, state=state, weight=x.weight + likelihood))
        total = float(scipy.special.logsumexp([x.weight for x in weighted]))
        return sorted((replace(x, weight=x.weight - total) for x in weighted),
                      key=lambda x: -x.weight)

    def _thinned(self, filters: list[_Held]) -> list[_Held]:
        """Return filters without one that is close to an older one, where they are too many."""
        if len(filters) <= PAYLOAD_SETTINGS.filters:
            return filters
        ages = {id(x): self._count - x.since + 1 for x in filters}
        by_age = sorted(filters, key=lambda x: ages[id(x)])
        closest, distance = by_age[0], math.inf
        for young, old in zip(by_age, by_age[1:]):
            lighter = young if young.weight < old.weight else old
            ratio = ages[id(old)] / ages[id(young)]
            if lighter is not filters[0] and ratio < distance:
                closest, distance = lighter, ratio
        return [x for x in filters if x is not closest]

    def _predicted(self, state: _State, window: _Window, begins: Flags) -> _State:
        """Return the state before a window: friction wanders, or begins with a rest."""
        s = PAYLOAD_SETTINGS
        mean, covariance = state.mean.copy(), state.covariance.copy()
        k = len(self._labels)
        at = np.arange(N_PAYLOAD, N_PAYLOAD + k)
        covariance[at, at] += self._wander
        covariance[:N_PAYLOAD, :N_PAYLOAD] += self._open() * (2.0 * s.walk) ** 2 * s.hop
        factor = np.where(begins, 0.0, math.exp(-s.hop / s.rest_time))
        tail = slice(N_PAYLOAD + k, None)
        mean[tail] *= factor
        covariance[tail] *= factor[:, None]
        covariance[:, tail] *= factor
        at = np.arange(N_PAYLOAD + k, len(mean))
        covariance[at, at] += (1.0 - factor ** 2) * self._coulomb(state, window) ** 2
        return _State(mean, covariance)

    def _coulomb(self, state: _State, window: _Window) -> Array:
        """Return the friction that each resting joint may have [J], N m."""
        if self._knowledge is not None:
            return np.maximum(self._knowledge.sizes, window.dry)
        chain, out = self._robot.chain, np.zeros(self._joints)
        for j, name in enumerate(chain.joints):
            i = N_PAYLOAD + self._labels.index(f'coulomb {name}')
            out[j] = abs(chain.coulomb[j] + state.mean[i]) + math.sqrt(state.covariance[i, i])
        return out

    def _columns_at(self, state: _State, window: _Window) -> Array:
        """Return how a window answers to the state [J, S]."""
        certain = state.mean[0] ** 2 > SEEN ** 2 * state.covariance[0, 0]
        centre = centre_of(state.mean[:N_PAYLOAD]) if certain else np.zeros(3)
        return np.hstack([window.weight @ compact(centre), window.h, np.diag(window.resting)])

    def _corrected(self, state: _State, window: _Window) -> tuple[_State, float]:
        """Return the state after a window, and its log likelihood but for a constant."""
        s, h = PAYLOAD_SETTINGS, self._columns_at(state, window)
        error, likeliest, new = window.y - h @ state.mean, -math.inf, state
        for chance, factor in ((1.0 - s.push, 1.0), (s.push, s.loud ** 2)):
            corrected, logarithm = _updated(state, h, error, factor * self._noise_of_means)
            if math.log(chance) + logarithm > likeliest:
                likeliest, new = math.log(chance) + logarithm, corrected
        return new, likeliest

    def _reopened(self, state: _State) -> _State:
        """Return a state that forgot the payload."""
        mean, covariance = state.mean.copy(), state.covariance.copy()
        mean[:N_PAYLOAD] = 0.0
        covariance[:N_PAYLOAD], covariance[:, :N_PAYLOAD] = 0.0, 0.0
        covariance[:N_PAYLOAD, :N_PAYLOAD] = self._open()
        return _State(mean, covariance)

    def _measure_noise(self, error: Array) -> None:
        """Take the error [J] of a window: medians do not see a push."""
        s, errors = PAYLOAD_SETTINGS, self._errors
        errors.append(error)
        first, squares = (s.guess * self._size) ** 2, np.square(errors)
        self._noise = (s.belief * first + len(errors) * np.median(squares, axis=0) / MEDIAN) / (
            s.belief + len(errors))
        count = len(errors) // s.block
        means = np.array(errors)[len(errors) - count * s.block:].reshape(
            count, s.block, self._joints).mean(axis=1)
        slow = np.median(means ** 2, axis=0) * s.block / MEDIAN if count > 1 else self._noise
        self._noise_of_means = np.maximum(self._noise, slow) * self._dispersion

    def _estimate(self, window: _Window) -> PayloadEstimate:
        """Return mean and covariance over the filters, by their weights."""
        parts = []
        for x in self._held:
            h = self._columns_at(x.state, window)
            parts.append((h @ x.state.mean - window.y,
                          np.einsum('ij,jk,ik->i', h, x.state.covariance, h)))
        share = np.exp([x.weight for x in self._held])
        pushes = np.array([push for push, _ in parts])
        external = share @ pushes
        variance = share @ (np.array([v for _, v in parts]) + (pushes - external) ** 2)
        means = np.array([x.state.mean[:N_PAYLOAD] for x in self._held])
        b = share @ means
        covariance = np.einsum('n,nij->ij', share, np.array([
            x.state.covariance[:N_PAYLOAD, :N_PAYLOAD] for x in self._held])
            + np.einsum('ni,nj->nij', means - b, means - b))
        std = math.sqrt(max(covariance[0, 0], 0.0))
        centre = centre_std = np.full(3, np.nan)
        if abs(b[0]) > std and b[0] != 0.0:
            centre = b[1:] / b[0]
            slopes = np.column_stack([-centre, np.eye(3)]) / b[0]
            centre_std = np.sqrt(np.maximum(np.diag(slopes @ covariance @ slopes.T), 0.0))
        return PayloadEstimate(
            window.stamp_ns, float(b[0]), std, centre, centre_std, self._held[0].since_ns,
            external, np.sqrt(np.maximum(variance, 0.0) + self._noise))


def _updated(state: _State, h: Array, error: Array, noise: Array) -> tuple[_State, float]:
    """
    Return the state after a measurement, and the log likelihood but for a constant.

    Args:
        state: before.
        h: columns [J, S].
        error: measured less expected [J].
        noise: variances [J].
    """
    cross = state.covariance @ h.T
    inner = h @ cross + np.diag(noise)
    factor = np.linalg.cholesky(inner)
    half = np.linalg.solve(factor, cross.T)
    white = np.linalg.solve(factor, error)
    covariance = state.covariance - half.T @ half
    return (_State(state.mean + half.T @ white, 0.5 * (covariance + covariance.T)),
            -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum()))
