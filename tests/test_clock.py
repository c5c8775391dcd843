"""The clock: recordings cut and jittered on purpose, whose true instants are known."""

import numpy as np
import pytest

from bematist.clock import repair
from bematist.errors import DataError, UsageError

RATE = 200.0


def walk(t: np.ndarray, seed: int = 0) -> np.ndarray:
    """Six channels that move as a foot's do (smooth swings, rests), with a sensor's noise, at instants t."""
    rng = np.random.default_rng(seed)
    swing = np.maximum(0.0, np.sin(2 * np.pi * 0.9 * t)) ** 2
    rows = [swing * np.sin(2 * np.pi * (4 + k) * t + k) * (6 if k < 3 else 3) for k in range(6)]
    return np.stack(rows, 1) + 0.01 * rng.normal(size=(len(t), 6))


@pytest.fixture
def truth() -> np.ndarray:
    return np.arange(8000) / RATE


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_late_reports_of_an_even_clock_are_fitted(truth, seed):
    rng = np.random.default_rng(seed)
    stamps = np.maximum.accumulate(truth + rng.uniform(0, 8e-3, len(truth)))
    assert np.diff(stamps).max() > 0.012, "the test needs steps of 0 to 13 ms"
    clock = repair(stamps, walk(truth))
    assert clock.kind == "uniform" and "signal" in clock.note
    error = clock.time - truth
    assert np.abs(error - np.median(error)).max() < 1e-3
    assert clock.lost.sum() == 0 and len(clock.time) == len(truth)
    # The median step, the usual shortcut, would be off by far more.
    assert abs(np.median(np.diff(stamps)) * (len(truth) - 1) - truth[-1]) > 0.2


def test_late_reports_of_a_real_recording(shared_data):
    table = np.loadtxt(shared_data / "foot/gsu_gx5/SensorConnectData_32.csv", delimiter=",", skiprows=1)
    true, signal = table[:, 0], table[:, 1:7]
    rng = np.random.default_rng(7)
    clock = repair(np.maximum.accumulate(true + rng.uniform(0, 8e-3, len(true))), signal)
    assert clock.kind == "uniform"
    error = clock.time - true
    assert np.abs(error - np.median(error)).max() < 1e-3
    assert clock.lost.sum() == 0


def test_true_uneven_instants_are_kept(truth):
    rng = np.random.default_rng(4)
    uneven = np.cumsum(rng.uniform(0.002, 0.008, 8000))
    clock = repair(uneven, walk(uneven))
    assert clock.kind == "stamps" and "signal" in clock.note
    np.testing.assert_array_equal(clock.time, uneven)
    assert clock.lost.sum() == 0


def test_true_instants_around_a_grid_are_kept_although_steps_make_up_for_one_another():
    rng = np.random.default_rng(5)
    t = np.arange(8000) / RATE + rng.uniform(0, 4e-3, 8000)
    assert np.corrcoef(np.diff(t)[:-1], np.diff(t)[1:])[0, 1] < -0.4
    assert repair(t, walk(t)).kind == "stamps"


def test_without_motion_the_pattern_of_the_steps_decides(truth):
    rng = np.random.default_rng(6)
    still = 0.01 * rng.normal(size=(len(truth), 6))
    clock = repair(truth + rng.uniform(0, 3e-3, len(truth)), still)
    assert clock.kind == "uniform" and "correlation" in clock.note
    uneven = np.cumsum(rng.uniform(0.002, 0.008, 8000))
    assert repair(uneven, still).kind == "stamps"


def test_lost_samples_with_true_stamps_are_gaps_and_shift_nothing(truth):
    rng = np.random.default_rng(8)
    keep = rng.random(len(truth)) > 0.01
    keep[[0, -1]] = True
    clock = repair(truth[keep], walk(truth)[keep])
    assert clock.kind == "stamps"
    np.testing.assert_array_equal(clock.time, truth[keep])
    assert clock.lost.sum() == (~keep).sum()
    assert any("samples missing" in w for w in clock.warnings)


def test_lost_samples_among_jitter_do_not_shift_time(truth):
    rng = np.random.default_rng(9)
    keep = np.ones(len(truth), bool)
    for start, length in ((500, 1), (1500, 3), (2600, 40), (4000, 300), (6000, 2)):
        keep[start : start + length] = False
    stamps = (truth + rng.uniform(0, 8e-3, len(truth)))[keep]
    clock = repair(stamps, walk(truth)[keep])
    assert clock.kind == "uniform"
    assert clock.lost.sum() == (~keep).sum()
    error = clock.time - truth[keep]
    off = np.abs(error - np.median(error)) > 1e-3
    assert off.sum() <= 20, "only the samples next to a gap may be on its wrong side"


def test_repeated_rows_are_removed_and_counted(truth):
    rows = np.sort(np.concatenate([np.arange(len(truth)), [10, 10, 500, 4000]]))
    clock = repair(truth[rows], walk(truth)[rows])
    np.testing.assert_array_equal(clock.time, truth)
    assert any(w.startswith("4 rows that repeat") for w in clock.warnings)


def test_repeated_stamps_with_new_values_are_late_reports(truth):
    batches = np.ceil(truth * 20) / 20  # packets of ten
    clock = repair(batches, walk(truth))
    assert clock.kind == "uniform"
    inside = slice(20, None)  # the first packet holds one sample
    error = (clock.time - truth)[inside]
    assert np.ptp(error) < 2e-3
    assert np.all(np.diff(clock.time) > 0)


def test_swapped_rows_are_sorted(truth):
    order = np.arange(len(truth))
    order[[100, 101]] = [101, 100]
    order[[3000, 3001, 3002]] = [3002, 3000, 3001]
    clock = repair(truth[order], walk(truth)[order])
    np.testing.assert_array_equal(clock.time, truth)
    np.testing.assert_array_equal(order[clock.rows], np.arange(len(truth)))
    assert any("wrong order" in w for w in clock.warnings)


def test_a_clock_that_goes_back_is_a_gap_of_unknown_length(truth):
    stamps = truth.copy()
    stamps[4000:] -= 15.0
    clock = repair(stamps, walk(truth))
    np.testing.assert_allclose(clock.time, truth, atol=1e-9)
    assert any("went back" in w and "row 4001" in w for w in clock.warnings)


def test_a_single_stray_stamp_is_left_out(truth):
    for bad in (0.0, 1e6):
        stamps = truth.copy()
        stamps[4000] = bad
        clock = repair(stamps, walk(truth))
        assert 4000 not in clock.rows and len(clock.time) == len(truth) - 1
        np.testing.assert_allclose(clock.time, np.delete(truth, 4000), atol=1e-9)


def test_counter_of_32_bits_is_unrolled(truth):
    wrap = 2**32 * 1e-6
    clock = repair(np.mod(truth + wrap - 12.0, wrap), walk(truth), wrap_s=wrap)
    np.testing.assert_allclose(clock.time, truth + wrap - 12.0, atol=1e-6)


def test_a_sample_counter_tells_the_losses(truth):
    rng = np.random.default_rng(10)
    keep = rng.random(len(truth)) > 0.05
    keep[0] = True
    stamps = (truth + rng.uniform(0, 8e-3, len(truth)))[keep]
    clock = repair(stamps, walk(truth)[keep], count=np.arange(len(truth))[keep])
    error = clock.time - truth[keep]
    assert np.abs(error - np.median(error)).max() < 1e-3


def test_force_either(truth):
    rng = np.random.default_rng(11)
    stamps = truth + rng.uniform(0, 3e-3, len(truth))
    kept = repair(stamps, walk(truth), "stamps")
    np.testing.assert_array_equal(kept.time, stamps)
    uneven = np.cumsum(rng.uniform(0.002, 0.008, 8000))
    fitted = repair(uneven, walk(uneven), "uniform")
    assert fitted.kind == "uniform" and np.diff(fitted.time).min() > 0
    with pytest.raises(UsageError, match="uniform"):
        repair(stamps, None, "even")  # pyright: ignore[reportArgumentType]


def test_strange_clocks():
    with pytest.raises(DataError, match="never advance"):
        repair(np.full(10, 3.0), np.zeros((10, 6)))
    with pytest.raises(DataError, match="No time stamp"):
        repair(np.full(10, np.nan), np.zeros((10, 6)))
    assert repair(np.array([5.0]), np.zeros((1, 6))).time.tolist() == [5.0]
    with pytest.raises(DataError, match="backwards"):
        repair(np.array([2.0, 1.0]), np.zeros((2, 6)))
    assert repair(np.array([1.0, 2.0]), np.zeros((2, 6))).time.tolist() == [1.0, 2.0]
    with_nan = repair(np.array([0.0, np.nan, 0.02, 0.03, 0.04, 0.05]), walk(np.arange(6.0)))
    assert with_nan.rows.tolist() == [0, 2, 3, 4, 5]


def test_a_minute_without_samples_stays_a_minute(truth):
    stamps = truth.copy()
    stamps[4000:] += 60.0
    clock = repair(stamps, walk(truth))
    np.testing.assert_array_equal(clock.time, stamps)
    assert any("60" in w for w in clock.warnings)


def test_wandering_oscillator_is_followed(truth):
    t = np.arange(40000) / RATE
    true = t + 1e-3 * 20 * np.sin(2 * np.pi * t / 200)  # 0.06 % of rate, up and down
    rng = np.random.default_rng(12)
    clock = repair(true + rng.uniform(0, 4e-3, len(t)), walk(true))
    error = clock.time - true
    assert clock.kind == "uniform"
    assert np.abs(error - np.median(error)).max() < 2.5e-3
