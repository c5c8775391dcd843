"""How the shoe moves: it stands on footprints in time, and between them swings, with analytic derivatives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bematist.frames import conjugate, matrix_from_quaternion, multiply, quaternion_from_euler, rotate
from bematist.simulate.parameters import Scenario
from bematist.simulate.shape import Array, evaluated, shape_of

_BLOCK = 16384
"""Samples at once: what is worked on stays in the processor's cache, and a long recording needs no more memory than it holds."""

_JOLT_PITCH = 5.0
"""Pitch of the foot in the jolt of a heel strike, rad/m: it turns about a point 0.2 m away."""


@dataclass(frozen=True, eq=False)
class State:
    """Truth at instants (K rows): the sensor in ENU, and its angular rate in its own axes. SI."""

    position: Array
    velocity: Array
    acceleration: Array
    attitude: Array
    angular_rate: Array


class Movement(Protocol):
    """A walk as a function of time, of a sensor on the shoe or in the hand: what the sensor and the field need of it.

    `along` (K+1,) m are the ends of its strides or steps along the path.
    """

    @property
    def scenario(self) -> Scenario: ...
    @property
    def along(self) -> Array: ...
    @property
    def duration_s(self) -> float: ...

    def places(self, along: Array) -> tuple[Array, Array]:
        """Places (K,3), m, and directions (K,), rad, of the path in ENU at the distances (K,) along it, m."""
        ...

    def travelled(self, time: Array) -> Array:
        """Distance along the path (K,), m, at the times (K,), s."""
        ...

    def still(self, begin: Array, end: Array) -> NDArray[np.bool_]:
        """Whether nothing moves from `begin` to `end` (K,), s."""
        ...

    def at(self, time: Array) -> State:
        """Position, velocity, acceleration, attitude and angular rate at the times (K,), s."""
        ...

    def signals(self, time: Array) -> tuple[Array, Array]:
        """Specific force (K,3), m/s², and angular rate (K,3), rad/s, in the sensor's axes at the times (K,), s."""
        ...


@dataclass(frozen=True, eq=False)
class Strides:
    """What distinguishes the strides (K,): `shape` names the swing; `full` is the length over the gait's own, at most 1; the others are
    sizes in m and rad (`pitch` relative); `rocking` is that of the stance before the swing; `climbs` is 1 upstairs, −1 downstairs.
    """

    shape: NDArray[Any]
    full: Array
    roll: Array
    pitch: Array
    sway: Array
    clearance: Array
    impact: Array
    rocking: Array
    climbs: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _Instants:
    # Where the foot is at instants of movement: position, velocity, acceleration, and roll, pitch, yaw with their rates.
    p: Array
    v: Array
    a: Array
    angle: Array
    rate: Array


@dataclass(frozen=True, eq=False)
class Motion:
    """A walk as a function of time.

    Attributes
    ----------
    edges : (2K+2,) s; the foot is flat from edges[2k] to edges[2k+1], on footprint k, then swings until edges[2k+2].
    footprint : (K+1,3) m.
    yaw : (K+1,) rad, direction of the foot, unwrapped.
    along : (K+1,) m, the footprints along the path.
    strides : what distinguishes them.
    scenario : what it was made of.
    """

    edges: Array
    footprint: Array
    yaw: Array
    along: Array
    strides: Strides
    scenario: Scenario

    @property
    def duration_s(self) -> float:
        return float(self.edges[-1])

    def standing(self, time: Array) -> NDArray[np.bool_]:
        """Whether the foot is flat (K,) at the times (K,), s."""
        return np.searchsorted(self.edges[1:-1], time) % 2 == 0

    def still(self, begin: Array, end: Array) -> NDArray[np.bool_]:
        """Whether nothing moves from `begin` to `end` (K,), s."""
        a, b = (np.searchsorted(self.edges[1:-1], t) for t in (begin, end))
        return (a == b) & (a % 2 == 0) & (self._rocks[a // 2] == 0.0)

    def places(self, along: Array) -> tuple[Array, Array]:
        """Places (K,3), m, and directions (K,), rad, between the footprints at the distances (K,) along the path, m."""
        place = np.column_stack([np.interp(along, self.along, axis) for axis in self.footprint.T])
        return place, np.interp(along, self.along, self.yaw)

    def travelled(self, time: Array) -> Array:
        """Distance along the path (K,), m, at the times (K,), s."""
        return np.interp(time, self.edges, np.repeat(self.along, 2))

    def at(self, time: Array) -> State:
        """Position, velocity, acceleration, attitude and angular rate at the times (K,), s."""
        n = len(time)
        out = State(np.empty((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.empty((n, 4)), np.zeros((n, 3)))
        mounting = self._mounting
        flat = multiply(quaternion_from_euler(0.0, 0.0, self.yaw), mounting)
        for rows, k, moving, m in self._blocks(time):
            out.position[rows] = self.footprint[k]
            out.attitude[rows] = flat[k]
            if len(moving):
                out.position[moving], out.velocity[moving], out.acceleration[moving] = m.p, m.v, m.a
                out.attitude[moving] = multiply(quaternion_from_euler(*m.angle.T), mounting)
                out.angular_rate[moving] = rotate(conjugate(mounting), _body_rate(m))
        return out

    def signals(self, time: Array) -> tuple[Array, Array]:
        """Specific force (K,3), m/s², and angular rate (K,3), rad/s, in the sensor's axes at the times (K,), s.

        Against the stars: where the Earth turns, its rate Ω is in the angular rate, and 2 Ω × v in the specific force.
        """
        f, w = np.empty((len(time), 3)), np.zeros((len(time), 3))
        up = np.array([0.0, 0.0, self.scenario.gravity])
        earth = np.array(self.scenario.earth_rate)
        mounting = matrix_from_quaternion(self._mounting)
        still = mounting.T @ up
        for rows, k, moving, m in self._blocks(time):
            f[rows] = still
            if len(moving):
                f[moving] = _in_foot(m.angle, m.a + up) @ mounting
                w[moving] = _body_rate(m) @ mounting
            if earth.any():
                angle = np.column_stack([np.zeros((len(k), 2)), self.yaw[k]])
                angle[moving - rows.start] = m.angle
                w[rows] += _in_foot(angle, np.broadcast_to(earth, angle.shape)) @ mounting
                f[moving] += _in_foot(m.angle, 2 * np.cross(earth, m.v)) @ mounting
        return f, w

    @cached_property
    def _mounting(self) -> Array:
        return quaternion_from_euler(*np.radians(self.scenario.mounting_deg))

    @cached_property
    def _rocks(self) -> Array:
        # How far the foot rocks on each footprint, rad; rests do not rock.
        rocks = np.append(self.strides.rocking, 0.0)
        rocks[0] = 0.0
        return rocks

    def _blocks(self, time: Array) -> Iterator[tuple[slice, NDArray[np.int64], NDArray[np.int64], _Instants]]:
        # Rows, their footprints, the rows that move, and how.
        rocks = self._rocks
        for start in range(0, len(time), _BLOCK):
            rows = slice(start, min(start + _BLOCK, len(time)))
            t = time[rows]
            piece = np.searchsorted(self.edges[1:-1], t)
            k = piece // 2
            swings = piece % 2 == 1
            moves = np.flatnonzero(swings | (rocks[k] != 0.0))
            k_moving = k[moves]
            m = _Instants(self.footprint[k_moving], *(np.zeros((len(moves), 3)) for _ in range(4)))
            m.angle[:, 2] = self.yaw[k_moving]
            for name in np.unique(self.strides.shape) if len(moves) else ():
                i = np.flatnonzero(swings[moves])
                i = i[self.strides.shape[k_moving[i]] == name]
                self._swing(str(name), i, t[moves[i]], k_moving[i], m)
            i = np.flatnonzero(~swings[moves])
            if len(i):
                self._rock(i, t[moves[i]], k_moving[i], rocks[k_moving[i]], m)
            yield rows, k, moves + start, m

    def _swing(self, name: str, i: NDArray[np.int64], t: Array, k: NDArray[np.int64], m: _Instants) -> None:
        shape, s = shape_of(name), self.strides
        begin = self.edges[2 * k + 1]
        T = self.edges[2 * k + 2] - begin
        u = (t - begin) / T
        forward, up, pitch, turning, bump = _derivatives(shape.swing, u, T)
        climbs = np.flatnonzero(s.climbs[k])
        early, late = _derivatives(shape.climb, u[climbs], T[climbs])
        upstairs = s.climbs[k[climbs]] > 0
        stride, turn = self.footprint[k + 1] - self.footprint[k], self.yaw[k + 1] - self.yaw[k]
        track = np.column_stack([np.cos(self.yaw[k]), np.sin(self.yaw[k])])
        left = np.column_stack([-track[:, 1], track[:, 0]]) * s.sway[k, None]
        # A heel that strikes late in a short swing rings no longer than the swing lasts.
        jolt_s = np.minimum(shape.jolt_s, (1 - shape.strike) * T)
        w = (u - shape.strike) * T / jolt_s
        hit = np.flatnonzero((w > 0) & (w < 1))
        jolt, back = _derivatives(shape.jolt, w[hit], jolt_s[hit])
        size = s.impact[k[hit]]
        for order, target in enumerate((m.p, m.v, m.a)):
            rise = forward[order].copy()
            rise[climbs] = np.where(upstairs, early[order], late[order])
            target[i, :2] += forward[order][:, None] * stride[:, :2] + bump[order][:, None] * left
            target[i, 2] += rise * stride[:, 2] + s.clearance[k] * up[order]
            target[i[hit], :2] += (0.5 * size * back[order])[:, None] * track[hit]
            target[i[hit], 2] += size * jolt[order]
        for axis, (value, first, _), largest in ((0, bump, s.roll[k]), (1, pitch, s.pitch[k]), (2, turning, turn)):
            m.angle[i, axis] += largest * value
            m.rate[i, axis] = largest * first
        m.angle[i[hit], 1] += _JOLT_PITCH * size * back[0]
        m.rate[i[hit], 1] += _JOLT_PITCH * size * back[1]

    def _rock(self, i: NDArray[np.int64], t: Array, k: NDArray[np.int64], size: Array, m: _Instants) -> None:
        # The foot pitches by b about its toes, and back; the sensor, a lever away, goes with it.
        begin = self.edges[2 * k]
        T = self.edges[2 * k + 1] - begin
        b = [size * x for x in _derivatives(shape_of("walk").swing, (t - begin) / T, T)[-1]]
        forward, up = self.scenario.lever_m
        c, s = np.cos(b[0]), np.sin(b[0])
        along, rise = forward * c + up * s, up * c - forward * s
        # d/dθ (along, rise) = (rise, −along)
        track = np.column_stack([np.cos(self.yaw[k]), np.sin(self.yaw[k])])
        for target, x, z in (
            (m.p, along - forward, rise - up),
            (m.v, rise * b[1], -along * b[1]),
            (m.a, rise * b[2] - along * b[1] ** 2, -along * b[2] - rise * b[1] ** 2),
        ):
            target[i, :2] += x[:, None] * track
            target[i, 2] += z
        m.angle[i, 1], m.rate[i, 1] = b[0], b[1]


def _derivatives(rows: Array, u: Array, T: Array) -> list[tuple[Array, Array, Array]]:
    # Values and two time derivatives of each polynomial of a shape, at u in [0, 1] of the time T.
    found, speed = evaluated(rows, 2 * u - 1), 2 / T
    return [(found[j], found[j + 1] * speed, found[j + 2] * speed**2) for j in range(0, len(found), 3)]


def _in_foot(angle: Array, v: Array) -> Array:
    # ENU vectors in the axes of the foot: Rx(roll)ᵀ Ry(pitch)ᵀ Rz(yaw)ᵀ v.
    (cr, cp, cy), (sr, sp, sy) = np.cos(angle.T), np.sin(angle.T)
    x, y, z = v.T
    x, y = cy * x + sy * y, cy * y - sy * x
    x, z = cp * x - sp * z, sp * x + cp * z
    return np.column_stack([x, cr * y + sr * z, cr * z - sr * y])


def _body_rate(m: _Instants) -> Array:
    # Angular rate of the foot in its own axes from the rates of roll, pitch, yaw (z-y-x).
    (roll, pitch, _), (r, p, y) = m.angle.T, m.rate.T
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    return np.column_stack([r - y * sp, p * cr + y * cp * sr, y * cp * cr - p * sr])
