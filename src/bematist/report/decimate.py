"""Fewer points that draw the same picture. Pure numpy; nothing here knows of pages or plots."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

PREFILTER = 30_000
"""Points of a path that `path_indices` looks at closely; the rest is thinned by distance first."""


def extreme_indices(y: ArrayLike, n: int) -> Index:
    """Indices (≤ n + 2) of a series (N,): first, last, and the smallest and largest value of every bucket.

    A bucket without a finite value stands with one index, so that a gap in a line stays a gap.
    """
    y = np.asarray(y, float)
    N = len(y)
    if n + 2 >= N:
        return np.arange(N)
    buckets = max(n // 2, 1)
    size = -(-N // buckets)
    buckets = -(-N // size)
    padded = np.full(buckets * size, np.nan)
    padded[:N] = y
    rows = padded.reshape(buckets, size)
    bad = ~np.isfinite(rows)
    low, high = np.where(bad, np.inf, rows).argmin(1), np.where(bad, -np.inf, rows).argmax(1)
    start = np.arange(buckets) * size
    # argmin and argmax of a bucket of nothing but gaps are both its first index.
    keep = np.zeros(N, bool)
    keep[0] = keep[-1] = keep[start + low] = keep[start + high] = True
    return np.flatnonzero(keep)


def envelope(low: ArrayLike, high: ArrayLike, n: int) -> tuple[Index, Array, Array]:
    """A band thinned to about n instants that still covers all of it: indices, lower edge, upper edge.

    Gaps (NaN) inside a bucket are bridged; a bucket of nothing but gaps stays one.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    N = len(low)
    if n >= N:
        return np.arange(N), low, high
    start = np.arange(0, N, -(-N // n))
    lower = np.fmin.reduceat(low, start)
    upper = np.fmax.reduceat(high, start)
    start = np.append(start, N - 1)
    return start, np.append(lower, low[-1]), np.append(upper, high[-1])


def path_indices(points: ArrayLike, n: int, keep: ArrayLike = ()) -> Index:
    """Indices of a path (N,2) that keep its shape, at most about n besides those of `keep`; rows that are not finite are dropped.

    The path is thinned by the distance walked, then simplified with the smallest tolerance that meets n.
    Source: D. Douglas, T. Peucker, Cartographica 10, 1973, all segments of one level at a time.
    """
    p = np.asarray(points, float)
    good = np.flatnonzero(np.isfinite(p).all(1))
    if len(good) <= 2:
        return good
    kept = good[_by_distance(p[good], PREFILTER)]
    extent = float(np.ptp(p[kept], axis=0).max())
    if extent == 0:
        kept = good[[0, -1]]
    tolerance = extent / 5000
    while tolerance > 0:
        kept = kept[_simplify(p[kept], tolerance)]
        if len(kept) <= n:
            break
        tolerance *= 1.5
    chosen = np.zeros(len(p), bool)
    chosen[kept] = chosen[np.asarray(keep, np.int64)] = True
    return np.flatnonzero(chosen & np.isfinite(p).all(1))


def _by_distance(p: Array, n: int) -> Index:
    """First, last, and each point where the distance walked passes a multiple of length/n; of few points, each that differs from the last.

    Equal points would be equally far from a chord, so that simplification could not drop one without the others.
    """
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    share = walked if len(p) <= n or not walked[-1] > 0 else np.floor(walked / walked[-1] * n)
    passed = np.flatnonzero(np.diff(share)) + 1
    return np.unique(np.concatenate([[0], passed, [len(p) - 1]]))


def _simplify(p: Array, tolerance: float) -> NDArray[np.bool_]:
    """Which points of a path (N,2) stay so that none of the others is further than the tolerance from its chord."""
    keep = np.zeros(len(p), bool)
    keep[[0, -1]] = True
    while True:
        ends = np.flatnonzero(keep)
        segment = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
        a, b = p[ends[segment]], p[ends[segment + 1]]
        far = _distance_to_chord(p[: ends[-1]], a, b)
        worst = np.maximum.reduceat(far, ends[:-1])
        split = np.flatnonzero((far == worst[segment]) & (far > tolerance))
        if not len(split):
            return keep
        keep[split] = True


def _distance_to_chord(p: Array, a: Array, b: Array) -> Array:
    """Distances (N,) of points from the chords a–b, m."""
    d, r = b - a, p - a
    square = (d * d).sum(1)
    along = np.clip((r * d).sum(1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.linalg.norm(r - along[:, None] * d, axis=1)
