# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The drives and the motion of config/arm6.urdf, for the demo and the tests."""
from dataclasses import replace

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.robot.arm_plant import ArmPlant, ArmRun, pick_and_place
from gearbox_monitor.robot.description import RobotDescription
from gearbox_monitor.robot.dynamics import (
    arrays_of, GRAVITY, move, Payload, RobotArrays, torque_on)

LOW = np.array([-2.0, -1.2, -0.3, -2.0, -1.5, -3.0])  # rad
HIGH = np.array([2.0, 0.9, 2.2, 2.0, 1.5, 3.0])
SPEED = np.array([2.0, 1.8, 2.2, 3.0, 3.0, 4.0])      # rad/s
MIDDLE = 0.5 * (LOW + HIGH)
# Motor inertia kg m^2, stiffness N m/rad, half gap rad, Coulomb N m, viscous N m s/rad.
DRIVES = ((4.0, 4e4, 2e-4, 9.0, 8.0), (4.0, 4e4, 2e-4, 12.0, 8.0), (1.6, 2e4, 2.5e-4, 6.0, 5.0),
          (0.3, 6e3, 4e-4, 2.0, 1.2), (0.3, 6e3, 4e-4, 2.0, 1.2), (0.15, 3e3, 5e-4, 1.2, 0.6))
RATED = np.array([100.0, 100.0, 50.0, 6.0, 6.0, 3.0])  # N m, scale of the noise of torques
ENCODER = 2e-5                                         # rad, standard deviation
PAYLOAD = Payload(position=(0.0, 0.0, 0.05), link='tool')
PAYLOADS = (1.0, 5.0)                                  # kg


def nominal_drives(robot: RobotDescription) -> list[DriveModel]:
    """Return the model of each drive, with the inertia that `robot` has in the middle."""
    arrays = arrays_of(robot)
    move(arrays, np.vstack([MIDDLE, np.zeros((2, len(MIDDLE)))]))
    return [DriveModel(
        motor_inertia=inertia, arm_inertia=torque_on(arrays, joint)[2], damping=1e-3 * stiffness,
        viscous_friction=viscous, coulomb_friction=coulomb, position_gain=0.0,
        transmission=Transmission(stiffness=stiffness, half_gap=half_gap))
        for joint, (inertia, stiffness, half_gap, coulomb, viscous) in enumerate(DRIVES)]


def parameters_of(joint: int) -> dict[str, object]:
    """Return the parameters of the estimator of `joint`, by the size of its torques."""
    rated = float(RATED[joint])
    return {
        'motor_joint': f'motor{joint + 1}', 'arm_joint': f'joint{joint + 1}',
        'arm_load': 'model', 'payload_link': PAYLOAD.link,
        'payload_position': list(PAYLOAD.position), 'r_std_motor': ENCODER, 'r_std_arm': ENCODER,
        'q_std_motor_speed': 0.01, 'q_std_arm_speed': 0.01, 'tau_k_model': 'elastic',
        'q_std_tau_k_deviation': 0.005 * rated, 'q_std_tau_k': 0.1 * rated,
        'q_std_tau_arm': 0.1 * rated, 'p0_std_torque': rated,
        'p0_std_tau_k_deviation': 0.005 * rated, 'p0_std_speed': 1.0,
        'friction_error_std': 0.4 * DRIVES[joint][3]}


def as_built(robot: RobotDescription, rng: np.random.Generator, spread: float) -> RobotArrays:
    """Return a `robot` with masses and inertias that `rng` draws, off by `spread` at most."""
    mass, inertia = (1.0 + spread * rng.uniform(-1.0, 1.0, (2, len(robot.mass))))
    return arrays_of(replace(robot, mass=robot.mass * mass,
                             inertia=robot.inertia * inertia[:, None, None]),
                     PAYLOAD, 0.0, GRAVITY)


def drives_as_built(drives: list[DriveModel], rng: np.random.Generator) -> list[DriveModel]:
    """Return `drives` with frictions and inertias that `rng` draws within their tolerances."""
    def off(tolerance: float) -> float:
        return 1.0 + tolerance * float(rng.uniform(-1.0, 1.0))
    return [replace(d, coulomb_friction=d.coulomb_friction * off(d.friction_tolerance),
                    viscous_friction=d.viscous_friction * off(d.damping_tolerance),
                    motor_inertia=d.motor_inertia * off(d.inertia_tolerance)) for d in drives]


def worked(plant: ArmPlant, rng: np.random.Generator, moves: int, dt: float
           ) -> tuple[ArmRun, Array, Array, Array]:
    """
    Let a plant pick and place.

    Args:
        plant: of the arm.
        rng: source of poses, payloads and noise of the encoders.
        moves: how many.
        dt: length of a sample, s.

    Returns:
        The ArmRun, its payload [N] (kg), and the measured positions of motors and arms [N, n].

    """
    references, payload = pick_and_place(
        rng, (LOW, HIGH, SPEED), plant.target, moves, dt, PAYLOADS)
    run = plant.run(references, payload, dt)
    motor, arm = (true + ENCODER * rng.normal(size=true.shape) for true in (run.motor, run.arm))
    return run, payload, motor, arm
