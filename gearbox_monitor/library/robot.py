# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A whole robot: its file, logs, healthy reference, diagnosis of all joints, and watch.

A watch folds recordings as the live node does, to the same bits.
"""
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, UTC
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.diagnosis.robot import knowledge, verdict as balance
from gearbox_monitor.diagnosis.robot.conventions import (
    least_explained, LIMITS as CONVENTION_LIMITS, log_as_read, misfit, named_readings)
from gearbox_monitor.diagnosis.robot.knowledge import Knowledge
from gearbox_monitor.diagnosis.robot.likelihood import RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.robot_log import (
    checked_log, RawLog, RobotLog, SETPOINT, TORQUE)
from gearbox_monitor.diagnosis.robot.rows import RobotModel, rows_of
from gearbox_monitor.diagnosis.robot.servo import with_learnt_servos, with_servos
from gearbox_monitor.diagnosis.robot.verdict import effort_curves, RobotVerdict, verdict_data
from gearbox_monitor.diagnosis.robot.zeros import zeros_in
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.files.knowledge_file import load_knowledge, load_watch, SUFFIX
from gearbox_monitor.files.user_files import plain
from gearbox_monitor.library.progress import Progress, reported
from gearbox_monitor.library.recording import load_recording
from gearbox_monitor.library.simulator_file import expect_path
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.presentation import as_written, percent, Said, said
from gearbox_monitor.recordings.from_bag import (
    ANY, load_locked, load_log, load_values, names_in_log, robot_model, RobotValues)
from gearbox_monitor.recordings.joint_input import find_topic
from gearbox_monitor.recordings.reading import BY_NAMES, open_recording, ReadOptions
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.report.diagnosis_page import by_effect, DiagnosisContext, effort_chart
from gearbox_monitor.report.watch_words import reading_words
from gearbox_monitor.report.words import counted, finding_words, headline
from gearbox_monitor.robot.description import LONGEST, SUFFIXES
from gearbox_monitor.signals.finding import BAD, DataFinding, hurts, judged, WARN
from gearbox_monitor.signals.recording import conventions_of
from gearbox_monitor.signals.stamps import require_stamps
from gearbox_monitor.simulators.robot_model import ChainFile, MODEL_FILES, read_robot
from gearbox_monitor.simulators.robot_patch import closed_file, rollouts, title_of
from gearbox_monitor.simulators.xml_edit import difference
from gearbox_monitor.watch.fold import begin, step
from gearbox_monitor.watch.record import Block, Cutter, DATED, SECOND, Watch, WATCH_SETTINGS


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot: its file in a simulator, and further values that a user states."""

    file: ChainFile
    values: RobotValues

    def __repr__(self) -> str:
        return f'Robot({self.file.path.name}: {", ".join(self.joints)})'

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that move."""
        return tuple(self.file.chain.joints)

    def read_log(self, log: str | Path, joints: Mapping[str, str] | None, topic: str,
                 reading: ReadOptions) -> RobotLog:
        """Return a `log`, see load_recording."""
        return robot_logs(log, self, recorded=joints, topic=topic, reading=reading)[0]


def load_robot(path: str | Path, *, values: str | Path | None = None,
               root: str | Path | None = None) -> Robot:
    """
    Return the robot in an MJCF or URDF file.

    Args:
        path: of the file.
        values: YAML file of further values (docs/robot_gap.md), None for nothing.
        root: folder below which the files lie that it includes, None for its own folder.

    Raises:
        InputError: naming the fault of the file and the expectation.
    """
    path = expect_path(path, 'path', 'an MJCF or URDF file')
    if path.suffix.lower() not in (*SUFFIXES, *MODEL_FILES):
        raise InputError(f'{path}: expected an MJCF (.xml) or URDF file of the whole robot, or a '
                         'model file of a drive; one joint of a robot goes to load_model '
                         '(--joint)')
    stated = None if values is None else str(values)
    file = read_robot(path, root, load_locked(stated))
    return Robot(file, load_values(stated, file))


def recorded_names(words: Iterable[str], option: str = '--recorded') -> dict[str, str]:
    """Return {joint: name in the log} of `words` NAME=LOGNAME of `option`. Raises InputError."""
    names = {}
    for word in words:
        joint, equals, name = word.partition('=')
        if not equals or not name:
            raise InputError(f'{option}: {word!r}, expected NAME=LOGNAME')
        names[joint] = name
    return names


def robot_logs(paths: str | Path | Sequence[str | Path], robot: Robot, *,
               recorded: Mapping[str, str] | None = None, topic: str = JOINT_STATES,
               learnt: bool = False, reading: ReadOptions = BY_NAMES) -> list[RobotLog]:
    """
    Return the checked logs of a robot, with inputs of one kind.

    Args:
        paths: recordings of any kind, one or several.
        robot: of `load_robot`.
        recorded: {joint: its name in the log}, where they differ.
        topic: of the joints, in bags.
        learnt: whether a reference teaches the friction.
        reading: how columns are read whose names and units do not say it.

    Raises:
        InputError: a log cannot be read, has not all joints, or has another kind of input.
    """
    expect_robot(robot)
    for joint in recorded or {}:
        if joint not in (ANY, *robot.joints):
            raise InputError(f'recorded: {unknown(joint, robot.joints)}')
    listed = paths if isinstance(paths, (list, tuple)) else [paths]
    model = robot_model(robot.file, robot.values, learnt)
    read = [str(expect_path(path, 'logs', 'a log')) for path in listed]
    drive = robot.file.drive
    logs = [load_log(path, robot.file, model, robot.values, recorded or {}, topic, reading)
            if drive is None else _drive_log(path, drive, recorded or {}, topic, reading)
            for path in read]
    if not logs:
        raise InputError('logs: none, expected at least one log')
    for log in logs:
        if log.kind != logs[0].kind:
            raise InputError(f'{log.name}: {log.kind}, but {logs[0].name}: {logs[0].kind}; '
                             'expected one kind of input')
    return logs


def _drive_log(path: str, drive: DriveModel, recorded: Mapping[str, str], topic: str,
               reading: ReadOptions) -> RobotLog:
    """Return the log of a `drive` as that of a robot of one joint; see robot_logs."""
    recording, notes = load_recording(path, drive, joints={
        joint: name for joint, name in recorded.items() if joint != ANY}, topic=topic,
        reading=reading).uniform()
    if len(recording.channels) > 1 and drive.transmission.kind != 'rigid':
        raise InputError(f'{path}: two encoders of a drive, expected one with a reference; else '
                         'fit model to the reference, and diagnose with the file that it writes')
    return checked_log(RawLog(
        path, recording.t, {'motor': recording.y[:, recording.channels[0]]},
        {'motor': recording.u}, TORQUE if drive.controller is None else SETPOINT,
        notes=tuple(map(as_written, notes))), ['motor'])


def learn(logs: str | Path | Sequence[str | Path], robot: Robot, *,
                recorded: Mapping[str, str] | None = None, topic: str = JOINT_STATES,
                reading: ReadOptions = BY_NAMES,
                progress: Progress | None = None) -> tuple[Knowledge, list[str]]:
    """
    Return the reference that logs of the healthy robot give, and notes about them.

    Args:
        logs: as `robot_logs` takes them; or one file of the command learn.
        robot: of `load_robot`.
        recorded: {joint: its name in the log}.
        topic: of the joints, in bags.
        reading: how columns are read whose names and units do not say it.
        progress: called with (done, total); None shows a bar or, in a pipe, lines.

    Raises:
        InputError: as of `robot_logs`; or the file is of another robot.
    """
    knowledge, notes, _ = _learnt(logs, robot, recorded, topic, reading, progress)
    return knowledge, [*map(str, _remarks(robot.file)), *notes]


def _learnt(logs: str | Path | Sequence[str | Path], robot: Robot,
            recorded: Mapping[str, str] | None, topic: str, reading: ReadOptions,
            progress: Progress | None) -> tuple[Knowledge, list[str], float]:
    """Return as `learn`, and the least misfit of the logs, 0 where it is unknown."""
    expect_robot(robot)
    paths = [str(path) for path in ([logs] if isinstance(logs, (str, Path)) else logs)]
    if len(paths) == 1 and paths[0].endswith(SUFFIX):
        return load_knowledge(paths[0], robot.file.digest), [], 0.0
    learnt = [path for path in paths if path.endswith(SUFFIX)]
    if learnt:
        raise InputError(f'reference: {", ".join(learnt)} and others, expected logs, or one '
                         'file of learn')
    read = robot_logs(paths, robot, recorded=recorded, topic=topic, learnt=True, reading=reading)
    _, doubts = as_named(read, robot, reading)
    if doubts:
        raise InputError('; '.join(doubts))
    model = robot_model(robot.file, robot.values, True)
    with reported('learn', progress) as report:
        result = with_learnt_servos(knowledge.learn(
            model, read, robot.file.digest, progress=report), model, read)
    notes, floor = [f'{log.name}: {note}' for log in read for note in log.notes], 0.0
    if robot.file.drive is None:  # no known load gives the torque of a drive a scale
        stated = robot_model(robot.file, robot.values, False)
        floor = min(misfit(log, stated, (robot.file.low, robot.file.high)) for log in read)
        axes = {'gaps': [{'joint': link.joint, 'axis': 'prismatic' if link.slides else 'rotary'}
                         for link in robot.file.chain.links]}
        notes += [str(said('reference_differs', finding=finding_words(f.to_dict(), axes)))
                  for f in balance.examined(model, read, result)]
    notes += [str(said('unjudged', place=joint)) for joint in result.unjudged]
    return result, notes, floor


def diagnosed(logs: str | Path | Sequence[str | Path], robot: Robot, *,
              reference: str | Path | Sequence[str | Path] | None,
              effects: Sequence[str] | None, recorded: Mapping[str, str] | None, topic: str,
              reading: ReadOptions, progress: Progress | None
              ) -> tuple[RobotVerdict, dict[str, Any], str | None]:
    """
    Return (verdict on a whole robot, its plain data, the robot's file with the findings or None).

    Args:
        logs: to judge, as `robot_logs` takes them.
        robot: of `load_robot`.
        reference: see `identify.diagnose`.
        effects: ids to try, None for all.
        recorded: {joint: its name in the log}, where they differ.
        topic: of the joints, in bags.
        reading: how columns are read whose names and units do not say it.
        progress: called with (done, total) while the reference is learnt.

    Raises:
        InputError: as of `robot_logs`; or the reference has another kind of input.
    """
    file, values = robot.file, robot.values
    knowledge: Knowledge | None = None
    notes, floor = list[str](), 0.0
    if reference is not None:
        knowledge, notes, floor = _learnt(reference, robot, recorded, topic, reading, progress)
    model = robot_model(file, values, knowledge is not None)
    read = robot_logs(logs, robot, recorded=recorded, topic=topic, reading=reading,
                      learnt=knowledge is not None)
    notes += [*map(str, _remarks(file)),
              *(f'{log.name}: {note}' for log in read for note in log.notes)]
    read, readings = as_named(read, robot, reading, floor)
    if knowledge is not None:
        notes += _notes_of_reference(knowledge, read[0])
    elif values.tolerance is None:
        code = 'taken_tolerances' if read[0].kind == SETPOINT else 'taken_tolerance'
        notes.append(str(said(code, percent=100 * model.tolerance.max(),
                              gain=100 * model.gain_tolerance)))
    verdict = balance.diagnose(model, read, knowledge, effects)
    recorded_too = [log.of_servos is not None for log in read]
    if any(recorded_too) and not (all(recorded_too) and (
            knowledge is None or knowledge.servos)):
        notes.append(str(said('setpoints_unused', why='not every log has them' if not all(
            recorded_too) else 'the reference has none')))
    verdict = with_servos(verdict, model, read, effects, knowledge)
    names = [str(path) for path in ([logs] if isinstance(logs, (str, Path)) else logs)]
    data = plain(verdict_data(verdict)) | {
        'logs': names, 'model': str(file.path), 'model_digest': file.digest,
        'locked': dict(file.locked),
        'references': list(knowledge.references) if knowledge else [],
        'readings': readings, 'options': '', 'rollouts': None, 'closed': None}
    data['warnings'] += notes
    if file.compiled is not None and verdict.findings:
        _confirm(data, plain(rollouts(file, verdict)))
    text, refused = closed_file(file, data['findings'], f'gearbox_monitor {__version__} diagnose')
    data['lacking'] = [f'{title}: {reason}' for title, reason in refused.items()]
    data['changes'] = [] if text is None else difference(
        file.path.name, file.path.read_bytes(), text.encode())
    return verdict, {'summary': headline(data), **data}, text


def context_of_robot(verdict: RobotVerdict, robot: Robot, data: Mapping[str, Any]
                     ) -> DiagnosisContext:
    """
    Return what accompanies a verdict on a robot on its page.

    Args:
        verdict: on all joints.
        robot: that it is about.
        data: the verdict as plain data.
    """
    recordings = verdict.evidence.recordings
    curves = effort_curves(verdict, by_effect(data)[0]['joint'])
    return DiagnosisContext(
        [('worst joint', effort_chart(curves))],
        [(Path(r.name).name, len(r.tests.mask) / r.rate, r.rate) for r in recordings],
        robot.file.chain, np.median(np.concatenate([r.motion.q for r in recordings]), axis=0))


def _notes_of_reference(knowledge: Knowledge, log: RobotLog) -> list[str]:
    """Return where a reference and a `log` differ. Raises InputError: in the kind of input."""
    if knowledge.kind != log.kind:
        raise InputError(f'reference: learnt from {knowledge.kind}, but {log.name} '
                         f'has {log.kind}, expected one kind of input')
    if 0.5 < knowledge.rate / log.rate < 2.0:
        return []
    return [str(said('reference_rate', reference=knowledge.rate, log=log.rate))]


def _confirm(data: dict[str, Any], runs: dict[str, Any]) -> None:
    """Put free `runs` with and without each finding of a diagnosis into its `data`."""
    data['rollouts'] = runs
    for finding in data['findings']:
        name = title_of(finding)
        finding['confirmed'] = None if name in runs['without'] else name not in runs['vetoed']
    data['warnings'] += [f'{name}: free runs in MuJoCo are farther off with it than without'
                         for name in runs['vetoed']]


def _remarks(file: ChainFile) -> list[Said]:
    """Return a note on each doubt of a robot's `file`, and each joint that its balance has not."""
    return [*(as_written(f'{file.path.name}: {doubt}') for doubt in file.doubts),
            *(said('massless', place=joint, file=file.path.name) for joint in file.unread)]


def check_robot(log: str | Path, robot: Robot, *, recorded: Mapping[str, str] | None = None,
                topic: str = JOINT_STATES, reading: ReadOptions = BY_NAMES) -> list[DataFinding]:
    """
    Return findings about a log and its conventions, joint by joint.

    Args:
        log: a recording of any kind.
        robot: of `load_robot`.
        recorded: {joint: its name in the log}, where they differ.
        topic: of the joints, in bags.
        reading: how columns and joints are read.

    Raises:
        InputError: the log cannot be read, has not all joints, or is too short or slow.
    """
    read = robot_logs(log, robot, recorded=recorded, topic=topic, reading=reading)
    checked = read[0]
    parts = len(checked.sections)
    findings = [judged(
        'log', 'length', said('log_length', seconds=checked.seconds, kind=checked.kind,
                              rate=checked.rate, parts=counted(parts, 'part')), values={
            'seconds': checked.seconds, 'rate_hz': checked.rate, 'parts': parts})]
    for note in (*_remarks(robot.file), *checked.notes):
        place = note.numbers.get('place')
        findings.append(judged(place if place in robot.joints else 'log', 'note', note,
                               hurts(diagnosis=WARN)))
    if checked.of_servos is not None:
        findings.append(judged('log', 'used', said('both_used')))
    model = robot_model(robot.file, robot.values, False)
    if checked.kind == TORQUE and model.kp is not None:
        evidence = RobotLikelihood([rows_of(checked, model)])
        findings += [judged('log', 'held setpoint', held, hurts(diagnosis=WARN))
                     for held in balance.held_setpoints(evidence, evidence.fit())]
    as_meant, doubts = as_named(read, robot, reading)
    findings += [judged('conventions', 'reading', as_written(
        doubt.partition(': ')[2]), hurts(diagnosis=BAD)) for doubt in doubts]
    if not doubts:
        findings.append(_agreement(read[0], robot, model))
    if robot.file.drive is None:
        findings += _zeros(as_meant[0], robot, model, reading)
    places = ['log', 'conventions', *robot.joints]
    return sorted(findings, key=lambda finding: places.index(finding.group))


def _agreement(log: RobotLog, robot: Robot, model: RobotModel) -> DataFinding:
    """Return whether the model of a robot explains a `log` in which no reading was named."""
    worst = least_explained(log, model, (robot.file.low, robot.file.high))
    if worst is None:
        return judged('conventions', 'reading', said('conventions_agree'))
    joint, left = robot.joints[worst[0]], worst[1]
    return judged('conventions', 'reading', said('conventions_open', place=joint,
                                                 left=percent(left)), hurts(diagnosis=WARN),
                  {'joint': joint, 'unexplained': left})


def _zeros(log: RobotLog, robot: Robot, model: RobotModel, reading: ReadOptions
           ) -> list[DataFinding]:
    """Return what a `log` leaves open of the zeros of joints, as the user states its reading."""
    names = robot.joints
    zeros = zeros_in(log, model, [names.index(joint) for joint in conventions_of(
        reading.conventions, names)])
    found: list[DataFinding] = []
    if zeros.joint is not None and zeros.rival and abs(zeros.zero) > CONVENTION_LIMITS.turned:
        effect, place = zeros.rival
        found.append(judged('conventions', 'zero', said(
            'zero_or_effect', place=names[zeros.joint], zero=zeros.zero, effect=effect, of=place),
            hurts(diagnosis=WARN), {'joint': names[zeros.joint], 'zero': zeros.zero,
                                    'effect': effect, 'place': place}))
    if zeros.hidden:
        hidden = [names[j] for j in zeros.hidden]
        found.append(DataFinding('conventions', 'zero not checked', (said(
            'zeros_hidden', names=', '.join(hidden), size=SETTINGS.zero_shown),),
            values={'joints': hidden}, open=True))
    return found


def as_named(logs: Sequence[RobotLog], robot: Robot, reading: ReadOptions, floor: float = 0.0
             ) -> tuple[list[RobotLog], list[str]]:
    """
    Return logs as weight and inertia say that they have to be read, and that in words.

    Args:
        logs: of the robot, of one driver: the one that contradicts most tells of all.
        robot: of `load_robot`.
        reading: as the user states it; joints of its conventions are read as it says.
        floor: least misfit of a reference, which is read rightly.
    """
    if robot.file.drive is not None:
        return list(logs), []
    model, limits = robot_model(robot.file, robot.values, False), (robot.file.low, robot.file.high)
    stated = conventions_of(reading.conventions, robot.joints)
    log = max(logs, key=lambda log: misfit(log, model, limits)) if len(logs) > 1 else logs[0]
    readings = named_readings(log, model, limits,
                              [robot.joints.index(joint) for joint in stated], floor)
    if not readings:
        return list(logs), []
    return ([log_as_read(x, [n.reading for n in readings]) for x in logs],
            [f'{log.name}: {reading_words(n, robot.joints)}' for n in readings])


def robot_effects() -> set[str]:
    """Return the ids of all effects that a robot may have."""
    return {e.id for e in EFFECTS.values() if e.column is not None} | {e.id for e in ROBOT_EFFECTS}


def expect_robot(robot: object) -> Robot:
    """Return `robot` if `load_robot` gave it. Raises InputError."""
    if isinstance(robot, Robot):
        return robot
    raise InputError(f'robot: {type(robot).__name__} {str(robot)[:40]!r}, expected a Robot, as '
                     "load_robot('robot.xml') returns it")


DESCRIPTION = 'robot_description'
STRING = 'std_msgs/msg/String'


def watch_robot(recordings: str | Path | Sequence[str | Path], model: str | Path | None = None, *,
                state: Watch | str | Path | None = None, topic: str = JOINT_STATES,
                reading: ReadOptions = BY_NAMES,
                progress: Progress | None = None) -> Watch:
    """
    Return what is known of a robot after recordings of its joint states.

    Recordings without a date follow one another.

    Args:
        recordings: of any kind, in order of time.
        model: URDF file; None: a message on robot_description in one of the recordings.
        state: of an earlier watch of this robot, or its file, which goes on; None: it begins to
            learn.
        topic: of the joint states.
        reading: how columns are read whose names and units do not say it.
        progress: called with (recordings done, recordings); None shows a bar or, in a pipe, lines.

    Raises:
        InputError: a recording cannot be read, or there is no description.
    """
    given = [recordings] if isinstance(recordings, (str, Path)) else recordings
    paths = [Path(path) for path in given]
    if not paths:
        raise InputError('recordings: none, expected at least one')
    known = load_watch(state) if isinstance(state, (str, Path)) else state
    text = urdf_in(model) if model is not None else description_in(paths, reading)
    if known is None and text is None:
        raise InputError(f'{paths[0]}: no message on {DESCRIPTION}, expected one or --model FILE')
    if known is None:
        known = begin(str(text))
    elif text not in (None, known.description):
        raise InputError('state: another robot_description than in the recordings, expected the '
                         'same robot; without a state, watch learns the robot again')
    cutter, assumed = Cutter(known.stamp_ns), list[str]()     # a block may end in the next one
    with reported('watch', progress) as report:
        for number, path in enumerate(paths):
            report(number, len(paths))
            for item in _taken(path, cutter, topic, reading, known, assumed):
                known = _after(known, item, model is None)
        for block in cutter.end():
            known, _ = step(known, block)
    return replace(known, notes=tuple(dict.fromkeys((*known.notes, *assumed))))


def _after(known: Watch, item: Block | str, described: bool) -> Watch:
    """Return the watch after a block, or a description if the recordings are `described`."""
    if isinstance(item, Block):
        return step(known, item)[0]
    return known if not described or item == known.description else begin(item)


def _renamed(path: Path, recorded: Sequence[str], known: Watch, assumed: list[str]) -> list[str]:
    """
    Return the names of joints in a recording; where it has none of the robot's, read by number.

    Args:
        path: of the recording.
        recorded: names in it.
        known: watch of the robot.
        assumed: takes a sentence on the names that were read by number or prefix.

    Raises:
        InputError: neither numbers nor one prefix tell the joints.
    """
    joints = [j.name for j in known.joints]
    if not recorded or set(joints) & set(recorded):
        return list(recorded)
    try:
        found, notes = names_in_log(str(path), recorded, [
            j.name for j in known.joints if not j.fixed], {}, hint='')
    except InputError:
        raise InputError(f'{path}: joints {", ".join(recorded)}, expected those of the '
                         f'description: {", ".join(joints)}') from None
    assumed += notes
    own = {name: joint for joint, name in found.items()}
    return [own.get(name, name) for name in recorded]


def _taken(path: Path, cutter: Cutter, topic: str, reading: ReadOptions, known: Watch,
           assumed: list[str]) -> Iterator[Block | str]:
    """
    Yield the descriptions in a recording, and the blocks that it completes, as a node takes them.

    Args:
        path: of the recording.
        cutter: that takes its messages.
        topic: of the joint states.
        reading: how columns are read.
        known: before it.
        assumed: see _renamed.

    Raises:
        InputError: it has no such topic, no message is stamped, or it begins more than a block
            before the end of the last.
    """
    described, after_ns = deque(_descriptions(path, reading)), known.stamp_ns
    with open_recording(path, reading, topic) as reader:
        topic = find_topic(reader, topic)
        recorded = reader.joint_names(topic)
        states = reader.joint_states(topic, recorded)
    require_stamps(str(path), states.stamp_ns)
    names = _renamed(path, recorded, known, assumed)
    first = int(states.stamp_ns.min()) if len(states.stamp_ns) else after_ns
    if DATED <= first < after_ns - WATCH_SETTINGS.block_ns:    # the last block was cut short
        begins, taken = (datetime.fromtimestamp(ns / SECOND, UTC) for ns in (first, after_ns))
        raise InputError(f'{path}: begins at {begins:%Y-%m-%d %H:%M:%S} UTC, expected a time '
                         f'after what was taken, {taken:%Y-%m-%d %H:%M:%S}')
    yield from cutter.before(first)
    for row, (stamp, logged) in enumerate(zip(states.stamp_ns.tolist(), states.log_ns.tolist())):
        while described and described[0][0] <= logged:
            yield described.popleft()[1]
        yield from cutter.take(stamp, names, states.position[row], states.velocity[row],
                               states.effort[row])
    yield from (text for _, text in described)


def description_in(paths: Sequence[Path], reading: ReadOptions = BY_NAMES) -> str | None:
    """Return the first description in `paths`, read as `reading` says, None without any."""
    return next((text for path in paths for _, text in _descriptions(path, reading)), None)


def _descriptions(path: Path, reading: ReadOptions) -> Iterator[tuple[int, str]]:
    """Yield (when it was recorded, ns; URDF) of each description in a recording."""
    with open_recording(path, reading) as reader:
        found = [t for t in reader.topics if t.rpartition('/')[2] == DESCRIPTION]
        for _, logged, _, raw in reader.messages(found[:1]) if found else ():
            yield logged, str(reader.decode(STRING, raw).data)


def urdf_in(model: str | Path) -> str:
    """Return the URDF in the file `model`. Raises InputError."""
    try:
        return Path(model).read_bytes()[:LONGEST + 1].decode('utf-8', 'replace')
    except OSError as error:
        raise InputError(f'{model}: {error.strerror}, expected a URDF file') from None
