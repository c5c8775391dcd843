"""Shimmer (Consensys) CSV: `sep=;`, a line of names such as `Shimmer_40AC_Accel_WR_X_CAL`, a line of units, the data.

Two accelerometers may be in it: the wide-range one (WR, to 16 g) is read, as the low-noise one (LN, 2 g) saturates at each footfall.
"""

from __future__ import annotations

import re

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import Raw
from bematist.io.streams import Found, read_streams
from bematist.io.table import split_header

CHANNEL = re.compile(r"(.*?)_?(Accel_WR|Accel_LN|Gyro|Mag)_([XYZ])_CAL")
SCALAR = re.compile(r"(.*?)_?(Pressure\w*|Timestamp\w*)_CAL")
QUANTITY = {"Accel_WR": "specific_force", "Accel_LN": "specific_force", "Gyro": "angular_rate", "Mag": "magnetic_flux_density"}
UNIT = {
    "m/(s^2)": "m/s^2",
    "m/(sec^2)": "m/s^2",
    "m/s^2": "m/s^2",
    "g": "g",
    "deg/s": "deg/s",
    "deg/sec": "deg/s",
    "rad/s": "rad/s",
    "local_flux": "a.u.",
    "local": "a.u.",
    "uT": "uT",
    "Pa": "Pa",
    "kPa": "kPa",
    "ms": "ms",
    "s": "s",
}
CLOCKS = ("Timestamp_Unix", "TimestampSync_Unix", "Timestamp_Shimmer", "TimestampSync_Shimmer", "Timestamp_PC")


def _names(head: Head) -> int:
    return next((i for i, s in enumerate(head.lines[:5]) if "Timestamp" in s and "_CAL" in s), -1)


def sniff(head: Head) -> bool:
    return _names(head) >= 0


def read(head: Head) -> Raw:
    line = _names(head)
    declared = re.fullmatch(r'"?sep=(.|\\t)"?', head.lines[0].strip(" \r\n")) if line else None
    names, separator = split_header(head.lines[line], None if declared is None else declared[1].replace("\\t", "\t"))
    units = dict(zip(names, split_header(head.lines[line + 1], separator)[0] if len(head.lines) > line + 1 else [], strict=False))
    devices: dict[str, dict[str, dict[str, str]]] = {}
    for name in names:
        if m := CHANNEL.fullmatch(name):
            devices.setdefault(m[1], {}).setdefault(m[2], {})[m[3].lower()] = name
        elif m := SCALAR.fullmatch(name):
            devices.setdefault(m[1], {})[m[2]] = {"": name}
    device = max(devices, key=lambda d: sum(len(axes) for axes in devices[d].values()))
    channels = devices[device]
    clock = next((c for c in CLOCKS if c in channels), None) or next((c for c in channels if c.startswith("Timestamp")), None)
    if clock is None:
        raise DataError(f"{head.path}: no column of {device} is a calibrated timestamp. Export it from Consensys with Timestamp_Unix.")
    found: Found = {}
    for channel in ("Accel_WR", "Accel_LN", "Gyro", "Mag"):
        if channel in channels:
            found.setdefault(QUANTITY[channel], channels[channel])
    if pressure := next((c for c in channels if c.startswith("Pressure")), None):
        found["pressure"] = channels[pressure]
    raw = Raw(source=str(head.path), streams={}, unit_source="stated in the line of units")
    if "Accel_WR" in channels and "Accel_LN" in channels:
        raw.notes.append("Accelerometer: the wide-range one (Accel_WR) was read, the low-noise one (Accel_LN) saturates at footfalls")
    stamp = channels[clock][""]
    dated = "Formatted" in clock
    raw.stated["time"] = "s" if dated else UNIT.get(units.get(stamp, ""), "ms")
    for quantity, axes in found.items():
        text = units.get(next(iter(axes.values())), "")
        if text.rstrip("*") in UNIT:
            raw.stated[quantity] = UNIT[text.rstrip("*")]
    raw.streams = read_streams(head, line + 1, names, separator, stamp, found, dated=dated)
    raw.notes.append(f"Device: {device}")
    if len(devices) > 1:
        raw.warnings.append(f"The file holds {len(devices)} sensors ({', '.join(devices)}); {device} was read.")
    return raw
