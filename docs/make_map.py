# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Draw map.svg, the rooms of the package and their imports, and list the public names of each room.

Usage: python docs/make_map.py. A room is a folder or a module of the package's root. It stands one
row above the highest room that it imports. Arrows that follow from others (a imports b, b imports
c, a imports c) are left out. Public are the names that another room imports; the docstring of the
room's __init__ lists them by module.
"""
import ast
from functools import cache
from html import escape
from pathlib import Path
import textwrap

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / 'gearbox_monitor'
PICTURE = ROOT / 'docs/map.svg'
COLUMN, ROW, WIDTH, HEIGHT, MARGIN = 230, 118, 204, 76, 16
STYLE = """\
text { font-family: "DejaVu Sans", Verdana, sans-serif; fill: #1b2733 }
.name { font-size: 15px; font-weight: bold }
.job { font-size: 11px }
rect { fill: #eef3f8; stroke: #54708c; rx: 6 }
line { stroke: #7d93a8; stroke-width: 1.2; marker-end: url(#tip) }"""


def rooms() -> dict[str, list[Path]]:
    """Return {name of a room: its modules}; the package's own __init__ and __main__ are none."""
    out: dict[str, list[Path]] = {}
    for path in sorted(PACKAGE.rglob('*.py')):
        parts = path.relative_to(PACKAGE).with_suffix('').parts
        if parts[0] not in ('__init__', '__main__'):
            out.setdefault(parts[0], []).append(path)
    return out


@cache
def nodes(path: Path) -> list[ast.AST]:
    """Return all nodes of the syntax of a module at `path`."""
    return list(ast.walk(ast.parse(path.read_text(encoding='utf-8'))))


def imports(paths: list[Path], names: dict[str, list[Path]]) -> set[str]:
    """Return the rooms, of `names`, that the modules `paths` import."""
    out = set()
    for path in paths:
        for node in nodes(path):
            if isinstance(node, ast.ImportFrom) and node.module:
                dotted = [f'{node.module}.{alias.name}' for alias in node.names]
            elif isinstance(node, ast.Import):
                dotted = [alias.name for alias in node.names]
            else:
                continue
            parts = [name.split('.') for name in dotted]
            out |= {part[1] for part in parts if part[0] == PACKAGE.name and len(part) > 1}
    return out & set(names)


def arrows() -> dict[str, set[str]]:
    """Return {room: the rooms that it imports}; raises ValueError where they form a circle."""
    names = rooms()
    graph = {name: imports(paths, names) - {name} for name, paths in names.items()}
    heights(graph)
    return graph


def heights(graph: dict[str, set[str]]) -> dict[str, int]:
    """Return {room: its row in `graph`, 0 at the bottom}; raises ValueError for a circle."""
    rows: dict[str, int] = {}

    def height(name: str, path: tuple[str, ...]) -> int:
        if name in path:
            raise ValueError(f'import circle of rooms: {" -> ".join([*path, name])}')
        if name not in rows:
            rows[name] = 1 + max((height(room, (*path, name)) for room in graph[name]),
                                 default=-1)
        return rows[name]

    for name in graph:
        height(name, ())
    return rows


def reduced(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Return `graph` without the arrows that follow from others (its transitive reduction)."""
    def reach(name: str) -> set[str]:
        return graph[name].union(*(reach(room) for room in graph[name]))

    return {name: {room for room in below if not any(room in reach(between) for between in below)}
            for name, below in graph.items()}


def job(paths: list[Path]) -> str:
    """Return the first sentence of the docstring of a room, its modules `paths`."""
    text = ast.get_docstring(ast.parse(paths[0].read_text(encoding='utf-8'))) or ''
    return text.strip().split('\n\n')[0].replace('\n', ' ').rstrip('.')


def box(name: str, x: float, y: float, paths: list[Path]) -> list[str]:
    """Return the SVG of the room `name` with the modules `paths`, its corner at `x`, `y` px."""
    lines = [f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}"/>',
             f'<text class="name" x="{x + 10:.0f}" y="{y + 20:.0f}">{escape(name)}</text>']
    for i, line in enumerate(textwrap.wrap(job(paths), 32)[:3]):
        lines.append(f'<text class="job" x="{x + 10:.0f}" y="{y + 37 + 14 * i:.0f}">'
                     f'{escape(line)}</text>')
    return lines


def public_names() -> dict[str, dict[str, set[str]]]:
    """Return {room: {its module: names that other rooms import}}, folders alone."""
    public: dict[str, dict[str, set[str]]] = {
        name: {} for name in rooms() if (PACKAGE / name).is_dir()}
    for name, paths in rooms().items():
        for path in paths:
            for node in nodes(path):
                if not isinstance(node, ast.ImportFrom) or not node.module:
                    continue
                _, room, *module = (*node.module.split('.'), '')
                if room in public and room != name:
                    public[room].setdefault('.'.join(module[:-1]), set()).update(
                        alias.name for alias in node.names)
    return public


def with_list(text: str, modules: dict[str, set[str]]) -> str:
    """Return the `text` of a room's __init__ with the list of its public names, by `modules`."""
    def in_order(names: set[str]) -> str:
        return ', '.join(sorted(names, key=lambda name: (name.lower(), name)))

    lines = [textwrap.fill(f'{module or "."}: {in_order(names)}', 95,
                           initial_indent='    ', subsequent_indent=' ' * 8,
                           break_long_words=False, break_on_hyphens=False)
             for module, names in sorted(modules.items())]
    docstring = ast.get_docstring(ast.parse(text)) or ''
    words = docstring.partition('\n\nPublic names')[0]
    listed = '\n\nPublic names, by module:\n\n' + '\n'.join(lines) if lines else ''
    head, _, rest = text.partition('"""')
    return f'{head}"""\n{words}{listed}\n"""{rest.partition(chr(34) * 3)[2]}'


def page() -> str:
    """Return the text of the picture."""
    names, graph = rooms(), arrows()
    rows = heights(graph)
    columns = max(list(rows.values()).count(row) for row in rows.values())
    size = (columns * COLUMN + 2 * MARGIN, (max(rows.values()) + 1) * ROW + 2 * MARGIN)
    corner = {}
    for row in range(max(rows.values()) + 1):
        members = [name for name in names if rows[name] == row]
        for i, name in enumerate(members):
            corner[name] = (MARGIN + (columns - len(members) + 2 * i) * COLUMN / 2.0
                            + (COLUMN - WIDTH) / 2.0,
                            size[1] - MARGIN - (row + 1) * ROW + (ROW - HEIGHT) / 2.0)
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" '
             f'width="{size[0]}" height="{size[1]}">', f'<style>{STYLE}</style>',
             '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
             'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="#7d93a8"/></marker>'
             '</defs>', '<rect width="100%" height="100%" style="fill: white; stroke: none"/>']
    for name, below in sorted(reduced(graph).items()):
        x, y = corner[name]
        for room in sorted(below):
            to = corner[room]
            lines.append(f'<line x1="{x + WIDTH / 2:.0f}" y1="{y + HEIGHT:.0f}" '
                         f'x2="{to[0] + WIDTH / 2:.0f}" y2="{to[1] - 2:.0f}"/>')
    for name, paths in names.items():
        lines += box(name, *corner[name], paths)
    return '\n'.join([*lines, '</svg>']) + '\n'


if __name__ == '__main__':
    PICTURE.write_text(page(), encoding='utf-8')
    for room, modules in public_names().items():
        init = PACKAGE / room / '__init__.py'
        init.write_text(with_list(init.read_text(encoding='utf-8'), modules), encoding='utf-8')
