# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Between ROS messages and the core: samples, estimates, definitions of message types."""
from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
import importlib
import importlib.util
import math
from pathlib import Path
import re
from typing import Any, TypeAlias

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from gearbox_monitor.estimation.estimates import Estimate, Sample
from gearbox_monitor.health.checks.outcome import Outcome
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.topics import joint_values, Signal, TRANSMISSION
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


def joint_values_of(message: JointState, joint: str) -> tuple[float, float] | None:
    """Return (position, effort) of `joint` in `message`; None if it does not name the joint."""
    if joint not in message.name:
        return None
    index = message.name.index(joint)
    return _at(message.position, index), _at(message.effort, index)


def to_paired(stamp_ns: int, joints: Sequence[str], motor: tuple[float, float],
              arm: tuple[float, float] | None) -> JointState:
    """
    Return the JointState of motor and arm.

    Args:
        stamp_ns: of the message, ns.
        joints: names of motor and arm.
        motor: position (rad) and effort (N m).
        arm: position and effort; None = not measured.

    Returns:
        The message.

    """
    position, effort = zip(motor, arm or (NAN, NAN))
    return JointState(header=Header(stamp=to_time(stamp_ns)), name=list(joints),
                      position=array('d', position), effort=array('d', effort))


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
        self._names: list[str] | None = None
        self._motor = self._arm = -1

    def sample(self, message: JointState, stamp_ns: int) -> tuple[Sample, RawSample] | None:
        """
        Return the Sample of a message, and what it is made of; None if it names neither joint.

        message: the JointState; stamp_ns: its stamp.
        """
        if message.name != self._names:
            self._names = names = list(message.name)
            self._motor, self._arm, *self._robot = (
                names.index(joint) if joint in names else -1
                for joint in (self.motor_joint, self.arm_joint, *self._robot_joints))
        motor, arm = self._motor, self._arm
        if motor < 0 and arm < 0:
            return None
        position, effort = message.position, message.effort
        x1, x2, u, load = (_at(position, motor), _at(position, arm), _at(effort, motor),
                           _at(effort, arm))
        return (Sample(stamp_ns, (u * self._effort_scale, load), (x1 / self._gear_ratio, x2),
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
                    ) -> list[JointState]:
    """
    Return the JointStates of `signal` for the `estimates` of one sample of several gearboxes.

    Values with the same stamp are in one message, in the order of the gearboxes.
    """
    parts: dict[int, tuple[list[str], list[float], list[float], list[float]]] = {}
    for names, estimate in estimates:
        for stamp_ns, row in (estimate.smoothed if signal.smoothed
                              else ((estimate.stamp_ns, estimate.row),)):
            part = parts.setdefault(stamp_ns, ([], [], [], []))
            joints, *fields = joint_values(signal, row, names.joints, names.gear_ratio)
            part[0].extend(joints)
            for whole, values in zip(part[1:], fields):
                whole.extend(values)
    messages = []
    for stamp_ns, (joints, position, velocity, effort) in parts.items():
        message = JointState()
        message.header.stamp = to_time(stamp_ns)
        message.name = joints
        message.position = array('d', position)
        message.velocity = array('d', velocity)
        message.effort = array('d', effort)
        messages.append(message)
    return messages


def serialised(signal: Signal, estimates: Sequence[tuple[GearboxNames, Estimate]]
               ) -> Sequence[JointState | bytes]:
    """
    Return what to_joint_states makes of a `signal` of several gearboxes, serialised at once.

    As JointStates where a joint was not measured or the stamps differ; `estimates` as there.
    """
    if signal.smoothed:
        stamps = [stamp_ns for stamp_ns, _ in estimates[0][1].smoothed]
        if any([stamp_ns for stamp_ns, _ in e.smoothed] != stamps for _, e in estimates):
            return to_joint_states(signal, estimates)
        if not stamps:
            return []
        rows = np.array([[row for _, row in e.smoothed] for _, e in estimates]).swapaxes(0, 1)
    else:
        stamps = [estimates[0][1].stamp_ns]
        if any(e.stamp_ns != stamps[0] for _, e in estimates):
            return to_joint_states(signal, estimates)
        rows = np.array([[e.row for _, e in estimates]])
    position = signal.positions(rows)
    if TRANSMISSION not in signal.joints and np.isnan(position).any():
        return to_joint_states(signal, estimates)
    joints, scale = _joints(signal, *[names for names, _ in estimates])
    return encode_joint_states(
        stamps, joints, position * scale,
        rows[..., signal.velocity] * scale if signal.velocity else None,
        rows[..., signal.effort] if signal.effort else None)


@lru_cache(maxsize=256)
def _joints(signal: Signal, *gearboxes: GearboxNames) -> tuple[tuple[str, ...], Array]:
    """Return the joints of `gearboxes` in a message of `signal`, and the scale of each."""
    return tuple(names.joints[joint] for names in gearboxes for joint in signal.joints), np.array([
        [signal.scale(joint, names.gear_ratio) for joint in signal.joints]
        for names in gearboxes])


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
