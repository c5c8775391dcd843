"""Tables and figures of the gyroscope quaternion, the rest, the walk outdoors, and the covariance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import polars as pl

from bematist.evaluate.metrics import nees_bounds
from bematist.reproduce.magyq import gyroscope, outdoors, rest
from bematist.reproduce.magyq.choices import ABLATIONS, FILTERS
from bematist.reproduce.page import Page
from bematist.reproduce.plots import COLORS, colored, sheet
from bematist.reproduce.study import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METHOD_COLORS = colored(list(FILTERS)) | dict.fromkeys(ABLATIONS, COLORS[7]) | {"with a dip gate": COLORS[5]}

SIGNALS = {"rate": "rate, z", "first": "quaternion, first component", "fourth": "quaternion, fourth component"}

HEADINGS = {
    "heading, rms °": "heading_rms_deg",
    "heading, largest °": "heading_largest_deg",
    "heading, last °": "heading_last_deg",
    "tilt, rms °": "tilt_rms_deg",
}

SPREAD = "Over seeds: median (10 % – 90 %; worst)."


def show_gyroscope(results: Results, page: Page) -> None:
    """Figures 5 to 7."""
    first = results.cases[0]
    apart = np.abs(results.frame.select("ratio_smallest", "ratio_largest").to_numpy() - 1).max()
    page.text(
        "Three hours of the simulated ADIS16488 at rest, and its gyroscope quaternion (eq 19). The Allan deviation of the fourth "
        f"component is T/2 times that of the rate at all averaging times, to {apart:.1g} of it: the quaternion of one period *is* half the "
        "angle, and says nothing that the rate does not. The first component, 1 − T²|y|²/8, is another thing: seven orders smaller, and "
        "not Gaussian. The print's Figure 5 shows the fourth component."
    )
    page.figure("figure-5", _deviation(first.arrays), "Figure 5 anew: Allan deviation of the rate, times T/2, and of the quaternion.")
    page.figure(
        "figure-6-7",
        _density(first.arrays),
        f"Figures 6 and 7 anew: density of a simulated gyroscope with white noise and a random walk of {gyroscope.AS_PRINTED}, and of its "
        "quaternion; dashed: 1/f². With the random walk of Table 2 per √h instead, nothing but white noise is to be seen above 0.0001 Hz.",
    )


def _deviation(arrays: dict[str, np.ndarray]) -> Figure:
    figure, (axes,) = sheet(width=7, height=4.2)
    half = 0.5 / gyroscope.RATE_HZ
    for k, (name, label) in enumerate(SIGNALS.items()):
        scale, words = (half, f"{label}, times T/2") if name == "rate" else (1.0, label)
        style = {"linewidth": 4.0, "alpha": 0.35} if name == "rate" else {"linewidth": 1.4}
        axes.loglog(arrays["tau"], scale * arrays[f"{name} deviation"], color=COLORS[k], label=words, **style)
    axes.set(xlabel="averaging time (s)", ylabel="Allan deviation")
    axes.legend(frameon=False, fontsize=9)
    return figure


def _density(arrays: dict[str, np.ndarray]) -> Figure:
    figure, axes = sheet(1, 2, width=10, height=4)
    f = arrays["frequency"]
    for a, names, unit in ((axes[0], ("rate",), "rad²/s²/Hz"), (axes[1], ("first", "fourth"), "1/Hz")):
        for k, name in enumerate(names):
            a.loglog(f, arrays[f"{name} density"], color=COLORS[list(SIGNALS).index(name)], linewidth=1.2, label=SIGNALS[name])
            if k == len(names) - 1:
                a.loglog(f[:40], arrays[f"{name} density"][0] * (f[0] / f[:40]) ** 2, "k--", linewidth=0.8)
        a.set(xlabel="frequency (Hz)", ylabel=f"density ({unit})")
        a.legend(frameon=False, fontsize=9)
    return figure


def show_test(results: Results, page: Page) -> None:
    """Section 3.3.2."""
    n = results.cases[0].settings["samples"]
    right, printed = gyroscope.critical(n), 1.36 / np.sqrt(n)
    page.text(
        f"Quaternions of a simulated gyroscope against quaternions drawn from the model (20), both centred and normalised, {n:,} samples "
        f"each. Two samples of that size differ by more than {right:.5f} in 5 % of all cases (the print's critical value, {printed:.5f}, "
        "is that of one sample against a known distribution). *exceeds* is the share of seeds with a distance above it. What the paper "
        "calls a probability above 80 % that the hypothesis holds is none: the test gives how often such a distance would come about if "
        "it held."
    )
    rows = []
    for (walk, component), group in results.frame.group_by(["walk", "component"], maintain_order=True):
        d = group["distance"].to_numpy()
        rows.append(
            [str(walk), int(str(component)), float(np.median(d)), float(d.max()), float((d > right).mean()), float((d > printed).mean())]
        )
    page.table("test", ["random walk", "component", "distance, median", "largest", "exceeds", "exceeds the print's"], rows)
    page.text(
        "The test asks for independent samples. White noise is independent, and passes as often as it should. A random walk is not: two "
        "of its realisations have different shapes, and are told apart although both follow the model; how often, depends on how large it "
        "is against the white noise. So a pass says only that the white noise drowns the rest. The first component is never Gaussian (it "
        "is the sum of three squares), and fails in every case by a factor of twenty."
    )


def show_rest(results: Results, page: Page) -> None:
    """Figure 9."""
    page.text(
        "5000 s on a table, where the field is constant and not the Earth's; heading and the Earth's field are known from before. One "
        "field differs from the Earth's in its norm too, the other only in direction, by 31° in the plan."
    )
    page.spread("rest", results.frame, ["field", "method"], HEADINGS, SPREAD)
    for number, field in enumerate(rest.FIELDS):
        case = results.where(field=field)[0]
        figure, axes = sheet(3, 1, width=8, height=6)
        for row, angle in enumerate(("roll", "pitch", "heading")):
            for name, color in METHOD_COLORS.items():
                if name in case.arrays:
                    t = np.linspace(0, case.settings["seconds"], len(case.arrays[name]))
                    # The default lies on the gyroscope alone where no field is the Earth's.
                    style = "--" if name == "hand" else "-"
                    axes[row].plot(t, case.arrays[name][:, row], style, color=color, linewidth=1.1, label=name)
            axes[row].set_ylabel(f"{angle} error (°)")
        axes[0].legend(frameon=False, fontsize=8, ncols=3)
        axes[-1].set_xlabel("time (s)")
        page.figure(f"figure-9{'ab'[number]}", figure, f"Figure 9 anew, one seed, a field {field}.")


def show_outdoors(results: Results, page: Page) -> None:
    """Figure 10."""
    too_much = np.degrees(outdoors.TOO_MUCH)
    page.text(
        f"The walk of 1.5 km without the building: parked cars and a facade only. The rest at the start was made to say {too_much:.2g} °/s "
        "too much about the vertical, and the filters are told that it may."
    )
    page.spread("outdoors", results.frame, ["method"], HEADINGS, SPREAD)
    figure, (axes,) = sheet(width=8, height=4)
    time = results.cases[0].arrays["time"]
    for k, name in enumerate(outdoors.RUNS):
        low, middle, high = np.quantile([c.arrays[name] for c in results.cases], [0.1, 0.5, 0.9], axis=0)
        axes.plot(time, middle, color=COLORS[k], linewidth=1.3, label=name)
        axes.fill_between(time, low, high, color=COLORS[k], alpha=0.15, linewidth=0)
    axes.set(xlabel="time (s)", ylabel="heading error (°)")
    axes.legend(frameon=False, fontsize=9)
    page.figure("figure-10", figure, "Figure 10 anew: heading error over the walk; median, 10 % and 90 % quantiles over the seeds.")


def show_consistency(results: Results, page: Page) -> None:
    """NEES."""
    runs = len(results.cases)
    low, high = nees_bounds(runs)
    page.text(
        f"{runs} walks of 300 m inside a building, with a phone whose errors are those that the filter believes in: white noise, constant "
        "offsets and the random walk of the gyroscope's. The normalised square of the attitude error is 3 on the average, 2.4 in the "
        f"median, if the filter knows how wrong it is; its mean over {runs} walks then lies between {low:.2f} and {high:.2f} in 95 %. "
        "*median of each walk* is the median over the instants of a walk."
    )
    columns = {"NEES at the end": "nees", "median of each walk": "nees_median", "heading error at the end °": "heading_deg"}
    columns |= {"its deviation says the filter °": "heading_sd_deg"}
    page.spread("consistency", results.frame, ["method"], columns, SPREAD)
    means = results.frame.group_by("method", maintain_order=True).agg(pl.col("nees").mean())
    page.table("consistency-mean", ["method", "mean NEES at the end"], [list(row) for row in means.iter_rows()])
    figure, (axes,) = sheet(width=8, height=4)
    for k, name in enumerate(means["method"]):
        values = np.nanmedian([c.arrays[name] for c in results.cases], axis=0)
        axes.semilogy(np.linspace(0, 1, len(values)), values, color=COLORS[k], linewidth=1.3, label=name)
    axes.axhline(2.37, color="black", linewidth=0.8, linestyle="--")
    axes.set(xlabel="share of the walk", ylabel="NEES, median over seeds")
    axes.legend(frameon=False, fontsize=8)
    page.figure("consistency", figure, "NEES of the attitude along the walk, median over the seeds; dashed: what it should be.")
