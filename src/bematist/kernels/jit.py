"""How kernels are compiled: once, into the cache beside the module, with fused multiply-add and IEEE NaN kept intact."""

import importlib.util
import sys
from collections.abc import Callable
from typing import Any

from numba import njit


def _spare_blas() -> None:
    """Let numba set itself up without importing scipy.linalg.

    numba does so only to ask whether there is a BLAS, which no kernel here needs, and it is half of the time that a compiled kernel takes
    to load. Its answer is then put right, so that other users of numba in the process find what they expect.
    """
    if "scipy.linalg" in sys.modules or "numba.np.arraymath" in sys.modules:
        return
    sys.modules["scipy.linalg"] = None  # pyright: ignore[reportArgumentType]
    try:
        from numba.np import arraymath
    finally:
        del sys.modules["scipy.linalg"]
    if hasattr(arraymath, "_HAVE_BLAS"):
        arraymath._HAVE_BLAS = importlib.util.find_spec("scipy") is not None


_spare_blas()
# Without reference counting of arrays: kernels allocate nothing, and the counting would cost more than the arithmetic.
_OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz"}, "_nrt": False}


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that Python calls."""
    return njit(**_OPTIONS, cache=True)(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that other kernels call: always inlined, so that constants and layout fold into the caller."""
    return njit(**_OPTIONS, forceinline=True)(function)
