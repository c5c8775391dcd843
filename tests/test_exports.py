"""Trajectories on disk and in other programs' formats."""

import json
import sys
import time
import xml.etree.ElementTree as ET
from dataclasses import fields, replace

import numpy as np
import polars as pl
import pytest
from pymap3d import geodetic2enu

from bematist.errors import DataError, UsageError
from bematist.evaluate import align_path
from bematist.frames import matrix_from_quaternion, quaternion_from_euler
from bematist.io import export, read_trajectory, write_trajectory
from bematist.io.trajectory_files import COVARIANCE_COLUMNS, PIECE, write_steps
from bematist.placement import turned
from bematist.trajectory import COLUMNS, PACKED, Steps, Trajectory

ZURICH = (47.3769, 8.5417, 408.0)


def walk(n=2000, seed=0):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, 3, 3, 3))
    P = np.einsum("nkij,nklj->nkil", A, A)
    stance = (np.arange(n) % 100 < 40).astype(np.uint8)
    return Trajectory(
        time=np.arange(n) / 100,
        position=rng.normal(0, 0.1, (n, 3)).cumsum(0),
        velocity=rng.normal(0, 1, (n, 3)),
        attitude=quaternion_from_euler(*rng.uniform(-1.5, 1.5, (3, n))),
        stance=stance,
        packed_covariance=P[:, :, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]].reshape(n, 18),
        method="foot",
    )


def test_parquet_keeps_every_bit(tmp_path):
    t = walk()
    t.packed_covariance[5:9, 7] = np.nan
    write_trajectory(t, tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["trajectory.csv", "trajectory.parquet"]
    back = read_trajectory(tmp_path)
    for name in ("time", "position", "velocity", "attitude", "stance", "packed_covariance"):
        a, b = getattr(t, name), getattr(back, name)
        assert a.dtype == b.dtype
        assert a.shape == b.shape
        assert a.tobytes() == b.tobytes(), name
    assert pl.read_parquet_schema(tmp_path / "trajectory.parquet").names() == [*COLUMNS, *COVARIANCE_COLUMNS]
    assert read_trajectory(tmp_path / "trajectory.parquet").position.tobytes() == t.position.tobytes()


def test_parquet_is_what_the_library_would_write(tmp_path):
    """Types, values and the row groups, which a reader may take one by one."""
    t = walk(2 * PIECE + 5)
    write_trajectory(t, tmp_path)
    path = tmp_path / "trajectory.parquet"
    names = [*COLUMNS, *COVARIANCE_COLUMNS]
    want = pl.DataFrame(dict(zip(names, [*t.columns(), *t.packed_covariance.T], strict=True)))
    assert pl.read_parquet(path).equals(want)
    assert (
        pl.scan_parquet(path).filter(pl.col("time") > t.time[-8]).select("east", "stance").collect().equals(want[["east", "stance"]][-7:])
    )
    write_trajectory(t.rows(0, 0), tmp_path)
    assert pl.read_parquet(path).equals(want[:0])
    damaged = path.with_name("damaged.parquet")
    damaged.write_bytes(path.read_bytes()[:-20] + bytes(12) + path.read_bytes()[-8:])
    with pytest.raises(DataError):
        read_trajectory(damaged)


def test_steps_are_written_as_the_library_would(tmp_path):
    rng = np.random.default_rng(1)
    columns = rng.normal(size=(7, 50)) * 10.0 ** rng.integers(-7, 4, (7, 50))
    words = np.array(["walking", "stairs"])[rng.integers(0, 2, (2, 50))]
    steps = Steps(**dict(zip((f.name for f in fields(Steps)), [*columns, *words], strict=True)))
    write_steps(steps, tmp_path / "steps.csv")
    steps.to_polars().write_csv(tmp_path / "library.csv", float_precision=6)
    assert (tmp_path / "steps.csv").read_bytes() == (tmp_path / "library.csv").read_bytes()


def test_csv_is_the_contract_and_reads_back(tmp_path):
    t = walk()
    write_trajectory(t, tmp_path)
    text = (tmp_path / "trajectory.csv").read_text().splitlines()
    assert text[0] == "time,east,north,up,ve,vn,vu,qw,qx,qy,qz,sd_east,sd_north,sd_up,stance"
    assert len(text) == len(t) + 1
    assert text[1].endswith(",1")
    back = read_trajectory(tmp_path / "trajectory.csv")
    assert np.abs(back.time - t.time).max() < 1e-6
    assert np.abs(back.position - t.position).max() < 1e-6
    assert np.abs(back.velocity - t.velocity).max() < 1e-6
    assert np.abs(back.attitude - t.attitude).max() < 1e-8
    np.testing.assert_array_equal(back.stance, t.stance)
    np.testing.assert_allclose(back.position_sd, t.position_sd, atol=1e-6)
    assert np.isnan(back.packed_covariance[:, [1, 2, 4, *range(6, 18)]]).all()


def test_what_is_unknown_is_an_empty_cell(tmp_path):
    t = replace(walk(), packed_covariance=np.full((2000, 18), np.nan))
    write_trajectory(t, tmp_path)
    assert "NaN" not in (tmp_path / "trajectory.csv").read_text()
    assert np.isnan(read_trajectory(tmp_path / "trajectory.csv").position_sd).all()


def test_a_rest_of_whole_numbers_is_read(tmp_path):
    rows = ["0,0,0,0,0,0,0,1,0,0,0,0,0,0,1"] + [f"{k}.5,0,0,0,0,0,0,1,0,0,0,0,0,0,1" for k in range(300)]
    path = tmp_path / "t.csv"
    path.write_text("\n".join([",".join(COLUMNS), *[r.replace(".5", "") for r in rows[1:200]], *rows[201:]]))
    assert read_trajectory(path).time[-1] == 299.5


def test_the_summary_beside_it_is_read(tmp_path):
    write_trajectory(walk(), tmp_path)
    (tmp_path / "summary.json").write_text(json.dumps({"method": "maginav", "source": "w.csv", "warnings": ["odd"]}))
    back = read_trajectory(tmp_path)
    assert (back.method, back.source, back.warnings) == ("maginav", "w.csv", ("odd",))
    (tmp_path / "summary.json").write_text("{")
    assert read_trajectory(tmp_path).method == ""


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "damaged or of another format"),
        (b"time,east\n0,1\n", "north, up"),
        ((",".join(COLUMNS) + "\n").encode(), "no rows"),
        ((",".join(COLUMNS) + "\n" + ",".join(["x"] * 15) + "\n").encode(), "could not parse"),
        ((",".join(COLUMNS) + "\n" + ",".join(["0"] * 15) + "\n" + "1," * 3 + "," * 11 + "\n").encode(), "row 3"),
        (b"PAR1 and no more", "damaged"),
        (bytes(range(256)) * 4, "."),
    ],
)
def test_what_is_no_trajectory_is_said(tmp_path, content, says):
    path = tmp_path / "trajectory[1].csv"
    path.write_bytes(content)
    with pytest.raises(DataError, match=says) as error:
        read_trajectory(path)
    assert "\n" not in str(error.value)


def test_a_missing_trajectory_is_said(tmp_path):
    with pytest.raises(DataError, match="no trajectory"):
        read_trajectory(tmp_path)
    with pytest.raises(DataError, match="cannot be read"):
        read_trajectory(tmp_path / "nothing.csv")


def test_nothing_half_written(tmp_path, monkeypatch):
    t = walk()
    write_trajectory(t, tmp_path)
    before = (tmp_path / "trajectory.csv").read_bytes()

    def fails(self):
        raise OSError("disk full")

    monkeypatch.setattr(type(t), "columns", fails)
    with pytest.raises(OSError, match="full"):
        write_trajectory(walk(seed=1), tmp_path)
    assert (tmp_path / "trajectory.csv").read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["trajectory.csv", "trajectory.parquet"]


def test_tum_reads_back(tmp_path):
    t = walk()
    export(t, tmp_path / "w.tum", "tum")
    lines = (tmp_path / "w.tum").read_text().splitlines()
    assert lines[0].startswith("#")
    back = np.loadtxt(tmp_path / "w.tum")
    assert back.shape == (len(t), 8)
    np.testing.assert_allclose(back[:, 0], t.time, atol=1e-6)
    np.testing.assert_allclose(back[:, 1:4], t.position, atol=1e-6)
    np.testing.assert_allclose(back[:, 4:], t.attitude[:, [1, 2, 3, 0]], atol=1e-8)


def test_geojson_is_where_it_should_be(tmp_path):
    t = walk()
    export(t, tmp_path / "w.geojson", "geojson", origin=ZURICH)
    found = json.loads((tmp_path / "w.geojson").read_text())
    (feature,) = found["features"]
    assert feature["geometry"]["type"] == "LineString"
    longitude, latitude, height = np.array(feature["geometry"]["coordinates"]).T
    enu = np.column_stack(geodetic2enu(latitude, longitude, height, *ZURICH))
    rows = np.searchsorted(t.time, np.array(feature["properties"]["times"]) - 1e-7)
    np.testing.assert_allclose(enu, t.position[rows], atol=3e-4)
    assert rows[0] == 0
    assert rows[-1] == len(t) - 1
    assert set(t.stance_intervals().sum(1) // 2) <= set(rows)
    assert feature["properties"]["distance_m"] == pytest.approx(t.distance_m, abs=1e-4)


def test_no_height_is_made_up(tmp_path):
    export(walk(), tmp_path / "w.geojson", "geojson", origin=ZURICH[:2])
    found = json.loads((tmp_path / "w.geojson").read_text())
    assert {len(p) for p in found["features"][0]["geometry"]["coordinates"]} == {2}


def test_the_map_line_is_drawn_between_footfalls_too(tmp_path):
    t = replace(walk(), stance=np.zeros(2000, np.uint8))
    export(t, tmp_path / "w.geojson", "geojson", origin=ZURICH)
    times = json.loads((tmp_path / "w.geojson").read_text())["features"][0]["properties"]["times"]
    assert len(times) == 21
    assert max(np.diff(times)) <= 1.0 + 1e-6


def test_heading_turns_the_path_and_all_that_goes_with_it(tmp_path):
    t = walk()
    t.position[:] = [[k / 100, 0, 0] for k in range(len(t))]  # along its own East
    # The path's East axis points South-West (225°): it walks South and West.
    export(t, tmp_path / "w.tum", "tum", heading_deg=225.0)
    back = np.loadtxt(tmp_path / "w.tum")
    end = t.position[-1, 0] / np.sqrt(2)
    np.testing.assert_allclose(back[-1, 1:4], [-end, -end, 0], atol=1e-6)
    made = turned(t, 225.0)
    R = align_path(t.position, made.position, "yaw").rotation
    np.testing.assert_allclose(matrix_from_quaternion(made.attitude), R @ matrix_from_quaternion(t.attitude), atol=1e-9)
    np.testing.assert_allclose(made.velocity, t.velocity @ R.T, atol=1e-9)
    np.testing.assert_allclose(made.velocity_covariance, R @ t.velocity_covariance @ R.T, atol=1e-9)
    np.testing.assert_allclose(made.packed_covariance[:, PACKED], R @ t.covariance @ R.T, atol=1e-9)
    same = turned(t, 90.0)
    np.testing.assert_allclose(same.position, t.position, atol=1e-12)
    # North, by compass: an East axis that points North.
    export(t, tmp_path / "n.geojson", "geojson", origin=ZURICH, heading_deg=0.0)
    points = np.array(json.loads((tmp_path / "n.geojson").read_text())["features"][0]["geometry"]["coordinates"])
    assert points[-1, 1] > points[0, 1]
    assert points[-1, 0] == pytest.approx(points[0, 0], abs=1e-8)


def test_gpx_is_valid_and_in_place(tmp_path):
    pytest.importorskip("gpxpy")
    t = walk()
    export(t, tmp_path / "w.gpx", "gpx", origin=ZURICH)
    root = ET.parse(tmp_path / "w.gpx").getroot()
    assert root.tag == "{http://www.topografix.com/GPX/1/1}gpx"
    points = root.findall(".//{*}trkpt")
    first, last = points[0], points[-1]
    assert float(first.attrib["lat"]) == pytest.approx(ZURICH[0], abs=1e-5)
    ele = float(last.find("{*}ele").text)  # pyright: ignore
    enu = geodetic2enu(float(last.attrib["lat"]), float(last.attrib["lon"]), ele, *ZURICH)
    np.testing.assert_allclose(enu, t.position[-1], atol=1e-3)


def test_gpx_without_its_package_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "gpxpy", None)
    with pytest.raises(UsageError, match=r"pip install bematist\[gpx\]"):
        export(walk(), tmp_path / "w.gpx", "gpx", origin=ZURICH)
    assert not list(tmp_path.iterdir())


def test_exports_of_tables(tmp_path):
    t = walk()
    export(t, tmp_path / "a.csv", "csv")
    export(t, tmp_path / "a.parquet", "parquet")
    assert read_trajectory(tmp_path / "a.parquet").attitude.tobytes() == t.attitude.tobytes()
    np.testing.assert_allclose(read_trajectory(tmp_path / "a.csv").position, t.position, atol=1e-6)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"format": "kml"}, "choose one of tum"),
        ({"format": "geojson"}, "latitude,longitude"),
        ({"format": "gpx"}, "latitude,longitude"),
        ({"format": "geojson", "origin": (95.0, 8.0)}, "−90 to 90"),
        ({"format": "geojson", "origin": (1.0,)}, "−90 to 90"),
        ({"format": "tum", "heading_deg": float("nan")}, "clockwise from North"),
    ],
)
def test_wrong_use_is_said(tmp_path, changes, says):
    with pytest.raises(UsageError, match=says):
        export(walk(), tmp_path / "w", **changes)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written(tmp_path):
    with pytest.raises(DataError, match="cannot be written"):
        write_trajectory(walk(), tmp_path / "missing")


def test_twenty_minutes_are_written_fast(tmp_path):
    n = 285_600
    t = walk(2000)
    big = replace(t, **{
        name: np.resize(getattr(t, name), (n, *getattr(t, name).shape[1:]))
        for name in ("position", "velocity", "attitude", "stance", "packed_covariance")
    }, time=np.arange(n) / 238)  # fmt: skip
    start = time.process_time()
    write_trajectory(big, tmp_path)
    # Half a second of one core when nothing else runs; a second column-by-column loop would take ten times that.
    assert time.process_time() - start < 2.0
    assert (tmp_path / "trajectory.csv").stat().st_size < 45e6
