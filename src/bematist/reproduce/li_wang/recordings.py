"""The same variants on real recordings: those of `BEMATIST_SHARED`, or of ../shared/data beside the working folder."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bematist.evaluate import evaluate
from bematist.io import read
from bematist.methods import track
from bematist.reproduce.li_wang.variants import VARIANTS
from bematist.reproduce.study import Found, Row, Settings
from bematist.trajectory import Trajectory

WALKS = {
    "GSU 32": ("gsu_gx5/SensorConnectData_32.csv", "walk"),
    "GSU 35": ("gsu_gx5/SensorConnectData_35.csv", "run"),
    "Vicon 11-22-11-22": ("pyshoe_vicon/2017-11-22-11-22-03.mat", "walk"),
    "Vicon 11-22-11-30": ("pyshoe_vicon/2017-11-22-11-30-14.mat", "walk"),
    "Vicon 11-27": ("pyshoe_vicon/2017-11-27-11-18-11.mat", "run"),
    "Vicon 12-15": ("pyshoe_vicon/2017-12-15-18-01-18.mat", "run"),
    "Vicon 02-09": ("pyshoe_vicon/2018-02-09-11-18-04.mat", "slow"),
    "NGIMU": ("ngimu/short_walk.csv", "walk"),
    "OpenShoe": ("openshoe/OpenShoe_Matlab_Implementation_Measurement_100521_44_data_inert.txt", "walk"),
}
"""File below foot/, and how was gone."""


def folder() -> Path:
    """Where the recordings are, if they are."""
    return Path(os.environ.get("BEMATIST_SHARED", "../shared/data")) / "foot"


def cases(seeds: int) -> list[Settings]:
    """A case for each recording that is there."""
    variants = [[name, method, changes] for name, (method, changes) in VARIANTS.items()]
    return [
        {"recording": name, "gait": gait, "file": file, "variants": variants}
        for name, (file, gait) in WALKS.items()
        if (folder() / file).exists()
    ]


def compute(settings: Settings) -> Found:
    """Read once, track by every variant."""
    recording = read(folder() / settings["file"])
    rows = []
    for name, method, changes in settings["variants"]:
        t = track(recording, method, config=changes)
        # The reference's heading has nothing to do with the sensor's: yaw and place are fitted.
        judged = {} if recording.reference is None else _judged(evaluate(t, recording.reference, align="yaw").to_dict())
        rows.append({"variant": name, "distance_m": t.distance_m, **judged, **_closure(t)})
    return Found(rows)


def _judged(d: Row) -> Row:
    return {"rms_m": d["ate_rmse_2d_m"], "end_m": d["end_point_m"], "length_percent": 100 * (d["length_ratio"] - 1)} | {
        "height_rms_m": d["ate_rmse_height_m"],
        "heading_deg": d["heading_rmse_deg"],
    }


def _closure(t: Trajectory) -> Row:
    return {"closure_m": float(np.linalg.norm(t.position[-1, :2] - t.position[0, :2])), "stance_percent": 100 * float(t.stance.mean())}
