"""One self-contained HTML page: plotly.js, style, script and data in a single file that asks the network for nothing."""

from __future__ import annotations

import importlib.util
import json
import re
from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.floorplan import FloorPlan
from bematist.recording import Reference
from bematist.report import ground, summary
from bematist.report.overlay import Overlay, evaluate_all, overlay
from bematist.report.panels import panels
from bematist.report.plan import plan
from bematist.report.subject import Panel, Subject, subjects
from bematist.trajectory import NORTH, Trajectory

if TYPE_CHECKING:
    from bematist.evaluate import Align, Evaluation

Array = NDArray[np.float64]

ASSETS = Path(__file__).parent / "assets"


def write_report(
    trajectories: Sequence[Trajectory],
    path: str | Path,
    reference: Reference | None = None,
    evaluations: Sequence[Evaluation | None] | None = None,
    floor_plan: FloorPlan | None = None,
    align: Align = "yaw",
) -> None:
    """Write a page about one trajectory, or about several of the same recording side by side.

    Parameters
    ----------
    trajectories : at least one, each with at least one sample.
    path : the page; it appears whole or not at all.
    reference : the true path. It is drawn in the frame of the trajectory that fits it best, the other trajectories as their
        alignments with it lay them over it.
    evaluations : one for each trajectory, or None where there is none; without them they are made here, aligned by `align`.
    floor_plan : a plan of the building to draw the paths on, see `bematist.read_floor_plan`.

    Raises
    ------
    UsageError
        No trajectory, or another number of evaluations.
    DataError
        A trajectory without samples, or the page cannot be written.
    """
    if not trajectories:
        raise UsageError("A report needs at least one trajectory.")
    if any(not len(t) for t in trajectories):
        raise DataError("A trajectory has no samples: there is nothing to show.")
    if evaluations is not None and len(evaluations) != len(trajectories):
        raise UsageError(f"There are {len(trajectories)} trajectories and {len(evaluations)} evaluations: give one for each.")
    found = list(evaluations) if evaluations is not None else evaluate_all(trajectories, reference, align)
    write_page(Path(path), *_content(subjects(trajectories), reference, found, floor_plan))


def _content(
    drawn: Sequence[Subject], reference: Reference | None, evaluations: Sequence[Evaluation | None], floor_plan: FloorPlan | None
) -> tuple[str, str, dict[str, Any]]:
    """Title, HTML and data of the page."""
    first = drawn[0].trajectory
    laid = overlay([s.trajectory for s in drawn], reference, evaluations)
    local = laid.reference(reference)
    figures = panels(drawn, local)
    traces = plan(drawn, local, laid, evaluations, floor_plan)
    source = Path(first.source).name if first.source else "Recording"
    methods = ", ".join(s.name or s.trajectory.method for s in drawn)
    body = "".join(
        [
            header(source, _subtitle(first, methods)),
            summary.cards(first, evaluations[0]) if len(drawn) == 1 else summary.methods_table(drawn, evaluations),
            summary.about([s.trajectory for s in drawn]),
            summary.warnings(drawn),
            '<main class="figures">',
            plan_section(_plan_note(reference, laid, drawn)) if traces else "",
            f'<div class="timeline">{"".join(map(panel_section, figures))}</div></main>',
            summary.errors_table(drawn, evaluations),
            summary.parameters([(s.name, s.trajectory.parameters) for s in drawn]),
        ]
    )
    data = page_data(figures, traces, first.time)
    paths = [laid.path(k, s.trajectory.position, np.empty((0, 3, 3)))[0] for k, s in enumerate(drawn)]
    data["image"] = ground.image(floor_plan)
    data["view"] = ground.view([*paths, *([local.position] if local else [])])
    return f"{source}: {methods or 'path'}", body, data


def _subtitle(t: Trajectory, methods: str) -> str:
    seconds = float(t.time[-1] - t.time[0])
    return f"{methods or 'path'} · {summary.clock(seconds)} · {summary.number(len(t), '', 0)} samples"


def _plan_note(reference: Reference | None, laid: Overlay, drawn: Sequence[Subject]) -> str:
    note = f"{_directions(drawn[laid.anchor].trajectory)} Equal axes. Ellipses: where the filter is 95 % sure to be."
    if reference is None:
        return note
    truth = f"The reference{f' ({reference.note})' if reference.note else ''}"
    if laid.frame is None or laid.frame.kind == "none":
        return f"{note} {truth} is drawn as it stands, not aligned."
    if len(drawn) == 1:
        return f"{note} {truth} is laid over the path by alignment {laid.frame}."
    name = drawn[laid.anchor].name
    return f"{note} Each path is laid over the reference by alignment {laid.frame}; the axes are those of {name}."


def _directions(t: Trajectory) -> str:
    """What right and up of the plan are."""
    word, how = NORTH[t.north]
    if t.north == "none":
        return "The axes are the path's own, for nothing tells North: the start is along its East, to the right."
    return f"Up is {'' if t.north == 'given' else f'{word} '}North, {how}; East to the right."


def page_data(figures: Sequence[Panel], traces: Sequence[dict[str, Any]], time: Array) -> dict[str, Any]:
    """What the script of the page reads; it shows the times (N,) from the first to the last."""
    finite = time[np.isfinite(time)]
    return {
        "range": [float(finite[0]), float(finite[-1])],
        "plan": list(traces),
        "panels": [{"key": p.key, "axis": p.axis, "log": p.log, "traces": p.traces, "layout": p.layout} for p in figures],
    }


def header(title: str, subtitle: str) -> str:
    return f'<header><div><h1>{escape(title)}</h1><p class="subtitle">{escape(subtitle)}</p></div><p class="brand">bematist</p></header>'


def plan_section(note: str) -> str:
    return (
        '<section class="panel plan"><h2>Path in plan</h2>'
        f'<p class="note">{escape(note)}</p><div class="plot" id="plot-plan"></div></section>'
    )


def panel_section(panel: Panel) -> str:
    note = f'<p class="note">{escape(panel.note)}</p>' if panel.note else ""
    return (
        f'<section class="panel" id="panel-{panel.key}"><h2>{escape(panel.title)}</h2>{note}'
        f'<div class="plot" id="plot-{panel.key}"></div></section>'
    )


def plot_section(plot: Mapping[str, Any]) -> str:
    """A panel of a page that `plots.js` draws: key, kind, title and note."""
    return (
        f'<section class="panel"><h2>{escape(plot["title"])}</h2><p class="note">{escape(plot["note"])}</p>'
        f'<div class="plot {plot["kind"]}" id="plot-{plot["key"]}"></div></section>'
    )


def write_plots(path: str | Path, title: str, body: str, plots: Sequence[Mapping[str, Any]]) -> None:
    """Write a page of plots that do not share a time axis (`plot_section`). DataError where it cannot be written."""
    write_page(Path(path), title, body, {"range": [0.0, 1.0], "plan": [], "panels": [], "plots": plots}, "plots.js")


def write_page(path: Path, title: str, body: str, data: Mapping[str, Any], script: str = "") -> None:
    """Write a page; `body` is HTML, `title` text, `script` a further script of `assets`.

    Raises
    ------
    DataError
        The file cannot be written.
    """
    from bematist import __version__
    from bematist.outputs import whole_file

    # In a script element only "<" can do harm: it might end the element.
    payload = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = {
        "title": escape(title),
        "style": asset("page.css"),
        "plotly": plotly_script(),
        "body": body,
        "data": payload,
        "script": asset("page.js") + (asset(script) if script else ""),
        "hint": _hint(data),
        "version": escape(__version__),
    }
    # One pass: what is put in is never searched for marks again.
    pieces = re.split(r"\{\{(\w+)\}\}", asset("page.html"))
    page = "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))
    with whole_file(path) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _hint(data: Mapping[str, Any]) -> str:
    """How to handle the plots that a page has."""
    turn = "Drag a sphere to turn it. " if any(plot["kind"] == "ball" for plot in data.get("plots", ())) else ""
    follow = " in time: all plots follow" if data["panels"] else ""
    path = " Hover to find the place on the path." if data["plan"] and data["panels"] else ""
    return f"{turn}Drag in a plot to zoom{follow}. Double-click to see everything again.{path}"


@cache
def asset(name: str) -> str:
    """A file of the page's template."""
    return (ASSETS / name).read_text(encoding="utf-8")


@cache
def plotly_script() -> str:
    """plotly.js as the plotly package carries it; the package itself is not imported, which would take longer than the rest.

    Raises
    ------
    DataError
        plotly is not installed as it should be.
    """
    spec = importlib.util.find_spec("plotly")
    for folder in (spec.submodule_search_locations or []) if spec else []:
        file = Path(folder) / "package_data" / "plotly.min.js"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise DataError("The report needs plotly, and its plotly.min.js was not found: install the package plotly anew.")
