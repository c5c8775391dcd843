"""Initial alignment: where the foot rests, which way is up, which way is north, and what the gyroscope reads at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from bematist.errors import DataError
from bematist.frames import (
    conjugate,
    matrix_from_quaternion,
    multiply,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    yaw_from_heading_deg,
)
from bematist.intervals import intervals
from bematist.parameters import Parameters
from bematist.stance import StanceParameters, detect

Array = NDArray[np.float64]

ENOUGH_S = 2.0
"""A rest this long is good enough not to look for a longer one."""


class RestParameters(Parameters):
    """The rest at the start: its average levels the sensor, gives the gyroscope's offset and the undisturbed field."""

    longest_s: float = Field(
        default=10.0, gt=0, description="At most this much of the start is looked at, s; a live filter answers from then on."
    )
    shortest_s: float = Field(default=0.3, gt=0, description="A shorter rest, s, is not averaged for the gyroscope's offset.")
    rest_statistic: float = Field(
        default=5.0, gt=0, description="At rest while the SHOE statistic over 0.1 s stays below this; larger allows more sway."
    )
    average: bool = Field(
        default=True,
        description="Average over the rest. False: level and take the field from its first sample, as MAGINAV eqs 4 and 11 do, and start "
        "with no gyroscope offset.",
    )
    sway: float = Field(
        default=math.radians(0.1),
        ge=0,
        description="How far a standing foot turns, rad: over a rest of T seconds the gyroscope's offset is known to this over T.",
    )
    gyro_bias_sd: float = Field(default=math.radians(1.0), ge=0, description="Gyroscope offset before the rest, rad/s.")
    heading_deg: float | None = Field(
        default=None,
        description="Heading of the sensor's x axis at the start, degrees clockwise from North; none: see `earth_field`.",
    )
    earth_field: tuple[float, float, float] | None = Field(
        default=None,
        description="Earth's field, µT, East, North, Up (`--origin` fills it in): with it and a magnetometer the start is aligned to true "
        "North by TRIAD. Without it and without `heading_deg` the sensor's x axis starts along East.",
    )


class InitialParameters(RestParameters):
    """The rest at the start, and how well it aligns a filter that knows its own uncertainty."""

    tilt_sd: float = Field(
        default=math.radians(1.0),
        ge=0,
        description="Tilt after levelling on a rest, rad, apart from what the accelerometer's offset explains.",
    )
    accel_bias_sd: float = Field(default=0.05, ge=0, description="Accelerometer offset before the first update, m/s².")
    gravity_from: Literal["parameter", "rest"] = Field(
        default="parameter",
        description="parameter: gravity is the parameter `gravity`. rest: the length of the mean specific force over the rest at the "
        "start, where there is one; the accelerometer's scale and its offset along gravity are then in it.",
    )


class FieldGates(Protocol):
    """How far a field may differ from the undisturbed one: in norm, relative, and in inclination, rad."""

    @property
    def norm_tolerance(self) -> float: ...
    @property
    def inclination_tolerance(self) -> float: ...


@dataclass(frozen=True, eq=False)
class Alignment:
    """The state at the first sample.

    attitude (4,) wxyz at the first sample; gyro_bias (3,) rad/s with gyro_bias_sd; tilt_sd rad; velocity_sd m/s; rest: first and
    one-past-last row of the rest that was averaged; field (3,) µT in ENU averaged over the rest, or None; field_from (3,3): what turned the
    magnetometer's readings into it, on the average; earth_rate (3,) rad/s: the part of the Earth's rotation whose direction is known,
    only that about Up where North is not; warnings; north: what North is, "magnetic", "true" (by the Earth's field), "given" (by a
    heading) or "none" (the sensor's x axis starts along East); rate_hz: of the samples; gravity m/s² (`initial.gravity_from`).
    """

    attitude: Array
    gyro_bias: Array
    gyro_bias_sd: float
    tilt_sd: float
    velocity_sd: float
    rest: tuple[int, int]
    field: Array | None
    field_from: Array
    earth_rate: Array
    warnings: tuple[str, ...]
    north: str
    rate_hz: float
    gravity: float


MAGNETIC_NORTH = (0.0, 1.0, 0.0)
"""Earth's field where none is given: its horizontal part points North."""


def level(specific_force: Array) -> Array:
    """Attitude (4,) whose up is along the mean specific force (3,) and whose x axis points East in plan.

    Where x stands upright within 20 degrees, y points North instead.
    """
    up = specific_force / np.linalg.norm(specific_force)
    axis = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < math.cos(math.radians(20)) else None
    if axis is not None:
        east = axis - up * (axis @ up)
        east /= np.linalg.norm(east)
        north = np.cross(up, east)
    else:
        axis = np.array([0.0, 1.0, 0.0])
        north = axis - up * (axis @ up)
        north /= np.linalg.norm(north)
        east = np.cross(north, up)
    return quaternion_from_matrix(np.stack([east, north, up]))


def triad(a1: Array, b1: Array, a2: Array, b2: Array) -> Array:
    """Rotation R (3,3) with a2 = R a1 exactly and b2 = R b1 as nearly as a1 allows; vectors (3,) of any length.

    MAGINAV eq 10 and Appendix A (erratum: the inputs must be unit vectors).

    Raises
    ------
    DataError
        The two vectors of a pair are parallel.
    """

    def base(a: Array, b: Array) -> Array:
        a = a / np.linalg.norm(a)
        n = np.cross(a, b)
        length = float(np.linalg.norm(n))
        if not length > 1e-9 * float(np.linalg.norm(b)):
            raise DataError(
                "TRIAD needs two directions, but the magnetic field is parallel to gravity here (or zero). Give the heading instead."
            )
        n = n / length
        return np.stack([a, n, np.cross(a, n)], 1)

    return base(a2, b2) @ base(a1, b1).T


def rest_interval(rows: Array, parameters: InitialParameters, rate_hz: float, gravity: float) -> tuple[int, int, bool]:
    """First and one-past-last row of the first good rest, and whether it is one; else the quietest tenth of a second."""
    detector = StanceParameters(window_s=0.1)
    statistic = detect(rows, detector, rate_hz, gravity=gravity)[:, 0]
    still = statistic < parameters.rest_statistic
    edges = intervals(still)
    long_enough = rows[edges[:, 1] - 1, 0] - rows[edges[:, 0], 0] >= parameters.shortest_s
    if long_enough.any():
        # The first that is nearly as good as the longest: a knock must not cut the rest short, nor a rest at the end of a short walk win.
        length = edges[:, 1] - edges[:, 0]
        first, last = edges[np.argmax(length >= min(0.5 * length.max(), ENOUGH_S * rate_hz))]
        # The window reaches over the edge of the rest by half its length.
        half = detector.window_samples(rate_hz) // 2
        if last < len(rows) and last - first > 4 * half:
            last -= half
        return int(first), int(last), True
    n = max(1, round(0.1 * rate_hz))
    finite = np.where(np.isfinite(statistic), statistic, 1e12)
    sums = np.convolve(finite, np.ones(min(n, len(finite))), "valid")
    first = int(np.argmin(sums))
    return first, min(first + n, len(rows)), False


def initial_alignment(
    rows: Array,
    parameters: InitialParameters,
    rate_hz: float,
    gravity: float,
    angle_random_walk: float,
    gap_s: float,
    earth_rate: tuple[float, float, float] | None = None,
) -> Alignment:
    """Level, aim and calibrate on the rest at the start of sample rows (K,10), the first `longest_s` of a recording.

    A recording that begins in motion is levelled on its quietest tenth of a second, and turned back from there by the gyroscope; steps
    longer than `gap_s` are gaps, in which nothing is known to turn. `earth_rate` (rad/s, East, North, Up) is no offset of the gyroscope:
    what it reads at rest is freed of it.

    Raises
    ------
    DataError
        There is no sample with both specific force and angular rate, or the specific force is zero.
    """
    first, last, resting = rest_interval(rows, parameters, rate_hz, gravity)
    if not parameters.average:
        last = _one_of_each(rows, first, last)
    f, w = rows[first:last, 1:4], rows[first:last, 4:7]
    f, w = f[np.isfinite(f).all(1)], w[np.isfinite(w).all(1)]
    if not len(f) or not len(w):
        raise DataError(
            "No specific force or no angular rate in the first seconds: without both the start cannot be levelled. Cut the recording to "
            "where both sensors work."
        )
    up = f.mean(0)
    if not np.linalg.norm(up) > 0.1:
        raise DataError(
            "The specific force is zero at the start, so there is no direction of gravity. A sensor at rest reads 9.8 m/s²: check that the "
            "columns are the accelerometer's and that gravity was not taken out."
        )
    duration = float(rows[last - 1, 0] - rows[first, 0])
    warnings: list[str] = []
    if abs(float(np.linalg.norm(up)) - gravity) > 0.1 * gravity:
        warnings.append(
            f"The specific force is {np.linalg.norm(up):.3g} m/s² where the foot is quietest, and not {gravity:.3g}: is its unit m/s², and "
            "are accelerometer and gyroscope not exchanged?"
        )
    attitude = level(up)
    field = _mean_field(rows[first:last], matrix_from_quaternion(attitude))
    attitude, turn = aim(attitude, up, field, parameters, warnings)
    field = turn @ field if field is not None else None
    earth = known_rotation(earth_rate, north(parameters, field))
    turning = matrix_from_quaternion(attitude).T @ earth
    prior = parameters.gyro_bias_sd**2
    bias, variance = np.zeros(3), prior
    if resting and parameters.average:
        measured = angle_random_walk**2 / duration + (parameters.sway / duration) ** 2
        gain = prior / (prior + measured) if prior > 0 else 0.0
        bias, variance = gain * (w.mean(0) - turning), (1 - gain) * prior
        if rows[first, 0] - rows[0, 0] > 0.5:
            warnings.append(
                f"The first good rest, at {rows[first, 0] - rows[0, 0]:.1f} s, was used for the start, and the attitude "
                "turned back from there by the gyroscope. Stand still before walking."
            )
        if prior > 0 and np.linalg.norm(w.mean(0)) > 3 * parameters.gyro_bias_sd:
            warnings.append(
                f"The gyroscope reads {math.degrees(float(np.linalg.norm(w.mean(0)))):.1f} deg/s at rest: the rest may be none, or the "
                "gyroscope's offset is large or its unit wrong."
            )
    else:
        warnings.append(
            f"No rest of {parameters.shortest_s:g} s in the first {rows[-1, 0] - rows[0, 0]:.1f} s: the start was levelled on the "
            "quietest moment and the gyroscope's offset is unknown. Stand still for a few seconds before walking."
        )
    moving_start = not resting or rows[first, 0] - rows[0, 0] > 0.1
    return Alignment(
        attitude=_turn_back(attitude, rows[: first + 1], bias + turning, gap_s),
        gyro_bias=bias,
        gyro_bias_sd=math.sqrt(variance),
        tilt_sd=parameters.tilt_sd * (1.0 if resting else 3.0),
        velocity_sd=1.5 if moving_start else 0.0,
        rest=(first, last),
        field=field,
        field_from=matrix_from_quaternion(attitude),
        earth_rate=earth,
        warnings=tuple(warnings),
        north=north(parameters, field),
        rate_hz=rate_hz,
        gravity=float(np.linalg.norm(up)) if resting and parameters.gravity_from == "rest" else gravity,
    )


def north(parameters: InitialParameters, field: Array | None) -> str:
    """What North is (`Alignment.north`) after a start with this field (3,) or without one, by the parameters as the user gave them."""
    if parameters.heading_deg is not None:
        return "given"
    return "true" if parameters.earth_field is not None and field is not None else "none"


def by_field(parameters: InitialParameters, field: Array) -> InitialParameters:
    """Parameters that let the field (K,3) at the start be North, where it has a sample and no other North is given: else as they are."""
    seen = np.square(field).sum(1) > 0  # neither missing nor of a dead sensor
    if parameters.heading_deg is not None or parameters.earth_field is not None or not seen.any():
        return parameters
    return parameters.override({"earth_field": MAGNETIC_NORTH})


def _one_of_each(rows: Array, first: int, last: int) -> int:
    """End of the shortest part of a rest, from its beginning, with a sample of each sensor that has one in the rest."""
    found = [np.isfinite(rows[first:last, c : c + 3]).all(1) for c in (1, 4, 7)]
    return first + 1 + max(int(np.argmax(ok)) for ok in found)


def _mean_field(rows: Array, C: Array) -> Array | None:
    """Mean magnetic field over a rest, turned by C (3,3); None without a sample."""
    m = rows[:, 7:10]
    m = m[np.isfinite(m).all(1)]
    return C @ m.mean(0) if len(m) else None


def known_rotation(earth_rate: tuple[float, float, float] | None, points: str) -> Array:
    """The part of the Earth's rotation (3,), rad/s, whose direction is known in n, by what North is, `Alignment.north`."""
    east, northward, up = earth_rate or (0.0, 0.0, 0.0)
    return np.array([east, northward, up] if points != "none" else [0.0, 0.0, up])


def aim(attitude: Array, up: Array, field: Array | None, parameters: InitialParameters, warnings: list[str]) -> tuple[Array, Array]:
    """Give a levelled attitude its heading; also the turn about up (3,3) that did it."""
    yaw = 0.0
    if parameters.heading_deg is not None:
        yaw = float(yaw_from_heading_deg(parameters.heading_deg))
    elif parameters.earth_field is not None:
        if field is None:
            warnings.append("Earth's field was given but the magnetometer has no sample in the first rest: the heading starts at East.")
        else:
            C = matrix_from_quaternion(attitude)
            aimed = triad(up, C.T @ field, np.array([0.0, 0.0, 1.0]), np.array(parameters.earth_field))
            turn = aimed @ C.T
            yaw = math.atan2(turn[1, 0], turn[0, 0])
    q = quaternion_from_rotation_vector(np.array([0.0, 0.0, yaw]))
    return multiply(q, attitude), matrix_from_quaternion(q)


def undisturbed(parameters: InitialParameters, measured: Array | None) -> Array | None:
    """The undisturbed field (3,), µT: the Earth's where it is given, else the mean over the start.

    MAGINAV eq 4 (erratum: averaged over the rest, not one sample), MAGYQ section 4.2. Where the heading is given, the field points as it
    did at the start.
    """
    if parameters.earth_field is None:
        return measured
    earth = np.array(parameters.earth_field)
    if parameters.heading_deg is not None and measured is not None:
        earth[:2] = measured[:2] * math.hypot(*earth[:2]) / max(math.hypot(*measured[:2]), 1e-12)
    return earth


def disagreement(measured: Array, earth: Array, gates: FieldGates) -> list[str]:
    """A warning where the field at the start (3,) would not pass the gates of the Earth's (3,); nothing where it does. µT, ENU."""
    norms = [float(np.linalg.norm(m)) for m in (measured, earth)]
    dips = [math.degrees(math.atan2(-m[2], math.hypot(m[0], m[1]))) for m in (measured, earth)]
    near = abs(norms[0] - norms[1]) <= gates.norm_tolerance * norms[1]
    if near and abs(dips[0] - dips[1]) <= math.degrees(gates.inclination_tolerance):
        return []
    return [
        f"The magnetic field at the start is {norms[0]:.1f} µT, {dips[0]:.1f}° below the horizon, and the Earth's is {norms[1]:.1f} µT, "
        f"{dips[1]:.1f}°: the place is disturbed or the magnetometer not calibrated, and the heading at the start may be wrong by as much. "
        "Samples that do not look like the Earth's field are not used."
    ]


def _turn_back(attitude: Array, rows: Array, bias: Array, gap_s: float) -> Array:
    """Attitude at the first of rows (K,10) from the attitude at the last, by the gyroscope, whose missing values are held backwards."""
    good = np.isfinite(rows[:, 4:7]).all(1)
    if len(rows) < 2 or not good.any():
        return attitude
    following = np.minimum.accumulate(np.where(good, np.arange(len(rows)), len(rows))[::-1])[::-1]
    w = rows[np.minimum(following, np.flatnonzero(good)[-1]), 4:7] - bias
    dt = np.diff(rows[:, 0])
    for q in quaternion_from_rotation_vector(w[1:] * np.where(dt > gap_s, 0.0, dt)[:, None])[::-1]:
        attitude = multiply(attitude, conjugate(q))
    return attitude / np.linalg.norm(attitude)
