# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Several publishers of the same joints: their numbers decide whose messages are taken."""
import numpy as np
import pytest

from gearbox_monitor.ros.publishers import Publishers, REACH, SECOND, SILENT

T0 = 1_700_000_000 * SECOND
MS = SECOND // 1000


def run(policy, *streams, publishers=None):
    """
    Hand merged `streams` of (name, times ms, numbers) to Publishers.

    Returns ({name: [taken at ms]}, Publishers).
    """
    publishers = publishers or Publishers(policy)
    events = sorted((t, name, number) for name, times, numbers in streams
                    for t, number in zip(times, numbers))
    taken = {name: [] for name, *_ in streams}
    for t, name, number in events:
        if publishers.admit(int(number), T0 + int(t) * MS):
            taken[name].append(t)
    return taken, publishers


def stream(name, begin, end, step=2, first=1, loss=0.0, seed=0):
    """Return a stream from `begin` to `end` (ms), a share `loss` of its messages lost."""
    times = np.arange(begin, end, step)
    keep = np.random.default_rng(seed).random(len(times)) >= loss
    return name, times[keep], (first + np.arange(len(times)))[keep]


@pytest.mark.parametrize('policy', ['refuse', 'follow_first', 'accept'])
def test_all_of_a_single_publisher_is_taken(policy):
    """With losses, with numbers that other joints use up, through a pause and a restart."""
    lossy = stream('a', 0, 20_000, loss=0.3)
    later = stream('a', 60_000, 70_000, first=10_001)
    again = stream('a', 71_500, 80_000)
    name, times, numbers = stream('a', 90_000, 100_000)
    taken, publishers = run(policy, lossy, later, again, (name, times, 7 * numbers + 90_000))
    sent = sum(len(s[1]) for s in (lossy, later, again)) + len(times)
    assert len(taken['a']) == sent and publishers.refused == publishers.disputes == 0


@pytest.mark.parametrize('step', [-3600, -0.2, 3600])
def test_a_clock_that_is_set_loses_nobody(step):
    """A restart just after it is followed within a second; who was refused stays refused."""
    publishers = Publishers('follow_first')
    run('', stream('a', 0, 10_000), stream('b', 5000.5, 10_000), publishers=publishers)
    base = 10_000 + 1000 * step
    taken, _ = run('', stream('a', base, base + 5000, first=5001),
                   stream('b', base + 0.5, base + 5000, first=2501), publishers=publishers)
    assert len(taken['a']) == 2500 and not taken['b']
    base += 5000 + 1000 * step
    taken, _ = run('', stream('a', base, base + 5000), publishers=publishers)
    assert len(taken['a']) >= 2000 - 1 and taken['a'][-1] == base + 4998


@pytest.mark.parametrize('seed', range(5))
def test_a_stranger_is_never_followed(seed):
    """Whatever its rate and numbers, while the first goes on and once that has gone."""
    random = np.random.default_rng(seed)
    first = int(random.integers(10 ** 4, 10 ** 6))
    low = int(random.integers(1, 1000))
    a = stream('a', 0, 60_000, first=first, loss=0.05, seed=seed)
    b = stream('b', 10_000.5, 90_000, step=random.choice([0.7, 3, 100]), first=low, seed=seed)
    c = stream('c', 20_000.5, 70_000, step=5, first=first + 10 ** 6, seed=seed)
    taken, publishers = run('follow_first', a, b, c)
    assert taken['a'] == list(a[1]) and not taken['b'] and not taken['c']
    assert publishers.refused == len(b[1]) + len(c[1])
    assert publishers.others(T0 + 69_999 * MS) == 2 and publishers.waits(T0 + 69_999 * MS)
    # Back, it is the first again; and a new one is followed once nobody else may be meant.
    taken, _ = run('', stream('a', 95_000, 96_000, first=int(a[2][-1]) + 1),
                   stream('b', 95_000.5, 99_000, first=int(b[2][-1]) + 1),
                   stream('d', 97_500.2, 99_000, first=5 * 10 ** 6), publishers=publishers)
    assert len(taken['a']) == 500 and not taken['b'] and len(taken['d']) == 750


@pytest.mark.parametrize('first', [1, 40, 1001])
def test_where_nobody_was_first_nothing_is_taken(first):
    """Also with equal numbers, and with numbers that look like a loss of the other's messages."""
    a = stream('a', 0, 10_000, first=1001)
    b = stream('b', 500.5, 6000, first=first)
    taken, publishers = run('follow_first', a, b)
    assert publishers.disputes >= 1 and len(taken['b']) <= 1
    early = [t for t in taken['a'] if t < 6000]
    assert early[-1] < 520
    late = [t for t in taken['a'] if t >= 6000]
    assert late and late[-1] == 9998 and late[0] <= 6000 + 2 * SILENT / MS


def test_numbers_ahead_of_the_first_do_not_take_its_place():
    """Started together, but one was heard later: its numbers are those of lost messages."""
    a = stream('a', 0, 20_000, first=5)
    b = stream('b', 8000.5, 20_000, first=4005 + REACH // 2)
    taken, publishers = run('follow_first', a, b)
    assert taken['b'] == [8000.5] and taken['a'] == list(a[1])


def test_a_publisher_that_was_held_up_is_recognised():
    """Reliable messages that were lost on the way come later, in one go."""
    name, times, numbers = stream('b', 5000.5, 20_000)
    late = np.where((times > 8000) & (times < 10_000), 10_000.5, times)
    taken, publishers = run('follow_first', stream('a', 0, 20_000), (name, late, numbers))
    assert len(taken['a']) == 10_000 and publishers.refused == len(numbers)


@pytest.mark.parametrize('step', [0.2, 2.0])
@pytest.mark.parametrize('ahead', [-200, 0, 1, 101])
def test_numbers_near_those_of_the_first_stop_nothing(ahead, step):
    """Equal numbers, numbers that overtake, numbers that look like losses: the stamps tell."""
    _, times, numbers = stream('a', 0, 30_000, first=5, loss=0.05)
    _, other, foreign = stream('b', 15_000.5, 30_000, step=step, first=7505 + ahead, loss=0.05)
    random, publishers = np.random.default_rng(1), Publishers('follow_first')
    stamps = times + random.uniform(-0.05, 0.05, len(times)), other + 0.3
    events = sorted([*zip(times, numbers, stamps[0], np.zeros(len(times))),
                     *zip(other, foreign, stamps[1], np.ones(len(other)))])
    taken = [who for t, number, stamp, who in events if publishers.admit(
        int(number), T0 + int(t * MS), T0 + int(stamp * MS))]
    assert publishers.disputes == 0
    assert len(times) - taken.count(0.0) <= 1 and taken.count(1.0) <= 1


@pytest.mark.parametrize('change', [
    lambda t: t + 3.6e6 * (t > 9000), lambda t: t - 3000.0 * (t > 9000),
    lambda t: t + 3.0 * np.maximum(t - 9000, 0.0)])
def test_one_publisher_whose_clock_is_set_is_still_followed(change):
    _, times, numbers = stream('a', 0, 20_000)
    publishers = Publishers('follow_first')
    taken = [publishers.admit(int(number), T0 + int(t * MS), T0 + int(stamp * MS))
             for t, number, stamp in zip(times, numbers, change(times.astype(float)))]
    assert taken.count(False) * 2 <= 60 and all(taken[-5000:])


def test_policies_refuse_and_accept():
    a = stream('a', 0, 20_000)
    b = stream('b', 8000.5, 12_000)
    taken, _ = run('refuse', a, b)
    assert not taken['b'] and not [t for t in taken['a'] if 8010 < t < 12_900]
    assert taken['a'][-1] == a[1][-1]
    taken, publishers = run('accept', a, b)
    assert len(taken['b']) == len(b[1]) and len(taken['a']) == len(a[1])
    assert publishers.others(T0 + 11_990 * MS) == 1


def test_unnumbered_messages_and_many_publishers():
    publishers = Publishers('follow_first')
    assert all(publishers.admit(None, T0) for _ in range(3))
    crowd = [stream(f'{k}', 5000.5 + k / 100, 9000, step=200, first=1 + 10 ** 5 * k)
             for k in range(2, 60)]
    taken, publishers = run('follow_first', stream('a', 0, 9000), *crowd)
    assert len(taken.pop('a')) == 4500 and not any(taken.values())
    assert len(publishers._sources) <= 16
