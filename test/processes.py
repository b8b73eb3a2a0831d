# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Processes of tests: their end, and nodes that refuse what they are given."""
import json
import os
from pathlib import Path
import re
import subprocess
import sys

RUNS = """
from importlib import import_module
import json
import sys
main = import_module(sys.argv[1]).main
for words in json.loads(sys.argv[2]):
    print('exit code', main(['node', '--ros-args', *words]), file=sys.stderr, flush=True)
"""


def refusals(module, cases, folder):
    """
    Return [(exit code, lines on stderr)] of runs of a node that come to an end.

    One process runs them all: importing takes longer than refusing.

    Args:
        module: of gearbox_monitor.ros.
        cases: the ROS arguments of each run, [[text]].
        folder: where it runs.

    """
    done = subprocess.run(
        [sys.executable, '-c', RUNS, f'gearbox_monitor.ros.{module}', json.dumps(cases)],
        cwd=folder, capture_output=True, text=True, timeout=300,
        env={**os.environ, 'PYTHONPATH': str(Path(__file__).parents[1])})
    assert done.returncode == 0, done.stderr
    texts = re.split(r'exit code (\d+)\n', done.stderr)
    runs = [(int(code), [line for line in text.splitlines() if line])
            for text, code in zip(texts[::2], texts[1::2])]
    assert len(runs) == len(cases), done.stderr
    return runs


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
