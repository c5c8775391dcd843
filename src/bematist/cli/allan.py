"""`allan`: from hours of rest to the noise that a filter believes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, progress, table, warn
from bematist.cli.options import Reading
from bematist.outputs import results_folder, to_json

if TYPE_CHECKING:
    from bematist.allan import AllanResult

FILES = ("allan.csv", "coefficients.csv", "allan.json", "noise.toml", "allan.html", "allan.png", "allan.svg")
SPACINGS = ("octave", "decade")


@app.command()
def allan(
    recording: options.RecordingPath,
    output_folder: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder of the results; without it, RECORDING-allan.", metavar="DIR"),
    ] = None,
    start: Annotated[float | None, typer.Option("--from", help="Only from this time on, s.", metavar="S")] = None,
    end: Annotated[float | None, typer.Option("--to", help="Only to this time, s.", metavar="S")] = None,
    spacing: Annotated[str, typer.Option("--spacing", help="Averaging times.", metavar="octave|decade")] = "octave",
    quaternion: Annotated[bool, typer.Option("--quaternion", help="Also of the gyroscope quaternion (MAGYQ).")] = False,
    horizon: Annotated[
        float,
        typer.Option("--horizon", min=1.0, help="Averaging time at which noise.toml's bias walks equal what was found, s.", metavar="S"),
    ] = 100.0,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    quiet: options.Quiet = False,
) -> None:
    """Identify a sensor's noise from a recording at rest.

    Writes the Allan deviations (allan.csv), the noises with their intervals (coefficients.csv, allan.json), a page to look at
    (allan.html), pictures (allan.png, allan.svg), and noise.toml, which "bematist track --config noise.toml" takes.
    """
    config.choose("spacing", spacing, SPACINGS)
    reading = Reading.given(format, columns, axes, units, clock, calibration=calibration, uncalibrated=uncalibrated)
    folder = options.folder_for(recording, output_folder, "-allan")
    options.keep([recording], [folder / name for name in FILES])
    with results_folder(folder) as place:
        with progress("reading", quiet=quiet):
            data = reading.read(recording)
        from bematist.allan import allan as identify

        with progress("Allan deviation", quiet=quiet) as tell:
            found = identify(
                data,
                start_s=start,
                end_s=end,
                spacing=spacing,  # pyright: ignore[reportArgumentType]
                quaternion=quaternion,
                progress=lambda done, total: tell(done / total),
            )
        with progress("writing", quiet=quiet):
            write(place, found, horizon)
    if not quiet:
        show(found, folder, horizon)
        warn(found.warnings)


def write(folder: Path, found: AllanResult, horizon_s: float) -> None:
    """Write the files of `FILES`."""
    import polars as pl

    from bematist.report import still_allan, write_allan_page

    rows = found.coefficients()
    found.to_polars().write_csv(folder / "allan.csv")
    flat = [{k: v for k, v in row.items() if k != "other_units"} for row in rows]
    pl.DataFrame(flat, infer_schema_length=None).write_csv(folder / "coefficients.csv")
    content = {
        "source": found.source,
        "start_s": found.start_s,
        "end_s": found.end_s,
        "coefficients": rows,
        "fits": {s.name: s.verdicts() for s in found.sensors.values()},
        "noise": found.noise(horizon_s),
        "left_out": found.left_out(horizon_s),
        "horizon_s": horizon_s,
        "warnings": found.warnings,
    }
    (folder / "allan.json").write_text(to_json(content), "utf-8")
    (folder / "noise.toml").write_text(found.to_toml(horizon_s), "utf-8")
    write_allan_page(found, folder / "allan.html", horizon_s)
    still_allan(found, folder / "allan.png")
    still_allan(found, folder / "allan.svg")


def show(found: AllanResult, folder: Path, horizon_s: float) -> None:
    """Print what was found."""
    from bematist.allan import sheet

    name = Path(found.source).name or "recording"
    output().print(f"{name} · rest from {found.start_s:.1f} to {found.end_s:.1f} s", style="bold", soft_wrap=True)
    shown = [row for row in found.coefficients() if row["found"] or row["symbol"] in "BK"]
    output().print(table(sheet.HEADER, [sheet.cells(row) for row in shown], right=(4, 5)))
    lines = [(s.name, s.verdict()) for s in found.sensors.values()]
    lines += [(key, f"{value:.4g}") for key, value in found.noise(horizon_s).items()]
    lines += [("noise.toml", reason) for reason in found.left_out(horizon_s)]
    output().print(facts(lines))
    output().print(f"Results in {folder}/, see {folder / 'allan.html'}; bematist track … --config {folder / 'noise.toml'}", soft_wrap=True)
