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
from gearbox_monitor.kernels.translate.program import Program
from gearbox_monitor.kernels.translate.values import form

# Whose imports have all entries of the package.
EVERYTHING = (
    'estimation.innovation_filter', 'estimation.score',
    'health.checks.row_checks', 'health.checks.innovation', 'health.checks.observability',
    'health.elastic_regression', 'plant.batch', 'recordings.cdr',
    'robot.arm_plant', 'robot.dynamics')
FLAGS = ('-std=c99', '-O2', '-fPIC', '-ffp-contract=off', '-fno-math-errno',
         '-fno-trapping-math', '-w')
# Of GCC alone. On x86 a copy of two numbers must not wait until both were written.
X86 = platform.machine() in ('x86_64', 'AMD64')
ITS_FLAGS = ('-fvect-cost-model=dynamic', *(
    ('-mtune-ctrl=^sse_unaligned_load_optimal',) if X86 else ()))


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


def text_of(entries: Iterable[Any]) -> str:
    """
    Return the C of `entries`.

    Raises:
        TypeError: one returns something else than it declares.
        Refused: see Program.entry.
    """
    program = Program()
    for entry in entries:
        arguments, stated = entry.types
        made = program.entry(entry.__wrapped__, arguments, entry.symbol)
        if form([made]) != form([stated]):
            raise TypeError(f'{entry.__module__}.{entry.__name__}: returns {made}, expected '
                            f'{stated} as it declares')
    return program.text()


def compile_(text: str, path: Path, *flags: str) -> None:
    """
    Compile C to a library that is complete when it stands at its path.

    Args:
        text: the C.
        path: of the library; its name tells the kind of processor, see library.STEMS.
        flags: of the compiler beside FLAGS.

    Raises:
        InputError: there is no compiler, or it fails.
    """
    command, newer = [*compiler(), *FLAGS, *flags], path.stem.endswith(library.STEMS[0])
    if not subprocess.run([*command, *ITS_FLAGS, '-Werror', '-E', '-xc', os.devnull],
                          capture_output=True, check=False).returncode:
        command += ITS_FLAGS
    if X86:
        command.append(('-mcpu=x86_64' if 'ziglang' in command else '-march=x86-64') + (
            ('_v3' if 'ziglang' in command else '-v3') if newer else ''))
    path.parent.mkdir(0o700, parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        source, made = Path(folder, 'kernels.c'), Path(folder, 'kernels.so')
        source.write_text(text)
        run = subprocess.run([*command, '-shared', '-o', str(made), str(source), '-lm'],
                             capture_output=True, text=True, check=False)
        if run.returncode:
            lines = run.stderr.strip().splitlines() or ['']
            reason = next((line for line in lines if 'error' in line), lines[0])
            raise library.missing(f'{command[0]} failed: {reason}')
        os.replace(made, path)


def digest_of(text: str) -> str:
    """Return a digest of C and of what compiles it."""
    return hashlib.sha256(str((text, FLAGS, ITS_FLAGS, compiler())).encode()).hexdigest()[:24]


def compiled(text: str, folder: Path) -> Path:
    """Return the library of this C `text` in `folder`; it is built if it is new."""
    path = folder / f'{digest_of(text)}{library.stems()[0]}.so'
    if not path.exists():
        compile_(text, path)
    return path


def package(path: Path) -> None:
    """
    Build the library of the package at `path`. Raises InputError.

    One of the same C that is there already is copied: sources change more often than what they say
    in C.
    """
    for module in EVERYTHING:
        import_module(f'gearbox_monitor.{module}')
    text = text_of(sorted(library.ENTRIES, key=lambda entry: str(entry.symbol)))
    notes = [library.digest(), digest_of(text), *library.sources()]
    for other in path.parent.parent.glob(f'*/{path.name}'):
        old = library.notes(other)
        if old[1:] == notes[1:]:
            path.parent.mkdir(0o700, parents=True, exist_ok=True)
            made = path.with_suffix(f'.{os.getpid()}')
            made.write_bytes(other.read_bytes().replace(old[0].encode(), notes[0].encode()))
            os.replace(made, path)
            return
    compile_(f'{text}const char *gm_notes = "{" ".join(notes)}";\n', path)


def main(folder: str, wanted: str = '') -> int:
    """
    Build the library `wanted` (of library.STEMS; '': the one for this processor) in `folder`.

    Of the others, those that a package has which is handed on. Returns the exit code.
    """
    usual = library.STEMS if os.environ.get('GEARBOX_MONITOR_PORTABLE') else library.stems()[:1]
    try:
        for stem in usual:
            if wanted in ('', stem):
                package(Path(folder, f'{stem}.so').absolute())
    except InputError as error:
        sys.stderr.write(f'{error}\n')
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
