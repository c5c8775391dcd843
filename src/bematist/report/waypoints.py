"""The reference on the plan: its line, and where its points are few, the points with how far the path was from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.recording import Reference
from bematist.report.decimate import path_indices
from bematist.report.overlay import Overlay
from bematist.report.subject import Subject
from bematist.report.traces import Trace, encode, text

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation

Array = NDArray[np.float64]
Rows = NDArray[np.integer]

FEW = 500
"""Up to this many points of a reference are drawn as points, each with its error."""

LABELLED = 60
"""Up to this many have their number beside them."""


def few(reference: Reference) -> bool:
    """Whether the reference is points (footfalls, waypoints) rather than a path."""
    return len(reference.position) <= FEW or reference.footfall is not None


def errors(number: int, s: Subject, reference: Reference, overlay: Overlay, evaluation: Evaluation | None) -> tuple[Rows, Array]:
    """Rows of the reference that were compared with the path (K,), and where the path was then (K,2), in the frame of the page."""
    if evaluation is None or not few(reference):
        return np.empty(0, np.int64), np.empty((0, 2))
    from bematist.evaluate.pairing import sample

    there, _ = overlay.path(number, sample(s.trajectory, evaluation.time)["position"], np.empty((0, 3, 3)))
    return evaluation.rows_used, there[:, :2]


def strokes(start: Array, end: Array) -> Array:
    """Strokes from points (K,2) to points (K,2), one after the other with a row of NaN between (3K,2)."""
    return np.stack([start, end, np.full_like(start, np.nan)], 1).reshape(-1, 2)


def reference_traces(
    drawn: Sequence[Subject], reference: Reference | None, overlay: Overlay, evaluations: Sequence[Evaluation | None]
) -> list[Trace]:
    """The reference, lowest first: its line, strokes from its points to where the paths were, and the points."""
    if reference is None:
        return []
    p = reference.position[:, :2]
    points = few(reference)
    k = np.flatnonzero(np.isfinite(p).all(1)) if points else path_indices(p, 6000)
    if not len(k):
        return []
    line: Trace = {
        "type": "scatter",
        "mode": "lines",
        "x": encode(p[k, 0]),
        "y": encode(p[k, 1]),
        "name": "reference",
        "legendgroup": "reference",
        "line": {"color": "@ink", "width": 1.3, "dash": "dot"},
        "hovertemplate": "reference<br>east %{x:.2f} m<br>north %{y:.2f} m",
        **({"hoverinfo": "skip"} if points else {}),
    }
    if not points:
        return [line]
    said = [_name(reference, row) for row in k.tolist()]
    found: list[Trace] = []
    for number, s in enumerate(drawn):
        rows, there = errors(number, s, reference, overlay, evaluations[number])
        found += _errors(s, p[rows], there) if len(rows) else []
        far = dict(zip(rows.tolist(), np.linalg.norm(there - p[rows], axis=1).tolist(), strict=True))
        who = f"{text(s.name)}: " if s.name else ""
        said = [f"{words}<br>{who}{far[row]:.2f} m off" if row in far else words for words, row in zip(said, k.tolist(), strict=True)]
    return [line, *found, _points(reference, k, said)]


def _name(reference: Reference, row: int) -> str:
    when = f", {reference.time[row]:.2f} s" if np.isfinite(reference.time[row]) else ""
    return f"point {row + 1} of the reference{when}"


def _errors(s: Subject, true: Array, there: Array) -> list[Trace]:
    x, y = strokes(true, there).T
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "x": encode(x),
            "y": encode(y),
            "name": "error at the reference",
            "showlegend": s.alone,
            "line": {"color": "@1/0.8" if s.alone else f"{s.color}/0.6", "width": 1.5},
            "connectgaps": False,
            "hoverinfo": "skip",
        }
    ]


def _points(reference: Reference, k: Rows, said: list[str]) -> Trace:
    p, time = reference.position[k, :2], reference.time[k]
    labelled = len(k) <= LABELLED
    return {
        "type": "scatter",
        "mode": "markers+text" if labelled else "markers",
        "x": encode(p[:, 0]),
        "y": encode(p[:, 1]),
        **({"customdata": encode(time)} if np.isfinite(time).all() else {}),
        "text": [str(row + 1) for row in k.tolist()],
        "textposition": "top right",
        "textfont": {"color": "@ink", "size": 11.5},
        "hovertext": said,
        "hovertemplate": "%{hovertext}<br>east %{x:.2f} m<br>north %{y:.2f} m<extra></extra>",
        "name": "reference",
        "legendgroup": "reference",
        "showlegend": False,
        "marker": {"color": "@ink", "size": 7, "symbol": "circle-open" if labelled else "cross-thin-open"},
    }
