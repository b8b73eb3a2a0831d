# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a column of a recording is by its name and unit alone: quantity, source, side and joint.

A name is cut into words; words of the vocabulary say what is measured, how it came about and on
which side of the gear, and the others are the name or number of the joint.
"""
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import re

from gearbox_monitor.recordings.importer.unit_table import (
    ANGLE, ANGULAR_SPEED, COUNT_RATE, COUNTS, DRIVE_INPUT, FORCE, LENGTH, scaled_unit, SPEED,
    standard_unit, TIME, TORQUE)

POSITION, VELOCITY, EFFORT, ACCELERATION, TIMES, COUNTER, NOTHING = (
    'position', 'velocity', 'effort', 'acceleration', 'time', 'counter', '')
MEASURED, SETPOINT, FILTERED, MODEL, PART, SENSOR, ERROR = (
    'measured', 'setpoint', 'filtered', 'model', 'part', 'sensor', 'error')
_QUANTITIES = {
    ACCELERATION: 'acceleration accelerations acc accel ddq qdd qddot qacc ddtheta',
    VELOCITY: 'velocity velocities vel vels velo speed speeds dq qd qdot dqdt omega rpm qvel jvel '
              'dtheta thetadot geschwindigkeit drehzahl',
    EFFORT: 'torque torques tau taus trq effort efforts eff qfrc current currents curr cur '
            'amps force forces moment moments load pwm duty i iq u tor drehmoment kraft strom '
            'motorcurrent',
    POSITION: 'position positions pos angle angles theta q qm ql phi enc encoder encoders jpos '
              'qpos winkel lage',
    TIMES: 't time times timestamp timestamps stamp stamps sec secs seconds nsec nsecs nanosec '
           'nanosecs nanoseconds nano ms us ns clock elapsed zeit when epoch date datetime utc tm '
           'datum zeitstempel',
    COUNTER: 'index idx id row seq seqno sequence frame frames counter count cnt step steps '
             'sample samples nr number episode task',
}
_SOURCES = {
    ERROR: 'error err errors deviation residual diff delta limit limits max min lower upper',
    PART: 'fric friction grav gravity coriolis comp compensation ff feedforward ext external '
          'disturbance offset bias reaction brake inertia passive constraint',
    MODEL: 'pred predicted prediction model modelled modeled sim simulated identified hat',
    SETPOINT: 'desired des set setpoint setpoints sp goal goals target targets tgt ref reference '
              'references cmd cmds command commands commanded action actions soll sollwert '
              'control ctrl con demand ipo planned profile limited interpolated',
    FILTERED: 'filt filtered filter smooth smoothed lp lowpass butter savgol',
    SENSOR: 'sensor transducer loadcell shaft ft jts straingauge',
    MEASURED: 'measured meas msr act actual present ist istwert real raw feedback fb current '
              'estimate estimated est',
}
_SIDES = {
    'motor': 'motor mot rotor input drive servo m qm',
    'arm': 'arm link output out load abtrieb l ql',
}
# Words that neither tell a quantity nor name a joint.
_CONTAINERS = ('joint joints states state observation observations field data msg header dof dofs '
               'jnt actuator actuators low lowstate interfaces value values points topic axis '
               'axes j a foc axisq signal controller robot rt base feedback info the of in')
# Quantities of what is no joint: a tool's pose, an inertial unit, an environment.
_FOREIGN = ('tcp pose cartesian cart ee tool imu gyro accelerometer quaternion quat foot contact '
            'temperature temp temps volts volt voltage bus status mode enable enabled fault '
            'faults ready success rate iteration priority wrench twist camera image reward done '
            'payload jacobian vector scaling digital analog runtime safety power gripper battery '
            'kp kd kv gain gains gtau torque_enable')
_UNIT_WORDS = ('deg degrees rad rads rpm nm mm ms us ns s sec turns rev revs tick ticks counts '
               'cts inc percent amps a ma mrad n v permille')
_SETS: dict[str, dict[str, frozenset[str]]] = {
    name: {kind: frozenset(words.split()) for kind, words in table.items()}
    for name, table in (('quantity', _QUANTITIES), ('source', _SOURCES), ('side', _SIDES))}
_CONTAINER, STRANGE, _UNITS = (frozenset(words.split()) for words in (
    _CONTAINERS, _FOREIGN, _UNIT_WORDS))
_GERMAN = re.compile(r'(?i)(?<![a-z])(ist|soll|motor|achs|gelenk)'
                     r'(position|winkel|lage|drehzahl|geschwindigkeit|moment|strom)')
_WORD = re.compile(r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+|[^\W\d_]+')
UNITS: dict[str, Mapping[str, float]] = {
    POSITION: {**ANGLE, **LENGTH, **COUNTS},
    VELOCITY: {**ANGULAR_SPEED, **SPEED, **COUNT_RATE},
    EFFORT: {**TORQUE, **FORCE, **DRIVE_INPUT},
    TIMES: TIME,
}
# Words of an effort that is no torque but what a constant turns into one: their units.
INPUTS = {'current': 'A', 'currents': 'A', 'curr': 'A', 'cur': 'A', 'amps': 'A', 'i': 'A',
          'iq': 'A', 'strom': 'A', 'motorcurrent': 'A', 'load': '', 'pwm': '', 'duty': '',
          'u': ''}
# Drivers that state no unit in their files, by words that their names contain.
CONVENTIONS: tuple[tuple[frozenset[str], str, str, str], ...] = (
    (frozenset({'pos', 'estimate'}), POSITION, 'turns', 'ODrive writes turns'),
    (frozenset({'vel', 'estimate'}), VELOCITY, 'turns/s', 'ODrive writes turns/s'),
    (frozenset({'ai', 'pos'}), POSITION, 'deg', 'KUKA RSI writes degrees'),
    (frozenset({'as', 'pos'}), POSITION, 'deg', 'KUKA RSI writes degrees'),
)
# ... by names that stand beside each other in one file.
NEIGHBOURS: tuple[tuple[set[str], dict[str, str], str], ...] = (
    ({'position', 'velocity', 'q_current', 'd_current'},
     {POSITION: 'turns', VELOCITY: 'turns/s'}, 'moteus writes revolutions'),
    ({'position', 'velocity', 'q_A', 'd_A'},
     {POSITION: 'turns', VELOCITY: 'turns/s'}, 'moteus writes revolutions'),
    ({'position', 'velocity', 'torque', 'current_motor'},
     {POSITION: 'deg', VELOCITY: 'deg/s'}, 'Kortex writes degrees'),
)


JOINT = re.compile(r'(?i)(joint|axis|j|a)[ _]?\d+')
ALL = 0.8  # share of the names of a file that a product of joints and signals makes up


@dataclass(frozen=True)
class Meaning:
    """
    What the name and unit of a column say.

    quantity: of the constants above, '' = none of a drive; source: how it came about; side:
    'motor', 'arm' or ''; unit: standard name, '' = not stated; scale: of the unit in the name, as
    in '0.229rpm'; joint: '' where the name tells none; why: words that decided; key: words of the
    name that tell the joint; implied: a setpoint without a word of what, so of the position.
    """

    label: str
    quantity: str
    source: str
    side: str
    unit: str
    scale: float
    joint: str
    why: str
    stated: bool = True
    key: tuple[str, ...] = ()
    implied: bool = False

    @property
    def own_words(self) -> frozenset[str]:
        """Words of the name that tell the joint; empty where there is only one."""
        return frozenset({*self.key, *words_of(self.joint), 'joint'}) if self.joint else \
            frozenset()

    @property
    def words(self) -> list[str]:
        """Words of the name without those of the joint."""
        return [word for word in words_of(self.label) if word not in self.own_words]


def words_of(label: str) -> list[str]:
    """Return the words of a `label` in lower case; 'motorPos_rad[3]' is motor, pos, rad and 3."""
    plain = re.sub(r'[\[(<{]([^\])>}]*)[\])>}]', _inside, label)
    plain = re.sub(r'(?i)feed[ _-]?back', 'feedback', plain)
    plain = _GERMAN.sub(r'\1 \2', plain)
    return [word.lower() for word in _WORD.findall(plain)]


def _inside(match: re.Match[str]) -> str:
    """Return what brackets hold if it is a number or a name, blank for a unit."""
    text = match[1].strip()
    return ' ' if not text.isdigit() and (scaled_unit(text)[1] or text in ('-', '?', '')) \
        else f' {text} '


def meaning_of(label: str, unit: str = '') -> Meaning:
    """
    Return the Meaning of the name `label`; `unit` is one that the file states elsewhere.

    The joint is left as the words that the vocabulary does not know; see `meanings`.
    """
    words = words_of(label)
    axis = _rotating_axis(words)
    words = [word for word in words if word not in axis]
    scale, stated = scaled_unit(label, True)
    unit = standard_unit(unit) or stated
    abbreviations: set[str] = set()

    def _of(table: str, skipped: frozenset[str] = frozenset()) -> list[str]:
        return [kind for kind, names in _SETS[table].items()
                if any(word in names and word not in skipped for word in words)]
    quantity = _quantity(words, unit)
    leaf = words_of(re.split(r'[./]', label.rstrip('./'))[-1])
    sources = _of('source', frozenset(words) - frozenset(leaf)) or _of('source')
    if 'd' in words[1:] and quantity in (POSITION, VELOCITY, EFFORT, ACCELERATION):
        sources.insert(0, SETPOINT)  # q_d, tau_J_d: desired
        abbreviations.add('d')
    if {'controller', 'input'} <= set(words) or ('as', 'pos') in zip(words, words[1:]):
        sources = [SETPOINT]  # of an ODrive, of KUKA RSI
    if 'd' in axis:
        sources = [PART]  # makes no torque
    if len(sources) > 1:
        sources = [source for source in sources if source != MEASURED] or sources
    implied = quantity == NOTHING and SETPOINT in sources
    if implied:
        quantity = POSITION
    if 'current' in words and quantity in (POSITION, VELOCITY) and sources == [MEASURED]:
        abbreviations.add('current')
    source = sources[0] if sources else ''
    if quantity == EFFORT and source == MEASURED and not set(words) - {'current', 'currents'} & \
            _SETS['source'][MEASURED]:
        source = ''
    side = next(iter(_of('side', frozenset({'load', 'drive', 'input'}) if quantity == EFFORT
                         else frozenset({'drive'}))), '')
    if 'observation' in words and 'state' in words and quantity == NOTHING:
        quantity = POSITION
    if set(words) & STRANGE and quantity != TIMES:
        quantity = NOTHING
    vocabulary = _CONTAINER | _UNITS | abbreviations | frozenset().union(
        *(names for table in _SETS.values() for names in table.values()))
    first = words[0] if words else ''
    if quantity == NOTHING and first in ('p', 'v') and not set(words) & STRANGE:
        quantity, abbreviations = (POSITION if first == 'p' else VELOCITY), {first}
    unexplained = [word for k, word in enumerate(words) if word not in vocabulary
                   and not (k == 0 and word in abbreviations)]
    if quantity == NOTHING and source == MEASURED and {'joint', 'joints'} & set(words) and all(
            word.isdigit() for word in unexplained) and not set(words) & STRANGE:
        quantity = POSITION  # feedBack.joints[3]: what is measured of a joint as such
    return Meaning(label, quantity, source, side, unit, scale, ' '.join(unexplained),
                   _why(words, quantity, source, side), bool(unit), implied=implied)


def run_of(name: str) -> tuple[bool, tuple[str, ...]]:
    """
    Return (whether the `name` of a file calls it setpoints, its words that tell runs apart).

    Those of parts of a torque do: 'friction_gravity_control' is a run to learn friction.
    """
    words, sources = words_of(name), _SETS['source']
    plain = _CONTAINER | sources[SETPOINT] | sources[MEASURED] | frozenset().union(
        *_SETS['quantity'].values(), *_SETS['side'].values())
    return not sources[SETPOINT].isdisjoint(words), tuple(w for w in words if w not in plain)


def _rotating_axis(words: Sequence[str]) -> set[str]:
    """Return which of 'd' and 'q' are the axes of a current or voltage, as in 'q_current'."""
    return {'d', 'q'} & set(words) if set(words) & {
        'current', 'currents', 'curr', 'voltage', 'voltages', 'id', 'vq', 'vd'} and not (
        'q' in words and 'd' in words) else set()


def _quantity(words: Sequence[str], unit: str) -> str:
    """Return the quantity that `words` and `unit` say, '' for none."""
    pairs = set(zip(words, words[1:]))
    if pairs & {('q', 'dot'), ('theta', 'dot'), ('d', 'q'), ('d', 'theta'), ('d', 'pos')}:
        return VELOCITY
    kinds = [kind for kind in _SETS['quantity'] if _SETS['quantity'][kind] & set(words)]
    moving = [kind for kind in kinds if kind in (POSITION, VELOCITY, ACCELERATION)]
    if EFFORT in kinds and moving and not unit:
        # 'current position', 'load speed': the words are sides or times of another quantity.
        strong = set(words) & _SETS['quantity'][EFFORT] - {'current', 'load', 'i', 'u'}
        kinds = [kind for kind in kinds if kind not in (moving if strong else [EFFORT])]
    by_unit = [kind for kind in kinds if unit in UNITS.get(kind, ())]
    if unit and not by_unit:
        by_unit = [kind for kind in (POSITION, VELOCITY, EFFORT) if unit in UNITS[kind]
                   and not (unit in COUNTS and kinds) and not (unit in DRIVE_INPUT and
                                                               unit != 'A')]
        if by_unit and kinds and kinds[0] in (TIMES, COUNTER):
            by_unit = []
    order = [*by_unit, *kinds]
    quantity = order[0] if order else NOTHING
    if quantity == COUNTER and TIMES in kinds:
        return TIMES
    return quantity


def _why(words: Sequence[str], quantity: str, source: str, side: str) -> str:
    """Return the words of a name that decided, for a table."""
    pairs = (('quantity', quantity), ('source', source), ('side', side))
    deciding = [word for table, kind in pairs for word in words
                if kind and word in _SETS[table].get(kind, ())]
    return ', '.join(dict.fromkeys(repr(word) for word in deciding))


def meanings(labels: Sequence[str], units: Sequence[str] | None = None) -> list[Meaning]:
    """
    Return the Meaning of each of the names of one file, with the joint that it belongs to.

    Joints are distinguished by words outside of the vocabulary: a number that counts through
    a family of names alike ('q_0' ... 'q_6'), or a name that stands beside several quantities.

    Args:
        labels: names of the columns.
        units: units that the file states, '' for none; None: no units.
    """
    units = units or [''] * len(labels)
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
    return _without_other_vectors(result)


def _product(labels: Sequence[str], units: Sequence[str]) -> dict[str, tuple[str, Meaning]]:
    """
    Return {label: (joint, Meaning of the rest)} where names are all of 'JOINT_SIGNAL'.

    Names of joints may hold words of the vocabulary, 'wrist_angle' or the axes S, L, U, R, B, T;
    what tells them is that each stands before each of the same signals.
    """
    prefixes: dict[str, set[str]] = {}
    sides = frozenset().union(*_SETS['side'].values())
    splits = [(label, unit, cut) for label, unit in zip(labels, units)
              for cut in re.finditer(r'[_./ ]+', label) if cut.start()]
    for label, _, cut in splits:
        prefixes.setdefault(label[cut.end():], set()).add(label[:cut.start()])
    counts = Counter(frozenset(joints) for joints in prefixes.values())
    whole = [(joints, n) for joints, n in counts.items() if len(joints) > 1 < n
             and len(joints) * n >= ALL * len(labels)
             and not any(set(words_of(joint)) & named for joint in joints
                         for named in _SETS['source'].values())
             and not all(set(words_of(joint)) <= sides for joint in joints)]
    if not whole:
        return {}
    joints, _ = max(whole, key=lambda pair: len(pair[0]))
    splits = [(label, unit, cut) for label, unit, cut in splits
              if prefixes[label[cut.end():]] == joints]
    signals = _by_convention([meaning_of(label[cut.end():], unit) for label, unit, cut in splits])
    quantities = {meaning.quantity for meaning in signals}
    if not quantities & {POSITION, VELOCITY} or any(
            signal.quantity == NOTHING and not STRANGE & set(words_of(signal.label))
            for signal in signals):  # a temperature of each joint may stand beside them
        return {}
    return {label: (label[:cut.start()], meaning)
            for (label, _, cut), meaning in zip(splits, signals)}


def _has_signal_words(joint: str) -> bool:
    """Return whether the name of a joint holds words that a signal may be called by."""
    words = set(words_of(joint))
    return any(words & named for table in ('quantity', 'side')
               for named in _SETS[table].values()) or bool(words & (STRANGE | _UNITS))


def _without_other_vectors(columns: Sequence[Meaning]) -> list[Meaning]:
    """
    Return `columns`, of which those of a vector are of no joint that all joints have a rival of.

    'base_pos 1' to 'base_pos 3' beside 'dof_pos 1' to 'dof_pos 12' are no joints' positions.
    """
    joints = {column.joint for column in columns if column.joint}
    vectors: dict[tuple[str, ...], set[str]] = {}
    for column in columns:
        vectors.setdefault(_vector(column), set()).add(column.joint)
    whole = {vector[:3] for vector, own in vectors.items() if own >= joints}
    return [replace(column, quantity=NOTHING, joint='', key=()) if column.joint
            and 1 < len(vectors[_vector(column)]) < len(joints) and _vector(column)[:3] in whole
            else column for column in columns]


def _vector(column: Meaning) -> tuple[str, ...]:
    """Return what the columns of one vector have in common: quantity, source, side, name."""
    return column.quantity, column.source, column.side, stem_of(column)


def _by_convention(columns: Sequence[Meaning]) -> list[Meaning]:
    """Return `columns` with units that a driver is known to write without stating them."""
    names = {re.sub(r'[\W\d]+$', '', column.label.rpartition('.')[2]) for column in columns}
    beside: dict[str, tuple[str, str]] = {}
    for needed, units, reason in NEIGHBOURS:
        if needed <= names:
            beside = {quantity: (unit, reason) for quantity, unit in units.items()}
    result = []
    for column in map(_by_notation(columns), columns):
        words = set(words_of(column.label))
        unit, reason = next(((unit, reason) for needed, quantity, unit, reason in CONVENTIONS
                             if needed <= words and quantity == column.quantity),
                            beside.get(column.quantity, ('', '')))
        if unit and not column.unit:
            column = replace(column, unit=unit, why=f'{column.why}; {reason}', stated=False)
        result.append(column)
    return result


def _by_notation(columns: Sequence[Meaning]) -> Callable[[Meaning], Meaning]:
    """
    Return the function that reads a Meaning by letters that mean one thing beside each other.

    theta beside q: motor and link of an elastic joint. q_A beside d_A, i_q beside i_d: axes of a
    current. input_pos beside pos_estimate: what an ODrive is to do.
    """
    endings = {column.label.rpartition('.')[2] for column in columns}
    measured = [set(words_of(c.label)) for c in columns if c.quantity == POSITION
                and c.source in (MEASURED, '') and not c.side]
    elastic = all(any(letter in words for words in measured) for letter in ('q', 'theta'))
    estimated = any({'pos', 'estimate'} <= words for words in measured)

    def _read(column: Meaning) -> Meaning:
        words = set(words_of(column.label))
        axis = column.label.rpartition('.')[2]
        for pair in (('q_A', 'd_A'), ('i_q', 'i_d')):
            if axis in pair and set(pair) <= endings:
                return replace(column, quantity=EFFORT, unit='A', joint='', why=f"'{axis}'",
                               source='' if axis == pair[0] else PART, side='')
        if estimated and 'input' in words and column.quantity in (POSITION, VELOCITY, EFFORT):
            return replace(column, source=SETPOINT, side='')
        if elastic and not column.side and column.quantity in (POSITION, VELOCITY):
            if words & {'theta', 'dtheta'}:
                return replace(column, side='motor', why=f'{column.why}; of the motor, beside q')
            if words & {'q', 'dq'}:
                return replace(column, side='arm', why=f'{column.why}; of the link, beside theta')
        return column
    return _read


def _joints(columns: Sequence[Meaning]) -> list[tuple[str, ...]]:
    """
    Return the words that tell the joint of each column, () where there is only one.

    Of the ways to read them (all words, those of several signals, numbers alone, none) that one is
    right in which joints and signals fill a table: each joint has about the same signals, each of
    them once.
    """
    parts = [tuple(column.joint.split()) for column in columns]
    # What all names contain tells no joint; a number counts as often as all have it.
    common = Counter(*parts[:1])
    for part in parts:
        common &= Counter(part)
    distinct = [_without(part, common) for part in parts]
    signals = [(column.quantity, column.source, column.side, column.quantity == EFFORT and bool(
        column.unit in DRIVE_INPUT or set(words_of(column.label)) & set(INPUTS)))
        for column in columns]
    if not columns:
        return []
    numbers = _counting(signals, distinct)
    none: list[tuple[str, ...]] = [()] * len(columns)
    several = len(set(signals)) > 1
    signals_of: dict[str, set[object]] = {}
    for signal, part in zip(signals, distinct):
        for word in part:
            signals_of.setdefault(word, set()).add(signal)
    # A word that one signal alone has is of that signal: 'process' in 'hip_process_value'.
    shared = [tuple(word for word in part if len(signals_of[word]) > 1) for part in distinct]
    readings = [none, *(keys for keys in (numbers, shared, distinct) if len(set(keys)) > 1 and (
        several or len(set(keys)) > 2 or all(any(map(str.isdigit, key)) for key in keys)))]
    return max(readings, key=lambda keys: round(_filled(keys, signals), 9))


def _without(words: Sequence[str], excluded: Mapping[str, int]) -> tuple[str, ...]:
    """Return `words` without the first so many of each word that is excluded."""
    budget, result = Counter(excluded), []
    for word in words:
        if budget[word] > 0:
            budget[word] -= 1
        else:
            result.append(word)
    return tuple(result)


def _filled(keys: Sequence[tuple[str, ...]], signals: Sequence[tuple[object, ...]]) -> float:
    """Return the share of a table of joints and signals that is filled, less what stands twice."""
    cells = set(zip(keys, signals))
    share = len(cells) / (len(set(keys)) * len(set(signals)))
    return share - (len(keys) - len(cells)) / len(keys)


def _counting(signals: Sequence[tuple[object, ...]], parts: Sequence[tuple[str, ...]]
              ) -> list[tuple[str, ...]]:
    """Return the numbers in each of `parts` that not all columns of its signal have."""
    numbers = [tuple(word for word in part if word.isdigit()) for part in parts]
    fixed: dict[object, Counter[str]] = {}
    counts = Counter(signals)
    for signal, own in zip(signals, numbers):
        fixed[signal] = fixed.get(signal, Counter(own)) & Counter(own)
    return [own if counts[signal] == 1 else _without(own, fixed[signal])
            for signal, own in zip(signals, numbers)]


def _joint_name(label: str, key: Sequence[str]) -> str:
    """Return what messages call the joint of the column `label`, which `key` tells apart."""
    if not key:
        return ''
    if all(word.isdigit() for word in key):
        stem = re.search(rf'[A-Za-z][\w]*?_0*{key[-1]}_joint\b', label)
        return f'joint_{"_".join(key)}' if stem is None else '_'.join(
            part for part in re.split(r'_', stem[0])[1:])
    return '_'.join(key)


def with_listed_names(columns: Sequence[Meaning], names: Sequence[str]) -> list[Meaning]:
    """Return `columns` with the `names` that a file lists in place of the numbers of joints."""
    numbers = {column.joint: int(column.joint.removeprefix('joint_')) for column in columns
               if column.joint.removeprefix('joint_').isdigit()}
    first = min(1, *numbers.values()) if numbers else 1  # columns count from 0 or from 1
    if not numbers or max(numbers.values()) - first >= len(names):
        return list(columns)
    return [replace(column, joint=names[numbers[column.joint] - first])
            if column.joint in numbers else column for column in columns]


def joints_of(columns: Sequence[Meaning]) -> list[str]:
    """Return the joints that have a position or velocity, in the order of `columns`."""
    return list(dict.fromkeys(column.joint for column in columns
                              if column.quantity in (POSITION, VELOCITY) and
                              column.source in (MEASURED, FILTERED, '')))


def stem_of(meaning: Meaning) -> str:
    """Return the label of a `meaning` without the words of its joint, as '--use' takes it."""
    if not meaning.joint:
        return meaning.label
    plain = re.sub(r'[\[(<{]([^\])>}]*)[\])>}]', _inside, meaning.label)
    return '_'.join(word for word in _WORD.findall(plain)
                    if word.lower() not in meaning.own_words)
