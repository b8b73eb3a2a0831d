# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Diagnose pairs of real recordings whose truth stays sealed until all verdicts are written.

FOLDER holds manifests NAME.pair.yaml in any folders, and truth.yaml. A manifest says which files
are compared and how they are read (benchmarks/README.md). Files lie beside the manifest,
or in the same folder of --data. Every pair runs the commands that a user would type: import, learn
or fit model of the references, diagnose. truth.yaml is opened last.

Scores are those of the LiU-ICE fault diagnosis competition (Jung, Frisk, Krysander 2024): how
often a change is seen, how often one is reported where nothing changed, the probability and the
rank of the right cause. Least squares with the Bayesian information criterion stands beside it.

usage examples:
  python -m benchmarks real_gap benchmarks/real_logs --data path/to/data
  python -m benchmarks real_gap my_pairs --out verdicts --json real_gap.json
"""
import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
import json
import math
from pathlib import Path
import resource
import shlex
import subprocess
import sys
import tempfile
import time

from typing import Any

import yaml

from benchmarks import intervals
from benchmarks.harness import (
    add_json_option, bar_lines, BarTable, finish, progress_line, write_json)
from benchmarks.least_squares import Cause, ranked_of_drive, ranked_of_robot
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.files.user_files import load_model, load_yaml, Yaml
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.robot.description import SUFFIXES

ENDING, TRUTH = '.pair.yaml', 'truth.yaml'
KEYS = ('log', 'reference', 'model', 'joint', 'import', 'recorded', 'values', 'free', 'diagnose')
NONE, UNKNOWN, REFUSED, UNDECIDED = 'none', 'unknown', 'refused', 'undecided'
EFFECT_IDS = {*EFFECTS, *(effect.id for effect in ROBOT_EFFECTS), UNKNOWN}


@dataclass(frozen=True)
class Pair:
    """
    A manifest: what is compared, without what is true of it.

    folder: of the manifest, in which commands run; log, reference: files; model: file of the robot
    or drive; joint of it, None for all or a drive; import_: options of the command import, None
    where logs are read as they are; recorded {joint: its name in the logs}; values: of the option
    --values; free: values of the drive that fit model fits to the references; diagnose: further
    options.
    """

    name: str
    folder: Path
    log: tuple[Path, ...]
    reference: tuple[Path, ...]
    model: Path
    joint: str | None
    import_: tuple[str, ...] | None
    recorded: Mapping[str, str]
    values: Mapping[str, Any]
    free: tuple[str, ...]
    diagnose: tuple[str, ...]

    @property
    def of_robot(self) -> bool:
        """Whether all joints of a robot are compared."""
        return self.joint is None and self.model.suffix.lower() in SUFFIXES


@dataclass(frozen=True)
class Answer:
    """
    What a method says of a pair.

    probabilities {effect, place: probability}, of UNKNOWN as well, empty where nothing changed;
    ranked: causes, the likeliest first; cpu: s; refused: why there is none. findings: of diagnose,
    as JSON; undecided: whether it says that the motion shows too little.
    """

    probabilities: Mapping[Cause, float]
    ranked: tuple[Cause, ...]
    cpu: float
    refused: str = ''
    findings: tuple[Mapping[str, Any], ...] = ()
    undecided: bool = False

    @property
    def words(self) -> str:
        """The answer as text: what it names, likeliest first."""
        causes = sorted(self.probabilities, key=lambda c: -self.probabilities[c])
        if self.refused or self.undecided:
            return REFUSED if self.refused else UNDECIDED
        return ', '.join(effect + (f'@{place}' if place else '')
                         for effect, place in causes[:2]) or NONE


@dataclass(frozen=True)
class Truth:
    """
    Effects any of which is right, at a place ('' for any); no effects: nothing changed.

    values: {name: value} of the change, as far as they are known.
    """

    effects: tuple[str, ...]
    place: str = ''
    values: Mapping[str, float] = field(default_factory=dict)

    def admits(self, cause: Cause) -> bool:
        """Return whether a cause is the right one."""
        return cause[0] in self.effects and (not self.place or cause[1] == self.place)

    def named_by(self, answer: Answer) -> list[Mapping[str, Any]]:
        """Return the findings that are right, by themselves or among their equals."""
        return [f for f in answer.findings if any(map(self.admits, causes_of(f)))]

    def sized_by(self, finding: Mapping[str, Any]) -> bool | None:
        """Return whether a finding has the right size, None where that is not known."""
        known = {name: value for name, value in self.values.items() if name in finding['values']}
        return all(abs(finding['values'][name] - value) <= max(
            3.0 * (finding['deviations'][name] or 0.0), 0.2 * abs(value))
            for name, value in known.items()) if known else None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    parser.add_argument('folder', metavar='FOLDER', help=f'manifests *{ENDING} and {TRUTH}')
    parser.add_argument('--data', metavar='DIR', help='where the files lie, in folders of the '
                        'same names (default: beside the manifests)')
    parser.add_argument('--only', metavar='TEXT', help='pairs whose name contains this text')
    parser.add_argument('--out', metavar='DIR', help='keep the verdicts in this new folder')
    add_json_option(parser)


def load_pairs(folder: Path, data: Path | None) -> list[Pair]:
    """
    Return the pairs of a folder, by name.

    Args:
        folder: of manifests.
        data: where their files lie, None for beside them.

    Raises:
        InputError: there is none, or one of them is not valid.
    """
    paths = sorted(folder.rglob('*' + ENDING))
    if not paths:
        raise InputError(f'{folder}: no *{ENDING}, expected one manifest for each pair')
    if not (folder / TRUTH).is_file():
        raise InputError(f'{folder / TRUTH}: no such file, expected the truth of each pair')
    return [_pair(path, folder, data) for path in paths]


def _pair(path: Path, folder: Path, data: Path | None) -> Pair:
    """Return the Pair of the manifest `path`."""
    content = _table(load_yaml(path), KEYS)
    relative = path.parent.relative_to(folder)
    places = [path.parent, *([data / relative] if data else [])]

    def _text(key: str, default: str | None = None) -> str | None:
        value = content.get(key, default)
        if value is not None and not isinstance(value, str):
            raise InputError(f'{path}: {key}: {str(value)[:40]!r}, expected text')
        return value

    def _texts(key: str) -> tuple[str, ...]:
        value = content.get(key, [])
        value = [value] if isinstance(value, str) else value
        if not isinstance(value, list) or not all(isinstance(x, str) for x in value):
            raise InputError(f'{path}: {key}: {str(value)[:40]!r}, expected a name or a list')
        return tuple(value)

    def _file(key: str, name: str) -> Path:
        for place in places:
            if (place / name).exists():
                return (place / name).resolve()
        raise InputError(f'{path}: {key}: {name}: no such file in '
                         f'{" or ".join(map(str, places))}, expected one')

    def _options(key: str) -> tuple[str, ...] | None:
        text = _text(key)
        try:
            return None if text is None else tuple(shlex.split(text))
        except ValueError as error:
            raise InputError(f'{path}: {key}: {error}, expected options as typed') from None
    logs, model = _texts('log'), _text('model')
    if not logs or model is None:
        raise InputError(f'{path}: {"model" if logs else "log"}: missing, expected a file')
    for key in ('values', 'recorded'):
        if not isinstance(content.setdefault(key, {}), dict):
            raise InputError(f'{path}: {key}: {str(content[key])[:40]!r}, expected keys and '
                             'values')
    pair = Pair(str(relative / path.name.removesuffix(ENDING)), path.parent,
                tuple(_file('log', x) for x in logs),
                tuple(_file('reference', x) for x in _texts('reference')), _file('model', model),
                _text('joint'), _options('import'), content['recorded'], content['values'],
                _texts('free'), _options('diagnose') or ())
    if bool(pair.free) != (bool(pair.reference) and not pair.of_robot):
        raise InputError(f'{path}: free: {list(pair.free)}, expected values of the model that are '
                         'fitted to the reference of a single drive, and only there')
    return pair


def _table(file: Yaml, keys: Sequence[str] | None = None) -> dict[str, Any]:
    """Return the mapping in a YAML file, with no other than some `keys`."""
    if not isinstance(file.content, dict):
        raise InputError(f'{file.path}: {str(file.content)[:40]!r}, expected keys and values')
    for key in file.content:
        if keys is not None and key not in keys:
            raise InputError(f'{file.path}: {key}: {unknown(key, keys)}')
    return file.content


def load_truth(path: Path) -> dict[str, Truth]:
    """Return {name of a pair: Truth} of the file `path`. Raises InputError."""
    out = {}
    for name, value in _table(load_yaml(path)).items():
        if value == NONE:
            out[name] = Truth(())
            continue
        value = value if isinstance(value, dict) else {'effect': value}
        effects, place = value.get('effect'), value.get('place', '')
        sizes = value.get('values', {})
        effects = [effects] if isinstance(effects, str) else effects
        if (set(value) - {'effect', 'place', 'values'} or not isinstance(place, str)
                or not effects or not isinstance(sizes, dict)
                or not isinstance(effects, list)
                or not all(isinstance(e, str) for e in effects)):
            raise InputError(f'{path}: {name}: {str(value)[:60]!r}, expected none, or effect (an '
                             'id or several) and, of a robot, place; values')
        for effect in effects:
            if effect not in EFFECT_IDS:
                raise InputError(f'{path}: {name}: {unknown(effect, EFFECT_IDS)}')
        out[name] = Truth(tuple(effects), place, {k: float(v) for k, v in sizes.items()})
    return out


class Runner:
    """Runs commands that write into a folder; what two pairs share is made once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.numbers = count()
        self.made: dict[tuple[Any, ...], str] = {}
        self.commands: list[str] = []
        self.cpu = 0.0

    def command(self, place: Path, *words: str) -> None:
        """Run gearbox_monitor with some `words` in the folder `place`; raises InputError."""
        self.commands.append('gearbox_monitor ' + shlex.join(words))
        start = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([sys.executable, '-m', 'gearbox_monitor.cli.main', *words],
                              cwd=place, capture_output=True, text=True)
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.cpu = end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime
        undecided = done.returncode == 3 and Path(words[-1]).is_file()  # its verdict
        if done.returncode not in (0, 1) and not undecided:
            raise InputError((done.stderr.strip() or 'no message').splitlines()[-1])

    def new(self, ending: str) -> str:
        """Return a new path with this `ending`."""
        return str(self.folder / f'{next(self.numbers):03d}{ending}')

    def once(self, pair: Pair, key: tuple[Any, ...], ending: str, *words: str) -> str:
        """
        Return the file or folder that a command writes, from an earlier pair where there is one.

        Args:
            pair: for which it is needed.
            key: of what it depends on.
            ending: of its name.
            words: of the command; OUT stands for it.
        """
        if key not in self.made:
            path = self.new(ending)
            self.command(pair.folder, *(path if word == 'OUT' else word for word in words))
            self.made[key] = path
        return self.made[key]

    def logs(self, pair: Pair, paths: Sequence[Path]) -> list[str]:
        """Return logs as diagnose reads them."""
        if pair.import_ is None:
            return [str(path) for path in paths]
        return [self.once(pair, (path, pair.folder, pair.import_), '', 'import', str(path),
                          *pair.import_, 'OUT') for path in paths]

    def values(self, pair: Pair) -> str | None:
        """Return the file of what a pair states beside the model, None without any."""
        if not pair.values:
            return None
        text = yaml.safe_dump(dict(pair.values))
        path = self.made.setdefault((text,), self.new('.values.yaml'))
        Path(path).write_text(text, encoding='utf-8')
        return path

    def verdict(self, pair: Pair) -> dict[str, Any]:
        """Return the verdict on a pair and, beside it, what the baseline needs."""
        self.commands = []
        logs, references = self.logs(pair, pair.log), self.logs(pair, pair.reference)
        about = ['--model', str(pair.model), *(['--joint', pair.joint] if pair.joint else [])]
        if pair.recorded:
            about += ['--recorded', *(f'{a}={b}' for a, b in pair.recorded.items())]
        values = self.values(pair)
        if values:
            about += ['--values', values]
        key = (*references, *about, *pair.free)
        knowledge, model = None, str(pair.model)
        if references and pair.of_robot:
            knowledge = self.once(pair, key, '.knowledge', 'learn', *references, *about, '--out',
                                  'OUT')
            about += ['--reference', knowledge]
        elif references:
            model = self.once(pair, key, '.drive.yaml', 'fit', 'model', *references, *about,
                              '--free', *pair.free, '--out', 'OUT')
            about = ['--model', model]
        out = self.new('.verdict.json')
        jobs = [] if pair.of_robot else ['--jobs', '1']
        self.command(pair.folder, 'diagnose', *logs, *about, *jobs, *pair.diagnose, '--json', out)
        return {'verdict': json.loads(Path(out).read_text(encoding='utf-8')), 'cpu': self.cpu,
                'logs': logs, 'model': model, 'values': values, 'knowledge': knowledge}


def causes_of(finding: Mapping[str, Any]) -> list[Cause]:
    """Return the cause that a finding names, and those that it calls confusable."""
    place = finding.get('joint') or finding.get('link') or ''
    out = []
    for name in (finding['effect'], *finding['confusable']):
        effect, _, elsewhere = name.partition('@')
        out.append((effect.partition(' ')[0], elsewhere or place))
    return out


def answer_of(verdict: Mapping[str, Any], cpu: float) -> Answer:
    """
    Return the Answer of a verdict of diagnose.

    Probability is divided equally among the findings and, where there is one, the remainder; that
    of a finding equally among its effect and those that it calls confusable.

    Args:
        verdict: as JSON.
        cpu: s.
    """
    probabilities: dict[Cause, float] = {}
    ranked: list[Cause] = []
    remainder = verdict['verdict'] in ('incomplete', UNKNOWN)
    share = 1.0 / max(len(verdict['findings']) + remainder, 1)
    for finding in verdict['findings']:
        causes = causes_of(finding)
        for cause in causes:
            probabilities[cause] = probabilities.get(cause, 0.0) + share / len(causes)
            ranked.append(cause)
    if remainder:
        probabilities[UNKNOWN, ''] = share
        ranked.append((UNKNOWN, ''))
    ranked += [(effect, '') for effect in verdict.get('ranked', ())]
    return Answer(probabilities, tuple(dict.fromkeys(ranked)), cpu,
                  findings=tuple(verdict['findings']), undecided=verdict['verdict'] == UNDECIDED)


def baseline_of(pair: Pair, run: Mapping[str, Any]) -> Answer:
    """
    Return the Answer of least squares with BIC.

    Args:
        pair: of recordings.
        run: of Runner.verdict.
    """
    began = time.process_time()
    if pair.of_robot:
        gains = ranked_of_robot(run['logs'], pair.model, run['values'], run['knowledge'],
                                pair.recorded)
    elif pair.joint and not pair.reference:
        raise InputError('of a joint in the file of a simulator there is no baseline')
    else:
        gains = ranked_of_drive(run['logs'], load_model(run['model']))
    chosen = {gains[0][0]: 1.0} if gains and gains[0][1] > 0.0 else {}
    return Answer(chosen, tuple(cause for cause, _ in gains), time.process_time() - began)


def scores(answers: Mapping[str, Answer], truths: Mapping[str, Truth]) -> dict[str, list[float]]:
    """
    Return the trials behind each figure of merit.

    detection: of pairs with a change, whether one is seen; false alarm: of those without;
    isolation: of a change that is seen, the probability of its true cause; rank: of a change, one
    over the rank of its true cause, 0 where it is not ranked; cpu: s. Of diagnose also: named, of
    a change, whether a finding is right; size, of those, whether its values are (within three
    deviations or 20 %); alone, of those, whether no other finding is beside it; undecided, of all
    pairs. Refused pairs count in none.

    Args:
        answers: by pair.
        truths: by pair.
    """
    out: dict[str, list[float]] = {
        'detection': [], 'false alarm': [], 'isolation': [], 'rank': [], 'named': [], 'size': [],
        'alone': [], 'undecided': [], 'cpu': []}
    of_diagnose = any(a.findings or a.undecided for a in answers.values())
    for name, answer in answers.items():
        truth = truths.get(name)
        if truth is None or answer.refused:
            continue
        detected = bool(answer.probabilities)
        out['cpu'].append(answer.cpu)
        if of_diagnose:
            out['undecided'].append(float(answer.undecided))
            right = truth.named_by(answer)
            out['named'] += [float(bool(right))] * bool(truth.effects)
            out['alone'] += [float(len(answer.findings) == len(right))] * bool(right)
            out['size'] += [float(sized) for sized in map(truth.sized_by, right[:1])
                            if sized is not None]
        if not truth.effects:
            out['false alarm'].append(float(detected))
            continue
        out['detection'].append(float(detected))
        if detected:
            out['isolation'].append(math.fsum(
                p for cause, p in answer.probabilities.items() if truth.admits(cause)))
        out['rank'].append(next((1.0 / number for number, cause in enumerate(answer.ranked, 1)
                                 if truth.admits(cause)), 0.0))
    return out


def _bars(methods: Mapping[str, Mapping[str, Answer]], truths: Mapping[str, Truth]) -> BarTable:
    """Return the figures of some `methods` {name: answers}; they are reported, not judged."""
    bars = BarTable()
    for method, answers in methods.items():
        for figure, trials in scores(answers, truths).items():
            if figure in ('detection', 'false alarm', 'named', 'size', 'alone', 'undecided'):
                if not trials:
                    continue
                bars.share(f'{method}: {figure}', trials)
            elif trials:
                bars.judge(f'{method}: {figure}' + (', s per pair' if figure == 'cpu' else ''),
                           math.fsum(trials) / len(trials), interval=intervals.mean(trials),
                           count=f'{len(trials)}')
        refused = sum(bool(a.refused) for a in answers.values())
        bars.judge(f'{method}: refused', float(refused), count=f'{refused}/{len(answers)}')
    return bars


def _lines(methods: Mapping[str, Mapping[str, Answer]], truths: Mapping[str, Truth],
           refused: Mapping[str, str]) -> list[str]:
    """Return a line for each pair: truth, what each of the `methods` says, and refusals."""
    names = list(next(iter(methods.values())))
    rows = [['pair', 'truth', *methods]]
    for name in names:
        truth = truths.get(name)
        words = 'not stated' if truth is None else NONE if not truth.effects else (
            ' or '.join(truth.effects) + (f'@{truth.place}' if truth.place else ''))
        rows.append([name, words, *(answers[name].words for answers in methods.values())])
    widths = [max(map(len, column)) for column in zip(*rows)]
    return ['  '.join(f'{cell:<{w}}' for cell, w in zip(row, widths)).rstrip() for row in rows] + [
        f'{name}: {reason}' for name, reason in refused.items()]


def measure(pairs: Sequence[Pair], truth: Path, folder: Path) -> dict[str, Any]:
    """
    Diagnose all pairs, write the verdicts, open the truth and score; returns plain data.

    Args:
        pairs: to diagnose.
        truth: file that is opened when all verdicts are written.
        folder: for verdicts and what is made on the way.
    """
    runner, show = Runner(folder), progress_line()
    own: dict[str, Answer] = {}
    baseline: dict[str, Answer] = {}
    commands: dict[str, list[str]] = {}
    for number, pair in enumerate(pairs, 1):
        show(f'{number}/{len(pairs)} {pair.name}')
        nothing = Answer({}, (), 0.0)
        try:
            run = runner.verdict(pair)
            own[pair.name] = answer_of(run['verdict'], run['cpu'])
        except InputError as error:
            own[pair.name] = baseline[pair.name] = replace(nothing, refused=str(error))
        else:
            try:
                baseline[pair.name] = baseline_of(pair, run)
            except InputError as error:
                baseline[pair.name] = replace(nothing, refused=str(error))
        commands[pair.name] = runner.commands
    methods = {'diagnose': own, 'least squares': baseline}
    answers = {method: {name: {'answer': a.words, 'cpu_s': round(a.cpu, 2), 'probabilities': [
        [*cause, p] for cause, p in a.probabilities.items()], 'refused': a.refused or None}
        for name, a in by_pair.items()} for method, by_pair in methods.items()}
    write_json(answers, str(folder / 'answers.json'))
    show('')
    truths = load_truth(truth)
    bars = _bars(methods, truths)
    refused = {f'{name}, {method}': a.refused for method, by_pair in methods.items()
               for name, a in by_pair.items() if a.refused}
    return {'answers': answers, 'commands': commands, 'bars': bars.rows,
            'lines': [*_lines(methods, truths, refused), '', *bar_lines(bars.rows)]}


def run(args: argparse.Namespace) -> int:
    """Run the benchmark with the options `args`; returns the exit code."""
    folder = Path(args.folder)
    pairs = [pair for pair in load_pairs(folder, Path(args.data) if args.data else None)
             if not args.only or args.only in pair.name]
    if not pairs:
        raise InputError(f'--only: {args.only}: no pair, expected a part of a name')
    with tempfile.TemporaryDirectory() as temporary:
        out = Path(args.out or temporary).resolve()
        if args.out:
            try:
                out.mkdir()
            except OSError as error:
                raise InputError(f'{args.out}: {error.strerror}, expected a new folder') from None
        data = measure(pairs, folder / TRUTH, out)
    return finish(data, '\n'.join(data.pop('lines')), args.json)
