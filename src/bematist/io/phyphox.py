"""phyphox: a zip or a folder with a CSV for each export set, or one such CSV; `"Time (s)","Acceleration x (m/s^2)",…`.

The app writes in the phone's language, so that columns go by the unit in their name and their order: the first in s is the time, the
first three in m/s² or rad/s or µT are x, y, z. Acceleration comes with gravity or without (and gravity alone): the values tell. Times
count from the start and stand still in a pause; meta/time.csv tells when and how long.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bematist.errors import DataError
from bematist.io.bundle import Bundle, bundle
from bematist.io.gnss import fixes
from bematist.io.guess import norms, rest_norm
from bematist.io.head import Head
from bematist.io.raw import Array, Raw, Stream
from bematist.io.table import read_columns, split_header

COLUMN = re.compile(r"(.*\S) \(([^()]*)\)$")
AXIS = re.compile(r"(?:^|\W)([xyz])$")
SENSOR = {"m/s^2": "specific_force", "m/s²": "specific_force", "rad/s": "angular_rate", "µT": "magnetic_flux_density"}
STATED = {"time": "s", "specific_force": "m/s^2", "angular_rate": "rad/s", "magnetic_flux_density": "uT", "pressure": "hPa"}
WITH_GRAVITY = 5.0
"""m/s²: an acceleration whose norm at rest lies below has no gravity in it."""


@dataclass(frozen=True)
class Table:
    """One CSV: its head, and its columns as (place, name without unit, unit)."""

    head: Head
    names: list[str]
    separator: str
    columns: list[tuple[str, str, str]]

    def of(self, unit: str) -> list[str]:
        return [name for name, _, u in self.columns if u == unit]

    def triples(self, unit: str) -> list[list[str]]:
        """Columns x, y, z: those with such a name, three by three, else the first three."""
        lettered = [name for name, words, u in self.columns if u == unit and AXIS.search(words.lower())]
        all_of = self.of(unit)
        if len(lettered) >= 3:
            return [lettered[i : i + 3] for i in range(0, len(lettered) - 2, 3)]
        return [all_of[:3]] if len(all_of) >= 3 else []

    def read(self, wanted: list[str]) -> Array:
        """Columns (N,C), the time first."""
        every = [self.of("s")[0], *wanted]
        found = read_columns(self.head, self.head.header()[0], self.names, every, separator=self.separator)
        return np.column_stack([found[n] for n in every])


def _table(head: Head) -> Table | None:
    """A CSV of phyphox, or None where it is none: the time in s comes first, and a sensor follows."""
    names, separator = split_header(head.header()[1])
    columns = [(n, m[1], m[2]) for n in names if (m := COLUMN.match(n.replace("\N{GREEK SMALL LETTER MU}", "µ")))]
    units = [u for _, _, u in columns]
    axes = any(AXIS.search(words) for _, words, _ in columns)
    if len(columns) < 2 or units[0] != "s" or columns[0][0] != names[0] or not ({*SENSOR, "hPa", "°"} & set(units)):
        return None
    # Others write a capital X.
    return None if not axes and any(AXIS.search(words.lower()) for _, words, _ in columns) else Table(head, names, separator, columns)


def _tables(files: Bundle) -> Iterator[Table]:
    for name in files:
        # Its first lines tell whether it is worth reading.
        if name.lower().endswith(".csv") and not name.startswith("meta/") and COLUMN.match("".join(files.header(name)[:1])):
            table = _table(files.open(name))
            if table is not None:
                yield table


def sniff(head: Head) -> bool:
    files = bundle(head)
    if files is not None:
        return next(_tables(files), None) is not None
    table = _table(head)
    return table is not None and any(unit in SENSOR for _, _, unit in table.columns)


def read(head: Head) -> Raw:
    files = bundle(head)
    one = _table(head) if files is None else None
    tables = [one] if one is not None else list(_tables(files)) if files is not None else []
    raw = Raw(source=str(head.path), streams={}, stated=dict(STATED), unit_source="stated in the header", phone=True)
    accelerations: list[tuple[str, Array]] = []
    for table in tables:
        for unit, quantity in SENSOR.items():
            for axes in table.triples(unit):
                rows = table.read(axes)
                if quantity == "specific_force":
                    accelerations.append((axes[0], rows))
                elif quantity not in raw.streams:
                    raw.streams[quantity] = _stream(rows)
        if (pressure := table.of("hPa")) and "pressure" not in raw.streams:
            raw.streams["pressure"] = _stream(table.read(pressure[:1]))
        if len(degrees := table.of("°")) >= 2:
            g = table.read([*degrees[:2], *table.of("m")[:2]])
            raw.reference = fixes(*g.T)
    _pick_force(accelerations, raw)
    if files is not None:
        _meta(files, raw)
    return raw


def _stream(rows: Array) -> Stream:
    return Stream(stamps=rows[:, 0].copy(), values=rows[:, 1:].copy())


def _pick_force(found: list[tuple[str, Array]], raw: Raw) -> None:
    """The acceleration with gravity: near g at rest, and of those the one that varies most (the other is gravity alone)."""
    heavy = [(name, rows) for name, rows in found if rest_norm(rows[:, 1:]) > WITH_GRAVITY]
    if not heavy:
        if found:
            raise DataError(
                f"{raw.source}: the acceleration in the file is without gravity (its norm at rest is {rest_norm(found[0][1][:, 1:]):.2g} "
                'm/s²). Record "Acceleration (with g)" in phyphox.'
            )
        return
    name, rows = max(heavy, key=lambda f: float(np.nanstd(norms(f[1][:, 1:]))))
    if len(found) > 1:
        raw.notes.append(f"Accelerometer: {name} … is the one with gravity and motion, of {len(found)} accelerations")
    raw.streams["specific_force"] = _stream(rows)


def _meta(files: Bundle, raw: Raw) -> None:
    """Device, start and pauses from the folder meta."""
    about = {row[0]: row[1] for row in _cells(files, "meta/device.csv") if len(row) > 1}
    if model := about.get("deviceModel"):
        raw.notes.append(f"Device: {' '.join(dict.fromkeys([about.get('deviceBrand', ''), model])).strip()}")
    try:
        events = [(row[0], float(row[1]), float(row[2])) for row in _cells(files, "meta/time.csv")[1:] if len(row) > 2]
    except ValueError:
        raw.warnings.append("meta/time.csv cannot be read: pauses of the recording are not known.")
        return
    if not events:
        return
    raw.start_ns = round((events[0][2] - events[0][1]) * 1e9)
    clocks = {id(s.stamps): s.stamps for s in raw.streams.values()}
    if raw.reference is not None:
        clocks[0] = raw.reference.time
    original = {key: stamps.copy() for key, stamps in clocks.items()}
    pauses = [(b[1], b[2] - a[2]) for a, b in itertools.pairwise(events) if (a[0], b[0]) == ("PAUSE", "START")]
    for at, length in pauses:
        for key, stamps in clocks.items():
            stamps[original[key] > at] += length
    if pauses:
        raw.notes.append(f"Pauses: {len(pauses)}, {sum(p for _, p in pauses):.4g} s in all, put in as meta/time.csv tells")


def _cells(files: Bundle, name: str) -> list[list[str]]:
    """Rows of a small table; numbers with a decimal point."""
    if name not in files:
        return []
    lines = [line for line in files.open(name).lines if line.strip()]
    separator = split_header(lines[0])[1] if lines else ","
    rows = [split_header(line, separator)[0] for line in lines]
    return rows if separator == "," else [[cell.replace(",", ".") for cell in row] for row in rows]
