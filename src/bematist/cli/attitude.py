"""`attitude`: from a recording to the sensor's attitude, without a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from bematist import __version__, config
from bematist.cli import options, site
from bematist.cli.app import app
from bematist.cli.console import output, progress, seconds, table, warn
from bematist.cli.job import Changes, configured, judged_by
from bematist.cli.options import Reading
from bematist.cli.site import Site
from bematist.errors import DataError
from bematist.outputs import results_folder, to_json

if TYPE_CHECKING:
    from bematist.attitudes import Attitude
    from bematist.evaluate import AttitudeEvaluation
    from bematist.evaluate.attitude import Align
    from bematist.recording import Recording, Reference

FILES = ("attitude.parquet", "attitude.csv", "summary.json", "config.toml", "evaluation.json", "report.html")
DEFAULT_FILTER = "madgwick"
ALIGNMENTS = ("none", "yaw", "frames")


@app.command()
def attitude(
    recording: options.RecordingPath,
    filter: Annotated[
        str | None, typer.Option("--filter", "-f", help="gyro, mahony, madgwick …  [default: madgwick]", metavar="NAME")
    ] = None,
    compare: Annotated[
        str | None, typer.Option("--compare", help="Further filters for the page and the table, with commas, or all.", metavar="A,B,C")
    ] = None,
    output_folder: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder of the results; without it, RECORDING-attitude.", metavar="DIR"),
    ] = None,
    configuration: Annotated[
        Path | None, typer.Option("--config", help="Parameters from a file, such as the config.toml of a result.", metavar="FILE.toml")
    ] = None,
    sets: options.Set = None,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    heading: options.Heading = None,
    origin: site.Origin = None,
    date: site.Date = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    reference: options.ReferencePath = None,
    align: Annotated[
        str,
        typer.Option(
            "--align",
            help="What is taken out before the comparison: the mean heading error (yaw), or a constant rotation on either side.",
            metavar="|".join(ALIGNMENTS),
        ),
    ] = "none",
    quiet: options.Quiet = False,
) -> None:
    """Tell the attitude of the sensor: heading, roll, pitch.

    Writes attitude.parquet, attitude.csv, summary.json, config.toml (everything that was used; give it back with --config)
    and report.html; where a true attitude is known, evaluation.json.
    """
    from bematist.ahrs import find_filter

    kind = cast("Align", config.choose("alignment", align, ALIGNMENTS))
    stored, name = configured(configuration, "filter", filter, DEFAULT_FILTER)
    reading = Reading.given(format, columns, axes, units, clock, stored.get("reading"), calibration=calibration, uncalibrated=uncalibrated)
    where = Site.given(origin, date)
    changes = {name: Changes.of(stored.get("parameters", {}), sets, heading, where)}
    changes |= {n: Changes.of({}, None, heading, where) for n in _others(compare, name)}
    changes[name].check(find_filter(name).parameters)
    folder = options.folder_for(recording, output_folder, "-attitude")
    options.keep([recording, reference], [folder / file for file in FILES])
    with results_folder(folder) as place:
        with progress("reading", quiet=quiet):
            data = reading.read(recording)
        truth = options.read_truth(reference, data)
        found = [_run(data, n, c, quiet=quiet) for n, c in changes.items()]
        judged = _judged(found, truth, kind, required=reference is not None)
        if isinstance(judged, str):
            found, judged = [replace(found[0], warnings=(*found[0].warnings, judged)), *found[1:]], []
        with progress("writing", quiet=quiet):
            _write(place, found, judged, reading, truth if judged else None, report=report)
    if not quiet:
        _show(found, judged)
        output().print(f"Results in {folder}/, see {folder / ('report.html' if report else 'attitude.csv')}", soft_wrap=True)
        warn(w for a in found for w in a.warnings)


def _others(text: str | None, name: str) -> list[str]:
    from bematist.ahrs import FILTERS, find_filter

    names = [part.strip() for part in (text or "").split(",") if part.strip()]
    names = list(FILTERS) if names == ["all"] else names
    return [find_filter(n).name for n in dict.fromkeys(names) if n != name]


def _run(data: Recording, name: str, changes: Changes, *, quiet: bool) -> Attitude:
    """The attitudes by one filter. DataError where it did not end in numbers."""
    import numpy as np

    from bematist.ahrs import attitude as compute
    from bematist.ahrs import find_filter

    with progress(f"{name}", quiet=quiet) as tell:
        used = changes.on(find_filter(name).parameters, data).model_dump()
        found = compute(data, name, config=used, earth=None, progress=lambda done, total: tell(done / max(total, 1)))
    lost = np.flatnonzero(~np.isfinite(found.attitude).all(1))
    if len(lost):
        raise DataError(
            f"{data.source}: the filter {name} diverged, the attitude is no number from {found.time[lost[0]]:.2f} s on. Check units and "
            "parameters."
        )
    return found


def _judged(found: Sequence[Attitude], truth: Reference | None, align: Align, *, required: bool) -> list[AttitudeEvaluation] | str:
    """One evaluation for each, none without a true attitude; why not, where a reference that came along does not fit."""
    from bematist.evaluate import evaluate_attitude

    if truth is None or (truth.attitude is None and not required):
        return []
    return judged_by(lambda: [evaluate_attitude(a, truth, align) for a in found], required=required)


def _write(
    folder: Path,
    found: Sequence[Attitude],
    judged: Sequence[AttitudeEvaluation],
    reading: Reading,
    truth: Reference | None,
    *,
    report: bool,
) -> None:
    from bematist.io import write_attitude

    first = found[0]
    write_attitude(first, folder)
    (folder / "summary.json").write_text(to_json(first.summary()), "utf-8")
    stored = {"version": __version__, "recording": first.source, "filter": first.filter, "reading": reading.table()}
    (folder / "config.toml").write_text(config.to_toml({**stored, "parameters": first.parameters}), "utf-8")
    if judged:
        (folder / "evaluation.json").write_text(to_json([e.to_dict() for e in judged]), "utf-8")
    if report:
        from bematist.report import write_attitude_page

        write_attitude_page(found, folder / "report.html", truth, judged)


def _show(found: Sequence[Attitude], judged: Sequence[AttitudeEvaluation]) -> None:
    """The filters side by side."""
    errors = ["attitude rms °", "heading rms °", "tilt rms °"] if judged else []
    rows = []
    for k, a in enumerate(found):
        s = a.summary()
        cells = [a.filter, a.north, f"{s['heading_start_deg']:.1f}", f"{s['heading_end_deg']:.1f}", seconds(a.processing_s)]
        if judged:
            d = judged[k].to_dict()
            cells += [f"{d[f'{key}_rmse_deg']:.2f}" for key in ("attitude", "heading", "tilt")]
        rows.append(cells)
    title = f"errors after alignment by {judged[0].align}" if judged else ""
    head = ["filter", "north", "heading start °", "end °", "processing", *errors]
    output().print(table(head, rows, right=range(2, len(head)), title=title))
