"""Each reader against the raw file, on real recordings and on files written from the documented headers."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from bematist.earth import STANDARD_GRAVITY as G
from bematist.errors import DataError, UsageError
from bematist.io import FORMATS, read, read_reference, sniff


def rest_norm(r) -> float:
    return float(np.linalg.norm(r.specific_force[:60], axis=1).mean())


def walk_rows(n: int = 600, rate: float = 100.0) -> np.ndarray:
    """Rows (N,10) time, SI, µT of a sensor that rests, rocks about x, and rests."""
    t = np.arange(n) / rate
    tilt = np.where((t > 1) & (t < t[-1] - 1), 0.6 * np.sin(2 * np.pi * 0.5 * (t - 1)), 0.0)
    rate_x = np.gradient(tilt, t)
    f = G * np.stack([0 * t, np.sin(tilt), np.cos(tilt)], 1)
    w = np.stack([rate_x, 0 * t, 0 * t], 1)
    m = np.stack([0 * t + 1, 20 * np.cos(tilt) - 40 * np.sin(tilt), -20 * np.sin(tilt) - 40 * np.cos(tilt)], 1)
    rng = np.random.default_rng(0)
    values = np.concatenate([f, w, m], 1) + rng.normal(size=(n, 9)) * np.repeat([0.02, 0.002, 0.1], 3)
    return np.column_stack([t, values])


def write(path, header, rows, fmt="%.9g", sep=","):
    lines = [sep.join("" if not np.isfinite(v) else fmt % v for v in row) for row in rows]
    path.write_text(header + "\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return path


# Real recordings ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number,footfalls", [(32, 62), (35, 29)])
def test_microstrain(shared_data, number, footfalls):
    path = shared_data / f"foot/gsu_gx5/SensorConnectData_{number}.csv"
    raw = np.loadtxt(path, delimiter=",", skiprows=1)
    r = read(path)
    assert sniff(path).name == "microstrain"
    np.testing.assert_array_equal(r.time, raw[:, 0])
    np.testing.assert_allclose(r.specific_force, raw[:, 1:4] * G)
    np.testing.assert_allclose(r.angular_rate, raw[:, 4:7])
    np.testing.assert_allclose(r.magnetic_flux_density, raw[:, 7:10] * 100)
    assert rest_norm(r) == pytest.approx(9.81, abs=0.03)
    assert r.reference is not None and r.reference.position.shape == (footfalls, 3)
    assert r.reference.mirrored and np.isnan(r.reference.time).all() and np.isnan(r.reference.position[:, 2]).all()
    assert r.reference.footfall is not None and r.reference.footfall[0] == 0
    assert not r.warnings


def test_ngimu(shared_data):
    path = shared_data / "foot/ngimu/short_walk.csv"
    raw = np.loadtxt(path, delimiter=",", skiprows=1)
    r = read(path)
    once = np.concatenate([[True], np.diff(raw[:, 0]) > 0])
    assert (~once).sum() == 205
    np.testing.assert_array_equal(r.time, raw[once, 0])
    np.testing.assert_allclose(r.angular_rate, np.radians(raw[once, 1:4]))
    np.testing.assert_allclose(r.specific_force, raw[once, 4:7] * G)
    assert not r.has_magnetometer
    assert rest_norm(r) == pytest.approx(9.8, abs=0.03)
    assert any("205 rows that repeat" in w for w in r.warnings)
    # Steps are 1 to 5 periods of 2.51 ms: true stamps, samples lost.
    assert np.abs(np.diff(r.time) / 0.0025105 - np.round(np.diff(r.time) / 0.0025105)).max() < 0.01
    assert any("244 samples missing" in w for w in r.warnings)


def test_openshoe(shared_data):
    path = next((shared_data / "foot/openshoe").glob("*inert.txt"))
    tokens = [line.split() for line in path.read_text().splitlines() if line.strip().startswith("0x")]
    r = read(path)
    assert len(r) == len(tokens) == 12239
    first = np.array([float(v) for v in tokens[0][1:7]])
    np.testing.assert_allclose(r.specific_force[0], first[:3] * G)
    np.testing.assert_allclose(r.angular_rate[0], first[3:])
    np.testing.assert_allclose(r.magnetic_flux_density[0], [-12.193213, -1.433237, -46.171623])
    missing = sum("nan" in row[-1].lower() for row in tokens)
    assert len(r.magnetic_time) == len(r) - missing
    assert rest_norm(r) == pytest.approx(9.8, abs=0.05)
    assert r.start_ns == pytest.approx(1274439406.246974e9, abs=5e6)
    # The sensor's counter says 78,720 ticks of 19.6608 MHz each: an even clock, no sample lost.
    np.testing.assert_allclose(np.diff(r.time), 78720 / 19660800, rtol=2e-4)


@pytest.mark.parametrize("name", ["2017-11-22-11-22-03", "2017-12-15-18-01-18", "2018-02-09-11-18-04"])
def test_pyshoe(shared_data, name):
    path = shared_data / f"foot/pyshoe_vicon/{name}.mat"
    mat = loadmat(path)
    r = read(path)
    np.testing.assert_array_equal(r.specific_force, mat["imu"][:, :3])
    np.testing.assert_array_equal(r.angular_rate, mat["imu"][:, 3:])
    assert np.abs(r.time - mat["ts"].ravel()).max() < 2e-3
    assert np.diff(r.time).std() < 2e-6, "200 Hz behind stamps with 0.1 ms of jitter"
    assert r.reference is not None and r.reference.mirrored
    kept = np.isfinite(r.reference.position).all(1)
    np.testing.assert_array_equal(r.reference.position[kept], mat["gt"][kept])
    assert (~kept).sum() == (77 if name == "2017-11-22-11-22-03" else 0)
    np.testing.assert_array_equal(r.reference.time, mat["ts"].ravel())


def test_a_map_reads_ngimu_as_the_reader_does(shared_data, tmp_path):
    path = shared_data / "foot/ngimu/short_walk.csv"
    (tmp_path / "map.toml").write_text(
        """
        [time]
        column = "Time (s)"
        [specific_force]
        columns = ["Accelerometer X (g)", "Accelerometer Y (g)", "Accelerometer Z (g)"]
        [angular_rate]
        columns = ["Gyroscope X (deg/s)", "Gyroscope Y (deg/s)", "Gyroscope Z (deg/s)"]
        """
    )
    a, b = read(path), read(path, columns=tmp_path / "map.toml")
    np.testing.assert_array_equal(a.specific_force, b.specific_force)  # units guessed: g, deg/s
    np.testing.assert_array_equal(a.angular_rate, b.angular_rate)
    np.testing.assert_array_equal(a.time, b.time)
    assert sum("not stated" in w for w in b.warnings) == 3


# Canonical ------------------------------------------------------------------------------------------------------------

HEADER = "time,fx,fy,fz,wx,wy,wz,mx,my,mz"


def test_canonical_csv_values_and_empty_cells(tmp_path):
    rows = walk_rows()
    rows[np.arange(600) % 3 > 0, 7:] = np.nan
    r = read(write(tmp_path / "a.csv", "# a walk\n\n# second comment\n" + HEADER, rows))
    np.testing.assert_allclose(r.time, rows[:, 0], atol=1e-9)
    np.testing.assert_allclose(r.specific_force, rows[:, 1:4], rtol=1e-8)
    np.testing.assert_allclose(r.angular_rate, rows[:, 4:7], rtol=1e-8)
    np.testing.assert_allclose(r.magnetic_flux_density, rows[::3, 7:], rtol=1e-8)
    np.testing.assert_allclose(r.magnetic_time, rows[::3, 0], atol=1e-9)
    assert not r.warnings


def test_canonical_columns_go_by_name(tmp_path):
    rows = walk_rows()
    order = [9, 3, 2, 1, 0, 6, 5, 4, 8, 7]
    names = np.array(HEADER.split(","))
    path = write(tmp_path / "a.csv", ",".join([*names[order], "temperature"]), np.column_stack([rows[:, order], rows[:, 0]]))
    r = read(path)
    np.testing.assert_allclose(r.specific_force, rows[:, 1:4], rtol=1e-8)
    np.testing.assert_allclose(r.magnetic_flux_density, rows[:, 7:], rtol=1e-8)


def test_magnetometer_on_its_own_rows(tmp_path):
    """238 Hz and 80 Hz, as in MAGINAV: rows of one sensor leave the cells of the other empty."""
    a = walk_rows(1000, 238.0)
    m = walk_rows(330, 80.0)
    m[:, 0] += 0.0013
    a[:, 7:] = np.nan
    m[:, 1:7] = np.nan
    rows = np.concatenate([a, m])
    rows = rows[np.argsort(rows[:, 0])]
    r = read(write(tmp_path / "a.csv", HEADER, rows))
    np.testing.assert_allclose(r.time, a[:, 0], atol=1e-9)
    np.testing.assert_allclose(r.magnetic_time, m[:, 0], atol=1e-9)
    np.testing.assert_allclose(r.magnetic_flux_density, m[:, 7:], rtol=1e-8)


def test_gyroscope_at_half_the_rate(tmp_path):
    rows = walk_rows()
    rows[1::2, 4:7] = np.nan
    r = read(write(tmp_path / "a.csv", HEADER, rows))
    assert len(r) == 600 and np.isfinite(r.specific_force).all()
    np.testing.assert_array_equal(np.isnan(r.angular_rate[:, 0]), np.arange(600) % 2 == 1)


def test_accelerometer_and_gyroscope_on_separate_rows(tmp_path):
    a, g = walk_rows(), walk_rows()
    g[:, 0] += 0.004
    a[:, 4:], g[:, 1:4], g[:, 7:] = np.nan, np.nan, np.nan
    rows = np.concatenate([a, g])
    r = read(write(tmp_path / "a.csv", HEADER, rows[np.argsort(rows[:, 0], kind="stable")]))
    assert len(r) == 1200
    np.testing.assert_allclose(r.time[np.isfinite(r.angular_rate[:, 0])], g[:, 0], atol=1e-9)
    np.testing.assert_allclose(r.specific_force[np.isfinite(r.specific_force[:, 0])], a[:, 1:4], rtol=1e-8)


def test_nan_runs_keep_the_other_sensor(tmp_path):
    rows = walk_rows()
    rows[100:130, 1:4] = np.nan
    rows[300:302, 1:7] = np.nan
    rows[400, 2] = np.nan
    r = read(write(tmp_path / "a.csv", HEADER, rows))
    assert len(r) == 598, "rows without any inertial sample are a gap"
    assert np.isfinite(r.angular_rate[100:130]).all() and np.isnan(r.specific_force[100:130]).all()
    assert any("1 accelerometer samples with a part missing" in w for w in r.warnings)
    assert any("1 gaps" in w for w in r.warnings)


@pytest.mark.parametrize(
    "encoding,eol,sep", [("utf-8-sig", "\r\n", ","), ("utf-16", "\n", ","), ("utf-8", "\n", ";"), ("utf-8", "\r\n", "\t")]
)
def test_canonical_encodings_and_separators(tmp_path, encoding, eol, sep):
    rows = walk_rows()
    path = write(tmp_path / "a.csv", HEADER.replace(",", sep), rows, sep=sep)
    path.write_bytes(path.read_text().replace("\n", eol).encode(encoding))
    np.testing.assert_allclose(read(path).specific_force, rows[:, 1:4], rtol=1e-8)


def test_decimal_commas(tmp_path):
    rows = walk_rows()
    path = write(tmp_path / "a.csv", HEADER.replace(",", ";"), rows, sep=";")
    path.write_text(path.read_text().replace(".", ","))
    np.testing.assert_allclose(read(path).angular_rate, rows[:, 4:7], rtol=1e-8)


def test_parquet_whatever_its_name(tmp_path):
    import polars as pl

    rows = walk_rows()
    rows[1::2, 7:] = np.nan
    frame = pl.DataFrame(rows, schema=HEADER.split(",")).fill_nan(None).with_columns(pressure=pl.lit(100000))
    for name in ("a.parquet", "a.csv"):
        frame.write_parquet(tmp_path / name)
        r = read(tmp_path / name)
        np.testing.assert_array_equal(r.specific_force, rows[:, 1:4])
        np.testing.assert_array_equal(r.magnetic_flux_density, rows[::2, 7:])
        assert (r.pressure == 100000).all()
    (tmp_path / "text.parquet").write_text("time,fx,fy,fz,wx,wy,wz\n0,0,0,9.8,0,0,0\n0.01,0,0,9.8,0,0,0.1\n")
    assert len(read(tmp_path / "text.parquet")) == 2


def test_unix_times_become_relative(tmp_path):
    rows = walk_rows()
    rows[:, 0] += 1_700_000_000
    r = read(write(tmp_path / "a.csv", HEADER, rows, fmt="%.12f"))
    assert r.time[0] == 0 and r.start_ns == 1_700_000_000 * 10**9
    np.testing.assert_allclose(r.time, walk_rows()[:, 0], atol=1e-6)


# x-io -----------------------------------------------------------------------------------------------------------------

INERTIAL = (
    "Timestamp (us),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)"
)


def x_imu3_rows(n=800, rate=100.0):
    rows = walk_rows(n, rate)
    return rows, np.column_stack([rows[:, 0] * 1e6 + 5e6, np.degrees(rows[:, 4:7]), rows[:, 1:4] / G])


@pytest.mark.parametrize("axes", ["X (a.u.),Y (a.u.),Z (a.u.)", "X Axis (a.u.),Y Axis (a.u.),Z Axis (a.u.)"])
def test_x_imu3_folder(tmp_path, axes):
    rows, table = x_imu3_rows()
    write(tmp_path / "Inertial.csv", INERTIAL, table)
    field = rows[::5, 7:] / np.linalg.norm(rows[0, 7:])
    write(tmp_path / "Magnetometer.csv", f"Timestamp (us),{axes}", np.column_stack([table[::5, 0] + 700, field]))
    r = read(tmp_path)
    np.testing.assert_allclose(r.specific_force, rows[:, 1:4], rtol=1e-7)
    np.testing.assert_allclose(r.angular_rate, rows[:, 4:7], rtol=1e-7)
    np.testing.assert_allclose(r.time, rows[:, 0] + 5, atol=1e-6)
    np.testing.assert_allclose(r.magnetic_time, rows[::5, 0] + 5.0007, atol=1e-6)
    np.testing.assert_allclose(r.magnetic_flux_density, field * 50, rtol=1e-7)
    assert any("no absolute scale" in w for w in r.warnings)


def test_x_imu3_single_csv_and_ngimu_folder(tmp_path):
    rows, table = x_imu3_rows()
    r = read(write(tmp_path / "Inertial.csv", INERTIAL, table))
    np.testing.assert_allclose(r.angular_rate, rows[:, 4:7], rtol=1e-7)
    folder = tmp_path / "ngimu"
    folder.mkdir()
    header = INERTIAL.replace("Timestamp (us)", "Time (s)") + (
        ",Magnetometer X (uT),Magnetometer Y (uT),Magnetometer Z (uT),Barometer (hPa)"
    )
    more = np.column_stack([rows[:, 0], table[:, 1:], rows[:, 7:], np.full(len(rows), 1000.0)])
    write(folder / "sensors.csv", header, more)
    n = read(folder)
    np.testing.assert_allclose(n.magnetic_flux_density, rows[:, 7:], rtol=1e-7)
    assert (n.pressure == 1e5).all() and n.source == str(folder)


def test_x_imu3_counter_wrap(tmp_path):
    rows, table = x_imu3_rows()
    table[:, 0] = np.mod(table[:, 0] - 5e6 + 2**32 - 3e6, 2**32)
    r = read(write(tmp_path / "Inertial.csv", INERTIAL, table, fmt="%.12g"))
    np.testing.assert_allclose(r.time - r.time[0], rows[:, 0], atol=1e-5)


def test_sensorconnect_with_preamble_and_dates(tmp_path):
    rows = walk_rows()
    names = [f"inertial-1:scaled{s}{a}" for s in ("Accel", "Gyro") for a in "XYZ"]
    head = "FILE_INFO\n;File Format Version\n1.0\n\nDATA_START\nTime," + ",".join(names)
    stamps = [f"11/22/2017 11:{int(t // 60):02d}:{t % 60:012.9f}" for t in rows[:, 0]]
    body = [s + "," + ",".join(f"{v:.9g}" for v in [*row[1:4] / G, *row[4:7]]) for s, row in zip(stamps, rows, strict=True)]
    path = tmp_path / "a.csv"
    path.write_text(head + "\n" + "\n".join(body) + "\n")
    r = read(path)
    np.testing.assert_allclose(r.specific_force, rows[:, 1:4], rtol=1e-7)
    np.testing.assert_allclose(r.time, rows[:, 0], atol=1e-6)
    assert r.start_ns == 1511348400 * 10**9


# References -----------------------------------------------------------------------------------------------------------


def test_references(tmp_path, shared_data):
    gsu = read_reference(shared_data / "foot/gsu_gx5/SensorConnectData_32.mat")
    assert gsu.footfall is not None and gsu.footfall.tolist() == list(range(62))
    plan = gsu.position[:, :2]
    assert np.linalg.norm(np.diff(plan, axis=0), axis=1).sum() == pytest.approx(79.6, abs=0.3)
    vicon = read_reference(shared_data / "foot/pyshoe_vicon/2017-11-22-11-22-03.mat")
    assert vicon.mirrored and vicon.position.shape == (6490, 3)


def test_reference_csv(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text("time,east,north,up,qw,qx,qy,qz\n1,2,3,,2,0,0,0\n0,0,0,1,,,,\n2,,,,1,0,0,0\n3,,,,,,,\n")
    r = read_reference(path)
    assert r.time.tolist() == [0, 1, 2]
    np.testing.assert_array_equal(r.position[1], [2, 3, np.nan])
    assert r.attitude is not None and r.attitude[1].tolist() == [1, 0, 0, 0] and np.isnan(r.attitude[0]).all()
    path.write_text("time,east,north\n1,2,3\n2,3,4\n")
    assert np.isnan(read_reference(path).position[:, 2]).all()
    path.write_text("time,x,y\n1,2,3\n")
    with pytest.raises(DataError, match="east, north"):
        read_reference(path)
    savemat(tmp_path / "no.mat", {"a": 1})
    with pytest.raises(DataError, match="GCP_meters"):
        read_reference(tmp_path / "no.mat")
    with pytest.raises(DataError, match="trajectory"):
        read_reference(tmp_path)


# The table ------------------------------------------------------------------------------------------------------------


def test_every_format_of_the_table_is_a_module_with_sniff_and_read():
    for name, form in FORMATS.items():
        assert form.name == name and form.summary
        assert callable(form.load().sniff) and callable(form.load().read)


def test_unknown_file_names_what_is_known(tmp_path):
    (tmp_path / "a.csv").write_text("a,b,c\n1,2,3\n")
    with pytest.raises(DataError) as error:
        read(tmp_path / "a.csv")
    assert all(name in str(error.value) for name in FORMATS) and "--columns" in str(error.value)
    with pytest.raises(UsageError, match="canonical"):
        read(tmp_path / "a.csv", format="nothing")
    with pytest.raises(DataError, match="does not look like"):
        read(tmp_path / "a.csv", format="pyshoe")


def test_axes(tmp_path):
    rows = walk_rows()
    path = write(tmp_path / "a.csv", HEADER, rows)
    r = read(path, axes="x,-z,y")
    expected = rows[:, [1, 3, 2]] * [1, -1, 1]
    np.testing.assert_allclose(r.specific_force, expected, rtol=1e-8)
    np.testing.assert_allclose(r.magnetic_flux_density, rows[:, [7, 9, 8]] * [1, -1, 1], rtol=1e-8)
    with pytest.raises(UsageError, match="mirror"):
        read(path, axes="x,z,y")
