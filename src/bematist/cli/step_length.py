"""`step-length`: from walks of known length to the parameters of the step length."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, progress, warn
from bematist.cli.options import Reading
from bematist.errors import UsageError
from bematist.outputs import to_json, whole_file

if TYPE_CHECKING:
    from bematist.step_length import StepLengthCalibration


@app.command("step-length")
def step_length(
    recordings: Annotated[list[Path], typer.Argument(help="Walks with a sensor in the hand.", metavar="RECORDING...")],
    references: Annotated[
        list[Path] | None,
        typer.Option("--reference", help="The true path of a walk; once for each, in their order.", metavar="REFERENCE"),
    ] = None,
    distances: Annotated[
        list[float] | None, typer.Option("--distance", help="Or its length along the path, m; once for each.", metavar="M")
    ] = None,
    heights: Annotated[
        list[float] | None, typer.Option("--height", help="Height of the walker, m; once, or once for each.  [default: 1.75]", metavar="M")
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            "--model",
            help="scale: one factor; line: a and c; full: a, b and c, of walkers of several heights.",
            metavar="auto|scale|line|full",
        ),
    ] = "auto",
    method: Annotated[str, typer.Option("--method", "-m", help="Method whose steps and headings are used.", metavar="NAME")] = "hand",
    apart: Annotated[
        float, typer.Option("--apart", min=1.0, help="Fixes of a reference nearer than this are left out, s.", metavar="S")
    ] = 10.0,
    file: Annotated[Path, typer.Option("--output", "-o", help="File of the parameters.", metavar="FILE.toml")] = Path("step-length.toml"),
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Calibrate the step length on walks whose length is known.

    The length comes from --distance, from --reference (waypoints, GNSS, motion capture), or from the reference in the recording. Writes a
    file that "bematist track --method hand --config FILE.toml" takes.
    """
    from bematist.step_length import calibrate_steps

    reading = Reading.given(format, columns, axes, units, clock)
    options.keep([*recordings, *(references or [])], [file])
    for what, given in (("--reference", references), ("--distance", distances)):
        if given and len(given) != len(recordings):
            raise UsageError(f"There are {len(recordings)} recordings and {len(given)} {what}: give one for each.")
    with progress("reading", quiet=quiet):
        walks = [reading.read(path) for path in recordings]
        truths = [options.read_truth(path, walk) for path, walk in zip(references or [None] * len(walks), walks, strict=True)]
    with progress("walking", quiet=quiet):
        found = calibrate_steps(
            walks,
            truths,
            heights=1.75 if not heights else heights[0] if len(heights) == 1 else heights,
            distances=distances or None,
            model=model,
            method=method,
            stretch_s=apart,
        )
    with whole_file(file) as place:
        place.write_text(config.to_toml({"parameters": {"step_length": found.parameters()}}), "utf-8")
    if json:
        output().print(to_json(found.to_dict()), end="", soft_wrap=True)
    elif not quiet:
        output().print(facts(_rows(found)))
        output().print(f"Written: {file}; bematist track … -m {method} --config {file}", soft_wrap=True)
    if not quiet:
        warn(found.warnings)


def _rows(found: StepLengthCalibration) -> list[tuple[str, str]]:
    """What was found, for a person."""
    sds = found.covariance.diagonal() ** 0.5
    named = zip("abc", (found.a, found.b, found.c), sds, strict=True)
    values = [f"{name} = {value:.4f}" + (f" ± {sd:.4f}" if sd else "") for name, value, sd in named]
    steps = f"{found.distance_m:,.1f} m in {found.steps:.0f} steps"
    walked = f"{steps} on {found.stretches} stretch(es), {found.residual_m:.2f} m rms left over"
    return [
        ("model", found.model),
        ("parameters", ", ".join(values)),
        ("against published", f"{found.factor:.3f} ± {found.factor_sd:.3f} times as long"),
        ("walked", walked),
    ]
