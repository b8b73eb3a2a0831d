# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled kernels are kept where a folder can keep them; where none can, the user is told."""
from collections import namedtuple
import ctypes
import importlib
import os
from pathlib import Path
import subprocess
import sys

import pytest

from gearbox_monitor.kernels import jit
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


def test_machine_code_is_valid_while_its_sources_are_the_same(monkeypatch, tmp_path):
    monkeypatch.setattr(jit, 'CACHE_FOLDER', str(tmp_path))
    monkeypatch.setattr(sys, 'dont_write_bytecode', True)
    monkeypatch.syspath_prepend(tmp_path)

    def loaded(shift, doc):
        """Return the result of a kernel that calls one of another file, and if it was kept."""
        head = 'from gearbox_monitor.kernels.jit import jit, jit_inline\n'
        (tmp_path / 'callee.py').write_text(
            f'{head}SHIFT = {shift}\n@jit_inline\ndef moved(x):\n    return x + SHIFT\n')
        (tmp_path / 'caller.py').write_text(
            f'{head}import callee\n{doc}\n@jit\ndef doubled(x):\n    "{doc}"\n'
            '    return 2.0 * callee.moved(x)\n')
        importlib.invalidate_caches()
        for name in ('callee', 'caller'):
            sys.modules.pop(name, None)
        kernel = importlib.import_module('caller').doubled
        return kernel(1.0), sum(kernel.stats.cache_hits.values())
    assert loaded(1.0, '') == (4.0, 0)
    assert loaded(1.0, '# in other lines, with another text') == (4.0, 1)
    assert loaded(2.0, '') == (6.0, 0)  # the file of the kernel is the same
    assert loaded(1.0, '') == (4.0, 1)
    kernel = jit.jit(lambda pair: pair.first)
    assert [kernel(namedtuple('Pair', names)(1.0, 2.0))
            for names in (('first', 'second'), ('second', 'first'))] == [1.0, 2.0]


def test_a_node_loads_what_its_child_has_compiled(tmp_path):
    work = 'from gearbox_monitor.kernels.elementary import arctan; arctan(1.0)'
    done = python('-c', f"""
from gearbox_monitor.ros.first_start import compile_first
compile_first(print, exec, {work!r})
compile_first(print, exec, {work!r})
from gearbox_monitor.kernels.elementary import arctan
print(sum(arctan.stats.cache_hits.values()))""", XDG_CACHE_HOME=tmp_path)
    told, end, hits = done.stdout.splitlines()
    assert 'first start' in told and end.startswith('compiled in') and hits == '1'


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
