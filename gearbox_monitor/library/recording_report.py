# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a bag, and of each gearbox in it."""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import (
    expect_new_file, gearboxes_of, load_parameters, plain, write_new)
from gearbox_monitor.library.progress import Progress, reported
from gearbox_monitor.library.simulator_file import expect_path, load_model
from gearbox_monitor.parameters import SETTINGS
from gearbox_monitor.presentation import Shown
from gearbox_monitor.recordings.joint_input import bag_arguments, recorded_inputs, topics_called
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.report.recording_page import figures, headline, recording_page, robot_page
from gearbox_monitor.report.timeline import recorded_timeline, RecordingFacts, Timeline


@dataclass(frozen=True, repr=False)
class ReportPages(Shown):
    """
    The pages of a recording.

    page: file of the first one; headline: its sentence; figures: of it, as `report --json` prints
    them; pages {gearbox: file}, empty for one gearbox; extent: how much is on them; notes.
    """

    page: Path
    headline: str
    figures: Mapping[str, Any]
    pages: Mapping[str, Path]
    extent: str
    notes: tuple[str, ...]


def write_report(bag: str | Path, out: str | Path | None = None, *, topic: str = JOINT_STATES,
                 model: str | Path | None = None, parameters: str | Path | None = None,
                 filter: str | None = None,  # noqa: A002
                 reading: ReadOptions = BY_NAMES, progress: Progress | None = None
                 ) -> ReportPages:
    """
    Write the page of a bag: the state of the gearbox, and the trust in its estimates.

    The estimator is run on the recorded samples, from its recorded snapshots on, as `replay` does;
    a model, parameters or a filter replace what is recorded.

    Args:
        bag: bag folder or MCAP file.
        out: file of the page, None: the name of the bag with .html, in the working directory.
        topic: of the inputs, or the name of a gearbox.
        model: model file that replaces the recorded model.
        parameters: parameter file of the estimator.
        filter: to run.
        reading: how columns are read whose names and units do not say it.
        progress: called with (done, total, text); None shows a bar or, in a pipe, lines.

    Returns:
        The pages; of several gearboxes one of all, and one of each.

    Raises:
        InputError: the bag, or a file, is unusable, or a page exists.
    """
    path = expect_path(bag, 'bag', 'a bag folder or an MCAP file')
    page = Path(out or f'{path.resolve().stem}.html')
    expect_new_file(page)
    with open_recording(path, reading, topic) as reader:
        estimators = sorted(recorded_inputs(reader, topic))
        if parameters and not estimators and topics_called(reader, topic):
            estimators = [f'{topic}/{gearbox}'
                          for gearbox in gearboxes_of(parameters, 'estimator')]

    def recorded(node: str, task: str, report: Progress) -> tuple[Timeline, RecordingFacts]:
        """Return Timeline and facts of a `node`; `report` of the `task` takes its progress."""
        values = load_parameters(parameters, 'estimator', SETTINGS, node) if parameters else {}
        file = model or values.pop('model', '')
        values.pop('model', None)
        if filter:
            values['filter'] = filter
        drive = load_model(file) if file else None
        with open_recording(path, reading, topic) as opened:
            timeline, facts = recorded_timeline(
                opened, node, drive, values, lambda share: report(share, 1.0, task))
        if not timeline.samples:
            raise InputError(f'{path}: topic {node} holds no sample, expected some')
        return timeline, facts
    with reported('report', progress) as report:
        if len(estimators) > 1:
            return _of_robot(str(bag), page, estimators,
                             lambda node, task: recorded(node, task, report))
        timeline, facts = recorded(topic, 'report', report)
    write_new(page, recording_page(timeline, facts, _name(bag), bag_arguments(bag, topic)))
    said = headline(timeline, facts)[0]
    return ReportPages(page, said, plain({
        'summary': said, 'bag': str(bag), 'page': str(page), 'headline': said,
        **figures(timeline, facts)}), {}, (
            f'{timeline.last:.1f} s, {timeline.samples} samples'), tuple(facts.notes))


def _of_robot(bag: str, page: Path, estimators: Sequence[str],
              recorded: Callable[[str, str], tuple[Timeline, RecordingFacts]]) -> ReportPages:
    """Write the page of all `estimators`, and one of each."""
    names = [node.rsplit('/', 1)[1] for node in estimators]
    if len(set(names)) < len(names):
        names = [node.strip('/').replace('/', '_') for node in estimators]
    pages = {name: page.with_name(f'{page.stem}.{name}.html') for name in names}
    for new in pages.values():
        expect_new_file(new)
    joints, bags = {}, {name: bag_arguments(bag, node) for name, node in zip(names, estimators)}
    for name, node in zip(names, estimators):
        joints[name] = recorded(node, name)
        write_new(pages[name], recording_page(
            *joints[name], f'{_name(bag)}, {name}', bags[name]))
    html, said = robot_page(
        joints, {name: path.name for name, path in pages.items()}, _name(bag), bags)
    write_new(page, html)
    rows = {name: {'page': str(pages[name]), 'headline': headline(timeline, facts)[0],
                   **figures(timeline, facts)} for name, (timeline, facts) in joints.items()}
    notes = dict.fromkeys(note for _, facts in joints.values() for note in facts.notes)
    return ReportPages(page, said, plain({
        'summary': said, 'bag': bag, 'page': str(page), 'headline': said,
        'joints': rows}), pages, (
            f'{len(joints)} joints, each with its page: {page.stem}.JOINT.html'), tuple(notes))


def _name(bag: str | Path) -> str:
    """Return the name of the recording on pages."""
    return '/'.join(Path(bag).parts[-2:])
