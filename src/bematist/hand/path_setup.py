"""From parameters to what the path kernels start from."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bematist.align import Alignment
from bematist.frames import conjugate, matrix_from_quaternion, multiply, quaternion_from_euler, rotate, yaw_from_heading_deg
from bematist.hand.path_parameters import Axis, HandPdrParameters
from bematist.kernels import pdr_layout as at
from bematist.kernels.pdr import STRIDE_HZ
from bematist.steps import CARRYING

Array = NDArray[np.float64]

_KELVIN = 273.15


def axis(name: Axis) -> Array:
    """The unit vector (3,) of a body axis."""
    v = np.zeros(3)
    v["xyz".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
    return v


def right(ahead: Axis, carrying: str) -> Array:
    """The body axis (3,) that points to the right where the other points ahead and the way of carrying has an end up.

    The screen is up where it is read and in a swinging hand, the upper edge (y) at the ear, in pocket and bag. Where that is the axis
    ahead, it is the other way round.
    """
    up = axis("z" if carrying in ("texting", "swinging") else "y")
    if abs(axis(ahead) @ up) > 0:
        up = axis("y" if up[2] else "z")
    return np.cross(axis(ahead), up)


def workspace(p: HandPdrParameters) -> Array:
    """The state before the first step, whose length would be that of a usual walk."""
    W = np.zeros(at.WORKSPACE_SIZE)
    length = p.step_length
    W[at.DIRECTION_E] = 1.0
    W[at.LENGTH] = max(0.0, length.height * (length.a * STRIDE_HZ + length.b) + length.c)
    P = W[at.P : at.P + at.WIDTH**2].reshape(at.WIDTH, at.WIDTH)
    P[at.E_SCALE, at.E_SCALE] = p.step_length.scale_sd**2
    P[at.E_DIRECTION, at.E_DIRECTION] = p.direction.sd**2
    return W


def kernel_parameters(p: HandPdrParameters, gap_s: float) -> Array:
    """The parameters that the kernels read (`kernels.pdr_layout`)."""
    length, direction, height = p.step_length, p.direction, p.altitude
    prm = np.zeros(at.PARAMETERS)
    values = {
        at.HEIGHT: length.height,
        at.A: length.a,
        at.B: length.b,
        at.C: length.c,
        at.RUNNING_FACTOR: length.running_factor,
        at.TREAD: length.tread,
        at.STEP_VAR: length.sd**2,
        at.SCALE_VAR: length.scale_sd**2,
        at.TURN_VAR: direction.step_sd**2,
        at.DIRECTION_VAR: direction.sd**2,
        at.DIRECTION_S: direction.time_s,
        at.HEADING_S: direction.heading_time_s,
        at.HEADING_FIXED: direction.heading_sd**2 if p.attitude.correction == "replace" else -1.0,
        at.SWAY_VAR: p.sway_speed**2,
        at.FLAT_VAR: height.unknown**2,
        at.BARO_USE: height.barometer,
        at.BARO_VAR: height.sd**2,
        at.BARO_WALK: height.walk**2,
        at.CLIMB_PSD: height.climb**2,
        at.TEMPERATURE: height.temperature_c + _KELVIN,
        at.G: p.gravity,
        at.GAP_S: gap_s,
        at.STEEP: math.cos(direction.steep),
        at.OFFSET_COS: math.cos(direction.offset),
        at.OFFSET_SIN: math.sin(direction.offset),
        at.PENDULUM: length.pendulum,
        at.ONSET_VAR: p.onset_speed**2,
    }
    prm[list(values)] = list(values.values())
    for k, name in enumerate(CARRYING):
        ahead = getattr(direction, name)
        prm[at.AXES + 6 * k : at.AXES + 6 * k + 6] = [*axis(ahead), *right(ahead, name)]
    return prm


def ahead(q: Array, p: HandPdrParameters) -> float:
    """Direction (yaw, rad) in which the pointing axis of the start looks at an attitude (4,), by the same rule as the kernel."""
    first = p.direction.first
    name = getattr(p.direction, first)
    d = rotate(q, axis(name))
    if math.hypot(d[0], d[1]) < math.cos(p.direction.steep):
        r = rotate(q, right(name, first))
        d = np.array([-r[1], r[0], 0.0])
    return math.atan2(d[1], d[0]) + p.direction.offset


def pointed(a: Alignment, p: HandPdrParameters) -> Alignment:
    """An alignment whose given heading, or East where there is none, is that of the pointing axis instead of the sensor's x axis."""
    heading = p.initial.heading_deg
    if a.north in ("magnetic", "true"):
        return a
    wanted = 0.0 if heading is None else float(yaw_from_heading_deg(heading))
    turn = quaternion_from_euler(0.0, 0.0, wanted - ahead(a.attitude, p))
    C = matrix_from_quaternion(turn)
    field = None if a.field is None else C @ a.field
    attitude = multiply(turn, a.attitude)
    # What the gyroscope reads at rest is its offset and the Earth's rotation, which points elsewhere in the body now.
    moved = rotate(conjugate(a.attitude), a.earth_rate) - rotate(conjugate(attitude), a.earth_rate)
    return replace(a, attitude=attitude, field=field, field_from=C @ a.field_from, gyro_bias=a.gyro_bias + moved)
