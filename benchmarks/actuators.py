# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Entries of the catalogue of actuators from public recordings: values, ranges, held-out error.

Each recording of the back end is fitted alone, those of a servo by the gain of its firmware; the
ranges are those of the next recording. The recordings held out were not fitted: their error is
that of the median values. Joints of an arm are fitted with its links, and each group of recordings
is judged by the values of the others. DATA is the folder of the recordings, see docs/actuators.md
for its source.

usage examples:
  python -m benchmarks actuators xl330 path/to/bam_servo_pendulum --out xl330.yaml
  python -m benchmarks actuators davinci_backend path/to/davinci_backend
  python -m benchmarks actuators tx40_joint1 path/to/staubli_TX40
"""
import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks import bam
from benchmarks.harness import progress_line
from gearbox_monitor.cli.options import write_or_print
from gearbox_monitor.diagnosis.joint.nominal import fit_nominal, NominalFit
from gearbox_monitor.diagnosis.joint.parameter_ranges import (
    ParameterRanges, ranges_of, UnitEstimate)
from gearbox_monitor.diagnosis.joint.torque_domain import BalanceLikelihood, driven
from gearbox_monitor.diagnosis.robot.likelihood import Prior, RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_log import checked_log, RawLog, RobotLog, TORQUE
from gearbox_monitor.diagnosis.robot.rows import RobotModel, Rows, rows_of
from gearbox_monitor.diagnosis.robot.verdict import rms_in_motion
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.library.ranges import ranges_data
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.reading import read_signals, ReadOptions
from gearbox_monitor.robot.chain import Chain
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import at_one_rate, UniformRecording
from gearbox_monitor.simulators.robot_model import read_robot

FREE = ('m1', 'Cv', 'Cc', 'u0', 'kt')
LOADED = 'load_friction'  # of a servo: its friction grows with the torque that it transmits
FIELDS = {'m1': 'motor_inertia', 'Cv': 'viscous_friction', 'Cc': 'coulomb_friction',
          'kt': 'torque_constant', 'u0': 'torque_offset'}
LIGHT = 1e-6  # kg m^2: an arm that carries nothing
BACKEND = DriveModel().with_(
    kind='rigid', position_gain=0.0, motor_inertia=6e-4, arm_inertia=LIGHT, viscous_friction=0.005,
    coulomb_friction=0.02, process_torque_time=0.3, arm_load='measured',
    friction_sharpness=1000.0, tolerance=0.5, driven_by='position')
OF_JOINT = {'m1': ('armature', 'kg m^2'), 'Cv': ('viscous', 'N m s/rad'),
            'Cc': ('coulomb', 'N m')}  # nuisance of the robot's balance, and its unit
LINKS, OWN = 0.3, 1.0  # tolerances of the links' inertias, and of the guesses of the joints
PENDULUM = Path(__file__).parents[1] / 'benchmarks/real_logs/double_pendulum/double_pendulum.urdf'
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


def _unit(name: str, fit: NominalFit, factor: float, unit: str,
          carried: float = 0.0) -> UnitEstimate:
    """Return the UnitEstimate of a fit, kt times `factor` in `unit`, m1 less `carried` kg m^2."""
    estimate = UnitEstimate.of(name, fit.values, fit.covariance)
    size = np.array([factor if v.name == 'kt' else 1.0 for v in fit.values])
    values = {v.name: v.value * s - carried * (v.name == 'm1') for v, s in zip(fit.values, size)}
    return UnitEstimate(name, values, {**estimate.units, 'kt': unit},
                        estimate.covariance * np.outer(size, size))


def _of_servo(folder: Path, kind: str) -> Measured:
    """Return the estimates of a servo of BAM's bench by its setpoints, one of each gain."""
    servo, show = bam.SERVOS[kind], progress_line()
    logs = bam.read_logs(folder / kind)
    fitted = [log for log in logs if log.raw['trajectory'] in bam.TRAINED]
    test = [log for log in logs if log.raw['trajectory'] not in bam.TRAINED]
    if not (fitted and test):
        raise InputError(f'{folder / kind}: {len(fitted)} recordings to fit and {len(test)} to '
                         f'judge, expected some of {", ".join(bam.TRAINED)} and some others')
    estimates, left = [], []
    for gain in sorted({log.kp for log in fitted}):
        group = [log for log in fitted if log.kp == gain]
        carried = group[0].raw['mass'] * group[0].raw['length'] ** 2
        model = _swinging(servo, group[0], servo.inertia)
        show(f'{kind}: gain {gain:g}')
        try:
            fit = fit_nominal(at_one_rate([bam.recording_of(log, model) for log in group]), model,
                              (*FREE, LOADED), seconds=bam.WHOLE)
        except (InputError, Undecided) as error:
            left.append(f'gain {gain:g}: {error}')
            continue
        # The gain of the firmware is exact: its torque goes with kt.
        estimates.append(_unit(' and '.join(log.path.name for log in group), fit, servo.torque,
                               'N m at full duty', carried))
    show('')
    if not estimates:
        raise InputError(*left)

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
    raw = read_signals(path, ReadOptions('davinci_backend'))
    readings = np.column_stack([raw['motor_position'], np.full(len(raw.stamp_ns), np.nan)])
    return admitted(raw.stamp_ns, raw['motor_effort'], readings, raw['arm_effort'], path.name,
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
        fit = fit_nominal([_backend_recording(path)], BACKEND, FREE)
        estimates.append(_unit(path.name, fit, factor, 'N m/A'))

    def judged(ranges: ParameterRanges) -> dict[str, Any]:
        """Return the torque that the balance leaves with the median values."""
        value = {name: float(v) for name, v in zip(ranges.names, ranges.centre)}
        errors, sizes = [], []
        for path in test:
            model = replace(BACKEND, motor_inertia=value['m1'],
                            viscous_friction=value['Cv'], coulomb_friction=value['Cc'],
                            torque_offset=value['u0'],
                            effects=({'id': 'torque_gain', 'g': value['kt'] / factor - 1.0},))
            recording = driven(_backend_recording(path), model)
            balance = BalanceLikelihood(recording, model, np.zeros(2), [recording.span])
            errors.append(float(balance.run(model, np.zeros(2)).left[0]))
            sizes.append(float(np.std(recording.u)))
        return {'recordings': [path.name for path in test], 'unit': 'mN m',
                'error': [round(1e3 * e, 1) for e in errors],
                'of': 'rms of the torque that the balance of the drive leaves',
                'motion': [round(1e3 * size, 1) for size in sizes]}
    return Measured(estimates, [], judged)


def _with_guesses(path: Path, armature: Any, viscous: Any, coulomb: Any) -> Chain:
    """Return the chain in a URDF, with guesses of the joints' own values [J] or of all alike."""
    chain = read_robot(path).chain
    return replace(chain, **{name: np.ones(len(chain.links)) * guess for name, guess in (
        ('armature', armature), ('viscous', viscous), ('coulomb', coulomb))})


def _log(chain: Chain, name: str, t: Array, position: Array, torque: Array) -> RobotLog:
    """Return the log of all joints: t [N] s, position [N, J] rad, measured torque [N, J] N m."""
    q, tau = (dict(zip(chain.joints, x.T)) for x in (position, torque))
    return checked_log(RawLog(name, t, q, tau, TORQUE, measured=True), chain.joints)


def _of_tx40(folder: Path, joint: int) -> Measured:
    """Return the estimates of a joint of the arm TX40, by halves of its recording."""
    paths = [folder / 'data' / f'{name}.csv' for name in ('pos_read_data', 'curr_data')]
    for path in paths:
        if not path.is_file():
            raise InputError(f'{path}: no such file, expected a recording of the TX40')
    position, torque = (np.genfromtxt(path, delimiter=',', skip_header=1) for path in paths)
    ratio = np.diag([32.0, 32.0, 45.0, -48.0, 45.0, 32.0])
    ratio[5, 4] = 32.0  # the motor of joint 6 turns with joint 5
    position = position @ np.linalg.inv(ratio).T + np.pi / 2 * np.array([0, -1, 1, 0, 0, 0])
    chain = _with_guesses(
        folder / 'urdf' / 'tx40_mdh_modified.urdf', [0.3, 0.3, 0.1, 0.03, 0.03, 0.01],
        [6.0, 6.0, 2.0, 1.0, 1.0, 0.6], [7.0, 7.0, 7.0, 3.0, 3.0, 3.0])
    t, middle = np.arange(len(position)) * 2e-4, len(position) // 2
    return _of_joint({name: [_log(chain, name, t[part], position[part], (torque @ ratio)[part])]
                      for name, part in (('first half', slice(middle)),
                                         ('second half', slice(middle, None)))}, chain, joint)


def _of_pendulum(folder: Path, joint: int) -> Measured:
    """Return the estimates of a drive of the double pendulum, two of each day of recordings."""
    chain = _with_guesses(PENDULUM, 0.003, 0.01, 0.1)

    def log(path: Path) -> RobotLog:
        """Return the log of both joints in a file."""
        raw = np.genfromtxt(path, delimiter=',', names=True)
        return _log(chain, path.name, raw['time'], *(
            np.column_stack([raw[f'{name}1'], raw[f'{name}2']]) for name in ('pos_meas',
                                                                             'tau_meas')))
    days = {'2022-09-14': sorted(folder.glob('design_C.0/20220914/sys_id/trajectory_*.csv')),
            '2023-06-29': sorted(folder.glob('design_C.1/sys_id/20230629/*/trajectory.csv'))}
    # Of one length, 10 s; the repository has longer ones, which were not read.
    small = {day: [path for path in paths if path.stat().st_size < 2e6]
             for day, paths in days.items()}
    if min(map(len, small.values())) < 2:
        raise InputError(f'{folder}: no recordings of two days, expected data/experiment_records')
    return _of_joint({f'{day}, {name}': [log(path) for path in paths[begin::2]]
                      for day, paths in small.items()
                      for begin, name in enumerate(('odd recordings', 'even recordings'))},
                     chain, joint)


def _of_joint(groups: dict[str, list[RobotLog]], chain: Chain, joint: int) -> Measured:
    """
    Return the estimates of a joint of a robot, one of each group of recordings.

    Args:
        groups: recordings by the name of their group; each is judged by the values of the others.
        chain: of the robot, with guesses of the joints' own values.
        joint: its index.
    """
    robot = RobotModel(chain, np.full(len(chain.links), LINKS), OWN)
    rows = {name: [rows_of(log, robot) for log in logs] for name, logs in groups.items()}
    labels = [f'{label} {chain.joints[joint]}' for label, _ in OF_JOINT.values()]
    guess = np.array([getattr(chain, label)[joint] for label, _ in OF_JOINT.values()])

    def taught(recordings: list[Rows]) -> tuple[Prior, Array, Array]:
        """Return what recordings teach of the robot, and the joint's values and covariance."""
        evidence = RobotLikelihood(recordings)
        prior = evidence.posterior(evidence.fit())
        at = [prior.labels.index(label) for label in labels]
        return prior, guess + prior.mean[at], prior.covariance[np.ix_(at, at)]

    estimates = []
    for name, recordings in rows.items():
        values, covariance = taught(recordings)[1:]
        estimates.append(UnitEstimate(name, dict(zip(OF_JOINT, values.tolist())),
                                      {key: unit for key, (_, unit) in OF_JOINT.items()},
                                      covariance))

    def judged(ranges: ParameterRanges) -> dict[str, Any]:
        """Return the torque that each group leaves with the values of the others."""
        errors, of_links, sizes = [], [], []
        for name, recordings in rows.items():
            prior, values = taught([r for key in rows if key != name for r in rows[key]])[:2]
            evidence = RobotLikelihood(recordings, prior)
            residual = evidence.at[joint].y
            own = sum(evidence.at[joint].z[:, list(evidence.at[joint].index).index(i)]
                      / evidence.deviation[i] * value for i, value in zip(
                          map(evidence.labels.index, labels), values))
            errors.append(rms_in_motion(evidence, joint, residual))
            of_links.append(rms_in_motion(evidence, joint, residual + own))
            sizes.append(float(np.std(np.concatenate(
                [r.joints[joint].effort for r in recordings]))))
        return {'recordings': [f'{name}, with the values of the others' for name in rows],
                'unit': 'N m', 'error': [float(f'{e:.3g}') for e in errors],
                'without': [float(f'{e:.3g}') for e in of_links],
                'of': 'rms of the residual torque in the balance of the robot; without: with '
                'neither inertia nor friction of the joint itself',
                'motion': [float(f'{e:.3g}') for e in sizes]}
    return Measured(estimates, [], judged)


_BAM = ('Apache-2.0', 'Duclusaud, Passault, Padois, Ly, "Extended friction models for the physics '
        'simulation of servo actuators", arXiv 2410.08650')
_TX40 = ('github.com/thanhndv212/figaroh-examples, examples/staubli_TX40', 'Apache-2.0',
         'Nguyen et al., "FIGAROH: a Python toolbox for dynamic identification and geometric '
         'calibration of robots and humans", Humanoids 2023', 'unknown')
SOURCES = {
    'xl330': PublicSource(
        'servo XL330, effort: duty of the motor, -1 to 1',
        'github.com/Rhoban/bam, commit af22604, bam/data.bak/raw', *_BAM, '2026-01-15',
        partial(_of_servo, kind='xl330')),
    'sts3250': PublicSource(
        'servo STS3250, effort: duty of the motor, -1 to 1',
        'github.com/Rhoban/bam, commit b53408c, data_raw_feetech', *_BAM, '2024-10-26',
        partial(_of_servo, kind='sts3250')),
    'davinci_backend': PublicSource(
        'motor with a 35:1 gearbox of a surgical tool, effort: current in A; everything at the '
        "gearbox's output", 'github.com/MRDLab/mis-tool-characterization', 'ODbL 1.0',
        "O'Neill, Stephens, Kowalewski, IEEE RA-L 3(4), 2018, doi 10.1109/LRA.2018.2849862",
        '2018', _of_backend),
    'ak80_6': PublicSource(
        'quasi-direct drive AK80-6 in the elbow of a double pendulum, effort: torque in N m',
        'github.com/dfki-ric-underactuated-lab/double_pendulum, data/experiment_records', 'BSD-3',
        'Wiebe et al., "Open source dual-purpose acrobot and pendubot platform", IEEE RAM 31(2), '
        '2024', '2022 and 2023', partial(_of_pendulum, joint=1)),
    **{f'tx40_joint{joint + 1}': PublicSource(
        f'gearmotor of joint {joint + 1} of the arm Staubli TX40, effort: torque in N m', *_TX40,
        partial(_of_tx40, joint=joint)) for joint in range(4)}}


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
