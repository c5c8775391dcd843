"""The panels over time: which there are, and those of the motion. A panel without data is left out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bematist.recording import Reference
from bematist.report.constraints import hdr, maru, pace, zaru
from bematist.report.explanations import OFFSETS, bias, evidence, field_norm, inclination, innovation, nis, statistic
from bematist.report.fields import earth_heading, field_nis, verdicts
from bematist.report.gait import frequency, length, modes
from bematist.report.subject import AXES, Panel, Subject
from bematist.report.traces import Trace, band, line

Array = NDArray[np.float64]

JUMP_DEG = 90.0
"""An angle that differs by more than this from one sample to the next has jumped, as roll and yaw do where the pitch is upright."""


def panels(drawn: Sequence[Subject], reference: Reference | None = None) -> list[Panel]:
    """All panels that have something to show. `reference` is in the frame of the first trajectory."""
    gait = (frequency, length, modes)
    stood = (statistic, pace, innovation, nis, zaru, hdr)
    builders = (*gait, speed, tilt, heading, uncertainty, *stood, field_norm, inclination, maru, verdicts, field_nis, earth_heading)
    found = [height(drawn, reference), *(build(drawn) for build in builders)]
    found += [*(bias(drawn, quantity) for quantity in OFFSETS), evidence(drawn)]
    return [panel for panel in found if panel.traces]


def height(drawn: Sequence[Subject], reference: Reference | None = None) -> Panel:
    """Height with its 95 % band, and the reference's; none of a path whose height nothing told."""
    traces: list[Trace] = []
    for s in drawn:
        if not s.trajectory.has_height:
            continue
        t, up = s.trajectory.time, s.trajectory.position[:, 2]
        sd = s.trajectory.position_sd[:, 2]
        if s.alone and np.isfinite(sd).any():
            traces += band(t, up - 1.96 * sd, up + 1.96 * sd, s.budget.slow, "@0/0.18", "95 %")
        if np.isfinite(up).any():
            traces.append(line(t, up, s.budget.fast, s.color, s.name or "height", hovertemplate="%{y:.3f} m"))
    known = _reference_height(reference, drawn[0]) if traces else []
    above = "the start" if drawn[0].trajectory.position[0, 2] == 0 else "0 of the frame"
    note = f"Above {above}." + (" The reference begins at the height that the path has at its first instant." if known else "")
    return Panel("height", "Height", "height (m)", traces + known, note)


def _reference_height(reference: Reference | None, s: Subject) -> list[Trace]:
    if reference is None:
        return []
    good = np.isfinite(reference.time) & np.isfinite(reference.position[:, 2])
    if not good.any():
        return []
    t, up = reference.time[good], reference.position[good, 2]
    # An alignment fits the mean height; here drift shall be seen, so both begin together.
    start = float(np.interp(t[0], s.trajectory.time, s.trajectory.position[:, 2]))
    up = up - up[0] + (start if np.isfinite(start) else 0.0)
    return [line(t, up, s.budget.slow, "@ink", "reference", dash="dot", hovertemplate="%{y:.3f} m")]


def speed(drawn: Sequence[Subject]) -> Panel:
    """Norm of the velocity."""
    traces: list[Trace] = []
    for s in drawn:
        v = np.linalg.norm(s.trajectory.velocity, axis=1)
        if np.isfinite(v).any():
            traces.append(line(s.trajectory.time, v, s.budget.fast, s.color, s.name, hovertemplate="%{y:.3f} m/s"))
    shoe = any(s.trajectory.steps is None for s in drawn)
    note = "Of the sensor itself: a foot swings faster than its wearer walks." if shoe else "Mean of each step; zero where nobody walks."
    return Panel("speed", "Speed", "speed (m/s)", traces, note)


def tilt(drawn: Sequence[Subject]) -> Panel:
    """Roll and pitch."""
    traces: list[Trace] = []
    for s in drawn:
        for column, name in enumerate(("roll", "pitch")):
            angle = s.euler_deg[:, column]
            if s.trajectory.steps is None:
                angle = continuous(angle, s.trajectory.stance_intervals())
            how = s.per_axis(name, *AXES[column][1:])
            if np.isfinite(angle).any():
                traces.append(line(s.trajectory.time, angle, s.budget.fast, hovertemplate="%{y:.1f}°", **how))
    return Panel("tilt", "Roll and pitch", "angle (°)", traces)


def heading(drawn: Sequence[Subject]) -> Panel:
    """Heading, continued through 360°."""
    traces: list[Trace] = []
    for s in drawn:
        steps = s.trajectory.steps
        if steps is None:
            t = s.trajectory.time
            angle = continuous(np.mod(90.0 - s.euler_deg[:, 2], 360.0), s.trajectory.stance_intervals())
        else:
            t, angle = steps.time, np.unwrap(steps.heading_deg, period=360.0)
        if np.isfinite(angle).any():
            traces.append(line(t, angle, s.budget.fast, s.color, s.name, hovertemplate="%{y:.1f}°"))
    of = {s.footing: "the sensor's x axis" if s.footing == "stance" else "each step" for s in drawn}
    own = "the path's own " if any(s.trajectory.north == "none" for s in drawn) else ""
    note = f"Of {' or '.join(of.values())}, clockwise from {own}north, continued through 360°."
    return Panel("heading", "Heading", "heading (°)", traces, note)


def continuous(angle_deg: Array, stances: NDArray[np.int64]) -> Array:
    """An angle (N,), degrees, without its jumps by 360.

    It is made continuous from stance to stance and follows the nearest turn between them: in a swing roll and yaw may jump where
    the pitch is upright, and adding those up would never come back. The line is broken (NaN) where it still jumps.
    """
    good = np.isfinite(angle_deg)
    if not good.any():
        return angle_deg
    middle = stances.sum(1) // 2
    at = middle[good[middle]]
    at = at if len(at) else np.flatnonzero(good)
    anchor = np.unwrap(angle_deg[at], period=360.0)
    centre = np.interp(np.arange(len(angle_deg)), at, anchor)
    return broken(angle_deg - 360.0 * np.round((angle_deg - centre) / 360.0))


def broken(angle_deg: Array) -> Array:
    """An angle (N,), degrees, with NaN where it has jumped, so that no line is drawn there."""
    found = np.array(angle_deg, float)
    with np.errstate(invalid="ignore"):
        found[1:][np.abs(np.diff(found)) > JUMP_DEG] = np.nan
    return found


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
            if np.isfinite(value).any() and (name == "plan" or s.trajectory.has_height):
                how = s.per_axis(name, color, dash)
                traces.append(line(s.trajectory.time, value, s.budget.slow, hovertemplate="%{y:.3f} m", **how))
    note = "One standard deviation as the filter sees it; in the plan along the longest axis of the ellipse."
    return Panel("uncertainty", "Position uncertainty", "1 σ (m)", traces, note)
