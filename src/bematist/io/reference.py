"""References: the true path as CSV, Parquet or .mat."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head, open_head
from bematist.recording import Reference


def read_gsu(path: Path) -> Reference | None:
    """Surveyed footfalls of one shoe (GSU): positions (K,2) m in the corridor's frame, no times. None where it holds none."""
    from bematist.io.mat import load

    mat = load(path)
    if "GCP_meters" not in mat:
        return None
    xy = np.asarray(mat["GCP_meters"], float)
    numbers = np.asarray(mat.get("GCP_stride_numbers", np.arange(len(xy)))).ravel().astype(np.int64)
    if xy.ndim != 2 or xy.shape[1] != 2 or len(numbers) != len(xy):
        raise DataError(f"{path}: GCP_meters has shape {xy.shape} and there are {len(numbers)} stride numbers.")
    return Reference(
        time=np.full(len(xy), np.nan),
        position=np.column_stack([xy, np.full(len(xy), np.nan)]),
        footfall=numbers,
        mirrored=True,
        note="surveyed footfalls (GSU), plan only, corridor frame",
        source=str(path),
    )


def read_reference(path: str | Path, *, start_ns: int | None = None) -> Reference:
    """The true path from a file.

    CSV or Parquet with `time,east,north[,up][,qw,qx,qy,qz]` (empty cells allowed; a trajectory is one too), a GSU, PyShoe or BROAD .mat,
    or a folder that `bematist track` wrote. `start_ns`, the start of the recording, turns UNIX times into times of the recording.

    Raises
    ------
    DataError
        The file cannot be read or holds no reference.
    """
    path = Path(path)
    if path.is_dir():
        path = next((p for n in ("parquet", "csv") if (p := path / f"trajectory.{n}").is_file()), path)
    head = open_head(path)
    if head.is_folder:
        raise DataError(f"{path}: the folder holds no trajectory.parquet or trajectory.csv. Name the reference file.")
    if head.raw[:6] == b"MATLAB":
        return _mat(path)
    return _table(head, start_ns)


def _mat(path: Path) -> Reference:
    from bematist.io import broad, pyshoe
    from bematist.io.mat import load

    found = read_gsu(path) or pyshoe.reference_of(mat := load(path)) or broad.reference_of(mat)
    if found is None:
        raise DataError(
            f"{path}: neither GCP_meters (GSU) nor gt and ts (PyShoe) nor opt_quat and sampling_rate (BROAD) is in this MATLAB file."
        )
    return replace(found, source=str(path))


def _table(head: Head, start_ns: int | None) -> Reference:
    columns = _columns(head)
    time = columns["time"].copy()
    keep = np.isfinite(time) & np.isfinite(columns["east"]) & np.isfinite(columns["north"])
    if "qw" in columns:
        keep |= np.isfinite(time) & np.isfinite(columns["qw"])
    if not keep.any():
        raise DataError(f"{head.path}: no row has a time and a position. Fill time, east and north.")
    if start_ns is not None and np.nanmin(time) > 1e8:
        time -= start_ns * 1e-9
    order = np.flatnonzero(keep)[np.argsort(time[keep], kind="stable")]
    up = columns.get("up", np.full(len(time), np.nan))
    position = np.column_stack([columns["east"], columns["north"], up])[order]
    attitude = None
    if "qw" in columns:
        attitude = np.column_stack([columns[n] for n in ("qw", "qx", "qy", "qz")])[order]
        norm = np.linalg.norm(attitude, axis=1, keepdims=True)
        attitude = np.where(norm > 0, attitude / np.where(norm > 0, norm, 1.0), np.nan)
    return Reference(time=time[order], position=position, attitude=attitude, note=f"reference {head.path.name}", source=str(head.path))


def _columns(head: Head) -> dict[str, np.ndarray]:
    import polars as pl

    from bematist.io.parquet import columns_of, read_parquet
    from bematist.io.table import read_columns, split_header

    optional = ("up", "qw", "qx", "qy", "qz")
    try:
        parquet = head.raw[:4] == b"PAR1"
        line, text = head.header()
        names, separator = (columns_of(head.path), "") if parquet else split_header(text)
        if missing := [n for n in ("time", "east", "north") if n not in names]:
            raise DataError(
                f"{head.path}: the reference lacks the column {', '.join(missing)}. A reference is a CSV with "
                "time,east,north[,up][,qw,qx,qy,qz], or a GSU, PyShoe or BROAD .mat."
            )
        quaternion = all(n in names for n in optional[1:])
        wanted = ["time", "east", "north", *(n for n in optional if n in names and (n == "up" or quaternion))]
        if not parquet:
            return read_columns(head, line, names, wanted, separator=separator)
        frame = read_parquet(head.path, wanted).with_columns(pl.all().cast(pl.Float64).fill_null(np.nan))
        return {n: frame[n].to_numpy() for n in wanted}
    except (pl.exceptions.PolarsError, OSError) as error:
        raise DataError(f"{head.path}: cannot be read ({str(error).splitlines()[0][:120]}). Write it anew.") from None


def write_reference(reference: Reference, path: str | Path) -> None:
    """Write a reference as CSV with `time,east,north,up[,qw,qx,qy,qz]`; what is not known is an empty cell.

    Raises
    ------
    DataError
        The file cannot be written.
    """
    import polars as pl

    from bematist.outputs import whole_file

    columns = dict(zip(("time", "east", "north", "up"), (reference.time, *reference.position.T), strict=True))
    if reference.attitude is not None:
        columns |= dict(zip(("qw", "qx", "qy", "qz"), reference.attitude.T, strict=True))
    with whole_file(Path(path)) as place:
        # ns, nm and 1e-9 of a quaternion.
        pl.DataFrame(columns).with_columns(pl.all().round(9)).fill_nan(None).write_csv(place)
