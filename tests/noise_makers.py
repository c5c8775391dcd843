"""Noises whose Allan variance is known, as an integrating sensor samples them."""

import numpy as np
from scipy.signal import lfilter

OVERSAMPLED = 8


def flicker(n: int, rng: np.random.Generator) -> np.ndarray:
    """Flicker noise of B = 1 (Kasdin 1995), averaged over samples; scale-free, so that the rate does not matter."""
    long = n * OVERSAMPLED
    size = 1 << (2 * long - 1).bit_length()
    k = np.arange(1, long)
    response = np.concatenate([[1.0], np.cumprod((k - 0.5) / k)])
    noise = np.fft.irfft(np.fft.rfft(response, size) * np.fft.rfft(rng.standard_normal(long), size), size)[:long]
    return noise.reshape(n, OVERSAMPLED).mean(1)


def made(
    n: int,
    rate_hz: float,
    rng: np.random.Generator,
    *,
    white: float = 0.0,
    flicker: float = 0.0,
    walk: float = 0.0,
    markov: float = 0.0,
    correlation_s: float = 1.0,
    quantisation: float = 0.0,
) -> np.ndarray:
    """n samples of a sum of noises with these coefficients."""
    values = white * np.sqrt(rate_hz) * rng.standard_normal(n)
    if flicker:
        values += flicker * _flicker(n, rng)
    if walk:
        values += walk / np.sqrt(rate_hz) * np.cumsum(rng.standard_normal(n))
    if markov:
        keep = np.exp(-1 / (rate_hz * correlation_s))
        drive = markov * np.sqrt(1 - keep**2) * rng.standard_normal(n)
        drive[0] = markov * rng.standard_normal()
        values += lfilter([1.0], [1.0, -keep], drive)
    if quantisation:
        values += quantisation * rate_hz * np.diff(rng.standard_normal(n + 1))
    return values


_flicker = flicker
