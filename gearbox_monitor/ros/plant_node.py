# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate a drive and publish the readings of its sensors: the node ``plant``.

Publishes joint_states (measured positions and the torque in force from that stamp on) and
plant/transmission_state (the truth, same stamps). Stamps are exactly equidistant. Parameters are
those of parameters.PLANT; most can be changed while it runs.
"""
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
import math
import sys
import time
from typing import Any

from builtin_interfaces.msg import Time
import numpy as np
from rclpy.duration import Duration
from rclpy.logging import get_logger
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path, load_model
from gearbox_monitor.parameters import PLANT, PLANT_MODEL, PlantParameters
from gearbox_monitor.plant.drive import expect_integrable, expect_torque_input, model_from_dict
from gearbox_monitor.plant.effects.arm_side import ARM_COULOMB, GRAVITY, LOAD_TORQUE
from gearbox_monitor.plant.faults import EncoderFault, Excitation, Faults, FaultyPlant, JOINTS
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.topics import JOINT_STATES, PLANT_TRANSMISSION_STATE, TRANSMISSION
from gearbox_monitor.ros.runtime import (
    advertise, declare, finish, on_change, spin_node, steady_timer, TableNode)

SECOND = 1_000_000_000
BLOCK_TIME = 0.01     # s between two checks for services: the wait for a changed parameter
FREE_RUN_BLOCK = 50   # samples, when there is no pace
REPORT_PERIOD = 10.0  # s between two reports of overruns
ACKNOWLEDGED = Duration(seconds=5)
QUEUE = 1000          # messages kept for a slow subscriber


class PacedNode(TableNode):
    """
    Base of the simulated plants: calls `simulate` and `send` at the pace of `set_pace`.

    count: samples published; t0_ns: stamp of the first; dt, dt_ns: between two.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.count = self.t0_ns = 0
        self.overruns = 0        # samples published more than one period late
        self.max_delay = 0.0     # s
        self._reported, self._report_at = 0, 0.0
        self._start = 0  # ns of a steady clock, 0: not yet

    def set_pace(self, rate: float, duration: float, subscribers: int, speed: float = 1.0) -> None:
        """
        Set when samples are due.

        Args:
            rate: samples per simulated second.
            duration: simulated time after which the process ends, s; 0: never.
            subscribers: start once the outputs have so many together; 0: at once.
            speed: simulated seconds per second; 0: as fast as possible.

        """
        self.dt_ns = round(SECOND / rate)
        self.dt = self.dt_ns / SECOND
        self._speed, self._expected, self._awaited = speed, round(duration / self.dt), subscribers
        self.block = FREE_RUN_BLOCK if speed == 0 else max(1, round(BLOCK_TIME * rate * speed))

    def begin(self, joints: Sequence[str], truth: Sequence[str]) -> None:
        """Start to work: publish samples of `joints` and, of the names `truth`, the truth."""
        # Reused for every sample: making new ones costs more than sending them.
        self._states, self._truth = JointState(name=joints), JointState(name=truth)
        self._outputs = [advertise(self, JointState, topic, QUEUE)
                         for topic in (JOINT_STATES, PLANT_TRANSMISSION_STATE)]
        # A node timer would follow /clock, which may be this node's own.
        self._timer = steady_timer(self, 1e-3, self._work)

    def publish(self, states: Mapping[str, Sequence[float]], truth: Mapping[str, Sequence[float]]
                ) -> None:
        """Publish `states` and `truth`, {field of JointState: values}, stamped `stamp_ns`."""
        for output, message, fields in zip(
                self._outputs, (self._states, self._truth), (states, truth)):
            stamp(message.header.stamp, self.stamp_ns)
            for field, values in fields.items():
                setattr(message, field, array('d', values))
            output.publish(message)

    def simulate(self, n: int) -> Iterator[tuple[Any, ...]]:
        """Return the next `n` samples."""
        raise NotImplementedError

    def send(self, row: tuple[Any, ...]) -> None:
        """Publish a `row` of `simulate`, stamped `stamp_ns`."""
        raise NotImplementedError

    def begin_block(self) -> None:
        """Do what comes before a block of samples."""

    @property
    def stamp_ns(self) -> int:
        """Stamp of the next sample."""
        return self.t0_ns + self.count * self.dt_ns

    def _work(self) -> None:
        """Simulate and publish one block of samples, each at its time."""
        if not self._start:
            if sum(out.get_subscription_count() for out in self._outputs) < self._awaited:
                return
            self._start = time.monotonic_ns()
            self.t0_ns = time.time_ns()
        self.begin_block()
        end = self._expected
        for row in self.simulate(min(self.block, end - self.count) if end > 0 else self.block):
            self.wait()
            self.send(row)
            if self.count == 0 and self._awaited:
                self._await_first()
            self.count += 1
        self._report()
        if 0 < end <= self.count:
            finish(self._timer, self._outputs)

    def wait(self) -> None:
        """Sleep until the time of the next sample, counted from the start: no drift."""
        if self._speed == 0:
            return
        deadline = self._start + int(self.count * self.dt_ns / self._speed)
        wait = (deadline - time.monotonic_ns()) / SECOND
        if wait > 0:
            time.sleep(wait)
        elif -wait > self.dt / self._speed:
            self.overruns += 1
            self.max_delay = max(self.max_delay, -wait)

    def _await_first(self) -> None:
        """Wait until all have the first sample: a publisher knows them up to 3 s before."""
        for publisher in self._outputs:
            publisher.wait_for_all_acked(ACKNOWLEDGED)
        self._start = time.monotonic_ns()

    def _report(self) -> None:
        time_s = time.monotonic()
        if self.overruns > self._reported and time_s > self._report_at:
            self.get_logger().warning(self._overrun_text())
            self._reported, self._report_at = self.overruns, time_s + REPORT_PERIOD

    def _overrun_text(self) -> str:
        return (f'{self.overruns} of {self.count} samples were more than a period late, at worst '
                f'{1e3 * self.max_delay:.1f} ms (stamps are not affected)')

    def close(self) -> None:
        """Report how many samples were published."""
        text = f'published {self.count} samples'
        # A logger without /rosout, which is gone when a signal has ended the context.
        get_logger(f'{self.get_name()}_node').info(
            f'{text}; {self._overrun_text()}' if self.overruns else text)


def stamp(time_message: Time, ns: int) -> None:
    """Set `time_message` to `ns`."""
    time_message.sec, time_message.nanosec = divmod(ns, SECOND)


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
        self._use(v)
        self.plant = FaultyPlant(self._model, self._noise, v.seed, self._faults)
        Plant(self._model, Noise(process=(1.0,) * 4)).run(np.zeros(2), self.dt)  # loads kernels
        on_change(self, PLANT, self._change)
        self._open()
        self.begin([v.motor_joint, v.arm_joint], [TRANSMISSION])
        self.warn_of_unknown()
        self.get_logger().info(
            f'{path}: {v.rate:g} Hz, {v.excitation}, speed {v.speed:g}, seed {v.seed}')

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
        values['effects'] += loads
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
            self._clock_out = advertise(self, ClockMessage, '/clock', 10)
        self._clock_message = ClockMessage()

    # ------------------------------------------------------------------ running

    def begin_block(self) -> None:
        """Publish the time."""
        if self._clock_out:
            stamp(self._clock_message.clock, self.stamp_ns)
            self._clock_out.publish(self._clock_message)

    def simulate(self, n: int) -> Iterator[tuple[float, ...]]:
        """Return n rows (u, y1, y2, twist, twist rate, tau_k, tau_arm) in arm-side values."""
        t = (self.count + np.arange(n)) * self.dt
        run = self.plant.run(self._excitation.torque(t), self.dt, t[0])
        x = run.x
        return zip(run.u.tolist(), run.y[:, 0].tolist(), run.y[:, 1].tolist(),
                   (x[:, 0] - x[:, 1]).tolist(), (x[:, 2] - x[:, 3]).tolist(),
                   run.tau_k.tolist(), run.tau_arm.tolist())

    def send(self, row: tuple[float, ...]) -> None:
        """Publish a `row` of `simulate`."""
        u, y1, y2, twist, rate, tau_k, tau_arm = row
        load = tau_arm if self.values.measure_arm_load else math.nan
        self.publish({'position': (y1 * self.drive.gear_ratio, y2),
                      'effort': (u / self.drive.effort_scale, load)},
                     {'position': (twist,), 'velocity': (rate,), 'effort': (tau_k,)})


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(PlantNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
