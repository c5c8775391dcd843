"""Whether a recording is one that a calibration was made for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bematist.calibrate.rests import find_rests
from bematist.errors import DataError
from bematist.recording import Recording

if TYPE_CHECKING:
    from bematist.calibrate.result import Calibration

GRAVITY_AT_REST = 0.05
"""Relative: calibrated, a rest cannot be farther from gravity (the Earth's differs by 0.5 %)."""
DOUBTFUL_AT_REST = 0.01
"""Relative: closer than this gravity of any place and what temperature does to a sensor may be; more is said."""
FORCE = (0.7, 1.6)
"""Middle of the specific force over gravity: a walk has 1.0 to 1.1, a run up to 1.5."""
FIELD = (0.25, 4.0)
"""Middle of the field over that of the calibration: indoors it is half or twice, nowhere a quarter or four times."""
UNEVEN = 0.08
"""Scatter of the calibrated field's length over the field, beyond which it is said."""
OTHER_RATE = 0.05
"""Relative: a sampling rate that differs more is that of another sensor, or of other settings."""
WORSE_AT_REST = 0.2
"""°/s by which a gyroscope may read more at rest with its calibration than without: offsets change from one start to the next."""


def check(calibration: Calibration, recording: Recording) -> None:
    """Raise DataError where the recording cannot be one of the device, axes, channel and units that were calibrated."""
    made, own = calibration.sensing, recording.sensing
    name, source = recording.source or "The recording", calibration.source or "a recording"
    if own.calibration:
        raise DataError(f"{name}: it is calibrated already, by {own.calibration}. Apply one calibration to the recording as it was read.")
    if made.device and own.device and made.device != own.device:
        raise DataError(
            f"{name}: it is of the device {own.device}, and the calibration was made for {made.device} (from {source}). Calibrate this "
            "device by itself."
        )
    if made.axes != own.axes:
        raise DataError(
            f"{name}: it was read with {_axes(own.axes)}, and the calibration was made with {_axes(made.axes)}. Read both in the same way: "
            "a calibration is of the sensor's axes, before they are named anew."
        )
    if "magnetometer" in calibration.sensors and recording.has_magnetometer and made.uncalibrated != own.uncalibrated:
        which = "the phone's raw readings" if made.uncalibrated else "the readings that the phone calibrates"
        raise DataError(f"{name}: the calibration was made for {which}, and this recording was read otherwise. See --uncalibrated.")
    _check_force(calibration, recording, name, source)
    _check_field(calibration, recording, name, source)


def doubts(calibration: Calibration, calibrated: Recording) -> list[str]:
    """What a calibrated recording makes doubtful of the calibration."""
    return [*_another_sensor(calibration, calibrated), *_off_at_rest(calibration, calibrated), *_uneven(calibration, calibrated)]


def _another_sensor(calibration: Calibration, calibrated: Recording) -> list[str]:
    """What tells, where the logger names no device, that the calibration may be of another sensor."""
    made, own = calibration.sensing.device, calibrated.sensing.device
    if made and own:
        return []
    signs = [f"the calibration is of the device {made}"] if made else [f"the recording is of the device {own}"] if own else []
    if abs(calibrated.rate_hz / calibration.rate_hz - 1) > OTHER_RATE:
        signs.append(f"the calibration was made at {calibration.rate_hz:.4g} Hz and the recording has {calibrated.rate_hz:.4g} Hz")
    gyroscope, rests = calibration.sensors.get("gyroscope"), find_rests([calibrated])
    if gyroscope is not None and len(rests):
        rate = np.median(rests.rate, axis=0)
        raw, better = (float(np.degrees(np.linalg.norm(w))) for w in (np.linalg.solve(gyroscope.matrix, rate) + gyroscope.offset, rate))
        if better > raw + WORSE_AT_REST:
            signs.append(f"at rest the gyroscope reads {raw:.2f} °/s without it and {better:.2f} °/s with it")
    if not signs:
        return []
    unnamed = "The calibration" if own else "The recording" if made else "Neither the calibration nor the recording"
    verb = "does not name" if made or own else "names"
    return [
        f"The calibration may be of another sensor: {', '.join(signs)}. {unnamed} {verb} a device. Make sure that it is of this sensor: "
        "that of another one does more harm than none."
    ]


def _off_at_rest(calibration: Calibration, calibrated: Recording) -> list[str]:
    sensor, rests = calibration.sensors.get("accelerometer"), find_rests([calibrated])
    if sensor is None or not len(rests):
        return []
    found = float(np.median(np.linalg.norm(rests.force, axis=1)))
    if abs(found / sensor.length - 1) < DOUBTFUL_AT_REST:
        return []
    return [
        f"Calibrated, the accelerometer reads {found:.4g} m/s² at rest, {100 * (found / sensor.length - 1):+.1f} % off gravity "
        f"({sensor.length:.4g}): its offset has changed since, with the temperature or the power, or it is another sensor. Calibrate anew."
    ]


def _uneven(calibration: Calibration, calibrated: Recording) -> list[str]:
    sensor = calibration.sensors.get("magnetometer")
    if sensor is None or not calibrated.has_magnetometer:
        return []
    size = np.linalg.norm(calibrated.magnetic_flux_density, axis=1)
    scatter = float(np.nanstd(size)) / sensor.length
    if scatter < UNEVEN:
        return []
    return [
        f"Calibrated, the magnetic flux density scatters by {100 * scatter:.0f} % of the calibration's {sensor.length:.4g} µT: either "
        "there is iron along the way, or the hard iron is no longer what it was. That of a phone changes from day to day: calibrate just "
        "before the walk."
    ]


def _axes(axes: str) -> str:
    return f'--axes "{axes}"' if axes else "the axes as they are"


def _check_force(calibration: Calibration, recording: Recording, name: str, source: str) -> None:
    sensor = calibration.sensors.get("accelerometer")
    if sensor is None:
        return
    f = sensor.apply(recording.specific_force)
    ratio = float(np.nanmedian(np.linalg.norm(f, axis=1))) / sensor.length if len(f) else 1.0
    rests = find_rests([recording])
    at_rest = float(np.median(np.linalg.norm(sensor.apply(rests.force), axis=1))) / sensor.length if len(rests) else 1.0
    if not FORCE[0] < ratio < FORCE[1] or abs(at_rest - 1) > GRAVITY_AT_REST:
        what = f"{at_rest * sensor.length:.4g} m/s² at rest" if len(rests) else f"{ratio * sensor.length:.4g} m/s² in the middle"
        raise DataError(
            f"{name}: calibrated, the accelerometer reads {what}, where gravity is {sensor.length:.4g}. The calibration (from {source}) is "
            "of another sensor, or of other units or axes: read both recordings in the same way, or calibrate this sensor."
        )


def _check_field(calibration: Calibration, recording: Recording, name: str, source: str) -> None:
    sensor = calibration.sensors.get("magnetometer")
    if sensor is None or not recording.has_magnetometer:
        return
    size = np.linalg.norm(sensor.apply(recording.magnetic_flux_density), axis=1)
    middle = float(np.nanmedian(size)) if np.isfinite(size).any() else sensor.length
    if not FIELD[0] < middle / sensor.length < FIELD[1]:
        raise DataError(
            f"{name}: calibrated, the magnetometer reads {middle:.4g} µT in the middle, where the calibration (from {source}) had "
            f"{sensor.length:.4g}. It is of another sensor or another channel of it, or of other units, or the hard iron has changed: "
            "calibrate the magnetometer anew."
        )
