"""How a carried sensor moves: the body along the way, the arm at the body, the hand at the arm, as splines of the fifth degree in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

from bematist.frames import conjugate, multiply, quaternion_from_rotation_vector, rotate
from bematist.simulate.carry import Walker
from bematist.simulate.handling import RATE_HZ, in_the_hand, smoothed
from bematist.simulate.motion import State
from bematist.simulate.paces import Route
from bematist.simulate.parameters import Scenario

Array = NDArray[np.float64]

_BODY_S, _TURN_S = 0.45, 0.9
"""How long the body takes to change its speed, and to turn, s."""


@dataclass(frozen=True, eq=False)
class HandMotion:
    """A carried sensor as a function of time. What it did between the instants of the splines is what the splines say.

    Attributes
    ----------
    route : where the walk leads, and its steps.
    walker : who walks.
    """

    route: Route
    walker: Walker
    _sensor: BSpline
    _body: BSpline

    @property
    def scenario(self) -> Scenario:
        return self.route.scenario

    @property
    def duration_s(self) -> float:
        return self.route.duration_s

    @property
    def along(self) -> Array:
        """(K+1,) m, the ends of the steps along the path, the first its beginning."""
        return self.route.steps.along

    def places(self, along: Array) -> tuple[Array, Array]:
        """Places (K,3), m, and directions (K,), rad, of the path in ENU at the distances (K,), m."""
        return self.route.at(along)

    def travelled(self, time: Array) -> Array:
        """Distance along the path (K,), m, at the times (K,), s."""
        return self.route.steps.along_at(time)

    def still(self, begin: Array, end: Array) -> NDArray[np.bool_]:
        """Whether nothing moves from `begin` to `end` (K,), s: never for certain."""
        return np.zeros(np.broadcast(begin, end).shape, bool)

    def body(self, time: Array) -> tuple[Array, Array]:
        """Place of the body over the ground (K,3), m, and its direction of walking (K,), rad, at the times (K,), s."""
        found = self._body(time)
        return found[:, :3], found[:, 3]

    def at(self, time: Array) -> State:
        """Position, velocity, acceleration, attitude and angular rate of the sensor at the times (K,), s."""
        p, v, a = (self._sensor(time, nu) for nu in range(3))
        q, w = _turning(p[:, 3:], v[:, 3:])
        return State(p[:, :3], v[:, :3], a[:, :3], q, w)

    def signals(self, time: Array) -> tuple[Array, Array]:
        """Specific force (K,3), m/s², and angular rate (K,3), rad/s, in the sensor's axes at the times (K,), s.

        Against the stars: where the Earth turns, its rate Ω is in the angular rate, and 2 Ω × v in the specific force.
        """
        state = self.at(time)
        earth, to_body = np.array(self.scenario.earth_rate), conjugate(state.attitude)
        force = state.acceleration + np.array([0.0, 0.0, self.scenario.gravity]) + 2 * np.cross(earth, state.velocity)
        return rotate(to_body, force), state.angular_rate + rotate(to_body, np.broadcast_to(earth, force.shape))


def _turning(s: Array, speed: Array) -> tuple[Array, Array]:
    # Attitude q = s/|s| and its rate 2 Im(q* ⊗ q̇); what q̇ has along q is real there.
    size = np.linalg.norm(s, axis=1, keepdims=True)
    q = s / size
    return q, 2 * multiply(conjugate(q), speed / size)[:, 1:]


def carried(route: Route, walker: Walker, rng: np.random.Generator) -> HandMotion:
    """The movement of a sensor that a walker carries along a route. ENU; the origin is on the ground under the body at the start."""
    time = np.arange(int(np.ceil(route.duration_s * RATE_HZ)) + 1) / RATE_HZ
    place, yaw = route.at(smoothed(route.steps.along_at(time), _BODY_S))
    place, yaw = smoothed(place, _BODY_S), smoothed(yaw, _TURN_S)
    hand, turned = in_the_hand(route, walker, time, rng)
    facing = quaternion_from_rotation_vector(np.column_stack([0 * time, 0 * time, yaw]))
    attitude = multiply(facing, turned)
    # One sign for all the way.
    changes = np.append(False, (attitude[1:] * attitude[:-1]).sum(1) < 0)
    attitude *= np.where(np.cumsum(changes) % 2, -1.0, 1.0)[:, None]
    sensor = make_interp_spline(time, np.column_stack([place + rotate(facing, hand), attitude]), k=5)
    return HandMotion(route, walker, sensor, make_interp_spline(time, np.column_stack([place, yaw]), k=5))
