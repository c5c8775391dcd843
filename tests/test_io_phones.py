"""Readers of loggers that write each sensor by itself: values, units, clocks, and that no reader takes another's file."""

import numpy as np
import pytest

from bematist.errors import DataError
from bematist.io import FORMATS, read
from bematist.io.head import open_head
from bematist.recording import Recording
from phone_files import (
    EPOCH_S,
    FILES,
    INDOOR_HEAD,
    LATE_S,
    fine,
    indoor,
    indoor_lines,
    phyphox_files,
    rows,
    sensor_logger_files,
    text_folder,
    zipped,
)


@pytest.mark.parametrize("name", FILES)
def test_each_reader_finds_its_own_files_and_no_other(tmp_path, name):
    wanted, write = FILES[name]
    head = open_head(write(tmp_path))
    assert [f.name for f in FORMATS.values() if f.load().sniff(head)] == [wanted]


@pytest.mark.parametrize("name", FILES)
def test_every_variant_holds_the_same_motion(tmp_path, name):
    """Whatever the units, signs, separators and clocks: SI, the accelerometer +g up, the field in µT."""
    r = read(FILES[name][1](tmp_path))
    same_motion(r)


def same_motion(r: Recording) -> None:
    since = r.time - r.time[0]
    assert len(r) >= 590 and np.isfinite(r.specific_force).all()
    for late in (0.0, LATE_S):
        now = fine()[np.round((since + late) * 1000).astype(int)]
        if np.abs(now[:, 4:7] - r.angular_rate).max() < 1e-4:
            # The noise of 0.02 m/s², and chords.
            assert np.abs(now[:, 1:4] - r.specific_force).max() < 0.15
            return
    raise AssertionError("the gyroscope is neither that of the accelerometer's instants nor of its own")


# Sensor Logger ---------------------------------------------------------------------------------------------------------


def test_sensor_logger(tmp_path):
    r = read(FILES["logger_ios_zip"][1](tmp_path))
    assert r.start_ns == pytest.approx(EPOCH_S * 10**9, abs=1e7) and r.phone and not r.warnings
    np.testing.assert_allclose(r.magnetic_flux_density, rows(step=2)[:, 7:], rtol=1e-6)
    assert (r.pressure == 100050).all() and len(r.pressure) == 6
    assert r.reference is not None and "stated accuracy 5 m" in r.reference.note
    np.testing.assert_allclose(np.diff(r.reference.position, axis=0), [[0.7168, 0, 1]] * 4, atol=1e-3)
    assert any("turned to the sign" in n and "ios, as Metadata.csv says" in n for n in r.notes)
    assert any("My phone" in n for n in r.notes)


@pytest.mark.parametrize("only,warned", [("total", False), ("raw", True)])
def test_sensor_logger_without_metadata(tmp_path, only, warned):
    files = sensor_logger_files(only=only)
    del files["Metadata.csv"]
    r = read(zipped(tmp_path / "a.zip", files))
    same_motion(r)
    assert any("iPhone" in w for w in r.warnings) == warned


def test_sensor_logger_ios_told_by_its_location(tmp_path):
    files = sensor_logger_files("ios")
    del files["Metadata.csv"]
    files["Location.csv"] = files["Location.csv"].replace("altitude,", "altitudeAboveMeanSeaLevel,altitude,").replace(",0,10", ",0,99,10")
    r = read(zipped(tmp_path / "a.zip", files))
    same_motion(r)
    assert not r.warnings


# phyphox ---------------------------------------------------------------------------------------------------------------


def test_phyphox(tmp_path):
    r = read(FILES["phyphox_semicolon_comma"][1](tmp_path))
    assert r.start_ns == EPOCH_S * 10**9 and r.phone and not r.warnings
    np.testing.assert_allclose(r.magnetic_flux_density, rows(step=2)[:, 7:], rtol=1e-7)
    assert any("Acceleration x (m/s^2) … is the one with gravity" in n for n in r.notes) and "Device: google Pixel 6a" in r.notes


def test_phyphox_pauses_are_put_in(tmp_path):
    files = phyphox_files()
    files["meta/time.csv"] += '"PAUSE",3.0,1700000003.0,"x"\n"START",3.0,1700000063.0,"x"\n"PAUSE",6.0,1700000066.0,"x"\n'
    r = read(zipped(tmp_path / "a.zip", files))
    assert r.duration_s == pytest.approx(65.99, abs=0.02)
    assert np.diff(r.time).max() == pytest.approx(60.01, abs=1e-3)
    assert any("1 gaps" in w for w in r.warnings) and any("1, 60 s in all" in n for n in r.notes)


# Indoor Location 2.0 ---------------------------------------------------------------------------------------------------


def test_indoor_location(tmp_path):
    r = read(indoor(tmp_path))
    want = rows()
    np.testing.assert_allclose(r.specific_force, want[:, 1:4], rtol=1e-7)
    np.testing.assert_allclose(r.angular_rate, want[:, 4:7], rtol=1e-7)
    np.testing.assert_allclose(r.magnetic_flux_density, want[:, 7:], rtol=1e-7)
    assert r.start_ns == EPOCH_S * 10**9 and r.phone
    assert (r.pressure == 100050).all() and len(r.pressure) == 12
    assert r.reference is not None
    np.testing.assert_allclose(r.reference.time, [0, 2, 4], atol=1e-9)
    np.testing.assert_allclose(r.reference.position[:, 0], [100, 102, 104])
    assert np.isnan(r.reference.position[:, 2]).all() and "B1" in r.reference.note
    assert "Device: OPPO PBCM10" in r.notes and not r.warnings


def test_uncalibrated_alone_has_its_bias_taken_off(tmp_path):
    r = read(FILES["indoor_uncalibrated"][1](tmp_path))
    np.testing.assert_allclose(r.angular_rate, rows()[:, 4:7], atol=1e-7)
    np.testing.assert_allclose(r.magnetic_flux_density, rows()[:, 7:], atol=1e-6)
    assert sum("bias taken off" in n for n in r.notes) == 3


def test_lines_that_ran_together_are_parted(tmp_path):
    lines = indoor_lines()
    path = indoor(tmp_path)
    path.write_text(INDOOR_HEAD + "\n".join(lines[:100]) + "".join(lines[100:102]) + "\n" + "\n".join(lines[102:]) + "\n")
    r = read(path)
    np.testing.assert_allclose(r.specific_force, rows()[:, 1:4], rtol=1e-7)
    assert any("1 that ran together" in n or "2 that ran together" in n for n in r.notes)


def test_text_folder(tmp_path):
    r = read(text_folder(tmp_path))
    assert r.start_ns == 1464685476 * 10**9 and "Device: LGE Nexus 5" in r.notes and r.phone
    np.testing.assert_allclose(r.angular_rate, rows(LATE_S)[: len(r), 4:7], rtol=1e-7)
    np.testing.assert_allclose(r.magnetic_flux_density, rows(step=2)[:, 7:], rtol=1e-7)
    assert any("instants of the gyroscope" in n for n in r.notes)
    (tmp_path / "gyroscope-calibrated.txt").unlink()
    with pytest.raises(DataError, match="no gyroscope"):
        read(tmp_path)


def test_nexus5_reference_turns_as_the_gyroscope(shared_data):
    """The offset's sign and the matrix' order: the room's angular rate and the phone's agree, and gravity is up."""
    from bematist.frames import conjugate, multiply, rotate, rotation_vector_from_quaternion

    for name in ("Guillaume_Nexus5_NoDist_Texting", "Thibaud_Nexus5_NoDist_Swinging"):
        r = read(shared_data / "hand/nexus5_mocap" / name)
        ref = r.reference
        assert ref is not None and ref.attitude is not None and r.phone
        rate = rotation_vector_from_quaternion(multiply(conjugate(ref.attitude[:-1]), ref.attitude[1:])) * 60
        middle = (ref.time[1:] + ref.time[:-1]) / 2
        w = np.stack([np.interp(middle, r.time, r.angular_rate[:, k]) for k in range(3)], 1)
        known = np.isfinite(rate).all(1) & (middle > r.time[0]) & (middle < r.time[-1])
        off = np.median(np.linalg.norm(rate - w, axis=1)[known])
        assert off < 0.25 * np.median(np.linalg.norm(w, axis=1)[known]), "the median, as the markers leap at times"
        f = np.stack([np.interp(ref.time, r.time, r.specific_force[:, k]) for k in range(3)], 1)
        inside = np.isfinite(ref.attitude).all(1) & (ref.time > r.time[0]) & (ref.time < r.time[-1])
        mean = rotate(ref.attitude[inside], f[inside]).mean(0)
        np.testing.assert_allclose(mean, [0, 0, 9.7], atol=0.15)
        assert 0.5 < np.nanmedian(ref.position[:, 2]) < 2


def test_indoor_location_of_the_data_set(shared_data):
    for path in sorted((shared_data / "hand/ms_indoor20").glob("*.txt")):
        r = read(path)
        assert r.reference is not None and len(r.reference.time) in (8, 9) and r.reference.time[-1] < r.time[-1] + 1
        assert r.rate_hz == pytest.approx(50, rel=0.02) and not r.warnings
