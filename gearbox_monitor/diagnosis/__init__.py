# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it closes.

In go recordings and a model; out comes a verdict with findings and a remainder. `joint` diagnoses
one drive by the innovations of a filter, `robot` all joints by the balance of torques.

Planned for 5 300 lines of code with both kinds of evidence. They need more, as effects without a
derivative, hidden sides, servos, zeros and conventions each have a numerical method of their own.

Public names, by module:

    hypothesis: EFFECT, Finding, INCOMPLETE, kind_of, NONE, UNDECIDED, UNKNOWN
    joint: diagnose, nominal, windows
    joint.candidates: CandidateModel, Coordinate, NUISANCES, sine_and_cosine, with_effects
    joint.diagnose: chosen_ids, diagnose_change
    joint.innovations: coordinate_columns, evaluated, FilteredFit, fitted, halves,
        InnovationFit, InnovationLikelihood, noise_floor
    joint.nominal: Adapted, fit_nominal, FittedValue, NominalFit, samples_of
    joint.parameter_ranges: Combination, ParameterRanges, ranges_of, UnitEstimate
    joint.shooting: Simulator
    joint.verdict: Verdict
    joint.windows: closed_of, FLANKS, gap_of, ModelRun, Overlay, overlay
    robot: knowledge, verdict
    robot.candidates: Candidate
    robot.conventions: columns_as_read, least_explained, LIMITS, log_as_read, misfit,
        named_readings, NamedReading, ReadingScore, RobotReading
    robot.knowledge: another_day_of, farther, Knowledge, learn, ServoKnowledge, States,
        VERSION, Visits, with_unvisited
    robot.likelihood: Prior, RobotFit, RobotLikelihood
    robot.robot_effects: BASE, BASE_TILT, INERTIA_NAMES, JOINT, LINK, LINK_INERTIA, PAYLOAD,
        ROBOT_EFFECTS, RobotEffect, tilted
    robot.robot_log: checked_log, continuous, CURRENT, jump, raw_log, RawLog, read_by,
        RobotLog, SETPOINT, TORQUE
    robot.rows: NuisanceColumn, RobotModel, Rows, rows_of
    robot.servo: SERVO, with_learnt_servos, with_servos
    robot.verdict: effort_curves, EffortCurves, RobotVerdict, sampled_early, setpoint_lags,
        verdict_data
    robot.zeros: zeros_in
    settings: SETTINGS
"""
