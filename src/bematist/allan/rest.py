"""Where a sensor lay still. An Allan deviation of motion says nothing of the sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.intervals import intervals
from bematist.recording import Recording

Array = NDArray[np.float64]

CELL_S = 0.1
"""Means over this time tell motion from the sensor's white noise, whatever its rate."""
BLOCK_CELLS = 20
FORCE_SD, RATE_SD = 0.05, 0.01
"""m/s², rad/s: a hand, a foot or a car scatters the means of a block more than this; a sensor on a table does not."""
RELATIVE_SD = 3.0
"""A block that scatters this many times more than the middle one was disturbed."""
TURN = 0.02
"""rad/s: a block that turns this much faster than the middle one is no rest."""
TILT = 0.1
"""m/s²: a block whose mean specific force differs this much from the one before stands otherwise."""
SHORTEST_S = 10.0


@dataclass(frozen=True)
class Rest:
    """The stretch that is used, s, the ones that are still, and what is to be said about it."""

    start_s: float
    end_s: float
    still: tuple[tuple[float, float], ...]
    warnings: tuple[str, ...] = ()


def find_rest(recording: Recording, start_s: float | None = None, end_s: float | None = None) -> Rest:
    """The longest stretch in which the sensor lay still, between `start_s` and `end_s` where they are given.

    Raises
    ------
    DataError
        There are no samples, or there is no rest of `SHORTEST_S`.
    """
    name = recording.source or "The recording"
    first = recording.time[0] if len(recording) else 0.0
    last = recording.time[-1] if len(recording) else 0.0
    start = first if start_s is None else max(start_s, first)
    end = last if end_s is None else min(end_s, last)
    if end - start < SHORTEST_S:
        raise DataError(
            f"{name}: {max(end - start, 0):.3g} s are too short for an Allan deviation. Record the sensor lying still: a minute for "
            "the white noise, hours for bias instability and random walks."
        )
    still = still_stretches(recording, start, end)
    longest = max(still, key=lambda s: s[1] - s[0], default=(start, start))
    if longest[1] - longest[0] < SHORTEST_S:
        raise DataError(
            f"{name}: the sensor does not lie still for {SHORTEST_S:g} s anywhere (the longest rest is {longest[1] - longest[0]:.3g} s). "
            "An Allan deviation needs a recording of the sensor lying on something solid. If it did lie still, the units are "
            "wrong: give them, such as --units angular_rate=deg/s."
        )
    moved = (end - start) - (longest[1] - longest[0])
    warnings = []
    if moved > 2 * BLOCK_CELLS * CELL_S:
        warnings.append(
            f"The sensor does not lie still all the time: of {end - start:.0f} s only the longest rest is used, {longest[0]:.1f} to "
            f"{longest[1]:.1f} s ({longest[1] - longest[0]:.0f} s)." + _others(still, longest)
        )
    else:
        longest = (start, end)
    return Rest(longest[0], longest[1], tuple(still), tuple(warnings))


def _others(still: list[tuple[float, float]], longest: tuple[float, float]) -> str:
    others = sorted((s for s in still if s != longest and s[1] - s[0] >= SHORTEST_S), key=lambda s: s[0] - s[1])[:4]
    return f" Other rests: {', '.join(f'{a:.1f} to {b:.1f} s' for a, b in others)}." if others else ""


def still_stretches(recording: Recording, start: float, end: float) -> list[tuple[float, float]]:
    """Start and end, s, of the stretches without motion; next to a motion a block is left out as well."""
    r, size = recording, CELL_S * BLOCK_CELLS
    blocks = max(int((end - start) / size), 1)
    moving = np.zeros(blocks, bool)
    for values, limit in ((r.specific_force, FORCE_SD), (r.angular_rate, RATE_SD)):
        cells = cell_means(r.time, values, start, blocks * BLOCK_CELLS).reshape(blocks, BLOCK_CELLS, 3)
        there = np.asarray(np.isfinite(cells).all(2))
        count = np.maximum(there.sum(1), 1)[:, None]
        filled = np.where(there[:, :, None], cells, 0.0)
        mean = filled.sum(1) / count
        sd = np.sqrt((np.where(there[:, :, None], cells - mean[:, None], 0.0) ** 2).sum(1) / count)
        seen = there.sum(1) > BLOCK_CELLS // 2
        quiet = np.asarray(seen & (sd < limit).all(axis=1))
        if not quiet.any():
            return []
        moving |= seen & ~(quiet & (sd < RELATIVE_SD * np.median(sd[quiet], axis=0) + 1e-12).all(1))
        if limit == RATE_SD:
            moving |= seen & (np.abs(mean - np.median(mean[quiet], axis=0)) > TURN).any(1)
        else:
            at = np.flatnonzero(seen)
            moving[at[1:]] |= (np.abs(np.diff(mean[at], axis=0)) > TILT).any(1)
    beside = moving.copy()
    beside[1:] |= moving[:-1]
    beside[:-1] |= moving[1:]
    edges = intervals(~beside)
    return [(start + a * size, end if b == blocks else start + b * size) for a, b in edges]


def cell_means(time: Array, values: Array, start: float, cells: int) -> Array:
    """Means (cells,3) over `CELL_S`; NaN where there is no sample."""
    first, last = np.searchsorted(time, [start, start + cells * CELL_S])
    at = np.minimum(((time[first:last] - start) / CELL_S).astype(np.int64), cells - 1)
    out = np.empty((cells, 3))
    good = np.asarray(np.isfinite(values[first:last]).all(axis=1))
    everywhere = bool(good.all())
    number = np.bincount(at if everywhere else at[good], minlength=cells)
    for axis in range(3):
        x = values[first:last, axis]
        sums = np.bincount(at if everywhere else at[good], x if everywhere else x[good], cells)
        out[:, axis] = np.where(number > 0, sums / np.maximum(number, 1), np.nan)
    return out
