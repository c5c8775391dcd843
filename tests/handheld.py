"""Walks of the package's simulator with a sensor in the hand, indoors, for the tests of the handheld filters; and their errors."""

from dataclasses import replace

import numpy as np

from bematist.frames import conjugate, multiply, quaternion_from_euler, rotation_vector_from_quaternion
from bematist.simulate import IndoorField, Scenario, simulate_hand
from bematist.simulate.field import earth_field

_CORNERS = ((0, 0), (40, 0), (40, 25), (70, 25), (70, 5), (20, 5), (20, 40), (0, 40))
ROOMS = Scenario(waypoints=tuple((float(x), float(y), 0.0) for x, y in _CORNERS))
SPEED = 1.3 / 1.16
"""Of the gait, m/s."""

EARTH = earth_field(ROOMS)
G = ROOMS.gravity

WHITE = {
    **{f"{sensor}_{what}_sd": 0.0 for sensor in ("accel", "gyro", "magnetic") for what in ("scale", "misalignment")},
    **{f"{sensor}_bias_instability": 0.0 for sensor in ("accel", "gyro")},
    **{f"{sensor}_lsb": 0.0 for sensor in ("accel", "gyro", "magnetic")},
    "magnetic_bias_sd": 0.0,
    "gyro_g_sensitivity_sd": 0.0,
    "gravity": G,
}
"""Sensors that err as the filters believe: white noise, constant offsets and the random walk of the gyroscope's."""

CALIBRATED = {"adis16488": {"accel_bias_sd": 0.15e-3 * G, "gyro_bias_sd": np.radians(0.05)}, "phone": {}}


def walk(sensor="adis16488", seed=0, duration_s=300.0, **changes):
    """A recording of that length: rooms with fields of their own; the sensor lies still for ten seconds, until the first step.

    Its reference holds the true attitude.
    """
    length = SPEED * duration_s
    start = {"carries": ((0.0, "table"), (0.3, "texting")), "length_m": length, "indoor_fields": (IndoorField(from_m=10.0, to_m=length),)}
    made = simulate_hand(ROOMS, "texting", sensor, seed, **{**WHITE, **CALIBRATED[sensor], **start, **changes})
    return between(made.recording, 0.0, duration_s)


def between(r, begin, end):
    """The samples of a recording from begin to before end, s; its reference goes with them."""
    inertial, magnetic, barometer = ((t >= begin - 1e-9) & (t < end - 1e-9) for t in (r.time, r.magnetic_time, r.pressure_time))
    reference = r.reference
    return r.replace(
        time=r.time[inertial] - begin,
        specific_force=r.specific_force[inertial],
        angular_rate=r.angular_rate[inertial],
        magnetic_time=r.magnetic_time[magnetic] - begin,
        magnetic_flux_density=r.magnetic_flux_density[magnetic],
        pressure_time=r.pressure_time[barometer] - begin,
        pressure=r.pressure[barometer],
        reference=replace(
            reference, time=r.time[inertial] - begin, position=reference.position[inertial], attitude=reference.attitude[inertial]
        ),
    )


def held(n, seed=5):
    """n samples at 200 Hz of a phone with a barometer that is carried up a slope, by 0.1 m/s from the sixth second on."""
    seconds = n / 200
    slope = ((0.0, 0.0, 0.0), (SPEED * seconds, 0.0, 0.1 * seconds))
    rates = {"rate_hz": 200.0, "pressure_rate_hz": 25.0, "pressure_walk": 0.0}
    recording = walk("phone", seed, seconds, rest_s=5.5, waypoints=slope, **rates)
    # Between the samples of the others.
    return recording.replace(pressure_time=recording.pressure_time[:-1] + 0.013, pressure=recording.pressure[:-1])


def rotation_error(attitude, truth):
    """psi (N,3) in n with C_est = exp([psi×]) C_true, once the mean turn about up over the first second is taken out (the frame)."""
    psi = rotation_vector_from_quaternion(multiply(attitude, conjugate(truth)))
    first = np.zeros(3)
    first[2] = psi[:100, 2].mean()
    turn = quaternion_from_euler(0, 0, -first[2])
    return rotation_vector_from_quaternion(multiply(multiply(turn, attitude), conjugate(truth)))
