# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Words for what changed in a gearbox: effect, place, size, and whether the model file holds."""
from collections.abc import Mapping
from typing import Any

from gearbox_monitor.diagnosis.joint.verdict import INCOMPLETE, NONE, UNKNOWN
from gearbox_monitor.report.summary import PLACES
from gearbox_monitor.report.words import number

UNDETERMINED = 'size not determined'


def sentence(verdict: Mapping[str, Any]) -> str:
    """Return a verdict on a change, as ChangeVerdict.to_dict has it, in one sentence."""
    kind = verdict['verdict']
    if kind == NONE:
        text = 'nothing named: no change beyond the baseline recording'
    elif kind == UNKNOWN:
        text = f'a change that no known effect explains ({_place(verdict["remainder"])})'
    else:
        text = ', '.join(map(_finding, verdict['findings']))
        if kind == INCOMPLETE:
            text += f', and more that no known effect explains ({_place(verdict["remainder"])})'
    return f'{text}; {model_words(verdict)}'


def model_words(verdict: Mapping[str, Any]) -> str:
    """Return whether the model file holds by `verdict`, in words."""
    if verdict['model_holds']:
        return 'the model file holds'
    if verdict['model_held']:
        return 'the model file no longer holds'
    missed = ' and '.join(verdict['effects_before'])
    return 'the model file did not hold in the baseline recording either' + (
        f' ({missed})' if missed else '')


def _finding(finding: Mapping[str, Any]) -> str:
    sizes = ', '.join(map(_value, finding['values']))
    return f'{finding["effect"]} ({_place(finding["place"])}): {sizes}'


def _place(location: str) -> str:
    return PLACES.get(location, location)


def _value(value: Mapping[str, Any]) -> str:
    unit = '' if value['unit'] == '-' else f' {value["unit"]}'
    text = f'{value["name"]} {number(value["before"])} to {number(value["now"])}{unit}'
    if value['relative'] is not None:
        digits = 1 if value['relative_std'] >= 0.001 else 2
        return (f'{text}, {100 * value["relative"]:+.{digits}f} % +- '
                f'{100 * value["relative_std"]:.{digits}f} %')
    if value['std'] is None:
        return f'{text} ({UNDETERMINED})'
    return f'{text} +- {value["std"]:.2g}'
