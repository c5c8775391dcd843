"""How kernels are compiled: once, into the cache beside the module, with fused multiply-add and IEEE NaN kept intact."""

from collections.abc import Callable
from typing import Any

from numba import njit

_OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz"}, "_nrt": False}


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that Python calls."""
    return njit(**_OPTIONS)(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """A compiled function that other kernels call: always inlined, so that constants and layout fold into the caller."""
    return njit(**_OPTIONS, forceinline=True)(function)
