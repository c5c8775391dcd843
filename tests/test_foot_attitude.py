"""Attitude filters inside the navigator, and MAGINAV as printed, on simulated walks: how near each stays to the truth."""

import numpy as np
import pytest

import bematist as bm
from bematist.simulate import simulate_walk
from bematist.stance import StanceParameters, analyse

WALKS = [simulate_walk("short", "lsm9ds1", seed) for seed in range(3)]
"""A minute, 58 m."""


def worst(method, **changes):
    """Largest rms error in plan and in height, m, over the walks."""
    found = [bm.evaluate(bm.track(w.recording, method, **changes), w.recording.reference, align="origin").to_dict() for w in WALKS]
    return max(e["ate_rmse_2d_m"] for e in found), max(e["ate_rmse_height_m"] for e in found)


@pytest.mark.parametrize(
    ("method", "plan", "height"),
    [
        ("common-9", 0.3, 0.3),
        ("mahony-9", 0.8, 0.8),
        ("madgwick-9", 1.2, 0.5),
        ("mahony-zupt", 1.2, 0.4),
        ("madgwick-zupt", 0.6, 0.3),
    ],
)
def test_every_attitude_filter_stays_near_the_truth(method, plan, height):
    assert np.less(worst(method), (plan, height)).all()


def test_the_magnetometer_gives_an_attitude_filter_its_heading():
    """The gyroscope has an offset of half a degree a second that nothing else would find."""
    w = WALKS[0]
    off = w.recording.replace(angular_rate=w.recording.angular_rate + np.radians([0.0, 0.0, 0.5]))
    nine = {"states": 9, "initial": {"average": False}}

    def heading(magnetometer):
        t = bm.track(off, "madgwick-zupt", attitude={"magnetometer": magnetometer, "beta": 0.2}, **nine)
        return bm.evaluate(t, w.recording.reference, align="origin").to_dict()["heading_rmse_deg"]

    assert heading("all") < 10 < heading("off")
    assert heading("gated") < 10


def test_what_is_printed_is_worse_than_what_is_corrected():
    assert worst("maginav-printed")[0] > 5 * worst("maginav")[0]


def test_the_attitude_of_the_end_costs_height():
    """MAGINAV eq 14, half a sample late, without noise."""
    w = simulate_walk("straight", "ideal", 0)
    climb = {at: bm.track(w.recording, "zupt", attitude={"force_at": at}).position[-1, 2] for at in ("middle", "end")}
    assert abs(climb["middle"]) < 0.1 < 0.3 < abs(climb["end"])


def test_a_window_to_one_side_calls_motion_still():
    w = simulate_walk("straight", "ideal", 0)
    speed = np.linalg.norm(w.truth.velocity, axis=1)
    median = {}
    for placement in ("centred", "forward", "causal"):
        stance = analyse(w.recording, StanceParameters(placement=placement)).stance
        median[placement] = np.median(speed[stance & (w.truth.stance == 0)])
    assert median["centred"] < 0.003 < 2 * median["centred"] < min(median["forward"], median["causal"])


def test_the_delay_of_a_window_follows_its_place():
    delays = [StanceParameters(window_s=0.05, placement=p).latency_samples(238.0) for p in ("causal", "centred", "forward")]
    assert delays == [0, 5, 10]
