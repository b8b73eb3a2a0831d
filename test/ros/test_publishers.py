# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Two publishers of one joint: the numbers of their messages show them, nothing is taken."""
import numpy as np

from gearbox_monitor.ros.gearbox_input import HOLD, JointPublishers, RECENT, SECOND

T0 = 1_700_000_000 * SECOND
MS = SECOND // 1000


def run(*streams):
    """
    Hand merged `streams` of (name, times ms, numbers) to JointPublishers.

    Returns ({name: [taken at ms]}, [ms at which there are two]).
    """
    publishers, two = JointPublishers(), []
    events = sorted((t, name, number) for name, times, numbers in streams
                    for t, number in zip(times, numbers))
    taken = {name: [] for name, *_ in streams}
    for t, name, number in events:
        now_ns = T0 + int(t * MS)
        if publishers.admit(int(number), now_ns):
            taken[name].append(t)
        if publishers.are_two(now_ns):
            two.append(t)
    return taken, two


def stream(name, begin, end, step=2.0, first=1, loss=0.0, seed=0):
    """Return a stream from `begin` to `end` (ms), a share `loss` of its messages lost."""
    times = np.arange(begin, end, step)
    keep = np.random.default_rng(seed).random(len(times)) >= loss
    return name, times[keep], (first + np.arange(len(times)))[keep]


def test_one_publisher_is_taken_through_losses_restarts_and_clocks():
    """A restart costs HOLD; numbers that other joints use up, and a clock that is set, nothing."""
    for clock_step in (0.0, -3600e3, -500.0, 3600e3):
        lossy = stream('a', 0, 20_000, loss=0.3)
        name, times, numbers = stream('b', 20_500 + clock_step, 30_000 + clock_step)
        hold = HOLD / MS
        parts = [lossy, (name, times, 7 * numbers),
                 stream('c', 30_001 + clock_step, 40_000 + clock_step)]
        publishers = JointPublishers()
        taken = [[t for t, n in zip(times, numbers)
                  if publishers.admit(int(n), T0 + int(t * MS))] for _, times, numbers in parts]
        assert taken[0] == list(lossy[1])
        for got, (_, times, _) in zip(taken[1:], parts[1:]):
            assert got == list(times[times >= times[0] + hold])
        assert not publishers.are_two(T0 + int(30_001 + clock_step) * MS)


RIVALS = [
    (2.0, 1, 0.0), (2.0, 4001, 0.0), (2.0, 4003, 0.2), (2.0, 10 ** 6, 0.0), (0.7, 1, 0.0),
    (20.0, 1, 0.2), (100.0, 10 ** 6, 0.0), (900.0, 1, 0.0)]


def test_nothing_is_taken_of_two_until_one_ends():
    """Whatever their rates and numbers; of the rival's messages not more than the first is."""
    for step, first, loss in RIVALS:
        taken, two = run(stream('a', 0, 40_000, loss=loss), stream(
            'b', 8000.5, 20_000, step=step, first=first, loss=loss, seed=1))
        assert len(taken['b']) <= 1
        known, recovered = two[0], 20_000 + RECENT / MS
        assert known <= 8000.5 + 2 * step + 20
        assert not [t for t in taken['a'] if known <= t <= 20_000]
        assert two[-1] < recovered
        later = [t for t in taken['a'] if t >= recovered]
        assert later == list(stream('a', 0, 40_000, loss=loss)[1][-len(later):])
        assert len(later) > 7000


def test_a_rival_that_stays_is_taken_once_the_first_has_ended():
    taken, two = run(stream('a', 0, 10_000), stream('b', 5000.5, 20_000, first=77))
    assert two[0] < 5010 and two[-1] < 10_000 + RECENT / MS
    assert taken['b'][0] < 10_010 + RECENT / MS and taken['b'][-1] > 19_990


def test_messages_without_numbers_are_taken():
    publishers = JointPublishers()
    assert all(publishers.admit(None, T0 + k) for k in range(3)) and not publishers.are_two(T0)
