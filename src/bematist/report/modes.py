"""Motion and carrying over time, as the step detector tells them apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bematist.report.subject import Panel
from bematist.report.traces import Trace, line
from bematist.steps import CARRYING, MOTIONS


def modes_panel(time: ArrayLike, motion: ArrayLike, carrying: ArrayLike, n: int, *behind: Trace) -> Panel:
    """Modes (N,), indices into MOTIONS and CARRYING, as two lines of about n points over one axis of names."""
    names = [*MOTIONS, *CARRYING]
    traces = [
        line(time, np.asarray(value, float) + first, n, color, name, width=2, hovertemplate="%{y}")
        for name, value, first, color in (("motion", motion, 0, "@0"), ("carrying", carrying, len(MOTIONS), "@1"))
    ]
    axis = {"tickvals": list(range(len(names))), "ticktext": names, "range": [-0.5, len(names) - 0.5]}
    note = "What the step detector takes motion and device for."
    return Panel("modes", "Motion and carrying", "", [*behind, *traces], note, layout={"yaxis": axis})
