"""What the figures of all studies share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from bematist.report.still import COLORS, dress

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["COLORS", "colored", "dots", "dress", "sheet"]


def sheet(rows: int = 1, columns: int = 1, *, width: float = 8.0, height: float = 4.0) -> tuple[Figure, list[Axes]]:
    """A figure and its axes, row by row; inches."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    mpl.rcParams["svg.hashsalt"] = "bematist"  # the same figure is the same file
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = list(np.ravel(figure.subplots(rows, columns)))
    for a in axes:
        dress(a)
    return figure, axes


def colored(names: Sequence[str]) -> dict[str, str]:
    """A colour for each name, in the order of the palette."""
    return {name: COLORS[k % len(COLORS)] for k, name in enumerate(names)}


def dots(axes: Axes, groups: Mapping[str, ArrayLike], colors: Mapping[str, str], *, log: bool = True) -> None:
    """A row of dots for each group, one for each seed, with a stroke at the median; the first group is on top."""
    for k, (name, values) in enumerate(groups.items()):
        v = np.asarray(values, float)
        axes.plot(v, np.full(len(v), k), "o", color=colors[name], alpha=0.45, markersize=4, markeredgewidth=0)
        axes.plot([np.median(v)] * 2, [k - 0.32, k + 0.32], color=colors[name], linewidth=2.2)
    axes.set_yticks(range(len(groups)), list(groups))
    axes.set_ylim(len(groups) - 0.5, -0.5)
    if log:
        axes.set_xscale("log")
