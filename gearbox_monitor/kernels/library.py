# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find the library of compiled kernels that installation built, or build it again.

A library knows the sources that it was made of. Where they have changed (a checkout at work), the
C compiler runs at the first call, and its library is kept in the user's cache.
"""
import ctypes
from functools import cache
import hashlib
import os
from pathlib import Path
import subprocess
import sys
import tempfile
from typing import Any

from gearbox_monitor.errors import InputError

ENTRIES: list[Any] = []  # of the package, as far as it is imported
PACKAGE = Path(__file__).parents[1]
ROOMS = ('kernels', 'estimation', 'health', 'plant', 'recordings', 'robot')  # with kernels
STEMS = ('_kernels_v3', '_kernels')  # of libraries in the package, the best first
V3 = ('avx2', 'bmi2', 'fma', 'movbe')


def missing(reason: str) -> InputError:
    """Return the error of kernels that are not there and cannot be built."""
    return InputError(f'compiled kernels: {reason}, expected a C compiler: install gcc (apt) or '
                      'ziglang (pip), then install gearbox_monitor again')


@cache
def stems() -> tuple[str, ...]:
    """Return the names of libraries that this processor can run, the best first."""
    try:
        words = set(Path('/proc/cpuinfo').read_text().partition('flags')[2].partition('\n')[0]
                    .split())
    except OSError:
        words = set()
    return STEMS if words.issuperset(V3) else STEMS[1:]


def sources() -> list[str]:
    """Return the names of the files that kernels and their constants may stand in."""
    return sorted(str(path.relative_to(PACKAGE)) for room in ROOMS
                  for path in (PACKAGE / room).rglob('*.py'))


@cache
def digest(*names: str) -> str:
    """Return a digest of the files `names` of the package, of all `sources` without any."""
    seen = hashlib.sha256()
    for path in (PACKAGE / name for name in names or sources()):
        seen.update(path.read_bytes() if path.exists() else b'missing')
    return seen.hexdigest()[:24]


def notes(path: Path) -> list[str]:
    """Return digests of sources and C of the library at `path`, then their names; [] if none."""
    try:
        value = ctypes.c_char_p.in_dll(ctypes.CDLL(str(path)), 'gm_notes').value
    except (OSError, ValueError):
        return []
    return (value or b'').decode().split()


def cache_folder() -> Path:
    """Return the folder of what is built at run time; it is the user's own. Raises InputError."""
    base = os.environ.get('XDG_CACHE_HOME') or os.path.join(os.path.expanduser('~'), '.cache')
    for folder in (Path(base, 'gearbox_monitor', 'kernels'),
                   Path(tempfile.gettempdir(), f'gearbox_monitor-{os.getuid()}', 'kernels')):
        try:
            folder.mkdir(0o700, parents=True, exist_ok=True)
            if any(path.stat().st_uid != os.getuid() or path.stat().st_mode & 0o002
                   for path in (folder.parent, folder)):
                continue  # what others put there would be run
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    raise missing('no folder can keep them, set XDG_CACHE_HOME to one')


@cache
def installed() -> Any:
    """Return the library of the package; it is built where the sources have changed."""
    for stem in stems():
        found = notes(PACKAGE / f'{stem}.so')
        if found and found[0] == digest(*found[2:]):  # an old build may have left others beside
            return ctypes.CDLL(str(PACKAGE / f'{stem}.so'))
    folder = cache_folder() / digest()
    path = folder / f'{stems()[0]}.so'
    if not path.exists():
        sys.stderr.write(
            'compiling kernels: their sources are not those of the installed library\n')
        sys.stderr.flush()
        run = subprocess.run([sys.executable, '-m', 'gearbox_monitor.kernels.build', str(folder)],
                             env={**os.environ, 'PYTHONPATH': str(PACKAGE.parent),
                                  'GEARBOX_MONITOR_KERNELS': ''},
                             capture_output=True, text=True, check=False)
        if run.returncode:
            raise missing((run.stderr.strip().splitlines() or ['no library'])[-1])
    return ctypes.CDLL(str(path))
