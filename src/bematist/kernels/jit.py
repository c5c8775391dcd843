"""How kernels are compiled: by numba, with fused multiply-add and IEEE NaN kept intact, and only where they never were on this machine.

To import numba takes longer than to filter twenty minutes of samples, so nothing here imports it before something must be compiled. A
`kernel`, which Python calls, is kept as machine code (`compiled.py`) and called without numba. The functions that it calls are needed only
while it is compiled: numba finds its own function behind each by `_numba_type_`.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import struct
import threading
import time
from array import array
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from bematist.kernels.compiled import Entry

# Without reference counting of arrays: kernels allocate nothing, and the counting would cost more than the arithmetic.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz"}, "_nrt": False}

# And without what Python would need to call them, which takes a fifth of the time to compile.
_BARE: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

announce: Callable[[str], AbstractContextManager[object]] = nullcontext
"""Called with the name of a kernel that must be compiled, which takes seconds; what it returns is entered meanwhile. For a command line."""

FOLDER = Path(__file__).parent


def sources() -> tuple[tuple[str, str], ...]:
    """The files of this folder and digests of what they hold: a kernel has code of several files inlined."""
    return tuple((f.name, hashlib.sha256(f.read_bytes()).hexdigest()) for f in sorted(FOLDER.glob("*.py")))


SOURCES = sources()
"""The files as they were imported: what is compiled later is theirs, whatever has become of them."""
STAMP = hashlib.sha256(repr(SOURCES).encode()).hexdigest()
"""The version of the kernels: of their code, and of how a state is laid out that they go on from."""

_lock = threading.RLock()
_preparing_s = 0.0


class Inlined:
    """A function that kernels call; numba's own function is made when it is asked for."""

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        functools.update_wrapper(self, function)
        self.function, self.options = function, _OPTIONS | options

    @functools.cached_property
    def dispatcher(self) -> Any:
        """numba's function, for a call from Python; the plain one where NUMBA_DISABLE_JIT is set."""
        from numba import njit

        return njit(**self.options)(self.function)

    @functools.cached_property
    def bare(self) -> Any:
        """numba's function, for calls from other compiled ones and for `compiled.py`."""
        from numba import njit

        return njit(**self.options, **_BARE)(self.function)

    @property
    def _numba_type_(self) -> Any:
        return self.bare._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        return self.dispatcher(*arguments)


class Kernel(Inlined):
    """A function that Python calls: `kernel(…)`, or what `kernel.bind(…)` returns, where the same arrays are used often."""

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        super().__init__(function, **options)
        self.name = f"{function.__module__}.{function.__name__}"
        self._entries: dict[tuple[str | int, ...], Entry | None] = {}

    @functools.cached_property
    def dispatcher(self) -> Any:
        from bematist.kernels.compiled import dispatcher

        return dispatcher(self.function, self.options)

    def __call__(self, *arguments: Any) -> Any:
        return self.bind(*arguments)()

    def bind(self, *arguments: Any) -> Callable[[], Any]:
        """A call with these arguments: arrays by reference, numbers by value.

        Types that cannot be handed over as they are, and whatever else is not as usual, are left to numba, which knows what to do or say.
        """
        words, kinds = [0, 0], []
        for argument in arguments:
            if not _hand_over(argument, words, kinds):
                return functools.partial(self.dispatcher, *arguments)
        key = tuple(kinds)
        entry = self._entries[key] if key in self._entries else self._prepared(key, arguments)
        return functools.partial(self.dispatcher, *arguments) if entry is None else Bound(self, entry, words, arguments)

    def __reduce__(self) -> str:
        return self.function.__qualname__

    def _prepared(self, kinds: tuple[str | int, ...], arguments: tuple[Any, ...]) -> Entry | None:
        global _preparing_s
        with _lock:
            if kinds not in self._entries:
                started = time.perf_counter()
                from bematist.kernels import compiled

                self._entries[kinds] = compiled.entry(self, kinds, arguments, announce)
                _preparing_s += time.perf_counter() - started
        return self._entries[kinds]


class Bound:
    """A call of a kernel with arguments that are given already; arrays may hold something else in each call."""

    def __init__(self, kernel: Kernel, entry: Entry, words: list[int], arguments: tuple[Any, ...]) -> None:
        self._given = kernel, *arguments  # kept, so that their memory stays
        self._words = array("q", words)
        self._address = self._words.buffer_info()[0]
        self._call, self._result = entry.call, entry.result

    def __call__(self) -> Any:
        """The code writes its result over the first word, where a failure would be told in the second, and returns its status."""
        if self._call(self._address):
            raise RuntimeError("A compiled kernel failed: with NUMBA_DISABLE_JIT=1 in the environment, Python says where.")
        return self._words[0] if self._result else None

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has copies of the arrays, which lie elsewhere."""
        return Kernel.bind, self._given


_NUMBERS: dict[type, str] = {float: "double", np.float64: "double", int: "integer", np.int64: "integer", bool: "truth", np.bool_: "truth"}


def _hand_over(argument: Any, words: list[int], kinds: list[str | int]) -> bool:
    """Append the words that numba's compiled functions take for an argument, and its kind; whether it is one that is known here.

    A number is one word. An array (writeable, in one piece) has two words for its owners (none, as nothing is counted), then size, bytes of
    an item, address, shape and strides. Of arguments of one kind the numba type is the same.
    """
    if type(argument) is np.ndarray:
        data: Any = argument
        dtype, size = data.dtype, data.size
        if not (data.flags.carray and dtype.kind in "fiu" and dtype.isnative):
            return False
        address = ctypes.addressof(ctypes.c_char.from_buffer(data)) if size else 0  # `data.ctypes.data` takes three times as long
        words += (0, 0, size, data.itemsize, address, *data.shape, *data.strides)
        kinds += (dtype.char, data.ndim)
        return True
    kind = _NUMBERS.get(type(argument))
    if kind is None:
        return False
    words += struct.unpack("q", struct.pack("d", argument)) if kind == "double" else (int(argument),)
    kinds.append(kind)
    return True


@contextmanager
def stopwatch() -> Iterator[Callable[[], float]]:
    """Tells the seconds since it was started, without those in which kernels were compiled or loaded."""
    started = time.perf_counter() - _preparing_s
    yield lambda: time.perf_counter() - _preparing_s - started


def kernel(function: Callable[..., Any]) -> Kernel:
    """A compiled function that Python calls."""
    return Kernel(function)


def summing(function: Callable[..., Any]) -> Kernel:
    """A kernel whose sums may be taken in any order, so that several numbers are added at once; not for recursions."""
    return Kernel(function, fastmath={*_OPTIONS["fastmath"], "reassoc"})


def inlined(function: Callable[..., Any]) -> Inlined:
    """A compiled function that other kernels call: always inlined, so that constants and layout fold into the caller."""
    return Inlined(function, forceinline=True)


def apart(function: Callable[..., Any]) -> Inlined:
    """A compiled function that other kernels call where they seldom do, or from many places: not inlined, so that loops stay small."""
    return Inlined(function)
