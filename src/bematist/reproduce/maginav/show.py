"""Tables and figures of attitude, walks and run times."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from bematist.reproduce.maginav import attitude, tuned, walks
from bematist.reproduce.page import Page
from bematist.reproduce.plots import COLORS, colored, dots, sheet
from bematist.reproduce.study import Result, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METHOD_COLORS = colored(["maginav", "zupt", "foot", "madgwick-zupt", "mahony-zupt", "maginav-printed", "zupt, invariant"])


def show_attitude(results: Results, page: Page) -> None:
    """Figure 3 and its numbers."""
    per_hour = {name: np.degrees(w) * 3600 for name, (_, w) in attitude.BIASES.items()}
    page.text(
        "A still object in a uniform field, with the white noise of Table 3 (of the magnetometer 0.079 µT/√Hz, a hundredth of the print, "
        "which drowns the Earth's field) and a constant offset. The paper does not say how large it is. Two are shown: on every axis "
        + " and ".join(f"{rate:.3g} °/h ({name})" for name, rate in per_hour.items())
        + ". Offsets of accelerometer and magnetometer do nothing here: the same offset is in the samples at the start. Errors are taken "
        "at the end of each interval of 5 s, just before the next correction. *Gyroscope* is eq 7 alone; *TRIAD* is eq 11 corrected "
        "(transposed), from a start averaged over 10 s."
    )
    columns = {
        f"{axis}, {what} °": f"{axis}_{key}_deg"
        for axis in ("roll", "pitch", "yaw")
        for what, key in (("rms", "rms"), ("largest", "largest"))
    }
    # The uncalibrated gyroscope alone goes round and round: its errors are no numbers of interest.
    shown = results.frame.filter((pl.col("bias") == "bias instability") | (pl.col("attitude") != "gyroscope"))
    page.spread("attitude", shown, ["bias", "attitude"], columns, "Over seeds: median (10 % – 90 %; worst).")
    page.figure(
        "figure-3",
        _attitude_figure(results.where(bias="bias instability")[0]),
        "Figure 3 anew, one seed: attitude errors over five hours with an offset of 8.63 °/h. Left: gyroscope alone and TRIAD; right: "
        "TRIAD "
        "on its own scale.",
    )
    page.text(
        "An object that does not turn cannot tell eq 11 from its transpose, since TRIAD's answer is near the identity: Figure 3 comes "
        "out the "
        "same with the print's error. Between corrections the gyroscope's offset shows in full: with an uncalibrated 0.2 °/s the attitude "
        "is off by 1° after 5 s, so that even the corrected attitude needs the offset estimated, which this scheme does not do."
    )


def _attitude_figure(result: Result) -> Figure:
    figure, axes = sheet(3, 2, width=9, height=6.5)
    for row, axis in enumerate(("roll", "pitch", "yaw")):
        left, right = axes[2 * row : 2 * row + 2]
        for k, name in enumerate(("gyroscope", "TRIAD")):
            error = result.arrays[name][:, row]
            hours = np.linspace(0, result.settings["hours"], len(error))
            step = 6
            left.plot(hours[::step], error[::step], color=COLORS[1 - k], linewidth=1.2 - 0.6 * k, label=name)
            if name == "TRIAD":
                right.plot(hours[::step], error[::step], color=COLORS[0], linewidth=0.5)
        left.set_ylabel(f"{axis} error (°)")
    axes[0].legend(frameon=False, fontsize=9)
    axes[4].set_xlabel("time (h)")
    axes[5].set_xlabel("time (h)")
    return figure


WALK_COLUMNS = {
    "closure m": "closure_m",
    "closure %": "closure_percent",
    "rms plan m": "rms_m",
    "rms heading °": "heading_deg",
    "height m": "height_m",
    "rms height m": "height_rms_m",
}


def show_walks(results: Results, page: Page) -> None:
    """Figures 5, 6 and 8, and their numbers."""
    seeds = len(results.where(walk="disturbed"))
    page.text(
        f"{seeds} simulated walks of 20 minutes and 1.3 km, closed, with the sensor of Table 3, each past everything that disturbs the "
        "field and once more with nothing that does. Nothing is aligned but the start. Closure is the distance in the plan between the "
        "path's two ends, which the paper judges by; rms and heading are against the truth over the whole walk; height is the size of the "
        "error at the end. The methods are as they come: γ = 150, which suits real feet, and the literature's gains."
    )
    page.spread("walks", results.frame, ["walk", "method"], WALK_COLUMNS, "Over seeds: median (10 % – 90 %; worst).")
    for name, methods, caption in (
        ("figure-5", ("zupt",), "Figure 5 anew: zero-velocity updates alone."),
        ("figure-6", ("maginav",), "Figure 6 anew: the paper's algorithm, corrected."),
        ("figure-8", ("maginav", "madgwick-zupt", "mahony-zupt"), "Figure 8 anew: the three algorithms of the paper."),
        ("plan-all", walks.METHODS, "All methods, and maginav with every equation as printed."),
    ):
        _show_plan(results, page, name, methods, caption)
    page.figure("walks", _walks_figure(results), "Every seed (dot) and the median (stroke); dashed: 0.25 %.")
    page.figure(
        "along", _along_figure(results), "Error in the plan along the walk: median, and the 10 % and 90 % quantiles, over the seeds."
    )
    page.text(
        "That the paper's algorithm does *worse* where nothing disturbs it is a matter of γ. With 150 a stance begins and ends with "
        "samples "
        "in which the simulated foot already moves by some cm/s. Each is taken for standing; and because TRIAD ties the tilt to the "
        "accelerometer's offset, what does not fit is put into the offset, which tilts the next attitude. Fewer TRIADs, less harm. "
        "The next part shows the same walks with γ = 50."
    )


def show_tuned(results: Results, page: Page) -> None:
    """The same walks with tuned methods."""
    page.text(
        "The paper says of its thresholds that they must be carefully selected, gives none, and gives no gains of its rivals. Here each "
        "method "
        "has the best of a few values, by rms and height on four walks that are not among these: γ = 50 for all; inclination gate 2° "
        "(`maginav`), β = 0.003 /s (`madgwick-zupt`), kp = 0.01 /s (`mahony-zupt`). A real foot rolls while it stands, and does not let "
        "γ be so "
        "low."
    )
    page.spread("tuned", results.frame, ["walk", "method"], WALK_COLUMNS, "Over seeds: median (10 % – 90 %; worst).")
    _show_plan(results, page, "figure-8-tuned", tuned.METHODS, "Figure 8 anew, every method tuned.")
    page.figure("walks-tuned", _walks_figure(results), "Every seed (dot) and the median (stroke), every method tuned; dashed: 0.25 %.")
    page.figure(
        "along-tuned", _along_figure(results), "Error in the plan along the walk, every method tuned: median, 10 % and 90 % quantiles."
    )


def _show_plan(results: Results, page: Page, name: str, methods: Iterable[str], caption: str) -> None:
    result = _typical(results, "disturbed", "maginav")
    seed = result.settings["seed"]
    page.figure(name, _plan_figure(result, list(methods)), f"{caption} Seed {seed}, where maginav's rms is nearest to its median.")


def _typical(results: Results, walk: str, method: str) -> Result:
    frame = results.frame.filter((pl.col("walk") == walk) & (pl.col("method") == method))
    middle = frame["rms_m"].median()
    seed = frame.sort((pl.col("rms_m") - middle).abs())["seed"][0]
    return results.where(walk=walk, seed=seed)[0]


def _plan_figure(result: Result, methods: list[str]) -> Figure:
    figure, (axes,) = sheet(width=8, height=6)
    for method in methods:
        p = result.arrays[f"{method} plan"]
        axes.plot(p[:, 0], p[:, 1], color=METHOD_COLORS[method], linewidth=1.3, label=method)
        axes.plot(*p[-1], "s", color=METHOD_COLORS[method], markersize=7, markeredgecolor="white")
    p = result.arrays["truth"]
    axes.plot(p[:, 0], p[:, 1], color="black", linewidth=1.0, linestyle=":", label="truth")
    axes.plot(*p[0], "ko", markersize=6)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="east (m)", ylabel="north (m)")
    axes.legend(frameon=False, fontsize=9)
    return figure


def _walks_figure(results: Results) -> Figure:
    count = results.frame["method"].n_unique()
    figure, axes = sheet(2, 3, width=11, height=1.8 + 0.55 * count)
    for row, walk in enumerate(walks.WALKS):
        frame = results.frame.filter(pl.col("walk") == walk)
        shown = {"closure_percent": "closure (%)", "rms_m": "rms in plan (m)", "heading_deg": "rms heading (°)"}
        for column, (name, label) in enumerate(shown.items()):
            a = axes[3 * row + column]
            groups = {str(m): frame.filter(pl.col("method") == m)[name].to_numpy() for m in frame["method"].unique(maintain_order=True)}
            dots(a, groups, METHOD_COLORS)
            a.set_xlabel(label)
            if column:
                a.set_yticklabels([])
            else:
                a.set_title(walk, loc="left", fontsize=10)
        axes[3 * row].axvline(0.25, color="black", linewidth=0.8, linestyle="--")
    for above, below in zip(axes[:3], axes[3:], strict=True):
        both = [*above.get_xlim(), *below.get_xlim()]
        above.set_xlim(min(both), max(both))
        below.set_xlim(min(both), max(both))
    return figure


def _along_figure(results: Results) -> Figure:
    figure, axes = sheet(1, 2, width=10, height=3.8)
    for a, walk in zip(axes, walks.WALKS, strict=True):
        cases = results.where(walk=walk)
        for method in cases[0].settings["methods"]:
            gone = np.mean([c.arrays[f"{method} along"][::2, 0] for c in cases], axis=0)
            low, middle, high = np.quantile([c.arrays[f"{method} along"][::2, 1] for c in cases], [0.1, 0.5, 0.9], axis=0)
            a.plot(gone, middle, color=METHOD_COLORS[method], linewidth=1.3, label=method)
            a.fill_between(gone, low, high, color=METHOD_COLORS[method], alpha=0.12, linewidth=0)
        a.set_yscale("log")
        a.set_ylim(bottom=0.05)
        a.set(xlabel="distance walked (m)", ylabel="error in plan (m)")
        a.set_title(walk, loc="left", fontsize=10)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=6, frameon=False, fontsize=8)
    return figure


def ratios(results: Results, to: str = "maginav") -> dict[str, np.ndarray]:
    """Run time of each method over that of one of them, round by round."""
    table = results.frame.pivot("method", index="round", values="ns_per_sample")
    return {m: (table[m] / table[to]).to_numpy() for m in table.columns if m != "round"}


def show_time(results: Results, page: Page) -> None:
    """Table 4 as ratios."""
    printed = {"maginav": 10.67, "madgwick-zupt": 19.96, "mahony-zupt": 18.32}
    samples = 20 * 60 * 238
    rows = []
    for method, ratio in ratios(results).items():
        ns = results.frame.filter(pl.col("method") == method)["ns_per_sample"].to_numpy()
        said = printed.get(method)
        rows.append(
            [
                method,
                *np.quantile(ratio, [0.5, 0.1, 0.9]).tolist(),
                float(np.median(ns)),
                *([said / 10.67, said / samples * 1e9] if said else [None] * 2),
            ]
        )
    header = ["method", "time over maginav's: median", "10 %", "90 %", "ns per sample", "print: ratio", "print: ns per sample"]
    rounds = results.frame["round"].n_unique()
    page.text(
        f"Processor time of one thread over the same 20-minute walk, one call of each method after the other, {rounds} rounds. Only the "
        "ratios "
        "mean anything beyond the machine on which they were measured. `zupt` and `foot` are not in the paper's table."
    )
    page.table("table-4", header, rows)
    extra = [(said - 10.67) / samples * 1e6 for m, said in printed.items() if m != "maginav"]
    page.text(
        "The three share the detector, the strapdown equations and a Kalman filter with 15 states, whose covariance is most of the work; "
        "what "
        "differs is a few hundred multiplications in one step. In the print that difference is "
        f"{min(extra):.0f} to {max(extra):.0f} µs per sample, tens of thousands of processor cycles: it is the cost of calling interpreted "
        "functions in MATLAB, "
        "which Madgwick's and Mahony's filters do at every sample and TRIAD only in stance. Compiled, the difference nearly vanishes."
    )
