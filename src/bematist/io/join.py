"""Accelerometer and gyroscope with clocks of their own → one time axis.

A phone samples each sensor by itself: about the same rate, other instants. The estimators want a specific force and an angular rate
at each instant. The instants are those of the gyroscope, since attitude is a sum of its samples and suffers most from a changed one;
where the accelerometer is clearly faster they are the accelerometer's, so that no impact is lost. The other sensor is taken at these
instants on the straight line between its two neighbouring samples: nothing lies beyond what was measured, and what is summed is what
the trapezoidal rule sums over its own samples. Where its samples lie too far apart there is none, and the row says so with NaN.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError

Array = NDArray[np.float64]

SAME_S = 1e-6
"""Instants that agree within a µs are one instant."""
FASTER = 1.5
"""From this ratio of the rates on, one sensor is clearly faster."""
FAR = 3.5
"""Periods: neighbours that lie farther apart have a gap between them."""


@dataclass(frozen=True)
class Joined:
    """One time axis (N,), specific force and angular rate (N,3) on it, what was done, and a warning where it is doubtful."""

    time: Array
    force: Array
    rate: Array
    note: str
    warning: str


def join(force_time: Array, force: Array, rate_time: Array, rate: Array) -> Joined:
    """Samples of the accelerometer and the gyroscope on the instants of one of them, where both run.

    Raises
    ------
    DataError
        The two have no time in common.
    """
    step_f, step_w = _step(force_time), _step(rate_time)
    on_force = step_w > FASTER * step_f
    base, other = (force_time, rate_time) if on_force else (rate_time, force_time)
    kept, moved, values = ("accelerometer", "gyroscope", rate) if on_force else ("gyroscope", "accelerometer", force)
    rows = np.flatnonzero((base >= other[0] - SAME_S) & (base <= other[-1] + SAME_S))
    if not len(rows):
        raise DataError(
            f"the accelerometer runs from {force_time[0]:.10g} to {force_time[-1]:.10g} s and the gyroscope from {rate_time[0]:.10g} to "
            f"{rate_time[-1]:.10g} s: they have no time in common. Their stamps may count from different instants, or the files belong to "
            "different recordings."
        )
    time = base[rows]
    step = step_w if on_force else step_f
    found, between = _on_the_line(other, values, time, FAR * step if np.isfinite(step) else np.inf)
    empty = int(np.isnan(found[:, 0]).sum())
    parts = [f"the {moved} was taken at the instants of the {kept}"]
    parts.append(f"{between} of {len(time)} on the line between two of its samples" if between else "which are its own as well")
    if cut := len(base) - len(time):
        parts.append(f"{cut} rows before or after it ran were left out")
    if empty:
        parts.append(f"{empty} rows in its gaps have none")
    slow, fast = sorted([1 / step_f, 1 / step_w])
    warning = ""
    if fast > FASTER * slow:
        warning = (
            f"The {kept} has {fast:.4g} Hz and the {moved} {slow:.3g} Hz: between its samples the {moved} was taken on straight lines, and "
            f"motion faster than about {slow / 2:.2g} Hz is not in it."
        )
    kept_values = (force if on_force else rate)[rows]
    pair = (kept_values, found) if on_force else (found, kept_values)
    return Joined(time, *pair, ", ".join(parts), warning)


def _step(time: Array) -> float:
    return float(np.median(np.diff(time))) if len(time) > 1 else np.nan


def _on_the_line(time: Array, values: Array, at: Array, far: float) -> tuple[Array, int]:
    """Values (N,3) at instants `at` within `time`, NaN between neighbours farther apart than `far`; how many lie between samples."""
    after = np.clip(np.searchsorted(time, at), 1, max(len(time) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(time) - 1)
    span = time[after] - time[before]
    part = np.where(span > 0, (at - time[before]) / np.where(span > 0, span, 1), 0.0)
    out = values[before] + (values[after] - values[before]) * part[:, None]
    at_before, at_after = np.abs(at - time[before]) <= SAME_S, np.abs(at - time[after]) <= SAME_S
    out[at_before], out[at_after] = values[before[at_before]], values[after[at_after]]
    exact = at_before | at_after
    out[~exact & (span > far)] = np.nan
    return out, int((~exact & (span <= far)).sum())
