"""`track` and `compare` with a start, a heading and a plan of the building."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from PIL import Image

from bad_walk import csv, walk
from bematist.cli import main

MAP = ("--map", "plan.png", "--map-scale", "0.05", "--map-origin", "100,300", "--map-rotation", "10")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a walk of 4.8 m along East, its waypoints on axes turned by 90° and shifted, and a plan."""
    monkeypatch.chdir(tmp_path)
    Path("walk.csv").write_text(csv(walk()))
    rows = "".join(f"{t},50,{20 + 1.2 * k}\n" for k, t in enumerate((0.5, 2.3, 3.3, 4.3, 6.0)))
    Path("truth.csv").write_text("time,east,north\n" + rows)
    Image.new("RGB", (2000, 900), "white").save("plan.png")
    return tmp_path


def track(*args: str, out: str = "out") -> pl.DataFrame:
    assert main(["track", "walk.csv", "-o", out, "-q", *args]) == 0
    return pl.read_csv(f"{out}/trajectory.csv")


def test_the_start_is_in_every_file(here: Path) -> None:
    plain, moved = track(out="plain"), track("--start", "7,-3,1.5")
    for name, shift in (("east", 7), ("north", -3), ("up", 1.5)):
        assert moved[name].to_numpy() == pytest.approx(plain[name].to_numpy() + shift, abs=2e-6)
    assert json.loads(Path("out/summary.json").read_text())["start_m"] == pytest.approx([7, -3, 1.5])
    assert main(["export", "out", "w.tum"]) == 0
    assert np.loadtxt("w.tum")[0, 1:4] == pytest.approx([7, -3, 1.5], abs=1e-6)


def test_start_and_heading_of_the_reference(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", "walk.csv", "-o", "out", "--reference", "truth.csv", "--start", "reference", "--heading", "reference"]) == 0
    said = capsys.readouterr().out
    assert "50.00 m east, 20.00 m north" in said and "aligned by none" in said
    found = json.loads(Path("out/evaluation.json").read_text())
    assert found["alignment"] == "none" and found["ate_rmse_2d_m"] < 0.05


def test_the_configuration_repeats_start_turn_and_map(here: Path) -> None:
    track("--reference", "truth.csv", "--start", "reference", "--heading", "reference", *MAP)
    track("--config", "out/config.toml", out="again")
    for name in ("trajectory.csv", "config.toml"):
        assert Path("out", name).read_bytes() == Path("again", name).read_bytes()
    assert "data:image/png" in Path("again/report.html").read_text("utf-8")
    other = track("--config", "out/config.toml", "--start", "1,2", out="other")
    assert other["east"][0] == pytest.approx(1) and other["north"][-1] == pytest.approx(2 + 4.8, abs=0.05)
    straight = track("--config", "out/config.toml", "--heading", "90", out="straight")
    assert straight["east"][-1] == pytest.approx(50 + 4.8, abs=0.05)


def test_a_plan_that_the_path_does_not_touch(here: Path) -> None:
    track(*MAP, "--start", "900,0")
    assert any("No point of the path lies on the plan" in w for w in json.loads(Path("out/summary.json").read_text())["warnings"])
    track(*MAP, out="on")
    assert not any("plan" in w for w in json.loads(Path("on/summary.json").read_text())["warnings"])


def test_compare_on_a_plan(here: Path) -> None:
    args = ["compare", "walk.csv", "-m", "foot,zupt", "-o", "both", "--reference", "truth.csv", "--start", "reference", "-q"]
    assert main([*args, "--heading", "reference", *MAP]) == 0
    rows = json.loads(Path("both/comparison.json").read_text())
    assert [row["alignment"] for row in rows] == ["none", "none"] and all(row["ate_rmse_2d_m"] < 0.05 for row in rows)
    assert "data:image/png" in Path("both/report.html").read_text("utf-8")
    track("--config", "both/zupt/config.toml", out="again")
    assert Path("again/trajectory.csv").read_bytes() == Path("both/zupt/trajectory.csv").read_bytes()


@pytest.mark.parametrize(
    ("args", "status", "says"),
    [
        (["--start", "here"], 2, "2 or 3 numbers"),
        (["--start", "1"], 2, "2 or 3 numbers"),
        (["--start", "1,nan"], 2, "2 or 3 numbers"),
        (["--start", "reference"], 2, "there is no reference"),
        (["--heading", "referense"], 2, "--heading"),
        (["--map", "plan.png"], 2, "--map-scale"),
        (["--map", "plan.png", "--map-scale", "1"], 2, "--map-origin X,Y"),
        (["--map", "plan.png", "--map-scale", "-1", "--map-origin", "0,0"], 2, "greater than 0"),
        (["--map", "plan.png", "--map-scale", "1", "--map-origin", "0"], 2, "2 numbers"),
        (["--map-scale", "1"], 2, "name it with --map"),
        (["--map", "nothing.png", "--map-scale", "1", "--map-origin", "0,0"], 1, "cannot be opened"),
        (["--map", "walk.csv", "--map-scale", "1", "--map-origin", "0,0"], 1, "neither a picture"),
        (["--map", ".", "--map-scale", "1", "--map-origin", "0,0"], 1, "cannot be opened"),
    ],
)
def test_what_does_not_make_sense(args: list[str], status: int, says: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", "walk.csv", "-o", "out", *args]) == status
    said = capsys.readouterr()
    assert says in said.err and said.out == "" and said.err.count("\n") == 1
    assert not Path("out").exists()
