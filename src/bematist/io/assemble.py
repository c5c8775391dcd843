"""From what a reader found to a `Recording`: empty rows, clocks, units and axes, settled in this order."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bematist.clock import Clock, Mode, repair
from bematist.errors import DataError
from bematist.frames import axes_matrix
from bematist.io.android import take_raw
from bematist.io.join import SAME_S, join
from bematist.io.raw import WORDS, Raw, Stream
from bematist.io.scale import check_forced, factor, time_factor, times
from bematist.io.suspect import stuck, warnings_of
from bematist.recording import Recording, Sensing

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

EPOCH_S = 1e8
"""Times beyond this (1973) are UNIX times."""
WRAP_TICKS = 2.0**32
NEAR_S = 1.0
"""A slow sensor may have its one sample just before or after the others run."""
BEYOND = 1e9
"""No sensor reads more, in any unit: a damaged file."""


def assemble(
    raw: Raw, *, axes: str | None = None, units: Mapping[str, str] | None = None, clock: Mode = "auto", uncalibrated: bool = False
) -> Recording:
    """Settle empty rows, units, clock and axes, in this order.

    Raises
    ------
    DataError
        No accelerometer or no gyroscope, or no usable time.
    UsageError
        An unknown quantity, unit or axis.
    """
    if uncalibrated:
        take_raw(raw)
    forced = dict(units or {})
    check_forced(forced)
    for needed in ("specific_force", "angular_rate"):
        stream = raw.streams.get(needed)
        if stream is None or not np.isfinite(stream.values).any():
            raise DataError(
                f"{raw.source}: there is no {WORDS[needed]} in the file. bematist needs an accelerometer and a gyroscope; "
                "if the columns have other names, map them with --columns map.toml."
            )
    _one_clock_where_equal(raw)
    one_table = raw.streams["specific_force"].stamps is raw.streams["angular_rate"].stamps
    seconds = time_factor(raw, forced)
    start_ns = _to_seconds(raw, seconds)
    clocks = _clocks(raw, WRAP_TICKS * seconds if seconds in (1e-6, 1e-3) else None, clock)
    time, force, rate = _inertial(clocks, raw, one_table)
    _drop_strangers(clocks, raw, time)
    scaled = {"specific_force": force, "angular_rate": rate}
    for name in ("magnetic_flux_density", "pressure"):
        if name in clocks:
            scaled[name] = raw.streams[name].values
    since = time - time[0]
    for name in list(scaled):
        scaled[name] = times(scaled[name], factor(raw, name, scaled, since, forced))
    if axes:
        M = axes_matrix(axes)
        for name in ("specific_force", "angular_rate", "magnetic_flux_density"):
            if name in scaled:
                scaled[name] = scaled[name] @ M.T
        raw.notes.append(f'Axes: turned by "{axes}"')
    raw.warnings.extend(warnings_of(time, scaled["specific_force"], scaled["angular_rate"]))
    if "magnetic_flux_density" in scaled:
        raw.warnings.extend(stuck("magnetometer", scaled["magnetic_flux_density"]))
    extra: dict[str, object] = {}
    if "magnetic_flux_density" in clocks:
        c = clocks["magnetic_flux_density"]
        extra = {"magnetic_time": c.time, "magnetic_flux_density": scaled["magnetic_flux_density"]}
    if "pressure" in clocks:
        extra |= {"pressure_time": clocks["pressure"].time, "pressure": scaled["pressure"][:, 0]}
    return Recording(
        time=time,
        specific_force=scaled["specific_force"],
        angular_rate=scaled["angular_rate"],
        reference=raw.reference,
        start_ns=start_ns,
        phone=raw.phone,
        source=raw.source,
        sensing=Sensing(device=raw.device, axes=axes or "", uncalibrated=raw.uncalibrated),
        notes=tuple(raw.notes),
        warnings=tuple(dict.fromkeys(raw.warnings)),
        **extra,  # pyright: ignore[reportArgumentType]
    )


def _to_seconds(raw: Raw, factor: float) -> int | None:
    """Bring all stamps to s. UNIX times count from the first inertial sample, whose UNIX time in ns is returned.

    Times that are no UNIX times stay those of the file, so that a reference on the same clock fits.
    """
    inertial = [raw.streams[n].stamps for n in ("specific_force", "angular_rate")]
    finite = [s[np.isfinite(s)] for s in inertial]
    first = min((float(s[0]) for s in finite if len(s)), default=0.0)
    epoch = first * factor > EPOCH_S
    done: dict[int, Array] = {}
    for stream in raw.streams.values():
        key = id(stream.stamps)
        if key not in done:
            done[key] = (stream.stamps - (first if epoch else 0.0)) * factor
        stream.stamps = done[key]
    if raw.reference is not None:
        raw.reference = replace(raw.reference, time=(raw.reference.time - (first if epoch else 0.0)) * factor)
    return round(first * factor * 1e9) if epoch else raw.start_ns


def _one_clock_where_equal(raw: Raw) -> None:
    """Streams with equal stamps share one array of them: they were sampled together."""
    seen: list[Array] = []
    for stream in raw.streams.values():
        same = next((s for s in seen if s is stream.stamps or np.array_equal(s, stream.stamps, equal_nan=True)), None)
        if same is None:
            seen.append(stream.stamps)
        else:
            stream.stamps = same


def _drop_strangers(clocks: dict[str, Clock], raw: Raw, time: Array) -> None:
    """Leave out a sensor that never runs while the inertial ones do."""
    for name in ("magnetic_flux_density", "pressure"):
        if name in clocks and not ((c := clocks[name].time) <= time[-1] + NEAR_S)[c >= time[0] - NEAR_S].any():
            raw.warnings.append(
                f"The {WORDS[name]} runs from {c[0]:.10g} to {c[-1]:.10g} s, the others from {time[0]:.10g} to {time[-1]:.10g} s: its "
                "stamps count from another instant, and it was left out."
            )
            del clocks[name]


def _clocks(raw: Raw, wrap: float | None, mode: Mode) -> dict[str, Clock]:
    """One repaired clock for each sensor; sensors that sample in the same rows share one. Values follow their clock."""
    used = _used_rows(raw)
    clocks: dict[str, Clock] = {}
    force, rate = raw.streams["specific_force"], raw.streams["angular_rate"]
    if force.stamps is rate.stamps:
        a, g = used["specific_force"], used["angular_rate"]
        both = a if np.array_equal(a, g) else np.union1d(a, g)
        if len(a) + len(g) - len(both) >= 0.9 * min(len(a), len(g)):
            inertial = force.values, rate.values
            done = _repair(raw, "specific_force", both, lambda: np.concatenate([_pick(v, both) for v in inertial], 1), mode, wrap, "time")
            raw.notes.append(f"Clock: {done.note}")
            for name in ("specific_force", "angular_rate"):
                clocks[name] = done
                raw.streams[name].values = _pick(raw.streams[name].values, done.rows)
    for name, rows in used.items():
        stream = raw.streams[name]
        if name in clocks or not len(rows):
            continue
        clock = clocks.get("specific_force")
        shared = _shared(clock, rows, stream) if clock is not None and stream.stamps is force.stamps else None
        if shared is None:
            label = "time" if name == "specific_force" else f"{WORDS[name]} time"
            shared = _repair(raw, name, rows, partial(_pick, stream.values, rows), mode, wrap, label)
            raw.notes.append(f"Clock of the {WORDS[name]}: {shared.note}")
        clocks[name] = shared
        stream.values = _pick(stream.values, shared.rows)
    return clocks


def _pick(values: Array, rows: Rows) -> Array:
    """Rows of a table, which is not copied when all are asked for in order."""
    whole = len(rows) == len(values) and (not len(rows) or (rows[0] == 0 and np.all(np.diff(rows) == 1)))
    return values if whole else np.take(values, rows, 0)


def _shared(clock: Clock, rows: Rows, stream: Stream) -> Clock | None:
    """The part of `clock` that falls on `rows`, or None where most rows have no time there."""
    place = np.full(len(stream.stamps), -1)
    place[clock.rows] = np.arange(len(clock.rows))
    found = place[rows]
    found = np.sort(found[found >= 0])
    if len(found) < 0.9 * len(rows):
        return None
    return Clock(clock.time[found], clock.rows[found], clock.kind, clock.note, clock.lost)


def _repair(raw: Raw, name: str, rows: Rows, values: Callable[[], Array], mode: Mode, wrap: float | None, label: str) -> Clock:
    stream = raw.streams[name]
    count = None if stream.count is None else stream.count[rows]
    try:
        done = repair(stream.stamps[rows], values, mode, count=count, wrap_s=wrap, name=label)
    except DataError as error:
        raise DataError(f"{raw.source}: {error}") from None
    raw.warnings.extend(done.warnings)
    return Clock(done.time, rows[done.rows], done.kind, done.note, done.lost)


def _used_rows(raw: Raw) -> dict[str, Rows]:
    """Rows in which each sensor has a whole sample; a sample with a part missing counts as none."""
    used: dict[str, Rows] = {}
    for name in ("specific_force", "angular_rate", "magnetic_flux_density", "pressure"):
        stream = raw.streams.get(name)
        if stream is None:
            continue
        columns = stream.values.T
        finite = np.isfinite(stream.values)
        # By columns: far faster than by rows.
        whole = np.logical_and.reduce(list(finite.T))
        some = np.logical_or.reduce(list(finite.T))
        damaged = max(np.fmax.reduce(columns, None), -np.fmin.reduce(columns, None)) >= BEYOND
        if damaged:
            whole &= np.abs(columns).max(0) < BEYOND
        broken = np.flatnonzero(~whole)
        partial = np.flatnonzero(some & ~whole)
        if damaged:
            beyond: NDArray[np.bool_] = np.asarray((np.abs(columns[:, broken]) >= BEYOND).any(0))
            raw.warnings.append(f"{beyond.sum()} {WORDS[name]} samples beyond anything a sensor can read were left out.")
            partial = partial[~beyond[np.searchsorted(broken, partial)]]
        if len(partial):
            raw.warnings.append(f"{len(partial)} {WORDS[name]} samples with a part missing were left out.")
        if np.count_nonzero(np.isnan(columns)) < len(columns) * len(broken):
            stream.values[broken] = np.nan
        used[name] = np.flatnonzero(whole)
        gone = len(broken)
        if gone and name in ("specific_force", "angular_rate"):
            raw.notes.append(f"Rows without a sample of the {WORDS[name]}: {gone} of {len(whole)}")
    return used


def _inertial(clocks: Mapping[str, Clock], raw: Raw, one_table: bool) -> tuple[Array, Array, Array]:
    """Accelerometer and gyroscope on one time axis; NaN where one of them has no sample.

    Rows of one table stay as they are; sensors with a clock of their own are joined.
    """
    a, g = clocks["specific_force"], clocks["angular_rate"]
    f, w = raw.streams["specific_force"].values, raw.streams["angular_rate"].values
    if a is g or np.array_equal(a.time, g.time):
        return a.time, f, w
    if not one_table:
        try:
            joined = join(a.time, f, g.time, w)
        except DataError as error:
            raise DataError(f"{raw.source}: {error}") from None
        raw.notes.append(f"Clock: {joined.note}")
        raw.warnings += [joined.warning] if joined.warning else []
        return joined.time, joined.force, joined.rate
    time = np.union1d(a.time, g.time)
    time = time[np.concatenate([[True], np.diff(time) > SAME_S])]
    out = []
    for clock, values in ((a, f), (g, w)):
        full = np.full((len(time), 3), np.nan)
        full[np.searchsorted(time, clock.time + SAME_S, side="right") - 1] = values
        out.append(full)
    return time, out[0], out[1]
