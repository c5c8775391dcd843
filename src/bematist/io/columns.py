"""Anyone's own CSV, described by a map.toml: names, units, axes, separators, clocks, or the rate where there is no time column."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bematist.errors import DataError, UsageError
from bematist.frames import axes_matrix
from bematist.io.head import Head, open_head
from bematist.io.raw import UNITS, Raw, Stream
from bematist.io.table import read_columns, split_header

Name = str | int


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Time(_Model):
    column: Name
    unit: str | None = None


class Sensor(_Model):
    columns: list[Name] = Field(min_length=1, max_length=3)
    unit: str | None = None
    axes: str | None = None
    time_column: Name | None = None
    time_unit: str | None = None
    file: str | None = None


class ColumnMap(_Model):
    """The content of a map.toml."""

    separator: str | None = Field(None, min_length=1)
    decimal: str | None = Field(None, pattern=r"^[.,]$")
    comment: str = Field("#", min_length=1)
    skip_lines: int = Field(0, ge=0)
    header: bool = True
    rate_hz: float | None = Field(None, gt=0)
    counter: Name | None = None
    time: Time | None = None
    specific_force: Sensor
    angular_rate: Sensor
    magnetic_flux_density: Sensor | None = None
    pressure: Sensor | None = None


def load_map(path: Path) -> ColumnMap:
    """Read and check a map.toml. Raises UsageError, naming the entry that is wrong."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"{path}: the column map cannot be opened ({error.strerror or error}).") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: the column map is no valid TOML ({error}).") from None
    try:
        found = ColumnMap(**content)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(p) for p in first["loc"])
        raise UsageError(f"{path}: {where}: {first['msg']}. docs/formats.md shows a map by example.") from None
    for quantity in UNITS:
        unit = getattr(getattr(found, quantity), "unit", None)
        if unit is not None and unit not in (*UNITS[quantity], "a.u."):
            raise UsageError(f'{path}: "{unit}" is no unit of {quantity}. Choose one of {", ".join(UNITS[quantity])}.')
    wide = [q for q in ("specific_force", "angular_rate", "magnetic_flux_density") if (s := getattr(found, q)) and len(s.columns) != 3]
    if wide:
        raise UsageError(f"{path}: {wide[0]}.columns: name three columns, in the order x, y, z.")
    if found.time is None and found.rate_hz is None:
        raise UsageError(f"{path}: name the time column ([time] column = …) or give rate_hz.")
    return found


def read_mapped(head: Head, map_path: Path) -> Raw:
    """Read `head`'s file by the map at `map_path`."""
    m = load_map(map_path)
    raw = Raw(source=str(head.path), streams={}, unit_source=f"stated in {map_path.name}")
    if m.time and m.time.unit:
        raw.stated["time"] = m.time.unit
    elif m.time is None:
        raw.stated["time"] = "s"
        raw.notes.append(f"Time: none in the file; the rate of {m.rate_hz:g} Hz is from {map_path.name}")
    tables: dict[str, dict[str, Any]] = {}
    for quantity in ("specific_force", "angular_rate", "magnetic_flux_density", "pressure"):
        sensor: Sensor | None = getattr(m, quantity)
        if sensor is None:
            continue
        key = sensor.file or ""
        if key not in tables:
            tables[key] = _table(head if not sensor.file else open_head(_beside(head, sensor.file)), m, key)
        raw.streams[quantity] = _stream(m, sensor, tables[key], raw)
        if sensor.unit:
            raw.stated[quantity] = sensor.unit
    return raw


def _beside(head: Head, name: str) -> Path:
    return (head.path if head.is_folder else head.path.parent) / name


def _table(head: Head, m: ColumnMap, key: str) -> dict[str, Any]:
    """All columns that the map asks of one file, by their name in the map."""
    if not head.lines:
        raise DataError(f"{head.path}: a column map describes a text file, and this is none.")
    line, text = _header(head, m)
    names, separator = split_header(text, m.separator)
    if not m.header:
        names = [str(i + 1) for i in range(len(names))]
    asked: list[Name] = [m.time.column] if m.time else []
    asked += [m.counter] if m.counter is not None else []
    for quantity in ("specific_force", "angular_rate", "magnetic_flux_density", "pressure"):
        sensor: Sensor | None = getattr(m, quantity)
        if sensor is not None and (sensor.file or "") == key:
            asked += [*sensor.columns, *([sensor.time_column] if sensor.time_column is not None else [])]
    wanted: dict[Name, str] = {}
    for name in dict.fromkeys(asked):
        real = names[name - 1] if isinstance(name, int) and 0 < name <= len(names) else str(name)
        if real in names:
            wanted[name] = real
        elif not (key and name in (m.counter, m.time.column if m.time else None)):
            raise DataError(f'{head.path}: there is no column "{name}". Columns: {", ".join(names[:40])}.')
    columns = read_columns(
        head,
        line if m.header else line - 1,
        names,
        list(dict.fromkeys(wanted.values())),
        separator=separator,
        comment=m.comment,
        comma=None if m.decimal is None else m.decimal == ",",
        clock=wanted.get(m.time.column) if m.time else None,
    )
    return {"path": head.path, **{f"={name}": columns[real] for name, real in wanted.items()}}


def _header(head: Head, m: ColumnMap) -> tuple[int, str]:
    for i, line in enumerate(head.lines):
        if i >= m.skip_lines and line.strip() and not line.lstrip().startswith(m.comment):
            return i, line
    raise DataError(f"{head.path}: no line is left after skip_lines = {m.skip_lines} and comments.")


def _stream(m: ColumnMap, sensor: Sensor, table: dict[str, Any], raw: Raw) -> Stream:
    values = np.stack([table[f"={name}"] for name in sensor.columns], 1)
    if sensor.axes:
        values = values @ axes_matrix(sensor.axes).T
    count = table.get(f"={m.counter}")
    number = count.astype(np.int64) if count is not None and np.isfinite(count).all() else None
    if sensor.time_column is not None:
        stamps = table[f"={sensor.time_column}"]
        unit = sensor.time_unit or (m.time.unit if m.time else None)
        base = raw.stated.setdefault("time", unit or "s")
        if unit and unit not in UNITS["time"]:
            raise UsageError(f'time_unit: "{unit}" is no unit of time. Choose one of {", ".join(UNITS["time"])}.')
        if unit and unit != base:
            stamps = stamps * (UNITS["time"][unit] / UNITS["time"][base])
        return Stream(stamps=stamps, values=values)
    if m.time is None:
        assert m.rate_hz is not None
        return Stream(stamps=table.setdefault("rate", np.arange(len(values)) / m.rate_hz), values=values)
    if f"={m.time.column}" not in table:
        raise DataError(f'{table["path"]}: there is no column "{m.time.column}". Give time_column for the sensors of this file.')
    return Stream(stamps=table[f"={m.time.column}"], values=values, count=number)
