# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write dynamics.json: torques and inertias of arms by pinocchio 4.1 (pip install pin).

    python test/truth/dynamics.py config/arm6.urdf > test/truth/dynamics.json
"""
import json
from pathlib import Path
import sys

import numpy as np
import pinocchio


def states(text, count=4):
    """Return {name: rows} of a URDF: motion, torques, those of gravity, inertias."""
    model = pinocchio.buildModelFromXML(text)
    model.gravity.linear = np.array([0.0, 0.0, -9.80665])
    data, rng, rows = model.createData(), np.random.default_rng(11), []
    for _ in range(count):
        q, v, a = rng.normal(size=(3, model.nv))
        inertia = pinocchio.crba(model, data, q)
        rows.append((q, v, a, pinocchio.rnea(model, data, q, v, a),
                     pinocchio.computeGeneralizedGravity(model, data, q),
                     np.triu(inertia) + np.triu(inertia, 1).T))
    return {name: [x.tolist() for x in values] for name, values in zip(
        ('q', 'v', 'a', 'torque', 'gravity', 'inertia'), zip(*rows))}


if __name__ == '__main__':
    arm = Path(sys.argv[1]).read_text()
    slide = arm.replace('name="joint3" type="revolute"', 'name="joint3" type="prismatic"')
    json.dump({'arm': states(arm), 'slide': states(slide)}, sys.stdout, indent=0)
