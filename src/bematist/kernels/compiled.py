"""Kernels as machine code in files, which LLVM loads without numba.

A file belongs to one kernel, the types of its arguments, this processor and these versions of Python, NumPy and numba; it is void when any
file of this folder changes. Beside numba's function it holds one that takes all arguments as words in a table (`_entry_text`), since numba
flattens each array into many and ctypes is slow with every argument. That function is all that a caller needs.

Only where this was tried, on Linux with an x86-64 processor; elsewhere, where anything is unexpected, and where numba is told something by
its environment variables, a kernel is numba's own function, in numba's own cache.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bematist.kernels.jit import FOLDER, SOURCES, STAMP, sources

if TYPE_CHECKING:
    from bematist.kernels.jit import Kernel

HARMLESS = {"NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS"}


class Entry(NamedTuple):
    """Compiled code: a function of the address of a table of words, which returns 0, and whether it has a result."""

    call: Callable[[int], int]
    result: bool


def entry(
    kernel: Kernel, kinds: tuple[str | int, ...], arguments: tuple[Any, ...], announce: Callable[[str], AbstractContextManager[object]]
) -> Entry | None:
    """The code of a kernel for arguments of these kinds, loaded, or compiled and kept; None: numba's own function is to be used."""
    usual = sys.platform == "linux" and os.uname().machine == "x86_64"
    if usual and not {name for name in os.environ if name.startswith("NUMBA_")} - HARMLESS:
        # Whatever goes wrong here, numba does the same work, and says what is wrong with arguments that do not fit.
        with suppress(Exception):
            name = _name(kernel, kinds)
            found = _read(name)
            if found is None:
                with announce(kernel.name):
                    found = _compiled(kernel, name, arguments)
                if sources() == SOURCES:  # else the code is of files that are no longer there
                    _write(name, *found)
            return _loaded(name, *found)
    with announce(kernel.name):
        _ready(kernel.dispatcher, arguments)
    return None


# -- files ---------------------------------------------------------------------------------------------------------------


def _name(kernel: Kernel, kinds: tuple[str | int, ...]) -> str:
    """The name of a file, and of the function in it: everything that the code depends on but the sources."""
    file = Path(kernel.function.__code__.co_filename)
    own = (0, 0) if file.parent == FOLDER else (file.stat().st_mtime_ns, file.stat().st_size)  # a kernel may be defined elsewhere
    what = own, kinds, *_surroundings()
    return f"{kernel.name}-{hashlib.sha256(repr(what).encode()).hexdigest()[:16]}"


@functools.cache
def _surroundings() -> tuple[Any, ...]:
    """Processor, versions and folder, which code depends on."""
    from llvmlite import binding as llvm

    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    return processor, sys.version_info[:3], np.__version__, version("numba"), version("llvmlite"), str(FOLDER)


def _folders() -> Iterator[Path]:
    """Where files are looked for, and written if that can be: as with numba, beside the sources or else in the user's own cache."""
    if told := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(told) / "bematist"
        return
    yield FOLDER / "__pycache__"
    with suppress(RuntimeError):  # nobody's home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "bematist"


def _read(name: str) -> tuple[bool, bytes] | None:
    """Whether the kernel of a file has a result, and its code; None without a file that is whole and of these sources."""
    for folder in _folders():
        with suppress(OSError, ValueError):
            head, code = (folder / f"{name}.code").read_bytes().split(b"\n", 1)
            stamp, digest, result = head.split()
            if stamp.decode() == STAMP and digest == hashlib.sha256(code).hexdigest().encode():
                return result == b"result", code
    return None


def _write(name: str, result: bool, code: bytes) -> None:
    """Keep code for the next process; a process that reads meanwhile sees all of it or nothing."""
    head = b" ".join((STAMP.encode(), hashlib.sha256(code).hexdigest().encode(), b"result" if result else b"none"))
    for folder in _folders():
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            unfinished = folder / f"{name}.{os.getpid()}"
            unfinished.write_bytes(head + b"\n" + code)
            unfinished.replace(folder / f"{name}.code")
            return


# -- code ----------------------------------------------------------------------------------------------------------------


def _machine(cpu: str, features: str) -> Any:
    """A target as numba chooses it, for code that is loaded anywhere in memory."""
    from llvmlite import binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(opt=3, cpu=cpu, features=features, reloc="static", codemodel="jitdefault", jit=True)


def _compiled(kernel: Kernel, name: str, arguments: tuple[Any, ...]) -> tuple[bool, bytes]:
    """A kernel compiled by numba for the types of these arguments: whether it has a result, and the code of the function `name`."""
    from llvmlite import binding as llvm
    from numba import typeof

    types = tuple(typeof(a) for a in arguments)
    kernel.bare.compile(types)
    made = kernel.bare.overloads[types]
    result = {"int64": True, "none": False}[str(made.signature.return_type)]
    module = llvm.parse_assembly(made.library.get_llvm_str())
    flat = [str(a.type) for a in module.get_function(made.fndesc.llvm_func_name).arguments]
    module.link_in(llvm.parse_assembly(_entry_text(name, made.fndesc.llvm_func_name, flat)))
    for item in (*module.functions, *module.global_variables):
        if item.name != name and not item.is_declaration:
            item.linkage = "internal"  # two files may hold functions of the same name
    module.verify()
    process = ctypes.CDLL(None)
    for item in module.functions:
        # What LLVM cannot find when it loads the code ends the process. Of numba's own helpers it would find none.
        if item.is_declaration and not item.name.startswith("llvm.") and not hasattr(process, item.name):
            raise LookupError(item.name)
    _, cpu, features = made.library.codegen.magic_tuple()
    return result, _machine(cpu, features).emit_object(module)


def _entry_text(name: str, inner: str, types: list[str]) -> str:
    """A function of a table of words, for each argument of numba's function `inner` one, in LLVM's language.

    The first two are places: for the result, and for what a failure would have to tell.
    """
    body = []
    for i, kind in enumerate(types):
        body += [f"%place{i} = getelementptr i64, ptr %table, i64 {i}", f"%word{i} = load i64, ptr %place{i}"]
        how = {"ptr": "inttoptr", "i64": "bitcast", "double": "bitcast"}.get(kind, "trunc")
        body.append(f"%argument{i} = {how} i64 %word{i} to {kind}")
    given = ["ptr %place0", "ptr %place1", *(f"{kind} %argument{i}" for i, kind in enumerate(types) if i > 1)]
    body += [f'%status = call i32 @"{inner}"({", ".join(given)})', "ret i32 %status"]
    return f'declare i32 @"{inner}"({", ".join(types)})\ndefine i32 @"{name}"(ptr %table) {{\n' + "\n".join(body) + "\n}\n"


@functools.cache
def _engine() -> Any:
    """What places code in memory and links it with the C library."""
    from llvmlite import binding as llvm

    machine = _machine(llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())
    module = llvm.parse_assembly("")
    module.triple = llvm.get_process_triple()
    return llvm.create_mcjit_compiler(module, machine)


def _loaded(name: str, result: bool, code: bytes) -> Entry:
    from llvmlite import binding as llvm

    engine = _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return Entry(ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)(engine.get_function_address(name)), result)


# -- numba's own ---------------------------------------------------------------------------------------------------------


def dispatcher(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """numba's own function for a kernel, in numba's cache; the plain one where NUMBA_DISABLE_JIT is set."""
    from numba import njit

    made: Any = njit(**options, cache=True)(function)
    # numba looks only whether the file of the kernel itself has changed, not at those of what is inlined into it.
    cache_file = getattr(getattr(made, "_cache", None), "_cache_file", None)
    if cache_file is not None and hasattr(cache_file, "_source_stamp"):
        cache_file._source_stamp = SOURCES
    return made


def _ready(function: Any, arguments: tuple[Any, ...]) -> None:
    """Let numba's own function be compiled or read for these arguments."""
    from numba import typeof

    if hasattr(function, "compile"):
        function.compile(tuple(typeof(a) for a in arguments))
