"""The page and the picture of attitudes: heading, roll and pitch over time, with the truth and the error where it is known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.frames import euler_from_quaternion, heading_deg_from_yaw
from bematist.recording import Reference
from bematist.report import summary
from bematist.report.decimate import extreme_indices
from bematist.report.explanations import OFFSETS
from bematist.report.page import header, page_data, panel_section, write_page
from bematist.report.panels import broken, continuous
from bematist.report.still import COLORS, dress, picture_path
from bematist.report.subject import AXES, Panel
from bematist.report.traces import Budget, Trace, band, line

if TYPE_CHECKING:
    from bematist.evaluate import AttitudeEvaluation
    from bematist.evaluate.attitude import Align

Array = NDArray[np.float64]

UPRIGHT_DEG = 80.0
"""A pitch steeper than this, degrees, is upright: heading and roll then turn about nearly the same axis."""

ANGLES = (("heading", "Heading"), ("roll", "Roll"), ("pitch", "Pitch"))


def write_attitude_page(
    attitudes: Sequence[Attitude],
    path: str | Path,
    reference: Reference | None = None,
    evaluations: Sequence[AttitudeEvaluation] | None = None,
    align: Align = "none",
) -> None:
    """Write a page about the attitudes of one recording by one filter or several; the first is the one that the page is about.

    evaluations: one for each filter, or an empty list; without them they are made here, aligned by `align`, where the reference has
    attitudes.

    Raises
    ------
    UsageError
        There are no attitudes, or another number of evaluations.
    DataError
        The page cannot be written.
    """
    if not attitudes or not all(len(a) for a in attitudes):
        raise UsageError("A page of attitudes needs at least one filter, with samples.")
    if evaluations is None:
        evaluations = _evaluated(attitudes, reference, align)
    if len(evaluations) not in (0, len(attitudes)):
        raise UsageError(f"There are {len(attitudes)} filters and {len(evaluations)} evaluations: give one for each.")
    first = attitudes[0]
    offsets = [_offsets(attitudes, quantity) for quantity in ("gyro_bias", "hard_iron")]
    figures = [*_angles(attitudes, reference), *_errors(attitudes, evaluations), *(p for p in offsets if p.traces)]
    name = Path(first.source).name if first.source else "Recording"
    names = ", ".join(a.filter for a in attitudes)
    body = "".join(
        [
            header(name, f"Attitude · {names} · {summary.clock(float(first.time[-1] - first.time[0]))}"),
            _table(attitudes, evaluations),
            summary.warning_list([w for a in attitudes for w in a.warnings]),
            f'<main class="timeline">{"".join(map(panel_section, figures))}</main>',
            summary.parameters([(a.filter if len(attitudes) > 1 else "", a.parameters) for a in attitudes]),
        ]
    )
    write_page(Path(path), f"{name}: attitude", body, page_data(figures, (), first.time))


def _evaluated(attitudes: Sequence[Attitude], reference: Reference | None, align: Align) -> list[AttitudeEvaluation]:
    if reference is None or reference.attitude is None:
        return []
    from bematist.evaluate import evaluate_attitude

    return [evaluate_attitude(a, reference, align) for a in attitudes]


def angles_deg(attitude: Array) -> dict[str, Array]:
    """Heading, roll and pitch (N,), degrees, of attitudes (N,4), continued through 360°.

    Where the x axis comes to stand upright, heading and roll jump at the pole, and turns added up there would never come back: they then
    stay within one turn.
    """
    roll, pitch, yaw = np.moveaxis(euler_from_quaternion(attitude), -1, 0)
    none = np.empty((0, 2), np.int64)
    if len(pitch) and np.degrees(np.nanmax(np.abs(pitch))) > UPRIGHT_DEG:
        return {"heading": broken(heading_deg_from_yaw(yaw)), "roll": broken(np.degrees(roll)), "pitch": np.degrees(pitch)}
    return {
        "heading": continuous(heading_deg_from_yaw(yaw), none),
        "roll": continuous(np.degrees(roll), none),
        "pitch": np.degrees(pitch),
    }


def _beside(angle: Array, time: Array, other: Array, other_time: Array) -> Array:
    """An angle (K,), degrees, moved by whole turns to lie beside another (N,) where both are first known."""
    good = np.flatnonzero(np.isfinite(angle))
    if not len(good):
        return angle
    return angle - 360.0 * np.round((angle[good[0]] - np.interp(time[good[0]], other_time, other)) / 360.0)


def _angles(attitudes: Sequence[Attitude], reference: Reference | None) -> list[Panel]:
    budget = Budget(len(attitudes))
    found = [angles_deg(a.attitude) for a in attitudes]
    true = None if reference is None or reference.attitude is None else angles_deg(reference.attitude)
    panels = []
    for key, title in ANGLES:
        traces: list[Trace] = []
        if true is not None and reference is not None:
            y = _beside(true[key], reference.time, found[0][key], attitudes[0].time)
            traces.append(line(reference.time, y, budget.fast, "@ink", "reference", dash="dot", hovertemplate="%{y:.2f}°"))
        for k, a in enumerate(attitudes):
            y = _beside(found[k][key], a.time, found[0][key], attitudes[0].time)
            traces.append(line(a.time, y, budget.fast, f"@{k % 8}", a.filter, hovertemplate="%{y:.2f}°"))
        note = (
            "Of the sensor's x axis, clockwise from north, continued through 360° unless that axis comes to stand upright."
            if key == "heading"
            else ""
        )
        panels.append(Panel(key, title, f"{key} (°)", traces, note))
    return panels


def _errors(attitudes: Sequence[Attitude], evaluations: Sequence[AttitudeEvaluation]) -> list[Panel]:
    if not evaluations:
        return []
    budget = Budget(len(attitudes))
    turn, tilt = [], []
    for k, (a, e) in enumerate(zip(attitudes, evaluations, strict=True)):
        size = np.degrees(np.hypot(e.vectors[:, 0], e.vectors[:, 1]))
        turn.append(line(e.time, np.degrees(e.vectors[:, 2]), budget.fast, f"@{k % 8}", a.filter, hovertemplate="%{y:.2f}°"))
        tilt.append(line(e.time, size, budget.fast, f"@{k % 8}", a.filter, hovertemplate="%{y:.2f}°"))
    by = {"none": "not aligned", "yaw": "the mean heading error taken out", "frames": "a constant rotation on either side taken out"}[
        evaluations[0].align
    ]
    note = f"Of the rotation between estimate and reference, {by}; where the reference counts."
    return [
        Panel("turn", "Error about the vertical", "error (°)", turn, note + " Positive: turned counter-clockwise."),
        Panel("tilt", "Error of the vertical", "error (°)", tilt, note),
    ]


def _offsets(attitudes: Sequence[Attitude], quantity: str) -> Panel:
    """An offset as the filters believe it, one of `OFFSETS`; where one filter is drawn, with ±3σ."""
    title, what, scale, unit, digits = OFFSETS[quantity]
    budget = Budget(3 * len(attitudes))
    traces: list[Trace] = []
    alone = len(attitudes) == 1
    for k, a in enumerate(attitudes):
        value = a.gyro_bias if quantity == "gyro_bias" else a.diagnostics.get(quantity, np.full((len(a), 3), np.nan))
        sd = a.diagnostics.get(f"{quantity}_sd")
        for axis, (name, color, dash) in enumerate(AXES):
            b = scale * np.asarray(value[:, axis], float)
            if not np.isfinite(b).any():
                continue
            how = {"name": name, "color": color} if alone else {"name": f"{a.filter}, {name}", "color": f"@{k % 8}", "dash": dash}
            if alone and sd is not None:
                spread = 3 * scale * np.asarray(sd[:, axis], float)
                traces += band(a.time, b - spread, b + spread, budget.slow, f"{color}/0.13", legendgroup=name)
            hover = f"%{{y:.{digits}f}} {unit}"
            traces.append(line(a.time, b, budget.slow, hovertemplate=hover, legendgroup=how["name"], **how))
    note = "As the filter believes it, in the body frame" + (", with ±3 σ where it has one." if alone else ".")
    return Panel("offset" if quantity == "gyro_bias" else "hard-iron", title, f"{what} ({unit})", traces, note)


def _table(attitudes: Sequence[Attitude], evaluations: Sequence[AttitudeEvaluation]) -> str:
    head = ["Filter", "North", "Heading at the start", "at the end", "Processing"]
    head += [f"{what} rms [{evaluations[0].align}]" for what in ("Attitude", "Heading", "Tilt")] if evaluations else []
    rows = []
    for k, a in enumerate(attitudes):
        s = a.summary()
        cells = [a.filter, a.north, summary.number(s["heading_start_deg"], "°", 1), summary.number(s["heading_end_deg"], "°", 1)]
        cells.append(summary.spent(a.processing_s))
        if evaluations:
            d = evaluations[k].to_dict()
            cells += [summary.number(d[f"{key}_rmse_deg"], "°") for key in ("attitude", "heading", "tilt")]
        rows.append(cells)
    return f"<section>{summary.table(head, [[summary.escape(c) for c in row] for row in rows])}</section>"


def still_attitude(attitudes: Sequence[Attitude], path_png: str | Path, reference: Reference | None = None) -> None:
    """Draw heading, roll and pitch over time into a PNG, SVG or PDF file (by its suffix); the reference, if there is one, below them.

    Raises
    ------
    UsageError
        There are no attitudes, or a suffix that is no picture.
    DataError
        The file cannot be written.
    """
    from matplotlib.figure import Figure

    from bematist.outputs import whole_file

    if not attitudes:
        raise UsageError("A picture needs at least one filter.")
    path = picture_path(path_png)
    if any(not len(a) for a in attitudes):
        raise DataError("There are no samples to draw.")
    figure = Figure(figsize=(9, 7.5), layout="constrained")
    found = [angles_deg(a.attitude) for a in attitudes]
    true = None if reference is None or reference.attitude is None else angles_deg(reference.attitude)
    plots = figure.subplots(3, 1, sharex=True)
    for plot, (key, title) in zip(plots, ANGLES, strict=True):
        if true is not None and reference is not None:
            y = _beside(true[key], reference.time, found[0][key], attitudes[0].time)
            plot.plot(reference.time, y, color="black", linewidth=2.4, alpha=0.35, label="reference")
        for k, a in enumerate(attitudes):
            y = _beside(found[k][key], a.time, found[0][key], attitudes[0].time)
            at = extreme_indices(y, 6000)
            plot.plot(a.time[at], y[at], color=COLORS[k % len(COLORS)], linewidth=0.9, label=a.filter)
        plot.set(ylabel=f"{title.lower()} (°)")
        dress(plot)
    plots[-1].set(xlabel="time (s)")
    plots[0].legend(frameon=False, fontsize=9, ncols=4)
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=150, format=path.suffix[1:].lower())
