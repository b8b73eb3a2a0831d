# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

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
    PLUGIN_GROUP, plugins, quantised, slip_profile)

__all__ = [
    'EFFECTS', 'LOCATIONS', 'MAX_DELAY', 'MAX_SETPOINT_DELAY', 'MEMORIES', 'N_EFFECTS',
    'N_MEMORY', 'PLACES', 'PLUGIN_GROUP', 'Effect', 'FreeParameter', 'Parameter', 'Scales',
    'Three', 'Torques', 'arm_profile', 'library', 'not_in_filters', 'pack', 'plugins', 'quantised',
    'slip_profile']
