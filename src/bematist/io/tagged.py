"""Text with one event a line and a tag that says of what sensor: phones' logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tagged:
    """Numbers (N,C) by tag, the number of lines of every tag in the file, and of the lines that could not be read."""

    rows: dict[str, Array]
    seen: dict[str, int]
    broken: int

    def warnings(self) -> list[str]:
        lines = "1 line that is" if self.broken == 1 else f"{self.broken} lines that are"
        return [f"{lines} cut or damaged could not be read and left out."] if self.broken else []


def read_tagged(lines: Sequence[str], separator: str, place: int, wanted: Mapping[str, tuple[int, ...]], comment: str) -> Tagged:
    """The lines whose cell `place` is a tag of `wanted`, with the cells of the numbers asked for: tag → places.

    A cell that is missing or no number makes a broken line.
    """
    import polars as pl

    width = 1 + max(place, *(i for cells in wanted.values() for i in cells))
    events = pl.Series("line", lines, pl.String)
    events = events.filter(~events.str.starts_with(comment))
    # One part more than is read takes what is left of a longer line.
    frame = events.str.splitn(separator, width + 1).struct.unnest()
    frame.columns = [f"{i}" for i in range(width + 1)]
    tag = pl.col(f"{place}")
    seen = dict(frame.filter(tag.is_not_null()).group_by(tag).len().iter_rows())
    rows: dict[str, Array] = {}
    broken = 0
    for name, cells in wanted.items():
        if name not in seen:
            continue
        numbers = frame.filter(tag == name).select(pl.col(f"{i}").str.strip_chars().cast(pl.Float64, strict=False) for i in cells)
        whole = numbers.drop_nulls()
        broken += len(numbers) - len(whole)
        if len(whole):
            rows[name] = np.array(whole.to_numpy())
    return Tagged(rows, seen, broken)
