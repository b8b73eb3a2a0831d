# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Serves one page and a stream of events (server-sent events) to browsers, by the stdlib."""
from collections.abc import Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
import ipaddress
import json
import socket
import socketserver
import sys
import threading
from typing import Any

from gearbox_monitor.errors import InputError

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
        number = 0
        while not self.server.ended:
            parts, newest = self.server.news(number)
            if newest == number:
                self.wfile.write(b': still there\n\n')
                continue
            number = newest
            changed = {name: html for name, html in parts.items() if sent.get(name) != html}
            sent = parts
            if changed:
                self.wfile.write(f'data: {json.dumps(changed)}\n\n'.encode())

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing about requests."""
