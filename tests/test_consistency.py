"""Simulate and recover: on walks whose noise is the filter's, the errors are as large as it says.

The normalised squared error of a three-vector has mean 3; over 20 independent walks its mean lies in [2.02, 4.16] with 95 % (chi-square
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
    rate_hz=238,
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


LOW, HIGH = chi2.ppf([0.025, 0.975], 3 * SEEDS) / SEEDS


def errors_at(t, truth, k):
    """Errors (3,) of samples k with covariances, in the frame whose heading is right at the start, since its origin is free."""
    first = frames.multiply(t.attitude[0], frames.conjugate(truth.attitude[0]))
    q = frames.quaternion_from_rotation_vector([0, 0, -frames.rotation_vector_from_quaternion(first)[2]])
    R = frames.matrix_from_quaternion(q)
    attitude = frames.multiply(frames.multiply(q, t.attitude[k]), frames.conjugate(truth.attitude[k]))
    return {
        "position": (R @ t.position[k] - truth.position[k], R @ t.covariance[k] @ R.T),
        "velocity": (R @ t.velocity[k] - truth.velocity[k], R @ t.velocity_covariance[k] @ R.T),
        "attitude": (frames.rotation_vector_from_quaternion(attitude), R @ t.attitude_covariance[k] @ R.T),
    }


def middles(walk, swing):
    """Samples in the middle of a dozen swings or stances, evenly spaced over the walk."""
    edges = walk.motion.edges[1:-1]
    pieces = np.stack([edges[:-1], edges[1:]], 1)[0 if swing else 1 :: 2]
    return np.searchsorted(walk.recording.time, pieces[np.linspace(1, len(pieces) - 2, 12).astype(int)].mean(1))


def walked(seed, scenario="short", **changes):
    walk = simulate_walk(scenario, SENSOR, seed=seed, gravity=STANDARD_GRAVITY, **changes)
    return walk, {how: bm.track(walk.recording, "zupt", linearisation=how, **MATCHED) for how in ("printed", "invariant")}


def short_walk(seed):
    walk, tracks = walked(seed)
    t, truth = tracks["printed"], walk.truth
    return {
        **errors_at(t, truth, -1),
        "nis": np.nanmean(t.diagnostics["nis"]),
        "gyro_bias": (t.diagnostics["gyro_bias"][-1] - truth.diagnostics["gyro_bias"][-1], t.diagnostics["gyro_bias_sd"][-1]),
        "accel_bias": (t.diagnostics["accel_bias"][-1] - truth.diagnostics["accel_bias"][-1], t.diagnostics["accel_bias_sd"][-1]),
    }


def long_walk(seed):
    """Eight minutes, 500 m: errors of the last sample by both linearisations, and in swings and stances by the invariant one."""
    walk, tracks = walked(seed, "campus", length_m=500, pauses=(), parked_cars=())
    swing, stance = middles(walk, True), middles(walk, False)
    assert walk.truth.stance[stance].all() and not walk.truth.stance[swing].any()
    return {
        **{how: errors_at(t, walk.truth, -1) for how, t in tracks.items()},
        "swing": [errors_at(tracks["invariant"], walk.truth, k) for k in swing],
        "stance": [errors_at(tracks["invariant"], walk.truth, k) for k in stance],
    }


@pytest.fixture(scope="module")
def errors():
    return [short_walk(seed) for seed in range(SEEDS)]


@pytest.fixture(scope="module")
def long_errors():
    return [long_walk(seed) for seed in range(SEEDS)]


def mean_nees(found):
    return np.mean([e @ np.linalg.solve(P, e) for e, P in found])


@pytest.mark.parametrize("quantity", ["position", "attitude"])
def test_errors_are_as_large_as_the_filter_says(errors, quantity):
    assert LOW < mean_nees([x[quantity] for x in errors]) < HIGH


@pytest.mark.parametrize("quantity", ["position", "velocity", "attitude"])
def test_errors_in_swing_are_as_large_as_the_filter_says(long_errors, quantity):
    """The mean over instants of one walk is no wider spread than one instant, so the bounds hold all the more."""
    assert LOW < mean_nees([e[quantity] for x in long_errors for e in x["swing"]]) < HIGH


def test_velocity_in_stance_is_no_larger_than_the_filter_says(long_errors):
    """Below the bounds: the simulated foot stands still, and the filter allows it its zero velocity's standard deviation."""
    assert 0.5 < mean_nees([e["velocity"] for x in long_errors for e in x["stance"]]) < LOW


@pytest.mark.parametrize("quantity", ["position", "attitude"])
def test_of_a_long_walk_only_the_invariant_filter_knows_its_heading(long_errors, quantity):
    """As printed, zero velocities seem to tell of heading, and the filter becomes too sure of it, and of position with it."""
    printed, invariant = (mean_nees([x[how][quantity] for x in long_errors]) for how in ("printed", "invariant"))
    assert LOW < invariant < HIGH
    assert printed > max(HIGH, 1.3 * invariant)


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
