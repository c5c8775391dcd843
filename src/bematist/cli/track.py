"""`track`: from a recording to its path."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bematist.cli import options, placing, site
from bematist.cli.app import app
from bematist.cli.console import facts, output, progress, seconds, warn
from bematist.cli.job import Changes, Job, configured, found_in, judge, known_as, noted
from bematist.cli.options import Reading
from bematist.cli.results import FILES, write_results
from bematist.cli.site import Site
from bematist.outputs import results_folder

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation
    from bematist.trajectory import Trajectory

DEFAULT_METHOD = "foot"


@app.command()
def track(
    recording: options.RecordingPath,
    method: Annotated[
        str | None, typer.Option("--method", "-m", help='Method, see "bematist methods".  [default: foot]', metavar="NAME")
    ] = None,
    output_folder: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder of the results; without it, named after the recording.", metavar="DIR"),
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
    heading: placing.Heading = None,
    origin: site.Origin = None,
    date: site.Date = None,
    start: placing.Start = None,
    plan: placing.Map = None,
    map_scale: placing.MapScale = None,
    map_origin: placing.MapOrigin = None,
    map_rotation: placing.MapRotation = None,
    chunk: Annotated[
        int | None,
        typer.Option("--chunk", min=1, help="Feed this many samples at a time; the result is the same.", metavar="N"),
    ] = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    reference: options.ReferencePath = None,
    align: options.AlignOrPlaced = None,
    quiet: options.Quiet = False,
) -> None:
    """Track a recording: its path, how sure it is, and a report.

    Writes trajectory.parquet, trajectory.csv, summary.json, config.toml (everything that was used; give it back with
    --config) and report.html.
    """
    stored, name = configured(configuration, "method", method, DEFAULT_METHOD)
    reading = Reading.given(format, columns, axes, units, clock, stored.get("reading"), calibration=calibration, uncalibrated=uncalibrated)
    changes = Changes.of(stored.get("parameters", {}), sets, placing.heading_deg(heading), Site.given(origin, date))
    lies = placing.Placing.given(start, heading, plan, map_scale, map_origin, map_rotation, stored)
    kind = lies.alignment(align)
    job = Job(name, changes).check()
    folder = options.folder_for(recording, output_folder)
    options.keep([recording, reference, plan], [folder / name for name in FILES])
    with results_folder(folder) as place:
        with progress("reading", quiet=quiet):
            data = reading.read(recording)
        truth = options.read_truth(reference, data)
        trajectory = job.run(data, chunk=chunk, quiet=quiet)
        lies = lies.settled(trajectory, truth)
        trajectory = lies.place(trajectory)
        evaluation = judge(trajectory, truth, align=kind, required=reference is not None)
        trajectory = noted(trajectory, evaluation)
        with progress("writing", quiet=quiet):
            summary = write_results(place, trajectory, reading, lies, reference=truth, evaluation=found_in(evaluation), report=report)
    if not quiet:
        output().print(_headline(summary), style="bold", soft_wrap=True)
        told = [] if truth is None else [("truth", known_as(truth, reference is not None))]
        output().print(facts([*summary_facts(summary, trajectory, found_in(evaluation)), *told]))
        written = "report.html" if report else "trajectory.csv"
        output().print(f"Results in {folder}/, see {folder / written}", soft_wrap=True)
        warn(trajectory.warnings)


def _headline(summary: Mapping[str, Any]) -> str:
    name = Path(summary["source"]).name or "recording"
    return f"{name} · {summary['method']} · {seconds(summary['duration_s'])}, {summary['samples']:,} samples"


def summary_facts(summary: Mapping[str, Any], trajectory: Trajectory, evaluation: Evaluation | None = None) -> list[tuple[str, str]]:
    """The summary for a person."""
    from bematist.hard_iron import words
    from bematist.trajectory import NORTH

    percent = f" ({summary['closure_percent']:.2f} % of it)" if summary["closure_percent"] is not None else ""
    east, north, up = summary["position_sd_m"]
    above = f", ± {up:.2f} m up" if trajectory.has_height else ""
    start = [round(v, 2) for v in summary["start_m"]]
    rows = [
        ("distance", f"{summary['distance_m']:,.2f} m"),
        *([("start", f"{start[0]:,.2f} m east, {start[1]:,.2f} m north, {start[2]:,.2f} m up")] if any(start) else []),
        ("start to end", f"{summary['closure_m']:,.2f} m{percent}"),
        risen(summary, trajectory),
        ("north", ", ".join(NORTH[summary["north"]])),
        ("sure to", f"± {east:.2f} m east, ± {north:.2f} m north{above} at the end (one sigma)"),
        feet(summary, trajectory),
        *([("hard iron", words(summary["hard_iron"]))] if "hard_iron" in summary else []),
        ("processing", seconds(summary["processing_s"])),
    ]
    if evaluation is not None:
        rows.append(("against truth", error_text(evaluation)))
    return rows


def risen(summary: Mapping[str, Any], trajectory: Trajectory) -> tuple[str, str]:
    """The change of height, or why there is none, for a person."""
    if trajectory.has_height:
        return "height change", f"{summary['height_change_m']:+.2f} m"
    return "height", "unknown, for no barometer told it; steps on stairs count as steps on level ground"


def feet(summary: Mapping[str, Any], trajectory: Trajectory) -> tuple[str, str]:
    """The stances of a shoe or the steps of a hand's path, for a person."""
    steps = trajectory.steps
    if steps is None:
        return "stance", f"{100 * summary['stance_fraction']:.0f} % of the time, {len(trajectory.stance_intervals())} phases"
    if not len(steps):
        return "steps", "none"
    height = trajectory.parameters["step_length"]["height"]
    return "steps", f"{len(steps)} of {steps.length.mean():.2f} m on average, for a height of {height:g} m (step_length.height)"


def error_text(evaluation: Evaluation) -> str:
    """The error against the reference in one line."""
    found = evaluation.to_dict()
    text = f"{found['ate_rmse_2d_m']:.2f} m rms in plan"
    if found["ate_rmse_height_m"] is not None:
        text += f", {found['ate_rmse_height_m']:.2f} m in height"
    return f"{text} (aligned by {evaluation.alignment}, {found['rows']:,} points)"
