# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Units of recordings, and what a column is by its name and unit alone, from one vocabulary.

A name is cut into words. Each word votes, by the vocabulary, for what is measured, how it came
about and on which side of the gear; the others are the name or number of the joint. Joints are
what fills a table of joints and signals best.
"""
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from importlib import resources
from operator import and_
import re
from typing import Any
from unicodedata import normalize

import yaml

from gearbox_monitor.errors import InputError

POSITION, VELOCITY, EFFORT, TIME = 'position', 'velocity', 'effort', 'time'
ROTARY, PRISMATIC = 'rotary', 'prismatic'
SI = {ROTARY: {POSITION: 'rad', VELOCITY: 'rad/s', EFFORT: 'N m'},
      PRISMATIC: {POSITION: 'm', VELOCITY: 'm/s', EFFORT: 'N'}}
COUNTS = ('counts', 'counts/s')


@lru_cache(None)
def vocabulary() -> dict[str, Any]:
    """Return the content of vocabulary.yaml; what is a text of words there is a set here."""
    text = resources.files(__package__).joinpath('vocabulary.yaml').read_text(encoding='utf-8')
    content: dict[str, Any] = yaml.load(text, getattr(yaml, 'CSafeLoader', yaml.SafeLoader))
    for key, value in content.items():
        if isinstance(value, str):
            content[key] = frozenset(value.split())
        elif key in ('quantities', 'sources', 'sides'):
            content[key] = {kind: frozenset(words.split()) for kind, words in value.items()}
    content['rules'] = [{
        'words': (), 'of': (POSITION, VELOCITY, EFFORT), 'beside': (), 'is': {}, 'unit': '',
        'why': '', **rule, 'any': frozenset(rule.get('any', '').split())}
        for rule in content['rules']]
    return content


def units_of(quantity: str, *axes: str) -> dict[str, float]:
    """Return {unit: factor} of a `quantity` on `axes` (with 'input': what needs a constant)."""
    tables = vocabulary()['units'][quantity]
    return {unit: factor for axis in axes or tables for unit, factor in tables[axis].items()}


@lru_cache(None)
def _spellings() -> dict[str, str]:
    units = [unit for quantity in vocabulary()['units'] for unit in units_of(quantity)]
    table = {}
    for unit in units:
        for word in (re.sub(r'\s', '', unit), *vocabulary()['spellings'].get(unit, '').split()):
            table[word] = unit
            if f'{unit}/s' in units:
                table |= {f'{word}{second}': f'{unit}/s' for second in ('/s', '/sec', 's-1')}
    return table


@lru_cache(4096)
def standard_unit(text: str) -> str:
    """Return the name in the tables of the unit `text` ('Nm', 'N*m', 'degrees'), '' if none."""
    plain = text.replace('µ', 'u').replace('μ', 'u')
    plain = re.sub(r'\s*\((?:angle|torque|velocity|position|force|time)\)\s*$', '', plain,
                   flags=re.IGNORECASE)  # 'deg (Angle)' of a TwinCAT scope
    squeezed = re.sub(r'[\s*·.^_]|(?<=[A-Za-z])-(?=[A-Za-z])', '', plain)
    return _spellings().get(squeezed) or _spellings().get(squeezed.lower(), '')


def scaled_unit(text: str) -> tuple[float, str]:
    """Return (factor, unit) of a unit with a number in front: '0.229rpm' is (0.229, 'rpm')."""
    match = re.fullmatch(r'\s*(\d*\.?\d+(?:[eE][-+]?\d+)?)?\s*\*?\s*(\D.*)', text)
    unit = standard_unit(match[2]) if match else ''
    return (float(match[1]) if match and match[1] and unit else 1.0), unit or standard_unit(text)


def unit_of_label(label: str) -> tuple[float, str]:
    """Return (factor, unit) that a `label` states: 'q [deg]', 'q_deg'; '' if none."""
    bracketed = re.search(r'[\[(<{]([^\[\](){}<>]+)[\])>}]\s*$', label)
    if bracketed:
        unit = bracketed[1].strip()
        return (1.0, '') if unit.isdigit() else scaled_unit(unit.rstrip('?'))
    # Within a name, 'angle [deg] raw', one letter is that of a part: 'encoder (A) position'.
    for inside in re.findall(r'[\[(]([^\[\]()]{2,})[\])]', label):
        if scaled_unit(inside)[1]:
            return scaled_unit(inside)
    # Single letters after an underscore are indices more often than units. Behind: of the joint.
    ending = re.search(r'[_ /-]((?:[A-Za-z]+_per_)?[A-Za-z%°]+)(?:_?\d+)?$', label)
    text = ending[1].replace('_per_', '/') if ending else ''
    return 1.0, standard_unit(text) if len(text) > 1 and text not in ('in', 'min') else ''


def strange_unit(label: str) -> str:
    """Return the text in brackets that names no known unit, as in 'torque [foo]', else ''."""
    match = re.search(r'\s\[([^\[\]]*[^\W\d][^\[\]]*)\]\s*$', label)
    return match[1].strip() if match and not scaled_unit(match[1])[1] else ''


def number_with_unit(cell: str) -> tuple[float, str] | None:
    """Return (number, unit) of a cell such as '0.005 sec', None if it is none."""
    match = re.fullmatch(r'\s*([-+]?\d*\.?\d+(?:[eE][-+]?\d+)?)\s+(\D{1,8}?)\s*', cell)
    unit = standard_unit(match[2]) if match else ''
    return (float(match[1]), unit) if match and unit else None


def axis_of(units: Iterable[str], otherwise: str = ROTARY) -> str:
    """Return the axis that one of the `units` says, `otherwise` where none does."""
    for unit in map(standard_unit, units):
        for axis in (PRISMATIC, ROTARY):
            if any(unit in units_of(quantity, axis) for quantity in SI[axis]):
                return axis
    return otherwise


def unit_factor(unit: str, quantity: str, axis: str) -> tuple[float, bool]:
    """
    Return (factor to SI, whether it suffices) of a unit.

    Counts and inputs of a motor need a second factor: counts per turn, a constant or a scale.

    Args:
        unit: as a user writes it.
        quantity: POSITION, VELOCITY or EFFORT.
        axis: ROTARY or PRISMATIC.

    Raises:
        InputError: not a unit of this quantity; the text names what was expected.
    """
    name = standard_unit(unit)
    for axes, complete in ((axis, True), ('input', False)):
        if name in units_of(quantity, axes):
            return units_of(quantity, axes)[name], complete
    raise InputError(f'{unit!r}, expected a unit of {quantity} on a {axis} axis: '
                     + ', '.join(units_of(quantity, axis, 'input')))


ACCELERATION, COUNTER, NOTHING = 'acceleration', 'counter', ''
MEASURED, SETPOINT, FILTERED, PART, SENSOR, RELATIVE = (
    'measured', 'setpoint', 'filtered', 'part', 'sensor', 'relative')
OF_DRIVE = (POSITION, VELOCITY, EFFORT)
_WORD = re.compile(r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+|[^\W\d_]+')
JOINT = re.compile(r'(?i)(joint|axis|j|a)[ _/]?\d+')
FROM_0 = 'numbers from 0 beside others from 1'
SHORTEST = 3  # letters of each of several words that are written as one
IN_STEP = 3  # joints from which on numbers from 0 beside others from 1 are those of the same
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

    @property
    def frame(self) -> frozenset[str]:
        """Words of the name that do not tell the joint, before its name is known."""
        return frozenset(words_of(self.label)).difference(self.joint.split())

    @property
    def is_silent(self) -> bool:
        """Whether the name is that of a joint alone, as 'elbow' beside 'goal/elbow'."""
        known = vocabulary()
        return self.quantity == NOTHING and self.source in (MEASURED, '') and not (
            self.unit or known['foreign'] & set(words_of(self.label))
            or known['poses'].issuperset(self.joint.split()))

    @property
    def moves(self) -> bool:
        """Whether it is a position or velocity that was measured."""
        return self.quantity in (POSITION, VELOCITY) and self.source in (
            MEASURED, FILTERED, RELATIVE, '')


@lru_cache(65536)
def words_of(label: str) -> tuple[str, ...]:
    """Return the words of a `label` in lower case; 'motorPos_rad[3]' is motor, pos, rad and 3."""
    plain = re.sub(r'(?i)feed[ _-]?back', 'feedback', _without_brackets(label))
    plain = re.sub(r'\b([SP]-\d-\d{4}|0x[\dA-Fa-f]{4,})\b', '', plain)  # parameters of drives
    if not plain.isascii():  # accents
        plain = normalize('NFC', re.sub('[\u0300-\u036f]', '', normalize('NFD', plain)))
    return tuple(part for word in _WORD.findall(plain) for part in _parts_of(word.lower()))


@lru_cache(4096)
def _parts_of(word: str) -> tuple[str, ...]:
    """
    Return the known words that a `word` is made of; else itself.

    'setpos' is set and pos, 'targ' the beginning of words for setpoints alone.
    """
    shortest = SHORTEST if word.isascii() else SHORTEST - 1
    if word in known_words() or len(word) < shortest:
        return (word,)
    for k in range(shortest, len(word) - shortest + 1):
        behinds = (word[k:], word[k:].removeprefix('s')) if word[:k] in known_words() else ()
        for behind in behinds:
            rest = _parts_of(behind)  # 'abtriebswinkel' is abtrieb and winkel
            if known_words().issuperset(rest):
                return word[:k], *rest
    begun = {source: known for source, words in vocabulary()['sources'].items()
             for known in words if known.startswith(word)}
    return (*begun.values(),) if len(begun) == 1 else (word,)


def _without_brackets(label: str) -> str:
    return re.sub(r'[\[(<{]([^\])>}]*)[\])>}]', _inside, label)


def _inside(match: re.Match[str]) -> str:
    """Return what brackets hold if it is a number or a name, blank for a unit."""
    text = match[1].strip()
    return ' ' if not text.isdigit() and (scaled_unit(text)[1] or text in ('-', '?', '', ':')) \
        else f' {text} '


@lru_cache(None)
def known_words() -> frozenset[str]:
    """Return the words that name a quantity, a source, a side or a unit, or contain them."""
    return vocabulary()['containers'] | vocabulary()['unit_words'] | _signal_words('sources')


@lru_cache(None)
def _signal_words(*more: str) -> frozenset[str]:
    """Return the words that name quantities, sides or what stands in the tables `more`."""
    return frozenset().union(*(words for table in ('quantities', 'sides', *more)
                               for words in vocabulary()[table].values()))


def run_of(name: str) -> tuple[bool, tuple[str, ...]]:
    """
    Return (whether the `name` of a file calls it setpoints, its words that tell runs apart).

    Those of parts of a torque do: 'friction_gravity_control' is a run to learn friction.
    """
    known, words = vocabulary(), words_of(name)
    common = known['containers'] | _signal_words() | known['sources'][SETPOINT] | \
        known['sources'][MEASURED]
    return (not known['sources'][SETPOINT].isdisjoint(words),
            tuple(word for word in words if word not in common))


# --- one name -----------------------------------------------------------------------------------
def _votes(table: str, words: Iterable[str], spent: frozenset[str] = frozenset()) -> list[str]:
    """Return the kinds in a `table` that one of `words` names, the first of the table first."""
    return [kind for kind, names in vocabulary()[table].items()
            if not (names - spent).isdisjoint(words)]


def meaning_of(label: str, unit: str = '', silent: frozenset[str] = frozenset(),
               naming: frozenset[str] = frozenset()) -> Meaning:
    """
    Return the Meaning of the name `label`; `unit` is one that the file states elsewhere.

    The joint is left as the words that the vocabulary does not know; see `meanings`. silent: words
    that tell nothing; naming: that belong to the name of the joint, whatever the vocabulary says.
    """
    known, words = vocabulary(), tuple(w for w in words_of(label) if w not in silent)
    unit = standard_unit(unit) or unit_of_label(label)[1]
    quantity = _quantity(words, unit)
    spent = known['quantities'][EFFORT] if quantity == EFFORT else frozenset()
    leaf = set(words_of(re.split(r'[./]', _without_brackets(label).rstrip('./ '))[-1])) - silent
    sources = _votes('sources', leaf, spent) or _votes('sources', words, spent)
    desired = 'd' in words[1:] and quantity in (*OF_DRIVE, ACCELERATION)  # q_d, tau_J_d
    source = SETPOINT if desired else next(iter(sources), '')
    side = next(iter(_votes('sides', words, spent | naming)), '')
    implied = quantity == NOTHING and SETPOINT in sources
    foreign = not known['foreign'].isdisjoint(words)
    short = quantity == NOTHING and not implied and not foreign and words[:1] in (('p',), ('v',))
    if short:
        quantity = POSITION if words[0] == 'p' else VELOCITY
    elif implied:
        quantity = POSITION
    if leaf and leaf <= known['quantities'][TIME]:  # 'q.time'
        quantity = TIME
    elif foreign and quantity != TIME:
        quantity = NOTHING
    unexplained = [word for k, word in enumerate(words) if word in naming or (
        word not in known_words() and not (desired and word == 'd' if k else short))]
    if quantity == NOTHING and not foreign and not {'joint', 'joints'}.isdisjoint(words) and (
            source == MEASURED or {'state', 'states'} & set(leaf)) and all(
            word.isdigit() for word in unexplained):
        quantity = POSITION  # feedBack.joints[3], joint_states: a measured joint as such
    deciding = [word for table, kind in (('quantities', quantity), ('sources', source),
                                         ('sides', side)) for word in words
                if kind and word in known[table].get(kind, ())]
    return Meaning(label, quantity, source, side, unit, ' '.join(unexplained),
                   ', '.join(dict.fromkeys(map(repr, deciding))), bool(unit), implied=implied)


def _quantity(words: Sequence[str], unit: str) -> str:
    """Return the quantity that `words` and `unit` say, '' for none: a unit outvotes words."""
    known, text = vocabulary(), [word for word in words if not word.isdigit()]
    if not known['speeds'].isdisjoint(map('_'.join, zip(text, text[1:]))):
        return VELOCITY
    kinds = _votes('quantities', words)
    moving = [kind for kind in kinds if kind in (POSITION, VELOCITY, ACCELERATION)]
    if EFFORT in kinds and moving and not unit:
        # 'current position', 'load speed': the words are sides or times of another quantity.
        strong = known['quantities'][EFFORT] - {'current', 'load', 'i', 'u'}
        kinds = [kind for kind in kinds if kind not in (
            [EFFORT] if strong.isdisjoint(words) else moving)]
    fitting = [kind for kind in kinds if kind in known['units'] and unit in units_of(kind)]
    if unit and not fitting and not {TIME, COUNTER} & set(kinds[:1]):
        fitting = [kind for kind in OF_DRIVE if unit in units_of(kind, 'rotary', 'prismatic') or (
            unit in units_of(kind, 'input') and (unit == 'A' if kind == EFFORT else not kinds))]
    quantity = next(iter([*fitting, *kinds]), NOTHING)
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
        listed: names of joints that the file lists, in place of numbers, or behind each signal.
    """
    behind = {label: f' {joint}' for joint in sorted(listed, key=len) for label in labels
              if label.endswith(f' {joint}')}
    stated = len(set(behind.values())) == len(listed) > 0 and not _are_sides(listed)
    joints = behind if stated else _product(labels, units)
    names = [label.removesuffix(joints.get(label, '')) if stated else
             label.removeprefix(joints.get(label, '')) for label in labels]
    # What all names of a log of efforts have is the controller that wrote it.
    silent = vocabulary()['writers'].intersection(*map(words_of, names))
    words = set(map(words_of, names))
    mirrored = any('l' in own and tuple('r' if word == 'l' else word for word in own) in words
                   for own in words)  # left and right
    naming = frozenset('l' if mirrored else '')
    columns = [meaning_of(name, unit, silent, naming) for name, unit in zip(names, units)]
    if silent and not any(c.quantity == EFFORT for c in columns):
        silent -= vocabulary()['sources'][SETPOINT]
        columns = [meaning_of(name, unit, silent, naming) for name, unit in zip(names, units)]
    columns = _ruled(columns)
    columns = [replace(column, label=label) for label, column in zip(labels, columns)]
    if not any(c.quantity == POSITION and c.source in (MEASURED, '') for c in columns):
        desired = {c.joint for c in columns if c.quantity == POSITION and c.source == SETPOINT}
        # Of names alike all have a goal, or none is taken: a joint would be lost.
        loose = {c.frame for c in columns if c.is_silent and c.joint not in desired}
        columns = [replace(c, quantity=POSITION, why='the joint itself')
                   if JOINT.fullmatch(c.label) or c.is_silent and c.frame not in loose else c
                   for c in columns]
    own = [column for column in columns if column.quantity in OF_DRIVE]
    parts = [(joints[c.label].strip('_./ '),) if c.label in joints else tuple(c.joint.split())
             for c in own]
    keys = dict(zip((c.label for c in own), _joints(own, parts)))
    result = [replace(column, key=keys.get(column.label, ()), joint=_joint_name(
        column.label, keys.get(column.label, ()))) for column in columns]
    return _with_listed_names(_in_step(result), () if stated else listed)


def joints_of(columns: Sequence[Meaning]) -> list[str]:
    """Return the joints that have a position or velocity, in the order of `columns`."""
    return list(dict.fromkeys(column.joint for column in columns if column.moves))


def _are_sides(joints: Iterable[str]) -> bool:
    """Return whether `joints` are the two sides of one drive by their names."""
    sides = frozenset().union(*vocabulary()['sides'].values())
    return all(sides.issuperset(words_of(joint)) for joint in joints)


def _product(labels: Sequence[str], units: Sequence[str]) -> dict[str, str]:
    """
    Return {label: name of its joint} where names are all of 'JOINT_SIGNAL'; {} if they are not.

    Names of joints may hold words of the vocabulary, 'wrist_angle' or the axes S, L, U, R, B, T;
    each stands before each of the same signals.
    """
    prefixes: dict[str, dict[str, str]] = {}  # signal: {label: joint}
    for label in labels:
        for cut in re.finditer(r'[_./ ]+', label):
            if cut.start() and re.search(r'[^\W\d]', label[cut.end():]):
                prefixes.setdefault(label[cut.end():], {})[label] = label[:cut.end()]
    signals: dict[frozenset[str], list[str]] = {}
    for signal, own in prefixes.items():
        signals.setdefault(frozenset(own.values()), []).append(signal)
    known = vocabulary()
    telling = _signal_words() | known['foreign'] | known['unit_words']
    sources = frozenset().union(*known['sources'].values())
    whole = [joints for joints, own in signals.items() if len(joints) > 1 < len(own) == len(
             {re.sub(r'\d+', '', signal) for signal in own})
             and len(joints) * len(own) >= ALL * len(labels)
             and all(sources.isdisjoint(words_of(joint)) for joint in joints)
             and any(telling.intersection(words_of(joint)) or known['containers'].issuperset(
                 words_of(joint)) for joint in joints)
             and not _are_sides(joints)]
    if not whole:
        return {}
    joints = max(whole, key=len)
    stated = dict(zip(labels, units))
    columns = _ruled([meaning_of(signal, stated[next(iter(prefixes[signal]))])
                      for signal in signals[joints]])
    nothing = [c for c in columns if c.quantity == NOTHING
               and known['foreign'].isdisjoint(words_of(c.label))]  # a temperature may be there
    if nothing or not {c.quantity for c in columns} & {POSITION, VELOCITY}:
        return {}
    return {label: joint for signal in signals[joints]
            for label, joint in prefixes[signal].items()}


def _ruled(columns: Sequence[Meaning]) -> list[Meaning]:
    """Return `columns` by what words mean together, or beside other names of the file."""
    endings = {' '.join(word for word in words_of(re.split(r'[./]', column.label)[-1])
                        if word in known_words() or word == 'd') for column in columns}
    rules = [rule for rule in vocabulary()['rules'] if endings.issuperset(rule['beside'])]
    result = []
    for column in columns:
        words = set(words_of(column.label))
        for rule in rules:
            if words.issuperset(rule['words']) and column.quantity in rule['of'] and (
                    not rule['any'] or rule['any'] & words) and not (
                    column.side and rule['is'].get('side')):
                says_unit = bool(rule['unit'] and not column.unit)
                column = replace(
                    column, **rule['is'], unit=rule['unit'] if says_unit else column.unit,
                    stated=column.stated and not says_unit,
                    joint=' '.join(w for w in column.joint.split() if w not in rule['words']),
                    why='; '.join(filter(None, (column.why, rule['why']))))
        result.append(column)
    return result


def _joints(columns: Sequence[Meaning], parts: Sequence[tuple[str, ...]]
            ) -> list[tuple[str, ...]]:
    """
    Return the words that name the joint of each column, () if there is only one.

    All words outside of the vocabulary, `parts` of each, may name it, or only those that not all
    columns of a signal have, or numbers alone, or none. The right reading fills a table of joints
    and signals: each joint has about the same signals, each of them once.
    """
    if not columns:
        return []
    # Words in all names do not name a joint; a number counts as often as all have it.
    distinct = _without_common(parts)
    signals = [(c.quantity, c.source, c.side, c.quantity == EFFORT and bool(
        c.unit in units_of(EFFORT, 'input') or set(words_of(c.label)) & set(
            vocabulary()['inputs']))) for c in columns]
    of_signal: dict[object, list[int]] = {}
    for k, signal in enumerate(signals):
        of_signal.setdefault(signal, []).append(k)
    # A word in all columns of one signal belongs to it: 'process' in 'hip_process_value'.
    own = list(distinct)
    for rows in of_signal.values():
        if len(rows) > 1:
            for k, part in zip(rows, _without_common([distinct[k] for k in rows])):
                own[k] = part
    numbers = [tuple(word for word in part if word.isdigit()) for part in own]
    # A word in a single column distinguishes two encoders, not two joints; but all columns have
    # one, and some share theirs, where they are of several joints.
    readings: list[list[tuple[str, ...]]] = [keys for keys in (numbers, own, distinct) if len(
        set(keys) - {()}) > 1 and (len(of_signal) > 1 or len(set(keys)) > 2 or all(
            any(map(str.isdigit, key)) for key in keys))]
    if not readings or not (all(numbers) or all(distinct) and any(
            key and own.count(key) > 1 for key in own)):
        readings.insert(0, [()] * len(columns))
    return max(readings, key=lambda keys: round(_filled(keys, signals), 9))


def _without_common(parts: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return `parts` without the first so many of each word that all of them have."""
    common = reduce(and_, map(Counter, parts))
    return [tuple(word for k, word in enumerate(part) if part[:k].count(word) >= common[word])
            for part in parts]


def _filled(keys: Sequence[tuple[str, ...]], signals: Sequence[tuple[object, ...]]) -> float:
    """Return the share of a table of joints and signals that is filled, less what stands twice."""
    cells = set(zip(keys, signals))
    share = len(cells) / (len(set(keys)) * len(set(signals)))
    return share - (len(keys) - len(cells)) / len(keys)


def _joint_name(label: str, key: Sequence[str]) -> str:
    """Return what messages call the joint of the column `label`, which `key` tells apart."""
    if not all(word.isdigit() for word in key):
        return '_'.join(key)
    stem = re.search(rf'[A-Za-z][\w]*?_0*{key[-1]}_joint\b', label) if key else None
    return '_'.join(stem[0].split('_')[1:] if stem else ['joint', *key] if key else ())


def _in_step(columns: Sequence[Meaning]) -> list[Meaning]:
    """Return `columns` whose numbers of joints all count from 1 where some count from 0."""
    numbers: dict[tuple[str, ...], set[int]] = {}
    signals = [(c.quantity, c.source, c.side, *(w for w in c.words if not w.isdigit()))
               if len(c.key) == 1 and c.joint == f'joint_{c.key[0]}' else () for c in columns]
    for signal, column in zip(signals, columns):
        if signal:
            numbers.setdefault(signal, set()).add(int(column.key[0]))
    begins = {min(own) for own in numbers.values()}
    whole = len({len(own) for own in numbers.values()}) == 1 and all(
        max(own) - min(own) == len(own) - 1 for own in numbers.values())
    if begins != {0, 1} or not whole or max(map(max, numbers.values())) < IN_STEP:
        return list(columns)
    return [replace(c, joint=f'joint_{int(c.key[0]) + 1}', why=f'{c.why}, {FROM_0}')
            if signal and 0 in numbers[signal] else c for signal, c in zip(signals, columns)]


def _with_listed_names(columns: Sequence[Meaning], names: Sequence[str]) -> list[Meaning]:
    """Return `columns` with the `names` that a file lists in place of the numbers of joints."""
    numbers = {column.joint: int(column.joint.removeprefix('joint_')) for column in columns
               if column.joint.removeprefix('joint_').isdigit()}
    first = min(1, *numbers.values()) if numbers else 1  # columns count from 0 or from 1
    if not numbers or max(numbers.values()) - first >= len(names):
        return list(columns)
    return [replace(column, joint=names[numbers[column.joint] - first])
            if column.joint in numbers else column for column in columns]
