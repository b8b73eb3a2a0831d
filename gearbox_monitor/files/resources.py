# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

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
