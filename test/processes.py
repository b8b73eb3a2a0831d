# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Nodes as processes of their own, forked from one that has imported what nodes need.

Importing takes a node longer than most tests take it to do its work.
"""
import atexit
from functools import cache
import gc
from importlib import import_module
import json
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import time

ROOT = Path(__file__).parents[1]
DOMAIN = 1 + os.getpid() % 100  # its own: several test runs may share the machine
NODES = ('estimator_node', 'plant_node', 'arm_plant_node', 'recorder_node', 'watch_node')


class Node:
    """A running node: what tests use of a subprocess.Popen; its output goes to files."""

    def __init__(self, module, arguments, folder, parameters=None):
        words = [word for name, value in (parameters or {}).items()
                 for word in ('-p', f'{name}:={value}')]
        self.output = [folder / f'{module}{time.monotonic_ns()}.{name}' for name in ('out', 'err')]
        self.returncode = None
        self.pid = _answer({
            'module': f'gearbox_monitor.ros.{module}', 'folder': str(folder),
            'arguments': [module, '--ros-args', *map(str, arguments), *words],
            'output': [*map(str, self.output)], 'environment': {
                **os.environ, 'ROS_DOMAIN_ID': str(DOMAIN),
                'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_LOG_DIR': str(folder / 'log')}})

    def poll(self):
        """Return its exit code, None while it runs."""
        if self.returncode is None:
            self.returncode = _answer({'pid': self.pid})
        return self.returncode

    def communicate(self, timeout=300.0):
        """Wait for its end; return what it wrote to stdout and stderr."""
        end = time.monotonic() + timeout
        while self.poll() is None:
            if time.monotonic() > end:
                raise subprocess.TimeoutExpired(self.output[0].name, timeout)
            time.sleep(0.01)
        return tuple(file.read_text() for file in self.output)

    def send_signal(self, number):
        """Send it a signal, if it still runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self):
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self):
        """End it."""
        self.send_signal(signal.SIGKILL)

    def wait(self):
        """Wait for its end; return its exit code."""
        self.communicate()
        return self.returncode


@cache
def _forks():
    """Return the channel to the process that forks; it ends with this one."""
    here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with there:
        process = subprocess.Popen(
            [sys.executable, '-P', __file__, str(there.fileno())], stdin=subprocess.DEVNULL,
            env={**os.environ, 'PYTHONPATH': str(ROOT)}, pass_fds=[there.fileno()])

    @atexit.register
    def end():
        here.close()
        process.wait()
    return here


def _answer(order):
    _forks().send(json.dumps(order).encode())
    return json.loads(_forks().recv(1 << 10))


def serve(channel):
    """Fork a node for each order that comes by `channel`, and tell how nodes ended."""
    # A test that limits the size of files would cut modules that are compiled meanwhile.
    sys.dont_write_bytecode = True
    interrupted = signal.signal(signal.SIGINT, signal.SIG_IGN)
    for module in NODES:
        import_module(f'gearbox_monitor.ros.{module}')
    gc.freeze()
    while request := channel.recv(1 << 20):
        order = json.loads(request)
        if 'pid' in order:
            pid, status = os.waitpid(order['pid'], os.WNOHANG)
            answer = os.waitstatus_to_exitcode(status) if pid else None
        elif not (answer := os.fork()):
            channel.close()
            signal.signal(signal.SIGINT, interrupted)
            return _run(order)
        channel.send(json.dumps(answer).encode())
    return 0


def _run(order):
    """Be the node that an order is about; return its exit code."""
    os.chdir(order['folder'])
    os.environ.clear()
    os.environ.update(order['environment'])
    for number, path in enumerate(order['output'], 1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), number)
    sys.argv = order['arguments']
    return import_module(order['module']).main()


def refusals(module, cases, folder):
    """
    Return [(exit code, lines on stderr)] of runs of a node that come to an end.

    Args:
        module: of gearbox_monitor.ros.
        cases: the ROS arguments of each run, [[text]].
        folder: where it runs.

    """
    nodes = [Node(module, words, folder) for words in cases]
    told = [node.communicate()[1].splitlines() for node in nodes]
    return [(node.returncode, [*filter(None, lines)]) for node, lines in zip(nodes, told)]


def put_down(processes):
    """
    End all `processes` that still run: asked first, killed where that does not help.

    A node killed while it publishes may leave the shared memory of its reader broken, and Fast DDS
    crashes where it opens that again: in this process, in the next test.
    """
    for process in processes:
        if process.poll() is None:
            process.terminate()
    for process in processes:
        try:
            process.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


if __name__ == '__main__':
    sys.exit(serve(socket.socket(fileno=int(sys.argv[1]))))
