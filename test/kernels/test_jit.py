# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled kernels are kept where a folder can keep them; where none can, the user is told."""
import ctypes
import os
from pathlib import Path
import subprocess
import sys

import pytest

from gearbox_monitor.kernels.jit import COMPILED, fma, interrupts_kept, usable_cache

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(not COMPILED, reason='numba is not in use')
STEP = ('from gearbox_monitor.kernels import elementary, jit\n'
        'assert elementary.arctan(1.0) > 0.7\n'
        'hits = sum(elementary.arctan.stats.cache_hits.values())\n'
        'print(jit.CACHE_FOLDER, hits, jit.CACHE_PROBLEM)')


def python(*words, **changes):
    env = {name: value for name, value in os.environ.items() if name != 'NUMBA_CACHE_DIR'}
    return subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, text=True,
                          env={**env, **{name: str(value) for name, value in changes.items()}})


@pytest.fixture
def blocked(tmp_path):
    """Return a path below a file: not even root can make a folder there."""
    (tmp_path / 'file').touch()
    return tmp_path / 'file/below'


def test_without_a_home_kernels_are_kept_among_temporary_files(blocked, tmp_path):
    for hits in '01':  # the second start finds what the first has compiled
        done = python('-c', STEP, HOME=blocked, XDG_CACHE_HOME='', TMPDIR=tmp_path)
        folder, found = done.stdout.split()
        assert found == hits and not done.stderr
        assert Path(folder).parent == tmp_path / f'gearbox_monitor-{os.getuid()}'
        assert Path(folder).stat().st_mode & 0o777 == 0o700 and any(Path(folder).rglob('*.nbc'))


def test_processes_that_start_together_compile_once(tmp_path):
    environment = {**os.environ, 'XDG_CACHE_HOME': str(tmp_path)}
    environment.pop('NUMBA_CACHE_DIR', None)
    together = [subprocess.Popen([sys.executable, '-c', STEP], cwd=ROOT, text=True,
                                 stdout=subprocess.PIPE, env=environment) for _ in range(3)]
    assert sorted(p.communicate()[0].split()[1] for p in together) == ['0', '1', '1']


def test_ctrl_c_in_a_callback_of_the_compiler_ends_the_command(capsys):
    @ctypes.CFUNCTYPE(None)
    def callback():
        raise KeyboardInterrupt
    before = sys.unraisablehook
    with pytest.raises(KeyboardInterrupt), interrupts_kept():
        callback()
    assert sys.unraisablehook is before
    assert not capsys.readouterr().err


def test_without_any_folder_kernels_run_and_the_reason_is_told_once(blocked):
    nowhere = {'HOME': blocked, 'XDG_CACHE_HOME': blocked, 'TMPDIR': blocked}
    folder, found, told = python('-c', STEP, **nowhere).stdout.strip().split(' ', 2)
    assert (folder, found) == ('None', '0') and told.count('Not a directory') == 2
    done = python('-m', 'gearbox_monitor', 'replay', 'missing', '--csv', '/dev/null', **nowhere)
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == f'gearbox_monitor replay: {told}'
    assert done.stderr.count('no folder can keep compiled kernels') == 1
    assert not (ROOT / '~').exists()


def test_folders_that_others_can_write_into_are_not_ours(blocked, tmp_path):
    open_to_all, shared, own = (tmp_path / name / 'digest' for name in ('open', 'shared', 'own'))
    open_to_all.mkdir(parents=True)
    open_to_all.chmod(0o777)
    shared.mkdir(parents=True)
    shared.parent.chmod(0o777)
    linked = tmp_path / 'linked/digest'
    linked.parent.symlink_to(shared.parent)
    for bad in (open_to_all, shared, blocked, 'relative'):
        assert usable_cache([str(bad), str(own)]) == (str(own), '')
        assert usable_cache([str(bad)])[0] is None
    assert usable_cache([str(linked)])[0] is None
    # What the user names is theirs to choose, if it can be written.
    assert usable_cache([str(own)], str(shared)) == (str(shared), '')
    assert usable_cache([str(own)], str(blocked)) == (str(own), '')


def test_a_fused_product_is_rounded_once():
    # (1 + e)(1 - e) = 1 - e^2; rounded by itself, the product is 1.
    assert fma(1.0 + 2.0 ** -30, 1.0 - 2.0 ** -30, -1.0) == -2.0 ** -60
