"""`steps`: what the step detector makes of a recording."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, warn
from bematist.cli.options import Reading
from bematist.outputs import to_json, whole_file

if TYPE_CHECKING:
    from bematist.steps import StepAnalysis


@app.command()
def steps(
    recording: options.RecordingPath,
    page: Annotated[
        Path | None, typer.Option("--output", "-o", help="The page; without it RECORDING-steps.html.", metavar="FILE.html")
    ] = None,
    sets: Annotated[
        list[str] | None,
        typer.Option("--set", help="Change a parameter of the detector, such as detection.periodic=0.3.", metavar="NAME=VALUE"),
    ] = None,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    calibration: options.Calibration = None,
    uncalibrated: options.Uncalibrated = False,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Count the steps of a handheld sensor, and show why.

    A page with the signal, the steps and the features by which motion (walking, running, stairs) and carrying (texting, phoning,
    swinging, pocket, bag) are told apart.
    """
    from bematist.steps import StepParameters, analyse

    changes = config.assignments(sets or [])
    changes = changes.pop("steps", {}) | changes  # "steps.detection.periodic" as for `track`, or "detection.periodic"
    parameters = StepParameters().override(changes)
    data = Reading.given(format, columns, axes, units, clock, calibration=calibration, uncalibrated=uncalibrated).read(recording)
    found = analyse(data, parameters)
    path = page or Path(f"{recording.resolve().stem}-steps.html")
    options.keep([recording], [path])
    with whole_file(path) as place:
        from bematist.report import write_steps_page

        write_steps_page(data, found, place)
    if json:
        sys.stdout.write(to_json(summary(found) | {"page": str(path)}))
    elif not quiet:
        stairs = [] if len(data.pressure_time) else [("stairs", "cannot be told from level ground: the recording has no barometer")]
        output().print(facts([*lines(found), *stairs, ("page", str(path))]))
        warn(data.warnings)


def summary(found: StepAnalysis) -> dict[str, Any]:
    """Numbers of an analysis: how many steps, and shares of the time in motion, of the steps in carrying."""
    import numpy as np

    from bematist.steps import CARRYING, MOTIONS

    n = len(found.event_time)
    return {
        "steps": n,
        "walks": int((np.diff(found.motion > 0, prepend=False) & (found.motion > 0)).sum()),
        "frequency_hz": float(found.event_frequency.mean()) if n else None,
        "motion": {name: float((found.motion == k).mean()) for k, name in enumerate(MOTIONS)},
        "carrying": {name: float((found.event_carrying == k).mean()) if n else 0.0 for k, name in enumerate(CARRYING)},
    }


def lines(found: StepAnalysis) -> list[tuple[str, str]]:
    """The same for a person."""
    numbers = summary(found)
    if not numbers["steps"]:
        return [("steps", "none")]
    shares = {
        key: ", ".join(f"{name} {100 * share:.0f} %" for name, share in numbers[key].items() if share) for key in ("motion", "carrying")
    }
    return [
        ("steps", f"{numbers['steps']} at {numbers['frequency_hz']:.2f} Hz on average, in {numbers['walks']} walk(s)"),
        ("motion", shares["motion"] + " of the time"),
        ("carrying", shares["carrying"] + " of the steps"),
    ]
