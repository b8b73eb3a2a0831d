# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A finding about a recording: how good it is for each purpose, and the limits that decide it.

All limits of findings are here. Grids of a search and numbers of rows that are fitted, which
change how accurate a measure is and not what counts as wrong, stand where they are used.
Deviations are standard deviations.
"""
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
import enum
from types import MappingProxyType
from typing import Any

from gearbox_monitor.presentation import on_axis, Said


@dataclass(frozen=True)
class RecordingLimits:
    """Limits that decide a finding, a repair or a refusal."""

    # --- Stamps
    # Samples without which nothing is examined.
    min_samples: int = 100
    # Hz of estimation, 1 % apart: below, the resonance is missed; above, a second is too much.
    slowest: float = 100.0
    fastest: float = 2000.0
    # Hz below which nothing of a drive's motion is left.
    least_rate: float = 20.0
    # Hz of diagnosis.
    diagnosis_slowest: float = 30.0
    diagnosis_fastest: float = 4000.0
    # Hz from which on positions that are held over rows are late by little.
    held_rate: float = 200.0
    # Share of samples: unusable stamps that nothing should rest on; at least known, or alive.
    least_share: float = 0.05
    # Jitter over the period that is worth a word; beyond the period it is no clock.
    jitter_notice: float = 0.1
    # Share of samples that are lost: worth a word. Lost, or without a value: too many.
    lost_notice: float = 0.001
    lost_many: float = 0.1
    # Windows of drift that are few.
    drift_windows_few: int = 6
    # Changes of a value that show a rhythm; messages of one side alone.
    least_changes: int = 50
    # Share of changes that come in one rhythm, if values are held.
    held: float = 0.8
    # Spread of steps over their size: steps of a lattice are all of one size.
    uneven: float = 0.3
    # Of the mean step: messages that came at once; their share that makes it bursts.
    at_once: float = 0.25
    bursts: float = 0.4
    # Times the longest usual step.
    dropout: float = 3.0
    # s: stamps farther ahead are another run, where no estimator says it and if they stay there; a
    # torque on one value sticks.
    max_gap: float = 0.25

    # --- Repair of a recording
    # s: four windows of the gap metric; of motion; where the ends of the twist are taken. Below
    # twice as many, few remain for validation.
    min_duration: float = 4.0
    # s of a recording that a diagnosis or fit of one drive uses at most. At 1 kHz, each takes half
    # a CPU second and 14 MB; 60 of them show a change of a value by 0.1 %.
    longest: float = 60.0
    # Share of the largest travel from which on a newer stretch is preferred.
    far: float = 0.8
    # Share of samples that may be interpolated; more is worth a word.
    max_repaired: float = 0.01
    # Samples in a row that may be interpolated: below the drive's own periods.
    max_run: int = 3
    # Relative difference of rates up to which recordings are brought to one.
    rates_alike: float = 0.1
    # s over which stamps are averaged: longer than what makes single ones late.
    wander_span: float = 0.2
    # Jitter (rms) of a sample time: stamps rounded by a computer, as good as even.
    quiet_jitter: float = 0.01
    # Robust deviations off its neighbours of a wild reading.
    spike: float = 12.0

    # --- Encoders
    # Factor between noise and parameter that the indicators of trust notice.
    noise_off: float = 1.3
    # Share of the swing of the twist that counts: of a step of the lattice, of a slip.
    swing_share: float = 0.1
    # Samples in a row on one and the same reading that are looked at; lost, that are not bridged.
    stuck_samples: int = 10
    # Of the travel: backlash of a drive whose model may have none.
    own_play: float = 0.05

    # --- Motion
    # Noise over motion of the acceleration that is wanted.
    acceleration_noise: float = 0.15
    # Travel in deviations of the noise: a drive that moves.
    travel: float = 10.0
    # Share of the top speed that counts as standing.
    slow_share: float = 0.02
    # Share of half the swing of the twist, or of the half gap, where a flank begins.
    flank: float = 0.7
    # Factor near to 1, either way: travel of the arm over that of the motor that needs no gear
    # ratio; an error of the model, no current; a known unit.
    near: float = 1.5
    # A slip over what motion and load move: the scatter of the ends of the twist, the swing that a
    # change of the mean torque explains, the change of the swing.
    slip: float = 2.0
    # Condition number of acceleration, speed, friction and offset that counts as excited.
    excited: float = 30.0

    # --- Torque
    # Samples in a row on the extreme; share of all that are a relay.
    limit_samples: int = 5
    relay_share: float = 0.7
    # Share of the samples with a torque on its limits, or stuck, that is worth a word.
    stuck_share: float = 0.02
    # Share of changes from sample to sample elsewhere: a torque that keeps a value sticks.
    lively: float = 0.5
    # Noises that the drive moves meanwhile.
    stuck_travel: float = 50.0
    # Correlation with the acceleration from which on the torque is seen in it.
    torque_seen: float = 0.3
    # Samples: what the low pass and a controller's feedback leave in the delay.
    delay_method: float = 0.15
    # Of |u dx|: net work that has a sign.
    work: float = 0.05
    # Deviations from which on a torque, or the sign of the twist, is called wrong, a twist is
    # seen, a joint moves and a step is longer than a late stamp makes it.
    certain: float = 5.0
    # Share of a position that follows its setpoint, and of its slope of 1.
    setpoint_share: float = 0.05
    # s that a position is behind its setpoint at most.
    behind: float = 0.5
    # Correlation of a position with its setpoint, at least.
    follows: float = 0.5
    # Times the motion: the setpoint is in another unit.
    other_unit: float = 5.0

    # --- What effort and model say of each other
    # Share of the torque's power that no drive like the model leaves; the same, worth a word.
    implausible: float = 5.0
    strange: float = 0.5
    # Log likelihood ratio from which on another kind of effort is better: e^5.
    effort_ratio: float = 5.0
    # Share of the torque's power that models leave, of torque and of twist.
    torque_accuracy: float = 0.01
    twist_accuracy: float = 0.03
    # Independent samples at most: the error of a model does not average out.
    model_samples: float = 20.0
    # Relative deviation expected of inertias and stiffness; friction and offset have any size.
    effort_model: float = 0.2
    # Times, or part, of the model's inertias and stiffness that a drive may have.
    loose: float = 3.0
    # Share of the power that an accepted reading leaves at most.
    explained: float = 0.12
    # Log likelihood ratio by which another reading of the recording must be better; odd factors
    # are many, which costs a fit more.
    margins: Mapping[str, float] = field(default_factory=lambda: MappingProxyType(
        {'signs': 15.0, 'swapped': 15.0, 'usual': 15.0, 'odd': 20.0}))


LIMITS = RecordingLimits()


PURPOSES = ('estimation', 'drift', 'diagnosis')


class Grade(enum.IntEnum):
    """How good something is; the worst counts."""

    OK = 0
    WARN = 1
    BAD = 2


OK, WARN, BAD = Grade.OK, Grade.WARN, Grade.BAD


# Faults with which the diagnosis refuses a recording.
FATAL = frozenset({'not_finite', 'rate', 'too_short', 'clipped', 'frozen', 'unexcited'})


@dataclass(frozen=True)
class DataFinding:
    """
    One finding.

    group, name: of its line; says: what was found, as codes of the table of sentences with their
    numbers; hurts {purpose: Grade}: what it spoils, purposes that are not named are fine;
    values {name: number}: for programs, SI units; fault: of a recording, by which the diagnosis
    refuses it, '' where nothing is spoilt; axis: of the drive; open: nothing could be judged, so
    that its line is no OK.
    """

    group: str
    name: str
    says: tuple[Said, ...]
    hurts: dict[str, Grade] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)
    fault: str = ''
    axis: str = 'rotary'
    open: bool = False

    @property
    def figure(self) -> str:
        """What was found, in words with units."""
        words = ''.join(map(str, self.says)).removeprefix(f'{self.group}: ')  # its line has it
        return on_axis(words, self.axis)

    @property
    def advice(self) -> str:
        """What to do next, '' where nothing is spoilt."""
        remedies = (said.remedy for said in self.says) if self.hurts else ()
        return on_axis(next(filter(None, remedies), ''), self.axis)

    @property
    def text(self) -> str:
        """The finding as a sentence: figure and advice."""
        return f'{self.figure}: {self.advice}' if self.advice else self.figure

    @property
    def fatal(self) -> bool:
        """Whether a verdict would be about the recording, not about the drive."""
        return self.fault in FATAL

    def verdict(self, purposes: Iterable[str] = PURPOSES) -> Grade:
        """Return the worst Grade for any of `purposes`."""
        return max((self.hurts.get(purpose, OK) for purpose in purposes), default=OK)

    def verdict_word(self, purposes: Iterable[str] = PURPOSES) -> str:
        """Return the verdict for `purposes` in a word, - for what could not be judged."""
        return '-' if self.open else self.verdict(purposes).name.lower()


def hurts(estimation: Grade = OK, drift: Grade = OK, diagnosis: Grade = OK) -> dict[str, Grade]:
    """
    Return {purpose: Grade} of what is not fine.

    Args:
        estimation: grade for estimation.
        drift: grade for drift.
        diagnosis: grade for the diagnosis.
    """
    grades = dict(zip(PURPOSES, (estimation, drift, diagnosis)))
    return {purpose: verdict for purpose, verdict in grades.items() if verdict > OK}


def everything(verdict: Grade) -> dict[str, Grade]:
    """Return {purpose: `verdict`} for all purposes."""
    return hurts(*(verdict for _ in PURPOSES))


def judged(group: str, name: str, says: Said | tuple[Said, ...],
           grades: dict[str, Grade] | None = None, values: dict[str, Any] | None = None,
           fault: str = '') -> DataFinding:
    """
    Return a DataFinding, with the fault only where something is spoilt.

    Args:
        group: of the finding.
        name: of the finding.
        says: what was found.
        grades: what it spoils, None or {} for nothing.
        values: for programs.
        fault: of the recording.
    """
    return DataFinding(group, name, (says,) if isinstance(says, Said) else says, grades or {},
                       values or {}, fault if grades else '')
