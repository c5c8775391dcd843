"""Table 4: run times of the algorithms, as ratios."""

from __future__ import annotations

import time

from bematist.methods import track
from bematist.reproduce.study import Found, Settings
from bematist.simulate import simulate

METHODS = ("maginav", "madgwick-zupt", "mahony-zupt", "zupt", "foot")


def cases(seeds: int) -> list[Settings]:
    """One: many rounds over one walk."""
    return [{"scenario": "campus", "changes": {}, "rounds": 15, "methods": METHODS, "seed": 0}]


def compute(settings: Settings) -> Found:
    """Processor time of this thread of every method in every round, ns per sample; one call of each after the other, so that a busy machine
    slows all alike."""
    recording = simulate(settings["scenario"], "lsm9ds1", settings["seed"], **settings["changes"])
    for method in settings["methods"]:
        track(recording, method)  # compiled and in the caches
    rows = []
    for k in range(settings["rounds"]):
        for method in settings["methods"]:
            start = time.thread_time()
            track(recording, method)
            rows.append({"round": k, "method": method, "ns_per_sample": 1e9 * (time.thread_time() - start) / len(recording)})
    return Found(rows)
