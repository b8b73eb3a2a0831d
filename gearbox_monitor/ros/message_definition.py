# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The ``ros2msg`` text of a message class, made from the class itself."""
import importlib
import importlib.util
from pathlib import Path
import re
from typing import Any

BASE_TYPES = {'boolean': 'bool', 'double': 'float64', 'float': 'float32', 'octet': 'byte'}


def import_message(msgtype: str) -> Any:
    """
    Return the class of `msgtype` (``pkg/msg/Name``); raises ImportError if it is not installed.

    Anybody can offer a topic of any type: only packages with messages are imported.
    """
    package, _, name = msgtype.partition('/msg/')
    spec = importlib.util.find_spec(package) if package.isidentifier() else None
    folders = spec.submodule_search_locations or () if spec else ()
    if not any((Path(folder) / 'msg').is_dir() for folder in folders):
        raise ImportError(f'{msgtype}: no package with messages')
    try:
        return getattr(importlib.import_module(f'{package}.msg'), name)
    except (AttributeError, ValueError) as error:
        raise ImportError(f'{msgtype}: {error}') from None


def message_definition(msgtype: str) -> str:
    """
    Return the definition of `msgtype` with those of all types in it.

    Constants, default values and comments are left out: the bytes do not depend on them.
    """
    texts: dict[str, str] = {}
    pending = [msgtype]
    while pending:
        name = pending.pop()
        if name in texts:
            continue
        lines = []
        for field, kind in import_message(name).get_fields_and_field_types().items():
            if field == 'structure_needs_at_least_one_member':
                continue
            base, suffix = _split(kind)
            if '/' in base:
                package, short = base.split('/')
                pending.append(f'{package}/msg/{short}')
            lines.append(f'{BASE_TYPES.get(base, base)}{suffix} {field}')
        texts[name] = '\n'.join(lines)
    root = texts.pop(msgtype)
    parts = [f'\n{"=" * 80}\nMSG: {name.replace("/msg/", "/")}\n{text}'
             for name, text in texts.items()]
    return root + ''.join(parts) + '\n'


def _split(kind: str) -> tuple[str, str]:
    """Split ``sequence<double, 3>`` into (``double``, ``[<=3]``), ``double[3]`` likewise."""
    if match := re.fullmatch(r'sequence<(.*?)(?:, *(\d+))?>', kind):
        base, bound = match.groups()
        suffix = f'[<={bound}]' if bound else '[]'
    elif match := re.fullmatch(r'(.*)(\[\d+\])', kind):
        base, suffix = match.groups()
    else:
        base, suffix = kind, ''
    if match := re.fullmatch(r'(w?string)<(\d+)>', base):
        base, suffix = match[1], f'<={match[2]}{suffix}'
    return base, suffix
