# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A functional mock-up unit (pythonfmu, a drive of its own) as the simulator of the user."""
from pathlib import Path
import shutil
import subprocess
import sys

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.export.user_simulator import confirmation, user_simulator
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.excitation import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.quality.recording import UniformRecording

pytest.importorskip('fmpy')
pytest.importorskip('pythonfmu')
pytest.importorskip('pythonfmu3')
SLAVE = '''
import math
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Drive(Fmi2Slave):
    """Two masses, a dead zone, friction: small semi-implicit steps."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u_m = self.u_a = self.q_m = self.q_a = self.v_m = self.v_a = 0.0
        self.q_m0 = self.q_a0 = self.v_m0 = self.v_a0 = 0.0
        self.arm_inertia = 0.023454
        for name in ('u_m', 'u_a'):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ('q_m', 'q_a'):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        for name in ('q_m0', 'q_a0', 'v_m0', 'v_a0', 'arm_inertia'):
            self.register_variable(Real(name, causality=Fmi2Causality.input))

    def exit_initialization_mode(self):
        self.q_m, self.q_a, self.v_m, self.v_a = self.q_m0, self.q_a0, self.v_m0, self.v_a0

    def do_step(self, current_time, step_size):
        h = step_size / 20
        for _ in range(20):
            twist = self.q_m - self.q_a
            spring = (25.0 * (twist - min(max(twist, -0.1), 0.1))
                      + 0.01 * (self.v_m - self.v_a))
            friction = 0.1 * self.v_m + 0.27 * 2 / math.pi * math.atan(20.0 * self.v_m)
            self.v_m += h * (self.u_m - spring - friction - 0.01 * self.q_m) / 0.006442
            self.v_a += h * (self.u_a + spring) / self.arm_inertia
            self.q_m, self.q_a = self.q_m + h * self.v_m, self.q_a + h * self.v_a
        return True
'''
# The same as a unit of FMI 3.
SLAVE3 = SLAVE.replace(
    'pythonfmu ', 'pythonfmu3 ').replace(
    'Slave, Real', 'Slave, Fmi3Variability, Float64').replace('Real(', 'Float64(').replace(
    'Fmi2', 'Fmi3').replace('(**kwargs)\n', """(**kwargs)
        self.time = 0.0
        self.register_variable(Float64('time', causality=Fmi3Causality.independent,
                                       variability=Fmi3Variability.continuous))
""")
NAMES = """motor_torque: u_m
arm_torque: u_a
motor_position: q_m
arm_position: q_a
motor_start: q_m0
arm_start: q_a0
motor_speed_start: v_m0
arm_speed_start: v_a0
"""


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp('fmu')
    # Units of one process share its modules: each has a name of its own.
    for builder, source, name in (('pythonfmu3', SLAVE3, 'drive3'), ('pythonfmu', SLAVE, 'drive')):
        (path / f'{name}.py').write_text(source)
        subprocess.run([sys.executable, '-m', builder, 'build', '-f', f'{name}.py'], cwd=path,
                       check=True, capture_output=True)
        (path / 'Drive.fmu').rename(path / f'{name}.fmu')
    (path / 'names.yaml').write_text(NAMES)
    return path


@pytest.fixture(autouse=True)
def beside_it(folder, monkeypatch):
    monkeypatch.chdir(folder)


@pytest.mark.parametrize('unit', ['drive.fmu', 'drive3.fmu'])
def test_a_unit_confirms_what_was_found(unit):
    """The arm's inertia reaches it as a parameter; each run has its own start."""
    nominal = DriveModel(friction_sharpness=20.0)
    closed = nominal.with_(effects=[{'id': 'arm_inertia', 'm2': 0.04}])
    u = Excitation().torque(np.arange(2000) * 2e-3)
    run = simulate(closed, u, 2e-3, Noise(measurement=(2e-3, 2e-3)), seed=3)
    ran = confirmation(user_simulator(f'{unit}:names.yaml'),
                       UniformRecording(run.t, run.u, run.y, 2e-3), (nominal, closed),
                       np.full(2, 2e-3), lambda *_: None)
    assert (ran['name'], ran['passed']) == (unit, {'arm_inertia': 'parameter'})
    assert ran['gap_before'] > 5.0 and ran['closed_fraction'] == pytest.approx(1.0, abs=0.02)
    value, deviation = ran['values']['arm_inertia']['m2']
    assert abs(value - 0.04) < 4.0 * deviation < 0.004


@pytest.mark.parametrize('name, text', [
    ('other.fmu', 'no such file'), ('drive.py.fmu', 'expected a functional mock-up unit'),
    ('drive.fmu', "motor_torque: no variable 'motor_torque' of real numbers"),
    ('drive.fmu:wrong.yaml', "half_gab: did you mean 'half_gap'?"),
    ('drive.fmu:number.yaml', 'half_gap: 1, expected the name of a variable'),
    ('drive.fmu:missing.yaml', "half_gap: no variable 'b' of real numbers")])
def test_what_is_wrong_is_one_line(name, text):
    shutil.copy('drive.py', 'drive.py.fmu')
    for file, line in (('wrong', 'half_gab: b'), ('number', 'half_gap: 1'),
                       ('missing', 'half_gap: b')):
        Path(f'{file}.yaml').write_text(NAMES + line + '\n')
    with pytest.raises(InputError) as caught:
        user_simulator(name)
    assert text in str(caught.value) and '\n' not in str(caught.value)
