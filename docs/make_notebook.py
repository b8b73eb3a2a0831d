# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Make python.ipynb of the first sections of python.md: python docs/make_notebook.py."""
import json
from pathlib import Path
import re

DOCS = Path(__file__).parent
SECTIONS = ('A recording', 'Torque, trust, backlash', 'A verdict', 'A closed model')
TITLE = """\
# gearbox_monitor in a notebook

From a recording to a verdict and a closed model. [python.md](python.md) explains it."""


def cells(page: str) -> list[dict[str, object]]:
    """Return the cells of a notebook: a heading per section of `page`, and its Python blocks."""
    made = [_cell('markdown', TITLE)]
    for section in re.split(r'^## ', page, flags=re.MULTILINE)[1:]:
        name, _, text = section.partition('\n')
        if name in SECTIONS:
            made.append(_cell('markdown', f'## {name}'))
            made += [_cell('code', code)
                     for code in re.findall(r'```python\n(.*?)\n```', text, re.DOTALL)]
    return [{'id': f'cell-{k}', **cell} for k, cell in enumerate(made)]


def _cell(kind: str, text: str) -> dict[str, object]:
    cell: dict[str, object] = {'cell_type': kind, 'metadata': {},
                               'source': text.splitlines(keepends=True)}
    return cell | ({'execution_count': None, 'outputs': []} if kind == 'code' else {})


def notebook(page: str) -> str:
    """Return the notebook of `page` as JSON, nbformat 4, without outputs."""
    data = {'cells': cells(page), 'metadata': {
        'kernelspec': {'display_name': 'Python 3', 'language': 'python', 'name': 'python3'},
        'language_info': {'name': 'python'}}, 'nbformat': 4, 'nbformat_minor': 5}
    return json.dumps(data, indent=1, ensure_ascii=False) + '\n'


if __name__ == '__main__':
    (DOCS / 'python.ipynb').write_text(
        notebook((DOCS / 'python.md').read_text(encoding='utf-8')), encoding='utf-8')
