# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recordings of a real six-axis arm, which are no part of this project."""
import csv
import gzip
from pathlib import Path
import re

import numpy as np

DATA = Path(__file__).parents[1].parent / 'shared/data'
CONSTANTS = np.array([10.0, 10.7, 8.46, 9.0, 9.48, 10.12])  # N m/A, as published
UNLOADED = ('ur-20_01_31-unload', 'ur-20_02_10-30sec_12harm', 'ur-20_02_19_14harm50sec')


def samples(name):
    """Return the columns of a recording of the six-axis arm, without torn lines."""
    with gzip.open(DATA / f'ur10e/{name}.csv.gz', 'rt') as file:
        rows = [row for row in csv.reader(file) if len(row) == 31]
    x = np.array([[float(v) if re.fullmatch(r'[-+.\deE]+', v) else np.nan for v in row]
                  for row in rows])
    return x[np.abs(x[:, 0] - np.median(x[:, 0])) < 200]


def controller_constants():
    """
    Return torque per current as the arm's own controller has it: its two desired values.

    They are 12 to 18 % above the published ones. At the last two wrists the desired torque is
    small: they have the drive of the wrist before.
    """
    x, out = samples(UNLOADED[0]), CONSTANTS.copy()
    x = x[np.isfinite(x).all(axis=1)]
    for j in range(4):
        v = x[:, 7 + j]
        out[j] = np.linalg.lstsq(np.stack([x[:, 19 + j], np.tanh(v / 0.02), v], axis=1),
                                 x[:, 25 + j], rcond=None)[0][0]
    out[4:] *= out[3] / CONSTANTS[3]
    return out
