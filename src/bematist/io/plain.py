"""Delimited text of plain decimals → columns of numbers, by a kernel: several times as fast as a library that reads any text.

Most recordings are such. Whatever else there may be in a file (words, dates, comments, quotation marks, rows of different lengths, numbers
of twenty digits) is left to `table`.
"""

from __future__ import annotations

import mmap
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from bematist.io.head import Head
from bematist.kernels import numerals

Array = NDArray[np.float64]

PIECE = 1 << 16
"""Bytes that are looked at together: they stay in the processor's cache."""


def read_plain(head: Head, skip_lines: int, column: Sequence[int], separator: str, comment: str, point: str) -> Array | None:
    """Numbers (C,n) of the rows after `skip_lines` lines; None where the text is not plain.

    Cell i of a row goes to row column[i] of the result, or nowhere where that is negative; an empty cell is NaN.
    """
    marks = (separator, point, comment)
    if not head.is_utf8 or separator in (" ", point) or any(len(mark) != 1 or not mark.isascii() for mark in marks):
        return None
    with suppress(OSError, ValueError):
        text = _text(head, skip_lines)
        lines = 1 + sum(int(np.count_nonzero(text[k : k + PIECE] == numerals.NEWLINE)) for k in range(0, len(text), PIECE))
        numbers = np.empty((max(column) + 1, lines))
        found = numerals.rows(text, *map(ord, marks), np.array(column), numbers)
        return numbers[:, :found] if found > 0 else None
    return None


def _text(head: Head, skip_lines: int) -> NDArray[np.uint8]:
    """The bytes after the first lines; ValueError where there are fewer lines."""
    if head.content is not None:
        content = bytearray(head.content)
    else:
        with head.path.open("rb") as file:
            content = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)  # kernels take what could be written to
    start = 0
    for _ in range(skip_lines):
        start = content.find(b"\n", start) + 1
        if not start:
            raise ValueError
    return np.frombuffer(content, np.uint8)[start:]
