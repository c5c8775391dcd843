"""How well steps and modes are found: simulated hands, real ones, and hands that do not walk. Prints the tables of docs/steps.md.

`python benchmarks/steps.py [SEEDS]`. The recordings are looked for at BEMATIST_SHARED, then beside the project.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pages import DATA
from scipy.signal import butter, find_peaks, sosfiltfilt

import bematist as bm
from bematist import steps
from bematist.recording import Recording
from bematist.simulate import HandSimulation, simulate_hand

MOTION = {"standing": 0, "walking": 1, "running": 2, "upstairs": 3, "downstairs": 3}
MIXED: dict[str, Any] = {
    "length_m": 1000.0,
    "gestures": 10.0,
    "pauses": ((100.0, 15.0), (250.0, 10.0), (400.0, 20.0), (520.0, 15.0), (800.0, 10.0)),
    "carries": (
        (0.0, "texting"),
        (150.0, "swinging"),
        (300.0, "phoning"),
        (450.0, "texting"),
        (550.0, "pocket"),
        (700.0, "swinging"),
        (850.0, "bag"),
    ),
}


class Score:
    """Steps counted against steps made, and confusion of the modes, sample by sample."""

    def __init__(self) -> None:
        self.errors: list[float] = []
        self.motion = np.zeros((4, 4), int)
        self.carrying = np.zeros((5, 5), int)

    def add(self, made: HandSimulation, *, attitude: bool = False) -> None:
        found = steps.analyse(made.recording, attitude=made.truth.attitude if attitude else None)
        self.errors.append(100 * (len(found.event_time) / len(made.steps) - 1))
        motion, carry = made.modes_at(found.time)
        true = np.array([MOTION[m] for m in motion])
        np.add.at(self.motion, (true, found.motion), 1)
        walks = true > 0
        np.add.at(self.carrying, ([steps.CARRYING.index(str(c)) for c in carry[walks]], found.carrying[walks]), 1)

    def row(self, name: str) -> str:
        e = np.array(self.errors)
        right = [100 * np.trace(m) / m.sum() for m in (self.motion, self.carrying)]
        worst = e[np.argmax(np.abs(e))]
        return f"| {name} | {len(e)} | {np.median(np.abs(e)):.2f} | {worst:+.2f} | {right[0]:.1f} | {right[1]:.1f} |"


HEAD = "| walks | number | steps: median error % | worst % | motion right % | carrying right % |\n|---|---|---|---|---|---|"


def confusion(names: tuple[str, ...], counts: NDArray[np.int64]) -> str:
    """A confusion matrix, % of each true mode."""
    lines = ["| true \\ found | " + " | ".join(names) + " |", "|" + "---|" * (len(names) + 1)]
    for name, row in zip(names, counts, strict=True):
        share = 100 * row / max(row.sum(), 1)
        lines.append(f"| {name} | " + " | ".join(f"{s:.1f}" for s in share) + " |")
    return "\n".join(lines)


def simulated(seeds: range) -> None:
    """Walks of one gait and one way of carrying, walks with all of them, and stairs."""
    every = Score()
    print(HEAD)
    for gait in ("slow", "walk", "brisk", "run"):
        score = Score()
        for carry in steps.CARRYING:
            for sensor in ("phone", "adis16488"):
                for seed in seeds:
                    score.add(simulate_hand("straight", carry, sensor, seed=seed, gait=gait, length_m=250.0))
        print(score.row(f"one gait ({gait}), one way of carrying"), flush=True)
    for sensor in ("phone", "adis16488"):
        for attitude in (False, True):
            score = Score()
            for seed in seeds:
                made = simulate_hand("building", sensor=sensor, seed=seed, **MIXED)
                score.add(made, attitude=attitude)
                if not attitude:
                    every.add(made)
            print(score.row(f"all ways of carrying, pauses with gestures; {sensor}{', attitude known' * attitude}"), flush=True)
    score = Score()
    for carry in steps.CARRYING:
        for seed in seeds:
            made = simulate_hand("stairs", carry, "phone", seed=seed)
            score.add(made)
            every.add(made)
    print(score.row("stairs, 8 flights up and 8 down; phone with barometer"))
    for seed in seeds:
        for carry in steps.CARRYING:
            every.add(simulate_hand("straight", carry, "phone", seed=seed, gait="run", length_m=250.0))
    print("\nConfusion over the mixed walks, the stairs and the runs, % of the samples:\n")
    print(confusion(steps.MOTIONS, every.motion), "\n")
    print(confusion(steps.CARRYING, every.carrying), "\n")


def peaks(t: NDArray[np.float64], x: NDArray[np.float64], band_hz: tuple[float, float], height: float, apart_s: float) -> int:
    """Peaks of a series after a band pass without delay."""
    good = np.isfinite(x)
    rate = 1 / float(np.median(np.diff(t)))
    smooth = sosfiltfilt(butter(2, np.array(band_hz) / rate * 2, "band", output="sos"), np.interp(t, t[good], x[good]))
    return len(find_peaks(smooth, prominence=height, distance=max(1, int(apart_s * rate)))[0])


def by_force(r: Recording) -> int:
    return peaks(r.time, np.linalg.norm(r.specific_force, axis=1), (0.7, 3.5), 2.0, 0.28)


def by_height(height: float, each: int, r: Recording) -> int:
    assert r.reference is not None
    return each * peaks(r.reference.time, r.reference.position[:, 2], (0.4, 5.0), height, 0.25)


REAL = {
    "hand/ms_indoor20/site1_B1_5dda149f9191710006b57212.txt": by_force,
    "hand/ms_indoor20/site2_F2_5dd3793144333f00067aa1c7.txt": by_force,
    "hand/nexus5_mocap/Guillaume_Nexus5_NoDist_Texting": lambda r: by_height(0.006, 1, r),
    "hand/nexus5_mocap/Thibaud_Nexus5_NoDist_Swinging": lambda r: by_height(0.05, 2, r),
    "hand/nexus5_mocap/calib_mag_Nexus5_d1": lambda _: 0,
    "attitude/broad/12_undisturbed_slow_translation_C.mat": lambda _: 0,
    "attitude/broad/33_disturbed_attached_magnet_2cm.mat": lambda _: 0,
}
"""Recordings, and how their steps were counted independently of the detector."""


def real() -> None:
    print("| recording | duration s | steps | found | carrying, % of the steps |\n|---|---|---|---|---|")
    for name, count in REAL.items():
        if not (DATA / name).exists():
            print(f"| {name} | – | – | – | not at hand |")
            continue
        r = bm.read(DATA / name)
        found = steps.analyse(r)
        n = len(found.event_time)
        shares = [f"{c} {100 * np.mean(found.event_carrying == k):.0f}" for k, c in enumerate(steps.CARRYING) if k in found.event_carrying]
        print(f"| {Path(name).name} | {r.duration_s:.0f} | {count(r)} | {n} | {', '.join(shares)} |")


def speed() -> None:
    print("\n| rate Hz | ns a sample | 10 minutes, s |\n|---|---|---|")
    for rate in (50.0, 100.0, 200.0, 500.0):
        made = simulate_hand("straight", "texting", "phone", length_m=150.0, rate_hz=rate)
        rows = made.recording.samples()
        took = []
        for _ in range(7):
            begin = time.process_time()
            steps.detect(rows, steps.StepParameters())
            took.append((time.process_time() - begin) / len(rows))
        print(f"| {rate:g} | {1e9 * min(took):.0f} | {600 * rate * min(took):.3f} |")


if __name__ == "__main__":
    simulated(range(100, 100 + int(sys.argv[1] if len(sys.argv) > 1 else 5)))
    real()
    speed()
