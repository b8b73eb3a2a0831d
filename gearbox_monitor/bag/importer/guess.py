# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Propose the mapping of a foreign recording from names, units and the motion itself.

Names and units say what a column may be. The motion decides between candidates and gives signs and
units: a velocity is the derivative of a position; two encoders of one drive move together; an
effort follows acceleration, velocity and its sign, and does work against friction on the whole.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import re
from typing import Any

import numpy as np
import yaml

from gearbox_monitor.bag.importer.clocks import motion_regressors, unexplained
from gearbox_monitor.bag.importer.header import with_settings
from gearbox_monitor.bag.importer.layout import recognised_layout, Series
from gearbox_monitor.bag.importer.mapping import (
    ImportMapping, mapping_from_dict, SIGNALS, TimeMapping)
from gearbox_monitor.bag.importer.stamp_policy import absolute_ns, LONGEST, SHORTEST
from gearbox_monitor.bag.importer.unit_table import (
    ANGLE, ANGULAR_SPEED, COUNT_RATE, COUNTS, DRIVE_INPUT, FORCE, LENGTH, SPEED, TIME, TORQUE,
    unit_factor)
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array

WORDS = {
    'time': 't time timestamp stamp stamps sec secs seconds ms us ns clock elapsed zeit when '
            'epoch date datetime',
    'position': 'position positions pos angle angles theta phi q qm encoder enc counts winkel '
                'lage',
    'velocity': 'velocity velocities vel speed dq qd qdot omega rpm geschwindigkeit drehzahl',
    'effort': 'torque torques tau trq effort current curr cur amps force moment load pwm duty '
              'voltage u i iq drehmoment kraft strom',
    'motor': 'motor mot m rotor input drive servo',
    'arm': 'arm link output out load abtrieb l',
    'sensor': 'sensor transducer loadcell reference ref ext external',
    'command': 'command cmd commanded',
    'setpoint': 'goal target desired des setpoint sp',
    # Not measured, or not of the drive.
    'none': 'goal target desired des setpoint sp trajectory temp temperature status error err '
            'mode enable enabled id index seq volts volt count',
}
_WORDS = {kind: frozenset(words.split()) for kind, words in WORDS.items()}
UNITS = {
    'position': {**ANGLE, **LENGTH, **COUNTS},
    'velocity': {**ANGULAR_SPEED, **SPEED, **COUNT_RATE},
    'effort': {**TORQUE, **FORCE, **DRIVE_INPUT},
}
EPOCH = 1_000_000_000_000_000_000  # ns: a stamp from 2001 on is a date
SAME_MOTION = 0.98  # share of the variance that one encoder explains of the other
DERIVATIVE = 0.7  # share of a velocity that the derivative of a position explains
FOLLOWS = 0.3  # share of an effort that the motion explains
COARSE = 100.0  # whole numbers over a wider range are counts
SMOOTHER = 0.3  # path length of a decoded integer to that of the raw one
CODINGS = (('twos_complement', 16), ('twos_complement', 32), ('sign_magnitude', 11),
           ('sign_magnitude', 16))


@dataclass(frozen=True)
class Guess:
    """A proposed mapping: plain `data`, what it assumes, and where it comes from."""

    source: str
    data: Mapping[str, Any]
    assumptions: tuple[str, ...]

    @property
    def yaml_text(self) -> str:
        """Return the mapping as a file, its assumptions as comments."""
        lines = [f'# {line}' for line in (f'Proposed for {self.source}.', *self.assumptions)]
        return '\n'.join(lines) + '\n' + yaml.safe_dump(
            dict(self.data), sort_keys=False, default_flow_style=None, allow_unicode=True)

    def mapping(self) -> ImportMapping:
        """Return the checked mapping. Raises InputError: a value could not be guessed."""
        try:
            return mapping_from_dict(self.data, f'guess of {self.source}', self.yaml_text)
        except InputError as error:
            raise InputError(*(f'{line} (--set KEY=VALUE)' for line in error.args)) from None


@dataclass(frozen=True)
class Motion:
    """The position that all others are compared with, at times `t` in s."""

    t: Array
    position: Array

    @property
    def velocity(self) -> Array:
        """Return the derivative of the position over some 10 samples."""
        velocity: Array = motion_regressors(self.t, self.position, False)[:, 1]
        return velocity

    def explained(self, values: Array, is_position: bool = False) -> float:
        """Return the share of the variance of `values` that the motion explains."""
        valid = np.isfinite(values)
        if valid.sum() < 10 or np.ptp(values[valid]) == 0.0:
            return 0.0
        regressors = motion_regressors(self.t, self.position, is_position)
        return 1.0 - unexplained(self.t, regressors, self.t[valid], values[valid])


def guessed_mapping(path: str | Path, settings: Sequence[str] = ()) -> Guess:
    """
    Return the Guess of a mapping for the file `path`.

    `settings` are ``KEY=VALUE`` that replace what is proposed. Raises InputError: the file has no
    time or no motion that can be recognised.
    """
    layout = recognised_layout(path)
    assumptions: list[str] = []
    data: dict[str, Any] = {**layout.blocks}
    time, t, data['time'] = _time(path, layout.series, settings, assumptions)
    columns = [column for column in layout.series if column is not time
               and column.values.dtype.kind in 'iuf' and np.isfinite(column.values).any()
               and np.nanmax(column.values) > np.nanmin(column.values)]
    decoded = {id(column): _decoded(column, assumptions) for column in columns}
    signals = _signals(path, columns, decoded, t, assumptions)
    kind = 'prismatic' if 'kind=prismatic' in settings or any(
        column.unit in {**LENGTH, **FORCE} for column in signals.values()) else 'rotary'
    data['kind'] = kind
    _note_units(signals, kind, assumptions)
    blocks = {name: _block(name, column, decoded[id(column)][1])
              for name, column in signals.items()}
    _complete(data, blocks, signals, {name: decoded[id(column)][0]
                                      for name, column in signals.items()}, (t, settings),
              assumptions)
    data['signals'] = blocks
    unused = [column.label for column in layout.series
              if column is not time and column not in signals.values()]
    if unused:
        assumptions.append(f'Not used: {", ".join(unused)}.')
    return Guess(Path(path).name, with_settings(data, settings), tuple(assumptions))


def _words(label: str) -> set[str]:
    """Return the words of a name: 'motorPos_rad' is motor, pos and rad."""
    plain = re.sub(r'[\[(<{][^\])>}]*[\])>}]', ' ', label)
    return {word.lower() for word in re.findall(
        r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])', plain)} | {plain.strip().lower()}


def _is(kind: str, column: Series) -> bool:
    """Return whether name or unit of `column` says that it is of a `kind` of WORDS."""
    words = _words(column.label)
    if kind == 'command':  # a commanded torque is what is asked for
        return bool(words & _WORDS[kind]) and not (
            column.unit in {**TORQUE, **FORCE} or words & {'torque', 'tau', 'force'})
    return bool(words & _WORDS[kind]) or bool(column.unit) and column.unit in UNITS.get(kind, ())


# --- time ---------------------------------------------------------------------------------------
def _time(path: str | Path, series: Sequence[Series], settings: Sequence[str],
          assumptions: list[str]) -> tuple[Series | None, Array, dict[str, Any]]:
    """Return (column of the time, times in s from 0, its block of the mapping)."""
    rate = next((float(text.partition('=')[2]) for text in settings
                 if re.fullmatch(r'time\.rate=[\d.eE+-]+', text)), None)
    if rate:
        return None, np.arange(len(series[0].values)) / rate, {'rate': rate}
    # Named times first; without a name, what grows steadily.
    ordered = sorted(series, key=lambda column: not _is('time', column))
    for column in ordered:
        named = _is('time', column)
        units = ['iso8601'] if column.values.dtype.kind == 'U' else [
            unit for unit in (column.unit, *TIME) if unit in TIME]
        for unit in units:
            block = _time_block(path, column, unit, named)
            if block is not None:
                stamps, extra = block
                how = 'by its name' if named else 'by its steady growth'
                assumptions.append(f'Time: {column.label}, {how}, in {unit}: one sample per '
                                   f'{np.median(np.diff(stamps)) * 1e-9:.6g} s.')
                if column.unit in TIME and unit != column.unit:
                    assumptions.append(f'Its name says {column.unit}, at which the sample time '
                                       'makes no sense.')
                if len(extra):
                    assumptions.append(f'Time: {", ".join(f"{k} {v}" for k, v in extra.items())}.')
                t = (stamps - stamps[0]) * 1e-9
                return column, t, {**column.place, **({'unit': unit} if unit != 's' else {}),
                                   **extra}
    raise InputError(f'{path}: no column of {", ".join(c.label for c in series)[:200]} grows like '
                     'a time, expected one, or --set time.rate=HZ')


def _time_block(path: str | Path, column: Series, unit: str, named: bool
                ) -> tuple[Array, dict[str, Any]] | None:
    """Return (stamps, further keys of the mapping) of `column` read in `unit`, None: no time."""
    time = TimeMapping(unit=unit)
    try:
        stamps = absolute_ns(path, column.values, time, str)
    except InputError:
        return None
    step = np.diff(stamps)
    median = float(np.median(step)) * 1e-9
    if not SHORTEST <= median < LONGEST or (step < 0).mean() > 0.01 or (step == 0).mean() > 0.3:
        return None
    if not named and np.std(step) > 0.5 * np.mean(step):
        return None
    extra: dict[str, Any] = {}
    if (step < 0).any():
        extra['unordered'] = 'sort'
    if len(np.unique(stamps)) < len(stamps):
        extra['repeated'] = 'first'
    if stamps[0] >= EPOCH:
        extra['start_stamp_ns'] = 'recorded'
    return stamps.astype(float), extra


# --- signals ------------------------------------------------------------------------------------
def _decoded(column: Series, assumptions: list[str]) -> tuple[Array, dict[str, Any]]:
    """Return (values, keys bits and coding) of `column`, in the coding that is smooth."""
    values = column.values.astype(float)
    valid = values[np.isfinite(values)]
    if (valid != np.floor(valid)).any() or valid.min() < 0:
        return values, {}
    best, keys, path = values, {}, float(np.abs(np.diff(valid)).sum())
    for coding, bits in CODINGS:
        half, full = 2.0 ** (bits - 1), 2.0 ** bits
        if valid.max() < half or valid.max() >= full:
            continue
        negative = half - values if coding == 'sign_magnitude' else values - full
        trial = np.where(values >= half, negative, values)
        length = float(np.abs(np.diff(trial[np.isfinite(trial)])).sum())
        if length < SMOOTHER * path:
            best, path = trial, length
            keys = {'bits': bits, **({'coding': coding} if coding == 'sign_magnitude' else {})}
    if keys:
        assumptions.append(f'{column.label}: {keys["bits"]}-bit integers, '
                           f'{keys.get("coding", "twos_complement")}.')
    return best, keys


def _signals(path: str | Path, columns: Sequence[Series], decoded: Mapping[int, tuple[Array, Any]],
             t: Array, assumptions: list[str]) -> dict[str, Series]:
    """Return {signal: column} of the recording."""
    setpoints = [column for column in columns if _is('setpoint', column)
                 and not _is('velocity', column) and not _is('effort', column)]
    columns = [column for column in columns if not _is('none', column)]
    measured = [column for column in columns if not _is('command', column)]
    positions = [column for column in measured if _is('position', column)
                 and not (_is('velocity', column) or _is('effort', column)
                          and column.unit not in {**ANGLE, **LENGTH})]
    if not positions:
        velocities = [column for column in measured if _is('velocity', column)]
        if not velocities:
            raise InputError(f'{path}: no position or velocity among '
                             f'{", ".join(c.label for c in columns)[:200]}, expected a mapping '
                             'file (--map)')
    else:
        velocities = []
    order, motion = np.argsort(t, kind='stable'), None
    t_sorted = t[order] + 1e-12 * np.arange(len(t))  # a repeated stamp has no derivative
    moving = {id(column): decoded[id(column)][0][order] for column in columns}
    signals: dict[str, Series] = {}
    if positions:
        motor, arm = _two_encoders(positions, moving, t_sorted, assumptions)
        signals.update({name: column for name, column in (
            ('motor_position', motor), ('arm_position', arm)) if column is not None})
        motion = _motion(t_sorted, moving[id(motor if motor is not None else arm)])
    for column in velocities or [c for c in measured if c not in positions and
                                 _is('velocity', c)]:
        side = 'arm' if _is('arm', column) or 'motor_position' not in signals and positions \
            else 'motor'
        if motion is None or motion.explained(moving[id(column)]) > DERIVATIVE:
            signals.setdefault(f'{side}_velocity', column)
    if motion is None:
        velocity = moving[id(next(iter(signals.values())))]
        motion = _motion(t_sorted, np.cumsum(np.nan_to_num(velocity) * np.gradient(t_sorted)))
    rest = [c for c in columns if c not in signals.values() and not _is('position', c)
            and not _is('velocity', c)]
    efforts = [c for c in rest if _is('effort', c) and c.unit not in COUNTS]
    # A command is better than none, and so is what follows the motion.
    efforts = [c for c in efforts if not _is('command', c)] or efforts
    if not efforts:
        efforts = [c for c in rest if FOLLOWS < motion.explained(
            moving[id(c)]) and motion.explained(moving[id(c)], True) < SAME_MOTION]
        assumptions += [f'{c.label}: an effort, because the motion explains '
                        f'{motion.explained(moving[id(c)]):.0%} of it.' for c in efforts]
    sensors = [c for c in efforts if _is('sensor', c) and len(efforts) > 1]
    for column in sensors[:1]:
        signals['reference_torque'] = column
    drives = [c for c in efforts if c not in sensors]
    if drives:
        signals['motor_effort'] = max(drives, key=lambda c: (
            _is('motor', c), motion.explained(moving[id(c)])))
    elif setpoints:
        signals['motor_setpoint'] = setpoints[0]
        assumptions.append(f'{setpoints[0].label}: the setpoint of the motor, because no effort '
                           'is recorded.')
    return signals


def _motion(t: Array, position: Array) -> Motion:
    valid = np.isfinite(position)
    return Motion(t, np.interp(t, t[valid], position[valid]))


def _two_encoders(positions: Sequence[Series], moving: Mapping[int, Array], t: Array,
                  assumptions: list[str]) -> tuple[Series | None, Series | None]:
    """Return the columns of motor and arm position, None for one that is not there."""
    pairs = [(_motion(t, moving[id(a)]).explained(moving[id(b)], True), a, b)
             for k, a in enumerate(positions) for b in positions[k + 1:]]
    share, a, b = max(pairs, key=lambda pair: pair[0], default=(0.0, positions[0], positions[0]))
    if share < SAME_MOTION:
        named = [c for c in positions if _is('motor', c) or _is('arm', c)]
        column = (named or positions)[0]
        is_arm = _is('arm', column) and not _is('motor', column)
        assumptions.append(f'{column.label}: the position of the {"arm" if is_arm else "motor"}, '
                           'the only one.')
        return (None, column) if is_arm else (column, None)
    if _is('motor', b) > _is('motor', a) or _is('arm', a) > _is('arm', b):
        motor, arm, why = b, a, 'by their names'
    elif _is('motor', a) > _is('motor', b) or _is('arm', b) > _is('arm', a):
        motor, arm, why = a, b, 'by their names'
    else:
        motor, arm = sorted((a, b), key=lambda c: -np.nanstd(moving[id(c)]))
        why = 'of two encoders that move together, the motor is the one with more motion'
    assumptions.append(f'{motor.label}: motor; {arm.label}: arm; {why}.')
    return motor, arm


# --- keys ---------------------------------------------------------------------------------------
def _block(name: str, column: Series, keys: Mapping[str, Any]) -> dict[str, Any]:
    block: dict[str, Any] = {**column.place, **keys}
    if not np.isfinite(column.values.astype(float)).all():
        block['missing'] = 'nan'
    quantity = SIGNALS[name].quantity
    if column.unit in UNITS[quantity]:
        block['unit'] = column.unit
    return block


def _note_units(signals: Mapping[str, Series], kind: str, assumptions: list[str]) -> None:
    silent = [name for name, column in signals.items() if not column.unit]
    if silent:
        units = 'rotary axis, rad, rad/s, N m (or --set kind=prismatic)' \
            if kind == 'rotary' else 'm, m/s, N'
        assumptions.append(f'No unit in the name, so {units} unless stated below: '
                           f'{", ".join(silent)}.')


def _complete(data: dict[str, Any], blocks: dict[str, dict[str, Any]],
              signals: Mapping[str, Series], values: Mapping[str, Array],
              context: tuple[Array, Sequence[str]], assumptions: list[str]) -> None:
    """Add units, signs, counts per turn and gear ratio that the motion shows to `blocks`."""
    t, settings = context
    for name, block in blocks.items():
        whole = values[name][np.isfinite(values[name])]
        if 'unit' not in block and 'velocity' not in name and np.ptp(whole) > COARSE and (
                whole == np.floor(whole)).all():
            block['unit'] = 'counts'
            assumptions.append(f'{signals[name].label}: whole numbers, so counts.')
    stated = {name: float(text.partition('=')[2]) for text in settings for name in blocks
              if re.fullmatch(rf'signals\.{name}\.counts_per_rev=[\d.eE+-]+', text)}
    for name, count in stated.items():
        blocks[name]['counts_per_rev'] = count
    if {'motor_position', 'arm_position'} <= set(blocks):
        _relate_encoders(data, blocks, (values['motor_position'], values['arm_position']),
                         assumptions)
    _velocity_units(data['kind'], blocks, values, t, assumptions)
    _effort_sign(blocks, values, t, assumptions)
    needed = [f'signals.{name}.counts_per_rev' for name, block in blocks.items()
              if block.get('unit') in ('counts', 'counts/s') and 'counts_per_rev' not in block
              and data['kind'] == 'rotary' and name != 'motor_effort']
    effort = blocks.get('motor_effort', {})
    if effort.get('unit') in DRIVE_INPUT:
        needed.append('signals.motor_effort.torque_constant (N m per A, or at full duty)')
    if effort.get('unit') in COUNTS:
        needed.append('signals.motor_effort.scale (N m per count)')
    settled = {text.partition('=')[0] for text in settings}
    needed = [text for text in needed if text.partition(' ')[0] not in settled]
    if needed:
        assumptions.append(f'Not in the data, state it: {", ".join(needed)}.')


def _scale(block: Mapping[str, Any], kind: str) -> float | None:
    """Return the factor of a position's block to SI, None: counts per turn are unknown."""
    factor, complete = unit_factor(block['unit'], 'position', kind) if 'unit' in block else \
        (1.0, True)
    if complete:
        return factor
    count = block.get('counts_per_rev')
    return 2.0 * np.pi / count if count else None


def _relate_encoders(data: dict[str, Any], blocks: dict[str, dict[str, Any]],
                     positions: tuple[Array, Array], assumptions: list[str]) -> None:
    """Add the sign of the arm, and the gear ratio or the motor's counts per turn of the output."""
    motor, arm = positions
    valid = np.isfinite(motor) & np.isfinite(arm)
    slope = float(np.polyfit(arm[valid], motor[valid], 1)[0])
    if slope < 0.0:
        blocks['arm_position']['sign'] = -1
        assumptions.append('The arm runs against the motor: its sign is -1.')
    scale = [_scale(blocks[name], data['kind']) for name in ('motor_position', 'arm_position')]
    if scale[1] is not None and scale[0] is None:
        count = abs(slope) * 2.0 * np.pi / scale[1]
        blocks['motor_position']['counts_per_rev'] = float(f'{count:.6g}')
        assumptions.append(f'Motor: {count:.6g} counts per turn of the output, from the motion of '
                           'the arm; lost motion makes it too large, a data sheet knows better.')
    elif scale[0] is not None and scale[1] is not None:
        ratio = abs(slope) * scale[0] / scale[1]
        if abs(ratio - 1.0) > 0.05:
            near = round(ratio)
            data['gear_ratio'] = float(near) if near and abs(ratio / near - 1.0) < 0.01 else \
                float(f'{ratio:.6g}')
            assumptions.append(f'Gear ratio {data["gear_ratio"]:g}: the motor turns {ratio:.5g} '
                               'times as much as the arm.')


def _velocity_units(kind: str, blocks: dict[str, dict[str, Any]], values: Mapping[str, Array],
                    t: Array, assumptions: list[str]) -> None:
    """Add the unit of a velocity, or of its position, that their derivative relation shows."""
    table = {('velocity', 'rotary'): ANGULAR_SPEED, ('velocity', 'prismatic'): SPEED}
    for side in ('motor', 'arm'):
        name, position = f'{side}_velocity', f'{side}_position'
        if name not in blocks or position not in blocks or 'unit' in blocks[name]:
            continue
        scale = _scale(blocks[position], kind)
        order = np.argsort(t, kind='stable')
        motion = _motion(t[order] + 1e-12 * np.arange(len(t)), values[position][order])
        valid = np.isfinite(values[name][order])
        velocity = values[name][order][valid]
        gain = float(velocity @ motion.velocity[valid] / (velocity @ velocity))
        if scale is None or gain == 0.0:
            continue
        units = table['velocity', kind]
        unit = min(units, key=lambda u: abs(np.log(abs(gain * scale / units[u]))))
        if gain < 0.0:
            blocks[name]['sign'] = -1
        if abs(np.log(abs(gain * scale / units[unit]))) < 0.1:
            blocks[name]['unit'] = unit
            assumptions.append(f'{name}: {unit}, as the derivative of {position}.')
        else:
            blocks[name]['scale'] = float(f'{abs(gain) * scale:.4g}')
            assumptions.append(f'{name}: scale {blocks[name]["scale"]:g}, as the derivative of '
                               f'{position}.')


def _effort_sign(blocks: dict[str, dict[str, Any]], values: Mapping[str, Array], t: Array,
                 assumptions: list[str]) -> None:
    """Turn the efforts round that take work out of a drive with friction."""
    position = next((name for name in ('motor_position', 'arm_position') if name in blocks), None)
    order = np.argsort(t, kind='stable')
    for name in ('motor_effort', 'reference_torque'):
        if name not in blocks or position is None:
            continue
        motion = _motion(t[order] + 1e-12 * np.arange(len(t)), values[position][order])
        effort = values[name][order]
        valid = np.isfinite(effort)
        power = (effort - np.nanmedian(effort))[valid] * motion.velocity[valid]
        sign = blocks[position].get('sign', 1)
        if power.mean() * sign < 0.0:
            blocks[name]['sign'] = -1
            assumptions.append(f'{name}: sign -1, or it would take work out of the drive.')
