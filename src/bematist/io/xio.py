"""x-io Technologies: NGIMU and x-IMU3 CSV and folders. The units stand in the header: `Gyroscope X (deg/s)`."""

from __future__ import annotations

import re
from pathlib import Path

from bematist.errors import DataError
from bematist.io.head import Head, open_head
from bematist.io.raw import Raw
from bematist.io.streams import Found, read_streams
from bematist.io.table import split_header

COLUMN = re.compile(r"(?:(Gyroscope|Accelerometer|Magnetometer) )?([XYZ])(?: Axis)? \(([^)]*)\)$")
CLOCK = re.compile(r"(?:Time|Timestamp) \((s|ms|us|µs|ns)\)$")
BAROMETER = re.compile(r"(?:Barometer|Pressure)(?: Pressure)? \((hPa|Pa|mbar|kPa)\)$")
QUANTITY = {"Gyroscope": "angular_rate", "Accelerometer": "specific_force", "Magnetometer": "magnetic_flux_density"}
UNIT = {
    "g": "g",
    "m/s^2": "m/s^2",
    "m/s²": "m/s^2",
    "deg/s": "deg/s",
    "°/s": "deg/s",
    "rad/s": "rad/s",
    "uT": "uT",
    "µT": "uT",
    "mG": "mG",
    "G": "G",
    "a.u.": "a.u.",
}


def sniff(head: Head) -> bool:
    if head.is_folder:
        return any((head.path / name).is_file() for name in ("Inertial.csv", "sensors.csv"))
    names = split_header(head.header()[1])[0]
    return any(CLOCK.match(n) for n in names) and any((m := COLUMN.match(n)) is not None and m[1] is not None for n in names)


def read(head: Head) -> Raw:
    if not head.is_folder:
        return _file(head, None)
    folder = head.path
    if (folder / "sensors.csv").is_file():
        raw = _file(open_head(folder / "sensors.csv"), None)
    else:
        raw = _file(open_head(folder / "Inertial.csv"), None)
        if (folder / "Magnetometer.csv").is_file():
            more = _file(open_head(folder / "Magnetometer.csv"), "Magnetometer")
            # Files of one x-IMU3 folder share one time base.
            factor = {"us": 1e-6, "s": 1.0, "ms": 1e-3, "ns": 1e-9}
            stream = more.streams["magnetic_flux_density"]
            stream.stamps = stream.stamps * (factor[more.stated["time"]] / factor[raw.stated["time"]])
            raw.streams |= more.streams
            raw.stated |= {q: u for q, u in more.stated.items() if q != "time"}
    raw.source = str(folder)
    return raw


def _file(head: Head, sensor: str | None) -> Raw:
    """One CSV. `sensor` names the sensor of columns that do not (`X (a.u.)` in Magnetometer.csv)."""
    line, text = head.header()
    names, separator = split_header(text)
    clock = next((n for n in names if CLOCK.match(n)), None)
    if clock is None:
        raise DataError(f'{head.path}: the header has no column "Time (s)" or "Timestamp (us)". Export the file again.')
    found: Found = {}
    stated = {"time": (CLOCK.match(clock) or [""])[1].replace("µ", "u")}
    for name in names:
        if (m := COLUMN.match(name)) and (m[1] or sensor):
            quantity = QUANTITY[m[1] or sensor or ""]
            found.setdefault(quantity, {})[m[2].lower()] = name
            _state(head.path, stated, quantity, m[3])
        elif m := BAROMETER.match(name):
            found["pressure"] = {"": name}
            stated["pressure"] = m[1]
    if sensor and QUANTITY[sensor] not in found:
        raise DataError(f"{head.path}: the header names no X, Y, Z of the {sensor.lower()}. Export the file again.")
    streams = read_streams(head, line, names, separator, clock, found)
    return Raw(source=str(head.path), streams=streams, stated=stated, unit_source="stated in the header")


def _state(path: Path, stated: dict[str, str], quantity: str, text: str) -> None:
    if text not in UNIT:
        raise DataError(f'{path}: the unit "{text}" of {quantity} is not known. Known: {", ".join(UNIT)}.')
    stated[quantity] = UNIT[text]
