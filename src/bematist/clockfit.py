"""The uniform clock behind jittered stamps, and what the signal itself says about when its samples were taken."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from bematist.arrays import median

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LONG_GAP_S = 1.0
"""After a longer gap the clock is fitted anew: its phase may have changed."""
KNOT_S = 30.0
"""Spacing of the knots of a fitted clock: the rate of a sensor's oscillator wanders with temperature."""

JUDGED = 20000
"""Samples on which the signal is asked."""


def period(t: Array) -> float:
    """Robust sampling period (s) of stamps (N,), N ≥ 2: the mode of the steps where they agree, else a long-lag slope."""
    d = np.diff(t)
    positive = d[d > 0]
    if not len(positive):
        return float("nan")
    m = median(positive)
    near = positive[np.abs(positive - m) < 0.3 * m]
    if len(near) > 0.7 * len(d):
        return float(near.mean())
    lag = max(1, min(200, len(t) // 4))
    return max(median(t[lag:] - t[:-lag]) / lag, 1e-9)


def uniform(t: Array, count: Index | None = None) -> tuple[Array, Index]:
    """Times (N,) of a uniform clock that stamps t (N,), N ≥ 2, report with jitter, and samples lost (N−1,) at each step.

    The index of each sample is found first: a lost sample shifts the level of the stamps against the index for good, a
    late report does not. `count` (N,), the sensor's own sample counter, spares the search. Then the clock is fitted, piece by
    piece between long gaps.
    """
    T = period(t)
    d = np.diff(t)
    far = np.abs(d / T - np.round(d / T))
    if count is not None:
        lost = np.diff(count) - 1
        lag = max(1, min(1000, len(t) // 4))
        T = float(np.median((t[lag:] - t[:-lag]) / (count[lag:] - count[:-lag])))
    elif np.quantile(far, 0.99) < 0.25 and np.mean(d < 0.5 * T) < 0.01:
        lost = np.maximum(np.round(d / T).astype(np.int64) - 1, 0)
    else:
        lost, T = _lost_among_jitter(t, T)
    index = np.concatenate([[0], np.cumsum(lost + 1)])
    out = np.empty(len(t))
    edges = [0, *(np.flatnonzero(lost * T > LONG_GAP_S) + 1), len(t)]
    for a, b in itertools.pairwise(edges):
        out[a:b] = _fit_piece(t[a:b], index[a:b] - index[a], T)
        if a and out[a] <= out[a - 1]:
            out[a:b] += out[a - 1] + T - out[a]
    return out, lost


def _lost_among_jitter(t: Array, T: float) -> tuple[Index, float]:
    """Samples lost at each step where single steps say nothing, and the period."""
    from bematist.kernels.lost import BEAM, NEXT, lost_samples

    d = np.diff(t)
    usual = d[np.abs(d - T) < 20 * T]
    jitter = max(float(np.std(usual)) / np.sqrt(2) if len(usual) else T, 0.03 * T)
    # Odds of one loss in some thousand samples; late reports beyond four deviations weigh no more.
    lost = np.zeros(len(t) - 1, np.int64)
    real, whole = np.zeros((6, NEXT)), np.zeros((4, NEXT), np.int64)
    parent, loss = np.zeros((len(t), BEAM), np.int8), np.zeros((len(t), BEAM), np.int32)
    lost_samples(np.ascontiguousarray(t), T, jitter, 9.0, 8.0, real, whole, parent, loss, lost)
    index = np.concatenate([[0], np.cumsum(lost + 1)])
    lag = max(1, min(1000, len(t) // 4))
    return lost, float(np.median((t[lag:] - t[:-lag]) / (index[lag:] - index[:-lag])))


def _fit_piece(t: Array, k: Index, T: float) -> Array:
    """Least-squares clock through stamps t at indices k, a line with knots each 30 s, late reports held down."""
    n = len(t)
    if n < 3:
        return t[0] + T * k
    span = float(k[-1]) * T
    cells = max(1, int(span // KNOT_S)) if n > 200 else 1
    x = k / k[-1] * cells
    cell = np.minimum(x.astype(np.int64), cells - 1)
    right = x - cell
    weight = np.ones(n)
    fit = np.zeros(n)
    knots = np.zeros(cells + 1)
    for _ in range(3):
        knots = _hat_solve(cell, right, weight, t - t[0], cells)
        fit = knots[cell] * (1 - right) + knots[cell + 1] * right
        r = t - t[0] - fit
        scale = 3 * 1.4826 * float(np.median(np.abs(r - np.median(r)))) + 1e-12
        weight = np.minimum(1.0, scale / np.maximum(np.abs(r), 1e-12))
    # A piece too short to tell its own rate takes the common one.
    if n < 50 or np.any(np.diff(knots) <= 0):
        return t[0] + T * k + np.median(t - t[0] - T * k)
    return t[0] + fit


def _hat_solve(cell: Index, right: Array, weight: Array, y: Array, cells: int) -> Array:
    left = 1 - right
    m = cells + 1
    A = np.zeros((m, m))
    g = np.zeros(m)
    for i, a in ((0, left), (1, right)):
        np.add.at(g, np.arange(cells) + i, np.bincount(cell, weight * a * y, cells))
        for j, c in ((0, left), (1, right)):
            A[np.arange(cells) + i, np.arange(cells) + j] += np.bincount(cell, weight * a * c, cells)
    return np.asarray(np.linalg.lstsq(A, g, rcond=None)[0], float)


def signal_vote(t_stamps: Array, t_uniform: Array, values: Array) -> float:
    """How many standard errors the signal prefers the uniform clock (positive) to the stamps (negative).

    Each sample of `values` (N,C) is predicted by the cubic through its two neighbours on either side, once on each time axis;
    the true axis leaves the smaller residual. The mean of the logarithm of their ratio is judged against its spread.
    """
    good = np.isfinite(values).all(1)
    ts, tu, x = t_stamps[good], t_uniform[good], values[good]
    if len(x) < 60:
        return 0.0
    if len(x) > JUDGED:
        # The stretch that moves most says most.
        starts = range(0, len(x) - JUDGED + 1, JUDGED // 2)
        start = max(starts, key=lambda i: float(x[i : i + JUDGED].var(0).sum()))
        ts, tu, x = (v[start : start + JUDGED] for v in (ts, tu, x))
    a, b = _cubic_residual(ts, x), _cubic_residual(tu, x)
    scale = np.minimum(a, b).mean(0)
    moving = scale > 0
    if not moving.any():
        return 0.0
    a, b = (a[:, moving] / scale[moving]).mean(1), (b[:, moving] / scale[moving]).mean(1)
    floor = float(np.median(np.minimum(a, b))) + 1e-6
    ratio = np.log((a + floor) / (b + floor))
    spread = float(ratio.std())
    # Five samples share each prediction: a third of the samples count as independent.
    return float(ratio.mean() / spread * np.sqrt(len(ratio) / 3)) if spread > 0 else 0.0


def _cubic_residual(t: Array, x: Array) -> Array:
    """Squared residuals (N−4,C) of the cubic prediction, over the noise that its weights let through."""
    k = np.arange(2, len(t) - 2)
    near = np.stack([k - 2, k - 1, k + 1, k + 2], 1)
    dt = t[near] - t[k][:, None]
    w = np.ones((len(k), 4))
    for i in range(4):
        for j in range(4):
            if i != j:
                w[:, i] *= dt[:, j] / (dt[:, j] - dt[:, i])
    predicted = sum(w[:, i, None] * x[near[:, i]] for i in range(4))
    return (x[k] - predicted) ** 2 / (1 + (w**2).sum(1))[:, None]
