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

"""Read a recording from CSV: columns t, u, motor, arm and, where measured, arm_torque."""
from dataclasses import dataclass
import gzip
import io
from pathlib import Path
import zlib

import numpy as np

from gearbox_monitor.bag.importer.columns import read_columns
from gearbox_monitor.bag.importer.mapping import mapping_from_dict
from gearbox_monitor.errors import InputError

# Column -> name of the importer's signal; the units are s, N m and rad.
COLUMNS = {'t': 'time', 'u': 'motor_effort', 'motor': 'motor_position', 'arm': 'arm_position',
           'arm_torque': 'arm_effort'}
NEEDED = ('t', 'u', 'motor', 'arm')
DELIMITERS = (',', ';', '\t')


@dataclass(frozen=True)
class CsvColumns:
    """
    Columns of a CSV file as they stand there, float64 [N], NaN where not measured.

    t s; u N m; motor, arm rad; arm_torque N m or None. notices: sentences for the user.
    place(row, column): where a value stands, for messages.
    """

    t: np.ndarray
    u: np.ndarray
    motor: np.ndarray
    arm: np.ndarray
    arm_torque: np.ndarray | None
    place: object
    notices: tuple = ()


def read_csv(path):
    """
    Return the CsvColumns of the file `path`, gzipped or not, with a header row.

    Commas, semicolons or tabs between values; '#' begins a comment line. An empty value or 'nan'
    is not measured. Other columns are ignored, with a notice.
    Raises InputError naming file, line, column, value and what was expected.
    """
    header, delimiter = _header(path)
    for name in COLUMNS:
        if header.count(name) > 1:
            raise InputError(f'{path}: header row: column {name!r} stands {header.count(name)} '
                             'times, expected once')
    missing = [name for name in NEEDED if name not in header]
    if missing:
        raise InputError(f'{path}: header row: no column {", ".join(missing)} in '
                         f'{", ".join(header)[:80]!r}, expected t,u,motor,arm[,arm_torque]')
    signals = {signal: {'column': header.index(name) + 1, 'missing': 'nan'}
               for name, signal in COLUMNS.items() if name in header and name != 't'}
    mapping = mapping_from_dict(
        {'format': 'text', 'text': {'header': True, 'delimiter': delimiter},
         'time': {'column': header.index('t') + 1}, 'signals': signals}, str(path))
    columns, place = read_columns(path, mapping)
    values = {name: columns.get(signal) for name, signal in COLUMNS.items()}
    ignored = [name or '(no name)' for name in header if name not in COLUMNS]
    notices = (f'ignored columns: {", ".join(ignored)}',) if ignored else ()

    def where(row, name):
        line = place(row, COLUMNS[name]).split(',')[0]
        return f'{line}, column {name}'
    return CsvColumns(**values, place=where, notices=notices)


def _header(path):
    """Return (names of the header row, delimiter)."""
    try:
        with Path(path).open('rb') as raw:
            packed = raw.read(2) == b'\x1f\x8b'
        opener = gzip.open if packed else open
        with io.TextIOWrapper(opener(path, 'rb'), encoding='utf-8') as stream:
            for line in stream:
                line = line.removeprefix('\ufeff').rstrip('\n')
                if line.strip() and not line.lstrip().startswith('#'):
                    break
            else:
                raise InputError(f'{path}: empty, expected a header row '
                                 't,u,motor,arm[,arm_torque]')
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise InputError(f'{path}: {error}, expected a whole gzip file') from None
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}, expected a readable file') from None
    except UnicodeDecodeError:
        raise InputError(f'{path}: not text, expected a CSV file with a header row '
                         't,u,motor,arm[,arm_torque]') from None
    delimiter = max(DELIMITERS, key=line.count)
    return [name.strip().strip('"') for name in line.split(delimiter)], delimiter
