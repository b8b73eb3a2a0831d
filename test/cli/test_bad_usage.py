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

"""Bad usage ends before the work begins, with one line and exit code 2."""
import pytest

from gearbox_monitor.cli.main import main


@pytest.mark.parametrize('words, says', [
    (['diagnose', 'BAG'], 'arguments are required: --model; see gearbox_monitor diagnose --help'),
    (['benchmark', 'foo'], "argument NAME: invalid choice: 'foo'"),
    ([], 'arguments are required: COMMAND; see gearbox_monitor --help')])
def test_bad_usage_is_one_line(words, says, capsys):
    with pytest.raises(SystemExit, match='2'):
        main(words)
    line, = capsys.readouterr().err.splitlines()
    assert says in line


@pytest.mark.parametrize('words', [
    ['report', 'BAG', '--out'], ['check', 'BAG', '--json'], ['replay', 'BAG', '--csv'],
    ['compare', 'BAG', '--png'], ['accept', 'BAG', '--write-model'],
    ['tune', 'BAG', '--out']])
def test_folder_of_a_result_is_checked_first(words, capsys, tmp_path):
    path = tmp_path / 'none' / 'result.png'
    assert main([*words, str(path)]) == 2
    assert f'{path}: no such folder, expected a new name' in capsys.readouterr().err
