# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The likelihood of a mixed model of all joints of a robot, by Gram matrices per joint and band.

    effort - model = X beta + Z u + e,   u ~ N(mean, covariance),   e with one variance per joint,
    recording and band of frequency (Whittle), profiled:
    deviance = sum n ln(RSS / n) + (u - mean)' covariance^-1 (u - mean)

A nuisance column acts on few joints only, and may be that of one recording, as of a load: each
Gram matrix holds the columns of its joint in its recording.

Of a servo the setpoint is known and the gain is a nuisance. Its balance is divided by the gain, so
that gains that are free do not allow the solution 0 = 0: with s, the gain of the model over the
true one,

    setpoint's effort - model = (s - 1) model + inputs + s (X beta + Z u) + e.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import Any, NamedTuple

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.motion import highest_kept
from gearbox_monitor.diagnosis.robot.rows import NuisanceColumn, Rows
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.effects.controller import SERVO_GAIN

WEAK = 1e-7      # prior precision of a candidate's coefficient, in units of its column
SINGULAR = 1e-13  # of a candidate's own Schur complement, relative
ROUNDED = 1.0 + 1e-11  # of a diagonal: columns that nearly agree leave it not below zero
CANCELLED = 1e-4  # below it the difference of two sums is not accurate
STEPS, STEADY = 24, 1e-6  # of Gauss and Newton, at most; 2 log likelihood of the last one
HALVED = (1.0, 0.5, 0.25, 0.1, 0.03)  # of a step, until one helps
LEAST_SCALE = 0.1  # gain of the model over that of a servo: it may be 10 times as large


@dataclass(frozen=True, eq=False)
class Prior:
    """Of the coefficients `labels`, in their units: mean [K] and covariance [K, K]."""

    labels: tuple[str, ...]
    mean: Array
    covariance: Array


class Grams(NamedTuple):
    """
    Of the `cells` [C] of a recording with its nuisance `columns` [n]: gram [C, n+1, n+1].

    turn [n+1, n+1]: what makes of columns and target those about a solution, None for nothing.
    """

    cells: slice
    columns: Integers
    gram: Array
    turn: Array | None = None

    def left(self, solution: Array) -> Array:
        """Return the sum of squares [C] that the coefficients `solution` of all columns leave."""
        c = np.append(-solution[self.columns], 1.0)
        c = c if self.turn is None else self.turn @ c
        result: Array = (self.gram @ c) @ c
        return result


class Servos(NamedTuple):
    """
    What a gain scales, of the nuisance and the columns of candidates [K+E].

    inputs: which columns are of the setpoint, no torques; gains [J, K+E]: change of a joint's gain
    of the model over its servo's with each coefficient; mean: of their prior.
    """

    inputs: Flags
    gains: Array
    mean: Array

    def scale(self, solution: Array) -> Array:
        """Return the gain of the model over that of each servo [J] at a solution [K+E]."""
        return np.maximum(1.0 + self.gains @ (self.mean + solution), LEAST_SCALE)

    @property
    def free(self) -> Flags:
        """Which coefficients [K+E] are no gains."""
        return ~np.any(self.gains != 0.0, axis=0)

    def about(self, solution: Array, joint: int, index: Integers, held: bool = False) -> Array:
        """
        Return what makes those about a solution of columns of a joint and its target.

        Args:
            solution: [K+E].
            joint: the joint.
            index: of its columns [n].
            held: whether gains stay, which makes the balance linear.

        Returns:
            [n+1, n+1], by which the rows of columns and target are multiplied.
        """
        scale = self.scale(solution)[joint]
        torque, out = ~self.inputs[index], np.eye(len(index) + 1)
        out[:-1, :-1] = np.diag(np.where(torque, scale, 1.0))
        out[:-1, -1] = torque * (1.0 - scale) * self.mean[index]
        if not held:
            own, slope = (self.mean + solution)[index] * torque, self.gains[joint]
            out[:-1, :-1] += np.outer(own, slope[index])
            out[:-1, -1] += own * float(slope @ solution)
        return out


@dataclass(frozen=True, eq=False)
class JointRows:
    """
    The rows of a joint, sorted by cell (recording and band).

    z [R, K]: its nuisance columns in units of their deviation; index [K]: which ones of all;
    y [R]: target less the prior's mean; cells: slices of equal variance; count [C]: effective
    rows; recording, band [C]: of the cell; segment [R]: number of the segment; order [R]: where a
    row stood; grams: of each recording. floor [C]: no cell's sum of squares is taken below it.
    """

    z: Array
    index: Integers
    y: Array
    cells: tuple[slice, ...]
    count: Array
    recording: Integers
    band: Integers
    segment: Integers
    order: Integers
    grams: tuple[Grams, ...]
    floor: Array

    def spread(self, per_cell: Array) -> Array:
        """Return the values [R] of cells `per_cell` [C]."""
        return np.repeat(per_cell, [c.stop - c.start for c in self.cells])

    @cached_property
    def rows(self) -> float:
        """The effective number of all rows."""
        return float(self.count.sum())

    @cached_property
    def close(self) -> Array:
        """How near the bands of two cells of one recording are [C, C]; 0 of a cell itself."""
        place = np.arange(len(self.count))
        distance = np.abs(np.subtract.outer(place, place))
        same = np.equal.outer(self.recording, self.recording)
        result: Array = np.exp(-distance / 1.5) * (distance > 0) * same
        return result


@dataclass(frozen=True, eq=False)
class RobotFit:
    """
    A set of candidates, fitted.

    values: coefficients of the chosen; nuisance [K]: in units of deviations, from the mean;
    covariance [K+E, K+E], scale [E]: of the columns; weights: 1 / variance per joint [C];
    residual: per joint [R]; gain [J]: of the model over that of the servo, else 1.
    """

    chosen: tuple[Candidate, ...]
    deviance: float
    values: Array
    nuisance: Array
    covariance: Array
    scale: Array
    weights: tuple[Array, ...]
    residual: tuple[Array, ...]
    gain: Array

    @property
    def solution(self) -> Array:
        """Coefficients [K+E] in the units of the fit."""
        return np.append(self.nuisance, self.values * self.scale)

    def torque(self, number: int) -> dict[int, Array]:
        """Return the rows {joint: [R]} of candidate `number`, in the scale of the balance."""
        c, values = self.chosen[number], self.values[self.of(number)]
        return {j: x @ values * (1.0 if c.of_input else self.gain[j])
                for j, x in c.columns.items()}

    def of(self, number: int) -> slice:
        """Return where the coefficients of candidate `number` stand in `values`."""
        begin = sum(c.width for c in self.chosen[:number])
        return slice(begin, begin + self.chosen[number].width)

    def dispersed(self, dispersion: Array) -> 'RobotFit':
        """Return the fit with the information of each joint over its `dispersion` [J]."""
        return replace(self, weights=tuple(w / phi for w, phi in zip(self.weights, dispersion)))


class AddedEstimate(NamedTuple):
    """Coefficients of a candidate added alone, their covariance, and the gain in chi squared."""

    values: Array
    covariance: Array
    gain: float


class RobotLikelihood:
    """
    The likelihood of `recordings` of one robot, about candidates.

    prior: what references taught; None, the tolerances of the file. variance [J, bands]: what they
    left, below which no variance is taken; rows where it is infinite are left out. nuisance:
    columns by label, the first of each.
    """

    def __init__(self, recordings: Sequence[Rows], prior: Prior | None = None,
                 variance: Array | None = None) -> None:
        self.variance = variance
        self.recordings = tuple(recordings)
        self.joints = len(recordings[0].joints)
        self.nuisance: dict[str, NuisanceColumn] = {}
        for number, rows in enumerate(recordings):
            for column in rows.nuisance:
                self.nuisance.setdefault(_label(column, number), column)
        self.labels = tuple(self.nuisance)
        self.deviation = np.array([column.deviation for column in self.nuisance.values()])
        self.mean, self.precision = self._prior(prior)
        self.at = tuple(self._joint(j) for j in range(self.joints))
        self.segments = sum(len(rows.tests.starts) for rows in recordings)

    def _prior(self, prior: Prior | None) -> tuple[Array, Array]:
        """Return mean and precision of the nuisance, in units of its deviations."""
        mean, covariance = np.zeros(len(self.labels)), np.eye(len(self.labels))
        if prior is None:
            return mean, covariance
        place = {label: i for i, label in enumerate(self.labels)}
        shared = [(i, place[label]) for i, label in enumerate(prior.labels) if label in place]
        theirs, ours = (np.array(x, int) for x in zip(*shared))
        scale = self.deviation[ours]
        mean[ours] = prior.mean[theirs] / scale
        covariance[np.ix_(ours, ours)] = prior.covariance[np.ix_(theirs, theirs)] / np.outer(
            scale, scale)
        values, vectors = np.linalg.eigh(covariance)
        return mean, (vectors / np.maximum(values, 1e-10 * values.max())) @ vectors.T

    def _joint(self, j: int) -> JointRows:
        place = {label: i for i, label in enumerate(self.labels)}
        indices = [sorted({place[_label(c, i)] for c in rows.nuisance if j in c.rows})
                   for i, rows in enumerate(self.recordings)]
        blocks, own = [], np.array(sorted({k for index in indices for k in index}), int)
        where = {k: i for i, k in enumerate(own)}
        cell, target, weight, model, segment = [], [], [], [], []
        begin, bands = 0, len(SETTINGS.bands) - 1
        for number, rows in enumerate(self.recordings):
            z = np.zeros((rows.tests.rows, len(own)))
            for column in rows.nuisance:
                if j in column.rows:
                    k = place[_label(column, number)]
                    z[:, where[k]] = column.rows[j] * self.deviation[k]
            blocks.append(z)
            cell.append(number * bands + rows.tests.band)
            target.append(rows.target[j])
            per_segment = rows.tests.rows // len(rows.tests.starts)
            weight.append(np.repeat(rows.tests.covered[:, j], per_segment))
            segment.append(begin + np.repeat(np.arange(len(rows.tests.starts)), per_segment))
            model.append(rows.model[j])
            begin += len(rows.tests.starts)
        usable = np.flatnonzero(np.concatenate([
            rows.tests.frequency <= highest_kept(rows.motion)[j]
            for rows in self.recordings]))
        if self.variance is not None:
            usable = usable[np.isfinite(self.variance[j])[np.concatenate(cell)[usable] % bands]]
        order = usable[np.argsort(np.concatenate(cell)[usable], kind='stable')]
        z, y, cells = np.concatenate(blocks)[order], np.concatenate(target)[order], np.concatenate(
            cell)[order]
        y = y - z @ self.mean[own]
        edges = np.flatnonzero(np.diff(cells, prepend=-1, append=cells[-1] + 1))
        slices = tuple(slice(a, b) for a, b in zip(edges[:-1], edges[1:]))
        covered, torque = np.concatenate(weight)[order], np.concatenate(model)[order]
        count = np.array([max(covered[s].sum(), 1e-3) for s in slices])
        # Else a joint without effort may explain all by nothing (0 = 0).
        floor = np.array([np.sum(torque[s] ** 2) for s in slices]) * SETTINGS.floor ** 2
        kind = cells[edges[:-1]]
        grams = []
        for number in np.unique(kind // bands):
            index = np.array(indices[number], int)
            part = slice(*np.searchsorted(kind // bands, [number, number + 1]))
            shown = np.append(np.searchsorted(own, index), len(own))
            full = [np.column_stack([z[s], y[s]]).take(shown, axis=1) for s in slices[part]]
            grams.append(Grams(part, index, np.stack([x.T @ x for x in full])))
        if self.variance is not None:
            floor = np.maximum(floor, count * self.variance[j][kind % bands])
        return JointRows(z, own, y, slices, count, kind // bands, kind % bands,
                         np.concatenate(segment)[order], order, tuple(grams), floor + 1e-30)

    def rows_in(self, candidate: Candidate) -> float:
        """Return the effective number of rows that a candidate acts on."""
        return sum(self.at[j].rows for j in candidate.columns)

    def _columns(self, chosen: Sequence[Candidate]) -> tuple[list[Array], list[Integers], Array]:
        """Return columns [R, E_j] and their places of each joint, and their scale [E]."""
        begins = np.cumsum([0, *(c.width for c in chosen)])
        squares, out, where = np.zeros(begins[-1]), [], []
        for j, a in enumerate(self.at):
            own = [i for i, c in enumerate(chosen) if j in c.columns]
            place = np.concatenate([np.arange(0), *(np.arange(*begins[i:i + 2]) for i in own)])
            x = np.concatenate([np.zeros((len(a.y), 0)),
                                *(chosen[i].columns[j][a.order] for i in own)], axis=1)
            squares[place] += (x ** 2).sum(axis=0)
            out.append(x)
            where.append(place)
        scale = np.sqrt(squares / sum(len(a.y) for a in self.at)) + 1e-12
        return [x / scale[place] for x, place in zip(out, where)], where, scale

    def _servos(self, chosen: Sequence[Candidate], scale: Array) -> Servos | None:
        """Return what gains of servos scale beside `chosen` in columns of a `scale` [E]."""
        if not self.recordings[0].setpoint:
            return None
        k = len(self.labels)
        gains = np.zeros((self.joints, k + len(scale)))
        inputs = [column.of_input for column in self.nuisance.values()]
        for j, name in enumerate(self.recordings[0].robot.chain.joints):
            own = self.labels.index(f'kp {name}')
            gains[j, own] = self.deviation[own]
        for c in chosen:
            if c.effect == SERVO_GAIN.id:
                gains[list(c.columns), len(inputs)] = 1.0 / scale[len(inputs) - k]
            inputs += [c.of_input] * c.width
        return Servos(np.array(inputs), gains, np.append(self.mean, np.zeros(len(scale))))

    def fit(self, chosen: Sequence[Candidate] = (), begin: RobotFit | None = None,
            rounds: int = 6) -> RobotFit:
        """
        Return the profiled fit of a set of candidates.

        Args:
            chosen: candidates.
            begin: fit whose variances and coefficients it begins with.
            rounds: of reweighting, at most.
        """
        k = len(self.labels)
        extra, places, scale = self._columns(chosen)
        grams = [[_extended(part, a, x, k + place) for part in a.grams]
                 for a, x, place in zip(self.at, extra, places)]
        weights: Sequence[Array] = [a.count / np.maximum(np.concatenate(
            [part.gram[:, -1, -1] for part in a.grams]), 1e-30) for a in self.at]
        size, servos = k + len(scale), self._servos(chosen, scale)
        solution: Array = np.zeros(size)
        if begin is not None:
            weights = begin.weights
        if begin is not None and servos is not None:
            old = {id(c): begin.values[begin.of(i)] for i, c in enumerate(begin.chosen)}
            solution = np.concatenate([begin.nuisance, *(
                old.get(id(c), np.zeros(c.width)) for c in chosen)]) * np.append(np.ones(k), scale)
        prior = np.zeros((size, size))
        prior[:k, :k] = self.precision
        prior[np.arange(k, size), np.arange(k, size)] = _precision(chosen, scale)
        for step in range(rounds):
            solution, factor, squares = self._solved(grams, weights, prior, servos, solution)
            updated = [a.count / s for a, s in zip(self.at, squares)]
            # Weights, solution and covariance that are returned belong together: where a candidate
            # has the column of a nuisance, their difference is all of its information.
            if step + 1 == rounds or max(
                    np.abs(np.log(w / b)).max() for w, b in zip(updated, weights)) < 0.01:
                break
            weights = updated
        offset = solution[:k]
        deviance = sum(float((a.count * np.log(s / a.count)).sum())
                       for a, s in zip(self.at, squares)) + float(
                           offset @ self.precision @ offset)
        residual = [full @ np.append(-solution[index], 1.0) for full, index in (
            self._seen(j, x, k + place, servos, solution)
            for j, (x, place) in enumerate(zip(extra, places)))]
        inverse = scipy.linalg.cho_solve(factor, np.eye(size), check_finite=False)
        return RobotFit(tuple(chosen), deviance, solution[k:] / scale, offset, inverse, scale,
                        tuple(weights), tuple(residual), np.ones(self.joints)
                        if servos is None else servos.scale(solution))

    def _solved(self, grams: Sequence[Sequence[Grams]], weights: Sequence[Array], prior: Array,
                servos: Servos | None, solution: Array) -> tuple[Array, Any, list[Array]]:
        """
        Return the solution that some weights make best, its factor, its sums of squares per joint.

        Gains of servos multiply torques: each step of Gauss and Newton moves the gains, as far as
        less remains, and all else follows exactly (variable projection; Golub and Pereyra, 1973).

        Args:
            grams: of all columns, per joint.
            weights: 1 / variance per joint [C].
            prior: precision [K+E, K+E].
            servos: what gains scale, None without.
            solution: to begin with [K+E].
        """
        def equations(x: Array, held: bool) -> tuple[Sequence[Sequence[Grams]], Array, Array]:
            """Return the columns about `x` and their normal equations."""
            seen = grams if servos is None else [[
                part._replace(turn=servos.about(x, j, part.columns, held)) for part in parts]
                for j, parts in enumerate(grams)]
            matrix, right = prior.copy(), np.zeros(len(x))
            for parts, w in zip(seen, weights):
                _add(matrix, right, parts, w)
            matrix[np.arange(len(x)), np.arange(len(x))] *= ROUNDED
            return seen, matrix, right

        def left(seen: Sequence[Sequence[Grams]], x: Array) -> list[Array]:
            """Return the sums of squares [C] that `x` leaves at each joint."""
            return [np.concatenate([part.left(x) for part in parts]) for parts in seen]

        def followed(x: Array, free: Flags) -> tuple[float, Array, list[Array]]:
            """Return what `x` costs with its gains and the best of all else, that, its squares."""
            seen, matrix, right = equations(x, True)
            best = x.copy()
            best[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free] - matrix[
                np.ix_(free, ~free)] @ x[~free])
            squares = left(seen, best)
            return float(best @ prior @ best + sum(
                w @ s for w, s in zip(weights, squares))), best, squares
        if servos is None:
            seen, matrix, right = equations(solution, True)
            factor = scipy.linalg.cho_factor(matrix, lower=True, check_finite=False)
            solution = scipy.linalg.cho_solve(factor, right, check_finite=False)
            return solution, factor, self._varied(left(seen, solution))
        cost, solution, squares = followed(solution, servos.free)
        for _ in range(STEPS):
            _, matrix, right = equations(solution, False)
            factor = scipy.linalg.cho_factor(matrix, lower=True, check_finite=False)
            move = scipy.linalg.cho_solve(factor, right, check_finite=False) - solution
            trials = (followed(solution + share * move, servos.free) for share in HALVED)
            trial = next((t for t in trials if t[0] < cost), None)
            if trial is None:
                break
            gained, (cost, solution, squares) = cost - trial[0], trial
            if gained < STEADY:
                break
        return solution, factor, self._varied(squares)

    def _varied(self, squares: Sequence[Array]) -> list[Array]:
        """Return sums of `squares` [C] per joint, above the floors and drawn together."""
        return [self._shrunk(np.maximum(s, a.floor), a) for s, a in zip(squares, self.at)]

    def _seen(self, j: int, extra: Array, places: Integers, servos: Servos | None,
              solution: Array) -> tuple[Array, Integers]:
        """
        Return the columns of a joint and its target [R, n+1] about a solution, and which they are.

        Args:
            j: the joint.
            extra: columns [R, e] of candidates.
            places: of these [e], among all.
            servos: what gains scale.
            solution: [K+E].
        """
        a = self.at[j]
        index = np.append(a.index, places)
        full = np.column_stack([a.z, extra, a.y])
        return full if servos is None else full @ servos.about(solution, j, index), index

    def hidden(self, fit: RobotFit) -> float:
        """
        Return the deviance of what the newest candidate of `fit` hides.

        Where any input has the same effect, it may have been anywhere in the range that is hidden:
        it is as improbable as noise of that size, not as the residual. A servo without effect
        does not stay near its setpoint: if that is more probable, by the stiffness of its gain
        over that of the joint itself at each frequency, it counts.
        """
        c = fit.chosen[-1]
        if not c.hidden:
            return 0.0
        (j, x), = c.columns.items()
        a, weights = self.at[j], fit.weights[j]

        def power(rows: Array) -> Array:
            """Return the sum of squares [C] of `rows`."""
            return np.array([np.sum(rows[a.order[cell]] ** 2) for cell in a.cells])
        ratio = power(x[:, 0]) * weights / a.count
        if self.recordings[0].setpoint:
            both = np.concatenate([rows.tested(j, np.stack([m.kp * m.q, m.model], axis=1), True)
                                   for rows in self.recordings for m in (rows.joints[j],)])
            held, own = (power(side) for side in both.T)
            ratio = np.minimum(ratio, held / np.maximum(own, 1e-300))
        return c.hidden * float(a.count @ np.log(np.maximum(ratio, 1.0)))

    def _shrunk(self, squares: Array, a: JointRows) -> Array:
        """
        Return sums of squares [C] drawn towards those of the neighbouring bands.

        A short recording would fit one band at the cost of another.
        """
        count = a.count
        log = np.log(squares / count)
        total = a.close @ count
        smooth = np.where(total > 0.0, a.close @ (log * count) / np.maximum(total, 1e-9), log)
        shrink = SETTINGS.shrink
        return count * np.exp((count * log + shrink * smooth) / (count + shrink))

    def estimates(self, fit: RobotFit, candidates: Sequence[Candidate],
                  part: Sequence[Array] | None = None) -> list[AddedEstimate]:
        """
        Return the AddedEstimate of each candidate, added alone at the weights of a fit.

        Args:
            fit: what is explained already.
            candidates: to add.
            part: of each joint which rows [R] an effect may act on, None for all. An effect in a
                part of the rows is what differs between this part and the others.
        """
        weight = [a.spread(w) for a, w in zip(self.at, fit.weights)]
        full, index, grams = self._about(fit)
        out: list[AddedEstimate | None] = [None] * len(candidates)
        single: dict[int, list[int]] = {}
        for i, c in enumerate(candidates):
            if len(c.columns) == 1:
                single.setdefault(next(iter(c.columns)), []).append(i)
            else:
                columns = {j: self._in_part(c, j, fit, part) for j in c.columns}
                score = np.zeros(c.width)
                for j, own_rows in columns.items():
                    score += own_rows.T @ (weight[j] * fit.residual[j])
                schur, squares = self._schur(fit, columns, full, index, weight, grams)
                out[i], = _estimates([c], score[None], schur[None], squares[None])
        for j, numbers in single.items():
            x: Array = np.concatenate(
                [self._in_part(candidates[i], j, fit, part) for i in numbers], axis=1)
            xw = x * weight[j][:, None]
            score, xz = xw.T @ fit.residual[j], xw.T @ full[j]
            inner = xz @ fit.covariance[index[j][:, None], index[j]]
            widths = np.array([candidates[i].width for i in numbers])
            for width in np.unique(widths):     # at once: M of one width
                own = np.flatnonzero(widths == width)
                at = (np.cumsum(widths) - widths)[own, None] + np.arange(width)     # [M, width]
                xx = xw.T[at] @ x.T[at].transpose(0, 2, 1)
                schurs: Array = xx - inner[at] @ xz[at].transpose(0, 2, 1)
                squares = np.diagonal(xx, axis1=1, axis2=2)
                for k in np.flatnonzero(np.linalg.eigvalsh(
                        schurs / _products(np.sqrt(squares) + 1e-30))[:, 0] < CANCELLED):
                    schurs[k], _ = self._schur(fit, {j: x[:, at[k]]}, full, index, weight, grams)
                of = [numbers[k] for k in own]
                for i, e in zip(of, _estimates([candidates[i] for i in of], score[at], schurs,
                                               squares)):
                    out[i] = e
        return [e for e in out if e is not None]

    def _in_part(self, c: Candidate, joint: int, fit: RobotFit, part: Sequence[Array] | None
                 ) -> Array:
        """Return columns [R, k] of `c` about a fit, in the order of a joint, in a part."""
        x = c.columns[joint][self.at[joint].order] * (1.0 if c.of_input else fit.gain[joint])
        return x if part is None else x * part[joint][:, None]

    def _about(self, fit: RobotFit) -> tuple[list[Array], list[Integers], list[Array]]:
        """
        Return the columns of a fit about its solution.

        Returns:
            Per joint: columns [R, n]; which ones of all [n]; their sums of squares [K+E, K+E].
        """
        extra, places, scale = self._columns(fit.chosen)
        k, servos = len(self.labels), self._servos(fit.chosen, scale)
        full, indices, grams = [], [], []
        for j, (x, place, w) in enumerate(zip(extra, places, fit.weights)):
            columns, index = self._seen(j, x, k + place, servos, fit.solution)
            gram = np.zeros_like(fit.covariance)
            parts = [_extended(g, self.at[j], x, k + place) for g in self.at[j].grams]
            _add(gram, np.zeros(len(gram)), parts if servos is None else [
                g._replace(turn=servos.about(fit.solution, j, g.columns)) for g in parts], w)
            full.append(columns[:, :-1])
            indices.append(index)
            grams.append(gram)
        return full, indices, grams

    def _schur(self, fit: RobotFit, columns: Mapping[int, Array], full: Sequence[Array],
               index: Sequence[Integers], weight: Sequence[Array], grams: Sequence[Array]
               ) -> tuple[Array, Array]:
        """
        Return the Schur complement of columns {joint: [R, k]}, and their squares [k].

        As a sum of squares of what all else leaves of them: what the tolerances nearly explain has
        a complement of 1e-8 of its squares, which a difference would not hold. Of joints without
        these columns, their weighted `grams` [K+E, K+E] hold the sum.
        """
        size = len(fit.covariance)
        width = next(iter(columns.values())).shape[1]
        cross, squares = np.zeros((size, width)), np.zeros(width)
        for j, x in columns.items():
            cross[index[j]] += full[j].T @ (x * weight[j][:, None])
            squares += weight[j] @ x ** 2
        share = fit.covariance @ cross
        k = len(self.labels)
        weak = _precision(fit.chosen, fit.scale)[:, None]
        schur = share[:k].T @ self.precision @ share[:k] + share[k:].T @ (weak * share[k:])
        for j, gram in enumerate(grams):
            if j in columns:
                reduced = columns[j] - full[j] @ share[index[j]]
                schur += (reduced * weight[j][:, None]).T @ reduced
            else:
                schur += share.T @ gram @ share
        return schur, squares

    def by_scales(self, fit: RobotFit, number: int) -> Array:
        """
        Return how the coefficients of candidate `number` move with the scale of each joint [J, k].

        Where a mass and its place come from what joints differ by, they move by more than their
        size; else the joints' shares add up to it.
        """
        k, own, torque = len(self.labels), fit.of(number), fit.torque(number)
        rows, (full, indices, _) = slice(k + own.start, k + own.stop), self._about(fit)
        return np.array([fit.covariance[rows, indices[j]] @ (full[j].T @ (
            self.at[j].spread(fit.weights[j]) * x[self.at[j].order])) / fit.scale[own]
            for j, x in torque.items()])

    def sandwich(self, fit: RobotFit) -> Array:
        """
        Return the covariance [E, E] of the values chosen in `fit`, from segments' scores.

        It holds where the residual is no white noise (White, 1980; segments as clusters), and is
        not below that of the likelihood.
        """
        k, (full, indices, _) = len(self.labels), self._about(fit)
        scores = np.zeros((self.segments, len(fit.covariance)))
        for a, x, index, w, r in zip(self.at, full, indices, fit.weights, fit.residual):
            total = np.zeros((self.segments, x.shape[1]))
            np.add.at(total, a.segment, x * (a.spread(w) * r)[:, None])
            scores[:, index] += total
        own = fit.covariance[k:]
        middle = scores @ own.T
        prior = own[:, :k] @ self.precision @ own[:, :k].T
        robust = middle.T @ middle + prior
        model = own[:, k:]
        share = np.sqrt(np.maximum(np.diag(robust) / np.diag(model), 1.0))
        return model * np.outer(share, share) / np.outer(fit.scale, fit.scale)

    def posterior(self, fit: RobotFit, dispersion: Array | None = None) -> Prior:
        """
        Return what a fit taught of the nuisance, in its units.

        Args:
            fit: with or without candidates.
            dispersion: [J], by which the information of each joint is divided, of a fit without
                candidates; None for 1.
        """
        if dispersion is not None:
            fit = self.fit((), fit.dispersed(dispersion), 1)
        d = self.deviation
        return Prior(self.labels, (self.mean + fit.nuisance) * d,
                     fit.covariance[:len(d), :len(d)] * np.outer(d, d))


def _extended(part: Grams, a: JointRows, x: Array, index: Integers) -> Grams:
    """Return `part` of the rows `a` with the columns `x` [R, e] of candidates, at `index` [e]."""
    e = x.shape[1]
    if not e:
        return part
    n, shown = len(part.columns), np.searchsorted(a.index, part.columns)
    gram = np.empty((len(part.gram), n + e + 1, n + e + 1))
    keep, new = np.r_[0:n, n + e], np.arange(n, n + e)
    gram[:, keep[:, None], keep] = part.gram
    for g, cell in zip(gram, a.cells[part.cells]):
        full = np.column_stack([a.z[cell].take(shown, axis=1), x[cell], a.y[cell]])
        cross = full.T @ x[cell]
        g[:, new], g[new] = cross, cross.T
    return Grams(part.cells, np.r_[part.columns, index], gram)


def _add(matrix: Array, right: Array, parts: Sequence[Grams], weights: Array) -> None:
    """Add `parts` of a joint with its `weights` [C] to the normal equations."""
    for cells, own, gram, turn in parts:
        total: Array = np.tensordot(weights[cells], gram, 1)
        total = total if turn is None else turn.T @ total @ turn
        matrix[own[:, None], own] += total[:-1, :-1]
        right[own] += total[:-1, -1]


def _label(column: NuisanceColumn, number: int) -> str:
    """Return the label of a nuisance column of recording `number`."""
    return f'{column.label} of recording {number + 1}' if column.own else column.label


def _precision(chosen: Sequence[Candidate], scale: Array) -> Array:
    """Return the prior precision [E] of the coefficients of `chosen`, in columns of a `scale`."""
    out = np.full(len(scale), WEAK)
    known = np.concatenate([np.full(c.width, math.inf) if c.deviation is None else c.deviation
                            for c in chosen] or [scale])
    return out + (scale * known) ** -2.0


def _products(x: Array) -> Array:
    """Return the outer products [M, k, k] of each row of `x` [M, k] with itself."""
    return x[:, :, None] * x[:, None]


def _estimates(candidates: Sequence[Candidate], score: Array, schur: Array, squares: Array
               ) -> list[AddedEstimate]:
    """
    Return coefficients of linear steps, made safe where columns are not excited.

    Args:
        candidates: of one width k, each alone.
        score: [M, k].
        schur: complements [M, k, k].
        squares: of the columns [M, k].
    """
    size, diagonal = np.sqrt(squares) + 1e-30, np.arange(schur.shape[1])
    inner = schur / _products(size)
    inner[:, diagonal, diagonal] += SINGULAR
    for c, s, own in zip(candidates, size, inner):
        if c.deviation is not None:
            own[diagonal, diagonal] += (s * c.deviation) ** -2.0
    covariance = np.linalg.inv(inner) / _products(size)
    values = (covariance @ score[:, :, None])[:, :, 0]
    return [AddedEstimate(b, c, float(s @ b)) for b, c, s in zip(values, covariance, score)]
