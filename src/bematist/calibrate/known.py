"""Turns whose angle is known: once around, against an edge or a line on the floor."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.solve import Model
from bematist.calibrate.turning import Turn, inverse_right_jacobian, propagated
from bematist.errors import DataError, UsageError
from bematist.frames import quaternion_from_matrix, rotation_vector_from_quaternion

Array = NDArray[np.float64]

HAND_SD = np.radians(1.0)
"""rad: how well a hand comes back to the edge it started from."""
TOLERANCE = 0.15
"""A turn is taken for the known one when the raw gyroscope agrees with its angle to this, relative."""
ALONG = 0.9
"""Of the way that was turned, this much must be about the axis."""


@dataclass(frozen=True, eq=False)
class KnownTurn:
    """A turn about one axis, 0 … 2, by an angle, rad (its size; either way around), with its standard deviation, rad."""

    turn: Turn
    axis: int
    angle: float
    sd: float = HAND_SD


def parse_turn(text: str) -> tuple[int, float]:
    """Axis and angle, rad, of "z=360".

    Raises
    ------
    UsageError
        It is not written so.
    """
    m = re.fullmatch(r"\s*([xyz])\s*=\s*([+-]?\d+(?:\.\d+)?)\s*", text)
    if m is None or not abs(float(m[2])) >= 45:
        raise UsageError(f"--turn {text}: write the axis and the angle in degrees, 45 or more, such as z=360.")
    return "xyz".index(m[1]), float(np.radians(abs(float(m[2]))))


def assigned(turns: Sequence[Turn], wanted: Sequence[tuple[int, float]], source: str) -> list[KnownTurn]:
    """The ways between rests that are the known turns.

    Raises
    ------
    DataError
        A known turn is not found.
    """
    found = []
    for axis, angle in dict.fromkeys(wanted):
        fitting = [t for t in turns if abs(abs(_about(t, axis)) / angle - 1) < TOLERANCE and abs(_about(t, axis)) > ALONG * t.way()]
        if not fitting:
            largest = max((t for t in turns), key=lambda t: abs(_about(t, axis)), default=None)
            angle_deg = 0.0 if largest is None else np.degrees(abs(_about(largest, axis)))
            most = f"the largest between two rests is {angle_deg:.0f} degrees"
            raise DataError(
                f"{source}: no turn of {np.degrees(angle):.0f} degrees about {'xyz'[axis]} is in the recording: {most}. Rest before and "
                "after the turn, and turn about this axis alone."
            )
        found += [KnownTurn(t, axis, angle) for t in fitting]
    return found


def full_turns(turns: Sequence[Turn]) -> list[KnownTurn]:
    """Ways between rests that look like whole turns about one axis."""
    found = []
    for t in turns:
        axis = int(np.argmax(np.abs(t.total())))
        whole = max(round(abs(_about(t, axis)) / (2 * np.pi)), 1) * 2 * np.pi
        if abs(abs(_about(t, axis)) / whole - 1) < 0.06 and abs(_about(t, axis)) > ALONG * t.way():
            found.append(KnownTurn(t, axis, whole))
    return found


def _about(turn: Turn, axis: int) -> float:
    return float(turn.total()[axis])


def known_model(known: Sequence[KnownTurn]) -> Model:
    """Residual (n,1), rad: the angle by which S w turns, less the known one. S has nine parameters.

    After a whole number of turns the attitude is the first again, and what is missing is the small rotation left, along the axis; else it
    is the angle of the whole rotation.
    """

    def one(p: Array, k: KnownTurn) -> tuple[float, Array]:
        R, G = propagated(p[:9].reshape(3, 3), k.turn)
        left = rotation_vector_from_quaternion(quaternion_from_matrix(R))
        sign = np.sign(_about(k.turn, k.axis))
        missing = float(np.remainder(k.angle + np.pi, 2 * np.pi) - np.pi)
        size = float(np.linalg.norm(left))
        axis = np.eye(3)[k.axis] * sign if abs(missing) < 1e-6 or size < 1e-9 else left / size * np.sign(left[k.axis] * sign)
        residual = float(np.remainder(axis @ left - missing + np.pi, 2 * np.pi) - np.pi)
        return residual, axis @ inverse_right_jacobian(left) @ G

    def model(p: Array) -> tuple[Array, Array]:
        out, J = np.empty((len(known), 1)), np.zeros((len(known), 1, len(p)))
        for i, k in enumerate(known):
            out[i, 0], J[i, 0, :9] = one(p, k)
        return out, J

    return model


def measured_angle(known: KnownTurn, S: Array) -> float:
    """The angle, rad, that the gyroscope with rates S w measures of a known turn."""
    residual, _ = known_model([known])(S.ravel())
    return known.angle + float(residual[0, 0])
