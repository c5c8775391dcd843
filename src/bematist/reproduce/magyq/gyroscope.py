"""Figures 5 to 7 and section 3.3.2: is the error of a gyroscope quaternion a random walk and white noise?"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bematist.allan.deviation import averaging_spans, overlapping_variance, stretches
from bematist.allan.spectrum import spectral_density
from bematist.frames import quaternion_from_rotation_vector
from bematist.reproduce.study import Found, Settings
from bematist.simulate import simulate

Array = NDArray[np.float64]

RATE_HZ = 100.0
AS_PRINTED = "0.00158 °/s/√s"
SAMPLES = 100_000
"""Of the Kolmogorov-Smirnov test, as in the paper."""

WALKS = {
    "none": 0.0,
    "0.00158 °/s/√h": math.radians(0.00158) / 60,
    "0.00158 °/s/√s": math.radians(0.00158),
}
"""Random walk of the rate, rad/s/√s: without, with Table 2 per √h (errata), and with its number per √s, as it is printed."""

WHITE = math.radians(0.00433)
"""Table 2, mean of the axes, in degrees (errata), rad/s/√Hz."""


def cases(seeds: int) -> list[Settings]:
    """A rest of three hours; at most three, as its curves differ little."""
    return [{"seed": seed, "hours": 3.0} for seed in range(min(seeds, 3))]


def compute(settings: Settings) -> Found:
    """Allan deviations of the sensor as it is, and densities where there is a random walk, of the rate and of the quaternion."""
    # Quanta would hide what is asked.
    changes = {"rest_s": 3600 * settings["hours"], "final_rest_s": 0.0, "gyro_lsb": 0.0, "gyro_bias_sd": 0.0}
    still = simulate("still", "adis16488", settings["seed"], magnetometer_rate_hz=0.0, **changes)
    pieces = stretches(still.time)
    spans = averaging_spans(int(pieces.lengths.max()))
    arrays = {"tau": spans * pieces.period_s}
    for name, values in _signals(still.angular_rate).items():
        arrays[f"{name} deviation"] = np.sqrt(overlapping_variance(values, pieces, spans))
    rate = simulated(WALKS[AS_PRINTED], len(still), np.random.default_rng([settings["seed"], 2]))
    for name, values in _signals(rate).items():
        arrays["frequency"], arrays[f"{name} density"] = spectral_density(values, RATE_HZ)
    ratio = 2 * RATE_HZ * arrays["fourth deviation"] / arrays["rate deviation"]
    return Found([{"ratio_smallest": float(ratio.min()), "ratio_largest": float(ratio.max())}], arrays)


def _signals(rate: Array) -> dict[str, Array]:
    q = quaternion_from_rotation_vector(rate / RATE_HZ)
    return {"rate": rate[:, 2].copy(), "first": q[:, 0].copy(), "fourth": q[:, 3].copy()}


def test_cases(seeds: int) -> list[Settings]:
    """The test for every seed and random walk."""
    return [{"seed": seed, "walk": walk, "samples": SAMPLES} for walk in WALKS for seed in range(seeds)]


def compute_test(settings: Settings) -> Found:
    """Distances between the quaternions of a simulated gyroscope and those of the model, component by component."""
    rng, walk, n = np.random.default_rng([settings["seed"], 1]), WALKS[settings["walk"]], settings["samples"]
    q = quaternion_from_rotation_vector(simulated(walk, n, rng) / RATE_HZ)
    found = distances(q, modelled(walk, n, rng))
    return Found([{"component": k + 1, "distance": float(distance)} for k, distance in enumerate(found)])


def simulated(walk: float, n: int, rng: np.random.Generator) -> Array:
    """Rates (n,3), rad/s, of a gyroscope at rest: white noise and a random walk (eqs 14, 15)."""
    steps = walk / math.sqrt(RATE_HZ) * rng.standard_normal((n, 3))
    return WHITE * math.sqrt(RATE_HZ) * rng.standard_normal((n, 3)) + steps.cumsum(0)


def modelled(walk: float, n: int, rng: np.random.Generator) -> Array:
    """Gyroscope quaternions (n,4) by the model: I + a random walk + white noise (eqs 20, 21), in the first component white noise too.

    The scale of the first does not matter, as distributions are centred and normalised.
    """
    vector = simulated(walk, n, rng) / (2 * RATE_HZ)
    return np.column_stack([1 + 1e-9 * rng.standard_normal(n), vector])


def distances(a: Array, b: Array) -> Array:
    """Kolmogorov and Smirnov's distance (K,) between two samples (n,K) of equal size, column by column, centred and normalised (eq 25:
    what is compared with the critical value is the distance itself, erratum).
    """
    return np.array([_distance(_normal(x), _normal(y)) for x, y in zip(a.T, b.T, strict=True)])


def _normal(x: Array) -> Array:
    return np.sort((x - x.mean()) / x.std())


def _distance(x: Array, y: Array) -> float:
    both = np.concatenate([x, y])
    return float(np.abs(np.searchsorted(x, both, "right") - np.searchsorted(y, both, "right")).max() / len(x))


def critical(n: int) -> float:
    """What the distance of two Gaussian samples of n, both centred and normalised, exceeds in 5 % (erratum of eq 25).

    The print's 1.36/√n is for one sample against a known distribution; of two samples as they come it is 1.36 √(2/n). Centring and
    normalising bring the two nearer to one another: 0.90 √(2/n), by simulation.
    """
    return 0.90 * math.sqrt(2 / n)
