"""The paper's four courses, simulated: every variant on the same walk."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.evaluate import evaluate
from bematist.evaluate.metrics import attitude_error_vectors
from bematist.frames import euler_from_quaternion, heading_deg_from_yaw
from bematist.methods import track
from bematist.reproduce.li_wang.variants import PAPER, VARIANTS, YARDSTICKS
from bematist.reproduce.numbers import thinned, walk_numbers
from bematist.reproduce.study import Found, Row, Settings
from bematist.simulate import GAITS, simulate_walk
from bematist.simulate.scenarios import SCENARIOS
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

ROUTES = {
    "rectangle": "Route 1",
    "ellipse": "Route 2",
    "mixed": "Route 3",
    "laps": "Figure 18",
    "ellipse, rocking": "Route 2, by a foot that rocks by 9° while it stands",
    "laps, rocking": "Figure 18, jogged by a foot that rocks by 9° while it stands",
}
"""The courses: scenarios, some with a change, and what they are in the paper."""

ROCKING_DEG = 9.0
_ROCKING_JOG = {**GAITS["jog"].model_dump(), "rocking_deg": ROCKING_DEG}
_CHANGES: dict[str, dict[str, Any]] = {
    "ellipse, rocking": {"rocking_deg": ROCKING_DEG},
    "laps, rocking": {"gaits": [[from_m, _ROCKING_JOG if g.name == "jog" else g.name] for from_m, g in SCENARIOS["laps"].gaits]},
}

SENSOR = {"rate_hz": 100.0, "magnetometer_rate_hz": 0.0}
"""The paper's rate (Table 1); no magnetometer (section 4)."""

POINTS = 500
"""Instants of a course at which errors are kept for the figures."""


def cases(seeds: int) -> list[Settings]:
    """One walk each, tracked by all variants."""
    variants = [[name, method, changes] for name, (method, changes) in VARIANTS.items()]
    return [
        {"route": r, "seed": s, "sensor": "lsm9ds1", "changes": {**SENSOR, **_CHANGES.get(r, {})}, "variants": variants}
        for r in ROUTES
        for s in range(seeds)
    ]


def compute(settings: Settings) -> Found:
    """Simulate once, track by every variant from the true heading of the sensor's x axis at the start."""
    made = simulate_walk(settings["route"].split(",")[0], settings["sensor"], settings["seed"], **settings["changes"])
    truth = thinned(made.truth, 25.0)
    start = float(heading_deg_from_yaw(euler_from_quaternion(made.truth.attitude[:1])[0, 2]))
    rows, arrays = [], _truth_arrays(made.truth, made.recording.angular_rate)
    for name, method, changes in settings["variants"]:
        initial = {**changes.get("initial", {}), "heading_deg": start}
        t = track(made.recording, method, config={**changes, "initial": initial})
        rows.append({"variant": name, **route_numbers(t, made.truth, truth)})
        if name in PAPER or name in YARDSTICKS:
            arrays |= _path_arrays(name, t, made.truth)
    return Found(rows, arrays)


def route_numbers(t: Trajectory, truth: Trajectory, few: Trajectory) -> Row:
    """Numbers of a path; `truth` has a row for every row of `t`, `few` are some of them.

    end_m is in the plan; yaw_end_deg the yaw error of the last row with its sign and yaw_sd_deg the filter's own standard deviation of it;
    heading_1_deg … the rms yaw error in each third of the way.
    """
    e = evaluate(t, few, align="origin", windows_s=(), windows_m=())
    yaw, third = _yaw_error(t, truth), _third(truth)
    rms = {f"heading_{k + 1}_deg": float(np.sqrt(np.mean(yaw[third == k] ** 2))) for k in range(3)}
    return {
        **walk_numbers(t, e),
        "end_m": float(np.linalg.norm(e.error[-1, :2])),
        "end_percent": 100 * float(np.linalg.norm(e.error[-1, :2])) / e.reference_distance_m,
        "yaw_end_deg": float(yaw[-1]),
        "yaw_sd_deg": float(np.degrees(np.sqrt(t.packed_covariance[-1, 17]))),
        **rms,
        **stance_numbers(t.stance, truth),
    }


def stance_numbers(found: NDArray[np.uint8], truth: Trajectory) -> Row:
    """missed_percent of the true stances in which no sample was taken for stance; moving_m_s the rms true speed where one was."""
    true = truth.stance_intervals()
    seen = np.concatenate([[0], found.cumsum()])
    missed = seen[true[:, 1]] == seen[true[:, 0]]
    speed = np.linalg.norm(truth.velocity[found > 0], axis=1)
    return {"missed_percent": 100 * float(missed.mean()), "moving_m_s": float(np.sqrt(np.mean(speed**2))) if len(speed) else None}


def _yaw_error(t: Trajectory, truth: Trajectory) -> Array:
    return np.degrees(attitude_error_vectors(t.attitude, truth.attitude)[:, 2])


def _third(truth: Trajectory) -> NDArray[np.int64]:
    """Which third of the way a row belongs to, 0 to 2."""
    gone = np.concatenate([[0.0], np.linalg.norm(np.diff(truth.position[:, :2], axis=0), axis=1).cumsum()])
    return np.minimum((3 * gone / gone[-1]).astype(int), 2)


def _truth_arrays(truth: Trajectory, angular_rate: Array) -> dict[str, NDArray[Any]]:
    return {
        "time": truth.time[_some(truth)],
        "truth plan": truth.position[::10, :2].astype(np.float32),
        "truth speed": np.linalg.norm(truth.velocity, axis=1).astype(np.float32),
        "truth stance": truth.stance,
        "gyro norm": np.linalg.norm(angular_rate, axis=1).astype(np.float32),
    }


def _path_arrays(name: str, t: Trajectory, truth: Trajectory) -> dict[str, NDArray[Any]]:
    some = _some(truth)
    found = {
        f"{name} plan": t.position[::10, :2],
        f"{name} error": np.degrees(attitude_error_vectors(t.attitude[some], truth.attitude[some])),
        f"{name} yaw sd": np.degrees(np.sqrt(t.packed_covariance[some, 17])),
        f"{name} height": t.position[some, 2],
    }
    if name in ("15mzh", "15mzha"):
        found[f"{name} velocity"] = t.velocity
        found[f"{name} pace"] = t.diagnostics["pace"]
    return {key: value.astype(np.float32) for key, value in found.items()}


def _some(truth: Trajectory) -> NDArray[np.int64]:
    return np.linspace(0, len(truth) - 1, POINTS).astype(int)
