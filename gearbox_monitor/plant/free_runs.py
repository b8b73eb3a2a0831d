# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Free runs of the drive over windows of a recording, one after the other; see batch, too."""
from typing import NamedTuple

from gearbox_monitor.kernels.kernel import entry
from gearbox_monitor.kernels.types import Cube, Integers, Matrix
from gearbox_monitor.plant.effects.composition import reading
from gearbox_monitor.plant.simulate import advance, N_STATE, PackedDrive, ProcessNoise


class RunSpans(NamedTuple):
    """
    Windows of one length in a recording, in samples.

    first: first sample of each window [W]; length: of all; begin: where its run starts [W], a
    little earlier, so that delayed readings have a past; carry_at: where the next begins [W];
    extra_at: row of Driving.extra where each begins [W], so that windows may overlap and still be
    driven each by its own torque from outside.
    """

    begin: Integers
    first: Integers
    length: int
    carry_at: Integers
    extra_at: Integers


class Begin(NamedTuple):
    """Where runs begin: states [W, 4] (rad, rad/s) and memories [W, N_MEMORY]."""

    states: Matrix
    memory: Matrix


class Driving(NamedTuple):
    """
    What drives a recording of N samples.

    u: torque of the actuator [N, n] in each of n substeps, N m. extra: torque from outside [M, 3]
    on motor, arm and in the transmission, N m. dt: length of a sample, s.
    """

    u: Matrix
    extra: Matrix
    dt: float


class RunResult(NamedTuple):
    """Room for readings y [W, L, 2] and for states where the next window begins [W, N_STATE]."""

    y: Cube
    carry: Matrix


@entry
def free_runs(spans: RunSpans, start: Begin, driving: Driving, drive: PackedDrive,
              noise: ProcessNoise, rows: Matrix, result: RunResult) -> None:
    """
    Run windows one after the other.

    Args:
        spans: the windows.
        start: where they begin.
        driving: what acts on the drive.
        drive: PackedDrive.
        noise: ProcessNoise of a sample, without any: numbers [1, n, 4] and std [4] are 0.
        rows: room to work in [longest run + 1, N_STATE].
        result: is filled in.
    """
    begin, first, length, carry_at, extra_at = spans
    u, extra, dt = driving
    y, carry = result
    for w in range(len(begin)):
        state = rows[0]
        for i in range(4):
            state[i] = start.states[w, i]
        for i in range(N_STATE - 4):
            state[4 + i] = start.memory[w, i]
        path = rows[1:]
        lead = first[w] - begin[w]
        for k in range(begin[w], first[w] + length):
            for i in range(N_STATE):
                path[k - begin[w], i] = state[i]
            if k == carry_at[w]:
                for i in range(N_STATE):
                    carry[w, i] = state[i]
            row = extra[extra_at[w] + k - begin[w]]
            external = (row[0], row[1], row[2])
            advance(state, k * dt, dt, u[k], external, (noise.numbers[0], noise.std), drive,
                    0.0)
        if carry_at[w] == first[w] + length:
            for i in range(N_STATE):
                carry[w, i] = state[i]
        for k in range(length):
            y[w, k, 0] = reading(path, lead + k, 0, dt, drive.e)
            y[w, k, 1] = reading(path, lead + k, 1, dt, drive.e)
