"""What was tried for the handheld filter: `make tried` writes the table into docs/hand.md, between its marks.

Walks of 1.5 km in simulation (those of `bematist reproduce magyq`), and the real recordings of `benchmarks/attitude.py`.
"""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import numpy as np
from attitude import ALIGNED, judged
from pages import ROOT, fill, required

import bematist as bm
from bematist.reproduce.magyq import choices, walks

SEEDS = 4


def hand(**attitude: Any) -> tuple[str, dict[str, Any]]:
    return "hand", {"attitude": attitude}


BEFORE = {"gravity_density": 0.5, "gravity_spread": 0.1, "heading_spread": 0.0, "heading_density": 0.4}
FIELD = {"earth": True, "dip_tolerance": math.radians(2.5), "earth_sd": 2.0}
TRIED: choices.Runs = {
    "`hand`": hand(),
    "`rest_field_sd` 0": hand(motion={"rest_field_sd": 0.0}),
    "`gravity_density` 0.5": hand(motion={"gravity_density": 0.5}),
    "`gravity_density` 1.5": hand(motion={"gravity_density": 1.5}),
    "`gravity_spread` 0.1": hand(motion={"gravity_spread": 0.1}),
    "`heading_density` 0.1": hand(motion={"heading_density": 0.1}),
    "`heading_spread` 1": hand(motion={"heading_spread": 1.0}),
    "`heading_density` 0.4, `heading_spread` 0, `gravity_density` 0.5, `gravity_spread` 0.1": hand(motion=BEFORE),
    "the same, `heading_density` 0.1, gates of 1 % and 1° in place of 10 % and 5°": hand(
        motion=BEFORE | {"heading_density": 0.1, "norm_tolerance": 0.01, "inclination_tolerance": math.radians(1)}
    ),
    "static magnetic fields wherever one is (`local`)": hand(magnetic={"local": True}),
    "the same, `walk` = 1 µT/√s": hand(magnetic={"local": True, "walk": 1.0}),
    "static fields that look like the Earth's (`earth`, 2.5°, 2 µT)": hand(magnetic=FIELD),
    "static specific force as gravity (`earth`)": hand(force={"earth": True}),
    "`gyro_bias_walk` 1e-6 rad/s/√s": hand(noise={"gyro_bias_walk": 1e-6}),
}
EXACT = {f"magnetic_{what}_sd": 0.0 for what in ("scale", "misalignment", "bias")}
"""A magnetometer of which calibration left nothing."""


def simulated(job: tuple[str, str, int, bool]) -> dict[str, float]:
    """Rms of the heading, deg, by filter, on one walk."""
    sensor, walker, seed, exact = job
    case = walks.case(sensor, walker, seed, {"`hand`": TRIED["`hand`"]} if exact else TRIED)
    if exact:
        case = {**case, "changes": {**case["changes"], **EXACT}}
    return {row["method"]: row["heading_rms_deg"] for row in walks.compute(case).rows}


def columns(pool: ProcessPoolExecutor) -> dict[str, dict[str, str]]:
    """By sensor: the medians over the walks and the worst, by filter."""
    found: dict[str, dict[str, str]] = {}
    for sensor in choices.SENSORS:
        for exact in (False, True):
            done = list(pool.map(simulated, [(sensor, w, seed, exact) for w in walks.WALKERS for seed in range(SEEDS)]))
            for name in done[0]:
                values = [d[name] for d in done]
                label = "`hand`, the magnetometer calibrated to the last" if exact else name
                found.setdefault(label, {})[sensor] = f"{np.median(values):.2f} / {max(values):.1f}"
            print(sensor, "exact" if exact else "", {n: c[sensor] for n, c in found.items() if sensor in c}, flush=True)
    return found


def _real(path: str, kind: str, changes: dict[str, Any]) -> str:
    return judged(path, partial(bm.attitude, filter=kind, config=changes))


def main() -> None:
    required("attitude", "hand")
    with ProcessPoolExecutor() as pool:
        found = columns(pool)
    heads = [*(f"{s}, simulated" for s in choices.SENSORS), *(words for words, _ in ALIGNED.values())]
    lines = ["| | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    for name, cells in found.items():
        real = [_real(path, *TRIED[name]) if name in TRIED else "–" for path in ALIGNED]
        lines.append("| " + " | ".join([name, *cells.values(), *real]) + " |")
        print(lines[-1], flush=True)
    fill(ROOT / "docs" / "hand.md", "tried", lines)


if __name__ == "__main__":
    main()
