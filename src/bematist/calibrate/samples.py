"""The samples of the magnetometer that a calibration uses: means over rests, single ones in motion, and pairs that a turn lies between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.rests import Rests
from bematist.calibrate.turning import attitudes
from bematist.frames import conjugate, matrix_from_quaternion, multiply
from bematist.recording import Recording

Array = NDArray[np.float64]

MOST = 3000
"""Single samples in motion, at most; more are thinned out evenly."""
TURN = 0.5
"""rad: samples of a pair lie this far apart in turning, more than the noise of the field's direction."""
PAIR_S = 3.0
"""A pair does not reach over a longer time, s, in which the gyroscope may drift and the sensor may be carried elsewhere."""

APART_S = 1e6
"""s between recordings on the common time axis of samples: nothing in one is near anything in another."""

DELAY_STEP_S, DELAYS = 0.01, 8
"""Delays between magnetometer and gyroscope that are tried, s, and how many to either side."""
CLEARLY = 0.9
"""A delay is believed where the misfit with it is this much of that without."""


@dataclass(frozen=True, eq=False)
class FieldSamples:
    """Readings (n,3), µT, with the variance of each (n,), the number of samples it is the mean of (n,), its rest (n,), -1 in motion, and
    its time, s (n,); recordings lie `APART_S` apart.
    """

    values: Array
    variance: Array
    count: Array
    rest: NDArray[np.int64]
    time: Array


@dataclass(frozen=True, eq=False)
class Pairs:
    """Readings (n,3) before and after a turn (n,3,3): the attitude at the second relative to the first; variance (n,), µT², and times
    of both, s (n,2).
    """

    first: Array
    second: Array
    turn: Array
    variance: Array
    time: Array


def field_samples(rests: Rests, recordings: Sequence[Recording]) -> FieldSamples:
    """Means over the rests, and the samples outside of them."""
    noise = sample_variance(recordings)
    known = np.isfinite(rests.field).all(1)
    of_means = np.maximum(rests.field_variance[known], 1e-6 * noise)
    values, variance = [rests.field[known]], [of_means]
    count = [np.maximum(noise / of_means, 1.0)]
    moving, times = [], []
    for k, r in enumerate(recordings):
        spans = [(a, b) for a, b, own in zip(rests.start_s, rests.end_s, rests.recording, strict=True) if own == k]
        free = outside(r.magnetic_time, spans) & np.isfinite(r.magnetic_flux_density).all(1)
        moving.append(r.magnetic_flux_density[free])
        times.append(r.magnetic_time[free] + k * APART_S)
    single = np.concatenate(moving)
    step = max(1, -(-len(single) // MOST))
    single = single[::step]
    middle = (rests.start_s + rests.end_s) / 2 + rests.recording * APART_S
    time = np.concatenate([middle[known], np.concatenate(times)[::step]])
    values.append(single)
    variance.append(np.full(len(single), noise))
    count.append(np.ones(len(single)))
    which = np.concatenate([np.flatnonzero(known), np.full(len(single), -1)])
    return FieldSamples(np.concatenate(values), np.concatenate(variance), np.concatenate(count), which, time)


def outside(time: Array, spans: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Which of the times (n,) lie in none of the spans."""
    free = np.ones(len(time), bool)
    for a, b in spans:
        free[slice(*np.searchsorted(time, [a, b]))] = False
    return free


def sample_variance(recordings: Sequence[Recording]) -> float:
    """White noise of a magnetometer sample, µT²: a low quantile of the third differences, which a smooth turn hardly touches."""
    found = []
    for r in recordings:
        m = r.magnetic_flux_density[np.isfinite(r.magnetic_flux_density).all(1)]
        if len(m) > 10:
            found.append((np.diff(m, 3, axis=0) ** 2).mean(1) / 20)
    if not found:
        return float("nan")
    # The 0.3 quantile of a mean of three squares of normal numbers is 0.47 of its mean.
    return max(float(np.quantile(np.concatenate(found), 0.3)) / 0.47, 1e-12)


def field_pairs(recordings: Sequence[Recording], offset: Array, S: Array, delay: float = 0.0) -> Pairs:
    """Pairs of samples half a radian of turning apart, each sample used once, with the turn by the gyroscope calibrated so far.

    delay : by how much, s, the magnetometer's stamps are later than the gyroscope's.
    """
    noise = sample_variance(recordings)
    first, second, turn, time = [], [], [], []
    for k, r in enumerate(recordings):
        q, way = attitudes(r, offset, S, r.magnetic_time - delay)
        good = np.isfinite(q).all(1) & np.isfinite(r.magnetic_flux_density).all(1)
        i, j = _partners(way[good])
        rows = np.flatnonzero(good)
        i, j = rows[i], rows[j]
        near = r.magnetic_time[j] - r.magnetic_time[i] < PAIR_S
        i, j = i[near], j[near]
        first.append(r.magnetic_flux_density[i])
        second.append(r.magnetic_flux_density[j])
        time.append(np.column_stack([r.magnetic_time[i], r.magnetic_time[j]]) + k * APART_S)
        turn.append(matrix_from_quaternion(multiply(conjugate(q[i]), q[j])))
    a, b, R, t = (np.concatenate(x) for x in (first, second, turn, time))
    step = max(1, -(-len(a) // (MOST // 3)))
    return Pairs(a[::step], b[::step], R[::step], np.full(len(a[::step]), 2 * noise), t[::step])


def _partners(way: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices of the samples (n,) of one stretch of turning, and of those a stretch later."""
    stretch = np.floor_divide(way, TURN).astype(np.int64)
    first, second = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    edges = np.searchsorted(stretch, np.unique(stretch))
    bounds = [*edges.tolist(), len(way)]
    for k in range(0, len(edges) - 1, 2):
        a, b, c = bounds[k], bounds[k + 1], bounds[k + 2]
        if stretch[b] - stretch[a] != 1:
            continue
        n = min(b - a, c - b)
        first.append(np.linspace(a, b - 1, n).round().astype(np.int64))
        second.append(np.linspace(b, c - 1, n).round().astype(np.int64))
    return np.concatenate(first), np.concatenate(second)


def stamp_delay(recordings: Sequence[Recording], offset: Array, S: Array, A: Array, h: Array) -> float:
    """By how much, s, the magnetometer's stamps are later than the gyroscope's; 0 where no delay makes the pairs fit clearly better.

    The median misfit of the pairs, with the field calibrated by A and h, at delays a hundredth of a second apart, and the top of the
    parabola through the least and its neighbours.
    """
    tried = np.arange(-DELAYS, DELAYS + 1) * DELAY_STEP_S
    misfit = []
    for delay in tried:
        p = field_pairs(recordings, offset, S, float(delay))
        x, y = (p.first - h) @ A.T, (p.second - h) @ A.T
        misfit.append(float(np.median(np.linalg.norm(y - np.einsum("nji,nj->ni", p.turn, x), axis=1))) if len(x) else np.inf)
    k = int(np.argmin(misfit))
    if not 0 < k < len(tried) - 1 or not misfit[k] < CLEARLY * misfit[DELAYS]:
        return 0.0
    a, b, c = misfit[k - 1 : k + 2]
    return float(tried[k] + 0.5 * DELAY_STEP_S * (a - c) / (a - 2 * b + c))
