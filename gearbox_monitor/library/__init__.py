# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The public API, as `import gearbox_monitor` offers it.

In go paths, arrays, DataFrames and models; out come results that show themselves. The commands
call the same functions.

Planned for 1 400 lines of code. It needs more, as each function names the argument that is wrong,
and each result shows itself as a line, a table and a page.

Public names, by module:

    .: robot
    identify: adapt, diagnose, Diagnosis, fit, uniform, write_adapted
    progress: Bar, count_bar, progress_bar, shown_time
    ranges: ranges, ranges_yaml
    recording: DriveRecording, load_recording
    recording_report: write_report
    robot: check_robot, description_in, load_robot, recorded_names, Robot, robot_effects,
        urdf_in, watch_robot
    simulator_file: CatalogueActuator, export_model, is_actuator, load_actuator, load_model,
        NAMES, SimulatorFile, SIMULATORS, TARGETS, with_backlash, written_model
"""
