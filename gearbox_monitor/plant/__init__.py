# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The physics of a drive: equations of motion, library of effects, simulator.

In go a model file's values, a torque and a start; out come motion, readings and slopes. An effect
is one object that carries its equation, its words and its column.

Public names, by module:

    .: batch
    batch: Begin, Driving, IN_GEARBOX, LANES, N_LANE_STATE, ON_ARM, ON_MOTOR, RunResult,
        RunSpans, step_lanes, steps_by_term, steps_with_plugin, T, U
    drive: ALPHA, arm_acceleration, ARM_ALPHA, arm_constraint, arm_load, arm_load_slopes, CAC,
        CAV, CC, CL, Controller, CV, D, DriveModel, expect_integrable, expect_model,
        expect_torque_input, fastest_eigenvalue, G, HALF_GAP, INVERSE_M1, INVERSE_M2, K_S,
        KEYS, KIND, KR, LAW, loads_arm, model_from_dict, motor_acceleration,
        motor_acceleration_by_law, motor_friction_load_slope, motor_friction_slope,
        motor_friction_slope_by_law, N_PARAMETERS, OFFSET, PHI, RANGES, steps_of, STIFFNESS,
        substeps, TL, TOLERANCES, Transmission, weight_of, WIDTH
    effects: actuator, arm_side, controller, Effect, EFFECTS, encoder, gearbox, library,
        LOCATIONS, MAX_DELAY, MAX_SETPOINT_DELAY, MEMORIES, motor_side, not_in_filters,
        Parameter, Scales, torque_map
    effects.actuator: ACTUATOR_DELAY, ACTUATOR_LAG, SATURATION, TORQUE_GAIN, TORQUE_OFFSET,
        TORQUE_RIPPLE
    effects.arm_side: ARM_COULOMB, ARM_INERTIA, ARM_VISCOUS, burst, DISTURBANCE, GRAVITY,
        LOAD_TORQUE
    effects.composition: actuator, arm_error, COMMAND_PLACES, DELAY1, DELAY2, lead,
        motor_error, steady_command
    effects.controller: SERVO_DELAY, SERVO_GAIN, SERVO_INTEGRATOR, SERVO_LIMIT, SETPOINT_DELAY
    effects.effect: BalanceColumn, COMMAND, dissipated, JointMotion, moved, not_negative, one,
        SCALE, SETPOINT, TORQUE, Torques, waves
    effects.encoder: ENCODER_OFFSET
    effects.gearbox: BACKLASH_GAP, SLIP, slipped
    effects.motor_side: COGGING, COULOMB_ASYMMETRY, LOAD_FRICTION, LUGRE, MOTOR_COULOMB,
        MOTOR_INERTIA, MOTOR_VISCOUS, STRIBECK
    effects.registry: INTEGRAL, LATE_A, LATE_B, LATE_C
    effects.torque_map: QUANTITIES, TORQUE_MAP
    faults: EncoderFault, Excitation, Faults, FaultyPlant, JOINTS, KINDS
    simulate: equivalent_torque, gains, imbalance, imbalance_with, N_STATE, Noise,
        packed_drive, PackedDrive, Plant, plugin_of, read_all, rebuilt, Schedule, simulate,
        Trajectory, true_motion
    transmission: ATAN, dead_zone, dead_zone_torque, elastic_torque, FrictionLaw, IMPEDANCES,
        play, RIGID, side, TWO_OVER_PI
"""
