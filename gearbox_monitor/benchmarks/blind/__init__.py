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
Diagnosis of effects that it cannot see: recordings of an own simulator, sealed labels, scores.

Every effect of the library, none, two at once, effects outside of the library, and the true
effect taken out of it (leave-one-out); several motions, noise of 0.2 to 2 %. Each recording is
diagnosed by a process of its own; the labels are opened after all verdicts are written. What
was missed is listed.

usage examples:
  gearbox_monitor benchmark blind
  gearbox_monitor benchmark blind --n 24 --jobs 2 --keep blind/
  gearbox_monitor benchmark blind --set stress --json stress.json
"""
from gearbox_monitor.benchmarks.blind.runner import add_arguments, run

__all__ = ['add_arguments', 'run']
