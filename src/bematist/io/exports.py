"""Trajectories for other programs: TUM, GeoJSON, GPX, CSV, Parquet."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import UsageError
from bematist.placement import turned
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

EXPORTS = {
    "tum": ("tum", "write", "t x y z qx qy qz qw, for evo and other tools of visual odometry"),
    "geojson": ("geojson", "write", "a line on the map, latitude and longitude"),
    "gpx": ("gpx", "write", "a track for maps and sports programs"),
    "csv": ("trajectory_files", "write_csv", "the columns of trajectory.csv"),
    "parquet": ("trajectory_files", "write_parquet", "the columns of trajectory.parquet"),
}
"""Formats by name: module, function, and what it is for."""

ON_THE_MAP = ("geojson", "gpx")


def export(
    trajectory: Trajectory,
    path: str | Path,
    format: str,
    origin: Sequence[float] | None = None,
    heading_deg: float | None = None,
) -> None:
    """Write a trajectory in another format.

    Parameters
    ----------
    format : tum, geojson, gpx, csv or parquet.
    origin : latitude and longitude in degrees and, where it is known, height in m (all WGS-84) of the point (0, 0, 0)
        of the trajectory, where the recording began unless it was placed elsewhere. GeoJSON and GPX need it; without a
        height they are written without heights.
    heading_deg : the true heading, in degrees clockwise from North, of the trajectory's East axis. A path without
        magnetometer starts along its own East: the heading of its first steps then belongs here. Absent or 90 leaves
        the path as it is. The path, its velocities, attitudes and covariances turn together, in every format.

    Raises
    ------
    UsageError
        An unknown format, or a format that needs an origin is asked for without one.
    DataError
        The file cannot be written.
    """
    if format not in EXPORTS:
        raise UsageError(f'There is no export "{format}": choose one of {", ".join(EXPORTS)}.')
    module, function, _ = EXPORTS[format]
    write: Any = getattr(importlib.import_module(f"bematist.io.{module}"), function)
    if heading_deg is not None:
        trajectory = turned(trajectory, heading_deg)
    if format in ON_THE_MAP:
        write(trajectory, Path(path), _checked(origin, format))
    else:
        write(trajectory, Path(path))


def _checked(origin: Sequence[float] | None, format: str) -> tuple[float, float, float | None]:
    if origin is None:
        raise UsageError(f"{format} needs to know where on Earth the path began: give the origin as latitude,longitude[,height].")
    if len(origin) not in (2, 3) or not np.isfinite(origin).all() or abs(origin[0]) > 90 or abs(origin[1]) > 360:
        raise UsageError(f"Origin {tuple(origin)}: give latitude (−90 to 90) and longitude in degrees and, if known, height in m.")
    return float(origin[0]), float(origin[1]), float(origin[2]) if len(origin) == 3 else None


def map_rows(trajectory: Trajectory) -> NDArray[np.int64]:
    """Rows that draw the path on a map: its ends, the middle of every stance phase, and one a second between.

    A map line of every sample would be ten megabytes of the foot's own arcs.
    """
    middles = trajectory.stance_intervals().sum(1) // 2
    seconds = np.searchsorted(trajectory.time, np.arange(trajectory.time[0], trajectory.time[-1]))
    # A second is added only where no footfall is near.
    near = np.searchsorted(trajectory.time[middles], trajectory.time[seconds])
    padded = np.concatenate([[-np.inf], trajectory.time[middles], [np.inf]])
    gap = np.minimum(trajectory.time[seconds] - padded[near], padded[near + 1] - trajectory.time[seconds])
    return np.unique(np.concatenate([[0], middles, seconds[gap > 1.0], [len(trajectory) - 1]]))


def geodetic(position: Array, origin: tuple[float, float, float | None]) -> tuple[Array, Array, Array | None]:
    """Latitude and longitude in degrees, and height in m where the origin has one, of ENU positions (K,3), m,
    WGS-84.
    """
    from pymap3d import enu2geodetic

    east, north, up = position.T
    latitude, longitude, height = enu2geodetic(east, north, up, origin[0], origin[1], origin[2] or 0.0)
    return np.asarray(latitude), np.asarray(longitude), np.asarray(height) if origin[2] is not None else None
