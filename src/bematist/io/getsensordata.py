"""GetSensorData (CAR-CSIC, the logs of the IPIN competitions): `ACCE;AppTimestamp;SensorTimestamp;x;y;z;accuracy`, `%` comments.

Two clocks stand in each line. The app's is common to all sensors and jitters; the sensor's is exact and may begin anywhere. The stamps
are the sensor's, moved to the app's clock by the median difference, which is one number for all sensors where theirs agree.
"""

from __future__ import annotations

import re

import numpy as np

from bematist.io.android import STATED
from bematist.io.gnss import fixes
from bematist.io.head import Head
from bematist.io.raw import Array, Raw, Stream
from bematist.io.tagged import read_tagged

LINE = re.compile(r"(ACCE|GYRO|MAGN|PRES|LIGH|PROX|HUMI|TEMP|AHRS|GNSS|WIFI|BLUE|BLE4|SOUN|RFID|IMU[XLI]|POSI|CELL|GSM);-?[0-9.]+;")
TAGS = {"specific_force": "ACCE", "angular_rate": "GYRO", "magnetic_flux_density": "MAGN", "pressure": "PRES"}
DEVICE = re.compile(r"% *(?:Manufacturer|Model):\s*(\S.*)")
TOGETHER_S = 0.05
"""Sensors whose clocks differ by less from one another share one: what is left is how long the app took to be told."""
STEADY_S = 1.0
"""A sensor's clock that strays farther from the app's does not count seconds."""


def sniff(head: Head) -> bool:
    return LINE.match(head.header("%")[1]) is not None


def read(head: Head) -> Raw:
    wanted = dict.fromkeys(("ACCE", "GYRO", "MAGN"), (1, 2, 3, 4, 5)) | {"PRES": (1, 2, 3), "POSI": (1, 3, 4), "GNSS": (1, 3, 4, 5, 7)}
    found = read_tagged(head.text().splitlines(), ";", 0, wanted, "%")
    raw = Raw(source=str(head.path), streams={}, stated={**STATED, "time": "s"}, unit_source="as GetSensorData writes them", phone=True)
    raw.warnings += found.warnings()
    if device := " ".join(m[1].strip() for line in head.lines if (m := DEVICE.match(line))):
        raw.notes.append(f"Device: {device}")
    rows = {quantity: found.rows[tag] for quantity, tag in TAGS.items() if tag in found.rows}
    for (quantity, values), stamps in zip(rows.items(), _stamps(list(rows.values()), raw), strict=True):
        raw.streams[quantity] = Stream(stamps=stamps, values=values[:, 2:].copy())
    if others := [f"{found.seen[tag]} lines {tag}" for tag in ("IMUX", "IMUL", "IMUI") if tag in found.seen]:
        raw.notes.append(f"Left out: {', '.join(others)} of other inertial sensors; the phone's own were read")
    if "POSI" in found.rows:
        raw.reference = fixes(*found.rows["POSI"].T, what="surveyed points (POSI), plan only")
    elif "GNSS" in found.rows:
        raw.reference = fixes(*found.rows["GNSS"].T)
    return raw


def _stamps(tables: list[Array], raw: Raw) -> list[Array]:
    """Stamps (N,) of each table on the app's clock."""
    apart = [t[:, 0] - t[:, 1] for t in tables]
    shifts = [float(np.median(d)) for d in apart]
    steady = [float(np.median(np.abs(d - s))) < STEADY_S and np.ptp(t[:, 1]) > 0 for d, s, t in zip(apart, shifts, tables, strict=True)]
    if not all(steady):
        raw.notes.append("Clock: the app's stamps, as the sensors' own do not run along with them")
        return [t[:, 0].copy() for t in tables]
    common = float(np.median(shifts)) if shifts else 0.0
    one = all(abs(s - common) < TOGETHER_S for s in shifts)
    how = "one clock" if one else "each with a beginning of its own"
    raw.notes.append(f"Clock: the sensors' own stamps, {how}, moved to the app's by the median difference")
    return [t[:, 1] + (common if one else s) for t, s in zip(tables, shifts, strict=True)]
