"""A still picture of paths: plan and height, for documents."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.floorplan import FloorPlan
from bematist.recording import Reference
from bematist.report import ground
from bematist.report.decimate import extreme_indices, path_indices
from bematist.report.overlay import evaluate_all, overlay, thinned
from bematist.report.subject import Subject, subjects
from bematist.report.waypoints import LABELLED, errors, few, strokes
from bematist.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bematist.evaluate import Align

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#6b5b2e", "#8a8f98")
"""The palette of the page (Okabe and Ito 2008)."""


def still_path(
    trajectories: Sequence[Trajectory],
    path_png: str | Path,
    reference: Reference | None = None,
    *,
    floor_plan: FloorPlan | None = None,
    align: Align = "yaw",
) -> None:
    """Draw paths in plan, and their height below, into a PNG, SVG or PDF file (by its suffix).

    The trajectories are laid over `reference` by `align` (yaw: turn and translation), in the frame of the one that fits it best; a
    reference of few points is drawn with their numbers and strokes to where the paths were then. `floor_plan` lies below.

    Raises
    ------
    UsageError
        No trajectory, or a suffix that is no picture.
    DataError
        A trajectory without samples, or the file cannot be written.
    """
    from matplotlib.figure import Figure

    from bematist.outputs import whole_file

    if not trajectories:
        raise UsageError("A picture needs at least one trajectory.")
    path = picture_path(path_png)
    if any(not len(t) for t in trajectories):
        raise DataError("A trajectory has no samples: there is nothing to draw.")
    drawn = subjects(trajectories)
    thin = None if reference is None else thinned(reference)
    judged = evaluate_all(trajectories, thin, align)
    laid = overlay(trajectories, thin, judged)
    local = laid.reference(reference)
    figure = Figure(figsize=(8, 7.5), layout="constrained")
    axes = list(figure.subplots(2, 1, height_ratios=[3.2, 1])) if any(s.trajectory.has_height for s in drawn) else [figure.subplots()]
    plan, height = axes[0], axes[1] if axes[1:] else None
    shown = [] if local is None else [local.position]
    for number, s in enumerate(drawn):
        p, _ = laid.path(number, s.trajectory.position, s.trajectory.covariance[:1])
        _draw(plan, height, s, p)
        shown.append(p)
        if local is not None:
            _draw_errors(plan, s, local, *errors(number, s, local, laid, judged[number]))
    _draw_reference(plan, height, local)
    _dress(plan, height, many=len(drawn) > 1 or local is not None)
    if floor_plan is not None:
        _draw_ground(plan, floor_plan, ground.view(shown))
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=150, format=path.suffix[1:].lower())


def picture_path(path: str | Path) -> Path:
    """The path of a picture. UsageError where its suffix is no picture's."""
    path = Path(path)
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise UsageError(f'{path}: a picture is written as .png, .svg or .pdf, not as "{path.suffix}".')
    return path


def _draw(plan: Axes, height: Axes | None, s: Subject, p: NDArray[np.float64]) -> None:
    t = s.trajectory
    color = COLORS[int(s.color[1:])]
    k = path_indices(p[:, :2], s.budget.plan)
    plan.plot(p[k, 0], p[k, 1], color=color, linewidth=1.2, label=s.name or t.method or "path")
    if s.alone:
        middle = t.stance_intervals().sum(1) // 2
        plan.plot(p[middle, 0], p[middle, 1], ".", color=color, markersize=3.5)
    if len(k):
        plan.plot(*p[k[0], :2], "o", color=color, markersize=7, markeredgecolor="white")
        plan.plot(*p[k[-1], :2], "s", color=color, markersize=7, markeredgecolor="white")
    if height is not None and t.has_height:
        k = extreme_indices(p[:, 2], 4000)
        height.plot(t.time[k], p[k, 2], color=color, linewidth=0.9)


def _draw_errors(plan: Axes, s: Subject, reference: Reference, rows: NDArray[np.integer], there: NDArray[np.float64]) -> None:
    if len(rows):
        color, name = (COLORS[1], "error at the reference") if s.alone else (COLORS[int(s.color[1:])], None)
        plan.plot(*strokes(reference.position[rows, :2], there).T, color=color, linewidth=1.1, label=name)


def _draw_ground(plan: Axes, floor_plan: FloorPlan, view: list[list[float]] | None) -> None:
    """The plan of the building below all, seen where the paths are."""
    west, south, east, north = floor_plan.bounds
    if floor_plan.image is not None:
        from PIL import Image

        picture = np.asarray(Image.open(io.BytesIO(floor_plan.image)).convert("RGBA"))
        plan.imshow(picture, extent=(west, east, south, north), zorder=0, interpolation="bilinear")
    plan.plot(*floor_plan.lines.T, color="#8a8f98", linewidth=0.8, zorder=1)
    for name, place in zip(floor_plan.names, floor_plan.places, strict=True):
        plan.plot(*place, "D", color="#8a8f98", markersize=3, zorder=1)
        plan.annotate(name, place, textcoords="offset points", xytext=(0, 4), ha="center", fontsize=7, color="#5f6872", clip_on=True)
    plan.set_aspect("equal", adjustable="datalim")
    if view is not None:
        plan.dataLim.set_points(np.transpose(view))
        plan.set_autoscale_on(True)
        plan.margins(0)


def _draw_reference(plan: Axes, height: Axes | None, reference: Reference | None) -> None:
    if reference is None:
        return
    p = reference.position
    points = few(reference)
    style = {"color": "black", "linewidth": 1.0, "linestyle": ":"}
    plan.plot(p[:, 0], p[:, 1], label="reference", marker="+" if points else None, markersize=4, **style)
    if points and len(p) <= LABELLED:
        for row in np.flatnonzero(np.isfinite(p[:, :2]).all(1)):
            plan.annotate(str(row + 1), (p[row, 0], p[row, 1]), textcoords="offset points", xytext=(4, 4), fontsize=8)
    if height is not None and np.isfinite(reference.time).any() and np.isfinite(p[:, 2]).any():
        height.plot(reference.time, p[:, 2], **style)


def _dress(plan: Axes, height: Axes | None, *, many: bool) -> None:
    plan.set(xlabel="east (m)", ylabel="north (m)")
    plan.set_aspect("equal", adjustable="datalim")
    dress(plan)
    if height is not None:
        height.set(xlabel="time (s)", ylabel="height (m)")
        dress(height)
    if many:
        plan.legend(frameon=False, fontsize=9)


def dress(axes: Axes) -> None:
    """Grid and frame of a plot, as all pictures have them."""
    axes.grid(color="#e3e6ea", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_axisbelow(True)
