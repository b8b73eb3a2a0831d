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

"""Bags of a simulated drive: to try commands on, and for benchmarks and tests."""
import numpy as np

from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.interfaces.signals import ARM, MOTOR, PLANT_TRANSMISSION_STATE, TRANSMISSION
from gearbox_monitor.plant.excitation import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant

NOISE = Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3))


def write_example_bag(path, model, seconds, seed=0, rate=1000.0, start=1_700_000_000,
                      topic='/joint_states', noise=NOISE, rest=0.0, truth=False):
    """
    Write the new bag `path` of a drive (DriveModel `model`) that is moved for `seconds`.

    Before that it stands still for `rest` s. `rate` Hz; `seed` of the Noise `noise`; `start`:
    first stamp in s. truth: write the true torque and twist, too. Raises InputError.
    """
    plant, dt = Plant(model, Noise(measurement=noise.measurement), seed), 1.0 / rate
    still = plant.run(np.zeros(round(rest * rate)), dt)
    plant.noise = noise
    t = np.arange(round(seconds * rate)) * dt
    run = plant.run(Excitation().torque(t), dt, len(still.t) * dt)
    t, u, y, x, tau_k, load = (
        np.concatenate([getattr(part, name) for part in (still, run)])
        for name in ('t', 'u', 'y', 'x', 'tau_k', 'tau_arm'))
    stamps = start * 1_000_000_000 + np.round(t * 1e9).astype(np.int64)
    measured = load if model.arm_load == 'measured' else np.full(len(t), np.nan)
    topics = {topic: encode_joint_states(  # the motor's on its own side, as on the wire
        stamps, [MOTOR, ARM], y * [model.gear_ratio, 1.0],
        effort=np.column_stack([u / model.effort_scale, measured]))}
    if truth:
        topics['/' + PLANT_TRANSMISSION_STATE] = encode_joint_states(
            stamps, [TRANSMISSION], *((x[:, i] - x[:, i + 1])[:, None] for i in (0, 2)),
            tau_k[:, None])
    with BagWriter(path, 'lz4') as writer:
        for name in topics:
            writer.add_topic(name, 'sensor_msgs/msg/JointState')
        for stamp, *messages in zip(stamps.tolist(), *topics.values()):
            for name, message in zip(topics, messages):
                writer.write(name, stamp, message)
