"""Intervals of the coefficients by profile: how far one may go while all other noises do their best to make up for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar, nnls
from scipy.special import ndtri

from bematist.allan.noises import MARKOV, shapes

Array = NDArray[np.float64]

LEVEL = 0.95
_RISE = float(ndtri((1 + LEVEL) / 2)) ** 2
_RISE_ONE_SIDED = float(ndtri(LEVEL)) ** 2
FASTEST = 3.0
"""Correlation time of a hidden Gauss-Markov process, at least, in shortest averaging times: a faster one is white."""
_TIMES = 24
_FURTHEST = 1e4
"""An interval does not reach further than this factor from the estimate."""


class Profile:
    """The weighted misfit with one coefficient held.

    The noises that were not found may come in with any coefficient that is not negative: an interval must not be narrow only because a
    noise that hides behind another was left out. A Gauss-Markov process that was found takes part with a correlation time near its own;
    one that was not (`correlation_s` NaN) with any within the averaging times.
    """

    def __init__(self, v: Array, taus: Array, whiten: Array, noises: Sequence[str], correlation_s: float) -> None:
        self.v, self.taus, self.whiten, self.noises = whiten @ v, taus, whiten, list(noises)
        self.correlation_s = correlation_s
        self.hidden = MARKOV in self.noises and bool(np.isnan(correlation_s))
        self.times = np.geomspace(FASTEST * taus[0], taus[-1], _TIMES)
        self.least = self._over_correlation(lambda t: self._misfit(None, 0.0, t)) if self.hidden else np.nan

    def _misfit(self, held: str | None, square: float, correlation_s: float) -> float:
        """Least misfit with the coefficient of `held` as given."""
        design = self.whiten @ shapes(self.noises, self.taus, correlation_s)
        if held is None:
            return nnls(design, self.v)[1] ** 2
        k = self.noises.index(held)
        rest = np.delete(design, k, axis=1)
        return nnls(rest, self.v - design[:, k] * square)[1] ** 2

    def _over_correlation(self, misfit: Callable[[float], float]) -> float:
        """The least misfit over correlation times within a factor of 10 of the estimate, or over all of them."""
        if MARKOV not in self.noises:
            return misfit(self.correlation_s)
        if self.hidden:
            return min(map(misfit, self.times))
        around = np.log(self.correlation_s) + np.array([-2.3, 2.3])
        found: Any = minimize_scalar(lambda x: misfit(float(np.exp(x))), bounds=around, method="bounded", options={"xatol": 0.02})
        return min(float(found.fun), misfit(self.correlation_s))

    def interval(self, noise: str, square: float) -> tuple[float, float]:
        """Lower and upper end of the squared coefficient of a noise that was found.

        The weights hold the noise for as large as it was found; were it larger, its variances would scatter more. So the upper end lies as
        far off on a logarithmic scale as it does on a linear one with these weights.
        """

        def rise(x: float) -> float:
            return self._over_correlation(lambda t: self._misfit(noise, x, t)) - limit

        limit = 0.0
        own = rise(square)
        # With a hidden process the misfit may fall; what was found stays within its interval even so.
        limit = own + _RISE if not self.hidden else max(self.least + _RISE, own + 0.001)
        low = 0.0 if rise(0.0) <= 0 else _crossing(rise, square, 1 / _FURTHEST)
        return low, square * float(np.exp(min(_crossing(rise, square, _FURTHEST) / square - 1, 50.0)))

    def correlation_interval(self) -> tuple[float, float]:
        """Lower and upper end of the correlation time, s."""

        def rise(t: float) -> float:
            return self._misfit(None, 0.0, t) - limit

        limit = 0.0
        limit = rise(self.correlation_s) + _RISE
        return _crossing(rise, self.correlation_s, 1 / _FURTHEST), _crossing(rise, self.correlation_s, _FURTHEST)

    def bound(self, noise: str) -> float:
        """The largest squared coefficient, one-sided, of a noise that was not found."""
        k = self.noises.index(noise)
        times = self.times if self.hidden else [self.correlation_s]
        none = self._over_correlation(lambda t: self._misfit(noise, 0.0, t))
        limit = none + _RISE_ONE_SIDED if not self.hidden else max(self.least + _RISE_ONE_SIDED, none + 0.001)
        if noise != MARKOV:
            sd = min(self._scale(k, t) for t in times)
            return _crossing(lambda x: self._over_correlation(lambda t: self._misfit(noise, x, t)) - limit, 1e-3 * sd, _FURTHEST)
        found = [
            _crossing(lambda x, t=t: self._misfit(noise, x, t) - limit, 1e-3 * self._scale(k, t), _FURTHEST)
            for t in times
            if self._misfit(noise, 1e-3 * self._scale(k, t), t) < limit
        ]
        return max(found, default=0.0)

    def _scale(self, k: int, correlation_s: float) -> float:
        """The squared coefficient of a noise alone that would stand out by one standard deviation."""
        return 1 / float(np.sqrt(np.sum((self.whiten @ shapes(self.noises, self.taus, correlation_s))[:, k] ** 2)))


def _crossing(rise: Callable[[float], float], start: float, factor: float) -> float:
    """Where a rise that is not positive at the start becomes so, on the way to `factor` times the start; that end if it never does."""
    step = 2.0 if factor > 1 else 0.5
    inside = start
    while (1 / _FURTHEST) < inside / start < _FURTHEST or inside == start:
        outside = inside * step
        if rise(outside) > 0:
            found: Any = brentq(lambda x: rise(float(np.exp(x))), float(np.log(inside)), float(np.log(outside)), xtol=1e-3)
            return float(np.exp(found))
        inside = outside
    return start * factor
