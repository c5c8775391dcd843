"""Canonical CSV and Parquet: `time,fx,fy,fz,wx,wy,wz,mx,my,mz[,pressure]`, SI units and µT, an empty cell is "no sample"."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.io.head import Head
from bematist.io.parquet import columns_of, read_parquet
from bematist.io.raw import WORDS, Raw, Stream
from bematist.io.table import read_columns, split_header
from bematist.recording import Recording

COLUMNS: dict[str, tuple[str, ...]] = {
    "specific_force": ("fx", "fy", "fz"),
    "angular_rate": ("wx", "wy", "wz"),
    "magnetic_flux_density": ("mx", "my", "mz"),
    "pressure": ("pressure",),
}
STATED = {
    "time": "s",
    "specific_force": "m/s^2",
    "angular_rate": "rad/s",
    "magnetic_flux_density": "uT",
    "pressure": "Pa",
}


def is_parquet(head: Head) -> bool:
    return head.raw[:4] == b"PAR1"


def sniff(head: Head) -> bool:
    if is_parquet(head):
        return True
    names = {name.lower() for name in split_header(head.header()[1])[0]}
    return len(names & {"fx", "fy", "fz", "wx", "wy", "wz"}) >= 3


def read(head: Head) -> Raw:
    if is_parquet(head):
        return from_columns(head.path, _parquet(head.path))
    line, text = head.header()
    names, separator = split_header(text)
    names = [name.lower() for name in names]
    wanted = _wanted(head.path, names)
    return from_columns(head.path, read_columns(head, line, names, wanted, separator=separator))


def _wanted(path: Path, names: list[str]) -> list[str]:
    """The canonical columns that are there; a sensor is there with all its axes or not at all."""
    if "time" not in names:
        raise DataError(f'{path}: the header has no column "time". Add one in seconds, or give the rate with --columns map.toml.')
    wanted = ["time"]
    for quantity, columns in COLUMNS.items():
        missing = [c for c in columns if c not in names]
        if missing and len(missing) < len(columns):
            raise DataError(f"{path}: the {WORDS[quantity]} lacks the column {', '.join(missing)}. Add it to the header.")
        wanted += [] if missing else columns
    return wanted


def from_columns(path: Path, columns: dict[str, NDArray[np.float64]]) -> Raw:
    stamps = columns.pop("time")
    streams = {}
    for quantity, names in COLUMNS.items():
        if names[0] in columns:
            streams[quantity] = Stream(stamps=stamps, values=np.stack([columns.pop(n) for n in names], 1))
    return Raw(source=str(path), streams=streams, stated=dict(STATED), unit_source="canonical columns are SI and µT")


def _parquet(path: Path) -> dict[str, NDArray[np.float64]]:
    import polars as pl

    names = {name.lower(): name for name in columns_of(path)}
    wanted = _wanted(path, list(names))
    frame = read_parquet(path, [names[name] for name in wanted])
    frame.columns = wanted
    if frame["time"].dtype.is_temporal():
        frame = frame.with_columns(pl.col("time").dt.epoch("ns") * 1e-9)
    try:
        frame = frame.with_columns(pl.all().cast(pl.Float64).fill_null(float("nan")))
    except pl.exceptions.PolarsError:
        text = next(c.name for c in frame if not c.dtype.is_numeric())
        raise DataError(f'{path}: the column "{text}" does not hold numbers. Write the table anew with numbers.') from None
    if not len(frame):
        raise DataError(f"{path}: the table has no row. Export the recording again.")
    return {name: frame[name].to_numpy() for name in wanted}


DECIMALS = {"time": 9}
"""Decimals of a CSV: ns for the time, 1e-7 of its unit for all else, far below the noise of any sensor."""


def write_recording(recording: Recording, path: str | Path) -> None:
    """Write a recording as canonical CSV, or Parquet (bit for bit), by the suffix.

    Each sensor keeps its own instants: a row holds the sensors that have a sample at its time, other cells are empty.

    Raises
    ------
    UsageError
        Another suffix.
    DataError
        The file cannot be written.
    """
    import polars as pl

    from bematist.outputs import whole_file

    path = Path(path)
    if path.suffix.lower() not in (".csv", ".parquet"):
        raise UsageError(f"{path}: the suffix says what is written: use .csv or .parquet.")
    table = pl.DataFrame(_table(recording)).fill_nan(None)
    with whole_file(path) as place:
        if path.suffix.lower() == ".parquet":
            table.write_parquet(place)
        else:
            table.with_columns(pl.col(name).round(DECIMALS.get(name, 7)) for name in table.columns).write_csv(place)


def _table(r: Recording) -> dict[str, NDArray[np.float64]]:
    sensors = {
        "specific_force": (r.time, r.specific_force),
        "angular_rate": (r.time, r.angular_rate),
        "magnetic_flux_density": (r.magnetic_time, r.magnetic_flux_density),
        "pressure": (r.pressure_time, r.pressure[:, None]),
    }
    time = np.unique(np.concatenate([times for times, _ in sensors.values()]))
    table = {"time": time}
    for quantity, (times, values) in sensors.items():
        if not len(times):
            continue
        rows = np.searchsorted(time, times)
        for name, column in zip(COLUMNS[quantity], values.T, strict=True):
            table[name] = np.full(len(time), np.nan)
            table[name][rows] = column
    return table
