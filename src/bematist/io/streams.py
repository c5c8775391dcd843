"""Columns of a table → streams of sensors: what most readers end with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import WORDS, Stream
from bematist.io.table import read_columns

Found = dict[str, dict[str, str]]
"""Quantity → axis ("x", "y", "z", or "" of a scalar) → name of its column."""


def read_streams(
    head: Head,
    line: int,
    names: Sequence[str],
    separator: str,
    clock: str,
    found: Mapping[str, Mapping[str, str]],
    *,
    dated: bool = False,
    comment: str = "#",
) -> dict[str, Stream]:
    """Streams of the columns in `found` on the stamps in the column `clock` (`dated`: it may hold dates).

    `line`, `separator` and `comment` are those of the header, `names` its columns, as `read_columns` takes them.

    Raises
    ------
    DataError
        An axis is missing, or the table cannot be read.
    """
    for quantity, axes in found.items():
        missing = [a for a in "xyz" if a not in axes] if quantity != "pressure" else []
        if missing:
            raise DataError(f"{head.path}: the {WORDS[quantity]} lacks the axis {', '.join(missing)}. Export all three.")
    wanted = [clock, *(name for axes in found.values() for name in axes.values())]
    columns = read_columns(head, line, names, wanted, separator=separator, comment=comment, clock=clock if dated else None)
    stamps = columns[clock]
    return {
        quantity: Stream(stamps=stamps, values=np.stack([columns[name] for _, name in sorted(axes.items())], 1))
        for quantity, axes in found.items()
    }
