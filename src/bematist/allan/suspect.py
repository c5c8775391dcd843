"""What does not look like a sensor at rest: wrong units, an axis that is saturated, stuck or coarse."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bematist.allan.result import SensorAllan
from bematist.earth import STANDARD_GRAVITY
from bematist.errors import DataError
from bematist.io.guess import saturated
from bematist.recording import Recording

Array = NDArray[np.float64]

GRAVITY_TOLERANCE = 0.15
"""Relative: an accelerometer that was never calibrated is within this of gravity."""
LARGEST_OFFSET = 0.7
"""rad/s: a steady rate of more is no offset of a gyroscope (40 °/s)."""
LARGEST_WHITE = math.radians(0.2)
"""rad/s/√Hz: ten times the noise of a phone's gyroscope."""
REPEATED = 0.6
"""An axis whose samples equal the one before this often is coarser than its noise."""
CLIPPED = 0.01
"""An axis at rest that stands at its extreme this often is saturated; less often, samples were held."""


def check_axis(sensor: str, axis: str, values: Array) -> str:
    """What is wrong with an axis (n,), or an empty string."""
    if sensor == "quaternion":
        return ""
    if np.ptp(values) == 0:
        return f"{sensor} {axis}: every sample is {values[0]:.6g}. The axis is stuck, or was never written; it has no noise."
    at = saturated(values[:, None])
    if at and at[0][2] > CLIPPED * len(values):
        return (
            f"{sensor} {axis}: {at[0][2]} samples stand at {at[0][1]:.6g}, the end of the range. Its noise is cut off; "
            "turn the sensor, or choose a wider range."
        )
    repeated = float(np.mean(values[1:] == values[:-1]))
    if repeated > REPEATED:
        return (
            f"{sensor} {axis}: {100 * repeated:.0f} % of the samples repeat the one before. Either samples were held, or the quantum is "
            "coarser than the noise; the white noise is then that of rounding, not of the sensor."
        )
    return ""


def poorly_fitted(s: SensorAllan) -> list[str]:
    """Warnings of axes whose curve the noises do not describe, and of samples that were smoothed."""
    fits = [(axis, fit) for axis, fit in zip(s.axes, s.fits, strict=True) if fit is not None]
    poor = [f"{axis} by {100 * fit.departure:.0f} %" for axis, fit in fits if not fit.good]
    smooth = [f"{axis} from {fit.from_s:.2g} s" for axis, fit in fits if fit.skipped]
    out = []
    if poor:
        out.append(
            f"{s.name}: no sum of these noises describes its Allan variance ({', '.join(poor)}): something moved, vibrated, warmed up or "
            "disturbed the field. Of such an axis noise.toml takes nothing."
        )
    if smooth:
        out.append(
            f"{s.name}: neighbouring samples are not independent. A filter smooths them, or a slower sensor's samples were held or "
            f"interpolated. Only longer averages are fitted: {', '.join(smooth)} on."
        )
    return out


def check_units(recording: Recording, start: float, end: float, sensors: Mapping[str, SensorAllan]) -> list[str]:
    """Warnings where a reading at rest is not that of a sensor at rest.

    Raises
    ------
    DataError
        The specific force is not gravity, or the angular rate is too large for an offset.
    """
    name = recording.source or "The recording"
    part = slice(*np.searchsorted(recording.time, [start, end + 1e-9]))
    force = float(np.linalg.norm(np.nanmean(recording.specific_force[part], axis=0)))
    if abs(force / STANDARD_GRAVITY - 1) > GRAVITY_TOLERANCE:
        raise DataError(
            f"{name}: at rest the specific force is {force:.4g}, and should be gravity, {STANDARD_GRAVITY:.2f} m/s². "
            "If it is in g or mg give the unit, such as --units specific_force=g (in Python, multiply first)."
        )
    rate = float(np.linalg.norm(np.nanmean(recording.angular_rate[part], axis=0)))
    if rate > LARGEST_OFFSET:
        raise DataError(
            f"{name}: at rest the angular rate is {rate:.4g} rad/s. If it is in deg/s give the unit, --units angular_rate=deg/s "
            "(in Python, multiply first); if the sensor turned, record it at rest."
        )
    white = sensors["gyroscope"].white() or 0.0
    if white > LARGEST_WHITE:
        return [
            f"The white noise of the gyroscope, {math.degrees(white):.3g} °/s/√Hz, is more than any sensor's for people. If the file is in "
            "deg/s give the unit: --units angular_rate=deg/s."
        ]
    return []
