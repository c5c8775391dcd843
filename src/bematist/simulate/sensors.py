"""From the truth to what a sensor says of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.earth import STANDARD_GRAVITY
from bematist.simulate.motion import Movement
from bematist.simulate.parameters import Matrix, Sensor
from bematist.simulate.slow import TIMES_S, exact_flicker, flicker, gauss_markov

Array = NDArray[np.float64]

_BLOCK = 65536


def inertial_truth(motion: Movement, time: Array, sensor: Sensor) -> tuple[Array, Array]:
    """Specific force (N,3), m/s², and angular rate (N,3), rad/s, as a sensor without errors says them at the times
    (N,).

    With `sampling="average"` a sample is the mean of the signal, in the turning body axes, over the interval that ends
    at its time: ∫f dt and ∫ω dt divided by the interval (three-point Gauss–Legendre). That is
    what a sensor does whose filter averages; the integral of the samples is then the integral in those axes at any
    rate (what turns within a sample is lost, as in a real sensor: sculling).
    """
    if sensor.sampling == "instant":
        return motion.signals(time)
    step = 1 / sensor.rate_hz
    specific_force, angular_rate = np.empty((2, len(time), 3))
    # Where an interval lies within one stance that does not rock, its mean is the value at its end.
    still = motion.still(time - step, time)
    specific_force[still], angular_rate[still] = motion.signals(time[still])
    i = np.flatnonzero(~still)
    total = [np.zeros((len(i), 3)), np.zeros((len(i), 3))]
    for node, weight in zip(*np.polynomial.legendre.leggauss(3), strict=True):
        for sum_of, values in zip(total, motion.signals(time[i] + step * (node - 1) / 2), strict=True):
            sum_of += weight / 2 * values
    specific_force[i], angular_rate[i] = total
    return specific_force, angular_rate


@dataclass(frozen=True, eq=False, kw_only=True)
class Errors:
    """What the sensor got wrong apart from white noise, rounding and clipping, for the tests of an estimator or of a calibration.

    measured = matrix · true + bias + noise; the gyroscope's has g_sensitivity · (true specific force) as well.

    Attributes
    ----------
    accel_bias : (N,3) m/s² at each inertial sample.
    gyro_bias : (N,3) rad/s at each inertial sample.
    magnetic_bias : (3,) µT, hard iron.
    accel_matrix, gyro_matrix, magnetic_matrix : (3,3) scale factors and misalignment; the magnetometer's holds soft iron.
    gyro_g_sensitivity : (3,3) rad/s per m/s².
    """

    accel_bias: Array
    gyro_bias: Array
    magnetic_bias: Array
    accel_matrix: Array
    gyro_matrix: Array
    magnetic_matrix: Array
    gyro_g_sensitivity: Array


def drawn_errors(sensor: Sensor, time: Array, rng: np.random.Generator) -> Errors:
    """The errors of this one sensor, at the inertial times (N,)."""
    s = sensor
    constant = {
        "magnetic_bias": s.magnetic_bias + s.magnetic_bias_sd * rng.standard_normal(3),
        "accel_matrix": _matrix(s.accel_errors, s.accel_scale_sd, s.accel_misalignment_sd, rng),
        "gyro_matrix": _matrix(s.gyro_errors, s.gyro_scale_sd, s.gyro_misalignment_sd, rng),
        "magnetic_matrix": _matrix(s.soft_iron, s.magnetic_scale_sd, s.magnetic_misalignment_sd, rng),
        "gyro_g_sensitivity": s.gyro_g_sensitivity_sd * rng.standard_normal((3, 3)),
    }
    accel, gyro = s.accel_bias + s.accel_bias_sd * rng.standard_normal(3), s.gyro_bias + s.gyro_bias_sd * rng.standard_normal(3)
    return Errors(
        accel_bias=_wandering(s, accel, s.accel_bias_instability, s.accel_rate_random_walk, s.accel_correlated_sd, time, rng),
        gyro_bias=_wandering(s, gyro, s.gyro_bias_instability, s.gyro_rate_random_walk, 0.0, time, rng),
        **constant,
    )


def _matrix(errors: Matrix, scale_sd: float, misalignment_sd: float, rng: np.random.Generator) -> Array:
    sd = np.where(np.eye(3, dtype=bool), scale_sd, misalignment_sd)
    return np.eye(3) + np.array(errors) + sd * rng.standard_normal((3, 3))


def _wandering(
    s: Sensor, bias: Array, instability: float, walk: float, correlated_sd: float, time: Array, rng: np.random.Generator
) -> Array:
    # The bias at the times (N,3): slow flicker and random walk drawn once a second, between seconds a straight line.
    seconds = np.arange(np.ceil(time[-1]) + 2)
    slow = flicker(instability, len(seconds), rng)
    fast = instability > 0 and s.flicker_from_s < TIMES_S[0] and len(time) > 1
    values = bias + (0.0 * slow if fast else slow)
    values[1:] += walk * rng.standard_normal((len(seconds) - 1, 3)).cumsum(0)
    if not (instability or walk or correlated_sd):
        return np.broadcast_to(bias, (len(time), 3))
    out = _interpolated(time, seconds, values)
    # What follows has generators of its own: all else that is drawn stays the same with it and without.
    if fast:
        step, own = max(float(time[1] - time[0]), s.flicker_from_s), rng.spawn(1)[0]
        at = np.arange(np.ceil(time[-1] / step) + 2) * step
        out += instability * _interpolated(time, at, exact_flicker(len(at), own))
    if correlated_sd and len(time) > 1:
        own = rng.spawn(1)[0]
        for axis in range(3):
            out[:, axis] += correlated_sd * gauss_markov(len(time), float(time[1] - time[0]), s.accel_correlation_s, own)
    return out


def _interpolated(time: Array, at: Array, values: Array) -> Array:
    return np.column_stack([np.interp(time, at, axis) for axis in values.T])


def measure(f: Array, w: Array, errors: Errors, sensor: Sensor, rng: np.random.Generator) -> tuple[Array, Array]:
    """What the sensor says (N,3), (N,3) of specific force and angular rate."""
    root = np.sqrt(sensor.rate_hz)
    said_f, said_w = np.empty_like(f), np.empty_like(w)
    for start in range(0, len(f), _BLOCK):
        rows = slice(start, start + _BLOCK)
        noise = rng.standard_normal((len(f[rows]), 6)) * root
        exact = f[rows] @ errors.accel_matrix.T + errors.accel_bias[rows]
        said_f[rows] = _digitised(exact + sensor.velocity_random_walk * noise[:, :3], sensor.accel_lsb, sensor.accel_range)
        exact = w[rows] @ errors.gyro_matrix.T + f[rows] @ errors.gyro_g_sensitivity.T + errors.gyro_bias[rows]
        said_w[rows] = _digitised(exact + sensor.angle_random_walk * noise[:, 3:], sensor.gyro_lsb, sensor.gyro_range)
    return said_f, said_w


def measure_field(m: Array, errors: Errors, sensor: Sensor, rng: np.random.Generator) -> Array:
    """What the sensor says (M,3) of the flux density in its own axes, µT."""
    noise = sensor.magnetic_noise_density * np.sqrt(sensor.magnetometer_rate_hz) * rng.standard_normal(m.shape)
    return _digitised(m @ errors.magnetic_matrix.T + errors.magnetic_bias + noise, sensor.magnetic_lsb, sensor.magnetic_range)


def pressure_at(height_m: Array) -> Array:
    """Pressure (K,), Pa, at heights (K,), m, above where it is 1013.25 hPa, in the standard atmosphere (ISO 2533)."""
    return 101325.0 * (1 - 0.0065 * height_m / 288.15) ** (STANDARD_GRAVITY * 0.0289644 / (8.314462618 * 0.0065))


def measure_pressure(pressure: Array, sensor: Sensor, rng: np.random.Generator) -> Array:
    """What the barometer says (L,), Pa, of a pressure (L,) at its rate; the weather is a part of its walk."""
    rate = sensor.pressure_rate_hz
    walk = sensor.pressure_walk / np.sqrt(rate) * rng.standard_normal(len(pressure)).cumsum()
    noise = sensor.pressure_noise_density * np.sqrt(rate) * rng.standard_normal(len(pressure))
    return _digitised(pressure + sensor.pressure_bias_sd * rng.standard_normal() + walk + noise, sensor.pressure_lsb, np.inf)


def jittered(time: Array, sensor: Sensor, rng: np.random.Generator) -> Array:
    """Time stamps (N,), s, of samples that were taken at the times (N,): still in order, off by less than half a step."""
    if not sensor.jitter_s:
        return time
    off = sensor.jitter_s * rng.standard_normal(len(time))
    return time + np.clip(off, -0.45 / sensor.rate_hz, 0.45 / sensor.rate_hz)


def _digitised(values: Array, lsb: float, largest: float) -> Array:
    if lsb:
        values = np.round(values / lsb) * lsb
    return np.clip(values, -largest, largest)
