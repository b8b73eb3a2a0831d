# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The benchmark of replay counts every sample; its figures are not judged here."""
from benchmarks import replay_cost


def test_every_row_takes_all_samples(monkeypatch):
    monkeypatch.setattr(replay_cost, 'SECONDS', 2.0)
    monkeypatch.setattr(replay_cost, 'FEW', 1.0)
    with replay_cost.steppers() as (steppers, samples):
        assert {name: run() for name, run in steppers.items()} == samples
        assert samples['replay, everything'] == 2000 and samples['rosbags, decoding'] == 1000
