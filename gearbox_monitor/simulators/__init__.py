# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Models of simulators: read the drive or robot in an MJCF or URDF file, and write into it.

In go a simulator's file and a verdict; out come a model, and the user's file with the values that
close the gap. All else in the file stays as the user wrote it.

Planned for 2 600 lines of code. It needs more, as whatever MuJoCo compiles is either read or
refused by name, and edits leave the user's text as it was.

Public names, by module:

    c99: firmware
    drive_patch: in_urdf, patched, patched_urdf
    file_edits: Patch
    mjcf: CONSTRUCT, Exported, expression_of, model_values, NATIVE, REFUSED, refused, values_of
    mjcf_file: compiled_file, drive_of, MjcfDrive, model_of, read_file, read_mjcf, RobotFile,
        values_in
    robot_model: ChainFile, links_of_compiled, MODEL_FILES, read_robot
    robot_patch: closed_file, rollouts, title_of
    user_simulator: confirmation, joint_readings, JointReading, NONE, SERVO, SPEED, TORQUE,
        user_simulator, UserSimulator
    xml_edit: difference
"""
