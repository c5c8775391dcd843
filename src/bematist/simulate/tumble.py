"""A sensor that is turned about in the hand to calibrate it: rests in many orientations, and turns between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bematist.frames import (
    conjugate,
    multiply,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    rotate,
    rotation_vector_from_quaternion,
)
from bematist.simulate.motion import Motion, State, Strides
from bematist.simulate.parameters import Scenario
from bematist.simulate.shape import Array

_GOLDEN = np.pi * (3 - np.sqrt(5))
_LEVER = np.array([0.03, -0.02, 0.15])
"""m: the sensor from the point that it is turned about, in its own axes."""


@dataclass(frozen=True, eq=False)
class Tumble(Motion):
    """A motion whose rests differ in attitude, not in place.

    attitude (K+1,4) at the rests; turn (K,3) rotation vector of the way to the next.
    """

    attitude: Array
    turn: Array

    @cached_property
    def _speed(self) -> Array:
        return self.edges[2::2] - self.edges[1:-1:2]

    def standing(self, time: Array) -> NDArray[np.bool_]:
        return np.searchsorted(self.edges[1:-1], time) % 2 == 0

    def still(self, begin: Array, end: Array) -> NDArray[np.bool_]:
        a, b = (np.searchsorted(self.edges[1:-1], t) for t in (begin, end))
        return (a == b) & (a % 2 == 0)

    def at(self, time: Array) -> State:
        piece = np.searchsorted(self.edges[1:-1], time)
        k = np.minimum(piece // 2, max(len(self.turn) - 1, 0))
        if not len(self.turn):
            nothing = np.zeros((len(time), 3))
            return State(nothing, nothing, nothing, np.tile(self.attitude[0], (len(time), 1)), nothing)
        T = self._speed[k]
        u = np.clip((time - self.edges[2 * k + 1]) / T, 0.0, 1.0)
        # From 0 to 1 with three continuous derivatives: 35u⁴ − 84u⁵ + 70u⁶ − 20u⁷.
        s = u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3)
        s1 = 140 * u**3 * (1 - u) ** 3 / T
        s2 = 420 * u**2 * (1 - u) ** 2 * (1 - 2 * u) / T**2
        attitude = multiply(self.attitude[k], quaternion_from_rotation_vector(s[:, None] * self.turn[k]))
        w, a = s1[:, None] * self.turn[k], s2[:, None] * self.turn[k]
        lever = np.broadcast_to(_LEVER, w.shape)
        v = np.cross(w, lever)
        acceleration = np.cross(a, lever) + np.cross(w, v)
        start = rotate(self.attitude[:1], _LEVER[None])
        return State(rotate(attitude, lever) - start, rotate(attitude, v), rotate(attitude, acceleration), attitude, w)

    def signals(self, time: Array) -> tuple[Array, Array]:
        state = self.at(time)
        up = np.array([0.0, 0.0, self.scenario.gravity])
        return rotate(conjugate(state.attitude), state.acceleration + up), state.angular_rate


def tumble(scenario: Scenario, rng: np.random.Generator) -> Tumble:
    """The motion: `tumble_rests` orientations whose verticals are spread evenly over the sphere, in random order and turned at random about
    the vertical; then, with `full_turns`, once around x, y and z between rests with that axis up.
    """
    n = scenario.tumble_rests
    k = np.arange(n)
    z = 1 - (2 * k + 1) / n
    r = np.sqrt(1 - z**2)
    up = np.column_stack([r * np.cos(_GOLDEN * k), r * np.sin(_GOLDEN * k), z])[rng.permutation(n)]
    attitude = [_upright(u, a) for u, a in zip(up, rng.uniform(-np.pi, np.pi, n), strict=True)]
    turns = [rotation_vector_from_quaternion(multiply(conjugate(p), q)) for p, q in pairwise(attitude)]
    for axis in np.eye(3) if scenario.full_turns else ():
        start = _upright(axis, 0.0)
        turns += [rotation_vector_from_quaternion(multiply(conjugate(attitude[-1]), start)), 2 * np.pi * axis]
        attitude += [start, start]
    way = np.linalg.norm(np.array(turns).reshape(-1, 3), axis=1)
    spans = np.maximum(way / scenario.tumble_rate, 0.5)
    rest = scenario.tumble_rest_s
    edges = np.concatenate([[0.0], np.column_stack([np.full(len(turns), rest), spans]).ravel().cumsum()])
    edges = np.append(edges, edges[-1] + rest)
    none = np.zeros((len(attitude), 3))
    nothing = np.empty(0)
    no_strides = Strides(np.empty(0, "U1"), nothing, nothing, nothing, nothing, nothing, nothing, nothing, np.empty(0, np.int64))
    return Tumble(edges, none, none[:, 0], none[:, 0], no_strides, scenario, np.array(attitude), np.array(turns).reshape(-1, 3))


def _upright(up: Array, turn: float) -> Array:
    """Attitude (4,) whose body direction `up` points up, turned by `turn`, rad, about it."""
    side = np.eye(3)[np.argmin(np.abs(up))]
    x = np.cross(side, up)
    x /= np.linalg.norm(x)
    start = quaternion_from_matrix(np.stack([x, np.cross(up, x), up]))
    return multiply(quaternion_from_rotation_vector(np.array([0.0, 0.0, turn])), start)
