# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate a drive and publish the readings of its sensors: the node ``plant``.

Publishes joint_states (measured positions and the torque in force from that stamp on) and
plant/transmission_state (the truth, same stamps). Stamps are exactly equidistant. Parameters are
those of parameters.PLANT; most can be changed while it runs.
"""
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
import math
import sys
import time
from typing import Any

import numpy as np
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Float64MultiArray

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import config_path
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.parameters import PLANT, PLANT_MODEL, PlantParameters
from gearbox_monitor.plant.drive import expect_integrable, expect_torque_input, model_from_dict
from gearbox_monitor.plant.effects.arm_side import ARM_COULOMB, GRAVITY, LOAD_TORQUE
from gearbox_monitor.plant.faults import EncoderFault, Excitation, Faults, FaultyPlant, JOINTS
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.topics import TRANSMISSION
from gearbox_monitor.ros.paced_node import declare, on_change, PacedNode, stamp
from gearbox_monitor.ros.runtime import advertise, drain, spin_node, subscribe_polled

EFFORT_COMMAND = 'effort_command'
DISCOVERY_TIME = 3.5  # s; a participant announces itself every 3 s
MAX_SUBSTEPS = 500    # integration steps per sample: 0.2 ms of computing time
LONGEST = 1e7         # s: a plant runs no longer
# Field of drive.faults.EncoderFault, Faults -> parameter.
ENCODER_FAULTS = {name: f'fault_{name}' for name in (
    'delay', 'scale', 'noise', 'outlier_rate', 'outlier_size')}
DRIVE_FAULTS = {
    **{name: f'fault_{name}' for name in (
        'torque', 'viscous_friction', 'coulomb_friction', 'stiffness', 'gap')},
    **{name: name for name in ('gap_growth_rate', 'gap_growth_start', 'gap_growth_max')}}


class PlantNode(PacedNode):
    """A drive in real time, or `speed` times as fast with /clock."""

    def __init__(self) -> None:
        super().__init__('plant')
        values = declare(self, [row for row in PLANT if row.name not in PLANT_MODEL])
        path = str(values['model']) or config_path('drive.yaml')
        self.drive = load_model(path)
        expect_torque_input(self.drive, str(path))
        values |= declare(self, [
            replace(row, default=self.drive.value(row.name)) for row in PLANT
            if row.name in PLANT_MODEL])
        self.values = PlantParameters.from_mapping(values)
        v = self.values
        self.set_pace(v.rate, v.duration, v.wait_for_subscribers, v.speed)
        self._command, self._refused = 0.0, 0
        self._command_at: int | None = None
        self._use(v)
        self.plant = FaultyPlant(self._model, self._noise, v.seed, self._faults)
        Plant(self._model, Noise(process=(1.0,) * 4)).run(np.zeros(2), self.dt)  # loads kernels
        on_change(self, PLANT, self._change)
        self._open()
        self.begin([v.motor_joint, v.arm_joint], [TRANSMISSION])
        self.warn_of_unknown()
        self.get_logger().info(
            f'{path}: {v.rate:g} Hz, torque from '
            f'{v.excitation if v.torque_source == "excitation" else EFFORT_COMMAND}, '
            f'speed {v.speed:g}, seed {v.seed}')

    # ------------------------------------------------------------------ parameters

    def _use(self, v: PlantParameters) -> None:
        """Make model, noise and excitation of the values `v`; raises InputError."""
        for name, length in (('process_noise', 4), ('measurement_noise', 2),
                             *((name, 2) for name in ENCODER_FAULTS.values())):
            numbers = list(getattr(v, name))
            if len(numbers) != length:
                raise InputError(f'plant: {name}: {numbers}, expected {length} numbers')
        excitation = Excitation(v.excitation, v.amplitudes, v.frequencies, v.period)
        if v.excitation == 'multisine' and len(v.amplitudes) != len(v.frequencies):
            raise InputError(f'plant: frequencies: {list(v.frequencies)}, expected one for each '
                             f'of the {len(v.amplitudes)} amplitudes')
        loads = ({'id': GRAVITY.id, 'G': v.load_gravity},
                 {'id': ARM_COULOMB.id, 'Cac': v.load_coulomb},
                 {'id': LOAD_TORQUE.id, 'TL': v.load_constant})
        values = self.drive.with_(**{name: getattr(v, name) for name in PLANT_MODEL}).to_dict()
        values['effects'] += [*loads, *map(_effect, filter(str.strip, v.effects))]
        model = model_from_dict(values, 'plant')
        encoders: dict[str, Any] = {joint: EncoderFault(
            frozen=v.fault_frozen in (joint, 'both'), lost=v.fault_lost in (joint, 'both'),
            **{field: getattr(v, name)[i] for field, name in ENCODER_FAULTS.items()})
            for i, joint in enumerate(JOINTS)}
        faults = Faults(
            v.fault_start, v.fault_duration or math.inf, **encoders,
            **{field: getattr(v, name) for field, name in DRIVE_FAULTS.items()})
        for source, drive in (('plant', model), (
                'plant with fault_...', faults.model(model.folded(), True, LONGEST))):
            expect_integrable(drive, self.dt, source, MAX_SUBSTEPS)
        self._model, self._excitation, self._faults = model, excitation, faults
        self._noise = Noise(v.process_noise, v.measurement_noise)

    def _change(self, changes: Mapping[str, object]) -> None:
        values = self.values.replace(**changes)
        self._use(values)
        self.values = values
        self.plant.model, self.plant.faults = self._model, self._faults
        self.plant.plant.noise = self._noise

    # ------------------------------------------------------------------ topics

    def _open(self) -> None:
        v = self.values
        self._clock_out = None
        if v.publish_clock or v.speed != 1.0:
            self._refuse_second_clock()
            self._clock_out = advertise(self, ClockMessage, '/clock', 10)
        self._commands = None
        if v.torque_source == 'topic':
            self._commands = subscribe_polled(self, Float64MultiArray, EFFORT_COMMAND, 10)
        self._clock_message = ClockMessage()

    def _refuse_second_clock(self) -> None:
        end, names = time.monotonic() + DISCOVERY_TIME, set[str]()
        # A publisher is discovered first, the name of its node a little later.
        while time.monotonic() < end and not any(map(self._is_named, names)):
            names = {i.node_name for i in self.get_publishers_info_by_topic('/clock')}
            time.sleep(0.05)
        if names:
            publishers = ', '.join(sorted(filter(self._is_named, names))) or 'of unknown name'
            raise InputError(
                f'/clock: is published by another node ({publishers}), expected no other source '
                'of time: stop it, or set speed to 1 and publish_clock to false')

    @staticmethod
    def _is_named(name: str) -> bool:
        return not name.startswith('_NODE_')

    # ------------------------------------------------------------------ running

    def begin_block(self) -> None:
        """Publish the time."""
        if self._clock_out:
            stamp(self._clock_message.clock, self.stamp_ns)
            self._clock_out.publish(self._clock_message)

    def most_at_once(self, n: int) -> int:
        """Return how many of `n` samples to simulate: with a torque from outside, one by one."""
        if self._commands:
            self.wait()  # it is taken at the sample's time
        return n if self._commands is None else 1

    def simulate(self, n: int) -> Iterator[tuple[float, ...]]:
        """Return n rows (u, y1, y2, twist, twist rate, tau_k, tau_arm) in arm-side values."""
        t = (self.count + np.arange(n)) * self.dt
        u = self._excitation.torque(t) if self._commands is None else np.array(self._commanded())
        run = self.plant.run(u, self.dt, t[0])
        x = run.x
        return zip(run.u.tolist(), run.y[:, 0].tolist(), run.y[:, 1].tolist(),
                   (x[:, 0] - x[:, 1]).tolist(), (x[:, 2] - x[:, 3]).tolist(),
                   run.tau_k.tolist(), run.tau_arm.tolist())

    def _commanded(self) -> list[float]:
        """Return [1] the torque (N m, arm side) that the last command demands."""
        for message, _ in drain(self._commands):
            if len(message.data) and math.isfinite(message.data[0]):
                self._command = message.data[0] * self.drive.effort_scale
                self._command_at = self.count
                continue
            self._refused += 1
            self.get_logger().warning(
                f'{EFFORT_COMMAND}: {self._refused} messages without a finite number ignored',
                throttle_duration_sec=5.0)
        timeout = self.values.command_timeout
        if self._command_at is not None and timeout > 0 and (
                (self.count - self._command_at) * self.dt > timeout):
            self._command, self._command_at = 0.0, None
            self.get_logger().warning(f'{EFFORT_COMMAND}: none for {timeout:g} s, torque is 0')
        return [self._command]

    def send(self, row: tuple[float, ...]) -> None:
        """Publish a `row` of `simulate`."""
        u, y1, y2, twist, rate, tau_k, tau_arm = row
        load = tau_arm if self.values.measure_arm_load else math.nan
        self.publish({'position': (y1 * self.drive.gear_ratio, y2),
                      'effort': (u / self.drive.effort_scale, load)},
                     {'position': (twist,), 'velocity': (rate,), 'effort': (tau_k,)})


def _effect(text: str) -> dict[str, str | float]:
    """Return the effect {'id': .., parameter: value} of a text like 'stribeck Cs=0.1 vs=0.2'."""
    name, *pairs = text.split()
    effect: dict[str, str | float] = {'id': name}
    for pair in pairs:
        key, _, value = pair.partition('=')
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise InputError(f'plant: effects: {text!r}: {pair!r}, expected name=number')
        if key in effect:
            raise InputError(f'plant: effects: {text!r}: {key} occurs twice, expected once')
        effect[key] = number
    return effect


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(PlantNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
