# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Ranges of parameters as the domain randomisation of a simulator: YAML, Isaac Lab, mjlab.

The events of both frameworks draw each parameter alone; a function beside them draws all
parameters of the joint together, with their correlation. Their texts stand in templates/.
"""
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from math import log
from types import MappingProxyType
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
import yaml

from gearbox_monitor.diagnosis.joint.parameter_ranges import NORMAL, ParameterRanges
from gearbox_monitor.diagnosis.robot.robot_effects import PAYLOAD
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.actuator import ACTUATOR_DELAY

FRICTION, VISCOUS, ARMATURE = 'Cc', 'Cv', 'm1'
DELAY, WEIGHT = 'actuator_delay.T', 'gravity.G'
MASS = f'{PAYLOAD.id}.m'  # mass that a robot holds beyond its file
JOINT = (FRICTION, VISCOUS, ARMATURE)  # that the function which draws together can write
MJLAB = {FRICTION: ('joint_friction', 'dof_frictionloss'),  # event and field of mujoco.MjModel
         VISCOUS: ('joint_damping', 'dof_damping'), ARMATURE: ('joint_armature', 'dof_armature')}
NAMES = {'delay': DELAY, 'weight': WEIGHT, 'mass': MASS}  # short ones
RELATED = 0.3  # correlation that is worth a sentence
JOINTS, BODIES, ACTUATORS = ('joint_names=JOINTS', 'body_names=BODIES', 'actuator_names=JOINTS')


class _Range(NamedTuple):
    """A range as text, and as text relative to its centre."""

    absolute: str
    relative: str
    law: str


class _Event(NamedTuple):
    """A term of the events: its function, what of the scene it changes, its parameters as text."""

    name: str
    function: str
    asset: str
    parameters: Mapping[str, str]


def randomisation(ranges: ParameterRanges, to: str) -> str:
    """
    Return ranges as a text of a simulator.

    Args:
        ranges: of a new drive.
        to: yaml, isaac or mjlab.

    Raises:
        InputError: another simulator.
    """
    if to not in WRITERS:
        raise InputError(f'to: {to!r}, {unknown(to, WRITERS)}')
    return WRITERS[to](ranges)


def ranges_data(ranges: ParameterRanges) -> dict[str, Any]:
    """Return ranges as plain data, the schema of the YAML file."""
    rows = {}
    for i, name in enumerate(ranges.names):
        rows[name] = {
            'unit': ranges.units[i], 'median': _rounded(ranges.centre[i]),
            'low': _rounded(ranges.low[i]), 'high': _rounded(ranges.high[i]),
            'distribution': 'lognormal' if ranges.logarithmic[i] else 'normal'}
        if ranges.between[i] == ranges.between[i]:
            rows[name]['between'] = _rounded(ranges.between[i])
    return {
        'confidence': 0.9, 'parameters': rows,
        'correlation': [[round(float(r), 3) for r in row] for row in ranges.correlation],
        'known_only_in_combination': [
            {'exponents': {k: round(v, 3) for k, v in c.exponents.items()},
             'deviation': _rounded(c.deviation)} for c in ranges.combinations],
        'sources': list(ranges.sources), 'notes': list(ranges.notes)}


def _yaml(ranges: ParameterRanges) -> str:
    head = ('# 90 % ranges of a new drive. lognormal: low and high are 5 % and 95 % of it, '
            'between is\n# the relative deviation from drive to drive; correlation: of the '
            'logarithms.\n')
    return head + yaml.safe_dump(ranges_data(ranges), sort_keys=False, width=99,
                                 allow_unicode=True)


def _rounded(value: float) -> float:
    return float(f'{value:.4g}')


@cache
def _environment() -> Environment:
    return Environment(loader=PackageLoader('gearbox_monitor.simulators'), trim_blocks=True,
                       lstrip_blocks=True, keep_trailing_newline=True, undefined=StrictUndefined)


def _text(template: str, ranges: ParameterRanges, r: Mapping[str, _Range | None],
          events: Sequence[_Event], varied: Sequence[str]) -> str:
    """
    Return the text of a framework.

    Args:
        template: its file.
        ranges: of a new drive.
        r: of `_ranges`.
        events: that draw each parameter alone.
        varied: names of the parameters that they draw.
    """
    return _environment().get_template(template).render(
        ranges=ranges, r=r, events=events, remarks=_remarks(ranges), joint=_joint(ranges),
        lacking=[name for name in ranges.names if name not in varied],
        fields={name: field for name, (_, field) in MJLAB.items() if r[name]})


def _remarks(ranges: ParameterRanges) -> list[str]:
    """Return comments on what the ranges do not say."""
    lines = [str(combination) for combination in ranges.combinations]
    for i in range(len(ranges.names)):
        lines += [f'{ranges.names[j]} and {ranges.names[i]}: correlation '
                  f'{ranges.correlation[i, j]:.2f}' for j in range(i)
                  if abs(ranges.correlation[i, j]) > RELATED]
    return [*lines, *ranges.notes]


def _ranges(ranges: ParameterRanges) -> dict[str, _Range | None]:
    """
    Return {name: range, None where it has none} of what events draw, by the short NAMES.

    A weight whose sign is open has none: it is no factor on a mass.
    """
    r = {name: _range(ranges, NAMES.get(name, name)) for name in (*JOINT, 'kp', 'kd', *NAMES)}
    i = ranges.index(WEIGHT)
    if i is not None and ranges.low[i] * ranges.high[i] <= 0.0:
        r['weight'] = None
    return r


def _range(ranges: ParameterRanges, name: str) -> _Range | None:
    i = ranges.index(name)
    if i is None:
        return None
    low, high, centre = (float(v[i]) for v in (ranges.low, ranges.high, ranges.centre))
    law = 'log_uniform' if ranges.logarithmic[i] else 'uniform'
    shares = sorted((low / centre, high / centre)) if centre else (1.0, 1.0)
    return _Range(f'({low:.6g}, {high:.6g})', f'({shares[0]:.5g}, {shares[1]:.5g})', law)


def _joint(ranges: ParameterRanges) -> dict[str, Any]:
    """Return what draws the parameters of the joint together, as texts; {} for none of them."""
    own = [i for i, name in enumerate(ranges.names) if name in JOINT]

    def _row(values: Sequence[float] | Array) -> str:
        return ', '.join(f'{value:.6g}' for value in values)
    return {} if not own else {
        'names': ', '.join(repr(ranges.names[i]) for i in own), 'centre': _row(ranges.centre[own]),
        'low': _row(ranges.low[own]), 'high': _row(ranges.high[own]),
        'deviation': _row([_deviation(ranges, i) for i in own]),
        'logarithmic': ', '.join(str(ranges.logarithmic[i]) for i in own),
        'correlation': [', '.join(f'{ranges.correlation[i, j]:.4f}' for j in own) for i in own]}


def _deviation(ranges: ParameterRanges, i: int) -> float:
    """Return the deviation of a normal with the range of the parameter at i, on its scale."""
    low, high = float(ranges.low[i]), float(ranges.high[i])
    return ((log(high) - log(low)) if ranges.logarithmic[i] else high - low) / (2.0 * NORMAL)


def _drawn(operation: str, law: str) -> dict[str, str]:
    return {'operation': repr(operation), 'distribution': repr(law)}


def _alone(event: tuple[str, str, str], drawn: _Range | None, key: str, operation: str,
           constants: Mapping[str, str] = MappingProxyType({})) -> list[_Event]:
    """Return the event (name, function, asset) that draws a range, none without a range."""
    return [] if drawn is None else [_Event(*event, {
        key: drawn.relative if operation == 'scale' else drawn.absolute, **constants,
        **_drawn(operation, drawn.law)})]


def _isaac(ranges: ParameterRanges) -> str:
    """Return event terms of Isaac Lab."""
    r = _ranges(ranges)
    friction, armature, weight, mass = r[FRICTION], r[ARMATURE], r['weight'], r['mass']
    gains = {key: gain for key, gain in (('stiffness_distribution_params', r['kp']),
                                         ('damping_distribution_params', r['kd'])) if gain}
    change, shift = 'mdp.randomize_joint_parameters', 'mdp.randomize_rigid_body_mass'
    whole, amount = {'recompute_inertia': 'True'}, 'mass_distribution_params'
    events = [*_alone(('joint_friction', change, JOINTS), friction,
                      'friction_distribution_params', 'scale'),
              *_alone(('joint_armature', change, JOINTS), armature,
                      'armature_distribution_params', 'abs')]
    if gains:
        events.append(_Event('actuator_gains', 'mdp.randomize_actuator_gains', JOINTS, {
            **{key: gain.absolute for key, gain in gains.items()},
            **_drawn('abs', next(iter(gains.values())).law)}))
    events += [*_alone(('payload', shift, BODIES), weight, amount, 'scale', whole),
               *_alone(('payload_mass', shift, BODIES), mass, amount, 'add', whole)]
    varied = [*(JOINT if friction else (ARMATURE,)), 'kp', 'kd', DELAY,
              *((WEIGHT,) if weight else ()), MASS]
    return _text('isaac.py.jinja', ranges, r, events, varied)


def _mjlab(ranges: ParameterRanges) -> str:
    """Return event terms of mjlab."""
    r = _ranges(ranges)
    kp, kd, weight, mass = r['kp'], r['kd'], r['weight'], r['mass']
    events = [row for name, (event, _) in MJLAB.items()
              for row in _alone((event, f'dr.{event}', JOINTS), r[name], 'ranges', 'abs')]
    if gain := kp or kd:
        events.append(_Event('pd_gains', 'dr.pd_gains', ACTUATORS, {
            'kp_range': kp.relative if kp else '(1.0, 1.0)',
            'kd_range': kd.relative if kd else '(1.0, 1.0)', **_drawn('scale', gain.law)}))
    for name, drawn, operation in (('payload', weight, 'scale'), ('payload_mass', mass, 'add')):
        events += _alone((name, 'dr.body_mass', BODIES), drawn, 'ranges', operation)
    if r['delay']:
        events.append(_Event(ACTUATOR_DELAY.id, 'dr.sync_actuator_delays', ACTUATORS, {
            'lag_range': 'DELAY_STEPS'}))
    return _text('mjlab.py.jinja', ranges, r, events, [
        *JOINT, 'kp', 'kd', DELAY, MASS, *((WEIGHT,) if weight else ())])


WRITERS: dict[str, Callable[[ParameterRanges], str]] = {
    'yaml': _yaml, 'isaac': _isaac, 'mjlab': _mjlab}
