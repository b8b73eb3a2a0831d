# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Ranges of parameters from several fits, verdicts or their JSON files.

They become the domain randomisation of a simulator: YAML, Isaac Lab, mjlab. The events of both
frameworks draw each parameter alone; a function beside them draws all parameters of the joint
together, with their correlation. Their texts stand in simulators/templates.
"""
from collections.abc import Callable, Mapping, Sequence
from functools import cache
import math
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
import numpy as np
import yaml

from gearbox_monitor.diagnosis.joint.candidates import NUISANCES
from gearbox_monitor.diagnosis.joint.nominal import Adapted, FittedValue, NominalFit
from gearbox_monitor.diagnosis.joint.parameter_ranges import (
    NORMAL, ParameterRanges, ranges_of, UnitEstimate)
from gearbox_monitor.diagnosis.joint.verdict import Verdict
from gearbox_monitor.diagnosis.robot.robot_effects import PAYLOAD
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.files.user_files import read_json
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.library.robot import RobotDiagnosis
from gearbox_monitor.plant.effects import library
from gearbox_monitor.plant.effects.actuator import ACTUATOR_DELAY
from gearbox_monitor.presentation import on_axis

SHORT = {where: name for name, where in NUISANCES.items()}
EXPECTED = 'JSON of fit or diagnose, or a result of fit or diagnose'
Source = NominalFit | Adapted | Verdict | RobotDiagnosis | str | Path


def ranges(sources: Sequence[Source]) -> ParameterRanges:
    """
    Return the ranges that a new drive of the kind may have, from estimates of several.

    Args:
        sources: one estimate of each drive, or of each recording of one drive: results of `fit`,
            `adapt`, `diagnose` and `diagnose_robot`, or the JSON files of the commands. Of
            a verdict the values of its findings count, as if their errors were independent; of
            one on a robot only its payload.

    Returns:
        The ranges: `low` and `high` hold 90 %; `sample` draws drives; `save` writes YAML.

    Raises:
        InputError: a source has no values with errors, or none in common with the others.

    >>> ranges([])
    Traceback (most recent call last):
    ...
    gearbox_monitor.errors.InputError: sources: none, expected one or several estimates
    """
    if isinstance(sources, (str, Path)) or not isinstance(sources, Sequence):
        raise InputError(f'sources: {sources!r}, expected a list of {EXPECTED}')
    if not sources:
        raise InputError('sources: none, expected one or several estimates')
    paths = [Path(source).resolve() for source in sources if isinstance(source, (str, Path))]
    for path in paths:
        if paths.count(path) > 1:
            raise InputError(f'sources: {path.name}: named twice, expected each estimate once')
    notes: list[str] = []
    return ranges_of([_estimate(source, f'estimate {i + 1}', notes)
                      for i, source in enumerate(sources)], notes)


def _estimate(source: Any, name: str, notes: list[str]) -> UnitEstimate:
    """Return the UnitEstimate of a source; add to `notes` which values have no range."""
    if isinstance(source, (str, Path)):
        return _read(Path(source), notes)
    if isinstance(source, Adapted):
        if source.fit is None:
            raise InputError(f'{name}: adapt identified no value, expected a fit')
        source = source.fit
    if isinstance(source, NominalFit):
        return _of_values(source.values, source.covariance, name, notes)
    if isinstance(source, Verdict):
        return _of_findings([f.to_dict() for f in source.findings], name, notes)
    if isinstance(source, RobotDiagnosis):
        return _of_payload(source.data['findings'], name, notes)
    raise InputError(f'{name}: {type(source).__name__}, expected {EXPECTED}')


def _read(path: Path, notes: list[str]) -> UnitEstimate:
    """Return the UnitEstimate in a JSON file."""
    data = read_json(path, EXPECTED)
    if isinstance(data, dict) and isinstance(data.get('findings'), list):
        if isinstance(data.get('remainders'), list) and 'axis' not in data:
            return _of_payload(data['findings'], str(path), notes)
        return _of_findings(data['findings'], str(path), notes)
    rows = data.get('values') if isinstance(data, dict) else None
    if not isinstance(rows, dict):
        raise InputError(f'{path}: neither values nor findings, expected {EXPECTED}')
    for name, row in rows.items():
        if not (isinstance(row, dict) and _is_number(row.get('value'))
                and _is_number(row.get('error')) and not row['error'] < 0.0
                and isinstance(row.get('unit', ''), str)):
            raise InputError(f'{path}: values: {name}: no value, error and unit, expected '
                             f'{EXPECTED}')
    values = [FittedValue(name, row.get('unit', ''), math.nan, row['value'], row['error'], True)
              for name, row in rows.items()]
    try:
        covariance = data.get('covariance')
        covariance = None if covariance is None else np.array(covariance, float)
        if covariance is not None and covariance.shape != (len(values), len(values)):
            raise ValueError
    except (TypeError, ValueError):
        raise InputError(f'{path}: covariance: expected {len(values)} rows of {len(values)} '
                         'numbers, those of the values') from None
    return _of_values(values, covariance, str(path), notes)


def _of_values(values: Sequence[FittedValue], covariance: Any, name: str,
               notes: list[str]) -> UnitEstimate:
    """Return the UnitEstimate of the values of a fit."""
    if covariance is None:
        notes.append(f'{name}: no covariance, its errors count as independent')
    return UnitEstimate.of(name, values, covariance)


def _of_findings(findings: Sequence[Any], name: str, notes: list[str]) -> UnitEstimate:
    """Return the UnitEstimate of the findings of a verdict, as plain data."""
    values, units, errors = dict[str, float](), dict[str, str](), list[float]()
    for finding in findings:
        if not (isinstance(finding, dict) and isinstance(finding.get('effect'), str)
                and all(isinstance(finding.get(key), Mapping)
                        for key in ('values', 'deviations'))):
            raise InputError(f'{name}: findings: no effect, values and deviations, expected '
                             f'{EXPECTED}')
        for where, own, unit in _parameters(finding, name):
            value, error = finding['values'].get(own), finding['deviations'].get(own)
            if not _is_number(value):
                continue
            if not _is_number(error):
                notes.append(f'{name}: {where}: without a deviation, no range')
                continue
            if error < 0.0:
                raise InputError(f'{name}: findings: {where}: deviation {error:g}, expected no '
                                 'negative number')
            if where in values:
                raise InputError(f'{name}: findings: {where}: two values, expected one')
            values[where], units[where] = float(value), unit
            errors.append(float(error))
    if not values:
        raise InputError(f'{name}: no finding with values and deviations, expected {EXPECTED}')
    return UnitEstimate(name, values, units, np.diag(np.square(errors)))


def _parameters(finding: Mapping[str, Any], name: str) -> list[tuple[str, str, str]]:
    """Return (name of the range, name in the finding, unit) of each parameter of a finding."""
    if finding['effect'] == PAYLOAD.id:
        return [(f'{PAYLOAD.id}.{own}', own, f'{unit} at {finding.get("link")}')
                for own, unit in PAYLOAD.units.items()]
    effect = library().get(finding['effect'])
    if effect is None:
        raise InputError(f'{name}: findings: effect: {finding["effect"]!r}, expected the id of an '
                         'effect')
    return [(SHORT.get(effect.replaces, f'{effect.id}.{p.name}'), p.name,
             on_axis(p.unit, 'rotary')) for p in effect.parameters]


def _of_payload(findings: Sequence[Any], name: str, notes: list[str]) -> UnitEstimate:
    """Return the UnitEstimate of the payload in the findings of a robot, as plain data."""
    findings = [f if isinstance(f, dict) else {} for f in findings]
    payloads = [f for f in findings if f.get('effect') == PAYLOAD.id]
    notes += [f'{name}: {f.get("effect")} at {f.get("joint") or f.get("link") or "the base"}: of '
              'a robot only the payload has a range' for f in findings if f not in payloads]
    if len(payloads) != 1:
        raise InputError(f'{name}: {len(payloads)} payloads, expected one in the verdict on a '
                         'robot')
    return _of_findings(payloads, name, notes)


def _is_number(value: object) -> bool:
    """Return whether a value of a JSON file is a number that a float holds."""
    return isinstance(value, float) or (
        isinstance(value, int) and not isinstance(value, bool) and value.bit_length() < 1024)


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
    width = math.log(high) - math.log(low) if ranges.logarithmic[i] else high - low
    return width / (2.0 * NORMAL)


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
