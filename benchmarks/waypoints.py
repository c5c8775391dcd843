"""Paths of a phone in a hand (part of `make accuracy`): against a surveyor's waypoints, the table and the pictures of docs/map.md; against
these and motion capture, the table of docs/pdr.md.

The recordings are looked for at BEMATIST_SHARED, then beside the project. The plan is drawn here: a corridor along the waypoints.
"""

from __future__ import annotations

import json

import numpy as np
from pages import DATA as RECORDINGS
from pages import ROOT, fill, required

import bematist as bm
from bematist.placement import by_reference
from bematist.report import still_path

DATA = RECORDINGS / "hand"
METHODS = ("gyint", "quest", "magyq", "hand")
WALKS = {
    "mall, site 1": "ms_indoor20/site1_B1_5dda149f9191710006b57212.txt",
    "mall, site 2": "ms_indoor20/site2_F2_5dd3793144333f00067aa1c7.txt",
    "motion capture, texting": "nexus5_mocap/Guillaume_Nexus5_NoDist_Texting",
    "motion capture, swinging": "nexus5_mocap/Thibaud_Nexus5_NoDist_Swinging",
}


def corridor(points: np.ndarray, half_width_m: float = 2.5) -> dict[str, object]:
    """A plan in plain metres: walls on both sides of the way through the points (K,2), and where the waypoints are."""
    leg = np.diff(points, axis=0)
    along = np.vstack([leg[:1], leg[1:] + leg[:-1], leg[-1:]])
    side = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True) * half_width_m
    ring = np.vstack([points + side, (points - side)[::-1], (points + side)[:1]])
    geometry = {"type": "Polygon", "coordinates": [ring.tolist()]}
    return {"type": "Feature", "properties": {"name": "corridor"}, "geometry": geometry}


def paths() -> None:
    """The table of docs/pdr.md: every walk by every method, free-running."""
    recordings = {name: bm.read(DATA / path) for name, path in WALKS.items()}
    lines = ["| | " + " | ".join(recordings) + " |", "|---" * (len(recordings) + 1) + "|"]
    no_bounce = {"step_length": {"pendulum": 0.0}}
    runs = [("`hand`", "hand", {}), ("`hand`, `step_length.pendulum` = 0", "hand", no_bounce)]
    for name, method, changes in [*runs, *((f"`{m}`", m, {}) for m in METHODS if m != "hand")]:
        cells = []
        for r in recordings.values():
            e = bm.evaluate(bm.track(r, method, config=changes), r.reference, "yaw").to_dict()
            nees = e["nees_position"]["mean"] if e["nees_position"] else float("nan")
            cells.append(f"{e['ate_median_2d_m']:.1f} / {e['ate_rmse_2d_m']:.1f}, {100 * (e['length_ratio'] - 1):+.0f} %, {nees:.1f}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
        print(lines[-1], flush=True)
    fill(ROOT / "docs" / "pdr.md", "paths", lines)


def main() -> None:
    required("hand")
    head = (
        "recording",
        "method",
        "begun as the reference: median, largest error",
        "aligned by yaw: the same",
        "length over the waypoints'",
    )
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for number, file in enumerate(sorted(DATA.glob("ms_indoor20/site*.txt"))):
        r = bm.read(file)
        assert r.reference is not None
        plan_file = ROOT / "build" / f"{file.stem}.geojson"
        plan_file.parent.mkdir(exist_ok=True)
        plan_file.write_text(json.dumps(corridor(r.reference.position[:, :2])))
        placed = []
        for method in METHODS:
            t = bm.track(r, method)
            t = by_reference(t, r.reference, start=True, heading=True).place(t)
            placed.append(t)
            free, fitted = (bm.evaluate(t, r.reference, align) for align in ("none", "yaw"))
            errors = [f"{e.ate_plan_median_m:.1f}, {e.ate_plan_max_m:.1f} m" for e in (free, fitted)]
            lines.append(f"| {file.stem.split('_5')[0]} | `{method}` | {errors[0]} | {errors[1]} | {free.length_ratio:.2f} |")
            print(lines[-1], flush=True)
        plan = bm.read_floor_plan(plan_file, scale=1.0)
        still_path(placed[-1:], ROOT / f"docs/pictures/waypoints-{number + 1}.png", r.reference, floor_plan=plan, align="none")
    fill(ROOT / "docs" / "map.md", "waypoints", lines)
    paths()


if __name__ == "__main__":
    main()
