# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Candidate models: nominal values and parameters of effects as coordinates of a fit.

Coordinates z [P] are bounded; some are logarithms. Nominal values carry a Gaussian prior.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS, library, Scales
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN, TORQUE_OFFSET
from gearbox_monitor.plant.effects.arm_side import ARM_COULOMB
from gearbox_monitor.plant.effects.encoder import ENCODER_OFFSET
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB
from gearbox_monitor.plant.transmission import FrictionLaw
from gearbox_monitor.signals.uniform import UniformRecording

# Values of the model that scatter with its tolerance: name in a verdict -> field.
NUISANCES = {'m1': 'motor_inertia', 'm2': 'arm_inertia', 'D': 'damping',
             'Cv': 'viscous_friction', 'Cc': 'coulomb_friction', 'K': 'stiffness', 'b': 'half_gap',
             'kp': 'kp', 'kd': 'kd', 'ki': 'ki', 'kff': 'feedforward',
             'kaff': 'feedforward_inertia'}
GAINS = ('kp', 'kd', 'ki', 'kff', 'kaff')  # of a servo, with a tolerance of its own
RIGID_HIDES = ('m2', 'D', 'K', 'b')  # of m1 and m2 only the sum shows
ZERO = 'zero'  # offset of the motor's encoder against the arm's, where model.zero_tolerance > 0
# Values that only an effect has: name -> (id, parameter). kt: factor on the torque.
BY_EFFECT = {'kt': (TORQUE_GAIN.id, 'g'), 'u0': (TORQUE_OFFSET.id, 'u0'),
             ZERO: (ENCODER_OFFSET.id, 'c')}
# Sharpness of Coulomb friction, which every fit has: name -> field.
SHAPES = {'alpha': 'friction_sharpness', 'alpha_arm': 'arm_friction_sharpness'}
SHARPER = 1e2  # factor by which a sharpness may be off at most
PERIODIC = tuple(name for name, effect in EFFECTS.items() if effect.periodic)
PHASED = tuple(name for name, effect in EFFECTS.items() if effect.phased)
ORDERS = range(1, 41)
LIMITED = (0.99, 0.4, 119)  # shares of the largest torque at which a limit may begin
TWIST = (2.0, 98.0)  # percentiles between which the twist swings
# Where the motor's motion is put in, its torque shows friction of both sides as one: what is the
# arm's leaves the motor's.
SHIFTS = {name: EFFECTS[effect.counterpart].parameters[0].name
          for name, effect in EFFECTS.items()
          if effect.counterpart and EFFECTS[effect.counterpart].replaces}
SHIFTED = 1.0
FREE_VALUE = 'v'  # coordinates of a torque map: v0, v1 ... in the order of its knots
# Not fitted as a motion: read from the lattice of the readings, or a free signal.
NOT_FITTED = tuple(name for name, effect in EFFECTS.items() if not effect.fitted)


@dataclass(frozen=True)
class Coordinate:
    """
    One number of a fit: `value` = low-level parameter, on a log scale where `log`.

    scale: a change that matters; low, high: bounds; prior: standard deviation about the start, or
    0. owner: index of the effect, or -1 for a nuisance.
    """

    owner: int
    name: str
    start: float
    scale: float
    low: float = -math.inf
    high: float = math.inf
    log: bool = False
    prior: float = 0.0

    def at(self, value: float) -> float:
        """Return the coordinate of a `value`."""
        return math.log(value) if self.log else value

    def value(self, z: float) -> float:
        """Return the value at the coordinate `z`."""
        return math.exp(z) if self.log else float(z)


@dataclass(frozen=True)
class CandidateModel:
    """
    A model to be fitted: the nominal one with nuisances and the effects `ids`.

    orders: {index of a periodic effect: its N}. tables: {index of a torque map: what of it is not
    fitted}.
    """

    nominal: DriveModel
    ids: tuple[str, ...]
    coordinates: tuple[Coordinate, ...]
    orders: dict[int, int] = field(default_factory=dict)
    tables: dict[int, Values] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Ids joined by '+'."""
        return '+'.join(self.ids)

    @property
    def key(self) -> tuple[str, ...]:
        """Ids in the order of the alphabet: the same for the same effects."""
        return tuple(sorted(self.ids))

    @property
    def n_effect(self) -> int:
        """Number of free parameters of the effects; N counts."""
        return sum(c.owner >= 0 for c in self.coordinates) + len(self.orders)

    def of(self, owner: int) -> list[Coordinate]:
        """Return the coordinates of the effect number `owner`."""
        return [c for c in self.coordinates if c.owner == owner]

    def start(self) -> Array:
        """Return the coordinates' start [P]."""
        return np.array([c.at(c.start) for c in self.coordinates])

    def start_from(self, base: 'CandidateModel', z: Array) -> Array:
        """Return the start [P] with the nominal values that `base` has at `z`."""
        nominal = {c.name: v for c, v in zip(base.coordinates, z) if c.owner < 0}
        return np.array([nominal.get(c.name, v) if c.owner < 0 else v
                         for c, v in zip(self.coordinates, self.start())])

    def bounded(self, z: Array) -> Array:
        """Return z [P] within the bounds."""
        low = [math.log(max(c.low, 1e-300)) if c.log else c.low for c in self.coordinates]
        high = [c.at(c.high) for c in self.coordinates]
        return np.clip(z, low, high)

    def _stopped(self, z: Array) -> list[tuple[Coordinate, float]]:
        """Return the effects' coordinates that sit at a bound that is finite, and their values."""
        rows = [(c, c.value(v))
                for c, v in zip(self.coordinates, self.bounded(z)) if c.owner >= 0]
        return [(c, v) for c, v in rows if min(v - c.low, c.high - v) <= 1e-6 * max(
            c.scale, abs(v))]

    def at_bound(self, z: Array) -> list[str]:
        """Return the names of the effects' coordinates that sit at a bound, at `z` [P]."""
        return [f'{self.ids[c.owner]}.{c.name}' for c, _ in self._stopped(z)]

    def beyond(self, z: Array, number: int) -> tuple[str, ...]:
        """
        Return which sizes of effect `number` stand at a bound of physics at `z` [P].

        A size of 0 is none: friction may have gone.
        """
        own = self.of(number)
        sizes = own if self.ids[number] in PHASED else own[:1]
        return tuple(f'{self.ids[number]}.{c.name}' for c, v in self._stopped(z)
                     if c in sizes and abs(v) > 1e-6 * c.scale)

    def steps(self) -> Array:
        """Return the steps [P] of finite differences."""
        return np.array([4e-3 if c.log else 4e-3 * c.scale for c in self.coordinates])

    def prior(self, z: Array) -> tuple[Array, Array]:
        """Return (pull [P], weight [P]) of the Gaussian prior on z [P]."""
        weight = np.array([c.prior ** -2 if c.prior else 0.0 for c in self.coordinates])
        return weight * (z - self.start()), weight

    def penalty(self, z: Array) -> float:
        """Return -2 log of the prior at z."""
        pull, _ = self.prior(z)
        return float(pull @ (z - self.start()))

    def values(self, z: Array) -> tuple[dict[str, float], list[dict[str, Any]]]:
        """
        Return (relative nuisances {name: factor - 1}, [{parameter: value} per effect]).

        Args:
            z: coordinates [P].
        """
        nuisances: dict[str, float] = {}
        parameters: list[dict[str, Any]] = [{} for _ in self.ids]
        for c, v in zip(self.coordinates, z):
            v = c.value(v)
            if c.owner < 0:
                nuisances[c.name] = v - 1.0 if c.log else v
            else:
                parameters[c.owner][c.name] = v
        for i, (name, values) in enumerate(zip(self.ids, parameters)):
            if name in PHASED:
                values.update(size_and_phase(name, values.pop('As'), values.pop('Ac')))
                if name in PERIODIC:
                    values['N'] = self.orders[i]
        for i, table in self.tables.items():
            torque = list(parameters[i].values())
            parameters[i] = {**table, 'values': torque, 'deviations': [0.0] * len(torque)}
        return nuisances, parameters

    def parameter(self, coordinate: Coordinate) -> str:
        """Return the name under which a coordinate of an effect is reported."""
        name = self.ids[coordinate.owner]
        wave = {'As': amplitude(name), 'Ac': 'phi'} if name in PHASED else {}
        return wave.get(coordinate.name, coordinate.name)

    def wave_jacobian(self, z: Array) -> Array:
        """Return the derivative [P, P] of coordinates, waves as size and phase, by `z` [P]."""
        out = np.eye(len(z))
        for i, name in enumerate(self.ids):
            if name in PHASED:
                own = [k for k, c in enumerate(self.coordinates) if c.owner == i]
                sine, cosine = z[own]
                size = max(math.hypot(sine, cosine), 1e-300)
                out[np.ix_(own, own)] = [[sine / size, cosine / size],
                                         [-cosine / size ** 2, sine / size ** 2]]
        return out

    def named_errors(self, z: Array, errors: Array) -> dict[str, dict[str, float]]:
        """
        Return {id: {parameter: standard error}} of the effects.

        Args:
            z: coordinates [P].
            errors: of the coordinates, waves as size and phase [P].
        """
        # The order of a periodic effect is a whole number, identified by search.
        out: dict[str, dict[str, float]] = {
            name: {'N': 0.0} if name in PERIODIC else {} for name in self.ids}
        for c, error, value in zip(self.coordinates, errors, z):
            if c.owner >= 0:
                out[self.ids[c.owner]][self.parameter(c)] = float(
                    error * (math.exp(value) if c.log else 1.0))
        return out

    def model(self, z: Array) -> DriveModel:
        """Return the DriveModel at z [P]."""
        nuisances, parameters = self.values(z)
        return with_effects(scaled(self.nominal, nuisances),
                            [{'id': name, **values} for name, values in zip(self.ids, parameters)])


def amplitude(name: str) -> str:
    """Return the name of the amplitude of the wave `name`, one of PHASED."""
    return EFFECTS[name].parameters[0].name


def probes(candidate: CandidateModel, share: float,
           at: Mapping[str, float]) -> list[tuple[dict[str, Any], float]]:
    """
    Return [(effect, size)], a little of an effect in each direction in which it is linear.

    Args:
        candidate: of this effect alone.
        share: of the scale of its coordinates.
        at: coordinates at which the effect changes nothing, see origin().
    """
    name, free = candidate.ids[0], candidate.of(0)
    size = share * free[0].scale
    if name in PHASED:
        order = {'N': candidate.orders[0]} if name in PERIODIC else {}
        sine, cosine = at.get('As', 0.0), at.get('Ac', 0.0)
        return [({'id': name, **order, **size_and_phase(name, *wave)}, size)
                for wave in ((sine + size, cosine), (sine, cosine + size))]
    values = {c.name: at.get(c.name, c.start) or share * c.scale for c in free}
    if free[0].name not in at:
        return [({'id': name, **values}, values[free[0].name])]
    values[free[0].name] = at[free[0].name] + size
    return [({'id': name, **values}, size)]


def size_and_phase(name: str, sine: float, cosine: float) -> dict[str, float]:
    """Return {amplitude, phi} of the wave `name`: the inverse of sine_and_cosine()."""
    return {amplitude(name): math.hypot(sine, cosine), 'phi': math.atan2(cosine, sine)}


def sine_and_cosine(name: str, values: Mapping[str, Any]) -> dict[str, float]:
    """Return {As, Ac}: the coordinates of the wave `name` with the parameters `values`."""
    size, phi = values[amplitude(name)], values.get('phi', 0.0)
    return {'As': size * math.cos(phi), 'Ac': size * math.sin(phi)}


def scaled(model: DriveModel, nuisances: Mapping[str, float]) -> DriveModel:
    """Return `model` changed by `nuisances` {name: relative change; u0: N m; ZERO: rad}."""
    if not nuisances:
        return model
    nuisances = dict(nuisances)
    for name, (effect, parameter) in BY_EFFECT.items():
        if name in nuisances:
            change = nuisances.pop(name)
            nominal = sum(e[parameter] for e in model.effects if e['id'] == effect)
            value = (1.0 + nominal) * (1.0 + change) - 1.0 if name == 'kt' else nominal + change
            model = with_effects(model, [{'id': effect, parameter: value}])
    shapes = {name: nuisances.pop(name, 0.0) for name in SHAPES}
    if any(shapes.values()):
        motor, arm = model.friction_sharpness, model.arm_sharpness
        model = replace(model, friction_sharpness=motor * (1.0 + shapes['alpha']),
                        arm_friction_sharpness=arm * (1.0 + shapes['alpha_arm']))
    if model.transmission.kind == 'rigid' and 'm1' in nuisances:
        nuisances['m2'] = nuisances['m1']  # the sum is what shows
    return model.with_values({NUISANCES[name]: model.value(NUISANCES[name]) * (1.0 + change)
                              for name, change in nuisances.items()})


def offered(model: DriveModel) -> list[str]:
    """Return the names of all values that can be fitted to the drive `model`."""
    hidden = (*RIGID_HIDES, ZERO) if model.transmission.kind == 'rigid' else ()
    # A value of 0 has no scale to move on.
    values = [name for name, where in NUISANCES.items() if model.value(where)]
    return [name for name in (*values, *BY_EFFECT) if name not in hidden]


def with_effects(model: DriveModel, effects: Sequence[Values]) -> DriveModel:
    """Return `model` with `found` effects (dicts) instead of those of the same id."""
    ids = {effect['id'] for effect in effects}
    retained = tuple(e for e in model.effects if e['id'] not in ids)
    return replace(model, effects=(*retained, *effects))


def with_law(candidate: CandidateModel, timestep: float) -> CandidateModel | None:
    """
    Return `candidate` with Coulomb friction by another law, None if the model has no friction.

    Of a smooth law the constraint that simulators solve, of a constraint the arctangent.

    Args:
        candidate: with the model's own law.
        timestep: s, at which the constraint is solved.
    """
    model = candidate.nominal
    ids = {*candidate.ids, *(e['id'] for e in model.effects)}
    if not (model.coulomb_friction > 0.0 or ids & {MOTOR_COULOMB.id, ARM_COULOMB.id}):
        return None
    variant = (replace(model, friction_law=FrictionLaw()) if model.friction_law.constraint
               else replace(model, friction_law=FrictionLaw('mujoco'),
                            timestep=model.timestep or timestep))
    return replace(candidate, nominal=variant)


def replaced_value(model: DriveModel, name: str) -> float | None:
    """Return the value of `model` that the effect `name` replaces, None when it replaces none."""
    effect = EFFECTS.get(name)
    if effect is None or not effect.replaces:
        return None
    return model.value(effect.replaces)


def own_effect(model: DriveModel, name: str, order: int | None = None) -> Values | None:
    """
    Return the effect `name` that `model` has, None if it has none.

    Args:
        model: model of the drive.
        name: id of an effect.
        order: of a periodic effect; one of another order is not it.
    """
    own = next((e for e in model.effects if e['id'] == name), None)
    return None if own is not None and name in PERIODIC and own['N'] != order else own


def origin(model: DriveModel, name: str, order: int | None = None) -> dict[str, float]:
    """
    Return {coordinate: value} at which the effect `name` changes nothing of `model`.

    For an effect that replaces a value, that value; for one that the model has, its parameters
    there, waves as sine and cosine; empty for others, which are off at 0.

    Args:
        model: model of the drive.
        name: id of an effect.
        order: of a periodic effect.
    """
    value = replaced_value(model, name)
    if value is not None:
        return {EFFECTS[name].parameters[0].name: value}
    own = own_effect(model, name, order)
    if own is None or name in NOT_FITTED:
        return {}
    waves = sine_and_cosine(name, own) if name in PHASED else {}
    return {**{k: float(v) for k, v in own.items() if isinstance(v, (int, float))}, **waves}


def nuisances_of(model: DriveModel) -> dict[str, float]:
    """
    Return {name: standard deviation} of the values that scatter; ones that are 0 do not.

    Args:
        model: model of the drive.
    """
    spread = {}
    if model.tolerance > 0.0:
        hidden = RIGID_HIDES if model.transmission.kind == 'rigid' else ()
        spread = {name: model.tolerance for name, where in NUISANCES.items()
                  if name not in (*hidden, *GAINS) and model.value(where)}
    if model.controller is not None and model.controller.tolerance > 0.0:
        spread.update((name, model.controller.tolerance) for name in GAINS
                      if model.value(NUISANCES[name]))
    if model.zero_tolerance > 0.0:
        spread[ZERO] = model.zero_tolerance
    return spread


class Starts:
    """Where fits of each effect begin, in the scales of one drive and its recordings."""

    def __init__(self, model: DriveModel, recordings: Sequence[UniformRecording]) -> None:
        self.model = model
        scales = [_scales(model, recording) for recording in recordings]
        self.scales = replace(scales[0], limits=_limits(np.concatenate(
            [r.torque for r in recordings])), **{
            name: max(getattr(s, name) for s in scales)
            for name in ('torque', 'peak', 'friction', 'speed', 'twist', 'angle', 'reach')})
        self.zero = float(np.mean([zero_and_swing(model, r)[0] for r in recordings]))
        travel = max(float(np.ptp(r.positions[:, r.channels[0]])) for r in recordings)
        # A wave of which less than a period is seen may be anything.
        self.orders = [order for order in ORDERS if order * travel >= 2.0 * math.pi]

    def none(self) -> CandidateModel:
        """Return the Candidate without effects."""
        return CandidateModel(self.model, (), tuple(self._nuisances(())))

    def candidates(self, name: str, order: int | None = None) -> list[CandidateModel]:
        """
        Return the Candidates, one per start, of the single effect `name`.

        The first start of an effect that the model has is as it is there.

        Args:
            name: id of the effect.
            order: order N of a periodic effect, None for the others.
        """
        own, usual = own_effect(self.model, name, order), self._usual_starts(name, order)
        return usual if own is None else [self.at(name, own), *usual]

    def _usual_starts(self, name: str, order: int | None) -> list[CandidateModel]:
        orders = {0: order} if order is not None and name in PERIODIC else {}
        return [self._candidate((name,), [[Coordinate(0, *free) for free in start]], orders)
                for start in library()[name].free_parameters(self.scales)]

    def at(self, name: str, values: Values) -> CandidateModel:
        """
        Return the Candidate of the single effect `name` that begins with these values.

        Args:
            name: id of the effect.
            values: its parameters; of those that are missing, it begins where fits do.
        """
        single = self._usual_starts(name, int(values.get('N', 1)))[0]
        if name in PHASED:
            values = {**values, **sine_and_cosine(name, values)}
        return replace(single, coordinates=tuple(
            replace(c, start=max(float(values[c.name]), 1e-300 if c.log else -math.inf))
            if c.owner == 0 and c.name in values else c for c in single.coordinates))

    def joint(self, parts: Iterable[tuple[CandidateModel, Array]]) -> CandidateModel:
        """
        Return the Candidate of several effects that begins where fits of them ended.

        parts: [(Candidate, z)] of single effects or pairs.
        """
        ids: list[str] = []
        groups, orders, tables = [], {}, {}
        for candidate, z in parts:
            for i, name in enumerate(candidate.ids):
                if i in candidate.tables:
                    tables[len(ids)] = candidate.tables[i]
                if i in candidate.orders:
                    orders[len(ids)] = candidate.orders[i]
                ids.append(name)
                groups.append([
                    replace(c, start=c.value(v))
                    for c, v in zip(candidate.coordinates, z) if c.owner == i])
        return replace(self._candidate(tuple(ids), groups, orders), tables=tables)

    def reduced(self, candidate: CandidateModel, z: Array,
                kept: Sequence[int]) -> tuple[CandidateModel, Array]:
        """
        Return the Candidate of some effects of another one alone, and where that has it.

        Args:
            candidate: of several effects.
            z: its coordinates [P].
            kept: numbers of the effects.
        """
        out = self._candidate(
            tuple(candidate.ids[i] for i in kept),
            list(map(candidate.of, kept)),
            {k: candidate.orders[i] for k, i in enumerate(kept) if i in candidate.orders})
        out = replace(out, tables={k: candidate.tables[i] for k, i in enumerate(kept)
                                   if i in candidate.tables})
        values = {(c.owner, c.name): v for c, v in zip(candidate.coordinates, z)}
        owners = (*kept, -1)  # -1: of a nominal value
        return out, np.array([values.get((owners[c.owner], c.name), v)
                              for c, v in zip(out.coordinates, out.start())])

    def _candidate(self, ids: tuple[str, ...], groups: Sequence[Sequence[Coordinate]],
                   orders: dict[int, int]) -> CandidateModel:
        coordinates = self._nuisances(ids)
        for i, group in enumerate(groups):
            coordinates += [replace(c, owner=i) for c in group]
        return CandidateModel(self.model, ids, tuple(coordinates), orders)

    def _nuisances(self, ids: Sequence[str]) -> list[Coordinate]:
        own = {EFFECTS[i].parameters[0].name for i in ids if i in EFFECTS and EFFECTS[i].replaces}
        spread = nuisances_of(self.model)
        if self.scales.swing:
            spread.update((name, SHIFTED) for effect, name in SHIFTS.items() if effect in ids
                          and self.model.value(NUISANCES[name]))
        zero = spread.pop(ZERO, 0.0)
        out = [Coordinate(-1, name, 0.0, r, -0.9, 10.0, prior=r)
               for name, r in spread.items() if name not in own]
        if zero and ENCODER_OFFSET.id not in ids:
            out.append(Coordinate(-1, ZERO, self.zero, min(
                zero, 0.1 * self.scales.swing or zero), prior=zero))
        return [*self._shapes(ids), *out]

    def _shapes(self, ids: Sequence[str]) -> list[Coordinate]:
        """Return coordinates of the shape of friction, where there is any."""
        model = self.model
        if not model.sharpness_tolerance or model.friction_law.constraint:
            return []
        sides = {'alpha': model.coulomb_friction > 0.0 or MOTOR_COULOMB.id in ids,
                 'alpha_arm': ARM_COULOMB.id in ids}
        return [Coordinate(-1, name, 1.0, 0.5, 1.0 / SHARPER, SHARPER, log=True,
                           prior=model.sharpness_tolerance) for name in SHAPES if sides[name]]


def zero_and_swing(model: DriveModel, recording: UniformRecording) -> tuple[float, float]:
    """
    Return (zero of the arm's encoder, swing of the twist), rad, where the readings tell more.

    Of encoders that share no zero, the middle of the twist tells more of it than the model file;
    the twist shows how far values may be off, also where the motion of a motor is put in.

    Args:
        model: of the drive.
        recording: of it.
    """
    low, high = np.percentile(np.diff(recording.positions, axis=1), TWIST)
    shared = model.zero_tolerance <= high - low
    return (0.0 if shared else float(0.5 * (low + high)),
            0.0 if shared and recording.motor is None else float(high - low))


def _scales(model: DriveModel, recording: UniformRecording) -> Scales:
    """Return the sizes of one drive in one recording."""
    t = model.transmission
    torque = max(float(np.std(recording.torque)), 1e-9)
    position, arm = recording.positions.T
    travel = position[10:] - position[:-10]
    twist = max(t.half_gap, torque / t.stiffness, 1e-6)
    swing = zero_and_swing(model, recording)[1]
    twist = max(twist, 0.5 * swing)
    measured = position - arm
    reach = float(np.ptp(measured) if model.zero_tolerance else np.abs(measured).max())
    values = {where: model.value(where) for where in (*NUISANCES.values(), 'delay')}
    return Scales(
        torque=torque, peak=max(float(np.abs(recording.torque).max()), 1e-9),
        friction=model.coulomb_friction or 0.1 * torque,
        speed=max(float(travel.std() / (10 * recording.dt)), 1e-6), twist=twist,
        angle=max(float(np.std(position)), 1e-6), swing=swing, values=values,
        reach=reach if len(recording.channels) == 2 or recording.motor is not None
        else math.inf)


def _limits(torque: Array) -> tuple[float, ...]:
    """
    Return levels of `torque` [N], N m, each of which cuts off twice the rms of the next higher.

    A limit may act on few samples or on many, and it acts in full: a fit that begins far from the
    true level makes the model worse than no limit does. One of these levels cuts off what the true
    limit does to within a factor of sqrt(2), so that less than half of its effect is left.
    """
    size = np.abs(torque)
    levels = max(float(size.max()), 1e-9) * np.linspace(*LIMITED)
    size = size[size > levels[-1]]
    cut = np.array([np.linalg.norm(np.maximum(size - level, 0.0)) for level in levels])
    count = 1 + int(np.log2(max(cut[-1] / max(cut[0], 1e-3 * cut[-1], 1e-300), 1.0)))
    wanted = cut[-1] * 0.5 ** np.arange(count)[::-1]
    return tuple(np.interp(wanted, cut, levels).tolist())
