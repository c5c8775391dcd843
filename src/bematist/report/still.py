"""A still picture of paths: plan and height, for documents."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.recording import Reference
from bematist.report.decimate import extreme_indices, path_indices
from bematist.report.overlay import evaluate_all, overlay, thinned
from bematist.report.subject import Subject, subjects
from bematist.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#6b5b2e", "#8a8f98")
"""The palette of the page (Okabe and Ito 2008)."""


def still_path(trajectories: Sequence[Trajectory], path_png: str | Path, reference: Reference | None = None) -> None:
    """Draw paths in plan, and their height below, into a PNG, SVG or PDF file (by its suffix).

    The trajectories are laid over `reference` by yaw and translation, in the frame of the one that fits it best.

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
    few = None if reference is None else thinned(reference)
    laid = overlay(trajectories, few, evaluate_all(trajectories, few))
    local = laid.reference(reference)
    figure = Figure(figsize=(8, 7.5), layout="constrained")
    plan, height = figure.subplots(2, 1, height_ratios=[3.2, 1])
    for number, s in enumerate(drawn):
        p, _ = laid.path(number, s.trajectory.position, s.trajectory.covariance[:1])
        _draw(plan, height, s, p)
    _draw_reference(plan, height, local)
    _dress(plan, height, many=len(drawn) > 1 or local is not None)
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=150, format=path.suffix[1:].lower())


def picture_path(path: str | Path) -> Path:
    """The path of a picture. UsageError where its suffix is no picture's."""
    path = Path(path)
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise UsageError(f'{path}: a picture is written as .png, .svg or .pdf, not as "{path.suffix}".')
    return path


def _draw(plan: Axes, height: Axes, s: Subject, p: NDArray[np.float64]) -> None:
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
    k = extreme_indices(p[:, 2], 4000)
    height.plot(t.time[k], p[k, 2], color=color, linewidth=0.9)


def _draw_reference(plan: Axes, height: Axes, reference: Reference | None) -> None:
    if reference is None:
        return
    p = reference.position
    few = len(p) <= 500
    style = {"color": "black", "linewidth": 1.0, "linestyle": ":"}
    plan.plot(p[:, 0], p[:, 1], label="reference", marker="+" if few else None, markersize=4, **style)
    if np.isfinite(reference.time).any() and np.isfinite(p[:, 2]).any():
        height.plot(reference.time, p[:, 2], **style)


def _dress(plan: Axes, height: Axes, *, many: bool) -> None:
    plan.set(xlabel="east (m)", ylabel="north (m)")
    plan.set_aspect("equal", adjustable="datalim")
    height.set(xlabel="time (s)", ylabel="height (m)")
    dress(plan)
    dress(height)
    if many:
        plan.legend(frameon=False, fontsize=9)


def dress(axes: Axes) -> None:
    """Grid and frame of a plot, as all pictures have them."""
    axes.grid(color="#e3e6ea", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_axisbelow(True)
