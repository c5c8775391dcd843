"""What the simulated sensor makes of the truth: each error as asked, and reported."""

import time

import allantools
import numpy as np
import pytest

from bematist.earth import STANDARD_GRAVITY
from bematist.simulate import SENSORS, Sensor, simulate, simulate_walk
from bematist.simulate.slow import exact_flicker, flicker, gauss_markov


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
    x = flicker(2.0, 100_000, np.random.default_rng(0))
    for tau in (10, 30, 100, 300):
        assert allan_deviation(x, 1.0, tau) == pytest.approx(0.664 * 2.0, rel=0.15), tau
    assert not flicker(0.0, 10, np.random.default_rng(0)).any()


@pytest.mark.parametrize("rate", [50.0, 238.0])
def test_flicker_reaches_down_to_a_sample(rate):
    made = simulate_walk(
        "still", "ideal", rest_s=4e5 / rate, rate_hz=rate, magnetometer_rate_hz=0, gyro_bias_instability=2.0, flicker_from_s=0.0
    )
    for samples, tolerance in ((1, 0.005), (2, 0.005), (5, 0.01), (30, 0.02), (100, 0.03), (1000, 0.1)):
        found = allan_deviation(made.errors.gyro_bias[1:], rate, samples / rate)
        assert found == pytest.approx(0.66428 * 2.0, rel=tolerance), samples
    slow = simulate_walk("still", "ideal", rest_s=10.0, rate_hz=rate, magnetometer_rate_hz=0, gyro_bias_instability=2.0)
    assert allan_deviation(slow.errors.gyro_bias[1:], rate, 1 / rate) < 0.2


def test_flicker_has_the_covariance_of_flicker():
    """Of its steps, over 6000 short records, against the fourth difference of k² ln k / 2π; numbers by hand for lags 0 to 3."""
    steps = np.diff(np.concatenate([exact_flicker(20, np.random.default_rng(k)).T for k in range(2000)]), axis=1)
    found = [np.mean(steps[:, : 19 - k] * steps[:, k:]) for k in range(4)]
    ln2, ln3, ln5 = np.log([2, 3, 5])
    by_hand = np.array([8 * ln2, 9 * ln3 - 16 * ln2, 56 * ln2 - 36 * ln3, 25 * ln5 + 54 * ln3 - 144 * ln2]) / (2 * np.pi)
    assert found == pytest.approx(by_hand, abs=0.015)


def test_what_else_is_drawn_is_the_same_with_exact_flicker_and_without():
    one, other = (simulate_walk("short", "lsm9ds1", 4, flicker_from_s=x) for x in (0.0, 3.0))
    for name in ("accel_matrix", "magnetic_bias", "gyro_g_sensitivity"):
        np.testing.assert_array_equal(getattr(one.errors, name), getattr(other.errors, name))
    np.testing.assert_array_equal(one.recording.magnetic_flux_density, other.recording.magnetic_flux_density)
    assert np.abs(one.errors.gyro_bias - other.errors.gyro_bias).max() > 0


def test_correlated_noise():
    x = gauss_markov(400_000, 0.1, 5.0, np.random.default_rng(0))
    assert x.std() == pytest.approx(1.0, abs=0.03)
    assert np.mean(x[50:] * x[:-50]) == pytest.approx(np.exp(-1), abs=0.03)
    made = simulate_walk(
        "still", "ideal", rest_s=4000.0, rate_hz=10.0, magnetometer_rate_hz=0, accel_correlated_sd=0.3, accel_correlation_s=2.0
    )
    assert made.errors.accel_bias.std() == pytest.approx(0.3, rel=0.05)
    assert not made.errors.gyro_bias.any()


def test_saturation_clips():
    r = simulate("short", "lsm9ds1", gyro_range=5.0, accel_range=15.0)
    assert np.abs(r.angular_rate).max() == 5.0
    assert np.abs(r.specific_force).max() == 15.0


HOURS = 5


@pytest.fixture(scope="module")
def still():
    before = time.process_time()
    made = simulate_walk("still", "lsm9ds1", rest_s=3600.0 * HOURS)
    return made, time.process_time() - before


def test_hours_of_rest_are_made_in_seconds(still):
    made, seconds = still
    assert len(made.recording) == 3600 * HOURS * 238 + 1 and len(made.recording.magnetic_time) == 3600 * HOURS * 80 + 1
    assert seconds < 15  # about 3 s
    assert made.truth.stance.all() and not made.truth.velocity.any()
    assert made.truth.packed_covariance.nbytes > 100 * made.truth.packed_covariance.base.nbytes  # zeros that take no memory


@pytest.mark.parametrize(
    ("quantity", "density", "instability"),
    [("angular_rate", "angle_random_walk", "gyro_bias_instability"), ("specific_force", "velocity_random_walk", "accel_bias_instability")],
)
def test_allan_deviation_returns_the_preset(still, quantity, density, instability):
    made, _ = still
    N, B = getattr(made.sensor, density), getattr(made.sensor, instability)
    taus = np.array([0.1, 1.0, 10.0, 100.0, 200.0, 400.0])
    axes = getattr(made.recording, quantity).T
    found = [allantools.oadev(axis, rate=made.sensor.rate_hz, data_type="freq", taus=taus)[1] for axis in axes]
    sigma = np.sqrt(np.mean(np.square(found), axis=0))
    # White noise: N at 1 s, slope -1/2; what flicker adds there is known. Then both together, and at last the floor.
    assert np.sqrt(sigma[0] ** 2 - (0.4 * B) ** 2) * np.sqrt(0.1) == pytest.approx(N, rel=0.02)
    model = np.sqrt(N**2 / taus + (0.664 * B) ** 2)
    assert sigma[1] == pytest.approx(N, rel=0.05)
    assert sigma[2] == pytest.approx(model[2], rel=0.06)
    np.testing.assert_allclose(sigma[3:], model[3:], rtol=0.2)
    if N / np.sqrt(taus[-1]) < 0.1 * B:
        assert sigma[3:].mean() == pytest.approx(0.664 * B, rel=0.12)


def test_rate_random_walk():
    made = simulate_walk("still", "ideal", rest_s=20_000.0, rate_hz=2.0, magnetometer_rate_hz=0, gyro_rate_random_walk=1e-4)
    _, sigma, _, _ = allantools.oadev(made.recording.angular_rate[:, 0], rate=2.0, data_type="freq", taus=[100.0, 400.0])
    np.testing.assert_allclose(sigma, 1e-4 * np.sqrt(np.array([100.0, 400.0]) / 3), rtol=0.35)  # K sqrt(tau / 3)


def test_scale_misalignment_iron_and_g_sensitivity_are_reported():
    drawn = {"accel_scale_sd": 0.01, "gyro_scale_sd": 0.02, "magnetic_scale_sd": 0.03, "accel_misalignment_sd": 0.005}
    drawn |= {"gyro_misalignment_sd": 0.004, "magnetic_misalignment_sd": 0.02, "gyro_g_sensitivity_sd": 1e-4, "magnetic_bias_sd": 10.0}
    ideal, made = (simulate_walk("short", "ideal", seed=5, accel_bias=b, **d) for b, d in (((0, 0, 0), {}), ((0.1, -0.2, 0.3), drawn)))
    e = made.errors
    f, w, m = (getattr(ideal.recording, name) for name in ("specific_force", "angular_rate", "magnetic_flux_density"))
    np.testing.assert_allclose(made.recording.specific_force, f @ e.accel_matrix.T + e.accel_bias, atol=1e-12)
    np.testing.assert_allclose(made.recording.angular_rate, w @ e.gyro_matrix.T + f @ e.gyro_g_sensitivity.T + e.gyro_bias, atol=1e-12)
    np.testing.assert_allclose(made.recording.magnetic_flux_density, m @ e.magnetic_matrix.T + e.magnetic_bias, atol=1e-11)
    np.testing.assert_allclose(e.accel_bias[0], [0.1, -0.2, 0.3])
    # Found again from the samples alone, as a calibration would: least squares of the twelve numbers.
    solved = np.linalg.lstsq(np.column_stack([m, np.ones(len(m))]), made.recording.magnetic_flux_density)[0]
    np.testing.assert_allclose(solved, np.vstack([e.magnetic_matrix.T, e.magnetic_bias]), atol=1e-6)
    many = [simulate_walk("still", "ideal", seed=k, rest_s=1.0, magnetometer_rate_hz=0, **drawn).errors for k in range(200)]
    off = np.array([x.accel_matrix for x in many]) - np.eye(3)
    assert off[:, [0, 1, 2], [0, 1, 2]].std() == pytest.approx(0.01, rel=0.1)
    assert off[:, [0, 0, 1], [1, 2, 2]].std() == pytest.approx(0.005, rel=0.1)


def test_fixed_errors_are_taken_as_they_are():
    iron = ((0.1, 0.02, 0), (0.02, -0.05, 0.01), (0, 0.01, 0.03))
    made = simulate_walk("still", "ideal", rest_s=1.0, soft_iron=iron, gyro_errors=((0.01, 0, 0), (0, 0, 0.002), (0, 0, 0)))
    np.testing.assert_array_equal(made.errors.magnetic_matrix, np.eye(3) + iron)
    np.testing.assert_array_equal(made.errors.gyro_matrix, [[1.01, 0, 0], [0, 1, 0.002], [0, 0, 1]])


def test_jittered_stamps_stay_in_order_and_the_truth_keeps_its_times():
    made = simulate_walk("short", "ideal", jitter_s=2e-3)
    off = made.recording.time - made.truth.time
    assert (np.diff(made.recording.time) > 0).all()
    assert 1e-3 < off.std() < 2.1e-3
    np.testing.assert_array_equal(made.truth.time, simulate_walk("short", "ideal").recording.time)


def test_adis16488_is_that_of_its_paper():
    s = SENSORS["adis16488"]
    # MAGYQ, Tables 1 and 2 with the errata: degrees, means of the axes; the floor of the Allan deviation is 0.664 of the instability.
    assert np.degrees(s.angle_random_walk) == pytest.approx(np.mean([0.00413, 0.00445, 0.00442]), rel=0.01)
    assert np.degrees(s.gyro_bias_instability) * 0.664 == pytest.approx(np.mean([0.00117, 0.00121, 0.00105]), rel=0.01)
    assert np.degrees(s.gyro_rate_random_walk) * 60 == pytest.approx(np.mean([0.00158, 0.00142, 0.00157]), rel=0.01)
    assert s.velocity_random_walk / STANDARD_GRAVITY * 1e3 == pytest.approx(np.mean([0.0650, 0.0717, 0.0639]), rel=0.01)
    assert s.accel_bias_instability / STANDARD_GRAVITY * 1e3 * 0.664 == pytest.approx(np.mean([0.1223, 0.0326, 0.0626]), rel=0.01)
    r = simulate("short", "adis16488")
    assert r.rate_hz == pytest.approx(100)
    assert np.abs(r.angular_rate).max() <= np.radians(450)  # a foot turns faster than this sensor can


def test_own_rates():
    r = simulate("short", Sensor(rate_hz=150.0, magnetometer_rate_hz=33.0))
    assert (r.rate_hz, 1 / np.median(np.diff(r.magnetic_time))) == (pytest.approx(150), pytest.approx(33))
