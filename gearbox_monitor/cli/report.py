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
Write one page about a recording: the state of the gearbox, and the trust in its estimates.

One HTML file that loads nothing, for a screen, a phone or paper: torque over twist minute by
minute, backlash with alarms, prediction errors with two sigma, NIS, levels of trust over time,
rate and dropouts of the input, parameters and versions. Drag in a chart to zoom.

Estimates in the bag are shown as they were published; without any, or with --model, --params,
--filter or --replay, the estimator is run on the recorded samples. Signals over time are
thinned to envelopes of lowest and highest value, so that an hour makes a page of some MB.

A recording of several gearboxes gets a page of the robot, one row per joint, the worst first, and
beside it the page of each joint. --topic GEARBOX writes the page of one joint alone; of a bag
without estimates that is --topic joint_states/GEARBOX.

usage examples:
  gearbox_monitor report gearbox_2026_11_21-10_00_00
  gearbox_monitor report BAG --model drive.yaml --params joint3.yaml --out joint3.html
  gearbox_monitor report BAG --replay --filter ukf --out ukf.html
  gearbox_monitor report BAG --json - | jq .gap_rad
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gearbox_monitor.bag.joint_input import recorded_inputs, topics_called
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.cli.options import (
    add_estimator_arguments, bag_arguments, check_filter, dump, estimator_options, expect_new_file,
    JSON_FILE_HELP, plain, warn, write_new)
from gearbox_monitor.cli.progress import percent_bar
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import gearboxes_of, load_model
from gearbox_monitor.parameters import FILTER_NAMES
from gearbox_monitor.report.recording_page import figures, headline, recording_page
from gearbox_monitor.report.robot_page import robot_page
from gearbox_monitor.report.timeline import Timeline
from gearbox_monitor.report.timeline_source import (
    EstimatorChoice, RecordingFacts, TimelineSource)


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_estimator_arguments(parser)
    parser.add_argument('--out', metavar='FILE', help='page to write (default: name of BAG.html, '
                        'here)')
    parser.add_argument('--filter', metavar='F', help='filter to run: ' + ', '.join(FILTER_NAMES))
    parser.add_argument('--replay', action='store_true',
                        help='run the estimator although the bag holds estimates')
    parser.add_argument('--json', metavar='FILE',
                        help='write the figures as JSON' + JSON_FILE_HELP)


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    out = Path(args.out or f'{Path(args.bag).resolve().stem}.html')
    expect_new_file(out)
    expect_new_file(args.json)
    with open_bag(args.bag) as reader:
        estimators = sorted(recorded_inputs(reader, args.topic))
        if args.params and not estimators and topics_called(reader, args.topic):
            estimators = [f'{args.topic}/{gearbox}'
                          for gearbox in gearboxes_of(args.params, 'estimator')]
    data, text = _robot(args, out, estimators) if len(estimators) > 1 else _single(args, out)
    data = {'summary': data['headline'], **data}
    if args.json == '-':
        print(dump(data))
        return 0
    if args.json:
        write_new(args.json, dump(data) + '\n')
    print(f'{data["headline"]}\n{out}: {out.stat().st_size / 1e6:.1f} MB, {text}')
    return 0


def _single(args: Namespace, out: Path) -> tuple[dict[str, Any], str]:
    """Write the page of one gearbox; return its figures and the size of the recording."""
    timeline, facts = _recorded(args, args.topic, 'report')
    write_new(out, recording_page(timeline, facts, _name(args),
                                  bag_arguments(args.bag, args.topic)))
    return plain({'bag': str(args.bag), 'page': str(out), 'headline': headline(timeline)[0],
                  **figures(timeline, facts)}), (
        f'{timeline.last:.1f} s, {timeline.samples} samples, '
        f'{"live" if facts.live else "replayed"} estimates')


def _robot(args: Namespace, out: Path, estimators: Sequence[str]
           ) -> tuple[dict[str, Any], str]:
    """Write the page of all `estimators`, and one of each beside it; return as _single."""
    names = [node.rsplit('/', 1)[1] for node in estimators]
    if len(set(names)) < len(names):
        names = [node.strip('/').replace('/', '_') for node in estimators]
    pages = {name: out.with_name(f'{out.stem}.{name}.html') for name in names}
    for page in pages.values():
        expect_new_file(page)
    joints, bags = {}, {name: bag_arguments(args.bag, node)
                        for name, node in zip(names, estimators)}
    for name, node in zip(names, estimators):
        joints[name] = _recorded(args, node, name)
        write_new(pages[name], recording_page(
            *joints[name], f'{_name(args)}, {name}', bags[name]))
    overview = robot_page(
        joints, {name: path.name for name, path in pages.items()}, _name(args), bags)
    write_new(out, overview.html)
    rows = {name: {'page': str(pages[name]), 'headline': headline(timeline)[0],
                   **figures(timeline, facts)} for name, (timeline, facts) in joints.items()}
    return plain({'bag': str(args.bag), 'page': str(out), 'headline': overview.headline,
                  'joints': rows}), (
        f'{len(joints)} joints, each with its page: {out.stem}.JOINT.html')


def _name(args: Namespace) -> str:
    """Return what pages call the recording."""
    return '/'.join(Path(args.bag).parts[-2:])


def _recorded(args: Namespace, topic: str, task: str) -> tuple[Timeline, RecordingFacts]:
    """Return what the recording shows of the estimator of `topic`; `task`: for the progress."""
    parameters, model_file = estimator_options(args, topic)
    if args.filter:
        parameters['filter'] = check_filter(args.filter)
    model = load_model(model_file) if model_file else None
    with open_bag(args.bag) as reader, percent_bar(task) as bar:
        source = TimelineSource(
            reader, topic, EstimatorChoice(model, parameters, args.replay),
            lambda share: bar.update(100.0 * share - bar.n))
        timeline, facts = source.run()
    warn(args, facts.notes)
    if not timeline.samples:
        raise InputError(f'{args.bag}: topic {source.topic} holds no sample, expected some')
    return timeline, facts
