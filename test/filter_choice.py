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

"""Filters by which tests run a whole monitor: one of them, the others behind the marker."""
import pytest

from gearbox_monitor.parameters import FILTER_NAMES

EACH_FILTER = [name if name == 'ekf' else pytest.param(name, marks=pytest.mark.system)
               for name in FILTER_NAMES]
