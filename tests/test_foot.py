"""The contract of every method, and the filter on walks whose truth is known."""

import dataclasses
import tomllib

import numpy as np
import polars as pl
import pytest
import tomli_w

import bematist as bm
from bematist.earth import STANDARD_GRAVITY
from bematist.foot import FootIns, FootParameters
from bematist.hand import HandPdrParameters
from bematist.methods import METHODS
from bematist.parameters import Parameters
from handheld import held
from walks import shaken

RECORDING = shaken(4000)


def damaged(recording):
    """Missing values that begin at borders of chunks, long and short, and a gap."""
    f, w = recording.specific_force.copy(), recording.angular_rate.copy()
    f[[0, 7, 250, 2100, 2101, 3999]] = np.nan
    w[2499:2502] = w[2748:2850] = f[2750:2752] = np.nan
    keep = np.ones(4000, bool)
    keep[3000:3050] = False
    return recording.replace(time=recording.time[keep], specific_force=f[keep], angular_rate=w[keep], reference=None)


DAMAGED = damaged(RECORDING)
HELD = held(4000)


def worn(name):
    """A recording of the kind that a method is for."""
    return RECORDING if METHODS[name].worn == "shoe" else HELD


VARIANTS = {name: m.parameters for name, m in METHODS.items() if m.worn == "shoe"} | {
    "nine states, heading": FootParameters().override({"states": 9, "magnetic": {"use": "heading"}}),
    "relative, reset": FootParameters().override({"stance": {"rule": "relative"}, "magnetic": {"use": "reset"}}),
    "all constraints, adaptive": FootParameters().override(
        {
            "zaru": {"use": "rest", "after_s": 0.1},
            "hdr": {"use": "stance", "tolerance": 0.5},
            "maru": {"use": True, "interval_s": 0.1},
            "stance": {"rule": "adaptive", "pace": {"window_s": 0.5, "walk_speed": 0.05, "run_speed": 0.2}},
        }
    ),
    "constraints as printed": FootParameters().override({"zaru": {"use": "stance"}, "hdr": {"use": "sample"}, "maru": {"use": True}}),
    **{f"detector {d}": FootParameters().override({"stance": {"detector": d}}) for d in ("ared", "amvd", "amag", "gyro")},
    "causal": FootParameters().override({"stance": {"placement": "causal"}, "attitude": {"integration": "first-order"}}),
    "forward, relative": FootParameters().override({"stance": {"placement": "forward", "rule": "relative"}}),
    "mahony, gated, integral": FootParameters().override(
        {"attitude": {"propagation": "mahony", "magnetometer": "gated", "ki": 0.2}, "magnetic": {"use": "reset"}}
    ),
    "madgwick, first order": FootParameters().override(
        {"attitude": {"propagation": "madgwick", "integration": "first-order", "magnetometer": "all"}, "magnetic": {"use": "heading"}}
    ),
}
"""The methods, and choices that no method makes."""


@pytest.mark.parametrize("recording", [RECORDING, DAMAGED], ids=["whole", "damaged"])
@pytest.mark.parametrize("name", VARIANTS)
def test_chunks_of_any_size_give_the_same_bits(name, recording):
    whole = FootIns(VARIANTS[name]).run(recording)
    for size in (1, 7, 250):
        ins = FootIns(VARIANTS[name])
        pieces = [ins.update(rows) for rows in recording.chunks(size)] + [ins.finish()]
        assert_same_bits(whole, pieces)


@pytest.mark.parametrize("name", sorted(VARIANTS.keys() - METHODS.keys()))
def test_a_variant_saved_and_restored_in_the_middle(name):
    whole, rows = FootIns(VARIANTS[name]).run(DAMAGED), DAMAGED.samples()
    for cut in (1300, 2751):
        ins = FootIns(VARIANTS[name])
        first = ins.update(rows[:cut])
        other = FootIns.restore(ins.save())
        ins.update(rows[cut : cut + 50])  # what the first does afterwards must not matter
        assert_same_bits(whole, [first, other.update(rows[cut:]), other.finish()])


def test_a_state_of_other_kernels_is_refused():
    ins = FootIns()
    ins.update(RECORDING.samples()[:1300])
    with pytest.raises(bm.UsageError, match="another version of bematist"):
        FootIns.restore({**ins.save(), "version": "0"})


def parts(trajectory):
    yield trajectory.time
    yield trajectory.position
    yield trajectory.velocity
    yield trajectory.attitude
    yield trajectory.packed_covariance
    yield trajectory.stance
    if trajectory.steps is not None:
        yield from (getattr(trajectory.steps, f.name) for f in dataclasses.fields(trajectory.steps))
    for name, values in sorted(trajectory.diagnostics.items()):
        if name != "magnetic_reference":
            yield values


def assert_same_bits(a, pieces):
    for whole, *split in zip(parts(a), *[parts(p) for p in pieces], strict=True):
        np.testing.assert_array_equal(whole, np.concatenate(split))


@pytest.mark.parametrize("size", [1, 7, 999])
def test_a_part_of_the_samples_is_that_part_of_all(size):
    t = RECORDING.time
    own = np.sort(np.concatenate([t[:2000:3] + 5e-7, t[1:2000:5] - 2e-3, t[2000:4000:2] + 3e-6]))
    r = RECORDING.replace(magnetic_time=own, magnetic_flux_density=np.arange(3.0 * len(own)).reshape(-1, 3))
    rows = r.samples()
    # Written plainly: each sample in the first row that is not more than a µs before it.
    plain = np.full((len(t), 3), np.nan)
    for at, value in zip(own, r.magnetic_flux_density, strict=True):
        if at - 1e-6 <= t[-1]:
            plain[np.flatnonzero(t >= at - 1e-6)[0]] = value
    np.testing.assert_array_equal(rows[:, 7:10], plain)
    np.testing.assert_array_equal(np.concatenate(list(r.chunks(size))), rows)


@pytest.mark.parametrize("name", METHODS)
class TestEveryMethod:
    def test_chunks_by_track(self, name):
        assert_same_bits(bm.track(worn(name), name), [bm.track(worn(name), name, chunk=13)])

    def test_saved_and_restored_in_the_middle(self, name):
        whole = bm.track(damaged(worn(name)), name)
        for cut in (100, 2500, 2751):  # while the start is gathered, and after, among missing values
            rows = damaged(worn(name)).samples(pressure=METHODS[name].worn == "hand")
            ins = METHODS[name].make(METHODS[name].parameters, method=name)
            first = ins.update(rows[:cut])
            other = METHODS[name].make.restore(ins.save())
            ins.update(rows[cut : cut + 50])  # what the first does afterwards must not matter
            assert_same_bits(whole, [first, other.update(rows[cut:]), other.finish()])

    def test_single_steps(self, name):
        whole = bm.track(worn(name), name)
        ins = METHODS[name].make(METHODS[name].parameters)
        rows = worn(name).samples(pressure=METHODS[name].worn == "hand")
        with pytest.raises(bm.UsageError, match="until `ready`"):
            ins.step(rows[:1])
        head = ins.update(rows[:2100])
        assert ins.ready
        got = np.array([ins.step(rows[k : k + 1]).copy() for k in range(2100, len(rows))])
        np.testing.assert_array_equal(got[:, 1:4], whole.position[len(head) : len(head) + len(got)])
        assert len(head) + len(got) == len(rows) - round(ins.latency_s * 200)

    def test_configuration_goes_round(self, name):
        p = METHODS[name].parameters
        text = tomli_w.dumps(p.model_dump(exclude_none=True))
        assert type(p).model_validate(tomllib.loads(text)) == p

    def test_gaps_nans_and_silence(self, name):
        rng = np.random.default_rng(0)
        recording = worn(name)
        f, w = recording.specific_force.copy(), recording.angular_rate.copy()
        f[rng.integers(0, 4000, 40)] = np.nan
        w[1500:1600] = np.nan
        keep = np.ones(4000, bool)
        keep[2600:2700] = False
        cut = recording.replace(time=recording.time[keep], specific_force=f[keep], angular_rate=w[keep], reference=None)
        t = bm.track(cut, name)
        assert len(t) == keep.sum()
        assert np.isfinite(t.position).all() and np.isfinite(t.packed_covariance).all()
        text = " ".join(t.warnings)
        assert "bridged" in text and "held" in text and "skipped" in text

    def test_rows_that_were_skipped_belong_to_the_gap(self, name):
        w = worn(name).angular_rate.copy()
        w[1500:1700] = np.nan
        t = bm.track(worn(name).replace(angular_rate=w), name)
        skipped = int((t.diagnostics["bridged"] == 2).sum())
        assert 150 < skipped <= 200
        told = next(warning for warning in t.warnings if warning.startswith("1 gap(s) of "))
        assert float(told.split()[3]) == pytest.approx((skipped + 1) / RECORDING.rate_hz, abs=0.006)

    def test_no_samples(self, name):
        empty = np.empty((0, 3))
        with pytest.raises(bm.DataError, match="0 sample"):
            bm.track(bm.Recording(time=[], specific_force=empty, angular_rate=empty), name)

    def test_without_magnetometer(self, name):
        blind = worn(name).replace(magnetic_time=[], magnetic_flux_density=np.empty((0, 3)))
        t = bm.track(blind, name)
        assert np.isfinite(t.position).all()
        p = METHODS[name].parameters
        if METHODS[name].worn == "shoe":
            listens = p.magnetic.use == "reset" or p.attitude.magnetometer != "off"
        else:
            listens = p.attitude.correction != "none"
        assert any("magnetometer" in w for w in t.warnings) == listens

    def test_summary_and_table(self, name):
        t = bm.track(worn(name), name)
        s = t.summary()
        assert s["method"] == name and s["samples"] == len(worn(name)) and s["version"] == bm.__version__
        assert ("steps" in s) == (METHODS[name].worn == "hand") == ("stance_fraction" not in s)
        table = t.to_polars()
        assert table.columns[:2] == ["time", "east"] and table["stance"].dtype == pl.UInt8


def models(model):
    yield model
    for f in model.model_fields.values():
        if isinstance(f.annotation, type) and issubclass(f.annotation, Parameters):
            yield from models(f.annotation)


def test_every_parameter_is_described():
    for model in (*models(FootParameters), *models(HandPdrParameters)):
        assert model.__doc__
        for name, f in model.model_fields.items():
            nested = isinstance(f.annotation, type) and issubclass(f.annotation, Parameters)
            assert nested or f.description, f"{model.__name__}.{name}"


@pytest.mark.parametrize("name", bm.METHODS)
def test_every_use_can_be_off(name):
    """A switch is a word, or true and false; the word off is understood by all of them."""
    parameters = bm.METHODS[name].parameters

    def switched_off(model):
        inner = {k: switched_off(v) for k, v in model if isinstance(v, Parameters)}
        return {k: v for k, v in inner.items() if v} | ({"use": "off"} if "use" in type(model).model_fields else {})

    def uses(model):
        for k, v in model:
            if isinstance(v, Parameters):
                yield from uses(v)
            elif k == "use":
                yield v

    found = list(uses(parameters.override(switched_off(parameters))))
    assert found and all(v is False or v == "off" for v in found)


def test_unknown_names_are_explained():
    with pytest.raises(bm.UsageError, match='Did you mean "zupt"'):
        bm.track(RECORDING, "zuppt")
    with pytest.raises(bm.UsageError, match=r"stance\.threshold"):
        bm.track(RECORDING, "zupt", stance={"treshold": 3})
    with pytest.raises(bm.UsageError, match="greater than 0"):
        bm.track(RECORDING, "zupt", stance={"threshold": -3.0})
    with pytest.raises(bm.UsageError, match=r"stance is a group of parameters. Set one of: stance\.detector"):
        bm.track(RECORDING, "zupt", stance=3)
    with pytest.raises(bm.UsageError, match="gravity = true: it is not of the kind"):
        bm.track(RECORDING, "zupt", gravity=True)


def test_time_that_does_not_increase_is_dropped():
    rows = RECORDING.samples()
    ins = FootIns()
    ins.update(rows[:2500])
    before = len(ins.update(rows[2500:2510]))
    ins.update(rows[2490:2510])
    assert before == 10 and "20 sample(s)" in ins.warnings[-1]


def test_a_caller_may_use_his_buffer_again():
    rows, buffer = RECORDING.samples(), np.empty((50, 10))
    ins, pieces = FootIns(), []
    for start in range(0, len(rows), 50):
        buffer[:] = rows[start : start + 50]
        pieces.append(ins.update(buffer))
    assert_same_bits(FootIns().run(RECORDING), [*pieces, ins.finish()])


def test_one_navigator_one_recording():
    ins = FootIns()
    ins.run(RECORDING)
    with pytest.raises(bm.UsageError, match="a new one"):
        ins.run(RECORDING)
    ins = FootIns()
    ins.update(RECORDING.samples()[:2500])
    ins.finish()
    with pytest.raises(bm.UsageError, match="a new FootIns"):
        ins.update(RECORDING.samples()[2500:])


def test_a_knock_during_the_rest_does_not_spoil_the_start():
    r = shaken(4000)
    f = r.specific_force.copy()
    f[80:84] += 5.0
    ins = FootIns()
    ins.run(r.replace(specific_force=f))
    assert ins.alignment is not None and ins.alignment.rest[0] > 80
    assert ins.alignment.gyro_bias_sd < 0.002


def test_gravity_may_be_what_the_rest_shows():
    """An accelerometer that reads 1 % too much, at rest and uncorrected: with g = 9.81 it rises by ½ 0.01 g t², with its own it stays."""
    n = 600
    louder = bm.Recording(
        time=np.arange(n) / 200, specific_force=np.tile([0.0, 0.0, 1.01 * STANDARD_GRAVITY], (n, 1)), angular_rate=np.zeros((n, 3))
    )
    uncorrected = {"states": 9, "stance": {"rule": "absolute", "threshold": 1e-300}}
    rise = {word: bm.track(louder, "zupt", initial={"gravity_from": word}, **uncorrected).position[-1, 2] for word in ("parameter", "rest")}
    assert rise["parameter"] == pytest.approx(0.005 * STANDARD_GRAVITY * louder.time[-1] ** 2, rel=0.01)
    assert abs(rise["rest"]) < 1e-9


def test_a_gap_of_missing_values_is_measured_in_seconds():
    w = RECORDING.angular_rate.copy()
    w[2600:2700] = np.nan
    t = bm.track(RECORDING.replace(angular_rate=w), "zupt")
    assert any("1 gap(s) of 0.48 s" in x or "1 gap(s) of 0.49 s" in x for x in t.warnings), t.warnings


def test_nine_states_keep_the_offsets():
    t = bm.track(RECORDING, "zupt", states=9)
    assert np.ptp(t.diagnostics["gyro_bias"], axis=0).max() == 0
    assert t.diagnostics["accel_bias_sd"].max() == 0
    assert np.ptp(bm.track(RECORDING, "zupt").diagnostics["gyro_bias"], axis=0).max() > 0


def test_a_long_gap_is_survived_by_the_next_stance():
    """The foot turns by 40 degrees of tilt while nothing is recorded; the stance after the gap finds level again."""
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(0)
    turn = Rotation.from_euler("x", 25, degrees=True).as_matrix()
    n = 3000
    t = np.arange(2 * n) / 200 + np.repeat([0, 5.0], n)
    f = np.tile([0, 0, 9.80665], (2 * n, 1))
    f[n:] = f[n:] @ turn
    r = bm.Recording(time=t, specific_force=f + rng.normal(0, 0.02, f.shape), angular_rate=rng.normal(0, 1e-3, f.shape))
    track = bm.track(r, "zupt")
    from bematist.frames import rotate

    up = rotate(track.attitude[-1], f[-1])
    assert np.degrees(np.arctan2(np.linalg.norm(up[:2]), up[2])) < 0.5
    assert np.abs(track.velocity[-1]).max() < 0.01
    assert np.linalg.norm(track.position_sd[-1]) > 1


def test_a_threshold_means_the_absolute_rule():
    low, high = (bm.track(RECORDING, "foot", stance={"threshold": x}) for x in (0.02, 150.0))
    assert low.parameters["stance"]["rule"] == "absolute" and low.stance.mean() < high.stance.mean()
    kept = bm.track(RECORDING, "foot", stance={"threshold": 1.0, "rule": "relative"})
    assert kept.parameters["stance"]["rule"] == "relative"


def test_wrong_units_and_shapes_are_told():
    g = RECORDING.replace(specific_force=RECORDING.specific_force / 9.80665)
    assert any("is its unit m/s²" in w for w in bm.track(g).warnings)
    assert not any("is its unit" in w for w in bm.track(RECORDING).warnings)
    with pytest.raises(bm.UsageError, match="Write NaN"):
        FootIns().update(RECORDING.samples()[:10, :7])
    with pytest.raises(bm.UsageError, match="read the file first"):
        bm.track("walk.csv")
    assert np.isnan(FootIns().latency_s)


def test_what_is_printed_is_short():
    assert repr(RECORDING).startswith("Recording(arrays, 4000 samples, ") and len(repr(bm.track(RECORDING))) < 80
