"""The page of a calibration: the spheres before and after, the errors, the turns, and the numbers with their uncertainty."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bematist.calibrate import Calibration
from bematist.calibrate.words import counted, error_text, rows, verdict
from bematist.errors import DataError
from bematist.report import summary
from bematist.report.calibration_spheres import Sphere, spheres
from bematist.report.page import header, plot_section, write_plots
from bematist.report.traces import Trace, encode, text


def write_calibration_page(found: Calibration, path: str | Path) -> None:
    """Write a page about a calibration that was just made (`found.evidence`).

    Raises
    ------
    DataError
        The calibration was read from a file, which holds no evidence, or the page cannot be written.
    """
    if found.evidence is None:
        raise DataError("A calibration that was read from a file has no evidence to show. Calibrate from the recording.")
    drawn, name, rests = spheres(found), Path(found.source).name or "Calibration", found.evidence.rests
    swayed = f", {rests.left_out} more turned slowly or swayed" if rests.left_out else ""
    plots = [p for s in drawn for p in (_ball(s), _errors(s))] + _turns(found)
    body = "".join(
        [
            header(name, f"Calibration · {', '.join(found.sensors)} · {len(rests)} rests{swayed}"),
            f'<section class="cards">{"".join(_card(found, s) for s in found.sensors)}</section>',
            summary.warning_list(found.warnings),
            f'<main class="figures"><div class="timeline">{"".join(map(plot_section, plots))}</div></main>',
            _numbers(found),
        ]
    )
    write_plots(path, f"{name}: calibration", body, plots)


def _card(found: Calibration, sensor: str) -> str:
    s = found[sensor]
    return summary.card(sensor.capitalize(), verdict(s), f"{counted(s)}: {error_text(s)}")


def _numbers(found: Calibration) -> str:
    cells = [[summary.escape(c) for c in row] for s in found.sensors.values() for row in rows(s)]
    return f"<section><h2>Parameters</h2>{summary.table(['Sensor', '', 'x', 'y', 'z', 'Unit'], cells)}</section>"


def _ball(s: Sphere) -> dict[str, Any]:
    traces: list[Trace] = [_globe()]
    for name, points, color in ((f"as read{s.shifted}", s.before, "@1"), ("calibrated", s.after, "@0")):
        traces.append(_points(points[s.kept], color, name))
    if (~s.kept).any():
        traces.append(_points(s.after[~s.kept], "@3", "left out, calibrated"))
    note = f"{s.what.capitalize()}, over the length they should have; the sphere is that length. Drag to turn."
    return {"key": f"{s.sensor}-ball", "kind": "ball", "title": f"{s.sensor.capitalize()} on the sphere", "note": note, "traces": traces}


def _points(points: Any, color: str, name: str) -> Trace:
    x, y, z = np.asarray(points).T
    marker = {"size": 2.6, "color": color}
    return {"type": "scatter3d", "mode": "markers", "x": encode(x), "y": encode(y), "z": encode(z), "name": text(name), "marker": marker}


def _globe() -> Trace:
    """Meridians and parallels of the unit sphere."""
    t = np.linspace(0, 2 * np.pi, 73)
    rings = [np.column_stack([np.cos(t) * np.cos(a), np.cos(t) * np.sin(a), np.sin(t)]) for a in np.radians(np.arange(0, 180, 30))]
    rings += [
        np.column_stack([np.cos(b) * np.cos(t), np.cos(b) * np.sin(t), np.full_like(t, np.sin(b))])
        for b in np.radians((-60, -30, 0, 30, 60))
    ]
    x, y, z = np.concatenate([np.vstack([r, np.full(3, np.nan)]) for r in rings]).T
    line = {"color": "@ink/0.25", "width": 1}
    return {
        "type": "scatter3d",
        "mode": "lines",
        "x": encode(x),
        "y": encode(y),
        "z": encode(z),
        "line": line,
        "hoverinfo": "skip",
        "showlegend": False,
    }


def _errors(s: Sphere) -> dict[str, Any]:
    number = np.arange(1, len(s.kept) + 1)
    traces = []
    for name, error, color in zip((f"as read{s.shifted}", "calibrated"), s.errors, ("@1", "@0"), strict=True):
        traces.append(_flat(number[s.kept], error[s.kept], color, name))
    return {
        "key": f"{s.sensor}-error",
        "kind": "flat",
        "title": f"{s.sensor.capitalize()}: error of the length",
        "note": s.what.capitalize() + ", in their order.",
        "traces": traces,
        "x": "rest" if s.sensor == "accelerometer" else "sample",
        "y": "error (%)",
    }


def _flat(x: Any, y: Any, color: str, name: str) -> Trace:
    return {"type": "scatter", "mode": "markers", "x": encode(x), "y": encode(y), "name": text(name), "marker": {"size": 5, "color": color}}


def _turns(found: Calibration) -> list[dict[str, Any]]:
    if found.evidence is None or not len(found.evidence.turns) or "gyroscope" not in found.sensors:
        return []
    way, before, after = found.evidence.turns.T
    traces = [_flat(way, before, "@1", "as read"), _flat(way, after, "@0", "calibrated")]
    note = "By how much gravity at the next rest is missed when the gyroscope carries it there, over the way turned; outliers too."
    return [
        {
            "key": "turns",
            "kind": "flat",
            "title": "Gyroscope: turns between rests",
            "note": note,
            "traces": traces,
            "x": "turned (°)",
            "y": "missed by (°)",
        }
    ]
