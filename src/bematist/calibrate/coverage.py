"""Which ways a vector has been seen from the sensor, and which not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEAR = np.cos(np.radians(40.0))
"""A direction is covered where a sample lies within 40 degrees: the corners of a cube lie 55 degrees from its sides."""
SIDES = {f"{sign}{axis}": s * np.eye(3)[k] for k, axis in enumerate("xyz") for sign, s in (("+", 1.0), ("-", -1.0))}


def missing_directions(units: Array, needed: int = 1) -> tuple[str, ...]:
    """Sides of the sensor, "+x" … "-z", near which fewer than `needed` of the unit vectors (n,3) lie."""
    return tuple(name for name, side in SIDES.items() if int((units @ side > NEAR).sum()) < needed)
