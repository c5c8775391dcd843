"""Intervals of samples for which something holds."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def intervals(flags: ArrayLike) -> NDArray[np.int64]:
    """First and one-past-last row (S,2) of every interval in which the flags (N,), true or 1, hold."""
    held = np.concatenate([[False], np.asarray(flags, bool), [False]])
    return np.flatnonzero(held[1:] != held[:-1]).reshape(-1, 2)
