"""TUM trajectories: `timestamp x y z qx qy qz qw`, separated by spaces (scalar last)."""

from __future__ import annotations

from pathlib import Path

from bematist.outputs import whole_file
from bematist.trajectory import Trajectory

ORDER = ("time", "east", "north", "up", "qx", "qy", "qz", "qw")


def write(trajectory: Trajectory, path: Path) -> None:
    """Write every sample; time in s from the start of the recording (µs), ENU position (µm), attitude body → ENU."""
    import polars as pl

    table = trajectory.to_polars().select(pl.col(n).round(9 if n[0] == "q" else 6) for n in ORDER)
    with whole_file(path) as place, place.open("wb") as file:
        file.write(b"# timestamp x y z qx qy qz qw\n")
        table.write_csv(file, include_header=False, separator=" ")
