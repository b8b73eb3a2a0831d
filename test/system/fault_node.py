# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A source that is killed and started again, with real nodes over DDS; then the same bag replayed.

The new plant begins anew: positions at another place, stamps of a new process. The killed one says
no goodbye.
"""
import json
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time

from fault_runs import OK_AGAIN, TRUST

import gearbox_monitor
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.replay import Comparer, ReplaySummary

AWAY = 3.0  # s without a source
TOLD = 3.0  # s: diagnostics come every second
# Neither estimator nor recorder misses the first samples of a plant that sees both.
RELIABLE = {'qos_overrides./joint_states.subscription.reliability': 'reliable'}
SUBSCRIBERS = 3  # estimator and recorder of the samples, recorder of the truth
HERE = Path(__file__).resolve().parent
ROOT = str(Path(gearbox_monitor.__file__).resolve().parents[1])
PATIENCE = 120.0  # s, for a start that compiles


class ScenarioNodes:
    """
    Node processes in one ROS domain, on this machine only; `watcher` follows the estimator.

    environment: {name: value} of variables that they have besides.
    """

    def __init__(self, folder, domain, environment=None):
        try:
            from gearbox_monitor.ros.live_node import Watcher
        except ImportError as error:
            raise InputError(f'--node: rclpy: {error}; expected a sourced ROS 2 or an '
                             f'installation with {installed_by("ros")}') from None
        os.environ.update({'ROS_DOMAIN_ID': str(domain),
                           'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', **(environment or {})})
        self.folder, self.processes, self._logs = folder, [], {}
        self.watcher = Watcher('fault_benchmark', domain)

    def start(self, module, **parameters):
        """
        Start a node with `parameters` and return its process.

        module: its name in gearbox_monitor.ros, or that of a module of this folder.
        """
        package = '' if (HERE / f'{module}.py').is_file() else 'gearbox_monitor.ros.'
        command = [sys.executable, '-m', package + module, '--ros-args',
                   '--disable-external-lib-logs']
        for name, value in parameters.items():
            command += ['-p', f'{name}:={json.dumps(value)}']
        path = os.pathsep.join(filter(None, [ROOT, str(HERE), os.environ.get('PYTHONPATH')]))
        log_path = self.folder / f'{module}_{len(self._logs)}.log'
        with open(log_path, 'wb') as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder,
                                       env={**os.environ, 'PYTHONPATH': path})
        self.processes.append(process)
        self._logs[process.pid] = log_path
        return process

    def said(self, process):
        """Return what a process of start() has printed."""
        return self._logs[process.pid].read_text(errors='replace').strip()

    def until(self, condition, what):
        """Take what comes until `condition()`; returns the clock then (s)."""
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise InputError(f'nodes: {what} did not happen within {PATIENCE:g} s, expected '
                                 'a machine that runs three nodes at 1 kHz')
            self.watcher.spin(0.02)
        return time.monotonic()

    def worst(self):
        """Return the worst level of TRUST that the estimator says now."""
        found = self.watcher.outcomes
        return max((found[name].level for name in TRUST if name in found), default=Level.WARN)

    def samples(self):
        """Return how many samples the estimator has taken, as it says."""
        found = self.watcher.outcomes.get('input')
        return int(found.values.get('samples', 0)) if found else 0

    def close(self):
        """
        End all nodes and wait for them, the recorder last: it was started first.

        One that does not end within 30 s is killed: none is left.
        """
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.watcher.close()


def restart(domain):
    """Return the figures of one run in ROS domain `domain`, as plain data."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        nodes = ScenarioNodes(folder, domain)
        try:
            nodes.start('recorder_node', output=str(folder / 'bag'))
            nodes.start('estimator_node', arm_load='none', **RELIABLE)
            nodes.until(nodes.watcher.ready, 'a start of the estimator')
            plant = nodes.start('plant_node', seed=1, wait_for_subscribers=SUBSCRIBERS)
            nodes.until(lambda: nodes.worst() == Level.OK, 'a first estimate that is OK')
            plant.kill()
            plant.wait()
            gone = time.monotonic()
            told = nodes.until(lambda: nodes.worst() > Level.OK, 'a level that is not OK') - gone
            by = [name for name in TRUST
                  if nodes.watcher.outcomes[name].level == nodes.worst()]
            always = True
            while time.monotonic() < gone + AWAY:
                nodes.watcher.spin(0.02)
                always &= nodes.worst() > Level.OK
            taken = nodes.samples()
            nodes.start('plant_node', seed=2, wait_for_subscribers=SUBSCRIBERS)
            back = nodes.until(lambda: nodes.samples() > taken, 'a sample of the new source')
            ok_after = nodes.until(lambda: nodes.worst() == Level.OK, 'a level OK again') - back
        finally:
            nodes.close()
        with open_bag(folder / 'bag') as reader:
            player = Player(reader)
            summary, comparer = ReplaySummary(player), Comparer(player)
            player.run([summary, comparer])
            data = summary.data(comparer.comparison)
    missed = [text for text, broken in (
        ('told in time', told > TOLD or not always), ('levels OK soon after', ok_after > OK_AGAIN),
        ('replay the same', data['replay_identical'] != 'yes')) if broken]
    return {'told': told, 'by': by, 'ok_after': ok_after, 'estimates': data['estimates'],
            'starts': data['refused'].get('starts', 0),
            'replay_identical': data['replay_identical'], 'missed': missed}


def text(row):
    """Return the figures in words."""
    return (f'real nodes, source killed for {AWAY:g} s: told after {row["told"]:.1f} s by '
            f'{", ".join(row["by"])}, OK {row["ok_after"]:.1f} s after the first diagnostics with '
            f'new samples; {row["starts"]} starts, {row["estimates"]} estimates, replay '
            f'identical: {row["replay_identical"]}\n'
            + (f'MISSED {", ".join(row["missed"])}' if row['missed'] else 'met    all'))
