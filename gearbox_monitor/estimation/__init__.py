# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Estimation: one sample in, one estimate out, by one of several Kalman filters.

In go samples, a model and parameters; out come torque, twist, innovations and deviations, smoothed
with a fixed lag or over a whole recording. Live nodes and replay run the same loop.

Planned for 3 300 lines of code. It needs more, as filters with different laws of tau_K may be
mixed, and what errors of the model add is carried beside each estimate.

Public names, by module:

    .: innovation_filter, rts_smoother, sample_loop
    consider: ERROR_NAMES
    estimates: Batch, COLUMNS, Estimate, Estimates, Sample, Samples, SMOOTHED_COLUMNS
    estimator: Estimator, expect_format, snapshot_errors, SnapshotError, unsmoothed
    filter_kind: Belief, filter_kind, Scratch
    filter_setup: described
    innovation_filter: COLOURED, FilterInput, FilterStart, FilterTrace, LASTING, N_FILTER,
        SampleSchedule
    noise_search: at_rest, BLUNT, MIN_SAMPLES, MIN_SECONDS, widened
    process_model: FRICTION_AT, K_P, LOAD_AT, P0, Q0, R1, R2, STATISTICAL, tangent, TAU_K,
        UNIFORM, X1, X2, X3, X4
    rts_smoother: S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, S_TAU_K, S_TAU_K_NOISE_STD,
        S_TAU_K_STD, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE, S_TWIST_RATE_NOISE_STD,
        S_TWIST_STD, S_U, S_X2, S_X3, S_X4, smoother_parameters
    sample_loop: BACKWARD, CONFIRM, DUPLICATE, ESTIMATE, HUGE, JUMP, LoopSettings, LoopState,
        Output, REASONS, SECOND, stamp_codes, START, Stream, ZERO_STAMP
    score: LAGS, ljung_box, MIN_SAMPLES, run_score
    tune: tune
"""
