"""Attitudes as `attitude.parquet` and `attitude.csv`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bematist.attitudes import COLUMNS, Attitude
from bematist.errors import DataError
from bematist.io.trajectory_files import summary_beside, table_of
from bematist.outputs import whole_file

FILES = ("attitude.parquet", "attitude.csv")
DECIMALS = {"time": 6} | dict.fromkeys(("qw", "qx", "qy", "qz"), 8) | dict.fromkeys(COLUMNS[5:8], 5) | dict.fromkeys(COLUMNS[8:], 9)
"""Decimals of the CSV: µs, 1e-8 of a quaternion, 1e-5 degrees, 1e-9 rad/s."""


def write_attitude(attitude: Attitude, folder: str | Path) -> None:
    """Write `attitude.parquet` (every bit) and `attitude.csv` (`DECIMALS`) into a folder that exists.

    Raises
    ------
    DataError
        The folder cannot be written.
    """
    import polars as pl

    table = attitude.to_polars()
    with whole_file(Path(folder) / "attitude.parquet") as place:
        table.write_parquet(place)
    rounded = table.with_columns(pl.col(name).round(n).fill_nan(None) for name, n in DECIMALS.items())
    with whole_file(Path(folder) / "attitude.csv") as place:
        rounded.write_csv(place)


def attitude_file(path: str | Path) -> Path | None:
    """The file of attitudes that a path means: itself, or the one in the folder (the Parquet is preferred); None where it is neither.

    A file is one of attitudes if it has the columns of a quaternion and no position.
    """
    path = Path(path)
    if path.is_dir():
        return next((p for name in FILES if (p := path / name).is_file()), None)
    if not path.is_file():
        return None
    columns = set(table_of(path, COLUMNS).columns)
    return path if {"time", "qw", "qx", "qy", "qz"} <= columns and "east" not in columns else None


def read_attitude(path: str | Path) -> Attitude:
    """Read attitudes: a Parquet or CSV file with `time,qw,qx,qy,qz`, or the folder that `bematist attitude` wrote.

    Raises
    ------
    DataError
        No such file, or it holds no attitudes.
    """
    import polars as pl

    found = attitude_file(path)
    if found is None:
        raise DataError(f"{path}: there are no attitudes here: a file of them has the columns time,qw,qx,qy,qz. See `bematist attitude`.")
    table = table_of(found, COLUMNS)
    wanted = ["time", "qw", "qx", "qy", "qz"]
    if not all(table[name].dtype.is_numeric() for name in wanted):
        raise DataError(f"{found}: there is text where numbers belong. Look for a damaged row.")
    values = table.select(pl.col(n).cast(pl.Float64).fill_null(np.nan) for n in wanted).drop_nans().to_numpy()
    norm = np.linalg.norm(values[:, 1:], axis=1)
    if not len(values) or not (norm > 0).all() or not (np.diff(values[:, 0]) > 0).all():
        raise DataError(f"{found}: the attitudes are none, or zero, or their time does not increase. Look for a damaged row.")
    bias = COLUMNS[8:]
    has_bias = all(name in table.columns for name in bias) and len(table) == len(values)
    summary = summary_beside(found)
    return Attitude(
        time=values[:, 0].copy(),
        attitude=values[:, 1:] / norm[:, None],
        gyro_bias=table.select(bias).to_numpy() if has_bias else np.full((len(values), 3), np.nan),
        north=str(summary.get("north") or "none"),
        filter=str(summary.get("filter") or ""),
        source=str(summary.get("source") or found),
        warnings=tuple(summary.get("warnings") or ()),
    )
