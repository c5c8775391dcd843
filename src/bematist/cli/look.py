"""`methods`, `info`, `stance`: what there is, before anything is tracked."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, table, warn
from bematist.cli.options import Reading
from bematist.errors import UsageError
from bematist.outputs import to_json, whole_file


@app.command()
def methods(json: options.Json = False) -> None:
    """List the methods: where they come from, what for."""
    from bematist.methods import METHODS

    keys = ("name", "worn", "summary", "paper", "equations")
    found = [{key: getattr(method, key) for key in keys} for method in METHODS.values()]
    if json:
        sys.stdout.write(to_json(found))
        return
    # Two columns, which a terminal of 80 characters can hold.
    rows = [(row["name"], f"{row['summary']}\n{row['paper']}: {row['equations']}") for row in found]
    output().print(table(("method", "what it is, and where it is from"), rows, apart=True))


@app.command()
def info(
    recording: options.RecordingPath,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    json: options.Json = False,
) -> None:
    """Tell what is in a recording.

    Sensors and their rates, gaps, jitter, saturation, rest, units and why they were taken for what they are.
    """
    from bematist.inspect import describe, lines

    data = Reading.given(format, columns, axes, units, clock, calibration=calibration, uncalibrated=uncalibrated).read(recording)
    found = describe(data)
    if json:
        sys.stdout.write(to_json(found))
        return
    output().print(facts(line for line in lines(found) if line[0] != "warning"))
    warn(data.warnings)


@app.command()
def stance(
    recording: options.RecordingPath,
    page: Annotated[
        Path | None, typer.Option("--output", "-o", help="The page; without it RECORDING-stance.html.", metavar="FILE.html")
    ] = None,
    method: Annotated[str, typer.Option("--method", "-m", help="The method whose detector is shown.", metavar="NAME")] = "foot",
    detector: Annotated[
        str | None, typer.Option("--detector", help="Test statistic: shoe, ared, amvd, amag or gyro.", metavar="NAME")
    ] = None,
    sets: Annotated[
        list[str] | None,
        typer.Option("--set", help="Change a parameter of the detector, such as threshold=200.", metavar="NAME=VALUE"),
    ] = None,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    quiet: options.Quiet = False,
) -> None:
    """Draw a stance detector's verdict over the signals.

    A page with statistic, threshold and verdict, to choose a threshold by eye.
    """
    from bematist.methods import find_method
    from bematist.stance import DETECTORS, analyse

    changes = config.assignments(sets or [])
    changes = changes.pop("stance", {}) | changes  # "stance.threshold" as for `track`, or "threshold"
    if detector is not None:
        changes["detector"] = config.choose("detector", detector, DETECTORS)
    own = getattr(find_method(method).parameters, "stance", None)
    if own is None:
        raise UsageError(f'The method "{method}" counts steps and detects no stance: see `bematist steps`, or choose one for a shoe.')
    parameters = own.override(config.with_rule({"stance": changes})["stance"])
    data = Reading.given(format, columns, axes, units, clock, calibration=calibration, uncalibrated=uncalibrated).read(recording)
    found = analyse(data, parameters)
    path = page or Path(f"{recording.resolve().stem}-stance.html")
    options.keep([recording], [path])
    with whole_file(path) as place:
        from bematist.report import write_stance_page

        write_stance_page(data, found, place)
    if quiet:
        return
    stands = found.stance.astype(bool)
    phases = int(stands[0]) + int((stands[1:] & ~stands[:-1]).sum())
    rule = f"relative, ratio {parameters.ratio:g}" if parameters.rule == "relative" else f"threshold {parameters.limit:g}"
    if parameters.rule == "adaptive":
        rule += ", that of walking: only the filter knows the speed"
    output().print(
        facts(
            [
                ("detector", f"{parameters.detector}, {rule}, window {parameters.window:g} s"),
                ("stance", f"{100 * stands.mean():.0f} % of the time, {phases} phases"),
                ("page", str(path)),
            ]
        )
    )
    warn(data.warnings)
