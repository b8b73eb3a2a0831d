# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The commands and the code of the pages run, on short recordings of a simulated drive."""
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
import tomllib
from types import ModuleType

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.health import monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag, write_robot_pair
from gearbox_monitor.report.sentences import Sentence, TABLE

ROOT = Path(__file__).parents[2]
DOCS = ROOT / 'docs'
# What is run elsewhere, being long, on nodes or on recordings of others.
ELSEWHERE = {
    'demo': 'test_demo',
    'fit': 'test_walks', 'diagnose': 'test_walks',
    'export': 'test_walks', 'learn': 'test_robot_commands',
    'import': 'test_import',
    'fleet': 'test_walks', 'live': 'test_live'}
# Commands that go on with each other's files: test_walks.
WALKS = ('first_hour.md', 'tuning.md', 'mujoco.md', 'simulator.md', 'robot_gap.md',
         'real_drives.md', 'watch.md')


def blocks(page, language):
    """Return the code blocks of `page` in one language."""
    return [textwrap.dedent(block) for block in re.findall(
        rf'```{language}\n(.*?)```', page.read_text(encoding='utf-8'), re.DOTALL)]


def commands(page):
    """Return the words of each command of ours in the shell blocks of `page`, in order."""
    lines = '\n'.join(blocks(page, 'sh')).replace('\\\n', ' ').splitlines()
    words = [shlex.split(line, comments=True) for line in lines]
    return [line[1:] for line in words if line[:1] == ['gearbox_monitor']]


@pytest.mark.system
def test_own_csv_to_a_named_cause(tmp_path, monkeypatch, capsys):
    """The first command of the page, after clone and install, on other columns and units."""
    weight = DriveModel().with_(effects=[{'id': 'gravity', 'G': 0.4, 'phi': 0.0}])
    t = np.arange(0.0, 12.0, 0.002)
    torque = np.where(t < 1.0, 0.0, 5.0 * np.cos(5.7 * t) + 2.0 * np.cos(14.5 * t))
    run = simulate(weight, torque, 0.002, Noise(measurement=(0.002, 0.002)), seed=1)
    monkeypatch.chdir(tmp_path)
    np.savetxt('log.csv', np.column_stack([1e3 * t, run.u, np.degrees(run.y)]), delimiter=';',
               header='time [ms];motor torque [Nm];motor angle [deg];link angle [deg]',
               comments='')
    shutil.copy(ROOT / 'config/drive.yaml', tmp_path)
    assert main(commands(DOCS / 'diagnose.md')[0]) == 1
    assert re.search(r"The arm's weight is 0.400\d? ± 0.\d+ N m; the model has none.",
                     ' '.join(capsys.readouterr().out.split()))


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    """Give the folder with what the commands of the pages are about."""
    folder = tmp_path_factory.mktemp('files')
    for name, seed in (('BAG', 0), ('BAG2', 1)):
        write_example_bag(folder / name, DriveModel(), ExampleMotion(12.0, 200.0, rest=2.0), seed)
    text = (ROOT / 'config/drive.yaml').read_text(encoding='utf-8')
    (folder / 'found').mkdir()
    for name in ('drive.yaml', 'joint3_drive.yaml', 'found/drive.closed.yaml'):
        (folder / name).write_text(text)
    write_robot_pair(folder / 'arm', 15.0, 0)
    for source, name in (('robot.urdf', 'robot.urdf'), ('healthy.csv', 'log.csv')):
        shutil.copy(folder / 'arm' / source, folder / name)
    t = 2e-3 * np.arange(6_000)
    run = simulate(DriveModel(), 6.0 * np.cos(5.7 * t), 2e-3, Noise(measurement=(2e-3, 2e-3)))
    np.savetxt(folder / 'bench.csv', np.column_stack([t, run.u, run.y]), '%.9g', ',',
               header='t,u,motor,arm', comments='')
    (folder / 'joint3.yaml').write_text('estimator: {ros__parameters: {arm_load: none}}')
    (folder / 'robot.yaml').write_text(
        'estimator: {ros__parameters: {gearboxes: [shoulder, elbow], arm_load: none}}')
    return folder


def shown(long):
    """Return {words: page} of the commands run here of all pages but WALKS, `long` ones or not."""
    found = {}
    for page in (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted(DOCS.glob('*.md'))):
        for words in commands(page):
            if page.name not in WALKS and words[0] not in ELSEWHERE:
                # Other recordings: those of the pages about real drives, other joints.
                if words[-1].isupper() or not (
                        {'pulses', 'run22', 'unit7/params.yaml', '--motor-joint',
                         '--topic'} & set(words)):
                    found.setdefault(tuple(words), page.name)
    # The table of all filters takes longer; the others are compared in the suite.
    return {words: page for words, page in found.items() if ('aekf' in str(words)) == long}


@pytest.mark.parametrize('long', [False, pytest.param(True, marks=pytest.mark.system)])
def test_commands_of_the_pages(long, files, new_folder, monkeypatch):
    for words, page in shown(long).items():
        folder = new_folder()
        for path in files.iterdir():
            (folder / path.name).symlink_to(path)
        monkeypatch.chdir(folder)
        assert main(list(words)) == 0, (page, words)


def with_filter(folder):
    """Copy the package into `folder`, the page's filter where it says; return what runs it."""
    for name in ('gearbox_monitor', 'config'):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(ROOT / 'package.xml', folder)  # of a checkout
    (folder / 'gearbox_monitor/estimation/filters/gated.py').write_text(
        blocks(DOCS / 'extend.md', 'python')[0])

    def run(*words):
        """Return what Python prints with `words`; interpreted: compiling takes longer."""
        done = subprocess.run(
            [sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False,
            env={**os.environ, 'GEARBOX_MONITOR_KERNELS': 'python', 'PYTHONPATH': str(folder)})
        assert done.returncode == 0, done.stderr
        return done.stdout
    return run


def test_the_filter_of_the_page_is_found_by_its_file(tmp_path):
    """A jump of the arm encoder moves the EKF, not the filter of the page."""
    ekf, gated = map(float, with_filter(tmp_path)('-c', textwrap.dedent("""\
        from gearbox_monitor import DriveModel, Estimator, Sample
        for name in ('ekf', 'gated'):
            one = Estimator(DriveModel(), {'filter': name, 'smoother_lag': 0.0})
            for k in range(42):  # 0.3 rad: no jump to the sample loop within 100 samples
                found = one.step(Sample(10 ** 9 + k * 2_000_000, (0.0, 0.0), (
                    0.0, 0.3 * (k == 41))))
            print(abs(found.tau_k))
        """)).split())
    assert ekf > 1.0 and gated < 1e-6


@pytest.mark.system
def test_a_filter_is_one_added_file(tmp_path):
    """The page's filter, put where it says, does in page and command what the page says."""
    run = with_filter(tmp_path)
    (tmp_path / 'use.py').write_text(blocks(DOCS / 'extend.md', 'python')[1])
    plain, gated = map(float, re.findall(r'(\d\.\d+) N m', run('use.py')))
    assert gated < 0.9 * plain
    write_example_bag(tmp_path / 'BAG', DriveModel(), ExampleMotion(1.0, 200.0), 0)
    assert 'filter gated' in run('-m', 'gearbox_monitor', 'replay', 'BAG', '--filter', 'gated')


def test_indicator_of_the_page(monkeypatch, capsys):
    *_, load, use = blocks(DOCS / 'extend.md', 'python')
    made = ModuleType('load')
    exec(compile(load, 'load.py', 'exec'), vars(made))
    *_, row = blocks(DOCS / 'extend.md', 'toml')
    for code, fields in tomllib.loads(row).items():
        monkeypatch.setitem(TABLE, code, Sentence(**fields))
    monkeypatch.setattr(monitor, 'ROW_CHECKS', (*monitor.ROW_CHECKS, made.CHECK))
    exec(compile(use, 'extend.md', 'exec'), {})
    lines = capsys.readouterr().out.splitlines()
    levels = [line.split()[1] for line in lines]
    assert levels[4:8] == ['OK'] * 4 and levels[9:] == ['WARN'] * 3
    assert all('beyond the rated one' in line for line in lines[9:])
