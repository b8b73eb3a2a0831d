# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write the ROS parameter file of a tuned estimator."""
from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

from gearbox_monitor import __version__
from gearbox_monitor.files.opening import write_new
from gearbox_monitor.parameters import EstimatorParameters, SETTINGS


def write_parameters(path: str | Path, parameters: EstimatorParameters,
                     model: tuple[str, dict[str, Any]], data: Mapping[str, Any]) -> None:
    """
    Write the parameter file that node and replay load.

    Args:
        path: of the new file.
        parameters: before.
        model: its file, '' for none, and values that replace those in it.
        data: result of the tuning.

    Raises:
        InputError: the file cannot be written.

    """
    rows = {row.name: row for row in SETTINGS}
    values = parameters.changes()
    values.update(model[1], **data['parameters'], filter=data['filter'])
    if model[0]:
        values['model'] = str(Path(model[0]).resolve())
    lines = [
        f'# Written by gearbox_monitor {__version__} {data.get("command", "tune")} from '
        f'{data["bag"]}.']
    if data['after']:
        lines.append(f'# Mean NIS {data["after"]["nis"]:.3f}, '
                     f'log-likelihood {data["after"]["loglik"]:.1f}.')
    if data['smoother']:
        lines.append('# For the smoothed torque: q_std_tau_k is that of the filter / sqrt(5).')
    lines += ['estimator:', '  ros__parameters:']
    for name in rows:
        if name in values:
            comment = [rows[name].unit] if rows[name].unit not in ('', '-') else []
            if name in data['parameters']:
                error = data['relative_error'].get(name)
                comment.append('tuned' + error_words(error))
            entry = f'    {name}: {_yaml(values[name])}'
            lines.append(f'{entry:40s} # {", ".join(comment)}' if comment else entry)
    write_new(path, '\n'.join(lines) + '\n')


def _yaml(value: object) -> str:
    """Return `value` as YAML 1.1 reads it back: 1e-05 would be a string."""
    if isinstance(value, float):
        digits = repr(value)
        mantissa, e, exponent = digits.partition('e')
        return f'{mantissa if "." in mantissa else mantissa + ".0"}e{exponent}' if e else digits
    return json.dumps(value)


def error_words(error: float | None) -> str:
    """Return the relative standard `error` of a tuned value in words, '' for none."""
    if not error:
        return ''
    return f' +- {100 * error:.2g} %' if error < 1.0 else ', undetermined'
