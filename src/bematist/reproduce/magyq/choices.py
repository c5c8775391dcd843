"""What the parts of the study share: sensors, what the filters are told of them, and the filters with their ablations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from bematist import config
from bematist.simulate import SENSORS as PRESETS

Changes = dict[str, Any]
Runs = dict[str, tuple[str, Changes]]
"""By name a filter and what is changed of it."""

SENSORS: dict[str, Changes] = {
    "adis16488": {
        "accel_bias_sd": 1.5e-3,
        "gyro_bias_sd": math.radians(0.05),
        "magnetic_bias_sd": 0.0,
        "magnetic_misalignment_sd": 0.0,
    },
    "phone": {},
}
"""The paper calibrates its sensor before the walk: turn-on offsets of accelerometer and magnetometer are gone. The phone is its preset."""

TOLD: dict[str, Changes] = {
    "adis16488": {
        "attitude": {
            "noise": {
                "angle_random_walk": PRESETS["adis16488"].angle_random_walk,
                "gyro_bias_walk": 1e-6,
                "accel_bias_sd": 0.005,
            },
            "magnetic": {"deviation": 0.3, "outlier": 0.8, "sd": 0.1, "earth_sd": 0.1},
            "force": {"sd": 0.05},
        },
        "initial": {"accel_bias_sd": SENSORS["adis16488"]["accel_bias_sd"]},
    },
    "phone": {
        "attitude": {
            "noise": {
                "angle_random_walk": PRESETS["phone"].angle_random_walk,
                "gyro_bias_walk": PRESETS["phone"].gyro_rate_random_walk,
            }
        }
    },
}
"""What the filters are told of a sensor: its noise, thresholds of the detectors that scale with it, and what calibration left."""

STEADY: Changes = {"initial": {"sway": math.radians(0.05)}}
"""The sensor lies on a table in the rest at the start."""

PUT_DOWN = ((0.0, "table"), (0.3, "texting"))
"""Picked up with the first step, as in the paper: its initialisation is static."""

FILTERS: Runs = {
    "gyint": ("gyint", {}),
    "quest": ("quest", {}),
    "magyq": ("magyq", {}),
    "magyq-estimated": ("magyq-estimated", {}),
    "hand": ("hand", {}),
}

ABLATIONS: Runs = {
    "without MARU": ("magyq", {"attitude": {"magnetic": {"gradient": False}}}),
    "without AGU": ("magyq", {"attitude": {"force": {"gradient": False}}}),
    "without local QSF": ("magyq", {"attitude": {"magnetic": {"local": False}, "force": {"local": False}}}),
    "bias noise as printed": ("magyq", {"attitude": {"noise": {"bias_scaling": "printed"}}}),
    "covariance not normalised": ("magyq", {"attitude": {"normalise_covariance": False}}),
    "with a dip gate": ("magyq", {"attitude": {"magnetic": {"dip_tolerance": math.radians(2.5)}}}),
}
"""The paper's filter with something left out or put in."""


def told(sensor: str, runs: Mapping[str, tuple[str, Changes]], *more: Changes) -> Runs:
    """The runs with what is known of a sensor, and what a run changes itself over it."""
    return {name: (f, config.merge(TOLD[sensor], *more, changes)) for name, (f, changes) in runs.items()}
