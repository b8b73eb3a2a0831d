# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Replay of a simulated recording: what "benchmarks speed" and test/system/scale.py measure."""
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import json
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader

from benchmarks.memory import peak_bytes
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.replay import BagOutput, CsvTable, ParquetTable, ReplaySummary
from gearbox_monitor.recordings.write import BagWriter

RATE = 1000.0  # Hz
TOPIC, JOINTS = '/joint_states', ('motor', 'arm')
FIRST_NS, STEP_NS = 1_700_000_000_000_000_000, 1_000_000
FIXED = {'arm_load': 'none'}  # the EKF of 5 states, as in the other rows
AT_ONCE = 100_000  # messages encoded at once
SECONDS, FEW = 600.0, 10.0  # length of the recording, and of that which rosbags decodes


def write_recording(path: Path, seconds: float, compression: str = 'lz4') -> None:
    """
    Write a bag of a simulated drive that is measured and commanded at RATE.

    Args:
        path: new bag.
        seconds: length.
        compression: lz4, zstd or none.
    """
    count = int(seconds * RATE)
    run = simulate(DriveModel(), Excitation().torque(np.arange(count) / RATE), 1.0 / RATE,
                   Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=0)
    effort = np.column_stack([run.u, np.full(count, np.nan)])
    # By size alone, as when messages come at their own time.
    with BagWriter(path, compression, chunk_seconds=np.inf) as writer:
        writer.add_topic(TOPIC, 'sensor_msgs/msg/JointState')
        for begin in range(0, count, AT_ONCE):
            part = slice(begin, begin + AT_ONCE)
            stamps = FIRST_NS + STEP_NS * np.arange(count)[part]
            for stamp, raw in zip(stamps.tolist(), encode_joint_states(
                    stamps, JOINTS, run.y[part], effort=effort[part])):
                writer.write(TOPIC, stamp, raw)


def replayed(bag: str | Path, whole: bool, parameters: Mapping[str, Any] | None = None,
             kind: Callable[[Path, Player], Any] = ParquetTable) -> int:
    """
    Replay a bag into a temporary output; return the number of samples.

    Args:
        bag: to replay.
        whole: with smoother, trust and drift.
        parameters: of the estimator, where they differ from the defaults.
        kind: of the output.
    """
    with tempfile.TemporaryDirectory() as folder, open_bag(bag) as reader:
        player = Player(reader, None, parameters, whole=whole)
        summary = ReplaySummary(player)
        output = kind(Path(folder) / 'out', player)
        player.run([summary, output])
        output.close()
        return summary.data()['samples']


def decoded(bag: str | Path) -> int:
    """Read `bag` into arrays, block by block; return the number of samples."""
    count = 0
    with open_bag(bag) as reader:
        decode = reader.decoder(TOPIC, JOINTS)
        for block in reader.blocks([TOPIC]):
            count += len(decode(block).stamp_ns)
    return count


def decoded_by_rosbags(reader: AnyReader) -> int:
    """Decode all messages of rosbags' open `reader` as its users do; return their number."""
    rows = []
    for connection, _, raw in reader.messages():
        message: Any = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        rows.append((stamp.sec * 10 ** 9 + stamp.nanosec, *message.position, *message.effort))
    return len(rows)


@contextmanager
def steppers() -> Iterator[tuple[dict[str, Callable[[], int]], dict[str, float]]]:
    """Give ({row: function}, {row: samples}) on recordings that are gone afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        bag, short = Path(folder) / 'bag', Path(folder) / 'short'
        write_recording(bag, SECONDS)
        write_recording(short, FEW)
        with AnyReader([short]) as reader:
            whole: dict[str, Callable[[], int]] = {
                'replay, estimates only': lambda: replayed(bag, False, FIXED),
                'replay, to CSV': lambda: replayed(bag, False, FIXED, CsvTable),
                'replay, to a bag': lambda: replayed(bag, False, FIXED, BagOutput),
                'replay, unknown load': lambda: replayed(bag, False),
                'replay, everything': lambda: replayed(bag, True),
                'replay, decoding alone': lambda: decoded(bag)}
            yield ({**whole, 'rosbags, decoding': lambda: decoded_by_rosbags(reader)},
                   {**dict.fromkeys(whole, SECONDS * RATE), 'rosbags, decoding': FEW * RATE})


def in_a_process(bag: Path, whole: bool, warm: Path) -> tuple[float, int]:
    """
    Replay a bag in a process of its own.

    Args:
        bag: to replay.
        whole: with smoother, trust and drift.
        warm: short bag that is replayed first, uncounted: start and compilation do not depend on
            the length of a bag.

    Returns:
        CPU time (s) and peak resident memory (bytes).
    """
    done = subprocess.run(
        [sys.executable, '-m', __name__, str(Path(bag).resolve()), str(int(whole)),
         str(Path(warm).resolve())], cwd=Path(__file__).parents[1],  # where this module is
        stdout=subprocess.PIPE, text=True, check=True,
        env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'})
    result = json.loads(done.stdout)
    return result['cpu_s'], result['peak_bytes']


def main(argv: list[str]) -> None:
    """Replay the bags of in_a_process() that `argv` names."""
    bag, whole, warm = argv[0], argv[1] == '1', argv[2]
    replayed(warm, whole)
    begin = time.process_time()
    replayed(bag, whole)
    print(json.dumps({'cpu_s': time.process_time() - begin, 'peak_bytes': peak_bytes()}))


if __name__ == '__main__':
    main(sys.argv[1:])
