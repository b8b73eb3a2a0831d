# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The public API: what `import gearbox_monitor` offers.

In go paths, arrays, DataFrames and models; out come results that show themselves. The commands
call the same functions.

Public names, by module:

    actuators: CatalogueActuator, is_actuator, load_actuator, NAMES
    drive_file: load_model, SIMULATORS
    identify: diagnose, expect_ids, uniform
    payload_track: payload_tracker, PayloadTrack, track_payload
    ranges: ranges
    recording: load_recording, Recording
    recording_report: write_report
    robot: diagnose_robot, learn_robot, load_robot, recorded_names, Robot, robot_effects,
        RobotDiagnosis
    simulator_file: export_model, SimulatorFile, TARGETS
    tuning: adapt, write_adapted
    views: columns
"""
