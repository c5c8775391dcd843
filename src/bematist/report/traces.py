"""Plotly traces as plain dicts: numbers as base64 float32, colours as tokens that the page turns into its theme's colours."""

from __future__ import annotations

import base64
import html
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bematist.report.decimate import envelope, extreme_indices

Trace = dict[str, Any]

LONG_S = 1e4
"""From this time on, s, float32 no longer tells milliseconds apart and times are written in double precision."""


class Budget:
    """How many points a trace may hold: the browser draws still fewer, but finds detail here when it zooms.

    With several trajectories on a page each gets its share, so that the page stays small.
    """

    def __init__(self, trajectories: int) -> None:
        share = max(trajectories, 1)
        self.fast = max(20_000 // share, 2_000)
        self.slow = max(4_000 // share, 800)
        self.plan = max(12_000 // share, 2_000)


def encode(values: ArrayLike) -> dict[str, str]:
    """A typed array for the page: float32, or float64 for times too long for it."""
    a = np.asarray(values, float)
    finite = np.abs(a[np.isfinite(a)])
    kind = "f8" if len(finite) and finite.max() > LONG_S and _is_time(a) else "f4"
    with np.errstate(over="ignore"):
        data = np.ascontiguousarray(a, dtype="<" + kind)
    return {"dtype": kind, "bdata": base64.b64encode(data.tobytes()).decode("ascii")}


def _is_time(a: np.ndarray[Any, Any]) -> bool:
    return bool((np.diff(a) >= 0).all())


def text(value: object) -> str:
    """Text that plotly shows as it stands: it reads a little HTML in names and titles."""
    return html.escape(str(value), quote=True)


def line(time: ArrayLike, y: ArrayLike, n: int, color: str, name: str = "", **more: Any) -> Trace:
    """A line of at most about n points that keeps the extremes of y."""
    t, y = np.asarray(time, float), np.asarray(y, float)
    k = extreme_indices(y, n)
    return {
        "type": "scatter",
        "mode": "lines",
        "x": encode(t[k]),
        "y": encode(y[k]),
        "name": text(name),
        "showlegend": bool(name),
        "line": {"color": color, "width": more.pop("width", 1.3), "dash": more.pop("dash", "solid")},
        "connectgaps": False,
        **more,
    }


def dots(time: ArrayLike, y: ArrayLike, n: int, color: str, name: str = "", **more: Any) -> Trace:
    """Dots where y is finite, at most about n, its extremes among them.

    The page draws them as one line of round ends without length: thousands of plotly's markers would make it slow.
    """
    t, y = np.asarray(time, float), np.asarray(y, float)
    good = np.flatnonzero(np.isfinite(y))
    k = good[extreme_indices(y[good], n)]
    return {
        "type": "scatter",
        "mode": "lines",
        "meta": "dots",
        "x": encode(t[k]),
        "y": encode(y[k]),
        "name": text(name),
        "showlegend": bool(name),
        "line": {"color": color, "width": more.pop("size", 3.5), "simplify": False},
        "connectgaps": False,
        **more,
    }


def band(time: ArrayLike, low: ArrayLike, high: ArrayLike, n: int, color: str, name: str = "", **more: Any) -> list[Trace]:
    """A shaded band as two traces; it covers all of the given band."""
    k, lower, upper = envelope(low, high, n)
    x = encode(np.asarray(time, float)[k])
    common = {"type": "scatter", "mode": "lines", "line": {"width": 0}, "hoverinfo": "skip", "x": x, **more}
    return [
        {**common, "y": encode(lower), "showlegend": False},
        {**common, "y": encode(upper), "fill": "tonexty", "fillcolor": color, "name": text(name), "showlegend": bool(name)},
    ]


def level(time: ArrayLike, y: float, color: str, name: str = "", dash: str = "dash") -> Trace:
    """A horizontal line over the whole time."""
    t = np.asarray(time, float)
    return {
        **line(t[[0, -1]], np.full(2, y), 2, color, name, dash=dash),
        "hoverinfo": "skip",
    }


def shading(intervals: ArrayLike, time: ArrayLike, color: str, name: str = "") -> Trace:
    """Intervals [first, one past last) of samples as shaded stretches behind a panel (on its second, hidden axis)."""
    t = np.asarray(time, float)
    spans = np.asarray(intervals, np.int64).reshape(-1, 2)
    edges = t[np.minimum(spans, len(t) - 1)].ravel()
    x = np.concatenate([t[:1], edges, t[-1:]])
    y = np.concatenate([[0.0], np.tile([1.0, 0.0], len(spans)), [0.0]])
    if len(spans) and spans[-1, 1] >= len(t):
        y[-2:] = 1.0  # standing to the end
    return {
        "type": "scatter",
        "mode": "lines",
        "x": encode(x),
        "y": encode(y),
        "yaxis": "y2",
        "line": {"width": 0, "shape": "hv"},
        "fill": "tozeroy",
        "fillcolor": color,
        "hoverinfo": "skip",
        "name": text(name),
        "showlegend": bool(name),
        "meta": "shading",
    }
