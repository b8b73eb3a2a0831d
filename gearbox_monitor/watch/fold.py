# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The fold of a watch: a Watch and a block in, a Watch and what happened out.

It describes the stream, learns the robot while it works, and then compares each block with what
was learnt.
"""
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
import math

import numpy as np

from gearbox_monitor.diagnosis.robot.conventions import columns_as_read, named_readings
from gearbox_monitor.diagnosis.robot.knowledge import learn
from gearbox_monitor.diagnosis.robot.likelihood import RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_effects import BASE
from gearbox_monitor.diagnosis.robot.robot_log import checked_log, continuous, RobotLog
from gearbox_monitor.diagnosis.robot.rows import RobotModel, rows_of
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.errors import InputError
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.presentation import percent, Quantity
from gearbox_monitor.robot.chain import chain_of
from gearbox_monitor.robot.compiled_model import implausible_limits, implausible_links
from gearbox_monitor.robot.description import own_joints, parse
from gearbox_monitor.watch.features import Features, features_of, Group, groups_of, state_levels
from gearbox_monitor.watch.record import (
    Block, Change, DESCRIBE, Deviation, FRICTION, Held, HeldLoad, JointWatch, LEARN, level_of,
    Levels, now, raw_log, RIPPLE, SCALE, SECOND, StateHealth, step_in, stepped, TILT, WATCH, Watch,
    WATCH_SETTINGS, WatchEvent, with_block)

SOURCE = 'robot_description'
NOUNS = {FRICTION: 'friction', SCALE: 'torque scale'}    # of what must be known of a joint


@lru_cache(maxsize=4)
def robot_of(description: str, locked: tuple[tuple[str, float], ...]
             ) -> tuple[RobotModel, tuple[Array, Array]]:
    """Return the model in a URDF `description` with `locked` joints, and their ranges."""
    parsed = parse(description, SOURCE, dict(locked), whole=True)
    chain, (low, high) = chain_of(parsed), parsed.ranges.T
    robot = RobotModel(chain, np.full(len(chain.links), SETTINGS.tolerance_learnt), 0.0, True)
    return robot, (low, high)


def begin(description: str) -> Watch:
    """Return the Watch of the robot in a URDF `description`. Raises InputError: it is none."""
    leads = own_joints(description, SOURCE)
    chain = robot_of(description, tuple((n, 0.0) for n, leading in leads.items() if leading)
                     )[0].chain
    fixed = {name: 'other joints mimic it' if leading else '' if name in chain.joints else
             'moves no mass in the description' for name, leading in leads.items()}
    return Watch(description, (*implausible_links(chain.links),
                               *implausible_limits(description, SOURCE)), joints=tuple(
        JointWatch(name, why, why=why or 'no sample yet') for name, why in fixed.items()))


def step(watch: Watch, block: Block) -> tuple[Watch, tuple[WatchEvent, ...]]:
    """
    Return the watch after one more block, and what happened with it.

    Args:
        watch: before; it stays as it is.
        block: of the same robot, later than those before.
    """
    if block.end_ns <= watch.stamp_ns:
        return watch, ()
    watch = replace(_described(watch, block), stamp_ns=block.end_ns, blocks=watch.blocks + 1)
    if watch.phase == WATCH:
        return _watched(watch, block)
    if not _moves(block, [j.name for j in watch.joints]).any():
        return watch, ()
    if watch.phase == LEARN and {j.name for j in watch.joints if not _whole(j)} != {*watch.locked}:
        watch = replace(watch, phase=DESCRIBE, kept=(), locked={})
    watch = replace(watch, kept=(*watch.kept, block))
    if watch.phase == DESCRIBE:
        return _settled(watch) if len(watch.kept) >= WATCH_SETTINGS.part else (watch, ())
    return _learnt(watch) if _enough(watch) else (watch, ())


def learn_again(watch: Watch) -> Watch:
    """Return the watch that forgets what it learnt, and learns the robot as it is now."""
    return replace(begin(watch.description), stamp_ns=watch.stamp_ns, blocks=watch.blocks,
                   joints=tuple(replace(j, moved=0.0, level=None, why='learns again', states=())
                                for j in watch.joints))


def tare(watch: Watch) -> Watch:
    """Return the watch that takes what the robot holds now for nothing."""
    watch = replace(watch, empty=watch.held or watch.empty)
    return replace(watch, payloads=_payloads(watch))


def save_baseline(watch: Watch) -> Watch:
    """Return the watch that takes all states as they are now for healthy; its alarms end."""
    if watch.states is None:
        return watch
    over = tuple(replace(c, over_ns=c.over_ns or watch.stamp_ns) for c in watch.changes)
    return replace(watch, baseline=_baseline(watch.states), changes=over)


def _baseline(states: Levels) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in states.level.tolist())


# --- describe and learn -------------------------------------------------------------------------
def _described(watch: Watch, block: Block) -> Watch:
    """Return the watch with what a block has of each joint."""
    names = [j.name for j in watch.joints]
    seconds, joints = _moved(block, names), []
    for joint, moved in zip(watch.joints, seconds):
        if joint.name not in block.joints:
            joints.append(replace(joint, has=(), why=joint.fixed or 'not in joint_states'))
            continue
        k = block.joints.index(joint.name)
        dead = (moved or joint.name in watch.locked) and _constant(block, joint.name)
        has = tuple(q for q in ('position', 'velocity', 'effort') if not (
            dead and q == 'effort') and np.isfinite(getattr(block, q)[:, k]).any())
        seen = np.isfinite(block.position[:, k])
        stamps = block.stamps[seen]
        rate = SECOND / float(np.median(np.diff(stamps))) if len(stamps) > 2 else 0.0
        total = joint.moved + float(moved)
        if watch.phase != WATCH and seen.any():
            joint = replace(joint, position=float(np.median(block.position[seen, k])))
        why = joint.fixed or (
            f'no {"position" if "position" not in has else "effort"}'
            if not {'position', 'effort'} <= set(has) else
            'had no effort while the robot was learnt' if joint.name in watch.locked else
            'has not moved yet' if total < 1.0 else joint.why if joint.states else 'learns')
        joints.append(replace(joint, has=has, rate=rate, moved=total, why=why))
    return replace(watch, joints=tuple(joints), others=tuple(
        sorted({*watch.others, *(n for n in block.joints if n not in names)})))


def _constant(block: Block, joint: str) -> bool:
    """Return whether the effort of a joint in a block is one value, as of a dead sensor."""
    effort = block.effort[:, block.joints.index(joint)]
    effort = effort[np.isfinite(effort)]
    return len(effort) > 0 and bool(np.ptp(effort) == 0.0)


def _whole(joint: JointWatch) -> bool:
    """Return whether the newest block holds position and effort of a joint that can move."""
    return not joint.fixed and {'position', 'effort'} <= set(joint.has)


def _moved(block: Block, names: Sequence[str]) -> Array:
    """Return the seconds of a block in which each of the joints `names` moves."""
    out = np.zeros(len(names))
    at = np.searchsorted(block.stamps, np.arange(
        block.stamps[0], block.stamps[-1], round(WATCH_SETTINGS.speed_step * SECOND)))
    for i, name in enumerate(names):
        if name in block.joints and len(at) > 1:
            q = block.position[:, block.joints.index(name)]
            rows = np.flatnonzero(np.isfinite(q))
            if len(rows) > 1:
                t = (block.stamps - block.stamps[0]) / SECOND
                speed = np.diff(np.interp(t[at], t[rows], q[rows])) / np.diff(t[at])
                out[i] = WATCH_SETTINGS.speed_step * float(np.sum(np.abs(speed) > SETTINGS.slow))
    return out


def _moves(block: Block, names: Sequence[str]) -> Flags:
    """Return which of the joints `names` move for a share of the block."""
    return _moved(block, names) > WATCH_SETTINGS.share * WATCH_SETTINGS.block


def _settled(watch: Watch) -> tuple[Watch, tuple[WatchEvent, ...]]:
    """Return the watch that knows which joints have an effort, and how they are read."""
    names = [j.name for j in watch.joints]
    dead = {name for block in watch.kept for name, moved in zip(names, _moved(block, names))
            if moved and _constant(block, name)}
    locked = {j.name: _usual(watch.kept, j.name) for j in watch.joints
              if not _whole(j) or j.name in dead}
    if len(locked) == len(watch.joints):
        return replace(watch, kept=watch.kept[1:], notes=(
            'no joint of the description has both position and effort',)), ()
    watch = replace(watch, phase=LEARN, locked=locked)
    try:
        robot, limits = _robot(watch)
        stated = replace(robot, learnt=False, friction_tolerance=SETTINGS.tolerance,
                         tolerance=np.full(len(robot.tolerance), SETTINGS.tolerance))
        log = _log(watch, watch.kept)
        readings = tuple(named_readings(log, stated, limits))
    except InputError as error:
        return replace(watch, phase=DESCRIBE, kept=watch.kept[1:], notes=(str(error),)), ()
    return replace(watch, readings=readings, notes=tuple(map(str, log.notes))), (WatchEvent(
        'phase', watch.stamp_ns, 'robot', 'learns the robot while it works'),)


def _usual(blocks: Sequence[Block], joint: str) -> float:
    """Return the median position of a joint, 0 without any."""
    values = np.concatenate([b.position[:, b.joints.index(joint)] for b in blocks
                             if joint in b.joints] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else 0.0


def _robot(watch: Watch) -> tuple[RobotModel, tuple[Array, Array]]:
    """Return the model of a watch and the ranges of its joints."""
    return robot_of(watch.description, tuple(sorted(watch.locked.items())))


def _log(watch: Watch, blocks: Sequence[Block]) -> RobotLog:
    """Return blocks as the log of the joints that are judged. Raises InputError."""
    joints = _robot(watch)[0].chain.joints
    raw = columns_as_read(raw_log(blocks, joints, 'joint_states'),
                          [n.reading for n in watch.readings])
    return checked_log(continuous(raw), joints)


def _enough(watch: Watch) -> bool:
    """Return whether all joints that move have moved enough to be learnt."""
    s = WATCH_SETTINGS
    return len(watch.kept) >= s.parts * s.part and len(watch.kept) % s.part == 0 and (
        not _waiting(watch) or len(watch.kept) >= s.patience)


def _waiting(watch: Watch) -> list[str]:
    """Return the joints that have not moved enough to be learnt."""
    return [j.name for j in watch.joints if j.name not in watch.locked
            and j.moved < WATCH_SETTINGS.moved]


def _learnt(watch: Watch) -> tuple[Watch, tuple[WatchEvent, ...]]:
    """Return the watch that has learnt the robot."""
    robot = _robot(watch)[0]
    carrying = replace(robot, carries=robot.chain.tips)
    try:
        logs = [replace(_log(watch, [block]), name=f'block {k + 1}')
                for k, block in enumerate(watch.kept)]
        first, logs = logs[0], _similar(carrying, logs)
    except InputError as error:
        return replace(watch, kept=watch.kept[1:], notes=(str(error),)), ()
    if len(logs) < WATCH_SETTINGS.least:
        return watch, ()
    knowledge = learn(carrying, logs)
    effort = np.array([np.sqrt(np.mean(np.concatenate(
        [section.input[:, j] for log in logs for section in log.sections]) ** 2))
                       for j in range(len(robot.chain.joints))])
    groups = groups_of(robot)
    states = state_levels(robot, groups, effort)
    # What a link held in the first block is 0: by definition, or measured if others taught alone.
    load = {robot.chain.links[k].name: (np.zeros(10), np.zeros((10, 10)))
            for k in carrying.carries} if first is logs[0] else features_of(
                first, robot, knowledge, groups, _levels(states, groups)).load
    empty = tuple(Held(link, values, covariance, watch.kept[0].begin_ns)
                  for link, (values, covariance) in load.items())
    notes = [f'{name} hardly moved while the robot was learnt: once it works, call ~/learn_again'
             for name in _waiting(watch)]
    watch = replace(watch, phase=WATCH, knowledge=knowledge, kept=(), baseline=_baseline(states),
                    empty=empty, states=states, notes=(*watch.notes, *notes))
    return watch, (WatchEvent('phase', watch.stamp_ns, 'robot', 'watches'),)


def _similar(robot: RobotModel, logs: Sequence[RobotLog]) -> list[RobotLog]:
    """Return the logs without those in which much more is unexplained: a load that changed."""
    recordings = [rows_of(log, replace(robot, carries=robot.carries if k else ()))
                  for k, log in enumerate(logs)]
    evidence = RobotLikelihood(recordings)
    fit = evidence.fit()
    logarithms = []
    for a, residual in zip(evidence.at, fit.residual):
        number = a.spread(a.recording.astype(float)).astype(int)
        rows = np.maximum(np.bincount(number, minlength=len(logs)), 1)
        power = np.bincount(number, residual ** 2, len(logs)) / rows
        logarithms.append(np.log(power + 1e-12) - np.median(np.log(power + 1e-12)))
    worst = np.max(logarithms, axis=0)
    return [log for log, x in zip(logs, worst) if x < math.log(WATCH_SETTINGS.alike)]


# --- watch --------------------------------------------------------------------------------------
def _watched(watch: Watch, block: Block) -> tuple[Watch, tuple[WatchEvent, ...]]:
    """Return the watch that has compared a block with what it learnt."""
    robot = _robot(watch)[0]
    groups, before = groups_of(robot), watch
    assert watch.knowledge is not None and watch.states is not None
    if not _moves(block, robot.chain.joints).any():
        return watch, ()
    try:
        silent = [j.name for j in watch.joints if j.name not in watch.locked and not _whole(j)]
        if silent:
            raise InputError(f'no position or no effort of {", ".join(silent)}')
        log = _log(watch, [block])
    except InputError as error:
        unread = (j if j.level == Level.WARN else replace(
            j, level=None, why=j.fixed or 'its newest samples cannot be read')
            for j in watch.joints)
        return replace(watch, notes=(str(error),), joints=tuple(unread),
                       level=watch.level if watch.level == Level.WARN else None), ()
    features = features_of(log, robot, watch.knowledge, groups, _levels(watch.states, groups))
    watch = replace(watch, states=with_block(watch.states, features.deviations, features.gains,
                                             block.begin_ns))
    watch = _with_payloads(_with_changes(_stepped(watch, groups), features, groups), features,
                           block.begin_ns)
    watch = _with_states(watch, features, groups)
    return watch, _events(before, watch)


def _levels(states: Levels, groups: Sequence[Group]) -> list[Deviation]:
    """Return mean and covariance of each of `groups` in their `states`."""
    return [level_of(states, i, g.width) for i, g in enumerate(groups)]


def _stepped(watch: Watch, groups: Sequence[Group]) -> Watch:
    """Return the watch with the step of a state, if one is sure."""
    assert watch.states is not None
    found = step_in(watch.states)
    if found is None:
        return watch
    g, rival = groups[found.state], None if found.rival is None else groups[found.rival]
    changes = watch.changes     # a ripple of several orders is one
    if not any((c.kind, c.place) == (g.kind, g.place) for c in watch.standing):
        changes = (*changes, Change(g.kind, g.place, 0.0, 0.0, found.since_ns, 0,
                                    before=tuple(found.before.tolist()), order=g.order,
                                    rival=(rival.kind, rival.place) if rival else ()))
    return replace(watch, states=stepped(watch.states, found), changes=changes)


def _size(change: Array, covariance: Array, features: Features, number: int
          ) -> tuple[float, float]:
    """
    Return by how much a state differs, as a share of what is there, and the deviation.

    Args:
        change: of its coefficients [k].
        covariance: of it [k, k].
        features: of the newest block, with the torque that the state makes.
        number: of the state.
    """
    inner, own = features.sizes[number], features.own[number]
    whole = math.sqrt(max(float(own @ inner @ own), 1e-30))
    size = math.sqrt(max(float(change @ inner @ change), 0.0))
    slope = inner @ (change if size > 0.0 else own)
    slope = slope / math.sqrt(max(float(slope @ np.linalg.pinv(inner) @ slope), 1e-30))
    std = math.sqrt(max(float(slope @ covariance @ slope), 0.0)) / whole
    share = math.copysign(size / whole, float(own @ inner @ change))
    return share, std


def _share(change: Array, covariance: Array, features: Features, number: int
           ) -> tuple[float, float]:
    """Return the part of a change that is a share of what is there; see _size."""
    own = features.own[number]
    slope = features.sizes[number] @ own
    slope = slope / max(float(own @ slope), 1e-30)
    return float(slope @ change), math.sqrt(max(float(slope @ covariance @ slope), 0.0))


def _with_changes(watch: Watch, features: Features, groups: Sequence[Group]) -> Watch:
    """Return the watch with the sizes of its changes, and with those without a step."""
    assert watch.states is not None
    changes, s = [], WATCH_SETTINGS
    number = {(g.kind, g.place, g.order): i for i, g in enumerate(groups)}
    for c in watch.changes:
        if not c.over_ns:
            size, std = _level_size(watch.states, c.before, features, groups,
                                    number[c.kind, c.place, c.order])
            c = replace(c, size=size, std=std)
            limit = s.kinds[c.kind].limit
            if not c.found_ns and abs(c.size) - s.certain * c.std > limit:
                c = replace(c, found_ns=watch.stamp_ns)
            elif not c.found_ns and abs(c.size) + s.certain * c.std < limit:
                continue                # too small to report
            elif c.found_ns and abs(c.size) + c.std < s.over * limit:
                c = replace(c, over_ns=watch.stamp_ns)
        changes.append(c)
    standing = {(c.kind, c.place) for c in changes if not c.over_ns}
    for i, (g, baseline) in enumerate(zip(groups, watch.baseline)):
        if g.kind == RIPPLE or (g.kind, g.place) in standing:
            continue
        size, std = _level_size(watch.states, baseline, features, groups, i)
        if abs(size) - s.certain * std > s.kinds[g.kind].slow:
            changes.append(Change(g.kind, g.place, size, std, watch.stamp_ns, watch.stamp_ns,
                                  before=baseline, order=g.order))
    return replace(watch, changes=tuple(changes))


def _level_size(states: Levels, before: Sequence[float], features: Features,
                groups: Sequence[Group], number: int) -> tuple[float, float]:
    """Return by how much the level of a state differs from that `before`, and the deviation."""
    g = groups[number]
    mean, covariance = level_of(states, number, g.width)
    return _size(mean - np.array(before)[:g.width], covariance, features, number)


def _with_states(watch: Watch, features: Features, groups: Sequence[Group]) -> Watch:
    """Return the watch with the states of each joint, and its level."""
    s, bad = WATCH_SETTINGS, {c.place for c in watch.standing if c.found_ns}
    assert watch.knowledge is not None and watch.states is not None
    astray = {name for name, x in zip(watch.knowledge.joints, features.left) if x > s.alike}
    gains = watch.states.gains.sum(axis=0)
    likeliest = {groups[i].place: i for i in np.argsort(gains) if groups[i].kind != RIPPLE}
    states: dict[str, list[StateHealth]] = {}
    for i, (g, baseline) in enumerate(zip(groups, watch.baseline)):
        if g.kind == RIPPLE:
            continue
        mean, covariance = now(watch.states, i, g.width)
        size, std = (_size if g.kind == TILT else _share)(
            mean - np.array(baseline)[:g.width], covariance, features, i)
        limit = s.kinds[g.kind].limit
        judged = bool(std < s.power * limit and watch.states.seen[i] >= s.lasting)
        off, off_std = _share(mean - level_of(watch.states, i, g.width)[0], covariance,
                              features, i)
        if judged and i == likeliest[g.place] and abs(off) - s.certain * off_std > limit:
            astray.add(g.place)
        states.setdefault(g.place, []).append(StateHealth(g.kind, size, std, judged))
    joints = []
    for joint in watch.joints:
        own = tuple(states.get(joint.name, ()))
        why = joint.why if joint.name in watch.locked else _unknown(
            joint.name in watch.knowledge.unjudged, joint.name in astray, own)
        level = Level.WARN if joint.name in bad else None if why else Level.OK
        joints.append(replace(joint, states=own, level=level, why=why))
    # While one joint is unknown, the robot is unknown, too.
    levels = [j.level for j in joints if j.name not in watch.locked or _whole(j)]
    level = Level.WARN if bad else Level.OK if levels and None not in levels else None
    return replace(watch, joints=tuple(joints), tilt=states[BASE][0], level=level)


def _unknown(unjudged: bool, astray: bool, states: Sequence[StateHealth]) -> str:
    """Return why a joint with `states` is not judged, '' if it is."""
    if unjudged:
        return 'the description leaves more than half of its effort unexplained'
    if astray:
        return 'its newest torques are not as learnt; no change is sure yet'
    unknown = [NOUNS[x.kind] for x in states if x.kind in NOUNS and not x.judged]
    return f'{" and ".join(unknown)} not known yet' if unknown else ''


def _with_payloads(watch: Watch, features: Features, begin_ns: int) -> Watch:
    """Return the watch with what each link holds after a block."""
    out = []
    for number, (link, (values, covariance)) in enumerate(features.load.items()):
        since = begin_ns
        if number < len(watch.held):
            known = watch.held[number]
            apart = (values - known.values)[:4]
            spread = (covariance + known.covariance)[:4, :4]
            if apart @ np.linalg.solve(spread, apart) < WATCH_SETTINGS.taken and (
                    abs(apart[0]) < WATCH_SETTINGS.noticed * math.sqrt(spread[0, 0])):
                before, new = (np.linalg.inv(c) for c in (2.0 * known.covariance, covariance))
                covariance = np.linalg.inv(before + new)
                values = covariance @ (before @ known.values + new @ values)
                since = known.since_ns
        out.append(Held(link, values, covariance, since))
    over = [replace(p, over_ns=begin_ns) for p, held in zip(watch.payloads, out)
            if held.since_ns != p.since_ns]
    watch = replace(watch, held=tuple(out),
                    earlier=(*watch.earlier, *over)[-WATCH_SETTINGS.remembered:])
    return replace(watch, payloads=_payloads(watch))


def _payloads(watch: Watch) -> tuple[HeldLoad, ...]:
    """Return what each link holds, against what it held when it was tared."""
    links, out = _robot(watch)[0].chain.links, []
    for held, empty in zip(watch.held, watch.empty):
        b = (held.values - empty.values)[:4]
        spread = (held.covariance + empty.covariance)[:4, :4]
        own = next(link.mass for link in links if link.name == held.link)
        of_scale = WATCH_SETTINGS.scaled * (own + abs(float(b[0])))
        std = math.hypot(math.sqrt(float(spread[0, 0])), of_scale)
        centre = centre_std = np.full(3, math.nan)
        if abs(b[0]) > 2.0 * std:
            centre = b[1:] / b[0]
            slopes = np.column_stack([-centre, np.eye(3)]) / b[0]
            centre_std = np.sqrt(np.diag(slopes @ spread @ slopes.T))
        out.append(HeldLoad(held.link, float(b[0]), std, tuple(centre.tolist()),
                            tuple(centre_std.tolist()), held.since_ns))
    return tuple(out)


def _events(before: Watch, after: Watch) -> tuple[WatchEvent, ...]:
    """Return what happened between two states of a watch."""
    out = []
    old = {(c.kind, c.place, c.since_ns): c for c in before.changes}
    for c in after.changes:
        known = old.get((c.kind, c.place, c.since_ns))
        size = f'{c.kind} {percent(c.size, c.std):+}'
        if c.found_ns and not (known and known.found_ns):
            out.append(WatchEvent('raised', after.stamp_ns, c.place, size))
        if c.over_ns and known and not known.over_ns:
            out.append(WatchEvent('over', after.stamp_ns, c.place, size))
    for p, known_p in zip(after.payloads, before.payloads or after.payloads):
        if p.since_ns != known_p.since_ns:
            out.append(WatchEvent('payload', after.stamp_ns, p.link,
                                  str(Quantity(p.mass, p.mass_std, 'kg'))))
    return tuple(out)
