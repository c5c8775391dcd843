"""The Jacobians of the handheld filter against finite differences of what they are derivatives of, and the solution of QUEST."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import twin_hand
from bematist.frames import matrix_from_quaternion as rotation
from bematist.frames import multiply, quaternion_from_matrix, quaternion_from_rotation_vector
from bematist.hand.setup import rotation_to_quaternion
from bematist.kernels import hand, hand_error, hand_fields, hand_quest, innovation
from bematist.kernels import hand_layout as at

RNG = np.random.default_rng(5)
STEP = 1e-6
NEVER = -1.0
"""A limit of the NIS that refuses every innovation: the update then leaves H P in W, and with P = 1 that is H."""


def unit(v):
    return v / np.linalg.norm(v)


def differences(function, x):
    """Central differences of a vector function (M,) to each of x (N,): (M,N)."""
    columns = [(np.atleast_1d(function(x + d)) - np.atleast_1d(function(x - d))) / (2 * STEP) for d in STEP * np.eye(len(x))]
    return np.stack(columns, -1)


def state():
    """A workspace with P = 1 and a state in which nothing is small."""
    S = np.zeros(at.WORKSPACE_SIZE)
    S[:256] = np.eye(16).ravel()
    S[at.X : at.X + 16] = RNG.normal(size=16)
    S[at.Q : at.Q + 4] = unit(S[at.Q : at.Q + 4])
    S[at.BQ : at.BQ + 3] *= 0.01
    S[at.TURN : at.TURN + 4], S[at.STEP : at.STEP + 4] = unit(RNG.normal(size=4)), unit(RNG.normal(size=4))
    return S


def jacobian(S):
    return S[at.W : at.W + 48].reshape(3, 16)


@pytest.mark.parametrize("_", range(3))
def test_h1_and_h3(_):
    q, x = RNG.normal(size=4), RNG.normal(size=3)  # of any norm: additive errors leave the sphere
    np.testing.assert_allclose(np.reshape(hand_error.h1(*q, *x), (3, 4)), differences(lambda v: twin_hand.sandwich(v, x), q), atol=1e-8)
    back = differences(lambda v: twin_hand.sandwich(v * [1, -1, -1, -1], x), q)
    np.testing.assert_allclose(np.reshape(hand_error.h3(*q, *x), (3, 4)), back, atol=1e-8)


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("force", [False, True])
def test_quasi_static_field(force, own):
    """h1, h2 and the own reference: z is minus the change of q ⊗ (y − b) ⊗ q* − r."""
    S, y, r = state(), RNG.normal(size=3), RNG.normal(size=3)
    x = S[at.X : at.X + 16].copy()
    place = at.E_F if force else at.E_M
    reference = x[place : place + 3] if own else r

    def predicted(v):
        value = y - v[at.E_BA : at.E_BA + 3] if force else y
        return twin_hand.sandwich(v[:4], value) - (v[place : place + 3] if own else r)

    measure = hand_fields.measure_force if force else hand_fields.measure_field
    value = y - x[at.E_BA : at.E_BA + 3] if force else y
    *z, _, used = measure(S, *value, *reference, own, 1.0, NEVER, True)
    assert not used
    np.testing.assert_allclose(z, -predicted(x), atol=1e-12)
    np.testing.assert_allclose(jacobian(S), differences(predicted, x), atol=1e-8)


@pytest.mark.parametrize("force", [False, True])
def test_clone(force):
    """A new reference has the errors of what it was made from."""
    S, y = state(), RNG.normal(size=3)
    A = RNG.normal(size=(16, 16))
    S[:256] = (A @ A.T).ravel()
    place = at.E_F if force else at.E_M

    def taken(v):
        out = v.copy()
        out[place : place + 3] = twin_hand.sandwich(v[:4], y - v[at.E_BA : at.E_BA + 3] if force else y)
        return out

    x = S[at.X : at.X + 16].copy()
    value = y - x[at.E_BA : at.E_BA + 3] if force else y
    (hand_fields.clone_force if force else hand_fields.clone_field)(S, *value, 0.3)
    T = differences(taken, x)
    wanted = T @ A @ A.T @ T.T
    wanted[place : place + 3, place : place + 3] += 0.3 * np.eye(3)
    np.testing.assert_allclose(S[:256].reshape(16, 16), wanted, atol=1e-6)
    np.testing.assert_allclose(S[at.X : at.X + 16], taken(x), atol=1e-12)


def transition(v, w, dt, period, decay):
    """The next state: MAGYQ eqs 17-19 and 28-31 with their normalisations."""
    out = v.copy()
    r = quaternion_from_rotation_vector(w * dt)
    r[1:] -= dt / period * v[4:7]
    out[:4] = unit(multiply(unit(v[:4]), unit(r)))
    out[7:10] *= decay
    return out


@pytest.mark.parametrize("dt", [0.01, 0.02])
def test_transition_with_its_normalisations(dt):
    """Φ column by column: P = e eᵀ becomes Φ e eᵀ Φᵀ, where e is projected as every P of the filter is."""
    prm = np.zeros(at.PARAMETERS)
    prm[at.PERIOD], prm[at.PROJECT], prm[at.ACCEL_DECAY] = 0.01, 1.0, 0.02
    first = state()
    w = RNG.normal(size=3) * 5
    first[at.ROW + 4 : at.ROW + 7] = w
    x = first[at.X : at.X + 16].copy()
    Phi = differences(lambda v: transition(v, w, dt, 0.01, 1 - 0.02 * dt), x)
    for column in range(16):
        S, e = first.copy(), np.zeros(16)
        e[column] = 1
        e[:4] -= x[:4] * (x[:4] @ e[:4])
        S[:256] = np.outer(e, e).ravel()
        hand.predict(S, prm, dt)
        np.testing.assert_allclose(S[:256].reshape(16, 16), np.outer(Phi @ e, Phi @ e), atol=1e-8)
    np.testing.assert_allclose(S[at.X : at.X + 16], transition(x, w, dt, 0.01, 1 - 0.02 * dt), atol=1e-12)


def test_maru_over_several_gyroscope_samples():
    prm = np.zeros(at.PARAMETERS)
    prm[at.PERIOD], prm[at.PROJECT] = 0.01, 1.0
    S, before, now = state(), RNG.normal(size=3), RNG.normal(size=3)
    hand.restart_turn(S)
    rates, steps = RNG.normal(size=(4, 3)) * 5, [0.01, 0.013, 0.02, 0.01]
    b = S[at.BQ : at.BQ + 3].copy()
    for w, dt in zip(rates, steps, strict=True):
        S[at.ROW + 4 : at.ROW + 7] = w
        hand.predict(S, prm, dt)
        hand.accumulate_turn(S)

    def predicted(v):
        q = np.array([1.0, 0, 0, 0])
        for w, dt in zip(rates, steps, strict=True):
            r = quaternion_from_rotation_vector(w * dt)
            r[1:] -= dt / 0.01 * v
            q = multiply(q, unit(r))
        return rotation(q).T @ before

    S[:256] = np.eye(16).ravel()
    nis = hand_fields.gradient_field(S, *before, *now, 0.25, NEVER, True)
    H = differences(predicted, b)
    np.testing.assert_allclose(jacobian(S)[:, 4:7], H, atol=1e-7)
    np.testing.assert_allclose(np.delete(jacobian(S), [4, 5, 6], 1), 0, atol=1e-12)
    z = now - predicted(b)
    np.testing.assert_allclose(nis, z @ np.linalg.solve(H @ H.T + 0.25 * np.eye(3), z), rtol=1e-9)


def test_agu():
    """The state is that of the later sample, so the offset of the earlier one is b/decay (erratum of MAGYQ eq 46)."""
    prm = np.zeros(at.PARAMETERS)
    prm[at.PERIOD], prm[at.PROJECT], prm[at.ACCEL_DECAY] = 0.01, 1.0, 5.0
    S, before, now, w = state(), RNG.normal(size=3), RNG.normal(size=3), RNG.normal(size=3) * 5
    S[at.ROW + 4 : at.ROW + 7] = w
    decay = hand.predict(S, prm, 0.01)
    assert decay == pytest.approx(0.95)
    x = S[at.X : at.X + 16].copy()

    def predicted(v):
        r = quaternion_from_rotation_vector(w * 0.01)
        r[1:] -= v[4:7]
        return rotation(unit(r)).T @ (before - v[7:10] / decay) + v[7:10]

    S[:256] = np.eye(16).ravel()
    b = x[7:10]
    nis = hand_fields.gradient_force(S, *(before - b / decay), *(now - b), decay, 0.25, NEVER, True)
    H = differences(predicted, x)
    np.testing.assert_allclose(jacobian(S), H, atol=1e-7)
    z = now - predicted(x)
    np.testing.assert_allclose(nis, z @ np.linalg.solve(H @ H.T + 0.25 * np.eye(3), z), rtol=1e-9)


def test_normalised_square_of_an_innovation():
    A, z = RNG.normal(size=(3, 3)), RNG.normal(size=3)
    S = A @ A.T + np.diag([0.1, 0.2, 0.3])
    L = innovation.factor(*S[np.tril_indices(3)], *z)
    np.testing.assert_allclose(innovation.squared(L), z @ np.linalg.solve(S, z), rtol=1e-12)
    S[2, 2] = S[2, :2] @ np.linalg.solve(S[:2, :2], S[:2, 2]) - 0.1
    assert np.isnan(innovation.squared(innovation.factor(*S[np.tril_indices(3)], *z)))  # no covariance: no limit is kept


def test_heading():
    S = state()
    S[at.EARTH_E : at.EARTH_U + 1] = 3.0, 20.0, -40.0
    # Near the truth, where H is linearised: the measured field is the Earth's in the body.
    q = S[at.Q : at.Q + 4].copy()
    m = rotation(multiply(quaternion_from_rotation_vector([1e-4, -2e-4, 1e-4]), q)).T @ S[at.EARTH_E : at.EARTH_U + 1]

    def angle(v):
        n = rotation(unit(v)) @ m
        return np.arctan2(3.0 * n[1] - 20.0 * n[0], 3.0 * n[0] + 20.0 * n[1])

    nu, used = hand_fields.heading(S, *m, 1.0, NEVER, True)
    assert not used
    np.testing.assert_allclose(nu, angle(q), atol=1e-12)
    # nu = estimate − truth, and the error of the state is truth − estimate.
    np.testing.assert_allclose(S[at.W : at.W + 4], -differences(angle, q)[0], atol=2e-3)


def test_rotation_vector_and_quaternion_errors():
    S = state()
    q = S[at.Q : at.Q + 4]
    psi = 1e-6 * RNG.normal(size=3)
    true = multiply(quaternion_from_rotation_vector(-psi), q)
    np.testing.assert_allclose(rotation_to_quaternion(q) @ psi, true - q, atol=1e-11)
    P = rotation_to_quaternion(q) @ np.diag([1.0, 4.0, 9.0]) @ rotation_to_quaternion(q).T
    S[:256].reshape(16, 16)[:4, :4] = P
    nav = np.zeros((1, at.NAV))
    hand_error.write_attitude_covariance(S, nav, 0, 5)
    np.testing.assert_allclose(nav[0, 5:], [1, 0, 0, 4, 0, 9], atol=1e-12)


@pytest.mark.parametrize("_", range(5))
def test_quest_of_two_vectors(_):
    a, b, r, s = (unit(v) for v in RNG.normal(size=(4, 3)))
    wa, wb = 7.0, 2.0
    got = np.array(hand_quest.two_vectors(*a, *(3 * b), *r, *s, wa, wb))
    wanted, _ = Rotation.align_vectors([r, s], [a, b], weights=[wa, wb])
    np.testing.assert_allclose(rotation(got), wanted.as_matrix(), atol=1e-9)


def test_levelled_and_headed():
    q = unit(RNG.normal(size=4))
    C = Rotation.from_rotvec([0.2, -0.1, 0.0]).as_matrix() @ rotation(q)  # the truth, turned about a level axis
    got = np.array(hand_quest.levelled(*q, *C[2]))
    np.testing.assert_allclose(rotation(got), C, atol=1e-9)
    m = rotation(q).T @ [0.5, 0.2, -3.0]
    got = np.array(hand_quest.headed(*q, *m, 1.0, 1.0))
    n = rotation(got) @ m
    assert np.arctan2(n[1], n[0]) == pytest.approx(np.pi / 4)
    turn = quaternion_from_matrix(rotation(got) @ rotation(q).T)
    np.testing.assert_allclose(turn[1:3], 0, atol=1e-12)
