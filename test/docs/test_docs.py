# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The pages say what the code does."""
from importlib import import_module
from pathlib import Path
import re
import runpy
import shlex

import numpy as np
import pytest
import yaml

from benchmarks.__main__ import _parse as parse_benchmark
from gearbox_monitor.cli.main import _parse
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.process_model import ADAPTABLE
from gearbox_monitor.estimation.sample_loop import REASONS
from gearbox_monitor.health.checks.observability import key_of
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters, PlantParameters, table_of
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings import topics
from gearbox_monitor.ros.diagnostic_keys import DIAGNOSTIC_KEYS, published

ROOT = Path(__file__).parents[2]
PAGES = [*map(ROOT.joinpath, ('README.md', 'CONTRIBUTING.md', 'benchmarks/README.md')),
         *sorted((ROOT / 'docs').glob('*.md'))]


def test_written_page_is_up_to_date():
    for name in ('commands', 'parameters', 'effects', 'messages'):
        page = runpy.run_path(str(ROOT / f'docs/make_{name}.py'))['page']()
        assert (ROOT / f'docs/{name}.md').read_text(encoding='utf-8') == page, \
            f'run python docs/make_{name}.py'


def test_pages_link_the_words_of_the_glossary():
    """Each at its first use; every anchor that a page links to has a heading."""
    links = runpy.run_path(str(ROOT / 'docs/link_terms.py'))
    glossary = (ROOT / 'docs/glossary.md').read_text(encoding='utf-8')
    headings = {title.lower().replace(' ', '-')
                for title in re.findall(r'^## (.*)$', glossary, re.MULTILINE)}
    assert {*links['TERMS']} <= headings
    for page in PAGES:
        text = page.read_text(encoding='utf-8')
        assert {*re.findall(r'glossary\.md#([^)]*)\)', text)} <= headings, page.name
    assert len(links['pages']()) > 25
    for page in links['pages']():
        text = page.read_text(encoding='utf-8')
        assert links['linked'](text) == text, f'{page.name}: run python docs/link_terms.py'
    once = links['linked']('`NIS` and NIS of white noise; [NIS](x.md)')
    assert once == ('`NIS` and [NIS](glossary.md#nis) of [white](glossary.md#white) noise; '
                    '[NIS](x.md)')


def test_every_name_on_the_three_walks_exists():
    text = (ROOT / 'CONTRIBUTING.md').read_text(encoding='utf-8')
    walks = text[text.index('### Walks'):text.index('### Rules')]
    names = re.findall(r'`([a-z_]+(?:\.[a-z_]+)+(?:\.[A-Za-z_]+)?)`', walks)
    assert len(names) > 15
    for name in names:
        path = ROOT / 'gearbox_monitor' / (name.replace('.', '/') + '.py')
        if not path.is_file():
            module, _, member = name.rpartition('.')
            if module.startswith('ros.'):
                pytest.importorskip('rclpy')
            assert hasattr(import_module(f'gearbox_monitor.{module}'), member), name


FILES = [
    ('estimator', EstimatorParameters), ('plant', PlantParameters)]


def test_parameter_files_show_the_defaults():
    for node, parameters in FILES:
        text = (ROOT / f'config/{node}.yaml').read_text(encoding='utf-8')
        values = yaml.safe_load(text)[node]['ros__parameters']
        assert parameters.from_mapping(values, node) == parameters()
        for row in table_of(parameters):
            assert re.search(rf'^\s*(# )?{row.name}:', text, re.MULTILINE), row.name


def test_every_topic_is_explained():
    text = (ROOT / 'docs/messages.md').read_text(encoding='utf-8')
    names = [signal.topic for signal in topics.SIGNALS]
    names += [topics.JOINT_STATES, topics.PAIRED_JOINT_STATES,
              topics.PLANT_TRANSMISSION_STATE, topics.DIAGNOSTICS, topics.DRIFT_ALERTS,
              f'~/{topics.SNAPSHOT}', f'~/{topics.DIAGNOSIS}']
    for name in names:
        assert f'`{name}`' in text


def test_every_published_value_is_explained():
    t = np.arange(0.0, 16.0, 2e-3)
    model = DriveModel()
    run = simulate(model, Excitation().torque(t), 2e-3, Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)))
    monitor = Monitor(model, {'drift_window': 2.0})
    monitor.run(Samples(10 ** 18 + np.round(t * 1e9).astype(np.int64),
                        np.column_stack([run.u, np.full(len(t), np.nan)]), run.y))
    assert monitor.health.feature('gap').baseline > 0.0
    explained = {(row.component, row.key) for row in DIAGNOSTIC_KEYS}
    for component, outcome in monitor.outcomes.items():
        for key in outcome.values:
            assert (component, key) in explained, f'{component}: {key}'
    for reason in REASONS.values():
        assert ('input', key_of(reason)) in explained, reason
    for name in ADAPTABLE:
        assert ('covariance', f'adapted_{name}') in explained
    for name in Estimator(model, {'filter': 'aekf', 'arm_load': 'none'}).adaptation_guards():
        assert ('covariance', f'adaptation_{name}') in explained


def test_keys_are_snake_case_and_published_in_the_order_of_the_table():
    keys = [(row.component, row.key) for row in DIAGNOSTIC_KEYS]
    assert len(set(keys)) == len(keys)
    assert all(re.fullmatch('[a-z][a-z0-9]*(_[a-z0-9]+)*', key) for _, key in keys)
    assert published('input', {'rate_hz': 1.0 / 3.0, 'zero_stamps': 2, 'samples': 7}) == [
        ('samples', '7'), ('rate_hz', '0.333333'), ('zero_stamps', '2')]


def test_index_has_every_page():
    text = (ROOT / 'docs/README.md').read_text(encoding='utf-8')
    for page in (ROOT / 'docs').glob('*.md'):
        assert page.name == 'README.md' or f']({page.name})' in text, page.name


def test_commands_can_be_given():
    """In shell blocks and sentences, every command of ours has the options it is shown with."""
    for page in PAGES:
        text = page.read_text(encoding='utf-8')
        lines = [line for block in re.findall(r'```sh\n(.*?)```', text, re.DOTALL)
                 for line in block.replace('\\\n', ' ').splitlines()]
        prose = re.sub(r'```.*?```', '', text, flags=re.DOTALL)
        lines += re.findall(r'`((?:gearbox_monitor|python -m benchmarks) [a-z_-]+\s[^`]+)`', prose)
        for line in lines:
            words = shlex.split(line, comments=True)
            if words[:1] == ['gearbox_monitor']:
                _parse(words[1:], words[1])
            elif words[1:3] == ['-m', 'benchmarks']:
                parse_benchmark(words[3:])


def anchors(page):
    """Return the anchors of the headings of a page, as they are made of them."""
    headings = re.findall(r'^#+ (.*)$', page.read_text(encoding='utf-8'), re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-') for heading in headings}


def test_links_lead_somewhere():
    for page in PAGES:
        text = page.read_text(encoding='utf-8')
        for words, link in re.findall(r'([^[\n]{0,80})\]\(([^)]+)\)', text):
            if re.match('https?://', link):
                continue
            assert link.endswith(words) or not words.endswith('.py'), f'[{words}]({link})'
            target, _, anchor = link.partition('#')
            target = page.parent / target if target else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), link


def test_tables_are_whole():
    """A blank line within one makes text of its rows; without one, two become one."""
    for page in PAGES:
        text = re.sub(r'```.*?```', '', page.read_text(encoding='utf-8'), flags=re.DOTALL)
        for table in re.findall(r'(?:^\|.*\n)+', text, re.MULTILINE):
            rules = [bool(re.fullmatch(r'(\|[ :]*-+[ :]*)+\|', row)) for row in table.splitlines()]
            assert rules[1:2] == [True] and sum(rules) == 1, table


def test_readme_is_short():
    assert len((ROOT / 'README.md').read_text(encoding='utf-8').splitlines()) <= 100


def test_pages_are_short():
    """Few pages, and few words in all of them but those that are generated."""
    pages = [*(ROOT / 'docs').glob('*.md')]
    generated = {name.stem.removeprefix('make_') for name in (ROOT / 'docs').glob('make_*.py')}
    words = {page.stem: len(page.read_text(encoding='utf-8').split()) for page in pages}
    assert len(pages) <= 32 and words['how_good'] <= 600
    assert sum(count for page, count in words.items() if page not in generated) <= 22_000
