"""What is suspicious in a recording whose units and clock are settled: said as warnings, the data stay as they are."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bematist.arrays import median
from bematist.earth import STANDARD_GRAVITY
from bematist.io.guess import saturated

Array = NDArray[np.float64]

SLOW_HZ = 40.0
"""Below this rate a foot's swing (about 2 Hz, with impacts) is not resolved."""
EMPTY_PART = 0.01


def warnings_of(time: Array, force: Array, rate: Array) -> Iterator[str]:
    """Warnings about the inertial samples: saturation, stuck sensors, missing samples, a slow rate."""
    for word, values, unit, scale in (
        ("accelerometer", force, "g", STANDARD_GRAVITY),
        ("gyroscope", rate, "°/s", math.radians(1)),
    ):
        for axis, extreme, count in saturated(values):
            yield (
                f"The {word} saturates: {'xyz'[axis]} stays at {extreme / scale:.4g} {unit} for {count} samples. Motion beyond "
                "its range is lost, and the path suffers."
            )
        yield from stuck(word, values)
        empty = float(np.isnan(values[:, 0]).mean())
        if empty > EMPTY_PART:
            yield f"{100 * empty:.1f} % of the rows have no {word} sample."
    if len(time) < 2:
        yield "The recording has one sample: there is no motion to follow."
        return
    hz = 1 / median(np.diff(time))
    if hz < SLOW_HZ:
        yield f"The rate of {hz:.3g} Hz is too slow to follow a foot; expect a poor path."


def stuck(word: str, values: Array) -> Iterator[str]:
    """A warning about the axes (N,3) that never change."""
    axes = ["xyz"[k] for k in range(3) if len(values) > 10 and _constant(values[:, k])]
    if axes:
        yield f"The {word} never changes on {', '.join(axes)}: it may be stuck or not recorded."


def _constant(x: Array) -> bool:
    """Whether the values (N,) that are not NaN are all the same."""
    head = x[:1000]
    return not np.fmax.reduce(head) > np.fmin.reduce(head) and bool(np.fmax.reduce(x) == np.fmin.reduce(x))
