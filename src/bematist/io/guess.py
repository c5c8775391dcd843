"""Units from evidence: what gravity, human motion and the Earth's field allow."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bematist import units
from bematist.arrays import median
from bematist.earth import STANDARD_GRAVITY
from bematist.intervals import intervals

Array = NDArray[np.float64]

TOLERANCE = 0.2
"""How far the norm at rest may lie from gravity for a unit to be believed."""
RATE_LIMIT = 60.0
"""rad/s (3400 °/s): no body-worn sensor turns faster for long, and few measure more."""
SLOW_RATE, MOVING = 0.3, 1.0
"""rad/s (17 °/s) and m/s²: who shakes the accelerometer by more turns the gyroscope by more too, were it only at the hand."""
JUDGED = 20000
"""Samples that are judged by the turning of gravity."""
LEVELS = 40
"""A signal with fewer distinct values is too coarse to tell saturation."""
TURN = 0.02
"""Part of its range by which a slow or coarse signal leaves its extreme at most in one sample; a clipped one leaves it by more."""
FIELD_UT = (5.0, 200.0)
"""µT: what a magnetometer near people reads, iron included (the Earth alone: 22 to 67)."""


def norms(vectors: Array) -> Array:
    """Norms (N,) of (N,3)."""
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))


def rest_norm(force: Array, window: int = 50) -> float:
    """Median norm of (N,3) over the quietest tenth of windows: gravity in the file's unit."""
    norm = norms(force)
    norm = norm[np.isfinite(norm)]
    if not len(norm):
        return float("nan")
    n = len(norm) // window
    if n < 5:
        return median(norm)
    pieces = norm[: n * window].reshape(n, window)
    spread = pieces.std(1)
    tenth = (n - 1) // 10
    quiet = spread <= np.partition(spread, tenth)[tenth]
    return median(pieces[quiet])


def unit_of(name: str, values: Mapping[str, Array], time: Array) -> tuple[str, str]:
    """The likeliest unit of a quantity and why. `values` holds the quantities, the accelerometer first brought to m/s²."""
    if name == "specific_force":
        return _force_unit(rest_norm(values[name]))
    if name == "angular_rate":
        return _rate_unit(values["specific_force"], values[name], time)
    if name == "magnetic_flux_density":
        return _field_unit(median(norms(values[name])))
    middle = median(np.abs(values[name]))
    unit = min(units.PRESSURE, key=lambda u: abs(np.log(max(middle, 1e-12) * units.PRESSURE[u] / 1e5)))
    return unit, f"its middle value is {middle:.4g}"


def _force_unit(norm: float) -> tuple[str, str]:
    if not norm > 0:
        return "m/s^2", "there is no reading to judge by"
    table = units.SPECIFIC_FORCE
    unit = min(table, key=lambda u: abs(np.log(norm * table[u] / STANDARD_GRAVITY)))
    return unit, f"the norm at rest is {norm:.4g}"


def _rate_unit(force: Array, rate: Array, time: Array) -> tuple[str, str]:
    """deg/s or rad/s. First by gravity, which must turn as the gyroscope says; else by the size of the peaks."""
    peak = peak_rate(rate)
    part = _middle(time)
    force, rate, time = force[part], rate[part], time[part]
    errors = {u: gravity_mismatch(force, rate * units.ANGULAR_RATE[u], time) for u in ("rad/s", "deg/s")}
    best, other = sorted(errors, key=lambda u: errors[u])
    if np.isfinite(errors[best]) and errors[best] < 0.4 * errors[other]:
        return best, f"gravity turns with the gyroscope as {best} and not as {other}; peak {peak:.4g}"
    if peak > 20 * RATE_LIMIT * 180 / np.pi:
        return "mdeg/s", f"its peak is {peak:.4g}"
    if peak > RATE_LIMIT:
        return "deg/s", f"its peak is {peak:.4g}, more than anyone turns in rad/s"
    return "rad/s", f"its peak is {peak:.4g}"


def peak_rate(rate: Array) -> float:
    """The norm of (N,3) that one sample in a thousand exceeds."""
    norm = norms(rate)
    norm = norm[np.isfinite(norm)]
    k = max(0, len(norm) - 1 - len(norm) // 1000)
    return float(np.partition(norm, k)[k]) if len(norm) else 0.0


def _middle(time: Array) -> slice:
    """The samples that are judged by the turning of gravity."""
    first = max(0, (len(time) - JUDGED) // 2)
    return slice(first, first + JUDGED)


def gravity_mismatch(force: Array, rate_rad_s: Array, time: Array) -> float:
    """Median angle (rad) between the gravity that the gyroscope predicts a moment ahead and the one measured.

    The moment is 0.1 s, or longer where the sensor tilts too little. Only instants whose norm is near gravity count, and those
    between which the sensor tilts: NaN where there are fewer than 20.
    """
    part = _middle(time)
    good = np.isfinite(force[part]).all(1) & np.isfinite(rate_rad_s[part]).all(1)
    f, w, t = force[part][good], rate_rad_s[part][good], time[part][good]
    norm, g = norms(f), rest_norm(f)
    if len(t) < 100 or not g > 0:
        return float("nan")
    step = median(np.diff(t))
    turn = np.concatenate([np.zeros((1, 3)), np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(t)[:, None], 0)])
    level = np.abs(norm / g - 1) < 0.05
    for moment_s in (0.1, 0.3, 1.0):
        lag = max(1, round(moment_s / step))
        i = np.arange(0, max(0, len(t) - lag), max(1, lag // 4))
        i = i[level[i] & level[i + lag] & (t[i + lag] - t[i] < 2 * moment_s + step)]
        u, v = f[i] / norm[i][:, None], f[i + lag] / norm[i + lag][:, None]
        moved = (u * v).sum(1) < np.cos(0.1)
        if moved.sum() >= 20:
            # A vector fixed in n turns in b against the sensor's own turn.
            predicted = _turn(u[moved], turn[i[moved]] - turn[i[moved] + lag])
            return median(np.arccos(np.clip((predicted * v[moved]).sum(1), -1, 1)))
    return float("nan")


def _turn(v: Array, r: Array) -> Array:
    """Rodrigues: vectors (N,3) turned by rotation vectors (N,3)."""
    angle = np.linalg.norm(r, axis=1, keepdims=True)
    k = r / np.maximum(angle, 1e-12)
    return v * np.cos(angle) + np.cross(k, v) * np.sin(angle) + k * (k * v).sum(1, keepdims=True) * (1 - np.cos(angle))


def _field_unit(norm: float) -> tuple[str, str]:
    if not norm > 0:
        return "uT", "there is no reading to judge by"
    table = units.MAGNETIC_FLUX_DENSITY
    unit = min(table, key=lambda u: abs(np.log(norm * table[u] / 45.0)))
    return unit, f"the middle norm is {norm:.4g}, and the Earth's field has 20 to 70 µT"


def doubt(name: str, si: Array, values: Mapping[str, Array], time: Array) -> str:
    """Why values in SI (or µT) are hard to believe; empty where they are not."""
    if name == "specific_force":
        norm = rest_norm(si)
        far = norm > 0 and abs(norm / STANDARD_GRAVITY - 1) > TOLERANCE
        return f"its norm at rest would be {norm:.4g} m/s² where gravity has 9.8" if far else ""
    if name == "angular_rate":
        unit, why = unit_of(name, {"specific_force": values["specific_force"], name: si}, time)
        if unit != "rad/s":
            return f"that does not fit the motion ({why})"
        peak = peak_rate(si)
        force = norms(values["specific_force"])
        slow = peak < SLOW_RATE and bool(np.isfinite(force).any()) and float(np.nanstd(force)) > MOVING
        return f"its peak would be {np.degrees(peak):.2g} °/s, less than of anyone who moves so" if slow else ""
    if name == "magnetic_flux_density":
        norm = median(norms(si))
        return "" if FIELD_UT[0] < norm < FIELD_UT[1] else f"its middle norm would be {norm:.4g} µT"
    return ""


def time_unit(stamps: Array) -> str:
    """Unit in which the steps make a plausible rate (1 Hz to 20 kHz)."""
    good = stamps[np.isfinite(stamps)]
    step = np.diff(good)
    step = step[step > 0]
    if not len(step):
        return "s"
    middle = median(step)
    return min(units.TIME, key=lambda u: abs(np.log(middle * units.TIME[u] / 0.01)))


def doubt_time(seconds: Array) -> str:
    good = seconds[np.isfinite(seconds)]
    step = np.diff(good)
    step = step[step > 0]
    if not len(step):
        return ""
    middle = median(step)
    if middle > 2.0:
        unit = time_unit(seconds)
        return f"The steps of time are {middle:.4g} s, too slow to follow a person. If the column is in {unit}, give --units time={unit}."
    if middle < 2e-5:
        return f"The steps of time are {middle:.3g} s, a rate of {1 / middle:.3g} Hz. Check the unit of the time column."
    return ""


def saturated(values: Array) -> list[tuple[int, float, int]]:
    """Axes of (N,C) that stay at their extreme: (axis, extreme, samples there).

    A sensor at the end of its range repeats one value, sample after sample, that it never passes, and falls back from it by more than a
    slow signal does that turns within its resolution. An axis that is there half of the time is stuck, which is another thing.
    """
    found = []
    for axis, x in enumerate(np.ascontiguousarray(values.T)):
        if not np.isfinite(x).any():
            continue
        for extreme in (float(np.fmax.reduce(x)), float(np.fmin.reduce(x))):
            there = np.flatnonzero(x == extreme)
            if len(there) < 3 or len(there) > len(x) // 2 or extreme == 0:
                continue
            begin, end = intervals(x == extreme).T
            long = end - begin >= 3
            if not long.any():
                continue
            levels = np.unique(x[np.isfinite(x)])
            # A quiet signal of few levels repeats its extremes as well.
            if len(levels) <= LEVELS:
                continue
            sides = np.concatenate([begin[long][begin[long] > 0] - 1, end[long][end[long] < len(x)]])
            if (np.abs(x[sides] - extreme) > TURN * (levels[-1] - levels[0])).any():
                found.append((axis, extreme, len(there)))
    return found
