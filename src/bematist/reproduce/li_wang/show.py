"""Tables of the simulated courses and of the real recordings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import polars as pl

from bematist.reproduce.li_wang import figures
from bematist.reproduce.li_wang.pairs import Compared, compare
from bematist.reproduce.li_wang.recordings import folder
from bematist.reproduce.li_wang.routes import ROUTES
from bematist.reproduce.li_wang.variants import MEANING, PAIRS, PAPER, YARDSTICKS
from bematist.reproduce.page import Cell, Page
from bematist.reproduce.plots import colored, dots, sheet
from bematist.reproduce.study import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = (*PAPER, "15", *YARDSTICKS)
COLUMNS = {
    "end m": "end_m",
    "rms m": "rms_m",
    "heading °": "heading_deg",
    "tilt °": "tilt_deg",
    "height rms m": "height_rms_m",
    "length %": "length_percent",
}
STANCES = {"stances missed %": "missed_percent", "speed in stance m/s": "moving_m_s", "stance %": "stance_percent"}
YAW = {"yaw error at the end °": "yaw_end_deg", "its sd by the filter °": "yaw_sd_deg"} | {
    f"heading, {word} third °": f"heading_{k}_deg" for k, word in enumerate(("first", "second", "last"), 1)
}


def show_routes(results: Results, page: Page) -> None:
    """Tables of the simulated courses, and all figures of the paper."""
    frame = results.frame
    page.text(
        f"{frame['seed'].n_unique()} walks of each course at 100 Hz (Table 1) by the simulated LSM9DS1 without magnetometer (section 4), "
        "after 10 s of rest: rectangle is Route 1, ellipse Route 2, mixed Route 3, laps the course of Figure 18; the two with *rocking* "
        "are harder than the jog of the simulator, whose foot is quiet enough for the walking threshold. Every method "
        "is told the "
        "true heading of the sensor at the start, as nothing in the method can find it (laps begins westward), and starts at the true "
        "place; nothing is fitted afterwards. End and rms are in the plan, heading and tilt rms over the walk, height rms; length is the "
        "path's over the true one. Medians (10 % – 90 %; worst).",
        "Names: " + "; ".join(f"**{name}**: {meaning}" for name, meaning in MEANING.items()) + ".",
    )
    for route, what in ROUTES.items():
        part = frame.filter((pl.col("route") == route) & pl.col("variant").is_in(SHOWN))
        page.spread(route, part, ["variant"], COLUMNS, f"**{route}** ({what}).")
    page.figure("walks", _dots(frame), "Every seed (dot) and the median (stroke).")
    page.text("One choice at a time, on the same walks. p is the sign test's: how often a fair coin is as one-sided; ties are not counted.")
    for column, word in (("rms_m", "rms in the plan, m"), ("heading_deg", "rms heading, °"), ("height_rms_m", "rms height, m")):
        _pairs(frame, "route", tuple(ROUTES), "seed", column, f"pairs-{column}", f"Pairs by {word}: with the choice against without.", page)
    yaw = frame.filter(pl.col("variant").is_in(SHOWN))
    page.spread("yaw", yaw, ["route", "variant"], YAW, "Yaw: what the filter believes, and how it grows. Medians (10 % – 90 %; worst).")
    names = ("15zh", "15zha", "15zh wide", "15mzh", "15mzha", "15mzh wide", "foot")
    page.spread(
        "stances", frame.filter(pl.col("variant").is_in(names)), ["route", "variant"], STANCES, "Stances: missed, and not standing."
    )
    figures.show(results, page)


def _pairs(frame: pl.DataFrame, group: str, groups: tuple[str, ...], by: str, column: str, name: str, caption: str, page: Page) -> None:
    rows: list[list[Cell]] = []
    for pair in PAIRS:
        found = [compare(frame.filter(pl.col(group) == g) if g else frame, pair.changed, pair.base, column, by) for g in groups]
        rows.append([pair.what, *(_cell(c) for c in found)])
    page.table(name, ["choice", *(g or "all" for g in groups)], rows, caption)


def _cell(c: Compared | None) -> str | None:
    return None if c is None else f"{c.median:.3g} : {c.other:.3g}; {c.better} of {c.runs}, p {c.p:.2g}"


def _dots(frame: pl.DataFrame) -> Figure:
    figure, axes = sheet(3, 2, width=10, height=10)
    colors = colored(SHOWN[:8]) | dict.fromkeys(SHOWN[8:], "#333333")
    for a, route in zip(axes, ROUTES, strict=True):
        part = frame.filter(pl.col("route") == route)
        dots(a, {v: part.filter(pl.col("variant") == v)["rms_m"].to_numpy() for v in SHOWN}, colors)
        a.set_title(route, loc="left", fontsize=10)
        a.set_xlabel("rms in plan (m)")
    return figure


def show_recordings(results: Results, page: Page) -> None:
    """The same variants on real recordings."""
    if not results.cases:
        page.text(f"No recording was found in {folder()}: this part is left out. `BEMATIST_SHARED` names the folder above foot/.")
        return
    frame = results.frame
    known = frame.filter(pl.col("rms_m").is_not_null()) if "rms_m" in frame.columns else frame.head(0)
    page.text(
        "The paper's recordings (its reference 25) are not at hand; these are other real ones. The methods start eastward, and yaw and "
        "place are fitted to the reference, since its directions have nothing to do with the sensor's; where there is no reference, the "
        "distance between start and end of the path is all there is (both walks ended near their start). Only here does `foot` use a "
        "magnetometer, where the recording has one."
    )
    names = frame["recording"].unique(maintain_order=True).to_list()
    referenced = known["recording"].unique(maintain_order=True).to_list()
    for column, title, walks in (
        ("rms_m", "rms in the plan, m", referenced),
        ("height_rms_m", "rms height, m", referenced),
        ("length_percent", "length, % too long", referenced),
        ("closure_m", "end from start, plan, m", [n for n in names if n not in referenced]),
    ):
        if not walks:
            continue
        rows: list[list[Cell]] = []
        for variant in frame["variant"].unique(maintain_order=True):
            mine = frame.filter(pl.col("variant") == variant)
            rows.append([variant, *(mine.filter(pl.col("recording") == w)[column].to_list()[0] for w in walks)])
        gait = dict(frame.select("recording", "gait").unique().iter_rows())
        page.table(f"real-{column}", ["variant", *(f"{w} ({gait[w]})" for w in walks)], rows, f"Real recordings: {title}.")
    if referenced:
        caption = "Real recordings, pairs by rms in the plan, m: medians with the choice against without, and on how many it is better."
        _pairs(known, "gait", ("", "walk", "run"), "recording", "rms_m", "real-pairs", caption, page)
