# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The watch over random arms at work: false alarms of healthy ones, and changes in the right joint.

A stream of joint states: MuJoCo's inverse dynamics on planned motions. The true arm has other
masses and rotors than its URDF; friction that no file knows (Stribeck, load, angle) and that
follows temperature; loads and postures that change; noise of encoders and torques. Sticking joints
hold any torque within their Coulomb friction.

usage examples:
  python -m benchmarks watch --seeds 11 12 --hours 24
  python -m benchmarks watch --seeds 13 --kinds friction torque_scale
  python -m benchmarks watch --load 300    # of the live node: 7 joints at 500 Hz
"""
from argparse import ArgumentParser, Namespace
from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from copy import deepcopy
from dataclasses import dataclass, field
import json
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any

import mujoco
import numpy as np

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish, write_json
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.watch.fold import begin, step
from gearbox_monitor.watch.record import Block, SECOND, WATCH, Watch, WATCH_SETTINGS

AXES = ('0 0 1', '0 1 0', '0 1 0', '1 0 0', '0 1 0', '1 0 0', '0 0 1')
SIZES = {'friction': 0.3, 'torque_scale': -0.15, 'weight': 0.3, 'rotor': 0.5, 'ripple': 0.05}
SETTLED, AFTER = 24, 20     # blocks before a planted change, and after it
LOAD, POSTURES = 0.2, 0.03  # of all blocks: a load changes, all postures do
START = 1_700_000_000 * SECOND // WATCH_SETTINGS.block_ns * WATCH_SETTINGS.block_ns


@dataclass
class Fault:
    """A planted change of a `kind` at a `joint` from `start_s` on."""

    kind: str
    joint: int
    start_s: float
    end_s: float = np.inf
    size: float = 0.0
    order: int = 0
    place: Array = field(default_factory=lambda: np.zeros(3))


class WorkingRobot:
    """A robot of a `seed`; blocks in order of time."""

    def __init__(self, seed: int) -> None:
        self.rng = rng = np.random.default_rng(seed)
        count = int(rng.integers(5, 8))
        self.joints = [f'joint{k + 1}' for k in range(count)]
        scale = float(rng.uniform(0.8, 1.3))
        length = scale * 0.36 * 0.8 ** np.arange(count)
        mass = scale ** 2 * 6.0 * 0.7 ** np.arange(count)
        self.length, self.mass = length, mass
        body: list[tuple[float, Array, Array]] = []
        for m, x in zip(mass, length):
            centre = np.array([*rng.uniform(-0.02, 0.02, 2), x / 2])
            body.append((m, centre, m * x ** 2 / 12 * np.array([1.1, 1.0, 0.3])))
        self.urdf = self._urdf(body)
        off = rng.uniform(-0.08, 0.08, count)
        self.body = [(m * (1 + d), c + rng.uniform(-0.01, 0.01, 3), i * (1 + d))
                     for (m, c, i), d in zip(body, off)]
        self.rate = float(rng.choice([100, 125, 250, 500]))
        self.phase = rng.uniform(0, 2 * np.pi)
        self.warm = float(rng.uniform(0.05, 0.1))   # amplitude of the day
        self.q = rng.uniform(-0.5, 0.5, count)
        self.postures = rng.uniform(-1.2, 1.2, (6, count))
        self.load, self.load_at, self.faults = 0.0, np.zeros(3), list[Fault]()
        usual = self._usual()
        self.usual = usual
        self.dry = usual * rng.uniform(0.08, 0.2, count) + 0.2
        self.wet = self.dry * rng.uniform(0.3, 1.0, count)
        self.rotor = rng.uniform(0.2, 0.6, count) * self.inertia
        self.stribeck, self.of_load = rng.uniform(0, 0.3, count), rng.uniform(0, 0.05, count)
        self.wavy = rng.uniform(0, 0.1, count)
        self.noise = 0.01 * usual
        self.encoder = float(10 ** rng.uniform(-4.7, -3.9))

    def _urdf(self, body: Sequence[tuple[float, Array, Array]]) -> str:
        parts = ['<robot name="arm"><link name="base"/>']
        for k, (m, c, i) in enumerate(body):
            parts.append(
                f'<link name="link{k + 1}"><inertial><origin xyz="{c[0]} {c[1]} {c[2]}"/>'
                f'<mass value="{m}"/><inertia ixx="{i[0]}" iyy="{i[1]}" izz="{i[2]}" ixy="0" '
                'ixz="0" iyz="0"/></inertial></link>')
            parent = f'link{k}' if k else 'base'
            at = self.length[k - 1] if k else 0.2
            parts.append(
                f'<joint name="{self.joints[k]}" type="revolute"><parent link="{parent}"/>'
                f'<child link="link{k + 1}"/><origin xyz="0 0.02 {at}"/><axis xyz="{AXES[k]}"/>'
                '<limit lower="-2.9" upper="2.9" effort="500" velocity="5"/></joint>')
        return ''.join(parts) + '</robot>'

    def _compiled(self, extra: list[tuple[int, float, Array]]) -> Any:
        """Return model and data with point masses (link, kg, place) on the true bodies."""
        body = list(self.body)
        for k, m, at in extra:
            m0, c0, i0 = body[k]
            whole = m0 + m
            c = (m0 * c0 + m * at) / whole

            def about(mass: float, p: Array, c: Array = c) -> Array:
                d = p - c
                return mass * (d @ d - d ** 2)
            body[k] = (whole, c, i0 + about(m0, c0) + about(m, at))
        text = self._urdf(body).replace('<robot name="arm">', '<robot name="arm"><mujoco>'
                                        '<compiler balanceinertia="true" fusestatic="false"/>'
                                        '</mujoco>')
        model = mujoco.MjModel.from_xml_string(text)
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        return model, mujoco.MjData(model)

    def _usual(self) -> Array:
        model, data = self._compiled([])
        total, inertia = np.zeros(len(self.joints)), np.zeros(len(self.joints))
        for _ in range(50):
            data.qpos[:] = self.rng.uniform(-1.0, 1.0, model.nv)
            data.qvel[:], data.qacc[:] = self.rng.normal(0, 0.6, model.nv), self.rng.normal(
                0, 1.5, model.nv)
            mujoco.mj_inverse(model, data)
            total += data.qfrc_inverse ** 2 / 50
            before = data.qfrc_inverse.copy()
            for k in range(model.nv):
                data.qacc[k] += 1.0
                mujoco.mj_inverse(model, data)
                inertia[k] += (data.qfrc_inverse[k] - before[k]) / 50
                data.qacc[k] -= 1.0
        self.inertia = inertia
        return np.sqrt(total)

    def warmth(self, t: float) -> float:
        """Return by how much friction is above its mean at `t` (s), by temperature."""
        return self.warm * float(np.sin(2 * np.pi * t / 86400.0 + self.phase))

    def _motion(self, seconds: float) -> tuple[Array, Array, Array, Array]:
        """Return t [N], q, v, a [N, J] of moves between postures, with rests."""
        n = int(round(seconds * self.rate))
        t = (np.arange(n) + 0.5) / self.rate
        q, v, a = (np.zeros((n, len(self.q))) for _ in range(3))
        begin, now = 0.0, self.q.copy()
        q[:] = now
        while begin < seconds:
            goal = self.postures[self.rng.integers(len(self.postures))] + self.rng.normal(
                0, 0.15, len(now))
            span = goal - now
            take = float(np.clip(1.9 * np.abs(span).max() / self.rng.uniform(0.5, 1.4), 0.6, 5.0))
            if begin + take > seconds:  # it rests until the next block
                break
            x = np.clip((t - begin) / take, 0, 1)
            rows = (t >= begin) & (t < begin + take + 0.3)
            shape = 10 * x ** 3 - 15 * x ** 4 + 6 * x ** 5
            slope = (30 * x ** 2 - 60 * x ** 3 + 30 * x ** 4) / take
            bend = (60 * x - 180 * x ** 2 + 120 * x ** 3) / take ** 2
            inside = (x > 0) & (x < 1)
            q[rows] = now + shape[rows, None] * span
            v[rows] = slope[rows, None] * span
            a[rows] = (bend * inside)[rows, None] * span
            begin, now = begin + take + float(self.rng.choice([0.0, 0.3])), goal
            q[t >= begin] = goal
            v[t >= begin] = a[t >= begin] = 0.0
        self.q = now
        return t, q, v, a

    def block(self, begin_s: float) -> Block:
        """Return the block that begins `begin_s` after START, a multiple of 20 s."""
        t, q, v, a = self._motion(WATCH_SETTINGS.block)
        count, at = len(self.q), begin_s + t
        active = [f for f in self.faults if f.start_s <= begin_s < f.end_s]
        extra = [(f.joint, f.size * self.mass[f.joint], f.place)
                 for f in active if f.kind == 'weight']
        if self.load:
            extra.append((count - 1, self.load, self.load_at))
        model, data = self._compiled(extra)
        torque = np.empty_like(q)
        for row, (x, dx, ddx) in enumerate(zip(q, v, a)):
            data.qpos[:], data.qvel[:], data.qacc[:] = x, dx, ddx
            mujoco.mj_inverse(model, data)
            torque[row] = data.qfrc_inverse
        rotor, friction = self.rotor.copy(), np.ones(count)
        for f in active:
            if f.kind == 'rotor':
                rotor[f.joint] *= 1 + f.size
            if f.kind == 'friction':
                friction[f.joint] *= 1 + f.size
        warmth = self.warmth(begin_s)
        sign = np.tanh(v / 0.004)
        dry = self.dry * (1 + self.stribeck * np.exp(-(v / 0.1) ** 2)
                          + self.wavy * np.sin(q + 1.0)) + self.of_load * np.abs(torque)
        rub = friction * (sign * dry * (1 + warmth) + self.wet * v * (1 + 1.5 * warmth))
        rest = np.abs(v) < 1e-6
        held = np.clip(np.cumsum(self.rng.normal(0, 0.01, q.shape), axis=0), -1, 1) * self.dry
        effort = torque + rotor * a + np.where(rest, held, rub)
        for f in active:
            if f.kind == 'ripple':
                effort[:, f.joint] += f.size * self.usual[f.joint] * np.sin(
                    f.order * q[:, f.joint] + 0.7)
        for f in active:
            if f.kind == 'torque_scale':
                effort[:, f.joint] *= 1 + f.size
        effort += self.noise * self.rng.standard_normal(q.shape)
        stamps = START + np.round(at * SECOND).astype(np.int64)
        return Block(int(START + begin_s * SECOND), tuple(self.joints), stamps,
                     q + self.encoder * self.rng.standard_normal(q.shape), v, effort)

    def change_load(self) -> None:
        """Take another load, or put it down."""
        if self.rng.random() < 0.4:
            self.load = 0.0
        else:
            self.load = float(self.rng.uniform(0.3, 1.0)) * 0.5 * float(self.mass[-1]) + 0.2
            self.load_at = np.array([*self.rng.uniform(-0.05, 0.05, 2),
                                     self.length[-1] + self.rng.uniform(0, 0.1)])


@dataclass
class Run:
    """The watch of a robot, the generator of what it does, and what is known of it so far."""

    robot: WorkingRobot
    rng: np.random.Generator
    watch: Watch
    time: float = 0.0
    raised: list[tuple[int, str, str]] = field(default_factory=list)
    errors: list[tuple[float, float]] = field(default_factory=list)

    def goes_on(self, numbers: Iterable[int], accelerated: int = 1) -> None:
        """Take the blocks with `numbers`; a day passes `accelerated` times as fast."""
        for k in numbers:
            if k and self.rng.random() < LOAD:
                self.robot.change_load()
            if k and self.rng.random() < POSTURES:
                self.robot.postures = self.rng.uniform(-1.2, 1.2, self.robot.postures.shape)
            self.watch, events = step(self.watch, self.robot.block(self.time))
            self.raised += [(k - SETTLED, e.place, e.words) for e in events if e.kind == 'raised']
            if self.watch.payloads:
                held = self.watch.payloads[0]
                self.errors.append((held.mass - self.robot.load, held.mass_std))
            self.time += WATCH_SETTINGS.block * (
                accelerated if self.watch.phase == WATCH else 1)

    def row(self, kind: str = '', joint: str = '') -> dict[str, Any]:
        """Return what was found, of a planted change of a `kind` at a `joint`, if any."""
        error, std = np.array(self.errors).T
        right = any(place == joint and words.startswith(kind) for _, place, words in self.raised)
        return {'kind': kind or 'none', 'joint': joint, 'joints': len(self.robot.joints),
                'judged': sum(j.level is not None for j in self.watch.joints),
                'raised': self.raised, 'right': right if kind else not self.raised,
                'kg_rms': float(np.sqrt(np.mean(error ** 2))),
                'within_2_std': float(np.mean(np.abs(error) < 2.0 * std))}


def watched(seed: int, kinds: Sequence[str], hours: float, accelerated: int
            ) -> Iterator[dict[str, Any]]:
    """
    Yield what the watch of a robot raised, and how well it weighed.

    Args:
        seed: of the robot.
        kinds: of planted changes, of SIZES, each after the same 8 min; none: a healthy robot.
        hours: of a robot without a change.
        accelerated: how many times as fast its day passes; blocks are as long.
    """
    robot, rng = WorkingRobot(seed), np.random.default_rng(seed + 9)
    joint = int(rng.integers(1, len(robot.joints) - 1))
    run = Run(robot, rng, begin(robot.urdf))
    if not kinds:
        run.goes_on(range(int(hours * 3600 / WATCH_SETTINGS.block / accelerated)), accelerated)
        yield run.row()
        return
    run.goes_on(range(SETTLED))
    for kind in kinds:
        changed = deepcopy(run)
        changed.robot.faults = [Fault(
            kind, joint, run.time, size=SIZES[kind], order=int(changed.rng.integers(4, 20)),
            place=np.array([0.05, 0.03, 0.8 * robot.length[joint]]))]
        changed.goes_on(range(SETTLED, SETTLED + AFTER))
        yield changed.row(kind, robot.joints[joint])


LOADED, HERTZ, SPARE = 7, 500.0, 60.0    # joints, their rate; s that the last block may take
BARS = {'node: share of a core, %': 10.0, 'child: share of a core, %': 15.0,
        'memory of both, MB': 300.0, 'messages dropped': 0.0}


def loaded(seconds: float) -> dict[str, float]:
    """
    Return what the live node costs beside a robot at work, by the names of BARS.

    Shares are CPU time over the time of the robot, so they hold on a busy machine, too.

    Args:
        seconds: of the robot's time.
    """
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String
    from gearbox_monitor.ros.convert import to_time
    robot = next(r for r in map(WorkingRobot, range(100)) if len(r.joints) == LOADED)
    robot.rate = HERTZ
    blocks = [robot.block(k * WATCH_SETTINGS.block)
              for k in range(int(seconds / WATCH_SETTINGS.block))]
    messages, told, ends = [], dict[str, str](), [0]
    for b in blocks:
        for stamp, *columns in zip(b.stamps.tolist(), b.position, b.velocity, b.effort):
            message = JointState(name=robot.joints)
            message.header.stamp = to_time(stamp)
            message.position, message.velocity, message.effort = (array('d', x) for x in columns)
            messages.append(message)

    def tell(array_: DiagnosticArray) -> None:
        told.update((v.key, v.value) for s in array_.status if s.name.endswith(': robot')
                    for v in s.values)
    with ExitStack() as stack:
        state = Path(stack.enter_context(TemporaryDirectory()), 'state')
        rclpy.init()
        stack.callback(rclpy.shutdown)
        node = rclpy.create_node('robot')
        node.create_subscription(DiagnosticArray, '/diagnostics', tell, 10)
        node.create_subscription(String, '/watch/findings', lambda message: ends.append(
            json.loads(message.data)['stamp_ns']), 10)
        states = node.create_publisher(JointState, 'joint_states', 1000)
        node.create_publisher(String, 'robot_description', QoSProfile(
            depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)).publish(String(data=robot.urdf))
        watcher = stack.enter_context(subprocess.Popen(
            [sys.executable, '-m', 'gearbox_monitor.ros.watch_node', '--ros-args', '-p',
             f'state_file:={state}']))
        stack.callback(watcher.terminate)
        while told.get('samples') is None or not states.get_subscription_count():
            rclpy.spin_once(node, timeout_sec=0.1)
        child, = Path(f'/proc/{watcher.pid}/task/{watcher.pid}/children').read_text().split()
        pids = watcher.pid, int(child)
        before, begun, peak = [_seconds(pid) for pid in pids], time.monotonic(), 0.0
        for k, message in enumerate(messages):
            time.sleep(max(begun + k / HERTZ - time.monotonic(), 0.0))
            states.publish(message)
            if k % 50 == 0:
                rclpy.spin_once(node, timeout_sec=0.0)
                peak = max(peak, sum(map(_megabytes, pids)))
        end = time.monotonic() + SPARE
        while time.monotonic() < end and int(told['samples']) < len(messages):
            rclpy.spin_once(node, timeout_sec=0.1)
        # The child gives way: on a busy machine it is behind. The last block is never whole.
        while time.monotonic() < end + SPARE and ends[-1] < blocks[-1].begin_ns:
            rclpy.spin_once(node, timeout_sec=0.1)
            peak = max(peak, sum(map(_megabytes, pids)))
        spent = [100.0 * (_seconds(pid) - x) / seconds for pid, x in zip(pids, before)]
        lost = len(messages) - int(told['samples']) + int(told['dropped'])
        return dict(zip(BARS, (*spent, peak, float(lost))))


def _seconds(pid: int) -> float:
    """Return the CPU time of a process, s."""
    times = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[11:13]
    return sum(map(int, times)) / os.sysconf('SC_CLK_TCK')


def _megabytes(pid: int) -> float:
    """Return the memory of a process now, MB; what it shares is counted once."""
    share, = (line.split()[1] for line in Path(f'/proc/{pid}/smaps_rollup').read_text()
              .splitlines() if line.startswith('Pss:'))
    return int(share) / 1024


def add_arguments(parser: ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('--seeds', type=int, nargs='+', default=[11, 12, 13], help='robots')
    parser.add_argument('--kinds', nargs='*', default=[], choices=[*SIZES],
                        help='planted changes; none: healthy robots')
    parser.add_argument('--hours', type=float, default=24.0, help='of a healthy robot')
    parser.add_argument('--accelerated', type=int, default=14, help='times as fast a day')
    parser.add_argument('--load', type=float, metavar='S', help='cost of the live node in S '
                        f'seconds of a robot with {LOADED} joints at {HERTZ:g} Hz')
    add_json_option(parser)


def run(args: Namespace) -> int:
    """Run the benchmark with the options `args`; returns the exit code."""
    if args.load:
        table = BarTable()
        for name, value in loaded(args.load).items():
            table.judge(name, value, high=BARS[name])
        return finish({'bars': table.rows}, '\n'.join(bar_lines(table.rows)), args.json)
    rows = []
    for seed in args.seeds:
        for row in watched(seed, args.kinds, args.hours, args.accelerated):
            rows.append({'seed': seed, **row})
            print(f'{seed:6d} {row["kind"]:13s}{row["joint"]:8s}'
                  f'{row["judged"]} of {row["joints"]} judged, load {row["kg_rms"]:.3f} kg rms, '
                  f'{row["within_2_std"]:.2f} within 2 std; {row["raised"]}', flush=True)
    write_json(rows, args.json)
    right = sum(r['right'] for r in rows)
    print(f'{right} of {len(rows)} right')
    return int(right < len(rows))
