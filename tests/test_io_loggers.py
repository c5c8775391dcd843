"""Readers of loggers that write each sensor by itself: values, units, clocks, and that no reader takes another's file."""

import re

import numpy as np
import pytest

from bematist.errors import BematistError, DataError
from bematist.io import FORMATS, read
from bematist.io.head import open_head
from bematist.recording import Recording
from logger_files import (
    EPOCH_S,
    FIELD,
    FILES,
    INDOOR_HEAD,
    LATE_S,
    PHYPHOX,
    fine,
    getsensordata_text,
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


# GetSensorData ---------------------------------------------------------------------------------------------------------


def test_getsensordata(tmp_path):
    r = read(FILES["getsensordata"][1](tmp_path))
    assert r.phone and "Device: samsung SM-A520F" in r.notes and not r.warnings
    assert r.time[0] == pytest.approx(12.0035 + LATE_S, abs=1e-3), "the sensors' stamps on the app's clock"
    assert np.diff(r.time).std() < 2e-6, "without its jitter"
    assert (r.pressure == 100050).all()
    assert r.reference is not None and "POSI" in r.reference.note
    np.testing.assert_allclose(r.reference.time, 12 + np.arange(6))
    np.testing.assert_allclose(np.diff(r.reference.position[:, 0]), 1.4336, atol=1e-3)
    assert any("6 lines IMUX" in n for n in r.notes)


@pytest.mark.parametrize("apart", [{"GYRO": 7000.0}, {"GYRO": 5000.02}])
def test_getsensordata_clocks_that_begin_apart(tmp_path, apart):
    """Another beginning is taken out; 20 ms is how late the app was told, and stays."""
    path = tmp_path / "logfile.txt"
    path.write_text(getsensordata_text(dict.fromkeys(("ACCE", "GYRO", "MAGN"), 5000.0) | apart, posi=False))
    r = read(path)
    late = 0.020 if apart["GYRO"] < 6000 else 0.0
    assert r.time[0] == pytest.approx(12.0035 + LATE_S + late, abs=3e-3)
    assert any(("each with a beginning" in n) == (late == 0) for n in r.notes if n.startswith("Clock: the sensors"))
    assert r.reference is not None and "satellite" in r.reference.note


def test_getsensordata_sensor_clock_that_stands(tmp_path):
    path = tmp_path / "logfile.txt"
    text = re.sub(r"^(ACCE;[^;]*);[^;]*;", r"\1;0;", getsensordata_text(dict.fromkeys(("ACCE", "GYRO", "MAGN"), 0.0)), flags=re.M)
    path.write_text(text)
    r = read(path)
    assert any("the app's stamps" in n for n in r.notes) and r.duration_s == pytest.approx(5.99, abs=0.02)


# Sensors that are strapped on ------------------------------------------------------------------------------------------


def test_xsens(tmp_path):
    for name in ("xsens_old", "xsens_new", "xsens_without_fine_time"):
        r = read(FILES[name][1](tmp_path))
        np.testing.assert_allclose(np.diff(r.time), 0.01, atol=1e-7)
        np.testing.assert_allclose(r.specific_force, rows()[:, 1:4], rtol=1e-7)
        np.testing.assert_allclose(r.magnetic_flux_density, rows()[:, 7:] / FIELD * 50, rtol=1e-7)
        assert not r.phone and [w for w in r.warnings if "absolute scale" not in w] == []
    path = tmp_path / "MT_0100_000.txt"
    path.write_text(path.read_text().replace("Update Rate", "Rate"))
    with pytest.raises(DataError, match="rate_hz"):
        read(path)


def test_movella_dot(tmp_path):
    for name in ("dot_rate", "dot_custom", "dot_delta"):
        r = read(FILES[name][1](tmp_path))
        np.testing.assert_allclose(np.diff(r.time), 0.01, atol=1e-7)
        np.testing.assert_allclose(r.angular_rate, rows()[:, 4:7], atol=1e-7)
        np.testing.assert_allclose(r.specific_force, rows()[:, 1:4], rtol=1e-7)
        assert r.has_magnetometer == (name != "dot_custom") and "Device: DOT 1" in r.notes


def test_metamotion(tmp_path):
    r = read(FILES["metamotion_folder"][1](tmp_path))
    np.testing.assert_allclose(r.magnetic_flux_density, rows(step=2)[:, 7:], rtol=1e-6)
    assert r.start_ns == EPOCH_S * 10**9
    FILES["metamotion_one_file"][1](tmp_path)
    with pytest.raises(DataError, match="3 recordings"):
        read(tmp_path)


def test_shimmer(tmp_path):
    r = read(FILES["shimmer_semicolon"][1](tmp_path))
    np.testing.assert_allclose(r.specific_force, rows()[:, 1:4], rtol=1e-7)
    assert any("wide-range" in n for n in r.notes) and "Device: Shimmer_40AC" in r.notes
    assert r.start_ns == pytest.approx(EPOCH_S * 10**9, abs=1e3)
    assert read(FILES["shimmer_dates"][1](tmp_path)).start_ns == EPOCH_S * 10**9


# Bad input -------------------------------------------------------------------------------------------------------------

BAD: dict[str, tuple[str, str, str, str]] = {
    # what is wrong: variant, pattern, replacement, what the message says
    "indoor, no gyroscope": ("indoor", r"TYPE_GYROSCOPE", "TYPE_GIRO", "no gyroscope"),
    "indoor, mixed clocks": ("indoor", r"^1700000(\d{6}\tTYPE_GYRO)", r"0000123\1", "no time in common"),
    "getsensordata, no accelerometer": ("getsensordata", r"^ACCE;", "AXXE;", "no accelerometer"),
    "xsens, half a gyroscope": ("xsens_new", r"Gyr_Y", "Other", "lacks the axis y"),
    "xsens, orientation only": ("xsens_old", r"(Acc|Gyr)_", "Free\\1_", "orientation and free acceleration"),
    "dot, Euler mode": ("dot_rate", r"(Acc|Gyr)_", "Free\\1_", "orientation and free acceleration"),
    "dot, text in a number": ("dot_custom", r"^7,\d+,1,", "7,oops,1,", "line 20"),
    "shimmer, no gyroscope": ("shimmer_tab", r"_Gyro_", "_Giro_", "no gyroscope"),
    "shimmer, uncalibrated": ("shimmer_tab", r"Timestamp_Unix_CAL", "Timestamp_Unix_RAW", "calibrated timestamp"),
    "metamotion, another unit": ("metamotion_one_file", r"deg/s", "rpm", "rpm"),
    "logger, no z": ("logger_one_csv", r"elapsed,z", "elapsed,Z", "no format|no column z"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_in_one_paragraph(tmp_path, name):
    kind, pattern, new, message = BAD[name]
    path = FILES[kind][1](tmp_path)
    text, n = re.subn(pattern, new.replace("\\\\", "\\"), path.read_text(encoding="utf-8"), flags=re.M)
    assert n
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=message) as error:
        read(path)
    one_paragraph(error.value)


def one_paragraph(error: BematistError) -> None:
    assert "\n" not in str(error) and len(str(error)) < 900


MISSING = {
    "logger_ios_raw_in_g": {"Gyroscope.csv": "no gyroscope", "AccelerometerUncalibrated.csv": "no accelerometer"},
    "logger_android_without_total": {"Gravity.csv": "without gravity"},
    "phyphox_without_letters": {"Gyroscope.csv": "no gyroscope", "Accelerometer.csv": "no accelerometer"},
    "text_folder": {"accelerometer.txt": "no accelerometer", "gyroscope-calibrated.txt": "no gyroscope"},
    "metamotion_folder": {"MetaWear_2023-11-14T15.13.20_C0FFEE_Gyroscope_100.000Hz_1.4.4.csv": "no gyroscope"},
}


@pytest.mark.parametrize("kind,file", [(kind, file) for kind, files in MISSING.items() for file in files])
def test_a_missing_sensor_is_named(tmp_path, kind, file):
    path = FILES[kind][1](tmp_path)
    (path / file).unlink()
    with pytest.raises(DataError, match=MISSING[kind][file]) as error:
        read(path)
    one_paragraph(error.value)


def test_an_empty_or_mixed_file_in_a_folder(tmp_path):
    path = FILES["logger_ios_standardised"][1](tmp_path)
    (path / "Magnetometer.csv").write_text("")
    assert not read(path).has_magnetometer
    text = (path / "Gyroscope.csv").read_text()
    (path / "Gyroscope.csv").write_text(re.sub(r"^1700000", "1600000", text, flags=re.M))
    with pytest.raises(DataError, match="no time in common") as error:
        read(path)
    one_paragraph(error.value)
    (path / "Gyroscope.csv").write_text("time,seconds_elapsed,z,y,x\n")
    with pytest.raises(DataError, match="no gyroscope"):
        read(path)


def test_phyphox_without_gravity(tmp_path):
    files = phyphox_files(names={k: PHYPHOX[k] for k in ("Linear Acceleration", "Gyroscope")})
    with pytest.raises(DataError, match=r"Acceleration \(with g\)") as error:
        read(zipped(tmp_path / "a.zip", files))
    one_paragraph(error.value)


@pytest.mark.parametrize("kind", ["indoor", "shimmer_tab", "logger_android_without_total"])
def test_two_recordings_in_one_file(tmp_path, kind):
    """A logger that goes on writing into the file of last week: read as one, and said."""
    path = FILES[kind][1](tmp_path)
    for file in path.glob("*.csv") if path.is_dir() else [path]:
        lines = file.read_text(encoding="utf-8").splitlines()
        old = [line for line in lines if re.match(r"1\.?700000", line)]
        if kind == "shimmer_tab":
            new = [f"{float(line.split()[0]) + 7e8:.16E}\t" + line.split("\t", 1)[1] for line in old]
        else:
            new = [line.replace("1700000", "1700700", 1) for line in old]
        file.write_text("\n".join([*lines, *new]) + "\n", encoding="utf-8")
    r = read(path)
    assert len(r) >= 1190 and r.duration_s < 13
    assert any("leapt ahead" in w for w in r.warnings)


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_was_cut_is_read_or_refused_in_words(tmp_path, name):
    path = FILES[name][1](tmp_path)
    for file in sorted(path.glob("*.*")) if path.is_dir() else [path]:
        whole = file.read_bytes()
        for part in (0.001, 0.02, 0.3, 0.617, 0.999):
            file.write_bytes(whole[: int(part * len(whole))])
            try:
                assert len(read(path)) >= 1
            except BematistError as error:
                one_paragraph(error)
        file.write_bytes(whole)


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
    path.write_text(INDOOR_HEAD + "\n".join(lines[:100]) + "\n" + "".join(lines[100:103]) + "\n" + "\n".join(lines[103:]) + "\n")
    r = read(path)
    np.testing.assert_allclose(r.specific_force, rows()[:, 1:4], rtol=1e-7)
    assert any("1 in which several had run together" in n for n in r.notes)


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


def test_a_method_for_the_shoe_warns_of_a_phone(tmp_path):
    from bematist import FootIns

    r = read(indoor(tmp_path))
    assert any("phone" in w for w in FootIns().run(r).warnings)
    assert not any("phone" in w for w in FootIns().run(r.replace(phone=False)).warnings)
