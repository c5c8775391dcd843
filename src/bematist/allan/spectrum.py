"""Spectral density of a sensor at rest, beside its Allan deviation (MAGYQ figures 6-7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bematist.allan.noises import MARKOV

Array = NDArray[np.float64]

PER_DECADE = 24
_SEGMENTS = 8
_LONGEST = 1 << 17


def spectral_density(values: Array, rate_hz: float) -> tuple[Array, Array]:
    """One-sided density of evenly spaced samples (n,) by Welch's method: frequency (F,), Hz, and density (F,), unit²/Hz.

    Half overlapping Hann windows of an eighth of the samples, at most 131072; then means over 24 bands a decade. White noise of Allan
    coefficient N stands at 2 N².
    """
    length = max(min(_LONGEST, 1 << int(np.log2(max(len(values) // _SEGMENTS, 8)))), 8)
    window = np.hanning(length + 1)[:-1]
    power, count = np.zeros(length // 2 + 1), 0
    for start in range(0, len(values) - length + 1, length // 2):
        part = values[start : start + length]
        spectrum = np.fft.rfft(window * (part - part.mean()))
        power += spectrum.real**2 + spectrum.imag**2
        count += 1
    # The window leaks the mean into the first frequencies, and the last counts half.
    frequency = np.arange(2, length // 2) * (rate_hz / length)
    density = 2 * power[2:-1] / (count * rate_hz * np.sum(window**2))
    band = np.floor(PER_DECADE * np.log10(frequency)).astype(int)
    _, first = np.unique(band, return_index=True)
    count = np.diff(np.append(first, len(band)))
    return np.add.reduceat(frequency, first) / count, np.add.reduceat(density, first) / count


def fitted_density(squares: dict[str, float], correlation_s: float, frequency: Array, period_s: float) -> Array:
    """One-sided density (F,) of a sum of noises with these squared coefficients, sampled every period_s.

    The ramp has none. Quantisation is of the integral, so that its density in the samples is (8/T) sin²(πfT) Q².
    """
    w = 2 * np.pi * frequency
    shapes = {
        "quantisation": 8 / period_s * np.sin(np.pi * frequency * period_s) ** 2,
        "white": np.full_like(w, 2.0),
        "flicker": 1 / (np.pi * frequency),
        MARKOV: 4 * correlation_s / (1 + (w * correlation_s) ** 2),
        "walk": 2 / w**2,
    }
    return np.sum([squares[n] * shape for n, shape in shapes.items() if n in squares], axis=0)
