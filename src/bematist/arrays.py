"""What NumPy does slowly for long, narrow arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def complete(values: Array) -> NDArray[np.bool_]:
    """Rows (N,) of (N,C) in which every value is finite. By columns: four times as fast as `np.isfinite(values).all(1)`."""
    return np.logical_and.reduce(list(np.isfinite(values).T))


def median(values: Array) -> float:
    """The median of all values that are not NaN, as `np.nanmedian` has it to the bit: that imports numpy.ma, which takes longer than all
    the medians of a recording; NaN where there is none.
    """
    known = values[~np.isnan(values)]
    if not len(known):
        return float("nan")
    half = len(known) // 2
    parts = np.partition(known, [max(half - 1, 0), half])
    return float(parts[half] if len(known) % 2 else (parts[half - 1] + parts[half]) / 2)
