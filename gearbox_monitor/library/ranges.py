# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Ranges of parameters from several fits, verdicts or their JSON files, for randomisation."""
from collections.abc import Mapping, Sequence
import math
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from gearbox_monitor.diagnosis.joint.candidates import NUISANCES
from gearbox_monitor.diagnosis.joint.nominal import Adapted, FittedValue, NominalFit
from gearbox_monitor.diagnosis.joint.parameter_ranges import (
    ParameterRanges, ranges_of, UnitEstimate)
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import read_json
from gearbox_monitor.library.identify import Diagnosis
from gearbox_monitor.plant.effects import library
from gearbox_monitor.presentation import on_axis

SHORT = {where: name for name, where in NUISANCES.items()}
EXPECTED = 'JSON of fit or diagnose, or a result of fit or diagnose'
Source = NominalFit | Adapted | Diagnosis | str | Path


def ranges(sources: Sequence[Source]) -> ParameterRanges:
    """
    Return the ranges that a new drive of the kind may have, from estimates of several.

    Args:
        sources: one estimate of each drive, or of each recording of one drive: results of `fit`,
            `adapt` and `diagnose`, or the JSON files of the commands. Of a verdict on a drive
            the values of its findings count, as if their errors were independent.

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
    if isinstance(source, Diagnosis):
        return _of_findings([f.to_dict() for f in source.findings], name, notes)
    raise InputError(f'{name}: {type(source).__name__}, expected {EXPECTED}')


def _read(path: Path, notes: list[str]) -> UnitEstimate:
    """Return the UnitEstimate in a JSON file."""
    data = read_json(path, EXPECTED)
    if isinstance(data, dict) and isinstance(data.get('findings'), list):
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
    if finding.get('joint') or finding.get('link'):
        raise InputError(f'{name}: findings: of a robot, expected a verdict on a drive')
    effect = library().get(finding['effect'])
    if effect is None:
        raise InputError(f'{name}: findings: effect: {finding["effect"]!r}, expected the id of an '
                         'effect')
    return [(SHORT.get(effect.replaces, f'{effect.id}.{p.name}'), p.name,
             on_axis(p.unit, 'rotary')) for p in effect.parameters]


def _is_number(value: object) -> bool:
    """Return whether a value of a JSON file is a number that a float holds."""
    return isinstance(value, float) or (
        isinstance(value, int) and not isinstance(value, bool) and value.bit_length() < 1024)


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


def ranges_yaml(ranges: ParameterRanges) -> str:
    """Return `ranges` as a YAML file."""
    head = ('# 90 % ranges of a new drive. lognormal: low and high are 5 % and 95 % of it, '
            'between is\n# the relative deviation from drive to drive; correlation: of the '
            'logarithms.\n')
    return head + yaml.safe_dump(ranges_data(ranges), sort_keys=False, width=99,
                                 allow_unicode=True)


def _rounded(value: float) -> float:
    return float(f'{value:.4g}')
