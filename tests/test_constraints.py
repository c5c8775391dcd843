"""ZARU, HDR, MARU and the adaptive threshold: against their twins, finite differences, and truths that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import bematist as bm
import twin_constraints
from bematist import frames
from bematist.foot import FootIns, FootParameters
from bematist.foot.setup import initial_covariance, kernel_parameters
from bematist.kernels import constraints, layout, pace
from bematist.recording import Recording
from bematist.simulate import simulate_walk
from bematist.simulate.parameters import Sensor
from bematist.stance import StanceParameters, detect
from walks import FIELD, shaken

RATE = 200.0

# ---- derivatives -----------------------------------------------------------------------------------------------------


@njit
def yaw_row(w, x, y, z, axis):
    return constraints.yaw_row(w, x, y, z, axis)


@given(st.integers(0, 2**31), st.integers(0, 1))
@settings(max_examples=50, deadline=None)
def test_the_row_of_the_yaw_is_its_derivative(seed, axis):
    C = Rotation.random(random_state=seed).as_matrix()
    if np.hypot(*C[:2, axis]) < 0.2:  # upright: it has no yaw
        return
    yaw, *row = yaw_row(*frames.quaternion_from_matrix(C), float(axis))
    assert yaw == pytest.approx(twin_constraints.yaw(C, axis), abs=1e-12)

    def turned(psi):
        return twin_constraints.yaw(Rotation.from_rotvec(psi).as_matrix() @ C, axis)

    J = [twin_constraints.wrapped(turned(1e-6 * e) - turned(-1e-6 * e)) / 2e-6 for e in np.eye(3)]
    np.testing.assert_allclose([*row, 1.0], J, atol=1e-7)
    np.testing.assert_allclose(twin_constraints.yaw_row(C, axis), J, atol=1e-7)


def test_the_rows_of_the_turned_field_are_their_derivative():
    """The field turned on by a gyroscope whose offset is wrong by x, against the field that is measured."""
    rng = np.random.default_rng(0)
    w, T, steps = rng.normal(0, 0.02, 3), 0.4, 80
    m = FIELD @ Rotation.random(random_state=3).as_matrix()
    start = Rotation.from_rotvec(w * T).as_matrix() @ m

    def predicted(x):
        field = start
        for _ in range(steps):
            field = Rotation.from_rotvec(-(w + x) * T / steps).as_matrix() @ field
        return field

    J = np.stack([(predicted(1e-6 * e) - predicted(-1e-6 * e)) / 2e-6 for e in np.eye(3)], 1)
    # The row is of first order in the angle turned, here 0.01 rad.
    np.testing.assert_allclose(twin_constraints.field_rows(m, T), J, atol=0.01 * T * np.linalg.norm(m))
    np.testing.assert_allclose(predicted(np.zeros(3)), m, atol=1e-10)


# ---- against the twins -----------------------------------------------------------------------------------------------


def run_both(p, recording):
    """The compiled filter and its dense twin: position, attitude, offset, diagnostics, covariance of the offset."""
    ins = FootIns(p)
    got = ins.run(recording)
    a, rate = ins.alignment, ins.alignment.rate_hz
    n = p.noise
    psd = np.square([n.angle_random_walk, n.velocity_random_walk, 0, n.accel_bias_walk, n.gyro_bias_walk])
    C = frames.matrix_from_quaternion(a.attitude)
    dense = twin_constraints.Constrained(C, a.gyro_bias, initial_covariance(p, a), psd, p.gravity, p=p, rate_hz=rate)
    rows = recording.samples()
    statistic = detect(rows, p.stance, rate)[:, 0]
    pace = twin_constraints.Pace(p.stance.pace, rate)
    kept = {name: [] for name in ("position", "C", "gyro_bias", "P", "zaru_nis", "hdr_innovation", "maru_nis", "pace")}
    for k in range(len(rows)):
        limit = p.stance.limits[pace.now] if p.stance.rule == "adaptive" and len(pace.means) else p.stance.limit
        kept["pace"].append(pace.now)
        dt = rows[k, 0] - rows[k - 1, 0] if k else 0.0
        sd = p.zero_velocity.sd if statistic[k] < limit else 0.0
        m = rows[k, 7:10] if np.isfinite(rows[k, 7]) else None
        if k:
            dense.step(rows[k, 1:4], rows[k, 4:7], dt, sd)
        elif sd > 0:
            dense.zero_velocity(sd)
        dense.constrain(rows[k, 4:7], dt, sd > 0, m)
        pace.take(np.linalg.norm(dense.v))
        now = dense.p, dense.C, dense.bg, dense.P[12:15, 12:15]
        for name, value in zip(("position", "C", "gyro_bias", "P"), now, strict=True):
            kept[name].append(value.copy())
        for name in ("zaru_nis", "hdr_innovation", "maru_nis"):
            kept[name].append(getattr(dense, name))
    return got, {name: np.array(v) for name, v in kept.items()}


CHOICES = {
    "zaru": {"zaru": {"use": "rest", "after_s": 0.1, "correlation_s": 0.02}},
    "zaru in stance": {"zaru": {"use": "stance", "correlation_s": 0.0, "sd": 0.1}},
    "hdr": {"hdr": {"use": "stance", "tolerance": 0.5, "sd": 0.02}},
    "hdr by sample": {"hdr": {"use": "sample", "longest_s": 0.3, "tolerance": 0.5}},
    "maru": {"maru": {"use": True, "interval_s": 0.1}},
    "maru of successive samples": {"maru": {"use": True, "interval_s": 0.0}},
    "all, adaptive": {
        "zaru": {"use": "rest", "after_s": 0.1},
        "hdr": {"use": "stance", "tolerance": 0.5},
        "maru": {"use": True, "interval_s": 0.05},
        "stance": {"rule": "adaptive", "pace": {"window_s": 0.5, "walk_speed": 0.05, "run_speed": 0.2, "run_threshold": 400.0}},
    },
}


@pytest.mark.parametrize("name", CHOICES)
def test_the_filter_equals_its_dense_twin(name):
    p = FootParameters().override(CHOICES[name])
    got, want = run_both(p, shaken())
    np.testing.assert_allclose(got.position, want["position"], atol=1e-8)
    np.testing.assert_allclose(frames.matrix_from_quaternion(got.attitude), want["C"], atol=1e-9)
    d = got.diagnostics
    np.testing.assert_allclose(d["gyro_bias"], want["gyro_bias"], rtol=1e-5, atol=1e-9)
    variance = np.diagonal(want["P"], axis1=1, axis2=2)
    np.testing.assert_allclose(d["gyro_bias_sd"], np.sqrt(variance), rtol=1e-5)
    used = {"zaru_nis": p.zaru.use != "off", "hdr_innovation": p.hdr.use != "off", "maru_nis": p.maru.use}
    for column, on in used.items():
        np.testing.assert_allclose(d[column], want[column], rtol=1e-4, atol=1e-7)
        assert np.isfinite(d[column]).sum() > 5 if on else not np.isfinite(d[column]).any(), column
    if p.stance.rule == "adaptive":
        np.testing.assert_array_equal(d["pace"], want["pace"])
        assert set(d["pace"]) == {0, 1, 2}
        np.testing.assert_allclose(d["stance_threshold"][300:], np.array(p.stance.limits)[want["pace"][300:]], rtol=1e-6)


@njit
def classes(S, prm, speeds, out):
    for k in range(len(speeds)):
        S[layout.V] = speeds[k]
        pace.follow(S, prm)
        out[k] = S[layout.CLASS]


@pytest.mark.parametrize("n", [1, 2, 7, 100])
def test_windows_of_the_speed_equal_whole_histories(n):
    p = StanceParameters(rule="adaptive", pace={"window_s": n / RATE})
    ins = FootIns(FootParameters(stance=p))
    ins.update(shaken().samples()[:2500])
    prm, _ = kernel_parameters(ins.parameters, ins.alignment, RATE)
    S = np.zeros(layout.WORKSPACE_SIZE + 2 * n)
    S[layout.CLASS] = layout.WALKING
    speeds = np.abs(np.random.default_rng(n).normal(0, 2.2, 3000)) * (1 + np.sin(np.arange(3000) / 200))
    got = np.empty(3000)
    classes(S, prm, speeds, got)
    plain, want = twin_constraints.Pace(p.pace, RATE), []
    for v in speeds:
        plain.take(v)
        want.append(plain.now)
    np.testing.assert_array_equal(got, want)
    assert len(set(want)) == 3


# ---- simulate and recover --------------------------------------------------------------------------------------------


def at_rest(seed, seconds=30.0, rate=100.0, turn=0.0, disturbed=False):
    """A sensor at rest, or turning slowly about the vertical after 3 s, with a constant offset; and the offset."""
    rng = np.random.default_rng(seed)
    n = round(seconds * rate)
    bias = rng.normal(0, 0.01, 3)
    t = np.arange(n) / rate
    spin = np.where(t > 3, turn, 0.0)
    C = Rotation.from_rotvec(np.cumsum(spin)[:, None] / rate * [0, 0, 1.0])
    field = np.tile([5.0, 20.0, -40.0], (n, 1)) + rng.normal(0, 0.5, (n, 3))
    if disturbed:
        field[:] = np.array([-15.0, 8.0, -25.0]) + rng.normal(0, 0.5, (n, 3))
    w = np.column_stack([0 * t, 0 * t, spin]) + bias + rng.normal(0, 0.01, (n, 3))
    m = C.inv().apply(field)
    f = np.tile([0, 0, 9.80665], (n, 1)) + rng.normal(0, 0.02, (n, 3))
    return Recording(time=t, specific_force=f, angular_rate=w, magnetic_time=t, magnetic_flux_density=m), bias


# The start is told nothing of the offset, so that what is known of it at the end comes from the update.
BLIND = {
    "initial": {"longest_s": 1.0, "sway": 10.0, "gyro_bias_sd": 0.01},
    "noise": {"angle_random_walk": 1e-3, "gyro_bias_walk": 0.0},
    "stance": {"threshold": 1e4},
}
SEEDS = 20


def nees(**changes):
    """NEES of the gyroscope's offset after 30 s, and its errors (rad/s), over the seeds."""
    how = {k: changes.pop(k) for k in ("turn", "disturbed") if k in changes}
    found, errors = [], []
    for seed in range(SEEDS):
        r, bias = at_rest(seed, **how)
        ins = FootIns(FootParameters().override(BLIND).override(changes))
        ins.run(r)
        S = ins.save()["state"][2]
        P = S[:240].reshape(15, 16)[12:15, 12:15]
        e = S[layout.BG : layout.BG + 3] - bias
        found.append(e @ np.linalg.solve(P, e))
        errors.append(e)
    return np.array(found), np.array(errors)


LOW, HIGH = chi2.ppf([0.0005, 0.9995], 3 * SEEDS) / SEEDS


def test_zaru_recovers_the_offset_and_knows_how_well():
    found, e = nees(zaru={"use": "rest", "sd": 0.01, "correlation_s": 0.0})
    assert LOW < found.mean() < HIGH, found.round(2)
    assert np.sqrt((e**2).mean()) < 3e-4
    _, without = nees()
    assert np.sqrt((without[:, 2] ** 2).mean()) > 5e-3  # zero velocity does not see it about the vertical


def test_maru_recovers_the_offset_of_a_turning_sensor_even_in_a_disturbed_field():
    """A slow turn, which ZARU takes for an offset: the field tells them apart."""
    for disturbed in (False, True):
        found, e = nees(maru={"use": True, "interval_s": 5.0}, turn=0.1, disturbed=disturbed)
        assert np.sqrt((e[:, 2] ** 2).mean()) < 6e-3  # 0.01 before; the field says least of the turn about its own direction
        # Successive intervals share a sample, whose noise cancels in their sum: the filter is less sure than it might be, never surer.
        assert found.mean() < HIGH, found.round(2)
    _, wrong = nees(zaru={"use": "rest"}, turn=0.1)
    assert np.abs(wrong[:, 2].mean() - 0.1) < 0.01


def test_successive_samples_say_far_less_than_long_intervals():
    """Erratum of MAGYQ eq 42: as printed, each sample's noise counts twice."""
    _, short = nees(maru={"use": True, "interval_s": 0.0}, turn=0.05)
    _, long = nees(maru={"use": True, "interval_s": 2.0}, turn=0.05)
    assert np.sqrt((long[:, 2] ** 2).mean()) < 0.4 * np.sqrt((short[:, 2] ** 2).mean())


GYRO = Sensor(rate_hz=100, magnetometer_rate_hz=0, angle_random_walk=2e-4, velocity_random_walk=0.002, gyro_bias_sd=0.004)
# Little rest at the start, so that an offset is left that bends the path.
SHORT_REST = {"initial": {"gyro_bias_sd": 0.005, "longest_s": 3.0}, "noise": {"angle_random_walk": 5e-4}}


def heading_error(waypoints, use, seed, direction_sd_deg=0.0):
    """Error of the heading at the end, degrees, of a walk whose prints scatter by this many degrees."""
    gaits = ((0.0, {"direction_sd_deg": direction_sd_deg}),)
    walk = simulate_walk("straight", GYRO, seed=seed, waypoints=waypoints, length_m=None, rest_s=0.6, final_rest_s=0.5, gaits=gaits)
    t = bm.track(walk.recording, "zupt", hdr={"use": use, "sd": np.radians(0.2)}, **SHORT_REST)
    error = t.euler[:, 2] - walk.truth.euler[:, 2]
    error = twin_constraints.wrapped(error - error[20])
    return np.degrees(np.abs(error[-20:].mean()))


def test_hdr_holds_the_heading_on_a_corridor_and_bends_it_in_a_curve():
    straight = ((0.0, 0.0, 0.0), (60.0, 0.0, 0.0))
    free, held = ([heading_error(straight, use, s) for s in range(5)] for use in ("off", "stance"))
    assert np.median(held) < 0.6 * np.median(free), (held, free)
    # A curve of 2.2 degrees a stride is within the tolerance, and taken for drift.
    angle = np.arange(0, np.pi, 0.02)
    curve = tuple((35 * np.sin(a), 35 - 35 * np.cos(a), 0.0) for a in angle)
    bent, left = ([heading_error(curve, use, s) for s in range(2)] for use in ("stance", "off"))
    assert min(bent) > 40 and max(left) < 8, (bent, left)


def test_hdr_leaves_who_stands_alone():
    """Standing turns nothing, and yields no measurement of the heading after its first moment."""
    r, _ = at_rest(0)
    for use in ("stance", "sample"):
        t = bm.track(r, "zupt", hdr={"use": use})
        assert not np.isfinite(t.diagnostics["hdr_innovation"]).any()


def test_a_gap_ends_what_the_constraints_remember():
    r = shaken(4000)
    p = FootParameters().override(CHOICES["all, adaptive"])
    keep = np.ones(4000, bool)
    keep[3000:3060] = False
    t = FootIns(p).run(r.replace(time=r.time[keep], specific_force=r.specific_force[keep], angular_rate=r.angular_rate[keep]))
    after = np.flatnonzero(t.diagnostics["bridged"] == layout.BRIDGED_OVER)[0]
    stances = t.stance_intervals()
    judged = np.flatnonzero(np.isfinite(t.diagnostics["hdr_innovation"]))
    assert (judged < after).any()
    third = stances[stances[:, 1] > after][2]
    assert not ((judged > after) & (judged < third[0])).any() and (judged > third[0]).any()


# ---- adaptive threshold on walks and runs ----------------------------------------------------------------------------


def shares(trajectory):
    """Shares of slow, walking and running while the foot is under way."""
    p = trajectory.diagnostics["pace"]
    moving = np.flatnonzero(np.linalg.norm(trajectory.velocity, axis=1) > 1)
    p = p[moving[0] + 200 : moving[-1]]
    return [float((p == k).mean()) for k in range(3)]


@pytest.mark.parametrize("method", ["15mzha", "zupt"])
def test_the_class_follows_a_simulated_change_of_gait(method):
    gaits = ((0.0, "walk"), (40.0, "run"), (100.0, "walk"))
    line = ((0.0, 0.0, 0.0), (140.0, 0.0, 0.0))
    made = simulate_walk("straight", "lsm9ds1", seed=1, waypoints=line, length_m=None, gaits=gaits)
    t = bm.track(made.recording, method, stance={"rule": "adaptive"})
    east = made.truth.position[:, 0]
    for low, high, kind in ((10, 38, 1), (48, 98, 2), (112, 135, 1)):
        p = t.diagnostics["pace"][(east > low) & (east < high)]
        assert (p == kind).mean() > 0.9, (low, high, np.bincount(p.astype(int)))


@pytest.mark.parametrize(
    ("path", "running"),
    [
        ("gsu_gx5/SensorConnectData_32.csv", False),
        ("pyshoe_vicon/2017-11-22-11-30-14.mat", False),
        ("gsu_gx5/SensorConnectData_35.csv", True),
        ("pyshoe_vicon/2017-11-27-11-18-11.mat", True),
        ("pyshoe_vicon/2017-12-15-18-01-18.mat", True),
    ],
)
def test_the_class_follows_real_walks_and_runs(shared_data, path, running):
    found = shares(bm.track(bm.read(shared_data / "foot" / path), "15mzha"))
    assert found[2] > 0.6 if running else found[1] > 0.9, found
    assert running or found[2] == 0


def test_the_adaptive_threshold_finds_the_stances_of_runs(shared_data):
    """What eq 36 is for; the limits are those of docs/stance.md."""
    errors = {}
    for name in ("2017-11-27-11-18-11", "2017-12-15-18-01-18"):
        r = bm.read(shared_data / "foot/pyshoe_vicon" / f"{name}.mat")
        for rule in ("absolute", "adaptive"):
            t = bm.track(r, "zupt", stance={"rule": rule})
            errors[name, rule] = bm.evaluate(t, r.reference, align="yaw").to_dict()["ate_rmse_2d_m"]
    assert errors["2017-11-27-11-18-11", "adaptive"] < 2 * 0.136 < 2 < errors["2017-11-27-11-18-11", "absolute"]
    assert errors["2017-12-15-18-01-18", "adaptive"] < 2 * 0.070 < 1 < errors["2017-12-15-18-01-18", "absolute"]
