# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The names that gearbox_monitor exports."""
from pathlib import Path
import subprocess
import sys

import pytest

import gearbox_monitor


@pytest.mark.parametrize('name', gearbox_monitor.__all__)
def test_every_public_name_resolves_and_is_documented(name):
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
