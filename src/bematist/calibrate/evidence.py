"""What a calibration was found from: for the report and for whoever wants to look."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.rests import Rests

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Whole:
    """A turn about an axis, "x" to "z", by an angle, and what the gyroscope says of it as read (`before`) and calibrated (`after`), deg."""

    axis: str
    angle: float
    before: float
    after: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """Readings and what was kept of them.

    Attributes
    ----------
    rests : the rests; rests_kept (K,) those that calibrated the accelerometer.
    field : (n,3) magnetometer readings, µT, field_kept (n,), field_weight (n,) the samples each is the mean of; None without magnetometer.
    turns : (T,3) turn between rests, degrees: the way turned, and the angle by which gravity, calibrated, is missed by the gyroscope as
        read and calibrated; those that the fit left out too.
    known_turns : each turn that was told or, where none was, that looks like a whole one; turns_told says which.
    elevation_deg : of the field above the horizon, degrees; NaN where unknown.
    """

    rests: Rests
    rests_kept: NDArray[np.bool_]
    field: Array | None
    field_kept: NDArray[np.bool_]
    turns: Array
    known_turns: tuple[Whole, ...] = ()
    turns_told: bool = False
    elevation_deg: float = float("nan")
