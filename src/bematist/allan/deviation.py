"""Overlapping Allan variance of signals with gaps, one axis at a time, so that only one running sum is held."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bematist.errors import UsageError
from bematist.kernels import allan as kernel

Array = NDArray[np.float64]
Spacing = Literal["octave", "decade"]

LONGEST_PART = 3
"""The longest averaging time is this part of the longest stretch without a gap: beyond, hardly a degree of freedom is left."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """Rows of the samples of a sensor, in stretches without a gap, and the sampling period."""

    rows: tuple[slice, ...]
    period_s: float

    @property
    def lengths(self) -> NDArray[np.int64]:
        return np.array([s.stop - s.start for s in self.rows], np.int64)


def stretches(time: Array) -> Stretches:
    """Cut sample times (n,), s, at gaps. A step of more than 1.5 periods is one; where steps vary, of more than 3.5."""
    steps = np.diff(time)
    period = float(np.median(steps))
    uneven = float(np.mean(np.abs(steps - period) > 0.1 * period)) > 0.1
    gaps = np.flatnonzero(steps > (3.5 if uneven else 1.5) * period) + 1
    edges = np.concatenate([[0], gaps, [len(time)]])
    rows = tuple(slice(int(a), int(b)) for a, b in pairwise(edges) if b - a > 1)
    long = sum(float(time[s.stop - 1] - time[s.start]) for s in rows)
    return Stretches(rows, long / sum(s.stop - s.start - 1 for s in rows))


def averaging_spans(longest: int, spacing: Spacing = "octave") -> NDArray[np.int64]:
    """Averaging times in samples: 1, 2, 4, 8 … or 1, 2, 5, 10, 20, 50 …, to a third of the longest stretch.

    Raises
    ------
    UsageError
        The spacing is unknown.
    """
    most = max(longest // LONGEST_PART, 1)
    if spacing == "octave":
        return 2 ** np.arange(int(np.log2(most)) + 1, dtype=np.int64)
    if spacing == "decade":
        spans = np.outer(10 ** np.arange(int(np.log10(most)) + 1, dtype=np.int64), [1, 2, 5]).ravel()
        return spans[spans <= most]
    raise UsageError(f'There is no spacing "{spacing}" of averaging times: choose octave or decade.')


def overlapping_variance(values: Array, pieces: Stretches, spans: NDArray[np.int64], room: Array | None = None) -> Array:
    """Overlapping Allan variance (M,) of one axis (n,) at spans (M,) in samples.

    σ²(mτ) = Σ (x[i+2m] - 2 x[i+m] + x[i])² / (2 m² terms), x the running sum of the values; second differences do not reach over a gap.
    `room` is memory for the running sum of the longest stretch, at least one longer than it, to be used for one axis after the other.
    """
    squares, terms = np.zeros(len(spans)), np.zeros(len(spans))
    sums = np.empty(int(pieces.lengths.max()) + 1) if room is None else room
    mean = float(values.mean())
    for rows in pieces.rows:
        n = rows.stop - rows.start
        kernel.running_sum(values[rows], mean, sums[: n + 1])
        kernel.squared_differences(sums[: n + 1], spans, squares)
        terms += np.clip(n + 1 - 2 * spans, 0, None)
    return squares / (2.0 * spans.astype(float) ** 2 * terms)
