"""Tables and figures of the walks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from bematist.reproduce.magyq.choices import FILTERS, SENSORS
from bematist.reproduce.magyq.show import HEADINGS, METHOD_COLORS, SPREAD
from bematist.reproduce.magyq.walks import WALKERS
from bematist.reproduce.page import Page
from bematist.reproduce.plots import dots, sheet
from bematist.reproduce.study import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = HEADINGS | {"position, rms m": "position_rms_m", "position, last m": "position_last_m", "NEES": "nees_median"}
PATHS = ("gyint", "magyq", "hand")
PATH_COLUMNS = {
    "path, rms m": "path_rms_m",
    "path, last m": "path_last_m",
    "headings alone, rms m": "position_rms_m",
    "lengths alone, rms m": "lengths_rms_m",
    "distance %": "distance_percent",
    "steps %": "steps_percent",
}


def show_walks(results: Results, page: Page) -> None:
    """Figures 11 to 13, and the numbers behind them."""
    seeds = len(results.cases) // len(SENSORS) // len(WALKERS)
    page.text(
        f"{seeds} walks of 1.5 km for each of three walkers and each of two sensors: along a parking lot, through a building whose field "
        "is constant by regions (of about 15 m, which differ by 8 µT in each component), around it, through it again, and back. The "
        "sensor lies on a table for the first ten seconds, and is held as one reads a phone from the first step on. Errors are those of "
        "the whole walk, nothing is aligned. *Position* is where the headings lead with the true steps, so that only headings err; the "
        "hand's own wander about the walking direction is a part of it (about 2 m). *NEES* is the median over the instants of a walk, 2.4 "
        "where the covariance is honest. What the filters are told of the sensor is in `choices.py`; the ablations change one thing of "
        "`magyq`."
    )
    for sensor in SENSORS:
        frame = results.frame.filter(pl.col("sensor") == sensor)
        page.spread(f"walks-{sensor}", frame, ["method"], COLUMNS, f"**{sensor}**, the three walkers together. {SPREAD}")
    per_walker = results.frame.filter(pl.col("method").is_in(PATHS))
    page.spread("walkers", per_walker, ["sensor", "walker", "method"], {k: COLUMNS[k] for k in list(COLUMNS)[:2]}, f"By walker. {SPREAD}")
    page.text(
        "The whole path by the methods of `track`: steps found, their lengths by eq 47 with the height of the walker and the numbers that "
        "the simulated walkers follow too (the paper calibrates them for each person), headings by the filter, the walking direction "
        "where the device points. *Headings alone* is the path of the true steps by these headings, *lengths alone* that of the found "
        "steps in the true directions; distance and steps are errors of their sums. `hand` takes eq 47 alone too, as after a calibration; "
        "as it comes, it asks the bounce of the body as well, which makes these walks 2.3 % too short. Of a stranger whose height is "
        "guessed 5 cm wrong, lengths are 3 % wrong."
    )
    frame = results.frame.filter(pl.col("path_rms_m").is_not_null())
    page.spread("paths", frame, ["sensor", "method"], PATH_COLUMNS, SPREAD)
    page.figure("walks", _dots(results), "Every walk (dot) and the median (stroke); dashed: the paper's 10°.")
    for number, walker in enumerate(WALKERS):
        page.figure(
            f"figure-{11 + number}",
            _paths(results, walker),
            f"Figure {11 + number} anew, {walker}: the paths, with the seed where the rms of magyq's heading is the median.",
        )
    page.figure(
        "headings", _courses(results), "Size of the heading error over the walk: median, 10 % and 90 % quantiles; grey: in the building."
    )


def show_held(results: Results, page: Page) -> None:
    """The same with another start."""
    page.text(
        "The same walk, but the hand holds the sensor in the rest at the start. It wanders by some tenths of a degree in those ten "
        "seconds, which the start takes for the gyroscope's offset: what that costs the gyroscope alone is the first row. The filters are "
        "told that the rest may turn by 1° (their default)."
    )
    page.spread("held", results.frame, ["sensor", "method"], COLUMNS, SPREAD)


def _dots(results: Results) -> Figure:
    shown = {"heading_rms_deg": "heading, rms (°)", "heading_largest_deg": "heading, largest (°)", "position_rms_m": "position, rms (m)"}
    methods = results.frame["method"].unique(maintain_order=True).to_list()
    figure, axes = sheet(len(SENSORS), len(shown), width=12, height=2.0 + 0.5 * len(methods) * len(SENSORS) / 2)
    for k, sensor in enumerate(SENSORS):
        frame = results.frame.filter(pl.col("sensor") == sensor)
        for column, (name, label) in enumerate(shown.items()):
            a = axes[k * len(shown) + column]
            dots(a, {m: frame.filter(pl.col("method") == m)[name].to_numpy() for m in methods}, METHOD_COLORS)
            a.set_xlabel(label)
            a.xaxis.set_minor_formatter("")
            if "heading" in name:
                a.axvline(10.0, color="black", linewidth=0.8, linestyle="--")
            if column:
                a.set_yticklabels([])
            else:
                a.set_title(sensor, loc="left", fontsize=10)
    return figure


def _paths(results: Results, walker: str) -> Figure:
    figure, axes = sheet(1, len(SENSORS), width=12, height=5.5)
    for a, sensor in zip(axes, SENSORS, strict=True):
        frame = results.frame.filter((pl.col("sensor") == sensor) & (pl.col("walker") == walker) & (pl.col("method") == "magyq"))
        middle = frame["heading_rms_deg"].median()
        seed = frame.sort((pl.col("heading_rms_deg") - middle).abs())["seed"][0]
        (case,) = results.where(sensor=sensor, walker=walker, seed=seed)
        for name in PATHS:
            a.plot(*case.arrays[f"{name} path"].T, color=METHOD_COLORS[name], linewidth=1.2, label=name)
        a.plot(*case.arrays["truth"].T, color="black", linewidth=1.0, linestyle=":", label="truth")
        a.plot(0, 0, "ko", markersize=6)
        a.set_aspect("equal", adjustable="datalim")
        a.set(xlabel="east (m)", ylabel="north (m)")
        a.set_title(f"{sensor}, seed {seed}", loc="left", fontsize=10)
        a.legend(frameon=False, fontsize=8)
    return figure


def _courses(results: Results) -> Figure:
    figure, axes = sheet(1, len(SENSORS), width=12, height=4)
    for a, sensor in zip(axes, SENSORS, strict=True):
        cases = results.where(sensor=sensor)
        share = np.linspace(0, 1, len(cases[0].arrays["time"]))
        for name in FILTERS:
            low, middle, high = np.quantile([np.abs(c.arrays[f"{name} heading"]) for c in cases], [0.1, 0.5, 0.9], axis=0)
            a.semilogy(share, middle, color=METHOD_COLORS[name], linewidth=1.3, label=name)
            a.fill_between(share, low, high, color=METHOD_COLORS[name], alpha=0.12, linewidth=0)
        inside = np.mean([c.arrays["inside"] for c in cases], axis=0) > 0.5
        a.fill_between(share, 0, 1, where=inside.tolist(), transform=a.get_xaxis_transform(), color="0.9", linewidth=0, zorder=0)
        a.set_ylim(0.03, 100)
        a.set(xlabel="share of the walk", ylabel="heading error (°)")
        a.set_title(sensor, loc="left", fontsize=10)
        a.legend(frameon=False, fontsize=8)
    return figure
