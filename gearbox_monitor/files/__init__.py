# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Files of a user: models, parameters, baselines, knowledge, and the packaged configuration.

In go paths; out come checked values, or one error that names file, field and value. Files are read
within limits and written whole.

Public names, by module:

    .: yaml_files
    baseline_recording: BaselineRecording, check_belongs, load_recording, split
    baselines: Damaged, load_baseline, load_state, save_baseline, set_aside, state_text
    bounded_yaml: parse_yaml
    knowledge_file: load_knowledge, save_knowledge, SUFFIX
    opening: open_file, read_bytes, read_text, write_new
    packed_files: lines_of, open_unpacked, PIECE, read_unpacked
    parameter_file: error_words, write_parameters
    plain_data: dump, plain, read_json
    resources: config_path
    robot_files: load_robot, TOPIC
    state_file: StateFile
    yaml_files: expect_folder_of, expect_new, expect_new_file, expect_outside_of_bag,
        gearboxes_of, load_model, load_parameters, load_yaml, model_text, save_model
"""
