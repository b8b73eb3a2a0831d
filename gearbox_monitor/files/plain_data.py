# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Plain data: what JSON holds."""
import json
import math
from typing import Any

import numpy as np


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
