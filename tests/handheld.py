"""A sensor held before a walking body, as one reads a phone: attitude, specific force and a magnetic field with disturbed regions."""

from dataclasses import dataclass, replace

import numpy as np

from bematist.frames import conjugate, multiply, quaternion_from_euler, rotate, rotation_vector_from_quaternion
from bematist.recording import Recording, Reference

G = 9.80665
EARTH = np.array([0.0, 21.0, -43.0])


@dataclass(frozen=True)
class Noise:
    """Of a sensor: gyroscope rad/s/√Hz, rad/s, rad/s/√s; accelerometer m/s²/√Hz, m/s²; magnetometer µT a sample; rates in Hz."""

    angle_random_walk: float
    gyro_bias: float
    gyro_bias_walk: float
    velocity_random_walk: float
    accel_bias: float
    magnetic: float
    rate_hz: float = 100.0
    magnetic_rate_hz: float = 100.0


ADIS16488 = Noise(np.radians(0.0042), np.radians(0.05), np.radians(2.6e-5), 0.067e-3 * G, 0.15e-3 * G, 0.045)
PHONE = Noise(np.radians(0.02), np.radians(0.5), np.radians(1.5e-3), 0.3e-3 * G, 0.05, 0.4, magnetic_rate_hz=50.0)


def smooth_steps(t, times, values, width):
    """Values that change at times, each over `width` seconds."""
    out = np.tile(values[0], (len(t), 1)).astype(float)
    for when, before, after in zip(times, values[:-1], values[1:], strict=True):
        u = np.clip((t - when) / width, 0, 1)[:, None]
        out += (after - before) * (u * u * (3 - 2 * u))
    return out


def walk(noise=ADIS16488, seed=0, duration_s=300.0, rest_s=10.0, disturbed=True, moving=True):
    """A recording with a rest at the start, whose reference holds the true attitude, and the true magnetic field in n (N,3)."""
    rng = np.random.default_rng(seed)
    n = int(duration_s * noise.rate_hz)
    t = np.arange(n) / noise.rate_hz
    go = np.clip((t - rest_s) / 2, 0, 1) * moving
    turns = np.arange(rest_s + 10, duration_s, 15.0) + rng.uniform(-4, 4, len(np.arange(rest_s + 10, duration_s, 15.0)))
    headings = np.cumsum(np.concatenate([[0.3], rng.choice([-1, 1], len(turns)) * rng.uniform(0.3, 1.8, len(turns)) * moving]))
    yaw = smooth_steps(t, turns, headings[:, None], 1.5)[:, 0]
    step = 2 * np.pi * 1.9 * t
    sway = rng.uniform(0, 6, 6)
    pitch = -0.5 + go * (0.04 * np.sin(step + sway[0]) + 0.1 * np.sin(0.4 * t + sway[1]))
    roll = 0.1 + go * (0.03 * np.sin(step / 2 + sway[2]) + 0.1 * np.sin(0.3 * t + sway[3]))
    yaw = yaw + go * (0.05 * np.sin(step / 2 + sway[4]) + 0.05 * np.sin(0.2 * t + sway[5]))
    q = quaternion_from_euler(roll, pitch, yaw)
    bounce = go[:, None] * np.stack([0.8 * np.sin(step / 2), 0.8 * np.sin(step), 2.0 * np.sin(step + 1)], 1)
    f = rotate(conjugate(q), bounce + np.array([0, 0, G]))
    w = np.zeros((n, 3))
    w[1:] = rotation_vector_from_quaternion(multiply(conjugate(q[:-1]), q[1:])) * noise.rate_hz
    field = np.tile(EARTH, (n, 1))
    if disturbed:
        edges = np.cumsum(rng.uniform(6, 25, int(duration_s / 6)))
        edges = edges[edges < duration_s - 1] + rest_s
        values = rng.normal(0, 8, (len(edges) + 1, 3)) * (rng.uniform(size=len(edges) + 1) < 0.7)[:, None]
        values[0] = 0
        field = field + smooth_steps(t, edges, values, 2.0)
    root = np.sqrt(noise.rate_hz)
    gyro_bias = noise.gyro_bias * rng.standard_normal(3) + np.cumsum(noise.gyro_bias_walk / root * rng.standard_normal((n, 3)), 0)
    accel_bias = noise.accel_bias * rng.standard_normal(3)
    every = round(noise.rate_hz / noise.magnetic_rate_hz)
    m = rotate(conjugate(q), field)[::every]
    return Recording(
        time=t,
        specific_force=f + accel_bias + noise.velocity_random_walk * root * rng.standard_normal((n, 3)),
        angular_rate=w + gyro_bias + noise.angle_random_walk * root * rng.standard_normal((n, 3)),
        magnetic_time=t[::every],
        magnetic_flux_density=m + noise.magnetic * rng.standard_normal(m.shape),
        reference=Reference(time=t, position=np.zeros((n, 3)), attitude=q),
    ), field


def held(n, seed=5):
    """n samples at 200 Hz of a phone with a barometer that is carried along, up a slope."""
    noise = replace(PHONE, rate_hz=200.0)
    recording = walk(noise, seed, n / 200, rest_s=5.0)[0]
    t = np.arange(0.013, recording.time[-1], 0.04)
    up = 0.1 * np.maximum(t - 6, 0)
    pressure = 101325 * (1 - 0.0065 * up / 288.15) ** 5.2559 + np.random.default_rng(seed).normal(0, 1.2, len(t))
    return recording.replace(pressure_time=t, pressure=pressure)


def rotation_error(attitude, truth):
    """psi (N,3) in n with C_est = exp([psi×]) C_true, once the mean turn about up over the first second is taken out (the frame)."""
    psi = rotation_vector_from_quaternion(multiply(attitude, conjugate(truth)))
    first = np.zeros(3)
    first[2] = psi[:100, 2].mean()
    turn = quaternion_from_euler(0, 0, -first[2])
    return rotation_vector_from_quaternion(multiply(multiply(turn, attitude), conjugate(truth)))
