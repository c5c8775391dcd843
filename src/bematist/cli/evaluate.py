"""`evaluate`: a trajectory against what is known of the truth."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from bematist import config
from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import output, table, warn
from bematist.outputs import to_json, whole_file


@app.command()
def evaluate(
    trajectory: Annotated[
        Path, typer.Argument(help="trajectory.csv, trajectory.parquet or the folder that holds it.", metavar="TRAJECTORY")
    ],
    reference: Annotated[Path, typer.Argument(help="The true path.", metavar="REFERENCE")],
    align: options.Align = "yaw",
    sync: Annotated[bool, typer.Option("--sync", help="First set the reference's clock by the motion.")] = False,
    json: Annotated[
        str | None, typer.Option("--json", help="Write the numbers as JSON to a file, or to stdout with -.", metavar="FILE|-")
    ] = None,
) -> None:
    """Compare a trajectory, or attitudes, with the truth.

    Position, length, heading and attitude errors, and whether the filter knew of them (NEES). Attitudes (attitude.csv,
    attitude.parquet or their folder) are aligned by none, yaw or frames.
    """
    kind = config.choose("alignment", align, (*options.ALIGNMENTS, "frames"))
    from bematist.attitudes import Attitude
    from bematist.evaluate import evaluate as compute
    from bematist.evaluate import evaluate_attitude
    from bematist.io import read_attitude, read_reference, read_trajectory
    from bematist.io.attitude_files import attitude_file
    from bematist.synchronise import sync as synchronised

    judged = read_attitude(trajectory) if attitude_file(trajectory) is not None else read_trajectory(trajectory)
    truth = read_reference(reference)
    if sync:
        shift = synchronised(judged, truth)
        truth = shift.apply(truth)
        ppm = 1e6 * shift.drift
        warn([f"The reference's clock was set by {shift.offset_s:+.3f} s, {ppm:+.1f} ppm (correlation {shift.correlation:.2f})."])
    if isinstance(judged, Attitude):
        found = evaluate_attitude(judged, truth, align=kind)  # pyright: ignore[reportArgumentType]
    else:
        found = compute(judged, truth, align=kind)  # pyright: ignore[reportArgumentType]
    text = to_json(found.to_dict())
    if json == "-":
        sys.stdout.write(text)
        return
    if json is not None:
        options.keep([trajectory, reference], [Path(json)])
        with whole_file(Path(json)) as place:
            place.write_text(text, "utf-8")
    output().print(table(("quantity", "value", "unit"), [(n, _text(v), unit) for n, v, unit in found.table()], right=[1]))
    warn(found.notes)


def _text(value: float | str) -> str:
    return f"{value:,.3f}" if isinstance(value, float) else f"{value:,}" if isinstance(value, int) else value
