# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bags as a recorder beside an estimator writes them, without nodes."""
import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation, Faults, FaultyPlant
from gearbox_monitor.plant.simulate import Noise
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.topics import signal_values, SIGNALS

JOINT_STATE = 'sensor_msgs/msg/JointState'
DIAGNOSTICS = 'diagnostic_msgs/msg/DiagnosticArray'
T0, RATE = 1_700_000_000_000_000_000, 500  # ns, samples/s
# Short windows, one operating point, a false alarm a day: enough for an alert in so short a time.
PARAMETERS = {
    'arm_load': 'none', 'drift_window': 2.0, 'false_alarm_interval': 86400.0, 'angle_bin': 0.0,
    'speed_bin': 1.0, 'load_bin': 1.0}


def worn(seconds, lost=(0, 0), seed=5, rate=0.05, half_gap=0.1, per_second=RATE):
    """
    Return Samples of a drive whose gap grows from 10 s on.

    Args:
        seconds: of the drive.
        lost: samples from .. to without the arm.
        seed: of the noise.
        rate: of the growth, relative per second.
        half_gap: at the begin.
        per_second: samples of one.

    """
    n = seconds * per_second
    plant = FaultyPlant(DriveModel().with_(half_gap=half_gap),
                        Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed,
                        faults=Faults(gap_growth_rate=rate, gap_growth_start=10.0))
    drive = plant.run(Excitation().torque(np.arange(n) / per_second), 1.0 / per_second)
    y = drive.y.copy()
    y[slice(*lost), 1] = np.nan
    return Samples(T0 + np.arange(n) * (1_000_000_000 // per_second),
                   np.column_stack([drive.u, np.full(n, np.nan)]), y)


def write_inputs(writer, samples, later=0):
    """Write the `samples`, recorded so many ns `later` than they are stamped."""
    writer.add_topic('/joint_states', JOINT_STATE)
    raws = encode_joint_states(samples.stamp_ns, ['motor', 'arm'], samples.y, effort=samples.u)
    for stamp, raw in zip(samples.stamp_ns.tolist(), raws):
        writer.write('/joint_states', stamp + later, raw)


def write_live(writer, samples, refused=(0, 0), later=0):
    """
    Write what a node with PARAMETERS would have published, once per second in one go.

    refused: first and last second in which it says that two publishers deliver; later: see
    write_inputs.
    """
    types = get_typestore(Stores.ROS2_JAZZY).types

    def array(name, statuses, stamp):
        message = types[DIAGNOSTICS](
            types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), ''), [
                types['diagnostic_msgs/msg/DiagnosticStatus'](
                    int(level), f'estimator: {component}', text, 'gearbox', [
                        types['diagnostic_msgs/msg/KeyValue'](key, str(value))
                        for key, value in values.items()])
                for component, (level, text, values) in statuses.items()])
        writer.write_message(name, stamp + later, message)

    monitor, alerted = Monitor(DriveModel(), PARAMETERS), {}
    for signal in SIGNALS:
        writer.add_topic(f'/{signal.topic}', JOINT_STATE)
    for topic in ('/diagnostics', '/drift_alerts', '/estimator/snapshot'):
        writer.add_topic(topic, DIAGNOSTICS)
    snapshot = {'version': '0.0.9', 'kernels': 'c', **monitor.snapshot()}
    array('/estimator/snapshot', {'snapshot': (0, '', snapshot)}, T0)
    for k in range(len(samples.stamp_ns) // RATE):
        part = slice(RATE * k, RATE * (k + 1))
        estimates = monitor.run(Samples(samples.stamp_ns[part], samples.u[part], samples.y[part]))
        now = int(samples.stamp_ns[part][-1])
        for signal in SIGNALS:
            stamps, values = signal_values(signal, estimates, 1.0)
            for stamp, raw in zip(stamps, encode_joint_states(stamps, signal.joints, **values)):
                writer.write(f'/{signal.topic}', now + later, raw)
        told = {name: (f.level, f.message, {**f.figures, 'codes': ' '.join(f.codes)})
                for name, f in monitor.outcomes.items()}
        if refused[0] <= k < refused[1]:
            told['input'] = (2, 'two publishers deliver the joint', {'codes': 'two_publishers'})
        array('/diagnostics', told, now)
        for name, stages in monitor.health.stages().items():
            if stages != alerted.get(name, {}):
                alerted[name] = stages
                array('/drift_alerts', {name: told[name]}, now)
    # The source has ended; the node goes on and says so.
    array('/diagnostics', {'input': (2, 'no samples received', {'codes': 'silent'})},
          now + 2_000_000_000)
