"""The panels that explain the filter: stance, zero-velocity updates, magnetic field, biases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bematist.report.subject import AXES, Panel, Subject
from bematist.report.traces import Trace, band, dots, level, line, shading

Array = NDArray[np.float64]

NIS_95 = 7.815
"""95 % quantile of chi-square with three degrees of freedom: a zero-velocity NIS exceeds it in one of twenty."""

GATES = {
    1: ("refused: norm", "@3"),
    2: ("refused: inclination", "@1"),
    3: ("refused: innovation", "@4"),
    4: ("used", "@0"),
    5: ("passed, not used", "@5"),
    6: ("refused: motion", "@2"),
}
"""Decisions of `magnetic_gate` on a sample: name and colour."""


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
            traces.append(line(s.trajectory.time, threshold, s.budget.slow, color, name, dash="dash", width=2, hovertemplate="%{y:.3g}"))
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
    """Normalised innovation squared of the zero-velocity updates."""
    traces = squares(drawn, "nis")
    note = "Normalised innovation squared. 3 on average where the foot is as still as the filter takes it to be; less where it is stiller."
    return Panel("nis", "Zero-velocity NIS", "NIS", traces, note, log=True)


def squares(drawn: Sequence[Subject], name: str) -> list[Trace]:
    """Normalised innovations squared, the diagnostic `name`, with what 95 % of them are expected below."""
    return with_limit([t for s in drawn for t in positive(s, name, s.color, s.name or "NIS", "%{y:.3g}")], drawn)


def positive(s: Subject, diagnostic: str, color: str, name: str, hover: str) -> list[Trace]:
    """Dots of a diagnostic (N,) where it is positive; none where it never is."""
    value = s.diagnostic(diagnostic)
    if value is None or not (value > 0).any():
        return []
    return [dots(s.trajectory.time, np.where(value > 0, value, np.nan), s.budget.fast // 2, color, name, hovertemplate=hover)]


def with_limit(traces: list[Trace], drawn: Sequence[Subject]) -> list[Trace]:
    """Normalised innovations squared of three numbers, if there are any, with the line that 95 % of them are expected below."""
    return [*traces, level(drawn[0].trajectory.time, NIS_95, "@muted", "95 % expected below", "dot")] if traces else []


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


OFFSETS = {
    "gyro_bias": ("Gyroscope bias", "bias", float(np.degrees(1.0)), "°/s", 4),
    "accel_bias": ("Accelerometer bias", "bias", 1.0, "m/s²", 4),
    "hard_iron": ("Hard iron", "field", 1.0, "µT", 1),
}
"""Offsets of sensors, by the name of their diagnostic: title, what is drawn, in which unit, and how many digits are shown."""


def bias(drawn: Sequence[Subject], quantity: str) -> Panel:
    """Estimated offsets of one sensor, of `OFFSETS`; where one trajectory is drawn, with ±3σ."""
    title, what, scale, unit, digits = OFFSETS[quantity]
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
            hover = f"%{{y:.{digits}f}} {unit}"
            traces.append(line(t, v, s.budget.slow, hovertemplate=hover, legendgroup=how["name"], **how))
    note = "Body axes" + (", with ±3 σ." if len(drawn) == 1 else ".")
    return Panel(quantity.replace("_", "-"), title, f"{what} ({unit})", traces, note)


def evidence(drawn: Sequence[Subject]) -> Panel:
    """Evidence for hard iron."""
    traces: list[Trace] = []
    for s in drawn:
        value = s.diagnostic("hard_iron_evidence")
        if value is not None:
            name = s.name or "ln of evidence"
            traces.append(line(s.trajectory.time, value, s.budget.slow, s.color, name, hovertemplate="%{y:.1f}"))
    note = "ln of how much likelier the readings of the magnetometer are with hard iron than without; below 0 they speak against it."
    return Panel("hard-iron-evidence", "Evidence of hard iron", "ln", traces, note)
