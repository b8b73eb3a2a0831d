# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Where fits of effects may begin and end: what the motion cannot show is no candidate."""
from dataclasses import replace
import math

import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.candidates import Starts
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.signals.uniform import UniformRecording

T = 1e-3 * np.arange(2000)


def backlash(model, twist, **changes):
    """Return the coordinate b of backlash_gap where the twist is `twist` [N] (rad)."""
    arm = np.sin(T)
    recording = UniformRecording(T, np.cos(T), np.column_stack([arm + twist, arm]), 1e-3)
    starts = Starts(model_from_dict(model, 'test'), [replace(recording, **changes)])
    candidates = starts.candidates('backlash_gap')
    return [candidate.coordinates[-1] for candidate in candidates]


def test_a_half_gap_beyond_all_twists_is_no_candidate():
    for b in backlash({}, 0.03 + 0.02 * np.sin(9.0 * T)):
        assert b.high == pytest.approx(0.05, rel=1e-3) and b.start <= b.high
    # The middle of the gap is anywhere: both flanks may lie as far apart as the twist swings.
    for b in backlash({'zero_tolerance': 0.5}, 3.0 + 0.02 * np.sin(9.0 * T)):
        assert b.high == pytest.approx(0.04, rel=1e-3)


def test_one_encoder_shows_no_twist_and_bounds_nothing():
    assert all(math.isinf(b.high) for b in backlash({}, 0.0 * T, channels=(0,)))


def test_limits_begin_at_the_peak_and_cut_off_twice_as_much_each():
    torque = 4.0 * np.sin(9.0 * T)
    recording = UniformRecording(T, torque, np.column_stack([np.sin(T)] * 2), 1e-3)
    starts = Starts(model_from_dict({}, 'test'), [recording])
    ends = [candidate.coordinates[-1] for candidate in starts.candidates('saturation')]
    levels = [end.start for end in ends]
    cut = [np.linalg.norm(np.maximum(np.abs(torque) - level, 0.0)) for level in levels]
    assert len(levels) > 3 and 0.95 < levels[0] / 4.0 < 1.0
    assert levels[-1] == pytest.approx(1.6, rel=1e-4)
    np.testing.assert_allclose(np.divide(cut[1:], cut[:-1]), 2.0, rtol=0.03)
    assert all(end.high == pytest.approx(4.0, rel=1e-3) for end in ends)
    assert len(Starts(model_from_dict({}, 'test'), [replace(recording, u=0.0 * torque)])
               .candidates('saturation')) == 1
