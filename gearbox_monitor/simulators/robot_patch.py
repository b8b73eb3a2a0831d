# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write the findings on a whole robot into its MJCF or URDF file, and run the file in MuJoCo.

Each effect has one place: an attribute of a joint, the inertia of a link, gravity. What has none
is left out, with the reason.
"""
from collections.abc import Callable, Collection, Mapping, Sequence
import copy
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import with_effects
from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.robot_effects import (
    BASE, BASE_TILT, INERTIA_NAMES, LINK_INERTIA, PAYLOAD, ROBOT_EFFECTS, tilted)
from gearbox_monitor.diagnosis.robot.verdict import RobotVerdict, sampled_early, setpoint_lags
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.files.user_files import model_text
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.effect import BalanceColumn
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA, MOTOR_VISCOUS
from gearbox_monitor.robot.chain import inertial
from gearbox_monitor.robot.compiled_model import actuators_on, disabled, mujoco_module
from gearbox_monitor.simulators.compiling import compiled_model
from gearbox_monitor.simulators.drive_patch import servo_gains
from gearbox_monitor.simulators.file_edits import (
    FileEdits, in_frame, mjcf_element, number, Patch, write_mjcf, write_urdf)
from gearbox_monitor.simulators.mjcf import EXPRESSIONS, REFUSED
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.robot_model import ChainFile, servo_of
from gearbox_monitor.simulators.xml_edit import parse_xml, XmlDocument

POINT = np.zeros((3, 3))  # inertia of a point about itself
TWO = 2.0  # deviations within which a sum below 0 is 0


class JointPlace(NamedTuple):
    """
    Where an effect of a joint stands in a file.

    value: of the finding, a change; field: of the Chain; attribute: of an MJCF joint; flags: of
    MuJoCo's options that switch it off.
    """

    value: str
    field: str
    attribute: str
    flags: tuple[str, ...]


# All other effects of joints have no attribute of their own, in either format.
OF_JOINT = {
    MOTOR_COULOMB.id: JointPlace('Cc_change', 'coulomb', 'frictionloss',
                                 ('FRICTIONLOSS', 'CONSTRAINT')),
    MOTOR_VISCOUS.id: JointPlace('Cv_change', 'viscous', 'damping', ('DAMPER',)),
    MOTOR_INERTIA.id: JointPlace('m1_change', 'armature', 'armature', ())}
OF_LINK: dict[str, Callable[[Mapping[str, float]], Array]] = {
    PAYLOAD.id: lambda v: inertial(v['m'], np.array([v['cx'], v['cy'], v['cz']]), POINT),
    LINK_INERTIA.id: lambda v: np.array([*np.zeros(4), *(v[name] for name in INERTIA_NAMES)])}

NEEDED = {**{name: (place.value,) for name, place in OF_JOINT.items()},
          **{e.id: tuple(e.units) for e in (PAYLOAD, LINK_INERTIA, BASE_TILT)},
          SERVO_GAIN.id: ('kp_factor',)}


def finding_title(effect: str, place: str) -> str:
    """Return what a finding is called: its `effect` and the joint or link that is its `place`."""
    return f'{effect} of {place}'


def title_of(finding: Mapping[str, Any]) -> str:
    """Return the title of a `finding` as plain data."""
    return finding_title(finding['effect'], finding.get('joint') or finding.get('link') or BASE)


def closed_file(file: ChainFile, findings: Sequence[Mapping[str, Any]], author: str
                ) -> tuple[str | None, dict[str, str]]:
    """
    Return the text of the file with the findings.

    Args:
        file: of the robot.
        findings: as plain data; those with `confirmed` false are left out.
        author: who writes it, for a comment.

    Returns:
        The text, None if nothing of them can stand in it, and {title of what cannot: reason}.
    """
    if file.drive is not None:
        return _closed_drive(file.drive, findings, author)
    document, omitted = parse_xml(read_file(file.path), str(file.path)), dict[str, str]()
    edits, patch = FileEdits(), Patch(document.data, ())
    for finding in findings:
        name = title_of(finding)
        try:
            if finding.get('confirmed', True) is False:
                raise InputError('free runs are farther off with it than without')
            further = edits | _edits(file, document, finding, edits)
            patch = (write_urdf(document, further, author) if file.compiled is None else
                     write_mjcf(document, file.compiled, further, author))
            edits = further
        except InputError as error:
            omitted[name] = str(error)
        if 'Ca' in finding['values']:
            omitted[f'{name}: its difference by direction'] = 'no attribute has it'
    try:
        return patch.data.decode('utf-8') if patch.changes else None, omitted
    except UnicodeDecodeError:
        return None, {**omitted, str(file.path): 'not UTF-8, expected it for a file to be written'}


def _closed_drive(drive: DriveModel, findings: Sequence[Mapping[str, Any]], author: str
                  ) -> tuple[str | None, dict[str, str]]:
    """Return the same as closed_file, for a `drive`."""
    effects, omitted = list[Values](), dict[str, str]()
    for finding in findings:
        effect, values = EFFECTS.get(finding['effect']), finding['values']
        parameters = effect.parameters if effect is not None else ()
        held = drive.value(effect.replaces) if effect is not None and effect.replaces else 0.0
        own = {p.name: values[p.name] if p.name in values else
               held + values[f'{p.name}_change'] if f'{p.name}_change' in values else
               held * values.get(f'{p.name}_of_model', values[f'{p.name}_factor'])
               for p in parameters
               if {p.name, f'{p.name}_change', f'{p.name}_factor'} & set(values)}
        if own and len(own) == len(parameters):
            effects.append({'id': finding['effect'], **own})
        else:
            omitted[title_of(finding)] = 'a drive has no such effect'
    if not effects:
        return None, omitted
    return model_text(with_effects(drive, effects), [f'Written by {author}.']), omitted


def _edits(file: ChainFile, document: XmlDocument, finding: Mapping[str, Any], before: FileEdits
           ) -> FileEdits:
    """Return the edits for a finding after those `before`. Raises InputError without a place."""
    effect, values, chain = finding['effect'], finding['values'], file.chain
    kind = 'joint' if finding.get('joint') else 'link'
    names = chain.joints if kind == 'joint' else [BASE, *(link.name for link in chain.links)]
    if finding.get(kind) not in names:
        raise InputError(f'{kind}: {finding.get(kind)!r} is not in {file.path}, '
                         + unknown(finding.get(kind), names))
    lacking = [name for name in NEEDED.get(effect, ()) if name not in values]
    if lacking or (effect in (*OF_JOINT, SERVO_GAIN.id)) > (kind == 'joint'):
        raise InputError(f'no {", ".join(lacking) or "joint"}, expected it in the finding')
    if effect in OF_JOINT:
        return _of_joint(file, OF_JOINT[effect], finding, before)
    if effect in OF_LINK:
        return _of_link(file, finding['link'], OF_LINK[effect](values))
    if effect == SERVO_GAIN.id:
        return _of_servo(file, document, finding['joint'],
                         values.get('kp_of_model', values['kp_factor']))
    if effect == BASE_TILT.id:
        return FileEdits(gravity=tilted(chain.gravity, values['ax'], values['ay']))
    row = EXPRESSIONS.get(effect)
    raise InputError(row.words if row is not None and row.kind == REFUSED
                     else 'no attribute of a joint or body has it')


def _of_joint(file: ChainFile, place: JointPlace, finding: Mapping[str, Any], before: FileEdits
              ) -> FileEdits:
    """Add a finding to the attribute at its `place`. Raises InputError."""
    attribute, m = place.attribute, file.compiled
    joint = file.chain.joints.index(finding['joint'])
    nominal = float((getattr(file.chain, place.field) if m is None
                     else getattr(m, f'dof_{attribute}'))[joint])
    if m is not None and place.flags and disabled(m, *place.flags):
        raise InputError(f'{attribute}: a flag of <option> switches it off')
    key = ('joint', finding['joint'] if m is None else joint)
    nominal = float(before.attributes.get(key, {}).get(attribute) or nominal)
    change = finding['values'][place.value]
    unsure = finding['deviations'][place.value] or 0.0
    changed = nominal + change
    if changed < -TWO * unsure - 1e-9 * nominal:
        raise InputError(f'{attribute} {nominal:.3g} in the file, {change:+.3g}, expected '
                         'a sum of 0 or more')
    return FileEdits({key: {attribute: number(max(changed, 0.0))}})


def _of_link(file: ChainFile, link: str, theta: Array) -> FileEdits:
    """Add `theta` [10], in the frame of its joint, to what a `link` has in the file."""
    m = file.compiled
    if m is None or link == BASE:
        return FileEdits(bodies={link: theta})
    # A body with several joints is several links of one name, of which the last has the mass.
    joint = max(i for i, of in enumerate(file.chain.links) if of.name == link)
    return FileEdits(bodies={int(m.jnt_bodyid[joint]): in_frame(theta, m.jnt_pos[joint])})


def _of_servo(file: ChainFile, document: XmlDocument, joint: str, factor: float) -> FileEdits:
    """Multiply kp of the servo of a `joint` by `factor`. Raises InputError."""
    m = file.compiled
    if m is None:
        raise InputError('a URDF has no actuators')
    if not factor > 0.0:
        raise InputError(f'kp_factor: {factor:g}, expected more than 0')
    servos = list(actuators_on(m, file.chain.joints.index(joint)))
    gains = [servo_gains(mjcf_element(document, m, 'actuator', i).tag, factor * m.actuator_gainprm[
        i, 0], m.actuator_biasprm[i, :3] * [1.0, factor, 1.0]) for i in servos]
    if len(gains) != 1 or not gains[0]:
        raise InputError('kp: expected one actuator <position> of the joint')
    return FileEdits({('actuator', servos[0]): gains[0]})


WINDOW = 0.5    # s of a run
MOST = 40       # windows
FARTHER = 1.1   # times as far off: more than what noise of the first state makes
FRICTION = (MOTOR_COULOMB.id, MOTOR_VISCOUS.id)  # references teach it
COLUMNS = {(e.id, ''): e.column for e in EFFECTS.values()} | {
    (e.id, e.over): e.column for e in ROBOT_EFFECTS}


def rollouts(file: ChainFile, verdict: RobotVerdict) -> dict[str, Any]:
    """
    Return how far free runs are off before and after the findings.

    A finding whose place is not in the file acts as a torque, which decides whether runs confirm
    it. Those `after` are of the file as it is written, without such torques and vetoed findings.

    Args:
        file: of the robot, an MJCF.
        verdict: on recordings, of which the first one is run.

    Returns:
        {'window': s, 'joints': {joint: {'before', 'after': rms, rad or m}}, 'vetoed': titles (see
        robot_patch) of findings with which the runs are farther off, in units of the motion of
        the joints that they act on; 'confirmed': whether there is none; 'without': titles of
        those that are not in the runs}.
    """
    rows, findings = verdict.evidence.recordings[0], [f.to_dict() for f in verdict.findings]
    joints, titles = rows.robot.chain.joints, {title_of(f) for f in findings}
    taught = {title_of(f) for f in findings if rows.robot.learnt and f['effect'] in FRICTION}
    closed, lacking = _written(file, findings)
    torques = {finding_title(c.effect, c.place) for c in verdict.fit.chosen
               if not c.free and _column(c) is not None} - (titles - lacking)
    # Where torques are recorded, the servos that made them are not in the runs.
    without = lacking - torques | titles - {
        finding_title(c.effect, c.place) for c in verdict.fit.chosen}
    before = _runs(file.compiled, verdict, frozenset())
    after = _runs(closed, verdict, torques | taught)
    spread, vetoed = np.std(rows.motion.q, axis=0) + 1e-9, list[str]()
    for c in verdict.fit.chosen:
        own = list(c.columns) if c.joint is None else [joints.index(c.joint)]
        size = [math.hypot(*(x / spread)[own]) for x in (before, after)]
        name = finding_title(c.effect, c.place)
        if name in titles - without and not size[1] < FARTHER * size[0]:
            vetoed.append(name)
    if torques or vetoed:
        closed, _ = _written(file, [f for f in findings if title_of(f) not in vetoed])
        after = _runs(closed, verdict, taught.difference(vetoed))
    return {'window': WINDOW, 'joints': {
        name: {'before': float(b), 'after': float(a)} for name, b, a in zip(joints, before, after)
        }, 'confirmed': not vetoed, 'vetoed': list(dict.fromkeys(vetoed)),
        'without': sorted(without)}


def _written(file: ChainFile, findings: Sequence[Mapping[str, Any]]) -> tuple[Any, set[str]]:
    """Return the model of the file with `findings`, and the titles of those that it lacks."""
    text, lacking = closed_file(file, findings, '')
    m = file.compiled if text is None else compiled_model(
        text.encode(), file.path, file.root, file.locked)
    return m, set(lacking)


def _column(c: Candidate) -> BalanceColumn | None:
    """Return the column of the torque of `c` on its joint, None if it is another one."""
    column = COLUMNS.get((c.effect, c.over))
    return None if column is None or c.joint is None or column.momentum else column


def _runs(model: Any, verdict: RobotVerdict, added: Collection[str]) -> Array:
    """
    Return the rms [J] of free runs at the ends of the windows.

    Args:
        model: mujoco.MjModel of the file.
        verdict: on a recording, whose torques or setpoints act.
        added: titles of findings that act as torques.
    """
    mujoco = mujoco_module()
    rows, m = verdict.evidence.recordings[0], copy.copy(model)
    m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION) | int(
        mujoco.mjtDisableBit.mjDSBL_CONTACT)
    robot, motion, joints = rows.robot, rows.motion, rows.joints
    gains = servo_of(model)[:2]   # a finding may have changed them
    kp, kd = (np.zeros(len(joints)) if x is None else x for x in (
        (robot.kp, robot.kd) if gains[0] is None else gains))
    torque = np.zeros_like(motion.q)
    if robot.learnt:   # friction of the file is not used: that of the references acts
        m.dof_frictionloss[:] = 0.0
        m.dof_damping[:] = 0.0
        m.actuator_damping[:] = 0.0
        torque -= np.stack([x.taught for x in joints], axis=1)
    for i, c in enumerate(verdict.fit.chosen):
        column = _column(c)
        if column is not None and finding_title(c.effect, c.place) in added:
            j = robot.chain.joints.index(c.joint or '')
            torque[:, j] -= column.series(joints[j], c.setting or 0.0) @ verdict.fit.values[
                verdict.fit.of(i)]
    setpoint = motion.input
    if rows.setpoint:   # the servo, whose damping MuJoCo integrates implicitly
        m.dof_damping[:] += kd
        torque += np.stack([x.compensation for x in joints], axis=1)
        # A run holds a setpoint over the timesteps of a period: it is late by their middle.
        late = setpoint_lags(verdict.evidence, verdict.fit) - 0.5 * (
            motion.step - m.opt.timestep)
        setpoint = setpoint - late * motion.input_speed
    else:
        early = sampled_early(verdict.evidence, verdict.fit)[0]
        rate = np.gradient(motion.v, motion.step, axis=0)
        torque += motion.input - early * (kp * motion.v + kd * rate)
    mujoco.mj_setConst(m, mujoco.MjData(m))
    data, step = mujoco.MjData(m), float(m.opt.timestep)
    length = max(int(round(WINDOW / motion.step)), 2)
    starts = [s for part in motion.sections
              for s in range(part.start, part.stop - length, length)]
    starts = starts[::max(1, len(starts) // MOST)]
    total = np.zeros(motion.q.shape[1])
    for s in starts:
        data.qpos[:], data.qvel[:] = motion.q[s], motion.v[s]
        t = motion.t[s:s + length]
        for k in range(int(round((t[-1] - t[0]) / step))):
            at = s + min((k + 0.5) * step / motion.step, length - 1.001)
            low = int(at)
            data.qfrc_applied[:] = torque[low] + (at - low) * (torque[low + 1] - torque[low])
            if rows.setpoint:
                data.qfrc_applied[:] += kp * (setpoint[low] - data.qpos)
            mujoco.mj_step(m, data)
        total += (data.qpos - motion.q[s + length - 1]) ** 2
    out: Array = np.sqrt(total / max(len(starts), 1))
    return out
