# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""An effect is one object in one file: the example of docs/extend.md works as it stands."""
import ast
from dataclasses import fields
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys

import pytest

from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.plant.effects import EFFECTS

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'gearbox_monitor'
PAGE = ROOT / 'docs/extend.md'
# Simulates the new effect, step by step and side by side, and writes a recording of it.
RECORD = """
from dataclasses import replace
import numpy as np
from gearbox_monitor.files.user_files import save_model
from gearbox_monitor.diagnosis.joint.shooting import N_MEMORY, shooting_windows, Simulator
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.signals.uniform import UniformRecording

plain = DriveModel()
model = plain.with_(effects=[{'id': 'motor_drag', 'Cd': 0.02}])
t = np.arange(6000) * 1e-3
u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.2)).torque(t)
run = simulate(model, u, 1e-3)
y = run.x[:, :2] + 0.002 * np.random.default_rng(1).standard_normal((len(t), 2))
np.savetxt('recording.csv', np.column_stack([t, u, y]), '%.9g', ',', header='t,u,motor,arm',
           comments='')
save_model('drive.yaml', plain, [])
recording = UniformRecording(t, u, y, 1e-3)
windows, simulator = shooting_windows(recording, 1.0), Simulator(recording, plain)
start = run.x[windows.begin], np.zeros((len(windows), N_MEMORY))
together, _ = simulator.run(windows, model, *start)
without, _ = simulator.run(windows, plain, *start)
np.testing.assert_allclose(together, run.x[windows.samples][..., :2], atol=1e-4)
assert np.abs(together - without).max() > 0.05
"""


def section(title):
    """Return the text of a section of the page."""
    text = PAGE.read_text(encoding='utf-8')
    return text[text.index(f'## {title}\n'):].split('\n## ')[0]


@pytest.mark.system
def test_the_effect_of_the_page_is_simulated_side_by_side_and_found(tmp_path):
    [block] = re.findall(r'```python\n(.*?)```', section('An effect'), re.DOTALL)
    [file] = re.findall(r'at the end of\n\[.*?\]\(\.\./(.*?)\)', section('An effect'))
    ignored = shutil.ignore_patterns('__pycache__')
    shutil.copytree(PACKAGE, tmp_path / 'gearbox_monitor', ignore=ignored)
    with open(tmp_path / file, 'a', encoding='utf-8') as source:
        source.write('\n\n' + block)

    def python(*words):
        return subprocess.run([sys.executable, *words], cwd=tmp_path, capture_output=True,
                              text=True, check=False,
                              env={**os.environ, 'PYTHONPATH': str(tmp_path)})
    done = python('-c', RECORD)
    assert done.returncode == 0, done.stderr
    done = python('-m', 'gearbox_monitor', 'diagnose', 'recording.csv', '--model', 'drive.yaml',
                  '--only', 'motor_drag', 'motor_viscous', 'viscous_drift',
                  '--jobs', '2', '--json', 'verdict.json')
    assert done.returncode == 1, done.stderr
    verdict = json.loads((tmp_path / 'verdict.json').read_text(encoding='utf-8'))
    assert verdict['effect'] == 'motor_drag'
    assert verdict['location'] == 'motor_side'
    assert verdict['params']['motor_drag']['Cd'] == pytest.approx(0.02, rel=0.1)
    assert 'square of its speed' in python(
        '-c', 'from gearbox_monitor.report.words import meaning\n'
        'print(meaning("motor_drag", "rotary"))').stdout


def test_no_other_file_spells_the_id_of_an_effect():
    """Fields of the model may have the name of an effect."""
    names = {f.name for kind in (DriveModel, Transmission) for f in fields(kind)}
    # A test of monitoring and parameters of nodes, which users see, have these names.
    names |= {'torque_gain'}
    names |= {'torque_map'}  # a key of the verdict, too
    names |= {'gravity'}     # an option of MJCF files, too
    names |= {'slip'}        # a finding of check and a change of health, too
    ids, spelt = set(EFFECTS) - names, []
    quoted = re.compile(f'[\'"]({"|".join(ids)})[\'"]')
    for path in PACKAGE.rglob('*.py'):
        name, text = path.relative_to(PACKAGE).as_posix(), path.read_text(encoding='utf-8')
        if name.startswith('plant/effects/') or not quoted.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Constant) and node.value in ids:
                spelt.append(f'{name}:{node.lineno}: {node.value}')
    assert not spelt
