"""From the truth to what a sensor says of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.simulate.motion import Motion
from bematist.simulate.parameters import Sensor

Array = NDArray[np.float64]

_FLICKER_S = (3.0, 30.0, 300.0, 3000.0)


def inertial_truth(motion: Motion, time: Array, sensor: Sensor) -> tuple[Array, Array]:
    """Specific force (N,3), m/s², and angular rate (N,3), rad/s, as a sensor without errors says them at the times
    (N,).

    With `sampling="average"` a sample is the mean of the signal, in the turning body axes, over the interval that ends
    at its time: ∫f dt and ∫ω dt divided by the interval (three-point Gauss–Legendre). That is
    what a sensor does whose filter averages; the integral of the samples is then the integral of the motion at any
    rate.
    """
    if sensor.sampling == "instant":
        return motion.signals(time)
    step = 1 / sensor.rate_hz
    specific_force, angular_rate = motion.signals(time)
    # Where an interval lies within one stance that does not rock, its mean is the value at its end.
    i = np.flatnonzero(~motion.still(time - step, time))
    total = [np.zeros((len(i), 3)), np.zeros((len(i), 3))]
    for node, weight in zip(*np.polynomial.legendre.leggauss(3), strict=True):
        for sum_of, values in zip(total, motion.signals(time[i] + step * (node - 1) / 2), strict=True):
            sum_of += weight / 2 * values
    specific_force[i], angular_rate[i] = total
    return specific_force, angular_rate


@dataclass(frozen=True, eq=False)
class Errors:
    """What the sensor got wrong apart from white noise, for the tests of an estimator: biases (N,3) at each sample,
    SI.
    """

    accel_bias: Array
    gyro_bias: Array


def flicker(instability: float, time: Array, rng: np.random.Generator) -> Array:
    """Flicker noise (N,3) whose Allan deviation is nearly flat at 0.664 `instability` from 3 s to an hour.

    A sum of first-order Gauss–Markov processes a decade apart in correlation time, each with the variance B² ln(10)/π,
    which together have the (one-sided) spectrum B²/(πf). Drawn once a second and interpolated.
    """
    if not instability:
        return np.zeros((len(time), 3))
    seconds = np.arange(np.ceil(time[-1]) + 2)
    keep = np.exp(-1 / np.array(_FLICKER_S))[:, None]
    sd = instability * np.sqrt(np.log(10) / np.pi)
    drive = rng.standard_normal((len(seconds), len(_FLICKER_S), 3)) * sd * np.sqrt(1 - keep**2)
    state, values = rng.standard_normal((len(_FLICKER_S), 3)) * sd, np.empty((len(seconds), 3))
    for k, step in enumerate(drive):
        values[k] = state.sum(0)
        state = keep * state + step
    return np.column_stack([np.interp(time, seconds, axis) for axis in values.T])


def measure(f: Array, w: Array, time: Array, sensor: Sensor, rng: np.random.Generator) -> tuple[Array, Array, Errors]:
    """Specific force and angular rate (N,3) with the errors of the sensor, and those errors."""
    bias_f = sensor.accel_bias_sd * rng.standard_normal(3) + flicker(sensor.accel_bias_instability, time, rng)
    bias_w = sensor.gyro_bias_sd * rng.standard_normal(3) + flicker(sensor.gyro_bias_instability, time, rng)
    root = np.sqrt(sensor.rate_hz)
    f = f + bias_f + sensor.velocity_random_walk * root * rng.standard_normal(f.shape)
    w = w + bias_w + sensor.angle_random_walk * root * rng.standard_normal(w.shape)
    return (
        _digitised(f, sensor.accel_lsb, sensor.accel_range),
        _digitised(w, sensor.gyro_lsb, sensor.gyro_range),
        Errors(bias_f, bias_w),
    )


def measure_field(m: Array, sensor: Sensor, rng: np.random.Generator) -> Array:
    """Flux density (M,3) in body axes, µT, with the errors of the sensor."""
    noise = sensor.magnetic_noise_density * np.sqrt(sensor.magnetometer_rate_hz) * rng.standard_normal(m.shape)
    return _digitised(m + sensor.magnetic_bias + noise, sensor.magnetic_lsb, sensor.magnetic_range)


def _digitised(values: Array, lsb: float, largest: float) -> Array:
    if lsb:
        values = np.round(values / lsb) * lsb
    return np.clip(values, -largest, largest)
