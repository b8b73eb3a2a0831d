# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The motion that is asked for would make a change a finding, or decide between rivals."""
import math

import pytest

from gearbox_monitor.diagnosis.hypothesis import of_rival, of_size
from gearbox_monitor.diagnosis.settings import CONTEST

WHERE, PRICE = ('motor_coulomb', 'elbow', 'elbow'), 20.0


@pytest.mark.parametrize('smallest', [0.3, 0.5, 1.0])
def test_so_long_a_motion_shows_the_plausible_size(smallest):
    """Evidence goes with time and the square of a size: twice the smallest needs four times."""
    asked = of_size(WHERE, (1.0, 40.0), (smallest, 0.25), PRICE)
    seen = (CONTEST.margin + PRICE) * (0.25 / smallest) ** 2 * asked.seconds / 40.0
    assert asked.evidence == pytest.approx(seen)
    exact = 40.0 * (smallest / 0.25) ** 2
    assert asked.seconds == min(max(round(exact, -1), 20.0), 600.0)
    assert asked.smallest == smallest and asked.plausible == 0.25
    assert of_size(WHERE, (1.0, 40.0), (2.5, 0.25), PRICE).smallest == math.inf
    assert asked.evidence >= 0.9 * (CONTEST.margin + PRICE) or asked.seconds == 600.0


def test_two_effects_part_by_the_margin_in_so_long_a_motion():
    asked = of_rival(WHERE, (1.0, 40.0), 'torque_offset', 2.0)
    assert asked.seconds == 120.0 and asked.evidence == pytest.approx(CONTEST.margin)
    twins = of_rival(WHERE, (1.0, 40.0), 'arm_coulomb', 0.0)
    assert twins.evidence is None and twins.rival == 'arm_coulomb' and twins.seconds == 80.0
    near = of_rival(WHERE, (1.0, 40.0), 'arm_coulomb', 0.5)
    assert near.seconds == 400.0 and near.evidence == pytest.approx(5.0)
