# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
Compile a robot's file with MuJoCo, safely: what it names may be large, endless or elsewhere.

A file of plain elements costs what its length says and is compiled here. One that refers to other
files, repeats elements or holds arrays is compiled by compile_child, which has limits of CPU time
and memory, and reads only below the file's folder or a root.
"""
from collections.abc import Mapping
from functools import lru_cache
import json
from pathlib import Path
import subprocess
import sys
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators import compile_child
from gearbox_monitor.simulators.xml_edit import parse_xml

CPU_SECONDS, MEMORY = 12, 1 << 30  # of a child: s, bytes of address space
SECONDS = 60.0      # longest time that a child may take, s: it may wait for what it reads
PLAIN_SIZE = 1 << 20  # bytes of a file that is compiled here
PLAIN = frozenset((
    'mujoco', 'compiler', 'option', 'flag', 'visual', 'global', 'quality', 'headlight', 'map',
    'scale', 'rgba', 'statistic', 'default', 'asset', 'material', 'worldbody', 'body', 'frame',
    'inertial', 'joint', 'freejoint', 'geom', 'site', 'camera', 'light', 'contact', 'pair',
    'exclude', 'equality', 'connect', 'weld', 'tendon', 'fixed', 'spatial', 'actuator', 'general',
    'motor', 'position', 'velocity', 'intvelocity', 'damper', 'cylinder', 'adhesion', 'dcmotor',
    'pid', 'sensor', 'jointpos', 'jointvel', 'actuatorfrc', 'keyframe', 'key', 'robot', 'link',
    'origin', 'mass', 'inertia', 'parent', 'child', 'axis', 'limit', 'dynamics', 'mimic',
    'transmission', 'type', 'hardwareInterface', 'mechanicalReduction'))


def compiled_model(data: bytes, path: Path, root: Path | None = None,
                   locked: Mapping[str, float] | None = None) -> Any:
    """
    Return what MuJoCo compiles of an MJCF file.

    Args:
        data: bytes of the file.
        path: of the file, to whose folder the files that it names are relative.
        root: folder below which those have to lie, None for that of the file.
        locked: {joint that stands still: its position, rad or m}.

    Returns:
        mujoco.MjModel.

    Raises:
        InputError: MuJoCo refuses the file, it takes too much time or memory, or lacks a joint.

    """
    mujoco, locked = mujoco_module(), dict(locked or {})
    if _plain(data, path):
        try:
            spec = mujoco.MjSpec.from_string(data.decode('utf-8'))
            return compile_child.compiled_without(locked, spec, mujoco)
        except compile_child.Rejected as refusal:
            raise InputError(f'{path}: {refusal}') from None
        except (ValueError, RuntimeError, UnicodeDecodeError) as error:
            raise InputError(f'{path}: {compile_child.in_words(error)}') from None
    folder = path.resolve().parent
    binary = _in_child(data, path, folder, (root or folder).resolve(), json.dumps(locked))
    return mujoco.MjModel.from_binary_path('robot.mjb', {'robot.mjb': binary})


def _plain(data: bytes, path: Path) -> bool:
    """Return whether a file costs no more than its length says."""
    if len(data) > PLAIN_SIZE:
        return False
    for element in parse_xml(data, str(path)).root.walk():
        if element.tag not in PLAIN or 'muscle' in element.attributes.values() or (
                'file' in element.attributes):
            return False
    return True


@lru_cache(maxsize=16)
def _in_child(data: bytes, path: Path, folder: Path, root: Path, locked: str) -> bytes:
    """Return the compiled model of a file, from a process with limits. Raises InputError."""
    order = json.dumps({'folder': str(folder), 'root': str(root), 'cpu_seconds': CPU_SECONDS,
                        'memory': MEMORY, 'locked': json.loads(locked)}).encode() + b'\n' + data
    try:
        done = subprocess.run([sys.executable, '-P', compile_child.__file__], input=order,
                              capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f'{path}: not compiled after {SECONDS:g} s, expected a file that MuJoCo '
                         'compiles') from None
    if done.returncode == 0:
        return done.stdout
    lines = done.stderr.decode('utf-8', 'replace').splitlines()
    if done.returncode == compile_child.FAILED and lines:
        raise InputError(f'{path}: {lines[-1]}')
    raise InputError(
        f'{path}: takes more than {CPU_SECONDS} s of CPU time or {MEMORY >> 20} MB to compile, '
        'expected a smaller file (replicate, hfield, size)')
