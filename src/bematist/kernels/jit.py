"""How kernels are compiled: once, into the cache beside the module, with fused multiply-add and IEEE NaN kept intact."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import event

# Without reference counting of arrays: kernels allocate nothing, and the counting would cost more than the arithmetic.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz"}, "_nrt": False}


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that Python calls."""
    return _cached(njit(**_OPTIONS, cache=True)(function))


@contextmanager
def stopwatch() -> Iterator[Callable[[], float]]:
    """Tells the seconds since it was started, without those in which kernels were compiled or loaded from the cache."""
    with event.install_listener("numba:compiler_lock", event.TimingListener()) as compiling:
        started = time.perf_counter()
        yield lambda: time.perf_counter() - started - (compiling.duration if compiling.done else 0.0)


def summing(function: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel whose sums may be taken in any order, so that several numbers are added at once; not for recursions."""
    options: dict[str, Any] = _OPTIONS | {"fastmath": {*_OPTIONS["fastmath"], "reassoc"}}
    return _cached(njit(**options, cache=True)(function))


def _cached(dispatcher: Any) -> Any:
    _load_at_once(dispatcher)
    _stamp(dispatcher)
    return dispatcher


def _stamp(dispatcher: Any) -> None:
    """Let the cache of a kernel be void when any file of this folder changes.

    numba looks only at the file of the kernel itself, not at those of the functions that are inlined into it.
    """
    cache_file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if cache_file is not None and hasattr(cache_file, "_source_stamp"):
        files = sorted(Path(__file__).parent.glob("*.py"))
        cache_file._source_stamp = tuple((f.name, f.stat().st_mtime, f.stat().st_size) for f in files)


def _load_at_once(dispatcher: Any) -> None:
    """Let a kernel be loaded from the cache without numba's registries of everything that it could compile.

    Before it looks into the cache, numba loads them all, half a second with scipy.linalg among them. Only compiling needs them, and loads
    them itself. Where numba's cache looks otherwise than here, it is left alone.
    """
    cache = getattr(dispatcher, "_cache", None)
    load, guard = getattr(cache, "_load_overload", None), getattr(cache, "_guard_against_spurious_io_errors", None)
    if cache is None or load is None or guard is None:
        return

    def load_overload(signature: Any, target_context: Any) -> Any:
        with guard():
            return load(signature, target_context)

    cache.load_overload = load_overload


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that other kernels call: always inlined, so that constants and layout fold into the caller."""
    return njit(**_OPTIONS, forceinline=True)(function)


def apart(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that other kernels call where they seldom do, or from many places: not inlined, so that loops stay small."""
    return njit(**_OPTIONS)(function)
