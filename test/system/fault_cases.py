# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The faults of faults.py, and how soon each has to be told."""
from dataclasses import dataclass

from fault_stream import (
    ARM, bursts, clock, copies, decimated, delayed_blocks, flipped, frozen, jittered, LASTS, lost,
    MOTOR, repeated_blocks, restarted, stalled, stuck_stamps, swapped, value, wrapped, zeroed)
import numpy as np

NAN = np.nan
# When a fault must be told, s after its begin. At once: with the next diagnostics but one.
# Statistics: a window of 2 s, three evaluations, and the second between two diagnostics.
AT_ONCE, STATISTICS = 2.0, 6.0
UNKNOWN_LOAD = 10.0  # where only torque over twist tells
# Hz: below, the packaged drive's torque changes too much from sample to sample for a random walk,
# and the prediction errors say so without a fault.
QUIET_FROM = 200.0


@dataclass(frozen=True)
class Case:
    """
    One fault.

    inject: see fault_stream. told: s within which a level must leave OK, and stay so until the
    end, or None: estimates stay right without. told_unknown: the same with an unknown load on the
    arm, where that differs. lasts: s, 0 = a moment. events: how many moments of it may cost
    samples beside those it spoils. rate: Hz.
    """

    name: str
    inject: object
    told: float | None = None
    told_unknown: float | None = None
    lasts: float = LASTS
    events: int = 1
    rate: float = 1000.0

    def limit(self, load):
        """Return within how many s it must be told with this arm_load, None: need not."""
        return self.told_unknown if load == 'unknown' and self.told_unknown else self.told

    def by_statistics(self, load):
        """Return whether estimates may be wrong under OK until it must be told."""
        return self.limit(load) in (STATISTICS, UNKNOWN_LOAD)

    @property
    def quiet(self):
        """Whether levels are OK without a fault."""
        return self.rate >= QUIET_FROM

    @property
    def moves_zero(self):
        """Whether positions count from another zero behind it."""
        return self.lasts < LASTS


def _healthy(messages, _):
    return messages


_MESSAGES = (
    Case('none', _healthy),
    Case('1 % of messages lost', lost(0.01), STATISTICS),
    Case('10 % lost', lost(0.1), STATISTICS),
    Case('50 % lost', lost(0.5), STATISTICS),
    Case('95 % lost', lost(0.95), AT_ONCE, events=100),
    Case('30 ms lost every second', bursts(0.03, 1.0), STATISTICS),
    Case('50 ms lost every second', bursts(0.05, 1.0), AT_ONCE, events=10),
    Case('0.5 s lost every 2 s', bursts(0.5, 2.0), AT_ONCE, events=5),
    Case('every 2nd message comes', decimated(2)),
    Case('every 20th comes', decimated(20), STATISTICS),
    Case('every 300th comes', decimated(300), AT_ONCE, events=2),
    Case('20 % come twice', copies(0.2), STATISTICS),
    Case('20 % again 5 ms later', copies(0.2, 0.005), STATISTICS),
    Case('20 ms again, every second', repeated_blocks(0.02, 1.0), STATISTICS),
    Case('10 % overtake the previous message', swapped(0.1), STATISTICS),
    Case('20 ms late by 50 ms, every second', delayed_blocks(0.02, 0.05, 1.0), STATISTICS),
    Case('100 ms late by 0.4 s, every 2 s', delayed_blocks(0.1, 0.4, 2.0), AT_ONCE, events=5),
    Case('stall of 10 s, all lost', stalled(False), AT_ONCE),
    Case('stall of 10 s, then all at once', stalled(True), AT_ONCE),
    Case('source gone for 3 s, same zero', restarted(3.0), AT_ONCE, lasts=3.0, events=100),
    Case('source gone for 3 s, new zero', restarted(3.0, by=0.5), AT_ONCE, lasts=3.0,
         events=100),
    Case('source gone for 3 s, stamps from 1 s', restarted(3.0, 1.0, 0.5), AT_ONCE, lasts=3.0,
         events=100),
)
_STAMPS = (
    Case('clock + 0.1 s', clock(0.1), AT_ONCE, lasts=0.0),
    Case('clock - 0.1 s', clock(-0.1), AT_ONCE, lasts=0.0),
    Case('clock + 1 h', clock(3600.0), AT_ONCE, lasts=0.0),
    Case('clock - 1 h', clock(-3600.0), AT_ONCE, lasts=0.0),
    Case('every 100th stamp + 0.1 s', clock(0.1, False), AT_ONCE, events=100),
    Case('every 100th stamp - 0.1 s', clock(-0.1, False), STATISTICS),
    Case('every 100th stamp + 10 s', clock(10.0, False), STATISTICS),
    Case('stamps stand still', stuck_stamps(), AT_ONCE),
    Case('stamps are 0', stuck_stamps(0), AT_ONCE),
    Case('stamps jitter by 0.2 ms', jittered(2e-4)),
)
_VALUES = (
    Case('motor NaN in 10 %', value(MOTOR, NAN, 0.1), STATISTICS),
    Case('both NaN in 10 %', value('both', NAN, 0.1), STATISTICS),
    Case('torque NaN in 10 %', value('torque', NAN, 0.1), STATISTICS),
    Case('motor inf in 1 %', value(MOTOR, np.inf, 0.01), STATISTICS),
    Case('torque -inf in 1 %', value('torque', -np.inf, 0.01), STATISTICS),
    Case('motor 1e300 in 1 %', value(MOTOR, 1e300, 0.01), STATISTICS),
    Case('torque 1e300 in 1 %', value('torque', 1e300, 0.01), STATISTICS),
    Case('arm 1e4 in 0.1 %', value(ARM, 1e4, 0.001), events=10),
    Case('motor 3 rad in 0.1 %', value(MOTOR, 3.0, 0.001), events=10),
    Case('torque 1e6 in 0.1 %', value('torque', 1e6, 0.001), AT_ONCE, events=10),
)
_ENCODERS = (
    Case('motor missing', value(MOTOR, NAN), STATISTICS),
    Case('arm missing', value(ARM, NAN), STATISTICS),
    Case('both missing', value('both', NAN), AT_ONCE, events=100),
    Case('motor frozen', frozen(MOTOR), STATISTICS),
    Case('arm frozen', frozen(ARM), STATISTICS),
    Case('both frozen', frozen(MOTOR, ARM), STATISTICS),
    Case('motor wraps at 2 pi', wrapped(MOTOR), AT_ONCE, events=40),
    Case('arm wraps', wrapped(ARM), AT_ONCE, events=40),
    Case('both wrap', wrapped(MOTOR, ARM), AT_ONCE, events=40),
    Case('new zero of the motor', zeroed(MOTOR), AT_ONCE, lasts=0.0),
    Case('new zero of the arm', zeroed(ARM), AT_ONCE, lasts=0.0),
    Case('new zero of both', zeroed(MOTOR, ARM), AT_ONCE, lasts=0.0),
    Case('sign of the motor', flipped(MOTOR), AT_ONCE, events=2),
    Case('sign of the arm', flipped(ARM), AT_ONCE, events=2),
    Case('sign of both', flipped(MOTOR, ARM), AT_ONCE, events=2),
)
_TORQUE = (
    Case('torque missing', value('torque', NAN), AT_ONCE, events=100),
    Case('torque is 0', value('torque', 0.0), STATISTICS, UNKNOWN_LOAD),
    Case('sign of the torque', flipped(torque=True), STATISTICS, UNKNOWN_LOAD),
)


def _at_other_rates():
    for rate in (50.0, 100.0, 250.0, 500.0, 2000.0, 4000.0):
        yield Case(f'none, {rate:g} Hz', _healthy, rate=rate)
        yield Case(f'motor missing, {rate:g} Hz', value(MOTOR, NAN), STATISTICS, rate=rate)
        yield Case(f'new zero of the motor, {rate:g} Hz', zeroed(MOTOR), AT_ONCE, lasts=0.0,
                   rate=rate)
        yield Case(f'0.1 s lost every 2 s, {rate:g} Hz', bursts(0.1, 2.0), AT_ONCE, events=5,
                   rate=rate)


CASES = (*_MESSAGES, *_STAMPS, *_VALUES, *_ENCODERS, *_TORQUE, *_at_other_rates())
