"""`convert`, `export`, `demo`: files in and out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bematist import config
from bematist.cli import options, site
from bematist.cli.app import app
from bematist.cli.console import output, warn
from bematist.cli.options import Reading
from bematist.errors import UsageError

EXPORTS = {".tum": "tum", ".txt": "tum", ".geojson": "geojson", ".json": "geojson", ".gpx": "gpx", ".csv": "csv"}
EXPORTS |= {".parquet": "parquet"}


@app.command()
def convert(
    recording: options.RecordingPath,
    out: Annotated[Path, typer.Argument(help="File to write, .csv or .parquet.", metavar="OUT")],
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    quiet: options.Quiet = False,
) -> None:
    """Write a recording of any format as canonical CSV or Parquet."""
    options.keep([recording], [out])
    from bematist.io import write_recording

    data = Reading.given(format, columns, axes, units, clock, calibration=calibration, uncalibrated=uncalibrated).read(recording)
    write_recording(data, out)
    if not quiet:
        output().print(f"{len(data):,} samples in {out}", soft_wrap=True)
        warn(data.warnings)


@app.command()
def export(
    trajectory: Annotated[
        Path, typer.Argument(help="trajectory.csv, trajectory.parquet or the folder that holds it.", metavar="TRAJECTORY")
    ],
    out: Annotated[Path, typer.Argument(help="File to write.", metavar="OUT")],
    format: Annotated[
        str | None,
        typer.Option("--format", help="tum, geojson, gpx, csv or parquet; without it the suffix tells.", metavar="NAME"),
    ] = None,
    origin: site.Origin = None,
    heading: Annotated[
        float | None,
        typer.Option("--heading", help="Heading of the path's East axis, degrees clockwise from North; 90 is true.", metavar="DEG"),
    ] = None,
) -> None:
    """Write a trajectory as TUM, GeoJSON, GPX, CSV or Parquet."""
    kind = format or EXPORTS.get(out.suffix.lower())
    if kind is None:
        raise UsageError(f"{out}: the suffix does not tell the format. Name it with --format, such as --format gpx.")
    kind = config.choose("format", kind, dict.fromkeys(EXPORTS.values()))
    place = None if origin is None else site.origin_of(origin)
    options.keep([trajectory], [out])
    from bematist.io import export as write
    from bematist.io import read_trajectory

    write(read_trajectory(trajectory), out, kind, origin=place, heading_deg=heading)


@app.command()
def demo(
    folder: Annotated[Path, typer.Option("--output", "-o", help="Folder of the results.", metavar="DIR")] = Path("demo"),
    scenario: Annotated[str, typer.Option("--scenario", help="The walk.", metavar="NAME")] = "campus",
    seed: Annotated[int, typer.Option("--seed", help="Of the random numbers.", min=0)] = 0,
    quiet: options.Quiet = False,
) -> None:
    """Simulate a walk, track it by three methods, leave a report."""
    from bematist.cli.demo import run

    run(folder, scenario, seed, quiet=quiet)
