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

"""Commands without matplotlib, which is an extra: a picture is refused before the work begins."""
import sys

import pytest

from gearbox_monitor.cli.main import main


@pytest.mark.parametrize('words, option', [
    (['compare', 'BAG', '--png', 'out.png'], '--png'),
    (['simulate', '--model', 'drive.yaml', '--against', 'BAG', '--out', 'pictures'], '--out'),
    (['benchmark', 'paper', '--png', 'out.png'], '--png'),
    (['demo', '--out', 'demo'], 'demo')])
def test_picture_without_matplotlib(words, option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    assert main(words) == 2
    assert f'{option}: matplotlib is not installed, expected pip install ' in \
        capsys.readouterr().err
    assert not list(tmp_path.iterdir())
