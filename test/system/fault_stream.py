# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Faults of the stream between source and estimator: what arrives, when, with which stamp.

Each fault takes the Messages of a healthy drive and gives those that arrive instead.
"""
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.parameters import PlantParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

START, LASTS, SECONDS = 15.37, 10.0, 45.0  # s: before the fault, with it, in all
SECOND = 1_000_000_000
T0 = 1_700_000_000 * SECOND
MOTOR, ARM = 0, 1
TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Messages:
    """
    N messages in the order in which they arrive.

    number int64 [N]: which measurement of the drive each carries; at [N] s: when it arrives;
    stamp_ns int64 [N]; u [N, 2] N m, y [N, 2] rad, see estimates.Samples.
    """

    number: np.ndarray
    at: np.ndarray
    stamp_ns: np.ndarray
    u: np.ndarray
    y: np.ndarray

    def take(self, rows):
        """Return the Messages `rows` (indices, slice or bool)."""
        return Messages(self.number[rows], self.at[rows], self.stamp_ns[rows], self.u[rows],
                        self.y[rows])

    def by_arrival(self, at):
        """Return the Messages in the order of `at` (s), when they arrive; ties keep theirs."""
        order = np.argsort(at, kind='stable')
        return replace(self, at=at).take(order)

    def during(self):
        """Return bool [N]: measured while the fault lasts."""
        return (self.at >= START - 1e-9) & (self.at < START + LASTS - 1e-9)

    def after(self):
        """Return bool [N]: measured since the fault began."""
        return self.at >= START - 1e-9


def healthy(rate=1000.0, seed=0, seconds=SECONDS):
    """Return (Messages, Trajectory) of the packaged drive, sampled at `rate` Hz."""
    plant, n = PlantParameters(), round(seconds * rate)
    noise = Noise(plant.process_noise, plant.measurement_noise)
    t = np.arange(n) / rate
    run = simulate(DriveModel(), Excitation().torque(t), 1.0 / rate, noise, seed)
    u = np.column_stack([run.u, np.full(n, np.nan)])
    return Messages(np.arange(n), t, T0 + np.round(t * SECOND).astype(np.int64), u, run.y), run


# ---------------------------------------------------------------------- messages

def lost(share):
    """Lose this share of the messages, each by itself."""
    def inject(m, random):
        return m.take(~(m.during() & (random.random(len(m.at)) < share)))
    return inject


def bursts(length, every):
    """Lose all messages of `length` s, `every` so many s."""
    def inject(m, _):
        return m.take(~(m.during() & (np.mod(m.at - START, every) < length)))
    return inject


def decimated(keep):
    """Let only one of `keep` messages come."""
    def inject(m, _):
        return m.take(~m.during() | (m.number % keep == 0))
    return inject


def copies(share, late=0.0):
    """Send this share of the messages twice, the copy `late` s later."""
    def inject(m, random):
        again = m.take(m.during() & (random.random(len(m.at)) < share))
        both = Messages(*(np.concatenate([getattr(m, name), getattr(again, name)])
                          for name in Messages.__dataclass_fields__))
        return both.by_arrival(np.concatenate([m.at, again.at + late]))
    return inject


def delayed_blocks(length, late, every):
    """Delay all messages of `length` s by `late` s, `every` so many s; the rest overtakes them."""
    def inject(m, _):
        held = m.during() & (np.mod(m.at - START, every) < length)
        return m.by_arrival(m.at + np.where(held, late, 0.0))
    return inject


def repeated_blocks(length, every):
    """Send all messages of `length` s once more, `every` so many s, right behind them."""
    def inject(m, _):
        again = m.take(m.during() & (np.mod(m.at - START, every) < length))
        both = Messages(*(np.concatenate([getattr(m, name), getattr(again, name)])
                          for name in Messages.__dataclass_fields__))
        return both.by_arrival(np.concatenate([m.at, again.at + length]))
    return inject


def swapped(share):
    """Let this share of the messages overtake the one before."""
    def inject(m, random):
        period = m.at[1] - m.at[0]
        early = m.during() & (random.random(len(m.at)) < share)
        return m.by_arrival(m.at - np.where(early, 1.5 * period, 0.0))
    return inject


def stalled(then_all):
    """Let nothing come while the fault lasts; `then_all`: the newest 2000 come at its end."""
    def inject(m, _):
        held = np.flatnonzero(m.during())
        if not then_all:
            return m.take(~m.during())
        at = m.at.copy()
        at[held] = START + LASTS
        keep = np.ones(len(at), bool)
        keep[held[:-2000]] = False  # the depth of the estimator's queue
        return replace(m, at=at).take(keep)
    return inject


# ---------------------------------------------------------------------- stamps

def clock(step, for_good=True):
    """Step the clock of the stamps by `step` s, for good or in every 100th message only."""
    def inject(m, _):
        wrong = m.after() if for_good else m.during() & (m.number % 100 == 0)
        return replace(m, stamp_ns=m.stamp_ns + np.where(wrong, round(step * SECOND), 0))
    return inject


def jittered(std):
    """Let the stamps miss the time of measurement by `std` s, at most three times that."""
    def inject(m, random):
        off = np.clip(random.standard_normal(len(m.at)), -3.0, 3.0) * std * m.during()
        return replace(m, stamp_ns=m.stamp_ns + np.round(off * SECOND).astype(np.int64))
    return inject


def stuck_stamps(to=None):
    """Let the stamps stand still, or be `to`, while the fault lasts."""
    def inject(m, _):
        wrong = m.during()
        value = m.stamp_ns[np.flatnonzero(wrong)[0] - 1] if to is None else to
        return replace(m, stamp_ns=np.where(wrong, value, m.stamp_ns))
    return inject


# ---------------------------------------------------------------------- values

def value(column, put, share=1.0):
    """Put `put` into `column` (MOTOR, ARM, 'both', 'torque') of this share of the messages."""
    def inject(m, random):
        wrong = m.during() & (random.random(len(m.at)) < share)
        u, y = m.u.copy(), m.y.copy()
        if column == 'torque':
            u[wrong, 0] = put
        elif column == 'both':
            y[wrong] = put
        else:
            y[wrong, column] = put
        return replace(m, u=u, y=y)
    return inject


def frozen(*columns):
    """Let these encoders stand still."""
    def inject(m, _):
        wrong, y = m.during(), m.y.copy()
        for column in columns:
            y[wrong, column] = y[np.flatnonzero(wrong)[0] - 1, column]
        return replace(m, y=y)
    return inject


def flipped(*columns, torque=False):
    """Turn the sign of these encoders, or of the torque."""
    def inject(m, _):
        wrong, u, y = m.during(), m.u.copy(), m.y.copy()
        for column in columns:
            y[wrong, column] *= -1.0
        if torque:
            u[wrong] *= -1.0
        return replace(m, u=u, y=y)
    return inject


def wrapped(*columns):
    """Let these encoders wrap to -pi .. pi, at a place that the motion passes."""
    def inject(m, _):
        wrong, y = m.during(), m.y.copy()
        centre = y[:, ARM].mean()
        for column in columns:
            y[wrong, column] -= TURN * (y[wrong, column] > centre)
        return replace(m, y=y)
    return inject


def zeroed(*columns, by=0.5):
    """Move the zero of these encoders by `by` rad, for good."""
    def inject(m, _):
        y = m.y.copy()
        for column in columns:
            y[m.after(), column] -= by
        return replace(m, y=y)
    return inject


def restarted(away, stamps_from=None, by=0.0):
    """Let the source be gone for `away` s; then stamps may begin anew, and encoders at `by`."""
    def inject(m, _):
        gone = m.after() & (m.at < START + away)
        back = m.at >= START + away
        m = zeroed(MOTOR, ARM, by=by)(m, None)
        if stamps_from is not None:
            first = m.stamp_ns[np.flatnonzero(back)[0]]
            m = replace(m, stamp_ns=np.where(
                back, m.stamp_ns - first + round(stamps_from * SECOND), m.stamp_ns))
        return m.take(~gone)
    return inject
