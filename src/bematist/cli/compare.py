"""`compare`: several methods on one recording, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bematist.cli import options, placing, site
from bematist.cli.app import app
from bematist.cli.console import output, progress, table, warn
from bematist.cli.job import Changes, Job, found_in, judge, known_as, noted
from bematist.cli.options import Reading
from bematist.cli.placing import Placing
from bematist.cli.results import write_page, write_results
from bematist.cli.site import Site
from bematist.errors import UsageError
from bematist.outputs import results_folder, to_json

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation
    from bematist.recording import Reference
    from bematist.trajectory import Trajectory


@app.command()
def compare(
    recording: options.RecordingPath,
    methods: Annotated[
        str | None,
        typer.Option(
            "--methods",
            "-m",
            help="Methods with commas between, or all.  [default: those for a shoe, of a phone those for a hand]",
            metavar="A,B,C",
        ),
    ] = None,
    output_folder: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder of the results; without it, RECORDING-compare.", metavar="DIR"),
    ] = None,
    sets: options.Set = None,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    heading: placing.Heading = None,
    origin: site.Origin = None,
    date: site.Date = None,
    start: placing.Start = None,
    plan: placing.Map = None,
    map_scale: placing.MapScale = None,
    map_origin: placing.MapOrigin = None,
    map_rotation: placing.MapRotation = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    reference: options.ReferencePath = None,
    align: options.AlignOrPlaced = None,
    quiet: options.Quiet = False,
) -> None:
    """Track a recording by several methods, side by side.

    Writes comparison.csv, comparison.json, one report.html with the paths over each other, and each method's results in a
    folder of its name.
    """
    from bematist.methods import worn

    lies = placing.Placing.given(start, heading, plan, map_scale, map_origin, map_rotation)
    kind = lies.alignment(align)
    reading = Reading.given(format, columns, axes, units, clock, calibration=calibration, uncalibrated=uncalibrated)
    changes = Changes.of({}, sets, placing.heading_deg(heading), Site.given(origin, date))
    named = [Job(name, changes).check() for name in method_names(methods)] if methods is not None else None
    folder = options.folder_for(recording, output_folder, "-compare")
    options.keep([recording, reference, plan], [folder / name for name in ("comparison.csv", "comparison.json", "report.html")])
    with results_folder(folder) as place:
        with progress("reading", quiet=quiet):
            data = reading.read(recording)
        truth = options.read_truth(reference, data)
        jobs = named if named is not None else [Job(name, changes).check() for name in worn("hand" if data.phone else "shoe")]
        trajectories = [job.run(data, quiet=quiet) for job in jobs]
        settled = [lies.settled(t, truth) for t in trajectories]
        trajectories = [s.place(t) for s, t in zip(settled, trajectories, strict=True)]
        judged = [judge(t, truth, align=kind, required=reference is not None) for t in trajectories]
        trajectories = [noted(t, e) for t, e in zip(trajectories, judged, strict=True)]
        rows = write_comparison(place, trajectories, [found_in(e) for e in judged], reading, settled, truth, report=report)
    if not quiet:
        output().print(comparison_table(rows))
        if truth is not None:
            output().print(f"Truth: {known_as(truth, reference is not None)}", soft_wrap=True)
        output().print(f"Results in {folder}/" + (f", see {folder / 'report.html'}" if report else ""), soft_wrap=True)
        warn(f"{t.method}: {text}" if text not in data.warnings else text for t in trajectories for text in t.warnings)


def method_names(text: str) -> list[str]:
    """Methods of a list with commas; "all" is every one.

    Raises
    ------
    UsageError
        The list is empty, or a name is unknown.
    """
    from bematist.methods import METHODS, find_method

    names = list(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))
    if names == ["all"]:
        return list(METHODS)
    if not names:
        raise UsageError(f"--methods {text!r}: name at least one of {', '.join(METHODS)}, with commas between.")
    return [find_method(name).name for name in names]


def write_comparison(
    folder: Path,
    trajectories: list[Trajectory],
    evaluations: list[Evaluation | None],
    reading: Reading,
    lies: Sequence[Placing],
    truth: Reference | None,
    *,
    report: bool = True,
) -> list[dict[str, Any]]:
    """Write the comparison and each method's results; returns its rows."""
    import polars as pl

    rows = []
    for trajectory, evaluation, placed in zip(trajectories, evaluations, lies, strict=True):
        own = folder / trajectory.method
        own.mkdir()
        write_results(own, trajectory, reading, placed, reference=truth, evaluation=evaluation, report=False)
        rows.append(comparison_row(trajectory, evaluation))
    (folder / "comparison.json").write_text(to_json(rows), "utf-8")
    flat = [{k: v for k, v in row.items() if not isinstance(v, (list, dict))} for row in rows]
    pl.DataFrame(flat, infer_schema_length=None).write_csv(folder / "comparison.csv")
    if report:
        found = [e for e in evaluations if e is not None]
        write_page(folder / "report.html", trajectories, truth, found if len(found) == len(trajectories) else None, lies[0].plan)
    return rows


def comparison_row(trajectory: Trajectory, evaluation: Evaluation | None) -> dict[str, Any]:
    """Summary of one method, and its errors where there is a reference."""
    errors = {} if evaluation is None else evaluation.to_dict()
    shared = ("method", "closure_m", "closure_percent")
    row = trajectory.summary()
    return row | {k: v for k, v in errors.items() if k not in shared}


def comparison_table(rows: list[dict[str, Any]]) -> Any:
    """Methods side by side."""
    columns = [
        ("distance m", "distance_m", "{:.2f}"),
        ("start to end m", "closure_m", "{:.2f}"),
        ("height m", "height_change_m", "{:+.2f}"),
        ("stance %", "stance_fraction", "{:.0%}"),
        ("steps", "steps", "{:d}"),
        ("rms plan m", "ate_rmse_2d_m", "{:.3f}"),
        ("rms height m", "ate_rmse_height_m", "{:.3f}"),
        ("end point m", "end_point_m", "{:.3f}"),
    ]
    shown = [c for c in columns if any(row.get(c[1]) is not None for row in rows)]
    aligned = rows[0].get("alignment")
    mirrored = [row["method"] for row in rows if row.get("mirrored")]
    mirror = f"; the reference mirrored for {', '.join(mirrored) if len(mirrored) < len(rows) else 'all'}" if mirrored else ""
    cells = [
        [row["method"], *(form.format(row[key]).rstrip("%") if row.get(key) is not None else "-" for _, key, form in shown)] for row in rows
    ]
    title = f"errors after alignment by {aligned}{mirror}" if aligned else ""
    return table(["method", *(c[0] for c in shown)], cells, right=range(1, len(shown) + 1), title=title)
