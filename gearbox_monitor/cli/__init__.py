# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The command line: one thin shell per subcommand.

In go words of a user; out come text, files and an exit code. A shell parses, calls the library and
prints.
"""
