"""What was tried on the runs, and what it costs on walks: `make tried` writes the table into docs/stance.md, between its marks.

The recordings are looked for as `benchmarks/accuracy.py` does it.
"""

from __future__ import annotations

import math
from typing import Any

from accuracy import DATA, ROOT, number
from pages import fill, required

import bematist as bm

RUNS = {
    "35": "gsu_gx5/SensorConnectData_35.csv",
    "27-11": "pyshoe_vicon/2017-11-27-11-18-11.mat",
    "12-15": "pyshoe_vicon/2017-12-15-18-01-18.mat",
}
WALKS = {
    "32": "gsu_gx5/SensorConnectData_32.csv",
    "22-11": "pyshoe_vicon/2017-11-22-11-22-03.mat",
    "30-14": "pyshoe_vicon/2017-11-22-11-30-14.mat",
}
LIMITS = {"35": 4.0, "27-11": 2 * 0.136, "12-15": 2 * 0.070}
"""Largest error: length in %, and twice the plan error of the best published detector, whose threshold was fitted to the truth, m."""

LOUD = {"velocity_random_walk": 0.1, "angle_random_walk": math.radians(0.2)}
TRIED: dict[str, tuple[str, dict[str, Any]]] = {
    "`foot`": ("foot", {}),
    "`foot`, accelerometer noise 0.01 instead of 0.1 m/s²/√Hz": ("foot", {"noise": {"velocity_random_walk": 0.01}}),
    "`foot`, `ratio` 4": ("foot", {"stance": {"ratio": 4.0}}),
    "`foot`, `lookaround_s` 0.2": ("foot", {"stance": {"lookaround_s": 0.2}}),
    "`foot`, `floor` 50": ("foot", {"stance": {"floor": 50.0}}),
    "`foot`, window 0.1 s": ("foot", {"stance": {"window_s": 0.1}}),
    "`foot`, ZARU": ("foot", {"zaru": {"use": "rest"}}),
    "`foot`, HDR": ("foot", {"hdr": {"use": "stance"}}),
    "`foot`, MARU": ("foot", {"maru": {"use": True, "interval_s": 0.1}}),
    "`zupt`, threshold 150": ("zupt", {}),
    "`zupt`, threshold 1000": ("zupt", {"stance": {"threshold": 1000.0}}),
    "`zupt`, threshold 3000": ("zupt", {"stance": {"threshold": 3000.0}}),
    "`zupt`, adaptive 100 / 150 / 1000": ("zupt", {"stance": {"rule": "adaptive"}}),
    "`zupt`, adaptive 100 / 150 / 2000": ("zupt", {"stance": {"rule": "adaptive", "pace": {"run_threshold": 2000.0}}}),
    "`zupt`, adaptive 100 / 150 / 4000": ("zupt", {"stance": {"rule": "adaptive", "pace": {"run_threshold": 4000.0}}}),
    "`zupt`, adaptive, noise of `foot`": ("zupt", {"stance": {"rule": "adaptive"}, "noise": LOUD}),
    "`15mzh`, threshold 0.6 rad/s": ("15mzh", {}),
    "`15mzha`, adaptive 0.5 / 0.6 / 1.5 rad/s": ("15mzha", {}),
    "`15mzha`, 1.0 rad/s for running": ("15mzha", {"stance": {"pace": {"run_threshold": 1.0}}}),
    "`15mzha`, 1.8 rad/s for running": ("15mzha", {"stance": {"pace": {"run_threshold": 1.8}}}),
    "`15mzha`, speed over 0.5 s": ("15mzha", {"stance": {"pace": {"window_s": 0.5}}}),
    "`15mzha`, 2.0 rad/s for running": ("15mzha", {"stance": {"pace": {"run_threshold": 2.0}}}),
    "`15mzha` without HDR": ("15mzha", {"hdr": {"use": "off"}}),
    "`15mzha` without Madgwick's attitude": ("15mzha", {"attitude": {"propagation": "common"}}),
    "the same without ZARU and HDR": ("15mzha", {"attitude": {"propagation": "common"}, "zaru": {"use": "off"}, "hdr": {"use": "off"}}),
    "the same, ZARU at every sample in stance": (
        "15mzha",
        {"attitude": {"propagation": "common"}, "zaru": {"use": "stance"}, "hdr": {"use": "off"}},
    ),
    "the same, ZARU as Jiménez has it (0.1 rad/s, each sample)": (
        "15mzha",
        {"attitude": {"propagation": "common"}, "zaru": {"use": "stance", "sd": 0.1, "correlation_s": 0.0}, "hdr": {"use": "off"}},
    ),
    "`15mzha`, noise of `foot`": ("15mzha", {"noise": LOUD}),
}


def errors(recording: bm.Recording, method: str, changes: dict[str, Any]) -> tuple[float, float]:
    """Rms in plan, m, after alignment by yaw, and the error of the length, %."""
    assert recording.reference is not None
    e = bm.evaluate(bm.track(recording, method, **changes), recording.reference, align="yaw").to_dict()
    return e["ate_rmse_2d_m"], 100 * (e["length_ratio"] - 1)


def line(name: str, recordings: dict[str, bm.Recording], method: str, changes: dict[str, Any]) -> str:
    """A line of the table; bold: within its limit."""
    found = {key: errors(r, method, changes) for key, r in recordings.items()}
    cells = []
    for key in RUNS:
        value = found[key][1] if key == "35" else found[key][0]
        text = number(value, 1 if key == "35" else 3)
        cells.append(f"**{text}**" if abs(value) <= LIMITS[key] else text)
        if key == "35":
            cells.append(number(found[key][0], 2))
    cells += [number(found[key][0]) for key in WALKS]
    return f"| {name} | " + " | ".join(cells) + " |"


def main() -> None:
    required("foot")
    recordings = {key: bm.read(DATA / path) for key, path in (RUNS | WALKS).items()}
    lines = [
        "| | run 35: length %, at most 4 | run 35: rms m | run 27-11: rms m, at most 0.272 | run 12-15: rms m, at most 0.140 "
        "| walk 32: rms m | walk 22-11: rms m | walk 30-14: rms m |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, (method, changes) in TRIED.items():
        lines.append(line(name, recordings, method, changes))
        print(lines[-1], flush=True)
    fill(ROOT / "docs" / "stance.md", "tried", lines)


if __name__ == "__main__":
    main()
