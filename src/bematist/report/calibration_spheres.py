"""What the page and the picture of a calibration draw: readings before and after, over the sphere that they should lie on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate import Calibration, SensorCalibration

Array = NDArray[np.float64]

FAR = 1.5
"""Readings whose middle is this many lengths from zero are drawn about their offset, else the sphere would be a dot."""


@dataclass(frozen=True, eq=False)
class Sphere:
    """Readings (n,3) of one sensor over the length they should have, as read (`before`) and calibrated (`after`); kept (n,).
    `shifted` says in words where the readings are drawn less their offset.
    """

    sensor: str
    what: str
    before: Array
    after: Array
    kept: NDArray[np.bool_]
    shifted: str

    @property
    def errors(self) -> tuple[Array, Array]:
        """Of the length, percent, (n,) each."""
        return tuple(100 * (np.linalg.norm(x, axis=1) - 1) for x in (self.before, self.after))  # pyright: ignore[reportReturnType]


def spheres(found: Calibration) -> list[Sphere]:
    """A sphere for accelerometer and magnetometer, as far as they were calibrated."""
    if found.evidence is None:
        return []
    e, out = found.evidence, []
    if "accelerometer" in found.sensors and len(e.rests):
        out.append(_sphere(found["accelerometer"], e.rests.force, e.rests_kept, "rests"))
    if "magnetometer" in found.sensors and e.field is not None:
        out.append(_sphere(found["magnetometer"], e.field, e.field_kept, "samples, and means over rests"))
    return out


def _sphere(s: SensorCalibration, readings: Array, kept: NDArray[np.bool_], what: str) -> Sphere:
    middle = s.offset if np.linalg.norm(s.offset) > FAR * s.length else np.zeros(3)
    shifted = " less the offset" if middle.any() else ""
    return Sphere(s.sensor, what, (readings - middle) / s.length, s.apply(readings) / s.length, kept, shifted)
