"""Find the files of ``config/`` in a checkout, a pip install and a colcon or apt install."""
import os
from pathlib import Path
import sys

from gearbox_monitor.errors import InputError


def config_path(name):
    """
    Return the path of the packaged configuration file `name`, for example ``drive.yaml``.

    Raises InputError when no installation holds it.
    """
    checkout = Path(__file__).resolve().parents[1]
    roots = [checkout / 'config'] if (checkout / 'package.xml').is_file() else []
    prefixes = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    roots += [Path(p) / 'share/gearbox_monitor/config' for p in prefixes if p]
    for root in roots:
        if (root / name).is_file():
            return root / name
    raise InputError(f'{name}: not found in any of {", ".join(map(str, roots))}')
