# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""The exit codes of all commands: --help shows them, docs/README.md and a test agree with them."""
from collections.abc import Mapping
import textwrap

BAD_INPUT, UNDECIDED, INTERRUPTED = 2, 3, 130
# command -> meaning of 0, 1 and 3, as far as it has them; 2 and 130 mean the same for all.
EXIT_CODES = {
    'demo': {0: 'done', 1: 'a node failed, the replay differed, or the fault was not detected '
             '(with --no-fault: there was an alarm)'},
    'example': {0: 'done'},
    'watch': {0: 'nothing has changed', 1: 'something has changed',
              3: 'still learning, or no joint could be judged'},
    'live': {0: 'ended by Ctrl-C'},
    'replay': {0: 'done', 1: 'replayed and recorded estimates differ'},
    'play': {0: 'done, or ended by Ctrl-C'},
    'recover': {0: 'the new bag exists, or none is needed'},
    'import': {0: 'done', 3: 'something is asked for that the file does not say; nothing is '
               'written'},
    'tune': {0: 'done', 1: 'no parameters are better than the previous ones, or the torque '
             'is worse than static compensation'},
    'compare': {0: 'done'},
    'check': {0: 'usable', 1: 'unsuitable for one of --for'},
    'report': {0: 'done'},
    'accept': {0: 'pass', 1: 'fail', 3: 'undecided: not excited, or too close to a limit'},
    'simulate': {0: 'done'},
    'describe': {0: 'all joints are read', 1: 'some are refused, or a value is doubted'},
    'diagnose': {0: 'no gap', 1: 'a gap: verdict effect, incomplete or unknown',
                 3: 'undecided: the motion shows too little; or free runs are not finite'},
    'explain': {0: 'done'},
    'learn': {0: 'done'},
    'suggest': {0: 'a motion separates all pairs', 1: 'none within the limits does'},
    'fit-nominal': {0: 'all values are determined', 1: 'some are not',
                    3: 'the fit did not find a solution, or took longer than --time-limit'},
    'adapt': {0: 'done', 1: 'no fit is more likely than the previous model and parameters',
              3: 'no value is identified: only tolerances are widened'},
    'export': {0: 'all is expressed', 1: 'some is not'},
    'fleet': {0: 'every bag has its row', 1: 'run it again: some bags failed for reasons that may '
              'pass', 2: 'bad usage or input, disk full, scheduler lost',
              3: 'bags of a folder name no gearbox'},
}


def exit_code_text(meanings: Mapping[int, str]) -> str:
    """Return the lines of --help about exit codes, `meanings` by code; 2 and 130 are added."""
    codes = {BAD_INPUT: 'bad usage or input', **meanings}
    if 'Ctrl-C' not in codes[0]:
        codes[INTERRUPTED] = 'ended by Ctrl-C'
    words = '; '.join(f'{code} {meaning}' for code, meaning in sorted(codes.items()))
    return textwrap.fill(f'exit code: {words}', 80)
