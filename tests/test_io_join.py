"""Accelerometer and gyroscope with clocks of their own become one stream, and nothing is invented."""

import numpy as np
import pytest

from bematist.errors import DataError
from bematist.io.assemble import assemble
from bematist.io.join import join
from bematist.io.raw import Raw, Stream


def motion(t: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(3 * t), 2 * np.cos(2 * t), 9.8 + 0 * t], 1)


def test_equal_rates_stand_on_the_gyroscope():
    """Offset clocks at 100 Hz: values on the chord, within h²/8 of the curve's second derivative."""
    ta, tg = np.arange(0.003, 10, 0.01), np.arange(0, 10, 0.01)
    done = join(ta, motion(ta), tg, -motion(tg))
    np.testing.assert_array_equal(done.time, tg[1:])
    np.testing.assert_array_equal(done.rate, -motion(tg[1:]))
    assert np.abs(done.force - motion(done.time)).max() < 9 * 0.01**2 / 8 * 1.01
    assert "instants of the gyroscope" in done.note and "999 of 999" in done.note and "1 rows before or after" in done.note
    assert not done.warning


def test_common_instants_keep_their_values():
    t = np.arange(0, 5, 0.01)
    rng = np.random.default_rng(0)
    f, w = rng.normal(size=(480, 3)), rng.normal(size=(490, 3))
    done = join(t[20:], f, t[:490] + 2e-7, w)
    np.testing.assert_array_equal(done.force, f[:470])
    np.testing.assert_array_equal(done.rate, w[20:])
    assert "its own as well" in done.note


def test_a_faster_accelerometer_keeps_its_samples():
    ta, tg = np.arange(0, 10, 0.0025), np.arange(0, 10, 0.01)
    done = join(ta, motion(ta), tg, motion(tg))
    assert len(done.time) == len(ta) - 3
    np.testing.assert_array_equal(done.force, motion(done.time))
    assert "400 Hz" in done.warning and "100 Hz" in done.warning and "50 Hz" in done.warning


def test_a_slow_accelerometer_is_told():
    ta, tg = np.arange(0, 10, 0.04), np.arange(0, 9.9, 0.01)
    done = join(ta, motion(ta), tg, motion(tg))
    assert len(done.time) == len(tg) and np.isfinite(done.force).all()
    assert "the accelerometer 25 Hz" in done.warning


def test_no_value_within_a_gap_of_the_other():
    ta, tg = np.arange(0, 10, 0.01), np.arange(0.002, 9.98, 0.01)
    hole = (ta > 4) & (ta < 4.5)
    done = join(ta[~hole], motion(ta[~hole]), tg, motion(tg))
    empty = np.isnan(done.force).all(1)
    np.testing.assert_array_equal(empty, (done.time > 4) & (done.time < 4.5))
    assert np.isfinite(done.rate).all() and f"{empty.sum()} rows in its gaps" in done.note


def test_one_sample_each():
    done = join(np.array([1.0]), np.ones((1, 3)), np.array([1.0]), np.ones((1, 3)))
    assert len(done.time) == 1 and np.isfinite(done.force).all()


def test_no_common_time_is_refused():
    t = np.arange(0, 5, 0.01)
    with pytest.raises(DataError, match="no time in common"):
        join(t, motion(t), t + 100, motion(t))


def raw(**shift: float) -> Raw:
    names = ("specific_force", "angular_rate", "magnetic_flux_density")
    t = np.arange(0, 20, 0.01)
    streams = {n: Stream(stamps=t + shift.get(n, 0.0), values=motion(t) * (1 if n == "specific_force" else 0.1)) for n in names}
    return Raw(source="walk", streams=streams, stated={"time": "s", "specific_force": "m/s^2", "angular_rate": "rad/s"})


def test_mixed_clocks_are_told():
    with pytest.raises(DataError, match=r"walk: .*no time in common") as error:
        assemble(raw(angular_rate=1.7e9))
    assert "\n" not in str(error.value)
    r = assemble(raw(magnetic_flux_density=1.7e9))
    assert not r.has_magnetometer and any("another instant" in w for w in r.warnings)


def test_equal_stamps_are_one_clock():
    one = raw()
    one.streams["angular_rate"].values[50] = np.nan
    r = assemble(one)
    assert len(r) == 2000 and np.isnan(r.angular_rate[50]).all() and np.isfinite(r.specific_force).all()
    assert sum(n.startswith("Clock") for n in r.notes) == 1


def test_reference_and_start_follow_the_clock():
    from bematist.recording import Reference

    one = raw(specific_force=1.7e9, angular_rate=1.7e9, magnetic_flux_density=1.7e9)
    one.reference = Reference(time=np.array([1.7e9 + 3]), position=np.zeros((1, 3)))
    r = assemble(one)
    assert r.start_ns == 1_700_000_000 * 10**9 and r.reference is not None and r.reference.time[0] == pytest.approx(3)
    two = raw()
    two.start_ns = 42
    assert assemble(two).start_ns == 42
