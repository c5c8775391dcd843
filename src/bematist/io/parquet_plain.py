"""Columns of numbers → Parquet in its plainest form: every value as it is, not compressed, none missing.

The table library writes Parquet too, but to import it takes longer than to write ten minutes of a path here. The format:
https://parquet.apache.org/docs; the numbers of fields and enumerations are those of its `parquet.thrift`, and a structure is written in
Thrift's compact protocol.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from bematist import __version__

MAGIC = b"PAR1"
REQUIRED, PLAIN, RLE, UNCOMPRESSED, DATA_PAGE = 0, 0, 3, 0, 0

Value = tuple[int, bytes]
"""A value of Thrift: the number of its type, and its bytes."""


@dataclass(frozen=True)
class Kind:
    """What a column holds: as a value of NumPy, as a stored type of Parquet, and what that stands for, if not for itself."""

    stored: str
    type: int
    stands_for: int | None = None


DOUBLE = Kind("<f8", 5)
UINT8 = Kind("<i4", 1, 11)


def write_columns(file: BinaryIO, schema: Mapping[str, Kind], groups: Iterable[Sequence[NDArray[Any]]]) -> None:
    """Write the columns of `schema`, given as groups of rows: for each group an array (n,) a column, n > 0."""
    file.write(MAGIC)
    rows, written = 0, []
    for columns in groups:
        chunks = [_write_chunk(file, name, kind, c) for (name, kind), c in zip(schema.items(), columns, strict=True)]
        size, n = sum(size for size, _ in chunks), len(columns[0])
        written.append(_struct({1: _list([chunk for _, chunk in chunks]), 2: _i64(size), 3: _i64(n)}))
        rows += n
    elements = [_struct({4: _text("schema"), 5: _i32(len(schema))}), *(_element(name, kind) for name, kind in schema.items())]
    made_by = _text(f"bematist version {__version__}")
    _, footer = _struct({1: _i32(1), 2: _list(elements), 3: _i64(rows), 4: _list(written), 6: made_by})
    file.write(footer + len(footer).to_bytes(4, "little") + MAGIC)


def _element(name: str, kind: Kind) -> Value:
    """The SchemaElement of a column."""
    fields = {1: _i32(kind.type), 3: _i32(REQUIRED), 4: _text(name)}
    return _struct(fields if kind.stands_for is None else {**fields, 6: _i32(kind.stands_for)})


def _write_chunk(file: BinaryIO, name: str, kind: Kind, column: NDArray[Any]) -> tuple[int, Value]:
    """Write a column of a group as one page; returns how many bytes it takes, and its ColumnChunk."""
    start, values = file.tell(), np.ascontiguousarray(column, kind.stored)
    n, size = len(values), _i32(values.nbytes)
    _, header = _struct({1: _i32(DATA_PAGE), 2: size, 3: size, 5: _struct({1: _i32(n), 2: _i32(PLAIN), 3: _i32(RLE), 4: _i32(RLE)})})
    file.write(header)
    file.write(values.data)
    total = len(header) + values.nbytes
    what = {1: _i32(kind.type), 2: _list([_i32(PLAIN)]), 3: _list([_text(name)]), 4: _i32(UNCOMPRESSED), 5: _i64(n)}
    return total, _struct({2: _i64(start), 3: _struct({**what, 6: _i64(total), 7: _i64(total), 9: _i64(start)})})


# -- Thrift's compact protocol -------------------------------------------------------------------------------------------


def _varint(number: int) -> bytes:
    """Seven bits a byte, the lowest first."""
    out = bytearray()
    while number > 127:
        out.append(number & 127 | 128)
        number >>= 7
    return bytes([*out, number])


def _i32(number: int) -> Value:
    """An int32 ≥ 0; its lowest bit would be the sign."""
    return 5, _varint(2 * number)


def _i64(number: int) -> Value:
    """An int64 ≥ 0."""
    return 6, _varint(2 * number)


def _text(text: str) -> Value:
    content = text.encode()
    return 8, _varint(len(content)) + content


def _list(values: Sequence[Value]) -> Value:
    """Values of one type."""
    kind, n = values[0][0] if values else 0, len(values)
    head = bytes([n << 4 | kind]) if n < 15 else bytes([15 << 4 | kind]) + _varint(n)
    return 9, head + b"".join(content for _, content in values)


def _struct(fields: Mapping[int, Value]) -> Value:
    """Fields by their numbers, which ascend from 1."""
    out, last = bytearray(), 0
    for number, (kind, content) in fields.items():
        out.append(number - last << 4 | kind)
        out += content
        last = number
    return 12, bytes(out) + b"\0"
