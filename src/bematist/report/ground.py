"""What lies below the paths: the plan of the building, as a picture or as lines."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.floorplan import FloorPlan
from bematist.report.traces import Trace, encode, text

Array = NDArray[np.float64]

MARGIN = 0.12
"""Room around the paths in the first view, relative to their larger extent."""


def lines(plan: FloorPlan | None) -> list[Trace]:
    """Lines and named points of the plan, to be drawn below the paths."""
    found: list[Trace] = []
    if plan is None:
        return found
    if len(plan.lines):
        found.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": encode(plan.lines[:, 0]),
                "y": encode(plan.lines[:, 1]),
                "name": "plan",
                "line": {"color": "@muted", "width": 1.2},
                "connectgaps": False,
                "hoverinfo": "skip",
            }
        )
    if len(plan.places):
        found.append(
            {
                "type": "scatter",
                "mode": "markers+text",
                "x": encode(plan.places[:, 0]),
                "y": encode(plan.places[:, 1]),
                "text": [text(name) for name in plan.names],
                "textposition": "top center",
                "textfont": {"color": "@muted", "size": 11},
                "marker": {"color": "@muted", "size": 5, "symbol": "diamond"},
                "name": "places of the plan",
                "showlegend": not len(plan.lines),
                "hovertemplate": "%{text}<br>east %{x:.2f} m<br>north %{y:.2f} m<extra></extra>",
            }
        )
    return found


def image(plan: FloorPlan | None) -> dict[str, Any] | None:
    """The picture as plotly lays it under a plot: the data are in the page itself."""
    if plan is None or plan.image is None:
        return None
    west, south, east, north = plan.bounds
    return {
        "source": f"data:image/{plan.media};base64,{base64.b64encode(plan.image).decode('ascii')}",
        "x": west,
        "y": north,
        "sizex": east - west,
        "sizey": north - south,
        "xref": "x",
        "yref": "y",
        "sizing": "stretch",
        "layer": "below",
    }


def view(points: Sequence[Array]) -> list[list[float]] | None:
    """Ranges of east and north, m, that show the paths with some room, however large a plan or an ellipse is; None without a point."""
    p = np.concatenate([np.empty((0, 2)), *(q[:, :2] for q in points)])
    p = p[np.isfinite(p).all(1)]
    if not len(p):
        return None
    low, high = p.min(0), p.max(0)
    room = MARGIN * max(float((high - low).max()), 1.0)
    return [[float(a - room), float(b + room)] for a, b in zip(low, high, strict=True)]
