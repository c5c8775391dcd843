"""Figures 11 to 13: three people walk 1.5 km outdoors and through a building, a hand holds the sensor before them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bematist import config
from bematist.ahrs.filters import attitude
from bematist.evaluate import nees
from bematist.evaluate.metrics import attitude_error_vectors
from bematist.frames import rotate
from bematist.methods import METHODS, track
from bematist.report.decimate import path_indices
from bematist.reproduce.magyq import choices
from bematist.reproduce.numbers import attitude_numbers
from bematist.reproduce.study import Found, Row, Settings
from bematist.simulate import HandSimulation, simulate_hand
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

WALKERS = {"M1": 1.84, "W1": 1.62, "M2": 1.75}
"""Heights, m. The paper gives the range from 1.62 to 1.84."""

KEPT_EVERY = 10
POINTS = 400


def cases(seeds: int) -> list[Settings]:
    """A walk each of every person with every sensor."""
    runs = choices.FILTERS | choices.ABLATIONS
    return [case(sensor, walker, seed, runs) for sensor in choices.SENSORS for walker in WALKERS for seed in range(seeds)]


def held_cases(seeds: int) -> list[Settings]:
    """The walk of one person, whose hand holds the sensor in the rest at the start already."""
    start = {"carries": ((0.0, "texting"),)}
    return [case(sensor, "M2", seed, choices.FILTERS, start) for sensor in choices.SENSORS for seed in range(seeds)]


def case(
    sensor: str, walker: str, seed: int, runs: Mapping[str, tuple[str, choices.Changes]], start: choices.Changes | None = None
) -> Settings:
    """A walk: picked up from a table unless `start` says otherwise. The step length is eq 47 with the walker's own numbers, as a
    calibration leaves it (`StepLengthCalibration.parameters`).
    """
    how = {"carries": choices.PUT_DOWN} if start is None else start
    changes = choices.SENSORS[sensor] | {"height_m": WALKERS[walker], **how}
    methods = choices.told(sensor, runs, choices.STEADY if start is None else {})
    walk = {"sensor": sensor, "walker": walker, "scenario": "building", "changes": changes}
    own = {"step_length": {"height": WALKERS[walker], "pendulum": 0.0}}
    return {**walk, "methods": methods, "calibrated": own, "seed": seed}


def compute(settings: Settings) -> Found:
    """Simulate once, run every filter: errors of the attitude, where its headings lead with the true steps, and the whole path of those
    that are methods of `track`.
    """
    seed = len(WALKERS) * settings["seed"] + list(WALKERS).index(settings["walker"])
    made = simulate_hand(settings["scenario"], "texting", settings["sensor"], seed, **settings["changes"])
    kept = slice(None, None, KEPT_EVERY)
    truth = made.truth.attitude[kept]
    begun = made.truth.time[kept] >= made.steps.begin[0]
    points = np.linspace(0, len(truth) - 1, POINTS).astype(int)
    path = made.motion.places(made.steps.along)[0][:, :2]
    rows: list[Row] = []
    arrays: dict[str, Array] = {"truth": path, "time": made.truth.time[kept][points], "inside": inside(made, points * KEPT_EVERY)}
    for name, (kind, more) in settings["methods"].items():
        if name in METHODS:
            found = track(made.recording, kind, config=config.merge(more, settings["calibrated"]))
            packed = found.packed_covariance[:, 12:]
        else:
            found = attitude(made.recording, kind, config=more)
            packed = found.packed_covariance
        q = found.attitude[kept]
        error = attitude_error_vectors(q, truth)
        off = np.linalg.norm(dead_reckoned(made, found.attitude) - path, axis=1)
        rows.append({"method": name, **attitude_numbers(q[begun], truth[begun])})
        rows[-1] |= {"position_rms_m": float(np.sqrt(np.mean(off**2))), "position_last_m": float(off[-1])}
        if packed is not None:
            rows[-1]["nees_median"] = float(np.nanmedian(nees(error, packed[kept])))
        if isinstance(found, Trajectory):
            rows[-1] |= path_numbers(found, made)
            arrays[f"{name} path"] = found.position[path_indices(found.position[:, :2], 1000), :2]
        arrays[f"{name} heading"] = np.degrees(error[points, 2])
    return Found(rows, {name: values.astype(np.float32) for name, values in arrays.items()})


def path_numbers(path: Trajectory, made: HandSimulation) -> Row:
    """Errors of a path against the pedestrian's, and of its steps; `lengths` is where its steps lead in the true directions."""
    reference = made.recording.reference
    assert reference is not None and path.steps is not None
    off = np.linalg.norm((path.position - reference.position)[:, :2], axis=1)
    by_lengths = gone(path.steps.length, made.direction_at(path.steps.time))[1:] - made.motion.body(path.steps.time)[0][:, :2]
    return {
        "path_rms_m": float(np.sqrt(np.mean(off**2))),
        "path_last_m": float(off[-1]),
        "lengths_rms_m": float(np.sqrt(np.mean((by_lengths**2).sum(1)))),
        "distance_percent": 100 * float(path.steps.length.sum() / made.steps.length_m.sum() - 1),
        "steps_percent": 100 * (len(path.steps.time) / len(made.steps) - 1),
    }


def gone(length: Array, direction: Array) -> Array:
    """Positions (K+1,2), m, after steps of these lengths (K,), m, in these directions (K,), rad counter-clockwise from East."""
    way = length[:, None] * np.column_stack([np.cos(direction), np.sin(direction)])
    return np.concatenate([np.zeros((1, 2)), way.cumsum(0)])


def dead_reckoned(made: HandSimulation, q: Array) -> Array:
    """Positions (K+1,2), m, at the ends of the true steps, each gone in the direction in which the device points (N,4) in its middle.

    Only headings make errors here; the wander of the hand about the walking direction is one of them.
    """
    steps = made.steps
    middle = np.searchsorted(made.truth.time, (steps.begin + steps.time) / 2).clip(max=len(q) - 1)
    ahead = rotate(q[middle], np.array(made.pointing))
    return gone(steps.length_m, np.arctan2(ahead[:, 1], ahead[:, 0]))


def inside(made: HandSimulation, rows: NDArray[np.int64]) -> Array:
    """Whether one is in the building (K,) at these samples, 0 or 1."""
    along = made.motion.travelled(made.truth.time[rows])
    return np.any([(along >= field.from_m) & (along <= field.to_m) for field in made.scenario.indoor_fields], axis=0).astype(float)
