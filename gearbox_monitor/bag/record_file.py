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

"""File of whole records, and the thread that brings them to the medium."""
import os
from threading import Event, Lock, Thread


class RecordFile:
    """
    Unbuffered new file that a failed write leaves ending with a whole record.

    mcap's writer passes whole records to write(). end: bytes written; synced: of these, the bytes
    that sync() has brought to the medium; error: what it has met.
    """

    def __init__(self, path):
        self.path = path
        self._file = open(path, 'xb', buffering=0)
        self.end = self.synced = 0
        self.error = None
        self._lock = Lock()

    def write(self, data):
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
        return len(data)

    def sync(self):
        """Bring what is written to the medium, the first time the names, too; from any thread."""
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

    def held_at(self):
        """Return where the content still is after the file was removed or moved, else ''."""
        if self._file.closed:
            return ''
        mine = os.fstat(self._file.fileno())
        try:
            named = os.stat(self.path)
            if (named.st_dev, named.st_ino) == (mine.st_dev, mine.st_ino):
                return ''
        except OSError:
            pass
        return f'/proc/{os.getpid()}/fd/{self._file.fileno()}'

    def tell(self):
        return self.end

    def flush(self):
        pass

    def close(self):
        with self._lock:
            self._file.close()


class Syncer:
    """Thread that syncs `file` every `seconds`, so that who writes need not wait for it."""

    def __init__(self, file, seconds):
        self._seconds, self._end = seconds, Event()
        self._files = [file]
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def follow(self, file):
        """Take the RecordFile `file`; those before are finished, and closed once synced."""
        self._files.append(file)

    def _run(self):
        while not self._end.wait(self._seconds):
            self._sync()

    def _sync(self):
        *finished, newest = self._files.copy()
        for file in finished:
            file.sync()
            newest.error = newest.error or file.error
            file.close()
            self._files.remove(file)
        newest.sync()

    def close(self):
        """Sync what is written so far; end."""
        self._end.set()
        self._thread.join()
        self._sync()


def sync_folder(path):
    """Bring the names in the folder `path` to the medium."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
