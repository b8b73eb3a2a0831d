# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings in memory, and what their signals say before any model of a drive is asked.

In go stamps, positions and efforts of a drive or a robot; out come a Recording, positions without
jumps, a recording on an even grid, and findings with limit and advice. Nothing here reads a file.

Planned for 1 500 lines of code. It needs more, as a doubt about wiring is settled by fits of
rival readings here, before a model is asked.

Public names, by module:

    .: SignalHandlerOptions
    examine: admitted, Examination, examine, examined, joined, kind_of, measured_samples,
        require_samples, SAMPLES, WINDOWS
    finding: BAD, DataFinding, hurts, judged, LIMITS, OK, PURPOSES, WARN
    jumps: counted_on, JumpFinding, OUTLIER, PERIODS, repeats, SLIP, strangers, TURNS, turns,
        wild_rows, without_jumps
    recording: ARM, AS_RECORDED, Convention, conventions_of, CURRENT, drive_samples, JOINT,
        JointSignals, MOTOR, NOT_MEASURED, Recording, UNKNOWN
    stamps: evened, require_stamps, unstamped
    uniform: at_one_rate, expect_one_rate, prepare, RecordingKind, rms_of, UniformRecording,
        usable_rows
"""
