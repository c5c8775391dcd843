"""What is to be said of a calibration: its verdict on the data, and what a person should do about it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from bematist.calibrate.result import SensorCalibration

OUTLIERS = 0.1
"""Part of the samples left out, beyond which it is said."""


def verdict(s: SensorCalibration) -> str:
    """Whether the data covered what the sensor's calibration needs, in one line."""
    if s.sensor == "accelerometer":
        missing = [f"no rest with {m} up" for m in s.missing]
    elif s.sensor == "magnetometer":
        missing = [f"the field never pointed along {m}" for m in s.missing]
    else:
        missing = []
    missing += [f"{name} not determined" for name in s.undetermined]
    return "; ".join(missing) or "enough directions"


def sensor_warnings(s: SensorCalibration) -> Iterator[str]:
    """What is doubtful about a sensor's calibration."""
    if s.missing or s.undetermined:
        stays = " What is not determined stays as the sensor has it." if s.undetermined else ""
        yield f"{s.sensor.capitalize()}: {verdict(s)}.{stays}"
    if s.left_out > OUTLIERS * (s.samples + s.left_out):
        yield f"{s.sensor.capitalize()}: {s.left_out} of {s.left_out + s.samples} samples disagreed with the others and were left out."
    if s.note:
        yield s.note


COUNTED = {"accelerometer": "rests", "gyroscope": "comparisons after turns", "magnetometer": "samples"}
"""What a sensor is fitted to; after a turn each direction that is seen again and each angle that was told is one comparison."""


def counted(s: SensorCalibration) -> str:
    """What the fit used and what it left out, in words."""
    return f"{s.samples:,} {COUNTED[s.sensor]}{f', {s.left_out:,} more left out' if s.left_out else ''}"


def error_text(s: SensorCalibration) -> str:
    """What the calibration removes, in words: of the readings as they are, and calibrated."""
    if not math.isfinite(s.before):
        return "nothing to judge by"
    if s.sensor == "gyroscope":
        return f"missed by {math.degrees(s.before):.2f}° rms as read, {math.degrees(s.after):.3f}° calibrated"
    what = "off gravity by" if s.sensor == "accelerometer" else "the field's length scatters by"
    return f"{what} {100 * s.before:.2f} % as read, {100 * s.after:.3f} % calibrated"


def rows(s: SensorCalibration) -> Iterator[list[str]]:
    """Offset, scale factors and misalignments with their standard deviations, as cells of a table."""
    factor, unit = {"gyroscope": (math.degrees(1.0), "°/s")}.get(s.sensor, (1.0, {"m/s^2": "m/s²", "uT": "µT"}.get(s.unit, s.unit)))
    off, sd, scale = s.offset * factor, s.offset_sd * factor, np.diag(s.matrix)
    yield [s.sensor, "offset", *(f"{v:.4f} ± {e:.4f}" for v, e in zip(off, sd, strict=True)), unit]
    yield ["", "scale", *(f"{v:.5f} ± {e:.5f}" for v, e in zip(scale, np.diag(s.matrix_sd), strict=True)), ""]
    for k, axis in enumerate("xyz"):
        cells = ["" if j == k else _entry(s.matrix[k, j], s.matrix_sd[k, j]) for j in range(3)]
        yield ["", f"{axis} from", *cells, ""]


def _entry(value: float, sd: float) -> str:
    """An entry of a matrix; one that was not free, by the choice of the frame, has no uncertainty."""
    return f"{value:+.5f} ± {sd:.5f}" if sd > 0 else "0, fixed" if value == 0 else f"{value:+.5f}, fixed"
