"""Simulate and recover: on walks whose noise is the filter's, the errors are as large as it says.

The normalised squared error of a three-vector has mean 3; over 20 independent walks its mean lies in [1.40, 5.15] with 99.9 % (chi-square
with 60 degrees of freedom, over 20).
"""

import numpy as np
import pytest
from scipy.stats import chi2

import bematist as bm
from bematist import frames
from bematist.earth import STANDARD_GRAVITY
from bematist.simulate import simulate_walk
from bematist.simulate.parameters import Sensor

SEEDS = 20
ARW, VRW, ACCEL_BIAS, GYRO_BIAS = np.radians(0.017), 0.0022, 0.03, np.radians(0.2)
SENSOR = Sensor(
    rate_hz=200,
    magnetometer_rate_hz=0,
    angle_random_walk=ARW,
    velocity_random_walk=VRW,
    accel_bias_sd=ACCEL_BIAS,
    gyro_bias_sd=GYRO_BIAS,
)
MATCHED = {
    # The simulated foot stands still to the last digit, so that the threshold can be as low as white noise allows.
    "stance": {"threshold": 1.0, "window_s": 0.025},
    "zero_velocity": {"sd": 5e-4},
    "noise": {"angle_random_walk": ARW, "velocity_random_walk": VRW, "gyro_bias_walk": 0.0, "accel_bias_walk": 0.0},
    "initial": {"accel_bias_sd": ACCEL_BIAS, "gyro_bias_sd": GYRO_BIAS, "sway": 0.0, "tilt_sd": 1e-4, "longest_s": 9.5},
}


def end_errors(seed):
    """Errors of the last sample, in the frame whose heading is right at the start (its origin is free), with covariances and offsets."""
    walk = simulate_walk("short", SENSOR, seed=seed, gravity=STANDARD_GRAVITY)
    t, truth = bm.track(walk.recording, "zupt", **MATCHED), walk.truth
    first = frames.multiply(t.attitude[0], frames.conjugate(truth.attitude[0]))
    q = frames.quaternion_from_rotation_vector([0, 0, -frames.rotation_vector_from_quaternion(first)[2]])
    R = frames.matrix_from_quaternion(q)
    attitude = frames.multiply(frames.multiply(q, t.attitude[-1]), frames.conjugate(truth.attitude[-1]))
    return {
        "position": (R @ t.position[-1] - truth.position[-1], R @ t.covariance[-1] @ R.T),
        "attitude": (frames.rotation_vector_from_quaternion(attitude), R @ t.attitude_covariance[-1] @ R.T),
        "nis": np.nanmean(t.diagnostics["nis"]),
        "gyro_bias": (t.diagnostics["gyro_bias"][-1] - walk.truth.diagnostics["gyro_bias"][-1], t.diagnostics["gyro_bias_sd"][-1]),
        "accel_bias": (t.diagnostics["accel_bias"][-1] - walk.truth.diagnostics["accel_bias"][-1], t.diagnostics["accel_bias_sd"][-1]),
    }


@pytest.fixture(scope="module")
def errors():
    return [end_errors(seed) for seed in range(SEEDS)]


@pytest.mark.parametrize("quantity", ["position", "attitude"])
def test_errors_are_as_large_as_the_filter_says(errors, quantity):
    nees = np.array([e @ np.linalg.solve(P, e) for e, P in (x[quantity] for x in errors)])
    low, high = chi2.ppf([0.0005, 0.9995], 3 * SEEDS) / SEEDS
    assert low < nees.mean() < high, nees.round(2)


@pytest.mark.parametrize("quantity", ["gyro_bias", "accel_bias"])
def test_offsets_are_recovered(errors, quantity):
    ratio = np.array([e / sd for e, sd in (x[quantity] for x in errors)])
    assert 0.6 < np.sqrt(np.mean(ratio**2)) < 1.5, ratio.round(2)


def test_path_is_recovered(errors):
    ends = np.array([np.linalg.norm(x["position"][0]) for x in errors])
    assert np.median(ends) < 0.1 and ends.max() < 0.5, ends.round(3)


def test_innovations_are_no_larger_than_the_filter_says(errors):
    """Below 3: the simulated foot is stiller than the zero velocity's standard deviation."""
    nis = np.array([x["nis"] for x in errors])
    assert 0.1 < nis.mean() < 3, nis.round(2)
