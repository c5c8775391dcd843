"""Calibration of a sensor in the hand: from a recording of it being turned about to scale factors, misalignments and offsets.

>>> import bematist as bm
>>> made = bm.simulate("tumble", "adis16488", seed=1)
>>> found = bm.calibrate(made)
>>> better = found.apply(made)

The methodology is that of MAG.I.C.AL. (K. Papafotis, P. P. Sotiriadis, "MAG.I.C.AL. - A unified methodology for magnetic and inertial
sensors calibration and alignment", IEEE Sensors J. 19, 2019) and of D. Tedaldi, A. Pretto, E. Menegatti, ICRA 2014: no rig, and all sensors
in one frame.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Sequence
from typing import Any

from bematist.calibrate.evidence import Evidence
from bematist.calibrate.known import parse_turn
from bematist.calibrate.result import Calibration, SensorCalibration
from bematist.calibrate.session import SENSORS, Request, run
from bematist.earth import STANDARD_GRAVITY
from bematist.errors import UsageError
from bematist.recording import Recording

__all__ = ["Calibration", "Evidence", "SensorCalibration", "calibrate"]


def calibrate(
    recordings: Recording | Sequence[Recording],
    *,
    gravity: float = STANDARD_GRAVITY,
    field: float | None = None,
    turns: Sequence[str] = (),
    sensors: Sequence[str] = (),
) -> Calibration:
    """Calibrate the sensors of one device.

    Parameters
    ----------
    recordings : one or several of the same device. Rests in many positions calibrate the accelerometer, the turns between them the
        gyroscope, turning every way the magnetometer; one recording may hold all.
    gravity : where it was recorded, m/s².
    field : the Earth's flux density there, µT; without it the magnetometer keeps its mean scale.
    turns : turns of a known angle, such as "z=360"; the recording rests before and after each.
    sensors : only these; without it all that the recordings can calibrate.

    Raises
    ------
    DataError
        A sensor that was asked for, or all of them, cannot be calibrated from the recordings; says why and what to record.
    UsageError
        No recording, recordings of two devices, or an unknown sensor or turn.
    """
    given = [recordings] if isinstance(recordings, Recording) else list(recordings)
    _check(given, sensors)
    return run(given, Request(gravity, field, [parse_turn(text) for text in turns], tuple(sensors)))


def _check(given: Sequence[Recording], sensors: Sequence[str]) -> None:
    if not given:
        raise UsageError("There is no recording to calibrate from.")
    if len({r.sensing for r in given}) > 1:
        raise UsageError(
            "The recordings are not of one device, read in the same way: "
            f"{'; '.join(dict.fromkeys(str(r.sensing) for r in given))}. Calibrate each device by itself."
        )
    for name in sensors:
        if name not in SENSORS:
            raise UsageError(f'There is no sensor "{name}". Known: {", ".join(SENSORS)}.')


class _Callable(types.ModuleType):
    # `bematist.calibrate` is this package once it is imported, and the function `calibrate` to whoever calls it.
    def __call__(self, *args: Any, **kwargs: Any) -> Calibration:
        return calibrate(*args, **kwargs)


sys.modules[__name__].__class__ = _Callable
