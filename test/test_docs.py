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

"""The pages say what the code does."""
from pathlib import Path
import re
import runpy
import shlex

import pytest
import yaml

from gearbox_monitor import signals
from gearbox_monitor.cli.main import _parse, COMMANDS
from gearbox_monitor.parameters import checked, defaults, ESTIMATOR, PLANT

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').glob('*.md'))]


@pytest.mark.parametrize('name', ['parameters', 'effects'])
def test_written_page_is_up_to_date(name):
    page = runpy.run_path(str(ROOT / f'docs/make_{name}.py'))['page']()
    assert (ROOT / f'docs/{name}.md').read_text(encoding='utf-8') == page, \
        f'run python docs/make_{name}.py'


@pytest.mark.parametrize('node, table', [('estimator', ESTIMATOR), ('plant', PLANT)])
def test_parameter_files_show_the_defaults(node, table):
    text = (ROOT / f'config/{node}.yaml').read_text(encoding='utf-8')
    values = yaml.safe_load(text)[node]['ros__parameters']
    assert checked(table, values, node) == defaults(table)
    for row in table:
        assert re.search(rf'^\s*(# )?{row.name}:', text, re.MULTILINE), row.name


def test_every_topic_is_explained():
    text = (ROOT / 'docs/topics.md').read_text(encoding='utf-8')
    topics = [signal.topic for signal in signals.SIGNALS]
    topics += [signals.JOINT_STATES, signals.PAIRED_JOINT_STATES,
               signals.PLANT_TRANSMISSION_STATE, signals.DIAGNOSTICS, signals.DRIFT_ALERTS,
               f'~/{signals.SNAPSHOT}']
    for topic in topics:
        assert f'`{topic}`' in text


def test_every_command_is_mentioned():
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    for command in COMMANDS:
        assert f'gearbox_monitor {command}' in text


@pytest.mark.parametrize('page', PAGES, ids=lambda p: p.name)
def test_commands_can_be_given(page):
    """In shell blocks, every command of ours has the options it is shown with."""
    for block in re.findall(r'```sh\n(.*?)```', page.read_text(encoding='utf-8'), re.DOTALL):
        for line in block.replace('\\\n', ' ').splitlines():
            words = shlex.split(line, comments=True)
            if words[:1] == ['gearbox_monitor']:
                _parse(words[1:], words[1])


@pytest.mark.parametrize('page', PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r'\]\(([^)#]+)[^)]*\)', page.read_text(encoding='utf-8')):
        assert re.match('https?://', target) or (page.parent / target).exists(), target


def test_readme_is_short():
    assert len((ROOT / 'README.md').read_text(encoding='utf-8').splitlines()) <= 155
