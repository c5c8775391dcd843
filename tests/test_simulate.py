"""The simulator against independent truth: finite differences, stillness, frames, seeds, paths."""

import time

import numpy as np
import pytest

from bematist.errors import UsageError
from bematist.evaluate import evaluate
from bematist.frames import (
    conjugate,
    euler_from_quaternion,
    matrix_from_quaternion,
    multiply,
    rotate,
    rotation_vector_from_quaternion,
)
from bematist.simulate import SCENARIOS, SENSORS, Scenario, simulate, simulate_walk
from bematist.simulate.path import rounded, scaled

GAUSS = 0.5 + np.array([-1, 1]) * np.sqrt(3) / 6


def test_derivatives_against_finite_differences():
    motion = simulate_walk("short", "ideal", rocking_deg=4.0, rate_hz=10.0).motion
    t, h = np.linspace(5, motion.duration_s - 1, 4001), 2e-5
    s, before, after = motion.at(t), motion.at(t - h), motion.at(t + h)
    # The third derivative may jump where a swing begins or ends; there the difference is of a lower order.
    np.testing.assert_allclose(s.velocity, (after.position - before.position) / (2 * h), atol=2e-5)
    np.testing.assert_allclose(s.acceleration, (after.velocity - before.velocity) / (2 * h), atol=5e-3)
    turn = rotation_vector_from_quaternion(multiply(conjugate(before.attitude), after.attitude)) / (2 * h)
    np.testing.assert_allclose(s.angular_rate, turn, atol=2e-4)
    # C²: neither velocity nor acceleration jumps anywhere, neither does the angular rate.
    fine = motion.at(np.arange(9.9, 12.5, 1e-5))
    largest = {"position": 1e-4, "velocity": 1e-3, "acceleration": 0.1, "attitude": 1e-4, "angular_rate": 2e-3}
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
    # The field is bent near cars, walls and iron underfoot, and nowhere else.
    norm = np.linalg.norm(r.magnetic_flux_density, axis=1)
    bent = np.abs(norm - 46) > 4
    assert 0.02 < bent.mean() < 0.12
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
    a, b = (simulate("short", "ideal", rate_hz=4000.0, sampling=s, magnetometer_rate_hz=0.0) for s in ("average", "instant"))
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
