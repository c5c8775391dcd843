"""Axes that were swapped, mirrored or turned between two sensors of one device: found, and named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CLEARLY = 0.5
"""Other axes are believed when their misfit is this much of that of the axes as they are named."""
CONVINCING = np.radians(15.0)
"""rad: no axes that miss by more are believed."""


def signed_permutations() -> list[Array]:
    """The 48 matrices (3,3) that name the axes anew, the nearest to the unit matrix first."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            P = np.zeros((3, 3))
            P[range(3), order] = signs
            found.append(P)
    return sorted(found, key=changes)


def changes(P: Array) -> int:
    """How far a signed permutation is from leaving all as it is: axes that move, and signs that turn."""
    order = np.argmax(np.abs(P), axis=1)
    return int((order != np.arange(3)).sum()) + int((P.sum(1) < 0).sum())


def best_axes(misfit: Callable[[Array], float], candidates: list[Array] | None = None) -> Array:
    """The axes with which a misfit, rad, is least; the unit matrix unless others fit clearly better."""
    candidates = signed_permutations() if candidates is None else candidates
    own = misfit(np.eye(3))
    scores = [misfit(P) for P in candidates]
    if not np.isfinite([own, *scores]).all():
        return np.eye(3)
    best = int(np.argmin(scores))
    return candidates[best] if scores[best] < CLEARLY * own and scores[best] < CONVINCING else np.eye(3)


def one_of_each_sign() -> list[Array]:
    """Of each pair P, −P the one with fewer changes: for what cannot tell a vector from its opposite."""
    found: list[Array] = []
    for P in signed_permutations():
        if not any((P == -Q).all() for Q in found):
            found.append(P)
    return found


@dataclass(frozen=True, eq=False)
class Blame:
    """Whose axes are wrong, and the axes (3,3) that put it right: right = axes · reading."""

    sensor: str
    axes: Array

    def text(self) -> str:
        """What is wrong, in words."""
        return f"the {self.sensor}'s axes do not fit the others': {described(self.axes)} (right: {option(self.axes)})"


def blame(gyro_axes: Array, field_axes: Array | None) -> Blame:
    """Whether gyroscope or accelerometer is wrong when turns fit gravity only with rates gyro_axes · w.

    An accelerometer whose readings are P f makes the gyroscope look turned by det(P) P, a proper rotation: only that leaves a choice. Then
    the magnetometer decides, where the gyroscope's own rates fit it (field_axes the unit matrix), else the fewer changes.
    """
    accel = min((gyro_axes.T, -gyro_axes.T), key=changes)
    if np.linalg.det(gyro_axes) < 0:
        return Blame("gyroscope", gyro_axes)
    if field_axes is not None:
        accel_is_wrong = bool((field_axes == np.eye(3)).all())
    else:
        accel_is_wrong = changes(accel) < changes(gyro_axes)
    return Blame("accelerometer", accel) if accel_is_wrong else Blame("gyroscope", gyro_axes)


def option(P: Array) -> str:
    """The axes as they are written for --axes: "y,x,-z"."""
    order = np.argmax(np.abs(P), axis=1)
    return ",".join(("-" if P[i, k] < 0 else "") + "xyz"[k] for i, k in enumerate(order))


def described(P: Array) -> str:
    """What to do with the axes, in words: "swap x and y, turn the sign of z"."""
    order = np.argmax(np.abs(P), axis=1)
    moved = [i for i in range(3) if order[i] != i]
    turned = ["xyz"[i] for i in range(3) if P[i].sum() < 0]
    words = []
    if len(moved) == 2:
        words.append(f"swap {' and '.join('xyz'[i] for i in moved)}")
    elif moved:
        words.append(f"take {', '.join('xyz'[k] for k in order)} for x, y, z")
    if turned:
        words.append(f"turn the sign of {' and '.join(turned)}" + (" afterwards" if moved else ""))
    return ", ".join(words) or "nothing to change"
