"""Trajectories as `trajectory.parquet` and `trajectory.csv`."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bematist.errors import DataError
from bematist.io.parquet import read_parquet
from bematist.io.parquet_plain import DOUBLE, UINT8, write_columns
from bematist.outputs import whole_file
from bematist.trajectory import COLUMNS, Steps, Trajectory

if TYPE_CHECKING:
    import polars as pl

COVARIANCE_COLUMNS = tuple(
    f"cov_{of}_{axes}" for of in ("position", "velocity", "attitude") for axes in ("ee", "en", "eu", "nn", "nu", "uu")
)
"""Columns of the parquet file after `trajectory.COLUMNS`: upper triangles of the three covariances (m², m²/s²,
rad²).
"""

SCHEMA = dict.fromkeys((*COLUMNS, *COVARIANCE_COLUMNS), DOUBLE) | {"stance": UINT8}

DECIMALS = {name: 8 if name in ("qw", "qx", "qy", "qz") else 6 for name in COLUMNS[:-1]} | {"stance": 0}
"""Decimals of the CSV: µs, µm, µm/s, and 1e-8 of a quaternion (a millionth of a degree)."""

PIECE = 1 << 14
"""Rows that are written at a time, and of a row group of the Parquet file."""


def write_trajectory(trajectory: Trajectory, folder: str | Path) -> None:
    """Write `trajectory.parquet` (every bit, with the covariances) and `trajectory.csv` (`DECIMALS`) into a folder that
    exists.

    Raises
    ------
    DataError
        The folder cannot be written.
    """
    write_parquet(trajectory, Path(folder) / "trajectory.parquet")
    write_csv(trajectory, Path(folder) / "trajectory.csv")


def write_parquet(trajectory: Trajectory, path: Path) -> None:
    """`trajectory.COLUMNS`, then `COVARIANCE_COLUMNS`, as float64: what is read back is the same bit for bit.

    Not compressed: of such digits a codec saves a seventh.
    """
    with whole_file(path) as place, place.open("wb") as file:
        write_columns(file, SCHEMA, ([*part.columns(), *part.packed_covariance.T] for part in _pieces(trajectory)))


def write_csv(trajectory: Trajectory, path: Path) -> None:
    """`trajectory.COLUMNS` with `DECIMALS`; an unknown value is an empty cell.

    Four million numbers are most of the command's work after the filter, so they have a kernel (`kernels.text`), four times as fast as
    the table library.
    """
    from bematist.kernels import text

    decimals = np.array([DECIMALS[name] for name in COLUMNS])
    out = np.empty(min(PIECE, len(trajectory)) * len(COLUMNS) * text.CELL, np.uint8)
    with whole_file(path) as place, place.open("wb") as file:
        file.write((",".join(COLUMNS) + "\n").encode())
        for part in _pieces(trajectory):
            size = text.rows(np.stack(part.columns()), decimals, out)
            if size < 0:
                raise DataError(f"{path}: positions or velocities are larger than 1e9 and mean nothing. Check the units of the recording.")
            out[:size].tofile(file)


def write_steps(steps: Steps, path: Path) -> None:
    """The steps of a hand's path as CSV: numbers with six decimals, and words."""
    columns = steps.columns()
    cells = [[f"{v:.6f}" for v in column] if column.dtype.kind == "f" else column.tolist() for column in columns.values()]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*cells, strict=True))


def _pieces(trajectory: Trajectory) -> Iterator[Trajectory]:
    """The trajectory in pieces: all columns of it at once would double the memory that it takes."""
    for start in range(0, len(trajectory), PIECE):
        yield trajectory.rows(start, start + PIECE)


def read_trajectory(path: str | Path) -> Trajectory:
    """Read a trajectory: its Parquet or CSV file, or the folder that holds them (the Parquet is then preferred).

    Method, source and warnings come from the `summary.json` beside the file. A CSV knows the standard deviations of the
    position only, so the rest of the covariance is NaN.

    Raises
    ------
    DataError
        No such file, or it holds no trajectory.
    """
    path = Path(path)
    if path.is_dir():
        found = [p for n in ("trajectory.parquet", "trajectory.csv") if (p := path / n).is_file()]
        if not found:
            raise DataError(f"{path}: there is no trajectory.parquet or trajectory.csv in this folder. Make one with `bematist track`.")
        path = found[0]
    table = table_of(path)
    if missing := [name for name in COLUMNS if name not in table.columns]:
        raise DataError(
            f"{path}: this is no trajectory, the column{'s' * (len(missing) > 1)} {', '.join(missing)} "
            f"{'are' if len(missing) > 1 else 'is'} missing. `bematist track` writes {', '.join(COLUMNS)}."
        )
    if not len(table):
        raise DataError(f"{path}: the trajectory has no rows.")
    values = _numbers(table, path)
    summary = summary_beside(path)
    return Trajectory(
        time=values[:, 0].copy(),
        position=values[:, 1:4].copy(),
        velocity=values[:, 4:7].copy(),
        attitude=values[:, 7:11].copy(),
        stance=(values[:, 14] > 0).astype(np.uint8),
        packed_covariance=_covariance(table, values, path),
        method=str(summary.get("method") or ""),
        source=str(summary.get("source") or path),
        warnings=tuple(summary.get("warnings") or ()),
    )


def table_of(path: Path, columns: Sequence[str] = COLUMNS) -> pl.DataFrame:
    """A Parquet or CSV file as a table, in which `columns` are numbers. DataError where it cannot be read."""
    import polars as pl

    try:
        with path.open("rb") as file:
            parquet = file.read(4) == b"PAR1"
        # glob=False: a name with brackets is a name.
        if parquet:
            return read_parquet(path)
        # Types are given: the first hundred rows of a rest look like integers.
        return pl.read_csv(path, comment_prefix="#", glob=False, schema_overrides=dict.fromkeys(columns, pl.Float64))
    except OSError as error:
        raise DataError(f"{path}: the trajectory cannot be read ({error.strerror or error}).") from None
    except pl.exceptions.PolarsError as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DataError(f"{path}: this is no readable trajectory, it is damaged or of another format ({first}).") from None


def _numbers(table: pl.DataFrame, path: Path) -> np.ndarray:
    import polars as pl

    text = [name for name in COLUMNS if not table[name].dtype.is_numeric() and table[name].dtype not in (pl.Null, pl.Boolean)]
    if text:
        raise DataError(f"{path}: the column {text[0]} holds text where numbers belong. Look for a damaged row.")
    values = table.select(pl.col(name).cast(pl.Float64) for name in COLUMNS).to_numpy()
    bad = np.flatnonzero(~np.isfinite(values[:, :4]).all(1))
    if len(bad):
        raise DataError(f"{path}: row {bad[0] + 2} has no time or no position. Look for a damaged row.")
    return values


def _covariance(table: pl.DataFrame, values: np.ndarray, path: Path) -> np.ndarray:
    import polars as pl

    if all(name in table.columns for name in COVARIANCE_COLUMNS):
        try:
            return np.ascontiguousarray(table.select(pl.col(n).cast(pl.Float64) for n in COVARIANCE_COLUMNS).to_numpy())
        except pl.exceptions.PolarsError:
            raise DataError(f"{path}: the columns cov_… hold text where numbers belong.") from None
    packed = np.full((len(values), 18), np.nan)
    packed[:, [0, 3, 5]] = values[:, 11:14] ** 2
    return packed


def summary_beside(path: Path) -> dict[str, Any]:
    """The content of the `summary.json` beside a file of results, empty without one."""
    try:
        found = json.loads((path.parent / "summary.json").read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
