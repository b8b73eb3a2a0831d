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

"""The last minutes of the measurement, written when asked for or after an alert."""
from threading import Thread

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.logging import get_logger
from rclpy.task import Future
from std_srvs.srv import Trigger

from gearbox_monitor.errors import InputError
from gearbox_monitor.monitoring.backlash.change import GROSS
from gearbox_monitor.ros.after_error import AfterError
from gearbox_monitor.ros.keep import About, keep
from gearbox_monitor.ros.ring import Ring

KEEP = '~/keep_recording'


class BlackBox:
    """
    What the estimator `node` holds in memory; its service ~/keep_recording and keep_after_error.

    parameters: EstimatorParameters; topic: where the samples come from. Raises InputError for a
    keep_after_error that cannot be had.
    """

    def __init__(self, node, parameters, topic):
        self._node, self._topic = node, topic
        span = 60.0 * parameters.keep_minutes
        self._refusal = '' if span else 'nothing is kept: keep_minutes is 0, expected more'
        if not parameters.arm_joint:
            self._refusal = self._refusal or (
                'nothing is kept without an arm encoder (arm_joint is empty): use the recorder')
        self._ring = Ring(span) if span else None
        self._keeping = None  # the thread that writes what the ring holds
        seconds, self._after_error = parameters.keep_after_error, None
        if seconds:
            if self._refusal:
                raise InputError(f'keep_after_error: {seconds:g} s, expected 0: {self._refusal}')
            if seconds > span:
                raise InputError(f'keep_after_error: {seconds:g} s, expected no more than '
                                 f'keep_minutes: {span:g} s')
            self._after_error = AfterError(seconds, span, self._wrong())
        # Its answer waits for the disk; in the default group everything else would wait, too.
        node.create_service(Trigger, KEEP, self._on_service,
                            callback_group=ReentrantCallbackGroup())

    def add(self, stamp_ns, good, values):
        """Take a row, see Ring.add()."""
        if self._ring is not None:
            self._ring.add(stamp_ns, good, values)

    def command(self):
        """Return the shell command that keeps the recording, or why it would not."""
        if self._ring is None:
            return 'nothing is kept: set keep_minutes'
        return (f'ros2 service call {self._node.resolve_service_name(KEEP)} '
                'std_srvs/srv/Trigger')

    def look(self, now):
        """
        Keep the recording where an alert asks for it, at `now` (s, of a steady clock).

        Returns {component: text} of what became of the alerts.
        """
        if self._after_error is None:
            return {}
        busy = self._keeping is not None or not len(self._ring)
        components = self._after_error.look(self._wrong(), now, busy)
        if components:
            self._after_error.tell(components, 'being written')
            self._node.executor.create_task(
                self._finish, components, self._start(components))
        return self._after_error.texts

    def close(self):
        """Let a recording come to its end, also of an alert that was still to be kept."""
        if self._keeping is not None:
            self._keeping.join()
        components = self._after_error.waiting() if self._after_error else []
        if components and len(self._ring):
            _, text = self._written(self._ring.rows(), self._about(components))
            # The node's own logger wants /rosout, which is gone by now.
            get_logger('estimator_end').warning(f'{", ".join(components)}: {text}')

    def _wrong(self):
        """Return the components of drift that are ERROR, also while no samples come."""
        stages = self._node.monitor.tracker.stages()
        return [component for component, tests in stages.items() if GROSS in tests.values()]

    def _about(self, components=()):
        monitor = self._node.monitor
        p, found = monitor.parameters, monitor.tracker.findings()
        why = '; '.join(f'{name}: {found[name].message}' for name in components)
        return About(self._topic, (p.motor_joint, p.arm_joint), monitor.model,
                     monitor.estimator.drive.arm_load, p, why or KEEP)

    def _start(self, components=()):
        """Write what is in memory, in a thread; return the Future of (success, message)."""
        done = Future()
        self._keeping = Thread(target=self._write,
                               args=(self._ring.rows(), self._about(components), done))
        self._keeping.start()
        return done

    def _write(self, rows, about, done):
        """Write the rows; the thread."""
        done.set_result(self._written(rows, about))
        if self._node.executor is not None:  # it may have ended meanwhile
            self._node.executor.wake()

    @staticmethod
    def _written(rows, about):
        try:
            return True, keep(about.parameters.keep_folder, rows(), about)
        except Exception as error:  # whatever it is, the estimates must go on
            return False, str(error) or type(error).__name__

    async def _finish(self, components, done):
        """Tell what became of the recording of the alerts of `components`."""
        good, text = await done
        self._keeping = None
        logger, names = self._node.get_logger(), ', '.join(components)
        self._after_error.tell(components, text if good else f'failed: {text}')
        if good:
            logger.warning(f'{names} became ERROR: {text}')
        else:
            logger.error(f'{names} became ERROR, keep_after_error: {text}')

    async def _on_service(self, _, response):
        response.message = self._refusal
        if self._refusal:
            return response
        if self._keeping is not None:
            response.message = 'a recording is being written: wait for its end'
        elif not len(self._ring):
            response.message = f'no samples yet on {self._topic}'
        else:
            response.success, response.message = await self._start()
            self._keeping = None
            if response.success:
                self._node.get_logger().info(response.message)
            else:
                self._node.get_logger().error(f'keep_recording: {response.message}')
        return response
