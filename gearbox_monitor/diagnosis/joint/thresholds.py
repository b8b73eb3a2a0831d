# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Thresholds of the verdict, each with what it means: what decides stands here or is CONTEST.margin.

Settings of an optimiser or of a numerical method, which change how soon a fit arrives and not what
counts as an answer, stand where they are used. "Blind sets" are those of `benchmarks blind`.
"""
from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """Limits that decide a verdict, beside the margin of the contest."""

    # Torque noise over the torque: more is an error of the model, not of an actuator.
    torque_noise: float = 0.1
    # Lasting unexplained torque over the torque, on a real drive: more is an unknown effect.
    lasting_torque: float = 0.2
    # Step of a lattice of readings over their noise: below, rounding adds 1 % to the noise.
    lattice: float = 0.5
    # The same for noise that is no longer white: the step spans one deviation to either side.
    rough_lattice: float = 2.0
    # chi2 per reading of a window that lacks nothing: error of the noise level, and chance in 1 s.
    quiet: float = 1.12
    # Time between bursts in the range that a quantity has during them, over the time of bursts: if
    # a few bursts come at times of their own, it is many times as long.
    followed: float = 0.5
    # s, of one burst where it is found: what overlapping windows find so near is the same burst.
    longest_burst: float = 0.24
    # Median deviations of the zero of the twist, beyond which a step of it is none by chance.
    step: float = 6.0
    # Where something has no known cause, a finding explains at least this share of the squared
    # misfit that the largest finding explains in free runs: a tenth of the misfit.
    idle: float = 0.01
    # 2 log likelihood between distinguishable effects: a Bayes factor of e^10.
    isolable: float = 20.0
    # The same over the evidence where much lasts that no model explains: real drives.
    isolable_share: float = 0.1
    # Misfit of free runs from which on the residual is as large as the noise: sqrt(1 + 1).
    misfit: float = 1.4142
    # Share of a drive's torque, gain or twice its inertia that a motion has to show, or else
    # finding nothing says nothing.
    plausible: float = 0.5
    # Rate (Hz) below which the reading of torque between stamps is open: from 200 on, less what
    # stamps wander, half a sample is within other tolerances.
    slow_rate: float = 198.0


@dataclass(frozen=True)
class Statements:
    """Limits of what is said about values; they decide no verdict."""

    # Deviations by which fourth differences may miss the level of the innovations: chance goes
    # beyond once in 16 000 recordings.
    noise_level: float = 4.0
    # Gap from which on a closed fraction is stated: below, the error of the noise is as large.
    gap: float = 1.02
    # Logarithm of the ratio of sharpnesses from which on the verdict mentions it: a fifth.
    shape: float = 0.2
    # Standard error of the logarithm of a value that counts as determined: a third of it.
    determined: float = 0.3
    # Standard error over a value from which on the recording does not determine it.
    undetermined: float = 1.0
    # Misfit over that of the model file that is no worse: two deviations of it in 10 s.
    no_worse: float = 1.01
    # chi2 per reading up to which a residual counts as encoder noise: beyond, neighbouring
    # readings say the same, so that a window counts as one.
    encoder_noise: float = 1.5
    # Correlation of two values that are hardly distinguishable: 10 % of each is its own.
    correlated: float = 0.95


THRESHOLDS, STATEMENTS = Thresholds(), Statements()
