# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Every limit that decides a diagnosis, with its reason.

CONTEST decides for drives and robots, THRESHOLDS a drive's verdict, STATEMENTS the words on its
values, SETTINGS the balance of a robot. Settings of an optimiser or of a numerical method, which
change how soon a fit arrives and not what counts as an answer, stand where they are used. "Blind
sets" are those of `benchmarks blind`.
"""
from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """
    Limits of the whole-robot diagnosis.

    Rows: grid Hz, fastest grid; hop s, distance of test functions; highest Hz, of test functions,
    and highest_share, of the log's rate; highest_servo Hz, where noise of the position is on both
    sides; bands Hz, edges: each has its own variance per joint.
    Motion: cut_off Hz, limits of the smoother; slow rad/s, below which friction is any torque up
    to Coulomb's; ramp s, half width of the mask's edges; presliding rad/s, no sign is sharper.
    Rate: least Hz, refused below; full Hz, from which all effects are tried; gap periods, and
    gap_seconds, after which a section ends; coincident periods, stamps closer than that are one.
    """

    grid: float = 200.0
    hop: float = 1.0
    highest: float = 10.0
    highest_share: float = 0.2
    highest_servo: float = 4.0
    bands: tuple[float, ...] = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.5, 7.5, 10.01)
    cut_off: tuple[float, float] = (4.0, 20.0)
    smoothed: float = 0.05       # of a motion that the smoother takes: faster rows are no evidence
    slow: float = 0.02
    ramp: float = 0.06
    presliding: float = 0.005
    least_rate: float = 30.0
    full_rate: float = 47.0      # a log of 50 Hz that loses a few samples is one of 50 Hz
    gap: float = 4.0
    gap_seconds: float = 0.1
    coincident: float = 0.3

    # Tolerances of a nominal file: relative, of masses, centres, inertias, friction and armature.
    tolerance: float = 0.05
    # With a reference: what a file may be off before the reference is learnt, and how much of the
    # torque (rms) friction of unknown shape may be.
    tolerance_learnt: float = 0.4
    tolerance_examined: float = 0.1  # of the file that references are held against
    learnt: float = 0.5
    armature_learnt: float = 1.0  # kg m^2 at 20 N m of rms torque, in proportion
    heaviest: float = 5.0        # kg, and farthest m: deviation of a load while a robot is learnt
    farthest: float = 0.2
    lag: float = 0.004           # s: the log's effort behind its positions, one of a recording
    lag_joint: float = 0.0015    # s: of one joint beside it; at least a quarter of the period
    creep: float = 0.03          # rad/s: friction of slower motion is any part of Coulomb's
    gain_tolerance: float = 0.2  # of servo gains
    torque_tolerance: float = 0.1  # of the scale of each joint's effort: currents were 18 % off
    # Another day: friction of a joint scales as a whole (temperature), and a little by column.
    drift: float = 0.10
    drift_own: float = 0.03
    drifted: float = 2.5         # such deviations: 1 joint in 80 by chance

    finalists: int = 10          # of a score test that are fitted
    rounds: int = 20             # of the dictionary of shapes, one per joint and round
    part: float = 10.0           # s: healthy parts whose scatter is measured
    shrink: float = 60.0         # rows' worth of belief that the spectrum of a residual is smooth
    floor: float = 3e-4          # no model is better than this part of its own torque
    bursts: float = 12.0         # energy of the worst tenth of segments over the median
    excess: float = 4.0          # energy over what healthy references leave: twice their rms
    visited: float = 0.8         # of a motion's samples near those of the reference
    # Times as far from the references as their own parts: random motions are at 1.1 to 2.5.
    farther: float = 3.0
    # One reference of less seconds does not tell how days differ: of the arms and pendulums on
    # which this was tried an effect by up to 1.5 % of the effort, and the margin doubles.
    short: float = 55.0
    day: float = 0.015
    # Sizes that a motion has to show: Coulomb friction, of the effort of a joint; a torque of half
    # its scale; a load, of the mass that carries.
    plausible_friction: float = 1.0
    plausible_gain: float = 0.5
    plausible_load: float = 0.25
    moving: float = 0.05         # of the time, from which a joint counts as moving
    unexplained: float = 0.5     # of a joint's effort: references that leave more teach nothing
    # Deviations by which no description of the robot, and no servo of its file, is off: chance
    # does not reach 5 in a hundred parameters.
    certain: float = 5.0
    # Zeros of encoders: pieces of a `part` that tell how a long log is read; effects that compete
    # with a zero; rad: a larger zero is another convention, and a log in which one might hide does
    # not show it; N m/rad: a smaller slope is rounding.
    pieces: int = 6
    zero_rivals: int = 12
    zero_shown: float = 0.2
    least_slope: float = 1e-6


SETTINGS = Settings()


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


@dataclass(frozen=True)
class ContestSettings:
    """
    What decides, and how wide the search is.

    margin: score by which a member must pay, and up to which hypotheses are rivals: a Bayes
    factor of e^3, strong evidence (Kass and Raftery, 1995). most: members.
    screened, further, confirmed: laws that are raced for the first member, for a further one, and
    where nothing but noise remains. starts: of each law in a race. finalists: of a race that are
    fitted to the end: a linear step underrates effects that are not linear. leaders: functions
    that are fitted. others: further first members from which the search starts again. close:
    share of the worth of the best, or of its own price, that a candidate needs at first to be
    followed further.
    """

    margin: float = 6.0
    most: int = 4
    screened: int = 12
    further: int = 6
    confirmed: int = 3
    starts: int = 2
    finalists: int = 3
    leaders: int = 2
    others: int = 2
    close: float = 0.5


CONTEST = ContestSettings()
