"""What is walked (`Scenario`) and with what it is measured (`Sensor`): parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any, Literal

from pydantic import Field, field_validator

from bematist.config import look_up
from bematist.earth import STANDARD_GRAVITY, normal_gravity, rotation_rate
from bematist.parameters import Parameters
from bematist.simulate.carry import CARRIES, Carry, Walker
from bematist.simulate.disturbances import Dipole, Facade, FieldRegion, FieldTurn, IndoorField, ParkedCars
from bematist.simulate.gaits import GAITS, Gait, NamedGait

Point = tuple[float, float, float]
Matrix = tuple[Point, Point, Point]

ATHENS_LATITUDE_RAD = math.radians(37.98)
_ZERO: Point = (0.0, 0.0, 0.0)
_NONE: Matrix = (_ZERO, _ZERO, _ZERO)


class Scenario(Parameters):
    """A walk. Lengths in m along the path; the frame is ENU with its origin at the start:
    the sensor on the shoe, or the ground under who carries it.
    """

    name: str = Field(default="", description="Name, for messages.")
    waypoints: tuple[Point, ...] = Field(
        description="Corners of the path, m; its first leg is turned to `heading_deg`. One point is a rest.", min_length=1
    )
    length_m: float | None = Field(default=None, description="Length the path is scaled to, m; as drawn when absent.", gt=0)
    corner_radius_m: float = Field(default=1.0, description="Radius of the rounded corners, m; smaller where legs are short.", gt=0)
    heading_deg: float = Field(default=90.0, description="Heading of the first leg, degrees clockwise from North.")
    gaits: tuple[tuple[float, NamedGait], ...] = Field(
        default=((0.0, GAITS["walk"]),), description="Gaits and where each begins: (m along the path, gait or its name).", min_length=1
    )
    stairs: tuple[int, ...] = Field(default=(), description="Legs between waypoints, counted from 0, that are stairs.")
    stairs_gait: NamedGait = Field(default=GAITS["stairs"], description="Gait on stairs, or its name; a stride there is two treads.")
    riser_m: float = Field(default=0.17, description="Height of a stair, m; fitted so that a flight is a whole number of them.", gt=0.02)
    tread_m: float = Field(default=0.29, description="Depth of a stair, m.", gt=0.05)
    rest_s: float = Field(default=10.0, description="Rest at the start, s.", ge=0)
    final_rest_s: float = Field(default=5.0, description="Rest at the end, s.", ge=0)
    pauses: tuple[tuple[float, float], ...] = Field(default=(), description="Stops: (m along the path, s).")
    tumble_rests: int = Field(
        default=0, description="Orientations in which a sensor rests that is turned about in the hand; 0 is a walk.", ge=0
    )
    tumble_rest_s: float = Field(default=3.0, description="Length of each of these rests, s.", gt=0)
    tumble_rate: float = Field(default=math.radians(90.0), description="Mean rate of the turns between them, rad/s.", gt=0)
    full_turns: bool = Field(default=False, description="Whether whole turns about x, y and z follow, each between two rests.")
    lever_m: tuple[float, float] = Field(default=(-0.10, 0.08), description="Sensor from the toes: forward and up, m; for rocking.")
    mounting_deg: Point = Field(default=(5.0, -20.0, 0.0), description="Roll, pitch, yaw of the sensor on the flat foot, degrees.")
    gravity: float = Field(default=normal_gravity(ATHENS_LATITUDE_RAD, 150.0), description="Gravity, m/s².", gt=0)
    field_ut: float = Field(default=46.0, description="Earth's magnetic flux density, µT.", ge=0)
    inclination_deg: float = Field(default=53.0, description="Magnetic inclination, degrees below the horizon; declination is 0.")
    latitude_deg: float | None = Field(
        default=None, description="Latitude, degrees, of the Earth that turns below the walk; none: it does not turn.", ge=-90, le=90
    )
    disturbed: bool = Field(default=True, description="Whether anything of the following is there; false leaves the Earth's field alone.")
    parked_cars: tuple[ParkedCars, ...] = Field(default=(), description="Stretches between parked cars, which bend the compass.")
    facades: tuple[Facade, ...] = Field(default=(), description="Walls with iron in them.")
    dipoles: tuple[Dipole, ...] = Field(default=(), description="Manhole covers and other iron.")
    field_regions: tuple[FieldRegion, ...] = Field(default=(), description="Stretches where something constant is added to the field.")
    indoor_fields: tuple[IndoorField, ...] = Field(default=(), description="Stretches inside buildings, each with many such regions.")
    field_turns: tuple[FieldTurn, ...] = Field(default=(), description="Stretches where the field is turned and keeps its norm.")

    @property
    def earth_rate(self) -> tuple[float, float, float]:
        """Rotation of the Earth, rad/s, East, North, Up; zero where it does not turn."""
        return (0.0, 0.0, 0.0) if self.latitude_deg is None else rotation_rate(math.radians(self.latitude_deg))

    @field_validator("gaits")
    @classmethod
    def _in_order(cls, value: tuple[tuple[float, Gait], ...]) -> tuple[tuple[float, Gait], ...]:
        if value[0][0] != 0.0 or any(b[0] <= a[0] for a, b in pairwise(value)):
            raise ValueError("the first gait begins at 0, and each farther along the path than the one before")
        return value


class Sensor(Parameters):
    """Errors of a nine-axis sensor: measured = clipped(rounded(matrix · true + bias + noise)), matrix = I + errors.

    White noise is given by its density N: a sample at rate f has the standard deviation N √f, as an Allan deviation of
    N at 1 s says. Bias instability B is flicker noise, whose Allan deviation is flat at 0.664 B. What ends in `_sd` is drawn from the seed.
    """

    name: str = Field(default="", description="Name, for messages.")
    rate_hz: float = Field(default=238.0, description="Rate of accelerometer and gyroscope, Hz.", gt=1)
    magnetometer_rate_hz: float = Field(default=80.0, description="Rate of the magnetometer, Hz; 0 is no magnetometer.", ge=0)
    sampling: Literal["average", "instant"] = Field(
        default="average", description="A sample is the mean over the interval that ends at its time, or the value at its time."
    )
    jitter_s: float = Field(default=0.0, description="Standard deviation of the inertial time stamps, s; the samples are regular.", ge=0)
    velocity_random_walk: float = Field(default=0.0, description="Accelerometer white noise, m/s²/√Hz.", ge=0)
    angle_random_walk: float = Field(default=0.0, description="Gyroscope white noise, rad/s/√Hz.", ge=0)
    magnetic_noise_density: float = Field(default=0.0, description="Magnetometer white noise, µT/√Hz.", ge=0)
    accel_bias_instability: float = Field(default=0.0, description="m/s².", ge=0)
    gyro_bias_instability: float = Field(default=0.0, description="rad/s.", ge=0)
    flicker_from_s: float = Field(
        default=3.0,
        description="Shortest averaging time at which flicker noise is there, s. 3 or more: a sum of four processes, from 3 s to an hour. "
        "Less: exact, drawn this often, or at every sample with 0, as an Allan deviation takes it to be; a walk does not feel it.",
        ge=0,
    )
    accel_correlated_sd: float = Field(default=0.0, description="Standard deviation of first-order Gauss-Markov noise, m/s².", ge=0)
    accel_correlation_s: float = Field(default=100.0, description="Its correlation time, s.", gt=0)
    accel_rate_random_walk: float = Field(default=0.0, description="Random walk of the accelerometer's bias, m/s²/√s.", ge=0)
    gyro_rate_random_walk: float = Field(default=0.0, description="Random walk of the gyroscope's bias, rad/s/√s.", ge=0)
    accel_bias: Point = Field(default=_ZERO, description="Constant bias, m/s².")
    gyro_bias: Point = Field(default=_ZERO, description="Constant bias, rad/s.")
    magnetic_bias: Point = Field(default=_ZERO, description="Hard iron, µT.")
    accel_bias_sd: float = Field(default=0.0, description="Standard deviation of the constant turn-on bias, m/s².", ge=0)
    gyro_bias_sd: float = Field(default=0.0, description="Standard deviation of the constant turn-on bias, rad/s.", ge=0)
    magnetic_bias_sd: float = Field(default=0.0, description="Standard deviation of the hard iron, µT.", ge=0)
    accel_errors: Matrix = Field(default=_NONE, description="Scale factor errors (diagonal) and misalignment (rad), row by row.")
    gyro_errors: Matrix = Field(default=_NONE, description="Scale factor errors (diagonal) and misalignment (rad), row by row.")
    soft_iron: Matrix = Field(default=_NONE, description="What soft iron, scale and misalignment add to the magnetometer's unit matrix.")
    accel_scale_sd: float = Field(default=0.0, description="Standard deviation of the scale factor errors.", ge=0)
    gyro_scale_sd: float = Field(default=0.0, description="Standard deviation of the scale factor errors.", ge=0)
    magnetic_scale_sd: float = Field(default=0.0, description="Standard deviation of the scale factor errors.", ge=0)
    accel_misalignment_sd: float = Field(default=0.0, description="Standard deviation of each of the six misalignments, rad.", ge=0)
    gyro_misalignment_sd: float = Field(default=0.0, description="Standard deviation of each of the six misalignments, rad.", ge=0)
    magnetic_misalignment_sd: float = Field(default=0.0, description="Standard deviation of each of the six misalignments, rad.", ge=0)
    gyro_g_sensitivity_sd: float = Field(
        default=0.0, description="What specific force adds to the angular rate: sd of the nine entries, rad/s per m/s².", ge=0
    )
    accel_range: float = Field(default=math.inf, description="Largest specific force, m/s².", gt=0)
    gyro_range: float = Field(default=math.inf, description="Largest angular rate, rad/s.", gt=0)
    magnetic_range: float = Field(default=math.inf, description="Largest flux density, µT.", gt=0)
    accel_lsb: float = Field(default=0.0, description="Quantum, m/s²; 0 is none.", ge=0)
    gyro_lsb: float = Field(default=0.0, description="Quantum, rad/s; 0 is none.", ge=0)
    magnetic_lsb: float = Field(default=0.0, description="Quantum, µT; 0 is none.", ge=0)
    pressure_rate_hz: float = Field(default=0.0, description="Rate of the barometer, Hz; 0 is no barometer.", ge=0)
    pressure_noise_density: float = Field(default=0.0, description="Barometer white noise, Pa/√Hz; 1.2 Pa are 10 cm.", ge=0)
    pressure_walk: float = Field(default=0.0, description="Random walk of what it says, with the weather, Pa/√s.", ge=0)
    pressure_bias_sd: float = Field(default=0.0, description="Standard deviation of its constant bias, Pa.", ge=0)
    pressure_lsb: float = Field(default=0.0, description="Quantum, Pa; 0 is none.", ge=0)


_G, _DEG = STANDARD_GRAVITY, math.radians(1.0)

SENSORS: dict[str, Sensor] = {
    "ideal": Sensor(name="ideal"),
    # MAGINAV Table 3, where the magnetometer's density is a hundredfold misprint and the accelerometer's instability is not per hour;
    # quanta from ST's data sheet DS10377 rather than range/2^15. Turn-on biases are what is left after a simple calibration: our
    # choice, the paper gives none.
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
    # MAGYQ Tables 1 and 2, means over the axes; what is read there as an Allan deviation's floor is 0.664 of the instability. Table 2 is in
    # degrees, not rad, and its random walk per √h (errata). Rate as in the paper's experiment. Ranges, quanta
    # and the orthogonality of the gyroscope from Analog Devices' data sheet ADIS16488A and the driver in Linux. Turn-on biases, the other
    # misalignments, the effect of acceleration and the magnetometer's 0.054 mG/√Hz (one-sided) are typical, not checked against the sheet.
    "adis16488": Sensor(
        name="adis16488",
        rate_hz=100.0,
        magnetometer_rate_hz=100.0,
        velocity_random_walk=0.0669e-3 * _G,
        angle_random_walk=0.00433 * _DEG,
        magnetic_noise_density=0.0054 / math.sqrt(2),
        accel_bias_instability=0.0725e-3 / 0.664 * _G,
        gyro_bias_instability=0.00114 / 0.664 * _DEG,
        gyro_rate_random_walk=0.00152 / 60 * _DEG,
        accel_bias_sd=16e-3 * _G,
        gyro_bias_sd=0.2 * _DEG,
        magnetic_bias_sd=1.5,
        accel_misalignment_sd=0.035 * _DEG,
        gyro_misalignment_sd=0.05 * _DEG,
        magnetic_misalignment_sd=0.35 * _DEG,
        gyro_g_sensitivity_sd=0.009 * _DEG / _G,
        accel_range=18 * _G,
        gyro_range=450 * _DEG,
        magnetic_range=250.0,
        accel_lsb=0.8e-3 * _G,
        gyro_lsb=0.02 * _DEG,
        magnetic_lsb=0.01,
    ),
    # A consumer phone after the calibration that Android does by itself, of no one part: round numbers of our choice, on the noisy side.
    # Data sheets give 0.003 to 0.014 °/s/√Hz and 75 to 400 µg/√Hz (MPU-6050, BMI160, BMI055, ICM-20602, ICM-42688); the rest is unchecked.
    "phone": Sensor(
        name="phone",
        rate_hz=100.0,
        magnetometer_rate_hz=50.0,
        velocity_random_walk=0.3e-3 * _G,
        angle_random_walk=0.02 * _DEG,
        magnetic_noise_density=0.4 / math.sqrt(50.0),
        accel_bias_instability=0.1e-3 * _G,
        gyro_bias_instability=10.0 / 3600 * _DEG,
        gyro_rate_random_walk=1.5e-3 * _DEG,
        accel_bias_sd=0.05,
        gyro_bias_sd=0.5 * _DEG,
        magnetic_bias_sd=0.5,
        accel_scale_sd=3e-3,
        gyro_scale_sd=3e-3,
        magnetic_scale_sd=5e-3,
        accel_misalignment_sd=0.2 * _DEG,
        gyro_misalignment_sd=0.2 * _DEG,
        magnetic_misalignment_sd=0.3 * _DEG,
        accel_range=8 * _G,
        gyro_range=2000 * _DEG,
        magnetic_range=4900.0,
        accel_lsb=8 * _G / 2**15,
        gyro_lsb=2000 * _DEG / 2**15,
        magnetic_lsb=0.15,
        pressure_rate_hz=10.0,
        pressure_noise_density=0.5,
        pressure_walk=0.1,
        pressure_bias_sd=100.0,
        pressure_lsb=0.16,
    ),
}
"""Sensor presets by name."""


def resolve(scenario: str | Scenario, sensor: str | Sensor, changes: Mapping[str, Any]) -> tuple[Scenario, Sensor]:
    """Scenario and sensor with `changes` to the fields of either, or of all the gaits of the walk; `gait` is one gait for all of it.

    Raises
    ------
    UsageError
        An unknown scenario, sensor or field, or a value that does not fit.
    """
    walk, device, _ = _resolved(scenario, sensor, changes, None)
    return walk, device


def resolve_hand(
    scenario: str | Scenario, carry: str | Carry, sensor: str | Sensor, changes: Mapping[str, Any]
) -> tuple[Scenario, Sensor, Walker]:
    """As `resolve`, for a sensor in the hand: `changes` to the walker and to all his ways of carrying too.

    Raises
    ------
    UsageError
        An unknown scenario, way of carrying, sensor or field, or a value that does not fit.
    """
    held = carry if isinstance(carry, Carry) else look_up("way of carrying", carry, CARRIES)
    walk, device, walker = _resolved(scenario, sensor, changes, Walker(carries=((0.0, held),)))
    assert walker is not None
    return walk, device, walker


def _resolved(
    scenario: str | Scenario, sensor: str | Sensor, changes: Mapping[str, Any], walker: Walker | None
) -> tuple[Scenario, Sensor, Walker | None]:
    from bematist.simulate.scenarios import SCENARIOS

    walk = scenario if isinstance(scenario, Scenario) else look_up("scenario", scenario, SCENARIOS)
    device = sensor if isinstance(sensor, Sensor) else look_up("sensor", sensor, SENSORS)
    changes = dict(changes)
    if "gait" in changes:
        changes["gaits"] = ((0.0, changes.pop("gait")),)
    kinds = (Scenario, Sensor, Gait) if walker is None else (Scenario, Sensor, Gait, Walker, Carry)
    fields = {kind: set(kind.model_fields) - {"name"} for kind in kinds}
    of = {kind: {k: v for k, v in changes.items() if k in known} for kind, known in fields.items()}
    known = dict.fromkeys(sorted(set().union(*fields.values(), ["gait"])))
    for name in changes:
        look_up("parameter of the simulation", name, known)
    walk, device = walk.override(of[Scenario]), device.override(of[Sensor])
    if of[Gait]:
        walk = walk.override({"gaits": tuple((at, gait.override(of[Gait]).model_dump()) for at, gait in walk.gaits)})
    if walker is not None:
        walker = walker.override(of[Walker])
        if of[Carry]:
            walker = walker.override({"carries": tuple((at, carry.override(of[Carry]).model_dump()) for at, carry in walker.carries)})
    return walk, device, walker
