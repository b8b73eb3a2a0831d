# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pages, messages, comments and templates use plain English: phrases that do not come back."""
from pathlib import Path
import re

import pytest

pytestmark = pytest.mark.prose
ROOT = Path(__file__).parents[2]
# A contorted phrase, and what to write.
PHRASES = {
    r'anew': 'again, or restart',
    r'cannot be told|told (apart|from|only)': 'distinguish, indistinguishable, informative',
    r'that is said|is said of': 'name who says it: the monitor reports',
    r'go(es)? by the (motor|arm|name)': 'is reported as, is called',
    r'misses something': 'model mismatch',
    r'no better known|not as \w+ as stated': 'state the quantity and its limit',
    r'(is|was|were|none) given (with|twice|beside)|none given': 'use --OPTION, appears twice',
    r'the one before': 'the previous one',
    r'all was well': 'reference, healthy',
    r'what is left|what it leaves': 'the residual, the remainder',
    r'nothing to tell|too short to tell': 'none, too short',
    r'none at all|in vain|for ever': 'none, without success, permanently',
    r'is no (number|file|solution|topic|text)': 'is not a',
    r'far (larger|smaller|fewer) than': 'much larger than',
    r'the other way round': 'the reverse',
    r'deaf|(lost|loses) its way': 'insensitive, diverged',
    r'very|simply|basically|actually|obviously|of course|easily|a lot|please': 'leave it out',
    r'in order to|utili[sz]\w+|as well as': 'to, use, and',
}
FILES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *(
    path for folder, pattern in (
        ('docs', '*.md'), ('docs', '*.py'), ('config', '*.*'), ('gearbox_monitor', '*.py'),
        ('gearbox_monitor', '*.html'), ('gearbox_monitor', '*.js'))
    for path in sorted((ROOT / folder).rglob(pattern)))]


@pytest.mark.parametrize('phrase, instead', PHRASES.items())
def test_no_contorted_phrase(phrase, instead):
    pattern = re.compile(rf'(?<![\w-])({phrase})(?![\w-])', re.IGNORECASE)
    hits = [f'{path.relative_to(ROOT)}:{number}: {line.strip()}' for path in FILES
            for number, line in enumerate(path.read_text(encoding='utf-8').splitlines(), 1)
            if pattern.search(line)]
    assert not hits, f'{instead}\n' + '\n'.join(hits)
