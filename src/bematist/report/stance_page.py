"""The page of `bematist stance`: signals, statistic, threshold and verdict, and a threshold to try in the browser."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.intervals import intervals
from bematist.recording import Recording
from bematist.report import summary
from bematist.report.page import header, page_data, panel_section, write_page
from bematist.report.subject import Panel
from bematist.report.traces import Budget, Trace, encode, line, shading

if TYPE_CHECKING:
    from bematist.stance import StanceAnalysis

Array = NDArray[np.float64]

JUDGED = 300_000
"""Samples of the statistic that the page judges anew when the threshold moves; of longer recordings every second, third … one."""

BINS = 160

LEVELS = 65_534
"""Steps into which the decades of the statistic are divided on the page: a few ten-thousandths of a decade each."""

NAMES = {
    "shoe": "SHOE: specific force against gravity, and angular rate",
    "ared": "angular rate energy",
    "amvd": "moving variance of the specific force",
    "amag": "magnitude of the specific force",
    "gyro": "rms angular rate (rad/s)",
}


def write_stance_page(recording: Recording, analysis: StanceAnalysis, path: str | Path) -> None:
    """Write the page about the stance detection of a recording.

    Raises
    ------
    DataError
        There is no statistic to show, or the page cannot be written.
    """
    statistic = np.where(analysis.statistic > 0, analysis.statistic, np.nan)
    if not np.isfinite(statistic).any():
        raise DataError(
            f"{recording.source or 'The recording'}: the stance statistic has no value anywhere. "
            "Look at the recording with `bematist info`: specific force or angular rate may be missing."
        )
    figures = _panels(recording, analysis, statistic)
    name = Path(recording.source).name if recording.source else "Recording"
    subtitle = f"Stance detection · {NAMES.get(analysis.detector, analysis.detector)} · {summary.clock(recording.duration_s)}"
    body = "".join(
        [
            header(name, subtitle),
            summary.warning_list(recording.warnings),
            _control(),
            f'<main class="timeline">{"".join(map(panel_section, figures))}</main>',
        ]
    )
    data = page_data(figures, (), analysis.time) | {"stance": _live(analysis, statistic)}
    write_page(Path(path), f"{name}: stance", body, data, "stance.js")


def _panels(recording: Recording, analysis: StanceAnalysis, statistic: Array) -> list[Panel]:
    t = analysis.time
    edges = intervals(analysis.stance)
    budget = Budget(1)

    def over_stance(*traces: Trace) -> list[Trace]:
        return [shading(edges, t, "@stance/0.22", "stance"), *traces]

    note = "Shaded: the foot is taken to stand."
    found = [
        Panel(
            "statistic",
            "Stance statistic",
            "statistic",
            over_stance(
                line(t, statistic, budget.fast, "@0", "statistic", hovertemplate="%{y:.3g}"),
                {
                    **line(t, analysis.threshold, budget.fast, "@1", "threshold", dash="dash", width=2, hovertemplate="%{y:.3g}"),
                    "meta": "threshold",
                },
            ),
            note,
            log=True,
        )
    ]
    signals = (
        ("force", "Specific force", "norm (m/s²)", recording.specific_force, 1.0, "%{y:.2f} m/s²"),
        ("rate", "Angular rate", "norm (°/s)", recording.angular_rate, float(np.degrees(1.0)), "%{y:.1f} °/s"),
    )
    for key, title, axis, values, scale, hover in signals:
        norm = np.linalg.norm(values, axis=1) * scale
        good = np.isfinite(norm)  # where the sensors run at different rates a row without a sample is no gap
        if good.any():
            trace = line(recording.time[good], norm[good], budget.fast, "@0", hovertemplate=hover)
            found.append(Panel(key, title, axis, over_stance(trace), note))
    return found


def _control() -> str:
    return (
        '<section class="control"><div><h2>How often the statistic has which value</h2>'
        '<p class="note">Standing on the left, moving on the right; a threshold in the valley between them tells them '
        "apart. Click to try one.</p>"
        '<div class="plot" id="plot-histogram"></div></div>'
        "<div><h2>Try a threshold</h2>"
        '<p><input type="range" id="threshold-slider" min="0" max="1000" step="1" aria-label="threshold"></p>'
        '<p class="row"><label>Threshold <input type="text" id="threshold" inputmode="decimal" autocomplete="off"></label>'
        '<button type="button" id="threshold-reset">as analysed</button></p>'
        '<div class="cards" id="stance-numbers"></div>'
        '<p class="note">Use it with</p><p><code id="command"></code></p></div></section>'
    )


def _live(analysis: StanceAnalysis, statistic: Array) -> dict[str, Any]:
    """What the browser needs to judge anew: time, log10 of the statistic in fine steps, and its histogram."""
    stride = -(-len(statistic) // JUDGED)
    logs = np.log10(statistic)
    finite = logs[np.isfinite(logs)]
    low, high = float(finite.min()), float(finite.max())
    high = high if high > low else low + 1.0
    counts, edges = np.histogram(finite, BINS, (low, high))
    thresholds = analysis.threshold[np.isfinite(analysis.threshold) & (analysis.threshold > 0)]
    start = float(np.median(thresholds)) if len(thresholds) else 10 ** ((low + high) / 2)
    return {
        "time": encode(analysis.time[::stride]),
        "statistic": _levels(logs[::stride], low, high),
        "low": low,
        "high": high,
        "levels": LEVELS,
        "threshold": start,
        "histogram": {
            "x": (10 ** ((edges[1:] + edges[:-1]) / 2)).tolist(),
            "y": (100 * counts / len(statistic)).tolist(),
        },
        "options": _options(analysis),
    }


def _levels(logs: Array, low: float, high: float) -> str:
    """log10 values as base64 of uint16 steps from low to high; 65535 where there is none."""
    steps = np.round((logs - low) / (high - low) * LEVELS)
    return base64.b64encode(np.where(np.isfinite(steps), steps, 65_535).astype("<u2").tobytes()).decode("ascii")


def _options(analysis: StanceAnalysis) -> str:
    """Options beside the threshold that make the command say the same as the page."""
    p = analysis.parameters
    words = [f"--set stance.detector={p.detector}"] if p.detector != type(p).model_fields["detector"].default else []
    return " ".join([*words, *(["--set stance.rule=absolute"] if p.rule != "absolute" else [])])
