"""`describe` says what is in a recording, on recordings whose content is known."""

import json
import math

import numpy as np
import pytest

from bematist.inspect import describe, lines, rest_periods
from bematist.io import read
from bematist.io.guess import saturated
from bematist.recording import Recording
from test_io_formats import HEADER, walk_rows, write


def test_describe_a_known_recording(tmp_path):
    rows = walk_rows()
    rows = np.concatenate([rows[:90], rows[:90], rows])
    rows[:, 0] = np.arange(780) / 100
    rows[np.arange(780) % 4 > 0, 7:] = np.nan
    keep = np.ones(780, bool)
    keep[[50, 51, 300]] = False
    d = describe(read(write(tmp_path / "a.csv", HEADER, rows[keep])))
    assert json.loads(json.dumps(d)) == d
    acc, mag = d["sensors"]["accelerometer"], d["sensors"]["magnetometer"]
    assert acc["samples"] == 777 and acc["missing"] == 0
    assert acc["rate_hz"] == pytest.approx(100) and mag["rate_hz"] == pytest.approx(25)
    assert (acc["gaps"], acc["lost"]) == (2, 3) and acc["longest_gap_s"] == pytest.approx(0.03)
    assert acc["saturated"] == [] and acc["jitter_ms"] < 1e-3
    assert mag["norm_uT"]["median"] == pytest.approx(math.hypot(20, 40), abs=0.5)
    assert d["duration_s"] == pytest.approx(7.79)
    (rest,) = d["rest"]["periods"]  # the one at the end is shorter than a second
    assert rest["start_s"] == 0 and rest["length_s"] == pytest.approx(2.8, abs=0.15)
    assert d["rest"]["norm_m_s2"] == pytest.approx(9.8, abs=0.05)
    assert d["reference"] is None and len(d["units"]) == 3 and len(d["clock"]) == 1
    assert any("2 gaps" in w for w in d["warnings"])
    text = dict(lines(d))
    assert "100 Hz" in text["accelerometer"] and "2 gaps, 3 lost" in text["accelerometer"]
    assert "7.79 s" in text["duration"]


def test_describe_saturation():
    t = np.arange(2000) / 200
    force = np.stack([0 * t, 0 * t, 9.8 + 0 * t], 1) + 0.01 * np.random.default_rng(0).normal(size=(2000, 3))
    rate = np.radians(np.stack([3000 * np.sin(9 * t), 100 * np.sin(5 * t), 0 * t], 1))
    rate[:, 0] = np.clip(rate[:, 0], -np.radians(2000), np.radians(2000))
    gyro = describe(Recording(time=t, specific_force=force, angular_rate=rate))["sensors"]["gyroscope"]
    assert {s["axis"] for s in gyro["saturated"]} == {"x"}
    assert sorted(round(s["at"]) for s in gyro["saturated"]) == [-2000, 2000]


def test_describe_real_recordings(shared_data):
    d = describe(read(shared_data / "foot/ngimu/short_walk.csv"))
    assert "magnetometer" not in d["sensors"]
    assert d["sensors"]["gyroscope"]["lost"] == 244
    first, last = d["rest"]["periods"][0], d["rest"]["periods"][-1]
    assert first["start_s"] < 0.5 and first["length_s"] > 10 and last["length_s"] > 5
    assert d["rest"]["norm_m_s2"] == pytest.approx(9.81, abs=0.03)
    d = describe(read(shared_data / "foot/gsu_gx5/SensorConnectData_32.csv"))
    assert d["reference"] == {"points": 62, "note": "surveyed footfalls (GSU), plan only, corridor frame", "mirrored": True}
    assert d["sensors"]["magnetometer"]["norm_uT"]["high"] > 60, "strongly disturbed"
    labels = [label for label, _ in lines(d)]
    assert {"file", "duration", "clock", "units of the gyroscope", "rest", "reference"} <= set(labels)


def test_describe_one_sample_and_nothing_finite():
    one = Recording(time=np.zeros(1), specific_force=np.zeros((1, 3)), angular_rate=np.zeros((1, 3)))
    assert describe(one)["sensors"]["accelerometer"]["rate_hz"] is None
    assert lines(describe(one))
    gone = Recording(time=np.arange(5.0), specific_force=np.full((5, 3), np.nan), angular_rate=np.zeros((5, 3)))
    assert describe(gone)["sensors"]["accelerometer"]["samples"] == 0
    assert rest_periods(gone) == []
    json.dumps(describe(gone), allow_nan=False)


def test_uneven_steps_are_jitter_and_not_gaps():
    t = np.cumsum(np.random.default_rng(0).uniform(0.002, 0.008, 500))
    still = Recording(time=t, specific_force=np.full((500, 3), 5.6), angular_rate=np.zeros((500, 3)))
    acc = describe(still)["sensors"]["accelerometer"]
    assert acc["gaps"] == 0 and acc["jitter_ms"] == pytest.approx(6 / math.sqrt(12), rel=0.1)


def test_slow_turn_of_a_coarse_signal_is_not_saturation():
    seconds = np.arange(0, 20, 0.01)
    field = 0.1 * np.round(400 * np.cos(0.8 * seconds))
    assert saturated(field[:, None]) == []
    clipped = np.clip(field, -30, 30)
    assert [round(extreme) for _, extreme, _ in saturated(np.repeat(clipped[::10], 4)[:, None])] == [30, -30]
