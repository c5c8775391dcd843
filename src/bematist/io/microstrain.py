"""MicroStrain SensorConnect CSV: `Time,inertial-6253.76535:scaledAccelX,…`; g, rad/s, gauss.

Columns go by name, whatever the node is called. The device's own roll, pitch and yaw are not read.
"""

from __future__ import annotations

import re

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import Raw
from bematist.io.streams import read_streams
from bematist.io.table import split_header

CHANNEL = re.compile(r"(?:(.*):)?(scaledAccel|scaledGyro|scaledMag|scaledAmbientPressure)([XYZ]?)$")
QUANTITY = {
    "scaledAccel": "specific_force",
    "scaledGyro": "angular_rate",
    "scaledMag": "magnetic_flux_density",
    "scaledAmbientPressure": "pressure",
}


def _header_line(head: Head) -> int:
    return next((i for i, line in enumerate(head.lines) if "scaledAccel" in line or "scaledGyro" in line), -1)


def sniff(head: Head) -> bool:
    return _header_line(head) >= 0


def read(head: Head) -> Raw:
    line = _header_line(head)
    names, separator = split_header(head.lines[line])
    clock = next((n for n in names if n.strip().lower() in ("time", "timestamp")), None)
    if clock is None:
        raise DataError(f'{head.path}: the header has no column "Time". Export it from SensorConnect with its time.')
    found: dict[tuple[str, str], dict[str, str]] = {}
    for name in names:
        if m := CHANNEL.match(name):
            found.setdefault((m[1] or "", m[2]), {})[m[3].lower()] = name
    if not found:
        raise DataError(f"{head.path}: no column has a name such as inertial-6253.76535:scaledAccelX. Export it from SensorConnect again.")
    nodes = list(dict.fromkeys(node for node, _ in found))
    node = max(nodes, key=lambda n: sum(len(v) for k, v in found.items() if k[0] == n))
    picked = {QUANTITY[ch]: axes for (n, ch), axes in found.items() if n == node}
    streams = read_streams(head, line, names, separator, clock, picked, dated=True)
    raw = Raw(
        source=str(head.path),
        streams=streams,
        stated={
            "time": "ns" if np.nanmax(next(iter(streams.values())).stamps) > 1e17 else "s",
            "specific_force": "g",
            "angular_rate": "rad/s",
            "magnetic_flux_density": "G",
            "pressure": "mbar",
        },
        unit_source="as SensorConnect writes them",
    )
    if len(nodes) > 1:
        raw.warnings.append(f"The file holds {len(nodes)} sensors ({', '.join(nodes)}); {node} was read.")
    if footfalls := _footfalls(head):
        raw.reference = footfalls
    return raw


def _footfalls(head: Head):
    """The surveyed footfalls that lie beside the recordings of the GSU data set."""
    from bematist.io.reference import read_gsu

    beside = head.path.with_suffix(".mat")
    return read_gsu(beside) if beside.is_file() else None
