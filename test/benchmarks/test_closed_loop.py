# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A controller that is tuned in a file, and follows a path in the true drive."""
import json

import numpy as np
import pytest

from benchmarks import closed_loop
from benchmarks.__main__ import main
from benchmarks.blind import mujoco_drives

pytest.importorskip('mujoco')


def test_what_the_file_lacks_costs_the_controller_its_path(monkeypatch):
    """Tuned in a drive with a heavier link and a delay, it follows there what it else misses."""
    monkeypatch.setattr(closed_loop, 'ROUNDS', 3)
    nominal = {**mujoco_drives.drawn_nominal(np.random.default_rng(3)), 'G': 0.0,
               'timestep': 2e-3, 'integrator': 'implicitfast'}
    truth = {**nominal, 'm2': 1.8 * nominal['m2'], 'delay': 0.008}
    simulators = [closed_loop.Simulator(mujoco_drives.xml_of(v), 1e-3, 8.0, 1.0)
                  for v in (nominal, truth)]
    start, random = closed_loop.start_of(nominal), np.random.default_rng(4)
    path, other = (closed_loop.needing(3.0, closed_loop.shape(random), start) for _ in range(2))
    blind, sighted = (float(np.std(simulators[1].followed(
        other, closed_loop.tuned(s, path, start, [5]), [6]))) for s in simulators)
    assert sighted < 0.1 and blind > 2.0 * sighted


@pytest.mark.system
def test_the_patched_file_is_as_good_as_the_true_one(tmp_path):
    out = tmp_path / 'out.json'
    assert main(['closed_loop', '--drives', '2', '--seed', '1001', '--json', str(out)]) == 0
    rows = json.loads(out.read_text(encoding='utf-8'))['rows']
    assert len(rows) == 2
    assert all(r['errors']['patched'] < 1.1 * r['errors']['true'] for r in rows)
    assert [r['ids'] for r in rows if r['errors']['nominal'] > 1.1 * r['errors']['true']] == [
        r['ids'] for r in rows if not r['outside']] != []
