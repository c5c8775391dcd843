"""The Earth: gravity, magnetic field and rotation against published values, and what the filters make of them."""

import datetime
import json
from importlib.resources import files

import numpy as np
import pytest

import bematist as bm
from bematist.cli import main
from bematist.earth import Earth, Field, as_date, earth_of, normal_gravity, rotation_rate
from bematist.frames import conjugate, heading_deg_from_yaw, multiply, rotate
from bematist.io import write_recording
from bematist.recording import Reference
from bematist.simulate import simulate, simulate_hand, simulate_walk

# NOAA, WMM2015v2testvalues.pdf: year, height km, latitude, longitude, X, Y, Z nT, inclination, declination.
VALUES_2015 = [
    (2015.0, 0, 80, 0, 6636.6, -451.9, 54408.9, 83.03, -3.90),
    (2015.0, 0, 0, 120, 39521.1, 377.7, -11228.8, -15.86, 0.55),
    (2015.0, 0, -80, 240, 5796.3, 15759.1, -52927.1, -72.40, 69.81),
    (2017.5, 100, 80, 0, 6294.3, -331.1, 52337.8, 83.13, -3.01),
    (2017.5, 100, 0, 120, 37584.4, 235.7, -10600.5, -15.75, 0.36),
    (2017.5, 100, -80, 240, 5674.9, 14793.1, -50179.5, -72.48, 69.01),
]


def noaa(year):
    """Rows as above of NOAA's own test values, which come with a peer."""
    text = (files("ahrs") / f"utils/WMM{year}/WMM{year}_TEST_VALUES.txt").read_text()
    rows = [[float(x) for x in line.split()] for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if year == 2020:  # there: D, I, H, X, Y, Z
        return [(*r[:4], *r[7:10], r[5], r[4]) for r in rows]
    return [(*r[:7], r[9], r[10]) for r in rows]


def day(year):
    start = datetime.date(int(year), 1, 1)
    return start + datetime.timedelta(days=round((year - int(year)) * (datetime.date(int(year) + 1, 1, 1) - start).days))


@pytest.mark.parametrize("values", [VALUES_2015, noaa(2020), noaa(2025)], ids=["2015v2", "2020", "2025"])
def test_field_is_that_of_noaa(values):
    for year, height, latitude, longitude, x, y, z, dip, declination in values:
        found = bm.earth_at(latitude, longitude, 1e3 * height, day(year)).field
        # A day of the secular change is 0.3 nT at most, and the values are rounded to 0.1 nT.
        np.testing.assert_allclose(found.vector, np.array([y, x, -z]) / 1e3, atol=4e-4)
        assert found.inclination_deg == pytest.approx(dip, abs=0.006)
        if found.horizontal_ut > 2.0:
            assert found.declination_deg == pytest.approx(declination, abs=0.012)
        assert found.strength_ut == pytest.approx(np.linalg.norm([x, y, z]) / 1e3, abs=4e-4)
    assert len(values) >= 6


@pytest.mark.parametrize(
    ("date", "model"),
    [
        ("2010-01-01", "WMM-2010"),
        ("2019-12-31", "WMM-2015v2"),
        ("2020-01-01", "WMM-2020"),
        ("2024-12-31", "WMM-2020"),
        ("2025-01-01", "WMM-2025"),
        ("2029-12-31", "WMM-2025"),
    ],
)
def test_the_model_of_the_day_is_used(date, model):
    field = bm.earth_at(0.0, 0.0, 0.0, date).field
    assert field.model == model and np.isfinite(field.vector).all()


@pytest.mark.parametrize("date", ["2009-12-31", "2030-01-01", "1970-01-01"])
def test_no_model_is_used_outside_its_years(date):
    with pytest.raises(bm.UsageError, match="no World Magnetic Model for"):
        bm.earth_at(47.0, 8.0, 0.0, date)


@pytest.mark.parametrize("place", [(91.0, 0.0), (0.0, 400.0), (0.0, 0.0, -5e3), (float("nan"), 0.0)])
def test_no_place_on_earth(place):
    with pytest.raises(bm.UsageError, match="no place on Earth"):
        bm.earth_at(*place)


def test_gravity_is_that_of_wgs84():
    # NIMA TR8350.2, Table 3.4: at the equator and at the pole. Moritz, Geodetic Reference System 1980, at 45 degrees, to what the systems
    # differ, and its free-air correction (Li & Götze 2001): (0.3087691 - 0.0004398 sin²φ) mGal/m, and 7.2125e-8 mGal/m².
    assert normal_gravity(0.0) == pytest.approx(9.7803253359, abs=1e-10)
    assert normal_gravity(np.pi / 2) == pytest.approx(9.8321849378, abs=2e-9)
    assert normal_gravity(np.pi / 4) == pytest.approx(9.806199203, abs=2e-6)
    assert normal_gravity(np.pi / 4, 1000.0) - normal_gravity(np.pi / 4) == pytest.approx(-3.08477e-3, abs=2e-7)


def test_rotation_points_to_the_pole():
    east, north, up = rotation_rate(np.radians(30.0))
    assert east == 0 and np.degrees(np.hypot(north, up)) * 3600 == pytest.approx(15.041, abs=1e-3)
    assert np.degrees(np.arctan2(up, north)) == pytest.approx(30.0)


LATITUDE = 38.0
AT = {"latitude_deg": LATITUDE, "disturbed": False}


def at_rest():
    """An hour without a move on the turning Earth, by a sensor without errors; the Earth as the walk has it."""
    r = simulate("still", "ideal", rest_s=3600.0, rate_hz=20.0, magnetometer_rate_hz=5.0, heading_deg=30.0, **AT)
    return r, rotation_rate(np.radians(LATITUDE)), tuple(46.0 * np.array([0, np.cos(np.radians(53)), -np.sin(np.radians(53))]))


def turned(attitude):
    """How far the heading went from start to end, degrees clockwise."""
    yaw = np.unwrap(bm.Attitude(time=np.arange(len(attitude)), attitude=attitude, gyro_bias=np.zeros((len(attitude), 3))).euler[:, 2])
    return -np.degrees(yaw[-1] - yaw[0])


def angle_between(p, q):
    """The angle of the rotation from one attitude to another, rad."""
    return 2 * np.arcsin(min(1.0, float(np.linalg.norm(multiply(conjugate(p), q)[1:]))))


def test_an_hour_at_rest_on_the_turning_earth():
    """A gyroscope without offset turns with the Earth, 15 degrees an hour about its axis: against East-North-Up it does not."""
    r, rate, field = at_rest()
    calibrated = {"gravity": simulate_walk("still", "ideal", rest_s=1.0).scenario.gravity, "states": 9}
    calibrated["initial"] = {"gyro_bias_sd": 0.0, "earth_field": field}
    left = bm.track(r, "zupt", **calibrated)
    taken = bm.track(r, "zupt", earth_rate=rate, **calibrated)
    assert turned(left.attitude) == pytest.approx(-np.degrees(rate[2]) * 3600, rel=0.01)  # 9.3 degrees, counter-clockwise
    assert abs(turned(taken.attitude)) < 0.01
    assert taken.north == "true"
    # The filter with offsets: what it believes of the gyroscope is the truth, and not the Earth.
    free = {"gravity": calibrated["gravity"], "initial": {"earth_field": field}}
    found = bm.track(r, "zupt", **free)
    seen = rotate(conjugate(found.attitude[-1]), np.array(rate))
    np.testing.assert_allclose(found.diagnostics["gyro_bias"][-1], seen, atol=0.05 * np.linalg.norm(rate))
    assert np.abs(bm.track(r, "zupt", earth_rate=rate, **free).diagnostics["gyro_bias"][-1]).max() < 0.02 * np.linalg.norm(rate)


def test_an_hour_at_rest_by_the_hand_filter():
    r, rate, field = at_rest()
    calibrated = {"initial": {"gyro_bias_sd": 0.0, "earth_field": field}, "gravity": 9.8}
    a = bm.attitude(r, "gyint", **calibrated).attitude
    assert np.degrees(angle_between(a[0], a[-1])) == pytest.approx(15.041, rel=0.01)
    a = bm.attitude(r, "gyint", attitude={"earth_rate": rate}, **calibrated).attitude
    assert np.degrees(angle_between(a[0], a[-1])) < 0.01
    # The offset of the rest at the start, where it may be one, is freed of the Earth too.
    found = bm.attitude(r, "gyint", attitude={"earth_rate": rate}, initial={"earth_field": field}, gravity=9.8)
    assert np.abs(found.gyro_bias).max() < 1e-9 and angle_between(*found.attitude[[0, -1]]) < 1e-4


def test_without_north_only_the_upward_part_of_the_rotation_is_known():
    r, rate, _ = at_rest()
    calibrated = {"gravity": 9.8, "states": 9, "initial": {"gyro_bias_sd": 0.0}, "earth_rate": rate}
    found = bm.track(r, "zupt", **calibrated)
    assert found.north == "none" and abs(turned(found.attitude)) < 0.1


@pytest.mark.parametrize("walk", [simulate_walk, simulate_hand])
def test_the_simulated_earth_turns_and_deflects(walk):
    made = walk("short", sensor="ideal", seed=1, sampling="instant")
    still, turning = made.recording, walk("short", sensor="ideal", seed=1, sampling="instant", latitude_deg=LATITUDE).recording
    state = made.motion.at(still.time)
    earth = np.array(rotation_rate(np.radians(LATITUDE)))
    body = conjugate(state.attitude)
    np.testing.assert_allclose(turning.angular_rate - still.angular_rate, rotate(body, np.tile(earth, (len(still), 1))), atol=1e-12)
    np.testing.assert_allclose(turning.specific_force - still.specific_force, rotate(body, 2 * np.cross(earth, state.velocity)), atol=1e-12)


def earth_with(declination, strength=46.0, dip=53.0):
    """A place whose field is the simulated one, but for its declination, degrees."""
    d, i = np.radians([declination, dip])
    vector = tuple(strength * np.array([np.cos(i) * np.sin(d), np.cos(i) * np.cos(d), -np.sin(i)]))
    sd = {"declination_sd_deg": 0.3, "inclination_sd_deg": 0.2, "strength_sd_ut": 0.1}
    field = Field(vector=vector, declination_deg=declination, inclination_deg=dip, model="", date=as_date("2025-01-01"), **sd)
    at = {"latitude_deg": 0.0, "longitude_deg": 0.0, "height_m": 0.0}
    return Earth(**at, gravity=normal_gravity(0.66, 150.0), rotation=(0.0, 0.0, 0.0), field=field)


@pytest.mark.parametrize("method", ["foot", "maginav"])
def test_headings_are_true(method):
    """The way of a walk towards simulated magnetic North + 40 degrees has the true heading 40 + declination."""
    r = simulate("straight", "lsm9ds1", seed=2, length_m=60.0, heading_deg=40.0, disturbed=False)
    found = bm.track(r, method, earth=earth_with(12.0))
    e, n = found.position[-1, :2]
    assert float(heading_deg_from_yaw(np.arctan2(n, e))) == pytest.approx(52.0, abs=1.0)
    assert found.north == "true" and found.summary()["north"] == "true"
    assert found.parameters["gravity"] == earth_with(12.0).gravity
    plain = bm.track(r, method, gravity=earth_with(12.0).gravity)
    assert plain.north == "none"
    assert np.linalg.norm(plain.position[-1]) == pytest.approx(np.linalg.norm(found.position[-1]), rel=2e-3)
    a = bm.attitude(r, "hand", earth=earth_with(12.0))
    assert a.north == "true"
    b = bm.attitude(r, "hand")
    assert b.north == "magnetic"
    assert float((a.heading_deg - b.heading_deg)[0]) % 360 == pytest.approx(12.0, abs=0.2)


def test_gates_compare_with_the_earth_and_say_so():
    r = simulate("straight", "lsm9ds1", seed=2, length_m=30.0, disturbed=False)
    weak = earth_with(0.0, strength=60.0)
    found = bm.track(r, "foot", earth=weak)
    np.testing.assert_allclose(found.diagnostics["magnetic_reference"], [60.0, np.radians(53.0)], rtol=1e-6)
    assert any("the Earth's is 60.0 µT" in w for w in found.warnings)
    found = bm.track(r, "foot", earth=weak, magnetic={"reference": "start"})
    assert found.diagnostics["magnetic_reference"][0] == pytest.approx(46.0, abs=0.5)
    assert not any("Earth's is" in w for w in found.warnings)
    assert not bm.track(r, "foot", earth=earth_with(0.0)).warnings


def test_a_given_heading_keeps_the_direction_of_the_field():
    r = simulate("straight", "lsm9ds1", seed=2, length_m=60.0, heading_deg=40.0, disturbed=False)
    found = bm.track(r, "foot", earth=earth_with(12.0), initial={"heading_deg": 70.0})
    e, n = found.position[-1, :2]
    assert float(heading_deg_from_yaw(np.arctan2(n, e))) == pytest.approx(70.0, abs=1.0)
    assert found.north == "given"


def recorded(**changes):
    """A short walk that a phone recorded near Zurich, with a satellite fix."""
    r = simulate("short", "lsm9ds1", seed=3, disturbed=False)
    fix = Reference(time=np.zeros(1), position=np.zeros((1, 3)), origin=(47.4, 8.5, np.nan))
    return r.replace(**{"reference": fix, "start_ns": 1_750_000_000_000_000_000, **changes})


def test_the_recording_tells_where_it_was_made():
    r = recorded()
    earth = earth_of(r)
    assert earth.field.date == datetime.date(2025, 6, 15) and earth.field.model == "WMM-2025"
    found = bm.track(r, "zupt")
    assert found.parameters["gravity"] == earth.gravity and found.parameters["initial"]["earth_field"] == earth.field.vector
    assert found.parameters["earth_rate"] == earth.rotation
    assert bm.track(r, "zupt", gravity=9.8).parameters["gravity"] == 9.8
    assert bm.track(r, "zupt", earth=None).parameters["initial"]["earth_field"] is None
    assert bm.attitude(r, "hand").parameters["attitude"]["earth_rate"] == earth.rotation
    # A clock that was never set knows no day: gravity is known, the field is not.
    assert earth_of(recorded(start_ns=0)).field is None and earth_of(recorded(start_ns=None)).field is None
    assert earth_of(recorded(reference=None)) is None


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    path = tmp_path_factory.mktemp("earth") / "walk.csv"
    write_recording(simulate("short", "lsm9ds1", seed=3, disturbed=False), path)
    return path


def test_origin_on_the_command_line(walk, tmp_path, capsys):
    out, again = tmp_path / "out", tmp_path / "again"
    options = ["track", str(walk), "--no-report", "-o", str(out), "--origin", "-33.9,18.4,20", "--date", "2021-05-01"]
    assert main([*options, "--set", "gravity=9.8"]) == 0
    assert "true, by the magnetic field" in capsys.readouterr().out
    text = (out / "config.toml").read_text()
    assert "gravity = 9.8\n" in text and "earth_rate = [" in text
    assert json.loads((out / "summary.json").read_text())["north"] == "true"
    assert main(["track", str(walk), "--no-report", "-q", "-o", str(again), "--config", str(out / "config.toml")]) == 0
    assert (again / "trajectory.csv").read_bytes() == (out / "trajectory.csv").read_bytes()
    # Given again, the place wins over the file.
    assert main(["track", str(walk), "--no-report", "-q", "-o", str(again), "--config", str(out / "config.toml"), *options[5:]]) == 0
    assert f"gravity = {normal_gravity(np.radians(-33.9), 20.0)}" in (again / "config.toml").read_text()
    assert main(["attitude", str(walk), "--no-report", "-q", "-o", str(tmp_path / "a"), *options[5:]]) == 0
    assert json.loads((tmp_path / "a" / "summary.json").read_text())["north"] == "true"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--origin", "47,8"], "Give the day with --date"),
        (["--origin", "47,8", "--date", "2031-01-01"], "no World Magnetic Model"),
        (["--origin", "47,8", "--date", "tomorrow"], "YYYY-MM-DD"),
        (["--origin", "47"], "--origin 47"),
        (["--date", "2025-01-01"], "--origin LAT,LON"),
    ],
)
def test_wrong_places_are_told_in_one_paragraph(walk, tmp_path, capsys, options, said):
    assert main(["track", str(walk), "-o", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


def test_earth_command(capsys):
    assert main(["earth", "-33.9,18.4", "--date", "2021-05-01"]) == 0
    assert "-25.48°" in capsys.readouterr().out
    assert main(["earth", "47.3769,8.5417,408", "--date", "2026-01-01", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["model"] == "WMM-2025" and told["gravity_m_s2"] == normal_gravity(np.radians(47.3769), 408.0)
