# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The state machine of every alarm, by exhaustion and by random sequences; the conditions."""
import itertools

import numpy as np

from gearbox_monitor.health.alarms import Alarm, joined, Level, Outcome, outcome_of, Said
from gearbox_monitor.health.checks.innovation import BIASED, GROSS, OUTLIERS

SECOND = 1_000_000_000
DEBOUNCES = [(3, 5), (2, 2), (1, 1), (4, 1), (1, 2)]


def levels_of(raws, up, down):
    alarm = Alarm(up, down)
    return [int(alarm.update(Level(raw), k)) for k, raw in enumerate(raws)]


def expected_levels(raws, up, down):
    """Two switches, one per level, each with its own runs: the rule in other words."""
    on, run, result = [True, False], [[0, 0], [0, 0]], []
    first = decided_at(raws, up)
    for k, raw in enumerate(raws):
        for i in range(2):
            above = raw > i
            run[i] = [run[i][0] + 1, 0] if above else [0, run[i][1] + 1]
            if run[i][0] >= up:
                on[i] = True
            elif run[i][1] >= down or k == first and not above:
                on[i] = False
        result.append(2 if on[1] else int(on[0]))
    return result


def decided_at(raws, up):
    """Return the number of the first evaluation that finds nothing, or confirms a WARN."""
    return next((k for k, raw in enumerate(raws) if not raw or k + 1 >= up), len(raws))


def random_sequences(count, length):
    rng = np.random.default_rng(0)
    for _ in range(count):
        stay = rng.uniform(0.3, 0.98)
        raws = [int(rng.integers(3))]
        while len(raws) < length:
            raws.append(raws[-1] if rng.random() < stay else int(rng.integers(3)))
        yield raws


def check_promises(raws, up, down):
    levels = levels_of(raws, up, down)
    assert levels == expected_levels(raws, up, down)
    for at in (1, 2):
        above = [raw >= at for raw in raws]
        alarmed = [level >= at for level in levels]
        for k in range(len(raws)):
            # Latency: so many evaluations that agree settle it, whatever came before.
            if k + 1 >= up and all(above[k + 1 - up:k + 1]):
                assert alarmed[k]
            if k + 1 >= down and not any(above[k + 1 - down:k + 1]):
                assert not alarmed[k]
            # No change without so many that agree, but for the one that decides the start.
            if k and alarmed[k] and not alarmed[k - 1]:
                assert k + 1 >= up and all(above[k + 1 - up:k + 1])
            if k > decided_at(raws, up) and alarmed[k - 1] and not alarmed[k]:
                assert not any(above[max(0, k + 1 - down):k + 1])
        changes = [k for k in range(1, len(raws)) if alarmed[k] != alarmed[k - 1]]
        for a, b in zip(changes, changes[1:]):
            assert b - a >= (up if alarmed[b] else down)  # how fast it can flap at most


def test_every_short_sequence():
    for up, down in DEBOUNCES:
        for raws in itertools.product(range(3), repeat=7):
            check_promises(raws, up, down)


def test_long_random_sequences():
    for up, down in DEBOUNCES:
        for raws in random_sequences(30, 300):
            check_promises(raws, up, down)


def test_counters_are_clamped():
    for before in itertools.product(range(3), repeat=4):
        for length in (1, 1000):
            start = [*before, *(before[-1:] * length)]
            assert levels_of([*start, 2, 2, 2], 3, 5)[-1] == 2
            assert levels_of([*start, 0, 0, 0, 0, 0], 3, 5)[-1] == 0


def test_a_bad_first_look_is_neither_ok_nor_an_alarm_yet():
    assert levels_of([1, 0], 3, 5) == [1, 0]
    assert levels_of([1, 1, 1, 0], 3, 5) == [1, 1, 1, 1]


def test_never_ok_before_data_nor_on_a_bad_first_look():
    assert Alarm().level == Level.WARN and Alarm().lasted(5) == 0.0
    assert Alarm().update(Level.ERROR, 0) == Level.WARN
    assert Alarm().update(Level.WARN, 0) == Level.WARN
    assert Alarm().update(Level.OK, 0) == Level.OK  # the first look may clear "no data yet"


def test_a_doubt_takes_back_ok_alone():
    fine, broken = Alarm(3, 5), Alarm(1, 1)
    fine.update(Level.OK, 0)
    broken.update(Level.ERROR, 0)
    for alarm, level, next_level in ((fine, Level.WARN, Level.OK),
                                     (broken, Level.ERROR, Level.ERROR)):
        alarm.doubt()
        assert alarm.level == level and alarm.judged == (alarm is broken)
        assert (alarm.since_ns is None) == (alarm is fine)
        assert alarm.update(next_level, SECOND) == next_level


def test_message_fits_the_level_in_force():
    alarm, said = Alarm(3, 5), []
    good = Outcome.of(Level.OK, 'usual', {'v': 1})
    bad = outcome_of([GROSS.said()], None, {'v': 2})
    fine, broken = good.message, bad.message
    for k, outcome in enumerate([good, bad, bad, bad, bad, good, good, good, good, good]):
        shown = alarm.judge(outcome, k * SECOND)
        assert outcome.values.items() <= shown.values.items()  # always those of now
        said.append((int(shown.level), shown.message))
    assert said == [
        (0, fine), (0, fine), (0, fine), (2, broken),
        *5 * [(2, broken)], (0, fine)]
    alarm = Alarm(1, 1)
    alarm.judge(bad, 5 * SECOND)
    assert alarm.judge(bad, 17_400_000_000).values['lasts_s'] == 12.4
    assert alarm.lasted(0) == 0.0  # the clock was set back


def test_an_outcome_has_the_remedy_of_its_worst_condition():
    fine = Said('as_predicted')
    assert outcome_of([], fine, {}) == Outcome.of(Level.OK, 'as_predicted')
    found = outcome_of([OUTLIERS.said(), GROSS.said(), BIASED.said()], fine, {'x': 2})
    assert (found.level, found.values) == (Level.ERROR, {'x': 2})
    assert found.message == (
        'outliers, prediction errors much larger than predicted, prediction errors biased: do not '
        'trust tau_K; check the encoders first, then the model')


JOINED = [
    ((0, 0, 0), 0, 'a'), ((1, 0, 0), 1, 'a'), ((0, 1, 0), 1, 'b'), ((0, 1, 2), 2, 'c'),
    ((1, 0, 2), 2, 'c; a'), ((2, 1, 1), 2, 'b; a')]


def test_joined_outcomes_say_what_is_wrong_and_the_first_last():
    for levels, level, message in JOINED:
        outcomes = [Outcome.of(Level(n), 'as_written', {text: n}, text=text)
                    for n, text in zip(levels, 'abc')]
        one = joined(outcomes)
        assert (one.level, one.message, one.values) == (level, message, {'a': levels[0]})
