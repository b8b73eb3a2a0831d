# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
A drive as an MJCF file of its own: one body on a joint, or two that a tendon holds together.

A plain file with the model's masses, into which mjcf_patch writes the drive as into any other.
"""
import cmath
from collections.abc import Sequence
import math
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.export.mjcf import Exported, MjcfValues
from gearbox_monitor.export.mjcf_file import drive_of
from gearbox_monitor.export.mjcf_patch import number, Patch, patched
from gearbox_monitor.plant.drive import DriveModel

G = 9.81            # m/s^2, default of MuJoCo
LENGTH = 0.1        # m, largest distance of the centre of mass from the joint
LEAST_MASS = 1.0    # kg
ROTOR = 0.01        # of the motor's inertia: that of its body, the rest is armature
INTEGRATORS = {'rk4': 'RK4', 'euler': 'Euler', 'implicitfast': 'implicitfast',
               'explicit_euler': 'Euler'}
TIMESTEP = 0.0005   # s, where the model states none


def standalone(model: DriveModel, values: MjcfValues, exported: Sequence[Exported],
               joint: str | None = None, arm_joint: str | None = None) -> Patch:
    """
    Return a Patch whose data are an MJCF file with a drive alone.

    Args:
        model: that is written.
        values: of values_of.
        exported: of values_of.
        joint: name of the joint of the motor, None: 'motor', or 'joint' where there is one.
        arm_joint: name of the joint of the arm, None: 'arm'.

    Returns:
        The Patch.

    Raises:
        InputError: a value that no file can have, or an arm joint of a rigid model.

    """
    if values.rigid and arm_joint:
        raise InputError('--model-arm-joint: the model is rigid, expected --joint alone')
    names = ((joint or 'joint', None) if values.rigid
             else (joint or 'motor', arm_joint or 'arm'))
    path = Path('drive.xml')
    drive = drive_of(_plain(model, values, names).encode(), path, names)
    return patched(drive, values, exported)


def _plain(model: DriveModel, values: MjcfValues, names: tuple[str, str | None]) -> str:
    """Return a file with the inertias of a drive; all else is left to the patch."""
    kind = 'slide' if model.axis == 'prismatic' else 'hinge'
    integrator = INTEGRATORS[model.integrator] if model.timestep else 'implicitfast'
    flag = '/>' if model.integrator != 'explicit_euler' else (
        '>\n    <flag eulerdamp="disable"/>\n  </option>')
    joint = f'type="{kind}" axis="{"1 0 0" if kind == "slide" else "0 1 0"}"'
    motor, arm = names
    if arm is None:
        bodies = _body(motor, joint, values.arm_inertia, values,
                       f' armature="{number(values.motor_inertia)}"')
        tendon = ''
    else:
        own = ROTOR * values.motor_inertia
        bodies = (_body(motor, joint, own, None,
                        f' armature="{number(values.motor_inertia - own)}"')
                  + _body(arm, joint, values.arm_inertia, values))
        tendon = f"""\
  <tendon>
    <fixed name="gearbox" springlength="0 0" stiffness="{number(values.stiffness)}">
      <joint joint="{motor}" coef="1"/>
      <joint joint="{arm}" coef="-1"/>
    </fixed>
  </tendon>
"""
    actuator = (f'<general name="{motor}" joint="{motor}" gear="{number(model.gear_ratio)}" '
                f'gainprm="{number(model.torque_constant)}"/>')
    if values.servo is not None:
        actuator = (f'<position name="{motor}" joint="{motor}" '
                    f'gear="{number(model.gear_ratio)}" kp="1"/>')
    return f"""\
<mujoco model="drive">
  <compiler angle="radian"/>
  <option timestep="{number(model.timestep or TIMESTEP)}" integrator="{integrator}"{flag}
  <worldbody>
{bodies}  </worldbody>
{tendon}  <actuator>
    {actuator}
  </actuator>
</mujoco>
"""


def _body(name: str, joint: str, inertia: float, values: MjcfValues | None,
          armature: str = '') -> str:
    """Return a body with an inertia (kg m^2) about its joint, and the weight of `values`."""
    weight = complex(values.weight or 0.0) if values is not None else 0j
    if 'slide' in joint:
        mass, centre, own = inertia, 0j, inertia
    else:
        # Heavier and nearer where a light body far out would have more inertia than the drive.
        size = abs(weight) / G
        mass = max(LEAST_MASS if size else inertia, size / LENGTH,
                   2.0 * size * size / inertia if size else 0.0)
        centre = cmath.rect(size / mass, cmath.phase(weight)) if size else 0j
        own = inertia - mass * abs(centre) ** 2
    place = number(-centre.imag, 0.0, -centre.real)
    tensor = number(*(max(own, 1e-12) for _ in range(3)))
    assert math.isfinite(own)
    return f"""\
    <body name="{name}">
      <joint name="{name}" {joint}{armature}/>
      <inertial pos="{place}" mass="{number(mass)}" diaginertia="{tensor}"/>
    </body>
"""
