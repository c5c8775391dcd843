"""The panels over time: which there are, and what is drawn in each. A panel without data is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.recording import Reference
from bematist.report.traces import Budget, Trace, band, dots, level, line, shading
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

AXES = (("x", "@0", "solid"), ("y", "@1", "dash"), ("z", "@2", "dot"))
"""Body axes: name, colour where one trajectory is drawn, dash where several are."""

NIS_95 = 7.815
"""95 % quantile of chi-square with three degrees of freedom: a zero-velocity NIS exceeds it in one of twenty."""

GATES = {
    1: ("refused: norm", "@3"),
    2: ("refused: inclination", "@1"),
    3: ("refused: innovation", "@4"),
    4: ("used", "@0"),
}
"""Decisions of `magnetic_gate` on a sample: name and colour."""


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


def panels(drawn: Sequence[Subject], reference: Reference | None = None) -> list[Panel]:
    """All panels that have something to show. `reference` is in the frame of the first trajectory."""
    builders = (speed, tilt, heading, uncertainty, statistic, innovation, nis, field_norm, inclination)
    found = [height(drawn, reference), *(build(drawn) for build in builders)]
    found += [bias(drawn, quantity) for quantity in ("gyro_bias", "accel_bias")]
    return [panel for panel in found if panel.traces]


def height(drawn: Sequence[Subject], reference: Reference | None = None) -> Panel:
    """Height with its 95 % band, and the reference's."""
    traces: list[Trace] = []
    for s in drawn:
        t, up = s.trajectory.time, s.trajectory.position[:, 2]
        sd = s.trajectory.position_sd[:, 2]
        if s.alone and np.isfinite(sd).any():
            traces += band(t, up - 1.96 * sd, up + 1.96 * sd, s.budget.slow, "@0/0.18", "95 %")
        if np.isfinite(up).any():
            traces.append(line(t, up, s.budget.fast, s.color, s.name or "height", hovertemplate="%{y:.3f} m"))
    traces += _reference_height(reference, drawn[0].budget) if traces else []
    return Panel("height", "Height", "height (m)", traces, "Above the start, upwards positive.")


def _reference_height(reference: Reference | None, budget: Budget) -> list[Trace]:
    if reference is None:
        return []
    good = np.isfinite(reference.time) & np.isfinite(reference.position[:, 2])
    if not good.any():
        return []
    t, up = reference.time[good], reference.position[good, 2]
    return [line(t, up, budget.slow, "@ink", "reference", dash="dot", hovertemplate="%{y:.3f} m")]


def speed(drawn: Sequence[Subject]) -> Panel:
    """Norm of the velocity."""
    traces: list[Trace] = []
    for s in drawn:
        v = np.linalg.norm(s.trajectory.velocity, axis=1)
        if np.isfinite(v).any():
            traces.append(line(s.trajectory.time, v, s.budget.fast, s.color, s.name, hovertemplate="%{y:.3f} m/s"))
    return Panel("speed", "Speed", "speed (m/s)", traces, "Of the sensor itself: a foot swings faster than its wearer walks.")


def tilt(drawn: Sequence[Subject]) -> Panel:
    """Roll and pitch."""
    traces: list[Trace] = []
    for s in drawn:
        for column, name in enumerate(("roll", "pitch")):
            angle = continuous(s.euler_deg[:, column], s.trajectory.stance_intervals())
            how = s.per_axis(name, *AXES[column][1:])
            if np.isfinite(angle).any():
                traces.append(line(s.trajectory.time, angle, s.budget.fast, hovertemplate="%{y:.1f}°", **how))
    return Panel("tilt", "Roll and pitch", "angle (°)", traces)


def heading(drawn: Sequence[Subject]) -> Panel:
    """Heading, continued through 360°."""
    traces: list[Trace] = []
    for s in drawn:
        angle = np.mod(90.0 - s.euler_deg[:, 2], 360.0)
        angle = continuous(angle, s.trajectory.stance_intervals())
        if np.isfinite(angle).any():
            traces.append(line(s.trajectory.time, angle, s.budget.fast, s.color, s.name, hovertemplate="%{y:.1f}°"))
    note = "Of the sensor's x axis, clockwise from north, continued through 360°."
    return Panel("heading", "Heading", "heading (°)", traces, note)


def continuous(angle_deg: Array, stances: NDArray[np.int64]) -> Array:
    """An angle (N,), degrees, without its jumps by 360.

    It is made continuous from stance to stance and follows the nearest turn between them: in a swing roll and yaw may jump where
    the pitch is upright, and adding those up would never come back.
    """
    good = np.isfinite(angle_deg)
    if not good.any():
        return angle_deg
    middle = stances.sum(1) // 2
    at = middle[good[middle]]
    at = at if len(at) else np.flatnonzero(good)
    anchor = np.unwrap(angle_deg[at], period=360.0)
    centre = np.interp(np.arange(len(angle_deg)), at, anchor)
    return angle_deg - 360.0 * np.round((angle_deg - centre) / 360.0)


def uncertainty(drawn: Sequence[Subject]) -> Panel:
    """Standard deviations of the position: in the plan (largest axis of the ellipse) and in height."""
    traces: list[Trace] = []
    for s in drawn:
        P = s.trajectory.packed_covariance
        xx, xy, yy = P[:, 0], P[:, 1], P[:, 3]
        with np.errstate(invalid="ignore"):
            plan = np.sqrt((xx + yy) / 2 + np.sqrt(((xx - yy) / 2) ** 2 + xy**2))
            plan = np.where(np.isfinite(plan), plan, np.sqrt(np.maximum(xx, yy)))
        for value, name, color, dash in ((plan, "plan", "@0", "solid"), (np.sqrt(P[:, 5]), "height", "@1", "dot")):
            if np.isfinite(value).any():
                how = s.per_axis(name, color, dash)
                traces.append(line(s.trajectory.time, value, s.budget.slow, hovertemplate="%{y:.3f} m", **how))
    note = "One standard deviation as the filter sees it; in the plan along the longest axis of the ellipse."
    return Panel("uncertainty", "Position uncertainty", "1 σ (m)", traces, note)


def statistic(drawn: Sequence[Subject]) -> Panel:
    """Stance statistic with its threshold; where one trajectory is drawn, its stance phases are shaded."""
    traces: list[Trace] = []
    for s in drawn:
        value, threshold = s.diagnostic("stance_statistic"), s.diagnostic("stance_threshold")
        if value is None:
            continue
        value = np.where(value > 0, value, np.nan)
        if s.alone:
            intervals = s.trajectory.stance_intervals()
            traces.append(shading(intervals, s.trajectory.time, "@stance/0.22", "stance"))
        traces.append(line(s.trajectory.time, value, s.budget.fast, s.color, s.name or "statistic", hovertemplate="%{y:.3g}"))
        if threshold is not None:
            name = "threshold" if s.alone else f"{s.name}, threshold"
            color = "@1" if s.alone else s.color
            traces.append(line(s.trajectory.time, threshold, s.budget.slow, color, name, dash="dash", hovertemplate="%{y:.3g}"))
    note = "The foot is taken to stand where the statistic is below the threshold."
    return Panel("stance", "Stance", "statistic", traces, note, log=True)


def innovation(drawn: Sequence[Subject]) -> Panel:
    """Velocity that the zero-velocity updates took away."""
    traces: list[Trace] = []
    for s in drawn:
        value = s.diagnostic("innovation", 3)
        if value is None:
            continue
        if s.alone:
            for k, (name, color) in enumerate((("east", "@0"), ("north", "@1"), ("up", "@2"))):
                traces.append(dots(s.trajectory.time, value[:, k], s.budget.fast // 2, color, name, hovertemplate="%{y:.4f} m/s"))
        else:
            norm = np.linalg.norm(value, axis=1)
            how = {"hovertemplate": "%{y:.4f} m/s"}
            traces.append(dots(s.trajectory.time, norm, s.budget.fast // 2, s.color, s.name, **how))
    note = "What each zero-velocity update had to correct: the velocity of a foot that stands."
    if len(drawn) > 1:
        note += " Drawn is its norm."
    return Panel("innovation", "Zero-velocity innovation", "innovation (m/s)", traces, note)


def nis(drawn: Sequence[Subject]) -> Panel:
    """Normalised innovation squared of the zero-velocity updates, and its gates."""
    traces: list[Trace] = []
    for s in drawn:
        value = s.diagnostic("nis")
        if value is None:
            continue
        value = np.where(value > 0, value, np.nan)
        traces.append(dots(s.trajectory.time, value, s.budget.fast // 2, s.color, s.name or "NIS", hovertemplate="%{y:.3g}"))
        gate = s.parameter("zero_velocity", "gate")
        if gate is not None and s.alone:
            traces.append(level(s.trajectory.time, gate, "@1", "gate"))
    if traces:
        traces.append(level(drawn[0].trajectory.time, NIS_95, "@muted", "95 % expected below", "dot"))
    note = "Normalised innovation squared. A filter that judges itself rightly has 3 on average."
    return Panel("nis", "Zero-velocity NIS", "NIS", traces, note, log=True)


def field_norm(drawn: Sequence[Subject]) -> Panel:
    """Norm of the magnetic samples with the decision on each, over the reference and its tolerance."""
    reference, tolerance = None, drawn[0].parameter("magnetic", "norm_tolerance")
    if (pair := _field(drawn[0])) is not None:
        reference = float(pair[0])
    margin = None if reference is None or tolerance is None else reference * tolerance
    traces = _gated(drawn, "magnetic_norm", 1.0, reference, margin, "%{y:.2f} µT")
    note = "Samples of the magnetometer, by what was decided on each; the band is what the norm gate accepts."
    return Panel("field", "Magnetic field", "norm (µT)", traces, note)


def inclination(drawn: Sequence[Subject]) -> Panel:
    """Inclination of the field, as `field_norm`."""
    reference, tolerance = None, drawn[0].parameter("magnetic", "inclination_tolerance")
    if (pair := _field(drawn[0])) is not None:
        reference = float(np.degrees(pair[1]))
    margin = None if reference is None or tolerance is None else float(np.degrees(tolerance))
    traces = _gated(drawn, "magnetic_inclination", float(np.degrees(1.0)), reference, margin, "%{y:.1f}°")
    note = "Angle of the field below the horizontal; the band is what the inclination gate accepts."
    return Panel("inclination", "Magnetic inclination", "inclination (°)", traces, note)


def _field(s: Subject) -> Array | None:
    """Norm (µT) and inclination (rad) of the field at the start, or None."""
    pair = s.trajectory.diagnostics.get("magnetic_reference")
    return np.asarray(pair, float) if pair is not None and np.shape(pair) == (2,) and np.isfinite(pair).any() else None


def _gated(drawn: Sequence[Subject], name: str, scale: float, reference: float | None, margin: float | None, hover: str) -> list[Trace]:
    """Magnetic samples by decision. The samples are the same for every method: those of the first that has them are drawn."""
    s = next((s for s in drawn if s.diagnostic(name) is not None), None)
    if s is None:
        return []
    value, t = np.asarray(s.diagnostic(name), float) * scale, s.trajectory.time
    gate = s.diagnostic("magnetic_gate")
    traces: list[Trace] = []
    if reference is not None and np.isfinite(reference):
        if margin is not None:
            traces += band(t[[0, -1]], np.full(2, reference - margin), np.full(2, reference + margin), 2, "@stance/0.2", "gate")
        traces.append(level(t, reference, "@muted", "at the start"))
    if gate is None:
        return [*traces, dots(t, value, s.budget.fast // 2, s.color, "sample", hovertemplate=hover)]
    for code, (label, color) in GATES.items():
        chosen = np.where(gate == code, value, np.nan)
        if np.isfinite(chosen).any():
            traces.append(dots(t, chosen, s.budget.fast // 2, color, label, size=4, hovertemplate=hover))
    rest = np.where(np.isin(gate, list(GATES)), np.nan, value)
    if np.isfinite(rest).any():
        traces.append(dots(t, rest, s.budget.fast // 2, "@muted", "not judged", size=3, hovertemplate=hover))
    return traces


def bias(drawn: Sequence[Subject], quantity: str) -> Panel:
    """Estimated biases of one sensor; where one trajectory is drawn, with ±3σ."""
    gyro = quantity == "gyro_bias"
    scale, unit = (float(np.degrees(1.0)), "°/s") if gyro else (1.0, "m/s²")
    traces: list[Trace] = []
    for s in drawn:
        value, sd = s.diagnostic(quantity, 3), s.diagnostic(quantity + "_sd", 3)
        if value is None:
            continue
        t = s.trajectory.time
        for k, (name, color, dash) in enumerate(AXES):
            v = value[:, k] * scale
            if s.alone and sd is not None:
                spread = 3 * scale * sd[:, k]
                traces += band(t, v - spread, v + spread, s.budget.slow, f"{color}/0.13", legendgroup=name)
            how = s.per_axis(name, color, dash)
            hover = "%{y:.4f} " + unit
            traces.append(line(t, v, s.budget.slow, hovertemplate=hover, legendgroup=how["name"], **how))
    title = "Gyroscope bias" if gyro else "Accelerometer bias"
    note = "Body axes" + (", with ±3 σ." if len(drawn) == 1 else ".")
    return Panel(quantity.replace("_", "-"), title, f"bias ({unit})", traces, note)
