# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Serves one page and a stream of events (server-sent events) to browsers, by the stdlib.

It follows an estimator in another process, by its state and its diagnostics.
"""
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
import ipaddress
import json
import socket
import socketserver
import sys
import threading
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from gearbox_monitor.errors import InputError
from gearbox_monitor.health.alarms import Level, Outcome
from gearbox_monitor.recordings.topics import (
    DIAGNOSTICS, DRIFT_ALERTS, FINDINGS, JOINT_STATES, PLANT_TRANSMISSION_STATE, ROBOT_DESCRIPTION,
    SIGNALS, SNAPSHOT, TRANSMISSION)
from gearbox_monitor.report.live_page import GearboxHistory, live_frame, LivePage, WatchNews
from gearbox_monitor.report.timeline import state_of
from gearbox_monitor.ros.convert import stamp_of
from gearbox_monitor.ros.runtime import (
    best_effort, drain, latched, RMWError, spin_node, steady_timer, subscribe, subscribe_polled)

MAX_CLIENTS = 16
PING_SECONDS = 1.0     # without news; finds out that a client has gone
SEND_SECONDS = 10.0    # that a client may take for an event before it is dropped


class EventServer(ThreadingHTTPServer):
    """
    Serves `page` (HTML, Content-Security-Policy) at / and events at /events, in threads.

    host, port: to listen on; port 0: any that is free. An event holds the parts {id: HTML} that
    have changed since the last one to the same client. Each client gets the newest parts: nothing
    queues for a slow one. Raises InputError if it cannot listen there.
    """

    daemon_threads = True

    def __init__(self, page: tuple[str, str], host: str, port: int) -> None:
        self.page = page
        self.clients = 0  # that follow the events
        self.ended = False
        self._parts: Mapping[str, str] = {}
        self._number = 0
        self._news = threading.Condition()
        try:
            self.address_family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
            super().__init__((host, port), PageRequest)
        except (OSError, OverflowError) as error:
            reason = getattr(error, 'strerror', None) or str(error)
            raise InputError(f'{host}:{port}: {reason}, expected an address of this machine and '
                             'a free port (--host, --port)') from None
        self._host = str(self.server_address[0])
        self._local = ipaddress.ip_address(self._host).is_loopback
        self._thread = threading.Thread(target=self.serve_forever, daemon=True)
        self._thread.start()

    def server_bind(self) -> None:
        """Bind; HTTPServer would ask the DNS for a name, too."""
        socketserver.TCPServer.server_bind(self)

    @property
    def address(self) -> str:
        """Return the address of the page."""
        host = f'[{self._host}]' if ':' in self._host else self._host
        return f'http://{host}:{self.server_address[1]}/'

    def trusts(self, host: str) -> bool:
        """
        Return whether to answer a request to the header Host `host`.

        A page of another site, whose name resolves to this machine, must not read a local one.
        """
        name = host.rpartition(':')[0] if not host.endswith(']') and ':' in host else host
        return not self._local or name in ('localhost', '127.0.0.1', '[::1]', self._host)

    def publish(self, parts: Mapping[str, str]) -> None:
        """Let all clients have `parts` {id: HTML}."""
        with self._news:
            self._parts, self._number = parts, self._number + 1
            self._news.notify_all()

    def news(self, number: int) -> tuple[Mapping[str, str], int]:
        """Return the newest parts and their number; wait a while if it is still `number`."""
        with self._news:
            self._news.wait_for(lambda: self._number != number or self.ended, PING_SECONDS)
            return self._parts, self._number

    def enter(self, clients: int) -> bool:
        """Count so many `clients` more; return whether they may follow."""
        with self._news:
            if self.clients + clients > MAX_CLIENTS:
                return False
            self.clients += clients
            return True

    def close(self) -> None:
        """End the streams and stop listening."""
        with self._news:
            self.ended = True
            self._news.notify_all()
        self.shutdown()
        self.server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Pass over clients that have gone; other errors are shown."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


class PageRequest(BaseHTTPRequestHandler):
    """One request to an EventServer."""

    server: EventServer
    timeout = SEND_SECONDS

    def do_GET(self) -> None:
        """Answer with the page or the events."""
        path = self.path.partition('?')[0]
        if not self.server.trusts(self.headers.get('Host', '')):
            self._answer(403, 'text/plain', b'Refused: the page is served to this machine only.\n')
        elif path == '/':
            self._answer(200, 'text/html', self.server.page[0].encode())
        elif path != '/events':
            self._answer(404, 'text/plain', b'Not here: expected / or /events.\n')
        elif not self.server.enter(1):
            self._answer(503, 'text/plain', b'Too many pages are open.\n')
        else:
            try:
                self._stream()
            finally:
                self.server.enter(-1)

    def _answer(self, code: int, kind: str, body: bytes) -> None:
        self._head(code, kind)
        self.send_header('Content-Length', str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def _head(self, code: int, kind: str) -> None:
        self.send_response(code)
        self.send_header('Content-Type', f'{kind}; charset=utf-8')
        self.send_header('Cache-Control', 'no-store')
        self.send_header('X-Content-Type-Options', 'nosniff')
        self.send_header('Content-Security-Policy',
                         f"{self.server.page[1]}; frame-ancestors 'none'")

    def _stream(self) -> None:
        """Send what changes until the client or the server ends."""
        self._head(200, 'text/event-stream')
        self.end_headers()
        sent: Mapping[str, str] = {}
        number, at = 0, time.monotonic()
        while not self.server.ended:
            parts, number = self.server.news(number)
            changed = {name: html for name, html in parts.items() if sent.get(name) != html}
            sent = parts
            if changed:
                self.wfile.write(f'data: {json.dumps(changed)}\n\n'.encode())
            elif time.monotonic() - at > PING_SECONDS:
                self.wfile.write(b': still there\n\n')
            else:
                continue
            at = time.monotonic()

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing about requests."""


MOTION = next(signal.topic for signal in SIGNALS if signal.smoothed)
PERIOD = 0.1           # s between two drawings
DEPTH = 2000           # messages that may wait between them
MAX_BYTES = 1 << 16    # longer messages are left out
MAX_GEARBOXES = 256    # anybody can publish any names


class LiveNode(Node):
    """Shows the robot of the node `watch` and the gearboxes of `estimator` on a `server`."""

    def __init__(self, estimator: str, watch: str, server: EventServer) -> None:
        super().__init__('live')
        self._server, self._page = server, LivePage()
        namespace = self.get_namespace().rstrip('/')
        self._source, node = (
            name if name.startswith('/') else f'{namespace}/{name}' for name in (estimator, watch))
        self._watch = WatchNews(node)
        subscribe(self, String, FINDINGS.replace('~', node), self._on_findings, latched())
        subscribe(self, String, ROBOT_DESCRIPTION, self._on_description, latched())
        self._gearboxes: dict[str, GearboxHistory] = {}
        self._motion = subscribe_polled(self, JointState, MOTION, best_effort(DEPTH), raw=True)
        subscribe(self, DiagnosticArray, DIAGNOSTICS, self._on_diagnostics, 50)
        subscribe(self, DiagnosticArray, DRIFT_ALERTS, self._on_alert, latched())
        self._timer = steady_timer(self, PERIOD, self._draw)

    def _gearbox(self, name: str) -> GearboxHistory | None:
        """Return the gearbox `name`; None: there are too many."""
        if name not in self._gearboxes and len(self._gearboxes) < MAX_GEARBOXES:
            self._gearboxes[name] = gearbox = GearboxHistory(name)
            path = self._source if name == TRANSMISSION else f'{self._source}/{name}'
            try:
                self.create_subscription(
                    DiagnosticArray, f'{path}/{SNAPSHOT}',
                    lambda message: _read_axis(gearbox, message), latched())
            except InvalidTopicNameException:
                pass  # anybody can publish any name: it is shown, in the units of a rotary axis
        return self._gearboxes.get(name)

    def _draw(self) -> None:
        """Take the messages that wait; draw, if anybody looks."""
        rows: dict[str, list[tuple[int, float, float]]] = {}
        for raw, _ in drain(self._motion, DEPTH):
            if len(raw) > MAX_BYTES:
                continue
            try:
                message = deserialize_message(raw, JointState)
            except (RMWError, UnicodeDecodeError):
                continue
            stamp = stamp_of(message)
            for name, twist, torque in zip(message.name, message.position, message.effort):
                rows.setdefault(name, []).append((stamp, twist, torque))
        for name, samples in rows.items():
            gearbox = self._gearbox(name)
            if gearbox is not None:
                gearbox.add_motion(np.array([s[0] for s in samples], np.int64),
                                   np.array([s[1:] for s in samples]))
        if self._server.clients:
            self._server.publish(self._page.parts(
                list(self._gearboxes.values()), self._source, time.monotonic(), self._watch))

    def _on_findings(self, message: String) -> None:
        data: Any = message.data
        try:
            data = json.loads(data)
        except ValueError:
            pass  # anybody can publish anything: the page says that it is none
        self._watch = replace(self._watch, data=data)

    def _on_description(self, message: String) -> None:
        self._watch = replace(self._watch, description=message.data)

    def _ours(self, status: DiagnosticStatus) -> tuple[GearboxHistory | None, str]:
        """Return gearbox and component of `status`; None: it is of another node."""
        node, _, component = status.name.partition(': ')
        source = self._source.lstrip('/')
        if node == source:
            gearbox = self._gearbox(TRANSMISSION)
        elif node.startswith(f'{source}/'):
            gearbox = self._gearbox(node.removeprefix(f'{source}/'))
        else:
            gearbox = None
        if gearbox is not None:
            gearbox.serial = status.hardware_id
        return gearbox, component

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == f'{self._watch.node.lstrip("/")}: robot':
                values = {v.key: v.value for v in status.values}
                self._watch = replace(self._watch, heard=time.monotonic(),
                                      problem=values.get('problem', ''))
            gearbox, component = self._ours(status)
            if gearbox is not None:
                gearbox.add_status(time.monotonic(), component, int(level_of(status)),
                                   status.message, {v.key: v.value for v in status.values})

    def _on_alert(self, message: DiagnosticArray) -> None:
        when = datetime.fromtimestamp(stamp_of(message) * 1e-9).strftime('%Y-%m-%d %H:%M:%S')
        for status in message.status:
            gearbox, component = self._ours(status)
            if gearbox is not None:
                gearbox.add_alert(
                    state_of(component, int(level_of(status)), status.message, {}), when)

    def close(self) -> None:
        """End the server."""
        self._server.close()


def _read_axis(gearbox: GearboxHistory, message: DiagnosticArray) -> None:
    """Take the axis of `gearbox` from the model in a snapshot."""
    for status in message.status:
        for value in status.values:
            if value.key == 'model':
                try:
                    gearbox.axis = str(json.loads(value.value)['axis'])
                except (ValueError, KeyError, TypeError):
                    pass  # anybody can publish anything: the units stay


def serve(host: str, port: int, nodes: tuple[str, str], ros_args: Sequence[str] = ()) -> int:
    """
    Serve the live page until SIGINT or SIGTERM; call it from the main thread.

    Args:
        host: address to listen on.
        port: to listen on, 0: any that is free.
        nodes: names of estimator and watch, relative to the namespace or absolute.
        ros_args: further arguments of rclpy.init.

    Returns:
        The exit code.

    Raises:
        InputError: host or port cannot be used.

    """
    server = EventServer(live_frame(), host, port)
    print(f'{server.address} shows {" and ".join(nodes)}; Ctrl-C ends', flush=True)
    code = spin_node(lambda: LiveNode(*nodes, server), ['gearbox_monitor live', *ros_args])
    if not server.ended:  # the node never began
        server.close()
    return code


class Watcher:
    """
    Node `name` in ROS domain `domain`, in its own context; it installs no signal handlers.

    gearboxes: of the estimator, ('',) for a single one without a name.

    joints: {gearbox: {component: Outcome}} of the estimator's newest diagnostics, values as texts;
    outcomes: those of the first gearbox; recorder: the recorder's Outcome or None; alerts: texts
    of the drift alerts, oldest first; updates: number of diagnostics of the estimator; snapshots:
    those of the estimator, {name: text}, oldest first: the first one holds the state at its start.
    """

    def __init__(self, name: str, domain: int, gearboxes: Sequence[str] = ('',)) -> None:
        self.joints: dict[str, dict[str, Outcome]] = {gearbox: {} for gearbox in gearboxes}
        self.outcomes = self.joints[gearboxes[0]]
        self.recorder: Outcome | None = None
        self.alerts: list[str] = []
        self.updates = 0
        self.snapshots: list[dict[str, str]] = []
        self._context = rclpy.Context()
        rclpy.init(args=['--ros-args', '--disable-external-lib-logs'], context=self._context,
                   domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(name, context=self._context, enable_rosout=False,
                          start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        subscribe = self._node.create_subscription
        subscribe(DiagnosticArray, DIAGNOSTICS, self._on_diagnostics, 20)
        subscribe(DiagnosticArray, DRIFT_ALERTS, self._on_alert, latched())
        for gearbox in gearboxes:
            subscribe(DiagnosticArray, f'estimator/{gearbox}/{SNAPSHOT}'.replace('//', '/'),
                      self._on_snapshot, latched())

    def spin(self, seconds: float) -> None:
        """Receive messages for `seconds`."""
        end = time.monotonic() + seconds
        while (remaining := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=remaining)

    def ready(self) -> bool:
        """Return whether estimator and recorder subscribe to the topics of a plant."""
        return (len(self.snapshots) >= len(self.joints)
                and self._node.count_subscribers(JOINT_STATES) >= 2
                and self._node.count_subscribers(PLANT_TRANSMISSION_STATE) >= 1)

    def close(self) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def _on_snapshot(self, message: DiagnosticArray) -> None:
        self.snapshots += [{value.key: value.value for value in status.values}
                           for status in message.status]

    def _on_alert(self, message: DiagnosticArray) -> None:
        for status in message.status:
            gearbox = _gearbox(status)
            self.alerts.append(f'{level_of(status).name}: ' + (f'{gearbox}: ' if gearbox else '')
                               + status.message)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            node, _, component = status.name.partition(': ')
            outcome = Outcome.of(level_of(status), 'as_written', {
                value.key: value.value for value in status.values}, text=status.message)
            if node.partition('/')[0] == 'estimator':
                self.joints.setdefault(_gearbox(status), {})[component] = outcome
            elif node == 'recorder':
                self.recorder = outcome
        self.updates += (message.status[0].name.startswith(('estimator: ', 'estimator/'))
                         if message.status else 0)


def _gearbox(status: DiagnosticStatus) -> str:
    """Return the gearbox that a `status` of the estimator is about, '' for a single one."""
    return str(status.name.partition(': ')[0].partition('/')[2])


def level_of(status: DiagnosticStatus) -> Level:
    """Return the Level of `status`."""
    return Level(min(ord(status.level), Level.ERROR))
