# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


import json
import math
from pathlib import Path
import re
import shlex

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import save_model
from gearbox_monitor.kernels.kernel import Entry, kernel
from gearbox_monitor.kernels.types import Matrix, Vector
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.signals.uniform import UniformRecording
from gearbox_monitor.simulators.user_simulator import (
    confirmation, passed, user_simulator, UserSimulator)

PAGE = (Path(__file__).parents[2] / 'docs/simulator.md').read_text(encoding='utf-8')
SIGMA = 2e-3
NOMINAL = DriveModel(friction_sharpness=20.0)


@kernel
def stepped(torque: Matrix, start: Vector, dt: float, m2: float, coulomb: float,
            out: Matrix) -> None:
    """Integrate equation (1) with small semi-implicit steps, nothing of the package's plant."""
    x1, x2, x3, x4 = start[0], start[1], start[2], start[3]
    h = dt / 200
    for k in range(len(torque)):
        out[k, 0] = x1
        out[k, 1] = x2
        for _ in range(200):
            twist = x1 - x2
            spring = 25.0 * (twist - min(max(twist, -0.1), 0.1)) + 0.01 * (x3 - x4)
            friction = 0.1 * x3 + coulomb * 2.0 / math.pi * math.atan(20.0 * x3)
            x3 += h * (torque[k, 0] - spring - friction - 0.01 * x1) / 0.006442
            x4 += h * (torque[k, 1] + spring) / m2
            x1 += h * x3
            x2 += h * x4


STEPPED = Entry(stepped)


def other_simulator(torque, start, dt, arm_inertia, coulomb_friction):
    out = np.empty((len(torque), 2))
    STEPPED(np.ascontiguousarray(torque), np.asarray(start, float), dt, arm_inertia,
            coulomb_friction, out)
    return out


def recording_of(model, seconds=5.0, dt=2e-3):
    u = Excitation().torque(np.arange(round(seconds / dt)) * dt)
    run = simulate(model, u, dt, Noise(measurement=(SIGMA, SIGMA)), seed=3)
    return UniformRecording(run.t, run.u, run.y, dt)


OTHERS = [
    ({'id': 'arm_inertia', 'm2': 0.04}, 'parameter'),       # by value
    ({'id': 'stiffness', 'K': 18.0}, 'torque'),             # a value that it does not take
    ({'id': 'cogging', 'A': 0.3, 'N': 9, 'phi': 0.4}, 'torque'),
    ({'id': 'lugre', 'sigma0': 30.0, 'sigma1': 0.3, 'Cs': 0.2, 'vs': 0.5}, 'torque'),  # a memory
    ({'id': 'load_torque', 'TL': 0.3}, 'torque'),           # on the arm
    ({'id': 'actuator_delay', 'T': 0.01}, 'torque'),        # from before the window, too
    ({'id': 'arm_encoder_delay', 'T': 0.01}, 'reading')]


def test_another_simulator_sees_the_same_gap_before_and_none_after():
    for effect, way in OTHERS:
        closed = NOMINAL.with_(effects=[effect])
        simulator = UserSimulator('mine', other_simulator, ('arm_inertia', 'coulomb_friction'))
        ran = confirmation(simulator, recording_of(closed), (NOMINAL, closed), np.full(2, SIGMA),
                           lambda *_: None)
        assert ran['passed'] == {effect['id']: way}
        assert ran['gap_before'] == pytest.approx(ran['here']['gap_before'], rel=0.02)
        assert ran['here']['gap_before'] > 1.5 and ran['gap_after'] < 1.1
        assert ran['closed_fraction'] == pytest.approx(ran['here']['closed_fraction'], abs=0.05)


OFF = [
    ({'id': 'arm_inertia', 'm2': 0.04}, {'m2': 0.041}),
    ({'id': 'cogging', 'A': 0.3, 'N': 9, 'phi': 0.4}, {'A': 0.294, 'phi': 0.41})]


def test_values_are_those_that_fit_in_the_other_simulator():
    for true, off in OFF:
        closed = NOMINAL.with_(effects=[{**true, **off}])
        simulator = UserSimulator('mine', other_simulator, ('arm_inertia', 'coulomb_friction'))
        recording = recording_of(NOMINAL.with_(effects=[true]))
        ran = confirmation(simulator, recording, (NOMINAL, closed), np.full(2, SIGMA),
                           lambda *_: None)
        values = ran['values'][true['id']]
        assert set(values) == set(off)  # N is a whole number
        for name, (value, deviation) in values.items():
            assert abs(value - true[name]) < 3.0 * deviation < abs(off[name] - true[name])


def test_ways_of_effects():
    closed = NOMINAL.with_(effects=[{'id': 'gravity', 'G': 1.0}, {'id': 'stribeck', 'Cs': 0.1,
                                                                  'vs': 0.2}])
    assert passed(NOMINAL, closed, ('gravity',)) == {'gravity': 'parameter', 'stribeck': 'torque'}
    assert passed(closed, closed, ()) == {}


BAD_SIMULATORS = [
    (None, 'no module nothing.py, expected it in the working directory or installed'),
    ('import absent_module', 'no module absent_module, expected'),
    ('def', 'SyntaxError'),
    ('x = 1', 'no function simulate in'),
    ('def simulate(torque, start): pass', 'takes 2 arguments, expected (torque, start, dt, names'),
    ('def simulate(torque, start, dt, mass): pass', 'argument mass, expected (torque, start, dt'),
    ('def simulate(torque, start, dt, *, mass=1): return torque[:, 0]',
     r'returned (500,), expected an array (500, 2)'),
    ('def simulate(torque, start, dt): return None', 'returned (), expected an array (500, 2)'),
    ('def simulate(torque, start, dt): return torque * float("nan") + start[:2]',
     'sample 0: position [nan, nan], expected finite numbers'),
    ('def simulate(torque, start, dt): return torque * 0 + 9.0',
     'first position [9.0, 9.0], expected the start'),
    ('def simulate(torque, start, dt):\n    return 1 / 0', 'line 2), expected positions')]


def test_one_line_for_what_is_wrong_with_a_simulator(tmp_path, monkeypatch):
    for source, problem in BAD_SIMULATORS:
        monkeypatch.chdir(tmp_path)
        name = 'nothing' if source is None else f'simulator_{abs(hash(source))}'
        if source is not None:
            (tmp_path / f'{name}.py').write_text(source, encoding='utf-8')
        with pytest.raises(InputError) as error:
            user_simulator(f'{name}:simulate').probe(recording_of(NOMINAL, 2.0), NOMINAL)
        assert problem in str(error.value) and str(error.value).startswith(f'--simulator {name}')
        assert '\n' not in str(error.value)


def test_models_that_take_no_torque_are_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    model = model_from_dict({'controller': {'kp': 6.0}}, 'test')
    save_model(tmp_path / 'servo.yaml', model, [])
    assert main(['example', 'run', '--seconds', '5']) == 0
    assert main(['diagnose', 'run', '--model', 'servo.yaml', '--simulator', 'a:b']) == 2
    assert main(['diagnose', 'run', '--model', 'servo.yaml', '--simulator', 'a']) == 2


def test_a_simulator_that_fails_later_leaves_the_diagnosis(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'late.py').write_text(
        'import numpy as np\ndef simulate(torque, start, dt):\n'
        '    return np.tile(start[:2], (len(torque), 1)) if not start[2] else 1 / 0\n')
    save_model(tmp_path / 'drive.yaml', NOMINAL, [])
    assert main(['example', 'run', '--model', 'drive.yaml', '--seconds', '5', '--rate', '500',
                 '--process-noise', '0']) == 0
    assert main(['diagnose', 'run', '--model', 'drive.yaml', '--only', 'motor_viscous',
                 '--simulator', 'late:simulate', '--json', 'verdict.json']) == 0
    data = json.loads((tmp_path / 'verdict.json').read_text())
    assert data['verdict'] == 'none' and 'simulator' not in data
    assert any('ZeroDivisionError' in note for note in data['warnings'])


@pytest.mark.system
def test_page(tmp_path, monkeypatch, capsys):
    pytest.importorskip('mujoco')
    monkeypatch.chdir(tmp_path)
    for text in re.findall(r'```(?:xml|yaml|python)\n(.*?)```', PAGE, re.DOTALL):
        name = re.match(r'(?:#|<!--) (\S+)', text)
        (tmp_path / name[1]).write_text(text, encoding='utf-8')
    block, = re.findall(r'```sh\n(.*?)```', PAGE, re.DOTALL)
    for line in block.replace('\\\n', ' ').splitlines():
        words = shlex.split(line)[1:]
        if words[0] == 'diagnose':  # fewer rivals, for time
            words += ['--only', 'cogging', 'motor_coulomb', '--out', 'out']
        assert main(words) == (words[0] == 'diagnose'), words
    out = capsys.readouterr().out
    expected, = re.findall(r'```text\n(.*?)```', PAGE, re.DOTALL)
    figures = [list(map(float, re.findall(r'(\S+) (?:before|after|%|\+-)', part)))
               for part in (out[out.index('simulator'):], expected)]
    assert figures[0] == pytest.approx(figures[1], rel=0.02)
    assert 'passed to it: cogging as torque' in out
    assert 'in my_arm:simulate' in (tmp_path / 'out/report.html').read_text(encoding='utf-8')
