# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Link each word of the glossary where a page first uses it: python docs/link_terms.py."""
from pathlib import Path
import re

DOCS = Path(__file__).resolve().parent
GENERATED = ('commands', 'effects', 'messages', 'parameters')
# Anchor in glossary.md: words that link to it, those that contain others first.
TERMS = {
    'law-of-tau_k': r'laws? of tau_K', 'companion-filter': r'companions?(?: filters?)?',
    'closed-fraction': r'closed fractions?', 'closed-model': r'closed models?',
    'half-gap': r'half gaps?', 'd-and-s2': r'd s2', 'drift-window': r'drift windows?',
    'operating-point': r'operating points?', 'lost-motion': r'lost motion',
    'ljung-box': r'Ljung-Box', 'likelihood': r'(?:log[- ])?likelihoods?',
    'innovation': r'innovations?', 'tau_k': r'tau_K', 'flank': r'flanks?',
    'play': r'(?:passive )?play', 'nis': r'(?-i:NIS)', 'white': r'white',
    'misfit': r'misfits?', 'dropout': r'dropouts?', 'backlash': r'backlash'}
NO_PROSE = (r'^```.*?^```', r'^ {4}[^\n]*$', r'^#[^\n]*$', r'`[^`\n]*`', r'!?\[[^\]]*\]\([^)]*\)')


def prose(text: str) -> str:
    """Return `text` with blanks in place of code, headings and links, as long as before."""
    for pattern in NO_PROSE:
        text = re.sub(pattern, lambda match: re.sub(r'[^\n]', ' ', match[0]), text,
                      flags=re.MULTILINE | re.DOTALL)
    return text


def linked(text: str) -> str:
    """Return the `text` of a page in which the first use of each word links to the glossary."""
    for anchor, words in TERMS.items():
        link = f'(glossary.md#{anchor})'
        first = re.search(rf'(?<![\w/.-])(?:{words})(?![\w-]|\.\w)', prose(text), re.IGNORECASE)
        if first and link not in text:
            begin, end = first.span()
            text = f'{text[:begin]}[{text[begin:end]}]{link}{text[end:]}'
    return text


def pages() -> list[Path]:
    """Return the pages that people write."""
    return [page for page in sorted(DOCS.glob('*.md'))
            if page.stem not in (*GENERATED, 'glossary')]


if __name__ == '__main__':
    for page in pages():
        page.write_text(linked(page.read_text(encoding='utf-8')), encoding='utf-8')
