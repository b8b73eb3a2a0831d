# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Knowledge of a robot, or the state of a watch, in a file: arrays of numpy and one text of JSON.

Never a pickle. The archive gives each part a checksum.
"""
import io
import json
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gearbox_monitor.diagnosis.robot.knowledge import Knowledge, VERSION
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baselines import write_whole
from gearbox_monitor.files.user_files import read_bytes, write_new
from gearbox_monitor.plain_data import from_data, to_data
from gearbox_monitor.watch.record import CLASSES, Watch

SUFFIX = '.knowledge'
MAX_BYTES = 256 << 20
T = TypeVar('T')


def packed(value: object, version: int) -> bytes:
    """Return a file of `value`, made of what watch.record can store, in a `version`."""
    arrays: dict[str, Any] = {}
    text = json.dumps({'version': version, 'value': to_data(value, arrays)})
    content = io.BytesIO()
    np.savez_compressed(content, text=np.frombuffer(text.encode(), np.uint8), **arrays)
    return content.getvalue()


def unpacked(content: bytes, path: str | Path, kind: type[T], version: int, writer: str) -> T:
    """
    Return the value in the `content` of a file.

    Args:
        content: of the file.
        path: what messages call it.
        kind: class of the value.
        version: of the file.
        writer: command that writes such files.

    Raises:
        InputError: it is damaged, of another version, or another file.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            text = json.loads(bytes(file['text']).decode())
            if text.get('version') != version:
                raise InputError(f'{path}: version: {text.get("version")}, expected {version}: '
                                 'learn it again')
            value = from_data(text['value'], CLASSES, {
                name: file[name] for name in file.files[1:]})
        if not isinstance(value, kind):
            raise TypeError
    except InputError:
        raise
    except Exception:  # of zip, zlib, numpy (which advises to load pickles) and JSON
        raise InputError(f'{path}: damaged or of another kind, expected a file that {writer} '
                         'wrote') from None
    return value


def read_archive(path: str | Path, writer: str) -> bytes:
    """Return the content of the file `path` that the command `writer` wrote. Raises InputError."""
    try:
        return read_bytes(Path(path), MAX_BYTES)
    except (OSError, ValueError) as error:
        raise InputError(f'{path}: {getattr(error, "strerror", None) or error}, expected a file '
                         f'that {writer} wrote') from None


def save_knowledge(path: str | Path, knowledge: Knowledge) -> None:
    """Write `knowledge` into the new file `path`. Raises InputError."""
    write_new(path, packed(knowledge, VERSION))


def load_knowledge(path: str | Path, model: str) -> Knowledge:
    """
    Return the Knowledge in the file `path`, of the model file with the hash `model`.

    Raises InputError: damaged, of another version, or of another model.
    """
    knowledge = unpacked(read_archive(path, 'learn'), path, Knowledge, VERSION, 'learn')
    if knowledge.model != model:
        raise InputError(f'{path}: model: learnt with another file or locked joints '
                         f'({knowledge.model[:12]}), expected the one of --model '
                         f'({model[:12]}): learn it again')
    return knowledge


FORMAT = 4


def watch_bytes(watch: Watch) -> bytes:
    """Return the file of a `watch`, whose every part has a checksum."""
    return packed(watch, FORMAT)


def save_watch(path: str | Path, watch: Watch) -> None:
    """Write `watch` to the file `path`, at once or not at all. Raises InputError."""
    write_whole(Path(path), packed(watch, FORMAT))


def load_watch(path: str | Path) -> Watch:
    """Return the Watch in the file `path`. Raises InputError: it is damaged, or another file."""
    return watch_from(read_archive(path, 'watch'), path)


def watch_from(content: bytes, path: str | Path) -> Watch:
    """Return the Watch in the `content` of a file called `path`. Raises InputError."""
    return unpacked(content, path, Watch, FORMAT, 'watch')
