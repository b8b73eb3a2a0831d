"""
Compile numerical kernels with numba, or run the same source interpreted.

numba is optional at run time (an apt-installed Jazzy on Ubuntu 24.04 has none). The environment
variable ``GEARBOX_MONITOR_JIT=0`` chooses the interpreted kernels where numba is installed, too.
``fastmath`` stays off: a monitor needs NaN checks, and replay needs the same bits as live.
"""
import os

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
