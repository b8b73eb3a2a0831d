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

"""
Node `estimator`: estimates the transmission torque from joint_states and judges the estimate.

Every published value carries the stamp of its measurement. monitor.Monitor does all the work; this
file moves messages in and out.

  ros2 run gearbox_monitor estimator_node --ros-args --params-file estimator.yaml
"""
from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
import json
import math
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockChange, ClockType, JumpThreshold, TimeJump
from rclpy.duration import Duration
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import Trigger

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Sample
from gearbox_monitor.files.baselines import (
    Damaged, load_baseline, load_state, save_baseline, save_state, set_aside)
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.interfaces.signals import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, MOTOR, SIGNALS, SNAPSHOT)
from gearbox_monitor.kernels.compilation import announced_compilation
from gearbox_monitor.kernels.jit import CACHE_PROBLEM, COMPILED, KERNELS
from gearbox_monitor.monitoring.backlash.change import Tracker
from gearbox_monitor.monitoring.backlash.change_tests import COMPONENTS, TESTS
from gearbox_monitor.monitoring.checks import usability
from gearbox_monitor.monitoring.checks.outcome import Level, Outcome, with_more
from gearbox_monitor.monitoring.monitor import Monitor
from gearbox_monitor.monitoring.staleness import Silence
from gearbox_monitor.parameters import ESTIMATOR, EstimatorParameters, MODEL, SETTINGS
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.black_box import BlackBox
from gearbox_monitor.ros.convert import to_diagnostics, to_joint_state, to_snapshot, to_status
from gearbox_monitor.ros.joint_subscriptions import JointSubscriptions, RawSample
from gearbox_monitor.ros.node_parameters import declare, on_change, TableNode
from gearbox_monitor.ros.qos import advertise, best_effort, latched, subscribe
from gearbox_monitor.ros.runtime import spin_node

SECOND = 1_000_000_000
# After a pause of this process the outputs come in a burst: a recorder must not lose them.
OUTPUT_DEPTH = 2000


class EstimatorNode(TableNode):
    """
    Shell around Monitor; see the module.

    node: arguments of rclpy.node.Node, like `namespace`; several nodes can share a process.
    """

    def __init__(self, **node: Any) -> None:
        super().__init__('estimator', **node)
        values = EstimatorParameters.from_mapping(declare(self, ESTIMATOR))
        model_file = values.model or config_path('drive.yaml')
        model = load_model(model_file)
        changed = declare(self, [replace(row, default=getattr(model, row.name)) for row in MODEL])
        model = model.with_(**changed)
        drift, adaptation = self._state_at_start(values)
        self.monitor = Monitor(model, values, drift)
        self._recall(adaptation)
        if CACHE_PROBLEM:
            self.get_logger().warning(CACHE_PROBLEM)
        with announced_compilation(self.get_logger().info):
            _warm_up(model, values)
        for test in TESTS:  # computed once, and not while a sample waits
            self.monitor.tracker.settings.threshold(test)
        self._gear_ratio = model.gear_ratio
        self._names = {MOTOR: values.motor_joint, ARM: values.arm_joint}
        self._starts = 0
        self._divergences = 0
        self._clock_set_back = 0  # how often
        self._silence = Silence()
        self._levels: dict[str, Level] = {}
        self._alerted: dict[str, Any] = {}  # {component: stages} of the drift alert in force
        self._state_stamp = self.monitor.tracker.stamp_ns
        self._state_error = ''
        self._component = self.get_fully_qualified_name().lstrip('/')
        self._snapshot_stamp = 0

        self._outputs = [
            (signal, advertise(self, JointState, signal.topic, OUTPUT_DEPTH))
            for signal in SIGNALS]
        self._diagnostics = advertise(self, DiagnosticArray, DIAGNOSTICS, 10)
        self._alerts = advertise(self, DiagnosticArray, DRIFT_ALERTS, latched())
        self._snapshots = advertise(self, DiagnosticArray, f'~/{SNAPSHOT}', latched())
        # Its callbacks come only once the node spins.
        self._inputs = JointSubscriptions(self, values, model, self._take, self._on_dispute)
        self._black_box = BlackBox(self, self.monitor, values, self._inputs.topic)
        # Replay needs them for bags with remapped topics.
        self._topics = json.dumps({
            JOINT_STATES: self._inputs.topic, DRIFT_ALERTS: self._alerts.topic_name,
            **{signal.topic: output.topic_name for signal, output in self._outputs}})
        self._publish_snapshot('start')
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(Trigger, '~/save_baseline', self._on_save_baseline)
        on_change(self, SETTINGS, self._on_parameters)
        if values.temperature_topic:
            subscribe(self, Temperature, values.temperature_topic, self._on_temperature,
                      best_effort(1))
        # A reference, since rclpy calls it even after it was deleted.
        self._jumps = self.get_clock().create_jump_callback(
            JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1),
                          on_clock_change=True), post_callback=self._on_clock)
        # Wall time: with a stopped simulation clock the missing data must still be reported.
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0, self._on_second, clock=self._steady)
        self.get_logger().info(
            f'gearbox_monitor {__version__}: model {model_file}, '
            + ('compiled' if COMPILED else 'INTERPRETED (numba is missing, expect < 1 kHz)')
            + ', ' + ', '.join(f'{k}={v}' for k, v in {**values.to_dict(), **changed}.items()))
        self.warn_of_unknown()
        self._warn([])
        self._alert(self.monitor.findings)

    def _warn(self, logged: Container[str]) -> None:
        """Log the warnings about the settings that are not `logged` yet."""
        for text in self.monitor.estimator.warnings:
            if text not in logged:
                self.get_logger().warning(text)

    def _state_at_start(self, values: EstimatorParameters) -> tuple[Any, dict[str, Any]]:
        """Return (state of drift, adapted values) of the state file, else of the baselines."""
        if values.drift_state_file:
            state, problem = load_state(values.drift_state_file, values.gearbox_serial)
            if problem:
                self.get_logger().error(problem)
            if state is not None:
                return state['drift'], state['adaptation']
        if self._has_baseline(values):
            try:
                return load_baseline(values.baseline_file, values.gearbox_serial), {}
            except Damaged as error:
                self.get_logger().error(f'{error}: {set_aside(values.baseline_file)}')
        return None, {}

    def _recall(self, adaptation: Mapping[str, Any]) -> None:
        """Let an adaptive filter continue from its saved `adaptation`."""
        if not adaptation:
            return
        try:
            if not self.monitor.estimator.recall(adaptation):
                self.get_logger().info('filter, model or start values are not those of the saved '
                                       'adaptation: it restarts')
        except InputError as error:
            self.get_logger().error(f'{error}: the adaptation restarts')

    def _has_baseline(self, values: EstimatorParameters) -> bool:
        """Return whether a baseline file is named and exists; save_baseline may write it later."""
        path = values.baseline_file
        if not path:
            return False
        try:
            with open(path, encoding='utf-8'):
                return True
        except FileNotFoundError:
            self.get_logger().info(f'{path}: no baseline yet; ~/save_baseline writes it')
            return False
        except OSError as error:
            raise InputError(f'{path}: {error.strerror}, expected a readable file') from None

    # ------------------------------------------------------------------ samples

    def _take(self, sample: Sample, raw: RawSample) -> None:
        previous_ns = self.monitor.stamp_ns
        estimate = self.monitor.step(sample)
        self._black_box.add(sample.stamp_ns, estimate is not None, raw)
        if self.monitor.counts[sample_loop.DIVERGED] != self._divergences:
            self._divergences = int(self.monitor.counts[sample_loop.DIVERGED])
            self.get_logger().error(f'{self.monitor.estimator.divergences[-1]}; restarting',
                                    throttle_duration_sec=5.0)
        if self.monitor.counts[sample_loop.START] != self._starts:
            self._starts = int(self.monitor.counts[sample_loop.START])
            self._publish_snapshot('restart')
            if previous_ns:
                self.get_logger().warning(
                    f'stamps went from {previous_ns / SECOND:.6f} s by '
                    f'{(sample.stamp_ns - previous_ns) / SECOND:+.6f} s: the filter restarts',
                    throttle_duration_sec=5.0)
        if self.monitor.tracker.stamp_ns != self._state_stamp:
            self._keep_state()
        if estimate is None:
            return
        for signal, publisher in self._outputs:
            if signal.smoothed:
                for stamp_ns, row in estimate.smoothed:
                    publisher.publish(to_joint_state(
                        signal, stamp_ns, row, self._names, self._gear_ratio))
            else:
                publisher.publish(to_joint_state(
                    signal, estimate.stamp_ns, estimate.row, self._names, self._gear_ratio))
        since = estimate.stamp_ns - self._snapshot_stamp
        if not 0 <= since < self.monitor.parameters.snapshot_period * SECOND:
            self._publish_snapshot('period')
            if self.monitor.estimator.learnt():  # goes on without windows, too
                self._keep_state()

    def _on_temperature(self, message: Temperature) -> None:
        if math.isfinite(message.temperature):
            self.monitor.temperature = message.temperature

    def _keep_state(self) -> None:
        """Write the state: after each window, and at the end."""
        tracker, p = self.monitor.tracker, self.monitor.parameters
        self._state_stamp = tracker.stamp_ns
        if not p.drift_state_file:
            return
        try:
            save_state(p.drift_state_file, tracker, p.gearbox_serial,
                       self.monitor.estimator.learnt())
            self._state_error = ''
        except InputError as error:  # a full disk must not stop the estimates
            if str(error) != self._state_error:
                self.get_logger().error(str(error))
            self._state_error = str(error)

    def _publish_snapshot(self, reason: str) -> None:
        self._snapshot_stamp = self.monitor.stamp_ns
        content = {'reason': reason, 'version': __version__, 'kernels': KERNELS,
                   'topics': self._topics, **self.monitor.snapshot()}
        serial = self.monitor.parameters.gearbox_serial or 'gearbox'
        self._snapshots.publish(to_snapshot(self._component, serial, content,
                                            self.monitor.stamp_ns))

    # ------------------------------------------------------------------ diagnostics

    def _findings(self) -> dict[str, Outcome]:
        """Return {component: Outcome}; a stream that stopped is never reported as good."""
        counts, unpaired = self._inputs.pairing()
        counts['messages_lost'], new_loss = self._inputs.loss()
        if self._clock_set_back:
            counts['clock_set_back'] = self._clock_set_back
        silence, previous = self._silence, self._silence.why
        findings: dict[str, Outcome] = silence.findings(
            self.monitor, self._steady.now().nanoseconds, self._inputs.foreign,
            self._inputs.silence(self.monitor.input_count > 0))
        if previous and silence.why not in ('', previous):
            self._levels['input'] = Level.OK  # another reason is worth another line
        finding = findings['input']
        level = finding.level
        suffix = f'; {unpaired}' if level and unpaired and not silence.why else ''
        finding = replace(finding, values={**finding.values, **counts},
                          message=finding.message + suffix)
        values, rivals = self._inputs.strangers()
        if rivals and level < Level.ERROR:
            finding = with_more(finding, [replace(usability.OTHERS, says=rivals)], values)
        else:
            finding = replace(finding, values={**finding.values, **values})
        if new_loss:
            finding = with_more(
                finding, [replace(usability.LOST, says=f'{new_loss} messages lost')], {})
        findings['input'] = finding
        return findings

    def _on_second(self) -> None:
        findings = self._findings()
        model = findings['model']
        if model.level and model.values:
            findings['model'] = replace(model, values={
                **model.values, 'command': self._black_box.command()})
        for name, text in self._black_box.look(self._steady.now().nanoseconds / SECOND).items():
            findings[name] = replace(findings[name], values={
                **findings[name].values, 'recording': text})
        serial = self.monitor.parameters.gearbox_serial or 'gearbox'
        statuses = [to_status(f'{self._component}: {name}', finding, serial)
                    for name, finding in findings.items()]
        self._diagnostics.publish(to_diagnostics(statuses, self.get_clock().now().to_msg()))
        for (name, finding), status in zip(findings.items(), statuses):
            level = self._levels.get(name)
            self._levels[name] = finding.level
            if level is None or level == finding.level:
                continue
            text = f'{name}: {finding.level.name}: {finding.message}'
            if finding.level:  # two calls: a call may not change its severity
                self.get_logger().warning(text)
            else:
                self.get_logger().info(text)
        self._alert(findings)

    def _alert(self, findings: Mapping[str, Outcome]) -> None:
        """Publish each change of a drift alert since the last call: raised, worse, over."""
        stages = self.monitor.tracker.stages()
        serial = self.monitor.parameters.gearbox_serial or 'gearbox'
        for name in COMPONENTS:
            if stages[name] == self._alerted.get(name, {}) or \
                    findings[name].message.startswith('no data'):
                continue
            self._alerted[name] = stages[name]
            self._alerts.publish(to_diagnostics(
                [to_status(f'{self._component}: {name}', findings[name], serial)],
                self.get_clock().now().to_msg()))

    # ------------------------------------------------------------------ changes

    def _on_parameters(self, changes: Mapping[str, Any]) -> None:
        logged = self.monitor.estimator.warnings
        restarts = self.monitor.set_parameters(changes)
        self.get_logger().info(
            ', '.join(f'{name}={value}' for name, value in changes.items())
            + (': the filter restarts with the next sample' if restarts
               else ': in force, the filter continues'))
        self._warn(logged)
        self._publish_snapshot('parameters')

    def _on_clock(self, jump: TimeJump) -> None:
        """Restart if the ROS clock was set back: a simulation or a bag started again."""
        if jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            on = jump.clock_change == ClockChange.ROS_TIME_ACTIVATED
            self.get_logger().info(
                f'from now on time comes from {"/clock" if on else "the system"}')
            return
        self._clock_set_back += 1
        self.get_logger().warning(
            f'/clock was set back by {-jump.delta.nanoseconds / SECOND:.3f} s: the filter '
            'restarts with the next sample')
        self._inputs.clear()
        self.monitor.reset()
        self._publish_snapshot('clock')

    def _on_dispute(self) -> None:
        """Restart if the samples so far may have come from another publisher."""
        self.get_logger().warning('several publishers give our joints and none was the first: the '
                                  'filter restarts with the next sample')
        self.monitor.reset()
        self._publish_snapshot('publishers')

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._inputs.forget_publishers()
        self.monitor.reset()
        self._publish_snapshot('reset')
        response.success, response.message = True, 'filter restarts with the next sample'
        return response

    def close(self) -> None:
        """Write the state; let a recording that is being written come to its end."""
        self._jumps.unregister()
        if self.monitor.input_count:
            self._keep_state()
        self._black_box.close()

    def _on_save_baseline(self, _: Trigger.Request,
                          response: Trigger.Response) -> Trigger.Response:
        monitor, p = self.monitor, self.monitor.parameters
        path = p.baseline_file
        # On a copy: if the file cannot be written, nothing has changed.
        tracker = Tracker(monitor.tracker.settings, monitor.tracker.to_dict())
        windows = tracker.accept()
        points = tracker.baseline_points()
        if not path:
            response.message = 'parameter baseline_file is empty: expected the file to write'
        elif not windows:
            response.message = ('no backlash measured yet: expected a motion that loads both '
                                f'flanks for {p.drift_window:g} s')
        else:
            try:
                save_baseline(path, points, p.gearbox_serial, p.to_dict())
            except InputError as error:
                response.message = str(error)
                return response
            monitor.tracker = tracker
            self._keep_state()
            self._publish_snapshot('baseline')
            response.success = True
            response.message = (f'{path}: {windows} windows at {len(points)} operating '
                                f'point{"s" if len(points) > 1 else ""}: '
                                + '; '.join(_point_text(point) for point in points[:4]))
        return response


def _point_text(point: Mapping[str, Any]) -> str:
    features = point['features']
    return ', '.join(f'{name} {features[name]["mean"]:.4g} {unit}' for name, unit in
                     (('gap', 'rad'), ('lost_motion', 'rad'), ('stiffness', 'N m/rad'))
                     if name in features)


def _warm_up(model: DriveModel, parameters: EstimatorParameters) -> None:
    """Compile every kernel before the node is ready: the first sample must not wait for it."""
    monitor = Monitor(model, parameters.replace(drift_window=0.5))
    for k in range(2200):  # 4.4 s: trust is judged from the third second on
        angle = 0.5 * math.sin(0.02 * k)
        monitor.step(Sample(SECOND + k * 2_000_000, (0.0, 0.0), (angle, 0.8 * angle)))


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(EstimatorNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
