# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Learn a healthy robot from its logs: friction, rotors, ripple, and how much healthy parts differ.

The file that it writes is a reference for diagnose: a comparison then takes about a second. Record
30 s or more of a motion like the one to compare, better two motions, without a load.

usage examples:
  gearbox_monitor learn june1 june2 --model robot.xml --out robot.knowledge
  gearbox_monitor learn log.csv --model arm.urdf --values values.yaml --out arm.knowledge
  gearbox_monitor diagnose today --model robot.xml --reference robot.knowledge
"""
from argparse import Namespace

from gearbox_monitor.cli.options import names_of, reading_of_robot, robot_of, show
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.knowledge_file import save_knowledge, SUFFIX
from gearbox_monitor.files.yaml_files import expect_new_file
from gearbox_monitor.library.robot import learn_robot
from gearbox_monitor.report.words import counted


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if not args.out.endswith(SUFFIX):
        raise InputError(f'--out: {args.out}, expected a name that ends with {SUFFIX}')
    learnt = [path for path in args.log if path.endswith(SUFFIX)]
    if learnt:
        raise InputError(f'{", ".join(learnt)}: written by learn, expected logs')
    expect_new_file(args.out)
    knowledge, notes = learn_robot(args.log, robot_of(args), topic=args.topic,
                                   recorded=names_of(args), reading=reading_of_robot(args))
    save_knowledge(args.out, knowledge)
    rows = {joint: (float(d), [name for j, name in knowledge.shapes if j == i])
            for i, (joint, d) in enumerate(zip(knowledge.joints, knowledge.dispersion))}
    data = {'out': args.out, 'seconds': knowledge.seconds, 'parts': knowledge.parts,
            'kind': knowledge.kind, 'rate': knowledge.rate, 'warnings': notes,
            'joints': {joint: {'dispersion': d, 'shapes': names}
                       for joint, (d, names) in rows.items()}}
    show(args, data, lambda: '\n'.join([
        f'{args.out}: {knowledge.seconds:.0f} s of {counted(len(args.log), "log")}, '
        f'{knowledge.parts} parts compared', *(f'  note: {note}' for note in notes),
        *(f'  {joint}: parts differ by {dispersion ** 0.5:.1f} times the noise; '
          f'{", ".join(names) or "no further shape"}'
          for joint, (dispersion, names) in rows.items())]))
    return 0
