# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Plant, recorders and witness for the benchmark of the recorder, and what a bag has kept."""
from dataclasses import dataclass
import os
import time

from fault_node import ScenarioNodes
import numpy as np
from witness import stamp_ns, Witness

from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.topics import JOINT_STATES, PLANT_TRANSMISSION_STATE
from gearbox_monitor.recordings.write import recover

TOPICS = (f'/{JOINT_STATES}', f'/{PLANT_TRANSMISSION_STATE}')
FAST_DDS = 'rmw_fastrtps_cpp'
SECOND = 1_000_000_000
BEGUN = 4096  # bytes of a bag that has messages
# The shared memory of Fast DDS holds locks; a process that is killed while it has one makes those
# wait for ever that need it. So all goes through the loopback interface.
PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>
  <transport_descriptors><transport_descriptor>
    <transport_id>loopback</transport_id><type>UDPv4</type>
    <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>
  </transport_descriptor></transport_descriptors>
  <participant profile_name="loopback" is_default_profile="true"><rtps>
    <userTransports><transport_id>loopback</transport_id></userTransports>
    <useBuiltinTransports>false</useBuiltinTransports>
  </rtps></participant>
</profiles></dds>
"""


@dataclass(frozen=True)
class Kept:
    """
    What a bag has kept.

    messages: in it. missing: those older than 1 s at the accident that are not. lost_s: from how
    long before the accident on messages are missing. unread: messages that recover has not saved.
    """

    messages: int
    missing: int
    lost_s: float
    unread: int


class Bench:
    """A plant, a witness beside it and recorders, all in ROS domain `domain`."""

    def __init__(self, folder, domain, seed):
        self.folder, self.random = folder, np.random.default_rng(seed)
        self._count, self._plant = 0, None
        self._nodes = ScenarioNodes(folder, domain, _environment(folder))
        try:
            self.witness = Witness(TOPICS, domain)
            self.plant(1000.0)
        except BaseException:
            self._nodes.close()
            raise

    def plant(self, rate):
        """Start a plant of `rate` (Hz) instead of the one before; 0: none."""
        if self._plant is not None:
            self._plant.kill()
            self._plant.wait()
            self.forget(self._plant)
            self._plant = None
        if not rate:
            return
        before = len(self.witness.seen[TOPICS[0]])
        self._plant = self._nodes.start('plant_node', rate=rate)
        self.until(lambda: len(self.witness.seen[TOPICS[0]]) > before + 100, 'a sample')

    def record(self, module='recorder_node', output=None, **kwargs):
        """Start a recorder as ScenarioNodes.start() does; return (process, path of its bag)."""
        self._count += 1
        output = output or self.folder / f'bag{self._count}'
        return self._nodes.start(module, output=str(output), topics=list(TOPICS),
                                 **kwargs), output

    def until(self, condition, what):
        """Let the witness work until `condition()`."""
        def done():
            self.witness.poll()
            return condition()
        self._nodes.until(done, what)

    def until_begun(self, processes, paths):
        """Wait until all bags `paths` have messages; return the time (ns)."""
        def begun():
            for process in processes:
                if process.poll() is not None:
                    raise InputError('a recorder ended: '
                                     + self.said(process))
            return all((path / f'{path.name}_0.mcap').is_file() and
                       (path / f'{path.name}_0.mcap').stat().st_size > BEGUN for path in paths)
        self.until(begun, 'a first message in a bag')
        return time.time_ns()

    def wait(self, seconds):
        """Let the witness work for `seconds`."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.witness.poll()
            self._nodes.watcher.spin(0.02)

    def told(self):
        """Return the recorder's newest Outcome, None before the first."""
        return self._nodes.watcher.recorder

    def said(self, process):
        """Return what a recorder has printed."""
        return self._nodes.said(process)

    def kept(self, path, begun_ns, event_ns):
        """
        Return what the bag `path` has Kept; it is recovered, too.

        begun_ns, event_ns: when it had messages, and when the accident was.
        """
        self.wait(0.1)
        missing, lost_ns, messages, content = 0, 0, 0, []
        if path.exists():
            with open_bag(path) as bag:
                content = list(bag.messages(TOPICS))
        found = {topic: [] for topic in TOPICS}
        for topic, _, _, raw in content:
            found[topic].append(stamp_ns(raw))
        for topic, stamps in found.items():
            messages += len(stamps)
            seen = np.array(self.witness.seen[topic], np.int64).reshape(-1, 2)
            due = (seen[:, 0] > begun_ns) & (seen[:, 0] < event_ns)
            gone = seen[due & ~np.isin(seen[:, 1], stamps)]
            missing += int((gone[:, 0] < event_ns - SECOND).sum())
            lost_ns = max(lost_ns, *(event_ns - gone[:, 0]), 0)
        out = path.with_name(f'{path.name}_recovered')
        unread = len(content)
        try:
            if not content or not recover(path, out).written:  # there is nothing to recover
                unread = 0
            else:
                with open_bag(out) as bag:
                    if list(bag.messages()) == content and not bag.notice:
                        unread = 0
        except InputError:
            pass  # it counts as unread
        return Kept(messages, missing, float(lost_ns) / SECOND, unread)

    def forget(self, process):
        """Leave out a process that has ended."""
        self._nodes.processes.remove(process)

    def close(self):
        """End all nodes."""
        self._nodes.close()
        self.witness.close()


def _environment(folder):
    """Return the variables that keep all nodes on this machine, without shared memory."""
    if os.environ.get('RMW_IMPLEMENTATION', FAST_DDS) != FAST_DDS:
        return {}
    path = folder / 'loopback.xml'
    path.write_text(PROFILE, encoding='utf-8')
    # With LOCALHOST it would take shared memory all the same.
    return {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'FASTRTPS_DEFAULT_PROFILES_FILE': str(path)}
