"""Canonical CSV and Parquet: `time,fx,fy,fz,wx,wy,wz,mx,my,mz[,pressure]`, SI units and µT, an empty cell is "no sample"."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import WORDS, Raw, Stream
from bematist.io.table import read_columns, split_header

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

    try:
        names = list(pl.read_parquet_schema(path))
        wanted = _wanted(path, names)
        frame = pl.read_parquet(path, columns=wanted)
        if frame["time"].dtype.is_temporal():
            frame = frame.with_columns(pl.col("time").dt.epoch("ns") * 1e-9)
        frame = frame.with_columns(pl.all().cast(pl.Float64).fill_null(float("nan")))
    except (pl.exceptions.PolarsError, OSError) as error:
        raise DataError(
            f"{path}: this Parquet file cannot be read ({str(error).splitlines()[0][:120]}). It may be cut short: write it anew."
        ) from None
    if not len(frame):
        raise DataError(f"{path}: the table has no row. Export the recording again.")
    return {name: frame[name].to_numpy() for name in wanted}
