# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Diagnosis of effects that it cannot see: recordings of an own simulator, sealed labels, scores.

Every effect of the library, none, two at once, effects outside of the library, and the true
effect taken out of it (leave-one-out); several motions, noise of 0.2 to 2 %. Each recording is
diagnosed by a process of its own; the labels are opened after all verdicts are written. What
was missed is listed.

usage examples:
  gearbox_monitor benchmark blind
  gearbox_monitor benchmark blind --n 24 --jobs 2 --keep blind/
  gearbox_monitor benchmark blind --set stress --json stress.json
"""
from concurrent.futures import as_completed, ThreadPoolExecutor
import json
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

from gearbox_monitor.benchmarks.blind import generate, imitate, score
from gearbox_monitor.benchmarks.harness import (
    add_json_option, finish, progress_line, require_compiled, require_whole)
from gearbox_monitor.errors import InputError

SETS = ('main', 'stress', 'loo', 'all')
TIMEOUT = 300.0  # s, of one diagnosis
# Reported beside the stress set.
OPTIONS = ({'torque': 0.04}, {'scatter': 0.03}, {'coloured': True}, {'jitter': True})


def add_arguments(parser):
    parser.add_argument('--n', type=int, default=240, metavar='N',
                        help='recordings of the main set; the others are sized by it '
                        '(default: %(default)s)')
    parser.add_argument('--set', choices=SETS, default='main',
                        help='main: nominal exact; stress: nominal scattered, process torque; '
                        'loo: the true effect taken out of the library (default: %(default)s)')
    add_json_option(parser)
    parser.add_argument('--seed', type=int, default=0, metavar='S',
                        help='other recordings for another seed (default: %(default)s)')
    parser.add_argument('--jobs', type=int, default=1, metavar='N',
                        help='recordings made and diagnosed at once (default: %(default)s)')
    parser.add_argument('--keep', metavar='DIR',
                        help='keep recordings, verdicts and, once all verdicts are written, '
                        'labels in this new directory')


def plans(which, n, random):
    """Return the specifications of the set `which` of size `n`."""
    specs = []
    if which in ('main', 'all'):
        specs += generate.plan(generate.counts_for(n), random)
    if which in ('stress', 'all'):
        third = max(n // 3, 4)
        specs += generate.plan({'single': third // 2, 'none': third // 2 - third // 6,
                                'pair': third // 6}, random, ('stress',))
        few = max(n // 15, 3)
        for options in OPTIONS:
            specs += generate.plan({'single': few // 2 + 1, 'none': few - few // 2 - 1,
                                    'pair': 1}, random, ('stress',), options)
    if which in ('loo', 'all'):
        specs += generate.plan({'loo': max(n // 4, 2)}, random)
    return [specs[i] for i in random.permutation(len(specs))]


def diagnose(folder, exclude, command=None):
    """
    Return (verdict or None, seconds, last line of a failure) of the recording in `folder`.

    command: the start of the command line, for tests.
    """
    out = Path(folder) / 'verdict.json'
    line = [*(command or [sys.executable, '-m', 'gearbox_monitor.cli.main', 'diagnose']),
            'recording.csv', '--model', 'drive.yaml', '--json', 'verdict.json']
    if exclude:
        line += ['--exclude', *exclude]
    began = time.monotonic()
    try:
        done = subprocess.run(line, cwd=folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, timeout=TIMEOUT, check=False)
        said = done.stderr.decode(errors='replace').strip().splitlines()[-1:]
        why = '' if done.returncode in (0, 1) else (said or [f'exit {done.returncode}'])[0]
    except subprocess.TimeoutExpired:
        why = f'no answer within {TIMEOUT:g} s'
    seconds = time.monotonic() - began
    try:
        return json.loads(out.read_text(encoding='utf-8')), seconds, why
    except (OSError, ValueError):
        return None, seconds, why or 'no readable verdict'


def diagnose_all(recordings, orders, jobs, progress, command=None):
    """Return ({name: verdict}, {name: s}, {name: failure}) of all `orders`."""
    verdicts, seconds, failures = {}, {}, {}
    with ThreadPoolExecutor(jobs) as pool:
        asked = {pool.submit(diagnose, Path(recordings) / order['name'], order['exclude'],
                             command): order['name'] for order in orders}
        try:
            for future in as_completed(asked):
                name = asked[future]
                verdicts[name], seconds[name], why = future.result()
                if verdicts[name] is None:
                    failures[name] = why
                progress(len(verdicts), len(orders))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    for order in orders:
        if jobs > 1 and seconds[order['name']] > score.MAX_SECONDS:
            # It shared the machine with others: how long does it take alone?
            _, seconds[order['name']], _ = diagnose(Path(recordings) / order['name'],
                                                    order['exclude'], command)
    return verdicts, seconds, failures


def evaluate(n, which, seed, jobs, keep=None, progress=lambda what, done, total: None,
             command=None):
    """Return the figures of score.score() with failures and what could not be drawn."""
    random = np.random.default_rng([seed, 1])
    # The labels lie where no path from a recording leads, and open to this user alone.
    with tempfile.TemporaryDirectory() as hidden, tempfile.TemporaryDirectory() as open_to_see:
        base = Path(keep or Path(open_to_see) / 'blind')
        sealed = Path(hidden) / 'labels.json'
        orders = generate.generate(plans(which, n, random), base, seed, jobs,
                                   lambda d, t: progress('recordings', d, t), sealed)
        recordings = base / 'recordings'
        verdicts, seconds, failures = diagnose_all(
            recordings, orders, jobs, lambda d, t: progress('diagnoses', d, t), command)
        drawn = json.loads(sealed.read_text(encoding='utf-8'))
        if keep:
            shutil.copy(sealed, base / 'labels.json')

        data = score.score(drawn['labels'], verdicts,
                           lambda name: generate.read(recordings / name), seconds,
                           progress=lambda d, t: progress('scores', d, t),
                           imitator=imitate.best_imitator)
    return {'n': n, 'set': which, 'seed': seed, 'failures': failures,
            'not_drawn': drawn['not_drawn'], **data}


def text(data):
    """Return all tables, at most 80 columns."""
    lines = [score.text(data)]
    for name, why in data['failures'].items():
        lines.append(f'{name}: {why}'[:80])
    if data['not_drawn']:
        lines.append(f'could not be drawn: {len(data["not_drawn"])}, '
                     + ', '.join('+'.join(ids) or 'none' for ids in data['not_drawn']))
    times = [r['seconds'] for r in data['rows'] if r['seconds'] is not None]
    if times:
        lines.append(f'{len(times)} diagnoses, median {np.median(times):.0f} s, longest '
                     f'{max(times):.0f} s')
    return '\n'.join(lines)


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    require_compiled('benchmark blind')
    require_whole('--n', args.n)
    require_whole('--jobs', args.jobs)
    require_whole('--seed', args.seed, 0)
    if args.json and not Path(args.json).absolute().parent.is_dir():
        raise InputError(f'{args.json}: its directory does not exist, expected one that does')
    if args.keep and Path(args.keep).exists():
        raise InputError(f'{args.keep}: exists, expected a new directory')
    show = progress_line()
    data = evaluate(args.n, args.set, args.seed, args.jobs, args.keep,
                    lambda stage, done, total: show(f'{stage} {done}/{total}'))
    show('')
    return finish(data, text(data), args.json)
