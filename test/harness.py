# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Real nodes as processes, on a ROS domain of this test run, and a feeder beside them."""
import signal
import time

from processes import DOMAIN, Node, put_down
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter

# With these the estimator loses no sample of a test, however starved the machine is.
RELIABLE = {'qos_overrides./joint_states.subscription.reliability': 'reliable',
            'qos_overrides./joint_states.subscription.depth': 20_000}


class Graph:
    """A node of the test (`node`) and the processes that it started."""

    def __init__(self, tmp_path, monkeypatch):
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        self.tmp_path, self.processes = tmp_path, []
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node('feeder', context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def start(self, module, *arguments, **parameters):
        """Start the node `module` of gearbox_monitor.ros as a process."""
        process = Node(module, arguments, self.tmp_path, parameters)
        self.processes.append(process)
        return process

    def until(self, condition, what='it', timeout=300.0):
        """Spin the test's node until condition() is true."""
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, f'{what} did not happen'
            for process in self.processes:
                assert (process.poll() or 0) <= 0, f'{what}: {process.communicate()[1]}'
            self.executor.spin_once(timeout_sec=0.02)

    def spin(self, seconds):
        """Spin the test's node for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)

    def call(self, kind, name, request):
        """
        Return the response of a service.

        DDS may drop a response: the server's writer has not matched the client's reader yet when a
        request comes early (rmw_fastrtps waits 100 ms for it). The same request is sent again.
        """
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready, f'service {name}')
        for _ in range(10):
            future, end = client.call_async(request), time.monotonic() + 30.0
            self.until(lambda: future.done() or time.monotonic() > end)
            if future.done():
                break
        assert future.done(), f'no answer of {name}'
        self.node.destroy_client(client)
        return future.result()

    def set(self, node, **values):
        """Set parameters of a `node`; return what it answers to each."""
        parameters = [Parameter(name, value=value) for name, value in values.items()]
        return self.call(SetParameters, f'{node}/set_parameters', SetParameters.Request(
            parameters=[parameter.to_parameter_msg() for parameter in parameters])).results

    def stop(self, process, sig=signal.SIGINT):
        """End `process`; it must end cleanly. Returns what it wrote to stderr."""
        process.send_signal(sig)
        _, errors = process.communicate(timeout=30)
        assert process.returncode == 0, errors
        assert 'Traceback' not in errors, errors
        return errors

    def close(self):
        """End what is left and leave the domain."""
        put_down(self.processes)
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
