"""`bematist demo`: a simulated walk, tracked by three methods, against its own truth."""

from __future__ import annotations

from pathlib import Path

from bematist.cli.compare import comparison_table, write_comparison
from bematist.cli.console import output, progress, warn
from bematist.cli.job import Job, judge
from bematist.cli.options import Reading
from bematist.cli.placing import Placing
from bematist.outputs import results_folder

METHODS = ("foot", "zupt", "maginav")


def run(folder: Path, scenario: str, seed: int, *, quiet: bool = False) -> None:
    """Simulate, track, compare; the folder then holds recording.csv, truth.csv, report.html and each method's results."""
    from bematist.io import read, write_recording, write_reference
    from bematist.placement import Placement
    from bematist.simulate import simulate

    with results_folder(folder) as place:
        with progress("simulating a walk", quiet=quiet):
            walk = simulate(scenario, "lsm9ds1", seed)
            write_recording(walk, place / "recording.csv")
        assert walk.reference is not None
        write_reference(walk.reference, place / "truth.csv")
        # What is tracked is the file, as a user's recording would be.
        data = read(place / "recording.csv").replace(source="recording.csv")
        trajectories = [Job(name).run(data, quiet=quiet) for name in METHODS]
        evaluations = [judge(t, walk.reference, align="none") for t in trajectories]
        found = [e for e in evaluations if e is not None and not isinstance(e, str)]
        with progress("drawing", quiet=quiet):
            rows = write_comparison(place, trajectories, list(found), Reading(), [Placing(Placement())] * len(METHODS), walk.reference)
    if quiet:
        return
    output().print(f"A simulated walk of {rows[0]['reference_distance_m']:.0f} m in {walk.duration_s / 60:.0f} minutes, by three methods:")
    output().print(comparison_table(rows))
    output().print(f"Open {(folder / 'report.html').resolve()} in a browser.", soft_wrap=True)
    warn(f"{t.method}: {text}" for t in trajectories for text in t.warnings)
