# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a column of a recording is by its name and unit alone: quantity, source, side and joint.

A name is cut into words; words of the vocabulary say what is measured, how it came about and on
which side of the gear, and the others are the name or number of the joint.
"""
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import re

from gearbox_monitor.bag.importer.unit_table import (
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
    EFFORT: 'torque torques tau taus trq effort efforts current currents curr cur amps force '
            'forces moment moments load pwm duty i iq u tor drehmoment kraft strom motorcurrent',
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
          'disturbance offset bias reaction brake inertia',
    MODEL: 'pred predicted prediction model modelled modeled sim simulated identified hat',
    FILTERED: 'filt filtered filter smooth smoothed lp lowpass butter savgol',
    SETPOINT: 'desired des set setpoint setpoints sp goal goals target targets tgt ref reference '
              'references cmd cmds command commands commanded action actions soll sollwert '
              'control ctrl con demand ipo planned',
    SENSOR: 'sensor transducer loadcell shaft ft jts straingauge',
    MEASURED: 'measured meas msr act actual present istwert real raw feedback fb current '
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


@dataclass(frozen=True)
class Meaning:
    """
    What the name and unit of a column say.

    quantity: of the constants above, '' = none of a drive; source: how it came about; side:
    'motor', 'arm' or ''; unit: standard name, '' = not stated; scale: of the unit in the name, as
    in '0.229rpm'; joint: '' where the name tells none; why: words that decided.
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


def words_of(label: str) -> list[str]:
    """Return the words of a `label` in lower case; 'motorPos_rad[3]' is motor, pos, rad and 3."""
    plain = re.sub(r'[\[(<{]([^\])>}]*)[\])>}]', _inside, label)
    plain = re.sub(r'(?i)feed[ _-]?back', 'feedback', plain)
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
    sources = _of('source')
    if 'd' in words[1:] and quantity in (POSITION, VELOCITY, EFFORT, ACCELERATION):
        sources.insert(0, SETPOINT)  # q_d, tau_J_d: desired
        abbreviations.add('d')
    if {('input', 'pos'), ('input', 'vel'), ('input', 'torque')} & set(zip(words, words[1:])):
        sources = [SETPOINT]  # of an ODrive
    if 'd' in axis:
        sources = [PART]  # makes no torque
    if len(sources) > 1:
        sources = [source for source in sources if source != MEASURED] or sources
    if quantity == NOTHING and SETPOINT in sources:
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
                   _why(words, quantity, source, side), bool(unit))


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
    columns = [meaning_of(label, unit) for label, unit in
               zip(labels, units or [''] * len(labels))]
    columns = _by_convention(columns)
    of_drive = [k for k, column in enumerate(columns)
                if column.quantity in (POSITION, VELOCITY, EFFORT)]
    joints = _joints([columns[k] for k in of_drive])
    result = [replace(column, joint='') for column in columns]
    for k, joint in zip(of_drive, joints):
        result[k] = replace(columns[k], joint=joint)
    return result


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

    theta beside q: motor and link of an elastic joint. q_A beside d_A: axes of a current.
    """
    endings = {column.label.rpartition('.')[2] for column in columns}
    measured = [set(words_of(c.label)) for c in columns if c.quantity == POSITION
                and c.source in (MEASURED, '') and not c.side]
    elastic = all(any(letter in words for words in measured) for letter in ('q', 'theta'))

    def _read(column: Meaning) -> Meaning:
        words = set(words_of(column.label))
        axis = column.label.rpartition('.')[2]
        if axis in ('q_A', 'd_A') and {'q_A', 'd_A'} <= endings:
            return replace(column, quantity=EFFORT, unit='A', joint='', why="'q', 'A'",
                           source='' if axis == 'q_A' else PART)
        if elastic and not column.side and column.quantity in (POSITION, VELOCITY):
            if words & {'theta', 'dtheta'}:
                return replace(column, side='motor', why=f'{column.why}; of the motor, beside q')
            if words & {'q', 'dq'}:
                return replace(column, side='arm', why=f'{column.why}; of the link, beside theta')
        return column
    return _read


def _joints(columns: Sequence[Meaning]) -> list[str]:
    """Return the name of the joint of each column, '' where there is only one."""
    rests = [tuple(column.joint.split()) for column in columns]
    common = set(rests[0]).intersection(*map(set, rests)) if rests else set()
    # What all names contain tells no joint; of a robot's name beside the number it is kept.
    distinct = [tuple(word for word in part if word not in common) for part in rests]
    numbers = _counting(columns, distinct)
    by_family: dict[tuple[str, ...], set[tuple[str, ...]]] = defaultdict(set)
    for column, part, number in zip(columns, distinct, numbers):
        if number:
            stem = (column.quantity, column.source, column.side,
                    *(word for word in part if not word.isdigit()))
            by_family[stem].add(number)
    families = [family for family in by_family.values() if len(family) > 1]
    counted = bool(families) and all(any(family <= relative for relative in families)
                                     for family in by_family.values())
    words = {tuple(word for word in part if not word.isdigit()) for part in distinct}
    kinds: dict[tuple[str, ...], set[tuple[str, str]]] = defaultdict(set)
    for column, part in zip(columns, distinct):
        kinds[part].add((column.quantity, column.source))
    joint_words = {part for part, signals in kinds.items() if part and len(signals) > 1}
    if joint_words and len(joint_words) + (() in kinds) >= len(kinds) and (
            len(joint_words) > 1 or () not in kinds):
        keys = distinct
    elif counted or len(words) > 1 and any(numbers):
        keys = numbers
    elif len(kinds) > 1 and all(len(signals) == 1 for signals in kinds.values()) and _one_family(
            columns, distinct):
        keys = distinct  # one quantity of several joints
    else:
        return [''] * len(columns)
    if len(set(keys)) < 2:
        return [''] * len(columns)
    return [_joint_name(column.label, key) for column, key in zip(columns, keys)]


def _counting(columns: Sequence[Meaning], rests: Sequence[tuple[str, ...]]
              ) -> list[tuple[str, ...]]:
    """Return the numbers in each of `rests` that not all columns of its kind have."""
    numbers = [tuple(word for word in rest if word.isdigit()) for rest in rests]
    fixed: dict[tuple[str, str, str], set[str]] = {}
    for column, own in zip(columns, numbers):
        kind = column.quantity, column.source, column.side
        fixed[kind] = fixed.get(kind, set(own)) & set(own)
    counts = Counter((column.quantity, column.source, column.side) for column in columns)
    return [tuple(word for word in own if counts[kind] == 1 or word not in fixed[kind])
            for column, own in zip(columns, numbers)
            for kind in [(column.quantity, column.source, column.side)]]


def _one_family(columns: Sequence[Meaning], rests: Sequence[tuple[str, ...]]) -> bool:
    """Return whether one quantity was taken of more than two joints, by name."""
    count = Counter((c.quantity, c.source, c.side) for c in columns)
    return max(count.values()) > 2 and len(set(rests)) == max(count.values())


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
    own = words_of(meaning.joint) + ['joint']
    plain = re.sub(r'[\[(<{]([^\])>}]*)[\])>}]', _inside, meaning.label)
    return '_'.join(word for word in _WORD.findall(plain) if word.lower() not in own)
