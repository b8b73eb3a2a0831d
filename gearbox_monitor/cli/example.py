# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a bag of a simulated drive, without ROS: to try the other commands on.

The drive stands still for --rest s and is then moved by the torque 6 cos(2 pi 0.9 t) +
2 cos(2 pi 2.3 t) N m (arm side), or by another --motion; varied makes this torque rise and fall
within 10 s. The encoders have noise (5 mrad), with --process-noise the torque has noise, too. The
bag contains joint_states with the joints motor and arm and, for scoring, the true torque, as the
plant node publishes them; --encoders leaves one encoder out. --wear widens the backlash of the
model file, --date sets the first stamp: several bags show a gearbox that wears. Effects in the
model file act in the simulated drive. With a controller in it, a setpoint of 0.1 rad per N m takes
the place of the torque, in the bag as well.

It also writes BAG.drive.yaml: the model of the drive that made the bag, with its wear, its
effects and the noise of its torque. With this model, diagnose finds no gap.

usage examples:
  gearbox_monitor example bag           # then: gearbox_monitor diagnose bag --model bag.drive.yaml
  gearbox_monitor example june --date 2026-06-15 --wear 25 --seconds 60 --seed 2
  gearbox_monitor example rough --motion varied --process-noise 0.4
  gearbox_monitor example arm --robot       # logs of a whole arm, healthy and changed
"""
from argparse import Namespace
from dataclasses import replace
from datetime import datetime, timezone
import math
from pathlib import Path

from gearbox_monitor.cli.options import show
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import (
    config_path, expect_outside_of_bag, load_model, save_model)
from gearbox_monitor.plant.simulate import Noise
from gearbox_monitor.recordings.examples import (
    ExampleMotion, NOISE, process_torque, write_example_bag, write_robot_pair)

ARM_JOINT = {'both': '', 'motor': " --recorded-arm ''", 'arm': ''}  # options of who reads the bag


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for name, value, low, high in (('seconds', args.seconds, 1.0, 86400.0),
                                   ('rest', args.rest, 0.0, 86400.0),
                                   ('rate', args.rate, 50.0, 10000.0),
                                   ('process-noise', args.process_noise, 0.0, 1e6),
                                   ('wear', args.wear, 0.0, 1000.0),
                                   ('seed', args.seed, 0, 2 ** 31 - 1)):
        if not (math.isfinite(value) and low <= value <= high):
            raise InputError(f'--{name}: {value:g}, expected {low:g} to {high:g}')
    bag = Path(args.bag)
    written = bag.with_name(f'{bag.name}.drive.yaml')
    for path, kind in ((bag, 'bag'), (written, 'bag, whose model this file would be')):
        if path.exists() and not (args.robot and path == written):
            raise InputError(f'{path}: exists, expected the name of a new {kind}')
    expect_outside_of_bag(bag)
    if args.robot:
        return _write_robot(args)
    model_file = str(args.model or config_path('drive.yaml'))
    noise = Noise((0.0, 0.0, args.process_noise, 0.0), NOISE.measurement)
    model = load_model(model_file)
    model = model.with_(half_gap=model.transmission.half_gap * (1.0 + 0.01 * args.wear))
    motion = ExampleMotion(args.seconds, args.rate, rest=args.rest, kind=args.motion)
    if args.date:
        motion = motion._replace(start=_seconds(args.date))
    write_example_bag(bag, model, motion, args.seed, noise=noise, truth=True,
                      encoders=args.encoders)
    save_model(written, replace(model, process_torque=process_torque(model, noise, args.rate)),
               [f'The drive that made {bag.name}, of gearbox_monitor example'])
    samples = round(args.rest * args.rate) + round(args.seconds * args.rate)
    data = {'bag': args.bag, 'samples': samples, 'rate_hz': args.rate, 'seed': args.seed,
            'duration_s': args.rest + args.seconds, 'model': model_file,
            'drive_model': str(written)}
    show(args, data, lambda: (
        f'{args.bag}: {samples} samples, {data["duration_s"]:g} s, {args.rate:g} Hz, model '
        f'{model_file}\n{written}: the model of the drive that made it, in which\n'
        f'  gearbox_monitor diagnose {args.bag} --model {written}{ARM_JOINT[args.encoders]}\n'
        'finds no gap'))
    return 0


def _write_robot(args: Namespace) -> int:
    """Write the pair of logs of the example arm; returns the exit code."""
    files = [f'{args.bag}/{name}' for name in
             write_robot_pair(Path(args.bag), args.seconds, args.seed)]
    show(args, {'folder': args.bag, 'files': files, 'seed': args.seed}, lambda: (
        f'{", ".join(files)}\ncompare them: gearbox_monitor diagnose {files[2]} '
        f'--model {files[0]} --reference {files[1]}'))
    return 0


def _seconds(date: str) -> int:
    """Return the Unix time of midnight UTC of the `date`. Raises InputError."""
    try:
        day = datetime.strptime(date, '%Y-%m-%d').replace(tzinfo=timezone.utc)
    except ValueError:
        raise InputError(f'--date: {date!r}, expected a date as 2026-06-15') from None
    return int(day.timestamp())
