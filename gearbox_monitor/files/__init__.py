# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Files of a user: models, parameters, baselines, knowledge, and the packaged configuration.

In go paths; out come checked values, or one error that names file, field and value. Files are read
within limits and written whole.

Public names, by module:

    .: user_files
    baselines: AGAIN, BaselineRecording, check_belongs, Damaged, earlier, health_text,
        load_recording, load_state, save_baseline, set_aside, STATE, StateFile
    knowledge_file: load_knowledge, load_watch, save_knowledge, save_watch, SUFFIX,
        watch_bytes, watch_from
    user_files: BoundedGzip, config_path, dump, error_words, expect_new, expect_new_file,
        expect_outside_of_bag, gearboxes_of, load_model, load_parameters, load_robot,
        load_yaml, LONGEST_LINE, model_text, open_file, open_unpacked, parse_yaml, plain,
        read_bytes, read_json, read_text, save_model, TOPIC, write_new, write_parameters
"""
