# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A whole robot: its description, dynamics, loads on its joints, and a simulated arm.

In go a compiled model or a URDF text, positions and speeds; out come a chain of links and the
torque that each joint needs. What a description states and this room cannot represent is refused.

Planned for 1 100 lines of code. It needs more, as a simulated arm that wears is here, and forces
of MuJoCo that no model can have are each refused by name.

Public names, by module:

    .: arm_plant
    arm_plant: DRIVES, GapGrowth, HIGH, LOW, program, WorkingArm
    chain: body_of, Chain, chain_of, inertial, level_frame, Link, PER_LINK, pseudo_inertia
    compiled_model: actuator_law, actuator_losses, ActuatorLaw, actuators_on, at_rest,
        disabled, DRAG, enabled, ends_of, implausible_limits, implausible_links,
        implausible_ranges, is_off, kind_of, moved_by, mujoco_module, name_of, open_loop,
        Refusal, runge_kutta, scalar_joints, tendon_forces, undecided, undecided_of_robot,
        Unread
    description: expanded_root, finite_number, LOCKED_IN_VALUES, LONGEST, own_joints, parse,
        PRINCIPAL, RobotDescription, SUFFIXES, turn
    dynamics: ArmLoad, arrays_of, GRAVITY, MotionState, Payload
"""
