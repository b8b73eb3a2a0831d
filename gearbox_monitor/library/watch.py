# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The watch of a robot over recordings: the same fold as the live node's, the same bits."""
from collections.abc import Callable, Sequence
from datetime import datetime, UTC
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.watch_file import load_watch
from gearbox_monitor.recordings.joint_input import find_topic
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.robot.description import LONGEST
from gearbox_monitor.watch.block import Block, Cutter
from gearbox_monitor.watch.fold import begin, step
from gearbox_monitor.watch.record import Watch
from gearbox_monitor.watch.settings import DATED, SECOND, WATCH_SETTINGS

DESCRIPTION = 'robot_description'
STRING = 'std_msgs/msg/String'


def watch_robot(recordings: str | Path | Sequence[str | Path], model: str | Path | None = None, *,
                state: Watch | str | Path | None = None, topic: str = JOINT_STATES,
                reading: ReadOptions = BY_NAMES,
                progress: Callable[[int, int], None] = lambda done, total: None) -> Watch:
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
        progress: called with (recordings done, recordings).

    Raises:
        InputError: a recording cannot be read, or there is no description.
    """
    given = [recordings] if isinstance(recordings, (str, Path)) else recordings
    paths = [Path(path) for path in given]
    if not paths:
        raise InputError('recordings: none, expected at least one')
    known = load_watch(state) if isinstance(state, (str, Path)) else state
    if known is None:
        known = begin(_description(paths, model, reading))
    cutter = Cutter()       # a block may end in the next recording
    for number, path in enumerate(paths):
        progress(number, len(paths))
        with open_recording(path, reading, topic) as reader:
            blocks = blocks_in(reader, cutter, topic, known.stamp_ns)
        for block in blocks if path is not paths[-1] else [*blocks, *cutter.end()]:
            known, _ = step(known, block)
    progress(len(paths), len(paths))
    return known


def blocks_in(reader: BagReader, cutter: Cutter, topic: str = JOINT_STATES, after_ns: int = 0
              ) -> list[Block]:
    """
    Return the blocks that an open bag completes.

    Args:
        reader: of the bag.
        cutter: that takes its messages.
        topic: of the joint states.
        after_ns: end of what was taken before; a recording without a date is moved behind it.

    Raises:
        InputError: the bag has no such topic, or begins before `after_ns`.
    """
    topic = find_topic(reader, topic)
    names = reader.joint_names(topic)
    states, out = reader.joint_states(topic, names), list[Block]()
    first, length = int(states.stamp_ns.min(initial=after_ns)), WATCH_SETTINGS.block_ns
    later = 0
    if first < after_ns:
        if first >= DATED:
            begins, taken = (datetime.fromtimestamp(ns / SECOND, UTC) for ns in (first, after_ns))
            raise InputError(f'{reader.path}: begins at {begins:%Y-%m-%d %H:%M:%S} UTC, expected '
                             f'a time after what was taken, {taken:%Y-%m-%d %H:%M:%S}')
        later = (after_ns // length + 1 - first // length) * length
    for row, stamp in enumerate((states.stamp_ns + later).tolist()):
        out += cutter.take(stamp, names, states.position[row], states.velocity[row],
                           states.effort[row])
    return out


def _description(paths: Sequence[Path], model: str | Path | None, reading: ReadOptions) -> str:
    """Return the URDF in the file `model`, or of the first bag that has one."""
    if model is not None:
        try:
            return Path(model).read_bytes()[:LONGEST + 1].decode('utf-8', 'replace')
        except OSError as error:
            raise InputError(f'{model}: {error.strerror}, expected a URDF file') from None
    for path in paths:
        with open_recording(path, reading) as reader:
            found = [t for t in reader.topics if t.rpartition('/')[2] == DESCRIPTION]
            for _, _, _, raw in reader.messages(found[:1]) if found else ():
                return str(reader.decode(STRING, raw).data)
    raise InputError(f'{paths[0]}: no message on {DESCRIPTION}, expected one or --model FILE')
