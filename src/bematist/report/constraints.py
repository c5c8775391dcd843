"""The panels of what a filter may use beside zero velocity: pace, angular rate at rest, heading reduction, turning of the field."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bematist.report.explanations import squares
from bematist.report.subject import Panel, Subject
from bematist.report.traces import Trace, band, dots, line

PACES = ("slow", "walking", "running")
"""Names of the diagnostic `pace`."""


def pace(drawn: Sequence[Subject]) -> Panel:
    """The class that sets the stance threshold."""
    traces: list[Trace] = []
    for s in drawn:
        value = s.diagnostic("pace")
        if value is not None:
            how = {"hovertemplate": "%{y}", "width": 2}
            traces.append(line(s.trajectory.time, value, s.budget.slow, s.color, s.name or "pace", **how))
    note = "By the speed of the foot over the last second; each has its own stance threshold."
    layout = {"tickvals": [0, 1, 2], "ticktext": list(PACES), "range": [-0.2, 2.2]}
    return Panel("pace", "Pace", "", traces, note, layout={"yaxis": layout})


def zaru(drawn: Sequence[Subject]) -> Panel:
    """Normalised innovation squared of the zero angular rate."""
    note = "Where the foot was at rest and its gyroscope showed its own offset. Normalised innovation squared, 3 on average."
    return Panel("zaru", "Zero angular rate", "NIS", squares(drawn, "zaru_nis"), note, log=True)


def maru(drawn: Sequence[Subject]) -> Panel:
    """Normalised innovation squared of the turning of the field."""
    note = "Turning of the field in a stance against the gyroscope's: difference squared over what was expected, 3 on average."
    return Panel("maru", "Magnetic angular rate", "NIS", squares(drawn, "maru_nis"), note, log=True)


def hdr(drawn: Sequence[Subject]) -> Panel:
    """Yaw of a stance against the two before; within the tolerance it is taken for drift."""
    traces: list[Trace] = []
    for s in drawn:
        value = s.diagnostic("hdr_innovation")
        if value is None:
            continue
        t = s.trajectory.time
        tolerance = s.parameter("hdr", "tolerance")
        if tolerance is not None and not traces:
            edge = np.full(2, float(np.degrees(tolerance)))
            traces += band(t[[0, -1]], -edge, edge, 2, "@stance/0.2", "taken for drift")
        hover = "%{y:.2f}°"
        traces.append(dots(t, np.degrees(value), s.budget.fast // 2, s.color, s.name or "stance", size=5, hovertemplate=hover))
    note = "Yaw of each stance against the mean of the two before. Outside the band it is a turn and left alone."
    return Panel("hdr", "Heading reduction", "difference (°)", traces, note)
