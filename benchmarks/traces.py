# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Traces: what small recordings and drawn problems gave, in test/traces.json, beside today's figures.

A trace is a table of figures: of estimates one row for each half second and joint, of health one
for each feature, of a verdict one for each finding; of the rooms on the way, see traced_rooms.
`changed` says which rows moved, so that a change of code shows which seconds of which joint it
changed. Where a change is meant, --update renews the file: commit it alone.

usage examples:
  python -m benchmarks traces             # compare
  python -m benchmarks traces --update
  python -m benchmarks traces --update contest signals  # these alone
"""
import argparse
from collections.abc import Callable, Iterable, Mapping
import copy
import json
import math
from pathlib import Path
import tempfile
from typing import Any, TypeAlias

import numpy as np

from benchmarks import traced_rooms
import gearbox_monitor as gm
from gearbox_monitor.files.knowledge_file import save_knowledge
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.examples import simulated

FILE = Path(__file__).parents[1] / 'test/traces.json'
BLOCK, DT = 0.5, 2e-3  # s
# Of each block: means of these columns, and the share of samples whose flags are clear.
COLUMNS = ('tau_k', 'tau_k_std', 'twist', 'nis', 'smoothed_tau_k')
# Relative change that is one: other processors and libraries differ by less. The search of a
# verdict ends within its own tolerance, and its names are compared as they are.
MOVED = {'estimates': 1e-6, 'health': 1e-4, 'verdict': 1e-2, 'decided': 1e-6}
SMALL = 1e-2  # of the largest figure of a row: below it the change counts against that one
Row: TypeAlias = list[Any]
Trace: TypeAlias = dict[str, dict[str, Row]]  # {kind: {where: figures and words}}

NOMINAL = gm.DriveModel()
WORN = NOMINAL.with_(half_gap=1.25 * NOMINAL.transmission.half_gap)
LOOSE = NOMINAL.with_(effects=[{'id': 'arm_coulomb', 'Cac': 0.3}])
NOISE = Noise((0.0, 0.0, 0.4, 0.4), (2e-3, 2e-3))


def drive_log(true: gm.DriveModel, seconds: float = 6.0, noise: Noise = NOISE,
              encoders: tuple[str, ...] = ('motor', 'arm')) -> dict[str, Array]:
    """Return columns of a recording of the drive `true`, with its `noise` and `encoders`."""
    t = np.arange(0.0, seconds, DT)
    u = 5.0 * np.cos(5.7 * t) + 2.0 * np.cos(14.5 * t)
    y = simulate(true, u, DT, noise, 3).y
    return {'t': t, 'torque': u, **{name: y[:, k] for k, name in enumerate(('motor', 'arm'))
                                    if name in encoders}}


def damaged() -> dict[str, Array]:
    """Return a recording with a dropout, missing readings, an outlier and a repeated stamp."""
    log = drive_log(NOMINAL)
    log['arm'][500:520], log['torque'][900:903] = np.nan, np.nan
    log['motor'][1200] += 0.5
    log['t'][1500] = log['t'][1499]
    keep = np.r_[0:2000, 2100:len(log['t'])]
    return {name: column[keep] for name, column in log.items()}


def estimates(log: Mapping[str, Array], **changes: object) -> Trace:
    """Return the trace of the estimates and of the health of a recording of the nominal drive."""
    found = gm.estimate(gm.load_recording(dict(log), NOMINAL, name='log'), drift_window=2.0,
                        **changes)
    rows: dict[str, Row] = {}
    for name in COLUMNS:
        t = found.smoothed_t if name.startswith('smoothed') else found.t
        block = (t / BLOCK).astype(int)
        for k in np.unique(block):
            rows.setdefault(f'{BLOCK * k:.1f} to {BLOCK * (k + 1):.1f} s', []).append(
                float(np.mean(getattr(found, name)[block == k])))
    health = {f'window {k}': [fit.gap, fit.gap_std, fit.stiffness, fit.coulomb]
              for k, fit in enumerate(found.backlash)}
    levels = {name: [level] for name, level in found.levels.items()}
    return {'estimates': rows, 'health': {**health, **levels}}


def verdict(log: Mapping[str, Array]) -> Trace:
    """Return the trace of the verdict on a recording against the nominal drive."""
    found = gm.diagnose(gm.load_recording(dict(log), NOMINAL, name='log'), NOMINAL, jobs=1,
                        only=['arm_coulomb', 'motor_coulomb', 'load_torque', 'backlash_gap'])
    data = found.data
    rows: dict[str, Row] = {'answer': [data['verdict'], data['gap_before'], data['gap_after']]}
    for part in data['findings']:
        rows[part['effect']] = [part['place'], *part['values'].values()]
    return {'verdict': rows}


def robot_verdicts() -> dict[str, Trace]:
    """Return the traces of verdicts on an arm: healthy, and with a load and a rubbing joint."""
    robot, rng = gm.load_robot(config_path('arm6.urdf')), np.random.default_rng(5)
    traces = dict[str, Trace]()
    names = [f'q_{j}' for j in robot.joints] + [f'tau_{j}' for j in robot.joints]
    with tempfile.TemporaryDirectory() as folder:
        log, learnt = Path(folder, 'log.csv'), Path(folder, 'healthy.knowledge')

        def write(rng: np.random.Generator, differs: bool) -> None:
            np.savetxt(log, simulated(robot.file.chain, 9.0, rng, differs), '%.9g', ',',
                       header=','.join(['t', *names]), comments='')
        write(rng, False)
        save_knowledge(learnt, gm.learn(log, robot)[0])
        for name, differs in (('healthy arm', False), ('load and rubbing joint, arm', True)):
            write(copy.deepcopy(rng), differs)
            data = gm.diagnose(log, robot, reference=learnt).data
            rows: dict[str, Row] = {'answer': [data['verdict']]}
            for gap in data['gaps']:
                rows[f'gap of {gap["joint"]}'] = [gap['before'], gap['after']]
            for part in data['findings']:
                rows[f'{part["effect"]} at {part.get("joint") or part.get("link")}'] = [
                    *part['values'].values()]
            traces[name] = {'verdict': rows}
    return traces


TRACES: Mapping[str, Callable[[], Trace]] = {
    'worn, ekf, mixed': lambda: estimates(drive_log(WORN), tau_k_model='mixed'),
    'worn, ekf, elastic': lambda: estimates(drive_log(WORN), tau_k_model='elastic'),
    'worn, ukf': lambda: estimates(drive_log(WORN), filter='ukf'),
    'worn, srukf': lambda: estimates(drive_log(WORN), filter='srukf'),
    'friction, aekf': lambda: estimates(drive_log(LOOSE), filter='aekf'),
    'one encoder, ekf': lambda: estimates(drive_log(NOMINAL, encoders=('motor',))),
    'damaged, ekf, mixed': lambda: estimates(damaged(), tau_k_model='mixed'),
    'friction of the arm, drive': lambda: verdict(drive_log(LOOSE, 8.0, Noise(
        measurement=(2e-3, 2e-3))))}


ROOMS: Mapping[str, Callable[[], Mapping[str, Trace]]] = {
    'drive': lambda: {name: make() for name, make in TRACES.items()}, 'robot': robot_verdicts,
    **{room: lambda room=room, make=make: {room: {'decided': make()}}  # type: ignore[misc]
       for room, make in traced_rooms.ROOMS.items()}}


def traced(rooms: Iterable[str] = ROOMS) -> dict[str, Mapping[str, Trace]]:
    """Return {room: {name: trace}} of the recordings and problems of `rooms`."""
    return {room: ROOMS[room]() for room in rooms}


def changed(before: Mapping[str, Trace], now: Mapping[str, Trace]) -> list[str]:
    """
    Return one line for each row that moved.

    Args:
        before: {recording: trace}, as `traced` returned it.
        now: the same of today's code.
    """
    lines = []
    for name in dict.fromkeys((*before, *now)):
        old, new = before.get(name, {}), now.get(name, {})
        for kind in dict.fromkeys((*old, *new)):
            rows, others = old.get(kind, {}), new.get(kind, {})
            lines += [f'{name}: {kind}, {where}: {_words(rows.get(where))} -> '
                      f'{_words(others.get(where))}' for where in dict.fromkeys((*rows, *others))
                      if not _same(rows.get(where), others.get(where), MOVED[kind])]
    return lines


def _same(old: Row | None, new: Row | None, relative: float) -> bool:
    """Return whether rows agree: words and missing values exactly, figures within `relative`."""
    if old is None or new is None or len(old) != len(new):
        return False
    scale = SMALL * max((abs(x) for x in old if isinstance(x, float)), default=0.0)
    return all(a == b or (isinstance(a, float) and isinstance(b, float) and math.isclose(
        a, b, rel_tol=relative, abs_tol=relative * scale)) for a, b in zip(old, new))


def _words(row: Row | None) -> str:
    if row is None:
        return 'no such row'
    return ' '.join(f'{x:.7g}' if isinstance(x, float) else str(x) for x in row)


def load() -> dict[str, dict[str, Trace]]:
    """Return the stored traces of all rooms."""
    stored: dict[str, dict[str, Trace]] = json.loads(FILE.read_text(encoding='utf-8'))
    return stored


def plain(value: Any) -> Any:
    """Return a trace or a part of one as JSON has it: ten digits, None for what is not finite."""
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    return [None if isinstance(x, float) and not math.isfinite(x) else
            float(f'{x:.10g}') if isinstance(x, float) else x for x in value]


def _text(traces: Mapping[str, Mapping[str, Trace]]) -> str:
    """Return plain `traces` as JSON with a line for each row, so that a diff shows what moved."""
    def lines(value: Any, depth: int) -> str:
        if not isinstance(value, Mapping):
            return json.dumps(value)
        space = ' ' * depth
        return '{\n' + ',\n'.join(f'{space} {json.dumps(key)}: {lines(part, depth + 1)}'
                                  for key, part in value.items()) + f'\n{space}}}'
    return lines(traces, 0) + '\n'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('--update', action='store_true', help='store the traces of this code')
    parser.add_argument('rooms', metavar='ROOM', nargs='*', choices=[[], *ROOMS],
                        help=f'of {", ".join(ROOMS)} (default: all)')


def run(args: argparse.Namespace) -> int:
    """Compare, or store with --update; returns 1 where something moved and is not stored."""
    stored = load() if FILE.exists() else {}
    now = plain(traced(args.rooms or ROOMS))
    lines = [line for room in now for line in changed(stored.get(room, {}), now[room])]
    print('\n'.join(lines) or 'no row moved')
    if args.update:
        FILE.write_text(_text({**stored, **now}), encoding='utf-8')
        return 0
    return int(bool(lines))
