# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Health of a gearbox: trust in the estimates, backlash, its growth and its alarms.

In go estimates, row by row; out come outcomes with a level, windows of features and alerts. The
same samples give the same outcomes, live and offline.

Planned for 3 200 lines of code with `watch`. They need more, as a motor encoder alone, slips,
temperature and operating points are distinguished from wear.

Public names, by module:

    .: judgement
    alarms: Condition, Group, Level, LIMITS, Outcome, outcome_of, with_more
    backlash: change_tests
    backlash.change_tests: ChangeTest, COMPONENTS, FEATURES, FRICTION, MEASURED, size_name,
        TESTS, WEAR, WEAR_FEATURES
    backlash.features: Backlash, combine, Combined, is_locked, locked_windows, NotExcited,
        reason_of, separable_of, width_of
    backlash.wear: when
    checks: observability
    checks.innovation: ErrorWatch, LJUNG_BOX_LIMIT, MEAN_LIMIT, N_SUMS, watch
    elastic_regression: add_row, certainty, D_FRICTION, D_RATE, D_TORQUE, D_TWIST, D_U, D_X2,
        D_X3, D_X4, HALF_GAP, N_CARRIED, N_DATA, N_SHAPE, S_GROUP, STIFFNESS, Sums
    health_record: FeatureHealth, GROSS, HealthSettings, Window
    judgement: accepted, CHANGED, CLASSES, figures, folded, from_data, Health, OF_WINDOWS,
        said_of_slips, sentence, serviced, SLIP, to_data
    monitor: CONDITIONS, DRIFT_SHOWS, Monitor, NO_DATA, ROW_CHECKS
"""
