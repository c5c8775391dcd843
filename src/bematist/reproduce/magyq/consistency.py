"""Whether the filter knows how wrong its attitude is: NEES over walks inside a building, with a fixed and with an estimated reference."""

from __future__ import annotations

import math

import numpy as np

from bematist.ahrs.filters import attitude
from bematist.evaluate import nees
from bematist.evaluate.metrics import attitude_error_vectors
from bematist.reproduce.magyq import choices
from bematist.reproduce.study import Found, Row, Settings
from bematist.simulate import IndoorField, simulate_hand

LENGTH_M = 300.0
POINTS = 60

WHITE: choices.Changes = {
    **{f"{sensor}_{what}_sd": 0.0 for sensor in ("accel", "gyro", "magnetic") for what in ("scale", "misalignment")},
    "magnetic_bias_sd": 0.0,
    "gyro_bias_instability": 0.0,
    "accel_bias_instability": 0.0,
    "accel_lsb": 0.0,
    "gyro_lsb": 0.0,
    "magnetic_lsb": 0.0,
    "parked_cars": (),
    "facades": (),
    "pauses": (),
    "length_m": LENGTH_M,
}
"""A phone that errs as the filter believes: white noise, constant offsets and the random walk of the gyroscope's."""

_NO_EARTH: choices.Changes = {"attitude": {"magnetic": {"earth": False}}}
_TOLD: choices.Changes = {"attitude": {"magnetic": {"sd": 0.4}}, "initial": {"accel_bias_sd": 0.05, "tilt_sd": math.radians(0.5)}}
"""The noise of a sample; what the rest at the start leaves open."""

RUNS: choices.Runs = {
    "magyq": ("magyq", {}),
    "magyq, local fields only": ("magyq", _NO_EARTH),
    "bias noise as printed": choices.ABLATIONS["bias noise as printed"],
    "magyq-estimated": ("magyq-estimated", {}),
    "magyq-estimated, local fields only": ("magyq-estimated", _NO_EARTH),
    "hand": ("hand", {}),
}


def cases(seeds: int) -> list[Settings]:
    """A walk each."""
    changes = WHITE | {"carries": choices.PUT_DOWN}
    return [{"changes": changes, "methods": choices.told("phone", RUNS, choices.STEADY, _TOLD), "seed": seed} for seed in range(seeds)]


def compute(settings: Settings) -> Found:
    """NEES of the attitude at instants evenly spaced over the walk, and at its end."""
    indoors = (IndoorField(from_m=20.0, to_m=settings["changes"]["length_m"]),)
    made = simulate_hand("building", "texting", "phone", settings["seed"], indoor_fields=indoors, **settings["changes"])
    k = np.linspace(np.searchsorted(made.truth.time, made.steps.begin[0]), len(made.truth) - 1, POINTS).astype(int)
    rows: list[Row] = []
    arrays = {"time": made.truth.time[k]}
    for name, (kind, more) in settings["methods"].items():
        found = attitude(made.recording, kind, config=more)
        assert found.packed_covariance is not None
        error, packed = attitude_error_vectors(found.attitude[k], made.truth.attitude[k]), found.packed_covariance[k]
        arrays[name] = nees(error, packed)
        rows.append({"method": name, "nees": float(arrays[name][-1]), "nees_median": float(np.nanmedian(arrays[name]))})
        rows[-1] |= {"heading_deg": math.degrees(error[-1, 2]), "heading_sd_deg": math.degrees(math.sqrt(packed[-1, 5]))}
    return Found(rows, arrays)
