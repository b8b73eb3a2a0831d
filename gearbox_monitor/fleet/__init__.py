# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Many bags: replayed, measured and tabulated, on a process pool or on a Dask cluster."""
