# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The state of a watch in a file, as knowledge_file packs it."""
from pathlib import Path

from gearbox_monitor.files.baselines import write_whole
from gearbox_monitor.files.knowledge_file import packed, read_archive, unpacked
from gearbox_monitor.watch.record import Watch

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
