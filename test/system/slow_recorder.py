# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The recorder on a slow disk: each call that goes there takes a while longer."""
import os
import sys
import time

from gearbox_monitor.recordings.mcap_file import RecordFile

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
