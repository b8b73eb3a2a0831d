# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The commands and the code of the pages run, on short recordings of a simulated drive."""
import json
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from types import ModuleType

import numpy as np
import pytest

from gearbox_monitor.bag.example import ExampleMotion, write_example_bag
from gearbox_monitor.cli.main import main
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.monitoring import checks
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, simulate

ROOT = Path(__file__).parents[2]
DOCS = ROOT / 'docs'
# What is run elsewhere, being long, on nodes or on recordings of others.
ELSEWHERE = {
    'adapt': 'test_unit_adaptation', 'demo': 'test_demo', 'play': 'test_play',
    'tune': 'test_tune, and below', 'diagnose': 'test_diagnose',
    'suggest': 'test_experiment_design', 'describe': 'test_describe',
    'export': 'test_mujoco_page', 'learn': 'test_robot_commands',
    'fit-nominal': 'test_real_drives', 'import': 'test_import',
    'fleet': 'test_fleet, and below', 'live': 'test_live'}
# Pages whose commands go on with each other's files: each has a test of its own.
WALKS = ('first_hour.md', 'current.md', 'closed_model.md', 'mujoco.md', 'simulator.md',
         'robot_gap.md', 'payload.md')
ENTRANCES = ('Motor encoder alone', 'Only setpoints')  # of first_hour.md
RATE = ['--rate', '200']  # five times as fast as what the pages make


def blocks(page, language, heading=''):
    """Return the code blocks of `page` in one language, of all or the section `heading`."""
    text = page.read_text(encoding='utf-8')
    if heading:
        text = re.split(r'\n## ', text.split(f'\n## {heading}\n')[1])[0]
    return [textwrap.dedent(block)
            for block in re.findall(rf'```{language}\n(.*?)```', text, re.DOTALL)]


def commands(page, heading=''):
    """Return the words of each command of ours in the shell blocks of `page`, in order."""
    lines = '\n'.join(blocks(page, 'sh', heading)).replace('\\\n', ' ').splitlines()
    words = [shlex.split(line, comments=True) for line in lines]
    return [line[1:] for line in words if line[:1] == ['gearbox_monitor']]


@pytest.mark.system
def test_first_hour(tmp_path, monkeypatch, capsys):
    """Every command of the tutorial, in order, in one folder: the example passes its checks."""
    page = DOCS / 'first_hour.md'
    shutil.copy(ROOT / 'config/drive.yaml', tmp_path / 'joint3_drive.yaml')
    (tmp_path / 'start.yaml').write_text(blocks(page, 'yaml')[0])
    monkeypatch.chdir(tmp_path)
    codes, output = {}, {}
    others = [words for heading in ENTRANCES for words in commands(page, heading)]
    for words in (words for words in commands(page) if words not in others):
        name = ' '.join(words[:2])
        codes[name] = main([*words, *(RATE if words[0] == 'example' else [])])
        output[name] = capsys.readouterr().out
    assert codes.pop('accept june') == 1, 'the worn one is to fail'
    assert len(codes) == 11 and set(codes.values()) == {0}
    assert 'hardly distinguishable' not in output['fit-nominal first']
    nis, low, high = map(float, re.search(
        r'mean NIS .* (\S+)  95 % band (\S+)\.\.(\S+)', output['tune first']).groups())
    assert low < nis < high
    assert 'baseline_file: "joint3_healthy.yaml"' in (tmp_path / 'joint3.yaml').read_text()
    page = (tmp_path / 'fleet/fleet.html').read_text(encoding='utf-8')
    assert re.search(r'most in SN0815: \+2[456]\.\d', page) and 'since 2026-01-15' in page


def entered(heading, folder):
    """Write the files of an entrance to the tutorial; return [command that may follow]."""
    page = DOCS / 'first_hour.md'
    text = (ROOT / 'config/drive.yaml').read_text(encoding='utf-8')
    (folder / 'joint3_drive.yaml').write_text(text)
    block = blocks(page, 'yaml', heading)[0]
    (folder / 'one.yaml').write_text(block)
    (folder / 'joint3_servo.yaml').write_text(
        re.sub('^controller: null', block.strip() + '  #', text, flags=re.MULTILINE))
    shorter = [*RATE, '--seconds', '32']
    return [[*words, *(shorter if words[0] == 'example' and '--rate' not in words else [])]
            for words in commands(page, heading)]


@pytest.mark.parametrize('heading', [
    pytest.param(ENTRANCES[0], marks=pytest.mark.system), ENTRANCES[1]])
def test_entrances_without_arm_encoder(heading, tmp_path, monkeypatch, capsys):
    words = [words for words in entered(heading, tmp_path) if words[0] != 'diagnose']
    monkeypatch.chdir(tmp_path)
    assert [main(command) for command in words] == [0] * len(words)
    shown = capsys.readouterr().out
    if heading == ENTRANCES[0]:
        assert 'verdict      pass' in shown
        assert re.search(r'SN0816: backlash .* \+2[456]\.\d', shown)


@pytest.mark.system
@pytest.mark.parametrize('heading, half_gap', [*zip(ENTRANCES, (0.125, 0.13))])
def test_causes_without_arm_encoder(heading, half_gap, tmp_path, monkeypatch):
    words = entered(heading, tmp_path)
    name = next(w[1] for w in words if w[0] == 'diagnose')
    monkeypatch.chdir(tmp_path)
    for command in words:
        if command[:2] in (['example', name], ['diagnose', name]):
            assert main(command) == int(command[0] == 'diagnose')
    verdict = json.loads(next(tmp_path.glob('*/verdict.json')).read_text())
    assert verdict['effect'] == 'backlash_gap'
    assert verdict['params']['backlash_gap']['b'] == pytest.approx(half_gap, rel=0.01)


def named(page):
    """Return {name: text} of the YAML files that `page` shows, the name in their first line."""
    return {text.splitlines()[0].lstrip('# '): text for text in blocks(page, 'yaml')}


@pytest.mark.system
def test_own_csv_to_a_named_cause(tmp_path, monkeypatch, capsys):
    """The first two commands of the page, after clone and install, on other columns and units."""
    weight = DriveModel().with_(effects=[{'id': 'gravity', 'G': 0.4, 'phi': 0.0}])
    t = np.arange(0.0, 12.0, 0.002)
    torque = np.where(t < 1.0, 0.0, 5.0 * np.cos(5.7 * t) + 2.0 * np.cos(14.5 * t))
    run = simulate(weight, torque, 0.002, Noise(measurement=(0.002, 0.002)), seed=1)
    monkeypatch.chdir(tmp_path)
    np.savetxt('log.csv', np.column_stack([1e3 * t, run.u, np.degrees(run.y)]), delimiter=';',
               header='time [ms];motor torque [Nm];motor angle [deg];link angle [deg]',
               comments='')
    shutil.copy(ROOT / 'config/drive.yaml', tmp_path)
    codes = [main(words) for words in commands(DOCS / 'diagnose.md')[:2]]
    assert codes == [0, 1]
    assert "The arm's weight is 0.400 N m; the model has none." in capsys.readouterr().out


def test_current_instead_of_torque(tmp_path, monkeypatch, capsys):
    """A constant is found, and estimator and simulator take it from the model file."""
    page, said = DOCS / 'current.md', []
    monkeypatch.chdir(tmp_path)
    for name, text in named(page).items():
        (tmp_path / name).write_text(text)
    for words in commands(page):
        assert main([*words, *(['--rate', '500'] if words[0] == 'example' else [])]) == 0, words
        said.append(capsys.readouterr()[0])
    fitted = load_model('fitted.yaml')
    true = load_model('motor.yaml').torque_constant
    assert fitted.torque_constant == pytest.approx(true, rel=0.01)
    assert not fitted.effects and re.search(r'kt +0.05 .* N m/A', said[1])
    before, after = map(float, re.search(r'gap in .* s +(\S+) +(\S+)', said[2]).groups())
    assert before > 20.0 and after < 1.05
    before, after = (float(re.search(r'smoothed (\S+?);', text)[1]) for text in said[3:])
    assert before > 1.0 and after < 0.3  # N m


@pytest.mark.system
def test_closed_model_in_the_estimator(tmp_path, monkeypatch, capsys):
    """Prediction errors become those of a right model, and the smoothed torque better."""
    page, said = DOCS / 'closed_model.md', []
    monkeypatch.chdir(tmp_path)
    for name, text in named(page).items():
        (tmp_path / name).write_text(text)
    (tmp_path / 'drive.yaml').write_text((ROOT / 'config/drive.yaml').read_text())
    for words in commands(page):
        if words[0] == 'example':
            words += ['--rate', '400']
        elif words[0] == 'compare':
            words.append('--json')
        elif words[0] == 'diagnose':  # fewer rivals, for time
            words += ['--only', 'gravity', 'arm_viscous']
        assert main(words) == (words[0] == 'diagnose'), words
        said.append(capsys.readouterr()[0])
    nominal, closed = (
        {'nis': float(re.search(r'NIS +(\S+)', text)[1]),
         'smoothed': float(re.search(r'smoothed (\S+?);', text)[1]),
         'trust': re.search(r'prediction error (\w+)', text)[1]} for text in said[3:5])
    white = [max(json.loads(text)['rows'][0]['ljung_box']) for text in said[5:]]
    assert nominal['nis'] > 3.0 and closed['nis'] == pytest.approx(2.0, abs=0.1)
    assert closed['smoothed'] < 0.75 * nominal['smoothed'] and white[1] < 0.05 * white[0]
    assert nominal['trust'] != 'OK' == closed['trust']


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    """Give the folder with what the commands of the pages are about."""
    folder = tmp_path_factory.mktemp('files')
    for name, seed in (('BAG', 0), ('BAG2', 1)):
        write_example_bag(folder / name, DriveModel(), ExampleMotion(24.0, 200.0, rest=2.0), seed)
    text = (ROOT / 'config/drive.yaml').read_text(encoding='utf-8')
    (folder / 'found').mkdir()
    for name in ('drive.yaml', 'joint3_drive.yaml', 'found/drive.closed.yaml'):
        (folder / name).write_text(text)
    (folder / 'joint3.yaml').write_text('estimator: {ros__parameters: {arm_load: none}}')
    (folder / 'robot.yaml').write_text(
        'estimator: {ros__parameters: {gearboxes: [shoulder, elbow], arm_load: none}}')
    return folder


def shown():
    """Return the different commands that are run here of all pages but WALKS."""
    found = {}
    for page in (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted(DOCS.glob('*.md'))):
        for words in commands(page):
            if page.name not in WALKS and words[0] not in ELSEWHERE:
                # Other recordings: those of the pages about real drives, other joints.
                if words[-1].isupper() or not (
                        {'pulses', 'run22', 'unit7/params.yaml', '--motor-joint',
                         '--topic'} & set(words)):
                    found.setdefault(tuple(words), page.name)
    # The table of all filters compiles one more; the others are compared in the suite.
    return [pytest.param(list(words), id=f'{page}: {" ".join(words)}',
                         marks=[pytest.mark.system] if 'aekf' in str(words) else [])
            for words, page in found.items()]


@pytest.mark.parametrize('words', shown())
def test_command_of_a_page(words, files, tmp_path, monkeypatch):
    for path in files.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)
    assert main(words) == 0


def module(monkeypatch, name, code):
    """Make the module `name` of `code`, also as an attribute of its package."""
    made = ModuleType(name)
    exec(compile(code, name, 'exec'), vars(made))
    monkeypatch.setitem(sys.modules, name, made)
    return made


def test_the_filter_of_the_page_is_found_by_its_file(tmp_path):
    """A jump of the arm encoder moves the EKF, not the filter of the page."""
    for folder in ('gearbox_monitor', 'config'):
        shutil.copytree(ROOT / folder, tmp_path / folder,
                        ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(ROOT / 'package.xml', tmp_path)  # of a checkout
    (tmp_path / 'gearbox_monitor/estimation/filters/gated.py').write_text(
        blocks(DOCS / 'extend.md', 'python')[0])
    (tmp_path / 'use.py').write_text(textwrap.dedent("""\
        from gearbox_monitor.estimation.filter import Filter
        from gearbox_monitor.plant.drive import DriveModel
        for name in ('ekf', 'gated'):
            one = Filter(DriveModel(), {'filter': name})
            one.start(0.0, 0.0)
            assert all(one.step(2e-3, 0.0, 0.0, 3.0 * (k == 40)) for k in range(41))
            print(abs(one.tau_k))
        """))
    done = subprocess.run(
        [sys.executable, 'use.py'], cwd=tmp_path, capture_output=True, text=True, check=True,
        env={**os.environ, 'GEARBOX_MONITOR_JIT': '0', 'PYTHONPATH': str(tmp_path)})
    ekf, gated = map(float, done.stdout.split())
    assert ekf > 1.0 and gated < 1e-6


@pytest.mark.system
def test_a_filter_is_one_added_file(tmp_path):
    """The page's filter, put where it says, is found; interpreted: compiling takes longer."""
    gated, use, *_ = blocks(DOCS / 'extend.md', 'python')
    for folder in ('gearbox_monitor', 'config'):
        shutil.copytree(ROOT / folder, tmp_path / folder,
                        ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(ROOT / 'package.xml', tmp_path)  # of a checkout
    (tmp_path / 'gearbox_monitor/estimation/filters/gated.py').write_text(gated)
    (tmp_path / 'use.py').write_text(use)

    def run(*words):
        done = subprocess.run(
            [sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, check=False,
            env={**os.environ, 'GEARBOX_MONITOR_JIT': '0', 'PYTHONPATH': str(tmp_path)})
        assert done.returncode == 0, done.stderr
        return done.stdout

    plain, gated = map(float, re.findall(r'(\d\.\d+) N m', run('use.py')))
    assert gated < 0.9 * plain
    write_example_bag(tmp_path / 'BAG', DriveModel(), ExampleMotion(1.0, 200.0), 0)
    assert 'filter gated' in run('-m', 'gearbox_monitor', 'replay', 'BAG', '--filter', 'gated')


def test_indicator_of_the_page(monkeypatch, capsys):
    *_, load, use = blocks(DOCS / 'extend.md', 'python')
    made = module(monkeypatch, 'gearbox_monitor.monitoring.checks.load', load)
    monkeypatch.setattr(checks, 'load', made, raising=False)
    exec(compile(use, 'extend.md', 'exec'), {})
    levels = [line.split()[1] for line in capsys.readouterr().out.splitlines()]
    assert levels == ['OK'] * 7 + ['WARN'] * 4 or levels == ['OK'] * 8 + ['WARN'] * 3
