"""The panels of a hand's path: step frequency, step length, how the device moved and was carried."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bematist.report.subject import Panel, Subject
from bematist.report.traces import Trace, dots, line


def frequency(drawn: Sequence[Subject]) -> Panel:
    """Step frequency over time with the steps on it."""
    traces: list[Trace] = []
    for s in walkers(drawn):
        steps = s.trajectory.steps
        assert steps is not None
        value = s.diagnostic("step_frequency")
        if value is not None:
            value = np.where(value > 0, value, np.nan)
            traces.append(line(s.trajectory.time, value, s.budget.slow, s.color, s.name or "frequency", hovertemplate="%{y:.2f} Hz"))
        color = "@1" if s.alone else s.color
        traces.append(dots(steps.time, steps.frequency, s.budget.slow, color, "step" if s.alone else "", hovertemplate="%{y:.2f} Hz"))
    return Panel("step-frequency", "Steps", "frequency (Hz)", traces, "A dot for each step at its own instant, on the step frequency.")


def length(drawn: Sequence[Subject]) -> Panel:
    """Length of each step."""
    traces: list[Trace] = []
    for s in walkers(drawn):
        steps = s.trajectory.steps
        assert steps is not None
        traces.append(dots(steps.time, steps.length, s.budget.slow, s.color, s.name or "step", hovertemplate="%{y:.2f} m"))
    note = "From step frequency and height of the walker; all of them may be too long or too short by the same share."
    return Panel("step-length", "Step length", "length (m)", traces, note)


def modes(drawn: Sequence[Subject]) -> Panel:
    """Motion and carrying over time, as the step detector tells them apart."""
    from bematist.steps import CARRYING, MOTIONS

    # The detector is the same for every method: those of the first that has them are drawn.
    s = next((s for s in drawn if s.diagnostic("motion") is not None), None)
    traces: list[Trace] = []
    names = [*MOTIONS, *CARRYING]
    if s is not None:
        for key, first, color in (("motion", 0, "@0"), ("carrying", len(MOTIONS), "@1")):
            value = s.diagnostic(key)
            assert value is not None
            traces.append(line(s.trajectory.time, value + first, s.budget.slow, color, key, width=2, hovertemplate="%{y}"))
    axis = {"tickvals": list(range(len(names))), "ticktext": names, "range": [-0.5, len(names) - 0.5]}
    return Panel("modes", "Motion and carrying", "", traces, "What the step detector takes motion and device for.", layout={"yaxis": axis})


def walkers(drawn: Sequence[Subject]) -> list[Subject]:
    """Those with a list of steps, at least one step long."""
    return [s for s in drawn if s.trajectory.steps]
