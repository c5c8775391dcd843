"""Where a sensor that is turned by hand lies still for a moment, and what it reads there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.allan.rest import CELL_S, FORCE_SD, RATE_SD, cell_means
from bematist.intervals import intervals
from bematist.recording import Recording

Array = NDArray[np.float64]

WINDOW_CELLS = 5
"""The scatter of the means of this many cells is what tells rest from motion."""
SHORTEST_S = 0.8
EDGE_S = 0.1
LARGEST_RATIO = 12.0
"""A rest in the hand may scatter this many times more than one on a table (`FORCE_SD`, `RATE_SD`); what scatters more is motion."""
TURNING = 0.03
"""rad/s: a stretch whose mean rate differs this much from the other rests' turns slowly."""
SWAY = 0.1
"""m/s²: halves of a rest whose specific forces differ more are not one position."""


@dataclass(frozen=True, eq=False)
class Rests:
    """K rests: start_s, end_s (K,); what each sensor reads, (K,3), NaN without a sample, and the variance (K,) of a mean by white noise;
    recording (K,), the index of the recording each is from; left_out: how many stretches turned slowly or swayed.
    """

    start_s: Array
    end_s: Array
    force: Array
    force_variance: Array
    rate: Array
    rate_variance: Array
    field: Array
    field_variance: Array
    recording: NDArray[np.int64]
    left_out: int = 0

    def __len__(self) -> int:
        return len(self.start_s)

    @property
    def seconds(self) -> Array:
        return self.end_s - self.start_s

    def chosen(self, keep: NDArray[np.bool_]) -> Rests:
        """The rests that are to be kept (K,)."""
        arrays = {k: v[keep] for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        return _made(arrays, self.left_out + int((~keep).sum()))


def _made(arrays: dict[str, Any], left_out: int = 0) -> Rests:
    return Rests(**arrays, left_out=left_out)


def find_rests(recordings: list[Recording]) -> Rests:
    """The rests of all recordings.

    A cell of 0.1 s is at rest where the means around it scatter less than a limit, between what a table and what a hand allows, that parts
    the recording's quiet cells from the moving ones best (Otsu's threshold of the logarithm). So no threshold must be chosen for a sensor.
    """
    parts = [_of_one(r, k) for k, r in enumerate(recordings)]
    arrays = [name for name, value in vars(parts[0]).items() if isinstance(value, np.ndarray)]
    joined = _made({name: np.concatenate([getattr(p, name) for p in parts]) for name in arrays}, sum(p.left_out for p in parts))
    if not len(joined):
        return joined
    usual = np.median(joined.rate, axis=0)
    return joined.chosen(np.asarray((np.abs(joined.rate - usual) < TURNING).all(axis=1)) & ~_swaying(joined, recordings))


def _swaying(rests: Rests, recordings: list[Recording]) -> NDArray[np.bool_]:
    middle = (rests.start_s + rests.end_s) / 2
    sways = np.zeros(len(rests), bool)
    for k, r in enumerate(rests.recording):
        halves = [_mean(recordings[r].time, recordings[r].specific_force, a, b)[0]
                  for a, b in ((rests.start_s[k], middle[k]), (middle[k], rests.end_s[k]))]  # fmt: skip
        sways[k] = bool(np.linalg.norm(halves[1] - halves[0]) > SWAY)
    return sways


def _of_one(r: Recording, index: int) -> Rests:
    spans = still_spans(r)
    rows = []
    for a, b in spans:
        force = _mean(r.time, r.specific_force, a, b)
        rate = _mean(r.time, r.angular_rate, a, b)
        field = _mean(r.magnetic_time, r.magnetic_flux_density, a, b)
        rows.append((force, rate, field))
    empty = np.empty((0, 3))
    means = [np.array([row[i][0] for row in rows]) if rows else empty for i in range(3)]
    variances = [np.array([row[i][1] for row in rows]) for i in range(3)]
    edges = np.array(spans, float).reshape(-1, 2)
    known = np.isfinite(means[0]).all(1) & np.isfinite(means[1]).all(1)
    return Rests(
        edges[:, 0],
        edges[:, 1],
        means[0],
        variances[0],
        means[1],
        variances[1],
        means[2],
        variances[2],
        np.full(len(spans), index),
    ).chosen(np.asarray(known))


def _mean(time: Array, values: Array, start: float, end: float) -> tuple[Array, float]:
    """Mean (3,) over a span and its variance by white noise (mean over the axes, from differences of neighbours)."""
    part = values[slice(*np.searchsorted(time, [start, end]))]
    part = part[np.isfinite(part).all(1)]
    if len(part) < 2:
        return np.full(3, np.nan), np.nan
    return part.mean(0), float(((np.diff(part, axis=0) ** 2).mean() / 2) / len(part))


def still_spans(r: Recording) -> list[tuple[float, float]]:
    """Start and end, s, of the stretches of at least `SHORTEST_S` in which the sensor is still."""
    if len(r) < 2:
        return []
    start = float(r.time[0])
    count = int(r.duration_s / CELL_S)
    if count < WINDOW_CELLS:
        return []
    ratio = np.maximum(
        *(_scatter(cell_means(r.time, x, start, count)) / s for x, s in ((r.specific_force, FORCE_SD), (r.angular_rate, RATE_SD)))
    )
    still = np.nan_to_num(ratio, nan=np.inf) < limit_of(ratio[np.isfinite(ratio)])
    edges = intervals(still)
    # A turn begins more slowly than any scatter shows: what lies near the edges counts as a part of it.
    spans = [(start + a * CELL_S + EDGE_S, start + b * CELL_S - EDGE_S) for a, b in edges]
    return [(a, b) for a, b in spans if b - a >= SHORTEST_S]


def _scatter(cells: Array) -> Array:
    """Root mean square over the axes of the standard deviation (C,) of the cell means (C,3) in a window around each; NaN at the ends."""
    out = np.full(len(cells), np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(cells, WINDOW_CELLS, axis=0)
    half = WINDOW_CELLS // 2
    out[half : len(cells) - half] = np.sqrt(windows.var(-1).mean(1))
    for k in range(half):  # a recording may begin and end in a rest
        out[k], out[-1 - k] = out[half], out[-1 - half]
    return out


def limit_of(ratio: Array) -> float:
    """The ratio below which a cell is at rest: the one that parts their logarithms (C,) into two groups with the least variance within.

    N. Otsu, "A threshold selection method from gray-level histograms", IEEE Trans. SMC 9, 1979. Not below 1 and not above `LARGEST_RATIO`.
    """
    x = np.sort(np.log(np.maximum(ratio, 1e-3)))
    if len(x) < 2:
        return 1.0
    n = np.arange(1, len(x))
    low = np.cumsum(x)[:-1] / n
    high = (x.sum() - np.cumsum(x)[:-1]) / (len(x) - n)
    between = n * (len(x) - n) * (high - low) ** 2
    best = int(np.argmax(between))
    return float(np.clip(np.exp((low[best] + high[best]) / 2), 1.0, LARGEST_RATIO))
