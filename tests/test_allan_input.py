"""Allan deviation of recordings that are not what they should be, and the command."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import bematist as bm
from bematist.cli import main
from bematist.io import write_recording
from bematist.simulate import simulate
from noise_makers import made


def resting(seconds: float = 120.0, rate: float = 100.0, **changes: object) -> bm.Recording:
    n = int(seconds * rate)
    rng = np.random.default_rng(0)
    r = bm.Recording(
        time=np.arange(n) / rate,
        specific_force=np.array([0.1, -0.2, 9.8]) + 0.02 * rng.standard_normal((n, 3)),
        angular_rate=np.array([0.01, 0.0, -0.02]) + 0.002 * rng.standard_normal((n, 3)),
        source="table",
    )
    return r.replace(**changes)


def with_motion(start: float, end: float) -> bm.Recording:
    r = resting()
    moved = (r.time >= start) & (r.time < end)
    rate = r.angular_rate.copy()
    rate[moved, 0] += 0.5 * np.sin(2 * np.pi * r.time[moved])
    return r.replace(angular_rate=rate)


def test_rest_is_rest() -> None:
    found = bm.allan(resting())
    assert found.warnings == ()
    assert (found.start_s, found.end_s) == (0.0, pytest.approx(119.99))
    assert found.noise()["angle_random_walk"] == pytest.approx(0.0002, rel=0.02)


def test_motion_is_named_and_the_longest_rest_used() -> None:
    found = bm.allan(with_motion(40.0, 45.0))
    assert 44.5 < found.start_s < 50
    assert found.end_s == pytest.approx(120.0, abs=0.1)
    assert "does not lie still all the time" in found.warnings[0]
    assert "Other rests: 0.0 to" in found.warnings[0]
    assert found.noise()["angle_random_walk"] == pytest.approx(0.0002, rel=0.02)


@pytest.mark.parametrize("turn", [0.03, 0.3])
def test_a_slow_turn_is_motion(turn: float) -> None:
    r = resting()
    moved = (r.time > 60) & (r.time < 70)
    found = bm.allan(r.replace(angular_rate=r.angular_rate + moved[:, None] * [0.0, 0.0, turn]))
    assert found.start_s == 0.0
    assert 50 < found.end_s <= 60


def test_a_sensor_laid_down_anew_is_motion() -> None:
    r = resting()
    found = bm.allan(r.replace(specific_force=np.where(r.time[:, None] < 70, r.specific_force, r.specific_force[:, ::-1])))
    assert found.start_s == 0.0
    assert 60 < found.end_s <= 70


def test_part_of_a_recording() -> None:
    found = bm.allan(with_motion(40.0, 45.0), start_s=2.0, end_s=30.0)
    assert (found.start_s, found.end_s) == (2.0, 30.0)
    assert found.warnings == ()


def test_a_walk_is_refused() -> None:
    walk = simulate("short", rest_s=3.0, final_rest_s=3.0)
    with pytest.raises(bm.DataError, match="does not lie still for 10 s anywhere"):
        bm.allan(walk)


def test_a_walk_with_a_rest_is_told() -> None:
    found = bm.allan(simulate("short", rest_s=40.0))
    assert found.start_s == 0.0
    assert 33 < found.end_s < 41
    assert "longest rest" in found.warnings[0]


@pytest.mark.parametrize("seconds", [0.0, 0.5, 5.0])
def test_too_short(seconds: float) -> None:
    with pytest.raises(bm.DataError, match="too short for an Allan deviation"):
        bm.allan(resting(seconds))


def test_too_few_samples() -> None:
    with pytest.raises(bm.DataError, match="too few"):
        bm.allan(resting(12.0, rate=8.0))


def test_wrong_units() -> None:
    r = resting()
    with pytest.raises(bm.DataError, match="specific_force=g"):
        bm.allan(r.replace(specific_force=r.specific_force / 9.80665))
    with pytest.raises(bm.DataError, match="angular_rate=deg/s"):
        bm.allan(r.replace(angular_rate=np.degrees(r.angular_rate)))


def test_saturated_stuck_and_coarse_axes() -> None:
    r = resting()
    force, rate = r.specific_force.copy(), r.angular_rate.copy()
    force[:, 0] = np.clip(force[:, 0], None, 0.11)
    rate[:, 1] = 0.0
    rate[:, 2] = np.round(rate[:, 2] / 0.01) * 0.01
    found = bm.allan(r.replace(specific_force=force, angular_rate=rate))
    said = "\n".join(found.warnings)
    assert "accelerometer x:" in said
    assert "end of the range" in said
    assert "gyroscope y: every sample is 0" in said
    assert "gyroscope z:" in said
    assert "repeat the one before" in said
    assert "accelerometer y" not in said
    assert found["gyroscope"].fits[1] is None


def test_gaps_and_sensors_of_different_rates() -> None:
    r = resting(200.0)
    keep = np.ones(len(r), bool)
    keep[5000:5400] = keep[12_000:12_001] = False
    force = r.specific_force.copy()
    force[1::2] = np.nan
    r = bm.Recording(time=r.time[keep], specific_force=force[keep], angular_rate=r.angular_rate[keep], source="gaps")
    found = bm.allan(r)
    assert found["accelerometer"].rate_hz == pytest.approx(50.0)
    assert found["gyroscope"].rate_hz == pytest.approx(100.0)
    assert any(w.startswith("gyroscope: 2 gaps") for w in found.warnings)
    assert found.noise()["velocity_random_walk"] == pytest.approx(0.02 / math.sqrt(50), rel=0.03)


def test_a_large_offset_costs_no_digits() -> None:
    r = resting()
    small = bm.allan(r)["accelerometer"].deviation
    assert bm.allan(r.replace(specific_force=r.specific_force + np.array([0.0, 1.0, 0.0])))["accelerometer"].deviation == pytest.approx(
        small, rel=1e-9
    )


def test_unknown_spacing() -> None:
    with pytest.raises(bm.UsageError, match="octave or decade"):
        bm.allan(resting(), spacing="hexade")  # pyright: ignore[reportArgumentType]


def test_bias_walk_stands_for_what_was_found() -> None:
    """Flicker of B becomes the random walk with the deviation 0.664 B at the horizon; a random walk stays what it is."""
    rng, n = np.random.default_rng(0), 100_000
    rate = np.column_stack([made(n, 20.0, rng, white=1e-4, flicker=5e-5) for _ in range(3)])
    force = np.array([0, 0, 9.8]) + np.column_stack([made(n, 20.0, rng, white=1e-3, walk=1e-4) for _ in range(3)])
    noise = bm.allan(bm.Recording(time=np.arange(n) / 20, specific_force=force, angular_rate=rate)).noise(100.0)
    assert noise["gyro_bias_walk"] == pytest.approx(0.664 * 5e-5 * math.sqrt(3 / 100), rel=0.1)
    assert noise["accel_bias_walk"] == pytest.approx(1e-4, rel=0.15)


def test_command_writes_what_track_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording(resting(), tmp_path / "rest.csv")
    write_recording(simulate("short"), tmp_path / "walk.csv")
    assert main(["allan", str(tmp_path / "rest.csv"), "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "white noise" in said
    assert "°/√h" in said
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "allan.csv",
        "coefficients.csv",
        "allan.json",
        "noise.toml",
        "allan.html",
        "allan.png",
        "allan.svg",
    }
    walk = ["track", str(tmp_path / "walk.csv"), "--no-report", "-q", "-o", str(tmp_path / "walk")]
    assert main([*walk, "--config", str(tmp_path / "out" / "noise.toml")]) == 0
    wanted = tomllib.loads((tmp_path / "out" / "noise.toml").read_text("utf-8"))["parameters"]["noise"]
    used = tomllib.loads((tmp_path / "walk" / "config.toml").read_text("utf-8"))["parameters"]["noise"]
    assert wanted.keys() == {"angle_random_walk", "velocity_random_walk"}
    assert {key: used[key] for key in wanted} == wanted


def test_command_refuses_a_walk(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording(simulate("short", rest_s=3.0), tmp_path / "walk.csv")
    assert main(["allan", str(tmp_path / "walk.csv"), "-o", str(tmp_path / "out")]) == 1
    assert "does not lie still" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["12_undisturbed_slow_translation_C", "33_disturbed_attached_magnet_2cm"])
def test_real_rests(shared_data: Path, name: str) -> None:
    """The rest before the motion, 30 to 40 s: it shows the white noise and no more."""
    m = loadmat(shared_data / "attitude" / "broad" / f"{name}.mat")
    time = np.arange(len(m["imu_acc"])) / float(m["sampling_rate"].squeeze())
    recording = bm.Recording(
        time=time, specific_force=m["imu_acc"], angular_rate=m["imu_gyr"], magnetic_time=time, magnetic_flux_density=m["imu_mag"]
    )
    found = bm.allan(recording)
    assert found.start_s == 0.0
    assert 25 < found.end_s < 45
    assert any("longest rest" in w for w in found.warnings)
    assert not any("end of the range" in w for w in found.warnings)
    noise = found.noise()
    assert 0.003 < math.degrees(noise["angle_random_walk"]) < 0.01
    assert 150e-6 < noise["velocity_random_walk"] / 9.81 < 500e-6
    assert "gyro_bias_walk" not in noise
    # The magnetometer's samples are those of a slower one, interpolated: 0.08 µT/√Hz, and no process of milliseconds.
    assert found["magnetometer"].white() == pytest.approx(0.078, abs=0.01)
    assert all(fit is not None and fit.good and fit.skipped for fit in found["magnetometer"].fits)
