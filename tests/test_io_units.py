"""Units guessed from evidence, said, doubted and forced; column maps."""

import numpy as np
import pytest

from bematist.earth import STANDARD_GRAVITY as G
from bematist.errors import DataError, UsageError
from bematist.io import guess, read
from test_io_formats import HEADER, walk_rows, write

MAP = """
[time]
column = "t"
[specific_force]
columns = ["ax", "ay", "az"]
[angular_rate]
columns = ["gx", "gy", "gz"]
[magnetic_flux_density]
columns = ["bx", "by", "bz"]
"""
NAMES = "t,ax,ay,az,gx,gy,gz,bx,by,bz"


def mapped(tmp_path, rows, text=MAP, header=NAMES, name="a.csv", **keywords):
    (tmp_path / "map.toml").write_text(text)
    path = write(tmp_path / name, header, rows, fmt="%.12g")
    return read(path, columns=tmp_path / "map.toml", **keywords)


def scaled(force=1.0, rate=1.0, field=1.0, time=1.0):
    return walk_rows() * np.repeat([time, force, rate, field], [1, 3, 3, 3])


@pytest.mark.parametrize("force", [1.0, 1 / G, 1000 / G])
@pytest.mark.parametrize("rate", [1.0, np.degrees(1.0)])
def test_force_and_rate_are_guessed(tmp_path, force, rate):
    r = mapped(tmp_path, scaled(force, rate))
    np.testing.assert_allclose(r.specific_force, walk_rows()[:, 1:4], rtol=1e-6)
    np.testing.assert_allclose(r.angular_rate, walk_rows()[:, 4:7], rtol=1e-6)
    assert sum("not stated" in w for w in r.warnings) == 4
    assert any("norm at rest" in n for n in r.notes)


def test_slow_rocking_is_told_from_gravity_not_from_the_peak(tmp_path):
    """A peak of 2.8 could be either unit; gravity turns with the gyroscope in only one of them."""
    assert guess.peak_rate(walk_rows()[:, 4:7]) < 3
    r = mapped(tmp_path, scaled(rate=np.degrees(1.0)))
    assert any("gravity turns with the gyroscope as deg/s" in n for n in r.notes)


@pytest.mark.parametrize("field", [1.0, 0.01, 10.0, 1000.0, 1e-6])
def test_field_is_guessed(tmp_path, field):
    r = mapped(tmp_path, scaled(field=field))
    np.testing.assert_allclose(r.magnetic_flux_density, walk_rows()[:, 7:], rtol=1e-6)


@pytest.mark.parametrize("time", [1.0, 1e3, 1e6, 1e9])
def test_time_is_guessed(tmp_path, time):
    r = mapped(tmp_path, scaled(time=time))
    np.testing.assert_allclose(r.time, walk_rows()[:, 0], atol=1e-6)


@pytest.mark.parametrize("number", [32, 35])
def test_guess_on_real_walks(shared_data, number):
    raw = np.loadtxt(shared_data / f"foot/gsu_gx5/SensorConnectData_{number}.csv", delimiter=",", skiprows=1)
    time, force, rate = raw[:, 0], raw[:, 1:4] * G, raw[:, 4:7]
    assert guess.unit_of("specific_force", {"specific_force": raw[:, 1:4]}, time)[0] == "g"
    assert guess.unit_of("angular_rate", {"specific_force": force, "angular_rate": rate}, time)[0] == "rad/s"
    assert guess.unit_of("angular_rate", {"specific_force": force, "angular_rate": np.degrees(rate)}, time)[0] == "deg/s"
    assert guess.unit_of("magnetic_flux_density", {"magnetic_flux_density": raw[:, 7:10]}, time)[0] == "G"


def test_canonical_in_g_and_degrees_is_doubted_and_can_be_forced(tmp_path):
    path = write(tmp_path / "a.csv", HEADER, scaled(1 / G, np.degrees(1.0), 0.01))
    r = read(path)
    np.testing.assert_allclose(r.specific_force, walk_rows()[:, 1:4] / G, rtol=1e-6)  # as the contract says, with a warning
    doubts = "\n".join(r.warnings)
    for text in ("--units specific_force=g", "--units magnetic_flux_density=G"):
        assert text in doubts
    wrong = read(path, units={"specific_force": "m/s^2", "angular_rate": "rad/s", "magnetic_flux_density": "mT"})
    for said in ("m/s^2 (as asked), but its norm at rest would be", "rad/s (as asked), but", "mT (as asked), but its middle norm would be"):
        assert any(said in w for w in wrong.warnings), said
    forced = read(path, units={"specific_force": "g", "angular_rate": "deg/s", "magnetic_flux_density": "G"})
    np.testing.assert_allclose(forced.specific_force, walk_rows()[:, 1:4], rtol=1e-6)
    np.testing.assert_allclose(forced.angular_rate, walk_rows()[:, 4:7], rtol=1e-6)
    assert not forced.warnings


def test_canonical_rate_in_degrees_alone_is_doubted(tmp_path):
    r = read(write(tmp_path / "a.csv", HEADER, scaled(rate=np.degrees(1.0))))
    assert any("--units angular_rate=deg/s" in w for w in r.warnings)


def test_a_forced_rate_that_is_too_slow_is_doubted(shared_data):
    """What is forced is done, with a warning that reaches the results."""
    walk = shared_data / "foot/gsu_gx5/SensorConnectData_32.csv"
    r = read(walk, units={"angular_rate": "deg/s"})
    assert any("deg/s (as asked), but its peak would be 8.3 °/s" in w for w in r.warnings)
    assert not read(walk, units={"angular_rate": "rad/s"}).warnings


def test_canonical_time_in_ms_is_doubted(tmp_path):
    path = write(tmp_path / "a.csv", HEADER, scaled(time=1e3))
    assert any("--units time=ms" in w for w in read(path).warnings)
    np.testing.assert_allclose(read(path, units={"time": "ms"}).time, walk_rows()[:, 0], atol=1e-9)
    assert any("give --units time=ms" in w for w in read(path, units={"time": "s"}).warnings)


def test_a_column_that_numbers_samples_is_no_time(tmp_path):
    rows = walk_rows()
    rows[:, 0] = np.arange(len(rows))
    with pytest.raises(DataError, match="rate_hz"):
        mapped(tmp_path, rows)


def test_slow_canonical_rate_in_degrees_is_doubted(tmp_path):
    """A peak of 12 could be rad/s, as a foot has; gravity, which turns in a second or so, tells that it is not."""
    t = np.arange(3000) / 100
    tilt = 0.6 * np.sin(2 * np.pi * 0.06 * t)
    rate = np.stack([np.gradient(tilt, t), 0 * t, 0 * t], 1)
    force = G * np.stack([0 * t, np.sin(tilt), np.cos(tilt)], 1)
    noise = 1e-3 * np.random.default_rng(0).normal(size=(3000, 6))
    right = np.column_stack([t, np.hstack([force, rate]) + noise])
    header = HEADER.removesuffix(",mx,my,mz")
    assert not read(write(tmp_path / "a.csv", header, right)).warnings
    wrong = right * np.r_[np.ones(4), np.full(3, np.degrees(1.0))]
    assert 10 < guess.peak_rate(wrong[:, 4:7]) < 20
    assert any("angular_rate=deg/s" in w for w in read(write(tmp_path / "b.csv", header, wrong)).warnings)


def test_wrong_units_asked(tmp_path):
    path = write(tmp_path / "a.csv", HEADER, walk_rows())
    with pytest.raises(UsageError, match="furlong"):
        read(path, units={"specific_force": "furlong"})
    with pytest.raises(UsageError, match="quantity"):
        read(path, units={"force": "g"})


# Column maps ----------------------------------------------------------------------------------------------------------


def test_map_with_units_axes_skipped_lines_and_semicolons(tmp_path):
    text = """
        separator = ";"
        decimal = ","
        skip_lines = 2
        [time]
        column = "t"
        unit = "ms"
        [specific_force]
        columns = ["az", "ax", "ay"]
        unit = "g"
        axes = "y,z,x"
        [angular_rate]
        columns = [5, 6, 7]
        unit = "deg/s"
    """
    rows = scaled(1 / G, np.degrees(1.0), time=1e3)
    path = write(tmp_path / "a.csv", NAMES.replace(",", ";"), rows, fmt="%.12g", sep=";")
    path.write_text("My logger, version 3\nbattery 80 %\n" + path.read_text().replace(".", ","))
    (tmp_path / "map.toml").write_text(text)
    r = read(path, columns=tmp_path / "map.toml")
    np.testing.assert_allclose(r.specific_force, walk_rows()[:, 1:4], rtol=1e-6)
    np.testing.assert_allclose(r.angular_rate, walk_rows()[:, 4:7], rtol=1e-6)
    np.testing.assert_allclose(r.time, walk_rows()[:, 0], atol=1e-9)
    assert not r.has_magnetometer and not r.warnings


def test_map_with_dates(tmp_path):
    rows = walk_rows()
    (tmp_path / "map.toml").write_text(MAP)
    body = [f"2026-11-22T01:00:{row[0]:09.6f}," + ",".join(f"{v:.9g}" for v in row[1:]) for row in rows]
    path = tmp_path / "a.csv"
    path.write_text(NAMES + "\n" + "\n".join(body) + "\n\n\n")
    r = read(path, columns=tmp_path / "map.toml")
    np.testing.assert_allclose(r.time, rows[:, 0], atol=1e-6)
    assert r.start_ns == 1795309200 * 10**9
    assert not any("stamp" in w for w in r.warnings), "blank lines are no rows"
    path.write_text(path.read_text().replace("2026-11-22T01:00:01.000000", "yesterday"))
    with pytest.raises(DataError, match=r'line 102: "yesterday" in column "t"'):
        read(path, columns=tmp_path / "map.toml")


def test_map_with_a_rate_and_no_header(tmp_path):
    text = """
        header = false
        rate_hz = 100
        [specific_force]
        columns = [2, 3, 4]
        unit = "m/s^2"
        [angular_rate]
        columns = [5, 6, 7]
        unit = "rad/s"
    """
    rows = walk_rows()
    (tmp_path / "map.toml").write_text(text)
    path = tmp_path / "a.csv"
    path.write_text("\n".join(" ".join(f"{v:.9g}" for v in row) for row in rows))
    r = read(path, columns=tmp_path / "map.toml")
    assert len(r) == len(rows)
    np.testing.assert_allclose(r.time, rows[:, 0], atol=1e-9)
    assert any("100 Hz is from map.toml" in n for n in r.notes)


def test_map_with_a_file_and_a_clock_for_each_sensor(tmp_path):
    text = """
        [time]
        column = "t"
        unit = "ms"
        [specific_force]
        columns = ["x", "y", "z"]
        unit = "m/s^2"
        [angular_rate]
        file = "gyro.csv"
        columns = ["x", "y", "z"]
        unit = "rad/s"
        [magnetic_flux_density]
        file = "mag.csv"
        time_column = "micros"
        time_unit = "us"
        columns = ["x", "y", "z"]
        unit = "uT"
    """
    rows = walk_rows()
    (tmp_path / "map.toml").write_text(text)
    t = rows[:, :1]
    path = write(tmp_path / "acc.csv", "t,x,y,z", np.hstack([t * 1e3, rows[:, 1:4]]))
    write(tmp_path / "gyro.csv", "t,x,y,z", np.hstack([t * 1e3 + 5, rows[:, 4:7]]))
    write(tmp_path / "mag.csv", "micros,x,y,z", np.hstack([t * 1e6, rows[:, 7:]])[::10])
    r = read(path, columns=tmp_path / "map.toml")
    np.testing.assert_allclose(r.time, rows[:-1, 0] + 0.005, atol=1e-9, err_msg="the gyroscope's instants, where the accelerometer runs")
    np.testing.assert_allclose(r.specific_force, (rows[:-1, 1:4] + rows[1:, 1:4]) / 2, atol=1e-6)
    np.testing.assert_allclose(r.magnetic_time, rows[::10, 0], atol=1e-9)
    np.testing.assert_allclose(r.angular_rate, rows[:-1, 4:7], rtol=1e-8)


def test_map_with_a_counter(tmp_path):
    rows = walk_rows()
    rng = np.random.default_rng(0)
    keep = rng.random(len(rows)) > 0.05
    table = np.column_stack([rows, np.arange(len(rows))])
    table[:, 0] += rng.uniform(0, 8e-3, len(rows))
    r = mapped(tmp_path, table[keep], 'counter = "n"\n' + MAP.replace('column = "t"', 'column = "t"\nunit = "s"'), NAMES + ",n")
    error = r.time - rows[keep, 0]
    assert np.abs(error - np.median(error)).max() < 1e-3


@pytest.mark.parametrize(
    "change,message",
    [
        (("[time]", "[tyme]"), "tyme"),
        (('column = "t"', 'column = "t"\nunit = "hours"'), "hours"),
        (('"ax", "ay", "az"', '"ax", "ay"'), "three columns"),
        (("[time]", "[time"), "TOML"),
        (("[time]", 'decimal = "x"\n[time]'), "decimal"),
        (('[time]\ncolumn = "t"', ""), "rate_hz"),
    ],
)
def test_bad_maps(tmp_path, change, message):
    with pytest.raises(UsageError, match=message):
        mapped(tmp_path, walk_rows(), MAP.replace(*change))


def test_map_that_names_a_missing_column(tmp_path):
    with pytest.raises(DataError, match='no column "acc"'):
        mapped(tmp_path, walk_rows(), MAP.replace('"ax"', '"acc"'))
    with pytest.raises(UsageError, match="cannot be opened"):
        read(tmp_path / "a.csv", columns=tmp_path / "none.toml")
