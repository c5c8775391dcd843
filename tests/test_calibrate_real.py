"""Calibration from real recordings, and by the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

import bematist as bm
from bematist.cli import main
from bematist.errors import DataError, UsageError
from bematist.simulate import Sensor, simulate

MAP = Path(__file__).parents[1] / "examples" / "imucal.toml"
PHONE = "hand/nexus5_mocap"


@pytest.fixture(scope="module")
def shoe(shared_data):
    folder = shared_data / "calibration/imucal"
    sections = json.loads((folder / "example_ferraris_session_list.json").read_text())
    return bm.read(folder / "example_ferraris_session.csv", columns=MAP), sections


def test_shoe_sensor_gravity_and_turns(shoe):
    """Six positions within 0.2 % of gravity, whole turns that were not told within 1 %; the sections that the data name were not told
    either."""
    recording, sections = shoe
    found = bm.calibrate(recording)
    better = found.apply(recording)
    assert max(abs(t.before / 360 - 1) for t in found.evidence.known_turns) > 0.02
    assert all(t.after == pytest.approx(360, rel=0.01) for t in found.evidence.known_turns)
    for name, part in sections.items():
        rows = slice(part["start"], part["end"])
        if name.endswith("rot"):
            turn = np.degrees(better.angular_rate[rows, "xyz".index(name[0])].sum() / 102.4)
            assert abs(turn) == pytest.approx(360, rel=0.01), name
        else:
            for r, least, most in ((recording, 0.01, 0.08), (better, 0.0, 0.002)):
                off = abs(np.linalg.norm(r.specific_force[rows].mean(0)) / 9.80665 - 1)
                assert least <= off < most, name


def test_phone_magnetometer_beats_the_phones_own(shared_data):
    folder = shared_data / PHONE / "calib_mag_Nexus5_d1"
    own, raw = bm.read(folder), bm.read(folder, uncalibrated=True)
    assert raw.sensing.uncalibrated
    assert not own.sensing.uncalibrated
    found = bm.calibrate(raw, sensors=["magnetometer"])

    def spread(r):
        size = np.linalg.norm(r.magnetic_flux_density, axis=1)
        return size.std() / size.mean()

    assert spread(own) > 0.028
    assert spread(found.apply(raw)) < 0.016
    with pytest.raises(DataError, match="phone's raw readings"):
        found.apply(own)
    with pytest.raises(UsageError, match="no uncalibrated readings"):
        bm.read(shared_data / "foot/ngimu/short_walk.csv", uncalibrated=True)


def test_the_device_of_a_recording_is_read(shared_data):
    assert bm.read(shared_data / PHONE / "Guillaume_Nexus5_NoDist_Texting").sensing.device == "03bd36a425202217"


@pytest.fixture
def tumble(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    from bematist.io import write_recording

    device = Sensor(
        rate_hz=100.0,
        magnetometer_rate_hz=20.0,
        velocity_random_walk=1e-3,
        accel_bias=(0.3, 0.0, -0.2),
        magnetic_bias=(30.0, 0.0, 0.0),
    )
    write_recording(simulate("tumble", device, tumble_rests=12, tumble_rest_s=2.0), tmp_path / "tumble.csv")
    write_recording(simulate("short", device), tmp_path / "walk.csv")
    return tmp_path


def test_the_chain(tumble, capsys):
    """calibrate, then every command that reads a recording takes the file; the configuration gives the same path again."""
    assert main(["calibrate", "tumble.csv", "-o", "sensor.toml"]) == 0
    said = capsys.readouterr().out
    assert " rests: off gravity by" in said and "comparisons after turns: missed by" in said
    assert (tumble / "sensor.html").stat().st_size > 1e6
    assert (tumble / "sensor.png").read_bytes()[1:4] == b"PNG"
    page = (tumble / "sensor.html").read_text("utf-8")
    assert "accelerometer-ball" in page
    assert "magnetometer-error" in page
    assert "Drag a sphere to turn it." in page and "all plots follow" not in page
    for command in (["info", "walk.csv"], ["convert", "walk.csv", "better.csv"], ["attitude", "walk.csv", "-o", "a", "--no-report"]):
        assert main([*command, "--calibration", "sensor.toml"]) == 0, command
    assert "calibrated from tumble.csv" in capsys.readouterr().out
    assert main(["track", "walk.csv", "--calibration", "sensor.toml", "-o", "one", "--no-report"]) == 0
    assert 'calibration = "' in (tumble / "one/config.toml").read_text("utf-8")
    assert main(["track", "walk.csv", "--config", "one/config.toml", "-o", "two", "--no-report"]) == 0
    assert (tumble / "one/trajectory.csv").read_bytes() == (tumble / "two/trajectory.csv").read_bytes()
    assert main(["track", "walk.csv", "-o", "raw", "--no-report"]) == 0
    assert (tumble / "raw/trajectory.csv").read_bytes() != (tumble / "one/trajectory.csv").read_bytes()


@pytest.mark.parametrize(
    ("args", "status", "says"),
    [
        (["calibrate", "walk.csv", "--sensor", "accelerometer", "-o", "s.toml"], 1, "too few to calibrate the accelerometer"),
        (["calibrate", "tumble.csv", "--turn", "up", "-o", "s.toml"], 2, "write the axis and the angle"),
        (["calibrate", "tumble.csv", "--gravity", "1", "-o", "s.toml"], 2, "on the Earth"),
        (["calibrate", "tumble.csv", "--gravity", "9.8", "--latitude", "40", "-o", "s.toml"], 2, "either --gravity or --latitude"),
        (["calibrate", "tumble.csv", "-o", "tumble.csv"], 2, "written over"),
        (["track", "walk.csv", "--calibration", "walk.csv", "-o", "x"], 2, "not TOML"),
        (["track", "walk.csv", "--calibration", "none.toml", "-o", "x"], 1, "cannot be opened"),
    ],
)
def test_wrong_use_is_one_paragraph(tumble, capsys, args, status, says):
    assert main(args) == status
    said = capsys.readouterr().err
    assert says in said
    assert "Traceback" not in said
    assert not (tumble / "s.toml").exists()
