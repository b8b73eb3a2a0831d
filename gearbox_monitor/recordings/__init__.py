# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings: bags read, written, replayed and repaired, and other formats imported.

In go bags (MCAP, SQLite) and files of other programs; out come samples, estimates and new bags.
Blocks of messages are converted at once, in bounded memory.

Public names, by module:

    cdr: encode_joint_states, JointStates
    csv: COLUMNS, CsvColumns, ENCODERS, read_csv, TEXTS
    examples: ENCODERS, ExampleMotion, MOTIONS, NOISE, process_torque, write_example_bag,
        write_robot_pair
    importer: load_mapping, read_any, write_imported_bag
    importer.containers: opened_table
    importer.guess: Answers, Guess, guessed_mapping
    importer.message_bag: import_bag, is_bag
    importer.sibling_file: state_files
    joint_input: bag_arguments, DIAGNOSTIC_ARRAY, find_input, GEARBOX, Joiner, JointInput,
        match_stamps, PAYLOAD_CHANGE, recorded_inputs, StampMatcher, topics_called,
        write_paired
    player: EstimatePlayer, Player, recorded_robot
    read: BagReader, JOINT_STATE, natural, open_bag
    recorded_samples: joined_samples, NO_MODEL, NO_SERIAL, read_samples, read_snapshots,
        RecordedSamples, sample_parts, samples_of, sliced
    recovery: recover, Recovery
    replay: Comparer, Comparison, interval_error, Replay, replay, ReplayCollector,
        ReplaySummary, smoothed, truth, truth_of
    replay_output: BagOutput, CsvTable, ParquetTable
    robot_input: read_robot_log, TABLES
    robot_values: load_locked, load_log, load_values, robot_model, RobotValues
    storage: FILE_NAME, qos_profile
    topics: ARM, DIAGNOSIS, DIAGNOSTICS, DRIFT_ALERTS, EXTERNAL_TORQUE, EXTERNAL_TORQUE_STD,
        JOINT_STATES, joint_values, MOTOR, PAIRED_JOINT_STATES, PAYLOAD, PAYLOAD_STD,
        PLANT_TRANSMISSION_STATE, Signal, SIGNALS, SNAPSHOT, TRANSMISSION
    write: BagWriter, WriteError
"""
