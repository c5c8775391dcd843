"""The page of a sensor's noise: Allan deviations with their intervals and what they are made of, spectral densities, and the numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.allan import AllanResult, SensorAllan, sheet
from bematist.report import summary
from bematist.report.page import header, plot_section, write_plots
from bematist.report.traces import Trace, encode, text

Array = NDArray[np.float64]

FINE = 120
"""Points of a fitted curve."""


def write_allan_page(found: AllanResult, path: str | Path, horizon_s: float) -> None:
    """Write a page about the noises of a sensor; `horizon_s` is that of the noise block (`AllanResult.noise`).

    Raises
    ------
    DataError
        The page cannot be written.
    """
    name = Path(found.source).name if found.source else "Recording"
    plots = [plot for s in found.sensors.values() for plot in (_deviation(s), _density(s))]
    body = "".join(
        [
            header(name, f"Noise at rest · {', '.join(found.sensors)} · {found.start_s:.1f} to {found.end_s:.1f} s"),
            f'<section class="cards">{"".join(_card(s) for s in found.sensors.values())}</section>',
            summary.warning_list(found.warnings),
            f'<main class="pairs">{"".join(map(plot_section, plots))}</main>',
            _coefficients(found),
            _block(found, horizon_s),
        ]
    )
    write_plots(path, f"{name}: noise", body, plots)


def _card(s: SensorAllan) -> str:
    """White noise of a sensor as data sheets write it, and how well its curves are described."""
    white, units = s.white(), sheet.SHEET[s.name]["white"] or ((sheet.SI[s.name]["white"], 1.0),)
    unit, factor = units[-1] if s.name == "gyroscope" else units[0]
    return summary.card(
        f"{s.name.capitalize()}: white noise", summary.DASH if white is None else f"{white * factor:.3g} {unit}", s.verdict()
    )


def _coefficients(found: AllanResult) -> str:
    rows = [[summary.escape(c) for c in sheet.cells(row)] for row in found.coefficients()]
    note = '<p class="note">N is the root of the two-sided density; a data sheet\'s one-sided one is √2 larger.</p>'
    return f"<section><h2>Noises</h2>{note}{summary.table(sheet.HEADER, rows)}</section>"


def _block(found: AllanResult, horizon_s: float) -> str:
    rows = [[f"<code>{name}</code>", f"{value:.4g}"] for name, value in found.noise(horizon_s).items()]
    note = f"Means over the axes; the bias walks equal all slow noises at {horizon_s:g} s. A floor: in motion a shoe needs more."
    left_out = "".join(f"<p class='note'>{summary.escape(reason)}.</p>" for reason in found.left_out(horizon_s))
    table = summary.table(["noise.toml", "SI"], rows) if rows else ""
    return f"<section><h2>What the filter takes</h2><p class='note'>{summary.escape(note)}</p>{table}{left_out}</section>"


def _deviation(s: SensorAllan) -> dict[str, Any]:
    unit, factor = sheet.curve_unit(s.name)
    fine = np.geomspace(s.taus[0], s.taus[-1], FINE)
    traces: list[Trace] = []
    for k, axis in enumerate(s.axes):
        fit, group = s.fits[k], {"legendgroup": axis}
        curve = factor * s.deviation[:, k]
        if fit is not None:
            low, high = factor * s.low[:, k], factor * s.high[:, k]
            traces += _band(s.taus, low, high, f"@{k}/0.15", group)
            for noise in fit.coefficients:
                what = f"{sheet.SYMBOLS[noise]}, {sheet.WORDS[noise]}, {axis}: %{{y:.3~g}} {unit}<extra></extra>"
                traces.append(_line(fine, factor * np.sqrt(fit.part(noise, fine)), f"@{k}", "dot", 0.9, what, group))
            whole = f"fitted noises, {axis}: %{{y:.4~g}} {unit}<extra></extra>"
            traces.append(_line(fine, factor * np.sqrt(fit.variance(fine)), f"@{k}", "dash", 1.2, whole, group))
            about = [f"95 %: {a:.3g} … {b:.3g}, {n:.3g} degrees of freedom" for a, b, n in zip(low, high, s.edf[:, k], strict=True)]
        else:
            about = ["not fitted"] * len(s.taus)
        traces.append(
            _line(s.taus, curve, f"@{k}", "solid", 1.6, f"{axis}, τ = %{{x:.4~g}} s: %{{y:.4~g}} {unit}<br>%{{text}}<extra></extra>", group)
            | {"mode": "lines+markers", "marker": {"size": 5}, "name": text(axis), "showlegend": True, "text": [text(a) for a in about]}
        )
    duration = summary.clock(s.samples / s.rate_hz)
    return {
        "key": f"{s.name}-deviation",
        "kind": "log",
        "title": f"{s.name.capitalize()}: Allan deviation",
        "note": f"{duration} at {s.rate_hz:.4g} Hz. Band: 95 %; dashed: the fitted noises; dotted: each of them.",
        "traces": traces,
        "x": "averaging time τ (s)",
        "y": f"Allan deviation ({unit})",
        "range_x": _decades(s.taus, 0.1),
        "range_y": _decades(factor * s.deviation, 0.35),
    }


def _density(s: SensorAllan) -> dict[str, Any]:
    unit, factor = sheet.curve_unit(s.name)
    root = factor * np.sqrt(s.density)
    traces: list[Trace] = []
    for k, axis in enumerate(s.axes):
        fit, group = s.fits[k], {"legendgroup": axis}
        what = f"{axis}, %{{x:.4~g}} Hz: %{{y:.4~g}} {unit}/√Hz<extra></extra>"
        traces.append(_line(s.frequency, root[:, k], f"@{k}", "solid", 1.1, what, group) | {"name": text(axis), "showlegend": True})
        if fit is not None:
            whole = f"fitted noises, {axis}: %{{y:.4~g}} {unit}/√Hz<extra></extra>"
            fitted = factor * np.sqrt(fit.density(s.frequency, 1 / s.rate_hz))
            traces.append(_line(s.frequency, fitted, f"@{k}", "dash", 1.2, whole, group))
    return {
        "key": f"{s.name}-density",
        "kind": "log",
        "title": f"{s.name.capitalize()}: spectral density",
        "note": "Root of the one-sided density, by Welch's method; dashed: of the fitted noises.",
        "traces": traces,
        "x": "frequency (Hz)",
        "y": f"root of the density ({unit}/√Hz)",
        "range_x": _decades(s.frequency, 0.05),
        "range_y": _decades(root, 0.2),
    }


def _decades(values: Array, margin: float) -> list[float]:
    """Range of a logarithmic axis that shows all of the values, in decades."""
    seen = np.log10(values[np.isfinite(values) & (values > 0)])
    return [float(seen.min() - margin), float(seen.max() + margin)] if len(seen) else [-1.0, 1.0]


def _line(x: Array, y: Array, color: str, dash: str, width: float, hover: str, more: dict[str, Any]) -> Trace:
    return {
        "type": "scatter",
        "mode": "lines",
        "x": encode(x),
        "y": encode(np.where(y > 0, y, np.nan)),
        "line": {"color": color, "dash": dash, "width": width},
        "hovertemplate": hover,
        "showlegend": False,
        **more,
    }


def _band(x: Array, low: Array, high: Array, color: str, more: dict[str, Any]) -> list[Trace]:
    """A band as one closed outline: bands of several axes do not fill to one another."""
    outline = {"x": encode(np.concatenate([x, x[::-1]])), "y": encode(np.concatenate([low, high[::-1]]))}
    return [
        {"type": "scatter", "mode": "lines", **outline, "line": {"width": 0}, "fill": "toself", "fillcolor": color, "hoverinfo": "skip"}
        | {"showlegend": False, **more}
    ]
