# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""File of whole records, and the thread that syncs them to the medium."""
from contextlib import suppress
import os
from pathlib import Path
from threading import Event, Lock, Thread


class RecordFile:
    """
    Unbuffered new file `path`; after a failed write it still ends with a whole record.

    end: bytes written; synced: those that sync() has synced to the medium; error: that sync() has
    raised.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = open(path, 'xb', buffering=0)
        self.end = self.synced = 0
        self.error: OSError | None = None
        self._lock = Lock()

    def write(self, data: bytes | bytearray) -> None:
        """Append the records `data`: all of them or, with an OSError, none."""
        if self.error is not None:
            raise self.error
        view = memoryview(data)
        try:
            while view:
                view = view[self._file.write(view):]
        except OSError:
            self._file.truncate(self.end)
            raise
        self.end += len(data)

    def sync(self) -> None:
        """Sync the file, the first time with its folders, to the medium; from any thread."""
        with self._lock:
            end = self.end
            if end == self.synced or self.error is not None or self._file.closed:
                return
            try:
                os.fdatasync(self._file.fileno())
                if not self.synced:
                    folder = os.path.dirname(self.path)
                    sync_folder(folder)
                    sync_folder(os.path.dirname(folder))
            except OSError as error:
                self.error = error
            else:
                self.synced = end

    def rescue_path(self) -> str:
        """Return the path of the content after the file was removed or moved, else ''."""
        if self._file.closed:
            return ''
        opened = os.fstat(self._file.fileno())
        with suppress(OSError):
            if os.path.samestat(os.stat(self.path), opened):
                return ''
        return f'/proc/{os.getpid()}/fd/{self._file.fileno()}'

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._file.close()


class Syncer:
    """Thread that syncs `file` every `seconds`, so that the writer need not wait for it."""

    def __init__(self, file: RecordFile, seconds: float) -> None:
        self._seconds, self._end = seconds, Event()
        self._files = [file]
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def follow(self, file: RecordFile) -> None:
        """Sync `file` from here on; the previous one is finished and is closed once synced."""
        self._files.append(file)

    def _run(self) -> None:
        while not self._end.wait(self._seconds):
            self._sync()

    def _sync(self) -> None:
        *finished, newest = self._files.copy()
        for file in finished:
            file.sync()
            newest.error = newest.error or file.error
            file.close()
            self._files.remove(file)
        newest.sync()

    def close(self) -> None:
        """Sync the newest file and end the thread."""
        self._end.set()
        self._thread.join()
        self._sync()


def sync_folder(path: str | Path) -> None:
    """Sync the names in the folder `path` to the medium."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
