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
Write a model, such as the closed one of diagnose, into the file of your simulator.

Edits the values of one joint in an MJCF file and nothing else: comments and formatting stay. One
joint takes a model with transmission.kind: rigid; for one with backlash and stiffness it becomes
the joint of the arm, and the motor's joint with the actuator is added beside it. --arm-joint names
the arm's joint where the file has both. What MuJoCo cannot express is listed with the reason.
Needs MuJoCo 4.0 (pip install 'gearbox_monitor[mujoco]').

usage examples:
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow --out fits.xml
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint m --arm-joint elbow

exit code: 0 all is expressed, 1 some is not, 2 bad usage or input.
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
import difflib
from pathlib import Path
import textwrap

from gearbox_monitor.cli.options import expect_new, write_new
from gearbox_monitor.export.mjcf import refused, values_of
from gearbox_monitor.export.mjcf_file import MjcfDrive, read_mjcf
from gearbox_monitor.export.mjcf_patch import Patch, patched
from gearbox_monitor.files.yaml_files import expect_folder_of, load_model

WIDTH = 80


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('model', metavar='MODEL', help='model file, such as drive.closed.yaml')
    parser.add_argument('--to', choices=('mjcf',), required=True, help='format of the file')
    parser.add_argument('--into', metavar='FILE', required=True,
                        help='file of the simulator that is patched; it stays as it is')
    add_joint_arguments(parser, '--arm-joint', required=True)
    parser.add_argument('--out', metavar='FILE',
                        help='write the patched file (default: print the difference)')


def add_joint_arguments(parser: ArgumentParser, arm: str, required: bool = False) -> None:
    """
    Declare which joint of a simulator's file is the drive.

    Args:
        parser: of the command.
        arm: name of the option for the joint of the arm.
        required: whether a joint must be named.

    """
    parser.add_argument('--joint', metavar='NAME', required=required,
                        help="joint of the simulator's file that the motor drives")
    parser.add_argument(arm, metavar='NAME', dest='model_arm_joint',
                        help="joint of the arm in the simulator's file, where it is another")
    parser.add_argument('--keyframe', metavar='NAME',
                        help='posture in which inertia and weight are taken, a key of the file')
    parser.add_argument('--actuator', metavar='NAME',
                        help='actuator of the joint, where several act on it')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_new(args.out)
    expect_folder_of(args.out)
    values, exported = values_of(load_model(args.model))
    drive = read_mjcf(args.into, args.joint, args.model_arm_joint, args.keyframe, args.actuator)
    patch = patched(drive, values, exported)
    if args.out:
        write_new(args.out, patch.data.decode('utf-8'))
    ending = [f'written {args.out}'] if args.out else ['', *difference(drive, patch)]
    print('\n'.join([*described(patch, drive), *ending]))
    return 1 if refused(exported) else 0


def described(patch: Patch, drive: MjcfDrive) -> list[str]:
    """Return lines about what `patch` changed in the file of `drive`, and what it could not."""
    lines = [f'{drive.path}: {len(patch.changes)} changes']
    for change in patch.changes:
        before = f'{change.before} -> ' if change.before else ''
        lines.append(f'  {change.element}: '
                     + (f'{change.attribute} ' if change.attribute else '')
                     + f'{before}{change.after}')
    for row in patch.exported:
        lines += _wrapped(f'{row.id}: {row.kind}: {row.words}')
    return lines


def _wrapped(words: str) -> Sequence[str]:
    return textwrap.wrap(words, WIDTH, subsequent_indent='  ', break_on_hyphens=False)


def difference(drive: MjcfDrive, patch: Patch) -> list[str]:
    """Return the lines of a unified diff between the file of `drive` and its `patch`."""
    before, after = (data.decode('utf-8').splitlines() for data in (
        drive.document.data, patch.data))
    name = Path(drive.path).name
    return list(difflib.unified_diff(before, after, f'a/{name}', f'b/{name}', lineterm='', n=1))
