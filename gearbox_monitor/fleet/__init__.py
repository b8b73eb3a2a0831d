# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Many bags, each analysed once: which gearboxes wear.

`find_bags` lists the bags behind paths, `analyse` makes a row of one bag, and `run` maps it over
all of them, on the processes `at_home` or a Dask cluster (`on_cluster`). `FleetFolder` keeps each
row as a Parquet file, which says that this bag is done, and writes the table of all rows.
`gearboxes` folds the windows of each gearbox into its history.

Planned for 400 lines of code. It needs more, as a folder of robots is folded by their watch, and
a run that is broken off goes on where it ended.

Public names, by module:

    fleet_run: at_home, FleetFolder, gearboxes, joints, on_cluster, pending_of, robot_bags,
        run, run_robots
    job: find_bags, JobSettings
"""
