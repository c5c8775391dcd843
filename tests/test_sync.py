"""The offset and drift between two clocks, on simulated walks and on real recordings whose clocks were set by others."""

import json

import numpy as np
import pytest

import bematist as bm
from bematist.cli import main
from bematist.frames import conjugate, multiply, quaternion_from_euler, rotate
from bematist.io import read, write_recording, write_reference, write_trajectory
from bematist.recording import Reference
from bematist.simulate import simulate

OFFSET, DRIFT = 7.123, 80e-6


def seen_by_another(recording, offset=OFFSET, drift=DRIFT):
    """The same recording with other axes, on a clock that began `offset` s later and runs slower by `drift`."""
    q = quaternion_from_euler(0.4, -0.8, 2.0)
    times = {name: (getattr(recording, name) - offset) / (1 + drift) for name in ("time", "magnetic_time")}
    turned = {name: rotate(q, getattr(recording, name)) for name in ("specific_force", "angular_rate", "magnetic_flux_density")}
    return recording.replace(reference=None, **times, **turned)


@pytest.fixture(scope="module")
def walks():
    """The same walk by two sensors of their own rates and errors."""
    return [simulate("campus", sensor, seed=5, length_m=220.0) for sensor in ("lsm9ds1", "adis16488")]


@pytest.mark.parametrize(("offset", "drift"), [(OFFSET, DRIFT), (-31.4567, 0.0), (0.0031, -30e-6)])
def test_two_sensors_of_one_walk(walks, offset, drift):
    a, b = walks
    found = bm.sync(a, seen_by_another(b, offset, drift))
    assert found.quantity == "angular rate" and found.correlation > 0.95
    # A sample is the mean over the step that ends at its time: the slower sensor's is later by half the difference of the steps.
    late = 0.5 * (1 / b.rate_hz - 1 / a.rate_hz)
    middle = b.duration_s / 2
    assert float(found.times(np.array([middle]))[0]) == pytest.approx(offset + (1 + drift) * middle - late, abs=1e-3)
    assert found.drift == pytest.approx(drift, abs=max(4 * found.drift_sd, 1e-6)) and found.drift_sd < 20e-6
    assert found.sd_s < 1e-3


@pytest.mark.parametrize("positions_only", [False, True])
def test_a_reference(walks, positions_only):
    truth = walks[0].reference
    rows = slice(None, None, 4)  # about 60 Hz
    later = (truth.time[rows] - OFFSET) / (1 + DRIFT)
    reference = Reference(time=later, position=truth.position[rows], attitude=None if positions_only else truth.attitude[rows])
    found = bm.sync(walks[0], reference)
    assert found.quantity == ("specific force" if positions_only else "angular rate")
    error = found.apply(reference).time - truth.time[rows]
    assert np.abs(error).max() < (0.03 if positions_only else 0.006)  # half a step, as above, and the noise


def test_what_is_on_the_other_clock_goes_along(walks):
    b = seen_by_another(walks[1]).replace(reference=walks[1].reference)
    shift = bm.Shift(offset_s=1.0, sd_s=0.0, drift=0.5, drift_sd=0.0, correlation=1.0, second=0.0, quantity="angular rate", overlap_s=1.0)
    moved = shift.apply(b)
    for name in ("time", "magnetic_time"):
        np.testing.assert_array_equal(getattr(moved, name), 1.0 + 1.5 * getattr(b, name))
    np.testing.assert_array_equal(moved.reference.time, 1.0 + 1.5 * b.reference.time)


def test_without_a_clear_peak_it_says_so(walks):
    other = simulate("campus", "lsm9ds1", seed=6, length_m=150.0)
    with pytest.raises(bm.DataError, match="no clear peak"):
        bm.sync(walks[0], other)
    only = Reference(time=np.arange(10.0), position=np.zeros((10, 3)))
    attitude = bm.Attitude(time=walks[0].time, attitude=walks[0].reference.attitude, gyro_bias=np.zeros((len(walks[0]), 3)))
    with pytest.raises(bm.DataError, match="only attitudes"):
        bm.sync(attitude, only)


def test_norms_know_no_frame(walks):
    """Attitudes to another world frame and of another body frame give the same offset."""
    t = walks[0].reference
    q = multiply(multiply(quaternion_from_euler(0.1, 0.2, 3.0), t.attitude), conjugate(quaternion_from_euler(1.0, 0.0, -2.0)))
    plain, turned = (bm.sync(walks[0], Reference(time=t.time, position=t.position, attitude=x)) for x in (t.attitude, q))
    assert turned.offset_s == pytest.approx(plain.offset_s, abs=1e-6)


def test_command(walks, tmp_path, capsys):
    a, b, out, plain = (tmp_path / name for name in ("a.csv", "b.csv", "shifted.csv", "plain.csv"))
    write_recording(walks[0], a)
    write_recording(seen_by_another(walks[1]), b)
    assert main(["sync", str(a), str(b), "-o", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    again = bm.sync(read(a), read(out))
    assert abs(again.offset_s) < 1e-3 and abs(again.drift) < 5e-6 and found["offset_s"] != 0
    write_reference(walks[0].reference, plain)
    assert main(["sync", str(a), "--reference", str(plain)]) == 0
    assert "to be added" in capsys.readouterr().out
    assert main(["sync", str(a)]) == 2
    assert "without a reference" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "correlation"), [("Guillaume_Nexus5_NoDist_Texting", 0.98), ("Thibaud_Nexus5_NoDist_Swinging", 0.97)])
def test_the_clock_of_the_motion_capture_room(shared_data, name, correlation):
    """Room time less the offset is the phone's: the reader sets it so, and with the other sign it is off by twice the offset."""
    folder = shared_data / "hand" / "nexus5_mocap" / name
    r = read(folder)
    found = bm.sync(r, r.reference)
    assert abs(found.offset_s) < 0.01 and found.correlation > correlation
    offset = float((folder / "timeAlignment.txt").read_text())
    room = Reference(time=r.reference.time + offset, position=r.reference.position, attitude=r.reference.attitude)
    assert bm.sync(r, room).offset_s == pytest.approx(-offset, abs=0.01)


def test_evaluate_sets_the_clock_of_the_reference(walks, tmp_path, capsys):
    write_trajectory(bm.track(walks[0], "zupt"), tmp_path)
    truth = walks[0].reference
    write_reference(Reference(time=truth.time - OFFSET, position=truth.position, attitude=truth.attitude), tmp_path / "late.csv")
    rms = []
    for option in ([], ["--sync"]):
        assert main(["evaluate", str(tmp_path), str(tmp_path / "late.csv"), "--json", "-", *option]) == 0
        rms.append(json.loads(capsys.readouterr().out)["ate_rmse_2d_m"])
    assert rms[0] > 3 and rms[1] < 1.5
