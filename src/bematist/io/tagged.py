"""Text with one event a line and a tag that says of what sensor: phones' logs."""

from __future__ import annotations

from collections.abc import Mapping
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
        return [f"{lines} cut or run together could not be read and left out."] if self.broken else []


def read_tagged(text: str, separator: str, place: int, wanted: Mapping[str, tuple[int, ...]], comment: str) -> Tagged:
    """The lines of a text whose cell `place` is a tag of `wanted`, with the cells of the numbers asked for: tag → places.

    A cell that is missing or no number makes a broken line; an empty one is NaN.
    """
    cells_of = {tag: [] for tag in wanted}
    seen: dict[str, int] = {}
    broken = 0
    for line in text.splitlines():
        if not line or line.startswith(comment):
            continue
        cells = line.split(separator)
        tag = cells[place] if len(cells) > place else ""
        seen[tag] = seen.get(tag, 0) + 1
        if tag in cells_of:
            try:
                cells_of[tag].append([float(cells[i] or "nan") for i in wanted[tag]])
            except (ValueError, IndexError):
                broken += 1
    rows = {tag: np.array(cells, float) for tag, cells in cells_of.items() if cells}
    return Tagged(rows, seen, broken)
