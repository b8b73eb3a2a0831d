# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings of every kind, read in one way.

In go bags and files of other programs. A container becomes a Table of named columns (table), to
which names and units (guess) or a file (mapping) give their meaning. Out come samples, a Recording
of a drive or a robot (reading: open_recording), estimates of a replay, and new bags.

Planned for 4 000 lines of code. It needs more, as tests hold every layout of text, container of
arrays and kind of damage that it reads, and a library for bags refuses what is cut or damaged.

Public names, by module:

    cdr: encode_joint_states, JointStates, MAX_LAYOUTS, MessageBlock, read_layout
    examples: ExampleMotion, NOISE, process_torque, write_example_bag, write_robot_pair
    from_bag: ANY, load_locked, load_log, load_values, names_in_log, recorded_joints,
        robot_model, RobotValues
    guess: Answers, Guess, Unsettled
    joint_input: bag_arguments, DIAGNOSTIC_ARRAY, find_input, find_topic, GEARBOX,
        innovation_topics, Joiner, JointInput, match_stamps, nis_of, NO_MODEL, NO_SERIAL,
        PAYLOAD_CHANGE, read_snapshots, recorded_inputs, recorded_settings, sample_parts,
        samples_of, topics_called
    player: Player
    read: BagReader, natural, open_bag
    reading: BY_NAMES, converted_bag, is_bag, open_recording, paired_bag, read_mapping,
        ReadOptions
    replay: BagOutput, Comparison, CsvTable, ParquetTable, Replay, replay, summarised
    si_signals: bag_of_table
    storage: FILE_NAME, next_free, qos_profile
    table: is_log_of_xml
    topics: ARM, DIAGNOSIS, DIAGNOSTICS, DRIFT_ALERTS, FINDINGS, JOINT_STATES, joint_values,
        MOTOR, PAIRED_JOINT_STATES, PAYLOAD, PAYLOAD_STD, PLANT_TRANSMISSION_STATE,
        ROBOT_DESCRIPTION, Signal, SIGNALS, SNAPSHOT, TRANSMISSION
    write: BagWriter, recover, Recovery, WriteError
"""
