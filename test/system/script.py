# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command line of the system tests: each of them runs as a script, from a checkout."""
import argparse
from pathlib import Path
import sys

from gearbox_monitor.errors import InputError

# The benchmarks, whose frame the tests share, are not installed.
sys.path.append(str(Path(__file__).parents[2]))


def run_script(module, argv=None):
    """
    Run the system test `module` with the command line `argv` (default: that of the process).

    The module has a docstring, add_arguments(parser) and run(args), which returns the exit code.
    Returns the exit code: 0 all bars met, 1 a bar is missed, 2 bad usage, 130 after Ctrl-C.
    """
    name = Path(module.__file__).name
    parser = argparse.ArgumentParser(
        prog=name, description=module.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    module.add_arguments(parser)
    try:
        return module.run(parser.parse_args(argv))
    except InputError as error:
        print(f'{name}: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
