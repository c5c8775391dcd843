"""`track` and `compare`: from a recording to paths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, progress, seconds, table, warn
from bematist.cli.options import Reading
from bematist.cli.results import write_page, write_results
from bematist.errors import UsageError
from bematist.outputs import results_folder, to_json

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation
    from bematist.recording import Recording, Reference
    from bematist.trajectory import Trajectory

DEFAULT_METHOD = "foot"
CONFIG_KEYS = ("version", "recording", "method", "reading", "parameters")

Heading = Annotated[
    float | None,
    typer.Option("--heading", help="Heading of the sensor's x axis at the start, degrees clockwise from North.", metavar="DEG"),
]


@dataclass(frozen=True)
class Job:
    """What is to be run: a method and the parameters that differ from its own."""

    method: str
    changes: Mapping[str, Any]

    def check(self) -> Job:
        """This job, when method and parameters exist and fit; a recording is only read after that."""
        from bematist.methods import find_method

        config.changed(find_method(self.method).parameters, self.changes)
        return self

    def run(self, recording: Recording, *, chunk: int | None = None, quiet: bool = False) -> Trajectory:
        """The trajectory of a recording."""
        from bematist.methods import find_method, track

        parameters = config.changed(find_method(self.method).parameters, self.changes)
        with progress(f"tracking with {self.method}", quiet=quiet) as tell:
            found = track(
                recording,
                self.method,
                config=parameters.model_dump(),
                chunk=chunk,
                progress=lambda done, total: tell(done / max(total, 1)),
            )
        return replace(found, warnings=tuple(dict.fromkeys([*recording.warnings, *found.warnings])))


def changes_from(stored: Mapping[str, Any], sets: list[str] | None, heading: float | None) -> dict[str, Any]:
    """Parameters of a stored configuration, then `--set`, then `--heading`."""
    north = {} if heading is None else {"initial": {"heading_deg": heading}}
    return config.merge(stored, config.assignments(sets or []), north)


def _stored(path: Path | None) -> dict[str, Any]:
    """The configuration file, its keys checked."""
    if path is None:
        return {}
    stored = config.read_toml(path)
    for key in stored:
        if key not in CONFIG_KEYS:
            raise UsageError(
                f'{path}: there is no key "{key}".{config.closest(key, CONFIG_KEYS)} A configuration holds method, [reading] '
                "and [parameters.…], as config.toml of any result does."
            )
    return stored


def _method(wanted: str | None, stored: Mapping[str, Any], path: Path | None) -> str:
    method = stored.get("method", wanted or DEFAULT_METHOD)
    if wanted and wanted != method:
        raise UsageError(
            f'{path} was written for the method "{method}", not "{wanted}". Leave out --method, or remove "method" and the '
            "parameters that are not yours from the file."
        )
    return method


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
    heading: Heading = None,
    chunk: Annotated[
        int | None,
        typer.Option("--chunk", min=1, help="Feed this many samples at a time; the result is the same.", metavar="N"),
    ] = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    reference: options.ReferencePath = None,
    quiet: options.Quiet = False,
) -> None:
    """Track a recording: its path, how sure it is, and a report.

    Writes trajectory.parquet, trajectory.csv, summary.json, config.toml (everything that was used; give it back with
    --config) and report.html.
    """
    stored = _stored(configuration)
    reading = Reading.given(format, columns, axes, units, clock, stored.get("reading"))
    changes = changes_from(stored.get("parameters", {}), sets, heading)
    job = Job(_method(method, stored, configuration), changes).check()
    folder = options.folder_for(recording, output_folder)
    with results_folder(folder) as place:
        data = reading.read(recording)
        truth = options.read_truth(reference, data)
        trajectory = job.run(data, chunk=chunk, quiet=quiet)
        evaluation = judge(trajectory, truth, required=reference is not None)
        trajectory = _noted(trajectory, evaluation)
        with progress("writing", quiet=quiet):
            summary = write_results(place, trajectory, reading, reference=truth, evaluation=_found(evaluation), report=report)
    if not quiet:
        output().print(_headline(summary), style="bold", soft_wrap=True)
        output().print(facts(summary_facts(summary, trajectory, _found(evaluation))))
        written = "report.html" if report else "trajectory.csv"
        output().print(f"Results in {folder}/, see {folder / written}", soft_wrap=True)
        warn(trajectory.warnings)


def judge(trajectory: Trajectory, truth: Reference | None, *, align: str = "yaw", required: bool = False) -> Evaluation | str | None:
    """The evaluation against the reference, None without one; why not, where a reference that came along does not fit."""
    if truth is None:
        return None
    from bematist.errors import DataError
    from bematist.evaluate import evaluate

    try:
        return evaluate(trajectory, truth, align=config.choose("alignment", align, options.ALIGNMENTS))  # pyright: ignore[reportArgumentType]
    except DataError as error:
        if required:
            raise
        return f"The reference that came with the recording was left out: {error}"


def _found(evaluation: Evaluation | str | None) -> Evaluation | None:
    return None if isinstance(evaluation, str) else evaluation


def _noted(trajectory: Trajectory, evaluation: Evaluation | str | None) -> Trajectory:
    if isinstance(evaluation, str):
        return replace(trajectory, warnings=(*trajectory.warnings, evaluation))
    return trajectory


def _headline(summary: Mapping[str, Any]) -> str:
    name = Path(summary["source"]).name or "recording"
    return f"{name} · {summary['method']} · {seconds(summary['duration_s'])}, {summary['samples']:,} samples"


def summary_facts(summary: Mapping[str, Any], trajectory: Trajectory, evaluation: Evaluation | None = None) -> list[tuple[str, str]]:
    """The summary for a person."""
    percent = f" ({summary['closure_percent']:.2f} % of it)" if summary["closure_percent"] is not None else ""
    east, north, up = summary["position_sd_m"]
    rows = [
        ("distance", f"{summary['distance_m']:,.2f} m"),
        ("start to end", f"{summary['closure_m']:,.2f} m{percent}"),
        ("height change", f"{summary['height_change_m']:+.2f} m"),
        ("sure to", f"± {east:.2f} m east, ± {north:.2f} m north, ± {up:.2f} m up at the end (one sigma)"),
        ("stance", f"{100 * summary['stance_fraction']:.0f} % of the time, {len(trajectory.stance_intervals())} phases"),
        ("processing", seconds(summary["processing_s"])),
    ]
    if evaluation is not None:
        rows.append(("against truth", error_text(evaluation)))
    return rows


def error_text(evaluation: Evaluation) -> str:
    """The error against the reference in one line."""
    found = evaluation.to_dict()
    text = f"{found['ate_rmse_2d_m']:.2f} m rms in plan"
    if found["ate_rmse_height_m"] is not None:
        text += f", {found['ate_rmse_height_m']:.2f} m in height"
    return f"{text} (aligned by {found['alignment']}, {found['rows']:,} points)"


@app.command()
def compare(
    recording: options.RecordingPath,
    methods: Annotated[str, typer.Option("--methods", "-m", help="Methods with commas between, or all.", metavar="A,B,C")] = "all",
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
    heading: Heading = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write report.html.")] = True,
    reference: options.ReferencePath = None,
    align: options.Align = "yaw",
    quiet: options.Quiet = False,
) -> None:
    """Track a recording by several methods, side by side.

    Writes comparison.csv, comparison.json, one report.html with the paths over each other, and each method's results in a
    folder of its name.
    """
    reading = Reading.given(format, columns, axes, units, clock)
    changes = changes_from({}, sets, heading)
    jobs = [Job(name, changes).check() for name in method_names(methods)]
    folder = options.folder_for(recording, output_folder, "-compare")
    with results_folder(folder) as place:
        data = reading.read(recording)
        truth = options.read_truth(reference, data)
        trajectories = [job.run(data, quiet=quiet) for job in jobs]
        judged = [judge(t, truth, align=align, required=reference is not None) for t in trajectories]
        trajectories = [_noted(t, e) for t, e in zip(trajectories, judged, strict=True)]
        rows = write_comparison(place, trajectories, [_found(e) for e in judged], reading, truth, report=report)
    if not quiet:
        output().print(comparison_table(rows))
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
    truth: Reference | None,
    *,
    report: bool = True,
) -> list[dict[str, Any]]:
    """Write the comparison and each method's results; returns its rows."""
    import polars as pl

    rows = []
    for trajectory, evaluation in zip(trajectories, evaluations, strict=True):
        own = folder / trajectory.method
        own.mkdir()
        write_results(own, trajectory, reading, reference=truth, evaluation=evaluation, report=False)
        rows.append(comparison_row(trajectory, evaluation))
    (folder / "comparison.json").write_text(to_json(rows), "utf-8")
    flat = [{k: v for k, v in row.items() if not isinstance(v, (list, dict))} for row in rows]
    pl.DataFrame(flat, infer_schema_length=None).write_csv(folder / "comparison.csv")
    if report:
        found = [e for e in evaluations if e is not None]
        write_page(folder / "report.html", trajectories, truth, found if len(found) == len(trajectories) else None)
    return rows


def comparison_row(trajectory: Trajectory, evaluation: Evaluation | None) -> dict[str, Any]:
    """Summary of one method, and its errors where there is a reference."""
    errors = {} if evaluation is None else evaluation.to_dict()
    shared = ("method", "closure_m", "closure_percent")
    row = trajectory.summary()
    row |= {("reference_distance_m" if k == "distance_m" else k): v for k, v in errors.items() if k not in shared}
    return row


def comparison_table(rows: list[dict[str, Any]]) -> Any:
    """Methods side by side."""
    columns = [
        ("distance m", "distance_m", "{:.2f}"),
        ("start to end m", "closure_m", "{:.2f}"),
        ("height m", "height_change_m", "{:+.2f}"),
        ("stance %", "stance_fraction", "{:.0%}"),
        ("rms plan m", "ate_rmse_2d_m", "{:.3f}"),
        ("rms height m", "ate_rmse_height_m", "{:.3f}"),
        ("end point m", "end_point_m", "{:.3f}"),
    ]
    shown = [c for c in columns if any(row.get(c[1]) is not None for row in rows)]
    aligned = rows[0].get("alignment")
    cells = [
        [row["method"], *(form.format(row[key]).rstrip("%") if row.get(key) is not None else "-" for _, key, form in shown)] for row in rows
    ]
    title = f"errors after alignment by {aligned}" if aligned else ""
    return table(["method", *(c[0] for c in shown)], cells, right=range(1, len(shown) + 1), title=title)
