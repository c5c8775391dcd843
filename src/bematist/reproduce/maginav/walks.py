"""Figures 5, 6 and 8: a closed walk around a campus, tracked by the paper's algorithm, its rivals, and what came after."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bematist.methods import track
from bematist.report.decimate import path_indices
from bematist.reproduce.numbers import error_along, judged, thinned, walk_numbers
from bematist.reproduce.study import Found, Settings
from bematist.simulate import simulate_walk

METHODS: dict[str, dict[str, Any]] = {m: {} for m in ("zupt", "maginav", "maginav-printed", "madgwick-zupt", "mahony-zupt", "foot")}
"""The methods, as they come."""

WALKS: dict[str, dict[str, Any]] = {"disturbed": {}, "undisturbed": {"disturbed": False}}
"""What is changed of the scenario."""


def cases(seeds: int, methods: Mapping[str, Mapping[str, Any]] = METHODS) -> list[Settings]:
    """One walk each, tracked by all methods with what is changed of them."""
    return [
        {"walk": walk, "scenario": "campus", "changes": changes, "methods": methods, "seed": seed}
        for walk, changes in WALKS.items()
        for seed in range(seeds)
    ]


def compute(settings: Settings) -> Found:
    """Simulate once, track by every method."""
    made = simulate_walk(settings["scenario"], "lsm9ds1", settings["seed"], **settings["changes"])
    truth = thinned(made.truth, 25.0)
    plan = truth.position[:, :2]
    rows, arrays = [], {"truth": plan[path_indices(plan, 1500)].astype(np.float32)}
    for method, changes in settings["methods"].items():
        t = track(made.recording, method, **changes)
        e = judged(t, truth)
        plan = t.position[:, :2]
        rows.append({"method": method, **walk_numbers(t, e)})
        arrays[f"{method} plan"] = plan[path_indices(plan, 1500)].astype(np.float32)
        arrays[f"{method} along"] = error_along(e, truth).astype(np.float32)
    return Found(rows, arrays)
