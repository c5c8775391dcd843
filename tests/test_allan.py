"""Allan deviation against published tables, a peer, the plain definition and simulated noises."""

import allantools
import numpy as np
import pytest
from allantools import ci

import bematist as bm
from bematist.allan.covariance import Overlap
from bematist.allan.deviation import Stretches, averaging_spans, overlapping_variance, stretches
from bematist.allan.fit import Estimate, Fit, fit_noises
from bematist.allan.noises import FLICKER_FLOOR, NOISES, markov_variance, phase_covariance, shapes
from bematist.allan.result import AllanResult, SensorAllan
from bematist.allan.spectrum import fitted_density, spectral_density
from noise_makers import made

NBS_MONOGRAPH_140 = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0]
"""NBS Monograph 140, annex 8.E, as in NIST SP 1065 table 29."""


def whole(values: np.ndarray, period_s: float = 1.0) -> Stretches:
    return Stretches((slice(0, len(values)),), period_s)


def deviation(values: np.ndarray, spans: list[int]) -> np.ndarray:
    return np.sqrt(overlapping_variance(np.asarray(values, float), whole(values), np.array(spans)))


def test_nbs_14() -> None:
    """NIST SP 1065 table 30, overlapping Allan deviation."""
    assert deviation(np.array(NBS_MONOGRAPH_140), [1, 2]) == pytest.approx([91.22945, 85.95287], abs=5e-6)


def test_nbs_1000_points() -> None:
    """NIST SP 1065 section 12.4 and table 31: the data come from its congruential generator."""
    n = [1234567890]
    for _ in range(999):
        n.append(16807 * n[-1] % 2147483647)
    assert n[1:4] == [395529916, 1209410747, 633705974]
    values = np.array(n) / 2147483647
    assert values.mean() == pytest.approx(4.897745e-1, abs=5e-8)
    assert deviation(values, [1, 10, 100]) == pytest.approx([2.922319e-1, 9.159953e-2, 3.241343e-2], rel=2e-7)


@pytest.mark.parametrize("n", [100, 4097, 50_000])
@pytest.mark.parametrize("spacing", ["octave", "decade"])
def test_agrees_with_allantools(n: int, spacing: str) -> None:
    values = 9.8 + np.cumsum(np.random.default_rng(n).standard_normal(n)) * 1e-3 + np.random.default_rng(1).standard_normal(n)
    spans = averaging_spans(n, spacing)  # pyright: ignore[reportArgumentType]
    taus, theirs, _, _ = allantools.oadev(values, rate=100.0, data_type="freq", taus=spans / 100)
    assert taus == pytest.approx(spans / 100)
    assert np.abs(deviation(values, list(spans)) / theirs - 1).max() < 1e-10


def test_gaps_are_not_averaged_over() -> None:
    """Against the plain definition: second differences of sums within a stretch."""
    rng = np.random.default_rng(3)
    time = np.delete(np.arange(3000) * 0.01, np.r_[700:760, 1500:1501])
    values = rng.standard_normal(len(time))
    pieces = stretches(time)
    assert pieces.lengths.tolist() == [700, 740, 1499]
    assert pieces.period_s == pytest.approx(0.01)
    spans = averaging_spans(1499)
    expected = []
    for m in spans:
        found = []
        for rows in pieces.rows:
            x = np.concatenate([[0.0], np.cumsum(values[rows])])
            found.append((x[2 * m :] - 2 * x[m:-m] + x[: -2 * m]) if len(x) > 2 * m else np.empty(0))
        expected.append(np.mean(np.concatenate(found) ** 2) / (2 * m**2))
    assert overlapping_variance(values, pieces, spans) == pytest.approx(expected, rel=1e-12)
    assert Overlap(spans, pieces.lengths, 0.01).terms.tolist() == [sum(max(n + 1 - 2 * m, 0) for n in (700, 740, 1499)) for m in spans]


@pytest.mark.parametrize("noise", ["white", "flicker", "walk", "markov"])
def test_covariance_and_allan_variance_are_of_the_same_noise(noise: str) -> None:
    """The Allan variance is the variance of a second difference over 2τ²: two tables of formulae, one truth."""
    tau = np.geomspace(0.01, 1000, 40)
    s = [phase_covariance(noise, k * tau, 7.0) for k in (0, 1, 2)]
    assert (6 * s[0] - 8 * s[1] + 2 * s[2]) / (2 * tau**2) == pytest.approx(shapes([noise], tau, 7.0)[:, 0], rel=1e-6)


def test_markov_is_smooth_where_its_formula_changes() -> None:
    assert markov_variance(np.array([0.999e-3, 1.001e-3]), 1.0) == pytest.approx([2 / 3 * 0.999e-3, 2 / 3 * 1.001e-3], rel=1e-3)
    top = np.linspace(1, 3, 400)
    assert top[np.argmax(markov_variance(top, 1.0))] == pytest.approx(1.89, abs=0.01)  # IEEE Std 952 C.1.6
    assert np.sqrt(markov_variance(np.array([1.89]), 1.0)[0]) == pytest.approx(0.437 * np.sqrt(2), abs=1e-3)


@pytest.mark.parametrize(("noise", "alpha"), [("white", 0), ("flicker", -1), ("walk", -2), ("quantisation", 2)])
def test_degrees_of_freedom_agree_with_greenhall(noise: str, alpha: int) -> None:
    spans, n = 2 ** np.arange(5, 13), 20_000
    overlap = Overlap(spans, [n], 0.01)
    variance = shapes([noise], overlap.taus)[:, 0]
    edf = 2 * variance**2 / np.diag(overlap.covariance({noise: 1.0}))
    theirs = [ci.edf_greenhall(alpha, 2, int(m), n, overlapping=True, modified=False) for m in spans]
    assert edf == pytest.approx(theirs, rel=0.04)


def test_degrees_of_freedom_of_white_noise_at_one_sample() -> None:
    """2/3 of the number of terms, exactly: neighbouring differences have the correlation -1/2."""
    overlap = Overlap([1], [2000], 1.0)
    assert 2 / overlap.covariance({"white": 1.0})[0, 0] == pytest.approx(2 * 1999 / 3, rel=1e-3)


def test_covariance_of_the_estimates_by_simulation() -> None:
    """Between averaging times too, for a sum of noises."""
    rng, n, spans = np.random.default_rng(5), 1000, 2 ** np.arange(8)
    found = np.array([overlapping_variance(made(n, 1.0, rng, white=1.0, walk=0.02), whole(np.empty(n)), spans) for _ in range(3000)])
    overlap = Overlap(spans, [n], 1.0)
    said = overlap.covariance({"white": 1.0, "walk": 0.02**2})
    scale = np.sqrt(np.outer(np.diag(said), np.diag(said)))
    assert np.abs(np.cov(found.T) - said).max() / scale.max() < 0.12
    assert np.abs((np.cov(found.T) - said) / scale).max() < 0.15


TRUTHS = {
    "white": {"white": 1e-3},
    "white and flicker": {"white": 1e-3, "flicker": 2e-4},
    "white and walk": {"white": 1e-3, "walk": 2e-5},
    "white and quantisation": {"white": 1e-3, "quantisation": 1e-4},
    "white, flicker and Gauss-Markov": {"white": 0.065, "flicker": 0.1, "markov": 0.15, "correlation_s": 18.0},
}


@pytest.mark.parametrize("name", TRUTHS)
def test_intervals_hold_the_truth(name: str) -> None:
    """95 % intervals over 20 seeds of an hour at 10 Hz: with 19 of 20 expected, fewer than 16 has the odds of 1 in 400."""
    truth, rate, n = TRUTHS[name], 10.0, 36_000
    spans = averaging_spans(n)
    overlap, held, invented = Overlap(spans, [n], 1 / rate), dict.fromkeys(truth, 0), 0
    for seed in range(20):
        values = made(n, rate, np.random.default_rng(seed), **truth)
        fit = fit_noises(overlapping_variance(values, whole(values), spans), overlap)
        invented += not set(fit.coefficients) <= set(truth)
        for key, value in truth.items():
            e = fit.correlation if key == "correlation_s" else fit.coefficients.get(key)
            held[key] += e.low <= value <= e.high if e else value <= fit.bounds.get(key, 0.0)
    assert min(held.values()) >= 16, held
    assert invented <= 3


def test_coefficients_scale_with_the_signal() -> None:
    values = made(20_000, 10.0, np.random.default_rng(0), white=1.0, walk=0.05)
    spans = averaging_spans(len(values))
    overlap = Overlap(spans, [len(values)], 0.1)
    small, large = (fit_noises(overlapping_variance(k * values, whole(values), spans), overlap) for k in (1e-9, 1e3))
    assert set(small.coefficients) == set(large.coefficients) == {"white", "walk"}
    for noise, e in small.coefficients.items():
        assert large.coefficients[noise].value / e.value == pytest.approx(1e12, rel=1e-6)


def test_low_passed_white_noise_keeps_its_density() -> None:
    """A filter is none of the noises: the short averages are left out, and the density is the one before it."""
    rng, n = np.random.default_rng(0), 50_000
    rate = np.stack([np.convolve(made(n + 4, 100.0, rng, white=1e-4), np.ones(5) / 5, "valid") for _ in range(3)], axis=1)
    force = np.array([0, 0, 9.8]) + made(3 * n, 100.0, rng, white=1e-3).reshape(n, 3)
    found = bm.allan(bm.Recording(time=np.arange(n) / 100, specific_force=force, angular_rate=rate))
    for fit in found["gyroscope"].fits:
        assert fit is not None and fit.skipped > 0 and fit.departure == 0 and set(fit.coefficients) == {"white"}
    assert found["accelerometer"].verdict() == "fits"
    assert "neighbouring samples are not independent" in found.warnings[0]
    assert found.noise()["angle_random_walk"] == pytest.approx(1e-4, rel=0.05)


@pytest.mark.parametrize("held", [True, False])
def test_samples_of_a_slower_sensor(held: bool) -> None:
    """Held or interpolated, as the magnetometer's are in many a file: the white noise is that of the sensor."""
    rng, n, slow = np.random.default_rng(1), 40_000, 37.0
    time, own = np.arange(n) / 100, np.arange(n) / slow
    values = 0.07 * np.sqrt(slow) * rng.standard_normal((n, 3))
    at = np.searchsorted(own, time, "right") - 1
    field = values[at] if held else np.column_stack([np.interp(time, own, axis) for axis in values.T])
    force = np.array([0, 0, 9.8]) + 0.01 * rng.standard_normal((n, 3))
    quiet = 1e-3 * rng.standard_normal((n, 3))
    r = bm.Recording(time=time, specific_force=force, angular_rate=quiet, magnetic_time=time, magnetic_flux_density=field)
    mag = bm.allan(r)["magnetometer"]
    assert mag.white() == pytest.approx(0.07, rel=0.04)
    for fit in mag.fits:
        assert fit is not None and fit.skipped > 0 and fit.good and "markov" not in fit.coefficients
        assert fit.coefficients["white"].low < 0.07 < 1.03 * fit.coefficients["white"].high


def test_what_does_not_fit_is_left_out_with_its_reason() -> None:
    """A slow vibration on one axis of the gyroscope: no sum of noises describes it, and noise.toml takes nothing of it."""
    rng, n = np.random.default_rng(2), 60_000
    time = np.arange(n) / 50
    force = np.array([0, 0, 9.8]) + 0.01 * rng.standard_normal((n, 3))
    rate = 1e-3 * rng.standard_normal((n, 3))
    rate[:, 1] += 3e-3 * np.sin(2 * np.pi * 0.11 * time)
    found = bm.allan(bm.Recording(time=time, specific_force=force, angular_rate=rate))
    fit = found["gyroscope"].fits[1]
    assert fit is not None and not fit.good
    assert found["gyroscope"].verdicts()["y"].startswith("does not fit")
    assert [axis for axis, f in zip("xyz", found["gyroscope"].fits, strict=True) if f is not None and f.good] == ["x", "z"]
    assert any("no sum of these noises" in w and "y by" in w for w in found.warnings)
    assert found.noise()["angle_random_walk"] == pytest.approx(1e-3 / np.sqrt(50), rel=0.02)
    assert found.left_out()[0].startswith("gyroscope y is left out: does not fit")
    assert "# gyroscope y is left out" in found.to_toml()


def curve_of(**coefficients: Estimate) -> SensorAllan:
    doubtful = tuple(name for name, found in coefficients.items() if found.low <= 0)
    fit = Fit(coefficients, None, {}, doubtful, 0.0, 0.01, 0, 1.0, 5, np.ones(2))
    taus = np.array([1.0, 2.0])
    axes = np.ones((2, 1))
    return SensorAllan("gyroscope", ("x",), 100.0, 1000, taus, axes, axes, axes, axes, taus, axes, (fit,))


def test_noise_block_leaves_out_what_is_not_significant() -> None:
    """An interval that reaches down to 0 may be that of nothing; one that does not is taken, and no more than it."""
    white, sure, doubtful = Estimate(1e-4, 0.9e-4, 1.1e-4), Estimate(1e-5, 1e-6, 2e-5), Estimate(1e-5, 0.0, 2e-5)
    accelerometer = curve_of(white=white)
    for name, other, walk in (("walk", "ramp", 1e-5), ("flicker", "walk", 0.664e-5 * np.sqrt(3 / 100))):
        taken = AllanResult({"gyroscope": curve_of(white=white, **{name: sure, other: doubtful}), "accelerometer": accelerometer}, 0, 1)
        assert taken.noise(100.0)["gyro_bias_walk"] == pytest.approx(walk, rel=1e-3)
        left = AllanResult({"gyroscope": curve_of(white=white, **{name: doubtful}), "accelerometer": accelerometer}, 0, 1)
        assert left.noise() == {"angle_random_walk": 1e-4, "velocity_random_walk": 1e-4}
        assert left.left_out()[0].endswith("is left out: its interval reaches down to 0")
        assert left.left_out()[1].startswith("gyro_bias_walk is left out")
        assert "gyro_bias_walk =" not in left.to_toml()


def test_spectral_density_fits_the_allan_deviation() -> None:
    truth = {"white": 1e-3, "flicker": 1e-3, "markov": 3e-3}
    values = made(200_000, 50.0, np.random.default_rng(2), correlation_s=5.0, **truth)
    frequency, density = spectral_density(values, 50.0)
    assert len(frequency) < 120
    said = fitted_density({n: x**2 for n, x in truth.items()}, 5.0, frequency, 0.02)
    middle = (frequency > 0.01) & (frequency < 10)
    assert np.median(density[middle] / said[middle]) == pytest.approx(1.0, abs=0.05)
    assert np.abs(np.log(density[middle] / said[middle])).max() < 1.0


def test_density_of_quantisation_is_that_of_its_samples() -> None:
    """The integral is rounded to steps of a root of twelve times Q, and differences of it are sampled."""
    rng, period = np.random.default_rng(3), 0.01
    integral = np.cumsum(rng.normal(0, 1e-2, 200_000))
    step = 1e-3
    values = np.diff(np.round(integral / step) * step - integral) / period
    frequency, density = spectral_density(values, 1 / period)
    said = fitted_density({"quantisation": step**2 / 12}, np.nan, frequency, period)
    middle = (frequency > 1) & (frequency < 45)
    assert np.median(density[middle] / said[middle]) == pytest.approx(1.0, abs=0.05)


def test_every_noise_is_found_in_noise_free_curves() -> None:
    """The curve of the formulae themselves gives the coefficients back."""
    spans = 2 ** np.arange(20)
    overlap = Overlap(spans, [4 * spans[-1]], 0.01)
    for noise in set(NOISES) - {"markov", "ramp"}:
        squares = {"white": 1.0, noise: {"quantisation": 1e-4, "flicker": 4.0, "walk": 1.0}.get(noise, 1.0)}
        curve = shapes(list(squares), overlap.taus) @ np.array(list(squares.values()))
        fit = fit_noises(curve, overlap)
        assert set(fit.coefficients) == set(squares)
        assert fit.coefficients[noise].value == pytest.approx(np.sqrt(squares[noise]), rel=1e-3)
    assert pytest.approx(0.664, abs=5e-4) == FLICKER_FLOOR


def test_the_public_function_takes_arrays() -> None:
    n = 6000
    rng = np.random.default_rng(0)
    r = bm.Recording(
        time=np.arange(n) / 100,
        specific_force=[0, 0, 9.8] + 0.02 * rng.standard_normal((n, 3)),
        angular_rate=1e-3 * rng.standard_normal((n, 3)),
    )
    found = bm.allan(r, quaternion=True)
    gyro, turn = found["gyroscope"], found["quaternion"]
    assert gyro.deviation.shape == gyro.low.shape == gyro.edf.shape == (len(gyro.taus), 3)
    assert (gyro.low < gyro.deviation).all() and (gyro.deviation < gyro.high).all()
    assert gyro.white() == pytest.approx(1e-4, rel=0.03)
    # MAGYQ eqs 19 and 24: the vector part is half the sampling period times the rate; the scalar part is far below it.
    assert turn.deviation[:, 1:] == pytest.approx(gyro.deviation * 0.005, rel=1e-6)
    assert turn.deviation[0, 0] < 1e-4 * turn.deviation[0, 1]
    assert found.to_polars().height == len(gyro.taus) * 10
    assert set(found.noise()) == {"angle_random_walk", "velocity_random_walk"}
