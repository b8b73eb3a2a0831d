# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The gearboxes of an estimator node and their settings, from the parameters of the node."""
from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
import json
import math
import re
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import Temperature
from std_msgs.msg import String

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Estimate, Sample
from gearbox_monitor.estimation.filter_setup import described
from gearbox_monitor.estimation.sample_loop import REASONS, SECOND
from gearbox_monitor.files.baselines import (
    AGAIN, Damaged, earlier, health_text, load_state, save_baseline, set_aside, STATE, StateFile)
from gearbox_monitor.files.user_files import config_path, load_model, load_robot, TOPIC
from gearbox_monitor.health.alarms import Level, LIMITS, Outcome, outcome_of, with_more
from gearbox_monitor.health.checks import observability
from gearbox_monitor.health.health_record import FeatureHealth
from gearbox_monitor.health.judgement import accepted
from gearbox_monitor.health.monitor import Monitor, NO_DATA
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.kernels.types import Integers
from gearbox_monitor.parameters import (
    ESTIMATOR, EstimatorParameters, FIXED, MODEL, PAYLOAD, ROBOT, RobotParameters, SETTINGS, Table)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said
from gearbox_monitor.recordings.joint_input import GEARBOX, PAYLOAD_CHANGE
from gearbox_monitor.recordings.topics import ARM, DIAGNOSIS, MOTOR, SNAPSHOT, TRANSMISSION
from gearbox_monitor.robot.description import parse, RobotDescription
from gearbox_monitor.ros.change_watch import ChangeNamer, ChangeWatch
from gearbox_monitor.ros.convert import (
    GearboxNames, RawSample, to_diagnostics, to_snapshot, to_status)
from gearbox_monitor.ros.gearbox_input import GearboxInput
from gearbox_monitor.ros.recording_export import BlackBox, KEEP
from gearbox_monitor.ros.runtime import (
    advertise, best_effort, declare, latched, subscribe, TableNode)

# What two gearboxes may not share: names in messages, files of their own.
OWN = ('motor_joint', 'arm_joint', 'baseline_file', 'drift_state_file')
PATIENCE = 15.0  # s until a latched description of the robot must have come


@dataclass(frozen=True)
class GearboxSettings:
    """
    Settings of one gearbox.

    name: '' for the only one of a node; parameters; model: of its drive, with the values that
    `changed` {name: value} puts in place of those in `model_file`; robot: of robot_description.
    """

    name: str
    parameters: EstimatorParameters
    model: DriveModel
    model_file: str
    changed: Mapping[str, Any]
    robot: RobotDescription | None = None

    @property
    def prefix(self) -> str:
        """What precedes the names of its parameters on the node."""
        return f'{self.name}.' if self.name else ''

    def rows(self, table: Table) -> Table:
        """Return the rows of `table` under the names that they have on the node."""
        return tuple(replace(row, name=self.prefix + row.name) for row in table)


def declare_gearboxes(node: TableNode) -> list[GearboxSettings]:
    """
    Declare the parameters of all gearboxes on `node` and return their settings.

    Without `gearboxes` the node has one, without a name. Raises InputError that names the gearbox.
    """
    robots: dict[str, RobotDescription] = {}  # read once each
    names = RobotParameters.from_mapping(declare(node, ROBOT)).gearboxes
    if names == RobotParameters.gearboxes:
        return [_declared(node, '', {}, robots)]
    source = f'node {node.get_name()}: gearboxes'
    used = {row.name for row in SETTINGS + ROBOT} | {'use_sim_time', 'qos_overrides'}
    for k, name in enumerate(names):
        if not re.fullmatch(r'[A-Za-z][A-Za-z0-9_]*', name) or name in used or name in names[:k]:
            raise InputError(f'{source}: {name!r}, expected different names of letters, digits '
                             'and _ that are no parameters')
    common = declare(node, [replace(row, change=FIXED) for row in ESTIMATOR])
    gearboxes = [_declared(node, name, {**common, 'gearbox_serial': name}, robots)
                 for name in names]
    _expect_own(f'node {node.get_name()}', gearboxes)
    return gearboxes


def _declared(node: TableNode, name: str, common: Mapping[str, Any],
              robots: dict[str, RobotDescription]) -> GearboxSettings:
    """
    Declare the gearbox `name` with the defaults `common` {parameter: value}.

    robots: {robot_description: its robot} so far.
    """
    prefix = f'{name}.' if name else ''

    def declared(table: Sequence[Any]) -> dict[str, Any]:
        values = declare(node, [replace(row, name=prefix + row.name) for row in table])
        return {key.removeprefix(prefix): value for key, value in values.items()}

    parameters = EstimatorParameters.from_mapping(declared(
        [replace(row, default=common.get(row.name, row.default)) for row in ESTIMATOR]))
    with located(name):
        model_file = parameters.model or config_path('drive.yaml')
        model = load_model(model_file)
        source = parameters.robot_description if described(parameters) else ''
        if source and parameters.arm_topic:
            raise InputError(f'arm_topic: {parameters.arm_topic!r}, expected none with '
                             'robot_description: all joints come in one message')
        if source and source not in robots:
            robots[source] = _robot_of(node, source)
    changed = declared([replace(row, default=getattr(model, row.name)) for row in MODEL])
    return GearboxSettings(name, parameters, model.with_(**changed), str(model_file), changed,
                           robots.get(source))


def _robot_of(node: Node, source: str) -> RobotDescription:
    """
    Return the robot of the parameter robot_description of a `node`.

    source: its value, a file or topic:TOPIC. Waits for the topic. Raises InputError if it is no
    URDF, or does not come.
    """
    if not source.startswith(TOPIC):
        return load_robot(source)
    topic = node.resolve_topic_name(source.removeprefix(TOPIC))
    node.get_logger().info(f'waiting for the robot description on {topic}')
    came, message = wait_for_message(String, node, topic, qos_profile=latched(),
                                     time_to_wait=PATIENCE)
    if came:
        return parse(message.data, topic)
    raise InputError(f'robot_description: {topic}: nothing came in {PATIENCE:g} s, expected a '
                     'robot description, as robot_state_publisher gives it')


def _expect_own(source: str, gearboxes: Sequence[GearboxSettings]) -> None:
    """Raise InputError that begins with `source` for what `gearboxes` may not have in common."""
    for gearbox in gearboxes:
        if arm_topic := gearbox.parameters.arm_topic:
            raise InputError(f'{source}: {gearbox.name}.arm_topic: {arm_topic!r}, expected none '
                             'with several gearboxes: the arm comes with the motor')
    for key in OWN:
        owners: dict[str, str] = {}
        for gearbox in gearboxes:
            value = getattr(gearbox.parameters, key)
            if value and owners.setdefault(value, gearbox.name) != gearbox.name:
                raise InputError(f'{source}: {gearbox.name}.{key}: {value!r}, expected another '
                                 f'than that of {owners[value]}')


@contextmanager
def located(name: str) -> Iterator[None]:
    """Let an InputError name the gearbox `name`, if it has a name."""
    try:
        yield
    except InputError as error:
        if not name:
            raise
        raise InputError(f'{name}: {error}') from None


class MonitoredGearbox:
    """
    Shell around the Monitor of one gearbox of `node`; its name precedes what is its own.

    settings: of the gearbox; alerts: where all gearboxes publish theirs; namer: has changes of all
    named; phase_ns: of its evaluations, see Monitor.

    input: takes its samples from messages. names: what messages call it.
    """

    def __init__(self, node: TableNode, settings: GearboxSettings, alerts: Publisher,
                 namer: ChangeNamer, phase_ns: int = 0) -> None:
        self._node, self.name, self._alert_output = node, settings.name, alerts
        self._says = f'{self.name}: ' if self.name else ''  # in front of what is logged
        values, model = settings.parameters, settings.model
        self._component = node.get_fully_qualified_name().lstrip('/') + (
            f'/{self.name}' if self.name else '')
        self._state_file = StateFile(values.drift_state_file, self._component) \
            if values.drift_state_file else None
        self._lost = ''  # a file that was set aside at the start, until a baseline is saved
        known, recording_ns = self._state_at_start(values)
        self.monitor = Monitor(model, values, known, settings.robot, phase_ns)
        self.names = GearboxNames(
            {TRANSMISSION: self.name or TRANSMISSION, MOTOR: values.motor_joint,
             ARM: values.arm_joint}, model.gear_ratio)
        self._starts = 0
        self._divergences = 0
        self._clock_set_back = 0  # how often
        self._silence = Silence()
        self._levels: dict[str, Level] = {}
        self._state_stamp = self.monitor.health.stamp_ns
        self._state_error = ''
        self._topics = ''
        self._snapshot_stamp = 0
        self._snapshots = advertise(node, DiagnosticArray, self.private(SNAPSHOT), latched())
        self.input = GearboxInput(node, values, model, self._on_other_publisher,
                                  self.monitor.estimator.robot_joints)
        self._black_box = BlackBox(node, self.monitor, values, self.input.topic,
                                   node.resolve_service_name(self.private(KEEP)))
        self._changes: ChangeWatch | None = None
        if values.name_changes:
            self._changes = ChangeWatch(self.monitor, self._black_box.buffer, namer,
                                        self._state_file, recording_ns)
            if self._changes.note:
                node.get_logger().warning(self._says + self._changes.note)
            self._diagnoses = advertise(node, String, self.private(DIAGNOSIS), latched())
        if values.temperature_topic:
            subscribe(node, Temperature, values.temperature_topic, self._on_temperature,
                      best_effort(1))

    def private(self, name: str) -> str:
        """Return the name relative to the node of the gearbox's topic or service `name`."""
        return f'~/{self.name}/{name}' if self.name else f'~/{name}'

    def start(self, topics: Mapping[str, str]) -> None:
        """Publish the first snapshot; `topics` {topic: name in the graph}: replay needs them."""
        self._topics = json.dumps(topics)
        self._publish_snapshot('start')

    def welcome(self) -> None:
        """Report warnings and drift alerts from before the first sample."""
        self._warn([])
        self._alert()

    def close(self) -> None:
        """Write the state; let a recording that is being written come to its end."""
        if self.monitor.input_count:
            self._keep_state()
        if self._state_file is not None:
            self._state_file.close()
        self._black_box.close()

    def _warn(self, logged: Container[str]) -> None:
        """Log the warnings about the settings that are not `logged` yet."""
        for text in self.monitor.estimator.warnings:
            if text not in logged:
                self._node.get_logger().warning(self._says + text)

    def _state_at_start(self, values: EstimatorParameters) -> tuple[Any, int]:
        """
        Return (what was known, stamp of the baseline recording).

        Of the state file, else of the baseline.
        """
        if self._state_file is not None and self._state_file.readable:
            state, self._lost = load_state(values.drift_state_file, values.gearbox_serial)
            if state is not None:
                return state['health'], state['recording_ns']
        known = None
        try:
            known, missing = earlier(values.to_dict())
            if missing:
                self._node.get_logger().info(
                    f'{self._says}{values.baseline_file}: no baseline yet; '
                    f'{self.private("save_baseline")} writes it')
        except Damaged as error:
            aside = f'{error}: {set_aside(values.baseline_file)}; {AGAIN}'
            self._lost = '; '.join(filter(None, (self._lost, aside)))
        if self._lost:
            self._node.get_logger().error(self._says + self._lost)
        return known, 0

    # ------------------------------------------------------------------ samples

    def step(self, sample: Sample, raw: RawSample) -> Estimate | None:
        """Take `sample`, and as received `raw`; return its Estimate, None if it is refused."""
        previous_ns = self.monitor.stamp_ns
        estimate = self.monitor.step(sample)
        self._black_box.add(sample.stamp_ns, estimate is not None, raw)
        if self.monitor.counts[sample_loop.DIVERGED] != self._divergences:
            self._divergences = int(self.monitor.counts[sample_loop.DIVERGED])
            self._node.get_logger().error(
                f'{self._says}{self.monitor.estimator.divergences[-1]}; restarting',
                throttle_duration_sec=5.0)
        if self.monitor.counts[sample_loop.START] != self._starts:
            self._starts = int(self.monitor.counts[sample_loop.START])
            self._publish_snapshot('restart')
            if previous_ns:
                self._node.get_logger().warning(
                    f'{self._says}stamps went from {previous_ns / SECOND:.6f} s by '
                    f'{(sample.stamp_ns - previous_ns) / SECOND:+.6f} s: the filter restarts',
                    throttle_duration_sec=5.0)
        if self.monitor.health.stamp_ns != self._state_stamp:
            if self._changes is not None:
                self._changes.window()
            self._keep_state()
        return estimate

    def published(self, estimate: Estimate) -> None:
        """Publish the state from time to time, after the outputs of `estimate`."""
        since = estimate.stamp_ns - self._snapshot_stamp
        if not 0 <= since < self.monitor.parameters.snapshot_period * SECOND:
            self._publish_snapshot('period')

    def _on_temperature(self, message: Temperature) -> None:
        if math.isfinite(message.temperature):
            self.monitor.temperature = message.temperature

    def _keep_state(self) -> None:
        """Let the state be written: after each window, and at the end."""
        health = self.monitor.health
        self._state_stamp = health.stamp_ns
        if self._state_file is not None:
            note = self._state_file.keep(health_text(
                STATE, health, self.monitor.parameters.gearbox_serial,
                recording_ns=self._changes.recording_ns if self._changes is not None else 0))
            if note:
                self._node.get_logger().warning(self._says + note)

    def _kept(self, outcome: Outcome) -> Outcome:
        """Return the `outcome` of backlash, a warning where a state is lost or not kept."""
        problem = self._state_file.problem if self._state_file is not None else ''
        if problem != self._state_error:
            self._state_error = problem
            if problem:
                self._node.get_logger().error(f'{self._says}{problem}')
        for code, text in (('state_lost', self._lost), ('state_not_kept', problem)):
            if text:
                own = (Said(code, {'problem': text}, Level.WARN),)
                outcome = replace(outcome, level=max(outcome.level, Level.WARN), says=(
                    *outcome.says, own) if outcome.level else (own, *outcome.says))
        return outcome

    def _publish_snapshot(self, reason: str) -> None:
        self._snapshot_stamp = self.monitor.stamp_ns
        content = {'reason': reason, 'version': __version__, 'kernels': KERNELS,
                   'topics': self._topics, **({GEARBOX: self.name} if self.name else {}),
                   **self.monitor.snapshot()}
        serial = self.monitor.parameters.gearbox_serial or 'gearbox'
        self._snapshots.publish(to_snapshot(self._component, serial, content,
                                            self.monitor.stamp_ns))

    # ------------------------------------------------------------------ diagnostics

    def _outcomes(self, clock_ns: int) -> dict[str, Outcome]:
        """Return {component: Outcome}; a stream that stopped is never reported as good."""
        counts, unpaired = self.input.pairing()
        counts['messages_lost'], new_loss = self.input.loss()
        if self._clock_set_back:
            counts['clock_set_back'] = self._clock_set_back
        silence, previous = self._silence, self._silence.why
        outcomes: dict[str, Outcome] = silence.outcomes(
            self.monitor, clock_ns, self.input.foreign,
            self.input.silence(self.monitor.input_count > 0))
        if previous and silence.why not in ('', previous):
            self._levels['input'] = Level.OK  # another reason is worth another line
        outcome = outcomes['input']
        level = outcome.level
        outcome = replace(outcome, values={**outcome.values, **counts, **self.input.counts()})
        if level and unpaired and not silence.why:
            outcome = replace(outcome, says=(*outcome.says, (unpaired,)))
        if rivals := self.input.rivals():
            outcome = outcome_of([observability.TWO_PUBLISHERS.said(rivals=rivals)], None,
                                 outcome.values)
        if new_loss:
            outcome = with_more(outcome, [observability.LOST.said(count=new_loss)], {})
        outcomes['input'] = outcome
        return outcomes

    def look(self, clock_ns: int) -> list[DiagnosticStatus]:
        """Return the diagnostics at `clock_ns` of a steady clock; log and alert what changed."""
        outcomes = self._outcomes(clock_ns)
        outcomes['backlash'] = self._kept(outcomes['backlash'])
        model = outcomes['model']
        if model.level and model.values:
            outcomes['model'] = replace(model, values={
                **model.values, 'command': self._black_box.command()})
        for name, text in self._black_box.look(clock_ns / SECOND).items():
            outcomes[name] = replace(outcomes[name], values={
                **outcomes[name].values, 'recording': text})
        if self._changes is not None:
            outcomes['diagnosis'] = self._named(self._changes)
        serial = self.monitor.parameters.gearbox_serial or 'gearbox'
        statuses = [to_status(f'{self._component}: {name}', outcome, serial)
                    for name, outcome in outcomes.items()]
        for name, outcome in outcomes.items():
            level = self._levels.get(name)
            self._levels[name] = outcome.level
            if level is None or level == outcome.level:
                continue
            text = f'{self._says}{name}: {outcome.level.name}: {outcome.message}'
            if outcome.level:  # two calls: a call may not change its severity
                self._node.get_logger().warning(text)
            else:
                self._node.get_logger().info(text)
        self._alert()
        return statuses

    def _named(self, changes: ChangeWatch) -> Outcome:
        """Return the Outcome on the newest change; publish a verdict that has just come."""
        outcome, verdict = changes.look()
        if verdict is not None:
            health = self.monitor.health
            if health.alerts:
                self.monitor.know(replace(health, cause=verdict['text']))
            self._diagnoses.publish(String(data=json.dumps(
                {**({GEARBOX: self.name} if self.name else {}), **verdict})))
        if not self.monitor.stamp_ns:
            return replace(outcome, level=Level.WARN, says=NO_DATA.says + outcome.says)
        return outcome  # of a change, which stays while no samples come: `input` tells that

    def _alert(self) -> None:
        """Publish each change of a drift alert since the last call: raised, worse, over."""
        serial = self.monitor.parameters.gearbox_serial or 'gearbox'
        while self.monitor.alerts:
            _, name, outcome = self.monitor.alerts.popleft()
            self._alert_output.publish(to_diagnostics(
                [to_status(f'{self._component}: {name}', outcome, serial)],
                self._node.get_clock().now().to_msg()))

    # ------------------------------------------------------------------ changes

    def set_parameters(self, changes: Mapping[str, Any]) -> None:
        """Apply `changes` {name: value} of parameters. Raises InputError."""
        estimator = self.monitor.estimator
        logged = estimator.warnings
        restarts = self.monitor.set_parameters(changes)
        self._node.get_logger().info(
            self._says + ', '.join(f'{name}={value}' for name, value in changes.items())
            + (': the filter restarts with the next sample' if restarts
               else ': in force, the filter continues'))
        self._warn(logged)
        self._publish_snapshot(PAYLOAD_CHANGE if PAYLOAD.issuperset(changes) else 'parameters')

    def clock_was_set_back(self) -> None:
        """Restart with the next sample: a simulation or a bag started again."""
        self._clock_set_back += 1
        self.input.clear()
        self.monitor.reset()
        self._publish_snapshot('clock')

    def _on_other_publisher(self) -> None:
        """Restart: another publisher delivers our joints."""
        self.monitor.reset()
        self._publish_snapshot('publishers')

    async def reset(self) -> tuple[bool, str]:
        """Restart with the next sample; return True and the answer."""
        self.monitor.reset()
        self._publish_snapshot('reset')
        return True, 'filter restarts with the next sample'

    async def keep_recording(self) -> tuple[bool, str]:
        """Write the last minutes as a bag; return whether that went well, and the answer."""
        return await self._black_box.keep()

    async def accept_baseline(self) -> tuple[bool, str]:
        """Take what was learnt for healthy; return whether that went well, and the answer."""
        monitor, p = self.monitor, self.monitor.parameters
        path = p.baseline_file
        health, windows = accepted(monitor.health)
        if not path:
            return False, 'parameter baseline_file is empty: expected the file to write'
        if not windows:
            return False, ('no backlash measured yet: expected a motion that loads both flanks '
                           f'for {p.drift_window:g} s')
        try:
            save_baseline(path, health, p.gearbox_serial, p.to_dict())
        except InputError as error:
            return False, str(error)
        monitor.know(health)
        self._lost = ''
        if self._changes is not None:
            self._changes.accept()
        self._alert()
        self._keep_state()
        self._publish_snapshot('baseline')
        sizes = [(name, health.feature(name), unit) for name, unit in (
            ('gap', 'rad'), ('lost_motion', 'rad'), ('stiffness', 'N m/rad'))]
        return True, f'{path}: {windows} windows: ' + ', '.join(
            f'{name} {_size(feature):.4g} {unit}' for name, feature, unit in sizes
            if math.isfinite(_size(feature)))


def _size(feature: FeatureHealth) -> float:
    """Return the healthy size of a feature; that of its newest window while there are few."""
    return feature.baseline if math.isfinite(feature.baseline) else feature.level


class Silence:
    """
    Watches one Monitor: its stamps must advance from one look to the next.

    why: codes of the reason why no usable sample arrived before the last look, '' if some did.
    """

    def __init__(self) -> None:
        # At the last look that found new stamps: stamp, inputs, clock, and counters.
        self._stamp = self._inputs = self._since = 0
        self._counts: Integers | None = None
        self.why = ''

    def outcomes(self, monitor: Monitor, now_ns: int, foreign: int = 0,
                 cause: Said | None = None) -> dict[str, Outcome]:
        """
        Return the outcomes of a monitor, replaced where its stream is dead.

        Args:
            monitor: the Monitor that takes the samples.
            now_ns: time of a steady clock, ns.
            foreign: number of messages that named none of our joints.
            cause: what the receiver of messages says, if it knows why none of them becomes a
                sample.

        Returns:
            {component: Outcome}; a dead stream is never OK.

        """
        if self._counts is None or monitor.stamp_ns != self._stamp:
            self._stamp, self._inputs, self._since = monitor.stamp_ns, monitor.input_count, now_ns
            self._counts, self.why = monitor.counts.copy(), ''
            return dict(monitor.outcomes)
        silent = (now_ns - self._since) / SECOND
        if silent < LIMITS.min_silence:
            return dict(monitor.outcomes)
        refused = monitor.input_count - self._inputs
        counts = {observability.key_of(reason): int(monitor.counts[code])
                  for code, reason in REASONS.items() if monitor.counts[code]}
        counts['messages_without_our_joints'] = foreign
        says = [cause or observability.SILENT.said()]
        if refused and not cause:
            new = monitor.counts - self._counts
            causes = observability.refused(
                {text: int(new[code]) for code, text in REASONS.items()})
            says = [Said('unusable', {'count': refused}, Level.OK if causes else Level.ERROR),
                    *causes]
        self.why = ' '.join(said.code for said in says)
        outcomes = {name: Outcome.of(Level.WARN, 'no_data', {'lasts_s': silent})
                    for name in monitor.outcomes}
        # Discovery takes a while: before the first sample ever, silence is not yet an error.
        starting = not monitor.input_count and not foreign and silent < LIMITS.start_time
        outcomes['input'] = Outcome(Level.WARN if starting else Level.ERROR,
                                    (tuple(says),), {**counts, 'lasts_s': silent})
        return outcomes
