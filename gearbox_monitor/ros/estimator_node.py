# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Node `estimator`: estimates the transmission torque from joint_states and judges the estimate.

Every published value carries the stamp of its measurement. monitor.Monitor does all the work; this
file moves messages in and out, of one gearbox or of all gearboxes of a robot.

  ros2 run gearbox_monitor estimator_node --ros-args --params-file estimator.yaml
"""
from collections.abc import Awaitable, Callable, Mapping, Sequence
from importlib import import_module
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.callback_groups import CallbackGroup, ReentrantCallbackGroup
from rclpy.clock import Clock, ClockChange, ClockType, JumpThreshold, TimeJump
from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from gearbox_monitor import __version__
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.kernels.library import installed
from gearbox_monitor.parameters import SETTINGS
from gearbox_monitor.recordings.topics import DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, SIGNALS
from gearbox_monitor.ros.change_watch import ChangeNamer
from gearbox_monitor.ros.convert import to_diagnostics, to_joint_states
from gearbox_monitor.ros.gearbox_input import JointSubscriptions, TakenSamples
from gearbox_monitor.ros.monitored_gearbox import (
    declare_gearboxes, GearboxSettings, located, MonitoredGearbox)
from gearbox_monitor.ros.recording_export import KEEP
from gearbox_monitor.ros.runtime import advertise, latched, on_change, spin_node, TableNode

SECOND = 1_000_000_000
# After a pause of this process the outputs come in a burst: a recorder must not lose them.
OUTPUT_DEPTH = 2000


class EstimatorNode(TableNode):
    """
    Shell around a MonitoredGearbox for each gearbox; see the module.

    node: arguments of rclpy.node.Node, like `namespace`; several nodes can share a process.
    """

    def __init__(self, **node: Any) -> None:
        super().__init__('estimator', **node)
        settings = declare_gearboxes(self)
        installed()  # the first sample must not wait for it,
        import_module('scipy.special')  # nor those while trust is first judged
        self._outputs = [
            (signal, advertise(self, JointState, signal.topic, OUTPUT_DEPTH))
            for signal in SIGNALS]
        self._diagnostics = advertise(self, DiagnosticArray, DIAGNOSTICS, 10)
        alerts = advertise(self, DiagnosticArray, DRIFT_ALERTS, latched())
        self._namer = ChangeNamer()
        self._gearboxes: list[MonitoredGearbox] = []
        for k, gearbox in enumerate(settings):
            with located(gearbox.name):
                self._gearboxes.append(MonitoredGearbox(
                    self, gearbox, alerts, self._namer, k * SECOND // len(settings)))
        # Its callbacks come only once the node spins.
        self._inputs = JointSubscriptions(self, [g.input for g in self._gearboxes], self._take)
        for shell in self._gearboxes:  # replay needs the names for bags with remapped topics
            shell.start({
                JOINT_STATES: shell.input.topic, DRIFT_ALERTS: alerts.topic_name,
                **{signal.topic: output.topic_name for signal, output in self._outputs}})
        self._offer('reset', MonitoredGearbox.reset)
        self._offer('save_baseline', MonitoredGearbox.accept_baseline)
        # It waits for the disk; in the default group everything else would wait, too.
        self._offer(KEEP, MonitoredGearbox.keep_recording, ReentrantCallbackGroup())
        self._watch_parameters(settings)
        # A reference, since rclpy calls it even after it was deleted.
        self._jumps = self.get_clock().create_jump_callback(
            JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1),
                          on_clock_change=True), post_callback=self._on_clock)
        # Wall time: with a stopped simulation clock the missing data must still be reported.
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0, self._on_second, clock=self._steady)
        for gearbox in settings:
            self.get_logger().info(
                f'gearbox_monitor {__version__}: '
                + (f'{gearbox.name}: ' if gearbox.name else '') + f'model {gearbox.model_file}, '
                + KERNELS + ', ' + ', '.join(f'{k}={v}' for k, v in {
                    **gearbox.parameters.to_dict(), **gearbox.changed}.items()))
        self.warn_of_unknown()
        for shell in self._gearboxes:
            shell.welcome()

    # ------------------------------------------------------------------ samples

    def _take(self, samples: TakenSamples) -> None:
        """Take the `samples` of one message; publish each output once for all gearboxes."""
        estimates = []
        for k, (sample, raw) in samples:
            gearbox = self._gearboxes[k]
            estimate = gearbox.step(sample, raw)
            if estimate is not None:
                estimates.append((gearbox, estimate))
        pairs = [(gearbox.names, estimate) for gearbox, estimate in estimates]
        for signal, publisher in self._outputs:
            if publisher.get_subscription_count():
                for message in to_joint_states(signal, pairs):
                    publisher.publish(message)
        for gearbox, estimate in estimates:
            gearbox.published(estimate)

    # ------------------------------------------------------------------ diagnostics

    def _on_second(self) -> None:
        now_ns = self._steady.now().nanoseconds
        statuses = [status for gearbox in self._gearboxes for status in gearbox.look(now_ns)]
        self._diagnostics.publish(to_diagnostics(statuses, self.get_clock().now().to_msg()))

    # ------------------------------------------------------------------ changes

    def _watch_parameters(self, settings: Sequence[GearboxSettings]) -> None:
        """Let the parameters of each gearbox change at run time."""
        for gearbox, shell in zip(settings, self._gearboxes):
            def apply(changes: Mapping[str, Any], prefix: str = gearbox.prefix,
                      shell: MonitoredGearbox = shell) -> None:
                shell.set_parameters({name.removeprefix(prefix): value
                                      for name, value in changes.items()})
            on_change(self, gearbox.rows(SETTINGS), apply)

    def _on_clock(self, jump: TimeJump) -> None:
        """Restart if the ROS clock was set back: a simulation or a bag started again."""
        if jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            on = jump.clock_change == ClockChange.ROS_TIME_ACTIVATED
            self.get_logger().info(
                f'from now on time comes from {"/clock" if on else "the system"}')
            return
        self.get_logger().warning(
            f'/clock was set back by {-jump.delta.nanoseconds / SECOND:.3f} s: the filter '
            'restarts with the next sample')
        for gearbox in self._gearboxes:
            gearbox.clock_was_set_back()

    def _offer(self, service: str, act: Callable[[MonitoredGearbox], Awaitable[tuple[bool, str]]],
               group: CallbackGroup | None = None) -> None:
        """Offer what `act` does to one gearbox as a `service`: of all, and of each by its name."""
        for name, gearboxes in [(f'~/{service}', self._gearboxes), *(
                (g.private(service), [g]) for g in self._gearboxes if g.name)]:
            async def answer(_: Trigger.Request, response: Trigger.Response,
                             gearboxes: Sequence[MonitoredGearbox] = gearboxes
                             ) -> Trigger.Response:
                return _answered(response, {g.name: await act(g) for g in gearboxes})
            self.create_service(Trigger, name, answer, callback_group=group)

    def close(self) -> None:
        """Write the states; let recordings that are being written come to their end."""
        self._jumps.unregister()
        self._namer.close()
        for gearbox in self._gearboxes:
            gearbox.close()


def _answered(response: Trigger.Response, answers: Mapping[str, tuple[bool, str]]
              ) -> Trigger.Response:
    """Return `response` with the `answers` {gearbox: (success, text)}."""
    response.success = all(success for success, _ in answers.values())
    response.message = '; '.join(f'{name}: {text}' if name else text
                                 for name, (_, text) in answers.items())
    return response


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(EstimatorNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
