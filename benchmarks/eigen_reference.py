# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
An EKF in C++ with Eigen, compiled on the spot: the reference for speed.

eigen_ekf.cpp does what the EKF of this package does, in two kinds. "Eigen EKF" takes the usual
tangent I + hA + h^2 A^2/2; the bar is set against it, because that is what people write and the
cheaper of the two. "Eigen EKF, exact" takes the exact tangent of the RK4 step as this package
does, and gives the same estimates.
"""
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import ctypes
import os
from pathlib import Path
import re
import shutil
import subprocess
import tempfile
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.process_model import (
    EIGENVALUE, K_P, P0, pack, Q0, R1, R2, state_names)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import (
    ALPHA, CAC, CAV, CC, CL, CV, D, DriveModel, G, INVERSE_M1, INVERSE_M2, KR, OFFSET, substeps,
    TL)

SOURCE = Path(__file__).with_name('eigen_ekf.cpp')
VARIABLE = 'EIGEN3_INCLUDE_DIR'
FOLDERS = ('/usr/include/eigen3', '/usr/local/include/eigen3')
FLAGS = ('-O3', '-march=native', '-DNDEBUG', '-std=c++14', '-shared', '-fPIC')
KINDS = {'Eigen EKF': 'eigen_ekf', 'Eigen EKF, exact': 'eigen_ekf_exact'}


def find_eigen(chosen: str | os.PathLike[str] | None = None) -> str | os.PathLike[str]:
    """
    Return the folder that holds Eigen/Core.

    Args:
        chosen: by the user; None: look in the environment, pkg-config and the usual folders.

    Raises:
        InputError: if no folder does.
    """
    chosen = chosen or os.environ.get(VARIABLE)
    for folder in [chosen] if chosen else [*_from_pkg_config(), *FOLDERS]:
        if (Path(folder) / 'Eigen/Core').is_file():
            return folder
    raise InputError(f'{chosen or "Eigen"}: {"no Eigen/Core there" if chosen else "not found"}, '
                     f'expected it from --eigen DIR, {VARIABLE}, pkg-config or the package '
                     'libeigen3-dev')


def _from_pkg_config() -> list[str]:
    try:
        flags = subprocess.run(['pkg-config', '--cflags-only-I', 'eigen3'], text=True,
                               capture_output=True).stdout
    except OSError:
        return []
    return re.findall(r'-I(\S+)', flags)


@contextmanager
def library(eigen: str | os.PathLike[str] | None = None) -> Iterator[ctypes.CDLL]:
    """Give the compiled eigen_ekf.cpp; `eigen`: folder of the headers, see find_eigen."""
    compiler = shutil.which(os.environ.get('CXX', 'c++'))
    if compiler is None:
        raise InputError(f'{os.environ.get("CXX", "c++")}: not found, expected a C++ compiler')
    folder = find_eigen(eigen)
    with tempfile.TemporaryDirectory() as room:
        built = Path(room) / 'eigen_ekf.so'
        done = subprocess.run([compiler, *FLAGS, f'-I{folder}', str(SOURCE), '-o', str(built)],
                              capture_output=True, text=True)
        if done.returncode:
            last = next((line for line in done.stderr.splitlines() if 'error:' in line),
                        f'exit code {done.returncode}')
            raise InputError(f'{compiler}: {last}, expected it to compile {SOURCE.name}')
        shared_library = ctypes.CDLL(str(built))
        array = np.ctypeslib.ndpointer(np.float64, flags='C_CONTIGUOUS')
        for name in KINDS.values():
            function = getattr(shared_library, name)
            function.restype = None
            function.argtypes = [ctypes.c_long, ctypes.c_double, *[array] * 5]
        yield shared_library


def steppers(compiled: ctypes.CDLL, model: DriveModel, parameters: Mapping[str, Any], u: Array,
             y: Array, dt: float) -> dict[str, Callable[[], tuple[Array, Array]]]:
    """
    Return functions that run the reference filters over a recording.

    Args:
        compiled: from library().
        model: drive without a load on the arm.
        parameters: of the estimator; a random walk of tau_K, one RK4 step per sample.
        u: motor torque [N], N m.
        y: encoder readings [N, 2], rad.
        dt: sample time, s.

    Returns:
        Functions by name; each returns states [N, 5] and NIS [N], undefined in the first row.

    Raises:
        InputError: for a model or parameters that the references do not implement.
    """
    checked = EstimatorParameters.of(parameters)
    model = model.with_(arm_load=checked.arm_load)
    p = pack(model, checked)
    if (len(state_names(model, checked)) != 5 or p[K_P] or substeps(dt, p[EIGENVALUE]) != 1
            or p[[CAV, CAC, G, TL, CL]].any()):
        raise InputError('parameters: expected five states, a random walk of tau_K, no load on '
                         'the arm and one RK4 step per sample')
    places = [INVERSE_M1, INVERSE_M2, D, CV, CC, ALPHA, KR, OFFSET, *range(Q0, Q0 + 5), R1, R2,
              *range(P0, P0 + 5)]
    values, u, y = p[places], np.ascontiguousarray(u), np.ascontiguousarray(y)

    def stepper(function: Callable[..., None]) -> Callable[[], tuple[Array, Array]]:
        """Return a call of the compiled `function` that returns states and NIS."""
        def run() -> tuple[Array, Array]:
            states, nis = np.empty((len(u), 5)), np.empty(len(u))
            function(len(u), dt, values, u, y, states, nis)
            return states, nis
        return run
    return {name: stepper(getattr(compiled, kind)) for name, kind in KINDS.items()}
