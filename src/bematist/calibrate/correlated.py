"""Errors that hang together in time: what is not white noise, such as a field that changes over the way of the hand, tells less than it
seems to by the number of samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONGEST_S = 5.0
"""Lags, s, up to which residuals are compared."""
BINS = 100
FEWEST = 20
"""Residuals; of fewer no correlation is told."""
TRIED = 60
"""Correlation times that are tried."""
SIGNIFICANT = 3.0
"""A correlation smaller than this many times its deviation by chance is none."""
FARTHEST = 6.0
"""Correlation times, beyond which nothing is left of a correlation."""


def correlation(residuals: Array, along: Array, time: Array) -> tuple[float, float]:
    """Share and correlation time, s, of the part of errors that hangs together: ρ(lag) = share · exp(-lag/T); the rest is white.

    residuals : (n,) of unit variance, each the component of an isotropic error along a direction (n,3), in the order of time (n,). Two of
    them have ρ(lag) times the cosine between their directions in common; ρ follows by least squares at each lag, up to twice the
    first that may be chance, and the exponential by least squares of these. A share of 0: the errors are white.
    """
    n = len(time)
    if n < FEWEST:
        return 0.0, 1.0
    width = max(float(np.median(np.diff(time))), LONGEST_S / BINS / 10)
    products, squares = np.zeros(BINS), np.zeros(BINS)
    for k in range(1, n):
        lag = time[k:] - time[:-k]
        at = (lag / width - 0.5).astype(np.int64)
        inside = (lag < LONGEST_S) & (at >= 0) & (at < BINS)
        if not (lag < LONGEST_S).any():
            break
        cosine = (along[k:] * along[:-k]).sum(1)
        products += np.bincount(at[inside], (residuals[k:] * residuals[:-k] * cosine)[inside], BINS)
        squares += np.bincount(at[inside], cosine[inside] ** 2, BINS)
    rho = products / np.maximum(squares, 1e-9) / float((residuals**2).mean())
    clear = rho * np.sqrt(squares) > SIGNIFICANT
    last = BINS if clear.all() else int(np.argmin(clear))
    if last == 0:
        return 0.0, 1.0
    upto = slice(0, min(2 * last, BINS))
    lags, weight, seen = width * np.arange(1, BINS + 1)[upto], squares[upto], rho[upto]
    tried = np.geomspace(width / 3, LONGEST_S, TRIED)
    shapes = np.exp(-lags / tried[:, None])
    shares = np.minimum((shapes * weight * seen).sum(1) / (shapes**2 * weight).sum(1), 1.0)
    best = int(np.argmin((weight * (seen - shares[:, None] * shapes) ** 2).sum(1)))
    return float(shares[best]), float(tried[best])


@dataclass(frozen=True, eq=False)
class Influence:
    """How the errors of samples move an estimate: time of each sample, s (n,), standard deviation of its error per axis (n,), and the
    derivatives (n,P,3) of the P parameters with respect to it.
    """

    time: Array
    sd: Array
    gain: Array


def influence(C: Array, J: Array, weight: Array, D: Array, time: Array, sd: Array) -> Influence:
    """That of residuals (n,d) with derivatives J (n,d,P) by the parameters and D (n,d,3) by the errors; weight (n,), covariance C (P,P).

    The estimate is -C Jᵀ W r: what an error e does to it is -C Jᵀ W D e.
    """
    return Influence(time, sd, np.einsum("pq,ndq,n,nde->npe", C, J, weight, D, optimize=True))


def spread(parts: Sequence[Influence], share: float, correlation_s: float) -> Array:
    """Covariance (P,P) of an estimate by errors that are isotropic, and correlated in time as `correlation` says.

    A sample that is used more than once, in its length and in a turn, counts with all that it does.
    """
    time, at = np.unique(np.concatenate([p.time for p in parts]), return_inverse=True)
    moved = np.zeros((len(time), *parts[0].gain.shape[1:]))
    np.add.at(moved, at, np.concatenate([p.gain * p.sd[:, None, None] for p in parts]))
    rows = moved.transpose(0, 2, 1)
    total = np.einsum("nep,neq->pq", rows, rows)
    for k in range(1, len(time) if share else 0):
        lag = time[k:] - time[:-k]
        near = lag < FARTHEST * correlation_s
        if not near.any():
            break
        rho = share * np.exp(-lag[near] / correlation_s)
        one = np.einsum("nep,neq->pq", rows[:-k][near] * rho[:, None, None], rows[k:][near])
        total += one + one.T
    return total
