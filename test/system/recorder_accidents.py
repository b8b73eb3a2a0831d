# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The accidents, each with its figures and the bars that it misses."""
from contextlib import contextmanager
import fcntl
import os
import re
import resource
import shutil
import signal
import struct
import subprocess
import time

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.recordings.mcap_file import McapFile
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.write import recover

BARS = (OLDER, RECOVERED, TOLD, NONE_LOST, CHUNKS) = (
    'all that is older than 1 s is in the bag', 'recover saves every message of it',
    'the recorder tells it', 'a slow disk costs no message',
    'a cut at any byte keeps all whole chunks')
BATCH = 3       # recorders at a time
RUN = 1.2, 3.5  # s from the first message to the accident
SLOW = 100.0    # Hz, of the bag that is cut at every byte
CUT_CHUNKS = 3
RECOVERED_CUTS = 100  # recover every so many cuts; all are read
EXT4_IOC_SHUTDOWN, NO_LOG_FLUSH = 0x8004587D, 2
IMAGE_MB, SMALL_MB = 64, 2
STOPPED = 'recording has stopped'
ROOT_ONLY = 'only root may mount a file system'


def _row(accident, kept, **broken):
    """Return the row of `accident` with the list of Kept; broken: {name of a bar: missed}."""
    broken = {OLDER: any(k.missing for k in kept), RECOVERED: any(k.unread for k in kept),
              **{globals()[name.upper()]: value for name, value in broken.items()}}
    lost = [k.lost_s for k in kept]
    return {'accident': accident, 'runs': len(kept),
            'messages': sum(k.messages for k in kept), 'missing': sum(k.missing for k in kept),
            'lost_s': float(np.median(lost)) if lost else None,
            'worst_s': max(lost, default=None), 'unread': sum(k.unread for k in kept),
            'missed': [bar for bar in BARS if broken.get(bar)]}


def _not_run(accident, why):
    return {'accident': accident, 'runs': 0, 'why': why, 'missed': []}


def killed(bench, name, kills, done, **parameters):
    """Kill recorders that have these `parameters`, `kills` in all; `name` is that of the row."""
    kept = []
    while len(kept) < kills:
        started = [bench.record(**parameters) for _ in range(min(BATCH, kills - len(kept)))]
        begun_ns = bench.until_begun(*zip(*started))
        begun = time.monotonic()
        for at, (process, path) in sorted(zip(bench.random.uniform(*RUN, BATCH), started)):
            bench.wait(max(0.0, begun + at - time.monotonic()))
            if len(kept) % 5 == 4:  # while it closes its bag
                process.send_signal(signal.SIGINT)
                time.sleep(bench.random.uniform(0.0, 0.05))
            event_ns = time.time_ns()
            process.kill()
            process.wait()
            bench.forget(process)
            kept.append(bench.kept(path, begun_ns, event_ns))
            done()
    return _row(name, kept) if kept else _not_run(name, f'--kills {kills}')


def slow_disk(bench, done):
    """Kill a recorder that waits for its disk with every call."""
    process, path = bench.record('slow_recorder')
    begun_ns = bench.until_begun([process], [path])

    def lost():
        outcome = bench.told()
        return outcome.values['lost'] if outcome and outcome.values['bag'] == str(path) else None
    bench.until(lambda: lost() is not None, 'diagnostics of the recorder')
    before = lost()  # a reader that has just joined may miss a message
    bench.wait(2 * RUN[1])
    after = lost()
    event_ns = time.time_ns()
    process.kill()
    process.wait()
    bench.forget(process)
    done()
    return _row('slow disk, kill -9', [bench.kept(path, begun_ns, event_ns)],
                none_lost=after != before)


@contextmanager
def _mounted(folder, *options):
    """Give a file system that is mounted at `folder`."""
    folder.mkdir()
    _call('mount', *options, str(folder))
    try:
        yield folder
    finally:
        _call('umount', str(folder))


def _call(*command):
    try:
        subprocess.run(command, check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError) as error:
        reason = getattr(error, 'stderr', '') or str(error)
        raise _NoMount(f'{command[0]}: {" ".join(reason.split())}') from None


class _NoMount(Exception):
    """A file system cannot be made or mounted."""


def power_cut(bench, cuts, done):
    """Stop the file system below recorders at once, and read what its journal gives back."""
    name, kept, untold = 'power cut (ext4)', [], 0
    if os.geteuid() != 0:
        return _not_run(name, ROOT_ONLY)
    image = bench.folder / 'image'
    try:
        for cut in range(cuts):
            with open(image, 'wb') as file:
                file.truncate(IMAGE_MB << 20)
            _call('mkfs.ext4', '-q', '-F', str(image))
            with _mounted(bench.folder / f'cut{cut}', '-o', 'loop', str(image)) as folder:
                process, path = bench.record(output=folder / 'bag')
                try:
                    begun_ns = bench.until_begun([process], [path])
                    bench.wait(bench.random.uniform(*RUN))
                    handle = os.open(folder, os.O_RDONLY)
                    event_ns = time.time_ns()
                    fcntl.ioctl(handle, EXT4_IOC_SHUTDOWN, struct.pack('I', NO_LOG_FLUSH))
                    os.close(handle)
                    bench.wait(2.5)  # to a recorder that has power the medium is gone
                    untold += STOPPED not in bench.said(process)
                finally:
                    process.kill()
                    process.wait()
                    bench.forget(process)
            with _mounted(bench.folder / f'again{cut}', '-o', 'loop', str(image)) as folder:
                copy = bench.folder / f'power{cut}'
                if (folder / 'bag').is_dir():
                    shutil.copytree(folder / 'bag', copy)
            kept.append(bench.kept(copy, begun_ns, event_ns))
            done()
    except _NoMount as error:
        return _not_run(name, str(error))
    return _row(name, kept, told=untold) if kept else _not_run(name, '--power-cuts 0')


def file_limit(bench, done):
    """Let a file grow no more while it is recorded."""
    process, path = bench.record()
    begun_ns = bench.until_begun([process], [path])
    bench.wait(RUN[1])
    size = (path / f'{path.name}_0.mcap').stat().st_size
    event_ns = time.time_ns()
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (size, size))
    told = _stopped(bench, process)
    done()
    return _row('file may not grow', [bench.kept(path, begun_ns, event_ns)], told=not told)


def disk_full(bench, done):
    """Record until a small file system is full."""
    name = 'disk full (tmpfs)'
    if os.geteuid() != 0:
        return _not_run(name, ROOT_ONLY)
    try:
        with _mounted(bench.folder / 'small', '-t', 'tmpfs', '-o', f'size={SMALL_MB}m',
                      'tmpfs') as folder:
            process, path = bench.record(output=folder / 'bag', compression='none')
            begun_ns = bench.until_begun([process], [path])
            bench.until(lambda: STOPPED in bench.said(process), 'a full disk')
            at = re.findall(rf'\[(\d+\.\d+)\][^\n]*{STOPPED}', bench.said(process))
            told = _stopped(bench, process)
            copy = bench.folder / 'from_full'
            shutil.copytree(path, copy)
    except _NoMount as error:
        return _not_run(name, str(error))
    done()
    return _row(name, [bench.kept(copy, begun_ns, int(float(at[0]) * 1e9))], told=not told)


def _stopped(bench, process):
    """Return whether the recorder tells that it cannot write, lives on and ends well."""
    told = _is_told(bench, 'cannot write') and process.poll() is None
    process.terminate()
    told &= process.wait(30) == 0
    bench.forget(process)
    return told


def removed(bench, done):
    """Remove a bag while it is recorded; the recorder says where its content still is."""
    process, path = bench.record()
    begun_ns = bench.until_begun([process], [path])
    bench.wait(RUN[1])
    shutil.rmtree(path)
    event_ns = time.time_ns()
    told, kept = _is_told(bench, 'removed or moved'), []
    if told:
        held = bench.told().message.split('cp ')[1].split()[0]
        copy = bench.folder / 'saved.mcap'
        shutil.copyfile(held, copy)
        kept = [bench.kept(copy, begun_ns, event_ns)]
    process.kill()
    process.wait()
    bench.forget(process)
    done()
    return {**_row('bag removed', kept, told=not told), 'runs': 1}


def _is_told(bench, words):
    """Return whether the recorder says ERROR with these `words`, soon."""
    def told():
        found = bench.told()
        return found is not None and found.level == Level.ERROR and words in found.message
    end = time.monotonic() + 5.0
    bench.until(lambda: told() or time.monotonic() > end, 'an error')
    return told()


def refused(bench, done):
    """Start a recorder whose target cannot be written: one line, exit code 2."""
    name = 'target read-only'
    try:
        with _read_only(bench.folder / 'read_only') as parent:
            process, _ = bench.record(output=parent / 'bag')
            code = process.wait(60)
    except _NoMount as error:
        return _not_run(name, str(error))
    bench.forget(process)
    line = bench.said(process)
    done()
    good = code == 2 and 'cannot create the bag' in line and '\n' not in line
    return {**_row(name, [], told=not good), 'runs': 1}


@contextmanager
def _read_only(folder):
    """Give a folder that nobody may write to: root may, unless its file system is read-only."""
    if os.geteuid() == 0:
        with _mounted(folder, '-t', 'tmpfs', '-o', 'ro', 'tmpfs'):
            yield folder
    else:
        folder.mkdir(mode=0o555)
        yield folder


def cut_at_every_byte(bench, done):
    """Cut a bag of a killed recorder at every byte of its last chunks."""
    bench.plant(SLOW)
    process, folder = bench.record()
    bench.until_begun([process], [folder])
    bench.wait(RUN[0])
    process.kill()
    process.wait()
    bench.forget(process)
    bench.plant(0.0)
    path = file_path = folder / f'{folder.name}_0.mcap'
    file = McapFile(file_path)
    ends = [(chunk.end, sum(chunk.counts.values())) for chunk in file.chunks]
    file.close()
    with open_bag(path) as bag:
        content = list(bag.messages())
    cuts, wrong, unread = 0, 0, 0
    for size in range(file_path.stat().st_size - 1, ends[-CUT_CHUNKS - 1][0], -1):
        os.truncate(file_path, size)
        cuts += 1
        whole = sum(count for end, count in ends if end <= size)
        with open_bag(path) as bag:
            found = list(bag.messages())
        wrong += len(found) < whole or any(message not in content for message in found)
        if cuts % RECOVERED_CUTS == 0:
            out = bench.folder / 'cut_recovered'
            try:
                recover(path, out)
                with open_bag(out) as bag:
                    unread += list(bag.messages()) != found or bool(bag.notice)
                shutil.rmtree(out)
            except InputError:
                unread += 1
    done()
    return {**_row('cut at every byte', [], chunks=wrong), 'runs': cuts, 'messages': len(content),
            'unread': unread, 'missed': [bar for bar, bad in (
                (RECOVERED, unread), (CHUNKS, wrong)) if bad]}
