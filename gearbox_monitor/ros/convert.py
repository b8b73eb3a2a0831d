# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Between ROS messages and the core: samples, estimates, definitions of message types."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
import importlib
import importlib.util
import math
from pathlib import Path
import re
import struct
from typing import Any, NamedTuple, TypeAlias

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
import numpy as np
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from gearbox_monitor.estimation.estimates import Estimate, Sample
from gearbox_monitor.health.alarms import Outcome
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import encode_joint_states, MAX_LAYOUTS, read_layout
from gearbox_monitor.recordings.topics import joint_values, Signal
from gearbox_monitor.ros.diagnostic_keys import published

NAN = math.nan
# Position of motor and arm, effort of motor and arm, as received.
RawSample: TypeAlias = tuple[float, float, float, float]
LEVELS = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR)


def to_time(stamp_ns: int) -> Time:
    """Return `stamp_ns` (int ns) as builtin_interfaces/Time."""
    return Time(sec=stamp_ns // 1_000_000_000, nanosec=stamp_ns % 1_000_000_000)


def _at(values: Sequence[float], index: int) -> float:
    return values[index] if 0 <= index < len(values) else NAN


def stamp_of(message: JointState | DiagnosticArray) -> int:
    """Return the stamp in the header of `message` (int ns)."""
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


class Joints(NamedTuple):
    """What a JointState tells: stamp_ns; position and effort may be shorter than the names."""

    stamp_ns: int
    name: Sequence[str]
    position: Sequence[float]
    effort: Sequence[float]

    def of(self, joint: str) -> tuple[float, float] | None:
        """Return (position, effort) of `joint`; None if the message does not name it."""
        if joint not in self.name:
            return None
        index = self.name.index(joint)
        return _at(self.position, index), _at(self.effort, index)


class JointReader:
    """Unpacks serialised JointStates: layouts that came before at once, by their bytes."""

    def __init__(self) -> None:
        # Newest first: bits that decide and what they are, values, number of positions, names.
        self._layouts: list[tuple[int, int, struct.Struct, int, tuple[str, ...]]] = []

    def __call__(self, raw: bytes) -> Joints:
        """Return the Joints of a message; raises RMWError or UnicodeDecodeError for others."""
        number = int.from_bytes(raw, 'little')
        for mask, fixed, values, count, names in self._layouts:
            if number & mask == fixed and len(raw) >= values.size:
                sec, nanosec, *numbers = values.unpack_from(raw)
                return Joints(sec * 1_000_000_000 + nanosec, names, numbers[:count],
                              numbers[count:])
        message = deserialize_message(raw, JointState)
        if (layout := read_layout(raw)) is not None:
            mask = fixed = 0
            for start, bits, word in zip(*(column.tolist() for column in (
                    layout.starts, layout.mask, layout.fixed))):
                mask, fixed = mask | bits << 8 * start, fixed | word << 8 * start
            (begin, _, end), (count, _, efforts) = layout.offsets, layout.counts
            values = struct.Struct(f'<4xiI{begin - 12}x{count}d{end - begin - 8 * count}x'
                                   f'{efforts}d')
            self._layouts.insert(0, (mask, fixed, values, count, layout.names))
            del self._layouts[MAX_LAYOUTS:]
        return Joints(stamp_of(message), message.name, message.position, message.effort)


class SampleReader:
    """
    Turn joint states into samples: find the joints by name and refer all values to the arm side.

    The joints `motor_joint` and `arm_joint` may stand in any order among others. With gear ratio N
    and torque constant kt of the DriveModel `model`, x1 = motor angle / N and u = N kt motor
    effort. robot_joints: whose positions samples hold, too.
    """

    def __init__(self, motor_joint: str, arm_joint: str, model: DriveModel,
                 robot_joints: Sequence[str] = ()) -> None:
        self.motor_joint, self.arm_joint = motor_joint, arm_joint
        self._robot_joints, self._robot = robot_joints, [-1 for _ in robot_joints]
        self._gear_ratio, self._effort_scale = model.gear_ratio, model.effort_scale
        self._names: Sequence[str] | None = None
        self._motor = self._arm = -1

    def sample(self, message: Joints) -> tuple[Sample, RawSample] | None:
        """Return the Sample of a `message` and what it is made of; None without both joints."""
        if message.name != self._names:
            self._names = names = message.name
            self._motor, self._arm, *self._robot = (
                names.index(joint) if joint in names else -1
                for joint in (self.motor_joint, self.arm_joint, *self._robot_joints))
        motor, arm = self._motor, self._arm
        if motor < 0 and arm < 0:
            return None
        position, effort = message.position, message.effort
        x1, x2, u, load = (_at(position, motor), _at(position, arm), _at(effort, motor),
                           _at(effort, arm))
        return (Sample(message.stamp_ns, (u * self._effort_scale, load),
                       (x1 / self._gear_ratio, x2),
                       tuple([_at(position, k) for k in self._robot])),
                (x1, x2, u, load))


@dataclass(frozen=True, eq=False)
class GearboxNames:
    """
    Names `joints` {TRANSMISSION, MOTOR, ARM: name} of a gearbox in messages; gear_ratio.

    Equal only to itself, so that it can be a key.
    """

    joints: Mapping[str, str]
    gear_ratio: float


def to_joint_states(signal: Signal, estimates: Iterable[tuple[GearboxNames, Estimate]]
                    ) -> list[bytes]:
    """
    Return the JointStates of `signal` for the `estimates` of one sample of several gearboxes.

    Serialised. Values with the same stamp are in one message, in the order of the gearboxes.
    """
    parts: dict[int, tuple[list[Any], ...]] = {}
    for names, estimate in estimates:
        for stamp_ns, row in (estimate.smoothed if signal.smoothed
                              else ((estimate.stamp_ns, estimate.row),)):
            part = parts.setdefault(stamp_ns, ([], [], [], []))
            found: tuple[list[Any], ...] = joint_values(
                signal, row, names.joints, names.gear_ratio)
            for whole, values in zip(part, found):
                whole.extend(values)
    return [joint_state(stamp_ns, *part) for stamp_ns, part in parts.items()]


def joint_state(stamp_ns: int, joints: Sequence[str], position: Sequence[float],
                velocity: Sequence[float], effort: Sequence[float]) -> bytes:
    """
    Return a serialised JointState.

    Args:
        stamp_ns: of the header, ns.
        joints: their names.
        position: of each, rad; all three may be empty.
        velocity: likewise, rad/s.
        effort: likewise, N m.
    """
    form, texts = _form(tuple(joints), len(position), len(velocity), len(effort))
    return form.pack(texts[0], *divmod(stamp_ns, 1_000_000_000), texts[1], *position, texts[2],
                     *velocity, texts[3], *effort)


@lru_cache(maxsize=256)
def _form(joints: tuple[str, ...], *counts: int) -> tuple[struct.Struct, list[bytes]]:
    """Return the form of a JointState with so many values, and the bytes in it that stay."""
    # Not by rclpy: behind an empty field it leaves bytes of its memory that no reader expects.
    position, velocity, effort = (np.zeros((1, n)) if n else None for n in counts)
    raw, = encode_joint_states([0], joints, position, velocity, effort)
    layout = read_layout(raw)
    assert layout is not None  # up to MAX_JOINTS
    form, texts, end = '<4siI', [raw[:4]], 12
    for offset, count in zip(layout.offsets, counts):
        form += f'{offset - end}s{count}d'
        texts.append(raw[end:offset])
        end = offset + 8 * count
    return struct.Struct(form), texts


def key_values(component: str, values: Mapping[str, Any]) -> list[KeyValue]:
    """Return the KeyValues of `component` on /diagnostics for `values` {key: value}."""
    return [KeyValue(key=key, value=text) for key, text in published(component, values)]


def to_status(name: str, outcome: Outcome, hardware_id: str) -> DiagnosticStatus:
    """
    Return the DiagnosticStatus of an outcome.

    Args:
        name: of the status.
        outcome: with level, message and values.
        hardware_id: serial number of the gearbox.

    Returns:
        The message.

    """
    return DiagnosticStatus(
        level=LEVELS[outcome.level], name=name, message=outcome.message, hardware_id=hardware_id,
        values=key_values(name.rpartition(': ')[2], outcome.figures))


def to_diagnostics(statuses: Iterable[DiagnosticStatus], stamp: Time) -> DiagnosticArray:
    """Return the DiagnosticArray of `statuses`, stamped `stamp`."""
    message = DiagnosticArray(status=list(statuses))
    message.header.stamp = stamp
    return message


def to_snapshot(name: str, hardware_id: str, snapshot: Mapping[str, str],
                stamp_ns: int) -> DiagnosticArray:
    """
    Return the DiagnosticArray that carries a snapshot.

    Args:
        name: of the node.
        hardware_id: serial number of the gearbox.
        snapshot: {name: text}, see Monitor.snapshot.
        stamp_ns: of the message, ns.

    Returns:
        The message.

    """
    status = DiagnosticStatus(
        level=DiagnosticStatus.OK, name=f'{name}: snapshot', hardware_id=hardware_id,
        message='what replay starts from',
        values=[KeyValue(key=key, value=value) for key, value in snapshot.items()])
    return to_diagnostics([status], to_time(stamp_ns))


BASE_TYPES = {'boolean': 'bool', 'double': 'float64', 'float': 'float32', 'octet': 'byte'}


def import_message(msgtype: str) -> Any:
    """
    Return the class of `msgtype` (``pkg/msg/Name``); raises ImportError if it is not installed.

    Anybody can offer a topic of any type: only packages with messages are imported.
    """
    package, _, name = msgtype.partition('/msg/')
    spec = importlib.util.find_spec(package) if package.isidentifier() else None
    folders = spec.submodule_search_locations or () if spec else ()
    if not any((Path(folder) / 'msg').is_dir() for folder in folders):
        raise ImportError(f'{msgtype}: no package with messages')
    try:
        return getattr(importlib.import_module(f'{package}.msg'), name)
    except (AttributeError, ValueError) as error:
        raise ImportError(f'{msgtype}: {error}') from None


def message_definition(msgtype: str) -> str:
    """
    Return the definition of `msgtype` with those of all types in it.

    Constants, default values and comments are left out: the bytes do not depend on them.
    """
    texts: dict[str, str] = {}
    pending = [msgtype]
    while pending:
        name = pending.pop()
        if name in texts:
            continue
        lines = []
        for field, kind in import_message(name).get_fields_and_field_types().items():
            if field == 'structure_needs_at_least_one_member':
                continue
            base, suffix = _split(kind)
            if '/' in base:
                package, short = base.split('/')
                pending.append(f'{package}/msg/{short}')
            lines.append(f'{BASE_TYPES.get(base, base)}{suffix} {field}')
        texts[name] = '\n'.join(lines)
    root = texts.pop(msgtype)
    parts = [f'\n{"=" * 80}\nMSG: {name.replace("/msg/", "/")}\n{text}'
             for name, text in texts.items()]
    return root + ''.join(parts) + '\n'


def _split(kind: str) -> tuple[str, str]:
    """Split ``sequence<double, 3>`` into (``double``, ``[<=3]``), ``double[3]`` likewise."""
    if match := re.fullmatch(r'sequence<(.*?)(?:, *(\d+))?>', kind):
        base, bound = match.groups()
        suffix = f'[<={bound}]' if bound else '[]'
    elif match := re.fullmatch(r'(.*)(\[\d+\])', kind):
        base, suffix = match.groups()
    else:
        base, suffix = kind, ''
    if match := re.fullmatch(r'(w?string)<(\d+)>', base):
        base, suffix = match[1], f'<={match[2]}{suffix}'
    return base, suffix
