"""What `track` leaves in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bematist import __version__, config
from bematist.outputs import to_json

if TYPE_CHECKING:
    from bematist.cli.options import Reading
    from bematist.cli.placing import Placing
    from bematist.evaluate import Evaluation
    from bematist.floorplan import FloorPlan
    from bematist.recording import Reference
    from bematist.trajectory import Trajectory

FILES = ("trajectory.parquet", "trajectory.csv", "steps.csv", "summary.json", "config.toml", "evaluation.json", "report.html")
"""Names of the files in a folder of results."""


def write_results(
    folder: Path,
    trajectory: Trajectory,
    reading: Reading,
    placing: Placing,
    *,
    reference: Reference | None = None,
    evaluation: Evaluation | None = None,
    report: bool = True,
) -> dict[str, Any]:
    """Write trajectory.parquet, trajectory.csv, summary.json, config.toml, and report.html where asked for.

    `evaluation.json` stands beside them where there is a reference. Returns the summary.
    """
    from bematist.io.trajectory_files import write_steps, write_trajectory

    write_trajectory(trajectory, folder)
    if trajectory.steps is not None:
        write_steps(trajectory.steps, folder / "steps.csv")
    summary = trajectory.summary()
    if reference is not None:
        summary["reference"] = reference.source or trajectory.source
    (folder / "summary.json").write_text(to_json(summary), "utf-8")
    (folder / "config.toml").write_text(_config(trajectory, reading, placing), "utf-8")
    if evaluation is not None:
        (folder / "evaluation.json").write_text(to_json(evaluation.to_dict()), "utf-8")
    if report:
        write_page(folder / "report.html", [trajectory], reference, [evaluation] if evaluation else None, placing.plan)
    return summary


def write_page(
    path: Path,
    trajectories: Sequence[Trajectory],
    reference: Reference | None,
    evaluations: Sequence[Evaluation] | None,
    floor_plan: FloorPlan | None = None,
) -> None:
    """Write the report of one trajectory or of several over each other."""
    from bematist.report import write_report

    write_report(trajectories, path, reference=reference, evaluations=evaluations, floor_plan=floor_plan)


def _config(trajectory: Trajectory, reading: Reading, placing: Placing) -> str:
    return config.to_toml(
        {
            "version": __version__,
            "recording": trajectory.source,
            "method": trajectory.method,
            "reading": reading.table(),
            **placing.tables(),
            "parameters": trajectory.parameters,
        }
    )
