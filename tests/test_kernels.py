"""Kernels against plain NumPy twins and finite differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.spatial.transform import Rotation

import twin
from bematist import frames
from bematist.foot import FootIns, FootParameters
from bematist.foot.setup import initial_covariance
from bematist.kernels import layout as kernel
from bematist.kernels import rotation, text
from bematist.methods import METHODS
from bematist.stance import DETECTORS, StanceParameters, detect
from walks import shaken

numbers = st.floats(-4, 4)


@njit
def exp_quaternion(x, y, z):
    return rotation.exp_quaternion(x, y, z)


@given(numbers, numbers, numbers)
@settings(max_examples=100, deadline=None)
def test_exponential_is_scipys(x, y, z):
    xyzw = Rotation.from_rotvec([x, y, z]).as_quat()
    q = np.array(exp_quaternion(x, y, z))
    if q @ xyzw[[3, 0, 1, 2]] < 0:
        q = -q
    np.testing.assert_allclose(q, xyzw[[3, 0, 1, 2]], atol=4e-16)


def test_exponential_near_identity_and_across_the_switch():
    for angle in (0.0, 1e-12, 1e-6, 0.4999999, 0.5000001, 3.0):
        q = np.array(exp_quaternion(0.0, angle, 0.0))
        np.testing.assert_allclose(q, [math.cos(angle / 2), 0, math.sin(angle / 2), 0], atol=3e-16)


@given(st.integers(0, 2**31))
@settings(max_examples=50, deadline=None)
def test_frames_agree_with_scipy(seed):
    q = Rotation.random(5, random_state=seed).as_quat()[:, [3, 0, 1, 2]]
    R = Rotation.from_quat(q[:, [1, 2, 3, 0]])
    np.testing.assert_allclose(frames.matrix_from_quaternion(q), R.as_matrix(), atol=1e-14)
    back = frames.quaternion_from_matrix(R.as_matrix())
    np.testing.assert_allclose(np.abs((back * q).sum(1)), 1, atol=1e-14)
    np.testing.assert_allclose(frames.euler_from_quaternion(q), R.as_euler("ZYX")[:, ::-1], atol=1e-7)
    np.testing.assert_allclose(np.abs((frames.quaternion_from_euler(*frames.euler_from_quaternion(q).T) * q).sum(1)), 1, atol=1e-12)
    np.testing.assert_allclose(frames.rotation_vector_from_quaternion(q), R.as_rotvec(), atol=1e-9)
    np.testing.assert_allclose(
        frames.matrix_from_quaternion(frames.multiply(q, frames.conjugate(q[::-1]))), (R * R[::-1].inv()).as_matrix(), atol=1e-14
    )


def test_heading_and_yaw_are_each_others_inverse():
    assert frames.heading_deg_from_yaw(0.0) == 90
    np.testing.assert_allclose(frames.yaw_from_heading_deg([0, 90, 180, 270]), np.array([90, 0, -90, 180]) * np.pi / 180, atol=1e-12)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize(
    ("window", "placement"), [(1, "centred"), (5, "centred"), (7, "centred"), (26, "centred"), (7, "forward"), (7, "causal")]
)
def test_running_sums_equal_the_papers_double_loop(detector, window, placement):
    r = shaken(700 + window // 2, seed=3)
    p = StanceParameters(detector=detector, window_s=window / 200, placement=placement)
    n = p.window_samples(200.0)
    assert n % 2 == 1 and abs(n - window) <= 1
    got = detect(r.samples(), p, 200.0)
    want = twin.statistic(r.specific_force, r.angular_rate, n, detector, p.accel_sd, p.gyro_sd, 9.80665, placement)
    assert len(got) == len(r)
    np.testing.assert_allclose(got[:, 0], want, rtol=1e-9, atol=1e-11)
    np.testing.assert_array_equal(got[:, 2] > 0, got[:, 0] < p.limit)


def test_sums_stay_exact_after_a_shock():
    """A heel strike at the range of the sensor leaves less than 1e-9 in the windows of a standing foot after it."""
    r = shaken(400, seed=1)
    f = r.specific_force.copy()
    f[100:103] = 160.0
    p = StanceParameters(window_s=0.05)
    got = detect(r.replace(specific_force=f).samples(), p, 200.0)[:, 0]
    want = twin.statistic(f, r.angular_rate, p.window_samples(200.0), "shoe", p.accel_sd, p.gyro_sd, 9.80665)
    np.testing.assert_allclose(got, want, rtol=1e-9)


@pytest.mark.parametrize("look", [0.0, 0.1, 0.4])
def test_relative_rule_equals_its_twin(look):
    r = shaken(900, seed=5)
    p = StanceParameters(rule="relative", lookaround_s=look, floor=8.0, ratio=2.5)
    got = detect(r.samples(), p, 200.0, zero_velocity_sd=0.02)
    limit, sd = twin.relative(got[:, 0], p.lookaround_samples(200.0), p.floor, p.ratio, 0.02)
    np.testing.assert_allclose(got[:, 1], limit, rtol=1e-14)
    np.testing.assert_allclose(got[:, 2], sd, rtol=1e-14)


def run_both(parameters, recording):
    """The compiled filter and its dense twin over the same recording with the same verdicts."""
    ins = FootIns(parameters)
    result = ins.run(recording)
    a = ins.alignment
    p = parameters
    P = initial_covariance(p, a)
    psd = np.square([p.noise.angle_random_walk, p.noise.velocity_random_walk, 0, p.noise.accel_bias_walk, p.noise.gyro_bias_walk])
    psd[:2] *= recording.rate_hz if p.noise.growth == "per-sample" else 1
    magnetic = {**p.magnetic.model_dump(), "field": a.field} if a.field is not None else None
    choices = magnetic, p.attitude.model_dump(), p.linearisation == "invariant"
    dense = twin.Filter(frames.matrix_from_quaternion(a.attitude), a.gyro_bias, P, psd, p.gravity, *choices)
    rows = recording.samples()
    verdicts = detect(rows, p.stance, recording.rate_hz, zero_velocity_sd=p.zero_velocity.sd)
    sd = verdicts[:, 2]
    still = verdicts[:, 0] <= p.magnetic.still_fraction * verdicts[:, 1]
    p_, C_, P_, nis = [dense.p], [dense.C], [dense.P.copy()], [np.nan]
    if sd[0] > 0:
        dense.zero_velocity(sd[0])
    for k in range(1, len(rows)):
        m = rows[k, 7:10] if np.isfinite(rows[k, 7]) else None
        dense.step(rows[k, 1:4], rows[k, 4:7], rows[k, 0] - rows[k - 1, 0], sd[k], m, still[k])
        p_.append(dense.p)
        C_.append(dense.C)
        P_.append(dense.P.copy())
        nis.append(dense.nis)
    return result, np.array(p_), np.array(C_), np.array(P_), np.array(nis)


@pytest.mark.parametrize("use", ["off", "reset", "heading"])
@pytest.mark.parametrize("rule", ["absolute", "relative"])
def test_filter_equals_its_dense_twin(use, rule):
    assert_equal_to_twin(FootParameters().override({"magnetic": {"use": use}, "stance": {"rule": rule}}))


AHRS = [{"attitude": {"propagation": p, "magnetometer": m}} for p in ("mahony", "madgwick") for m in ("off", "gated", "all")]
PRINTED = [
    {"attitude": {"integration": "first-order"}},
    {"attitude": {"integration": "first-order-matrix"}},
    {"attitude": {"force_at": "end"}, "magnetic": {"use": "reset"}},
    {"attitude": {"propagation": "mahony", "ki": 0.3, "integration": "first-order", "magnetometer": "all"}},
    {"attitude": {"propagation": "madgwick", "integration": "first-order", "force_at": "end"}},
    {"attitude": {"propagation": "madgwick", "integration": "first-order-matrix"}, "magnetic": {"use": "heading"}},
    {"magnetic": {"use": "reset", "triad": "printed"}},
    {"magnetic": {"use": "reset", "covariance": "untouched"}},
    {"noise": {"growth": "per-sample"}},
    {"linearisation": "invariant"},
    {"linearisation": "invariant", "magnetic": {"use": "reset"}, "stance": {"rule": "relative"}},
    {"stance": {"placement": "forward"}, "initial": {"average": False}},
    METHODS["maginav-printed"].parameters.model_dump(),
]


@pytest.mark.parametrize("changes", AHRS + PRINTED, ids=str)
def test_every_choice_equals_its_dense_twin(changes):
    assert_equal_to_twin(FootParameters().override(changes))


def assert_equal_to_twin(p):
    use = p.magnetic.use
    result, position, C, P, nis = run_both(p, shaken())
    np.testing.assert_allclose(result.position, position, atol=1e-8)
    np.testing.assert_allclose(frames.matrix_from_quaternion(result.attitude), C, atol=1e-9)
    np.testing.assert_allclose(result.covariance[1:], P[1:, 6:9, 6:9], rtol=1e-5, atol=1e-13)
    np.testing.assert_allclose(result.velocity_covariance[1:], P[1:, 3:6, 3:6], rtol=1e-5, atol=1e-13)
    np.testing.assert_allclose(result.attitude_covariance[1:], P[1:, 0:3, 0:3], rtol=1e-5, atol=1e-15)
    np.testing.assert_allclose(result.diagnostics["nis"][1:], nis[1:], rtol=1e-4)
    gates = result.diagnostics["magnetic_gate"]
    assert ((gates == kernel.NORM_REFUSED).sum() > 50) == (p.attitude.magnetometer != "all")
    assert ((gates == kernel.USED).sum() > 100) == (use != "off" or p.attitude.magnetometer != "off")


@pytest.mark.parametrize("length", [0.15, 2.0])
def test_a_gap_is_bridged_as_its_twin_does(length):
    """The state and covariance after a gap that falls into motion, short and long."""
    r = shaken(2600, magnetometer=False)
    shift = np.where(np.arange(len(r)) < 2500, 0.0, length - 1 / 200)
    r = r.replace(time=r.time + shift)
    p = FootParameters()
    ins = FootIns(p)
    before = [ins.update(r.samples()[:2503])]
    S = ins.save()["state"][2]
    assert before[0].time[-1] == r.time[2499]
    dense = twin.Filter(
        frames.matrix_from_quaternion(before[0].attitude[-1]), S[kernel.BG : kernel.BG + 3], np.zeros((15, 15)), [0] * 5, 9.8
    )
    dense.P = S[:240].reshape(15, 16)[:, :15].copy()
    dense.p, dense.v = before[0].position[-1], before[0].velocity[-1]
    w = r.angular_rate - S[kernel.BG : kernel.BG + 3]
    assert np.linalg.norm(dense.v) > 0.05 and np.linalg.norm(w[2500]) > 0.5
    dense.bridge(w[2500], w[2499], length, p.gap.model_dump())
    after = ins.update(r.samples()[2503:2504])
    assert after.diagnostics["bridged"][0] == kernel.BRIDGED_OVER and after.stance[0] == 0
    np.testing.assert_allclose(after.position[0], dense.p, atol=1e-12)
    np.testing.assert_allclose(after.velocity[0], dense.v, atol=1e-12)
    np.testing.assert_allclose(frames.matrix_from_quaternion(after.attitude[0]), dense.C, atol=1e-12)
    np.testing.assert_allclose(after.attitude_covariance[0], dense.P[0:3, 0:3], atol=1e-14)
    np.testing.assert_allclose(after.velocity_covariance[0], dense.P[3:6, 3:6], atol=1e-12)
    np.testing.assert_allclose(after.covariance[0], dense.P[6:9, 6:9], atol=1e-12)


def test_transition_matrix_is_the_derivative_of_the_strapdown():
    """Every block of Φ (eq 20) against central differences of the nonlinear propagation of estimate against truth."""
    rng = np.random.default_rng(2)
    C, f, w, dt, g = Rotation.random(random_state=1).as_matrix(), rng.normal(size=3) * 5 + [0, 0, 9.8], rng.normal(size=3), 1e-4, 9.80665
    v, p, ba, bg = rng.normal(size=(4, 3))

    def propagate(x):
        psi, dv, dp, dba, dbg = x.reshape(5, 3)
        # psi, v, p are estimate − truth; the offsets are truth − estimate (what is still to be subtracted)
        d = twin.Filter(Rotation.from_rotvec(psi).as_matrix() @ C, bg - dbg, np.eye(15), np.zeros(5), g)
        d.v, d.p, d.ba = v + dv, p + dp, ba - dba
        middle, fb = d.predict(f, w, dt)
        d.integrate(middle, fb, dt)
        return d

    def difference(a, b):
        return np.concatenate([Rotation.from_matrix(a.C @ b.C.T).as_rotvec(), a.v - b.v, a.p - b.p])

    h = 1e-5
    J = np.stack([difference(propagate(h * e), propagate(-h * e)) / (2 * h) for e in np.eye(15)], 1)
    d = twin.Filter(C, bg, np.eye(15), np.zeros(5), g)
    d.ba = ba
    middle, fb = d.predict(f, w, dt)
    Phi = d.transition(middle, middle @ fb, dt)
    # The first-order transition differs from the exact one by terms of second order in dt.
    np.testing.assert_allclose(J, Phi[:9], atol=5 * dt**2 * 20)
    assert np.abs(J - np.eye(15)[:9]).max() > 1e-4


def test_triad_covariance_is_its_derivative():
    """TRIAD's errors against finite differences of TRIAD itself."""
    C = Rotation.random(random_state=4).as_matrix()
    field, up = np.array([5.0, 22.0, -40.0]), np.array([0, 0, 9.8])
    horizontal = np.linalg.norm(field[:2])
    across = np.array([-field[1], field[0], 0]) / horizontal

    def attitude_error(e):
        est = twin.triad(C.T @ (up + 9.8 * np.append(e[:2], 0)), C.T @ (field - horizontal * e[2] * across), up, field)
        return Rotation.from_matrix(est @ C.T).as_rotvec()

    h = 1e-6
    J = np.stack([(attitude_error(h * e) - attitude_error(-h * e)) / (2 * h) for e in np.eye(3)], 1)
    d = twin.Filter(C, np.zeros(3), np.eye(15), np.zeros(5), 9.8, {"field": field})
    np.testing.assert_allclose(d.triad_jacobian(), J, atol=1e-8)


def test_heading_measurement_is_the_derivative():
    """The row h of the heading measurement against finite differences of the direction of the turned field."""
    field = np.array([5.0, 22.0, -40.0])
    h = field[:2] / np.linalg.norm(field[:2])

    def nu(psi):
        est = Rotation.from_rotvec(psi).as_matrix() @ field
        return math.atan2(h[0] * est[1] - h[1] * est[0], h @ est[:2])

    J = [(nu(1e-6 * e) - nu(-1e-6 * e)) / 2e-6 for e in np.eye(3)]
    slope = field[2] / np.linalg.norm(field[:2])
    np.testing.assert_allclose(J, [-slope * h[0], -slope * h[1], 1], atol=1e-9)


def test_covariance_stays_symmetric_and_positive():
    p = FootParameters().override({"magnetic": {"use": "heading"}})
    ins = FootIns(p)
    ins.run(shaken(20_000))
    P = ins.save()["state"][2][:240].reshape(15, 16)[:, :15]
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > 0


def test_running_sums_do_not_drift():
    """After half a million samples the statistic is what it is anew."""
    r = shaken(3000, seed=9)
    rows = np.tile(r.samples(), (170, 1))
    rows[:, 0] = np.arange(len(rows)) / 200
    p = StanceParameters(window_s=0.1)
    late = detect(rows, p, 200.0)[-1500:-500, 0]
    alone = detect(rows[-2000:], p, 200.0)[-1500:-500, 0]
    np.testing.assert_allclose(late, alone, rtol=1e-9)


class TestText:
    def test_numbers_are_printed_as_python_prints_them(self):
        rng = np.random.default_rng(0)
        x = rng.normal(size=(4, 500)) * 10.0 ** rng.integers(-9, 7, (4, 500))
        x[:, :6] = np.array([0.0, -0.0, np.nan, 9.9999996, -0.00000049, 99.5])
        decimals = np.array([6, 8, 0, 2])
        out = np.empty(x.size * text.CELL, np.uint8)
        got = bytes(out[: text.rows(x, decimals, out)]).decode().splitlines()
        assert len(got) == 500
        for line, row in zip(got, x.T, strict=True):
            for cell, value, places in zip(line.split(","), row, decimals, strict=True):
                if np.isnan(value):
                    assert cell == ""
                else:
                    assert len(cell.partition(".")[2]) == places and cell not in ("-0", "-0.00")
                    assert abs(float(cell) - value) <= 0.5 * 10.0**-places * (1 + 1e-9) + 4e-16 * abs(value), (cell, value)

    def test_more_digits_than_a_double_has_are_refused(self):
        out = np.empty(3 * text.CELL, np.uint8)
        for value in (1e10, -1e10, np.inf, -np.inf):
            assert text.rows(np.array([[1.0, value, 2.0]]), np.array([6]), out) == -1
        assert text.rows(np.array([[-9007199254.0]]), np.array([6]), out) <= text.CELL
