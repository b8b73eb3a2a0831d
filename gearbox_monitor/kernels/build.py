# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Build compiled kernels: ``python -m gearbox_monitor.kernels.build FOLDER``, as installation does.

The library is for the kind of processor that builds it; on x86-64 those with AVX2 and FMA are one
kind, all others another, where what FMA does in one instruction is a call. A package that is
handed on has both, if GEARBOX_MONITOR_PORTABLE is set. All give the same bits: rounding is that of
IEEE 754, products are not contracted, and only traps and errno, which nobody asks for, are left
out.
"""
from collections.abc import Iterable
import hashlib
from importlib import import_module
import json
import os
from pathlib import Path
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels import library
from gearbox_monitor.kernels.declared import Declared, declared, result_format
from gearbox_monitor.kernels.translate.program import Program
from gearbox_monitor.kernels.translate.values import (
    Array, BOOL, FLOAT, INT, Known, NATURAL, Number, Record, Refused, Type)

EVERYTHING = 'gearbox_monitor.compiled'  # imports whatever has entries
FLAGS = ('-std=c99', '-fPIC', '-ffp-contract=off', '-fno-math-errno', '-fno-trapping-math',
         '-w')


def compiler() -> list[str]:
    """Return the command of a C compiler: CC, cc, gcc, clang or that of the package ziglang."""
    if os.environ.get('CC'):
        return shlex.split(os.environ['CC'])
    for name in ('cc', 'gcc', 'clang'):
        if shutil.which(name):
            return [name]
    try:
        import_module('ziglang')
    except ImportError:
        raise library.missing('no C compiler') from None
    return [sys.executable, '-m', 'ziglang', 'cc']


def type_of(kind: Declared) -> Type:
    """Return the type of a declared argument at translation."""
    if kind.kind == 'array':
        return Array(kind.element, kind.ndim)
    if kind.kind == 'tuple':
        return Record(tuple(map(type_of, kind.items)), kind.made_of)
    if kind.kind == 'folded':
        return Known(kind.value)
    return {'float': FLOAT, 'int': INT, 'natural': NATURAL, 'bool': BOOL}[kind.kind]


def _format(kind: Type) -> str:
    """Return what declared.result_format says of a result of this type."""
    if isinstance(kind, Record):
        return f'({"".join(map(_format, kind.items))})'
    if isinstance(kind, Number):
        return {'f': 'd', 'b': '?'}.get(kind.kind, 'q')
    return ''


def add(program: Program, entry: Any, symbol: str, types: Iterable[Declared]) -> None:
    """
    Add a variant of an entry to a program.

    Args:
        program: extended.
        entry: Entry.
        symbol: of the variant.
        types: of its arguments.

    Raises:
        TypeError: it returns something else than it declares.
        Refused: see Program.entry.
    """
    made = _format(program.entry(entry.__wrapped__, tuple(map(type_of, types)), symbol))
    stated = result_format(entry.__wrapped__)
    if made != stated:
        raise TypeError(f'{entry.__wrapped__.__module__}.{entry.__name__}: returns {made!r}, '
                        f'expected {stated!r} as it declares')


def units() -> tuple[dict[str, str], dict[str, str]]:
    """
    Return the C of all entries of the package, {flags of the compiler: text}, and its notes.

    What is folded or has no variants is compiled for speed, the general forms faster.
    """
    import_module(EVERYTHING)
    fast, general = Program(), Program()
    for entry in sorted(library.ENTRIES, key=lambda e: str(e.symbol)):
        for k, (symbol, types) in enumerate(entry.variants()):
            add(general if entry.usual and not k else fast, entry, symbol, types)
    texts = {'-O3': fast.text(), '-O2': general.text()}
    sources = '\n'.join(sorted({'kernels/build.py', *(
        str(Path(str(module.__file__)).relative_to(library.PACKAGE))
        for name, module in list(sys.modules.items())
        if name.startswith('gearbox_monitor.') and getattr(module, '__file__', None))}))
    notes = {'sources': sources, 'digest': library.digest(sources),
             'text': hashlib.sha256(str((compiler(), FLAGS, texts)).encode()).hexdigest()}
    texts['-O3'] += ''.join(f'const char *gm_{name} = {json.dumps(note)};\n'
                            for name, note in notes.items())
    return texts, notes


def compile_(texts: dict[str, str], path: Path, *flags: str) -> None:
    """
    Compile C to a library that is complete when it stands at its path.

    Args:
        texts: {flags: C}.
        path: of the library.
        flags: of the compiler for all, beside FLAGS.

    Raises:
        InputError: there is no compiler, or it fails.
    """
    path.parent.mkdir(0o700, parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        objects = []
        for own, text in texts.items():
            objects.append(str(Path(folder, f'kernels{own}.o')))
            Path(folder, f'kernels{own}.c').write_text(text)
            _run(FLAGS, flags, [own, '-c', '-o', objects[-1], f'{folder}/kernels{own}.c'])
        made = path.with_suffix(f'.{os.getpid()}')
        _run(['-shared', '-o', str(made)], objects, ['-lm'])
        os.replace(made, path)


def _run(*words: Iterable[str]) -> None:
    command = [*compiler(), *(word for part in words for word in part)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise library.missing(f'{command[0]} failed: '
                              f'{(run.stderr.strip().splitlines() or [""])[0]}')


def _flags(stem: str) -> list[str]:
    """Return the flags of the library `stem`."""
    if platform.machine() not in ('x86_64', 'AMD64'):
        return []
    zig, newer = 'ziglang' in compiler(), stem == library.STEMS[0]
    if zig:
        return ['-mcpu=x86_64_v3' if newer else '-mcpu=x86_64']
    return ['-march=x86-64-v3'] if newer else []


def package(folder: Path, stems: Iterable[str]) -> None:
    """
    Build the libraries `stems` of the package in `folder`. Raises InputError.

    One of the same C that is there already is copied: sources change more often than what they say
    in C.
    """
    stems = list(stems)
    texts, notes = units() if stems else ({}, {})
    for stem in stems:
        path = folder / f'{stem}.so'
        for other in (library.PACKAGE / path.name, *folder.parent.glob(f'*/{path.name}')):
            if all(library.note(other, name) == notes[name] for name in ('text', 'sources')):
                path.parent.mkdir(0o700, parents=True, exist_ok=True)
                copy = path.with_suffix(f'.{os.getpid()}')
                copy.write_bytes(other.read_bytes().replace(
                    library.note(other, 'digest').encode(), notes['digest'].encode()))
                os.replace(copy, path)
                break
        else:
            compile_(texts, path, *_flags(stem))


def one(entry: Any, symbol: str, types: Any, folder: Path) -> Path:
    """
    Return a library with one variant of an entry; it is built if it is new.

    Args:
        entry: Entry.
        symbol: of the variant.
        types: of its arguments.
        folder: of the libraries.

    Raises:
        InputError: there is no compiler.
        Refused: see Program.entry.
    """
    program = Program()
    add(program, entry, symbol, types)
    text = program.text()
    path = folder / f'{hashlib.sha256(text.encode()).hexdigest()[:24]}-{library.stems()[0]}.so'
    if not path.exists():
        compile_({'-O3': text}, path, *_flags(library.stems()[0]))
    return path


def translates(function: Any, annotations: Iterable[Any]) -> bool:
    """Return whether a `function` of arguments with `annotations` can be compiled here."""
    try:
        compiler()
        Program().instance(function, tuple(type_of(declared(a)) for a in annotations))
    except (InputError, Refused):
        return False
    return True


def main(folder: str, wanted: str = '') -> int:
    """
    Build the library `wanted` (of library.STEMS; '': the one for this processor) in `folder`.

    Of the others, those that a package has which is handed on. Returns the exit code.
    """
    usual = library.STEMS if os.environ.get('GEARBOX_MONITOR_PORTABLE') else library.stems()[:1]
    try:
        package(Path(folder), [s for s in usual if wanted in ('', s)])
    except InputError as error:
        sys.stderr.write(f'{error}\n')
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
