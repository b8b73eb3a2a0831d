# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bags: what is written is read back, by others too, and after any accident."""
from contextlib import suppress
import os
from pathlib import Path
import shutil
import subprocess
import sys
import threading
import time

import lz4.frame
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer as PeerWriter
from mcap_ros2.decoder import DecoderFactory
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import (
    CompressionFormat, CompressionMode, StoragePlugin, Writer as RosbagsWriter)
from rosbags.typesys import get_typestore, Stores
import yaml
import zstandard

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import load_yaml
from gearbox_monitor.recordings import cdr, mcap_file, storage
from gearbox_monitor.recordings.cdr import block_of
from gearbox_monitor.recordings.mcap_file import RecordFile
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.reading import open_recording
from gearbox_monitor.recordings.storage import BagTopic, qos_profile
from gearbox_monitor.recordings.write import BagWriter, recover, WriteError

STORE = get_typestore(Stores.ROS2_JAZZY)
JOINT_STATE = 'sensor_msgs/msg/JointState'
STRING = 'std_msgs/msg/String'
NAMES = ('motor', 'arm')
BASE_NS = 1_700_000_000_000_000_000


def joint_state(stamp_ns, names, position=(), velocity=(), effort=(), frame_id=''):
    types = STORE.types
    stamp = types['builtin_interfaces/msg/Time'](*map(int, divmod(stamp_ns, 10**9)))
    return types[JOINT_STATE](
        types['std_msgs/msg/Header'](stamp, frame_id), list(names),
        *(np.asarray(v, float) for v in (position, velocity, effort)))


def raw_joint_state(*args, **kwargs):
    return bytes(STORE.serialize_cdr(joint_state(*args, **kwargs), JOINT_STATE))


def write_bag(path, count=60, chunk=10, compression='zstd', step_ns=10**6):
    """Write `count` joint states and as many strings, a chunk every `chunk`; return the raws."""
    rng = np.random.default_rng(1)
    written = []
    with BagWriter(path, compression=compression, chunk_seconds=1e9) as bag:
        bag.add_metadata('gearbox_monitor', {'version': '1'})
        bag.add_topic('/joint_states', JOINT_STATE, [qos_profile(reliability='best_effort')])
        bag.add_topic('/text', STRING)
        for k in range(count):
            raw = raw_joint_state(BASE_NS + k * step_ns, NAMES, rng.normal(size=2),
                                  effort=rng.normal(size=2))
            written.append(('/joint_states', BASE_NS + k * step_ns, raw))
            bag.write(*written[-1], publish_ns=7)
            text = STORE.types[STRING](f'text {k}')
            written.append(('/text', BASE_NS + k * step_ns, bytes(STORE.serialize_cdr(
                text, STRING))))
            bag.write_message('/text', BASE_NS + k * step_ns, text)
            if k % chunk == chunk - 1:
                bag.flush()
    return written


def random_messages(topics):
    """Return 500 messages on all `topics` but the third, of any order; log times repeat."""
    rng = np.random.default_rng(5)
    return [(topics[rng.choice([0, 1, 3])], int(BASE_NS + rng.integers(1000)), k,
             rng.bytes(rng.choice([0, 8, 40, 300]))) for k in range(500)]


def read_all(bag):
    return [(topic, log_ns, raw) for topic, log_ns, _, raw in bag.messages()]


def expect_round_trip(tmp_path, compression):
    written = write_bag(tmp_path / 'bag', compression=compression)
    for path in (tmp_path / 'bag', tmp_path / 'bag' / 'bag_0.mcap'):
        with open_bag(path) as bag:
            assert not bag.truncated and not bag.notice
            assert bag.topics == {'/joint_states': (JOINT_STATE, 60), '/text': (STRING, 60)}
            assert bag.metadata['gearbox_monitor'] == {'version': '1'}
            assert (bag.start_ns, bag.end_ns) == (BASE_NS, BASE_NS + 59 * 10**6)
            assert read_all(bag) == written
            assert next(bag.messages(['/joint_states']))[2] == 7
            assert [bag.decode(STRING, raw).data for *_, raw in bag.messages({'/text'})] == [
                f'text {k}' for k in range(60)]


def test_round_trip(new_folder):
    for compression in ('none', 'lz4', 'zstd'):
        expect_round_trip(new_folder(), compression)


def test_other_readers_and_metadata(tmp_path):
    written = write_bag(tmp_path / 'bag')
    with AnyReader([tmp_path / 'bag']) as reader:
        assert [(c.topic, t, bytes(raw)) for c, t, raw in reader.messages()] == written
        connection = next(c for c in reader.connections if c.topic == '/joint_states')
        assert connection.digest == STORE.hash_rihs01(JOINT_STATE)
        assert connection.ext.offered_qos_profiles[0].reliability.name == 'BEST_EFFORT'
    with open(tmp_path / 'bag' / 'bag_0.mcap', 'rb') as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == 'ros2'
        decoded = [m for *_, m in reader.iter_decoded_messages(topics=['/joint_states'])]
    assert len(decoded) == 60 and decoded[0].name == list(NAMES)
    info = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())
    info = info['rosbag2_bagfile_information']
    assert (info['version'], info['ros_distro'], info['message_count']) == (9, 'jazzy', 120)
    assert info['custom_data'] == {'gearbox_monitor.version': '1'}
    topic = info['topics_with_message_count'][0]['topic_metadata']
    assert topic['offered_qos_profiles'][0]['deadline']['sec'] == 9223372036
    assert topic['type_description_hash'].startswith('RIHS01_')


@pytest.mark.parametrize('compression', ['none', 'zstd'])
def test_blocks_and_single_messages_give_the_same_bytes(tmp_path, monkeypatch, compression):
    """Messages of any size and order, a topic without any."""
    monkeypatch.setattr('gearbox_monitor.recordings.write.CHUNK_BYTES', 3000)
    topics = ('/a', '/b', '/never', '/c')
    messages = random_messages(topics)
    names = ('single', 'block', 'blocks')
    for name in names:
        with BagWriter(tmp_path / name / 'bag', compression, chunk_seconds=1e9) as bag:
            for topic in topics:
                bag.add_topic(topic, STRING)
            if name == 'single':
                for topic, log_ns, publish_ns, raw in messages:
                    bag.write(topic, log_ns, raw, publish_ns)
            else:
                cut = 123 if name == 'blocks' else 0
                for part in (messages[:cut], messages[cut:]):
                    bag.write_block(block_of(topics[::-1], part))
            assert bag.message_count == 500 and bag.topics['/never'] == (STRING, 0)
    assert len({(tmp_path / name / 'bag' / 'bag_0.mcap').read_bytes() for name in names}) == 1
    with open(tmp_path / 'block' / 'bag' / 'bag_0.mcap', 'rb') as file:
        reader = make_reader(file, validate_crcs=True)
        assert len(reader.get_summary().chunk_indexes) > 10
        assert [(channel.topic, message.log_time, message.publish_time, message.data)
                for _, channel, message in reader.iter_messages(log_time_order=False)] == messages


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_files_equal_those_of_the_mcap_package(tmp_path, monkeypatch, compression):
    """Byte by byte: checksums, indexes, statistics, metadata, sequence numbers, any encoding."""
    monkeypatch.setattr(mcap_file, 'ZSTD_LEVEL', 3)  # that of the package
    topics = ('/a', '/b', '/never', '/c')
    ours = mcap_file.McapWriter(tmp_path / 'ours.mcap', compression)
    with open(tmp_path / 'peer.mcap', 'wb') as file:
        peer = PeerWriter(file, chunk_size=1 << 30,
                          compression=getattr(CompressionType, compression.upper()),
                          index_types=IndexType.ALL ^ IndexType.ATTACHMENT)
        ours.start()
        peer.start('ros2', f'gearbox_monitor {__version__}')
        for writer in (ours, peer):
            writer.add_metadata('first', {'key': 'text'})
        schemas, channels = {}, {}
        for topic, kind in zip(topics, ('ros2msg', 'unheard_of', 'ros2msg', 'unheard_of')):
            ours.add_topic(BagTopic(topic, kind, [], '', b'definition',
                                    {'of': topic}, kind, 'json'))
            if kind not in schemas:
                schemas[kind] = peer.register_schema(kind, kind, b'definition')
            channels[topic] = peer.register_channel(topic, 'json', schemas[kind], {'of': topic})
        for writer in (ours, peer):
            writer.add_metadata('second', {})
        for k, (topic, log_ns, publish_ns, raw) in enumerate(random_messages(topics)):
            ours.write(topic, log_ns, raw, publish_ns, 7 * k)
            peer.add_message(channels[topic], log_ns, raw, publish_ns, 7 * k)
            if k % 40 == 39:
                ours.finish_chunk()
                peer.flush()
        ours.finish()
        peer.finish()
    assert (tmp_path / 'ours.mcap').read_bytes() == (tmp_path / 'peer.mcap').read_bytes()


@pytest.mark.parametrize('block', [False, True])
@pytest.mark.parametrize('max_seconds', [0.0, 40e-9])
def test_a_full_disk_loses_what_is_counted_as_lost(tmp_path, monkeypatch, block, max_seconds):
    """Wherever the space ends, within two topics and files; another bag follows each time."""
    monkeypatch.setattr('gearbox_monitor.recordings.write.CHUNK_BYTES', 1000)
    messages = [(('/a', '/b')[k % 3 == 0], k, k, k.to_bytes(60, 'little')) for k in range(60)]
    write_record = RecordFile.write

    def write(name, space):
        left = [space]

        def limited(file, data):
            if len(data) > left[0]:
                raise OSError(28, 'No space left on device')
            left[0] -= len(data)
            write_record(file, data)
        monkeypatch.setattr(RecordFile, 'write', limited)
        bag = BagWriter(tmp_path / name, 'none', chunk_seconds=1e9, max_seconds=max_seconds)
        try:
            for topic in ('/a', '/b'):
                bag.add_topic(topic, STRING)
            if block:
                bag.write_block(block_of(['/b', '/a'], messages))
            for topic, log_ns, publish_ns, raw in () if block else messages:
                with suppress(WriteError):
                    bag.write(topic, log_ns, raw, publish_ns)
            bag.close()
        except WriteError:
            bag.close()
        return bag

    whole = write('whole', 1 << 20).byte_count
    assert whole > 8000
    for space in range(100, whole, 211):
        bag = write('full', space)
        assert bag.error is not None and bag.message_count + bag.dropped == 60
        try:
            with open_bag(bag.path) as reader:
                assert reader.truncated and read_all(reader) == [
                    (topic, log_ns, raw) for topic, log_ns, _, raw in messages[:bag.message_count]]
        except InputError:
            assert not bag.message_count
        shutil.rmtree(bag.path)


def test_a_log_time_before_1970_is_refused(tmp_path):
    """Such as that of a damaged bag; what was written before stays whole."""
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/text', STRING)
        bag.write('/text', 5, b'')
        for write in (lambda: bag.write('/text', -1, b''), lambda: bag.write_block(
                block_of(['/text'], [('/text', 7, 7, b''), ('/text', -1, 7, b'')]))):
            with pytest.raises(InputError, match='bag: .* logged at -1 ns since 1970, expected 0'):
                write()
        assert bag.message_count == 1 and not bag.dropped
    with open_bag(tmp_path / 'bag') as reader:
        assert read_all(reader) == [('/text', 5, b'')]


def test_blocks_begin_a_new_file_where_messages_do(tmp_path):
    for name in ('single', 'block'):
        with BagWriter(tmp_path / name, chunk_seconds=1e9, max_seconds=20e-9) as bag:
            bag.add_topic('/text', STRING)
            messages = [('/text', k, k, bytes(9)) for k in range(50)]
            if name == 'block':
                bag.write_block(block_of(['/text'], messages))
            for topic, log_ns, publish_ns, raw in messages if name == 'single' else ():
                bag.write(topic, log_ns, raw, publish_ns)
        with open_bag(tmp_path / name) as reader:
            assert len(reader._files) == 3 and list(reader.messages()) == messages


def test_refuses_to_overwrite(tmp_path):
    write_bag(tmp_path / 'bag', 1)
    before = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    with pytest.raises(InputError, match='bag: exists already'):
        BagWriter(tmp_path / 'bag')
    assert (tmp_path / 'bag' / 'bag_0.mcap').read_bytes() == before
    with pytest.raises(InputError, match="'gzip' is unknown.*zstd"):
        BagWriter(tmp_path / 'other', compression='gzip')


def test_chunks_end_by_time(tmp_path):
    """What is older than the chunk time is on disk."""
    bag = BagWriter(tmp_path / 'bag', chunk_seconds=0.02)
    bag.add_topic('/text', STRING)
    bag.write('/text', 1, b'\0\1\0\0\1\0\0\0\0')
    time.sleep(0.03)
    bag.flush_if_due()
    shutil.copytree(tmp_path / 'bag', tmp_path / 'killed')
    with open_bag(tmp_path / 'killed') as killed:
        assert killed.truncated and 'cut off' in killed.notice
        assert killed.topics == {'/text': (STRING, 1)}
    bag.close()


@pytest.mark.parametrize('compression', [
    *(pytest.param(name, marks=pytest.mark.system) for name in ('none', 'lz4')), 'zstd'])
def test_cut_anywhere(tmp_path, compression):
    """A cut never raises but InputError and loses nothing before its chunk."""
    written = write_bag(tmp_path / 'bag', 30, 5, compression)
    data = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    with open_bag(tmp_path / 'bag') as bag:
        chunks = bag._files[0].chunks
        ends, begins = [c.end for c in chunks], [c.begin for c in chunks]
    cuts = [*range(0, len(data), 397), *range(begins[-1] - 60, len(data), 11)]
    path = tmp_path / 'cut.mcap'
    for cut in sorted(set(cuts)):
        path.write_bytes(data[:cut])
        try:
            with open_bag(path) as bag:
                assert bag.truncated and bag.notice
                found = read_all(bag)
                if bag.topics.get('/joint_states', (None, 0))[1]:
                    bag.joint_states('/joint_states', NAMES)
        except InputError:
            assert cut < 8
            continue
        whole = sum(end <= cut for end in ends)
        assert len(found) >= 10 * whole
        assert found == written[:len(found)]
        assert sum(count for _, count in bag.topics.values()) == len(found)


def test_cut_chunk_gives_what_it_has(tmp_path):
    write_bag(tmp_path / 'bag', compression='none', chunk=1000)
    with open_bag(tmp_path / 'bag') as bag:
        chunk = bag._files[0].chunks[0]
    data = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    (tmp_path / 'cut.mcap').write_bytes(data[:chunk.end - 1])
    with open_bag(tmp_path / 'cut.mcap') as bag:
        assert len(read_all(bag)) == 119


def expect_the_rest(tmp_path, compression, share):
    written = write_bag(tmp_path / 'bag', 600, 200, compression)
    path = tmp_path / 'bag' / 'bag_0.mcap'
    with open_bag(path) as bag:
        middle = bag._files[0].chunks[1]
    data = bytearray(path.read_bytes())
    begin = middle.begin + int(share * (middle.end - middle.begin))
    data[begin:middle.end] = bytes(middle.end - begin)
    path.write_bytes(data)
    with open_bag(path) as bag:
        kept = read_all(bag)
        assert 'zeros from byte' in bag.notice
    count = len(kept) - 800
    assert kept == written[:400 + count] + written[800:] and 0 <= count <= 400 * share
    if compression == 'none':  # the others unpack block by block
        assert count > 400 * share - 10
    assert recover(path, tmp_path / 'new').topics['/text'].recovered == (len(kept)) // 2


def test_zeros_over_the_end_of_a_chunk(new_folder):
    """A block that never reached the medium: what is whole before it is kept, and exact."""
    for share in (0.0, 0.5):
        for compression in ('none', 'lz4', 'zstd'):
            expect_the_rest(new_folder(), compression, share)


def test_bags_that_rosbag2_compressed_are_refused_with_the_command_that_unpacks(tmp_path):
    for mode, says in (('FILE', 'compressed by rosbag2, expected it unpacked: zstd -d '),
                       ('MESSAGE', 'each message by itself, .*: ros2 bag convert')):
        for plugin in ('MCAP', 'SQLITE3'):
            path = tmp_path / f'{mode}_{plugin}'
            writer = RosbagsWriter(path, version=9, storage_plugin=StoragePlugin[plugin])
            writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
            with writer:
                connection = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
                for k in range(50):
                    writer.write(connection, BASE_NS + k, raw_joint_state(
                        BASE_NS + k, NAMES, [k, -k]))
            with pytest.raises(InputError, match=says):
                open_bag(path)
            for packed in path.glob('*.zstd'):
                with pytest.raises(InputError, match=says):
                    open_recording(packed)
                packed.with_suffix('').write_bytes(
                    zstandard.ZstdDecompressor().decompressobj().decompress(packed.read_bytes()))
                with open_bag(path) as bag:
                    assert bag.count('/joint_states') == 50
        if mode == 'MESSAGE':
            with pytest.raises(InputError, match=says):
                recover(tmp_path / f'{mode}_MCAP', tmp_path / 'new')


@pytest.mark.parametrize('compression', ['lz4', 'zstd'])
def test_what_unpacks_is_bounded_by_what_is_packed(compression):
    data = bytes(1 << 26)
    packed = lz4.frame.compress(data) if compression == 'lz4' else \
        zstandard.ZstdCompressor().compress(data)
    for stated in (1 << 20, 1 << 26, 1 << 40):
        out, _ = storage.unpack(packed, compression, stated)
        assert len(out) == min(stated, storage.unpacked_limit(len(packed)), len(data))


def test_pipes_are_refused_not_waited_for(tmp_path):
    (tmp_path / 'bag').mkdir()
    for name in ('bag_0.mcap', 'x.db3', 'x.yaml', 'x.csv'):
        os.mkfifo(tmp_path / 'bag' / name)
    for reader, path in ((open_bag, ''), (open_bag, 'bag_0.mcap'), (open_bag, 'x.db3'),
                         (load_yaml, 'x.yaml'), (open_recording, 'x.csv')):
        with pytest.raises(InputError, match='pipe|one kind'):
            reader(tmp_path / 'bag' / path)


def test_damage_is_told_and_bounded(tmp_path):
    """Random flipped bytes: no crash, no huge allocation, no silent loss."""
    write_bag(tmp_path / 'bag')
    data = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    rng = np.random.default_rng(2)
    for _ in range(300):
        broken = bytearray(data)
        for at in rng.integers(8, len(data), 3):
            broken[at] = rng.integers(256)
        (tmp_path / 'x.mcap').write_bytes(broken)
        try:
            with open_bag(tmp_path / 'x.mcap') as bag:
                read_all(bag)
                bag.joint_states('/joint_states', NAMES)
        except InputError:
            pass
    middle = data.index(b'zstd') + 40
    (tmp_path / 'x.mcap').write_bytes(data[:middle] + b'\xff\xff' + data[middle + 2:])
    with open_bag(tmp_path / 'x.mcap') as bag:
        assert len(read_all(bag)) == 100 and 'damaged chunk' in bag.notice


def test_bad_paths(tmp_path):
    (tmp_path / 'empty.mcap').touch()
    (tmp_path / 'text.mcap').write_text('not a recording')
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'x.db3').write_text('not a database')
    write_bag(tmp_path / 'gone', 1)
    (tmp_path / 'gone' / 'gone_0.mcap').unlink()
    for name, message in {'empty.mcap': 'empty', 'text.mcap': 'not an MCAP file',
                          'folder': 'holds no .mcap', 'nowhere': 'no such file',
                          'x.db3': 'cannot read', 'gone': 'gone_0.mcap: missing'}.items():
        with pytest.raises(InputError, match=message) as error:
            open_bag(tmp_path / name)
        assert name in str(error.value) and '\n' not in str(error.value)


def test_split_and_unordered_files(tmp_path):
    """Several files are one recording in log order; equal times keep the file order."""
    with BagWriter(tmp_path / 'bag', chunk_seconds=1e9) as bag:
        bag.add_topic('/text', STRING)
        for k, log_ns in enumerate([30, 10, 20, 20, 5, 40, 20]):
            bag.write('/text', log_ns, bytes([k]))
            if k % 3 == 2:
                bag.flush()
    write_bag(tmp_path / 'other', 3)
    shutil.copy(tmp_path / 'other' / 'other_0.mcap', tmp_path / 'bag' / 'bag_1.mcap')
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    with open_bag(tmp_path / 'bag') as bag:
        assert [raw[0] for *_, raw in bag.messages(['/text'])][:7] == [4, 1, 2, 3, 6, 0, 5]
        assert bag.topics['/text'] == (STRING, 10)


def test_sqlite_bag(tmp_path):
    with RosbagsWriter(tmp_path / 'old', version=9,
                       storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection('/joint_states', JOINT_STATE, typestore=STORE)
        for k in range(5):
            writer.write(connection, BASE_NS + k, raw_joint_state(BASE_NS + k, NAMES, [k, -k]))
    with open_bag(tmp_path / 'old') as bag:
        assert (bag.start_ns, bag.end_ns) == (BASE_NS, BASE_NS + 4)
        states = bag.joint_states('/joint_states', ['arm'])
        assert states.position[:, 0].tolist() == [0, -1, -2, -3, -4]
        assert np.isnan(states.effort).all()
    database = tmp_path / 'old' / 'old.db3'
    database.write_bytes(database.read_bytes()[:5000] + bytes(5000))
    with pytest.raises(InputError, match='old.db3: cannot read'):
        with open_bag(tmp_path / 'old') as bag:
            list(bag.messages())


def test_type_outside_the_store(tmp_path):
    definition = ('float64 tau\nmy_msgs/Inner[] inner\n' + '=' * 80
                  + '\nMSG: my_msgs/Inner\nint8 a\n')
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/own', 'my_msgs/msg/Own', msgdef=definition)
        bag.write('/own', 1, b'\0\1\0\0' + np.float64(2.5).tobytes() + b'\1\0\0\0\7')
        bag.add_topic('/unknown', 'my_msgs/msg/Unknown', msgdef='no[ definition')
        bag.write('/unknown', 2, b'')
        bag.add_topic('/untold', 'my_msgs/msg/Untold')
        bag.add_topic('/wide', 'my_msgs/msg/Wide', msgdef='wstring text')
        for topic in ('/untold', '/wide'):
            bag.write(topic, 3, b'')
    with open_bag(tmp_path / 'bag') as bag:
        assert len(bag.topics) == 4
        with pytest.raises(InputError, match='no definition of the type my_msgs/msg/Untold'):
            bag.decode('my_msgs/msg/Untold', b'')
        message = bag.decode('my_msgs/msg/Own', next(bag.messages(['/own']))[3])
        assert message.tau == 2.5 and message.inner[0].a == 7
        with pytest.raises(InputError, match='cannot decode .* my_msgs/msg/Unknown'):
            bag.decode('my_msgs/msg/Unknown', b'')
        with pytest.raises(InputError, match='cannot decode'):
            bag.decode(JOINT_STATE, b'\0\1\0\0\1')


def slow_joint_states(raws, names):
    """Independent decoding, message by message."""
    result = []
    for raw in raws:
        message = STORE.deserialize_cdr(raw, JOINT_STATE)
        row = []
        for values in (message.position, message.velocity, message.effort):
            known = dict(zip(message.name, values))
            row.append([known.get(name, np.nan) for name in names])
        result.append(row)
    return np.array(result).transpose(1, 0, 2)


def test_joint_states_equal_slow_decoding(tmp_path):
    rng = np.random.default_rng(3)
    shapes = [
        lambda t: raw_joint_state(t, NAMES, rng.normal(size=2), rng.normal(size=2), [1, np.nan]),
        lambda t: raw_joint_state(t, NAMES[::-1], rng.normal(size=2), [], rng.normal(size=2)),
        lambda t: raw_joint_state(t, NAMES, [np.nan, 1.0]),
        lambda t: raw_joint_state(t, ['x', 'motor'], rng.normal(size=2), frame_id='base'),
        lambda t: raw_joint_state(t, ['m', 'armmm'], rng.normal(size=2)),
        lambda t: raw_joint_state(t, [], frame_id='odd'),
        lambda t: raw_joint_state(t, ['arm'], [0.5], effort=[2.0, 3.0]),
        lambda t: raw_joint_state(t, NAMES, rng.normal(size=2)) + b'\xa5\x5a\0',
        lambda t: bytes(STORE.serialize_cdr(
            joint_state(t, NAMES, [1, 2]), JOINT_STATE, little_endian=False)),
    ]
    order = np.concatenate([np.repeat(rng.permutation(len(shapes)), 40),
                            rng.integers(len(shapes), size=300)])
    stamps = BASE_NS + np.arange(len(order)) * 1_000_003
    raws = [shapes[k](int(t)) for k, t in zip(order, stamps)]
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/j', JOINT_STATE)
        bag.add_topic('/text', STRING)
        for k, raw in enumerate(raws):
            bag.write('/j', k, raw)
    with open_bag(tmp_path / 'bag') as bag:
        states = bag.joint_states('/j', ['arm', 'motor'])
        expected = slow_joint_states(raws, ['arm', 'motor'])
        np.testing.assert_array_equal([states.position, states.velocity, states.effort], expected)
        np.testing.assert_array_equal(states.stamp_ns, stamps)
        assert states.named.shape == (len(raws), 2)
        assert (states.named | np.isnan(states.position)).all()
        np.testing.assert_array_equal(states.log_ns, np.arange(len(raws)))
        assert set(bag.joint_names('/j')) == {'motor', 'arm', 'x', 'm', 'armmm'}
        with pytest.raises(InputError, match="no joint 'elbow', it has .*motor"):
            bag.joint_states('/j', ['motor', 'elbow'])
        with pytest.raises(InputError, match='no topic /nope, the bag has /j, /text'):
            bag.joint_states('/nope', ['motor'])
        with pytest.raises(InputError, match='/text has type std_msgs/msg/String, expected'):
            bag.joint_states('/text', ['motor'])


FRAMES = [(), ('m',), NAMES, ('a', 'bcd', 'efghi')]


def test_encoder_equals_rosbags():
    for names in FRAMES:
        for frame_id in ('', 'abc', 'base_link'):
            rng = np.random.default_rng(4)
            stamps = np.array([0, 1, BASE_NS, BASE_NS + 999_999_999, -1])
            fields = rng.normal(size=(3, len(stamps), len(names)))
            fields[0, 0] = np.nan
            for used in ((0, 1, 2), (0,), (0, 2), (2,), ()):
                given = [fields[k] if k in used else None for k in range(3)]
                encoded = cdr.encode_joint_states(stamps, names, *given, frame_id=frame_id)
                assert encoded == [raw_joint_state(
                    int(t), names, *(fields[k][row] if k in used else () for k in range(3)),
                    frame_id=frame_id) for row, t in enumerate(stamps)]


FULL_DISK = """
import resource, sys
from gearbox_monitor.recordings.write import BagWriter, WriteError
limit = 50_000
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
bag = BagWriter(sys.argv[1], compression='none', chunk_seconds=1e9)
bag.add_topic('/text', 'std_msgs/msg/String')
errors, flushed = [], 0
for k in range(3000):
    try:
        bag.write('/text', k, k.to_bytes(100, 'little'))
        if k % 20 == 19:
            bag.flush()
            flushed = k + 1 if bag.error is None else flushed
    except WriteError as error:
        errors.append(str(error))
bag.close()
assert len(errors) == 1 and 'cannot write: File too large' in errors[0], errors
assert bag.message_count == flushed and bag.dropped == 3000 - flushed, (bag.dropped, flushed)
print(flushed)
"""


def test_full_disk_keeps_what_is_there(tmp_path):
    done = subprocess.run([sys.executable, '-c', FULL_DISK, str(tmp_path / 'bag')], check=True,
                          capture_output=True, text=True,
                          # A limit cuts compiled modules without a word, too.
                          env={**os.environ, 'PYTHONPATH': str(Path(__file__).parents[2]),
                               'PYTHONDONTWRITEBYTECODE': '1'})
    with open_bag(tmp_path / 'bag') as bag:
        assert bag.truncated
        found = [int.from_bytes(raw, 'little') for *_, raw in bag.messages()]
    assert found == list(range(int(done.stdout))) and len(found) > 200


def split_bag(path, **limits):
    """Write 300 joint states and texts, 1 ms apart, in files as the `limits` say; return them."""
    written = []
    with BagWriter(path, chunk_seconds=1e9, **limits) as bag:
        bag.add_metadata('gearbox_monitor', {'version': '1'})
        bag.add_topic('/joint_states', JOINT_STATE, [qos_profile(reliability='best_effort')])
        for k in range(300):
            written.append(('/joint_states', BASE_NS + k * 10**6, raw_joint_state(k, NAMES)))
            bag.write(*written[-1])
            if k % 10 == 9:
                bag.flush()
            if k == 100:
                bag.add_topic('/late', STRING)
            if k > 100:
                written.append(('/late', BASE_NS + k * 10**6, b'\0\1\0\0\1\0\0\0\0'))
                bag.write(*written[-1])
    return written


SPLITS = [
    ({'max_seconds': 0.1}, 3), ({'max_seconds': 0.0895}, 4), ({'max_size': 6_000}, 0)]


def expect_parts(tmp_path, limits, files):
    written = split_bag(tmp_path / 'bag', **limits)
    paths = sorted((tmp_path / 'bag').glob('*.mcap'), key=lambda p: int(p.stem.split('_')[-1]))
    if files:
        assert len(paths) == files
    else:  # index and summary come on top
        assert len(paths) > 3 and all(p.stat().st_size < 6_000 + 5_000 for p in paths)
    with open_bag(tmp_path / 'bag') as bag:
        assert not bag.truncated and read_all(bag) == written
        assert len(bag.joint_states('/joint_states', NAMES).stamp_ns) == 300
    with AnyReader([tmp_path / 'bag']) as reader:
        assert [(c.topic, t, bytes(raw)) for c, t, raw in reader.messages()] == written
        assert reader.message_count == len(written)
    info = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())
    info = info['rosbag2_bagfile_information']
    assert info['relative_file_paths'] == [p.name for p in paths] == [
        file['path'] for file in info['files']]
    assert sum(file['message_count'] for file in info['files']) == len(written)
    assert info['duration']['nanoseconds'] == 299 * 10**6
    begins = [file['starting_time']['nanoseconds_since_epoch'] for file in info['files']]
    for path, begin in zip(paths, begins):
        with open_bag(path) as bag:
            assert bag.start_ns == begin and not bag.truncated
            assert bag.metadata['gearbox_monitor'] == {'version': '1'}
    (tmp_path / 'bag' / 'metadata.yaml').unlink()  # killed before it was written
    paths[-1].write_bytes(paths[-1].read_bytes()[:-300])
    with open_bag(tmp_path / 'bag') as bag:
        assert bag.truncated and read_all(bag) == written
    recovery = recover(tmp_path / 'bag', tmp_path / 'whole')
    assert recovery.cut and recovery.lost_s == 0.0
    with open_bag(tmp_path / 'whole') as bag:
        assert not bag.truncated and read_all(bag) == written
    with AnyReader([tmp_path / 'whole']) as reader:
        assert [(c.topic, t, bytes(raw)) for c, t, raw in reader.messages()] == written


def test_split(new_folder):
    """All files together are one bag, for others, too; each is whole by itself."""
    for limits, files in SPLITS:
        expect_parts(new_folder(), limits, files)


def test_a_removed_file_is_not_given_up_for_the_next(tmp_path):
    """What was recorded before and since stays to be saved; the message says from where."""
    bag = BagWriter(tmp_path / 'bag', chunk_seconds=0.0, max_seconds=0.1)
    bag.add_topic('/joint_states', JOINT_STATE)
    for k in range(300):
        if k == 50:
            assert bag.removed == ''
            shutil.rmtree(tmp_path / 'bag')
        bag.write('/joint_states', BASE_NS + k * 10**6, raw_joint_state(k, NAMES))
    assert 'bag_0.mcap: removed or moved' in bag.removed
    words = bag.removed.split()
    held = words[words.index('cp') + 1]
    shutil.copyfile(held, tmp_path / 'saved.mcap')
    with pytest.raises(WriteError):
        bag.close()
    with open_bag(tmp_path / 'saved.mcap') as saved:
        stamps = saved.joint_states('/joint_states', NAMES).stamp_ns
    assert len(stamps) == 300


def test_a_medium_that_fails_is_told_and_a_slow_one_not_waited_for(tmp_path, monkeypatch):
    """Files are brought to the medium by another thread; its error ends the recording."""
    writer, synced, gate = threading.get_ident(), [], threading.Event()

    def slow(handle):
        synced.append(threading.get_ident())
        gate.wait(20)
    monkeypatch.setattr(os, 'fdatasync', slow)
    bag = BagWriter(tmp_path / 'bag', chunk_seconds=0.0, sync_seconds=0.01, max_seconds=0.1)
    bag.add_topic('/joint_states', JOINT_STATE)
    for k in range(300):  # three files, none of them waited for
        bag.write('/joint_states', BASE_NS + k * 10**6, raw_joint_state(k, NAMES))
    assert writer not in synced and len(list((tmp_path / 'bag').glob('*.mcap'))) == 3
    gate.set()
    bag.close()
    with open_bag(tmp_path / 'bag') as whole:
        assert not whole.truncated and whole.topics['/joint_states'][1] == 300
    assert len(synced) >= 3

    def broken(handle):
        raise OSError(5, 'Input/output error')
    monkeypatch.setattr(os, 'fdatasync', broken)
    bag = BagWriter(tmp_path / 'lost', chunk_seconds=0.0, sync_seconds=60.0)
    bag.add_topic('/joint_states', JOINT_STATE)
    bag.write('/joint_states', BASE_NS, raw_joint_state(0, NAMES))
    with pytest.raises(WriteError, match='Input/output error; the 0 bytes written before'):
        bag.close()
    assert not (tmp_path / 'lost' / 'metadata.yaml').exists()
