"""What Android's loggers have in common: units, and a sensor that comes calibrated, uncalibrated or both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bematist.errors import UsageError
from bematist.io.raw import WORDS, Raw, Stream

Array = NDArray[np.float64]

STATED = {"specific_force": "m/s^2", "angular_rate": "rad/s", "magnetic_flux_density": "uT", "pressure": "hPa"}
"""Units of Android's sensors."""


def choose(raw: Raw, quantity: str, calibrated: Array | None, uncalibrated: Array | None) -> None:
    """Put a sensor into `raw.streams` and say which variant it is.

    `calibrated` (N,4) is stamp, x, y, z; `uncalibrated` (N,4) or (N,7) also has the bias that Android estimates. The calibrated one is
    taken: of the magnetometer only it is free of the phone's own field. Without it the bias is taken off the uncalibrated one, which
    is the same but for the moments at which the bias changes.
    """
    word = WORDS[quantity].capitalize()
    if calibrated is not None:
        rows = calibrated
        if uncalibrated is not None:
            raw.notes.append(f"{word}: calibrated by the phone; the uncalibrated samples are not used")
            raw.raw_readings[quantity] = _stream(uncalibrated)
    elif uncalibrated is None:
        return
    elif uncalibrated.shape[1] >= 7 and np.isfinite(uncalibrated[:, 4:7]).all():
        rows = np.column_stack([uncalibrated[:, 0], uncalibrated[:, 1:4] - uncalibrated[:, 4:7]])
        raw.notes.append(f"{word}: uncalibrated, with the phone's own bias taken off")
        raw.raw_readings[quantity] = _stream(uncalibrated)
    else:
        rows = uncalibrated
        raw.notes.append(f"{word}: uncalibrated, and no bias stands beside it")
        raw.uncalibrated = True
        if quantity == "magnetic_flux_density":
            raw.warnings.append(
                "The magnetometer is uncalibrated: the phone's own field, often hundreds of µT, is in it and must be taken off before the "
                "heading means anything."
            )
    raw.streams[quantity] = _stream(rows)


def take_raw(raw: Raw) -> None:
    """Put the raw readings in the place of those that the phone calibrated.

    Raises
    ------
    UsageError
        There are none.
    """
    if not raw.raw_readings and not raw.uncalibrated:
        raise UsageError(f"{raw.source}: there are no uncalibrated readings of any sensor in it. Leave out --uncalibrated.")
    for quantity, stream in raw.raw_readings.items():
        raw.streams[quantity] = stream
        word = WORDS[quantity].capitalize()
        raw.notes[:] = [n for n in raw.notes if not n.startswith(f"{word}: ")]
        raw.notes.append(f"{word}: the uncalibrated readings, as asked")
    raw.uncalibrated = True


def _stream(rows: Array) -> Stream:
    return Stream(stamps=rows[:, 0].copy(), values=rows[:, 1:4].copy())
