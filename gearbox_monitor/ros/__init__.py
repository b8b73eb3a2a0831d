# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
ROS 2 nodes and launch files; the only room that knows ROS.

In go messages, parameters and services; out come estimates, diagnostics and recordings. The nodes
are thin shells around `health.monitor.Monitor`.

Planned for 3 000 lines of code. It needs more, as each node checks every parameter and
service call before it acts, and the recorder survives a killed process and a full disk.

Public names, by module:

    .: live_node
    live_node: Watcher
    middleware: Child, ChildFailed, cores, Interrupt, own_domain
"""
import os

# Their matrices are small: threads of BLAS gain nothing, and spin while they wait.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
