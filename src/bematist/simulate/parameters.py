"""What is walked (`Scenario`) and with what it is measured (`Sensor`): parameters and presets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field

from bematist.earth import STANDARD_GRAVITY, normal_gravity
from bematist.errors import UsageError
from bematist.parameters import Parameters

Point = tuple[float, float, float]

ATHENS_LATITUDE_RAD = math.radians(37.98)


class ParkedCars(Parameters):
    """Cars parked on both sides of a stretch of the path, each a magnetic dipole."""

    from_m: float = Field(description="Where the stretch begins, m along the path.", ge=0)
    to_m: float = Field(description="Where it ends, m along the path.", ge=0)
    spacing_m: float = Field(default=2.7, description="Distance between neighbours, m.", gt=0)
    away_m: float = Field(default=2.0, description="Distance of the dipoles from the path, m. Nearer disturbs more (cube).", gt=0.5)
    height_m: float = Field(default=0.5, description="Height of the dipoles above the path, m.")
    moment: float = Field(default=300.0, description="Root mean square magnetic moment of a car, A·m².", ge=0)


class Scenario(Parameters):
    """A walk of one shoe. Lengths in m along the path; the frame is ENU with its origin at the sensor at the start."""

    name: str = Field(default="", description="Name, for messages.")
    waypoints: tuple[Point, ...] = Field(description="Corners of the path, m; its first leg is turned to `heading_deg`.", min_length=2)
    length_m: float | None = Field(default=None, description="Length the path is scaled to, m; as drawn when absent.", gt=0)
    corner_radius_m: float = Field(default=1.0, description="Radius of the rounded corners, m; smaller where legs are short.", gt=0)
    heading_deg: float = Field(default=90.0, description="Heading of the first leg, degrees clockwise from North.")
    stride_m: float = Field(default=1.3, description="Length of a stride, m; fitted so that the path is a whole number of strides.", gt=0.1)
    swing_s: float = Field(default=0.86, description="Time from heel-off to foot flat, s. Less makes larger accelerations.", gt=0.1)
    stance_s: float = Field(default=0.3, description="Time the foot is flat, s.", gt=0.05)
    variation: float = Field(default=0.03, description="Standard deviation of stride lengths and times, relative.", ge=0, le=0.2)
    rest_s: float = Field(default=10.0, description="Rest at the start, s.", ge=0)
    final_rest_s: float = Field(default=5.0, description="Rest at the end, s.", ge=0)
    pauses: tuple[tuple[float, float], ...] = Field(default=(), description="Stops: (m along the path, s).")
    pitch: float = Field(default=1.0, description="Pitch of the foot in swing relative to a measured stride (+63°, −26°).", ge=0, le=1.3)
    roll_deg: float = Field(default=8.0, description="Largest roll of the foot in swing, degrees.")
    clearance_m: float = Field(default=0.06, description="Largest height of the sensor in swing, m.", ge=0)
    impact_m: float = Field(default=0.001, description="Height of the jolt at heel strike, m; 0.001 is a peak of 20 m/s².", ge=0)
    rocking_deg: float = Field(default=0.0, description="How far the standing foot rocks forward and back about its toes, degrees.")
    lever_m: tuple[float, float] = Field(default=(-0.10, 0.08), description="Sensor from the toes: forward and up, m; for rocking.")
    mounting_deg: Point = Field(default=(5.0, -20.0, 0.0), description="Roll, pitch, yaw of the sensor on the flat foot, degrees.")
    gravity: float = Field(default=normal_gravity(ATHENS_LATITUDE_RAD, 150.0), description="Gravity, m/s².", gt=0)
    field_ut: float = Field(default=46.0, description="Earth's magnetic flux density, µT.", ge=0)
    inclination_deg: float = Field(default=53.0, description="Magnetic inclination, degrees below the horizon; declination is 0.")
    parked_cars: tuple[ParkedCars, ...] = Field(default=(), description="Stretches between parked cars, which bend the compass.")


class Sensor(Parameters):
    """Errors of a nine-axis sensor, the same on each axis: measured = clipped(rounded(true + bias + noise)).

    White noise is given by its density N: a sample at rate f has the standard deviation N √f, as an Allan deviation of
    N at 1 s says. Bias instability B is flicker noise, whose Allan deviation is flat at 0.664 B.
    """

    name: str = Field(default="", description="Name, for messages.")
    rate_hz: float = Field(default=238.0, description="Rate of accelerometer and gyroscope, Hz.", gt=1)
    magnetometer_rate_hz: float = Field(default=80.0, description="Rate of the magnetometer, Hz; 0 is no magnetometer.", ge=0)
    sampling: Literal["average", "instant"] = Field(
        default="average", description="A sample is the mean over the interval that ends at its time, or the value at its time."
    )
    velocity_random_walk: float = Field(default=0.0, description="Accelerometer white noise, m/s²/√Hz.", ge=0)
    angle_random_walk: float = Field(default=0.0, description="Gyroscope white noise, rad/s/√Hz.", ge=0)
    magnetic_noise_density: float = Field(default=0.0, description="Magnetometer white noise, µT/√Hz.", ge=0)
    accel_bias_instability: float = Field(default=0.0, description="m/s².", ge=0)
    gyro_bias_instability: float = Field(default=0.0, description="rad/s.", ge=0)
    accel_bias_sd: float = Field(default=0.0, description="Standard deviation of the constant turn-on bias, m/s².", ge=0)
    gyro_bias_sd: float = Field(default=0.0, description="Standard deviation of the constant turn-on bias, rad/s.", ge=0)
    magnetic_bias: Point = Field(default=(0.0, 0.0, 0.0), description="Hard iron, µT.")
    accel_range: float = Field(default=math.inf, description="Largest specific force, m/s².", gt=0)
    gyro_range: float = Field(default=math.inf, description="Largest angular rate, rad/s.", gt=0)
    magnetic_range: float = Field(default=math.inf, description="Largest flux density, µT.", gt=0)
    accel_lsb: float = Field(default=0.0, description="Quantum, m/s²; 0 is none.", ge=0)
    gyro_lsb: float = Field(default=0.0, description="Quantum, rad/s; 0 is none.", ge=0)
    magnetic_lsb: float = Field(default=0.0, description="Quantum, µT; 0 is none.", ge=0)


_G, _DEG = STANDARD_GRAVITY, math.radians(1.0)

SENSORS: dict[str, Sensor] = {
    "ideal": Sensor(name="ideal"),
    # MAGINAV Table 3, where the magnetometer's density is a hundredfold misprint and the instabilities are per
    # nothing, not
    # per hour (accelerometer); quanta from ST's data sheet DS10377 rather than range/2^15. Turn-on biases are what is
    # left
    # after a simple calibration: our choice, the paper gives none.
    "lsm9ds1": Sensor(
        name="lsm9ds1",
        velocity_random_walk=226e-6 * _G,
        angle_random_walk=0.017 * _DEG,
        magnetic_noise_density=0.079,
        accel_bias_instability=182e-6 * _G,
        gyro_bias_instability=8.63 / 3600 * _DEG,
        accel_bias_sd=3e-3 * _G,
        gyro_bias_sd=0.2 * _DEG,
        accel_range=16 * _G,
        gyro_range=2000 * _DEG,
        magnetic_range=400.0,
        accel_lsb=0.732e-3 * _G,
        gyro_lsb=70e-3 * _DEG,
        magnetic_lsb=0.014,
    ),
}
"""Sensor presets by name."""

# A closed tour between buildings: along an avenue, a zig-zag, a road crossed at right angles, a parking lot, and back.
_CAMPUS: tuple[Point, ...] = tuple(
    (float(x), float(y), 0.0)
    for x, y in (
        (0, 0), (120, 0), (120, 60), (150, 60), (153, 66), (156, 60), (159, 66), (162, 60), (165, 66), (168, 60), (230, 60),
        (230, 150), (255, 150), (255, 162), (230, 162), (230, 215), (140, 240), (60, 240), (60, 170), (100, 150), (100, 95),
        (40, 80), (-30, 110), (-60, 50), (-60, 0), (0, 0),
    )
)  # fmt: skip
_RETURN: tuple[Point, ...] = (
    (0.0, 0.0, 0.0), (20.0, 0.0, 0.0), (20.0, 9.0, 0.0), (18.0, 9.0, 0.0),
    (18.0, 2.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 0.0),
)  # fmt: skip

SCENARIOS: dict[str, Scenario] = {
    "campus": Scenario(
        name="campus",
        waypoints=_CAMPUS,
        length_m=1300.0,
        pauses=((310.0, 12.0), (345.0, 8.0)),
        parked_cars=(ParkedCars(from_m=430.0, to_m=520.0), ParkedCars(from_m=900.0, to_m=950.0)),
    ),
    "short": Scenario(name="short", waypoints=_RETURN, rest_s=10.0, final_rest_s=3.0),
    "straight": Scenario(name="straight", waypoints=((0.0, 0.0, 0.0), (100.0, 0.0, 0.0))),
}
"""Walks by name: 20 minutes around a campus, a minute there and back, and 100 m straight on."""


def resolve(scenario: str | Scenario, sensor: str | Sensor, changes: Mapping[str, Any]) -> tuple[Scenario, Sensor]:
    """Scenario and sensor with `changes` to the fields of either.

    Raises
    ------
    UsageError
        An unknown scenario, sensor or field, or a value that does not fit.
    """
    walk = scenario if isinstance(scenario, Scenario) else _known("scenario", scenario, SCENARIOS)
    device = sensor if isinstance(sensor, Sensor) else _known("sensor", sensor, SENSORS)
    of_sensor = {k: v for k, v in changes.items() if k in Sensor.model_fields and k not in Scenario.model_fields}
    of_walk = {k: v for k, v in changes.items() if k not in of_sensor}
    if unknown := set(of_walk) - set(Scenario.model_fields):
        known = ", ".join(sorted({*Scenario.model_fields, *Sensor.model_fields} - {"name"}))
        raise UsageError(f"The simulation has no parameter {', '.join(sorted(unknown))}. Known are: {known}.")
    return walk.override(of_walk) if of_walk else walk, device.override(of_sensor) if of_sensor else device


def _known(what: str, name: str, table: Mapping[str, Any]) -> Any:
    if name not in table:
        raise UsageError(f'There is no {what} "{name}": choose one of {", ".join(table)}.')
    return table[name]
