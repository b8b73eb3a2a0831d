# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
numba's compiler for our kernels: machine code is made, and optimised, once for each.

numba makes machine code of every function, and optimises it twice; what is compiled into its
callers needs none of its own. numba changes the inside of its compiler: a version that was not
tried compiles as it always does, which takes longer.
"""
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
import hashlib
from typing import Any

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompilerBase, DefaultPassBuilder
from numba.core.postproc import PostProcessor, VariableLifetime
from numba.core.transforms import canonicalize_cfg
from numba.core.types import Function

from gearbox_monitor.kernels.kernel_cache import content

TRIED = (0, 62) <= numba.version_info.short <= (0, 68)

# For each set of flags and each function of numba, by its identity: the function, and its
# signature for each combination of argument types.
_signatures: dict[str, dict[int, tuple[Function, dict[Any, Any]]]] = {}
_look_up = Function.get_call_type
_process = PostProcessor.run


@contextmanager
def spared_work(flags: str) -> Iterator[None]:
    """
    Let numba leave out what it does again and again, and what only Python objects need.

    It tries all overloads of an operator or numpy function at each place and in each round of its
    inference: what these return for the same types is remembered. And after each of its passes it
    computes which variables live where, for code that works on Python objects or yields. The
    caller holds numba's lock.

    flags: of the compilation, by which overloads are compiled
    """
    of_flags = _signatures.setdefault(flags, {})

    def _remembered(function: Function, context: Any, args: Any, kws: Any) -> Any:
        signatures = of_flags.setdefault(id(function), (function, {}))[1]
        key = context, tuple(args), tuple(dict(kws).items())
        if key not in signatures:
            signatures[key] = _look_up(function, context, args, kws)
        return signatures[key]

    def _processed(processor: PostProcessor, emit_dels: bool = False,
                   extend_lifetimes: bool = False) -> None:
        code = processor.func_ir
        if code.is_generator:
            _process(processor, emit_dels, extend_lifetimes)
            return
        code.blocks = canonicalize_cfg(code.blocks)
        code.variable_lifetime = VariableLifetime(code.blocks)  # computes once it is asked
        code.generator_info = None
        if emit_dels:
            processor._insert_var_dels(extend_lifetimes=extend_lifetimes)

    with _replaced(Function, 'get_call_type', _remembered), \
            _replaced(PostProcessor, 'run', _processed):
        yield


@contextmanager
def _replaced(owner: Any, name: str, function: Any) -> Iterator[None]:
    """Let the method `name` of the class `owner` be `function` for a while."""
    own = getattr(owner, name)
    setattr(owner, name, function)
    try:
        yield
    finally:
        setattr(owner, name, own)


class LinkingLibrary(JITCodeLibrary):
    """Code that brings along the parts that its parts call: these have linked none of them."""

    _linking_libraries: list[Any]

    def add_linking_library(self, library: Any) -> None:
        """Link `library`, and what that is made of."""
        library._ensure_finalized()
        self._linking_libraries += [library, *getattr(library, 'parts', ())]

    def finalize(self) -> None:
        """Link: a function behind the last one that calls it, else LLVM drops it."""
        self._linking_libraries = _last(self._linking_libraries)
        super().finalize()


def _last(libraries: list[Any]) -> list[Any]:
    """Return each of `libraries` once, where it comes last."""
    return [*dict.fromkeys(libraries[::-1])][::-1]


class KernelLibrary(LinkingLibrary):
    """Code of a kernel without reference counts: the pass that brings these together is left."""

    def _optimize_final_module(self) -> None:
        passes, builder = self._codegen._module_pass_manager()
        passes.run(self._final_module, builder)


class SharedLibrary(KernelLibrary):
    """Code of a kernel that others call: optimised, but what links it makes machine code of it."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, where there is machine code its address."""
        self._ensure_finalized()
        return 0


class PartLibrary(SharedLibrary):
    """Code of a part: what links it optimises it as well."""

    def finalize(self) -> None:
        """Take no more code."""
        self._raise_if_finalized()
        self.parts = _last(self._linking_libraries)
        self._finalize_final_module()


class AllocatingCompiler(CompilerBase):
    """numba's compiler for kernels that count references."""

    library: type[LinkingLibrary] = LinkingLibrary

    def define_pipelines(self) -> list[Any]:
        """Return numba's own pipeline, with a library of our kind as its result."""
        state = self.state
        self._number(state.func_id)
        state.library = self.library(self.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return [DefaultPassBuilder.define_nopython_pipeline(state)]

    def _compile_core(self) -> Any:
        with spared_work(self.state.flags.summary()):
            return super()._compile_core()

    def _number(self, function: Any) -> None:
        """
        Give a `function` a number of its content; numba counts those of a process.

        The linker goes by name and number: what two processes have compiled of closures with one
        number, or of a kernel and its copy around a plug-in, it would take for the same.
        """
        text = f'{type(self).__name__} {content(function.func)}'
        function.unique_id = int(hashlib.sha256(text.encode()).hexdigest()[:15], 16)
        function.unique_name = f'{function.func_qualname}${function.unique_id}'

    def codegen(self) -> Any:
        """Return what makes machine code."""
        return self.state.targetctx.codegen()


class KernelCompiler(AllocatingCompiler):
    """numba's compiler with a KernelLibrary as its result."""

    library = KernelLibrary


class SharedCompiler(AllocatingCompiler):
    """numba's compiler with a SharedLibrary as its result."""

    library = SharedLibrary

    def codegen(self) -> Any:
        """Return what makes code without a place for what a function keeps for Python."""
        codegen: Any = copy(super().codegen())
        codegen.set_env = lambda name, environment: None
        return codegen


class PartCompiler(SharedCompiler):
    """numba's compiler with a PartLibrary as its result."""

    library = PartLibrary


ALLOCATING, KERNEL, SHARED, PART = (
    compiler if TRIED else Compiler
    for compiler in (AllocatingCompiler, KernelCompiler, SharedCompiler, PartCompiler))
