# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The watch of a robot over recordings: the same fold as the live node's, the same bits."""
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime, UTC
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.knowledge_file import load_watch
from gearbox_monitor.library.progress import Progress, reported
from gearbox_monitor.recordings.from_bag import names_in_log
from gearbox_monitor.recordings.joint_input import find_topic
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.robot.description import LONGEST
from gearbox_monitor.signals.stamps import require_stamps
from gearbox_monitor.watch.fold import begin, step
from gearbox_monitor.watch.record import Block, Cutter, Watch
from gearbox_monitor.watch.settings import DATED, SECOND, WATCH_SETTINGS

DESCRIPTION = 'robot_description'
STRING = 'std_msgs/msg/String'


def watch_robot(recordings: str | Path | Sequence[str | Path], model: str | Path | None = None, *,
                state: Watch | str | Path | None = None, topic: str = JOINT_STATES,
                reading: ReadOptions = BY_NAMES,
                progress: Progress | None = None) -> Watch:
    """
    Return what is known of a robot after recordings of its joint states.

    Recordings without a date follow one another.

    Args:
        recordings: of any kind, in order of time.
        model: URDF file; None: a message on robot_description in one of the recordings.
        state: of an earlier watch of this robot, or its file, which goes on; None: it begins to
            learn.
        topic: of the joint states.
        reading: how columns are read whose names and units do not say it.
        progress: called with (recordings done, recordings); None shows a bar or, in a pipe, lines.

    Raises:
        InputError: a recording cannot be read, or there is no description.
    """
    given = [recordings] if isinstance(recordings, (str, Path)) else recordings
    paths = [Path(path) for path in given]
    if not paths:
        raise InputError('recordings: none, expected at least one')
    known = load_watch(state) if isinstance(state, (str, Path)) else state
    text = urdf_in(model) if model is not None else description_in(paths, reading)
    if known is None and text is None:
        raise InputError(f'{paths[0]}: no message on {DESCRIPTION}, expected one or --model FILE')
    if known is None:
        known = begin(str(text))
    elif text not in (None, known.description):
        raise InputError('state: another robot_description than in the recordings, expected the '
                         'same robot; without a state, watch learns the robot again')
    cutter, assumed = Cutter(known.stamp_ns), list[str]()     # a block may end in the next one
    with reported('watch', progress) as report:
        for number, path in enumerate(paths):
            report(number, len(paths))
            for item in _taken(path, cutter, topic, reading, known, assumed):
                known = _after(known, item, model is None)
        for block in cutter.end():
            known, _ = step(known, block)
    return replace(known, notes=tuple(dict.fromkeys((*known.notes, *assumed))))


def _after(known: Watch, item: Block | str, described: bool) -> Watch:
    """Return the watch after a block, or a description if the recordings are `described`."""
    if isinstance(item, Block):
        return step(known, item)[0]
    return known if not described or item == known.description else begin(item)


def _renamed(path: Path, recorded: Sequence[str], known: Watch, assumed: list[str]) -> list[str]:
    """
    Return the names of joints in a recording; where it has none of the robot's, read by number.

    Args:
        path: of the recording.
        recorded: names in it.
        known: watch of the robot.
        assumed: takes a sentence on the names that were read by number or prefix.

    Raises:
        InputError: neither numbers nor one prefix tell the joints.
    """
    joints = [j.name for j in known.joints]
    if not recorded or set(joints) & set(recorded):
        return list(recorded)
    try:
        found, notes = names_in_log(str(path), recorded, [
            j.name for j in known.joints if not j.fixed], {}, hint='')
    except InputError:
        raise InputError(f'{path}: joints {", ".join(recorded)}, expected those of the '
                         f'description: {", ".join(joints)}') from None
    assumed += notes
    own = {name: joint for joint, name in found.items()}
    return [own.get(name, name) for name in recorded]


def _taken(path: Path, cutter: Cutter, topic: str, reading: ReadOptions, known: Watch,
           assumed: list[str]) -> Iterator[Block | str]:
    """
    Yield the descriptions in a recording, and the blocks that it completes, as a node takes them.

    Args:
        path: of the recording.
        cutter: that takes its messages.
        topic: of the joint states.
        reading: how columns are read.
        known: before it.
        assumed: see _renamed.

    Raises:
        InputError: it has no such topic, no message is stamped, or it begins more than a block
            before the end of the last.
    """
    described, after_ns = deque(_descriptions(path, reading)), known.stamp_ns
    with open_recording(path, reading, topic) as reader:
        topic = find_topic(reader, topic)
        recorded = reader.joint_names(topic)
        states = reader.joint_states(topic, recorded)
    require_stamps(str(path), states.stamp_ns)
    names = _renamed(path, recorded, known, assumed)
    first = int(states.stamp_ns.min()) if len(states.stamp_ns) else after_ns
    if DATED <= first < after_ns - WATCH_SETTINGS.block_ns:    # the last block was cut short
        begins, taken = (datetime.fromtimestamp(ns / SECOND, UTC) for ns in (first, after_ns))
        raise InputError(f'{path}: begins at {begins:%Y-%m-%d %H:%M:%S} UTC, expected a time '
                         f'after what was taken, {taken:%Y-%m-%d %H:%M:%S}')
    yield from cutter.before(first)
    for row, (stamp, logged) in enumerate(zip(states.stamp_ns.tolist(), states.log_ns.tolist())):
        while described and described[0][0] <= logged:
            yield described.popleft()[1]
        yield from cutter.take(stamp, names, states.position[row], states.velocity[row],
                               states.effort[row])
    yield from (text for _, text in described)


def description_in(paths: Sequence[Path], reading: ReadOptions = BY_NAMES) -> str | None:
    """Return the first description in `paths`, read as `reading` says, None without any."""
    return next((text for path in paths for _, text in _descriptions(path, reading)), None)


def _descriptions(path: Path, reading: ReadOptions) -> Iterator[tuple[int, str]]:
    """Yield (when it was recorded, ns; URDF) of each description in a recording."""
    with open_recording(path, reading) as reader:
        found = [t for t in reader.topics if t.rpartition('/')[2] == DESCRIPTION]
        for _, logged, _, raw in reader.messages(found[:1]) if found else ():
            yield logged, str(reader.decode(STRING, raw).data)


def urdf_in(model: str | Path) -> str:
    """Return the URDF in the file `model`. Raises InputError."""
    try:
        return Path(model).read_bytes()[:LONGEST + 1].decode('utf-8', 'replace')
    except OSError as error:
        raise InputError(f'{model}: {error.strerror}, expected a URDF file') from None
