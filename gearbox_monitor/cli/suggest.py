# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Suggest the motion that distinguishes effects which a recording could not separate.

VERDICT is verdict.json of a diagnosis (diagnose --out DIR), or DIR itself: the identified effect,
at its size, against those listed as confusable. Without it, --pair names two effects of the
library, at a usual size. Some sixty torque signals that the plant node knows are simulated within
the limits; d s2 is the evidence for the effect that the other one cannot imitate, above 20 is
enough. Limits are on the arm side; the simulation starts at rest and has no end stops.

usage examples:
  gearbox_monitor suggest found --model drive.yaml --max-torque 5 --max-speed 20 --max-travel 3
  gearbox_monitor suggest --pair actuator_lag actuator_delay --model drive.yaml --max-torque 5
  gearbox_monitor suggest found --model robot.xml --joint elbow --max-torque 5
  gearbox_monitor suggest found --model drive.yaml --max-torque 5 --out motion.yaml
  ros2 run gearbox_monitor plant_node --ros-args --params-file motion.yaml
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
import math
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from gearbox_monitor.cli.inputs import add_model_arguments, load_drive
from gearbox_monitor.cli.options import show
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.diagnosis.joint.isolability import Limits, suggest
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.files.opening import read_json
from gearbox_monitor.files.yaml_files import expect_folder_of
from gearbox_monitor.plant.drive import expect_torque_input
from gearbox_monitor.plant.effects import library
from gearbox_monitor.presentation import on_axis

PRINTED = 3
NOISE = 1e-3  # rad, without a recording


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('verdict', nargs='?', metavar='VERDICT',
                        help='verdict.json of diagnose, or its directory')
    parser.add_argument('--pair', nargs=2, metavar='ID',
                        help='distinguish the first from the second')
    add_model_arguments(parser)
    parser.add_argument('--max-torque', type=float, required=True, metavar='NM',
                        help='largest torque')
    parser.add_argument('--max-speed', type=float, default=math.inf, metavar='RAD_S',
                        help='largest speed (default: no limit)')
    parser.add_argument('--max-travel', type=float, default=math.inf, metavar='RAD',
                        help='largest travel to either side of the start (default: no limit)')
    parser.add_argument('--seconds', type=float, default=12.0, metavar='S',
                        help='length of the recording (default: %(default)g)')
    parser.add_argument('--noise', type=float, metavar='RAD',
                        help=f'of the encoders (default: that of the verdict, else {NOISE:g})')
    parser.add_argument('--out', metavar='FILE', help='write parameters of the plant node')
    parser.add_argument('--csv', metavar='FILE', help='write t (s), u (N m)')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for option in ('max_torque', 'max_speed', 'max_travel', 'seconds', 'noise'):
        value = getattr(args, option)
        if value is not None and not value > 0.0:
            raise InputError(f'--{option.replace("_", "-")}: {value:g}, expected a number > 0')
    if not 4.0 <= args.seconds <= 120.0:
        raise InputError(f'--seconds: {args.seconds:g}, expected 4 to 120')
    names = list(filter(None, (args.out, args.csv)))
    for name in names:
        expect_folder_of(name)
        if names.count(name) > 1:
            raise InputError(f'{name}: named twice, expected a file for each output')
        if Path(name).is_dir():
            raise InputError(f'{name}: a folder, expected the name of a file')
    effects, pairs, sigma = _question(args)
    model = load_drive(args)
    expect_torque_input(model, args.model)
    limits = Limits(args.max_torque, args.max_speed, args.max_travel)
    with progress_bar('suggest') as progress:
        motions = suggest(model, effects, pairs, limits, np.array(sigma), args.seconds,
                          progress=progress)
    if not motions:
        raise InputError(f'--max-speed, --max-travel: no motion of {args.seconds:g} s stays '
                         'within them, expected wider limits')
    motion = motions[0]
    if args.out:
        Path(args.out).write_text(yaml.safe_dump({'plant': {'ros__parameters': _plant(motion)}}),
                                  encoding='utf-8')
    if args.csv:
        np.savetxt(args.csv, np.column_stack(motion.torque()), '%.9g', ',', header='t,u',
                   comments='')
    data = [{'excitation': _plant(m), 'seconds': m.seconds, 'least': m.least,
             'separation': {f'{a}|{b}': v for (a, b), v in m.separation.items()},
             'reached': vars(m.reached)} for m in motions]
    show(args, data, lambda: text(motions, args, model.axis))
    return 0 if motion.least > THRESHOLDS.isolable else 1


def _question(args: Namespace) -> tuple[dict[str, Any], list[tuple[str, str]], list[float]]:
    """Return (effects {id: values or None}, pairs [(a, b)], sigma [2])."""
    library_ids = [name for name, effect in library().items() if effect.location]
    if bool(args.pair) == bool(args.verdict):
        raise InputError('expected either VERDICT or --pair ID ID')
    if args.pair:
        for name in args.pair:
            if name not in library_ids:
                raise InputError(f'--pair: {name!r}: {unknown(name, library_ids)}')
        if args.pair[0] == args.pair[1]:
            raise InputError(f'--pair: {args.pair[0]!r} twice, expected two effects')
        return {}, [(args.pair[0], args.pair[1])], [args.noise or NOISE] * 2
    path = Path(args.verdict)
    path = path / 'verdict.json' if path.is_dir() else path
    data = read_json(path, 'verdict.json of diagnose --out')
    try:
        effects, rivals = data['params'], data['confusable']
        sigma = [args.noise or s or NOISE for s in data['sigma']]
        pairs = [(a, b) for a in effects if a in library_ids for b in rivals
                 if b in library_ids]
    except (KeyError, TypeError, AttributeError):
        raise InputError(f'{path}: no verdict of diagnose, expected verdict.json of '
                         'diagnose --out') from None
    if not pairs:
        raise InputError(f'{path}: nothing is confusable there, expected a verdict with effects '
                         'to distinguish, or --pair')
    return effects, pairs, sigma


def _plant(motion: Any) -> dict[str, Any]:
    """Return the parameters of the plant node that run `motion`."""
    return {'excitation': motion.kind, 'amplitudes': [float(a) for a in motion.amplitudes],
            'frequencies': [float(f) for f in motion.frequencies],
            'period': float(motion.seconds)}


def text(motions: Sequence[Any], args: Namespace, axis: str = 'rotary') -> str:
    """
    Return the most informative motions as lines of at most 80 columns.

    Args:
        motions: in order of their evidence.
        args: options of the command.
        axis: of the drive, for units.

    """
    lines = []
    for k, motion in enumerate(motions[:PRINTED]):
        sizes = ', '.join(f'{a:.3g}' for a in motion.amplitudes)
        rates = ', '.join(f'{f:.3g}' for f in motion.frequencies)
        reached = motion.reached
        entry = [f'{k + 1}. {motion.kind}: {sizes} N m at {rates} Hz, {motion.seconds:g} s',
                 f'   reaches {reached.torque:.3g} N m, {reached.speed:.3g} rad/s, '
                 f'{reached.travel:.3g} rad from the start']
        lines += [on_axis(line, axis) for line in entry]
        for (a, b), value in sorted(motion.separation.items(), key=lambda item: item[1]):
            lines.append(f'   {a} from {b}: d s2 {value:.3g}'
                         + ('' if value > THRESHOLDS.isolable else ', not enough'))
    if motions[0].least <= THRESHOLDS.isolable:
        lines.append('no motion within the limits separates all of them: allow more, record '
                     'longer, or lower the noise')
    lines += [f'written: {name}' for name in (args.out, args.csv) if name]
    return '\n'.join(lines)
