# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What is fuzzed: sound files of every kind, how they are damaged, and who reads them."""
from dataclasses import dataclass
import gzip
import io
import json

from fuzz_damage import damaged_bytes, damaged_mcap, damaged_text
import h5py
import numpy as np
import pyarrow as pa
from pyarrow import feather, parquet
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer as RosbagsWriter
from rosbags.typesys import get_typestore, Stores
import scipy.io

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.files.baselines import (
    health_text, load_baseline, load_state, save_baseline, STATE, write_whole)
from gearbox_monitor.files.user_files import config_path, load_model, load_parameters
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.health_record import HealthSettings, Window
from gearbox_monitor.health.judgement import Health, judge
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.reading import open_recording, read_mapping, ReadOptions
from gearbox_monitor.recordings.replay import ReplaySummary
from gearbox_monitor.recordings.write import BagWriter, recover

JOINT_STATE, DIAGNOSTICS = 'sensor_msgs/msg/JointState', 'diagnostic_msgs/msg/DiagnosticArray'
TOPIC, JOINTS, SNAPSHOT = '/joint_states', ('motor', 'arm'), '/estimator/snapshot'
RATE, COUNT = 1000, 300
T0 = 1_000_000_000  # stamp of the first sample, ns


@dataclass(frozen=True)
class Target:
    """
    One kind of file.

    files: {name: bytes} of a sound one; the first is damaged by `damage`(data, random). read:
    function of the folder with these files, which reads all there is.
    """

    name: str
    files: dict
    damage: object
    read: object


def _bag_files(folder, compression):
    """Return {name: bytes} of a bag with measurements and a snapshot of an estimator."""
    run = simulate(DriveModel(), Excitation().torque(np.arange(COUNT) / RATE), 1.0 / RATE,
                   Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=0)
    stamps = T0 + np.arange(COUNT) * (10 ** 9 // RATE)
    effort = np.column_stack([run.u, np.full(COUNT, np.nan)])
    monitor = Monitor(DriveModel(), {'arm_load': 'none'})
    path = folder / f'bag_{compression}'
    with BagWriter(path, compression, chunk_seconds=np.inf) as writer:
        writer.add_topic(TOPIC, JOINT_STATE)
        writer.add_topic(SNAPSHOT, DIAGNOSTICS)
        for k, raw in enumerate(encode_joint_states(stamps, JOINTS, run.y, effort=effort)):
            if k in (0, COUNT // 2):
                writer.write_message(SNAPSHOT, int(stamps[k]), _snapshot(monitor))
            writer.write(TOPIC, int(stamps[k]), raw)
            monitor.run(Samples(stamps[k:k + 1], effort[k:k + 1], run.y[k:k + 1]))
    return {f'bag/{file.name}': file.read_bytes() for file in
            sorted(path.iterdir(), key=lambda file: file.suffix != '.mcap')}


def _snapshot(monitor):
    types = get_typestore(Stores.ROS2_JAZZY).types
    header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), '')
    return types[DIAGNOSTICS](header, [types['diagnostic_msgs/msg/DiagnosticStatus'](
        0, 'estimator: snapshot', '', 'gearbox', [
            types['diagnostic_msgs/msg/KeyValue'](key, value)
            for key, value in monitor.snapshot().items()])])


def _read_bag(folder):
    with open_bag(folder / 'bag') as reader:
        for topic, (msgtype, _) in list(reader.topics.items()):
            for _, _, _, raw in reader.messages([topic]):
                try:
                    reader.decode(msgtype, raw)
                except InputError as error:
                    one_line(error)  # of this message; others are tried
        for topic, (msgtype, _) in list(reader.topics.items()):
            if msgtype == JOINT_STATE:
                try:
                    reader.joint_states(topic, reader.joint_names(topic))
                except InputError as error:
                    one_line(error)
        player = Player(reader, whole=False)
        summary = ReplaySummary(player)
        player.run([summary])
        summary.data()


def _recover(folder):
    recovery = recover(folder / 'bag', folder / 'new')
    assert all(0 <= t.lost and 0 <= t.recovered for t in recovery.topics.values())
    assert recovery.lost_s >= 0.0


def _sqlite_files(folder):
    with RosbagsWriter(folder / 'sqlite', version=9,
                       storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection(
            TOPIC, JOINT_STATE, typestore=get_typestore(Stores.ROS2_JAZZY))
        for k, raw in enumerate(encode_joint_states(
                T0 + np.arange(60), JOINTS, np.zeros((60, 2)), effort=np.zeros((60, 2)))):
            writer.write(connection, T0 + k, raw)
    return {f'bag/{file.name}': file.read_bytes() for file in
            sorted((folder / 'sqlite').iterdir(), key=lambda file: file.suffix != '.db3')}


def one_line(error):
    """Assert that the InputError `error` is one readable line for each problem."""
    for line in str(error).split('\n'):
        assert line.strip() and line.isprintable() and len(line) < 1000, f'no line: {line[:200]!r}'


def _snapshot_text():
    monitor = Monitor(DriveModel(), {'arm_load': 'none'})
    monitor.run(Samples(np.arange(T0, T0 + 20_000_000, 1_000_000), np.zeros((20, 2)),
                        np.zeros((20, 2))))
    return json.dumps(monitor.snapshot(), indent=1).encode()


def _read_snapshot(folder):
    try:
        content = json.loads((folder / 'snapshot.json').read_bytes())
    except (ValueError, RecursionError):
        return  # the damage shall be in the texts, not around them
    if isinstance(content, dict) and all(isinstance(v, str) for v in content.values()):
        Monitor.restore(content)


def _known():
    """Return the Health of a gearbox after some windows."""
    health, random = Health(HealthSettings()), np.random.default_rng(0)
    for k in range(6):
        gap, stiffness = random.normal((0.2, 25.0), (0.002, 0.3))
        health = judge(health, Window(Backlash(
            T0 + k * 10 ** 10, gap, 0.002, stiffness, 0.3, viscous=0.0, viscous_std=0.01,
            coulomb=0.0, coulomb_std=0.01, gain=0.0, gain_std=0.01, lost_motion=gap,
            lost_motion_std=0.002, angle=0.1, speed=2.0, load=1.0), temperature=20.0))
    return health


CSV = 't,u,motor,arm\n' + ''.join(
    f'{k / 1000:.3f},{k % 7 - 3},{0.001 * k:.6f},{0.0009 * k if k % 5 else ""}\n'
    for k in range(120))
MAPPING = """time: {column: t, scale: 0.001}
signals:
  motor_position: {column: motor.q, counts_per_rev: 4096, zero: 12.0}
  motor_effort: {column: motor.i, torque_constant: 0.1, sign: -1}
gear_ratio: 35.0
"""
ROWS = json.dumps({'rows': [
    {'t': k, 'motor': {'q': 10.0 * k, 'i': 0.1 * k}} for k in range(120)]})


def read_log(path):
    """Read all joint states of a log of any kind, as commands do."""
    with open_recording(path) as reader:
        for topic in list(reader.topics):
            reader.joint_states(topic, reader.joint_names(topic)[:20])


def _logs():
    """Yield (name, bytes, damage) of a log of each kind."""
    k = np.arange(160)
    columns = {'t': 0.01 * k, 'q_1': np.sin(0.05 * k), 'q_2': np.cos(0.03 * k),
               'tau_1': np.sin(0.07 * k), 'tau_2': np.cos(0.05 * k)}
    yield 'data.csv', CSV.encode(), damaged_text
    yield 'data.csv.gz', gzip.compress(CSV.encode()), damaged_bytes
    yield 'data.bin', CSV.encode(), damaged_bytes
    rows = list(zip(*columns.values()))
    yield 'joints.csv', ('\n'.join(['time [s];q_1 [deg];q_2 [deg];tau_1 [Nm];tau_2 [Nm]', *(
        ';'.join(f'{x:.5f}'.replace('.', ',') for x in row) for row in rows)])
        + '\n').encode(), damaged_text
    yield 'long.csv', ('time,joint_name,position,effort\n' + ''.join(
        f'{t:.3f},{joint},{q:.5f},{u:.5f}\n' for t, q1, q2, u1, u2 in rows
        for joint, q, u in (('a', q1, u1), ('b', q2, u2)))).encode(), damaged_text
    for name, save in (('data.mat', lambda out: scipy.io.savemat(
            out, columns, do_compression=True)), ('data.npz', lambda out: np.savez(
                out, **columns)), ('data.parquet', lambda out: parquet.write_table(
                    pa.table(columns), out)), ('data.feather', lambda out: feather.write_feather(
                        pa.table(columns), out)), ('data.h5', lambda out: _hdf5(out, columns))):
        out = io.BytesIO()
        save(out)
        yield name, out.getvalue(), damaged_bytes


def _ros1_bag(folder):
    """Return the bytes of a bag of ROS 1 with joint states."""
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    with Ros1Writer(folder / 'old.bag') as writer:
        connection = writer.add_connection(TOPIC, JOINT_STATE, typestore=store)
        for k in range(160):
            header = types['std_msgs/msg/Header'](k, types['builtin_interfaces/msg/Time'](
                1, 1_000_000 * k), 'base')
            message = types[JOINT_STATE](header, list(JOINTS), np.full(2, 0.1 * k), np.zeros(0),
                                         np.full(2, 0.2 * k))
            writer.write(connection, T0 + 1_000_000 * k, store.serialize_ros1(
                message, JOINT_STATE))
    return (folder / 'old.bag').read_bytes()


def _hdf5(out, columns):
    with h5py.File(out, 'w') as file:
        for episode in range(2):
            for name, values in columns.items():
                file[f'data/demo_{episode}/obs/{name}'] = values


def targets(folder):
    """Return the Targets; sound files are made in `folder`."""
    health = _known()
    save_baseline(folder / 'baseline.yaml', health, 'joint3', {'filter': 'ekf'})
    write_whole(folder / 'state.json', health_text(
        STATE, health, 'joint3', adaptation={'gain': 0.1}, recording_ns=0))
    found = []
    for compression in ('none', 'lz4', 'zstd'):
        files = _bag_files(folder, compression)
        found.append(Target(f'bag, {compression}', files, damaged_mcap, _read_bag))
    found.append(Target('bag, recover', files, damaged_mcap, _recover))
    found.append(Target('bag, SQLite', _sqlite_files(folder), damaged_bytes, _read_bag))
    metadata = {name: files[name] for name in sorted(files, key=lambda n: not n.endswith('.yaml'))}
    found.append(Target('bag, metadata.yaml', metadata, damaged_text, _read_bag))
    found.append(Target('recover, metadata.yaml', metadata, damaged_text, _recover))

    def text(name, data, read, damage=damaged_text):
        found.append(Target(name, {name: data}, damage,
                            lambda where: read(where / name)))
    model = config_path('drive.yaml').read_bytes().replace(
        b'effects: []', b'effects: [{id: stribeck, Cs: 0.1, vs: 0.2}, {id: gravity, G: 1.0}]')
    text('drive.yaml', model, load_model)
    text('estimator.yaml', config_path('estimator.yaml').read_bytes(),
         lambda path: load_parameters(path, 'estimator', ESTIMATOR))
    for name, data, damage in (*_logs(), ('old.bag', _ros1_bag(folder), damaged_bytes)):
        text(name, data, read_log, damage)
    text('baseline.yaml', (folder / 'baseline.yaml').read_bytes(),
         lambda path: load_baseline(path, 'joint3'))
    text('state.json', (folder / 'state.json').read_bytes(),
         lambda path: load_state(path, 'joint3'))
    found.append(Target('snapshot', {'snapshot.json': _snapshot_text()}, damaged_text,
                        _read_snapshot))
    mapping, rows = {'map.yaml': MAPPING.encode()}, {'rows.json': ROWS.encode()}

    def read_mapped(where):
        read_mapping(where / 'rows.json', ReadOptions(str(where / 'map.yaml')))
    found.append(Target('map.yaml', {**mapping, **rows}, damaged_text, read_mapped))
    found.append(Target('rows.json', {**rows, **mapping}, damaged_text, read_mapped))
    return found
