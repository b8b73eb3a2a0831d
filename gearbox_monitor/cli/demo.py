# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Simulate, estimate, record and check one gearbox whose backlash grows, on this machine only.

Plant, estimator and recorder run as separate ROS 2 nodes. At the end the recording is replayed and
compared, and DIR holds: bag/ (for gearbox_monitor replay, ros2 bag, mcap), report.html,
summary.json and the log of each node. Ctrl-C ends early and leaves a readable bag.
A machine that loses samples says so; the demo then misses no alarm.

With --robot the plant is an arm of six joints that repeats a program. One estimator watches all
of its gearboxes, and the backlash of one joint grows. DIR then also holds robot.yaml and a model
file of each joint.

usage examples:
  gearbox_monitor demo
  gearbox_monitor demo --robot
  gearbox_monitor demo --no-fault --duration 60 --out healthy
  gearbox_monitor demo --json > summary.json
"""
from argparse import Namespace
from collections.abc import Mapping
import contextlib
import json
import os
from pathlib import Path
import shutil
import sys
import time
from typing import Any

import yaml

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.files.user_files import config_path, load_robot, save_model
from gearbox_monitor.library.progress import Bar, count_bar
from gearbox_monitor.parameters import RecorderParameters
from gearbox_monitor.presentation import number
from gearbox_monitor.recordings.topics import SNAPSHOT
from gearbox_monitor.robot import arm_plant
from gearbox_monitor.robot.arm_plant import program
from gearbox_monitor.ros.middleware import Child, ChildFailed, Interrupt, own_domain

# Heavy modules are imported where they are used, after the handler of Ctrl-C is installed.

WINDOWS = 8            # windows for the fit of the gap, in whole seconds: it runs at 1 Hz
GROWTH_AFTER = 3.3     # windows; the first three are the baseline
GROWTH = 0.6           # of the gap, at the end
SUBSCRIBERS = 3        # estimator and recorder of the samples, recorder of the truth
# A few short windows must suffice for baseline and alarm, and they contain no whole period of the
# motion: one operating point, and a false alarm a day. No minute is healthy, to name causes by.
DRIFT = {'false_alarm_interval': 86400.0, 'angle_bin': 0.0, 'speed_bin': 1.0, 'load_bin': 1.0,
         'name_changes': False}
MIN_DURATION = 16.0    # s, for windows of two seconds
ROBOT_MIN_DURATION = 45.0  # s, for as many windows of a program of the arm
READY_SECONDS = 240.0  # a checkout whose kernels changed compiles them first
STOP_SECONDS = {'estimator': 15.0, 'recorder': 30.0}  # 10 of others
STALL_SECONDS = 30.0
# Shows the plant that the estimator listens.
RELIABLE = {'qos_overrides./joint_states.subscription.reliability': 'reliable'}


class Interrupted(Exception):
    """The user wants to end."""


class Demo:
    """One run of the demo: `live`, then `evaluate`."""

    durations = MIN_DURATION, 30.0  # the shortest and the default, s
    rate = 500.0                    # Hz
    plant = 'plant'                 # name of its node
    gearboxes: tuple[str, ...] = ('',)

    def __init__(self, args: Namespace, interrupt: Interrupt) -> None:
        """Check `args` and create the directory; `interrupt` ends early. Raises InputError."""
        shortest, usual = self.durations
        self.duration = usual if args.duration is None else args.duration
        if not shortest <= self.duration <= 86400.0:
            raise InputError(f'--duration: {self.duration:g}, expected {shortest:g} to 86400 s '
                             f'(the gap is measured in windows of {shortest / WINDOWS:.2g} s or '
                             'more)')
        self.fault = not args.no_fault
        self.interrupt = interrupt
        self.out = Path(args.out or time.strftime('gearbox_demo_%Y_%m_%d-%H_%M_%S'))
        self.bag = self.out / 'bag'
        self.children: list[Child] = []
        self.notes: list[str] = []
        self.check_interrupt()
        try:
            self.out.mkdir(parents=True)
        except FileExistsError:
            raise InputError(f'{self.out}: exists, expected a new directory') from None
        except OSError as error:
            raise InputError(f'{self.out}: {error.strerror}, expected a directory that can be '
                             'created') from None

    @property
    def window(self) -> float:
        """Length of the windows of the gap, s."""
        return float(self.duration // WINDOWS)

    @property
    def growth_start(self) -> float:
        """Time at which the gap begins to grow, s."""
        return GROWTH_AFTER * self.window

    @property
    def growth_rate(self) -> float:
        """Rate at which the gap grows, 1/s."""
        return GROWTH / (self.duration - self.growth_start) if self.fault else 0.0

    def check_interrupt(self) -> None:
        """Raise Interrupted if the user wants to end."""
        if self.interrupt.requested:
            raise Interrupted

    # ------------------------------------------------------------------ live

    def live(self, domain: int) -> None:
        """Run the nodes in ROS domain `domain` until the plant ends."""
        for name in ('ROS_LOCALHOST_ONLY', 'ROS_STATIC_PEERS'):
            os.environ.pop(name, None)  # they would override the range
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
        print(f'{self.out}: {self.duration:g} s at {self.rate:g} Hz, '
              + (f'the backlash{f" of {self.gearboxes[0]}" * bool(self.gearboxes[0])} grows'
                 if self.fault else 'no fault')
              + '\nTo look in with ros2 tools: export '
              f'ROS_DOMAIN_ID={domain} ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST', flush=True)
        began = False
        try:
            with contextlib.ExitStack() as stack:
                stack.callback(self.stop)
                self.start_monitoring()
                watcher = self.watcher(domain)
                stack.callback(watcher.close)
                self.wait_ready(watcher)
                began = True
                self.start(self.plant, rate=self.rate, duration=self.duration,
                           wait_for_subscribers=SUBSCRIBERS,
                           gap_growth_rate=self.growth_rate, gap_growth_start=self.growth_start)
                self.follow(watcher)
        except (Interrupted, ChildFailed):
            if began:
                print(f'bag {self.bag}')
            elif not (self.bag / 'metadata.yaml').exists():
                shutil.rmtree(self.bag, ignore_errors=True)  # the recorder never began
            raise
        finally:
            for note in self.notes:
                print(f'note: {note}', file=sys.stderr)

    def start_monitoring(self) -> None:
        """Start recorder and estimator."""
        self.start_recorder()
        self.start('estimator', tau_k_model='mixed', arm_load='model',
                   drift_window=self.window, **DRIFT, **RELIABLE)

    def start_recorder(self, **parameters: Any) -> None:
        """Start the recorder with further `parameters`."""
        # The output is a pattern of strftime.
        self.start('recorder', output=str(self.bag).replace('%', '%%'), **parameters)

    def start(self, name: str, *files: Path, **parameters: Any) -> None:
        """
        Start a node.

        Args:
            name: of the node and its log.
            files: with parameters.
            parameters: of the node.

        """
        self.check_interrupt()
        arguments = [word for file in files
                     for word in ('--ros-args', '--params-file', str(file), '--')]
        self.children.append(Child(name, f'gearbox_monitor.ros.{name}_node', parameters,
                                   self.out / f'{name}.log', os.environ, arguments))

    def stop(self) -> None:
        """Stop all nodes: senders first, the recorder last."""
        names = [self.plant, 'estimator', 'recorder']
        for child in sorted(self.children, key=lambda c: names.index(c.name)):
            self.notes += filter(None, [child.stop(STOP_SECONDS.get(child.name, 10.0))])

    def watcher(self, domain: int) -> Any:
        """Return a node that watches the others in `domain`. Raises InputError."""
        try:
            from gearbox_monitor.ros.live_node import Watcher
        except ImportError as error:
            raise InputError(f'rclpy: {error}; expected a sourced ROS 2 or an installation with '
                             f'{installed_by("ros")}') from None
        self.check_interrupt()
        return Watcher('demo', domain, self.gearboxes)

    def spin(self, watcher: Any) -> None:
        """Let `watcher` receive for a while; check the nodes and Ctrl-C."""
        watcher.spin(0.1)
        for child in self.children:
            child.check()
            if child.name != self.plant and not child.running:
                raise ChildFailed(f'{child.name} ended too early:\n{child.tail()}')
        self.check_interrupt()

    def wait_ready(self, watcher: Any) -> None:
        """Wait until `watcher` sees estimator and recorder. Raises ChildFailed."""
        end = time.monotonic() + READY_SECONDS
        while not watcher.ready():
            self.spin(watcher)
            if time.monotonic() > end:
                raise ChildFailed(
                    f'estimator and recorder were not ready within {READY_SECONDS:g} s:\n'
                    + '\n'.join(child.tail() for child in self.children))

    def follow(self, watcher: Any) -> None:
        """Show what `watcher` sees until the estimator has all samples of the plant."""
        plant, samples, alerts, changed = self.children[-1], 0, 0, time.monotonic()
        with count_bar('demo', round(self.duration)) as bar:
            while plant.running:
                self.spin(watcher)
                for alert in watcher.alerts[alerts:]:
                    Bar.write(f'ALERT {alert}')
                alerts = len(watcher.alerts)
                outcome = watcher.outcomes.get('input')
                newest = int(outcome.values.get('samples', 0)) if outcome else 0
                if newest != samples:
                    bar.update((newest - samples) / self.rate)
                    samples, changed = newest, time.monotonic()
                patience = STALL_SECONDS if samples else READY_SECONDS
                if time.monotonic() - changed > patience:
                    raise ChildFailed(f'no samples arrived for {patience:g} s:\n' + plant.tail())
            plant.check()
            updates, end = watcher.updates, time.monotonic() + 3.0
            while watcher.updates == updates and time.monotonic() < end:
                self.spin(watcher)

    # ------------------------------------------------------------------ afterwards

    def evaluate(self) -> tuple[dict[str, Any], str]:
        """Replay the bag, write JSON and page; return ({name: value}, the summary in words)."""
        print('replaying ...', flush=True)
        from gearbox_monitor.recordings.read import open_bag
        with open_bag(self.bag) as reader:
            data = evaluated(reader, self)
        data['notes'] += self.notes
        data['problems'] = problems(data)
        (self.out / 'summary.json').write_text(json.dumps(data, indent=2) + '\n',
                                               encoding='utf-8')
        return data, text(data)


class RobotDemo(Demo):
    """One run of the demo of an arm; the gap of its first joint grows."""

    durations = ROBOT_MIN_DURATION, 60.0
    plant = 'arm_plant'
    rate = 250.0  # Hz, for six filters on a small machine

    def __init__(self, *arguments: Any) -> None:
        """Take the `arguments` of Demo; write a model file of each joint."""
        description = config_path('arm6.urdf')
        robot = load_robot(str(description))
        self._description, self.gearboxes = str(description), tuple(robot.joints)
        super().__init__(*arguments)
        self.drives = dict(zip(self.gearboxes, arm_plant.nominal_drives(robot)))
        for name, drive in self.drives.items():
            save_model(self.out / f'{name}.yaml', drive, [
                f'Drive of {name} in {description.name}.'])

    @property
    def window(self) -> float:
        """Length of the windows of the gap, s: of the arm's program, which all of them repeat."""
        return len(program(1.0 / self.rate)) / self.rate

    def start_monitoring(self) -> None:
        """Start recorder and estimator; write their parameters, for robot.launch.py, too."""
        self.start_recorder(topics=[*RecorderParameters().topics, *(
            f'estimator/{name}/{SNAPSHOT}' for name in self.gearboxes)])
        file = self.out / 'robot.yaml'
        file.write_text('# The gearboxes of the arm, as the demo monitors them.\n'
                        + yaml.safe_dump({
                            'estimator': {'ros__parameters': {
                                'gearboxes': list(self.gearboxes),
                                'robot_description': self._description,
                                'drift_window': self.window, **DRIFT, **{
                                    name: {'model': str(self.out / f'{name}.yaml'),
                                           **arm_plant.parameters_of(joint)}
                                    for joint, name in enumerate(self.gearboxes)}}},
                            'arm_plant': {'ros__parameters': {
                                'rate': self.rate, 'faulty_joint': 1,
                                'gap_growth_rate': self.growth_rate,
                                'gap_growth_start': self.growth_start}}},
                            sort_keys=False), encoding='utf-8')
        self.start('estimator', file, **RELIABLE)


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    output = sys.stdout
    # With --json, standard output gets nothing else: progress goes to standard error.
    with contextlib.redirect_stdout(sys.stderr if args.json == '-' else output), \
            Interrupt() as interrupt:
        try:
            demo = (RobotDemo if args.robot else Demo)(args, interrupt)
            with own_domain() as domain:
                demo.live(domain)
            interrupt.at_once()
            demo.check_interrupt()
            data, text = demo.evaluate()
            from gearbox_monitor.cli.options import show
            with contextlib.redirect_stdout(output):
                show(args, data, lambda: text)
            for problem in data['problems']:
                print(f'problem: {problem}', file=sys.stderr)
            return 1 if data['problems'] else 0
        except Interrupted:
            print('interrupted', flush=True)
            return 130
        except ChildFailed as error:
            print(f'gearbox_monitor demo: {error}', file=sys.stderr)
            return int(error.code)


MAX_LOSS = 0.01  # of samples or estimates: a busy machine may miss the alarm
SLOW = 'This machine was too busy and dropped samples or estimates: an alarm may be missing.'


def evaluated(reader: Any, demo: Any) -> dict[str, Any]:
    """Replay the bag `reader` of a `demo`, write its page; return {name: value}."""
    from gearbox_monitor.library.recording_report import write_report
    from gearbox_monitor.recordings.replay import replay
    expected, joints = round(demo.duration * demo.rate), dict[str, Any]()
    stamps: set[int] = set()
    pages = write_report(demo.bag, demo.out / 'report.html')
    for name in demo.gearboxes:
        result = replay(reader, topic=name or 'joint_states')
        stamps.update(result.samples.stamp_ns.tolist())
        gap = 2.0 * result.estimator.model.transmission.half_gap
        grown = demo.growth_rate * (demo.duration - demo.growth_start) * (
            name == demo.gearboxes[0])
        joints[name] = {
            **result.summary, 'true_gap_rad': [gap, gap * (1.0 + grown)],
            'alarms': pages.figures.get('joints', {name: pages.figures})[name]['alerts'],
            'backlash': result.monitor.outcomes['backlash'].message}
    missing = expected - len(stamps), expected - 1 - reader.count('/transmission_state')
    return {
        'summary': pages.headline, 'page': str(pages.page), 'bag': str(demo.bag),
        'duration_s': float(demo.duration), 'rate_hz': demo.rate,
        'samples': len(stamps), 'samples_expected': expected,
        'samples_missing': missing[0], 'estimates_missing': missing[1],
        'starved': max(missing) >= MAX_LOSS * expected, 'joints': joints,
        'planted': list(demo.gearboxes[:demo.fault]),
        'seen': [name for name, joint in joints.items() if joint['alarms']],
        'notes': list(dict.fromkeys(n for joint in joints.values() for n in joint['notes']))}


def problems(data: Mapping[str, Any]) -> list[str]:
    """Return the failures in the `data` of a run; a machine that lost samples may miss alarms."""
    failures = []
    for name, joint in data['joints'].items():
        place = f'{name}: ' if name else ''
        if not joint['estimates']:
            failures.append(f'{place}there are no estimates')
        if joint.get('replay_identical') != 'yes':
            failures.append(f'{place}replay was not identical: ' + (
                joint.get('comparison', {}).get('first')
                or joint.get('replay_identical', 'not compared')))
        if name in data['planted'] and name not in data['seen'] and not data['starved']:
            failures.append(f'{place}the backlash grew without a backlash alarm')
        if name in data['seen'] and name not in data['planted']:
            failures.append(f'{place}alarm without a fault')
    return failures


def text(data: Mapping[str, Any]) -> str:
    """Return the summary `data` in words."""
    joints = data['joints']
    identical, compared = (sum(joint.get('comparison', {}).get(key, 0)
                               for joint in joints.values()) for key in ('identical', 'compared'))
    verdicts = {joint.get('replay_identical', 'not compared') for joint in joints.values()}
    lines = [
        data['summary'], *([SLOW] if data['starved'] else []), '',
        f'samples      {data["samples"]} of {data["samples_expected"]} at {data["rate_hz"]:g} Hz; '
        f'dropped: {data["samples_missing"]} samples, {data["estimates_missing"]} estimates',
        f'replay       identical: {", ".join(sorted(verdicts - {"yes"})) or "yes"} ({identical} '
        'messages bit for bit' + f'; {compared - identical} follow a loss' * (
            identical < compared) + ')']
    for name, joint in joints.items():
        lines.append(f'{name or "gearbox":<12} {_seen(joint)}')
        lines += [f'             {alarm["t"]:.1f} s {alarm["component"]} {alarm["level"]}: '
                  f'{alarm["message"]}' for alarm in joint['alarms']]
    return '\n'.join([*lines, *(f'note         {note}' for note in data['notes']),
                      f'page         {data["page"]}',
                      f'next         gearbox_monitor replay {data["bag"]}'
                      + f' --topic {next(iter(joints))}' * (len(joints) > 1)])


def _seen(joint: Mapping[str, Any]) -> str:
    """Return what was seen of a `joint` in one line."""
    gaps, true = ([1e3 * gap for gap in joint[name]] for name in ('gap_rad', 'true_gap_rad'))
    words = (f'backlash {number(gaps[0])} to {number(gaps[-1], "mrad")} (true: {number(true[0])} '
             f'to {number(true[1])})' if gaps else joint['backlash'])
    if joint.get('tau_k_error') is not None:
        error, late, size = (number(joint[f'tau_k_{name}']) for name in (
            'error', 'error_smoothed', 'rms'))
        words += (f'; tau_K error {error}, smoothed {late}, of {size} N m rms; NIS '
                  f'{joint["nis"]:.2f} ({joint["nis_expected"]:.3g} expected)')
    return words + ('' if joint['alarms'] else '; no alarm')
