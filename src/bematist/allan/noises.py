"""The noises of an inertial sensor as the Allan variance sees them.

Each noise has one coefficient c² ≥ 0; the Allan variance at the averaging time τ is the sum of c² φ(τ) (IEEE Std 952-1997 annex C,
MAGYQ figures 3-5):

| noise | coefficient | φ(τ) | slope of the deviation |
|---|---|---|---|
| quantisation | Q, of the integral | 3/τ² | -1 |
| white | N | 1/τ | -1/2 |
| bias instability (flicker) | B | (2/π) ln 2: a flat 0.664 B | 0 |
| Gauss-Markov, first order | standard deviation s, correlation time T | (2T/τ)(1 - (T/2τ)(3 - 4e^(-τ/T) + e^(-2τ/T))) | +1/2, then -1/2 |
| random walk | K | τ/3 | +1/2 |
| ramp | R | τ²/2 | +1 |
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FLICKER_FLOOR = float(np.sqrt(2 * np.log(2) / np.pi))
"""Allan deviation of flicker noise over its coefficient B: 0.664."""

MARKOV = "markov"
LINEAR: dict[str, Callable[[Array], Array]] = {
    "quantisation": lambda tau: 3 / tau**2,
    "white": lambda tau: 1 / tau,
    "flicker": lambda tau: np.full_like(tau, FLICKER_FLOOR**2),
    "walk": lambda tau: tau / 3,
    "ramp": lambda tau: tau**2 / 2,
}
"""φ(τ) of the noises without a time constant."""

NOISES = ("quantisation", "white", "flicker", MARKOV, "walk", "ramp")
"""All noises, from short averaging times to long ones."""


def markov_variance(tau: Array, correlation_s: float) -> Array:
    """φ(τ) of a first-order Gauss-Markov process of unit variance (MAGYQ eq 13 with the erratum's sign; IEEE Std 952 C.1.6)."""
    x = tau / correlation_s
    small = x < 1e-3  # where the closed form loses its digits: the series 2x/3 - x²/2
    y = np.where(small, 1.0, x)
    closed = 2 / y - (3 - 4 * np.exp(-y) + np.exp(-2 * y)) / y**2
    return np.where(small, 2 * x / 3 - x**2 / 2, closed)


def shapes(noises: Sequence[str], tau: Array, correlation_s: float = np.nan) -> Array:
    """φ of several noises at averaging times (M,): (M,k)."""
    return np.column_stack([markov_variance(tau, correlation_s) if n == MARKOV else LINEAR[n](tau) for n in noises])


def phase_covariance(noise: str, lag: Array, correlation_s: float = np.nan) -> Array:
    """Generalised autocovariance of the integral of a noise with unit coefficient at lags in s.

    Second differences of the integral have the covariance that this gives by differencing; a polynomial of degree 3 is free in it
    (Greenhall & Riley 2003). Quantisation, which is white in the integral, and the ramp, which is no noise, have none here.
    """
    t = np.abs(lag)
    if noise == "white":
        return -t / 2
    if noise == "flicker":
        return t**2 * np.log(np.where(t > 0, t, 1.0)) / (2 * np.pi)
    if noise == "walk":
        return t**3 / 12
    if noise == MARKOV:
        x = t / correlation_s
        return -(correlation_s**2) * (np.expm1(-x) + x)
    return np.zeros_like(t)
