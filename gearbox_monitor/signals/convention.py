# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""How the values of a joint in a log become those of its description, as a user states it."""
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array

OPTION = '--convention'
ALL = 'all'
UNITS = {'deg': math.pi / 180.0, 'mrad': 1e-3, 'turns': 2.0 * math.pi, 'mm': 1e-3}
RULES = 'reversed, zero:RAD, effort:FACTOR, ' + ', '.join(UNITS)


@dataclass(frozen=True)
class Convention:
    """
    The reading of one joint: position = sign (unit logged - zero), torque = sign effort logged.

    reversed: the log counts the other way, so that sign is -1. zero: position, rad or m, that the
    log has where the description is at 0. unit: rad or m of one unit of the log. effort: N m or N
    of one unit of the effort; negative where its sign is turned against the position.
    """

    reversed: bool = False
    zero: float = 0.0
    unit: float = 1.0
    effort: float = 1.0

    @property
    def sign(self) -> float:
        """-1 where the log counts the other way."""
        return -1.0 if self.reversed else 1.0

    def position(self, logged: Array) -> Array:
        """Return positions or setpoints [N] as the description counts them."""
        return self.sign * (self.unit * logged - self.zero)

    def torque(self, logged: Array) -> Array:
        """Return efforts [N] as the description counts them."""
        return self.sign * self.effort * logged

    @property
    def rules(self) -> str:
        """The convention as the option takes it."""
        units = {value: word for word, value in UNITS.items() if word != 'mrad'}
        words = [*([units.get(self.unit, 'deg')] if self.unit != 1.0 else []),
                 *(['reversed'] if self.reversed else []),
                 *([f'zero:{self.zero:.4g}'] if self.zero else []),
                 *([f'effort:{self.effort:.4g}'] if self.effort != 1.0 else [])]
        return ','.join(words) or 'as-recorded'


AS_RECORDED = Convention()


def conventions_of(words: Iterable[str], joints: Sequence[str], option: str = OPTION
                   ) -> dict[str, Convention]:
    """
    Return {joint: Convention} of `words` JOINT=RULE[,RULE] of an option.

    Args:
        words: as a user writes them; JOINT may be `all`.
        joints: of the robot.
        option: what messages call it.

    Raises:
        InputError: no such joint or rule.
    """
    stated: dict[str, Convention] = {}
    for word in words:
        name, equals, rules = word.partition('=')
        if not equals or not rules:
            raise InputError(f'{option}: {word!r}, expected JOINT=RULE with a rule of {RULES}')
        if name not in (*joints, ALL):
            raise InputError(f'{option}: {name!r}, {unknown(name, (*joints, ALL))}')
        for joint in joints if name == ALL else (name,):
            convention = stated.get(joint, AS_RECORDED)
            for rule in rules.split(','):
                convention = _ruled(convention, rule, f'{option}: {word!r}')
            stated[joint] = convention
    return stated


def _ruled(convention: Convention, rule: str, where: str) -> Convention:
    """Return a convention with one more `rule`. Raises InputError."""
    word, _, number = rule.partition(':')
    if word == 'as-recorded' and not number:
        return convention
    if word == 'reversed' and not number:
        return replace(convention, reversed=True)
    if word in UNITS and not number:
        return replace(convention, unit=UNITS[word])
    if word in ('zero', 'effort'):
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if math.isfinite(value) and (word == 'zero' or value != 0.0):
            return replace(convention, zero=value) if word == 'zero' else replace(
                convention, effort=value)
    raise InputError(f'{where}: {rule!r}, expected a rule of {RULES}')
