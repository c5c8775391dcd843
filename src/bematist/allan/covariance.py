"""How sure an overlapping Allan variance is, and how its values at several averaging times hang together.

The estimates are means of squared second differences of the integrated signal, which for Gaussian noise is Gaussian: the covariance of
two of them is a sum over lags of twice the squared covariance of the second differences (Isserlis). Greenhall & Riley 2003
("Uncertainty of stability variances based on finite differences") evaluate it for one power law and one averaging time; here it is
evaluated for the sum of noises that was fitted, and for every pair of averaging times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bematist.allan.noises import MARKOV, phase_covariance

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_EVERY_LAG = 24
"""Stretches between corners of the covariance up to this long are summed lag by lag, longer ones by Gauss-Legendre."""
_SECOND_DIFFERENCE = ((-1, 1.0), (0, -2.0), (1, 1.0))
_SMOOTH = ("white", "flicker", "walk")


class Overlap:
    """The lags that matter to each pair of averaging times, made once for all axes of a sensor.

    Parameters
    ----------
    spans : (M,) averaging times in samples, increasing.
    lengths : samples of each uninterrupted stretch; second differences do not reach over a gap.
    period_s : sampling period, s.
    skipped : how many shorter averaging times were left out (`longer`).
    """

    def __init__(
        self, spans: Sequence[int] | NDArray[np.int64], lengths: Sequence[int] | NDArray[np.int64], period_s: float, *, skipped: int = 0
    ) -> None:
        self.spans = np.asarray(spans, np.int64)
        self.lengths = np.asarray(lengths, np.int64)
        self.taus: Array = self.spans.astype(float) * period_s
        self.period_s = period_s
        self.skipped = skipped
        self._longer: dict[int, Overlap] = {}
        self.terms = np.clip(self.lengths[:, None] + 1 - 2 * self.spans, 0, None).sum(0)
        """Number of second differences behind each value (M,)."""

    def longer(self, skipped: int) -> Overlap:
        """Without the `skipped` shortest averaging times; made once."""
        if skipped not in self._longer:
            self._longer[skipped] = Overlap(self.spans[skipped:], self.lengths, self.period_s, skipped=skipped)
        return self._longer[skipped]

    @cached_property
    def _pairs(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        first, second = np.tril_indices(len(self.spans))
        return first, second  # spans[first] >= spans[second]

    @cached_property
    def _lags(self) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Of all pairs in a row: number of the pair, lag in samples, weight, and jump of the covariance by white integrals."""
        parts = [self._of_pair(int(self.spans[i]), int(self.spans[j])) for i, j in zip(*self._pairs, strict=True)]
        pair = np.repeat(np.arange(len(parts)), [len(p[0]) for p in parts])
        lag, weight, jump = (np.concatenate([p[k] for p in parts]) for k in range(3))
        return pair, lag, weight, jump

    def _of_pair(self, long: int, short: int) -> tuple[Array, Array, Array]:
        """Lags, weights and jumps of two spans; the covariance is even in the lag, so that positive lags count twice."""
        reach = int(self.lengths.max()) + 1 - long - short
        corners = [0, short, long - short, long, long + short, 2 * (long + short), 4 * (long + short), 8 * (long + short)]
        corners = sorted({min(c, max(reach, 0)) for c in corners})
        lags, weights = [], []
        for a, b in pairwise(corners):
            if b - a <= _EVERY_LAG:
                inside, w = np.arange(a, b + 1.0), np.ones(b - a + 1)
                w[[0, -1]] = 0.5
            else:
                inside, w = a + (b - a) * (_NODES + 1) / 2, (b - a) * _WEIGHTS / 2
            lags.append(inside)
            weights.append(w)
        if not lags:
            lags, weights = [np.zeros(1)], [np.full(1, 0.5)]
        lag, weight = np.concatenate(lags), 2 * np.concatenate(weights)
        jumps: dict[int, float] = {}
        for a, p in _SECOND_DIFFERENCE:
            for b, q in _SECOND_DIFFERENCE:
                jumps[b * short - a * long] = jumps.get(b * short - a * long, 0.0) + p * q
        at = np.array([k for k in jumps if k >= 0], float)
        twice = np.where(at > 0, 2.0, 1.0)
        jump = np.array([jumps[int(k)] for k in at])
        lag, weight, jump = np.concatenate([lag, at]), np.concatenate([weight, twice]), np.concatenate([0 * lag, jump])
        return lag, weight * self._count(lag, long, short), jump

    def _count(self, lag: Array, long: int, short: int) -> Array:
        """How many pairs of second differences of the two spans are this far apart."""
        most = (self.lengths + 1 - 2 * long).astype(float)
        left = most[:, None] - np.clip(lag - (long - short), 0, None)
        return np.where(most[:, None] > 0, np.clip(left, 0, None), 0.0).sum(0)

    @cached_property
    def _smooth(self) -> dict[str, Array]:
        return {noise: self._difference(noise) for noise in _SMOOTH}

    def _difference(self, noise: str, correlation_s: float = np.nan) -> Array:
        """Covariance of the second differences at every lag, for the unit coefficient."""
        pair, lag, _, _ = self._lags
        long, short = self.spans[self._pairs[0]][pair], self.spans[self._pairs[1]][pair]
        total = np.zeros(len(lag))
        for a, p in _SECOND_DIFFERENCE:
            for b, q in _SECOND_DIFFERENCE:
                total += p * q * phase_covariance(noise, (lag + a * long - b * short) * self.period_s, correlation_s)
        return total

    def covariance(self, squares: Mapping[str, float], correlation_s: float = np.nan) -> Array:
        """Covariance (M,M) of the overlapping Allan variances of a sum of noises with these squared coefficients."""
        pair, _, weight, jump = self._lags
        smooth = np.zeros(len(weight))
        for noise in _SMOOTH:
            if squares.get(noise):
                smooth += squares[noise] * self._smooth[noise]
        if squares.get(MARKOV):
            smooth += squares[MARKOV] * self._difference(MARKOV, correlation_s)
        white = squares.get("quantisation", 0.0) * jump
        on_jump = jump != 0
        terms = 2 * np.where(on_jump, white * (2 * smooth + white), smooth**2)
        first, second = self._pairs
        if squares.get("ramp"):  # a ramp is no noise, but multiplies it: cov(x², y²) = 2 cov² + 4 E[x] E[y] cov
            mean = self.taus**2 * np.sqrt(squares["ramp"])
            terms += 4 * (mean[first] * mean[second])[pair] * np.where(on_jump, white, smooth)
        sums = np.bincount(pair, weight * terms, len(first))
        scale = 2 * self.taus**2 * self.terms
        sums /= scale[first] * scale[second]
        out = np.empty((len(self.spans), len(self.spans)))
        out[first, second] = out[second, first] = sums
        return out
