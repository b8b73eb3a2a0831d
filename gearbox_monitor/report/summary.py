# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The answer of a result in its first sentences, with sizes: of a verdict, of a fit.

One definition for the terminal, the page, the JSON and repr.
"""
from collections.abc import Iterable, Mapping, Sequence
import math
from typing import Any

from gearbox_monitor.diagnosis.joint.nominal import Adapted, FittedValue, NominalFit
from gearbox_monitor.estimation.noise_search import BLUNT
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.presentation import (
    change, credible, EXACT, number, on_axis, percent, Quantity, Said, said)
from gearbox_monitor.report.sentences import say

CERTAIN = 3.0  # errors by which a value differs from the model file
UNITS = {row.name: row.unit for row in ESTIMATOR}
NEAR_FLOOR = 1.5  # misfit that may be noise of the encoders
OWNERS = {
    'motor_side': "The motor's", 'arm_side': "The arm's", 'transmission': "The gearbox's",
    'controller': "The servo's", 'actuator': "The actuator's",
    'motor_sensor': "The motor encoder's", 'arm_sensor': "The arm encoder's"}
PLACES = {
    'motor_side': 'motor side', 'arm_side': 'arm side', 'transmission': 'transmission',
    'controller': 'controller', 'actuator': 'actuator', 'motor_sensor': 'motor encoder',
    'arm_sensor': 'arm encoder'}


def summary(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """
    Return the verdict in words: differences from the model, their sizes, their share.

    Args:
        data: of a verdict on one joint, as JSON has it.
        axis: of the drive.

    Returns:
        One to four sentences.
    """
    gap, misfit = data.get('gap_before') or 0.0, data.get('gap_after') or 0.0
    if data['verdict'] == 'undecided':
        return say('unshown', changes=' or of '.join(
            f'any {effect.noun}' if q['smallest'] is None else f'{effect.noun} below '
            f'{number(q["smallest"], on_axis(effect.parameters[0].unit, axis))}'
            for q in data['questions'] for effect in (EFFECTS[q['effect']],)))
    if data['verdict'] == 'none':
        code = ('small_residual' if misfit > NEAR_FLOOR else
                'within_tolerances' if gap > NEAR_FLOOR else 'no_gap')
        return say(code, misfit=number(misfit))
    if data['verdict'] == 'unknown':
        remainder = data.get('remainder') or {'location': data.get('location')}
        place = (Said('at', {'place': _place(remainder)}) if remainder['location'] in PLACES
                 else Said('no_place'))
        return say('unexplained', misfit=number(gap), place=(place,))
    findings, many = data['findings'], '1' if len(data['findings']) == 1 else 'n'
    sentences = [finding_sentence(f, data, axis) for f in findings]
    if data['verdict'] == 'incomplete' and data.get('remainder'):
        share = findings[0].get('share')
        part = percent(share) if many == '1' and share is not None else 'a part'
        sentences.append(say(f'part_{many}', part=part, place=_place(data['remainder'])))
    else:
        sentences.append(say(f'all_{many}'))
    if data.get('confusable'):
        sentences.append(say(f'rivals_{many}', rivals=', '.join(data['confusable'])))
    return ' '.join(sentences)


def finding_sentence(finding: Mapping[str, Any], data: Mapping[str, Any], axis: str) -> str:
    """
    Return one sentence on one effect: its value, the value of the model, the change.

    Args:
        finding: one of the findings of a verdict.
        data: the verdict, with `model_values`, `bursts` and `slips`.
        axis: of the drive.
    """
    name, values = finding['effect'], finding['values']
    effect = library().get(name)
    if name == DISTURBANCE.id:
        count = len(data.get('bursts') or ()) or 1
        return say('bursts', bursts='One burst' if count == 1 else f'{count} bursts',
                   torque=on_axis('torque', axis), time=number(values['t0'], 's'),
                   size=number(values['amplitude'], on_axis('N m', axis)))
    if name == SLIP.id:
        count = len(data.get('slips') or ())
        return say('slipped_n' if count > 1 else 'slipped_1', count=count, size=Quantity(
            abs(values['Ds']), finding['deviations']['Ds'], on_axis('rad', axis)),
            time=number(values['t0'], 's'))
    if effect is None or effect.parameters[0].name not in values:
        return say('acts', effect=name)
    parameter = effect.parameters[0]
    size = credible(values[parameter.name], finding['deviations'].get(parameter.name),
                    on_axis(parameter.unit, axis))
    nominal = (data.get('model_values') or {}).get(name, {}).get(parameter.name)
    if not nominal:
        model = Said('model_has_none')
    elif name in EFFECTS and EFFECTS[name].adds_to:
        model = Said('beyond_model', {'size': Quantity(nominal, unit=size.unit)})
    else:
        model = Said('not_model', {'size': Quantity(nominal),
                                   'change': change(values[parameter.name], nominal)})
    return say('effect', owner=OWNERS.get(finding['place'], 'The'), noun=effect.noun or name,
               size=size, doubt=(Said('doubt'),) if size.deviation is None else (),
               turns=(Said('turns', {'count': values['N']}),) if 'N' in values else (),
               nominal=(model,))


def _place(remainder: Mapping[str, Any]) -> str:
    """Return the place of a remainder and the quantity that it follows."""
    over = f', over the {remainder["over"]}' if remainder.get('over') else ''
    return PLACES.get(remainder['location'], remainder['location']) + over


def told(says: Iterable[Said]) -> dict[str, Any]:
    """Return what a result `says` as plain data: its summary in words, and its codes."""
    listed = list(says)
    return {'summary': ' '.join(map(str, listed)), 'codes': [said.code for said in listed]}


def largest_change(values: Iterable[FittedValue]) -> Said:
    """Return which of `values` changed most in its errors."""
    moved = max((v for v in values if v.error and v.value != v.start), default=None,
                key=lambda v: abs(v.value - v.start) / v.error)
    if moved is None or abs(moved.value - moved.start) < CERTAIN * moved.error:
        return said('fit_changes_nothing')
    by = (said('by', change=change(moved.value, moved.start)),) if moved.start else ()
    return said('fit_changes', name=moved.name, start=number(moved.start), by=by,
                size=credible(moved.value, moved.error, moved.unit))


def of_fit(fit: NominalFit) -> Sequence[Said]:
    """Return what a `fit` says: what it determines, what changes most, its misfit."""
    sure, count = [v for v in fit.values if v.determined], len(fit.values)
    code = ('fits_it' if sure else 'fits_it_not') if count == 1 else (
        'fits_all' if len(sure) == count else 'fits_part')
    return (said(code, sure=len(sure), count=count), largest_change(sure),
            said('misfit' if fit.gap_before is None else 'misfit_change',
                 before=number(fit.gap_before), misfit=number(fit.gap_after)))


def of_unit(unit: Adapted) -> Sequence[Said]:
    """Return what the model of one `unit` says."""
    if unit.fit is None:
        return said('unit_unknown', why='; '.join(unit.open)),
    if unit.kept:
        return said('unit_kept'),
    sure, count = [v for v in unit.fit.values if v.determined], len(unit.fit.values)
    return (said('unit_fits', sure=len(sure), count=f'{count} value{"s" * (count != 1)}'),
            largest_change(sure), said('misfit', misfit=number(unit.fit.gap_after)))


def of_noise(figures: Mapping[str, Any], axis: str = 'rotary') -> Sequence[Said]:
    """Return what the `figures` of a tuned filter of a drive with `axis` say."""
    if figures['kept']:
        return said('noise_kept'),
    start, tuned = figures['before'], figures['after']
    gain = tuned['loglik'] - start['loglik']
    says = [said('noise_likelier' if gain > 0.0 else 'noise_not_likelier', gain=gain,
                 likelihood=tuned['loglik'], nis=tuned['nis'], before=start['nis'])]
    before, errors = figures['before_parameters'], figures['relative_error']
    moved = {name: abs(math.log(value / before[name]))
             for name, value in figures['parameters'].items()
             if isinstance(value, float) and value > 0.0 and (before[name] or 0.0) > 0.0
             and errors.get(name, 0.0) <= BLUNT}
    name = max(moved, key=lambda n: moved[n], default=None)
    if name is not None and moved[name] > 0.0:
        value = figures['parameters'][name]
        size = Quantity(value, value * errors.get(name, EXACT), on_axis(UNITS[name], axis))
        says.append(said('noise_changes', name=name, size=size, start=number(before[name]),
                         change=change(value, before[name])))
    return says
