# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The watch of a whole robot: what its joints are like against what was learnt of them.

In go blocks of 20 s of joint states and the description of the robot, in order of time. Out comes
one frozen value, Watch, which every door shows, and the events of each block. The same messages
give the same bits, live and offline.

Public names, by module:

    .: fold
    fold: begin, step
    record: Block, Change, CLASSES, Cutter, DATED, DESCRIBE, FRICTION, HeldLoad, JointWatch,
        LEARN, RIPPLE, ROTOR, SCALE, SECOND, StateHealth, TILT, WATCH, Watch, WATCH_SETTINGS,
        WEIGHT
"""
