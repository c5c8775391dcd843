"""What is drawn: a trajectory with its name and colour, and the panel that it is drawn in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.report.traces import Budget, Trace
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

AXES = (("x", "@0", "solid"), ("y", "@1", "dash"), ("z", "@2", "dot"))
"""Body axes: name, colour where one trajectory is drawn, dash where several are."""


@dataclass(frozen=True)
class Panel:
    """One plot over time. `unit` stands in the axis title; `note` is one sentence below the heading."""

    key: str
    title: str
    axis: str
    traces: list[Trace]
    note: str = ""
    log: bool = False
    layout: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Subject:
    """A trajectory as it is drawn: with its name in the legend (empty when it is the only one) and its colour."""

    trajectory: Trajectory
    name: str
    color: str
    budget: Budget

    @cached_property
    def euler_deg(self) -> Array:
        """Roll, pitch, yaw (N,3), degrees."""
        return np.degrees(self.trajectory.euler)

    @property
    def footing(self) -> str:
        """What its steps are called: of a shoe one sees the stances."""
        return "stance" if self.trajectory.steps is None else "step"

    @property
    def alone(self) -> bool:
        return not self.name

    def diagnostic(self, name: str, width: int = 0) -> Array | None:
        """A diagnostic with one row per sample, or None where it is missing or has no finite value."""
        found = self.trajectory.diagnostics.get(name)
        shape = (len(self.trajectory), width) if width else (len(self.trajectory),)
        if found is None or np.shape(found) != shape:
            return None
        a = np.asarray(found, float)
        return a if np.isfinite(a).any() else None

    def parameter(self, *names: str) -> float | None:
        """A number of the nested parameters, or None."""
        value: Any = self.trajectory.parameters
        for name in names:
            value = value.get(name) if hasattr(value, "get") else None
        return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None

    def per_axis(self, name: str, color: str, dash: str) -> dict[str, str]:
        """Name, colour and dash of a component: by colour alone, or by dash beside other trajectories."""
        if self.alone:
            return {"name": name, "color": color, "dash": "solid"}
        return {"name": f"{self.name}, {name}", "color": self.color, "dash": dash}


def subjects(trajectories: Sequence[Trajectory]) -> list[Subject]:
    """The trajectories with names (numbered where two have the same method) and colours."""
    if len(trajectories) == 1:
        return [Subject(trajectories[0], "", "@0", Budget(1))]
    methods = [t.method or "path" for t in trajectories]
    names = [m if methods.count(m) == 1 else f"{m} ({methods[: k + 1].count(m)})" for k, m in enumerate(methods)]
    budget = Budget(len(trajectories))
    return [Subject(t, n, f"@{k % 8}", budget) for k, (t, n) in enumerate(zip(trajectories, names, strict=True))]
