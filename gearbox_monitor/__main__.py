import sys

from gearbox_monitor.cli.main import main

sys.exit(main())
