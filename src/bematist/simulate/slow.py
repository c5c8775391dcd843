"""Slow errors of a sensor: flicker noise (bias instability) and first-order Gauss-Markov processes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import lfilter

Array = NDArray[np.float64]

TIMES_S = (3.0, 30.0, 300.0, 3000.0)
"""Correlation times of the processes of `flicker`."""
_NEAR = 50


def flicker(instability: float, seconds: int, rng: np.random.Generator) -> Array:
    """Flicker noise (seconds,3), once a second, whose Allan deviation is nearly flat at 0.664 `instability` from 3 s to an hour.

    A sum of first-order Gauss–Markov processes a decade apart in correlation time, each with the variance B² ln(10)/π,
    which together have the (one-sided) spectrum B²/(πf).
    """
    keep = np.exp(-1 / np.array(TIMES_S))[:, None]
    sd = instability * np.sqrt(np.log(10) / np.pi)
    drive = rng.standard_normal((seconds, len(TIMES_S), 3)) * sd * np.sqrt(1 - keep**2)
    state, values = rng.standard_normal((len(TIMES_S), 3)) * sd, np.empty((seconds, 3))
    for k, step in enumerate(drive):
        values[k] = state.sum(0)
        state = keep * state + step
    return values


def exact_flicker(n: int, rng: np.random.Generator) -> Array:
    """Flicker noise (n,3) of B = 1, each sample the mean over its interval: its Allan deviation is 0.664 at every averaging time.

    The differences of successive samples are stationary, with the autocovariance δ⁴(k² ln|k|)/2π at lag k, the fourth difference of the
    generalised autocovariance of the integral (`allan.noises.phase_covariance`). They are drawn exactly, by circulant embedding, and summed
    from 0: all correlations of the circle but that at lag 0 are negative and their sum is not, so that no eigenvalue is.
    """
    values = np.zeros((n, 3))
    if n < 3:
        return values
    half = int(next_fast_len(n, real=True) or n)
    correlation = _step_covariance(np.arange(half + 1))
    # The eigenvalues of a circle of 2 · half lags. Its Fourier transform's ends are real, all between complex with half the variance each.
    eigenvalues = np.real(np.asarray(rfft(np.concatenate([correlation, correlation[-2:0:-1]]))))
    spread = np.sqrt(np.maximum(eigenvalues, 0.0) * half)
    spread[[0, -1]] *= np.sqrt(2.0)
    for axis in range(3):
        drawn = rng.standard_normal(2 * (half + 1)).view(complex) * spread
        drawn[[0, -1]] = np.real(drawn[[0, -1]])
        steps = np.asarray(irfft(drawn, 2 * half, overwrite_x=True))
        np.cumsum(steps[: n - 1], out=values[1:, axis])
    return values


def _step_covariance(lag: NDArray[np.int64]) -> Array:
    """δ⁴(k² ln|k|)/2π; of long lags the series -2/k² - 2/k⁴ - 3/k⁶, where the difference would lose its digits."""
    k = np.maximum(lag, 1).astype(float)
    out = -2 / k**2 - 2 / k**4 - 3 / k**6
    near = lag[lag < _NEAR]
    around = np.abs(near[:, None] + np.arange(-2, 3)).astype(float)
    out[: len(near)] = (around**2 * np.log(np.maximum(around, 1.0))) @ [1.0, -4.0, 6.0, -4.0, 1.0]
    return out / (2 * np.pi)


def gauss_markov(n: int, step_s: float, correlation_s: float, rng: np.random.Generator) -> Array:
    """First-order Gauss–Markov process (n,) of unit variance, stationary from its first sample (MAGYQ eq 13 with the erratum's sign)."""
    keep = np.exp(-step_s / correlation_s)
    drive = np.sqrt(1 - keep**2) * rng.standard_normal(n)
    return np.asarray(lfilter([1.0], [1.0, -keep], drive, zi=[keep * rng.standard_normal()])[0])
