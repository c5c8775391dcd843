"""Sensor Logger (Kelvin Choi) for iOS and Android: a zip or a folder with a CSV for each sensor, `time,seconds_elapsed,z,y,x`.

`time` is UNIX ns. Accelerometer.csv is without gravity: the specific force is TotalAcceleration.csv (Android), or
Accelerometer.csv + Gravity.csv, or AccelerometerUncalibrated.csv. On iOS all three are the negative of the specific force, and the
last is in g, unless the app's "Standardise Units & Frames" was on, as Metadata.csv tells.
"""

from __future__ import annotations

import csv

import numpy as np

from bematist.earth import STANDARD_GRAVITY
from bematist.errors import DataError
from bematist.io.android import choose
from bematist.io.bundle import Bundle, beside, bundle
from bematist.io.gnss import fixes
from bematist.io.head import Head
from bematist.io.raw import Array, Raw, Stream
from bematist.io.table import read_columns, split_header

SENSORS = ("Gyroscope", "TotalAcceleration", "Accelerometer", "AccelerometerUncalibrated", "GyroscopeUncalibrated")
VECTOR = ("time", "x", "y", "z")
IOS_ONLY = "altitudeAboveMeanSeaLevel"
"""A column of Location.csv that only the iPhone writes."""


def sniff(head: Head) -> bool:
    files = bundle(head)
    if files is None:
        return {"time", "seconds_elapsed", "x", "y", "z"} <= set(split_header(head.header()[1])[0])
    return any("seconds_elapsed" in files.header(f"{name}.csv") for name in SENSORS)


def read(head: Head) -> Raw:
    files = bundle(head) or beside(head)
    raw = Raw(source=str(head.path), streams={}, unit_source="as Sensor Logger writes them", phone=True)
    raw.stated = {"time": "ns", "specific_force": "m/s^2", "angular_rate": "rad/s", "magnetic_flux_density": "uT", "pressure": "mbar"}
    about = _metadata(files)
    if about:
        raw.notes.append(f"Device: {about.get('device name', 'unknown')}, {about.get('platform', 'unknown platform')}")
    _force(files, about, raw)
    for quantity, name in (("angular_rate", "Gyroscope"), ("magnetic_flux_density", "Magnetometer")):
        choose(raw, quantity, _rows(files, name), _rows(files, f"{name}Uncalibrated"))
    if (p := _rows(files, "Barometer", ("time", "pressure"))) is not None:
        raw.streams["pressure"] = Stream(stamps=p[:, 0], values=p[:, 1:])
    place = ("time", "latitude", "longitude", "altitude", "horizontalAccuracy")
    if (g := _rows(files, "Location", place)) is not None:
        raw.reference = fixes(*g.T)
    return raw


def _rows(files: Bundle, name: str, columns: tuple[str, ...] = VECTOR) -> Array | None:
    """Columns (N,C) of one sensor's file; None where there is none, or nothing in it, as where the phone lacks the sensor."""
    names = files.header(f"{name}.csv")
    if "time" not in names:
        return None
    head = files.open(f"{name}.csv")
    if missing := [c for c in columns if c not in names]:
        raise DataError(f"{head.path}: there is no column {', '.join(missing)}. Export the recording from Sensor Logger again.")
    line, text = head.header()
    if not any(s.strip() for s in head.lines[line + 1 :]):
        return None
    found = read_columns(head, line, names, columns, separator=split_header(text)[1])
    return np.column_stack([found[c] for c in columns])


def _metadata(files: Bundle) -> dict[str, str]:
    """The one row of Metadata.csv by its header."""
    name = next((n for n in files if n.lower() == "metadata.csv"), None)
    lines = list(csv.reader(files.open(name).lines)) if name else []
    return dict(zip(lines[0], lines[1], strict=False)) if len(lines) > 1 else {}


def _force(files: Bundle, about: dict[str, str], raw: Raw) -> None:
    """The specific force, with gravity, positive upwards."""
    total, alone, gravity = (_rows(files, n) for n in ("TotalAcceleration", "Accelerometer", "Gravity"))
    plain = _rows(files, "AccelerometerUncalibrated")
    if total is not None:
        rows, what = total, "TotalAcceleration.csv"
    elif alone is not None and gravity is not None:
        slow = [np.interp(alone[:, 0], gravity[:, 0], gravity[:, k], left=np.nan, right=np.nan) for k in (1, 2, 3)]
        rows, what = np.column_stack([alone[:, 0], alone[:, 1:] + np.stack(slow, 1)]), "Accelerometer.csv + Gravity.csv"
    elif plain is not None:
        rows, what = plain, "AccelerometerUncalibrated.csv"
    elif alone is not None:
        raise DataError(
            f"{raw.source}: Accelerometer.csv of Sensor Logger is without gravity, and neither Gravity.csv nor TotalAcceleration.csv is "
            "there to give it back. Record the sensor Gravity too (on Android TotalAcceleration)."
        )
    else:
        return
    values = rows[:, 1:]
    ios, why = _is_ios(files, about, total is not None)
    if ios is None:
        raw.warnings.append(
            "Metadata.csv is missing, so that nothing tells whether an iPhone wrote this, whose accelerometer has the opposite sign; it "
            "was taken as Android's. If the path climbs where the wearer descended, it was an iPhone: keep Metadata.csv in the export."
        )
    if ios and about.get("standardisation", "").strip().lower() != "true":
        values = -values * (STANDARD_GRAVITY if rows is plain else 1.0)
        what += ", turned to the sign of a specific force"
    raw.notes.append(f"Accelerometer: {what} ({why})")
    raw.streams["specific_force"] = Stream(stamps=rows[:, 0].copy(), values=np.ascontiguousarray(values))


def _is_ios(files: Bundle, about: dict[str, str], total: bool) -> tuple[bool | None, str]:
    """Whether an iPhone wrote the files, and why; None where nothing tells."""
    if platform := about.get("platform", "").strip().lower():
        return platform.startswith("ios"), f"{about['platform'].strip()}, as Metadata.csv says"
    if total:
        return False, "Android, as only there is TotalAcceleration.csv"
    if IOS_ONLY in files.header("Location.csv"):
        return True, f"iOS, as only there Location.csv has {IOS_ONLY}"
    return None, "taken as Android's"
