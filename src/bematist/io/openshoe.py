"""OpenShoe inertial text: a table with 0x tokens, g, rad/s and gauss, nan rows of the magnetometer, several clocks.

The host's unfiltered stamps are read (they come in pairs, milliseconds late); the sensor samples evenly, as its own counter
shows, so the clock behind them is fitted.
"""

from __future__ import annotations

import re

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import Raw, Stream

COLUMN = re.compile(r"([A-Za-z_.][A-Za-z_. ]*?)(?: ?\[([^\]]*)\])?:")
UNITS = {"g": "g", "rad/s": "rad/s", "G": "G", "m/s^2": "m/s^2", "deg/s": "deg/s", "uT": "uT"}
AXES = {
    "specific_force": ("a_x", "a_y", "a_z"),
    "angular_rate": ("ar_x", "ar_y", "ar_z"),
    "magnetic_flux_density": ("m_x", "m_y", "m_z"),
}


def _header(head: Head) -> int:
    return next((i for i, s in enumerate(head.lines[:20]) if s.startswith("Header:") and "a_x" in s), -1)


def sniff(head: Head) -> bool:
    return _header(head) >= 0


def read(head: Head) -> Raw:
    line = _header(head)
    # The word "Header:" stands over the first token of each row.
    columns = [(m[1].strip(), (m[2] or "").strip()) for m in COLUMN.finditer(head.lines[line])]
    names = [name for name, _ in columns]
    clock = next((n for n in ("Unfiltered ts", "Filtered ts", "Pred. ts") if n in names), None)
    if clock is None:
        raise DataError(f"{head.path}: no column of stamps (ts) in the header. Export the recording again.")
    tick = ["Counter"] if "Counter" in names else []
    wanted = [clock, *tick, *(n for axes in AXES.values() for n in axes if n in names)]
    values = _rows(head, line, names, wanted)
    stamps = values[:, 0]
    streams = {}
    for quantity, axes in AXES.items():
        if all(a in names for a in axes):
            picked = values[:, [wanted.index(a) for a in axes]]
            streams[quantity] = Stream(stamps=stamps, values=picked, count=_count(values[:, 1]) if tick else None)
    unit = dict(columns)
    stated = {q: UNITS[u] for q, axes in AXES.items() if (u := unit.get(axes[0], "")) in UNITS}
    raw = Raw(source=str(head.path), streams=streams, stated={"time": "s", **stated}, unit_source="stated in the header")
    lost = int(np.isnan(values[:, -1]).sum()) if "magnetic_flux_density" in streams else 0
    if lost:
        raw.notes.append(f"Rows: {lost} of {len(values)} without a magnetometer sample (nan)")
    return raw


def _count(ticks: np.ndarray) -> np.ndarray:
    """Sample numbers (N,) from the sensor's tick counter, which advances evenly and begins anew about once a second."""
    step = np.diff(ticks)
    usual = float(np.median(step))
    taken = np.where(step > 0, np.maximum(np.round(step / usual), 1), 1) if usual > 0 else np.ones(len(step))
    return np.concatenate([[0], np.cumsum(taken)]).astype(np.int64)


def _rows(head: Head, line: int, names: list[str], wanted: list[str]) -> np.ndarray:
    lines = head.text().splitlines()
    index = [names.index(n) for n in wanted]
    rows = []
    for number, text in enumerate(lines[line + 1 :], line + 2):
        cells = text.split()
        if not cells:
            continue
        if len(cells) != len(names):
            if number == len(lines):
                break  # the last line of a recording that was cut off
            raise DataError(f"{head.path}, line {number}: {len(cells)} cells where the header names {len(names)} columns.")
        try:
            rows.append([float(cells[i]) for i in index])
        except ValueError:
            raise DataError(f"{head.path}, line {number}: a number cannot be read. Correct or remove the line.") from None
    if not rows:
        raise DataError(f"{head.path}: there is a header but no row of data. Export the recording again.")
    return np.array(rows)
