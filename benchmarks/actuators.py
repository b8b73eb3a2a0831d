# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Entries of the catalogue of actuators from public recordings: values, ranges, held-out error.

Each recording is fitted alone; the ranges are those of the next recording. The recordings held
out were not fitted: their error is that of the median values. DATA is the folder of the
recordings, see docs/actuators.md for its source.

usage examples:
  python -m benchmarks actuators xl330 path/to/bam_servo_pendulum --out xl330.yaml
  python -m benchmarks actuators davinci_backend path/to/davinci_backend
"""
import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks import bam
from benchmarks.harness import progress_line
from gearbox_monitor.bag.importer import load_mapping, read_recording
from gearbox_monitor.cli.options import write_or_print
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.export.randomisation import ranges_data
from gearbox_monitor.identification.nominal import (
    balanced, BalancedValues, fit_nominal, NominalFit)
from gearbox_monitor.identification.parameter_ranges import (
    ParameterRanges, ranges_of, UnitEstimate)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.admission import admitted
from gearbox_monitor.quality.recording import UniformRecording

FREE = ('m1', 'Cv', 'Cc', 'u0', 'kt')
LOADED = 'load_friction'  # of a servo: its friction grows with the torque that it transmits
FIELDS = {'m1': 'motor_inertia', 'Cv': 'viscous_friction', 'Cc': 'coulomb_friction',
          'kt': 'torque_constant', 'u0': 'torque_offset'}
LIGHT = 1e-6  # kg m^2: an arm that carries nothing
BACKEND = DriveModel().with_(
    kind='rigid', position_gain=0.0, motor_inertia=6e-4, arm_inertia=LIGHT, viscous_friction=0.005,
    coulomb_friction=0.02, process_torque_time=0.3, arm_load='measured',
    friction_sharpness=1000.0, tolerance=0.5)
HELD_OUT = ('03', '12', '21', '30', '43')  # of the back end


@dataclass(frozen=True)
class Measured:
    """Estimates of the recordings that were fitted, and the error of those held out."""

    estimates: list[UnitEstimate]
    left_out: list[str]
    judged: Callable[[ParameterRanges], dict[str, Any]]


@dataclass(frozen=True)
class PublicSource:
    """Where recordings of an actuator come from, and what makes estimates of them."""

    description: str
    source: str
    licence: str
    citation: str
    recorded: str
    measure: Callable[[Path], Measured]


def _unit(name: str, fit: BalancedValues | NominalFit, factor: float, unit: str,
          carried: float = 0.0) -> UnitEstimate:
    """Return the UnitEstimate of a fit, kt times `factor` in `unit`, m1 less `carried` kg m^2."""
    estimate = UnitEstimate.of(name, fit.values, fit.covariance)
    size = np.array([factor if v.name == 'kt' else 1.0 for v in fit.values])
    values = {v.name: v.value * s - carried * (v.name == 'm1') for v, s in zip(fit.values, size)}
    return UnitEstimate(name, values, {**estimate.units, 'kt': unit},
                        estimate.covariance * np.outer(size, size))


def _of_servo(folder: Path, kind: str) -> Measured:
    """Return the estimates of a servo of BAM's bench, by its setpoints."""
    servo, show = bam.SERVOS[kind], progress_line()
    logs = bam.read_logs(folder / kind)
    if len(logs) < 2:
        raise InputError(f'{folder / kind}: {len(logs)} recordings, expected those of BAM')
    test = [log for log in logs if log.raw['trajectory'] not in bam.TRAINED]
    estimates, left = [], []
    for log in (log for log in logs if log not in test):
        carried = log.raw['mass'] * log.raw['length'] ** 2
        model = _swinging(servo, log, servo.inertia)
        show(f'{kind}: {log.path.name}')
        try:
            fit = fit_nominal([bam.recording_of(log, model)], model, (*FREE, LOADED),
                              seconds=bam.WHOLE)
        except (InputError, Undecided) as error:
            left.append(f'{log.path.name}: {error}')
            continue
        # The gain of the firmware is exact: its torque goes with kt.
        estimates.append(_unit(log.path.name, fit, servo.torque, 'N m at full duty', carried))
    show('')

    def judged(ranges: ParameterRanges) -> dict[str, Any]:
        """Return the mean absolute error of runs from the setpoints alone."""
        value = dict(zip(ranges.names, ranges.centre))
        errors = []
        for log in test:
            model = _swinging(servo, log, value['m1'], float(value[f'{LOADED}.Cl']))
            model = replace(model, viscous_friction=float(value['Cv']),
                            coulomb_friction=float(value['Cc']),
                            torque_offset=float(value['u0']),
                            effects=(*model.effects, {
                                'id': 'torque_gain', 'g': float(value['kt']) / servo.torque - 1}))
            errors.append(bam.run_error(log, model, servo))
        return {'recordings': [log.path.name for log in test], 'unit': 'mrad',
                'error': [round(1e3 * e, 1) for e in errors],
                'of': 'mean absolute error of position, one run from the setpoints alone',
                'motion': [round(1e3 * float(np.std(log.position)), 1) for log in test]}
    return Measured(estimates, left, judged)


def _swinging(servo: bam.BenchServo, log: bam.ServoLog, inertia: float,
              load: float = 0.1) -> DriveModel:
    """Return the model of a servo with the weight of `log`, all inertia on its motor."""
    model = bam.stated_model(servo, log)
    return replace(model, motor_inertia=float(inertia) + model.arm_inertia, arm_inertia=LIGHT,
                   effects=(*model.effects, {'id': LOADED, 'Cl': load}))


def _backend_recording(path: Path) -> UniformRecording:
    """Return a recording of the back end: its motor, current and torque sensor."""
    raw = read_recording(path, load_mapping('davinci_backend'))
    readings = np.column_stack([raw.motor_position, np.full(len(raw.stamp_ns), np.nan)])
    return admitted(raw.stamp_ns, raw.motor_effort, readings, raw.arm_effort, path.name, None,
                    BACKEND, 'the model')[0]


def _of_backend(folder: Path) -> Measured:
    """Return the estimates of the davinci back end, by its current and its torque sensor."""
    paths = sorted(folder.glob('[0-4][0-3].TXT.gz'))
    if len(paths) < 20:
        raise InputError(f'{folder}: {len(paths)} recordings XY.TXT.gz, expected 20')
    factor = 0.9302  # N m/A, by which the mapping multiplies
    test = [path for path in paths if path.name[:2] in HELD_OUT]
    estimates = []
    for path in (path for path in paths if path not in test):
        fit = balanced([_backend_recording(path)], BACKEND, FREE)
        estimates.append(_unit(path.name, fit, factor, 'N m/A'))

    def judged(ranges: ParameterRanges) -> dict[str, Any]:
        """Return the torque that the balance leaves with the median values."""
        value = {name: float(v) for name, v in zip(ranges.names, ranges.centre)}
        errors, sizes = [], []
        for path in test:
            model = replace(BACKEND, motor_inertia=value['m1'], viscous_friction=value['Cv'],
                            coulomb_friction=value['Cc'], torque_offset=value['u0'],
                            effects=({'id': 'torque_gain', 'g': value['kt'] / factor - 1.0},))
            recording = _backend_recording(path)
            errors.append(balanced([recording], model, ['Cv']).before)
            sizes.append(float(np.std(recording.u)))
        return {'recordings': [path.name for path in test], 'unit': 'mN m',
                'error': [round(1e3 * e, 1) for e in errors],
                'of': 'rms of the torque that the balance of the drive leaves, after its mean '
                'over 0.5 s is taken out of chance',
                'motion': [round(1e3 * size, 1) for size in sizes]}
    return Measured(estimates, [], judged)


_BAM = ('github.com/Rhoban/bam', 'Apache-2.0', 'Duclusaud, Passault, Padois, Ly, "Extended '
        'friction models for the physics simulation of servo actuators", arXiv 2410.08650')
SOURCES = {
    'xl330': PublicSource('servo XL330, effort: duty of the motor, -1 to 1', *_BAM, '2026-01-15',
                          lambda folder: _of_servo(folder, 'xl330')),
    'davinci_backend': PublicSource(
        'motor with a 35:1 gearbox of a surgical tool, effort: current in A; everything at the '
        "gearbox's output", 'github.com/MRDLab/mis-tool-characterization', 'ODbL 1.0',
        "O'Neill, Stephens, Kowalewski, IEEE RA-L 3(4), 2018, doi 10.1109/LRA.2018.2849862",
        '2018', _of_backend)}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('name', choices=SOURCES, help='actuator')
    parser.add_argument('data', metavar='DATA', help='folder of its recordings')
    parser.add_argument('--out', metavar='FILE', help='write the entry to a new file')


def entry(name: str, folder: Path) -> dict[str, Any]:
    """Return the entry of the actuator `name` from the recordings in `folder`, as plain data."""
    source = SOURCES[name]
    measured = source.measure(folder)
    ranges = ranges_of(measured.estimates, measured.left_out)
    value = {n: float(f'{v:.4g}') for n, v in zip(ranges.names, ranges.centre)}
    model = {FIELDS[n]: v for n, v in value.items() if n in FIELDS} | {
        'arm_inertia': LIGHT, 'position_gain': 0.0, 'transmission': {'kind': 'rigid'},
        'process_torque_time': 0.3}
    if f'{LOADED}.Cl' in value:
        model['effects'] = [{'id': LOADED, 'Cl': value[f'{LOADED}.Cl']}]
    return {'name': name, 'description': source.description, 'source': source.source,
            'licence': source.licence, 'citation': source.citation, 'recorded': source.recorded,
            'command': f'python -m benchmarks actuators {name} {folder.name}',
            'model': model, 'ranges': ranges_data(ranges),
            'held_out': measured.judged(ranges)}


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns the exit code."""
    write_or_print(args.out, yaml.safe_dump(entry(args.name, Path(args.data)), sort_keys=False,
                                            width=99))
    return 0
