"""Which unit a sensor is in: forced, stated by the file, or guessed; always said, and doubted where the evidence is against it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.io import guess
from bematist.io.raw import UNITS, WORDS, Raw

Array = NDArray[np.float64]

FIELD_OF_AU_UT = 50.0
"""What 1 a.u. of a magnetometer without absolute scale is taken for, µT: a common field of the Earth."""


def check_forced(forced: Mapping[str, str]) -> None:
    """Raise UsageError for a quantity or unit that is not known."""
    for name, unit in forced.items():
        if name not in UNITS:
            raise UsageError(f'Units: there is no quantity "{name}". Quantities: {", ".join(UNITS)}.')
        if unit not in UNITS[name]:
            raise UsageError(f'Units: "{unit}" is no unit of {name}. Choose one of {", ".join(UNITS[name])}.')


def time_factor(raw: Raw, forced: Mapping[str, str]) -> float:
    """Factor from the file's time to s."""
    unit = forced.get("time") or raw.stated.get("time")
    stamps = raw.streams["specific_force"].stamps
    if unit is None:
        if len(stamps) > 10 and np.all(np.diff(stamps) == 1):
            raise DataError(
                f"{raw.source}: the time column counts 1, 2, 3 …: it may number the samples. State its unit in the map, or leave "
                "[time] out and give rate_hz."
            )
        unit = guess.time_unit(stamps)
        raw.warnings.append(f"The unit of time is not stated; from the steps it was taken for {unit}.")
    elif doubt := guess.doubt_time(stamps * UNITS["time"][unit]):
        raw.warnings.append(doubt)
    return UNITS["time"][unit]


def times(values: Array, factor: float) -> Array:
    """Values times the factor; the same array where that is 1."""
    return values if factor == 1 else values * factor


def factor(raw: Raw, name: str, values: Mapping[str, Array], time: Array, forced: Mapping[str, str]) -> float:
    """Factor to SI (µT), with a note on where the unit comes from and a warning where it is a guess or doubtful."""
    word = WORDS[name]
    unit, source = (forced[name], "as asked") if name in forced else (raw.stated.get(name), raw.unit_source)
    if unit == "a.u.":
        raw.notes.append(f"Units of the {word}: arbitrary, 1 = the local field, taken as {FIELD_OF_AU_UT:g} µT")
        raw.warnings.append(
            f"The {word} has no absolute scale (a.u., 1 = the local field); 1 was taken as {FIELD_OF_AU_UT:g} µT. Ratios and "
            "directions hold, the norm in µT does not."
        )
        return FIELD_OF_AU_UT
    if unit is None:
        found, why = guess.unit_of(name, values, time)
        raw.notes.append(f"Units of the {word}: {found}, guessed: {why}")
        raw.warnings.append(
            f"The unit of the {word} is not stated; it was taken for {found} ({why}). Force another with --units {name}=UNIT."
        )
        return UNITS[name][found]
    raw.notes.append(f"Units of the {word}: {unit}, {source}")
    doubt = guess.doubt(name, times(values[name], UNITS[name][unit]), values, time)
    if doubt and not (name in raw.raw_readings and raw.uncalibrated):  # a phone's raw readings may be off by anything
        found, why = guess.unit_of(name, values, time)
        likely = f" The values look like {found} ({why}): if so, give --units {name}={found}." if found != unit else ""
        raw.warnings.append(f"The {word} is in {unit} ({source}), but {doubt}.{likely}")
    return UNITS[name][unit]
