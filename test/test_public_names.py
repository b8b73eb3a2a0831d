# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The names that gearbox_monitor exports."""
from pathlib import Path
import subprocess
import sys

import pytest

import gearbox_monitor


def test_every_public_name_resolves_and_is_documented():
    for name in gearbox_monitor.__all__:
        value = getattr(gearbox_monitor, name)
        assert value.__name__ == name and len(value.__doc__.strip()) > 20
        assert f' {name}' in gearbox_monitor.__doc__
        assert name in dir(gearbox_monitor)


def test_other_names_are_attribute_errors():
    name = 'Estimater'
    with pytest.raises(AttributeError, match=name):
        getattr(gearbox_monitor, name)


def test_importing_the_package_imports_no_room():
    code = ('import sys, gearbox_monitor; gearbox_monitor.__version__; '
            'print([m for m in sys.modules if m.startswith("gearbox_monitor.") or m == "numpy"])')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True,
                          cwd=Path(__file__).parents[1])
    assert done.stdout.strip() == '[]'
