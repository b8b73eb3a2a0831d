# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Read a recording from CSV: t, u or setpoint, motor, arm and, where measured, arm_torque."""
from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import lines_of
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.importer.containers import readable
from gearbox_monitor.recordings.importer.mapping import (
    ImportMapping, SignalMapping, TextFormat, TimeMapping)
from gearbox_monitor.recordings.importer.raw_columns import RawColumns
from gearbox_monitor.recordings.importer.text_file import read_text

COLUMNS = ('t', 'u', 'setpoint', 'motor', 'arm', 'arm_torque')
ENCODERS = ('motor', 'arm')
TEXTS = ('.csv', '.tsv', '.txt', '.csv.gz', '.tsv.gz', '.txt.gz')  # endings of tables
DELIMITERS = (',', ';', '\t')


@dataclass(frozen=True)
class CsvColumns:
    """
    Columns of a CSV file, float64 [N], NaN where not measured.

    t s; u N m; setpoint, motor, arm rad; arm_torque N m or None. notices: sentences for the user.
    place(row, column): line and column of a value, for messages.
    """

    t: Array
    u: Array
    setpoint: Array
    motor: Array
    arm: Array
    arm_torque: Array | None
    place: Callable[[int, str], str]
    notices: tuple[str, ...] = ()


def read_csv(path: str | Path) -> CsvColumns:
    """
    Return the CsvColumns of the file `path`, gzipped or not, with a header row.

    Commas, semicolons or tabs separate values; '#' begins a comment line. An empty value or 'nan'
    is not measured. Further columns are ignored with a notice. Raises InputError that names file,
    line, column, value and the expected value.
    """
    header, delimiter = header_of(path, 't,u,motor,arm[,arm_torque]', COLUMNS)
    missing = [name for name in ('t', 'u') if name not in header]
    if 'setpoint' in header and 'u' in missing:
        missing.remove('u')
    if not set(ENCODERS) & set(header):
        missing.append('motor or arm')
    if missing:
        raise InputError(f'{path}: header row: no column {", ".join(missing)} in '
                         f'{", ".join(header)[:80]!r}, expected t,u,motor,arm[,arm_torque]')
    raw = text_columns(path, header, delimiter, [name for name in COLUMNS if name in header],
                       ('t',))
    columns = raw.values
    ignored = [name or '(no name)' for name in header if name not in COLUMNS]
    notices = (f'ignored columns: {", ".join(ignored)}',) if ignored else ()

    def place_by_name(row: int, name: str) -> str:
        line = raw.place(row, name).split(',')[0]
        return f'{line}, column {name}'
    none = np.full(len(columns['t']), np.nan)
    t, u, setpoint, motor, arm = (columns.get(name, none) for name in COLUMNS[:-1])
    return CsvColumns(t, u, setpoint, motor, arm, columns.get('arm_torque'), place_by_name,
                      notices)


def header_of(path: str | Path, expected: str, once: Container[str] = ()
              ) -> tuple[list[str], str]:
    """
    Return (names of the header row, delimiter) of a text.

    Args:
        path: of the file, gzipped or not.
        expected: its header row, for messages.
        once: names that may not stand twice; none: all of them.

    Raises:
        InputError: it cannot be read, is empty, or has a name twice.
    """
    with readable(path):
        try:
            for line in lines_of(path, 'utf-8'):
                line = line.removeprefix('\ufeff').rstrip('\n')
                if line.strip() and not line.lstrip().startswith('#'):
                    break
            else:
                raise InputError(f'{path}: empty, expected a header row {expected}')
        except UnicodeDecodeError:
            raise InputError(f'{path}: not text, expected a CSV file with a header row '
                             f'{expected}') from None
    delimiter = max(DELIMITERS, key=line.count)
    names = [name.strip().strip('"') for name in line.split(delimiter)]
    for name in names:
        if names.count(name) > 1 and name in (once or names):
            raise InputError(f'{path}: header row: column {name!r} stands {names.count(name)} '
                             'times, expected once')
    return names, delimiter


def text_columns(path: str | Path, header: Sequence[str], delimiter: str, names: Iterable[str],
                 whole: Container[str] = ()) -> RawColumns:
    """
    Return the RawColumns of a text with a header row; an empty value is NaN.

    Args:
        path: of the file, gzipped or not.
        header: names of all columns.
        delimiter: between them.
        names: of those that are read.
        whole: those of them in which a value may not be empty.
    """
    mapping = ImportMapping(str(path), '', 'text', TimeMapping(), {}, text=TextFormat(
        delimiter=delimiter, header=True, rows='samples'))
    with readable(path):
        return read_text(path, mapping, {
            name: SignalMapping(column=header.index(name) + 1,
                                missing='error' if name in whole else 'nan') for name in names})
