"""The words and numbers of a page: cards, tables of methods and errors, warnings, parameters. All text is escaped here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from bematist.report.subject import Subject
from bematist.trajectory import NORTH, Trajectory

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation

DASH = "–"


def number(value: object, unit: str = "", digits: int = 2) -> str:
    """A number with its unit for a person; a dash where there is none."""
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        return DASH
    shown = f"{value:,.{digits}f}".replace("-", "\N{MINUS SIGN}").replace(",", "\N{NARROW NO-BREAK SPACE}")
    return f"{shown}\N{NO-BREAK SPACE}{unit}" if unit else shown


def clock(seconds: float) -> str:
    """A duration as a person says it."""
    if not math.isfinite(seconds):
        return DASH
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest:02d} s"


def cards(trajectory: Trajectory, evaluation: Evaluation | None) -> str:
    """The summary of one trajectory."""
    s = trajectory.summary()
    above = f"; height {number(s['position_sd_m'][2], 'm')}" if trajectory.has_height else ""
    found = [
        (
            "Distance",
            number(s["distance_m"], "m", 1),
            "from stance to stance, in space" if trajectory.steps is None else "sum of the steps",
        ),
        ("Duration", clock(s["duration_s"]), f"{number(s['samples'], '', 0)} samples at {rate(trajectory)}"),
        ("Closure", number(s["closure_m"], "m"), _percent(s["closure_percent"], "of the distance, end to start")),
        _risen(trajectory, s["height_change_m"]),
        ("Uncertainty at the end", plan_sd(trajectory), "1 σ in plan" + above),
        _feet(trajectory),
        ("North", *NORTH[trajectory.north]),
        ("Processing", spent(s["processing_s"]), pace(trajectory)),
    ]
    if shares := paces(trajectory):
        found.insert(6, ("Running", shares[2], f"of the time; walking {shares[1]}, slow {shares[0]}"))
    if evaluation is not None:
        error = evaluation.to_dict()
        note = f"rms in plan, {number(evaluation.rows, '', 0)} {_matched(evaluation)}, alignment {evaluation.alignment}"
        found.insert(3, ("Error to reference", number(error["ate_rmse_2d_m"], "m"), note))
    return '<div class="cards">' + "".join(card(*row) for row in found) + "</div>"


def _risen(trajectory: Trajectory, change_m: float) -> tuple[str, str, str]:
    """The change of height, or why there is none."""
    if trajectory.has_height:
        return "Height change", signed(change_m, "m"), "end against start"
    return "Height", "unknown", "no barometer told it; steps on stairs count as steps on level ground"


def _feet(trajectory: Trajectory) -> tuple[str, str, str]:
    """Stances of a shoe, or steps of a hand's path."""
    steps = trajectory.steps
    if steps is None:
        phases = number(len(trajectory.stance_intervals()), "", 0)
        return "Stance", _percent(100 * float(trajectory.stance.mean())), f"of the time, in {phases} phases"
    if not len(steps):
        return "Steps", "0", ""
    typical = f"{number(float(np.median(steps.frequency)), 'Hz')} and {number(float(np.median(steps.length)), 'm')} in the median"
    return "Steps", number(len(steps), "", 0), typical


def card(label: str, value: str, note: str) -> str:
    return (
        f'<div class="card"><div class="label">{escape(label)}</div><div class="value">{escape(value)}</div>'
        f'<div class="note">{escape(note)}</div></div>'
    )


def _matched(evaluation: Evaluation) -> str:
    return "footfalls" if evaluation.matched == "footfalls" else "instants"


def _percent(value: object, what: str = "") -> str:
    return f"{number(value, '%', 1 if isinstance(value, float) and value >= 1 else 2)} {what}".strip()


def signed(value: float | None, unit: str) -> str:
    shown = number(value, unit)
    return "+" + shown if value is not None and value >= 0.005 else shown


def rate(trajectory: Trajectory) -> str:
    n, duration = len(trajectory) - 1, float(trajectory.time[-1] - trajectory.time[0])
    return number(n / duration, "Hz", 0 if n / duration > 20 else 1) if n > 0 and duration > 0 else DASH


def plan_sd(trajectory: Trajectory) -> str:
    """Largest semi-axis of the ellipse at the end."""
    xx, xy, _, yy = (float(v) for v in trajectory.packed_covariance[-1, :4])
    if not math.isfinite(xy):
        xy = 0.0
    return number(math.sqrt(max(0.0, (xx + yy) / 2 + math.hypot((xx - yy) / 2, xy))), "m") if xx + yy >= 0 else DASH


def spent(seconds: float) -> str:
    """A processing time."""
    return number(seconds, "s") if not seconds < 0.1 else number(1000 * seconds, "ms", 0)


def pace(trajectory: Trajectory) -> str:
    """Speed of the processing."""
    taken = trajectory.processing_s
    if not (math.isfinite(taken) and taken > 0):
        return ""
    times = float(trajectory.time[-1] - trajectory.time[0]) / taken
    return f"{number(round(len(trajectory) / taken, -3), '', 0)} samples/s, {number(times, '×', 0)} real time"


def about(trajectories: Sequence[Trajectory]) -> str:
    """One line on each method, from the table of methods."""
    from bematist.methods import METHODS

    lines = []
    for name in dict.fromkeys(t.method for t in trajectories if t.method):
        known = METHODS.get(name)
        said = f" {DASH} {escape(known.summary)}" if known else ""
        lines.append(f"<li><b>{escape(name)}</b>{said}</li>")
    return f'<ul class="about">{"".join(lines)}</ul>' if lines else ""


def warnings(drawn: Sequence[Subject]) -> str:
    """All warnings, each once, with the methods it is about where it is not about all."""
    found: dict[str, list[str]] = {}
    for s in drawn:
        for w in dict.fromkeys(s.trajectory.warnings):
            found.setdefault(w, []).append(s.name)
    return warning_list(w if len(names) == len(drawn) else f"{', '.join(names)}: {w}" for w, names in found.items())


def warning_list(texts: Iterable[str]) -> str:
    """Warnings, each once; nothing without one."""
    items = "".join(f"<li>{escape(w)}</li>" for w in dict.fromkeys(texts))
    return f'<section class="warnings"><h2>Warnings</h2><ul>{items}</ul></section>' if items else ""


def paces(trajectory: Trajectory) -> list[str]:
    """Shares of the time that was slow, walking and running; empty where a method does not tell them apart."""
    value = np.asarray(trajectory.diagnostics.get("pace", ()), float)
    value = value[np.isfinite(value)]
    return [number(100 * float((value == k).mean()), "%", 0) for k in range(3)] if len(value) else []


def methods_table(drawn: Sequence[Subject], evaluations: Sequence[Evaluation | None]) -> str:
    """The methods side by side, with their error where there is a reference."""
    head = ["Method", "Distance", "Closure", "of distance", "Height change", "1 σ at the end, plan"]
    shoe, hand = (any((s.trajectory.steps is None) == on_shoe for s in drawn) for on_shoe in (True, False))
    head += ["Stance", "Phases"] * shoe + ["Steps"] * hand + ["Processing"]
    kinds = list(dict.fromkeys(str(e.alignment) for e in evaluations if e is not None))
    shares = [paces(s.trajectory) for s in drawn]
    head[-1:-1] = ["Slow / walking / running"] if any(shares) else []
    head[1:1] = [f"Error in plan, rms [{' / '.join(kinds)}]"] if kinds else []
    rows = []
    for s, e, share in zip(drawn, evaluations, shares, strict=True):
        t = s.trajectory
        m = t.summary()
        cells = [
            *([number(e.ate_plan_m if e else None, "m")] if kinds else []),
            number(m["distance_m"], "m", 1),
            number(m["closure_m"], "m"),
            _percent(m["closure_percent"]),
            signed(m["height_change_m"], "m"),
            plan_sd(t),
            *([_percent(100 * m["stance_fraction"]), number(len(t.stance_intervals()), "", 0)] if t.steps is None else [DASH] * 2 * shoe),
            *([DASH if t.steps is None else number(len(t.steps), "", 0)] * hand),
            *([" / ".join(share) or DASH] if any(shares) else []),
            spent(m["processing_s"]),
        ]
        rows.append([_swatch(s), *map(escape, cells)])
    return f"<section><h2>Methods side by side</h2>{table(head, rows)}</section>"


def _swatch(s: Subject) -> str:
    return f'<i class="swatch" style="background:var(--c{s.color[1:]})"></i>{escape(s.name)}'


def errors_table(drawn: Sequence[Subject], evaluations: Sequence[Evaluation | None]) -> str:
    """Errors against the reference; the alignment stands in each name, as `Evaluation.table` gives it."""
    known = [(s, e) for s, e in zip(drawn, evaluations, strict=True) if e is not None]
    if not known:
        return ""
    columns = [{(name, unit): value for name, value, unit in e.table()} for _, e in known]
    keys = list(dict.fromkeys(key for column in columns for key in column))
    head = ["Error", *("Value" if s.alone else s.name for s, _ in known), "Unit"]
    rows = [[escape(name), *(_value(c.get((name, unit))) for c in columns), escape(unit)] for name, unit in keys]
    notes = dict.fromkeys(note for _, e in known for note in e.notes)
    said = "".join(f"<p class='note'>{escape(note)}</p>" for note in notes)
    shut = "" if len(drawn) > 1 else "<summary>Errors against the reference</summary>"
    body = table(head, rows) + said
    if shut:
        return f'<details class="fold" open>{shut}{body}</details>'
    return f"<section><h2>Errors against the reference</h2>{body}</section>"


def _value(value: object) -> str:
    if isinstance(value, float):
        return escape(number(value, "", 3))
    return escape(DASH if value is None else str(value))


def table(head: Iterable[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; `head` is text, the cells are HTML. The first column names the row."""
    top = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join(f"<tr><th>{r[0]}</th>" + "".join(f"<td>{c}</td>" for c in r[1:]) + "</tr>" for r in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def parameters(used: Sequence[tuple[str, Mapping[str, Any]]]) -> str:
    """All parameters that were used, by the method's name (empty when it is the only one), in a fold-out; differences are marked."""
    columns = [dict(_flat(values)) for _, values in used]
    keys = list(dict.fromkeys(key for column in columns for key in column))
    if not keys:
        return ""
    head = ["Parameter", *(name or "Value" for name, _ in used)]
    rows = []
    for key in keys:
        values = [column.get(key, DASH) for column in columns]
        mark = "<b>{}</b>" if len(set(values)) > 1 else "{}"
        rows.append([mark.format(escape(key)), *(mark.format(escape(v)) for v in values)])
    note = "<p class='note'>Bold: where the methods differ.</p>" if len(used) > 1 else ""
    return f'<details class="fold"><summary>Parameters used</summary>{note}{table(head, rows)}</details>'


def _flat(value: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, str]]:
    for key, item in value.items():
        if isinstance(item, Mapping):
            yield from _flat(item, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", f"{item:.6g}" if isinstance(item, float) else str(item)
