"""Tables and figures of consistency and sensitivity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from bematist.evaluate import nees_bounds
from bematist.reproduce.maginav import consistency, sensitivity
from bematist.reproduce.maginav.sensitivity import BASELINE, TRANSPOSED
from bematist.reproduce.maginav.show import METHOD_COLORS
from bematist.reproduce.page import Cell, Page
from bematist.reproduce.plots import sheet
from bematist.reproduce.study import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def average_nees(results: Results) -> dict[tuple[str, str], np.ndarray]:
    """Mean NEES (K,3) over the seeds at each instant, by set-up and method."""
    found = {}
    for setup in consistency.SETUPS:
        cases = results.where(setup=setup)
        for method in cases[0].settings["methods"]:
            found[setup, method] = np.nanmean([c.arrays[method] for c in cases], axis=0)
    return found


def show_consistency(results: Results, page: Page) -> None:
    """NEES against its bounds."""
    seeds = len(results.where(setup="shipped, disturbed"))
    low, high = nees_bounds(seeds)
    page.text(
        "The normalised estimation error squared (NEES) of three components has mean 3 where the errors are as large as the filter says. "
        f"Over {seeds} walks its mean at an instant lies in {low:.2f} – {high:.2f} with 95 %. *Matched*: white noise and constant offsets, "
        "of which the filter is told (zero velocity and first tilt a little too modestly). *Shipped*: the sensor of Table 3 with its bias "
        "instability, and the methods as they come."
    )
    found = average_nees(results)
    rows: list[list[Cell]] = []
    for (setup, method), a in found.items():
        frame = results.frame.filter((pl.col("setup") == setup) & (pl.col("method") == method))
        error = float(np.sqrt(np.mean(frame["heading_deg"].to_numpy() ** 2)))
        inside = [f"{np.nanmean(a[:, k]):.3g} ({100 * np.nanmean((a[:, k] > low) & (a[:, k] < high)):.0f} %)" for k in range(3)]
        rows.append([setup, method, *inside, error, float(np.sqrt(np.mean(frame["heading_sd_deg"].to_numpy() ** 2)))])
    header = ["set-up", "method", *(f"NEES {q}" for q in consistency.QUANTITIES), "last heading, rms error °", "last heading, rms sd °"]
    page.table(
        "consistency",
        header,
        rows,
        "Mean over instants and seeds, in brackets the share of instants whose mean over seeds is in the bounds.",
    )
    page.figure("consistency", _nees_figure(found, low, high), "NEES over the walk, mean over the seeds; grey: 95 % bounds.")
    page.text(
        "Why `zupt` with matched noise is honest for a minute and not for twenty: the heading is not observable, and what the filter "
        "says of "
        "it must only get worse. With samples free of noise it does (the row without noise: its standard deviation is what the offset "
        "left by "
        "ten seconds of rest makes of the heading). With noise, every stance is linearised about another wrong velocity, and the filter "
        "takes "
        "what does not agree for information about the heading: its standard deviation shrinks several times, its error does not. "
        "*Invariant* (`linearisation`, see the page on the filter) takes that away; a heading wrong by several degrees then still bends a "
        "path further than its first order says.",
        "`maginav` with matched noise has no such fault, since TRIAD observes the heading. What all its attitudes share, the errors of "
        "field "
        "and tilt at the start, has no state in the filter and grows with the distance from the start; that is probably what is left in "
        "its position.",
        "As shipped, `zupt` and `maginav` are too sure of the position: besides the above, of bias instability, of disturbed fields, and "
        "of "
        "the moving samples that γ = 150 takes for stance (see the tuned walks). `foot` is far too modest: its noise is set for real feet, "
        "which roll and strike where the simulated one stands still. Velocity is below 3 in stance, where that foot is stiller than σ_v "
        "says.",
    )


def _nees_figure(found: dict[tuple[str, str], np.ndarray], low: float, high: float) -> Figure:
    setups = [s for s in consistency.SETUPS if "without" not in s]
    figure, axes = sheet(len(setups), 3, width=9.5, height=1.9 * len(setups))
    for row, setup in enumerate(setups):
        for k, quantity in enumerate(consistency.QUANTITIES):
            a = axes[3 * row + k]
            a.axhspan(low, high, color="#8a8f98", alpha=0.35, linewidth=0)
            for (s, method), values in found.items():
                if s == setup:
                    share = np.linspace(0, 1, len(values) + 1)[1:]
                    a.plot(share, np.maximum(values[:, k], 1e-3), color=METHOD_COLORS[method], linewidth=1.2, label=method)
            a.set_yscale("log")
            a.set_ylim(2e-3, 2e3)
            a.set_title(f"{setup}: {quantity}", loc="left", fontsize=9)
    for a in axes[-3:]:
        a.set_xlabel("share of the walk")
    axes[6].legend(frameon=False, fontsize=8)
    return figure


def relative(frame: pl.DataFrame, column: str) -> pl.DataFrame:
    """Each row's value over that of the baseline of its walk, seed and method, as column "ratio"."""
    keys = ["walk", "seed", "method"]
    base = frame.filter(pl.col("choice") == BASELINE).select(*keys, pl.col(column).alias("base"))
    return frame.join(base, on=keys).with_columns(ratio=pl.col(column) / pl.col("base"))


def show_sensitivity(results: Results, page: Page) -> None:
    """One-at-a-time changes against the methods as shipped."""
    frame = results.frame
    page.text(
        f"{frame['seed'].n_unique()} campus walks, disturbed unless said; one choice is changed at a time. *Still foot*: the simulated "
        "foot stands "
        "exactly still between heel strike and heel-off. *Rocking foot*: it rolls by 3° about its toes meanwhile, as real feet do, and the "
        "choices about stance are judged anew. Shipped are: N = 9 samples, γ = 150, window centred, σ_v = 0.01 m/s, f turned at the "
        "middle of the interval, "
        "exponential, Q = density² τ, 0.1 °/√s, start averaged over 10 s; m_thr 5 %, inclination gate 5°, TRIAD in the quiet part of a "
        "stance, P replaced by TRIAD's, eq 11 corrected; gains of the rivals 0.1 /s (β) and 1 /s (kp), drawn by every sample of the field."
    )
    columns = {"rms plan m": "rms_m", "rms heading °": "heading_deg", "rms height m": "height_rms_m", "closure %": "closure_percent"}
    page.spread("sensitivity", frame, ["walk", "method", "choice", "value"], columns, "Over seeds: median (10 % – 90 %; worst).")
    for walk in sensitivity.WALKS:
        part = frame.filter(pl.col("walk") == walk)
        name = f"sensitivity-{walk.replace(',', '').replace(' ', '-')}"
        page.figure(
            name, _ratio_figure(part), f"{walk.capitalize()}: errors over those of the method as shipped, same walk: median, 10 % to 90 %."
        )
    page.text("**Closure is blind.**")
    text = []
    for value in ("", TRANSPOSED):
        part = frame.filter((pl.col("method") == "maginav") & (pl.col("walk") == "still foot") & (pl.col("value") == value))
        closure, rms = part["closure_percent"].median(), part["rms_m"].median()
        text.append(f"{value or 'corrected'}: it closes to {closure:.2g} % and is off by {rms:.3g} m rms")
    page.text("TRIAD " + "; ".join(text) + " (medians).")
    page.figure(
        "closure-is-blind",
        _blind_figure(results),
        "Left: closure against rms, every variant and seed. Right: one path with eq 11 as printed.",
    )


def _ratio_figure(frame: pl.DataFrame) -> Figure:
    frame = frame.filter(pl.col("method").is_in(["zupt", "maginav"]))
    shown = {"rms_m": "rms plan", "heading_deg": "rms heading", "height_rms_m": "rms height"}
    labels = [
        f"{c}: {v}" for c, v in frame.filter(pl.col("choice") != BASELINE).select("choice", "value").unique(maintain_order=True).rows()
    ]
    figure, axes = sheet(1, 3, width=11, height=1.2 + 0.23 * len(labels))
    for a, (column, title) in zip(axes, shown.items(), strict=True):
        ratios = relative(frame, column)
        for k, (method, shift) in enumerate((("zupt", -0.16), ("maginav", 0.16))):
            mine = ratios.filter((pl.col("method") == method) & (pl.col("choice") != BASELINE))
            if mine.is_empty():
                continue
            for (choice, value), group in mine.group_by(["choice", "value"], maintain_order=True):
                y = labels.index(f"{choice}: {value}") + shift
                low, middle, high = np.quantile(group["ratio"].to_numpy(), [0.1, 0.5, 0.9])
                a.plot([low, high], [y, y], color=METHOD_COLORS[method], linewidth=1.5, alpha=0.6)
                a.plot(middle, y, "os"[k], color=METHOD_COLORS[method], markersize=4.5)
            a.plot([], [], "os"[k], color=METHOD_COLORS[method], label=method)
        a.axvline(1, color="black", linewidth=0.8)
        a.set_xscale("log")
        a.set_ylim(len(labels) - 0.5, -0.5)
        a.set_yticks(range(len(labels)), labels if a is axes[0] else [], fontsize=8)
        a.set_title(f"{title}, ratio", fontsize=9)
    axes[-1].legend(frameon=False, fontsize=8)
    return figure


def _blind_figure(results: Results) -> Figure:
    figure, (left, right) = sheet(1, 2, width=10, height=4.6)
    frame = results.frame.filter(pl.col("method") == "maginav")
    wrong = frame["value"] == TRANSPOSED
    left.plot(frame.filter(~wrong)["closure_percent"], frame.filter(~wrong)["rms_m"], ".", color="#8a8f98", label="every other variant")
    left.plot(frame.filter(wrong)["closure_percent"], frame.filter(wrong)["rms_m"], "o", color="#d55e00", label="eq 11 as printed")
    left.axvline(0.25, color="black", linewidth=0.8, linestyle="--")
    left.set(xscale="log", yscale="log", xlabel="closure (% of distance)", ylabel="rms in plan (m)")
    left.legend(frameon=False, fontsize=8)
    case = results.where(walk="still foot")[0]
    for name, color, style in ((TRANSPOSED, "#d55e00", "-"), (BASELINE, "#0072b2", "-"), ("truth", "black", ":")):
        p = case.arrays[name]
        right.plot(p[:, 0], p[:, 1], style, color=color, linewidth=1.2, label=name)
        right.plot(*p[-1], "s", color=color, markersize=6, markeredgecolor="white")
    right.set_aspect("equal", adjustable="datalim")
    right.set(xlabel="east (m)", ylabel="north (m)")
    right.legend(frameon=False, fontsize=8)
    return figure
