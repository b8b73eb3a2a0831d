# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Thresholds of the verdict, each with what it means: what decides stands here and nowhere else.

Settings of an optimiser or of a numerical method, which change how soon a fit arrives and not what
counts as an answer, stand where they are used. "Blind sets" are those of `benchmarks blind`: true
answers must stay on the one side of a threshold, wrong ones on the other. A comment without a
measurement says what the number means.
"""
from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """
    Limits that decide a verdict.

    Gains are in BIC or -2 log L, excesses in chi2 per reading, structures in standard deviations
    of the power in a frequency band.
    """

    # --- Selection
    # Gain of one effect over none: the best of some 35 effects gains up to 10 by chance.
    effect_gain: float = 25.0
    # Gain of a value with a tolerance: four standard deviations of one number.
    scatter_gain: float = 16.0
    # Gain of a parameter that sits at its bound: chance gives the best effect as much.
    bound_gain: float = 10.0
    # Gain of a further effect: more than effect_gain, since some 600 pairs are searched.
    further_effect_gain: float = 40.0
    # BIC up to which fits tie: twice the gain for which a fit does not go on.
    tie: float = 1.0
    # -2 log L by which windows, which carry more evidence, may turn a ranking round: blind sets.
    ranking_error: float = 60.0

    # --- Adequacy
    # -2 log L of torque noise beyond what is allowed: as an effect, which it stands for.
    noise_gain: float = 25.0
    # Probability that the best of all free functions of the motion gains as much by chance.
    chance: float = 1e-4
    # Misfit of free runs from which on the residual is as large as the noise: sqrt(1 + 1).
    misfit: float = 1.4142
    # Structure of a right model: at most 2.7 of white noise in 300 simulated recordings.
    structure: float = 3.8
    # The same where torque noise was taken out, which is right to first order only.
    noisy_structure: float = 6.0
    # Structure beside an encoder with steps above its noise: rounding is not white.
    rough_structure: float = 30.0
    # Torque noise over the torque: more is an error of the model, not of an actuator.
    torque_noise: float = 0.1
    # Lasting unexplained torque over the torque, on a real drive: more is an unknown effect.
    lasting_torque: float = 0.2
    # Step of a lattice of readings over their noise: below, rounding adds 1 % to the noise.
    lattice: float = 0.5
    # The same for noise that is no longer white: the step spans one deviation to either side.
    rough_lattice: float = 2.0
    # Correlation of coloured noise: below, its power at rest is that of white noise within 16 %.
    correlation: float = 0.15
    # Distance of a spectrum from that of first-order noise, rms of log power: blind sets.
    colour: float = 0.15

    # --- Bursts
    # chi2 per reading of a window that lacks nothing: error of the noise level, and chance in 1 s.
    quiet: float = 1.12
    # Share of the windows without a burst: what is in most of them is no rare event.
    quiet_share: float = 0.35
    # chi2 by which a torque at another place may explain bursts better: true ones, up to 10.
    elsewhere: float = 50.0
    # Share of a burst that a law of the motion foretells from the others: 29 of 30 simulated sets
    # of bursts at times of their own have 0.3 at most. Of eleven sets that follow a threshold of
    # the motion six have 0.54 and more; the other five pass for bursts.
    burst_law: float = 0.4
    # Probability that bursts meet the ends of travel by chance: 1 %.
    burst_chance: float = 0.01
    # Share of bursts that a steady oscillation explains: of true ones 0.3 at most.
    burst_sine: float = 0.6

    # --- Place
    # Ratio of what free signals leave at places that tie: the deviation of chi2 in 10 s.
    place_tie: float = 1.01
    # Share of a free torque that the command explains if the actuator is its cause: blind sets.
    command_share: float = 0.1

    # --- Isolability
    # 2 log likelihood between distinguishable effects: a Bayes factor of e^10.
    isolable: float = 20.0
    # The same over the evidence where much lasts that no model explains: real drives.
    isolable_share: float = 0.1

    # --- Statement
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
    # Rate (Hz) below which the reading of torque between stamps is open: from 200 on, less what
    # stamps wander, half a sample is within other tolerances.
    slow_rate: float = 198.0
    # BIC that a further turn of reading and fitting has to gain.
    reading_gain: float = 1.0
    # Correlation of two values that are hardly distinguishable: 10 % of each is its own.
    correlated: float = 0.95


THRESHOLDS = Thresholds()
