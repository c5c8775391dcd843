"""The panels of what a handheld filter took from the magnetic field and from gravity: judged samples, innovations, heading."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bematist.report.explanations import positive, with_limit
from bematist.report.subject import Panel, Subject
from bematist.report.traces import Trace, dots

VERDICTS = ("changing", "constant", "Earth's", "contradicts", "not used")
"""What was found of a sample, by the numbers 1 to 5 of `magnetic_verdict` and `force_verdict`."""

SENSORS = (("magnetic", "magnetic field", "@0"), ("force", "specific force", "@1"))


def verdicts(drawn: Sequence[Subject]) -> Panel:
    """What each sample was judged to be."""
    traces = [t for s in drawn for t in _of_sensors(s, "verdict", "%{y}")]
    note = (
        "Changing: nothing is made of it. Constant like the ones before it, or the Earth's field or gravity: used. Or it contradicts the "
        "filter: refused. Not used: the method takes nothing from such samples here."
    )
    layout = {"tickvals": [1, 2, 3, 4, 5], "ticktext": list(VERDICTS), "range": [0.5, 5.5]}
    return Panel("verdict", "Samples of field and gravity", "", traces, note, layout={"yaxis": layout})


def field_nis(drawn: Sequence[Subject]) -> Panel:
    """Normalised innovation squared of the samples that were tried."""
    traces = with_limit([t for s in drawn for t in _of_sensors(s, "nis", "%{y:.3g}")], drawn)
    note = "Innovation squared, normalised, of what stays as it is: 3 on average where the noise is as the filter takes it."
    return Panel("field-nis", "Field and gravity against the filter", "NIS", traces, note, log=True)


def earth_heading(drawn: Sequence[Subject]) -> Panel:
    """Heading by the magnetic field against the filter's."""
    traces: list[Trace] = []
    for s in drawn:
        value = s.diagnostic("heading_innovation")
        if value is not None:
            how = {"size": 5, "hovertemplate": "%{y:.1f}°"}
            traces.append(dots(s.trajectory.time, np.degrees(value), s.budget.fast // 2, s.color, s.name or "magnetic − filter", **how))
    note = "North of the magnetic field against the filter's, where the field was believed; iron nearby shows as a difference that lasts."
    return Panel("earth-heading", "Heading by the magnetic field", "difference (°)", traces, note)


def _of_sensors(s: Subject, name: str, hover: str) -> list[Trace]:
    if not s.alone:
        return positive(s, f"{SENSORS[0][0]}_{name}", s.color, s.name, hover)
    return [trace for sensor, words, color in SENSORS for trace in positive(s, f"{sensor}_{name}", color, words, hover)]
