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
    diagnosis_page: by_effect, context_of, diagnosis_page, DiagnosisContext, effort_chart
    explanation: ALL_CONDITIONS, Explanation, explanations
    fleet_page: CSV_NAME, fleet_csv, fleet_page, headline, name_of
    live_page: GearboxHistory, live_frame, LivePage, WatchNews
    recording_page: backlash_chart, figures, headline, overview, raised, recording_page,
        robot_page, ROLES
    sentences: CHANGES, entries, labelled, of_fit, of_noise, of_unit, say, title, told, UNITS,
        wrapped
    timeline: measured, recorded_timeline, RecordingFacts, State, state_of, Timeline,
        timeline_of
    watch_page: watch_page
    watch_words: reading_words, watch_data, watch_headline, watch_text
    words: change_sentence, counted, finding_words, headline, LABEL, sentence, verdict_text
"""
