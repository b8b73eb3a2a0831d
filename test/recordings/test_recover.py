# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recovered bags: nothing that was whole is lost, nothing is changed, success is never claimed."""
import json
import os
from pathlib import Path
import re
import resource
import shutil
import subprocess
import sys

from mcap.reader import make_reader
import pytest
from rosbags.highlevel import AnyReader
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings import write as module
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.storage import qos_profile
from gearbox_monitor.recordings.write import BagWriter, recover

JOINT_STATE = 'sensor_msgs/msg/JointState'
BASE_NS = 1_700_000_000_000_000_000
MS = 1_000_000
DIFFER = ('bag',)  # of two replays


def write(path, count=20, chunk=5, compression='zstd', first=0):
    """Write `count` joint states on two topics, 10 ms apart, `chunk` a chunk; return them."""
    written = []
    with BagWriter(path, compression=compression, chunk_seconds=1e9) as bag:
        bag.add_metadata('gearbox_monitor', {'version': '1'})
        bag.add_topic('/a', JOINT_STATE, [qos_profile(reliability='best_effort')])
        bag.add_topic('/b', JOINT_STATE)
        for k in range(first, first + count):
            (raw,) = encode_joint_states([k], ['motor'], [[0.1 * k]])
            for topic in '/a', '/b':
                written.append((topic, BASE_NS + 10 * k * MS, BASE_NS + k, 3 * k, raw))
                bag.write(topic, BASE_NS + 10 * k * MS, raw, BASE_NS + k, 3 * k)
            if k % chunk == chunk - 1:
                bag.flush()
    return written


def read(folder):
    """Return what mcap's own reader finds through the index: (topic, times, sequence, bytes)."""
    (path,) = folder.glob('*.mcap')
    with open(path, 'rb') as file:
        return [(channel.topic, m.log_time, m.publish_time, m.sequence, m.data)
                for _, channel, m in make_reader(file, validate_crcs=True).iter_messages()]


def chunks_of(path):
    with open_bag(path) as bag:
        return bag._files[0].chunks


@pytest.mark.parametrize('compression, every', [
    ('none', 29), ('lz4', 29), ('zstd', 13), pytest.param('zstd', 1, marks=pytest.mark.system)])
def test_recovered_wherever_it_was_cut(tmp_path, monkeypatch, compression, every):
    """All of the whole chunks, and a prefix of what was written; times and figures agree."""
    for name in 'fsync', 'fdatasync':  # hundreds of bags need not reach the disk
        monkeypatch.setattr(os, name, lambda handle: None)
    written = write(tmp_path / 'bag', 9, 3, compression)
    data = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    chunks = chunks_of(tmp_path / 'bag')
    behind = chunks[-1].end + 60  # amid its index
    cut_path, out = tmp_path / 'cut.mcap', tmp_path / 'out'
    for cut in (*range(chunks[-2].begin - 60, behind, every), *range(behind, len(data), 211)):
        cut_path.write_bytes(data[:cut])
        found = recover(cut_path, out)
        messages = read(out)
        assert len(messages) >= 6 * sum(chunk.end <= cut for chunk in chunks)
        assert messages == written[:len(messages)]
        kept = sum(topic.recovered for topic in found.topics.values())
        assert found.written == out and found.cut and kept == len(messages)
        told = BASE_NS + 10 * (5 if cut < chunks[-2].end else 8) * MS
        assert found.lost_s in (0.0, pytest.approx((told - messages[-1][1]) * 1e-9))
        shutil.rmtree(out)
    assert cut_path.read_bytes() == data[:cut] and sorted(tmp_path.iterdir()) == [
        tmp_path / 'bag', cut_path]


def test_recovered_bag_replays_and_others_read_it(tmp_path, capsys):
    """A split bag of a drive: as many estimates as samples are left; the old one is untouched."""
    write_example_bag(tmp_path / 'one', DriveModel(), ExampleMotion(4.0, 200.0))
    with open_bag(tmp_path / 'one') as one, BagWriter(tmp_path / 'bag', max_seconds=1.0) as bag:
        for topic, (msgtype, _) in one.topics.items():
            bag.add_topic(topic, msgtype)
        for topic, log_ns, publish_ns, raw in one.messages():
            bag.write(topic, log_ns, raw, publish_ns)
    replayed = []
    for name in 'one', 'bag':
        assert main(['replay', str(tmp_path / name), '--json']) == 0
        replayed.append(json.loads(capsys.readouterr().out))
    assert replayed[0]['samples'] == 800
    assert {**replayed[0], **dict.fromkeys(DIFFER)} == {**replayed[1], **dict.fromkeys(DIFFER)}
    path = tmp_path / 'bag' / 'bag_2.mcap'
    path.write_bytes(path.read_bytes()[:int(0.3 * path.stat().st_size)])
    before = {file.name: file.read_bytes() for file in (tmp_path / 'bag').iterdir()}
    assert main(['recover', str(tmp_path / 'bag'), '--json']) == 0
    data = json.loads(capsys.readouterr().out)
    assert {file.name: file.read_bytes() for file in (tmp_path / 'bag').iterdir()} == before
    out = tmp_path / 'bag_recovered'
    (row,) = (row for row in data['topics'] if row['topic'] == '/joint_states')
    kept, lost = row['kept']['messages'], row['lost']['messages']
    assert kept > 100 and lost > 100 and kept + lost == 800
    (tmp_path / 'bag' / 'metadata.yaml').unlink()  # then only the time is known
    found = recover(tmp_path / 'bag', tmp_path / 'again')
    assert found.topics['/joint_states'].lost == 0
    assert found.lost_s == pytest.approx(1.0, abs=0.01)
    with AnyReader([out]) as reader:
        assert [reader.topics[t].msgcount for t in sorted(reader.topics)] == [
            row['kept']['messages'] for row in data['topics']]
        assert sum(1 for _ in reader.messages()) == data['kept']['messages']
    assert main(['replay', str(out), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['samples'] == kept
    assert main(['recover', str(out)]) == 0
    assert 'complete' in capsys.readouterr().out
    assert not (tmp_path / 'bag_recovered_recovered').exists()


def test_damage_inside_and_definitions(tmp_path):
    """The messages of a damaged chunk are counted, exactly; the rest keeps all that it had."""
    written = write(tmp_path / 'bag')
    path = tmp_path / 'bag' / 'bag_0.mcap'
    chunk = chunks_of(tmp_path / 'bag')[1]
    data = bytearray(path.read_bytes())
    data[chunk.begin + 30:chunk.begin + 34] = b'\xff\0\xff\0'
    path.write_bytes(data)
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    found = recover(tmp_path / 'bag', tmp_path / 'out')
    assert read(tmp_path / 'out') == written[:10] + written[20:]
    assert [(t.recovered, t.lost) for t in found.topics.values()] == [(15, 5)] * 2
    assert found.lost_s == pytest.approx(0.05) and not found.cut
    assert 'metadata.yaml: missing' in found.notes[0] and 'chunk at byte' in found.notes[1]
    with open_bag(tmp_path / 'out') as bag:
        assert bag.metadata['gearbox_monitor'] == {'version': '1'}
        assert bag.metadata[module.RECOVERED]['lost_messages'] == '10'
    info = yaml.safe_load((tmp_path / 'out' / 'metadata.yaml').read_text())
    topics = info['rosbag2_bagfile_information']['topics_with_message_count']
    assert [t['topic_metadata']['offered_qos_profiles'][0]['reliability'] for t in topics] == [
        'best_effort', 'reliable']


def test_split_bag_with_missing_and_empty_files(tmp_path):
    """What metadata.yaml does not name is taken, too; what it names and is gone is told."""
    parts = [write(tmp_path / f'part{k}', first=20 * k) for k in range(3)]
    bag = tmp_path / 'bag'
    bag.mkdir()
    for k in range(3):
        shutil.copy(tmp_path / f'part{k}' / f'part{k}_0.mcap', bag / f'bag_{k}.mcap')
    (bag / 'bag_3.mcap').touch()  # killed just after it was begun
    with open_bag(bag) as reader:
        assert reader.truncated and 'bag_3.mcap: the file is empty' in reader.notice
        assert len(list(reader.messages())) == 120
    info = yaml.safe_load((tmp_path / 'part1' / 'metadata.yaml').read_text())
    about = info['rosbag2_bagfile_information']
    about['relative_file_paths'] = [about['files'][0]['path']] = ['bag_1.mcap']
    about['files'] = [{**about['files'][0], 'path': 'bag_1.mcap'}]
    (bag / 'metadata.yaml').write_text(yaml.safe_dump(info))
    (bag / 'bag_1.mcap').unlink()
    found = recover(bag, tmp_path / 'out')
    assert read(tmp_path / 'out') == parts[0] + parts[2]
    assert found.lost_s == pytest.approx(0.19)
    assert [note.split('/')[-1] for note in found.notes] == [
        'bag_1.mcap: missing',
        'bag_3.mcap: the file is empty, expected an MCAP recording']


def test_bad_input_leaves_nothing(tmp_path, monkeypatch, capsys):
    write(tmp_path / 'bag')
    data = (tmp_path / 'bag' / 'bag_0.mcap').read_bytes()
    (tmp_path / 'cut.mcap').write_bytes(data[:-100])
    (tmp_path / 'head.mcap').write_bytes(data[:60])
    (tmp_path / 'text.mcap').write_text('no recording')
    (tmp_path / 'old.db3').touch()
    (tmp_path / 'there').mkdir()
    before = sorted(tmp_path.iterdir())
    for arguments, message in (
            (['nowhere'], 'nowhere: no such file'), (['text.mcap'], 'not an MCAP file'),
            (['head.mcap'], 'head.mcap: no whole message remains'),
            (['old.db3'], 'old.db3: holds no MCAP file'), (['there'], 'there: holds no MCAP'),
            (['cut.mcap', '--out', 'there'], 'there: exists already'),
            (['cut.mcap', '--out', ''], "--out: '' is empty"),
            (['cut.mcap', '--out', 'text.mcap/x'], 'x: cannot create the bag: ')):
        monkeypatch.chdir(tmp_path)
        assert main(['recover', *arguments]) == 2
        told = capsys.readouterr().err
        assert message in told and told.count('\n') == 1
    # A full disk while it writes.
    done = subprocess.run(
        [sys.executable, '-m', 'gearbox_monitor', 'recover', 'cut.mcap'], check=False,
        capture_output=True, text=True, cwd=tmp_path,
        # A limit cuts compiled modules without a word, too.
        env={'PYTHONPATH': str(Path(__file__).parents[2]), 'PYTHONDONTWRITEBYTECODE': '1',
             'GEARBOX_MONITOR_KERNELS': 'python'},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1500, 1500)))
    assert done.returncode == 2 and done.stderr.count('\n') == 1, done.stderr
    assert 'cut_recovered_0.mcap: cannot write: File too large; ' in done.stderr
    assert sorted(tmp_path.iterdir()) == before


def test_success_is_only_claimed_for_the_same_messages(tmp_path, monkeypatch):
    """A writer that loses or changes one message is found out."""
    write(tmp_path / 'bag')
    (tmp_path / 'bag' / 'metadata.yaml').unlink()

    class Loses(BagWriter):
        def write(self, topic, log_ns, raw, publish_ns, sequence):
            if sequence != 30 or topic != '/b':
                super().write(topic, log_ns, raw, publish_ns, sequence)

    class Changes(BagWriter):
        def write(self, topic, log_ns, raw, publish_ns, sequence):
            super().write(topic, log_ns, raw, publish_ns + (sequence == 30), sequence)

    for writer in (Loses, Changes):
        monkeypatch.setattr(module, 'BagWriter', writer)
        with pytest.raises(InputError, match='out: the written bag differs when read back'):
            recover(tmp_path / 'bag', tmp_path / 'out')
        assert list(tmp_path.iterdir()) == [tmp_path / 'bag']


def test_metadata_that_cannot_be_true_counts_for_nothing(tmp_path):
    write(tmp_path / 'bag')
    path = tmp_path / 'bag' / 'metadata.yaml'
    good = path.read_text()
    for text in (good.replace('message_count: 20', 'message_count: -20'),
                 good.replace('message_count: 20', 'message_count: 1e300'),
                 good.replace('message_count: 20', 'message_count: many'),
                 re.sub('nanoseconds: [0-9]+', 'nanoseconds: -5', good),
                 re.sub('(?s)files:.*custom', 'files: [1, a]\\n  custom', good)):
        path.write_text(text)
        recovery = recover(tmp_path / 'bag', tmp_path / 'new')
        assert all(t.recovered == 20 and t.lost == 0 for t in recovery.topics.values())
        assert recovery.lost_s == 0.0 and 'metadata.yaml: missing or damaged' in recovery.notes[0]
        shutil.rmtree(tmp_path / 'new')
