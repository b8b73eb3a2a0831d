# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Replay in blocks: the same bits as sample by sample, whatever the bag; outputs; bounded size."""
import csv
from importlib.util import find_spec
import json
import os
from pathlib import Path
import subprocess
import sys
from types import SimpleNamespace

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
import pytest
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Sample
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings import cdr, joint_input, read, replay as replay_output
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.joint_input import match_stamps, StampMatcher
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.replay import replay
from gearbox_monitor.recordings.topics import ARM, joint_values, MOTOR, SIGNALS
from gearbox_monitor.recordings.write import BagWriter

STORE = get_typestore(Stores.ROS2_JAZZY)
JOINT_STATE, DIAGNOSTIC_ARRAY = 'sensor_msgs/msg/JointState', 'diagnostic_msgs/msg/DiagnosticArray'
T0 = 1_700_000_000_000_000_000
MS = 1_000_000
N = 6000
GEAR = -20.0
NAMES = ('m', 'a')


@pytest.fixture(scope='module')
def drive():
    return simulate(DriveModel(), Excitation().torque(1e-3 * np.arange(N)), 1e-3,
                    Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=5)


def encoded(stamp, names, position, effort, **kwargs):
    """Return the CDR bytes of one joint state."""
    return encode_joint_states(
        [stamp], names, None if position is None else np.array([position], float),
        effort=None if effort is None else np.array([effort], float), **kwargs)[0]


def big_endian(stamp, names, position, effort):
    types = STORE.types
    header = types['std_msgs/msg/Header'](
        types['builtin_interfaces/msg/Time'](*map(int, divmod(stamp, 10 ** 9))), 'x')
    return bytes(STORE.serialize_cdr(types[JOINT_STATE](
        header, list(names), np.array(position, float), np.empty(0), np.array(effort, float)),
        JOINT_STATE, little_endian=False))


def wild(drive):
    """Yield (log_ns, bytes) of a recording with everything in it that can go wrong."""
    rng = np.random.default_rng(8)
    for k in range(N):
        stamp = T0 + k * MS + (60_000 * MS if k > 4500 else 0)  # the clock jumps
        motor, arm, u = GEAR * drive.y[k, 0], drive.y[k, 1], drive.u[k] / GEAR
        raw = encoded(stamp, ['a', 'x', 'm'], [arm, 9.0, motor], [np.nan, np.nan, u])
        kind = rng.integers(40) if k > 50 else 0
        if kind == 1:
            raw = encoded(stamp, ['m', 'a'], [motor, arm], [u, np.nan], frame_id='base')
        elif kind == 2:
            raw = big_endian(stamp, ['m', 'a', 'y'], [motor, arm, 1.0], [u, np.nan, 0.0])
        elif kind == 3:
            raw = encoded(stamp, ['m'], [motor], [u])  # no arm
        elif kind == 4:
            raw = encoded(stamp, ['a', 'x', 'm'], [np.nan, 9.0, np.inf], [np.nan, np.nan, u])
        elif kind == 5:
            raw = encoded(stamp, ['m', 'a'], [motor, arm], None)  # no torque
        elif kind == 6:
            raw = encoded(0 if k % 2 else stamp - 1 * MS, ['m', 'a'], [motor, arm], [u, 0.0])
        elif kind == 7:
            raw += b'\x01\x02\x03'  # padding of a serialiser
        elif kind == 8:
            yield T0 + k * MS, encoded(stamp, ['gripper'], [0.5], None)
        elif kind == 9:
            raw = encoded(stamp, ['m', 'a', 'm'], [motor, arm, 7.0], [u, np.nan, 7.0])
        if not 3000 < k < 3150:  # a gap
            yield T0 + k * MS, raw


def write(path, messages, chunk, compression='lz4', split=None):
    """Write the joint states `messages`, a chunk every `chunk`; split: into so many files."""
    messages = list(messages)
    pieces = [messages] if split is None else [messages[k::split] for k in range(split)]
    for number, piece in enumerate(pieces):
        folder = path if split is None else path.with_name(f'{path.name}{number}')
        with BagWriter(folder, compression, chunk_seconds=1e9) as writer:
            writer.add_topic('/left/joint_states', JOINT_STATE)
            writer.add_topic('/other', JOINT_STATE)
            for k, (log_ns, raw) in enumerate(piece):
                writer.write('/left/joint_states', log_ns, raw)
                writer.write('/other', log_ns, raw)
                if k % chunk == chunk - 1:
                    writer.flush()
        if split is not None:
            path.mkdir(exist_ok=True)
            next(folder.glob('*.mcap')).rename(path / f'part_{number}.mcap')


def slow_samples(files):
    """Yield Samples, decoded message by message by the mcap package."""
    found = []
    for number, file in enumerate(sorted(files)):
        with open(file, 'rb') as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for k, (_, _, message, state) in enumerate(reader.iter_decoded_messages(
                    topics=['/left/joint_states'], log_time_order=False)):
                found.append((message.log_time, number, k, state))
    for *_, state in sorted(found, key=lambda item: item[:3]):
        if set(NAMES) & set(state.name):
            def value(values, name):
                k = state.name.index(name) if name in state.name else len(values)
                return values[k] if k < len(values) else np.nan
            stamp = state.header.stamp
            yield Sample(stamp.sec * 10 ** 9 + stamp.nanosec,
                         (value(state.effort, 'm') * GEAR, value(state.effort, 'a')),
                         (value(state.position, 'm') / GEAR, value(state.position, 'a')))


@pytest.mark.parametrize('compression, split', [('lz4', None), ('zstd', 3)])
def test_blocks_give_the_bits_of_single_samples(drive, tmp_path, monkeypatch, compression, split):
    """Missing joints, foreign layouts, bad stamps, jumps; one file or several that overlap."""
    write(tmp_path / 'bag', wild(drive), 37, compression, split)
    model = DriveModel(gear_ratio=GEAR)
    parameters = {'motor_joint': 'm', 'arm_joint': 'a', 'drift_window': 1.5}
    monitor = Monitor(model, parameters)
    single = [monitor.step(sample) for sample in slow_samples((tmp_path / 'bag').glob('*.mcap'))]
    rows = [estimate for estimate in single if estimate]
    smoothed = [row for estimate in rows for row in estimate.smoothed]
    for size, layouts in ((1, 16), (20_000, 2), (1 << 20, 16)):
        monkeypatch.setattr(read, 'BLOCK_BYTES', size)
        monkeypatch.setattr(cdr, 'MAX_LAYOUTS', layouts)  # others: message by message
        with open_bag(tmp_path / 'bag') as reader:
            result = replay(reader, model, parameters)
        estimates = result.estimates
        assert len(rows) > 4000 and len(result.monitor.windows) > 0
        np.testing.assert_array_equal(estimates.stamp_ns, [e.stamp_ns for e in rows])
        np.testing.assert_array_equal(estimates.rows, [e.row for e in rows])
        np.testing.assert_array_equal(estimates.smoothed_stamp_ns, [s for s, _ in smoothed])
        np.testing.assert_array_equal(estimates.smoothed, [row for _, row in smoothed])
        np.testing.assert_array_equal(result.monitor.counts, monitor.counts)
        assert result.monitor.outcomes == monitor.outcomes
        assert result.monitor.snapshot() == monitor.snapshot()
        assert len(result.samples.stamp_ns) == len(single)
    with open_bag(tmp_path / 'bag') as reader:
        player = Player(reader, model, parameters, whole=False)
        found = [part.estimates for part in player.parts()]
    np.testing.assert_array_equal(np.concatenate([e.rows for e in found]), estimates.rows)
    assert not any(len(e.smoothed) for e in found)


@pytest.fixture(scope='module')
def live(drive, tmp_path_factory):
    """Return a bag of an estimator, with snapshots, changes and a reset, and its rows."""
    path = tmp_path_factory.mktemp('live') / 'bag'
    monitor = Monitor(DriveModel(), {})
    samples = {'/joint_states': encode_joint_states(
        T0 + np.arange(N) * MS, ['motor', 'arm'], drive.y,
        effort=np.column_stack([drive.u, np.full(N, np.nan)]))}
    types = STORE.types
    header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), '')

    def snapshot(reason, log_ns):
        content = {'reason': reason, **monitor.snapshot()}
        status = types['diagnostic_msgs/msg/DiagnosticStatus'](
            0, 'estimator: snapshot', '', '',
            [types['diagnostic_msgs/msg/KeyValue'](key, value) for key, value in content.items()])
        writer.write_message('/estimator/snapshot', log_ns,
                             types[DIAGNOSTIC_ARRAY](header, [status]))

    with BagWriter(path, 'lz4', chunk_seconds=1e9) as writer:
        writer.add_topic('/joint_states', JOINT_STATE)
        writer.add_topic('/estimator/snapshot', DIAGNOSTIC_ARRAY)
        for signal in SIGNALS:
            writer.add_topic(f'/{signal.topic}', JOINT_STATE)
        snapshot('start', T0 - MS)
        rows = []
        for k in range(N):
            now = T0 + k * MS
            if k == 2000:
                monitor.set_parameters({'q_std_tau_k': 14.0})
                snapshot('parameters', now - MS // 2)
            elif k == 3300:
                monitor.reset()
                snapshot('reset', now - MS // 2)
            elif k % 1000 == 500:
                snapshot('period', now - MS // 2)
            writer.write('/joint_states', now, samples['/joint_states'][k])
            estimate = monitor.step(Sample(now, (drive.u[k], np.nan), drive.y[k]))
            if not estimate:
                continue
            rows.append(estimate.row)
            for signal in SIGNALS:
                due = [(now, estimate.row)] if not signal.smoothed else estimate.smoothed
                for stamp, row in due:
                    names, *fields = joint_values(signal, row, {MOTOR: 'motor', ARM: 'arm'}, 1.0)
                    writer.write(f'/{signal.topic}', now + 1000, encode_joint_states(
                        [stamp], names, *(np.array([f]) if f else None for f in fields))[0])
            if k % 200 == 199:
                writer.flush()
    return path, np.array(rows)


def test_snapshots_changes_and_cuts_replay_to_the_same_bits(live, tmp_path, monkeypatch):
    bag, rows = live
    for size in (1, 1 << 20):
        monkeypatch.setattr(read, 'BLOCK_BYTES', size)
        with open_bag(bag) as reader:
            result = replay(reader)
        comparison = result.comparison
        assert comparison.verdict == 'yes', comparison
        assert comparison.compared == comparison.identical > 5.9 * N
        assert comparison.lost_inputs == comparison.lost_outputs == 0
        np.testing.assert_array_equal(result.estimates.rows, rows)
    data = next(bag.glob('*.mcap')).read_bytes()
    for share in (0.35, 0.8):
        (tmp_path / 'cut.mcap').write_bytes(data[:int(share * len(data))])
        with open_bag(tmp_path / 'cut.mcap') as reader:
            part = replay(reader)
        assert part.comparison.verdict == 'yes' and part.comparison.different == 0
        n = len(part.estimates.rows)
        assert share - 0.15 < n / N < share + 0.05
        np.testing.assert_array_equal(part.estimates.rows, rows[:n])


def test_differences_behind_a_loss_are_explained_in_any_blocks(live, tmp_path, monkeypatch):
    """As many, whether decided on the way or at the end."""
    with open_bag(live[0]) as reader, BagWriter(tmp_path / 'hole') as writer:
        for topic, (kind, _) in reader.topics.items():
            writer.add_topic(topic, kind)
        for topic, log_ns, _, raw in reader.messages():
            if not (topic == '/joint_states' and 700 * MS <= log_ns - T0 < 705 * MS):
                writer.write(topic, log_ns, raw)
    found = []
    for size, wait in ((1 << 20, joint_input.MATCH_WAIT), (1, 300 * MS)):
        monkeypatch.setattr(read, 'BLOCK_BYTES', size)
        monkeypatch.setattr(joint_input, 'MATCH_WAIT', wait)
        monkeypatch.setattr('gearbox_monitor.recordings.replay.MATCH_WAIT', wait)
        with open_bag(tmp_path / 'hole') as reader:
            found.append(replay(reader).comparison)
    assert found[0] == found[1]
    assert found[0].lost_inputs == 5 and found[0].different == 0 < found[0].explained


@pytest.mark.parametrize('again', [False, True])
def test_pairing_on_the_way_equals_pairing_at_once(again):
    rng = np.random.default_rng(3)
    left, right = (np.sort(rng.choice(3000, 1500, replace=again)) for _ in range(2))
    i, j = match_stamps(left, right)
    assert (left[i] == right[j]).all() and len(i) == sum(
        min((left == s).sum(), (right == s).sum()) for s in np.unique(left))
    both, met = StampMatcher(1, 1), []
    for k in range(0, 3100, 100):
        # The right comes a little later.
        parts = [a[(a >= k - late) & (a < k + 100 - late)] for a, late in ((left, 0), (right, 20))]
        both.put(k, *((part, part[:, None].astype(float)) for part in parts))
        stamps, a, b = both.pairs()
        assert (a[:, 0] == stamps).all() and (b[:, 0] == stamps).all()
        met.append(stamps)
    lost = both.expired()
    np.testing.assert_array_equal(np.sort(np.concatenate(met)), np.sort(left[i]))
    assert len(lost[0]) == len(left) - len(i)


def test_tables_hold_the_same_numbers(live, tmp_path, capsys, monkeypatch):
    parquet = pytest.importorskip('pyarrow.parquet')
    monkeypatch.setattr(replay_output, 'ROW_GROUP', 1000)
    monkeypatch.setattr(read, 'BLOCK_BYTES', 50_000)
    bag, file = str(live[0]), tmp_path / 'out.parquet'
    for out in (file, tmp_path / 'out.csv'):
        assert main(['replay', bag, '--out', str(out), '--json']) == 0
        assert json.loads(capsys.readouterr().out)['replay_identical'] == 'yes'
    with open_bag(bag) as reader:
        estimates = replay(reader).estimates
    table = parquet.read_table(file)
    assert table.column_names == ['stamp_ns', *replay_output.COLUMNS] and table.num_rows == N - 2
    assert json.loads(table.schema.metadata[b'gearbox_monitor.parameters'])['filter'] == 'ekf'
    with open(tmp_path / 'out.csv', newline='') as stream:
        rows = list(csv.DictReader(stream))
    for name in table.column_names:
        column = table[name].to_numpy()
        np.testing.assert_array_equal(column, getattr(estimates, name))
        np.testing.assert_array_equal(column, np.array([row[name] for row in rows], column.dtype))
    assert main(['replay', bag, '--out', str(tmp_path / 'only.parquet'), '--estimates-only']) == 0
    told = capsys.readouterr().out
    assert 'identical    yes' in told and 'trust' not in told
    assert parquet.read_table(tmp_path / 'only.parquet').equals(table)


NUMBERS = np.array([np.nan, np.inf, -np.inf, -0.0, 0.0, 1e300, 5e-324, 1.0 / 3.0, 1e16, 2.0])
STAMPS = np.array([2 ** 63 - 1, -1, 0, *[1_700_000_000_123_456_789] * 7])
PLAYER = SimpleNamespace(estimator=SimpleNamespace(learned_curve=lambda: None))


def test_csv_has_all_bits_of_any_number(tmp_path):
    """In two parts, the second empty."""
    columns = {name: np.roll(NUMBERS, k) for k, name in enumerate(replay_output.COLUMNS)}
    table = replay_output.CsvTable(tmp_path / 'out', PLAYER)
    for end in (len(STAMPS), 0):
        table.write(SimpleNamespace(stamp_ns=STAMPS[:end], **{
            name: column[:end] for name, column in columns.items()}))
    table.close()
    with open(tmp_path / 'out', newline='') as stream:
        rows = list(csv.DictReader(stream))
    assert [int(row['stamp_ns']) for row in rows] == STAMPS.tolist()
    for name, column in columns.items():
        numbers = np.array([float(row[name]) for row in rows])
        np.testing.assert_array_equal(numbers.view(np.int64), column.view(np.int64))


@pytest.mark.parametrize('rows', [1, 100_000], ids=['at the end', 'at once'])
def test_csv_on_a_full_disk_is_refused_and_leaves_nothing(rows, tmp_path):
    (tmp_path / 'out.part').symlink_to('/dev/full')
    table = replay_output.CsvTable(tmp_path / 'out', PLAYER)
    with pytest.raises(InputError, match='out: No space left on device, expected a new, writable'):
        table.write(SimpleNamespace(stamp_ns=np.arange(rows), **{
            name: np.linspace(0.0, 1.0, rows) for name in replay_output.COLUMNS}))
        table.close()
    table.abandon()
    assert not list(tmp_path.iterdir())


def test_no_half_table_and_no_pyarrow(drive, tmp_path, capsys, monkeypatch):
    write(tmp_path / 'bag', wild(drive), 500)
    (tmp_path / 'p.yaml').write_text(
        '{estimator: {ros__parameters: {motor_joint: m, arm_joint: a}}}')
    options = ['replay', str(tmp_path / 'bag'), '--params', str(tmp_path / 'p.yaml')]

    def full(*_):
        raise OSError(28, 'No space left on device')
    parquet = ['out.parquet'] if find_spec('pyarrow') else []
    # Chunks as small as that fail before the first part.
    for name, chunk in (('out.csv', 0), ('out_bag', 0), ('out_bag', 1 << 20),
                        *((name, 0) for name in parquet)):
        with monkeypatch.context() as patch:
            patch.setattr(replay_output.CsvTable, '_write', full)
            patch.setattr(replay_output.ParquetTable, '_write', full)
            patch.setattr('gearbox_monitor.recordings.mcap_file.McapWriter.finish_chunk', full)
            patch.setattr('gearbox_monitor.recordings.write.CHUNK_BYTES', chunk)
            assert main([*options, '--out', str(tmp_path / name)]) == 2
        told = capsys.readouterr().err
        assert name in told and 'No space left' in told and told.count('\n') == 1
    monkeypatch.setitem(sys.modules, 'pyarrow', None)
    assert main([*options, '--out', str(tmp_path / 'out.parquet')]) == 2
    assert 'pyarrow is missing, expected' in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ['bag', 'p.yaml']


def test_blocks_stay_small(drive, tmp_path):
    write(tmp_path / 'bag', wild(drive), 100)
    with open_bag(tmp_path / 'bag') as reader:
        chunk = max(c.unpacked_size for c in reader._files[0].chunks)
        for size in (1, 100_000):
            read.BLOCK_BYTES, before = size, read.BLOCK_BYTES
            try:
                blocks = [len(block.data) for block in reader.blocks()]
            finally:
                read.BLOCK_BYTES = before
            assert max(blocks) <= size + chunk and len(blocks) >= 1_000_000 // max(size, chunk)


INTERPRETED = """
import hashlib, sys
from gearbox_monitor.recordings.read import open_bag
with open_bag(sys.argv[1]) as bag:
    states = bag.joint_states('/left/joint_states', ('m', 'a'))
    digest = hashlib.sha256()
    for column in (states.stamp_ns, states.log_ns, states.named, states.position, states.effort):
        digest.update(column.tobytes())
    print(digest.hexdigest())
"""


def test_interpreted_decoding_gives_the_same_bytes(drive, tmp_path):
    write(tmp_path / 'bag', list(wild(drive))[:1500], 300)
    told = [subprocess.run(
        [sys.executable, '-c', INTERPRETED, str(tmp_path / 'bag')], check=True, text=True,
        capture_output=True, env={**os.environ, 'GEARBOX_MONITOR_KERNELS': kernels,
                                  'PYTHONPATH': str(Path(__file__).parents[2])}).stdout
            for kernels in ('', 'python')]
    assert told[0] == told[1] != ''
