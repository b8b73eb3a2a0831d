# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A learned curve is compared with the model file where it is the probable one."""
from gearbox_monitor.health.checks.innovation import learned_curve
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.report.sentences import phrase


def test_an_improbable_curve_says_nothing():
    values = {'learned_stiffness': 16.6, 'learned_stiffness_std': 0.07, 'learned_gap_rad': 0.2,
              'learned_gap_std_rad': 0.001}

    def broken(**probabilities):
        return [phrase(said) for said in learned_curve(
            {**values, **{f'probability_{k}': v for k, v in probabilities.items()}},
            DriveModel(), EstimatorParameters())]

    assert broken() == ['learned stiffness differs from the model file (x 0.66)']
    assert broken(random_walk=0.1, elastic=0.1, learned=0.8) == broken()
    # Neither the walk nor the learned curve explains the motion: the curve of the file does.
    assert not broken(random_walk=2e-4, elastic=1.0 - 4e-4, learned=2e-4)
    assert not broken(random_walk=0.9, elastic=0.0, learned=0.1)
