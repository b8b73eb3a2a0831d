# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Damaged files of every kind: each is read, refused in one line, or read with its loss stated.

Files are damaged at random, but so that most of their structure stays: records and messages of
bags, counts of serialised messages, tokens of CSV, YAML and JSON. Never a crash, another
exception, a run longer than the limit, or memory beyond it. A case is named by target, seed and
number, and comes again with --only, --seed and --first.

--bombs runs whole commands on small files that ask for gigabytes, minutes or a wait without an end
(fuzz_bombs.py) under limits of the operating system, and prints a table.

usage examples:
  .venv/bin/python test/system/fuzz.py --seconds 60
  .venv/bin/python test/system/fuzz.py --only bag --seconds 600 --seed 7
  .venv/bin/python test/system/fuzz.py --only "bag, lz4" --seed 7 --first 1234 --cases 1
  .venv/bin/python test/system/fuzz.py --bombs
"""
from collections import Counter
import contextlib
import io
import multiprocessing
from pathlib import Path
import random
import resource
import signal
import sys
import tempfile
import time
import traceback

from fuzz_bombs import BOMBS, explode, sound_bag
from fuzz_targets import one_line, targets
from script import run_script

from benchmarks.harness import add_json_option, write_json
from benchmarks.memory import forget_peak, peak_bytes
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of

LIMIT_S = 30.0  # CPU, one case; compiling a kernel takes a third of it
LIMIT_BYTES = 256 << 20  # that one case may add to the resident memory
ROOM = 1 << 30  # bytes of address space that the whole run may add: the machine must not suffer
READ, REFUSED = 'read', 'refused'


class Hang(BaseException):
    """A case took longer than LIMIT_S."""


def add_arguments(parser):
    parser.add_argument('--seconds', type=float, default=60.0, metavar='S',
                        help='how long (default: %(default)g)')
    parser.add_argument('--seed', type=int, default=0, metavar='N')
    parser.add_argument('--only', default='', metavar='TEXT', help='targets that contain TEXT')
    parser.add_argument('--first', type=int, default=0, metavar='N', help='first case of each')
    parser.add_argument('--cases', type=int, metavar='N', help='cases of each, then end')
    parser.add_argument('--bombs', action='store_true', help='whole commands on bombs instead')
    add_json_option(parser)


def case_of(target, seed, number, folder):
    """Write the damaged files of case `number` into the empty `folder`."""
    chance = random.Random(f'{target.name} {seed} {number}')
    for k, (name, data) in enumerate(target.files.items()):
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(target.damage(data, chance) if k == 0 else data)


def judge(target, folder):
    """Read what is in `folder`; returns READ, REFUSED or what is wrong, in one line."""
    forget_peak()
    before = peak_bytes()
    try:
        with _limited(LIMIT_S):
            target.read(folder)
        outcome = READ
    except InputError as error:
        outcome = REFUSED
        try:
            one_line(error)
        except AssertionError as wrong:
            outcome = str(wrong)
    except Hang:
        outcome = f'longer than {LIMIT_S:g} s of CPU'
    except Exception as error:  # what is looked for
        place = traceback.extract_tb(error.__traceback__)[-1]
        outcome = (f'{type(error).__name__} {" ".join(str(error).split())[:100]} at '
                   f'{Path(place.filename).name}:{place.lineno}')
    added = peak_bytes() - before
    return f'{added >> 20} MB of memory' if added > LIMIT_BYTES else outcome


@contextlib.contextmanager
def _limited(seconds):
    def late(*_):
        raise Hang
    before = signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def run_cases(target, seed, numbers, tell=lambda number, outcome: None):
    """Judge the cases `numbers`; tell(number, None) before each, (number, outcome) behind it."""
    for number in numbers:
        with tempfile.TemporaryDirectory() as folder:
            case_of(target, seed, number, Path(folder))
            tell(number, None)
            tell(number, judge(target, Path(folder)))


def _in_child(target, seed, first, cases, end, pipe):
    used = int(Path('/proc/self/statm').read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, used + ROOM))
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    number = first
    while number < first + cases and time.monotonic() < end:
        spent = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        resource.setrlimit(resource.RLIMIT_CPU, (int(spent + 2 * LIMIT_S), hard))
        run_cases(target, seed, [number], lambda *said: pipe.send(said))
        number += 1
    pipe.send(None)


def fuzz(target, seed, first, cases, end):
    """
    Judge cases of `target` from `first` on in a process of its own, until the clock says `end`.

    Returns (Counter of outcomes, {what is wrong: first case}). A crash ends the process only.
    """
    context = multiprocessing.get_context('fork')
    counts, wrong, last = Counter(), {}, first + cases
    while first < last and time.monotonic() < end:
        ours, theirs = context.Pipe(False)
        child = context.Process(target=_in_child, args=(
            target, seed, first, last - first, end, theirs))
        child.start()
        theirs.close()
        number, done = first, False
        with contextlib.suppress(EOFError):
            while not done:
                said = ours.recv()
                done = said is None
                if not done:
                    number, outcome = said
                    if outcome is not None:
                        counts[outcome] += 1
                        if outcome not in (READ, REFUSED):
                            wrong.setdefault(outcome, number)
        child.join()
        if not done:
            wrong.setdefault(f'crash, exit code {child.exitcode}', number)
            counts[f'crash, exit code {child.exitcode}'] += 1
        first = number + 1
        if done:
            break
    return counts, wrong


def run_bombs(args):
    """Run all commands on the bombs whose name contains --only; return 1 if one ends badly."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        sound_bag(Path(folder) / 'bag')
        with contextlib.redirect_stdout(io.StringIO()):  # all is compiled before time counts
            for command in ('replay {0}/bag', 'check {0}/bag', 'recover {0}/bag --out {0}/new'):
                main(command.format(folder).split())
        print('| file | kB | commands: exit code | CPU, s, at most | memory, MB, at most |\n'
              '|---|---|---|---|---|')
        for bomb in BOMBS:
            if args.only not in bomb.name:
                continue
            ends = list(explode(bomb, Path(folder)))
            rows += [{'file': bomb.name, 'command': command, 'bytes': size, 'seconds': end.seconds,
                      'memory': end.added, 'code': end.code, 'wrong': end.wrong}
                     for command, size, end in ends]
            codes = ', '.join(f'{command.split()[0]}: {end.code}' for command, _, end in ends)
            print(f'| {bomb.name} | {ends[0][1] / 1e3:.0f} | {codes} | '
                  f'{max(end.seconds for *_, end in ends):.1f} | '
                  f'{max(end.added for *_, end in ends) / 1e6:.0f} |', flush=True)
            for command, _, end in ends:
                if end.wrong:
                    print(f'  MISSED {command}: {end.wrong}', flush=True)
    write_json(rows, args.json)
    return 1 if any(row['wrong'] for row in rows) else 0


def run(args):
    """Run the benchmark; returns 1 when a file was neither read nor refused."""
    if args.bombs:
        return run_bombs(args)
    if not args.seconds > 0.0:
        raise InputError(f'--seconds: {args.seconds:g}, expected a number > 0')
    expect_folder_of(args.json)
    with tempfile.TemporaryDirectory() as folder:
        every = targets(Path(folder))
        chosen = [target for target in every if args.only in target.name]
        if not chosen:
            raise InputError(f'--only: no target contains {args.only!r}, expected one of '
                             + ', '.join(target.name for target in every))
        for target in chosen:  # sound files are read, and all is compiled before time counts
            whole = Path(tempfile.mkdtemp(dir=folder))
            for name, data in target.files.items():
                (whole / name).parent.mkdir(exist_ok=True)
                (whole / name).write_bytes(data)
            target.read(whole)
        rows, begin = [], time.monotonic()
        print(f'{"file":<22}{"cases":>8}{"read":>8}{"refused":>9}{"wrong":>7}')
        for k, target in enumerate(chosen):
            end = begin + args.seconds * (k + 1) / len(chosen)
            counts, wrong = fuzz(target, args.seed, args.first, args.cases or 1 << 60, end)
            bad = sum(counts.values()) - counts[READ] - counts[REFUSED]
            rows.append({'file': target.name, 'cases': sum(counts.values()),
                         'read': counts[READ], 'refused': counts[REFUSED], 'wrong': wrong})
            print(f'{target.name:<22}{sum(counts.values()):8d}{counts[READ]:8d}'
                  f'{counts[REFUSED]:9d}{bad:7d}', flush=True)
            for what, number in wrong.items():
                print(f'  MISSED --only "{target.name}" --seed {args.seed} --first {number} '
                      f'--cases 1: {what}', flush=True)
    write_json({'seed': args.seed, 'files': rows}, args.json)
    return 1 if any(row['wrong'] for row in rows) else 0


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
