# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a filter computes with: its drive, the load on the arm, settings and arrays of its loop."""
import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.consider import companions_of
from gearbox_monitor.estimation.filter_kind import Belief, FilterKind, record_size, Scratch
from gearbox_monitor.estimation.filters.ukf import N_LANES
from gearbox_monitor.estimation.sample_loop import LoopSettings, LoopState, SECOND
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel, expect_integrable, loads_arm
from gearbox_monitor.plant.effects import not_in_filters
from gearbox_monitor.robot.description import RobotDescription
from gearbox_monitor.robot.dynamics import ArmLoad, arrays_of, MotionState, Payload

COMPENSATED = 'gravity_compensated'  # of effort_is
DESCRIBED_FILTERS = ('ekf', 'ukf')  # that take a load by a robot's description


def settings_of(drive: DriveModel, parameters: EstimatorParameters) -> LoopSettings:
    """Return the LoopSettings of a filter of `drive` with `parameters`."""
    return LoopSettings(
        sample_loop.CHOICES[parameters.filter], round(parameters.max_gap * SECOND),
        parameters.effort_delay, round(parameters.smoother_lag * SECOND),
        drive.arm_load == 'measured', parameters.narrow_std)


def loop_arrays(kind: FilterKind, n: int, rows: int,
                drive: DriveModel) -> tuple[Belief, Scratch, LoopState]:
    """
    Return the arrays that sample_loop.run carries from sample to sample.

    Args:
        kind: the filter.
        n: number of states.
        rows: of the ring of step records.
        drive: that the filter computes with; it states the tolerances.

    """
    memory, companions = np.zeros(kind.memory_size(n)), companions_of(drive, n)
    belief = Belief(np.zeros(n), np.eye(n).ravel(), memory)
    n_matrices = 1 + N_LANES if drive.friction_law.constraint else 5  # 5: of the smoother
    scratch = Scratch(np.zeros((kind.n_vectors, n)),
                      np.zeros((max(kind.n_matrices, n_matrices), n * n)))
    state = LoopState(
        np.zeros(sample_loop.N_GATE, np.int64), np.zeros(sample_loop.N_COUNTS, np.int64),
        np.zeros(sample_loop.N_CLOCK), np.zeros((sample_loop.N_EFFORTS, 2)),
        np.zeros((rows, record_size(n, companions.number))), np.zeros(rows, np.int64),
        np.zeros(n + n * n + len(memory)), companions)
    return belief, scratch, state


def arm_load_of(robot: RobotDescription | None, parameters: EstimatorParameters,
                motion: MotionState | None = None) -> ArmLoad | None:
    """
    Return what gives the load on the arm by the description of a robot; None if it is not used.

    Args:
        robot: its description.
        parameters: of the filter.
        motion: of the robot so far.

    Raises:
        InputError: the description has no such joint, or the filter knows no such load.

    """
    p = parameters
    if robot is None or not described(p):
        return None
    if p.arm_joint not in robot.joints:
        raise InputError(f'robot_description: no joint {p.arm_joint!r} (arm_joint), expected '
                         + unknown(p.arm_joint, robot.joints))
    if p.filter not in DESCRIBED_FILTERS:
        raise InputError(f'filter: {p.filter}, expected one of {", ".join(DESCRIBED_FILTERS)} '
                         'with robot_description: others keep what they know of the load')
    for name in ('robot_gravity', 'payload_position'):
        if len(getattr(p, name)) != 3:
            raise InputError(f'{name}: {list(getattr(p, name))}, expected three numbers')
    arrays = arrays_of(robot, Payload(p.payload_mass, p.payload_tolerance, p.payload_position,
                                      p.payload_link), p.robot_tolerance, p.robot_gravity)
    return ArmLoad(arrays, robot.joints.index(p.arm_joint), p.robot_acceleration_time, motion,
                   p.effort_is == COMPENSATED)


def expect_effort(model: DriveModel, parameters: EstimatorParameters) -> None:
    """Raise InputError where `model` or `parameters` cannot convert what effort_is states."""
    kind, constant = parameters.effort_is, model.torque_constant
    if kind == 'current' and constant == 1.0:
        raise InputError('effort_is: current, but torque_constant of the model file is 1, '
                         'expected another number of N m/A')
    if kind in ('torque', COMPENSATED) and constant != 1.0:
        raise InputError(f'effort_is: {kind}, but torque_constant of the model file is '
                         f'{constant:g}, expected 1')
    if kind == COMPENSATED and not described(parameters):
        raise InputError(f'effort_is: {kind}, expected arm_load model and a robot_description, '
                         'which give the weight')


def described(parameters: EstimatorParameters) -> bool:
    """Return whether by `parameters` a robot's description gives the load on the arm."""
    return bool(parameters.robot_description and parameters.arm_joint
                and parameters.arm_load == 'model')


def drive_of(model: DriveModel, parameters: EstimatorParameters) -> DriveModel:
    """
    Return the drive that a filter with `parameters` computes with, made from `model`.

    Of a load by a robot's description the filter estimates the error, an unknown load.

    Raises InputError for one that no filter can compute with, or not in time.
    """
    if model.transmission.kind == 'rigid':
        raise InputError('transmission.kind: rigid: a filter has no twist to see the '
                         'transmission torque by, expected another kind')
    if parameters.arm_joint:
        load = parameters.arm_load
        if load == 'model':
            load = 'unknown' if described(parameters) else model.arm_load
        drive = model.with_(arm_load=load)
    elif parameters.tau_k_stiffness > 0.0:
        raise InputError(f'tau_k_stiffness: {parameters.tau_k_stiffness:g}, expected 0 where '
                         'no arm is measured (arm_joint is empty)')
    else:
        drive = model.without_arm()
    dt = parameters.max_gap
    expect_integrable(drive, dt, f'max_gap: {dt:g}, model')
    stiffness = parameters.tau_k_stiffness
    if stiffness > drive.transmission.stiffness:
        expect_integrable(drive.with_(stiffness=stiffness), dt,
                          f'max_gap: {dt:g}, tau_k_stiffness in place of stiffness')
    return drive


def model_warnings(drive: DriveModel) -> list[str]:
    """Return warnings about effects of the `drive` that the filter ignores or counts twice."""
    result = []
    ignored = not_in_filters(drive.effects)
    if ignored:
        result.append('effects of the model that no filter knows are left out: '
                      + ', '.join(ignored))
    loads = [e['id'] for e in drive.effects if loads_arm(e['id'])]
    if loads and drive.arm_load == 'measured':
        result.append('effects of the model act besides the measured load on the arm: '
                      f'{", ".join(loads)}; leave out what it contains')
    return result
