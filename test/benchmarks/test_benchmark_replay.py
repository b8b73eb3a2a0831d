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

"""The benchmark of replay counts every sample; its figures are not judged here."""
from gearbox_monitor.benchmarks import replay_cost


def test_every_row_takes_all_samples(monkeypatch):
    monkeypatch.setattr(replay_cost, 'SECONDS', 2.0)
    monkeypatch.setattr(replay_cost, 'FEW', 1.0)
    with replay_cost.steppers() as (steppers, samples):
        assert {name: run() for name, run in steppers.items()} == samples
        assert samples['replay, everything'] == 2000 and samples['rosbags, decoding'] == 1000
