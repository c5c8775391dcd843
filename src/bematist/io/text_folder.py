"""A folder with a text file for each sensor, no header: `seconds x y z` or, uncalibrated, `seconds x y z bias_x bias_y bias_z`.

So writes the logger of Michel et al. 2017 (Android: m/s², rad/s, µT): `accelerometer.txt`, `gyroscope.txt`, `magnetometer.txt`, the
last two also as `…-calibrated.txt`, `record.properties`. Where `qualisys.mat` lies beside them, its rigid body is the reference.
"""

from __future__ import annotations

import re

import numpy as np

from bematist.errors import DataError
from bematist.frames import quaternion_from_matrix
from bematist.io.android import STATED, choose
from bematist.io.bundle import Bundle, bundle
from bematist.io.head import Head
from bematist.io.mat import load
from bematist.io.raw import Array, Raw, Stream
from bematist.io.table import read_columns
from bematist.recording import Reference

SENSORS = {"specific_force": "accelerometer", "angular_rate": "gyroscope", "magnetic_flux_density": "magnetometer"}
PROPERTY = re.compile(r"(\w+) *= *(.+)")
MOCAP, ALIGNMENT = "qualisys.mat", "timeAlignment.txt"


def sniff(head: Head) -> bool:
    files = bundle(head)
    return files is not None and any(re.fullmatch(r"(accelerometer|gyroscope)(-(un)?calibrated)?\.txt", name) for name in files)


def read(head: Head) -> Raw:
    files = bundle(head)
    assert files is not None
    raw = Raw(source=str(head.path), streams={}, stated={**STATED, "time": "s"}, unit_source="as Android gives them", phone=True)
    for quantity, sensor in SENSORS.items():
        plain = _rows(files, f"{sensor}.txt")
        calibrated, uncalibrated = _rows(files, f"{sensor}-calibrated.txt"), _rows(files, f"{sensor}-uncalibrated.txt")
        # The file without a suffix is the uncalibrated one where it holds a bias or stands beside the calibrated one.
        if plain is not None and calibrated is None and plain.shape[1] == 4:
            calibrated = plain
        elif uncalibrated is None:
            uncalibrated = plain
        choose(raw, quantity, calibrated, uncalibrated)
    if (p := _rows(files, "barometer.txt")) is not None:
        raw.streams["pressure"] = Stream(stamps=p[:, 0], values=p[:, 1:2])
    _properties(files, raw)
    if MOCAP in files and head.is_folder:
        raw.reference = _reference(files)
    return raw


def _rows(files: Bundle, name: str) -> Array | None:
    """The table (N,C) of one file, or None without it."""
    if name not in files:
        return None
    head = files.open(name)
    first = head.header()[1].split()
    names = [str(i) for i in range(len(first))]
    if len(first) < 2:
        raise DataError(f"{head.path}: a row should hold seconds and the sensor's values; the first is {' '.join(first)[:40]!r}.")
    columns = read_columns(head, head.header()[0] - 1, names, names, separator=" ")
    return np.column_stack([columns[n] for n in names])


def _properties(files: Bundle, raw: Raw) -> None:
    """What `record.properties` tells of the device and the start."""
    if "record.properties" not in files:
        return
    lines = files.open("record.properties").lines
    found = {m[1]: m[2] for line in lines if (m := PROPERTY.fullmatch(line.strip()))}
    if "Model" in found:
        raw.notes.append(f"Device: {found.get('Manufacturer', '')} {found['Model']}".replace("  ", " "))
    raw.device = found.get("ID", "")
    if re.fullmatch(r"\d{9,11}", start := found.get("StartTime", "")):
        raw.start_ns = int(start) * 10**9


def _reference(files: Bundle) -> Reference | None:
    """The rigid body of Qualisys (mm, matrices column by column, body → room, z up) on the recording's clock.

    Frame k of the room is at k / FrameRate − offset of the recording: so the angular rates of both agree (to 10 ms), in the recordings
    whose offset is −3.71 s and 0.66 s alike.
    """
    path = files.path / MOCAP
    found = [v for v in load(path).values() if isinstance(v, dict) and "RigidBodies" in v]
    try:
        body, hz, first = found[0]["RigidBodies"], float(found[0]["FrameRate"].item()), float(found[0]["StartFrame"].item())
        position, turn = body["Positions"][0].T * 1e-3, body["Rotations"][0].T.reshape(-1, 3, 3).transpose(0, 2, 1)
        offset = float(files.open(ALIGNMENT).text()) if ALIGNMENT in files else None
    except (IndexError, KeyError, ValueError, AttributeError, TypeError):
        raise DataError(
            f"{path}: no rigid body of Qualisys is in it, or {ALIGNMENT} holds no number. Take the file away to go on."
        ) from None
    if offset is None:
        return None
    attitude = np.full((len(turn), 4), np.nan)
    whole = np.isfinite(turn).all((1, 2))
    attitude[whole] = quaternion_from_matrix(turn[whole])
    time = (first + np.arange(len(position), dtype=np.float64)) / hz - offset
    note = f"rigid body of Qualisys, {hz:g} Hz, room axes, z up; the clock is set by {ALIGNMENT}"
    return Reference(time=time, position=position, attitude=attitude, note=note, source=str(path))
