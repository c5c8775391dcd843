"""MetaMotion (MbientLab MetaBase): a CSV for each sensor, `<name>_<time>_<MAC>_Accelerometer….csv`, each with a clock of its own.

`epoch (ms),time (-07:00),elapsed (s),x-axis (g),…`; older tools write `epoc (ms),timestamp (-0700)`. The path is the folder, or one of
the files, whose fellows are found by their name.
"""

from __future__ import annotations

import re

from bematist.errors import DataError
from bematist.io.bundle import beside, bundle
from bematist.io.head import Head
from bematist.io.raw import WORDS, Raw
from bematist.io.streams import read_streams
from bematist.io.table import split_header

NAME = re.compile(r"(.*?)_?(Accelerometer|Gyroscope|Magnetometer|Pressure)(_[^/]*)?\.csv", re.IGNORECASE)
AXIS = re.compile(r"([xyz])-axis \(([^)]*)\)")
CLOCK = re.compile(r"epoch? \(ms\)")
SENSOR = {
    "g": "specific_force",
    "deg/s": "angular_rate",
    "rad/s": "angular_rate",
    "T": "magnetic_flux_density",
    "uT": "magnetic_flux_density",
}


def _is_table(names: list[str]) -> bool:
    return bool(names) and CLOCK.fullmatch(names[0]) is not None and any(AXIS.fullmatch(n) for n in names)


def sniff(head: Head) -> bool:
    files = bundle(head)
    if files is None:
        return _is_table(split_header(head.header()[1])[0])
    return any(NAME.fullmatch(name) and _is_table(files.header(name)) for name in files)


def read(head: Head) -> Raw:
    files = bundle(head) or beside(head)
    own = None if head.is_folder or head.is_zip else NAME.fullmatch(head.path.name)
    groups: dict[str, list[str]] = {}
    for name in files:
        if (m := NAME.fullmatch(name)) and (own is None or m[1] == own[1]) and _is_table(files.header(name)):
            groups.setdefault(m[1], []).append(name)
    if len(groups) > 1:
        raise DataError(
            f"{head.path}: {len(groups)} recordings are in the folder ({', '.join(sorted(groups)[:5])}). Name one file of the one to read."
        )
    tables = [files.open(n) for n in next(iter(groups.values()), [])] or [head]
    raw = Raw(source=str(head.path), streams={}, stated={"time": "ms"}, unit_source="stated in the header")
    for table in tables:
        line, text = table.header()
        names, separator = split_header(text)
        axes = {m[1]: n for n in names if (m := AXIS.fullmatch(n))}
        unit = next(m[2] for n in names if (m := AXIS.fullmatch(n)))
        if (quantity := SENSOR.get(unit)) is None:
            raise DataError(f'{table.path}: the unit "{unit}" of the columns is not known. Known: {", ".join(SENSOR)}.')
        if quantity in raw.streams:
            raise DataError(f"{head.path}: two files hold the {WORDS[quantity]}, {table.path.name} is one. Take one of them away.")
        raw.streams |= read_streams(table, line, names, separator, names[0], {quantity: axes})
        raw.stated[quantity] = unit
    return raw
