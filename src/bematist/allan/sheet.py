"""Coefficients as data sheets write them. The factor makes the SI value (rad/s, m/s², µT, s) one of the named unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from bematist.earth import STANDARD_GRAVITY
from bematist.units import ANGULAR_RATE

_DEG_S = 1 / ANGULAR_RATE["deg/s"]
_UG = 1e6 / STANDARD_GRAVITY
_HOUR = 3600.0
_ROOT_HOUR = math.sqrt(_HOUR)

SYMBOLS = {"quantisation": "Q", "white": "N", "flicker": "B", "markov": "s", "walk": "K", "ramp": "R"}

SI = {
    "gyroscope": {
        "quantisation": "rad",
        "white": "rad/√s",
        "flicker": "rad/s",
        "markov": "rad/s",
        "walk": "rad/s^1.5",
        "ramp": "rad/s²",
    },
    "accelerometer": {
        "quantisation": "m/s",
        "white": "m/s²/√Hz",
        "flicker": "m/s²",
        "markov": "m/s²",
        "walk": "m/s^2.5",
        "ramp": "m/s³",
    },
    "magnetometer": {
        "quantisation": "µT·s",
        "white": "µT/√Hz",
        "flicker": "µT",
        "markov": "µT",
        "walk": "µT/√s",
        "ramp": "µT/s",
    },
    "quaternion": {"quantisation": "s", "white": "√s", "flicker": "1", "markov": "1", "walk": "1/√s", "ramp": "1/s"},
}
"""Units of the coefficients inside; the magnetometer's in µT as everywhere, the gyroscope quaternion's without a unit."""

SHEET = {
    "gyroscope": {
        "quantisation": (("arcsec", _DEG_S * 3600),),
        "white": (("°/√h", _DEG_S * _ROOT_HOUR), ("°/s/√Hz", _DEG_S)),
        "flicker": (("°/h", _DEG_S * _HOUR),),
        "markov": (("°/h", _DEG_S * _HOUR),),
        "walk": (("°/h/√h", _DEG_S * _HOUR * _ROOT_HOUR),),
        "ramp": (("°/h/h", _DEG_S * _HOUR**2),),
    },
    "accelerometer": {
        "quantisation": (("mm/s", 1e3),),
        "white": (("µg/√Hz", _UG), ("m/s/√h", _ROOT_HOUR)),
        "flicker": (("µg", _UG),),
        "markov": (("µg", _UG),),
        "walk": (("µg/√h", _UG * _ROOT_HOUR),),
        "ramp": (("µg/h", _UG * _HOUR),),
    },
    "magnetometer": {
        "quantisation": (("nT·s", 1e3),),
        "white": (("nT/√Hz", 1e3),),
        "flicker": (("nT", 1e3),),
        "markov": (("nT", 1e3),),
        "walk": (("nT/√h", 1e3 * _ROOT_HOUR),),
        "ramp": (("nT/h", 1e3 * _HOUR),),
    },
    "quaternion": dict.fromkeys(SYMBOLS, ()),
}
"""Units of data sheets and their factors, the customary one first."""

WORDS = {
    "quantisation": "quantisation",
    "white": "white noise",
    "flicker": "bias instability",
    "markov": "Gauss-Markov",
    "walk": "random walk",
    "ramp": "ramp",
}


HEADER = ("sensor", "axis", "noise", "", "value", "95 % interval", "unit", "SI")
"""Of a table of `cells`."""


def cells(row: Mapping[str, Any]) -> list[str]:
    """A row of `AllanResult.coefficients` as a table shows it, in the unit of data sheets and in SI."""
    which = "sheet_" if row["sheet_unit"] else ""
    unit = row["sheet_unit"] or row["unit"]
    value, low, high = (row[f"{which}{key}"] for key in ("value", "low", "high"))
    names = [row["sensor"], row["axis"], row["noise"], row["symbol"]]
    if not row["found"]:
        return [*names, "not found", f"< {high:.3g}", unit, f"< {row['high']:.3g} {row['unit']}"]
    return [*names, f"{value:.4g}", f"{low:.4g} … {high:.4g}", unit, f"{row['value']:.4g} {row['unit']}"]


def curve_unit(sensor: str) -> tuple[str, float]:
    """Unit of a curve of deviations as data sheets write it, and the factor of the SI value; that of bias instability."""
    units = SHEET[sensor]["flicker"]
    return units[0] if units else ("1", 1.0)
