# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Files of a user: models, parameters, baselines, knowledge, and the packaged configuration.

In go paths; out come checked values, or one error that names file, field and value. Files are read
within limits and written whole.

Public names, by module:

    .: yaml_files
    baselines: AGAIN, BaselineRecording, check_belongs, Damaged, earlier, health_text,
        load_recording, load_state, save_baseline, set_aside, STATE, StateFile
    knowledge_file: load_knowledge, load_watch, save_knowledge, save_watch, SUFFIX,
        watch_bytes, watch_from
    opening: BoundedGzip, config_path, dump, load_robot, LONGEST_LINE, open_file,
        open_unpacked, plain, read_bytes, read_json, read_text, TOPIC, write_new
    yaml_files: error_words, expect_new, expect_new_file, expect_outside_of_bag, gearboxes_of,
        load_model, load_parameters, load_yaml, model_text, parse_yaml, save_model,
        write_parameters
"""
