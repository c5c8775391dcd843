"""The page of `bematist steps`: why a step was counted, and why the device is taken to be carried so."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bematist.intervals import intervals
from bematist.kernels.steps_layout import CELL_S
from bematist.recording import Recording
from bematist.report import summary
from bematist.report.gait import modes_panel
from bematist.report.page import header, page_data, panel_section, write_page
from bematist.report.subject import Panel
from bematist.report.traces import Budget, Trace, dots, level, line, shading

if TYPE_CHECKING:
    from bematist.steps import StepAnalysis


def write_steps_page(recording: Recording, analysis: StepAnalysis, path: str | Path) -> None:
    """Write the page about the steps of a recording.

    Raises
    ------
    DataError
        The page cannot be written.
    """
    figures = [*_detection(analysis), *_modes(analysis)]
    name = Path(recording.source).name if recording.source else "Recording"
    n = len(analysis.event_time)
    body = "".join(
        [
            header(name, f"Steps · {n} in {summary.clock(recording.duration_s)}"),
            summary.warning_list(recording.warnings),
            f'<main class="timeline">{"".join(map(panel_section, figures))}</main>',
            summary.parameters([("", analysis.parameters.model_dump())]),
        ]
    )
    write_page(Path(path), f"{name}: steps", body, page_data(figures, (), analysis.time))


def _over_walk(a: StepAnalysis, *traces: Trace) -> list[Trace]:
    edges = intervals(a.motion > 0)
    return [shading(edges, a.time, "@stance/0.22", "walking"), *traces]


def _detection(a: StepAnalysis) -> list[Panel]:
    t, n = a.time, Budget(1)
    d = a.parameters.detection
    middle = t - CELL_S / 2  # of the cell that a sample shows, at the latest
    hz = np.where(a.frequency > 0, a.frequency, np.nan)
    seen = np.where(a.feature("period_frequency") > 0, a.feature("period_frequency"), np.nan)
    return [
        Panel(
            "acceleration",
            "Acceleration and steps",
            "m/s²",
            _over_walk(
                a,
                line(middle, a.feature("acceleration"), n.fast, "@muted", "acceleration", hovertemplate="%{y:.2f} m/s²"),
                line(middle, a.feature("step_band"), n.fast, "@0", "in the band of the steps", hovertemplate="%{y:.2f} m/s²"),
                dots(a.event_time, a.event_size, n.slow, "@1", "step", size=6, hovertemplate="step, %{x:.2f} s"),
            ),
            "A dot for each step: a peak of the band-passed acceleration. Shaded: known as a walk at the time; its first steps are "
            "counted when it is recognised, and lie before.",
        ),
        Panel(
            "periodicity",
            "Is it periodic?",
            "autocorrelation",
            _over_walk(
                a,
                line(t, a.feature("periodicity"), n.fast, "@0", "at the step period", hovertemplate="%{y:.2f}"),
                line(
                    t, a.feature("periodicity_asked"), n.fast, "@1", "asked for where a walk begins", dash="dash", hovertemplate="%{y:.2f}"
                ),
            ),
            "A walk begins with some regular steps while the coefficient is above the dashed line, which rises with the rotation.",
        ),
        Panel(
            "frequency",
            "Step frequency",
            "Hz",
            _over_walk(
                a,
                line(t, seen, n.fast, "@muted", "by the period of the signal", hovertemplate="%{y:.2f} Hz"),
                line(t, hz, n.fast, "@0", "step frequency", width=2, hovertemplate="%{y:.2f} Hz"),
                level(t, d.slowest_hz, "@1", "slowest and fastest"),
                level(t, d.fastest_hz, "@1"),
            ),
        ),
    ]


def _modes(a: StepAnalysis) -> list[Panel]:
    t, n, m = a.time, Budget(1), a.parameters.modes

    def values(name: str, color: str, label: str) -> Trace:
        return line(t, a.feature(name), n.fast, color, label, hovertemplate="%{y:.2f}")

    found = [
        modes_panel(t, a.motion, a.carrying, n.slow, *_over_walk(a)),
        Panel(
            "force",
            "How strongly it moves",
            "rms acceleration (m/s²)",
            _over_walk(a, values("force_rms", "@0", "acceleration"), level(t, m.run_force, "@1", "run_force")),
            f"Running: above the line, and at least {m.run_hz:g} steps a second.",
        ),
        Panel(
            "rotation",
            "How strongly it turns",
            "rms angular rate (rad/s)",
            _over_walk(a, values("rate_rms", "@0", "angular rate"), level(t, m.swing_rate, "@1", "swing_rate")),
        ),
        Panel(
            "stride",
            "Does it turn back and forth once a stride?",
            "coefficient",
            _over_walk(a, values("stride_rotation", "@0", "opposite of a step ago"), level(t, m.swing_stride, "@1", "swing_stride")),
            "Swinging or pocket: both this and the angular rate above their lines. 1: each step turns it the other way; -1: each step does "
            "the same.",
        ),
        Panel(
            "tilt",
            "How it is held",
            "cosine to up",
            _over_walk(
                a,
                values("screen_up", "@0", "screen"),
                values("top_up", "@1", "upper end"),
                level(t, m.screen_up, "@0", "screen_up", dash="dot"),
                level(t, m.phone_top, "@1", "phone_top, phone_top_most", dash="dot"),
                level(t, m.phone_top_most, "@1", dash="dot"),
            ),
            "1: it points up, 0: level, -1: down.",
        ),
    ]
    if np.any(a.feature("climb_speed")):
        climb = values("climb_speed", "@0", "speed of climbing")
        found.append(Panel("climb", "Up and down", "m/s", _over_walk(a, climb, level(t, m.climb_speed, "@1", "climb_speed"))))
    return found
