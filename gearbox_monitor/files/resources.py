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

"""Find the files of ``config/`` in a checkout, a pip install and a colcon or apt install."""
import os
from pathlib import Path
import sys

from gearbox_monitor.errors import InputError


def config_path(name: str) -> Path:
    """
    Return the path of the packaged configuration file `name`, for example ``drive.yaml``.

    Raises InputError when no installation holds it.
    """
    package = Path(__file__).resolve().parents[1]
    checkout = package.parent
    roots = [checkout / 'config'] if (checkout / 'package.xml').is_file() else []
    # The prefix that this package is installed in comes first: another may hold another version.
    prefixes: list[str | Path] = [
        *package.parents, *os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    shares = [Path(p) / 'share/gearbox_monitor/config' for p in prefixes if p]
    roots += [share for share in dict.fromkeys(shares) if share.is_dir()]
    for root in roots:
        if (root / name).is_file():
            return root / name
    places = ', '.join(map(str, roots)) or 'share/gearbox_monitor/config, which is not installed'
    raise InputError(f'{name}: not found, expected in {places}')
