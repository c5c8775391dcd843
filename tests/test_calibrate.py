"""Calibration: the truth of simulated sensors, bad input, files."""

import re
from dataclasses import replace

import numpy as np
import pytest

import bematist as bm
from bematist.calibrate import turning
from bematist.calibrate.accelerometer import fit_gravity, up_directions
from bematist.calibrate.axes import blame, changes, described, one_of_each_sign, option, signed_permutations
from bematist.calibrate.correlated import Influence, correlation, spread
from bematist.calibrate.gyroscope import Directions, direction_model
from bematist.calibrate.known import KnownTurn, known_model
from bematist.calibrate.magnetometer import dip_model, norm_full, turn_model
from bematist.calibrate.norm import ellipsoid, norm_model
from bematist.calibrate.rests import find_rests
from bematist.calibrate.samples import Pairs
from bematist.calibrate.turning import Turn
from bematist.calibrate.words import counted, rows
from bematist.errors import DataError, UsageError
from bematist.frames import matrix_from_quaternion, quaternion_from_rotation_vector
from bematist.recording import Sensing
from bematist.simulate import Sensor, simulate_walk
from bematist.simulate.slow import gauss_markov

SMALL = {"rate_hz": 100.0, "magnetometer_rate_hz": 25.0, "tumble_rest_s": 2.0}
DEVICE = Sensor(
    rate_hz=100.0,
    magnetometer_rate_hz=25.0,
    velocity_random_walk=2e-3,
    angle_random_walk=2e-4,
    magnetic_noise_density=0.05,
    accel_bias=(0.3, -0.2, 0.15),
    gyro_bias=(0.01, -0.02, 0.005),
    magnetic_bias=(20.0, -35.0, 10.0),
    accel_errors=((0.02, 0.004, -0.006), (0.002, -0.015, 0.005), (0.0, -0.003, 0.01)),
    gyro_errors=((-0.02, 0.006, 0.004), (-0.005, 0.015, 0.007), (0.003, -0.006, 0.01)),
    soft_iron=((0.1, 0.02, -0.03), (0.01, -0.06, 0.04), (-0.02, 0.03, 0.05)),
)


def tumbled(seed=0, device=DEVICE, **changes):
    return simulate_walk("tumble", device, seed, tumble_rest_s=2.0, **changes)


@pytest.fixture(scope="module")
def made():
    return tumbled()


@pytest.fixture(scope="module")
def found(made):
    return bm.calibrate(made.recording, gravity=made.scenario.gravity, field=made.scenario.field_ut)


def truth(made, sensor):
    e = made.errors
    names = {"accelerometer": ("accel_matrix", "accel_bias"), "gyroscope": ("gyro_matrix", "gyro_bias")}
    matrix, bias = names.get(sensor, ("magnetic_matrix", "magnetic_bias"))
    b = getattr(e, bias)
    return getattr(e, matrix), b if b.ndim == 1 else b[0]


def frame_of(made):
    """Rotation from the body to the frame of the calibration: that in which the accelerometer's inverse matrix is upper triangular."""
    Q, R = np.linalg.qr(np.linalg.inv(truth(made, "accelerometer")[0]))
    return (Q * np.sign(np.diag(R))).T


# ---- equations against finite differences ------------------------------------------------------------------------------------------------


def check_derivatives(model, p, atol):
    r, J = model(p)
    for k in range(len(p)):
        step = np.zeros(len(p))
        step[k] = 1e-6 * max(1.0, abs(p[k]))
        slope = (model(p + step)[0] - model(p - step)[0]) / (2 * step[k])
        np.testing.assert_allclose(J[..., k], slope, atol=atol, err_msg=str(k))
    assert r.shape == J.shape[:-1]


def a_turn(rng, n=40, size=3.0):
    return Turn(0, 1, size * rng.standard_normal((n, 3)), rng.uniform(0.005, 0.03, n))


@pytest.mark.parametrize("symmetric", [True, False])
def test_norm_derivatives(symmetric):
    rng = np.random.default_rng(1)
    p = np.array([1.1, 0.1, -0.2, 0.9, 0.05, 1.2, 0.3, -0.4, 0.1])
    check_derivatives(norm_model(rng.standard_normal((7, 3)) * 5, 4.0, symmetric_matrix=symmetric), p, 1e-7)


def test_magnetometer_derivatives():
    rng = np.random.default_rng(2)
    p = np.concatenate([(np.eye(3) + 0.1 * rng.standard_normal((3, 3))).ravel(), [10.0, -20.0, 5.0], [0.4]])
    m, up = 30 * rng.standard_normal((6, 3)), rng.standard_normal((6, 3))
    R = matrix_from_quaternion(quaternion_from_rotation_vector(rng.standard_normal((6, 3))))
    check_derivatives(norm_full(m, 40.0), p, 1e-6)
    check_derivatives(dip_model(m, up, 40.0), p, 1e-6)
    check_derivatives(turn_model(Pairs(m, 30 * rng.standard_normal((6, 3)), R, np.ones(6), np.arange(12.0).reshape(6, 2))), p, 1e-6)


def test_turn_derivatives():
    rng = np.random.default_rng(3)
    f = rng.standard_normal((2, 3)) * 6
    accel = np.array([1.02, 0.01, -0.02, 0.98, 0.03, 1.01, 0.1, -0.2, 0.3])
    p = np.concatenate([(np.eye(3) + 0.05 * rng.standard_normal((3, 3))).ravel(), accel])

    def up(q):
        return up_directions(f, q)

    turn = a_turn(rng)
    check_derivatives(direction_model([turn], Directions(up(accel)[0], np.ones(2), up)), p, 1e-6)
    check_derivatives(direction_model([turn], Directions(up(accel)[0], np.ones(2))), p, 1e-6)
    whole = Turn(0, 1, np.tile([0.1, -0.05, 2.0], (314, 1)), np.full(314, 0.01))
    for angle in (2 * np.pi, np.pi / 2):
        model = known_model([KnownTurn(whole if angle > 3 else Turn(0, 1, whole.rates[:80], whole.steps[:80]), 2, angle)])
        check_derivatives(model, p, 1e-6)


def plain_turn(w, dt, S):
    """The kernel again, in plain NumPy: attitude matrix, and its derivative by finite steps of S."""

    def attitude(S):
        R = np.eye(3)
        for rate, step in zip(w, dt, strict=True):
            R = R @ matrix_from_quaternion(quaternion_from_rotation_vector(S @ rate * step))
        return R

    R, G = attitude(S), np.empty((3, 9))
    for k in range(9):
        d = np.zeros(9)
        d[k] = 1e-6
        K = R.T @ (attitude(S + d.reshape(3, 3)) - attitude(S - d.reshape(3, 3))) / 2e-6
        G[:, k] = [K[2, 1], K[0, 2], K[1, 0]]
    return R, G


@pytest.mark.parametrize("size", [1e-4, 3.0, 200.0])
def test_turn_kernel_is_its_twin(size):
    rng = np.random.default_rng(4)
    turn, S = a_turn(rng, 30, size), np.eye(3) + 0.05 * rng.standard_normal((3, 3))
    R, G = turning.propagated(S, turn)
    plain_R, plain_G = plain_turn(turn.rates, turn.steps, S)
    np.testing.assert_allclose(R, plain_R, atol=1e-12)
    np.testing.assert_allclose(G, plain_G, atol=1e-6 * max(1.0, np.abs(plain_G).max()))


def test_ellipsoid_is_found_exactly():
    rng = np.random.default_rng(5)
    u = rng.standard_normal((200, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    A = np.array([[1.2, 0.1, 0.0], [0.1, 0.9, -0.1], [0.0, -0.1, 1.1]])
    y = u @ np.linalg.inv(A).T + [3.0, -40.0, 7.0]
    y[:10] += rng.standard_normal((10, 3))  # outliers
    C, b = ellipsoid(y)
    np.testing.assert_allclose(C, A, atol=1e-9)
    np.testing.assert_allclose(b, [3.0, -40.0, 7.0], atol=1e-9)
    assert ellipsoid(rng.standard_normal((30, 1)) * [[1.0, 0.0, 0.0]]) is None


# ---- the truth -------------------------------------------------------------------------------------------------------------------------


def test_rests_are_found(made):
    rests = find_rests([made.recording])
    edges = made.motion.edges.reshape(-1, 2)
    assert len(rests) == len(edges)
    # The turns begin and end with no acceleration: a tenth of a degree is turned before anything shows.
    assert ((rests.start_s > edges[:, 0] - 0.2) & (rests.end_s < edges[:, 1] + 0.2)).all()
    assert rests.seconds.min() > 1.2


@pytest.mark.parametrize("sensor", ["accelerometer", "gyroscope", "magnetometer"])
def test_truth_is_recovered(made, found, sensor):
    M, b = truth(made, sensor)
    s, R = found[sensor], frame_of(made)
    product = s.matrix @ M
    np.testing.assert_allclose(product, R, atol={"accelerometer": 5e-4, "gyroscope": 5e-4, "magnetometer": 1.5e-3}[sensor])
    assert np.abs((s.offset - b) / s.offset_sd).max() < 4
    assert s.after < 0.1 * s.before
    assert not s.missing
    assert not s.undetermined
    assert found.evidence.elevation_deg == pytest.approx(-53.0, abs=0.1)


def test_the_calibrated_recording_is_what_an_ideal_sensor_says(made, found):
    ideal = tumbled(device=Sensor(rate_hz=100.0, magnetometer_rate_hz=25.0)).recording
    better, R = found.apply(made.recording), frame_of(made)
    for name, noise in (("specific_force", 0.02), ("angular_rate", 0.002), ("magnetic_flux_density", 0.25)):
        off = getattr(better, name) - getattr(ideal, name) @ R.T
        assert np.sqrt((off**2).mean()) < 1.1 * noise, name
        worse = getattr(made.recording, name) - getattr(ideal, name)
        assert np.sqrt((worse**2).mean()) > 5 * noise, name


def test_errors_are_as_large_as_claimed():
    """Twelve runs: the errors are as large as claimed (against the Cramér-Rao bound: benchmarks/calibration.py)."""
    scores = {name: [] for name in ("accelerometer", "gyroscope", "magnetometer")}
    for seed in range(12):
        run = tumbled(seed, full_turns=False)
        c = bm.calibrate(run.recording, gravity=run.scenario.gravity, field=run.scenario.field_ut)
        R = frame_of(run)
        for name in scores:
            M, b = truth(run, name)
            s = c[name]
            P = s.covariance
            off = np.concatenate([(s.matrix - R @ np.linalg.inv(M)).ravel(), s.offset - b])
            free = np.diag(P) > 0
            scores[name].append(off[free] / np.sqrt(np.diag(P)[free]))
    for name, z in scores.items():
        rms = np.sqrt(np.mean(np.square(z)))
        assert 0.7 < rms < 1.3, (name, rms)


def test_known_turns_tell_what_gravity_cannot():
    """All rests with one side up, and turns about it: gravity sees nothing of the gyroscope's z axis, a known turn does."""
    made = tumbled(tumble_rests=14, device=DEVICE.override({"magnetometer_rate_hz": 0.0}), full_turns=True)
    told = bm.calibrate(made.recording, gravity=made.scenario.gravity, turns=["x=360", "y=360", "z=-360"])
    assert [t.axis for t in told.evidence.known_turns] == ["x", "y", "z"]
    assert all(abs(t.after - 360) < 0.3 for t in told.evidence.known_turns)
    assert all(abs(t.before - 360) > 2 for t in told.evidence.known_turns)
    assert np.diag(told["gyroscope"].matrix_sd).max() < 1e-3
    with pytest.raises(DataError, match="no turn of 720 degrees about x"):
        bm.calibrate(made.recording, turns=["x=720"])
    with pytest.raises(UsageError, match="such as z=360"):
        bm.calibrate(made.recording, turns=["around"])


# ---- bad input -------------------------------------------------------------------------------------------------------------------------


def test_no_rest():
    walk = simulate_walk("short", DEVICE, rest_s=0.0, final_rest_s=0.0).recording
    with pytest.raises(DataError, match="too few to calibrate the accelerometer"):
        bm.calibrate(walk, sensors=["accelerometer"])


def test_a_rest_that_is_none_is_left_out(made):
    r = made.recording
    a, b = made.motion.edges[4] + 0.1, made.motion.edges[5] - 0.1
    during = (r.time > a) & (r.time < b)
    w, f = r.angular_rate.copy(), r.specific_force.copy()
    w[during] += [0.1, 0.0, 0.0]
    s, c = np.sin(0.1 * (r.time[during] - a)), np.cos(0.1 * (r.time[during] - a))
    y, z = f[during, 1], f[during, 2]
    f[during, 1], f[during, 2] = c * y + s * z, c * z - s * y
    g = r.replace(specific_force=f, angular_rate=w)
    assert find_rests([g]).left_out >= 1
    M, _ = truth(made, "accelerometer")
    C = bm.calibrate(g, gravity=made.scenario.gravity)["accelerometer"].matrix
    np.testing.assert_allclose(C @ M, frame_of(made), atol=1e-3)


def test_a_rest_in_a_lift_is_an_outlier(made):
    r = made.recording
    f = r.specific_force.copy()
    inside = (r.time > made.motion.edges[6]) & (r.time < made.motion.edges[7])
    f[inside] *= 1.03
    c = bm.calibrate(r.replace(specific_force=f), gravity=made.scenario.gravity)
    assert c["accelerometer"].left_out == 1
    assert ", 1 more left out" in counted(c["accelerometer"])
    np.testing.assert_allclose(c["accelerometer"].matrix @ truth(made, "accelerometer")[0], frame_of(made), atol=1e-3)


def test_too_few_directions_are_named(made):
    r = made.recording
    rests = find_rests([r])

    def without(left_out):
        keep = np.ones(len(r), bool)
        for a, b in zip(rests.start_s[left_out], rests.end_s[left_out], strict=True):
            keep &= ~((r.time > a - 0.5) & (r.time < b + 0.5))
        return bm.Recording(time=r.time[keep], specific_force=r.specific_force[keep], angular_rate=r.angular_rate[keep])

    half = bm.calibrate(without(rests.force[:, 2] < 2.0), gravity=made.scenario.gravity)
    assert half["accelerometer"].missing == ("-z",)
    assert any("no rest with -z up" in w for w in half.warnings)
    with pytest.raises(DataError, match=r"no rest with .*-z up"):
        bm.calibrate(without(rests.force[:, 2] < 7.5))


def test_field_that_changed(made):
    r = made.recording
    m = r.magnetic_flux_density.copy()
    half = len(m) // 2
    m[half:] = (m[half:] - DEVICE.magnetic_bias) * 1.6 + DEVICE.magnetic_bias
    c = bm.calibrate(r.replace(magnetic_flux_density=m))
    assert "magnetometer" not in c.sensors
    assert any("was not the same all the time" in w for w in c.warnings)
    with pytest.raises(DataError, match="was not the same all the time"):
        bm.calibrate(r.replace(magnetic_flux_density=m), sensors=["magnetometer"])


def test_a_magnet_that_passes_is_left_out(made, found):
    r = made.recording
    m = r.magnetic_flux_density.copy()
    near = np.abs(r.magnetic_time - 20.0) < 3.0
    m[near] += [15.0, 5.0, -10.0]
    c = bm.calibrate(r.replace(magnetic_flux_density=m), gravity=made.scenario.gravity, field=made.scenario.field_ut)
    assert c["magnetometer"].left_out >= 0.7 * near.sum()
    np.testing.assert_allclose(c["magnetometer"].offset, truth(made, "magnetometer")[1], atol=0.3)


def test_saturated_accelerometer(made):
    r = made.recording
    with pytest.raises(DataError, match=r"one gravity"):
        bm.calibrate(r.replace(specific_force=np.clip(r.specific_force, -6.0, 6.0)), sensors=["accelerometer"])


@pytest.mark.parametrize("scale", [1 / 9.80665, 1000 / 9.80665])
def test_wrong_unit_of_the_accelerometer(made, scale):
    wrong = made.recording.replace(specific_force=made.recording.specific_force * scale)
    with pytest.raises(DataError, match="unit is wrong"):
        bm.calibrate(wrong, sensors=["accelerometer"])


def test_wrong_unit_of_the_gyroscope(made):
    wrong = made.recording.replace(angular_rate=made.recording.angular_rate * 0.2)
    with pytest.raises(DataError, match="miss the directions at rest"):
        bm.calibrate(wrong)


AXES = [("gyroscope", "y,x,z"), ("gyroscope", "x,-y,z"), ("gyroscope", "-x,-y,z"), ("accelerometer", "-x,y,z"), ("magnetometer", "y,x,z")]
AXES += [("magnetometer", "y,z,x"), ("magnetometer", "x,y,-z")]


@pytest.mark.parametrize(("sensor", "axes"), AXES)
def test_wrong_axes_are_found_named_and_put_right(made, sensor, axes):
    P = next(P for P in signed_permutations() if option(P) == axes)
    quantity = {"accelerometer": "specific_force", "gyroscope": "angular_rate", "magnetometer": "magnetic_flux_density"}[sensor]
    wrong = made.recording.replace(**{quantity: getattr(made.recording, quantity) @ P})
    c = bm.calibrate(wrong, gravity=made.scenario.gravity, field=made.scenario.field_ut)
    said = [w for w in c.warnings if w.startswith("Axes: ")]
    assert said == [f"Axes: the {sensor}'s axes do not fit the others': {described(P)} (right: {axes}); the calibration puts them right."]
    better = c.apply(wrong)
    right = bm.calibrate(made.recording, gravity=made.scenario.gravity, field=made.scenario.field_ut).apply(made.recording)
    for name, atol in (("specific_force", 0.02), ("angular_rate", 0.01), ("magnetic_flux_density", 0.3)):
        np.testing.assert_allclose(getattr(better, name), getattr(right, name), atol=atol, err_msg=name)


def test_a_late_magnetometer_is_noticed(made, found):
    r = made.recording
    late = bm.calibrate(r.replace(magnetic_time=r.magnetic_time + 0.043), gravity=made.scenario.gravity, field=made.scenario.field_ut)
    assert re.search(r"stamps are 4[0-6] ms later", late["magnetometer"].note)
    np.testing.assert_allclose(late["magnetometer"].matrix, found["magnetometer"].matrix, atol=2e-3)
    assert not found["magnetometer"].note


def test_axes_in_words():
    P = signed_permutations()
    assert len(P) == 48
    assert (P[0] == np.eye(3)).all()
    assert len(one_of_each_sign()) == 24
    swap = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])
    assert described(swap) == "swap x and y"
    assert changes(swap) == 2
    assert blame(swap, None).sensor == "gyroscope"  # a left-handed gyroscope cannot be the accelerometer's doing
    assert blame(np.diag([1.0, -1, -1]), None).sensor == "accelerometer"
    assert blame(np.diag([1.0, -1, -1]), np.diag([1.0, -1, -1])).sensor == "gyroscope"


def test_several_recordings(made, found):
    r, other = made.recording, tumbled(seed=7).recording
    both = bm.calibrate([r, other], gravity=made.scenario.gravity, field=made.scenario.field_ut)
    assert len(both.evidence.rests) == 2 * len(found.evidence.rests)
    assert (both["accelerometer"].offset_sd < 0.9 * found["accelerometer"].offset_sd).all()
    with pytest.raises(UsageError, match="not of one device"):
        bm.calibrate([r, other.replace(sensing=Sensing(device="7"))])
    with pytest.raises(UsageError, match="no recording"):
        bm.calibrate([])
    with pytest.raises(UsageError, match="no sensor"):
        bm.calibrate(r, sensors=["barometer"])


def test_gravity_fit_alone_uses_the_rests(made):
    alone = fit_gravity(find_rests([made.recording]), made.scenario.gravity, "test")
    assert alone.fit.floors[0] < 0.02


# ---- files and fitting ------------------------------------------------------------------------------------------------------------------


def test_file_gives_the_same_bits(found, made, tmp_path):
    found.save(tmp_path / "sensor.toml")
    again = bm.Calibration.load(tmp_path / "sensor.toml")
    for name, s in found.sensors.items():
        for key in ("offset", "matrix", "covariance"):
            np.testing.assert_array_equal(getattr(again[name], key), getattr(s, key))
    assert again.sensing == found.sensing
    np.testing.assert_array_equal(again.apply(made.recording).specific_force, found.apply(made.recording).specific_force)
    text = (tmp_path / "sensor.toml").read_text("utf-8")
    assert 'unit = "m/s^2"' in text
    assert 'unit = "rad/s"' in text
    assert 'unit = "uT"' in text


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('unit = "rad/s"', 'unit = "deg/s"', "readings are calibrated in rad/s"),
        ("calibration = 1", "calibration = 99", "has the form 99"),
        ("offset = [", "ofset = [", "this is no calibration"),
        ("[accelerometer]", "[acelerometer]", "this is no calibration"),
    ],
)
def test_bad_files(found, tmp_path, old, new, said):
    found.save(tmp_path / "sensor.toml")
    text = (tmp_path / "sensor.toml").read_text("utf-8")
    assert old in text
    (tmp_path / "sensor.toml").write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(UsageError, match=said):
        bm.Calibration.load(tmp_path / "sensor.toml")


def test_recordings_it_was_not_made_for(found, made):
    r = made.recording
    with pytest.raises(DataError, match="other units or axes"):
        found.apply(r.replace(specific_force=r.specific_force / 9.80665))
    with pytest.raises(DataError, match="another channel"):
        found.apply(r.replace(magnetic_flux_density=r.magnetic_flux_density + np.array([400.0, 0, 0])))
    with pytest.raises(DataError, match="calibrated already"):
        found.apply(found.apply(r))
    with pytest.raises(DataError, match="read with --axes"):
        found.apply(r.replace(sensing=Sensing(axes="y,-x,z")))
    marked = bm.Calibration(sensors=found.sensors, sensing=Sensing(device="A"))
    with pytest.raises(DataError, match="of the device B"):
        marked.apply(r.replace(sensing=Sensing(device="B")))
    assert any("device A" in w for w in marked.apply(r).warnings)
    assert any("device B" in w for w in found.apply(r.replace(sensing=Sensing(device="B"))).warnings)
    assert not any("device" in w for w in found.apply(r).warnings)
    slower, gyroscope = replace(found, rate_hz=50.0), found["gyroscope"]
    assert any("at 50 Hz and the recording has 100 Hz. Neither" in w for w in slower.apply(r).warnings)
    other = replace(found, sensors={**found.sensors, "gyroscope": replace(gyroscope, offset=gyroscope.offset + np.radians([3.0, 0, 0]))})
    assert any("°/s without it and 3." in w for w in other.apply(r).warnings)
    walk = simulate_walk("short", DEVICE).recording
    assert found.apply(walk).notes[-1].startswith("Calibration: accelerometer, gyroscope, magnetometer")


def test_errors_that_hang_together_are_found_out():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.choice([0.04, 0.04, 0.04, 1.0], 3000, p=[0.33, 0.33, 0.33, 0.01]))
    along = rng.standard_normal((1, 3)) + np.column_stack([np.sin(time), np.cos(time), np.sin(0.4 * time)])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    white = rng.standard_normal((3000, 3))
    error = white.copy()
    for k in range(1, len(time)):
        keep = np.exp(-(time[k] - time[k - 1]) / 0.5)
        error[k] = keep * error[k - 1] + np.sqrt(1 - keep**2) * white[k]
    mixed = np.sqrt(0.7) * error + np.sqrt(0.3) * rng.standard_normal((3000, 3))
    share, seconds = correlation((mixed * along).sum(1), along, time)
    assert share == pytest.approx(0.7, abs=0.08)
    assert seconds == pytest.approx(0.5, rel=0.45)  # of some 300 that are independent
    assert correlation((white * along).sum(1), along, time)[0] == 0.0


def test_spread_of_errors_that_hang_together():
    """Against the sum over all pairs; a sample that is used twice counts with both."""
    rng = np.random.default_rng(1)
    time, gain = np.sort(rng.uniform(0, 3, 30)), rng.standard_normal((30, 4, 3))
    sd = rng.uniform(0.5, 2, 30)
    twice = Influence(time[:5], sd[:5], rng.standard_normal((5, 4, 3)))
    whole = gain * sd[:, None, None]
    whole[:5] += twice.gain * sd[:5, None, None]
    rho = 0.6 * np.exp(-np.abs(time[:, None] - time) / 0.4)
    np.fill_diagonal(rho, 1.0)
    by_hand = np.einsum("iae,ij,jbe->ab", whole, np.where(np.abs(time[:, None] - time) < 6 * 0.4, rho, 0), whole)
    np.testing.assert_allclose(spread([Influence(time, sd, gain), twice], 0.6, 0.4), by_hand, rtol=1e-10)


def test_claims_hold_with_errors_that_hang_together():
    """A field that varies over the way of the hand, 0.5 µT over 0.5 s: as white noise it would be believed three times too much."""
    off = []
    for seed in range(3):
        m = tumbled(seed)
        rng, n = np.random.default_rng(seed), len(m.recording.magnetic_time)
        error = 0.5 * gauss_markov(3 * n, 0.04, 0.5, rng).reshape(3, n).T
        r = m.recording.replace(magnetic_flux_density=m.recording.magnetic_flux_density + error)
        c = bm.calibrate(r, gravity=m.scenario.gravity, field=m.scenario.field_ut, sensors=("magnetometer",))["magnetometer"]
        off.append((c.offset - m.errors.magnetic_bias) / c.offset_sd)
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 2.2


def test_table_says_what_is_fixed(found):
    cells = [cell for row in rows(found["accelerometer"]) for cell in row]
    assert "0, fixed" in cells and not any("± 0.00000" in c for c in cells)


def test_gravity_that_is_a_little_off_is_said(made, found):
    said = found.apply(made.recording).warnings
    assert not any("off gravity" in w for w in said)
    doubted = found.apply(made.recording.replace(specific_force=1.03 * made.recording.specific_force)).warnings
    assert any("+3." in w or "+2." in w for w in doubted if "off gravity" in w)
