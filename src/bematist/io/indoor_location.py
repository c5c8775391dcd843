"""Indoor Location 2.0 (Android): `unix_ms <tab> TYPE_… <tab> values`, `#` comments, surveyed waypoints.

Android axes (x right, y up the screen, z out of it), m/s², rad/s, µT. The calibrated sensors are read; where there is only an
uncalibrated one, its bias columns are taken off, which is what Android's calibration does.
"""

from __future__ import annotations

import re

import numpy as np

from bematist.io.android import STATED, choose
from bematist.io.head import Head
from bematist.io.raw import Raw, Stream
from bematist.io.tagged import read_tagged
from bematist.recording import Reference

LINE = re.compile(r"\d{9,16}\tTYPE_[A-Z]")
TAGS = {
    "specific_force": "TYPE_ACCELEROMETER",
    "angular_rate": "TYPE_GYROSCOPE",
    "magnetic_flux_density": "TYPE_MAGNETIC_FIELD",
}
PRESSURE, WAYPOINT = "TYPE_PRESSURE", "TYPE_WAYPOINT"
VECTOR, BIASED = (0, 2, 3, 4), (0, 2, 3, 4, 5, 6, 7)
DEVICE = re.compile(r"(Brand|Model):([^\t\n]+)")
RUN_TOGETHER = re.compile(r"(?<=\d)(\d{13}\tTYPE_)")
"""A line that begins before the one before it was ended."""
FLOOR = re.compile(r"FloorName:([^\t\n]+)")


def sniff(head: Head) -> bool:
    return LINE.match(head.header()[1]) is not None


def read(head: Head) -> Raw:
    wanted = {PRESSURE: (0, 2), WAYPOINT: (0, 2, 3)}
    for tag in TAGS.values():
        wanted |= {tag: VECTOR, f"{tag}_UNCALIBRATED": BIASED}
    lines = head.text().splitlines()
    together = [i for i, line in enumerate(lines) if line.count("\tTYPE_") > 1]
    for i in reversed(together):
        lines[i : i + 1] = RUN_TOGETHER.sub(r"\n\1", lines[i]).split("\n")
    found = read_tagged(lines, "\t", 1, wanted, "#")
    raw = Raw(source=str(head.path), streams={}, stated={**STATED, "time": "ms"}, unit_source="as Android gives them", phone=True)
    raw.warnings += found.warnings()
    if together:
        raw.notes.append(f"Lines: {len(together)} in which several had run together were parted")
    for quantity, tag in TAGS.items():
        choose(raw, quantity, found.rows.get(tag), found.rows.get(f"{tag}_UNCALIBRATED"))
    if (p := found.rows.get(PRESSURE)) is not None:
        raw.streams["pressure"] = Stream(stamps=p[:, 0], values=p[:, 1:])
    comments = "\n".join(line for line in head.lines if line.startswith("#"))
    if device := " ".join(m[2].strip() for m in DEVICE.finditer(comments)):
        raw.notes.append(f"Device: {device}")
    if (w := found.rows.get(WAYPOINT)) is not None:
        floor = m[1].strip() if (m := FLOOR.search(comments)) else "floor"
        note = f"waypoints marked by the surveyor, metres on the map of {floor}, whose axes' direction to north is unknown"
        w = w[np.argsort(w[:, 0], kind="stable")]
        raw.reference = Reference(time=w[:, 0], position=np.column_stack([w[:, 1:], np.full(len(w), np.nan)]), note=note)
    return raw
