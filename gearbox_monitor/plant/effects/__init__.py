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
Effects that equation (1) of the drive does not have: one object each, one file per place.

Plant, simulator and diagnosis take them from the registry; a model file switches effects on by its
key ``effects``. s(v) = (2/pi) atan(alpha v) is the sign of equation (1), dz the dead zone,
delta = x1 - x2 the twist. An effect that only replaces a value of the model is folded into it
(drive.DriveModel.folded) and has no equation here.
"""
from gearbox_monitor.plant.effects.effect import (
    Effect, FreeParameter, LOCATIONS, MAX_DELAY, MAX_SETPOINT_DELAY, Parameter, Scales, Three,
    Torques)
from gearbox_monitor.plant.effects.registry import (
    arm_profile, EFFECTS, library, MEMORIES, N_EFFECTS, N_MEMORY, not_in_filters, pack, PLACES,
    PLUGIN_GROUP, plugins, quantised)

__all__ = [
    'EFFECTS', 'LOCATIONS', 'MAX_DELAY', 'MAX_SETPOINT_DELAY', 'MEMORIES', 'N_EFFECTS',
    'N_MEMORY', 'PLACES', 'PLUGIN_GROUP', 'Effect', 'FreeParameter', 'Parameter', 'Scales',
    'Three', 'Torques', 'arm_profile', 'library', 'not_in_filters', 'pack', 'plugins', 'quantised']
