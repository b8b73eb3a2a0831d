# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Run a functional mock-up unit (FMI 2 or 3, co-simulation) as the user's simulator.

The standard leaves names of variables to the unit; a YAML file says which of them are ours.
"""
import atexit
from collections.abc import Mapping
from pathlib import Path
import shutil
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError, installed_by, unknown
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.kernels.types import Array

INPUTS = ('motor_torque', 'arm_torque')
OUTPUTS = ('motor_position', 'arm_position')
STARTS = ('motor_start', 'arm_start', 'motor_speed_start', 'arm_speed_start')
REAL = ('Real', 'Float64')


class Fmu:
    """An opened unit: `run` is the function of a UserSimulator, `takes` its parameters."""

    def __init__(self, instance: Any, references: Mapping[str, int],
                 takes: tuple[str, ...]) -> None:
        """
        Keep an instance and what its variables are.

        Args:
            instance: fmpy's FMU2Slave or FMU3Slave, instantiated.
            references: value reference of each of our names.
            takes: parameters among them.
        """
        self.takes, self._instance, self._references = takes, instance, references
        self._fmi3 = hasattr(instance, 'setFloat64')
        self._begun = False

    def run(self, torque: Array, start: Array, dt: float, **values: float) -> Array:
        """
        Return the positions of motor and arm [N, 2], rad, before each step.

        Args:
            torque: on motor and arm [N, 2], held over a step, N m.
            start: positions and speeds of motor and arm [4], rad and rad/s.
            dt: length of a step, s.
            values: of the parameters.
        """
        unit = self._instance
        write, read = ((unit.setFloat64, unit.getFloat64) if self._fmi3
                       else (unit.setReal, unit.getReal))
        if self._begun:
            unit.reset()
        self._begun = True
        if not self._fmi3:
            unit.setupExperiment(startTime=0.0)
        write(self._places((*STARTS, *values)), [*map(float, start), *values.values()])
        unit.enterInitializationMode()
        inputs, outputs = self._places(INPUTS), self._places(OUTPUTS)
        write(inputs, torque[0].tolist())
        unit.exitInitializationMode()
        positions = np.empty(torque.shape)
        for k, row in enumerate(torque.tolist()):
            positions[k] = read(outputs)
            write(inputs, row)
            unit.doStep(k * dt, dt)
        unit.terminate()
        return positions

    def _places(self, names: tuple[str, ...]) -> list[int]:
        return [self._references[name] for name in names]


def open_fmu(path: Path, names_file: str, parameters: tuple[str, ...]) -> Fmu:
    """
    Return the unit in a file, unpacked and instantiated.

    Args:
        path: of the .fmu file.
        names_file: YAML file {our name: name of the variable}; '': all have our names.
        parameters: names of the values that a simulator can take.

    Returns:
        The unit; its temporary folder is removed when the process ends.

    Raises:
        InputError: fmpy is missing, the file is none of co-simulation, a variable is missing.
    """
    try:
        import fmpy  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise InputError(f'fmpy: not installed, expected {installed_by("fmu")} '
                         f'for --simulator {path}') from None
    where = f'--simulator {path}'
    if not path.is_file():
        raise InputError(f'{where}: no such file')
    try:
        description = fmpy.read_model_description(str(path))
    except Exception as error:  # of a file of any kind
        reason = (str(error).splitlines() or [''])[0]
        raise InputError(f'{where}: {reason or type(error).__name__}, expected a functional '
                         'mock-up unit') from error
    if description.coSimulation is None or description.fmiVersion.startswith('1'):
        raise InputError(f'{where}: FMI {description.fmiVersion} without co-simulation, expected '
                         'FMI 2 or 3 for co-simulation')
    ours = (*INPUTS, *OUTPUTS, *STARTS, *parameters)
    chosen = _chosen(names_file, ours) if names_file else {}
    variables = {v.name: v for v in description.modelVariables if v.type in REAL}
    references = {}
    for name in ours:
        theirs = chosen.get(name, name)
        if theirs in variables:
            references[name] = variables[theirs].valueReference
        elif name not in parameters or name in chosen:
            raise InputError(f'{where}: {name}: no variable {theirs!r} of real numbers, expected '
                             'it in the unit, or its name in NAMES of --simulator FILE.fmu:NAMES')
    folder = fmpy.extract(str(path))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    instance = _instantiated(fmpy, folder, description, where)
    return Fmu(instance, references, tuple(p for p in parameters if p in references))


def _instantiated(fmpy: Any, folder: str, description: Any, where: str) -> Any:
    try:
        return fmpy.instantiate_fmu(folder, description, 'CoSimulation')
    except Exception as error:  # of the unit's own library
        raise InputError(f'{where}: {type(error).__name__}: {error}, expected a unit with a '
                         'library for this machine') from error


def _chosen(file: str, ours: tuple[str, ...]) -> dict[str, str]:
    """Return {our name: theirs} of a file. Raises InputError."""
    content = load_yaml(file).content
    if not isinstance(content, dict):
        raise InputError(f'{file}: {content!r}, expected a mapping {{name: variable}}')
    for name, theirs in content.items():
        if name not in ours:
            raise InputError(f'{file}: {name}: {unknown(name, ours)}')
        if not isinstance(theirs, str):
            raise InputError(f'{file}: {name}: {theirs!r}, expected the name of a variable')
    return content
