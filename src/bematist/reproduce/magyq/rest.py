"""Figure 9: 5000 s at rest where the field is constant, but not the Earth's."""

from __future__ import annotations

import numpy as np

from bematist.ahrs.filters import attitude
from bematist.evaluate.metrics import attitude_error_vectors
from bematist.reproduce.magyq import choices
from bematist.reproduce.numbers import attitude_numbers
from bematist.reproduce.study import Found, Settings
from bematist.simulate import FieldRegion, simulate_walk
from bematist.simulate.field import earth_field

FIELDS: dict[str, tuple[float, float, float]] = {
    "disturbed": (9.0, -5.0, 12.0),
    "of the Earth's norm": (12.0, -8.0, -3.07),
}
"""What is added to the Earth's field, µT. The second leaves the norm as it was to 0.01 µT, and turns the field by 31° in the plan."""

KEPT_EVERY = 500
"""Samples from one attitude that is judged to the next."""


def cases(seeds: int) -> list[Settings]:
    """At most five seeds in each field: one run is 5000 s long."""
    gated = {"with a dip gate": choices.ABLATIONS["with a dip gate"]}
    runs = choices.told("adis16488", choices.FILTERS | gated, choices.STEADY)
    return [{"field": field, "seconds": 5000.0, "methods": runs, "seed": seed} for field in FIELDS for seed in range(min(seeds, 5))]


def compute(settings: Settings) -> Found:
    """Attitude errors after the start, and their course."""
    region = FieldRegion(from_m=-9.0, to_m=9.0, offset_ut=FIELDS[settings["field"]])
    changes = {"rest_s": settings["seconds"], "final_rest_s": 0.0, "mounting_deg": (0.0, 0.0, 0.0), "field_regions": (region,)}
    made = simulate_walk("still", "adis16488", settings["seed"], **changes, **choices.SENSORS["adis16488"])
    # The sensor was carried in: heading and Earth's field are known from outside.
    given = {"heading_deg": 90.0, "earth_field": tuple(earth_field(made.scenario))}
    truth = made.truth.attitude[::KEPT_EVERY]
    rows, arrays = [], {}
    for name, (kind, more) in settings["methods"].items():
        found = attitude(made.recording, kind, config=more, initial=given)
        q = found.attitude[::KEPT_EVERY]
        rows.append({"method": name, **attitude_numbers(q, truth)})
        arrays[name] = np.degrees(attitude_error_vectors(q, truth)).astype(np.float32)
    return Found(rows, arrays)
