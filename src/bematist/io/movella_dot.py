"""Xsens DOT / Movella DOT CSV: `sep=,`, lines of keys, a blank line, `PacketCounter,SampleTimeFine,…`.

SampleTimeFine counts µs, the rate of turn is in °/s (an MTi's in rad/s), the field is relative. The modes that write increments
(`dq_*`, `dv[*]`) are read as their mean over the sample: the rotation vector of dq, and dv, each over the sampling period.
"""

from __future__ import annotations

import numpy as np

from bematist.frames import rotation_vector_from_quaternion
from bematist.io.head import Head
from bematist.io.raw import Raw, Stream
from bematist.io.streams import read_streams
from bematist.io.table import read_columns, split_header
from bematist.io.xsens import FINE, STATED, axes_of, check, unwrapped

INCREMENTS = ("dq_W", "dq_X", "dq_Y", "dq_Z", "dv[1]", "dv[2]", "dv[3]")


def _header(head: Head) -> int:
    return next((i for i, s in enumerate(head.lines[:60]) if s.startswith(("PacketCounter,", "PacketCounter;"))), -1)


def sniff(head: Head) -> bool:
    line = _header(head)
    return line >= 0 and FINE in split_header(head.lines[line])[0]


def read(head: Head) -> Raw:
    line = _header(head)
    names, separator = split_header(head.lines[line])
    stated = {**STATED, "time": "us", "angular_rate": "deg/s"}
    raw = Raw(source=str(head.path), streams={}, stated=stated, unit_source="as Movella DOT writes them")
    found = axes_of(names)
    if all(n in names for n in INCREMENTS) and not {"specific_force", "angular_rate"} <= set(found):
        axes = [name for _, name in sorted(found.get("magnetic_flux_density", {}).items())]
        columns = read_columns(head, line, names, [FINE, *INCREMENTS, *axes], separator=separator)
        stamps = columns[FINE]
        table = np.column_stack([columns[n] for n in (*INCREMENTS, *axes)])
        period_s = 1e-6 * float(np.nanmedian(np.diff(unwrapped(stamps, 2.0**32)))) if len(stamps) > 1 else np.nan
        raw.streams["specific_force"] = Stream(stamps=stamps, values=table[:, 4:7] / period_s)
        raw.streams["angular_rate"] = Stream(stamps=stamps, values=rotation_vector_from_quaternion(table[:, :4]) / period_s)
        if axes:
            raw.streams["magnetic_flux_density"] = Stream(stamps=stamps, values=table[:, 7:10].copy())
        raw.stated["angular_rate"] = "rad/s"
        raw.notes.append(f"Increments: dv and dq over {1e3 * period_s:.4g} ms are read as their mean rates")
    else:
        check(head, found)
        raw.streams = read_streams(head, line, names, separator, FINE, found)
    if tag := next((s.split(separator, 1)[1] for s in head.lines[:line] if s.startswith("DeviceTag") and separator in s), "").strip():
        raw.notes.append(f"Device: DOT {tag}")
    return raw
