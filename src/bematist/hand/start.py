"""The start of a handheld recording: at rest, or in motion."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bematist.align import Alignment, InitialParameters, aim, by_field, initial_alignment, known_rotation, level, north, rest_interval
from bematist.errors import DataError
from bematist.frames import matrix_from_quaternion, multiply, quaternion_from_rotation_vector, rotate
from bematist.hand.parameters import HandParameters

Array = NDArray[np.float64]


def start(head: Array, p: HandParameters, rate_hz: float) -> Alignment:
    """The state at the first of rows (K,10).

    From a rest where there is one (MAGYQ section 4.2), else from the averages of the fields in motion. Raises DataError where specific
    force or angular rate are missing.
    """
    gap_s = p.gap.seconds(rate_hz)
    if not p.attitude.magnetic.use:
        head = head.copy()
        head[:, 7:10] = np.nan
    initial = by_field(p.initial, head[:, 7:10])
    good = np.isfinite(head[:, 1:7]).all(1)
    if not good.any() or rest_interval(head, initial, rate_hz, p.gravity)[2]:
        own = p.attitude
        a = initial_alignment(head, initial, rate_hz, p.gravity, own.noise.angle_random_walk, gap_s, own.earth_rate)
    else:
        a = _in_motion(head[good][: max(2, int(p.moving_start_s * rate_hz))], p, initial, rate_hz, gap_s)
    return a if initial is p.initial or a.field is None else replace(a, north="magnetic")


def _in_motion(rows: Array, p: HandParameters, initial: InitialParameters, rate_hz: float, gap_s: float) -> Alignment:
    """Up is the mean specific force, turned by the gyroscope into the frame of the first row: a hand does not accelerate for long."""
    dt = np.diff(rows[:, 0])
    steps = quaternion_from_rotation_vector(rows[1:, 4:7] * np.where(dt > gap_s, 0.0, dt)[:, None])
    turned = np.empty((len(rows), 4))
    turned[0] = 1.0, 0.0, 0.0, 0.0
    for k, step in enumerate(steps):
        turned[k + 1] = multiply(turned[k], step)
    up = rotate(turned, rows[:, 1:4]).mean(0)
    if not np.linalg.norm(up) > 0.1:
        raise DataError(
            "The specific force is zero at the start, so there is no direction of gravity. A sensor at rest reads 9.8 m/s²: check that the "
            "columns are the accelerometer's and that gravity was not taken out."
        )
    warnings = [
        f"No rest of {initial.shortest_s:g} s in the first seconds: the start was levelled in motion, and the gyroscope's offset is "
        "unknown. Hold still for a few seconds before walking."
    ]
    if abs(float(np.linalg.norm(up)) - p.gravity) > 0.1 * p.gravity:
        warnings.append(
            f"The specific force is {np.linalg.norm(up):.3g} m/s² on the average of the first seconds, and not {p.gravity:.3g}: is its "
            "unit m/s², and are accelerometer and gyroscope not exchanged?"
        )
    attitude = level(up)
    seen = np.isfinite(rows[:, 7:10]).all(1)
    turning = matrix_from_quaternion(attitude) @ matrix_from_quaternion(turned[seen]).mean(0) if seen.any() else np.zeros((3, 3))
    field = matrix_from_quaternion(attitude) @ rotate(turned[seen], rows[seen, 7:10]).mean(0) if seen.any() else None
    attitude, turn = aim(attitude, up, field, initial, warnings)
    duration = float(rows[-1, 0] - rows[0, 0])
    # Speeds at both ends differ by about a walk's; the gyroscope's offset turned the mean by half of what it does in all.
    drift = 0.5 * initial.gyro_bias_sd * duration
    return Alignment(
        attitude=attitude,
        gyro_bias=np.zeros(3),
        gyro_bias_sd=initial.gyro_bias_sd,
        tilt_sd=math.hypot(initial.tilt_sd, math.hypot(1.0 / (p.gravity * max(duration, 0.1)), drift)),
        velocity_sd=1.5,
        rest=(0, 0),
        field=turn @ field if field is not None else None,
        field_from=turn @ turning,
        earth_rate=known_rotation(p.attitude.earth_rate, north(initial, field)),
        warnings=tuple(warnings),
        north=north(initial, field),
        rate_hz=rate_hz,
        gravity=p.gravity,
    )
