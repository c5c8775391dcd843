"""Recordings with true attitudes, their evaluation, and attitudes on disk."""

import numpy as np
import pytest
from scipy.io import savemat

import bematist as bm
from bematist import frames
from bematist.io import mat, read_attitude, sniff, write_attitude
from test_ahrs import turning


def broad_file(path, n=600, **changes):
    rng = np.random.default_rng(0)
    quat = rng.normal(size=(n, 4))
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    quat[50:60] = np.nan
    content = {
        "imu_gyr": rng.normal(0, 0.01, (n, 3)),
        "imu_acc": rng.normal(0, 0.1, (n, 3)) + np.array([0, 0, 9.8]),
        "imu_mag": np.tile([1.0, 18, -40], (n, 1)),
        "opt_quat": quat,
        "opt_pos": rng.normal(size=(n, 3)),
        "sampling_rate": 250.0,
        "movement": (np.arange(n) > 100).astype(np.uint8),
    }
    savemat(path, content | changes, do_compression=True)
    return content


def test_broad_as_it_is_written(tmp_path):
    content = broad_file(tmp_path / "trial.mat")
    assert sniff(tmp_path / "trial.mat").name == "broad"
    assert set(content) == set(mat.names(tmp_path / "trial.mat"))
    r = bm.read(tmp_path / "trial.mat")
    np.testing.assert_allclose(r.time, np.arange(600) / 250, atol=1e-12)
    for name, key in (("specific_force", "imu_acc"), ("angular_rate", "imu_gyr"), ("magnetic_flux_density", "imu_mag")):
        np.testing.assert_array_equal(getattr(r, name), content[key])
    for truth in (r.reference, bm.read_reference(tmp_path / "trial.mat")):
        np.testing.assert_array_equal(truth.attitude, content["opt_quat"])
        np.testing.assert_array_equal(truth.judged, content["movement"] > 0)
        np.testing.assert_allclose(truth.time, r.time, atol=1e-12)


@pytest.mark.parametrize(
    "changes", [{"sampling_rate": 0.0}, {"imu_gyr": np.zeros((5, 3))}, {"imu_acc": np.zeros((600, 2))}, {"movement": np.ones(3)}]
)
def test_damaged_broad_files_are_told(tmp_path, changes):
    broad_file(tmp_path / "trial.mat", **changes)
    with pytest.raises(bm.DataError):
        bm.read(tmp_path / "trial.mat")


def test_npz_as_vqf_writes_it(tmp_path):
    rng = np.random.default_rng(1)
    acc, gyr = rng.normal(0, 0.1, (500, 3)) + np.array([0, 0, 9.8]), rng.normal(0, 0.01, (500, 3))
    np.savez(tmp_path / "a.npz", acc=acc, gyr=gyr, sampling_rate=100.0)
    r = bm.read(tmp_path / "a.npz")
    assert not r.has_magnetometer and abs(r.rate_hz - 100) < 1e-6
    np.testing.assert_array_equal(r.angular_rate, gyr)
    np.savez(tmp_path / "b.npz", acc=acc, gyr=gyr[:400], sampling_rate=100.0)
    with pytest.raises(bm.DataError, match="different shapes"):
        bm.read(tmp_path / "b.npz")
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "c.npz").write_bytes(content[:2000] + bytes(500) + content[2500:])
    with pytest.raises(bm.DataError):
        bm.read(tmp_path / "c.npz")


def truth_of(attitude, **fields):
    return bm.Reference(time=np.arange(len(attitude)) / 100, position=np.full((len(attitude), 3), np.nan), attitude=attitude, **fields)


def estimate(attitude):
    return bm.Attitude(time=np.arange(len(attitude)) / 100, attitude=attitude, gyro_bias=np.zeros((len(attitude), 3)))


def test_known_errors_are_told_apart():
    """An error of 10° about the vertical and one of 5° about East, alone and together."""
    _, true = turning(3000)
    about = {"up": [0, 0, np.radians(10)], "east": [np.radians(5), 0, 0]}
    q = {k: frames.quaternion_from_rotation_vector(v) for k, v in about.items()}
    for turn, heading, tilt in ((q["up"], 10, 0), (q["east"], 0, 5), (frames.multiply(q["up"], q["east"]), 10, 5)):
        found = bm.evaluate_attitude(estimate(frames.multiply(turn, true)), truth_of(true)).to_dict()
        np.testing.assert_allclose([found["heading_rmse_deg"], found["tilt_rmse_deg"]], [heading, tilt], atol=1e-5)
        aligned = bm.evaluate_attitude(estimate(frames.multiply(turn, true)), truth_of(true), align="yaw").to_dict()
        np.testing.assert_allclose([aligned["heading_rmse_deg"], aligned["tilt_rmse_deg"]], [0, tilt], atol=1e-5)
        np.testing.assert_allclose(aligned["turned_deg"], -heading, atol=1e-5)


def test_what_is_not_judged_does_not_count():
    _, true = turning(3000)
    wrong = true.copy()
    wrong[:1000] = true[1500]
    lost = true.copy()
    lost[1200:1300] = np.nan
    judged = np.arange(3000) >= 1000
    found = bm.evaluate_attitude(estimate(wrong), truth_of(lost, judged=judged))
    assert found.rows == 1900 and found.error.total < 1e-7
    assert bm.evaluate_attitude(estimate(wrong), truth_of(lost)).error.total > 0.1


def test_references_at_instants_of_their_own():
    _, true = turning(3000)
    between = bm.Reference(time=np.arange(2999) / 100 + 0.005, position=np.full((2999, 3), np.nan), attitude=true[:-1])
    half = frames.quaternion_from_rotation_vector(
        0.5 * frames.rotation_vector_from_quaternion(frames.multiply(frames.conjugate(true[:-1]), true[1:]))
    )
    exact = bm.Reference(time=between.time, position=between.position, attitude=frames.multiply(true[:-1], half))
    assert bm.evaluate_attitude(estimate(true), exact).error.total < 1e-12
    with pytest.raises(bm.DataError, match="no instant"):
        bm.evaluate_attitude(estimate(true), bm.Reference(time=between.time + 1e3, position=between.position, attitude=true[:-1]))
    with pytest.raises(bm.DataError, match="no attitude"):
        bm.evaluate_attitude(estimate(true), bm.Reference(time=between.time, position=between.position))
    with pytest.raises(bm.UsageError, match="yaw"):
        bm.evaluate_attitude(estimate(true), exact, align="se3")


def test_attitudes_on_disk(tmp_path):
    r, _ = turning()
    mine = bm.attitude(r)
    write_attitude(mine, tmp_path)
    back = read_attitude(tmp_path)
    np.testing.assert_allclose(back.attitude, mine.attitude, atol=2e-16)
    np.testing.assert_array_equal(back.gyro_bias, mine.gyro_bias)
    text = read_attitude(tmp_path / "attitude.csv")
    np.testing.assert_allclose(text.attitude, mine.attitude, atol=1e-8)
    np.testing.assert_allclose(text.time, mine.time, atol=1e-6)
    with pytest.raises(bm.DataError, match="no attitudes here"):
        read_attitude(tmp_path / "nothing")
    (tmp_path / "bad.csv").write_text("time,qw,qx,qy,qz\n0,1,0,0,0\n0,1,0,0,0\n")
    with pytest.raises(bm.DataError, match="does not increase"):
        read_attitude(tmp_path / "bad.csv")
