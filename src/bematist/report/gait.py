"""The panels of a hand's path: step frequency, step length, how the device moved and was carried."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.report.subject import Panel, Subject
from bematist.report.traces import Trace, dots, line

Array = NDArray[np.float64]


def frequency(drawn: Sequence[Subject]) -> Panel:
    """Step frequency over time with the steps on it."""
    traces: list[Trace] = []
    late = np.empty(0)
    for s in walkers(drawn):
        steps = s.trajectory.steps
        assert steps is not None
        late = np.append(late, steps.counted - steps.time)
        value = s.diagnostic("step_frequency")
        if value is not None:
            value = np.where(value > 0, value, np.nan)
            traces.append(line(s.trajectory.time, value, s.budget.slow, s.color, s.name or "frequency", hovertemplate="%{y:.2f} Hz"))
        color = "@1" if s.alone else s.color
        traces.append(dots(steps.time, steps.frequency, s.budget.slow, color, "step" if s.alone else "", hovertemplate="%{y:.2f} Hz"))
    note = "A dot for each step at its own instant, on the step frequency."
    if len(late):
        note += (
            f" The path moves when a step is counted, {np.median(late):.1f} s later in the median. The first steps of a walk are counted "
            f"together once it is recognised, up to {late.max():.1f} s late: until then the path stands still."
        )
    return Panel("step-frequency", "Steps", "frequency (Hz)", traces, note)


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
    # The detector is the same for every method: those of the first that has them are drawn.
    for s in drawn:
        motion, carrying = s.diagnostic("motion"), s.diagnostic("carrying")
        if motion is not None and carrying is not None:
            return modes_panel(s.trajectory.time, motion, carrying, s.budget.slow)
    return Panel("modes", "Motion and carrying", "", [])


def modes_panel(time: Array, motion: NDArray[Any], carrying: NDArray[Any], n: int, *behind: Trace) -> Panel:
    """Modes (N,), indices into MOTIONS and CARRYING, as two lines of about n points over one axis of names."""
    from bematist.steps import CARRYING, MOTIONS

    names = [*MOTIONS, *CARRYING]
    both = (("motion", motion, "@0"), ("carrying", carrying + float(len(MOTIONS)), "@1"))
    traces = [line(time, value, n, color, name, width=2, hovertemplate="%{y}") for name, value, color in both]
    axis = {"tickvals": list(range(len(names))), "ticktext": names, "range": [-0.5, len(names) - 0.5]}
    note = "What the step detector takes motion and device for."
    return Panel("modes", "Motion and carrying", "", [*behind, *traces], note, layout={"yaxis": axis})


def walkers(drawn: Sequence[Subject]) -> list[Subject]:
    """Those with a list of steps, at least one step long."""
    return [s for s in drawn if s.trajectory.steps]
