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

"""The baseline file: what the backlash was when the gearbox was healthy."""
from dataclasses import asdict, fields
import math
import os
from pathlib import Path

import yaml

from gearbox_monitor import __version__
from gearbox_monitor.drift.change import Baseline
from gearbox_monitor.errors import InputError
from gearbox_monitor.files import load_yaml


def load_baseline(path):
    """Return the Baseline in the file `path`. Raises InputError."""
    data = load_yaml(path)
    values = data.get('baseline') if isinstance(data, dict) else None
    if not isinstance(values, dict):
        raise InputError(f'{path}: {data!r}, expected a block "baseline"')
    result = {}
    for field in fields(Baseline):
        value = values.get(field.name)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or \
                not math.isfinite(value) or value < 0.0:
            raise InputError(f'{path}: baseline.{field.name}: {value!r}, expected a number >= 0')
        result[field.name] = float(value)
    return Baseline(**result)


def save_baseline(path, baseline, gearbox_serial):
    """Write `baseline` to `path`, whole or not at all. Raises InputError."""
    text = yaml.safe_dump({
        'gearbox_monitor': __version__, 'gearbox_serial': gearbox_serial,
        'baseline': asdict(baseline)}, sort_keys=False)
    path = Path(path)
    temporary = path.with_name(path.name + '.tmp')
    try:
        temporary.write_text(text, encoding='utf-8')
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a writable file') from None
