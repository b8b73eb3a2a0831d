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

"""The recorder on a slow disk: each call that goes there takes a while longer."""
import os
import sys
import time

from gearbox_monitor.bag.record_file import RecordFile

WRITE, SYNC = 0.05, 2.0  # s


def _slow(function, seconds):
    def slow(*args):
        time.sleep(seconds)
        return function(*args)
    return slow


def main():
    """Run the recorder."""
    from gearbox_monitor.ros.recorder_node import main as record
    RecordFile.write = _slow(RecordFile.write, WRITE)
    os.fdatasync = _slow(os.fdatasync, SYNC)
    return record()


if __name__ == '__main__':
    sys.exit(main())
