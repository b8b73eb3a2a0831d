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

"""Condition monitor for robot joint gearboxes."""
from importlib import metadata
from pathlib import Path
import re


def _version() -> str:
    """Return the version by package.xml in a checkout, else by what was installed."""
    checkout = Path(__file__).resolve().parents[1] / 'package.xml'
    if checkout.is_file():
        found = re.search('<version>(.*)</version>', checkout.read_text(encoding='utf-8'))
        return found[1] if found else 'unknown'
    try:
        return metadata.version('gearbox_monitor')
    except metadata.PackageNotFoundError:  # a bare copy of the sources
        return 'unknown'


__version__ = _version()
