"""The handheld attitude filter: its contract, and against its plain twin."""

import tomllib

import numpy as np
import pytest
import tomli_w

import bematist as bm
import twin_hand
from bematist.hand import HandAttitude, HandParameters
from bematist.hand.setup import detectors, kernel_parameters, workspace
from bematist.kernels import hand_layout as at
from bematist.recording import Recording
from handheld import walk

RECORDING = walk("phone", 3, 50.0)


def damaged():
    """Missing values that begin at borders of chunks, long and short, a gap that is bridged and one that is not."""
    f, w = RECORDING.specific_force.copy(), RECORDING.angular_rate.copy()
    f[[0, 7, 250, 2100, 2101, 4999]] = np.nan
    w[2499:2502] = w[2748:2850] = f[2750:2752] = np.nan
    keep = np.ones(5000, bool)
    keep[3000:3010] = keep[4000:4100] = False
    return RECORDING.replace(time=RECORDING.time[keep], specific_force=f[keep], angular_rate=w[keep])


DAMAGED = damaged()


def made(**attitude):
    return HandParameters().override({"attitude": attitude})


OWN = {"reference": "estimated"}
VARIANTS = {
    "default": HandParameters(),
    "none": made(correction="none"),
    "replace": made(correction="replace", magnetic={"dip_tolerance": 0.05}),
    "as printed": made(normalise_covariance=False, noise={"bias_scaling": "printed"}),
    "estimated": made(**OWN, magnetic={"dip_tolerance": 0.05, "walk": 0.1, "gradient": False}, force={"walk": 0.1, "gradient": False}),
    "likelihood": made(**OWN, magnetic={"detector": "likelihood"}, force={"detector": "likelihood"}),
    "in motion": made(motion={"gravity_density": 0.3, "heading_density": 0.3, "heading_spread": 2.0}, earth_rate=(0.0, 5e-5, 5e-5)),
    "at rest": made(
        **OWN, magnetic={"local": False}, force={"local": False, "earth": False}, motion={"gravity_density": 0.5, "rest_field_sd": 0.6}
    ),
    "suspicious": made(magnetic={"innovation_limit": 0.5, "patience": 2}, force={"innovation_limit": 0.5, "patience": 3}),
    "no magnetometer": made(magnetic={"use": False}),
    "no force": made(force={"use": False}, magnetic={"local": False}),
}


def parts(a):
    yield from (a.time, a.attitude, a.gyro_bias)
    if a.packed_covariance is not None:
        yield a.packed_covariance
    yield from (v for _, v in sorted(a.diagnostics.items()))


def assert_same_bits(whole, pieces):
    for one, *split in zip(parts(whole), *[parts(p) for p in pieces], strict=True):
        np.testing.assert_array_equal(one, np.concatenate(split))


@pytest.mark.parametrize("name", VARIANTS)
class TestContract:
    @pytest.mark.parametrize("recording", [RECORDING, DAMAGED], ids=["whole", "damaged"])
    def test_chunks_of_any_size_give_the_same_bits(self, name, recording):
        whole = HandAttitude(VARIANTS[name]).run(recording)
        assert len(whole) == len(recording)
        np.testing.assert_allclose(np.linalg.norm(whole.attitude, axis=1), 1, atol=1e-12)
        for size in (1, 7, 250):
            live = HandAttitude(VARIANTS[name])
            assert_same_bits(whole, [*(live.update(rows) for rows in recording.chunks(size)), live.finish()])

    def test_saved_and_restored(self, name):
        whole = HandAttitude(VARIANTS[name]).run(DAMAGED)
        rows = DAMAGED.samples()
        for cut in (100, 2500, 2751):
            one = HandAttitude(VARIANTS[name], name="a")
            first = one.update(rows[:cut])
            other = HandAttitude.restore(one.save())
            one.update(rows[cut : cut + 50])  # what the first does afterwards must not matter
            assert_same_bits(whole, [first, other.update(rows[cut:]), other.finish()])
            assert other.name == "a"

    def test_configuration_goes_round(self, name):
        text = tomli_w.dumps(VARIANTS[name].model_dump(exclude_none=True))
        assert HandParameters.model_validate(tomllib.loads(text)) == VARIANTS[name]

    def test_silence_and_nothing(self, name):
        bare = RECORDING.replace(magnetic_time=np.empty(0), magnetic_flux_density=np.empty((0, 3)))
        assert np.isfinite(HandAttitude(VARIANTS[name]).run(bare).attitude).all()
        f = RECORDING.specific_force.copy()
        f[2000:] = np.nan
        assert np.isfinite(HandAttitude(VARIANTS[name]).run(RECORDING.replace(specific_force=f)).attitude).all()
        zero = RECORDING.replace(magnetic_flux_density=np.zeros_like(RECORDING.magnetic_flux_density))
        assert np.isfinite(HandAttitude(VARIANTS[name]).run(zero).attitude).all()
        with pytest.raises(bm.DataError, match="0 sample"):
            HandAttitude(VARIANTS[name]).run(Recording(time=np.empty(0), specific_force=np.empty((0, 3)), angular_rate=np.empty((0, 3))))


def dense(parameters, recording):
    """The twin, started as the filter is."""
    rows = recording.samples()
    start = HandAttitude(parameters)
    start.update(rows[:1200])
    a, rate = start.alignment, recording.rate_hz
    index, _ = detectors(parameters, rate, 1 / np.median(np.diff(recording.magnetic_time)))
    sizes = index.reshape(2, -1)[:, [at.LENGTH, at.FIRST]]
    prm, _ = kernel_parameters(parameters, a, rate)
    S = workspace(parameters, a, prm, rows[0, 0])
    gap = {**parameters.gap.model_dump(), "s": parameters.gap.seconds(rate)}
    earth = S[at.EARTH_E : at.EARTH_U + 1]
    P = S[:256].reshape(16, 16)
    return twin_hand.Filter(
        parameters.attitude.model_dump(), a.attitude, S[at.BQ : at.BQ + 3], P, 1 / rate, 9.80665, earth, sizes, gap
    ).run(rows)


@pytest.mark.parametrize("name", [n for n in VARIANTS if n != "replace" and n != "none"])
def test_against_the_plain_twin(name):
    r = RECORDING
    keep = np.ones(len(r), bool)
    keep[3000:3010] = keep[4000:4100] = False
    r = r.replace(time=r.time[keep], specific_force=r.specific_force[keep], angular_rate=r.angular_rate[keep])
    got = HandAttitude(VARIANTS[name]).run(r)
    q, b, P = dense(VARIANTS[name], r)
    np.testing.assert_allclose(got.attitude, q, atol=1e-7)
    np.testing.assert_allclose(got.gyro_bias, b[:, :3] * 200, atol=1e-6)
    np.testing.assert_allclose(got.diagnostics["accel_bias"], b[:, 3:], atol=1e-6)
    np.testing.assert_allclose(got.covariance, P, atol=1e-6 * np.abs(P).max(), rtol=1e-4)
