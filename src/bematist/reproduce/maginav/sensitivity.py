"""Which of the choices that the paper leaves open, or prints wrong, matter: one changed at a time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bematist.methods import track
from bematist.report.decimate import path_indices
from bematist.reproduce.numbers import judged, thinned, walk_numbers
from bematist.reproduce.study import Found, Settings
from bematist.simulate import simulate_walk

BASELINE = "as shipped"
TRANSPOSED = "transposed as printed"

STANCE: dict[str, dict[str, dict[str, Any]]] = {
    # 3, 5, 15 and 25 samples at 238 Hz; 9 as shipped
    "N (eqs 1, 2)": {f"{n} samples": {"stance": {"window_s": n / 238}} for n in (3, 5, 15, 25)},
    "γ (eq 3)": {f"{g}": {"stance": {"threshold": g}} for g in (15, 50, 500, 1500)},
    "window (eq 2)": {p: {"stance": {"placement": p}} for p in ("forward", "causal")},
    "σ_v (eq 24)": {f"{s:g} m/s": {"zero_velocity": {"sd": s}} for s in (0.001, 0.003, 0.03, 0.1)},
}
"""Choices about stance; shipped are 9 samples, 150, centred, 0.01 m/s."""

OTHERS: dict[str, dict[str, dict[str, Any]]] = {
    "attitude of f (eq 14)": {"end of the interval": {"attitude": {"force_at": "end"}}},
    "errors (eqs 20-22)": {"invariant": {"linearisation": "invariant"}},
    "C (eqs 8, 9)": {"first order, made orthogonal": {"attitude": {"integration": "first-order-matrix"}}},
    "Q (eq 23)": {"variance of a sample × τ": {"noise": {"growth": "per-sample"}}},
    "gyroscope's noise": {f"{d:g} °/√s": {"noise": {"angle_random_walk": math.radians(d)}} for d in (0.017, 0.5)},
    "start (eqs 4, 11)": {"one sample": {"initial": {"average": False}}},
}
"""Other choices that concern every method; shipped are the middle, the exponential, density² τ, 0.1 °/√s, the mean of 10 s."""

MAGNETIC: dict[str, dict[str, dict[str, Any]]] = {
    "m_thr (eq 5)": {f"{100 * m:g} % of the norm": {"magnetic": {"norm_tolerance": m}} for m in (0.01, 0.02, 0.1, 0.2)},
    "inclination gate": {
        "none, as in the paper": {"magnetic": {"inclination_tolerance": math.pi}},
        **{f"{d}°": {"magnetic": {"inclination_tolerance": math.radians(d)}} for d in (2, 10)},
    },
    "where in stance": {"anywhere, as in the paper": {"magnetic": {"still_fraction": 1.0}}},
    "P at TRIAD (Table 2)": {"untouched": {"magnetic": {"covariance": "untouched"}}},
    "TRIAD (eq 11)": {TRANSPOSED: {"magnetic": {"triad": "printed"}}},
}
"""Choices about the magnetometer; shipped are 5 %, 5°, the quiet part of a stance, TRIAD's covariance, corrected."""

LISTEN = {"gated": {"attitude": {"magnetometer": "gated"}}}
RIVALS: dict[str, dict[str, dict[str, dict[str, Any]]]] = {
    "madgwick-zupt": {"β": {f"{b} /s": {"attitude": {"beta": b}} for b in (0.003, 0.01, 0.03)}, "field": LISTEN},
    "mahony-zupt": {"kp": {f"{k} /s": {"attitude": {"kp": k}} for k in (0.01, 0.05, 0.2)}, "field": LISTEN},
}
"""The gains of the rivals, of which the paper says nothing; shipped are the literature's 0.1 and 1 /s, and every sample of the field."""

WALKS: dict[str, tuple[dict[str, Any], dict[str, dict[str, dict[str, dict[str, Any]]]]]] = {
    "still foot": ({}, {"zupt": STANCE | OTHERS, "maginav": STANCE | OTHERS | MAGNETIC, **RIVALS}),
    "still foot, undisturbed": ({"disturbed": False}, {"maginav": STANCE | OTHERS | MAGNETIC}),
    "rocking foot": ({"rocking_deg": 3.0}, {"zupt": STANCE, "maginav": STANCE}),
}
"""What is changed of the scenario, and what is varied for each method."""


def variants(tables: dict[str, dict[str, dict[str, dict[str, Any]]]]) -> list[list[Any]]:
    """Lists of method, choice, value and changed parameters."""
    found: list[list[Any]] = []
    for method, table in tables.items():
        found.append([method, BASELINE, "", {}])
        found += [[method, choice, value, changes] for choice, values in table.items() for value, changes in values.items()]
    return found


def cases(seeds: int) -> list[Settings]:
    """Half as many walks as elsewhere, each tracked some fifty times."""
    return [
        {"walk": walk, "scenario": "campus", "changes": changes, "variants": variants(tables), "seed": seed}
        for walk, (changes, tables) in WALKS.items()
        for seed in range((seeds + 1) // 2)
    ]


def compute(settings: Settings) -> Found:
    """Simulate once, track by every variant. The plan is kept of the baseline and of what is transposed."""
    made = simulate_walk(settings["scenario"], "lsm9ds1", settings["seed"], **settings["changes"])
    truth = thinned(made.truth, 10.0)
    plan = truth.position[:, :2]
    rows, arrays = [], {"truth": plan[path_indices(plan, 1500)].astype(np.float32)}
    for method, choice, value, changes in settings["variants"]:
        t = track(made.recording, method, **changes)
        rows.append({"method": method, "choice": choice, "value": value, **walk_numbers(t, judged(t, truth))})
        if method == "maginav" and (choice == BASELINE or value == TRANSPOSED):
            plan = t.position[:, :2]
            arrays[value or BASELINE] = plan[path_indices(plan, 1500)].astype(np.float32)
    return Found(rows, arrays)
