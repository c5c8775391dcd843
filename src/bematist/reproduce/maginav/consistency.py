"""Whether errors are as large as the filter says: NEES over walks, with matched noise and as shipped."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.earth import STANDARD_GRAVITY
from bematist.evaluate import nees
from bematist.evaluate.metrics import attitude_error_vectors
from bematist.methods import track
from bematist.reproduce.study import Found, Row, Settings
from bematist.simulate import SENSORS, simulate_walk
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

POINTS = 60
QUANTITIES = ("position", "velocity", "attitude")

ACCEL_BIAS, GYRO_BIAS = 0.03, math.radians(0.2)
_TABLE_3 = SENSORS["lsm9ds1"]
UNDISTURBED: dict[str, Any] = {"disturbed": False}

WHITE: dict[str, Any] = UNDISTURBED | {
    "accel_bias_instability": 0.0,
    "gyro_bias_instability": 0.0,
    "accel_bias_sd": ACCEL_BIAS,
    "gyro_bias_sd": GYRO_BIAS,
    "gravity": STANDARD_GRAVITY,
}
"""The sensor of Table 3 with white noise and constant offsets alone, in an undisturbed field."""

_NOISE: dict[str, Any] = {
    "stance": {"threshold": 1.0, "window_s": 0.025},
    "zero_velocity": {"sd": 5e-4},
    "noise": {
        "angle_random_walk": _TABLE_3.angle_random_walk,
        "velocity_random_walk": _TABLE_3.velocity_random_walk,
        "gyro_bias_walk": 0.0,
        "accel_bias_walk": 0.0,
    },
    "initial": {"accel_bias_sd": ACCEL_BIAS, "gyro_bias_sd": GYRO_BIAS, "sway": 0.0, "tilt_sd": 1e-4, "longest_s": 9.5},
}
"""The filter told this; zero_velocity.sd is a floor. The simulated foot stands still to the last digit, so the threshold may be as low as
white noise allows.
"""

_FIELD: dict[str, Any] = {
    "magnetic": {
        "still_fraction": 1.0,
        "tilt_sd": _TABLE_3.velocity_random_walk * math.sqrt(_TABLE_3.rate_hz) / STANDARD_GRAVITY,
        "direction_sd": _TABLE_3.magnetic_noise_density * math.sqrt(_TABLE_3.magnetometer_rate_hz) / (46 * math.cos(math.radians(53))),
    }
}
"""TRIAD's errors as the noise of one sample makes them, MAGINAV Table 3."""

_INVARIANT: dict[str, Any] = {"linearisation": "invariant"}

Runs = dict[str, tuple[str, dict[str, Any]]]
MATCHED: Runs = {"zupt": ("zupt", _NOISE), "zupt, invariant": ("zupt", _NOISE | _INVARIANT), "maginav": ("maginav", _NOISE | _FIELD)}
SHIPPED: Runs = {name: (name, {}) for name in ("zupt", "maginav", "foot")}

SETUPS: dict[str, tuple[str, str, dict[str, Any], Runs]] = {
    "matched, 1 minute": ("short", "lsm9ds1", WHITE, MATCHED),
    "matched, 20 minutes": ("campus", "lsm9ds1", WHITE, MATCHED),
    "matched, samples without noise": ("campus", "ideal", UNDISTURBED | {"gravity": STANDARD_GRAVITY}, {"zupt": MATCHED["zupt"]}),
    "shipped, undisturbed": ("campus", "lsm9ds1", UNDISTURBED, SHIPPED),
    "shipped, disturbed": ("campus", "lsm9ds1", {}, SHIPPED),
}
"""Scenario, sensor, what is changed of them, and by name the methods with what is changed of them."""


def cases(seeds: int) -> list[Settings]:
    """A walk each; a few are enough of the one whose errors are not of interest."""
    return [
        {"setup": setup, "scenario": scenario, "sensor": sensor, "changes": changes, "methods": methods, "seed": seed}
        for setup, (scenario, sensor, changes, methods) in SETUPS.items()
        for seed in range(min(seeds, 5) if sensor == "ideal" else seeds)
    ]


def compute(settings: Settings) -> Found:
    """NEES at instants evenly spaced over the walk, and the error of the last heading with what the filter says of it."""
    made = simulate_walk(settings["scenario"], settings["sensor"], settings["seed"], **settings["changes"])
    rows: list[Row] = []
    arrays: dict[str, Array] = {}
    for name, (method, changes) in settings["methods"].items():
        t = track(made.recording, method, **changes)
        found = nees_along(t, made.truth, POINTS)
        heading = attitude_error_vectors(t.attitude[-1:], made.truth.attitude[-1:])[0, 2]
        rows.append({"method": name} | {f"nees_{q}": float(found[-1, k]) for k, q in enumerate(QUANTITIES)})
        rows[-1]["heading_deg"] = math.degrees(heading)
        rows[-1]["heading_sd_deg"] = math.degrees(math.sqrt(t.packed_covariance[-1, 17]))
        arrays[name] = found
    return Found(rows, arrays)


def nees_along(t: Trajectory, truth: Trajectory, points: int) -> Array:
    """NEES (points,3) of position, velocity and attitude, at instants evenly spaced from the second on, to the last.

    The frames are one: the simulated sensor's x axis points East at the start, which is what the filter takes it for. (To turn the path by
    the attitude error of its first sample would be wrong: that may be TRIAD's already, with the noise of a sample.)
    """
    k = np.linspace(0, len(t) - 1, points + 1).astype(int)[1:]
    errors = (
        t.position[k] - truth.position[k],
        t.velocity[k] - truth.velocity[k],
        attitude_error_vectors(t.attitude[k], truth.attitude[k]),
    )
    packed = t.packed_covariance[k]
    return np.column_stack([nees(e, packed[:, 6 * i : 6 * i + 6]) for i, e in enumerate(errors)])
