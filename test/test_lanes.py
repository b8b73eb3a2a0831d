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

"""Runs side by side: the bits of single runs, and an arc tangent that a vector unit can do."""
import math

import numpy as np
import pytest

from gearbox_monitor.drive.arctan import arctan
from gearbox_monitor.drive.excitation import Excitation
from gearbox_monitor.drive.model import model_from_dict
from gearbox_monitor.drive.simulate import Noise, Plant
from gearbox_monitor.gap import lanes
from gearbox_monitor.gap.recording import Recording
from gearbox_monitor.gap.windows import cut, N_MEMORY, Simulator
from gearbox_monitor.jit import COMPILED

DT = 2e-3


def test_arctan():
    x = np.concatenate([np.linspace(-4.0, 4.0, 4001), np.logspace(-300, 300, 601)])
    found = np.array([arctan(v) for v in x])
    np.testing.assert_allclose(found, np.arctan(x), rtol=1e-15)
    np.testing.assert_array_equal([arctan(-v) for v in x], -found)
    assert arctan(math.inf) == 0.5 * math.pi and math.isnan(arctan(math.nan))
    assert arctan(0.0) == 0.0


@pytest.mark.skipif(not COMPILED, reason='interpreted, windows run one after the other')
@pytest.mark.parametrize('effects, side_by_side', [
    ([], True),
    ([{'id': 'stiffness', 'K': 31.0}, {'id': 'load_friction', 'Cl': 0.1},
      {'id': 'arm_viscous', 'Cav': 0.02}, {'id': 'load_torque', 'TL': 0.3}], True),
    ([{'id': 'actuator_lag', 'T': 0.004}, {'id': 'motor_encoder_delay', 'T': 0.003},
      {'id': 'arm_encoder_eccentricity', 'A': 0.02, 'phi': 1.0}], True),
    ([{'id': 'gravity', 'G': 0.3}], False),
    ([{'id': 'arm_coulomb', 'Cac': 0.05}], False),
    ([{'id': 'stribeck', 'Cs': 0.1, 'vs': 0.5}], False),
    ([{'id': 'mesh_error', 'A': 0.01, 'N': 7, 'phi': 0.0}], False),
])
def test_side_by_side_and_one_by_one_are_the_same_bits(effects, side_by_side, monkeypatch):
    model = model_from_dict({'effects': effects}, 'test')
    u = Excitation().torque(DT * np.arange(5000))
    run = Plant(model, Noise(measurement=(0.005, 0.005)), 3).run(u, DT)
    recording = Recording(run.t, u, run.y, DT)
    simulator, windows = Simulator(recording, model), cut(recording, 0.5)
    # Windows in any order, some several times; the first has no lead, others have.
    windows = windows.take(np.array([3, 0, 3, *range(len(windows)), 1]))
    random = np.random.default_rng(1)
    states = run.x[windows.begin] + 1e-3 * random.standard_normal((len(windows), 4))
    states[2, 2] = 1e308  # diverges
    memory = random.standard_normal((len(windows), N_MEMORY))
    extra = 0.05 * random.standard_normal((len(u), 3))
    used = []
    monkeypatch.setattr(lanes, 'suited', lambda *args, of=lanes.suited: (
        used.append(of(*args)) or used[-1]))
    together = simulator.run(windows, model, states, memory, extra)
    monkeypatch.setattr(lanes, 'suited', lambda *_: False)
    alone = simulator.run(windows, model, states, memory, extra)
    assert used == [side_by_side]
    for one, other in zip(together, alone):
        np.testing.assert_array_equal(one, other)
    assert not np.isfinite(alone[0][2]).all() and np.isfinite(alone[0][3:]).all()
