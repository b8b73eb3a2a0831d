# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a column of a recording is by its name and unit alone: quantity, source, side and joint.

A name is cut into words; words of the vocabulary say what is measured, how it came about and on
which side of the gear, and the others are the name or number of the joint.
"""
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from operator import and_
import re
from typing import Any

from gearbox_monitor.recordings.log_units import (
    EFFORT, POSITION, scaled_unit, standard_unit, TIME, unit_of_label, units_of, VELOCITY,
    vocabulary)

ACCELERATION, COUNTER, NOTHING = 'acceleration', 'counter', ''
MEASURED, SETPOINT, FILTERED, PART, SENSOR, RELATIVE = (
    'measured', 'setpoint', 'filtered', 'part', 'sensor', 'relative')
_GERMAN = re.compile(r'(?i)(?<![a-z])(ist|soll|motor|achs|gelenk)'
                     r'(position|winkel|lage|drehzahl|geschwindigkeit|moment|strom)')
_WORD = re.compile(r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+|[^\W\d_]+')
JOINT = re.compile(r'(?i)(joint|axis|j|a)[ _]?\d+')
AXES = (('q_A', 'd_A'), ('i_q', 'i_d'))  # of a current
ALL = 0.8  # share of the names of a file that a product of joints and signals makes up


@dataclass(frozen=True)
class Meaning:
    """
    What the name and unit of a column say.

    quantity: '' = none of a drive; source: how it came about; side: 'motor', 'arm' or ''; unit:
    standard name, '' = not stated; joint: '' where the name says none; why: words that decided;
    stated: the unit stands in the file; key: words of the name that belong to the joint; implied:
    a setpoint without a word of what, so of the position.
    """

    label: str
    quantity: str
    source: str
    side: str
    unit: str
    joint: str
    why: str
    stated: bool = True
    key: tuple[str, ...] = ()
    implied: bool = False

    @property
    def own_words(self) -> frozenset[str]:
        """Words of the name that belong to the joint; empty where there is only one."""
        return frozenset({*self.key, *words_of(self.joint), 'joint'}) if self.joint else \
            frozenset()

    @property
    def words(self) -> tuple[str, ...]:
        """Words of the name without those of the joint."""
        return tuple(word for word in words_of(self.label) if word not in self.own_words)

    @property
    def stem(self) -> str:
        """The label without the words of its joint, as an option takes it."""
        if not self.joint:
            return self.label
        return '_'.join(word for word in _WORD.findall(_without_brackets(self.label))
                        if word.lower() not in self.own_words)

    @property
    def is_input(self) -> bool:
        """Whether an effort needs a constant: a current, a duty, counts."""
        if self.unit:
            return self.unit in units_of(EFFORT, 'input')
        words = set(self.words)
        return bool(words & set(vocabulary()['inputs'])) and not words & vocabulary()['torques']


@lru_cache(65536)
def words_of(label: str) -> tuple[str, ...]:
    """Return the words of a `label` in lower case; 'motorPos_rad[3]' is motor, pos, rad and 3."""
    plain = re.sub(r'(?i)feed[ _-]?back', 'feedback', _without_brackets(label))
    return tuple(word.lower() for word in _WORD.findall(_GERMAN.sub(r'\1 \2', plain)))


def _without_brackets(label: str) -> str:
    return re.sub(r'[\[(<{]([^\])>}]*)[\])>}]', _inside, label)


def _inside(match: re.Match[str]) -> str:
    """Return what brackets hold if it is a number or a name, blank for a unit."""
    text = match[1].strip()
    return ' ' if not text.isdigit() and (scaled_unit(text)[1] or text in ('-', '?', '', ':')) \
        else f' {text} '


def _kinds(table: str, words: Sequence[str], skipped: frozenset[str] = frozenset()) -> list[str]:
    return [kind for kind, names in vocabulary()[table].items()
            if any(word in names and word not in skipped for word in words)]


def meaning_of(label: str, unit: str = '') -> Meaning:
    """
    Return the Meaning of the name `label`; `unit` is one that the file states elsewhere.

    The joint is left as the words that the vocabulary does not know; see `meanings`.
    """
    known = vocabulary()
    words, unit = list(words_of(label)), standard_unit(unit) or unit_of_label(label)[1]
    axis = {'d', 'q'} & set(words) if known['rotating'] & set(words) else set()
    if len(axis) == 1:  # of a current or voltage, as in 'q_current'
        words = [word for word in words if word not in axis]
    quantity = _quantity(words, unit)
    leaf = words_of(re.split(r'[./]', label.rstrip('./'))[-1])
    sources = _kinds('sources', words, frozenset(words) - frozenset(leaf)) or _kinds(
        'sources', words)
    desired = 'd' in words[1:] and quantity in (POSITION, VELOCITY, EFFORT, ACCELERATION)
    if axis == {'d'}:
        sources = [PART]  # makes no torque
    elif {'controller', 'input'} <= set(words) or ('as', 'pos') in zip(words, words[1:]):
        sources = [SETPOINT]  # of an ODrive, of KUKA RSI
    elif desired:  # q_d, tau_J_d
        sources = [SETPOINT]
    source = next((own for own in sources if own != MEASURED), MEASURED if sources else '')
    implied = quantity == NOTHING and SETPOINT in sources
    if implied or quantity == NOTHING and {'observation', 'state'} <= set(words):
        quantity = POSITION
    if quantity == EFFORT and source == MEASURED and not set(words) - {'current', 'currents'} & \
            known['sources'][MEASURED]:
        source = ''
    side = next(iter(_kinds('sides', words, frozenset(
        {'load', 'drive', 'input'} if quantity == EFFORT else {'drive'}))), '')
    foreign = bool(set(words) & known['foreign'])
    if foreign and quantity != TIME:
        quantity = NOTHING
    short = quantity == NOTHING and words[:1] in (['p'], ['v']) and not foreign
    if short:
        quantity = POSITION if words[0] == 'p' else VELOCITY
    unexplained = [word for k, word in enumerate(words) if word not in known_words()
                   and not (desired and word == 'd' if k else short)]
    if quantity == NOTHING and (source == MEASURED or {'state', 'states'} & set(leaf)) and {
            'joint', 'joints'} & set(words) and not foreign and all(
            word.isdigit() for word in unexplained):
        quantity = POSITION  # feedBack.joints[3], joint_states: a measured joint as such
    deciding = [word for table, kind in (('quantities', quantity), ('sources', source),
                                         ('sides', side)) for word in words
                if kind and word in known[table].get(kind, ())]
    return Meaning(label, quantity, source, side, unit, ' '.join(unexplained),
                   ', '.join(dict.fromkeys(map(repr, deciding))), bool(unit), implied=implied)


@lru_cache(None)
def known_words() -> frozenset[str]:
    """Return the words that name a quantity, a source, a side or a unit, or contain them."""
    known = vocabulary()
    return known['containers'] | known['unit_words'] | frozenset().union(
        *(names for table in ('quantities', 'sources', 'sides')
          for names in known[table].values()))


def run_of(name: str) -> tuple[bool, tuple[str, ...]]:
    """
    Return (whether the `name` of a file calls it setpoints, its words that tell runs apart).

    Those of parts of a torque do: 'friction_gravity_control' is a run to learn friction.
    """
    known, words = vocabulary(), words_of(name)
    common = known['containers'] | known['sources'][SETPOINT] | known['sources'][MEASURED] | \
        frozenset().union(*known['quantities'].values(), *known['sides'].values())
    return (not known['sources'][SETPOINT].isdisjoint(words),
            tuple(w for w in words if w not in common))


def _quantity(words: Sequence[str], unit: str) -> str:
    """Return the quantity that `words` and `unit` say, '' for none."""
    named = vocabulary()['quantities']
    pairs = set(zip(words, words[1:]))
    if pairs & {('q', 'dot'), ('theta', 'dot'), ('d', 'q'), ('d', 'theta'), ('d', 'pos')}:
        return VELOCITY
    kinds = _kinds('quantities', words)
    moving = [kind for kind in kinds if kind in (POSITION, VELOCITY, ACCELERATION)]
    if EFFORT in kinds and moving and not unit:
        # 'current position', 'load speed': the words are sides or times of another quantity.
        strong = set(words) & named[EFFORT] - {'current', 'load', 'i', 'u'}
        kinds = [kind for kind in kinds if kind not in (moving if strong else [EFFORT])]
    by_unit = [kind for kind in kinds if kind in vocabulary()['units'] and unit in units_of(kind)]
    if unit and not by_unit:
        by_unit = [kind for kind in (POSITION, VELOCITY, EFFORT)
                   if unit in units_of(kind, 'rotary', 'prismatic')
                   or unit in units_of(kind, 'input') and (
                       unit == 'A' if kind == EFFORT else not kinds)]
        if by_unit and kinds and kinds[0] in (TIME, COUNTER):
            by_unit = []
    order = [*by_unit, *kinds]
    quantity = order[0] if order else NOTHING
    return TIME if quantity == COUNTER and TIME in kinds else quantity


# --- all columns of one file --------------------------------------------------------------------
def meanings(labels: Sequence[str], units: Sequence[str], listed: Sequence[str] = ()
             ) -> list[Meaning]:
    """
    Return the Meaning of each of the names of one file, with the joint that it belongs to.

    Joints are distinguished by words outside of the vocabulary: a number that counts through
    a family of names alike ('q_0' ... 'q_6'), or a name that stands beside several quantities.

    Args:
        labels: names of the columns.
        units: that the file states, '' for none.
        listed: names of joints that the file lists, in place of numbers.
    """
    columns = _by_convention([meaning_of(label, unit) for label, unit in zip(labels, units)])
    product = _product(labels, units)
    if product and any(_has_signal_words(joint) for joint, _ in product.values()):
        return [replace(meaning, label=label, joint=_joint_name(joint, (joint,)),
                        key=tuple(words_of(joint)))
                if meaning.quantity in (POSITION, VELOCITY, EFFORT) else
                replace(meaning, label=label, joint='') for label, column in zip(labels, columns)
                for joint, meaning in [product.get(label, ('', column))]]
    if not any(c.quantity == POSITION and c.source in (MEASURED, '') for c in columns):
        columns = [replace(column, quantity=POSITION, why='the joint itself')
                   if JOINT.fullmatch(column.label) else column for column in columns]
    of_drive = [k for k, column in enumerate(columns)
                if column.quantity in (POSITION, VELOCITY, EFFORT)]
    result = [replace(column, joint='') for column in columns]
    for k, key in zip(of_drive, _joints([columns[k] for k in of_drive])):
        result[k] = replace(columns[k], joint=_joint_name(columns[k].label, key), key=key)
    return _with_listed_names(_without_other_vectors(result), listed)


def joints_of(columns: Sequence[Meaning]) -> list[str]:
    """Return the joints that have a position or velocity, in the order of `columns`."""
    return list(dict.fromkeys(column.joint for column in columns if _moves(column)))


def joints_of_none(columns: Sequence[Meaning]) -> list[str]:
    """Return the labels of positions and velocities among `columns` that name no joint."""
    return [column.label for column in columns if _moves(column) and not column.joint]


def _moves(column: Meaning) -> bool:
    return column.quantity in (POSITION, VELOCITY) and column.source in (
        MEASURED, FILTERED, RELATIVE, '')


def _product(labels: Sequence[str], units: Sequence[str]) -> dict[str, tuple[str, Meaning]]:
    """
    Return {label: (joint, Meaning of the rest)} where names are all of 'JOINT_SIGNAL'.

    Names of joints may hold words of the vocabulary, 'wrist_angle' or the axes S, L, U, R, B, T;
    each stands before each of the same signals.
    """
    prefixes: dict[str, set[str]] = {}
    sides = frozenset().union(*vocabulary()['sides'].values())
    splits = [(label, unit, cut) for label, unit in zip(labels, units)
              for cut in re.finditer(r'[_./ ]+', label) if cut.start()]
    for label, _, cut in splits:
        prefixes.setdefault(label[cut.end():], set()).add(label[:cut.start()])
    counts = Counter(frozenset(joints) for joints in prefixes.values())
    whole = [(joints, n) for joints, n in counts.items() if len(joints) > 1 < n
             and len(joints) * n >= ALL * len(labels)
             and not any(set(words_of(joint)) & named for joint in joints
                         for named in vocabulary()['sources'].values())
             and not all(set(words_of(joint)) <= sides for joint in joints)]
    if not whole:
        return {}
    joints, _ = max(whole, key=lambda pair: len(pair[0]))
    splits = [split for split in splits if prefixes[split[0][split[2].end():]] == joints]
    signals = _by_convention([meaning_of(label[cut.end():], unit) for label, unit, cut in splits])
    if not {s.quantity for s in signals} & {POSITION, VELOCITY} or any(
            signal.quantity == NOTHING and not vocabulary()['foreign'] & set(
                words_of(signal.label)) for signal in signals):  # a temperature may be there, too
        return {}
    return {label: (label[:cut.start()], meaning)
            for (label, _, cut), meaning in zip(splits, signals)}


def _has_signal_words(joint: str) -> bool:
    """Return whether the name of a joint holds words that a signal may be called by."""
    known, words = vocabulary(), set(words_of(joint))
    return any(words & named for table in ('quantities', 'sides')
               for named in known[table].values()) or bool(
                   words & (known['foreign'] | known['unit_words']))


def _without_other_vectors(columns: Sequence[Meaning]) -> list[Meaning]:
    """
    Return `columns`, with no joint for the short vectors of a signal that all joints have.

    'base_pos 1' to 'base_pos 3' are no joints' positions if there are 'dof_pos 1' to 'dof_pos 12'.
    """
    vectors: dict[tuple[str, ...], set[str]] = {}
    own = [(column.quantity, column.source, column.side, column.stem) for column in columns]
    joints = {column.joint for column in columns if column.joint}
    for vector, column in zip(own, columns):
        vectors.setdefault(vector, set()).add(column.joint)
    whole = {vector[:3] for vector, names in vectors.items() if names >= joints}
    return [replace(column, quantity=NOTHING, joint='', key=()) if column.joint
            and 1 < len(vectors[vector]) < len(joints) and vector[:3] in whole
            else column for vector, column in zip(own, columns)]


def _by_convention(columns: Sequence[Meaning]) -> list[Meaning]:
    """Return `columns` with units that a driver is known to write without stating them."""
    known = vocabulary()
    names = {re.sub(r'[\W\d]+$', '', column.label.rpartition('.')[2]) for column in columns}
    together: dict[str, tuple[str, str]] = {}
    for row in known['neighbours']:
        if set(row['names']) <= names:
            together = {quantity: (unit, row['why']) for quantity, unit in row['units'].items()}
    result = []
    for column in _by_notation(columns):
        words = set(words_of(column.label))
        unit, reason = next(((row['unit'], row['why']) for row in known['conventions']
                             if set(row['words']) <= words and row['quantity'] == column.quantity),
                            together.get(column.quantity, ('', '')))
        if unit and not column.unit:
            column = replace(column, unit=unit, why=f'{column.why}; {reason}', stated=False)
        result.append(column)
    return result


def _by_notation(columns: Sequence[Meaning]) -> list[Meaning]:
    """
    Return `columns`, read by letters that mean one thing together.

    theta and q: motor and link of an elastic joint. q_A and d_A, i_q and i_d: axes of a current.
    input_pos and pos_estimate: what an ODrive is to do.
    """
    endings = {column.label.rpartition('.')[2] for column in columns}
    measured = [set(words_of(c.label)) for c in columns if c.quantity == POSITION
                and c.source in (MEASURED, '') and not c.side]
    elastic = all(any(letter in words for words in measured) for letter in ('q', 'theta'))
    estimated = any({'pos', 'estimate'} <= words for words in measured)
    result = []
    for column in columns:
        words, axis = set(words_of(column.label)), column.label.rpartition('.')[2]
        moving = column.quantity in (POSITION, VELOCITY)
        pair = next((own for own in AXES if axis in own and set(own) <= endings), None)
        changes: dict[str, Any] = {}
        if pair is not None:
            changes = {'quantity': EFFORT, 'unit': 'A', 'joint': '', 'why': f"'{axis}'",
                       'source': '' if axis == pair[0] else PART, 'side': ''}
        elif estimated and 'input' in words and (moving or column.quantity == EFFORT):
            changes = {'source': SETPOINT, 'side': ''}
        elif elastic and not column.side and moving and words & {'theta', 'dtheta'}:
            changes = {'side': 'motor', 'why': f'{column.why}; of the motor, with q'}
        elif elastic and not column.side and moving and words & {'q', 'dq'}:
            changes = {'side': 'arm', 'why': f'{column.why}; of the link, with theta'}
        result.append(replace(column, **changes))
    return result


def _joints(columns: Sequence[Meaning]) -> list[tuple[str, ...]]:
    """
    Return the words that name the joint of each column, () if there is only one.

    All words may name it, or only words that several signals share, or numbers alone, or none. The
    right reading fills a table of joints and signals: each joint has about the same signals, each
    of them once.
    """
    if not columns:
        return []
    parts = [tuple(column.joint.split()) for column in columns]
    # Words in all names do not name a joint; a number counts as often as all have it.
    common = reduce(and_, map(Counter, parts))
    distinct = [_without(part, common) for part in parts]
    signals = [(c.quantity, c.source, c.side, c.quantity == EFFORT and bool(
        c.unit in units_of(EFFORT, 'input') or set(words_of(c.label)) & set(
            vocabulary()['inputs']))) for c in columns]
    numbers = _counting(signals, distinct)
    none: list[tuple[str, ...]] = [()] * len(columns)
    several = len(set(signals)) > 1
    # A word that only one signal has belongs to it: 'process' in 'hip_process_value'.
    signals_of_word = Counter(word for word, _ in {
        (word, signal) for signal, part in zip(signals, distinct) for word in part})
    shared = [tuple(word for word in part if signals_of_word[word] > 1) for part in distinct]
    # A word in a single column distinguishes two encoders, not two joints.
    readings = [none, *(keys for keys in (numbers, shared, distinct) if len(
        set(keys) - {()}) > 1 and (
        several or len(set(keys)) > 2 or all(any(map(str.isdigit, key)) for key in keys)))]
    return max(readings, key=lambda keys: round(_filled(keys, signals), 9))


def _without(words: Sequence[str], excluded: Mapping[str, int]) -> tuple[str, ...]:
    """Return `words` without the first so many of each word that is excluded."""
    seen = Counter[str]()
    return tuple(word for word in words if (
        seen.update([word]) or seen[word]) > excluded.get(word, 0))


def _filled(keys: Sequence[tuple[str, ...]], signals: Sequence[tuple[object, ...]]) -> float:
    """Return the share of a table of joints and signals that is filled, less what stands twice."""
    cells = set(zip(keys, signals))
    share = len(cells) / (len(set(keys)) * len(set(signals)))
    return share - (len(keys) - len(cells)) / len(keys)


def _counting(signals: Sequence[tuple[object, ...]], parts: Sequence[tuple[str, ...]]
              ) -> list[tuple[str, ...]]:
    """Return the numbers in each of `parts` that not all columns of its signal have."""
    numbers = [tuple(word for word in part if word.isdigit()) for part in parts]
    of_signal: dict[object, list[Counter[str]]] = {}
    for signal, own in zip(signals, numbers):
        of_signal.setdefault(signal, []).append(Counter(own))
    return [own if len(of_signal[signal]) == 1 else _without(own, reduce(and_, of_signal[signal]))
            for signal, own in zip(signals, numbers)]


def _joint_name(label: str, key: Sequence[str]) -> str:
    """Return what messages call the joint of the column `label`, which `key` tells apart."""
    if not key:
        return ''
    if all(word.isdigit() for word in key):
        stem = re.search(rf'[A-Za-z][\w]*?_0*{key[-1]}_joint\b', label)
        return f'joint_{"_".join(key)}' if stem is None else '_'.join(stem[0].split('_')[1:])
    return '_'.join(key)


def _with_listed_names(columns: Sequence[Meaning], names: Sequence[str]) -> list[Meaning]:
    """Return `columns` with the `names` that a file lists in place of the numbers of joints."""
    numbers = {column.joint: int(column.joint.removeprefix('joint_')) for column in columns
               if column.joint.removeprefix('joint_').isdigit()}
    first = min(1, *numbers.values()) if numbers else 1  # columns count from 0 or from 1
    if not numbers or max(numbers.values()) - first >= len(names):
        return list(columns)
    return [replace(column, joint=names[numbers[column.joint] - first])
            if column.joint in numbers else column for column in columns]
