"""What the gyroscope says of a turn, and how that changes with its scale factors and misalignments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.rests import Rests
from bematist.frames import matrix_from_quaternion, multiply, quaternion_from_rotation_vector
from bematist.kernels.turning import propagate
from bematist.recording import Recording

Array = NDArray[np.float64]

LONGEST_S = 60.0
"""A longer way between two rests tells more of the gyroscope's drift than of its scale."""
GAP_S = 0.1
"""The turn over a longer gap, s, is not known."""


@dataclass(frozen=True, eq=False)
class Turn:
    """The way from one rest to the next: their indices, rates (n,3), rad/s, the rest's own reading taken off, steps (n,), s."""

    first: int
    second: int
    rates: Array
    steps: Array

    @property
    def seconds(self) -> float:
        return float(self.steps.sum())

    def total(self) -> Array:
        """Integral of the rates (3,), rad: the turn, where its axis stands."""
        return self.steps @ self.rates

    def way(self) -> float:
        """Angle that was turned in all, rad."""
        return float(self.steps @ np.linalg.norm(self.rates, axis=1))


def turns_between(rests: Rests, recordings: Sequence[Recording]) -> list[Turn]:
    """The ways between neighbouring rests of one recording, without gaps; the mean reading of both rests is taken off."""
    found = []
    for k in range(len(rests) - 1):
        if rests.recording[k] != rests.recording[k + 1]:
            continue
        r = recordings[rests.recording[k]]
        good = np.isfinite(r.angular_rate).all(1)
        t, w = r.time[good], r.angular_rate[good]
        a, b = np.searchsorted(t, [rests.end_s[k], rests.start_s[k + 1]])
        a = max(a, 1)
        steps = t[a:b] - t[a - 1 : b - 1]
        if not len(steps) or steps.max() > GAP_S or steps.sum() > LONGEST_S:
            continue
        found.append(Turn(k, k + 1, w[a:b] - (rests.rate[k] + rests.rate[k + 1]) / 2, steps))
    return found


def turned(rates: Array, steps: Array, S: Array) -> Array:
    """Attitude (4,) at the end relative to the start, the rates S w of (n,3) constant over the steps (n,)."""
    return _run(rates, steps, S, np.empty(0))[-1]


def propagated(S: Array, turn: Turn) -> tuple[Array, Array]:
    """Attitude matrix (3,3) at the end relative to the start with rates S w, and its derivative G (3,9).

    A change dS of the matrix turns the end by the small rotation dφ = G vec(dS), vec row by row, in the axes of the end.
    """
    G = np.empty(27)
    q = _run(turn.rates, turn.steps, S, G)
    return matrix_from_quaternion(q[-1]), G.reshape(3, 9)


def _run(rates: Array, steps: Array, S: Array, G: Array) -> Array:
    q = np.empty((len(steps), 4))
    propagate(np.ascontiguousarray(rates), np.ascontiguousarray(steps), np.ascontiguousarray(S).ravel(), q, G)
    return q


def inverse_right_jacobian(theta: Array) -> Array:
    """J_r⁻¹ (3,3) with log(exp(θ) exp(φ)) = θ + J_r⁻¹ φ, of a rotation vector (3,): I + ½ [θ]× + (1/θ² − (1 + cos θ)/(2 θ sin θ)) [θ]×²."""
    angle = float(np.linalg.norm(theta))
    K = skew(theta)
    part = 1 / 12 if angle < 1e-3 else 1 / angle**2 - (1 + np.cos(angle)) / (2 * angle * np.sin(angle))
    return np.eye(3) + 0.5 * K + part * (K @ K)


def skew(v: Array) -> Array:
    """Matrices [v ×] (…,3,3) of vectors (…,3)."""
    K = np.zeros((*v.shape[:-1], 3, 3))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return K - np.swapaxes(K, -1, -2)


def attitudes(recording: Recording, offset: Array, S: Array, at: Array) -> tuple[Array, Array]:
    """Attitude (K,4) at the times (K,), s, relative to the first sample by the gyroscope alone, and the angle turned so far (K,), rad.

    NaN where no gyroscope sample is near.
    """
    good = np.isfinite(recording.angular_rate).all(1)
    t, w = recording.time[good], (recording.angular_rate[good] - offset) @ S.T
    steps = np.diff(t, prepend=t[0])
    q = _run(w, steps, np.eye(3), np.empty(0))
    way = np.cumsum(np.linalg.norm(w, axis=1) * steps)
    k = np.clip(np.searchsorted(t, at), 1, len(t) - 1)
    part = at - t[k - 1]
    found = multiply(q[k - 1], quaternion_from_rotation_vector(w[k] * part[:, None]))
    known = (at >= t[0]) & (at <= t[-1]) & (t[k] - t[k - 1] < GAP_S)
    # A gap behind makes the angle so far unknown; the step over it is counted as a whole turn, so that no pair reaches over it.
    way = way + np.cumsum(steps > GAP_S) * 2 * np.pi
    found[~known] = np.nan
    return found, np.where(known, way[k - 1] + np.linalg.norm(w[k], axis=1) * part, np.nan)
