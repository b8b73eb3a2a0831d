# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
Compile a robot's file in a process of its own, which has limits: started by simulators.compiling.

Reads a line of JSON {folder, root, cpu_seconds, memory, locked} and the XML from the standard
input; writes the compiled model. An error is one line on the standard error, with exit code 3, and
4 where memory is short. Needs nothing of the package.
"""
import json
import math
import os
from pathlib import Path
import re
import resource
import stat
import sys
from typing import Any
from xml.etree import ElementTree

REFERENCES = ('include', 'model')  # elements that name a further XML file
FAILED, TOO_LARGE = 3, 4
SHORT = ('unknown exception', 'allocate', 'memory')  # what MuJoCo says where memory is short


class Rejected(Exception):
    """The file refers to what it may not, or MuJoCo refuses it: the reason."""


def in_words(error: Exception) -> str:
    """Return what MuJoCo says of a file: the line, the element, and what is wrong with it."""
    text = ' '.join(str(error).split())
    place = re.search(r"Element (?:name )?'([^']*)'(?:, id \d+)?(?:, line (\d+))?", text)
    words = re.sub(r'^(XML )?(Error: )*(Schema violation: )?', '', text[:place.start()] if place
                   else text).strip()
    at = [f'line {place[2]}' * bool(place[2]), place[1]] if place else []
    return ': '.join(filter(None, [*at, f'{words}, expected a file that MuJoCo compiles']))


def checked(place: Path, root: Path, named: str) -> bool:
    """
    Return whether the file `place` exists. Raises Rejected if it must not be opened.

    Args:
        place: where `named` may lie.
        root: folder below which it has to lie, links resolved.
        named: its name in the robot's file.
    """
    try:
        mode = place.stat().st_mode
    except OSError:
        return False
    if not place.resolve().is_relative_to(root):
        raise Rejected(f'{named}: lies outside of {root}, expected a file below it, or --root '
                       'with a folder around both')
    if not stat.S_ISREG(mode):
        raise Rejected(f'{named}: a pipe, device or folder, expected a file')
    return True


def check_references(text: str, folder: Path, root: Path, seen: set[Path]) -> None:
    """
    Look at all XML files that a file refers to, and that those refer to.

    Args:
        text: of the file.
        folder: it lies in.
        root: see checked.
        seen: files that were looked at.

    Raises:
        Rejected: one must not be opened, or is no XML.
    """
    try:
        elements = list(ElementTree.fromstring(text).iter())
    except ElementTree.ParseError as error:
        raise Rejected(f'{error}, expected XML') from None
    for element in elements:
        reference = element.get('file', '') if element.tag in REFERENCES else ''
        for base in dict.fromkeys((folder, Path.cwd())) if reference else ():
            place = base / reference
            if checked(place, root, reference) and place.resolve() not in seen:
                seen.add(place.resolve())
                check_references(place.read_text(encoding='utf-8'), place.parent, root, seen)


def without_shapes(spec: Any, mujoco: Any, root: Path) -> None:
    """
    Remove from a specification what moves no joint: meshes, pictures, sensors but of joints.

    Meshes stay where they make the inertia of a body; they are looked at before they are opened.
    spec, mujoco: MjSpec and its module. root: folder that file names count from.
    """
    needed = _heavy_meshes(spec, mujoco)
    for material in spec.materials:
        material.textures = [''] * len(material.textures)
    for kind in ('pairs', 'skins', 'hfields', 'tuples', 'textures'):
        for element in list(getattr(spec, kind)):
            spec.delete(element)
    for sensor in list(spec.sensors):
        if sensor.type != mujoco.mjtSensor.mjSENS_JOINTPOS:
            spec.delete(sensor)
    for mesh in list(spec.meshes):
        if mesh.name not in needed and Path(mesh.file).stem not in needed:
            spec.delete(mesh)
        elif mesh.file:
            for base in ('', spec.meshdir):
                checked(Path(base) / mesh.file, root, mesh.file)


def _heavy_meshes(spec: Any, mujoco: Any) -> set[str]:
    """Delete all geoms of meshes and terrain but those that make inertia; return their meshes."""
    automatic = spec.compiler.inertiafromgeom != mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    moving: set[str] = set()
    for body in spec.bodies:  # a parent before its children
        if len(body.joints) or (body.parent is not None and body.parent.name in moving
                                and body.parent.name):
            moving.add(body.name)
    nameless = any(not body.name for body in spec.bodies)
    needed: set[str] = set()
    for geom in list(spec.geoms):
        if not geom.meshname and geom.type != mujoco.mjtGeom.mjGEOM_HFIELD:
            continue
        body = geom.parent
        own = body.explicitinertial and automatic
        still = not nameless and body.name not in moving and automatic
        light = geom.density == 0.0 if math.isnan(geom.mass) else geom.mass == 0.0
        if own or still or light or geom.type == mujoco.mjtGeom.mjGEOM_HFIELD:
            spec.delete(geom)
        else:
            needed.add(geom.meshname)
    return needed


def compiled_without(locked: dict[str, float], spec: Any, mujoco: Any) -> Any:
    """
    Return the compiled model of a specification in which joints stand still.

    What acts on them goes with them: tendons, actuators, equalities.

    Args:
        locked: {joint: position, rad or m}; a free or ball joint keeps the posture of the file. A
            free joint without a name is called as its body.
        spec: MjSpec, which changes.
        mujoco: its module.

    Raises:
        Rejected: the file has no such joint.
    """
    if not locked:
        return spec.compile()
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            joint.name = joint.name or joint.parent.name
    model = spec.compile()
    names = [model.joint(i).name for i in range(model.njnt)]
    state = mujoco.MjData(model)
    for name, position in locked.items():
        if name not in names:
            raise Rejected(f'locked: {name}: no joint, expected one of {", ".join(names)}')
        joint = model.joint(name)
        if int(joint.type[0]) in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            state.qpos[joint.qposadr] = position
    mujoco.mj_kinematics(model, state)
    bodies = {int(model.joint(name).bodyid[0]) for name in locked}
    tendons = [t for t in spec.tendons if locked.keys() & {
        wrap.target.name for wrap in t.path if wrap.type == mujoco.mjtWrap.mjWRAP_JOINT}]
    own, trn, eq = {t.name for t in tendons}, mujoco.mjtTrn, mujoco.mjtEq
    acted = {trn.mjTRN_JOINT: locked, trn.mjTRN_JOINTINPARENT: locked, trn.mjTRN_TENDON: own}
    tied = {eq.mjEQ_JOINT: locked, eq.mjEQ_TENDON: own}
    for element in [*(a for a in spec.actuators if a.target in acted.get(a.trntype, ())),
                    *(e for e in spec.equalities if not {e.name1, e.name2}.isdisjoint(
                        tied.get(e.type, ()))),
                    *tendons, *spec.sensors, *spec.keys, *(spec.joint(name) for name in locked)]:
        spec.delete(element)
    spec.compiler.fusestatic = False
    reduced = spec.compile()
    for body in bodies:
        parent, back = model.body_parentid[body], state.xquat[model.body_parentid[body]].copy()
        mujoco.mju_negQuat(back, back)
        mujoco.mju_rotVecQuat(reduced.body_pos[body], state.xpos[body] - state.xpos[parent], back)
        mujoco.mju_mulQuat(reduced.body_quat[body], back, state.xquat[body])
    mujoco.mj_setConst(reduced, mujoco.MjData(reduced))
    return reduced


def compiled(text: str, folder: Path, root: Path, locked: dict[str, float]) -> bytes:
    """
    Return the compiled model of an XML text in MuJoCo's binary format.

    Args:
        text: of the file.
        folder: it lies in, the one that the process works in.
        root: see checked.
        locked: see compiled_without.

    Raises:
        Rejected: a file that it names, or MuJoCo's reason.
    """
    check_references(text, folder, root, set())
    import mujoco
    import numpy as np
    mujoco.set_mju_user_warning(lambda message: None)  # which goes to a file in this folder
    try:
        spec = mujoco.MjSpec.from_string(text)
        without_shapes(spec, mujoco, root)
        model = compiled_without(locked, spec, mujoco)
    except (ValueError, RuntimeError, MemoryError) as error:
        raise Rejected(in_words(error)) from None
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def main() -> int:
    """Compile what the standard input holds."""
    head, _, text = sys.stdin.buffer.read().partition(b'\n')
    order = json.loads(head)
    for limit, bound in ((resource.RLIMIT_AS, order['memory']),
                         (resource.RLIMIT_CPU, order['cpu_seconds'])):
        resource.setrlimit(limit, (bound, bound))
    os.chdir(order['folder'])
    try:
        data = compiled(text.decode('utf-8'), Path(order['folder']), Path(order['root']),
                        order['locked'])
    except (Rejected, MemoryError, OSError, UnicodeDecodeError, RecursionError) as error:
        words = ' '.join(str(error).split())
        print(words or type(error).__name__, file=sys.stderr)
        short = isinstance(error, MemoryError) or any(word in words.lower() for word in SHORT)
        return TOO_LARGE if short else FAILED
    sys.stdout.buffer.write(data)
    return 0


if __name__ == '__main__':
    sys.exit(main())
