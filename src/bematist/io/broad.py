"""BROAD .mat trials: `imu_acc` m/s², `imu_gyr` rad/s, `imu_mag` µT at `sampling_rate` Hz, and the optical truth.

The truth is `opt_quat` (wxyz, ENU of magnetic north, NaN where the cameras lost the sensor) and `opt_pos` (m); errors count where
`movement` is 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.mat import load, names
from bematist.io.raw import Raw, evenly
from bematist.recording import Reference

SENSORS = {"specific_force": "imu_acc", "angular_rate": "imu_gyr", "magnetic_flux_density": "imu_mag"}


def sniff(head: Head) -> bool:
    return head.raw[:6] == b"MATLAB" and {"imu_acc", "imu_gyr", "sampling_rate"} <= set(names(head.path))


def read(head: Head) -> Raw:
    mat = load(head.path)
    raw = evenly(str(head.path), {q: mat[name] for q, name in SENSORS.items() if name in mat}, mat["sampling_rate"])
    raw.unit_source = "as BROAD writes them"
    raw.reference = reference_of(mat)
    return raw


def reference_of(mat: dict[str, Any]) -> Reference | None:
    if "opt_quat" not in mat or "sampling_rate" not in mat:
        return None
    attitude: NDArray[np.float64] = np.asarray(mat["opt_quat"], float)
    n = len(attitude)
    position = np.asarray(mat.get("opt_pos", np.full((n, 3), np.nan)), float)
    judged = np.asarray(mat["movement"]).ravel() > 0 if "movement" in mat else np.ones(n, bool)
    if attitude.shape != (n, 4) or position.shape != (n, 3) or judged.shape != (n,):
        raise DataError(
            f"opt_quat has shape {attitude.shape}, opt_pos {position.shape} and movement {judged.shape}: they must have one row each."
        )
    return Reference(
        time=np.arange(n) / float(np.asarray(mat["sampling_rate"]).ravel()[0]),
        position=position,
        attitude=attitude,
        judged=judged,
        note="motion capture (BROAD), ENU of magnetic north, judged in the movement phase",
    )
