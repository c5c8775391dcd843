"""Which noises a curve of Allan variances holds, how large they are, and how sure that is.

Generalised least squares of the variance on the sum of noises of `noises.py`, with coefficients that cannot be negative. The weights
are the inverse covariance of the overlapping estimates under the fitted sum itself, so that the fit is repeated until it agrees with
its weights. A noise is taken in only where it improves the likelihood (the Gaussian one of the variances) by more than `EVIDENCE`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar, nnls
from scipy.special import gammaincinv

from bematist.allan.covariance import Overlap
from bematist.allan.noises import MARKOV, NOISES, shapes
from bematist.allan.profile import Profile

Array = NDArray[np.float64]

EVIDENCE = 10.0
"""Least gain in -2 ln(likelihood) for each further parameter: about one noise invented in a hundred curves without it."""
_MISFIT = 0.001
"""A misfit less likely than this is taken for a departure from the model, and the intervals are widened until it is not."""
_ROUNDS = 12
_GRID = 20


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Fit:
    """The noises of one axis.

    Attributes
    ----------
    coefficients : noise → coefficient in SI (Q, N, B, K, R, and the standard deviation of the Gauss-Markov process).
    correlation : its correlation time, s; None where there is none.
    bounds : noise that was not found → the largest coefficient (95 %, one-sided) that could have been missed.
    departure : relative departure of the variances from the model that the intervals allow for; 0 where the model explains them.
    chi2, freedom : misfit before that allowance, and its degrees of freedom.
    edf : (M,) equivalent degrees of freedom of each variance under the fit.
    """

    coefficients: Mapping[str, Estimate]
    correlation: Estimate | None
    bounds: Mapping[str, float]
    departure: float
    chi2: float
    freedom: int
    edf: Array = field(repr=False)

    def variance(self, taus: Array, *, without: Sequence[str] = ()) -> Array:
        """The fitted Allan variance (M,) at averaging times in s; `without` some of its noises."""
        correlation_s = self.correlation.value if self.correlation else np.nan
        names = [n for n in self.coefficients if n not in without]
        if not names:
            return np.zeros(len(taus))
        return shapes(names, np.asarray(taus, float), correlation_s) @ np.array([self.coefficients[n].value ** 2 for n in names])


@dataclass(frozen=True, eq=False)
class _State:
    """A fit of given noises: squared coefficients, correlation time, covariance of the variances, -2 ln(likelihood)."""

    squares: dict[str, float]
    correlation_s: float
    covariance: Array
    cost: float
    chi2: float

    @property
    def parameters(self) -> int:
        return len(self.squares) + (MARKOV in self.squares)


def fit_noises(variance: Array, overlap: Overlap, noises: Sequence[str] = NOISES) -> Fit:
    """Fit a curve of overlapping Allan variances (M,) at the averaging times of `overlap`.

    noises : the ones to choose from; white noise is always among them.
    """
    candidates = [n for n in NOISES if n in noises]
    # Relative to the first value, so that no number is too small for the solver.
    scale = float(variance[0])
    found = _chosen(variance / scale, overlap, candidates, 0.0)
    misfit, freedom = found.chi2, len(variance) - found.parameters
    departure = 0.0
    if freedom > 0 and misfit > 2 * gammaincinv(freedom / 2, 1 - _MISFIT):
        departure = _departure(variance / scale, overlap, found, freedom)
        found = _chosen(variance / scale, overlap, candidates, departure)
    return _described(found, variance / scale, overlap, candidates, scale, departure, (misfit, freedom))


def _chosen(v: Array, overlap: Overlap, candidates: Sequence[str], departure: float) -> _State:
    """The noises that the likelihood asks for: one after the other, and out again where a later one makes it needless."""
    best = _converged(v, overlap, ["white"], departure)
    tried = {frozenset(best.squares)}
    while True:
        have = set(best.squares)
        sets = [have | {n} for n in candidates if n not in have]
        sets += [(have | {n}) - {m} for n in candidates if n not in have for m in have - {"white"}]
        sets += [have - {m} for m in have - {"white"}]
        sets = [s for s in sets if frozenset(s) not in tried]
        tried |= {frozenset(s) for s in sets}
        fits = [_converged(v, overlap, [n for n in NOISES if n in s], departure) for s in sets]
        better = min([best, *fits], key=lambda f: f.cost + EVIDENCE * f.parameters)
        if better is best:
            return best
        best = better


def _converged(v: Array, overlap: Overlap, names: Sequence[str], departure: float) -> _State:
    """Repeat weights and fit until they agree; a noise whose coefficient is zero is left out."""
    squares = {"white": float(np.median(v * overlap.taus))}
    correlation_s = np.nan
    covariance = _spread(v, overlap, squares, correlation_s, departure) if len(names) == 1 else _rough(v, overlap)
    previous = np.zeros(len(names))
    for _ in range(_ROUNDS):
        whiten = _whitening(covariance)
        whitened = whiten @ v
        if MARKOV in names:
            correlation_s = _correlation_time(names, overlap.taus, whiten, whitened, correlation_s)
        c, _ = nnls(whiten @ shapes(names, overlap.taus, correlation_s), whitened)
        squares = {n: float(x) for n, x in zip(names, c, strict=True)}
        if not any(squares.values()):
            squares = {"white": float(np.min(v * overlap.taus))}
        covariance = _spread(v, overlap, squares, correlation_s, departure)
        if np.allclose(c, previous, rtol=1e-3, atol=0):
            break
        previous = c
    squares = {n: x for n, x in squares.items() if x > 0}
    squares.setdefault("white", 0.0)
    return _judged(v, overlap, squares, correlation_s, covariance)


def _whitening(covariance: Array) -> Array:
    """Inverse of the Cholesky factor: it makes the residuals independent and of unit variance."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)), float)


def _rough(v: Array, overlap: Overlap) -> Array:
    """A covariance to start with: that of white noise's correlations around the curve as it is."""
    c = overlap.covariance({"white": 1.0})
    scale = v * overlap.taus
    return c * np.outer(scale, scale)


def _spread(v: Array, overlap: Overlap, squares: Mapping[str, float], correlation_s: float, departure: float) -> Array:
    c = overlap.covariance(squares, correlation_s)
    d = np.diag(c)
    return c + np.diag(1e-9 * d + (departure * v) ** 2)


def _correlation_time(names: Sequence[str], taus: Array, whiten: Array, whitened: Array, near: float) -> float:
    """The correlation time, s, at which the weighted misfit is least, within the averaging times; `near` is the last one, or NaN."""

    def misfit(log_s: float) -> float:
        return nnls(whiten @ shapes(names, taus, np.exp(log_s)), whitened)[1]

    grid = np.linspace(np.log(taus[0]), np.log(taus[-1]), _GRID)
    at = int(np.argmin([misfit(x) for x in grid])) if np.isnan(near) else int(np.argmin(np.abs(grid - np.log(near))))
    bracket = (grid[max(at - 1, 0)], grid[min(at + 1, _GRID - 1)])
    found: Any = minimize_scalar(misfit, bounds=bracket, method="bounded", options={"xatol": 1e-3})
    return float(np.exp(found.x))


def _judged(v: Array, overlap: Overlap, squares: dict[str, float], correlation_s: float, covariance: Array) -> _State:
    residual = v - shapes(list(squares), overlap.taus, correlation_s) @ np.array(list(squares.values()))
    whiten = _whitening(covariance)
    misfit = float(np.sum((whiten @ residual) ** 2))
    return _State(squares, correlation_s, covariance, misfit - 2 * float(np.log(np.diag(whiten)).sum()), misfit)


def _departure(v: Array, overlap: Overlap, found: _State, freedom: int) -> float:
    """The relative departure from the model that makes the misfit as large as its degrees of freedom."""
    residual = v - shapes(list(found.squares), overlap.taus, found.correlation_s) @ np.array(list(found.squares.values()))
    low, high = 0.0, 10.0
    for _ in range(40):
        middle = (low + high) / 2
        spread = found.covariance + np.diag((middle * v) ** 2)
        low, high = (middle, high) if residual @ np.linalg.solve(spread, residual) > freedom else (low, middle)
    return high


def _described(
    found: _State, v: Array, overlap: Overlap, candidates: Sequence[str], scale: float, departure: float, misfit: tuple[float, int]
) -> Fit:
    names = [n for n, x in found.squares.items() if x > 0]
    values = np.array([found.squares[n] for n in names])
    profile = Profile(
        v, overlap.taus, _whitening(found.covariance), [n for n in candidates if n != MARKOV or n in names], found.correlation_s
    )
    coefficients = {}
    for noise, square in zip(names, values, strict=True):
        low, high = profile.interval(noise, square)
        coefficients[noise] = Estimate(*(float(np.sqrt(scale * x)) for x in (square, low, high)))
    correlation = Estimate(found.correlation_s, *profile.correlation_interval()) if MARKOV in names else None
    bounds = {n: float(np.sqrt(scale * profile.bound(n))) for n in candidates if n not in names and n != MARKOV}
    own = np.diag(overlap.covariance(found.squares, found.correlation_s))
    edf = 2 * (shapes(names, overlap.taus, found.correlation_s) @ values) ** 2 / own
    return Fit(coefficients, correlation, bounds, departure, misfit[0], misfit[1], edf)
