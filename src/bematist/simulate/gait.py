"""How a shoe moves along a path: footprints in time, and between them a swing with analytic derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from bematist.frames import conjugate, multiply, quaternion_from_euler, rotate
from bematist.simulate.parameters import Scenario
from bematist.simulate.path import scaled

Array = NDArray[np.float64]

# Shape of a swing at every twentieth of the time u from heel-off (0) to foot flat (1), ends left out: the median
# stride of a walk in a motion capture room, sensor on the instep. Pitch in rad (positive: toes down), forward and up in
# shares of the stride and of the clearance.
# fmt: off
_PITCH = (
    0.04, 0.10, 0.21, 0.42, 0.78, 1.05, 1.12, 0.99, 0.81, 0.59,
    0.32, 0.06, -0.18, -0.36, -0.46, -0.43, -0.33, -0.15, -0.04,
)
_FORWARD = (
    0.003, 0.009, 0.019, 0.037, 0.067, 0.105, 0.161, 0.241, 0.333, 0.436,
    0.543, 0.654, 0.758, 0.845, 0.910, 0.944, 0.966, 0.986, 0.997,
)
_UP = (
    0.00, 0.02, 0.04, 0.05, 0.00, 0.10, 0.56, 0.93, 0.92, 0.77,
    0.56, 0.43, 0.48, 0.73, 1.00, 0.87, 0.57, 0.26, 0.06,
)
# fmt: on

IMPACT = 0.80
"""When in the swing the heel strikes."""
IMPACT_S = 0.04
"""How long the jolt of the strike lasts, s."""


@dataclass(frozen=True)
class Shape:
    """A swing as polynomials; value and three derivatives vanish at both ends (forward and turn: the value ends at 1).

    They are polynomials in y = 2u − 1: powers of u itself would lose six digits at the end of the swing.
    """

    pitch: Polynomial
    forward: Polynomial
    up: Polynomial
    turn: Polynomial
    bump: Polynomial


@cache
def walking() -> Shape:
    """The shape of a walking swing."""
    u = Polynomial([0.5, 0.5])
    step = (Polynomial([0, 0, 0, 0, 35.0, -84.0, 70.0, -20.0]))(u)
    bump = Polynomial([1.0, 0, -1.0]) ** 4

    def through(values: tuple[float, ...], base: Polynomial, order: int) -> Polynomial:
        y = np.linspace(-1, 1, len(values) + 2)[1:-1]
        c = np.linalg.lstsq(bump(y)[:, None] * np.vander(y, order, increasing=True), values - base(y))[0]
        return base + bump * Polynomial(c)

    zero = Polynomial([0.0])
    return Shape(through(_PITCH, zero, 9), through(_FORWARD, step, 7), through(_UP, zero, 9), step, bump)


@dataclass(frozen=True, eq=False)
class State:
    """Truth at instants (K rows): the sensor in ENU, and its angular rate in its own axes. SI."""

    position: Array
    velocity: Array
    acceleration: Array
    attitude: Array
    angular_rate: Array


@dataclass(frozen=True, eq=False)
class Motion:
    """A walk as a function of time.

    Attributes
    ----------
    edges : (2K+2,) s; the foot is flat from edges[2k] to edges[2k+1], on footprint k, then swings until edges[2k+2].
    footprint : (K+1,3) m.
    yaw : (K+1,) rad, direction of the foot, unwrapped.
    scenario : what it was made of.
    """

    edges: Array
    footprint: Array
    yaw: Array
    scenario: Scenario

    @property
    def duration_s(self) -> float:
        return float(self.edges[-1])

    def standing(self, time: Array) -> NDArray[np.bool_]:
        """Whether the foot is flat (K,) at the times (K,), s."""
        return np.searchsorted(self.edges[1:-1], time) % 2 == 0

    def at(self, time: Array) -> State:
        """Position, velocity, acceleration, attitude and angular rate at the times (K,), s, in order."""
        piece = np.searchsorted(self.edges[1:-1], time)
        k, swings = piece // 2, piece % 2 == 1
        n = len(time)
        p, v, a = self.footprint[k], np.zeros((n, 3)), np.zeros((n, 3))
        # Roll, pitch, yaw of the foot and their rates.
        angle, rate = np.zeros((n, 3)), np.zeros((n, 3))
        angle[:, 2] = self.yaw[k]
        self._swing(np.flatnonzero(swings), time, k, p, v, a, angle, rate)
        if self.scenario.rocking_deg:
            self._rock(np.flatnonzero(~swings), time, k, p, v, a, angle, rate)
        mounting = quaternion_from_euler(*np.radians(self.scenario.mounting_deg))
        q = multiply(quaternion_from_euler(*angle.T), mounting)
        return State(p, v, a, q, rotate(conjugate(mounting), _body_rate(angle, rate)))

    def _swing(self, i: NDArray[np.int64], time: Array, k: NDArray[np.int64], *state: Array) -> None:
        p, v, a, angle, rate = state
        shape, s = walking(), self.scenario
        k = k[i]
        begin = self.edges[2 * k + 1]
        T = self.edges[2 * k + 2] - begin
        u = (time[i] - begin) / T
        stride, turn = self.footprint[k + 1] - self.footprint[k], self.yaw[k + 1] - self.yaw[k]
        # A short stride lifts and pitches the foot less.
        full = np.minimum(1.0, np.linalg.norm(stride, axis=1) / s.stride_m)
        x, x1, x2 = _derivatives(shape.forward, u, T)
        p[i], v[i], a[i] = p[i] + x[:, None] * stride, x1[:, None] * stride, x2[:, None] * stride
        w = np.clip((u - IMPACT) * T / IMPACT_S, 0.0, 1.0)
        lift = zip(_derivatives(shape.up, u, T), _derivatives(shape.bump, w, IMPACT_S), strict=True)
        for target, (up, jolt) in zip((p, v, a), lift, strict=True):
            target[i, 2] += s.clearance_m * full * up + s.impact_m * jolt
        for axis, polynomial, size in (
            (0, shape.bump, np.radians(s.roll_deg) * full),
            (1, shape.pitch, s.pitch * full),
            (2, shape.turn, turn),
        ):
            value, first, _ = _derivatives(polynomial, u, T, order=1)
            angle[i, axis] += size * value
            rate[i, axis] = size * first

    def _rock(self, i: NDArray[np.int64], time: Array, k: NDArray[np.int64], *state: Array) -> None:
        # The foot pitches by b(u) about its toes; the sensor, a lever away, goes with it. Rests do not rock.
        p, v, a, angle, rate = state
        still = (k[i] == 0) | (k[i] == len(self.footprint) - 1)
        i = i[~still]
        k = k[i]
        begin = self.edges[2 * k]
        T = self.edges[2 * k + 1] - begin
        b = [np.radians(self.scenario.rocking_deg) * d for d in _derivatives(walking().bump, (time[i] - begin) / T, T)]
        forward, up = self.scenario.lever_m
        c, s = np.cos(b[0]), np.sin(b[0])
        along, rise = forward * c + up * s, up * c - forward * s
        # d/dθ (along, rise) = (rise, −along)
        track = np.column_stack([np.cos(self.yaw[k]), np.sin(self.yaw[k])])
        for target, x, z in (
            (p, along - forward, rise - up),
            (v, rise * b[1], -along * b[1]),
            (a, rise * b[2] - along * b[1] ** 2, -along * b[2] - rise * b[1] ** 2),
        ):
            target[i, :2] += x[:, None] * track
            target[i, 2] += z
        angle[i, 1], rate[i, 1] = b[0], b[1]


def _derivatives(polynomial: Polynomial, u: Array, T: Array | float, order: int = 2) -> tuple[Array, Array, Array]:
    # Value and time derivatives; a value that is not asked for is not computed.
    y, speed = 2 * u - 1, 2 / T
    second = polynomial.deriv(2)(y) * (speed * speed) if order > 1 else y
    return polynomial(y), polynomial.deriv()(y) * speed, second


def _body_rate(angle: Array, rate: Array) -> Array:
    # Angular rate of the foot in its own axes from the rates of roll, pitch, yaw (z-y-x).
    (roll, pitch, _), (r, p, y) = angle.T, rate.T
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    return np.column_stack([r - y * sp, p * cr + y * cp * sr, y * cp * cr - p * sr])


def walk(scenario: Scenario, rng: np.random.Generator) -> Motion:
    """The walk of a scenario: footprints a stride apart, the first and the last stride half as long, each a little
    varied.
    """
    path = scaled(scenario.waypoints, scenario.corner_radius_m, scenario.length_m)
    strides = max(2, round(path.length_m / scenario.stride_m) + 1)

    def varied(n: int) -> Array:
        return 1 + scenario.variation * np.clip(rng.standard_normal(n), -2.5, 2.5)

    part = varied(strides)
    part[[0, -1]] *= 0.5
    along = np.concatenate([[0.0], part.cumsum()])
    along *= path.length_m / along[-1]
    place, yaw = path.at(along)
    swing, flat = scenario.swing_s * varied(strides), scenario.stance_s * varied(strides + 1)
    swing[[0, -1]] *= 0.85
    for where, seconds in scenario.pauses:
        flat[min(np.searchsorted(along, where), strides)] += seconds
    flat[0], flat[-1] = scenario.rest_s, scenario.final_rest_s
    times = np.empty(2 * strides + 1)
    times[0::2], times[1::2] = flat, swing
    edges = np.concatenate([[0.0], times.cumsum()])
    # Turn the first leg to its heading, and put the origin at the start.
    first = np.radians(90.0 - scenario.heading_deg) - yaw[0]
    c, s = np.cos(first), np.sin(first)
    place = (place - place[0]) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return Motion(edges, place, yaw + first, scenario)
