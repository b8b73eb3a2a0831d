# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the diagnosis of a robot says in words."""

from gearbox_monitor.report.robot_words import remainder_words


REMAINS = [
    ('speed', {}, 'lift: 1.23 N rms over speed, by no law of the library'),
    ('bursts', {'times': [[3.0, 5.0], [9.0, 11.0]], 'recordings': ['a', 'b']},
     'lift: 1.23 N rms in bursts, at 3 s of a, 9 s of b'),
    (None, {'excess': 9.0},
     'lift: 1.23 N rms without a pattern, 3.00 times the remainder of healthy parts')]


def test_what_remains_has_its_size_and_how_it_shows():
    for over, more, words in REMAINS:
        remainder = {'joint': 'lift', 'size': 1.23, 'over': over, **more}
        assert remainder_words(remainder, {'lift': 'prismatic'}) == words
