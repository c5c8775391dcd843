"""The building blocks of the attitude filters against NumPy twins and finite differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

import twin_ahrs as twin
from bematist.frames import conjugate, multiply
from bematist.kernels import ahrs, rotation

NORTH = {"x to magnetic north": (1.0, 0.0), "ENU": (0.0, 1.0), "ENU, declination": (math.sin(0.3), math.cos(0.3))}


@njit
def mahony_error(q, f, m, he, hn):
    return ahrs.mahony_error(q[0], q[1], q[2], q[3], f[0], f[1], f[2], m[0], m[1], m[2], he, hn)


@njit
def madgwick_direction(q, f, m, he, hn):
    return ahrs.madgwick_direction(q[0], q[1], q[2], q[3], f[0], f[1], f[2], m[0], m[1], m[2], he, hn)


@njit
def integrate_first_order(q, w, dt):
    return rotation.normalise(*ahrs.first_order(q[0], q[1], q[2], q[3], w[0], w[1], w[2], dt))


def drawn(seed):
    """A unit quaternion, a specific force and a field, far from each other."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    return q / np.linalg.norm(q), rng.normal(size=3) * 5, rng.normal(size=3) * 40


seeds = st.integers(0, 2**31)
MISSING = [None, np.full(3, np.nan), np.zeros(3), np.array([np.inf, 0.0, 1.0])]


@given(seeds, st.sampled_from(list(NORTH)))
@settings(max_examples=100, deadline=None)
def test_mahonys_error_is_its_twins(seed, frame):
    q, f, m = drawn(seed)
    np.testing.assert_allclose(mahony_error(q, f, m, *NORTH[frame]), twin.error(q, f, m, NORTH[frame]), atol=1e-14)


def test_mahonys_error_is_the_rotation_that_is_missing():
    """An attitude off by a small rotation: gravity sees its level part, the field what turns it out of the magnetic meridian."""
    field = np.array([0.0, 20.0, -45.0]) / math.hypot(20, 45)
    small = np.array([1e-5, -2e-5, 3e-5])
    off = twin.turn(np.array([1.0, 0, 0, 0]), -small, 1.0, True)
    up = np.array([0, 0, 9.8])
    level = np.append(small[:2], 0)
    np.testing.assert_allclose(mahony_error(off, up, np.zeros(3), 0.0, 1.0), level, atol=1e-9)
    out_of_meridian = small[1] * field[2] - small[2] * field[1]
    want = level + out_of_meridian * np.array([0, field[2], -field[1]])
    np.testing.assert_allclose(mahony_error(off, up, 49 * field, 0.0, 1.0), want, atol=1e-9)


@given(seeds, st.sampled_from(list(NORTH)))
@settings(max_examples=100, deadline=None)
def test_madgwicks_direction_is_the_normalised_gradient(seed, frame):
    """In the frame of the formulas; in any other the same rotation is corrected alike."""
    q, f, m = drawn(seed)
    he, hn = NORTH[frame]
    half = 0.5 * math.atan2(hn, he)
    turned = multiply([math.cos(half), 0, 0, math.sin(half)], q)
    for field in (m, None):
        g = twin.gradient(q, f, field)
        got = madgwick_direction(turned, f, np.full(3, np.nan) if field is None else field, he, hn)
        back = multiply([math.cos(half), 0, 0, -math.sin(half)], got)
        np.testing.assert_allclose(back, g / np.linalg.norm(g), atol=1e-12)


@given(seeds)
@settings(max_examples=50, deadline=None)
def test_the_gradient_is_the_derivative_of_half_the_squared_misfit(seed):
    q, f, m = drawn(seed)
    references = twin.pairs(q, f, m, (1.0, 0.0))

    def cost(p):
        return 0.5 * np.sum(twin.misfit(p, references) ** 2)

    J = [(cost(q + 1e-5 * e) - cost(q - 1e-5 * e)) / 2e-5 for e in np.eye(4)]
    np.testing.assert_allclose(np.array(madgwick_direction(q, f, m, 1.0, 0.0)) * np.linalg.norm(J), J, atol=1e-7)


@given(seeds)
@settings(max_examples=50, deadline=None)
def test_both_filters_turn_about_the_same_axis(seed):
    q, f, m = drawn(seed)
    across = multiply(conjugate(q), madgwick_direction(q, f, m, 0.0, 1.0))[1:]
    e = np.array(mahony_error(q, f, m, 0.0, 1.0))
    np.testing.assert_allclose(across / np.linalg.norm(across), -e / np.linalg.norm(e), atol=1e-9)


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_gravity_says_nothing_about_heading(seed):
    q, f, _ = drawn(seed)
    e = twin.matrix(q) @ mahony_error(q, f, np.full(3, np.nan), 0.0, 1.0)
    assert abs(e[2]) < 1e-15 and np.linalg.norm(e) > 1e-3


@pytest.mark.parametrize("missing", range(1, len(MISSING)))
def test_what_is_missing_is_left_out(missing):
    q, f, m = drawn(4)
    none = MISSING[missing]
    np.testing.assert_allclose(mahony_error(q, none, m, 0.0, 1.0), twin.error(q, None, m, (0.0, 1.0)), atol=1e-14)
    np.testing.assert_allclose(mahony_error(q, f, none, 0.0, 1.0), twin.error(q, f, None, (0.0, 1.0)), atol=1e-14)
    assert mahony_error(q, none, none, 0.0, 1.0) == (0, 0, 0)
    assert madgwick_direction(q, none, none, 0.0, 1.0) == (0, 0, 0, 0)


def test_no_misfit_no_step():
    assert madgwick_direction(np.array([1.0, 0, 0, 0]), np.array([0, 0, 9.8]), np.full(3, np.nan), 0.0, 1.0) == (0, 0, 0, 0)


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_first_order_is_its_twin_and_turns_by_the_arc_tangent(seed):
    q, w, _ = drawn(seed)
    got = np.array(integrate_first_order(q, w, 0.01))
    want = twin.turn(q, w, 0.01, False)
    np.testing.assert_allclose(got, want / np.linalg.norm(want), atol=1e-15)
    turned = multiply(conjugate(q), got)
    angle = 2 * math.atan2(np.linalg.norm(turned[1:]), turned[0])
    np.testing.assert_allclose(angle, 2 * math.atan(np.linalg.norm(w) * 0.005), rtol=1e-9)
