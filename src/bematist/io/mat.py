"""MATLAB's level 5 files: the real numeric arrays in them, in structures too.

Written here because the reader of scipy ends the process on some damaged files, and takes longer to import than to read.
Format: "MAT-File Format", The MathWorks; data elements of a type, a length and content padded to eight bytes.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError

HEADER_BYTES = 128
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED = 14, 15
_NUMERIC_CLASSES = range(6, 16)
"""Array classes double, single and the integers; not cells, text and sparse arrays."""
_STRUCTURE = 2
_COMPLEX = 0x08


def names(path: Path) -> tuple[str, ...]:
    """Names of the variables of a file, without what they hold; none where the file is of another kind or damaged."""
    try:
        content = path.read_bytes()
        order = {b"IM": "<", b"MI": ">"}[content[126:128]]
        return tuple(_name(kind, body, order) for kind, body in _elements(content[HEADER_BYTES:], order))
    except (OSError, ValueError, struct.error, zlib.error, KeyError):
        return ()


def _name(kind: int, body: bytes, order: str) -> str:
    # The beginning of a compressed element holds the tag of a matrix (8 bytes), then flags, shape and name.
    start = zlib.decompressobj().decompress(body, 1024)[8:] if kind == _COMPRESSED else body[:1024]
    parts = _elements(start, order)
    for _ in range(2):
        _next(parts)
    return _next(parts).decode("ascii")


def load(path: Path) -> dict[str, Any]:
    """The real numeric arrays of a file by name, and as dictionaries of them the structures (of one element); others are left out.

    Raises
    ------
    DataError
        The file cannot be opened, is of another level (v7.3 is HDF5), or is cut short or damaged.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DataError(f"{path}: the file cannot be opened ({error.strerror}).") from None
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None or struct.unpack(f"{order}H", content[124:126])[0] != 0x0100:
        raise DataError(f"{path}: of MATLAB's files only those of level 5 are read, not v7.3 and v4. Save it with -v7.")
    try:
        found = (_variable(kind, body, order) for kind, body in _elements(content[HEADER_BYTES:], order))
        return dict(pair for pair in found if pair is not None)
    except (ValueError, struct.error, zlib.error, KeyError, UnicodeDecodeError, MemoryError, OverflowError) as error:
        raise DataError(
            f"{path}: this MATLAB file is cut short or damaged ({str(error)[:100] or type(error).__name__}). Save it anew with -v7."
        ) from None


def _elements(content: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Type and content of the data elements that follow one another; a type above 16 bits marks the small form."""
    at = 0
    while at + 8 <= len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        if kind >> 16:
            kind, size, start, after = kind & 0xFFFF, kind >> 16, at + 4, at + 8
        else:
            start = at + 8
            after = start + (size if kind == _COMPRESSED else -(-size // 8) * 8)
        if start + size > len(content) or (after == at + 8 and size > 4):
            raise ValueError(f"an element of {size} bytes where {len(content) - start} are left")
        yield kind, content[start : start + size]
        at = after


def _variable(kind: int, body: bytes, order: str) -> tuple[str, NDArray[Any] | dict[str, Any]] | None:
    """Name and content of one element; None where it is neither a real numeric array nor one structure."""
    if kind == _COMPRESSED:
        inner = next(_elements(zlib.decompress(body), order), None)
        return None if inner is None else _variable(*inner, order)
    if kind != _MATRIX:
        return None
    parts = _elements(body, order)
    flags = struct.unpack_from(f"{order}I", _next(parts))[0]
    structure = flags & 0xFF == _STRUCTURE
    if (flags & 0xFF not in _NUMERIC_CLASSES and not structure) or flags >> 8 & _COMPLEX:
        return None
    shape = np.frombuffer(_next(parts), f"{order}i4")
    name = _next(parts).decode("ascii")
    if structure:
        return (name, _fields(parts, order)) if math.prod(shape.tolist()) == 1 else None
    stored, data = next(parts, (9, b""))
    values = np.frombuffer(data, order + _TYPES[stored])
    if (shape < 0).any() or math.prod(shape.tolist()) != len(values):
        raise ValueError(f"{name} has {len(values)} numbers for the shape {tuple(shape.tolist())}")
    return name, values.reshape(shape, order="F")


def _fields(parts: Iterator[tuple[int, bytes]], order: str) -> dict[str, Any]:
    """The fields of one structure by name."""
    (length,) = struct.unpack(f"{order}i", _next(parts))
    words = _next(parts)
    names = [words[i : i + length].split(b"\x00")[0].decode("ascii") for i in range(0, len(words), max(length, 1))]
    found = {name: _variable(kind, body, order) for name, (kind, body) in zip(names, parts, strict=True)}
    return {name: value[1] for name, value in found.items() if value is not None}


def _next(parts: Iterator[tuple[int, bytes]]) -> bytes:
    found = next(parts, None)
    if found is None:
        raise ValueError("an array without content")
    return found[1]
