"""Plans of buildings: pictures and GeoJSON come to lie where they belong, and what cannot be is told in a paragraph."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pymap3d import enu2geodetic

from bematist.errors import BematistError, DataError, UsageError
from bematist.io import plan_image, read_floor_plan
from bematist.report import still_path, write_report
from report_cases import reference, walk

SPOT = (30, 70)
"""The red pixel of the picture, column and row."""


def picture(path: Path, size: tuple[int, int] = (200, 100)) -> Path:
    image = Image.new("RGB", size, "white")
    image.paste((255, 0, 0), (SPOT[0] - 1, SPOT[1] - 1, SPOT[0] + 2, SPOT[1] + 2))
    image.save(path, **({"quality": 100, "subsampling": 0} if path.suffix == ".jpg" else {}))
    return path


def red_place(plan) -> np.ndarray:
    """East and north of the middle of what is red in the plan's picture."""
    shown = np.asarray(Image.open(io.BytesIO(plan.image)).convert("RGBA")).astype(float)
    red = (shown[:, :, 0] > 200) & (shown[:, :, 1] < 90) & (shown[:, :, 3] > 200)
    row, column = (float(v.mean()) + 0.5 for v in np.nonzero(red))
    west, south, east, north = plan.bounds
    return np.array([west + column / shown.shape[1] * (east - west), north - row / shown.shape[0] * (north - south)])


def expected(scale: float, origin: tuple[float, float], rotation_deg: float) -> np.ndarray:
    right, up = SPOT[0] + 0.5 - origin[0], origin[1] - SPOT[1] - 0.5
    heading = np.radians(rotation_deg)
    return scale * (right * np.array([np.cos(heading), -np.sin(heading)]) + up * np.array([np.sin(heading), np.cos(heading)]))


@pytest.mark.parametrize("suffix", ["png", "jpg", "bmp"])
@pytest.mark.parametrize("rotation_deg", [0.0, 30.0, -90.0, 180.0, 271.5])
def test_a_pixel_comes_to_lie_where_it_belongs(tmp_path: Path, suffix: str, rotation_deg: float) -> None:
    plan = read_floor_plan(picture(tmp_path / f"p.{suffix}"), scale=0.1, origin=(20, 90), rotation_deg=rotation_deg)
    assert red_place(plan) == pytest.approx(expected(0.1, (20, 90), rotation_deg), abs=0.06)


def test_a_straight_picture_is_kept_as_it_is(tmp_path: Path) -> None:
    file = picture(tmp_path / "p.png")
    assert read_floor_plan(file, scale=1, origin=(0, 100)).image == file.read_bytes()


def test_a_large_picture_is_drawn_smaller(tmp_path: Path) -> None:
    file = picture(tmp_path / "p.png", (7000, 200))
    plan = read_floor_plan(file, scale=0.01, origin=(0, 200))
    assert plan.image is not None
    assert Image.open(io.BytesIO(plan.image)).width == plan_image.LARGEST_SIDE
    assert plan.bounds == pytest.approx((0, 0, 70, 2))


def test_a_photograph_that_lies_on_its_side(tmp_path: Path) -> None:
    image = Image.open(picture(tmp_path / "p.png"))
    exif = Image.Exif()
    exif[0x0112] = 6  # shown turned by 90° clockwise
    image.save(tmp_path / "side.jpg", exif=exif, quality=100, subsampling=0)
    plan = read_floor_plan(tmp_path / "side.jpg", scale=1, origin=(0, 200))
    # Row 70 of 100 from above comes to column 29 from the left, column 30 to row 30.
    assert plan.bounds == (0, 0, 100, 200) and red_place(plan) == pytest.approx([29.5, 200 - 30.5], abs=0.6)


@pytest.mark.parametrize("name", ["p.pgw", "p.pngw", "p.wld"])
def test_a_world_file_tells_scale_and_place(tmp_path: Path, name: str) -> None:
    file = picture(tmp_path / "p.png")
    (tmp_path / name).write_text("0.5\n0\n0\n-0.5\n1000.25\n2049.75\n")
    plan = read_floor_plan(file, origin=(1000, 2000))
    assert plan.bounds == pytest.approx((0, 0, 100, 50))
    assert red_place(plan) == pytest.approx([0.5 * 30.5, 50 - 0.5 * 70.5], abs=0.3)
    askew = 0.5 * np.array([[np.cos(0.3), np.sin(0.3)], [np.sin(0.3), -np.cos(0.3)]])
    (tmp_path / name).write_text("\n".join(str(v) for v in (*askew.T.ravel(), 7.0, 8.0)))
    plan = read_floor_plan(file)
    assert red_place(plan) == pytest.approx(askew @ SPOT + [7.0, 8.0], abs=0.3)
    assert read_floor_plan(file, scale=2, origin=(0, 100)).bounds == pytest.approx((0, 0, 400, 200))


def geojson(path: Path, *geometries: dict) -> Path:
    features = [{"type": "Feature", "properties": {"name": f"n{k}"}, "geometry": g} for k, g in enumerate(geometries)]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def test_geojson_in_metres(tmp_path: Path) -> None:
    file = geojson(
        tmp_path / "f.geojson",
        {"type": "Polygon", "coordinates": [[[0, 0], [40, 0], [40, 30], [0, 0]], [[1, 1], [2, 1], [1, 1]]]},
        {"type": "GeometryCollection", "geometries": [{"type": "LineString", "coordinates": [[5, 5, 9], [6, 6, 9]]}]},
        {"type": "MultiPoint", "coordinates": [[10, 20], [30, 20]]},
    )
    plan = read_floor_plan(file, scale=2, origin=(10, 0), rotation_deg=90)
    # Up of the plan is East, its right is South.
    assert plan.bounds == pytest.approx((0, -60, 60, 20))
    assert np.isnan(plan.lines[:, 0]).sum() == 3 and len(plan.lines) == 4 + 3 + 2 + 3
    assert plan.places == pytest.approx(np.array([[40, 0], [40, -40]]), abs=1e-9)
    assert plan.names == ("n2", "n2")


def test_geojson_in_degrees(tmp_path: Path) -> None:
    east, north = np.array([0.0, 55.0, 55.0]), np.array([0.0, 0.0, -31.0])
    latitude, longitude, _ = enu2geodetic(east, north, np.zeros(3), 30.27, 120.15, 0)
    line = [[float(x), float(y)] for x, y in zip(longitude, latitude, strict=True)]
    plan = read_floor_plan(geojson(tmp_path / "f.geojson", {"type": "LineString", "coordinates": line}), origin=(30.27, 120.15))
    assert plan.lines[:3] == pytest.approx(np.column_stack([east, north]), abs=1e-3)


def test_coordinates_that_can_be_no_degrees_are_metres(tmp_path: Path) -> None:
    file = geojson(tmp_path / "f.geojson", {"type": "LineString", "coordinates": [[200, 300], [260, 310]]})
    assert read_floor_plan(file, origin=(200, 300)).bounds == pytest.approx((0, 0, 60, 10))


LINE = {"type": "LineString", "coordinates": [[8.5, 47.3], [8.6, 47.4]]}


@pytest.mark.parametrize(
    ("content", "options", "kind", "says"),
    [
        (None, {}, DataError, "cannot be opened"),
        (b"hello", {"scale": 1, "origin": (0, 0)}, DataError, "neither a picture"),
        (b"<svg xmlns='http://www.w3.org/2000/svg'/>", {}, DataError, "Save this drawing as PNG"),
        (b"%PDF-1.7", {}, DataError, "Save this drawing as PNG"),
        ("cut", {"scale": 1, "origin": (0, 0)}, DataError, "damaged"),
        ("picture", {"origin": (0, 0)}, UsageError, "Give --map-scale"),
        ("picture", {"scale": 0.1}, UsageError, "lower left corner is 0,100"),
        ("picture", {"scale": 0.0, "origin": (0, 0)}, UsageError, "scale"),
        ("picture", {"scale": float("nan"), "origin": (0, 0)}, UsageError, "scale"),
        ("picture", {"scale": float("inf"), "origin": (0, 0)}, UsageError, "scale"),
        ("picture", {"scale": 1000.0, "origin": (0, 0)}, UsageError, "200 km wide"),
        ("picture", {"scale": 1.0, "origin": (1e6, 0)}, UsageError, "km from where the path has its 0, 0"),
        (b"{", {}, DataError, "no readable GeoJSON"),
        (b'{"type": "Feature"}', {}, DataError, "no geometry"),
        (b'{"type": "FeatureCollection", "features": []}', {}, DataError, "no geometry"),
        (b'{"type": "FeatureCollection", "features": 3}', {}, DataError, "no readable GeoJSON"),
        (b'{"type": "Circle"}', {}, DataError, "no type of GeoJSON"),
        (b'{"type": "Point", "coordinates": ["a", 1]}', {}, DataError, "no readable GeoJSON"),
        (b'{"type": "Point", "coordinates": [NaN, 1]}', {}, DataError, "no number"),
        (b"[1, 2]", {}, DataError, "no readable GeoJSON"),
        (LINE, {}, UsageError, "degrees or metres"),
        (LINE, {"origin": (8.5, 47.3)}, UsageError, "LATITUDE,LONGITUDE in this order"),
        (LINE, {"origin": (500.0, 47.3)}, UsageError, "no latitude"),
        ({"type": "LineString", "coordinates": [[3e5, 5e6], [3.1e5, 5e6]]}, {}, UsageError, "km from where"),
    ],
)
def test_what_cannot_be_is_told(tmp_path: Path, content, options: dict, kind: type[BematistError], says: str) -> None:
    file = tmp_path / "plan.png"
    if content == "picture":
        picture(file)
    elif content == "cut":
        file.write_bytes(picture(file).read_bytes()[:150])
    elif isinstance(content, dict):
        geojson(file, content)
    elif content is not None:
        file.write_bytes(content)
    with pytest.raises(kind, match=says) as caught:
        read_floor_plan(file, **options)
    assert "\n" not in str(caught.value)


def test_too_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan_image, "MOST_PIXELS", 10_000)
    with pytest.raises(DataError, match="Save it smaller"):
        read_floor_plan(picture(tmp_path / "p.png"), scale=1, origin=(0, 0))


@pytest.mark.parametrize("text", ["1\n2\n3", "a b c d e f", "0\n0\n0\n0\n1\n1"])
def test_a_broken_world_file(tmp_path: Path, text: str) -> None:
    picture(tmp_path / "p.png")
    (tmp_path / "p.pgw").write_text(text)
    with pytest.raises(DataError, match="world file"):
        read_floor_plan(tmp_path / "p.png")


def test_the_plan_lies_below_the_path_in_page_and_picture(tmp_path: Path) -> None:
    t = walk(3000)
    plain, seen = (tmp_path / name for name in ("plain.png", "seen.png"))
    still_path([t], plain, reference(t))
    plan = read_floor_plan(picture(tmp_path / "p.png"), scale=0.3, origin=(60, 80))
    still_path([t], seen, reference(t), floor_plan=plan)
    a, b = (np.asarray(Image.open(p).convert("RGB")).astype(int) for p in (plain, seen))
    assert ((b[:, :, 0] > 200) & (b[:, :, 1] < 90)).sum() > ((a[:, :, 0] > 200) & (a[:, :, 1] < 90)).sum()
    write_report([t], tmp_path / "r.html", floor_plan=plan)
    assert "data:image/png;base64," in (tmp_path / "r.html").read_text("utf-8")


def test_how_much_of_a_path_lies_on_the_plan(tmp_path: Path) -> None:
    plan = read_floor_plan(picture(tmp_path / "p.png"), scale=0.1, origin=(0, 100))
    assert plan.share_inside(np.array([[1.0, 1, 0], [30, 1, 0], [19.9, 9.9, 5], [1, -1, 0]])) == 0.5
