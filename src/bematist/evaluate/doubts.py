"""What speaks against a reference being of the same walk as the trajectory: it is warned of, and judged all the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bematist.evaluate.pairing import Pairs
from bematist.recording import Reference

Array = NDArray[np.float64]

FACTOR = 2.0
"""Lengths and extents that differ by more than this are doubtful."""

SHORTEST_M = 3.0
"""Shorter paths, m, are not compared: of those noise and one wrong step are a large part."""


def doubts(reference: Reference, pairs: Pairs, mine_m: float, theirs_m: float) -> list[str]:
    """Reasons, a sentence each; mine_m and theirs_m are the lengths of trajectory and reference through the same points."""
    found = []
    why = "Either the method failed, or the reference is of another recording or in another unit."
    if theirs_m > SHORTEST_M and not 1 / FACTOR <= mine_m / theirs_m <= FACTOR:
        found.append(f"The path is {mine_m / theirs_m:.2g} times as long as the reference between the same instants. {why}")
    mine, theirs = _extent(pairs.position), _extent(reference.position[pairs.rows])
    if not found and theirs > SHORTEST_M and not 1 / FACTOR <= mine / theirs <= FACTOR:
        found.append(f"The path reaches over {mine:.3g} m and the reference over {theirs:.3g} m. {why}")
    placed = np.isfinite(reference.position[:, :2]).all(1)
    if reference.judged is not None:
        placed &= reference.judged
    if len(pairs.rows) < placed.sum() / 2:
        found.append(
            f"Only {len(pairs.rows)} of {placed.sum()} points of the reference could be compared: do its clock and its footfalls belong to "
            "this recording?"
        )
    return found


def _extent(position: Array) -> float:
    """Diagonal of the box around the points (K,3) in the plan, m."""
    return float(np.linalg.norm(np.ptp(position[:, :2], axis=0)))
