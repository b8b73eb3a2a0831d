# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Name what changed in a gearbox, in a process of its own with limits: started by change_naming.

Reads a line of JSON, an Order as plain data, and packed rows from the standard input; writes the
verdict as JSON. An error is one line on the standard error, with exit code 3, and 4 where memory
is short. Imports no ROS. It ends with the process that started it.
"""
import json
import os
import resource
import signal
import sys
from typing import Any

from gearbox_monitor.ros.middleware import end_with

FAILED, SHORT_OF_MEMORY = 3, 4
NICE = 19


def limit(cpu_seconds: int, memory: int, parent: int) -> None:
    """
    Give way to all others, within limits, and end with the parent.

    Args:
        cpu_seconds: of CPU time; SIGXCPU ends the process then.
        memory: bytes of address space.
        parent: process id.
    """
    if not end_with(parent, signal.SIGKILL):
        sys.exit(FAILED)
    os.nice(NICE)
    for resource_id, soft, hard in ((resource.RLIMIT_CORE, 0, 0),
                                    (resource.RLIMIT_CPU, cpu_seconds, cpu_seconds + 5),
                                    (resource.RLIMIT_AS, memory, memory)):
        _, ceiling = resource.getrlimit(resource_id)
        if ceiling != resource.RLIM_INFINITY:
            soft, hard = min(soft, ceiling), min(hard, ceiling)
        resource.setrlimit(resource_id, (soft, hard))


def verdict_of(order: dict[str, Any], data: bytes) -> dict[str, Any]:
    """
    Return the verdict on a baseline recording and a later one, as plain data.

    Args:
        order: as change_naming.Order has it.
        data: packed rows of both recordings.

    Raises:
        InputError: a recording allows no statement; Undecided: none is possible.
    """
    from gearbox_monitor.errors import InputError
    from gearbox_monitor.files.baselines import split
    from gearbox_monitor.diagnosis.joint.diagnose import diagnose_change
    from gearbox_monitor.plant.drive import model_from_dict
    from gearbox_monitor.report.words import change_sentence
    from gearbox_monitor.ros.recording_export import MIN_STRETCH, SECOND, stretch, unpacked_rows
    from gearbox_monitor.ros.recording_export import load_of, recording_of
    blocks = split(data, (*order['reference'], *order['later']))
    count = len(order['reference'])
    parts = []
    for name, packed_rows, since_ns in (('baseline recording', blocks[:count], 0),
                                        ('recording', blocks[count:], order['since_ns'])):
        rows = stretch(unpacked_rows(packed_rows, since_ns), order['effort_delay'],
                       order['seconds'])
        if not len(rows):
            raise InputError(f'{name}: no {MIN_STRETCH:g} s without a dropout, with torque and '
                             'positions, expected them: nothing is named')
        parts.append((name, rows))
    model = model_from_dict(order['model'], 'model')
    loads = {load_of(rows, model, order['arm_load']) for _, rows in parts}
    model = model.with_(arm_load=loads.pop() if len(loads) == 1 else 'unknown')
    reference, later = (recording_of(rows, model, name) for name, rows in parts)
    span = parts[1][1]['stamp_ns'][[0, -1]]
    verdict = diagnose_change(reference, later, model).to_dict()
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return {**verdict, 'text': change_sentence(verdict), 'cpu_s': usage.ru_utime + usage.ru_stime,
            'recording': [stamp_ns / SECOND for stamp_ns in span.tolist()]}


def main() -> int:
    """Name what the standard input asks for."""
    head, _, data = sys.stdin.buffer.read().partition(b'\n')
    order = json.loads(head)
    limit(order['cpu_seconds'], order['memory'], order['parent'])
    try:
        from gearbox_monitor.errors import InputError
        verdict = verdict_of(order, data)
    except InputError as error:
        print(' '.join(str(error).split()), file=sys.stderr)
        return FAILED
    except MemoryError:
        return SHORT_OF_MEMORY
    json.dump(verdict, sys.stdout)
    return 0


if __name__ == '__main__':
    sys.exit(main())
