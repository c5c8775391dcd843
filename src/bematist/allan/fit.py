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
from bematist.allan.spectrum import fitted_density

Array = NDArray[np.float64]

EVIDENCE = 10.0
"""Least gain in -2 ln(likelihood) for each further parameter: about one noise invented in a hundred curves without it."""
_MISFIT = 0.001
"""A misfit less likely than this is taken for a departure from the model, and the intervals are widened until it is not."""
LONGEST_SKIPPED_S = 0.5
"""s: averaging times up to this may be left out where samples are smoothed; slower is no filter of a sensor."""
FEWEST_FITTED = 6
"""Averaging times that a fit keeps, at least."""
SLOWER = 5.0
"""Where short averaging times were left out, a Gauss-Markov process has at least this many times the first one for its correlation time:
a faster one would be what is left of the smoothing, and take its part of the white noise."""
SAFELY = 2
"""Further averaging times left out once the misfit may be chance: what smoothing takes from the variance halves with each octave."""
POOR = 0.3
"""A relative departure of the variances beyond which the noises do not describe the curve."""
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
    doubtful : noises that were found and could be none, the other ones of those found taking their place.
    departure : relative departure of the variances from the model that the intervals allow for; 0 where the model explains them.
    from_s : the shortest averaging time that was fitted, s.
    skipped : how many shorter ones were left out, because the samples are smoothed (filtered, held or interpolated).
    chi2, freedom : misfit before that allowance, and its degrees of freedom.
    edf : (M,) equivalent degrees of freedom of each variance under the fit.
    """

    coefficients: Mapping[str, Estimate]
    correlation: Estimate | None
    bounds: Mapping[str, float]
    doubtful: tuple[str, ...]
    departure: float
    from_s: float
    skipped: int
    chi2: float
    freedom: int
    edf: Array = field(repr=False)

    @property
    def good(self) -> bool:
        """Whether the noises describe the curve well enough for a filter to believe them."""
        return self.departure <= POOR

    def verdict(self) -> str:
        """How well the noises describe the curve, in words."""
        if not self.good:
            return f"does not fit: the variances depart by {100 * self.departure:.0f} % from any sum of these noises"
        within = f"fits within {100 * self.departure:.2g} % of the variances" if self.departure else "fits"
        return f"{within}, from {self.from_s:.2g} s on" if self.skipped else within

    def part(self, noise: str, taus: Array) -> Array:
        """The Allan variance (M,) of one of the noises that were found."""
        correlation_s = self.correlation.value if self.correlation else np.nan
        return self.coefficients[noise].value ** 2 * shapes([noise], np.asarray(taus, float), correlation_s)[:, 0]

    def variance(self, taus: Array, *, without: Sequence[str] = ()) -> Array:
        """The fitted Allan variance (M,) at averaging times in s; `without` some of its noises."""
        return np.sum([self.part(n, taus) for n in self.coefficients if n not in without] or [np.zeros(len(taus))], axis=0)

    def density(self, frequency: Array, period_s: float) -> Array:
        """One-sided spectral density (F,) of the fitted noises at frequencies (F,), Hz, of samples every period_s."""
        squares = {n: e.value**2 for n, e in self.coefficients.items()}
        return fitted_density(squares, self.correlation.value if self.correlation else np.nan, frequency, period_s)


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

    Where the misfit cannot be chance, short averaging times are left out one by one: what smooths the samples, a filter in the sensor or a
    slower sensor whose samples were held or interpolated, is none of the noises and spoils these alone. If that does not help, all are
    fitted, and the departure that would explain the misfit is added to the weights.
    """
    candidates = [n for n in NOISES if n in noises]
    # Relative to the first value, so that no number is too small for the solver.
    scale, departure, skipped = float(variance[0]), 0.0, 0
    v, part = variance / scale, overlap
    whole = found = _chosen(v, overlap, candidates, 0.0)
    while _misfits(found, len(v) - skipped) and skipped < _most_skipped(overlap):
        skipped += 1
        part = overlap.longer(skipped)
        found = _chosen(v[skipped:], part, candidates, 0.0)
    if skipped and not _misfits(found, len(v) - skipped):
        skipped = max(min(skipped + SAFELY, _most_skipped(overlap)), skipped)
        part = overlap.longer(skipped)
        found = _chosen(v[skipped:], part, candidates, 0.0)
    if _misfits(found, len(v) - skipped):
        skipped, part, found = 0, overlap, whole
        departure = _departure(v, overlap, whole, len(v) - whole.parameters)
        found = _chosen(v, overlap, candidates, departure)
        misfit = (whole.chi2, len(v) - whole.parameters)
    else:
        misfit = (found.chi2, len(v) - skipped - found.parameters)
    coefficients, correlation, bounds, doubtful = _intervals(found, v[skipped:], part, candidates, scale)
    own = np.diag(overlap.covariance(found.squares, found.correlation_s))
    model = shapes(list(found.squares), overlap.taus, found.correlation_s) @ np.array(list(found.squares.values()))
    return Fit(coefficients, correlation, bounds, doubtful, departure, float(part.taus[0]), skipped, *misfit, 2 * model**2 / own)


def _misfits(found: _State, values: int) -> bool:
    """Whether the misfit of a fit of so many variances cannot be chance."""
    freedom = values - found.parameters
    return freedom > 0 and found.chi2 > 2 * float(gammaincinv(freedom / 2, 1 - _MISFIT))


def _most_skipped(overlap: Overlap) -> int:
    return max(min(int((overlap.taus < LONGEST_SKIPPED_S).sum()), len(overlap.taus) - FEWEST_FITTED), 0)


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
            correlation_s = _correlation_time(names, overlap, whiten, whitened, correlation_s)
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


def _correlation_time(names: Sequence[str], overlap: Overlap, whiten: Array, whitened: Array, near: float) -> float:
    """The correlation time, s, at which the weighted misfit is least, within the averaging times; `near` is the last one, or NaN."""
    taus = overlap.taus
    shortest = taus[0] * (SLOWER if overlap.skipped else 1.0)

    def misfit(log_s: float) -> float:
        return nnls(whiten @ shapes(names, taus, np.exp(log_s)), whitened)[1]

    grid = np.linspace(np.log(shortest), np.log(taus[-1]), _GRID)
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


def _intervals(
    found: _State, v: Array, overlap: Overlap, candidates: Sequence[str], scale: float
) -> tuple[dict[str, Estimate], Estimate | None, dict[str, float], tuple[str, ...]]:
    """The coefficients that were found, the correlation time, the bounds of the others, and which of those found may be none."""
    names = [n for n, x in found.squares.items() if x > 0]
    whiten = _whitening(found.covariance)
    seen = [n for n in candidates if n != MARKOV or n in names]
    plain = Profile(v, overlap.taus, whiten, seen, found.correlation_s)
    # A Gauss-Markov process that was not found may still hide behind the others, at any correlation time.
    profiles = [plain, Profile(v, overlap.taus, whiten, candidates, np.nan)] if len(seen) < len(candidates) else [plain]
    coefficients, doubtful = {}, []
    for noise in names:
        square = found.squares[noise]
        lows, highs = zip(*(profile.interval(noise, square) for profile in profiles), strict=True)
        coefficients[noise] = Estimate(*(float(np.sqrt(scale * x)) for x in (square, min(lows), max(highs))))
        if lows[0] <= 0:
            doubtful.append(noise)
    correlation = Estimate(found.correlation_s, *plain.correlation_interval()) if MARKOV in names else None
    bounds = {n: float(np.sqrt(scale * max(p.bound(n) for p in profiles if n in p.noises))) for n in candidates if n not in names}
    return coefficients, correlation, bounds, tuple(doubtful)
