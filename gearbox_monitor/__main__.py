# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

import sys

from gearbox_monitor.cli.main import main

sys.exit(main())
