"""A precise integrator of inertial samples, for tests of the simulator: shares no code with the filters."""

import numpy as np
from scipy.interpolate import make_interp_spline

from bematist.frames import multiply, quaternion_from_rotation_vector, rotate

GAUSS = 0.5 + np.array([-1, 1]) * np.sqrt(3) / 6


def chained(q):
    """Products q[0] q[1] … q[k] of quaternions (N,4), by doubling."""
    q, d = q.copy(), 1
    while d < len(q):
        q[d:] = multiply(q[:-d], q[d:])
        d *= 2
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def reintegrated(made):
    """Attitude, velocity, position from the samples alone, of the fourth order.

    The values of a sensor that samples instants are their own; the running sums of averaged samples are the exact integrals of the
    signals. A quintic spline through them gives the signals between the samples, and a Magnus step of the fourth order with two Gauss
    points the attitude (A. Iserles, S. P. Nørsett, 1999).
    """
    r, h = made.recording, 1 / made.sensor.rate_hz
    samples = np.column_stack([r.angular_rate, r.specific_force])
    if made.sensor.sampling == "average":
        sums = np.cumsum(samples[1:] * h, axis=0)
        signal = make_interp_spline(r.time, np.concatenate([np.zeros((1, 6)), sums]), k=5).derivative()
    else:
        signal = make_interp_spline(r.time, samples, k=5)
    a, b = (signal(r.time[:-1] + c * h) for c in GAUSS)
    w1, w2 = a[:, :3], b[:, :3]
    slope = (w2 - w1) / (GAUSS[1] - GAUSS[0])
    start = w1 - slope * GAUSS[0]

    def turn(c):
        # Rotation over the share c of a step in which the rate grows evenly.
        return quaternion_from_rotation_vector(h * (start * c + slope * c**2 / 2) + h**2 * c**3 / 12 * np.cross(start, slope))

    q = chained(np.concatenate([made.truth.attitude[:1], turn(1.0)]))
    up = np.array([0.0, 0.0, made.scenario.gravity])
    a1, a2 = (rotate(multiply(q[:-1], turn(c)), x[:, 3:]) - up for c, x in zip(GAUSS, (a, b), strict=True))
    zero = np.zeros((1, 3))
    v = np.concatenate([zero, ((a1 + a2) / 2 * h).cumsum(0)])
    step = v[:-1] * h + h**2 / 2 * ((1 - GAUSS[0]) * a1 + (1 - GAUSS[1]) * a2)
    return q, v, made.truth.position[0] + np.concatenate([zero, step.cumsum(0)])
