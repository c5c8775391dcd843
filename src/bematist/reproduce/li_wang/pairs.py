"""Two variants on the same walks: in how many is one better, and could that be chance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import polars as pl


def sign_test(better: int, worse: int) -> float:
    """Two-sided probability that a fair coin splits as unevenly or more; ties are not counted."""
    n, k = better + worse, min(better, worse)
    return min(1.0, 2 * sum(math.comb(n, i) for i in range(k + 1)) / 2**n)


@dataclass(frozen=True)
class Compared:
    """Medians of two variants, and on how many walks the first is better (smaller) and worse."""

    median: float
    other: float
    better: int
    worse: int
    runs: int

    @property
    def p(self) -> float:
        return sign_test(self.better, self.worse)

    def __str__(self) -> str:
        return f"{self.median:.3g} against {self.other:.3g}, better in {self.better} of {self.runs} (p {self.p:.2g})"


def compare(frame: pl.DataFrame, changed: str, base: str, column: str, by: str = "seed") -> Compared | None:
    """Sizes of `column` of two variants over the walks (rows with the same `by`) that have both; None where there is none."""
    if frame[column].dtype == pl.Null:
        return None
    there = frame.filter(pl.col(column).is_not_null()).select(by, "variant", pl.col(column).abs())
    one, two = (there.filter(pl.col("variant") == v) for v in (changed, base))
    both = one.join(two, on=by, suffix="_base")
    if not len(both):
        return None
    a, b = both[column].to_numpy(), both[f"{column}_base"].to_numpy()
    return Compared(float(np.median(a)), float(np.median(b)), int((a < b).sum()), int((a > b).sum()), len(a))
