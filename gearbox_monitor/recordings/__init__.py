# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings: bags read, written, replayed and repaired, and other formats imported.

In go bags (MCAP, SQLite) and files of other programs; out come samples, estimates and new bags.
Blocks of messages are converted at once, in bounded memory.

Public names, by module:

    cdr: encode_joint_states, JointStates
    comparison: Comparer, Comparison
    csv: COLUMNS, CsvColumns, ENCODERS, read_csv, TEXTS
    estimate_table: CsvTable, ParquetTable
    example_bag: ENCODERS, ExampleMotion, MOTIONS, NOISE, process_torque, write_example_bag
    importer: load_mapping, read_any, write_imported_bag
    importer.containers: opened_table
    importer.guess: Answers, Guess, guessed_mapping
    importer.message_bag: import_bag, is_bag
    importer.sibling_file: state_files
    joiner: Joiner
    joint_input: bag_arguments, DIAGNOSTIC_ARRAY, find_input, GEARBOX, JointInput,
        PAYLOAD_CHANGE, recorded_inputs, topics_called
    metadata: FILE_NAME, qos_profile
    paired_bag: write_paired
    player: EstimatePlayer, Player, recorded_robot
    read: BagReader, JOINT_STATE, natural, open_bag
    recorded_samples: joined_samples, read_samples, RecordedSamples, sample_parts, samples_of,
        sliced
    recorded_snapshots: NO_MODEL, NO_SERIAL, read_snapshots
    recovery: recover, Recovery
    replay: interval_error, replay, Replay, ReplayCollector, smoothed, truth
    replay_output: BagOutput
    replay_summary: ReplaySummary, truth_of
    robot_example: write_robot_pair
    robot_input: read_robot_log, TABLES
    robot_values: load_locked, load_log, load_values, robot_model, RobotValues
    stamp_matching: match_stamps, StampMatcher
    topics: ARM, DIAGNOSIS, DIAGNOSTICS, DRIFT_ALERTS, EXTERNAL_TORQUE, EXTERNAL_TORQUE_STD,
        JOINT_STATES, joint_values, MOTOR, PAIRED_JOINT_STATES, PAYLOAD, PAYLOAD_STD,
        PLANT_TRANSMISSION_STATE, Signal, SIGNALS, SNAPSHOT, TRANSMISSION
    write: BagWriter, WriteError
"""
