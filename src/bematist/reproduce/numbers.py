"""Numbers of a case that more than one part or paper asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bematist.evaluate import Evaluation, Nees, evaluate
from bematist.evaluate.metrics import heading_and_tilt
from bematist.reproduce.study import Row
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]


def thinned(truth: Trajectory, rate_hz: float = 50.0) -> Trajectory:
    """The truth at every nth sample, about `rate_hz` a second: an evaluation then takes a fifth of the time."""
    step = max(1, round(len(truth) / (truth.time[-1] - truth.time[0]) / rate_hz))
    names = ("time", "position", "velocity", "attitude", "stance", "packed_covariance")
    return replace(truth, diagnostics={}, **{name: getattr(truth, name)[::step] for name in names})


def judged(trajectory: Trajectory, truth: Trajectory) -> Evaluation:
    """A path against the truth; nothing is aligned but the start."""
    return evaluate(trajectory, truth, align="origin")


def walk_numbers(trajectory: Trajectory, e: Evaluation) -> Row:
    """How far a path is from the truth.

    Closure is the distance in the plan between the path's own ends, also in % of the true length; height_m the size of the last height's
    error.
    """
    closure = float(np.linalg.norm(trajectory.position[-1, :2] - trajectory.position[0, :2]))
    d = e.to_dict()
    return {
        "distance_m": e.reference_distance_m,
        "closure_m": closure,
        "closure_percent": 100 * closure / e.reference_distance_m,
        "rms_m": e.ate_plan_m,
        "largest_m": e.ate_plan_max_m,
        "heading_deg": d["heading_rmse_deg"],
        "tilt_deg": d["tilt_rmse_deg"],
        "height_m": float(abs(e.error[-1, 2])),
        "height_rms_m": e.ate_height_m,
        "length_percent": 100 * (e.length_ratio - 1),
        "stance_percent": 100 * float(trajectory.stance.mean()),
        **_nees("position", e.nees_position),
        **_nees("velocity", e.nees_velocity),
        **_nees("attitude", e.nees_attitude),
    }


def attitude_numbers(estimate: Array, truth: Array) -> Row:
    """How far attitudes (K,4) are from the truth: errors of heading, and of the vertical (tilt), degrees."""
    heading, tilt = (np.degrees(error) for error in heading_and_tilt(estimate, truth))
    return {
        "heading_rms_deg": float(np.sqrt(np.mean(heading**2))),
        "heading_largest_deg": float(np.abs(heading).max()),
        "heading_last_deg": float(heading[-1]),
        "tilt_rms_deg": float(np.sqrt(np.mean(tilt**2))),
    }


def _nees(name: str, found: Nees | None) -> Row:
    return {f"nees_{name}": found.mean if found else None, f"inside_{name}": found.inside if found else None}


def error_along(e: Evaluation, truth: Trajectory, points: int = 300) -> Array:
    """Distance gone, error in the plan and error of the height (points,3), m, at instants evenly spaced over the walk."""
    k = np.linspace(0, len(e.time) - 1, points).astype(int)
    gone = np.concatenate([[0.0], np.linalg.norm(np.diff(truth.position[:, :2], axis=0), axis=1).cumsum()])
    return np.column_stack([gone[e.rows_used[k]], np.linalg.norm(e.error[k, :2], axis=1), e.error[k, 2]])
