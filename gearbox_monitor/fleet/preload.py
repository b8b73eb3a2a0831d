# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Load modules and kernels when imported, before workers are forked from this process.

A kernel is compiled, or read from the cache, once for all workers, including those that replace a
killed one.
"""
import os
import signal

PERIOD = 2e-3  # s
SECONDS = 13.0  # a window of the Monitor's own (drift_window) and its delay


def load_kernels() -> None:
    """Run a short simulated recording through a Monitor and fit its backlash."""
    import numpy as np

    from gearbox_monitor.estimation.estimates import Samples
    import gearbox_monitor.fleet.job  # noqa: F401, workers run it
    from gearbox_monitor.monitoring.backlash.recording_windows import RecordingWindows
    from gearbox_monitor.monitoring.monitor import Monitor
    from gearbox_monitor.plant.drive import DriveModel
    from gearbox_monitor.plant.excitation import Excitation
    from gearbox_monitor.plant.simulate import simulate

    model, t = DriveModel(), np.arange(0.0, SECONDS, PERIOD)
    run = simulate(model, Excitation().torque(t), PERIOD)
    monitor = Monitor(model)
    estimates = monitor.run(Samples(np.round(t * 1e9).astype(np.int64), np.column_stack(
        [run.u, np.full(len(t), np.nan)]), run.y))
    windows = RecordingWindows(monitor.estimator)
    windows.add(estimates)
    windows.finish()


# Ctrl-C reaches this process, too, during imports and compilation; the parent process reports it.
# Workers get the usual handler back.
_handler = signal.signal(signal.SIGINT, lambda *_: os._exit(130))
load_kernels()
signal.signal(signal.SIGINT, _handler)
