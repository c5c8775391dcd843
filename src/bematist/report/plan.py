"""The path in plan: equal axes, stance points, uncertainty ellipses, reference, start and end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.floorplan import FloorPlan
from bematist.recording import Reference
from bematist.report import ground
from bematist.report.decimate import path_indices
from bematist.report.overlay import Overlay
from bematist.report.subject import Subject
from bematist.report.traces import Trace, encode, text
from bematist.report.waypoints import reference_traces
from bematist.trajectory import PACKED

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation

Array = NDArray[np.float64]

ELLIPSES = 20
"""Uncertainty ellipses along a path that is drawn alone; beside others each has one, at its end."""

RADIUS_95 = 2.4477
"""Radius of the 95 % region of two normal variables, in standard deviations: sqrt of the chi-square quantile 5.991."""

SHOWN_STANCES = 1500

RINGS = 250
"""Up to this many stances are drawn as rings; more would be a tube around the path and are drawn as smaller dots."""

SWING_POINTS = 6
"""Points of a swing, its ends included, that stay in the drawn path."""


def plan(
    drawn: Sequence[Subject],
    reference: Reference | None,
    overlay: Overlay,
    evaluations: Sequence[Evaluation | None] = (),
    floor_plan: FloorPlan | None = None,
) -> list[Trace]:
    """Traces of the plan, lowest first. `reference` is in the frame of the page; evaluations: one for each trajectory, or none.

    The traces with `meta` "path" carry the time of each point as `customdata`: the page moves its cursor along them.
    """
    below, paths, above = [], [], []
    for number, s in enumerate(drawn):
        chosen = _instants(s)
        p, P = overlay.path(number, s.trajectory.position, s.trajectory.packed_covariance[chosen][:, PACKED])
        if not np.isfinite(p[:, :2]).all(1).any():
            continue
        below += _ellipses(s, p[chosen, :2], P[:, :2, :2])
        paths.append(_path(s, p))
        above += _stances(s, p) if s.alone else []
        above += _ends(s, p)
    known = reference_traces(drawn, reference, overlay, evaluations or [None] * len(drawn))
    return ground.lines(floor_plan) + below + known + paths + above


def _instants(s: Subject) -> NDArray[np.int64]:
    """Samples whose ellipse is drawn."""
    last = len(s.trajectory) - 1
    middle = s.trajectory.stance_intervals().sum(1) // 2
    if not s.alone or not len(middle):
        return np.array([last])
    spread = np.linspace(0, len(middle) - 1, min(ELLIPSES, len(middle))).round().astype(int)
    return np.unique(np.append(middle[spread], last))


def _path(s: Subject, p: Array) -> Trace:
    # Stances keep their ends and swings some points between, so that a place can be found from its time by interpolation.
    spans = s.trajectory.stance_intervals()
    spans = spans[:: max(1, len(spans) * SWING_POINTS // s.budget.plan)] - np.array([0, 1])
    lift, land = np.append(0, spans[:, 1]), np.append(spans[:, 0], len(p) - 1)
    edges = np.linspace(lift, land, SWING_POINTS).astype(np.int64).ravel()
    k = path_indices(p[:, :2], s.budget.plan, edges)
    return {
        "type": "scatter",
        "mode": "lines",
        "meta": "path",
        "x": encode(p[k, 0]),
        "y": encode(p[k, 1]),
        "customdata": encode(s.trajectory.time[k]),
        "name": text(s.name or "path"),
        "line": {"color": s.color, "width": 1.6},
        "hovertemplate": "%{customdata:.2f} s<br>east %{x:.2f} m<br>north %{y:.2f} m",
    }


def _stances(s: Subject, p: Array) -> list[Trace]:
    middle = s.trajectory.stance_intervals().sum(1) // 2
    middle = middle[:: -(-len(middle) // SHOWN_STANCES) or 1]
    if not len(middle):
        return []
    # A ring is a dot with a smaller one on it; see `traces.dots`.
    common = {
        "type": "scatter",
        "mode": "lines",
        "meta": "dots",
        "x": encode(p[middle, 0]),
        "y": encode(p[middle, 1]),
        "customdata": encode(s.trajectory.time[middle]),
        "connectgaps": False,
    }
    hover = f"{s.footing}, " + "%{customdata:.2f} s<br>east %{x:.2f} m<br>north %{y:.2f} m"
    ring = {**common, "name": s.footing, "line": {"color": s.color, "width": 6, "simplify": False}, "hovertemplate": hover}
    hole = {**common, "line": {"color": "@surface", "width": 3, "simplify": False}, "hoverinfo": "skip", "showlegend": False}
    if len(middle) > RINGS:
        return [{**ring, "line": {**ring["line"], "width": 3.5}}]
    return [{**ring, "legendgroup": s.footing}, {**hole, "legendgroup": s.footing}]


def _ends(s: Subject, p: Array) -> list[Trace]:
    good = np.flatnonzero(np.isfinite(p[:, :2]).all(1))
    found = []
    for k, name, symbol, fill in ((good[0], "start", "circle", "@2"), (good[-1], "end", "square", "@1")):
        color = fill if s.alone else s.color
        found.append(
            {
                "type": "scatter",
                "mode": "markers",
                "x": [float(p[k, 0])],
                "y": [float(p[k, 1])],
                "customdata": [float(s.trajectory.time[k])],
                "name": name,
                "showlegend": s.alone,
                "marker": {"color": color, "size": 11, "symbol": symbol, "line": {"color": "@surface", "width": 1.5}},
                "hovertemplate": f"{name}{' of ' + text(s.name) if s.name else ''}, "
                "%{customdata:.2f} s<br>east %{x:.2f} m<br>north %{y:.2f} m",
            }
        )
    return found


def _ellipses(s: Subject, centre: Array, covariance: Array) -> list[Trace]:
    """95 % ellipses (K) around centres (K,2), as one trace of closed outlines."""
    good = np.isfinite(centre).all(1) & np.isfinite(covariance).all((1, 2))
    if not good.any():
        return []
    variance, axes = np.linalg.eigh(covariance[good])
    angle = np.linspace(0, 2 * np.pi, 49)
    unit = np.stack([np.cos(angle), np.sin(angle)])
    shape = axes @ (np.sqrt(np.maximum(variance, 0))[:, :, None] * unit) * RADIUS_95
    outline = np.full((good.sum(), 50, 2), np.nan)
    outline[:, :49] = centre[good][:, None] + shape.transpose(0, 2, 1)
    x, y = outline.reshape(-1, 2).T
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "x": encode(x),
            "y": encode(y),
            "name": "95 % ellipse",
            "showlegend": s.alone,
            "line": {"color": f"{s.color}/0.55", "width": 1},
            "fill": "toself",
            "fillcolor": f"{s.color}/0.12",
            "hoverinfo": "skip",
        }
    ]
