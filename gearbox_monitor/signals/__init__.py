# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Signals of a recording: stamps, encoders, torque and motion, and what they suit.

In go arrays of one recording; out come a recording on an even grid and findings, each with its
limit and advice. Nothing here reads a file.

Public names, by module:

    .: SignalHandlerOptions
    admission: admitted, measured_samples, prepared, require_samples, weighed
    examine: Examination, examine
    finding: BAD, OK, PURPOSES, WARN
    parts: joined, SAMPLES, WINDOWS
    smoothed_motion: SmoothedMotion
    stamps: evened
    uniform: at_one_rate, expect_one_rate, merged, prepare, RecordingKind, REPEATED, rms_of,
        UniformRecording
"""
