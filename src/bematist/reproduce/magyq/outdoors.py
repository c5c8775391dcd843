"""Figure 10: a walk outdoors with the offset of the gyroscope known too large."""

from __future__ import annotations

import math

import numpy as np

from bematist.ahrs.filters import attitude
from bematist.evaluate.metrics import heading_and_tilt
from bematist.frames import conjugate, rotate
from bematist.reproduce.magyq import choices, walks
from bematist.reproduce.numbers import attitude_numbers
from bematist.reproduce.study import Found, Settings
from bematist.simulate import simulate_hand

TOO_MUCH = math.radians(0.05)
"""By how much the offset is exaggerated, rad/s, about the vertical. The paper says "slightly", and shows a drift."""

RUNS: choices.Runs = {
    "gyint": ("gyint", {}),
    "gyint, biased": ("gyint", {}),
    "magyq, biased": ("magyq", {}),
    "magyq-estimated, biased": ("magyq-estimated", {}),
    "hand, biased": ("hand", {}),
}


def cases(seeds: int) -> list[Settings]:
    """A walk each, past parked cars and a facade."""
    changes = choices.SENSORS["adis16488"] | {"indoor_fields": (), "carries": choices.PUT_DOWN}
    # An offset that may be wrong by that much, as the filter must be told: the rest seems to turn by 0.5° in its ten seconds.
    runs = choices.told("adis16488", RUNS, {"initial": {"sway": 10 * TOO_MUCH}})
    return [{"scenario": "building", "changes": changes, "methods": runs, "seed": seed} for seed in range(seeds)]


def compute(settings: Settings) -> Found:
    """Headings with the offset of the rest as it is, and exaggerated."""
    made = simulate_hand(settings["scenario"], "texting", "adis16488", settings["seed"], **settings["changes"])
    resting = made.truth.time < made.steps.begin[0]
    wrong = made.recording.angular_rate.copy()
    wrong[resting] += rotate(conjugate(made.truth.attitude[resting]), np.array([0.0, 0.0, TOO_MUCH]))
    biased = made.recording.replace(angular_rate=wrong)
    kept = np.flatnonzero(~resting)[:: walks.KEPT_EVERY]
    truth = made.truth.attitude[kept]
    points = np.linspace(0, len(kept) - 1, walks.POINTS).astype(int)
    rows, arrays = [], {"time": made.truth.time[kept][points]}
    for name, (kind, more) in settings["methods"].items():
        q = attitude(biased if "biased" in name else made.recording, kind, config=more).attitude[kept]
        rows.append({"method": name, **attitude_numbers(q, truth)})
        arrays[name] = np.degrees(heading_and_tilt(q, truth)[0])[points]
    return Found(rows, {name: values.astype(np.float32) for name, values in arrays.items()})
