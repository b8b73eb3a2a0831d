# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled kernels are found, built where sources have changed, and called with what they take."""
from importlib import import_module
import math
import os
import subprocess
import sys

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels import build, library
from gearbox_monitor.kernels.kernel import (
    address_of, compilable, Entry, Repeated)
from gearbox_monitor.kernels.types import Vector
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import N_STATE, packed_drive, Plant, with_plugin

T = 1e-3 * np.arange(300)
U = 4.0 * np.cos(2 * np.pi * 1.1 * T)


def added(z: Vector, a: float, b: float) -> float:
    z[0] += a
    return z[0] * b


def torques(t, x1, x2, x3, x4, u, tau_k, theta):
    drag = theta[0] * x3 * abs(x3)
    if x2 > theta[1]:
        drag += theta[2] * math.sin(3.0 * x2)
    return -drag, 0.0, 0.01 * tau_k


@pytest.fixture(scope='module')
def entry(tmp_path_factory):
    """Return `added` compiled."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('XDG_CACHE_HOME', str(tmp_path_factory.mktemp('cache')))
        made = Entry(added)
        assert made.function
    return made


def test_the_library_has_every_entry_of_the_package():
    for module in build.EVERYTHING:
        import_module(f'gearbox_monitor.{module}')
    assert len(library.ENTRIES) >= 38
    for one in library.ENTRIES:
        if one.__module__.startswith('gearbox_monitor'):
            assert hasattr(library.installed(), one.symbol), one.symbol


def test_kernels_are_imported_with_numpy_alone_as_installation_does():
    code = """
import sys
class Missing:
    def find_spec(name, path=None, target=None):
        if name.partition('.')[0] not in {*sys.stdlib_module_names, 'numpy', 'gearbox_monitor'}:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Missing)
from gearbox_monitor.kernels import build
for module in build.EVERYTHING:
    build.import_module('gearbox_monitor.' + module)
"""
    subprocess.run([sys.executable, '-c', code], check=True)


def test_a_library_of_other_sources_is_not_used(tmp_path, monkeypatch):
    folder = tmp_path / 'gearbox_monitor'
    (folder / 'plant').mkdir(parents=True)
    monkeypatch.setattr(library, 'PACKAGE', folder)
    monkeypatch.setattr(build, 'text_of', lambda entries: 'int a;\n')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    path, seen = folder / f'{library.stems()[0]}.so', []
    for text in ('1', '2'):
        (folder / 'plant' / 'a.py').write_text(text)
        library.digest.cache_clear()
        seen.append(library.digest())
        assert library.notes(path)[:1] != seen[-1:]
        build.package(path)  # the second time a copy, as its C is the same
        copy = path.rename(tmp_path / f'{text}.so')
        assert library.notes(copy)[:1] == seen[-1:]
        copy.rename(path)
        monkeypatch.setattr(build, 'compile_', None)
    assert seen[0] != seen[1] and not library.notes(tmp_path / 'missing.so')
    library.digest.cache_clear()


def test_ziglang_compiles_to_the_same_bits_where_there_is_no_compiler(tmp_path, monkeypatch):
    pytest.importorskip('ziglang')
    monkeypatch.setenv('PATH', '')
    monkeypatch.delenv('CC', raising=False)
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    made = Entry(added)
    assert 'ziglang' in build.compiler() and made(np.array([0.1]), 0.2, 3.0) == (0.1 + 0.2) * 3.0


def test_without_a_compiler_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setenv('PATH', '')
    monkeypatch.delenv('CC', raising=False)
    monkeypatch.setitem(library.sys.modules, 'ziglang', None)
    with pytest.raises(InputError) as error:
        build.compiler()
    assert '\n' not in str(error.value) and 'gcc' in str(error.value)


def test_a_folder_that_others_write_into_keeps_no_kernels(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    folder = library.cache_folder()
    assert folder.is_relative_to(tmp_path) and os.stat(folder).st_mode & 0o077 == 0
    os.chmod(folder.parent, 0o777)
    assert not library.cache_folder().is_relative_to(tmp_path / 'gearbox_monitor')


def test_prepared_calls_see_what_changes_in_arrays(entry):
    z = np.array([1.0, 5.0])
    once = entry.prepared(z, 2.0, 10.0)
    assert once() == 30.0 and once() == 50.0 and z.tolist() == [5.0, 5.0]


def test_repeated_calls_follow_their_arguments(entry):
    repeated, arrays = Repeated(entry), [np.array([float(k)]) for k in range(9)]
    for _ in range(2):
        for z in arrays:
            repeated(z, 1.0, 1.0)
    assert [z[0] for z in arrays] == [k + 2.0 for k in range(9)]


def test_arguments_by_name(entry):
    assert entry(np.array([1.0]), b=2.0, a=3.0) == 8.0
    for arguments, named in (((1.0,), {}), ((1.0, 2.0), {'c': 1.0}), ((1.0, 2.0, 3.0), {})):
        with pytest.raises(TypeError, match='argument'):
            entry(np.zeros(1), *arguments, **named)


def test_a_plugin_called_back_gives_what_it_gives_compiled(monkeypatch):
    model, theta = DriveModel(), np.array([0.02, 0.5, 0.1])
    assert compilable(torques, *(float,) * 7, Vector)
    runs = []
    for call in (0, address_of(torques)):
        plant = Plant(model)
        if not call:
            plant._kernel = with_plugin(torques, plant._kernel)[0]
        plant._drive = packed_drive(model)._replace(theta=theta, call=call)
        runs.append(plant.run(U, 1e-3))
    assert len(plant.state) == N_STATE
    np.testing.assert_array_equal(runs[0].x, runs[1].x)
    np.testing.assert_array_equal(runs[0].tau_k, runs[1].tau_k)
    assert np.abs(runs[0].x - Plant(model).run(U, 1e-3).x).max() > 1e-4


def test_a_plugin_that_cannot_be_compiled_is_called_back():
    def of_a_list(t, x1, x2, x3, x4, u, tau_k, theta):
        return [0.0, 0.0, 0.0]
    assert not compilable(of_a_list, *(float,) * 7, Vector)
