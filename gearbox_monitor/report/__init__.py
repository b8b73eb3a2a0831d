# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Words, charts and pages: here results become sentences.

In go verdicts, outcomes and time lines; out come lines of text and HTML pages. A page is
one file that loads nothing.

Planned for 2 300 lines of code. It needs more, as a robot, a drive, a recording, a fleet and a
live stream each have a page of their own.

Public names, by module:

    .: words
    builder: Page, page_summary, render_page, Section
    chart: Chart, Drawing, Panel, Plane, Trace
    diagnosis_page: diagnosis_page, gather, shows_place
    explanation: ALL_CONDITIONS, Explanation, explanations
    fleet_page: CSV_NAME, fleet_csv, fleet_page, headline, name_of
    live_page: GearboxHistory, live_frame, LivePage, WatchNews
    recording_page: backlash_chart, figures, headline, overview, recording_page, robot_page,
        ROLES
    robot_pages: by_effect, robot_gap_page, RobotContext, watch_page
    robot_words: finding_words, reading_words, robot_headline, robot_text, watch_data,
        watch_headline, watch_text
    sentences: CHANGES, of_fit, of_noise, of_unit, say, summary, title, told, UNITS
    timeline: measured, recorded_timeline, RecordingFacts, state_of, Timeline, timeline_of
    words: change_sentence, counted, NAMING, next_steps, NO_FILES, NOTHING, place_text,
        sentence, torque_map_of, undefined, unit_of, UserFiles, value_rows
"""
