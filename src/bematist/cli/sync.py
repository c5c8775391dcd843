"""`sync`: the clocks of two recordings, or of a recording and its reference."""

from __future__ import annotations

import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, progress
from bematist.cli.options import Reading
from bematist.errors import UsageError
from bematist.outputs import to_json


@app.command()
def sync(
    recording: options.RecordingPath,
    other: Annotated[Path | None, typer.Argument(help="Another recording of the same motion.", metavar="[OTHER]")] = None,
    reference: options.ReferencePath = None,
    out: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the other one on the recording's clock, .csv or .parquet.", metavar="FILE")
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Find offset and drift between two clocks.

    Of another recording, of --reference, or without either of the reference that came with the recording.
    """
    if other is not None and reference is not None:
        raise UsageError("Give another recording or --reference, not both.")
    options.keep([recording, other, reference], [out] if out else [])
    from bematist.io import write_recording, write_reference
    from bematist.recording import Recording
    from bematist.synchronise import sync as compute

    with progress("reading", quiet=quiet):
        a = Reading().read(recording)
        b = Reading().read(other) if other is not None else options.read_truth(reference, a)
    if b is None:
        raise UsageError(f"{recording} came without a reference: name another recording, or --reference.")
    found = compute(a, b)
    if out is not None:
        if isinstance(b, Recording):
            write_recording(found.apply(b), out)
        else:
            write_reference(found.apply(b), out)
    if json:
        sys.stdout.write(to_json(asdict(found)))
    elif not quiet:
        sure = "" if math.isnan(found.sd_s) else f" ± {1e3 * found.sd_s:.1f} ms"
        drift = "not known, too short" if math.isnan(found.drift_sd) else f"{1e6 * found.drift:+.1f} ± {1e6 * found.drift_sd:.1f} ppm"
        rows = [
            ("offset", f"{found.offset_s:+.4f} s{sure}, to be added to the other's times"),
            ("drift", drift + (", taken for none" if found.drift == 0 and not math.isnan(found.drift_sd) else "")),
            ("correlation", f"{found.correlation:.3f} of the {found.quantity}, next peak {found.second:.3f}, over {found.overlap_s:.1f} s"),
        ]
        output().print(facts(rows))
