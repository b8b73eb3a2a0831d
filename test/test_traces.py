# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What small recordings and drawn problems give, room by room, is what is stored."""
import json

import pytest

from benchmarks import traces


@pytest.mark.parametrize('room', traces.ROOMS)
def test_traces_are_the_stored_ones(room):
    """Where a change is meant: python -m benchmarks traces --update, in a commit of its own."""
    moved = traces.changed(traces.load()[room], traces.plain(traces.ROOMS[room]()))
    assert not moved, '\n'.join(moved)


def test_a_change_is_named_by_recording_and_seconds():
    log = traces.drive_log(traces.WORN)
    stored = {'log': traces.plain(traces.estimates(log))}
    log['motor'][1500:1750] += 2e-3  # from 3.0 to 3.5 s
    now = {'log': traces.plain(traces.estimates(log))}
    first, *_ = lines = traces.changed(stored, now)
    assert first.startswith('log: estimates, 2.5 to 3.0 s: ')  # smoothed with what follows
    assert any(line.startswith('log: estimates, 3.0 to 3.5 s: ') for line in lines)
    assert not traces.changed(stored, json.loads(json.dumps(stored)))
    stored['log']['health']['observability'] = ['ERROR']
    assert 'log: health, observability: ERROR -> no such row' in traces.changed(
        stored, {'log': {**stored['log'], 'health': {}}})
