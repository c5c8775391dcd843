"""The paper's figures anew."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from bematist.foot import FootParameters
from bematist.reproduce.li_wang.routes import ROUTES
from bematist.reproduce.li_wang.variants import GYRO
from bematist.reproduce.page import Page
from bematist.reproduce.plots import COLORS, colored, sheet
from bematist.reproduce.study import Result, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NINE = ("common-9", "mahony-9", "madgwick-9")
FIFTEEN = ("15m", "15zh", "15mzh")
COLOR = colored(NINE) | colored(FIFTEEN) | {"15mzha": COLORS[4], "foot": COLORS[5]}
RATE_HZ = 100
PACE = FootParameters().stance.pace


def show(results: Results, page: Page) -> None:
    """All figures, each of the walk whose rms is nearest to the median of a method."""
    typical = {route: _typical(results, route, "madgwick-9") for route in ROUTES}
    one, two, three, laps, *_, rocking = typical.values()
    chosen = ", ".join(f"{route} {r.settings['seed']}" for route, r in typical.items())
    page.text(f"The figures are of the seeds where madgwick-9's rms is nearest to its median ({chosen}).")
    page.figure("figure-3", _courses([one, two, three, laps]), "Figure 3 and 18 anew: the courses.")
    page.figure("figure-4", _plans([one, two], NINE), "Figure 4 anew: nine states by three attitudes, Routes 1 and 2.")
    page.figure("figure-5-6", _attitudes([one, two]), "Figures 5 and 6 anew, as errors: attitude about east, north and up.")
    page.figure("figure-7", _yaw_sd([one, two]), "Figure 7 anew: the filter's standard deviation of yaw (lines), the yaw error (dotted).")
    page.figure("figure-8-9", _plans([one, two], FIFTEEN), "Figures 8 and 9 anew: fifteen states.")
    page.figure("figure-10", _heights([one, two]), "Figure 10 anew: height on flat ground; the truth comes back to zero.")
    shown = [one, two, typical["ellipse, rocking"]]
    page.figure("figure-11", _norms(shown), "Figure 11 anew: norm of the angular rate with the thresholds; true stances grey.")
    page.figure("figure-12-16", _pace(three), "Figures 12 to 16 anew, Route 3: angular rate, 15mzh's speed, its mean, class over time.")
    page.figure("figure-17", _plans([three], ("15mzh", "15mzha", "foot")), "Figure 17 anew: Route 3 with fixed and adaptive threshold.")
    page.figure("figure-20-21", _plans([laps, rocking], ("15mzh", "15mzha", "foot"), 20.0), "Figures 20 and 21 anew: three laps.")


def _typical(results: Results, route: str, variant: str) -> Result:
    frame = results.frame.filter((pl.col("route") == route) & (pl.col("variant") == variant))
    middle = frame["rms_m"].median()
    return results.where(route=route, seed=frame.sort((pl.col("rms_m") - middle).abs())["seed"][0])[0]


def _titled(axes: Axes, result: Result) -> None:
    route = result.settings["route"]
    what = ROUTES[route].split(",")[0]
    axes.set_title(f"{route} ({what})", loc="left", fontsize=10)


def _plan(axes: Axes, result: Result, names: tuple[str, ...]) -> None:
    for name in names:
        p = result.arrays[f"{name} plan"]
        axes.plot(p[:, 0], p[:, 1], color=COLOR[name], linewidth=1.0, label=name)
        axes.plot(*p[-1], "s", color=COLOR[name], markersize=7, markeredgecolor="white")
    p = result.arrays["truth plan"]
    axes.plot(p[:, 0], p[:, 1], color="black", linewidth=0.9, linestyle="-" if not names else ":", label="truth")
    axes.plot(*p[0], "k^", markersize=6)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="east (m)", ylabel="north (m)")
    _titled(axes, result)


def _courses(shown: list[Result]) -> Figure:
    figure, axes = sheet(2, 2, width=9, height=6)
    for a, result in zip(axes, shown, strict=True):
        _plan(a, result, ())
    return figure


def _plans(shown: list[Result], names: tuple[str, ...], margin_m: float | None = None) -> Figure:
    """Paths beside the truth; no further from it than the margin, if one is given."""
    figure, axes = sheet(1, len(shown), width=10 if len(shown) > 1 else 8, height=4.5)
    for a, result in zip(axes, shown, strict=True):
        _plan(a, result, names)
        if margin_m is not None:
            low, high = (f(result.arrays["truth plan"], axis=0) for f in (np.min, np.max))
            a.set_aspect("equal", adjustable="box")
            a.set(xlim=(low[0] - margin_m, high[0] + margin_m), ylim=(low[1] - margin_m, high[1] + margin_m))
    axes[-1].legend(frameon=False, fontsize=9)
    return figure


def _attitudes(shown: list[Result]) -> Figure:
    figure, axes = sheet(3, 2, width=10, height=6.5)
    for column, result in enumerate(shown):
        _titled(axes[column], result)
        for row, word in enumerate(("east", "north", "up (yaw)")):
            a = axes[2 * row + column]
            for name in NINE:
                a.plot(result.arrays["time"], result.arrays[f"{name} error"][:, row], color=COLOR[name], linewidth=0.9, label=name)
            a.set_ylabel(f"about {word} (°)")
        axes[4 + column].set_xlabel("time (s)")
    axes[4].legend(frameon=False, fontsize=8)
    return figure


def _yaw_sd(shown: list[Result]) -> Figure:
    figure, axes = sheet(1, 2, width=10, height=3.8)
    for a, result in zip(axes, shown, strict=True):
        for name in NINE:
            a.plot(result.arrays["time"], result.arrays[f"{name} yaw sd"], color=COLOR[name], linewidth=1.3, label=f"{name}: sd")
            error = np.abs(result.arrays[f"{name} error"][:, 2])
            a.plot(result.arrays["time"], error, ":", color=COLOR[name], linewidth=1.0, label=f"{name}: error")
        a.set_yscale("log")
        a.set_ylim(0.01, 200)
        a.set(xlabel="time (s)", ylabel="yaw (°)")
        _titled(a, result)
    axes[0].legend(frameon=False, fontsize=8, ncols=3, loc="upper left")
    return figure


def _heights(shown: list[Result]) -> Figure:
    figure, axes = sheet(1, 2, width=10, height=3.6)
    for a, result in zip(axes, shown, strict=True):
        for name in FIFTEEN:
            a.plot(result.arrays["time"], result.arrays[f"{name} height"], color=COLOR[name], linewidth=0.9, label=name)
        a.set(xlabel="time (s)", ylabel="height (m)")
        _titled(a, result)
    axes[0].legend(frameon=False, fontsize=8)
    return figure


def _norms(shown: list[Result], start_s: float = 20.0, length_s: float = 6.0) -> Figure:
    figure, axes = sheet(len(shown), 1, width=9, height=2.5 * len(shown))
    rows = slice(int(start_s * RATE_HZ), int((start_s + length_s) * RATE_HZ))
    time = np.arange(rows.start, rows.stop) / RATE_HZ
    for a, result in zip(axes, shown, strict=True):
        a.fill_between(time, 0, 12, where=result.arrays["truth stance"][rows] > 0, color="#d9dde2", linewidth=0)
        a.plot(time, result.arrays["gyro norm"][rows], color=COLORS[0], linewidth=1.0)
        for k, (word, value) in enumerate((("δ1", GYRO.threshold), ("δ2", GYRO.running))):
            a.axhline(value, color=COLORS[1 + k], linewidth=1.0, linestyle="--", label=f"{word} = {value} rad/s")
        a.set(ylabel="angular rate (rad/s)", ylim=(0, 12))
        _titled(a, result)
    axes[-1].set_xlabel("time (s)")
    axes[0].legend(frameon=False, fontsize=8, loc="upper right")
    return figure


def trailing(values: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean over the last n values, and the largest mean over the last n of those; fewer at the start."""
    total = np.concatenate([[0.0], np.cumsum(values, dtype=float)])
    k = np.arange(1, len(values) + 1)
    first = np.maximum(0, k - n)
    mean = (total[k] - total[first]) / (k - first)
    padded = np.concatenate([np.full(n - 1, mean[0]), mean])
    return mean, np.lib.stride_tricks.sliding_window_view(padded, n).max(axis=1)


def _pace(result: Result) -> Figure:
    figure, axes = sheet(4, 1, width=9, height=8)
    speed = np.linalg.norm(result.arrays["15mzh velocity"], axis=1)
    mean, largest = trailing(speed, int(PACE.window_s * RATE_HZ))
    true, _ = trailing(result.arrays["truth speed"], int(PACE.window_s * RATE_HZ))
    time = np.arange(len(speed)) / RATE_HZ
    few = slice(None, None, 4)
    axes[0].plot(time[few], result.arrays["gyro norm"][few], color=COLORS[0], linewidth=0.5)
    axes[0].set_ylabel("angular rate (rad/s)")
    axes[1].plot(time[few], speed[few], color=COLORS[0], linewidth=0.5)
    axes[1].set_ylabel("speed (m/s)")
    axes[2].plot(time[few], true[few], ":", color="black", linewidth=1.0, label="truth, mean over 1 s")
    axes[2].plot(time[few], mean[few], color=COLORS[2], linewidth=1.0, label="mean over 1 s")
    axes[2].plot(time[few], largest[few], color=COLORS[1], linewidth=1.2, label="its largest in 1 s")
    for limit in (PACE.walk_speed, PACE.run_speed):
        axes[2].axhline(limit, color="#777777", linewidth=0.9, linestyle="--")
    axes[2].set_ylabel("speed (m/s)")
    axes[2].legend(frameon=False, fontsize=8, loc="upper right")
    axes[3].plot(time, result.arrays["15mzha pace"], color=COLORS[4], linewidth=1.4, drawstyle="steps-post")
    axes[3].set_yticks([0, 1, 2], ["slow", "walking", "running"])
    axes[3].set_xlabel("time (s)")
    _titled(axes[0], result)
    return figure
