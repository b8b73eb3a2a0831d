"""
Compile numerical kernels with numba, or run the same source interpreted.

numba is optional at run time (an apt-installed Jazzy on Ubuntu 24.04 has none). The environment
variable ``GEARBOX_MONITOR_JIT=0`` chooses the interpreted kernels where numba is installed, too.
``fastmath`` stays off: a monitor needs NaN checks, and replay needs the same bits as live.
"""
import hashlib
import os
from pathlib import Path

try:
    if os.environ.get('GEARBOX_MONITOR_JIT', '1') == '0':
        raise ImportError('switched off by GEARBOX_MONITOR_JIT=0')
    import numba
    COMPILED = True
except ImportError:
    COMPILED = False


def jit(function):
    """Return `function` compiled (cached on disk where a directory is writable) or as it is."""
    if not COMPILED:
        return function
    try:
        return numba.njit(cache=True, error_model='numpy')(function)
    except RuntimeError:  # no writable place for the cache: compile at each start instead
        return numba.njit(error_model='numpy')(function)


def _drop_stale_cache():
    """
    Remove cached kernels when any source has changed since they were made.

    numba looks only at the file of the kernel itself, not at those of the kernels it calls.
    """
    root = Path(__file__).parent
    sources = sorted(path for folder in ('.', 'drive', 'filters', 'trust')
                     for path in (root / folder).glob('*.py'))
    states = [(path.name, path.stat().st_mtime_ns, path.stat().st_size) for path in sources]
    digest = hashlib.sha256(repr(states).encode()).hexdigest()
    stamp = root / '__pycache__' / 'kernels.sha256'
    try:
        if stamp.is_file() and stamp.read_text(encoding='ascii') == digest:
            return
        for path in root.rglob('__pycache__/*.nb[ic]'):
            path.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(digest, encoding='ascii')
    except OSError:  # not ours to write: numba then keeps its cache elsewhere, or none
        pass


if COMPILED:
    _drop_stale_cache()
