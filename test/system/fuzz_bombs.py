# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Bombs: small files that ask a reader for gigabytes, minutes or a wait without an end.

Each is read by whole commands in a child process whose memory, CPU time and size of written files
the operating system limits. A command ends with exit code 0 to 3 and without a traceback.
"""
from collections.abc import Callable
import contextlib
from dataclasses import dataclass
import io
import math
import multiprocessing
import os
from pathlib import Path
import resource
import shutil
import signal
import sqlite3
import struct
import sys
import tempfile
import traceback
import zipfile
import zlib

from fuzz_damage import LAUGHS, MAGIC
import lz4.frame
from mcap.writer import CompressionType, Writer
import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.write import BagWriter

MODEL = str(config_path('drive.yaml'))
MEMORY = 1 << 30     # bytes of address space that a command may add
CPU = 60             # s
FILE_SIZE = 1 << 28  # bytes of a file that a command may write
GUARD = 120          # s after which a command that only waits is ended
T0 = 1_700_000_000 * 10 ** 9
JOINTS = ('motor', 'arm')
TYPE = 'sensor_msgs/msg/JointState'
TYPES = get_typestore(Stores.ROS2_JAZZY).types
MAPPING = """time: {{rate: 1000.0}}
signals:
  motor_position: {{column: {first}}}
  motor_effort: {{column: {second}}}
"""


@dataclass(frozen=True)
class Bomb:
    """make(folder) writes the files; `commands` read them, {0} is the folder."""

    name: str
    make: Callable[[Path], None]
    commands: tuple[str, ...]


@dataclass(frozen=True)
class Ended:
    """How a command ended; code: its exit code (negative: a signal), seconds: of CPU."""

    code: int
    seconds: float
    added: int    # bytes of resident memory
    written: int  # bytes left in the folder of temporary files
    text: str     # of standard error

    @property
    def wrong(self) -> str:
        """What is wrong in a few words, '' if nothing is."""
        if self.code not in (0, 1, 2, 3):
            return f'exit code {self.code}: {self.text.strip()[-200:]!r}'
        if 'Traceback' in self.text:
            return 'a traceback'
        lines = [line for line in self.text.splitlines() if line.startswith('gearbox_monitor ')]
        if self.code == 2 and len(lines) != 1 and 'error:' not in self.text:
            return f'{len(lines)} lines instead of one'
        return f'{self.written} bytes of temporary files left' if self.written else ''


def run_limited(argv, folder):
    """Return how the command line `argv` ended in a child process with limits."""
    output = folder / 'stderr.txt'
    temporary = folder / 'tmp'
    temporary.mkdir(exist_ok=True)
    ours, theirs = multiprocessing.get_context('fork').Pipe(False)
    child = multiprocessing.get_context('fork').Process(
        target=_child, args=(argv, output, temporary, theirs))
    child.start()
    theirs.close()
    child.join(GUARD)
    child.kill()
    child.join()
    seconds, added = math.inf, 0
    with contextlib.suppress(EOFError):
        seconds, added = ours.recv()
    left = sum(f.stat().st_size for f in temporary.rglob('*') if f.is_file())
    shutil.rmtree(temporary)
    return Ended(child.exitcode, seconds, added, left,
                 output.read_text(errors='replace') if output.exists() else '')


def _child(argv, output, temporary, pipe):
    from benchmarks.memory import forget_peak, peak_bytes
    with open(output, 'wb') as stream, open(os.devnull, 'wb') as null:
        os.dup2(stream.fileno(), 2)
        os.dup2(null.fileno(), 1)
    sys.stdout, sys.stderr = (open(k, 'w', closefd=False) for k in (1, 2))  # not those of pytest
    tempfile.tempdir = str(temporary)
    used = int(Path('/proc/self/statm').read_text().split()[0]) * resource.getpagesize()
    forget_peak()
    before, spent = peak_bytes(), sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    for limit, value in ((resource.RLIMIT_AS, used + MEMORY), (resource.RLIMIT_CPU, CPU),
                         (resource.RLIMIT_FSIZE, FILE_SIZE), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(limit, (value, value))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        code = main(argv)
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 2
    except BaseException:
        traceback.print_exc()
        code = 70
    sys.stderr.flush()
    with contextlib.suppress(Exception):
        pipe.send((sum(resource.getrusage(resource.RUSAGE_SELF)[:2]) - spent,
                   peak_bytes() - before))
    os._exit(code)


# ------------------------------------------------------------------------------------ the bombs
def sound_bag(path, count=400):
    """Write a sound bag of `count` samples."""
    samples = [(0.01 * k, 0.01 * k) for k in range(count)]
    with BagWriter(path) as writer:
        writer.add_topic('/joint_states', TYPE)
        for stamp, raw in zip(range(T0, T0 + count * 10 ** 6, 10 ** 6), encode_joint_states(
                [T0 + k * 10 ** 6 for k in range(count)], JOINTS, samples, effort=samples)):
            writer.write('/joint_states', stamp, raw)


def _metadata(change):
    def make(folder):
        sound_bag(folder / 'bag')
        path = folder / 'bag' / 'metadata.yaml'
        path.write_text(change(path.read_text()))
    return make


def laughs(key='a'):
    """Return YAML of nested aliases that stands for 10^9 values."""
    return LAUGHS.decode().replace('a:', f'{key}:', 1)


def merges(levels=60):
    """Return YAML of half a kilobyte whose merge keys double the keys at each level."""
    lines = ['a0: &a0 {x: 1}'] + [f'a{k}: &a{k} {{<<: [*a{k - 1}, *a{k - 1}]}}'
                                  for k in range(1, levels)]
    return '\n'.join(lines) + '\n'


def _yaml(text):
    def make(folder):
        sound_bag(folder / 'bag')
        (folder / 'x.yaml').write_text(text)
    return make


YAML_READERS = ('replay {0}/bag --params {0}/x.yaml', 'replay {0}/bag --model {0}/x.yaml',
                'import {0}/bag/metadata.yaml {0}/new --map {0}/x.yaml')
BAG_READERS = ('replay {0}/bag', 'recover {0}/bag --out {0}/new', 'check {0}/bag')


def rle_zstd(size, last=b'\0'):
    """Return a zstd frame of 4 bytes per 128 kB that unpacks to `size` zeros."""
    block, frame = 1 << 17, bytearray(b'\x28\xb5\x2f\xfd\x00\x58')
    count = size // block
    for k in range(count):
        frame += struct.pack('<I', (k + 1 == count) | 1 << 1 | block << 3)[:3] + last
    return bytes(frame)


def _chunk_file(path, compression, packed, stated, index=True):
    """Write an MCAP file whose second chunk is `packed`, which states `stated` bytes."""
    sound_bag(path.parent / 'sound')
    data = next((path.parent / 'sound').glob('*.mcap')).read_bytes()
    shutil.rmtree(path.parent / 'sound')
    chunk = struct.pack('<QQQII', T0, T0 + 10 ** 9, stated, 0, len(compression)) + \
        compression.encode() + struct.pack('<Q', len(packed)) + packed
    record = struct.pack('<BQ', 6, len(chunk)) + chunk
    if index:
        body = struct.pack('<HI', 1, 16) + struct.pack('<QQ', T0, 0)
        record += struct.pack('<BQ', 7, len(body)) + body
    # In front of the footer's data end: behind the chunk of the sound file.
    at, end = len(MAGIC), len(data)
    while at < end:
        opcode, length = struct.unpack_from('<BQ', data, at)
        if opcode == 15:  # data end
            break
        at += 9 + length
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data[:at] + record + data[at:])


def _chunk(compression, size, index):
    def make(folder):
        (folder / 'bag').mkdir()
        if compression == 'zstd':
            packed = rle_zstd(size)
        else:
            one = lz4.frame.LZ4FrameCompressor(block_size=lz4.frame.BLOCKSIZE_MAX4MB,
                                               block_linked=False)
            head, block = one.begin(), one.compress(bytes(1 << 22))
            packed = head + block * (size >> 22) + one.flush()
        _chunk_file(folder / 'bag' / 'bag_0.mcap', compression, packed, size, index)
    return make


def _names(count, messages=1):
    def make(folder):
        with BagWriter(folder / 'bag') as writer:
            writer.add_topic('/joint_states', TYPE)
            for k in range(messages):
                names = [*JOINTS, *(f'{j:x}{k}' for j in range(count))]
                time = TYPES['builtin_interfaces/msg/Time'](*divmod(T0 + k * 10 ** 6, 10 ** 9))
                zeros = np.zeros(len(names))
                writer.write_message('/joint_states', T0 + k * 10 ** 6, TYPES[TYPE](
                    TYPES['std_msgs/msg/Header'](time, ''), names, zeros, zeros[:0], zeros))
    return make


def _pipe(name):
    def make(folder):
        (folder / 'bag').mkdir()
        os.mkfifo(folder / 'bag' / name)
    return make


def _pipe_metadata(folder):
    sound_bag(folder / 'bag')
    (folder / 'bag' / 'metadata.yaml').unlink()
    os.mkfifo(folder / 'bag' / 'metadata.yaml')


def _years(folder):
    """Write a bag of two seconds with sixty years between them."""
    with BagWriter(folder / 'bag') as writer:
        writer.add_topic('/joint_states', TYPE)
        for begin in (T0 - 10 ** 18, T0):
            stamps = [begin + k * 10 ** 6 for k in range(1000)]
            values = [(0.01 * k, 0.01 * k) for k in range(1000)]
            for stamp, raw in zip(stamps, encode_joint_states(stamps, JOINTS, values,
                                                              effort=values)):
                writer.write('/joint_states', stamp, raw)


def _qos(folder):
    with open(folder / 'bag.mcap', 'wb') as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        schema = writer.register_schema(TYPE, 'ros2msg', b'')
        channel = writer.register_channel('/joint_states', 'cdr', schema, {
            'offered_qos_profiles': laughs() + '\n' + merges()})
        values = [(0.0, 0.0)]
        for stamp, raw in zip([T0], encode_joint_states([T0], JOINTS, values, effort=values)):
            writer.add_message(channel, stamp, raw, stamp)
        writer.finish()
    (folder / 'bag.mcap').write_bytes((folder / 'bag.mcap').read_bytes()[:-30])


def _packed_text(name, mapping, data):
    def make(folder):
        (folder / name).write_bytes(data())
        (folder / 'map.yaml').write_text(mapping)
    return make


def _gzip(piece, count):
    """Return the gzip file of `count` times `piece`, with a wrong checksum at its end."""
    return b'\x1f\x8b\x08' + bytes(7) + _deflated(piece, count) + bytes(8)


def _deflated(piece, count):
    """Return `count` times `piece` as a raw deflate stream."""
    one = zlib.compressobj(9, zlib.DEFLATED, -15)
    return (one.compress(piece) + one.flush(zlib.Z_FULL_FLUSH)) * count + one.flush()


def _mat(size):
    """Return a MATLAB file whose only variable unpacks to `size` bytes."""
    body = struct.pack('<II', 6, 8) + struct.pack('<II', 6, 0) + \
        struct.pack('<II', 5, 8) + struct.pack('<ii', size // 8, 1) + \
        struct.pack('<II', 1, 1) + b'x' + bytes(7) + struct.pack('<II', 9, size)
    one = zlib.compressobj(9)
    packed = one.compress(struct.pack('<II', 14, len(body) + size) + body)
    packed += one.flush(zlib.Z_FULL_FLUSH) + _deflated(bytes(1 << 20), size >> 20) + bytes(4)
    head = b'MATLAB 5.0'.ljust(124) + struct.pack('<H', 0x100) + b'IM'
    return head + struct.pack('<II', 15, len(packed)) + packed


def _npy(size):
    """Return the head of a NumPy file of `size` doubles, and none of them."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {
        'descr': '<f8', 'fortran_order': False, 'shape': (size,)})
    return stream.getvalue()


def _npz(size):
    """Return a NumPy archive whose only array unpacks to `size` bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, 'w', zipfile.ZIP_DEFLATED) as archive:
        with archive.open('x.npy', 'w', force_zip64=True) as file:
            file.write(_npy(size // 8))
            for _ in range(size >> 24):
                file.write(bytes(1 << 24))
    return stream.getvalue()


def _entities():
    """Return XML whose entities stand for 10^9 characters."""
    names = 'abcdefghij'
    lines = [f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip(names, names[1:])]
    return ('<!DOCTYPE mujoco [<!ENTITY a "lol">' + ''.join(lines)
            + ']><mujoco model="&j;"><worldbody/></mujoco>').encode()


def _database(statements):
    def make(folder):
        sound_bag(folder / 'bag')
        (file,) = (folder / 'bag').glob('*.mcap')
        file.unlink()
        path = folder / 'bag' / 'metadata.yaml'
        path.write_text(path.read_text().replace(file.name, 'bag_0.db3').replace(
            'storage_identifier: mcap', 'storage_identifier: sqlite3'))
        base = sqlite3.connect(folder / 'bag' / 'bag_0.db3')
        base.execute('CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, '
                     'serialization_format TEXT, offered_qos_profiles TEXT)')
        base.execute('INSERT INTO topics VALUES (1, "/joint_states", ?, "cdr", ?)',
                     (TYPE, laughs()))
        for statement in statements:
            base.execute(statement)
        base.commit()
        base.close()
    return make


MESSAGES = ('CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, '
            'data BLOB)')
JSON_MAP = MAPPING.format(first='a', second='b')
TEXT_MAP = MAPPING.format(first=1, second=2)
NPZ_MAP = MAPPING.format(first='x', second='x')
MAT_MAP = MAPPING.format(first='x', second='x')


BOMBS = (
    Bomb('metadata.yaml: nested aliases', _metadata(lambda text: laughs() + text.replace(
        'relative_file_paths:', 'relative_file_paths: *i\n  old:')), BAG_READERS),
    Bomb('metadata.yaml: merge keys', _metadata(lambda text: merges() + text), BAG_READERS),
    Bomb('metadata.yaml: nested deeply', _metadata(lambda text: text + 'x: ' + '[' * 200_000),
         BAG_READERS),
    Bomb('metadata.yaml: a pipe', _pipe_metadata, BAG_READERS),
    Bomb('YAML: nested aliases', _yaml(laughs()), YAML_READERS),
    Bomb('YAML: merge keys', _yaml(merges()), YAML_READERS),
    Bomb('YAML: an alias in itself', _yaml('a: &a\n  <<: *a\nb: &b [*b]\n'), YAML_READERS),
    Bomb('YAML: sexagesimal number', _yaml('stiffness: ' + '1:' * 500_000 + '1'), YAML_READERS),
    Bomb('QoS profiles: aliases', _qos, ('replay {0}/bag.mcap',
                                         'recover {0}/bag.mcap --out {0}/new')),
    Bomb('chunk: 4 GiB of zstd', _chunk('zstd', 1 << 32, True), BAG_READERS),
    Bomb('chunk: 4 GiB of zstd, no index', _chunk('zstd', 1 << 32, False), BAG_READERS),
    Bomb('chunk: 2 GiB of lz4', _chunk('lz4', 1 << 31, True), BAG_READERS),
    Bomb('a million names', _names(1_000_000), BAG_READERS),
    Bomb('40 times 60 000 names', _names(60_000, 40), BAG_READERS),
    Bomb('a pipe called *.mcap', _pipe('bag_0.mcap'), BAG_READERS + (
        'replay {0}/bag/bag_0.mcap', 'fleet {0}/bag --out {0}/new')),
    Bomb('a pipe called *.csv', _pipe('x.csv'), (
        'diagnose {0}/bag/x.csv --model ' + MODEL,
        'import {0}/bag/x.csv {0}/new --map emps')),
    Bomb('a pipe called *.yaml', _pipe('x.yaml'), (
        'replay {0}/bag --params {0}/bag/x.yaml', 'replay {0}/bag --model {0}/bag/x.yaml')),
    Bomb('sixty years in two seconds', _years, BAG_READERS + (
        'accept {0}/bag --max-gap 0.1', 'report {0}/bag --out {0}/x.html',
        'diagnose {0}/bag --model ' + MODEL)),
    Bomb('SQLite: a view without end', _database([
        'CREATE VIEW messages AS WITH RECURSIVE m(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM m)'
        " SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM m"]), BAG_READERS),
    Bomb('SQLite: a row of 1 GB', _database([MESSAGES, 'INSERT INTO messages VALUES (1, 1, 1, '
                                             'zeroblob(900000000))']), BAG_READERS),
    Bomb('gzip: a line of 4 GB', _packed_text('x.csv.gz', TEXT_MAP, lambda: _gzip(
        bytes(1 << 20).replace(b'\0', b'1'), 4000)), (
        'import {0}/x.csv.gz {0}/new --map {0}/map.yaml',
        'diagnose {0}/x.csv.gz --model ' + MODEL)),
    Bomb('gzip: a billion rows', _packed_text('x.csv.gz', TEXT_MAP, lambda: _gzip(
        b'0,0\n' * (1 << 18), 4000)), ('import {0}/x.csv.gz {0}/new --map {0}/map.yaml',)),
    Bomb('gzip: JSON of 4 GB', _packed_text('x.json.gz', JSON_MAP, lambda: _gzip(
        b'[],' * (1 << 18), 4000)), ('import {0}/x.json.gz {0}/new --map {0}/map.yaml',)),
    Bomb('MATLAB: 3 GB', _packed_text('x.mat', MAT_MAP, lambda: _mat(3 << 30)),
         ('import {0}/x.mat {0}/new --map {0}/map.yaml',)),
    Bomb('NumPy: a zip of 600 MB', _packed_text('x.npz', NPZ_MAP, lambda: _npz(600 << 20)),
         ('import {0}/x.npz {0}/new --map {0}/map.yaml',)),
    Bomb('NumPy: an array of 8 TB', _packed_text('x.npy', NPZ_MAP, lambda: _npy(1 << 40)),
         ('import {0}/x.npy {0}/new --map {0}/map.yaml',)),
    Bomb('JSON: nested deeply', _packed_text('x.json', JSON_MAP, lambda: b'[' * 1_000_000), (
        'import {0}/x.json {0}/new --map {0}/map.yaml', 'export {0}/x.json --to yaml --ranges')),
    Bomb('XML: nested entities', _packed_text('x.xml', '', _entities), (
        f'export {MODEL} --to mjcf --into {{0}}/x.xml --joint m',)),
    Bomb('a pipe called *.xml, *.json', _pipe('x.xml'), (
        f'export {MODEL} --to mjcf --into {{0}}/bag/x.xml --joint m',
        'export {0}/bag/x.xml --to yaml --ranges')),
    Bomb('gzip of MATLAB: 4 GB', _packed_text('x.mat', MAT_MAP, lambda: _gzip(
        bytes(1 << 20), 4000)), ('import {0}/x.mat {0}/new --map {0}/map.yaml',)),
)


def explode(bomb, folder, commands=None):
    """Yield (command, bytes of its files, Ended) of `bomb`; each begins in an empty folder."""
    for command in bomb.commands[:commands]:
        with tempfile.TemporaryDirectory(dir=folder) as name:
            place = Path(name)
            bomb.make(place)
            size = sum(f.stat().st_size for f in place.rglob('*') if f.is_file())
            yield command, size, run_limited(command.format(place).split(), place)
