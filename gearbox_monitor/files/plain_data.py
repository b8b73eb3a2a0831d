# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Plain data: what JSON holds."""
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import read_text

MAX_JSON = 1 << 26  # bytes of a file


def plain(value: Any) -> Any:
    """Return `value` of plain Python types; numbers that are not finite become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def dump(data: Any) -> str:
    """Return the plain `data` as JSON."""
    return json.dumps(data, indent=2, allow_nan=False)


def read_json(path: str | Path, expected: str) -> Any:
    """
    Return the content of a JSON file.

    Args:
        path: of the file.
        expected: what the file should be, for the message.

    Raises:
        InputError: no such file, or no JSON.
    """
    try:
        return json.loads(read_text(path, MAX_JSON))
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}, expected {expected}') from None
    except (ValueError, RecursionError):
        raise InputError(f'{path}: no JSON, expected {expected}') from None
