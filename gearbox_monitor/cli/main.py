# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The command line ``gearbox_monitor``: finds the subcommand and turns errors into exit codes."""
import argparse
import contextlib
from functools import partial
import importlib
import os
import sys

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError

# name -> (module, one line of help). Modules are imported only when their command is asked for.
COMMANDS = {
    'demo': ('demo', 'simulate, estimate, record and check one worn gearbox, on this machine'),
    'example': ('example', 'write a bag of a simulated drive, to try the others on'),
    'replay': ('replay', 'run a bag through the estimator, offline'),
    'play': ('play', 'publish a bag to live nodes, with /clock'),
    'recover': ('recover', 'make a whole bag of one that was cut'),
    'import': ('import_', 'turn CSV, .mat or JSON recordings into a bag'),
    'tune': ('tune', 'find R and Q of a filter from a recording'),
    'compare': ('compare', 'run several filters on one recording, side by side'),
    'check': ('check', 'say what is in a recording and what it suits'),
    'report': ('report', 'write one page about a recording'),
    'accept': ('accept', 'check the backlash and stiffness of a delivered gearbox from a bag'),
    'simulate': ('simulate', 'lay a recording, its model and the closed model over each other'),
    'diagnose': ('diagnose', 'find the effect that simulator and drive differ by, from a bag'),
    'suggest': ('suggest', 'find the motion that tells confused effects apart'),
    'fit-nominal': ('fit_nominal', 'find the values of a model file from recordings'),
    'fleet': ('fleet', 'replay many bags and see which gearboxes wear'),
    'benchmark': ('benchmark', 'measure this package against its bars'),
}


def main(argv=None):
    """
    Run one subcommand.

    Returns 0 when done, 1 for a finding that asks for action, 2 for bad usage or bad input, 130
    after Ctrl-C.
    """
    argv = sys.argv[1:] if argv is None else argv
    named = next((word for word in argv if not word.startswith('-')), None)
    try:
        args = _parse(argv, named)
        # Of a command that uses no kernel: absent.
        kernels = sys.modules.get('gearbox_monitor.kernels.jit')
        if kernels and kernels.CACHE_PROBLEM:
            print(f'gearbox_monitor {named}: {kernels.CACHE_PROBLEM}', file=sys.stderr)
        with _announced_compilation() if kernels else contextlib.nullcontext():
            return args.run(args) or 0
    except InputError as error:
        print(f'gearbox_monitor {named}: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # the reader of our output has gone (| head)
        sys.stderr.close()
        return 0


def _announced_compilation() -> contextlib.AbstractContextManager[None]:
    """Return the context that tells a user at a terminal why the first run takes so long."""
    if not sys.stderr.isatty():
        return contextlib.nullcontext()
    from tqdm import tqdm

    from gearbox_monitor.kernels.compilation import announced_compilation
    return announced_compilation(partial(tqdm.write, file=sys.stderr))


def _parse(argv, named):
    """Return the parsed `argv`; only the module of the command `named` is imported."""
    parser = argparse.ArgumentParser(
        prog='gearbox_monitor', description='Condition monitor for robot joint gearboxes.')
    parser.add_argument('--version', action='version', version=__version__)
    subparsers = parser.add_subparsers(dest='command', metavar='COMMAND', required=True)
    for name, (module, summary) in COMMANDS.items():
        sub = subparsers.add_parser(
            name, help=summary, formatter_class=argparse.RawDescriptionHelpFormatter)
        if name == named:
            # Small matrices, and fits in threads of our own: those of BLAS would be in the way.
            os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
            command = importlib.import_module('gearbox_monitor.cli.' + module)
            sub.description = command.__doc__
            command.add_arguments(sub)
            sub.set_defaults(run=command.run)
    return parser.parse_args(argv)


if __name__ == '__main__':
    sys.exit(main())
