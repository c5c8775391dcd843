"""Xsens: text of MT Manager (`//` lines, tabs, m/s² and rad/s), and columns that Movella DOT has in common with it.

SampleTimeFine of an MTi counts 100 µs and begins anew at 2³². Without it the sample counter (16 bits) and the rate in the `//` lines
are the clock. The magnetometer has no absolute scale: 1 is the field at its calibration.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import Array, Raw
from bematist.io.streams import Found, read_streams
from bematist.io.table import split_header

QUANTITY = {"Acc": "specific_force", "Gyr": "angular_rate", "Mag": "magnetic_flux_density"}
COUNTERS = ("PacketCounter", "Counter")
FINE = "SampleTimeFine"
RATE = re.compile(r"//\s*(?:Update Rate|Sample rate):\s*([\d.]+) *Hz", re.IGNORECASE)
TICK_S = 1e-4
STATED = {"time": "s", "specific_force": "m/s^2", "angular_rate": "rad/s", "magnetic_flux_density": "a.u."}


def sniff(head: Head) -> bool:
    names, separator = split_header(head.header("//")[1])
    return separator == "\t" and any(c in names for c in COUNTERS) and bool(axes_of(names) or "FreeAcc_X" in names)


def axes_of(names: Sequence[str]) -> Found:
    """The sensors in a header: `Acc_X` …"""
    found: Found = {}
    for name in names:
        if (m := re.fullmatch(r"(Acc|Gyr|Mag)_([XYZ])", name)) is not None:
            found.setdefault(QUANTITY[m[1]], {})[m[2].lower()] = name
    return found


def check(head: Head, found: Found) -> None:
    """Raise DataError where the file holds what the sensor made of its samples, and not the samples."""
    if missing := [f"{word}_X" for word in ("Acc", "Gyr") if QUANTITY[word] not in found]:
        raise DataError(
            f"{head.path}: the columns {', '.join(missing)} … are not in the file: orientation and free acceleration alone are no "
            "recording of the sensors. Export or record the inertial data (acceleration and rate of turn) as well."
        )


def read(head: Head) -> Raw:
    line, text = head.header("//")
    names, separator = split_header(text)
    found = axes_of(names)
    check(head, found)
    raw = Raw(source=str(head.path), streams={}, stated=dict(STATED), unit_source="as MT Manager writes them")
    clock = FINE if FINE in names else next(c for c in COUNTERS if c in names)
    raw.streams = read_streams(head, line, names, separator, clock, found, comment="//")
    if clock == FINE and not np.isfinite(raw.streams["specific_force"].stamps).any():
        clock = next(c for c in COUNTERS if c in names)
        raw.streams = read_streams(head, line, names, separator, clock, found, comment="//")
    ticks = raw.streams["specific_force"].stamps
    if clock == FINE:
        time = unwrapped(ticks, 2.0**32) * TICK_S
    else:
        hz = next((float(m[1]) for s in head.lines[:line] if (m := RATE.match(s))), 0.0)
        if not hz > 0:
            raise DataError(
                f"{head.path}: neither SampleTimeFine nor an update rate is in the file. Export it with SampleTimeFine, or describe it "
                "with --columns map.toml and rate_hz."
            )
        time = unwrapped(ticks, 2.0**16) / hz
        raw.notes.append(f"Time: the sample counter at the {hz:g} Hz of the header")
    for stream in raw.streams.values():
        stream.stamps = time
    return raw


def unwrapped(ticks: Array, period: float) -> Array:
    """A counter (N,) that begins anew at `period`, going on; NaN where it is NaN."""
    out = ticks.copy()
    known = np.isfinite(ticks)
    step = np.diff(ticks[known])
    out[known] += period * np.concatenate([[0], np.cumsum(step < -0.5 * period)])
    return out
