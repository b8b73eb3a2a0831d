# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The verdict of a diagnosis: findings, each an effect with its values, and a remainder.

One definition for one joint and for a robot: no finding and no remainder is `none`; findings
alone are an `effect`; findings beside a remainder are `incomplete`; a remainder alone is
`unknown`.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

NONE, EFFECT, INCOMPLETE, UNKNOWN = 'none', 'effect', 'incomplete', 'unknown'
KINDS = (NONE, EFFECT, INCOMPLETE, UNKNOWN)


@dataclass(frozen=True)
class Finding:
    """
    One effect that a recording shows.

    effect: its id. place: location class of the effect (actuator, motor_side, ...). joint, link:
    of a robot. channel: reading that shows it. values: parameters in their units. deviations: the
    standard deviation of each value, None where the recording does not determine it. share: of
    the squared misfit beyond noise that it explains, 0 to 1, None where none is beyond noise.
    evidence: 2 log likelihood that it gains less the penalty of its parameters (BIC).
    confusable: ids that explain the recording as well.
    """

    effect: str
    place: str
    values: Mapping[str, float]
    deviations: Mapping[str, float | None]
    evidence: float | None
    share: float | None = None
    channel: str | None = None
    joint: str | None = None
    link: str | None = None
    confusable: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, 'values', MappingProxyType(dict(self.values)))
        object.__setattr__(self, 'deviations', MappingProxyType(dict(self.deviations)))

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the values that the recording does not determine."""
        return tuple(name for name in self.values if self.deviations.get(name) is None)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; joint and link only where there is one."""
        data: dict[str, Any] = {
            'effect': self.effect, 'place': self.place, 'channel': self.channel,
            'values': dict(self.values), 'deviations': dict(self.deviations),
            'share': self.share, 'evidence': self.evidence, 'confusable': list(self.confusable)}
        return data | {key: value for key, value in (('joint', self.joint), ('link', self.link))
                       if value is not None}


@dataclass(frozen=True)
class Remainder:
    """
    What no finding explains.

    place: location class where a torque or an offset takes it up. channel: reading that shows it
    most, of size `size` there (rms beyond noise, in the unit of the reading). over: variable of
    the motion that it follows, None where it follows none. times: (begin, end) of bursts, s, each
    in the recording of the same place in `recordings`, which is empty where there is only one.
    """

    place: str
    channel: str | None = None
    size: float | None = None
    over: str | None = None
    joint: str | None = None
    times: tuple[tuple[float, float], ...] = ()
    recordings: tuple[str, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; joint, times and recordings only where there are any."""
        data: dict[str, Any] = {'location': self.place, 'place': self.place,
                                'channel': self.channel, 'size': self.size, 'over': self.over,
                                **self.figures}
        if self.joint is not None:
            data['joint'] = self.joint
        if self.times:
            data['times'] = [list(pair) for pair in self.times]
        if self.recordings:
            data['recordings'] = list(self.recordings)
        return data


def kind_of(findings: bool, remainder: bool) -> str:
    """
    Return the kind of a verdict.

    Args:
        findings: whether it has findings.
        remainder: whether something beyond noise remains.
    """
    return ((NONE, UNKNOWN), (EFFECT, INCOMPLETE))[findings][remainder]
