"""The simulator against independent truth: re-integration, finite differences, Allan deviation, Maxwell, and a real shoe."""

import time

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from bematist.errors import UsageError
from bematist.evaluate import evaluate
from bematist.frames import (
    conjugate,
    euler_from_quaternion,
    matrix_from_quaternion,
    multiply,
    quaternion_from_rotation_vector,
    rotate,
    rotation_vector_from_quaternion,
)
from bematist.simulate import SCENARIOS, SENSORS, Scenario, simulate, simulate_walk
from bematist.simulate.field import REACH_M, dipole_field, earth_field, field_at
from bematist.simulate.footprints import walk
from bematist.simulate.path import rounded, scaled
from bematist.simulate.sensors import flicker

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

    The running sums of averaged samples are the exact integrals of the signals; a quintic spline through them gives the signals
    between the samples, and a Magnus step of the fourth order with two Gauss points the attitude (A. Iserles, S. P. Nørsett, 1999).
    """
    r, h = made.recording, 1 / made.sensor.rate_hz
    sums = np.cumsum(np.column_stack([r.angular_rate, r.specific_force])[1:] * h, axis=0)
    signal = make_interp_spline(r.time, np.concatenate([np.zeros((1, 6)), sums]), k=5).derivative()
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


@pytest.mark.parametrize("changes", [{}, {"rocking_deg": 5.0}])
def test_reintegration_returns_to_the_truth(changes):
    made = simulate_walk("short", "ideal", rate_hz=1000.0, magnetometer_rate_hz=0.0, **changes)
    q, v, p = reintegrated(made)
    metres = np.linalg.norm(np.diff(made.motion.footprint, axis=0), axis=1).sum()
    assert np.abs(p - made.truth.position).max() < 0.005 * metres / 1000  # 5 mm in 1 km
    assert np.abs(v - made.truth.velocity).max() < 2e-5
    assert np.abs(rotation_vector_from_quaternion(multiply(q, conjugate(made.truth.attitude)))).max() < 1e-8


def test_reintegration_can_tell():
    made = simulate_walk("short", "ideal", rate_hz=1000.0, magnetometer_rate_hz=0.0)
    made.recording.angular_rate[:] += 1e-7
    _, _, p = reintegrated(made)
    assert np.abs(p - made.truth.position).max() > 0.0003


def test_derivatives_against_finite_differences():
    motion = simulate_walk("short", "ideal", rocking_deg=4.0, rate_hz=10.0).motion
    t, h = np.linspace(5, motion.duration_s - 1, 4001), 1e-4
    s, before, after = motion.at(t), motion.at(t - h), motion.at(t + h)
    # The third derivative may jump where a swing begins or ends; there the difference is of a lower order.
    np.testing.assert_allclose(s.velocity, (after.position - before.position) / (2 * h), atol=2e-5)
    np.testing.assert_allclose(s.acceleration, (after.velocity - before.velocity) / (2 * h), atol=5e-3)
    turn = rotation_vector_from_quaternion(multiply(conjugate(before.attitude), after.attitude)) / (2 * h)
    np.testing.assert_allclose(s.angular_rate, turn, atol=2e-4)
    # C²: neither velocity nor acceleration jumps anywhere, neither does the angular rate.
    fine = motion.at(np.arange(9.9, 12.5, 1e-5))
    largest = {"position": 1e-4, "velocity": 1e-3, "acceleration": 0.05, "attitude": 1e-4, "angular_rate": 2e-3}
    for name, most in largest.items():
        assert np.abs(np.diff(getattr(fine, name), axis=0)).max() < most, name


def test_the_stance_is_exactly_still():
    made = simulate_walk("short", "ideal", sampling="instant")
    standing = made.truth.stance == 1
    assert 0.35 < standing.mean() < 0.6
    assert np.abs(made.truth.velocity[standing]).max() == 0
    assert np.abs(made.recording.angular_rate[standing]).max() == 0
    up = np.linalg.norm(made.recording.specific_force[standing], axis=1)
    np.testing.assert_allclose(up, made.scenario.gravity, rtol=1e-12)


def test_a_rocking_stance_rocks_as_asked():
    made = simulate_walk("straight", "ideal", rocking_deg=5.0, variation=0.0, direction_sd_deg=0.0)
    plain = simulate_walk("straight", "ideal", variation=0.0, direction_sd_deg=0.0)
    standing = made.truth.stance == 1
    turn = rotation_vector_from_quaternion(multiply(made.truth.attitude, conjugate(plain.truth.attitude)))[standing]
    assert np.degrees(np.linalg.norm(turn, axis=1).max()) == pytest.approx(5, abs=0.02)
    # The toes stay where they are.
    forward, up = made.scenario.lever_m
    mounting = plain.truth.attitude[:1]
    foot = multiply(made.truth.attitude, conjugate(mounting))[standing]
    toes = made.truth.position[standing] - rotate(foot, np.array([forward, 0.0, up]))
    there = plain.truth.position[standing] - [forward, 0.0, up]
    np.testing.assert_allclose(toes, there, atol=1e-9)
    moves = np.abs(made.truth.velocity[standing]).max()
    assert 0.02 < moves < 0.5


def test_campus_is_a_closed_walk_of_twenty_minutes():
    before = time.process_time()
    made = simulate_walk("campus")
    # Less than 3 s asked for, about 2 s on a busy machine; a loop over samples would take minutes.
    assert time.process_time() - before < 6
    r, t = made.recording, made.truth
    assert r.duration_s == pytest.approx(20 * 60, abs=30)
    assert np.linalg.norm(np.diff(made.motion.footprint, axis=0), axis=1).sum() == pytest.approx(1300, rel=0.005)
    np.testing.assert_allclose(t.position[[0, -1]], 0, atol=1e-9)
    assert (t.position[:, 2] > -0.01).all()
    assert t.stance[: int(9.9 * 238)].all()
    assert (r.rate_hz, 1 / np.median(np.diff(r.magnetic_time))) == (pytest.approx(238), pytest.approx(80))
    assert r.reference is not None
    np.testing.assert_array_equal(r.reference.position, t.position)
    assert evaluate(t, r.reference, "none").ate_m == 0
    # The field near parked cars is bent, and nowhere else.
    norm = np.linalg.norm(r.magnetic_flux_density, axis=1)
    bent = np.abs(norm - 46) > 4
    assert 0.002 < bent.mean() < 0.05
    assert np.linalg.norm(simulate("short").magnetic_flux_density, axis=1).max() < 46 + 4


def test_first_leg_and_heading():
    for heading, direction in ((90.0, [1, 0]), (0.0, [0, 1]), (225.0, [-(0.5**0.5), -(0.5**0.5)])):
        t = simulate_walk("straight", "ideal", heading_deg=heading, mounting_deg=(0, 0, 0)).truth
        np.testing.assert_allclose(t.position[-1, :2] / 100, direction, atol=1e-9)
        np.testing.assert_allclose(matrix_from_quaternion(t.attitude[0])[:2, 0], direction, atol=1e-12)


def test_mounting_turns_the_sensor_only():
    flat = simulate_walk("short", "ideal", mounting_deg=(0, 0, 0))
    tilted = simulate_walk("short", "ideal", mounting_deg=(10.0, -30.0, 40.0))
    np.testing.assert_array_equal(flat.truth.position, tilted.truth.position)
    angles = np.degrees(euler_from_quaternion(tilted.truth.attitude[0]))
    np.testing.assert_allclose(angles, [10, -30, 40], atol=1e-9)
    for name in ("specific_force", "angular_rate"):
        a, b = getattr(flat.recording, name), getattr(tilted.recording, name)
        np.testing.assert_allclose(np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1), atol=1e-9)


def test_magnetometer_reads_the_field_in_its_own_axes():
    made = simulate_walk("campus", "ideal", length_m=600.0)
    t = made.recording.magnetic_time
    state = made.motion.at(t)
    seen = rotate(state.attitude, made.recording.magnetic_flux_density)
    earth = earth_field(made.scenario)
    assert np.linalg.norm(earth) == pytest.approx(46)
    assert np.degrees(np.arctan2(-earth[2], earth[1])) == pytest.approx(53)
    far = t < 300
    np.testing.assert_allclose(seen[far], np.tile(earth, (far.sum(), 1)), atol=0.03)
    assert np.abs(seen - earth).max() > 2


def test_dipole_has_no_divergence_and_no_curl():
    # Maxwell, by finite differences; and the textbook value on the axis, 2 µ0/4π m/r³.
    place, moment = np.array([1.0, 2.0, 0.5]), np.array([30.0, -80.0, 120.0])
    at, h = np.array([2.0, 0.5, 1.5]), 1e-4
    J = np.array([(dipole_field((at + d)[None], place, moment) - dipole_field((at - d)[None], place, moment))[0] / (2 * h)
                  for d in np.eye(3) * h])  # fmt: skip
    assert abs(np.trace(J)) < 1e-6 * np.abs(J).max()
    np.testing.assert_allclose(J, J.T, atol=1e-6 * np.abs(J).max())
    on_axis = dipole_field(np.array([[0.0, 0.0, 2.0]]), np.zeros(3), np.array([0.0, 0.0, 100.0]))
    np.testing.assert_allclose(on_axis, [[0, 0, 2 * 0.1 * 100 / 8]])


def test_a_cut_off_dipole_is_no_loss():
    motion = walk(SCENARIOS["campus"], np.random.default_rng(0))
    p = motion.at(np.arange(0, motion.duration_s, 0.5)).position
    bent = np.linalg.norm(field_at(motion, p, np.random.default_rng(1)) - earth_field(motion.scenario), axis=1)
    assert bent.max() > 3
    assert (bent[p[:, 0] < 50] == 0).all()
    assert np.linalg.norm(dipole_field(np.array([[REACH_M, 0, 0]]), np.zeros(3), np.array([300.0, 0, 0]))) < 0.01


def test_sensor_errors_are_those_of_the_preset():
    made, ideal = simulate_walk("short", "lsm9ds1", seed=3), simulate_walk("short", "ideal", seed=3)
    np.testing.assert_array_equal(made.truth.position, ideal.truth.position)
    s = made.sensor
    for name, bias, density, lsb in (
        ("specific_force", "accel_bias", s.velocity_random_walk, s.accel_lsb),
        ("angular_rate", "gyro_bias", s.angle_random_walk, s.gyro_lsb),
    ):
        noise = getattr(made.recording, name) - getattr(ideal.recording, name) - made.truth.diagnostics[bias]
        sd = np.sqrt(density**2 * s.rate_hz + lsb**2 / 12)
        np.testing.assert_allclose(noise.std(0), sd, rtol=0.05)
        assert np.abs(noise.mean(0)).max() < 5 * sd / np.sqrt(len(noise))
        steps = getattr(made.recording, name) / lsb
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    noise = made.recording.magnetic_flux_density - ideal.recording.magnetic_flux_density
    np.testing.assert_allclose(noise.std(0), 0.079 * np.sqrt(80), rtol=0.05)
    # Table 3 in its own units.
    assert np.degrees(s.angle_random_walk) == pytest.approx(0.017)
    assert s.velocity_random_walk / 9.80665 * 1e6 == pytest.approx(226)
    assert np.degrees(s.gyro_bias_instability) * 3600 == pytest.approx(8.63)


def allan_deviation(x, rate, tau):
    m = round(tau * rate)
    means = x[: len(x) // m * m].reshape(-1, m, *x.shape[1:]).mean(1)
    return np.sqrt(0.5 * (np.diff(means, axis=0) ** 2).mean())


def test_flicker_has_the_allan_deviation_of_its_instability():
    seconds = np.arange(100_000.0)
    x = flicker(2.0, seconds, np.random.default_rng(0))
    for tau in (10, 30, 100, 300):
        assert allan_deviation(x, 1.0, tau) == pytest.approx(0.664 * 2.0, rel=0.15), tau
    assert not flicker(0.0, seconds[:10], np.random.default_rng(0)).any()


def test_saturation_clips():
    r = simulate("short", "lsm9ds1", gyro_range=5.0, accel_range=15.0)
    assert np.abs(r.angular_rate).max() == 5.0
    assert np.abs(r.specific_force).max() == 15.0


def test_seeds():
    a, b, c = (simulate("short", seed=k) for k in (1, 1, 2))
    np.testing.assert_array_equal(a.specific_force, b.specific_force)
    np.testing.assert_array_equal(a.magnetic_flux_density, b.magnetic_flux_density)
    assert np.abs(a.specific_force[:500] - c.specific_force[:500]).max() > 0
    # The same seed walks the same way at another rate and with another sensor.
    d = simulate_walk("short", "ideal", seed=1, rate_hz=100.0)
    assert a.reference is not None
    np.testing.assert_allclose(d.truth.position[-1], a.reference.position[-1], atol=1e-9)


def test_averaged_and_instant_samples_agree_where_sampling_is_fine():
    a, b = (simulate("short", "ideal", rate_hz=2000.0, sampling=s, magnetometer_rate_hz=0.0) for s in ("average", "instant"))
    # The mean over an interval is the value at its middle.
    middle = (b.angular_rate[1:] + b.angular_rate[:-1]) / 2
    np.testing.assert_allclose(a.angular_rate[1:], middle, atol=1e-3)


def test_rounded_corners():
    path = rounded([(0, 0, 0), (10, 0, 0), (10, 10, 2)], 2.0)
    assert path.length_m == pytest.approx(8 + np.pi + 8)
    s = np.linspace(0, path.length_m, 2001)
    p, yaw = path.at(s)
    np.testing.assert_allclose(p[-1], [10, 10, 2], atol=1e-12)
    assert yaw[-1] == pytest.approx(np.pi / 2)
    direction = np.diff(p[:, :2], axis=0) / np.diff(s)[:, None]
    np.testing.assert_allclose(direction, np.column_stack([np.cos(yaw), np.sin(yaw)])[:-1], atol=3e-3)
    assert np.abs(np.linalg.norm(p[:, :2] - [8, 2], axis=1)[(s > 8) & (s < 8 + np.pi)] - 2).max() < 1e-9
    # A corner too tight for its radius, a turn round on the spot, a repeated point, a straight angle.
    for points in ([(0, 0, 0), (1, 0, 0), (1, 0.5, 0)], [(0, 0, 0), (5, 0, 0), (0, 0, 0)],
                   [(0, 0, 0), (0, 0, 0), (3, 0, 0)], [(0, 0, 0), (1, 0, 0), (3, 0, 0)]):  # fmt: skip
        path = rounded(points, 2.0)
        p, yaw = path.at(np.linspace(0, path.length_m, 101))
        assert np.isfinite(p).all()
        assert np.isfinite(yaw).all()
        np.testing.assert_allclose(p[-1], points[-1], atol=1e-6)
        assert np.linalg.norm(np.diff(p, axis=0), axis=1).max() < 1.01 * path.length_m / 100
    assert scaled(SCENARIOS["campus"].waypoints, 1.0, 777.0).length_m == pytest.approx(777)


def test_pauses_and_a_walk_of_ones_own():
    own = Scenario(waypoints=((0, 0, 0), (20, 0, 0)), pauses=((10.0, 30.0),), rest_s=2.0, final_rest_s=1.0)
    made = simulate_walk(own, SENSORS["ideal"])
    spans = made.truth.stance_intervals()
    length = np.diff(made.truth.time[np.minimum(spans, len(made.truth) - 1)], axis=1).ravel()
    k = int(np.argmax(length))
    assert length[k] == pytest.approx(30.3, abs=0.1)
    assert abs(made.truth.position[spans[k, 0], 0] - 10) < 1.4


@pytest.mark.parametrize(
    ("call", "says"),
    [
        ({"scenario": "moon"}, "campus"),
        ({"sensor": "adxl"}, "lsm9ds1"),
        ({"strides": 3}, "stride_m"),
        ({"stride_m": -1.0}, "stride_m"),
        ({"rate_hz": "fast"}, "rate_hz"),
    ],
)
def test_wrong_use_is_said(call, says):
    with pytest.raises(UsageError, match=says):
        simulate(**call)


def test_it_moves_like_a_real_shoe(shared_data):
    """Rates, forces and rest of a simulated stride against a walk with a GX5 on the shoe (gsu_gx5 32)."""
    from bematist.io import read

    real = read(shared_data / "foot" / "gsu_gx5" / "SensorConnectData_32.csv")
    walking = (real.time > 10) & (real.time < 60)
    made = simulate("straight", seed=1)
    walked = (made.time > 12) & (made.time < made.time[-1] - 7)
    rate = [np.linalg.norm(r.angular_rate[k], axis=1) for r, k in ((real, walking), (made, walked))]
    force = [np.linalg.norm(r.specific_force[k], axis=1) for r, k in ((real, walking), (made, walked))]
    for q, least, most in ((50, 0.6, 1.4), (90, 0.7, 1.3), (99, 0.8, 1.25)):
        assert least < np.percentile(rate[1], q) / np.percentile(rate[0], q) < most, q
    for q, least, most in ((50, 0.8, 1.2), (90, 0.6, 1.2), (99, 0.5, 1.2)):
        assert least < np.percentile(force[1], q) / np.percentile(force[0], q) < most, q
    assert abs((rate[0] < 0.6).mean() - (rate[1] < 0.6).mean()) < 0.12
