"""What a reader found in a file, before units, axes and clock are settled; and how it becomes a `Recording`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bematist import units as unit_tables
from bematist.clock import Clock, Mode, repair
from bematist.errors import DataError, UsageError
from bematist.frames import axes_matrix
from bematist.io import guess
from bematist.recording import Recording, Reference

Array = NDArray[np.float64]

EPOCH_S = 1e8
"""Times beyond this (1973) are UNIX times."""
WRAP_TICKS = 2.0**32
UNITS: dict[str, dict[str, float]] = {
    "specific_force": unit_tables.SPECIFIC_FORCE,
    "angular_rate": unit_tables.ANGULAR_RATE,
    "magnetic_flux_density": unit_tables.MAGNETIC_FLUX_DENSITY,
    "pressure": unit_tables.PRESSURE,
    "time": unit_tables.TIME,
}
WORDS = {
    "specific_force": "accelerometer",
    "angular_rate": "gyroscope",
    "magnetic_flux_density": "magnetometer",
    "pressure": "barometer",
    "time": "time",
}
FIELD_OF_AU_UT = 50.0
"""What 1 a.u. of a magnetometer without absolute scale is taken for, µT: a common field of the Earth."""


@dataclass(kw_only=True)
class Stream:
    """Samples of one sensor in the file's own units: stamps (N,) and values (N,C)."""

    stamps: Array
    values: Array


@dataclass(kw_only=True)
class Raw:
    """A file's content. `stated` maps a quantity to the unit that the file states; a missing one is guessed.

    Streams that share one array of stamps (the same object) are columns of one table and share one clock.
    """

    source: str
    streams: dict[str, Stream]
    stated: dict[str, str] = field(default_factory=dict)
    unit_source: str = "stated by the format"
    trust_units: bool = True
    reference: Reference | None = None
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def assemble(
    raw: Raw, *, axes: str | None = None, units: Mapping[str, str] | None = None, clock: Mode = "auto"
) -> Recording:
    """Settle empty rows, units, clock and axes, in this order.

    Raises
    ------
    DataError
        No accelerometer or no gyroscope, or no usable time.
    UsageError
        An unknown quantity, unit or axis.
    """
    forced = dict(units or {})
    _check_forced(forced)
    for needed in ("specific_force", "angular_rate"):
        stream = raw.streams.get(needed)
        if stream is None or not np.isfinite(stream.values).any():
            raise DataError(
                f"{raw.source}: there is no {WORDS[needed]} in the file. bematist needs an accelerometer and a gyroscope; "
                "if the columns have other names, map them with --columns map.toml."
            )
    factor = _time_factor(raw, forced)
    clocks = _clocks(raw, factor, clock)
    start_ns, offset = _start(clocks)
    time, force, rate = _inertial(clocks, raw)
    scaled = {"specific_force": force, "angular_rate": rate}
    for name in ("magnetic_flux_density", "pressure"):
        if name in clocks:
            scaled[name] = raw.streams[name].values
    for name in list(scaled):
        scaled[name] = scaled[name] * _factor(raw, name, scaled, time - time[0], forced)
    if axes:
        M = axes_matrix(axes)
        for name in ("specific_force", "angular_rate", "magnetic_flux_density"):
            if name in scaled:
                scaled[name] = scaled[name] @ M.T
        raw.notes.append(f'Axes: turned by "{axes}"')
    extra: dict[str, object] = {}
    if "magnetic_flux_density" in clocks:
        c = clocks["magnetic_flux_density"]
        extra = {"magnetic_time": c.time - offset, "magnetic_flux_density": scaled["magnetic_flux_density"]}
    if "pressure" in clocks:
        extra |= {"pressure_time": clocks["pressure"].time - offset, "pressure": scaled["pressure"][:, 0]}
    return Recording(
        time=time - offset,
        specific_force=scaled["specific_force"],
        angular_rate=scaled["angular_rate"],
        reference=raw.reference,
        start_ns=start_ns,
        source=raw.source,
        notes=tuple(raw.notes),
        warnings=tuple(dict.fromkeys(raw.warnings)),
        **extra,  # pyright: ignore[reportArgumentType]
    )


def _check_forced(forced: Mapping[str, str]) -> None:
    for name, unit in forced.items():
        if name not in UNITS:
            raise UsageError(f'Units: there is no quantity "{name}". Quantities: {", ".join(UNITS)}.')
        if unit not in UNITS[name]:
            raise UsageError(f'Units: "{unit}" is no unit of {name}. Choose one of {", ".join(UNITS[name])}.')


def _time_factor(raw: Raw, forced: Mapping[str, str]) -> float:
    unit = forced.get("time") or raw.stated.get("time")
    stamps = raw.streams["specific_force"].stamps
    if unit is None:
        unit = guess.time_unit(stamps)
        raw.warnings.append(f"The unit of time is not stated; from the steps it was taken for {unit}.")
    elif "time" not in forced and (doubt := guess.doubt_time(stamps * UNITS["time"][unit])):
        raw.warnings.append(doubt)
    return UNITS["time"][unit]


def _clocks(raw: Raw, factor: float, mode: Mode) -> dict[str, Clock]:
    """One repaired clock for each sensor; sensors that sample in the same rows share one."""
    wrap = WRAP_TICKS * factor if factor in (1e-6, 1e-3) else None
    clocks: dict[str, Clock] = {}
    for name, rows in _used_rows(raw).items():
        stream = raw.streams[name]
        if not len(rows):
            continue
        stamps = stream.stamps[rows] * factor
        shared = clocks.get("specific_force")
        label = "time" if name in ("specific_force", "angular_rate") else f"{WORDS[name]} time"
        if shared is not None and stream.stamps is raw.streams["specific_force"].stamps:
            found = np.searchsorted(shared.rows, rows)
            found = np.minimum(found, len(shared.rows) - 1)
            if np.mean(shared.rows[found] == rows) > 0.9 or name == "angular_rate" and len(rows) == len(shared.rows):
                match = shared.rows[found] == rows
                clocks[name] = Clock(shared.time[found[match]], rows[match], shared.kind, "", shared.lost)
                stream.values = stream.values[rows[match]]
                continue
        done = _repair(stamps, rows, raw, name, mode, wrap, label)
        clocks[name] = done
        stream.values = stream.values[done.rows]
        raw.warnings.extend(done.warnings)
        raw.notes.append(f"Clock of the {WORDS[name]}: {done.note}")
    return clocks


def _repair(stamps: Array, rows: NDArray[np.int64], raw: Raw, name: str, mode: Mode, wrap: float | None, label: str):
    values = raw.streams[name].values[rows]
    if name == "specific_force" and raw.streams["angular_rate"].stamps is raw.streams[name].stamps:
        values = np.concatenate([values, raw.streams["angular_rate"].values[rows]], 1)
    try:
        done = repair(stamps, values, mode, wrap_s=wrap, name=label)
    except DataError as error:
        raise DataError(f"{raw.source}: {error}") from None
    return Clock(done.time, rows[done.rows], done.kind, done.note, done.lost, done.warnings)


def _used_rows(raw: Raw) -> dict[str, NDArray[np.int64]]:
    """Rows in which each sensor has a whole sample; a sample with a part missing counts as none."""
    used: dict[str, NDArray[np.int64]] = {}
    for name in ("specific_force", "angular_rate", "magnetic_flux_density", "pressure"):
        stream = raw.streams.get(name)
        if stream is None:
            continue
        finite = np.isfinite(stream.values)
        whole = finite.all(1)
        partial = int((finite.any(1) & ~whole).sum())
        if partial:
            raw.warnings.append(f"{partial} {WORDS[name]} samples with a part missing were left out.")
        used[name] = np.flatnonzero(whole)
    if not len(used["specific_force"]) or not len(used["angular_rate"]):
        raise DataError(f"{raw.source}: no row holds a whole accelerometer and gyroscope sample.")
    both = [used["specific_force"], used["angular_rate"]]
    if raw.streams["specific_force"].stamps is raw.streams["angular_rate"].stamps:
        n = len(raw.streams["specific_force"].values)
        empty = n - len(np.union1d(*both)) if not np.array_equal(*both) else n - len(both[0])
        others = [used[k] for k in ("magnetic_flux_density", "pressure") if k in used]
        lone = len(np.setdiff1d(np.concatenate(others), both[0])) if others and empty else 0
        if empty - lone > 0:
            raw.notes.append(f"Rows: {empty - lone} rows without any sample")
    return used


def _start(clocks: Mapping[str, Clock]) -> tuple[int | None, float]:
    """UNIX start in ns and what to take off the times. Times that are no UNIX times stay those of the file."""
    first = min(float(c.time[0]) for n, c in clocks.items() if n in ("specific_force", "angular_rate"))
    return (round(first * 1e9), first) if first > EPOCH_S else (None, 0.0)


def _inertial(clocks: Mapping[str, Clock], raw: Raw) -> tuple[Array, Array, Array]:
    """Accelerometer and gyroscope on one time axis; NaN where one of them has no sample."""
    a, g = clocks["specific_force"], clocks["angular_rate"]
    f, w = raw.streams["specific_force"].values, raw.streams["angular_rate"].values
    if np.array_equal(a.time, g.time):
        return a.time, f, w
    # Instants that agree within a µs are one instant.
    time = np.union1d(a.time, g.time)
    time = time[np.concatenate([[True], np.diff(time) > 1e-6])]
    out = []
    for clock, values in ((a, f), (g, w)):
        full = np.full((len(time), 3), np.nan)
        full[np.searchsorted(time, clock.time + 1e-6, side="right") - 1] = values
        out.append(full)
    return time, out[0], out[1]


def _factor(raw: Raw, name: str, values: Mapping[str, Array], time: Array, forced: Mapping[str, str]) -> float:
    """Factor to SI (µT), with a note on where the unit comes from and a warning where it is a guess or doubtful."""
    word = WORDS[name]
    if name in forced:
        raw.notes.append(f"Units of the {word}: {forced[name]}, as asked")
        return UNITS[name][forced[name]]
    unit = raw.stated.get(name)
    if unit == "a.u.":
        raw.notes.append(f"Units of the {word}: arbitrary, 1 = the local field, taken as {FIELD_OF_AU_UT:g} µT")
        raw.warnings.append(
            f"The {word} has no absolute scale (a.u., 1 = the local field); 1 was taken as {FIELD_OF_AU_UT:g} µT. Ratios and "
            "directions hold, the norm in µT does not."
        )
        return FIELD_OF_AU_UT
    found, why = guess.unit_of(name, values, time)
    if unit is None:
        raw.notes.append(f"Units of the {word}: {found}, guessed: {why}")
        raw.warnings.append(
            f"The unit of the {word} is not stated; it was taken for {found} ({why}). Force another with "
            f"--units {name}=UNIT."
        )
        return UNITS[name][found]
    raw.notes.append(f"Units of the {word}: {unit}, {raw.unit_source}")
    doubt = guess.doubt(name, values[name] * UNITS[name][unit], values, time)
    if doubt:
        likely = f" The values look like {found} ({why}): if so, give --units {name}={found}." if found != unit else ""
        raw.warnings.append(f"The {word} is in {unit} ({raw.unit_source}), but {doubt}.{likely}")
    return UNITS[name][unit]
