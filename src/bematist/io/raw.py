"""What a reader found in a file, before units, axes and clock are settled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import units as unit_tables
from bematist.errors import DataError
from bematist.recording import Reference

Array = NDArray[np.float64]

UNITS: dict[str, dict[str, float]] = {
    "specific_force": unit_tables.SPECIFIC_FORCE,
    "angular_rate": unit_tables.ANGULAR_RATE,
    "magnetic_flux_density": unit_tables.MAGNETIC_FLUX_DENSITY,
    "pressure": unit_tables.PRESSURE,
    "time": unit_tables.TIME,
}
WORDS = {
    "specific_force": "accelerometer",
    "angular_rate": "gyroscope",
    "magnetic_flux_density": "magnetometer",
    "pressure": "barometer",
    "time": "time",
}


@dataclass(kw_only=True)
class Stream:
    """Samples of one sensor in the file's own units: stamps (N,), values (N,C), and the sensor's sample counter (N,) if any."""

    stamps: Array
    values: Array
    count: NDArray[np.int64] | None = None


@dataclass(kw_only=True)
class Raw:
    """A file's content. `stated` maps a quantity to the unit that the file states; a missing one is guessed.

    Streams that share one array of stamps (the same object) are columns of one table and share one clock; the others have a clock of
    their own. All stamps, those of the reference too, are in the file's unit of time and count from one instant, which is `start_ns`
    in UNIX time, where the file tells it apart from the stamps. `device` is the one device that recorded, such as a serial number;
    `raw_readings` are what a phone read where `streams` holds what it calibrated, and `uncalibrated` says that `streams` holds such.
    """

    source: str
    streams: dict[str, Stream]
    stated: dict[str, str] = field(default_factory=dict)
    unit_source: str = "stated by the format"
    reference: Reference | None = None
    start_ns: int | None = None
    phone: bool = False
    device: str = ""
    raw_readings: dict[str, Stream] = field(default_factory=dict)
    uncalibrated: bool = False
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def evenly(source: str, arrays: Mapping[str, Any], rate_hz: Any) -> Raw:
    """Arrays (N,3) of quantities, in m/s², rad/s and µT, sampled together at one rate (a number, as an array too).

    Raises
    ------
    DataError
        The arrays do not fit together, or the rate is none.
    """
    rate = np.asarray(rate_hz).ravel()
    shapes = {np.shape(a) for a in arrays.values()}
    if len(shapes) != 1 or len(shape := shapes.pop()) != 2 or shape[1] != 3:
        raise DataError(f"{source}: the sensors have arrays of different shapes, where each must have (N,3).")
    if rate.shape != (1,) or not np.isreal(rate[0]) or not 0 < rate[0] < np.inf:
        raise DataError(f"{source}: sampling_rate must be one number, in Hz.")
    stamps = np.arange(shape[0]) / float(rate[0])
    return Raw(
        source=source,
        streams={quantity: Stream(stamps=stamps, values=np.array(a, float)) for quantity, a in arrays.items()},
        stated={"time": "s", "specific_force": "m/s^2", "angular_rate": "rad/s", "magnetic_flux_density": "uT"},
    )
