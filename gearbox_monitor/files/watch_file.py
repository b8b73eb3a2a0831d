# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The state of a watch in a file: arrays of numpy and one text of JSON, with their checksums."""
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baselines import write_whole
from gearbox_monitor.files.opening import read_bytes
from gearbox_monitor.plain_data import from_data, to_data
from gearbox_monitor.watch.record import CLASSES, Watch

FORMAT = 2
MAX_BYTES = 256 << 20


def watch_bytes(watch: Watch) -> bytes:
    """Return the file of a `watch`, whose every part has a checksum."""
    arrays: dict[str, Any] = {}
    text = json.dumps({'format': FORMAT, 'watch': to_data(watch, arrays)})
    content = io.BytesIO()
    np.savez_compressed(content, text=np.frombuffer(text.encode(), np.uint8), **arrays)
    return content.getvalue()


def save_watch(path: str | Path, watch: Watch) -> None:
    """Write `watch` to the file `path`, at once or not at all. Raises InputError."""
    write_whole(Path(path), watch_bytes(watch))


def load_watch(path: str | Path) -> Watch:
    """Return the Watch in the file `path`. Raises InputError: it is damaged, or another file."""
    try:
        content = read_bytes(Path(path), MAX_BYTES)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a state that watch wrote') from None
    return watch_from(content, path)


def watch_from(content: bytes, path: str | Path) -> Watch:
    """Return the Watch in the `content` of a file called `path`. Raises InputError."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            data = json.loads(bytes(file['text']).decode())
            if data['format'] != FORMAT:
                raise InputError(f'{path}: format: {data["format"]}, expected {FORMAT}: remove it '
                                 'and learn the robot again')
            watch = from_data(data['watch'], CLASSES, {n: file[n] for n in file.files[1:]})
    except InputError:
        raise
    except Exception as error:  # zip, zlib, numpy and JSON raise many kinds for damaged files
        raise InputError(f'{path}: {type(error).__name__}: {error}, expected a state that watch '
                         'wrote') from None
    if not isinstance(watch, Watch):
        raise InputError(f'{path}: {type(watch).__name__}, expected a state that watch wrote')
    return watch
