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
Effects beyond equation (1), switched on by the key ``effects`` of a model file.

Each id names its place and the parameters that a model file gives for it: the load on the arm
(equation (1) has none, every real joint has one), and friction of the motor.
"""
ARM_LOADS = {
    'arm_viscous': ('Cav',),   # tau_arm += Cav x4            N m s/rad
    'arm_coulomb': ('Cac',),   # tau_arm += Cac s(x4)         N m
    'gravity': ('G',),         # tau_arm += G sin(x2)         N m
    'load_torque': ('TL',),    # tau_arm += TL                N m
}
# s(v) = (2/pi) atan(alpha v), the sign of equation (1).
MOTOR_FRICTIONS = {
    'load_friction': ('Cl',),  # tau_f += Cl |tau_K| s(x3)    N m per N m
}
EFFECTS = {**ARM_LOADS, **MOTOR_FRICTIONS}
