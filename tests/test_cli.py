"""The command line: its contracts, its files, its errors, its exit status."""

import json
import os
import signal
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import bematist
from bad_walk import csv, walk
from bematist import config
from bematist.cli import main
from bematist.cli.app import COMMANDS
from bematist.cli.job import judge, noted
from bematist.cli.track import error_text
from bematist.errors import DataError, UsageError
from bematist.outputs import results_folder, to_json, whole_file
from bematist.trajectory import COLUMNS

SUMMARY = {"method", "duration_s", "samples", "distance_m", "closure_m", "closure_percent", "height_change_m"}
SUMMARY |= {"stance_fraction", "processing_s", "warnings", "version"}


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A walk of 4.8 m, in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("walk.csv").write_text(csv(walk()))
    return Path("walk.csv")


@pytest.fixture
def truth(recording: Path) -> Path:
    """Its true plan at the five stances, on axes turned by 90° against the trajectory's."""
    path = Path("truth.csv")
    path.write_text("time,east,north\n" + "".join(f"{t},0,{1.2 * k}\n" for k, t in enumerate((0.5, 2.3, 3.3, 4.3, 6.0))))
    return path


def command(*args: object, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "bematist", *map(str, args)],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, **environment},
    )


def there(folder: str | Path = ".") -> list[str]:
    return sorted(path.name for path in Path(folder).iterdir())


def fails(capsys: pytest.CaptureFixture[str], status: int, *args: str) -> str:
    """Run a command that must fail; returns what it said."""
    assert main(args) == status
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    assert said.out == ""
    return said.err


# -- the shell ---------------------------------------------------------------------------------------------------------


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == f"bematist {bematist.__version__}"


def test_help_names_every_command_and_is_quick() -> None:
    took = []
    for _ in range(3):
        before = os.times()
        shown = command("--help")
        after = os.times()
        took.append(after.children_user + after.children_system - before.children_user - before.children_system)
    assert shown.returncode == 0
    names = ("demo", "track", "compare", "evaluate", "info", "stance", "steps", "methods", "convert", "export", "simulate", "reproduce")
    assert all(f"\n  {name} " in shown.stdout for name in names)
    assert "..." not in shown.stdout.partition("Commands:")[2]
    assert min(took) < 0.5


@pytest.mark.parametrize("name", ["demo", "track", "compare", "evaluate", "info", "stance", "steps", "methods", "export"])
def test_help_of_a_command(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    assert f"bematist {name}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["trak"], "Did you mean 'track'?"),
        (["track"], "RECORDING"),
        (["track", "walk.csv", "--methid", "foot"], "--method"),
        (["track", "walk.csv", "--chunk", "0"], "chunk"),
        (["track", "walk.csv", "--heading", "north"], "--heading"),
        (["track", "walk.csv", "--method", "zuppt"], "zupt"),
        (["track", "walk.csv", "--clock", "unifrom"], 'Did you mean "uniform"?'),
        (["track", "walk.csv", "--units", "g"], "specific_force=g"),
        (["track", "walk.csv", "--axes", "x,y"], "x,-z,y"),
        (["track", "walk.csv", "--set", "stance.thresold=3"], "stance.threshold"),
        (["track", "walk.csv", "--set", "threshold=3"], "stance.threshold"),
        (["track", "walk.csv", "--set", "stance=3"], "stance.threshold"),
        (["track", "walk.csv", "--set", "hard_iron.use=true"], "There is no parameter hard_iron.use. Did you mean magnetic.hard_iron.use?"),
        (["track", "walk.csv", "--set", "window_s=1"], "Did you mean stance.window_s or stance.pace.window_s?"),
        (["track", "walk.csv", "-m", "hand", "--set", "magnetic.sd=1"], "Did you mean attitude.magnetic.sd?"),
        (["track", "walk.csv", "-m", "hand", "--set", "magnetic.norm_tolerance=1"], "Did you mean attitude.motion.norm_tolerance?"),
        (["track", "walk.csv", "--set", "wurst.senf=1"], "There is no parameter wurst.senf. There are states, "),
        (["track", "walk.csv", "--set", "zaru.use=true"], "'off', 'rest' or 'stance'"),
        (["track", "walk.csv", "--set", "stance.window_s=true"], "stance.window_s"),
        (["track", "walk.csv", "--set", "stance.threshold=high"], "stance.threshold"),
        (["track", "walk.csv", "--set", "stance.threshold=-1"], "greater than 0"),
        (["track", "walk.csv", "--set", "stance.threshold"], "name=value"),
        (["track", "walk.csv", "--set", "stance.threshold=[1"], "neither a number"),
        (["track", "walk.csv", "--set", "stance.detector=shoo"], "shoe"),
        (["compare", "walk.csv", "--methods", "foot,zup"], "zupt"),
        (["compare", "walk.csv", "--methods", ","], "at least one"),
        (["compare", "walk.csv", "--align", "jaw", "--reference", "walk.csv"], 'Did you mean "yaw"?'),
        (["evaluate", "walk.csv", "walk.csv", "--align", "sim3"], "se3"),
        (["stance", "walk.csv", "--detector", "shoes"], 'Did you mean "shoe"?'),
        (["convert", "walk.csv", "walk.txt"], ".parquet"),
        (["convert", "walk.csv", "./walk.csv"], "written over"),
        (["stance", "walk.csv", "-o", "walk.csv"], "written over"),
        (["stance", "walk.csv", "-m", "magyq"], "bematist steps"),
        (["track", "walk.csv", "--heading", "nan"], "clockwise"),
        (["export", "walk.csv", "walk.kml"], "--format"),
        (["export", "walk.csv", "walk.x", "--format", "gpz"], 'Did you mean "gpx"?'),
        (["export", "walk.csv", "walk.gpx", "--origin", "here"], "latitude,longitude"),
        (["export", "walk.csv", "walk.gpx", "--origin", "95,0"], "latitude,longitude"),
        (["simulate", "-o", "sim", "--scenario", "campos"], "campus"),
        (["simulate", "-o", "sim", "--sensor", "lsm9ds"], 'Did you mean "lsm9ds1"?'),
        (["simulate", "-o", "sim", "--gait", "rum"], 'Did you mean "run"?'),
        (["simulate", "-o", "sim", "--set", "rate_hx=3"], 'Did you mean "rate_hz"?'),
    ],
)
def test_wrong_usage(args: list[str], says: str, recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert says in fails(capsys, 2, *args)
    assert there() == ["walk.csv"]


def test_wrong_usage_is_told_before_the_recording_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    assert "zupt" in fails(capsys, 2, "track", "nowhere.csv", "--method", "zup")


def test_an_unexpected_error_asks_for_a_report(
    recording: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import bematist.methods

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("a\nb")

    monkeypatch.setattr(bematist.methods, "track", broken)
    monkeypatch.delenv("BEMATIST_DEBUG", raising=False)
    said = fails(capsys, 1, "track", "walk.csv")
    assert "ZeroDivisionError (a b)" in said
    assert "BEMATIST_DEBUG=1" in said
    assert len(said.splitlines()) == 1
    monkeypatch.setenv("BEMATIST_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        main(["track", "walk.csv"])
    assert there() == ["walk.csv"]


NOISY = """
import sys, numpy, bematist.methods
whole = bematist.methods.track
def track(*args, **options):
    numpy.sqrt(numpy.array([-1.0]))
    return whole(*args, **options)
bematist.methods.track = track
from bematist.cli import main
sys.exit(main(["track", "walk.csv", "-o", "out", "--no-report", "-q"]))
"""


@pytest.mark.parametrize("debug", ["", "1"])
def test_numerical_noise_is_for_developers(debug: str, recording: Path) -> None:
    environment = {**os.environ, "BEMATIST_DEBUG": debug}
    done = subprocess.run([sys.executable, "-c", NOISY], capture_output=True, text=True, env=environment)
    assert done.returncode == 0
    assert ("invalid value" in done.stderr) == bool(debug)


SLOW = """
import sys, time, bematist.io
def read(*args, **options):
    print("reading", flush=True)
    time.sleep(30)
bematist.io.read = read
from bematist.cli import main
sys.exit(main(["track", "walk.csv", "-o", "out"]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_interrupted_in_the_middle(number: int, status: int, recording: Path) -> None:
    work = subprocess.Popen([sys.executable, "-c", SLOW], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert work.stdout is not None
    assert work.stdout.readline() == "reading\n"
    work.send_signal(number)
    _, said = work.communicate(timeout=20)
    assert work.returncode == status
    assert "Traceback" not in said
    assert there() == ["walk.csv"]


def test_a_reader_that_goes_away_is_no_error() -> None:
    python = f"'{sys.executable}' -m bematist"
    script = f"set -o pipefail; {python} methods --json | true; {python} methods | head -1"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert done.stderr == ""


# -- track -------------------------------------------------------------------------------------------------------------


def test_track_keeps_the_contract(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", "walk.csv", "--method", "zupt", "-o", "deep/out"]) == 0
    said = capsys.readouterr()
    assert "4.79 m" in said.out
    assert "deep/out/report.html" in said.out
    assert said.err == ""
    out = Path("deep/out")
    assert {p.name for p in out.iterdir()} == {
        "trajectory.parquet",
        "trajectory.csv",
        "summary.json",
        "config.toml",
        "report.html",
    }
    table = pl.read_csv(out / "trajectory.csv")
    assert tuple(table.columns) == COLUMNS
    assert len(table) == 700
    assert set(table["stance"].unique()) == {0, 1}
    assert table["east"][-1] == pytest.approx(4.8, abs=0.1)
    assert tuple(pl.read_parquet(out / "trajectory.parquet").columns[: len(COLUMNS)]) == COLUMNS
    summary = json.loads((out / "summary.json").read_text())
    assert set(summary) >= SUMMARY
    assert summary["method"] == "zupt"
    assert summary["samples"] == 700
    assert summary["version"] == bematist.__version__
    used = tomllib.loads((out / "config.toml").read_text())
    assert used["method"] == "zupt"
    assert used["version"] == bematist.__version__
    assert used["parameters"]["stance"]["detector"] == "shoe"
    assert used["reading"]["clock"] == "auto"
    assert "<html" in (out / "report.html").read_text()[:2000]


def test_new_files_have_ordinary_permissions(recording: Path) -> None:
    old = os.umask(0o027)
    try:
        assert main(["track", "walk.csv", "-o", "out", "--no-report", "-q"]) == 0
        assert main(["convert", "walk.csv", "copy.csv", "-q"]) == 0
    finally:
        os.umask(old)
    assert Path("out").stat().st_mode & 0o777 == 0o750
    assert Path("out/summary.json").stat().st_mode & 0o777 == 0o640
    assert Path("copy.csv").stat().st_mode & 0o777 == 0o640


def track(*args: str, out: str = "out") -> pl.DataFrame:
    assert main(["track", "walk.csv", "-o", out, "--no-report", "-q", *args]) == 0
    return pl.read_parquet(Path(out) / "trajectory.parquet")


def test_the_written_configuration_repeats_the_run(recording: Path) -> None:
    told = ("--method", "maginav", "--set", "stance.threshold=80", "--heading", "30", "--clock", "stamps")
    first = track(*told, "--axes", "y,-x,z", "--units", "specific_force=m/s^2", "--set", "stance.window_s=0.08")
    again = track("--config", "out/config.toml", out="again")
    assert first.equals(again)
    assert Path("out/config.toml").read_text() == Path("again/config.toml").read_text()
    assert not first.equals(track("--method", "maginav", "--heading", "30", out="other"))


def test_options_win_over_the_configuration(recording: Path) -> None:
    Path("mine.toml").write_text('method = "zupt"\n[parameters.stance]\nthreshold = 50\nwindow_s = 0.08\n')
    track("--config", "mine.toml", "--set", "stance.threshold=70", "--set", "stance.detector=ared")
    used = tomllib.loads(Path("out/config.toml").read_text())["parameters"]["stance"]
    assert (used["threshold"], used["window_s"], used["detector"]) == (70, 0.08, "ared")


def test_a_threshold_means_the_absolute_rule(recording: Path) -> None:
    """With the default method, whose own rule is another one; also on top of a stored configuration."""
    own = track()
    low, high = track("--set", "stance.threshold=20"), track("--config", "out/config.toml", "--set", "stance.threshold=400", out="high")
    assert low["stance"].mean() < high["stance"].mean()
    assert not own.equals(low)


@pytest.mark.parametrize(
    ("content", "args", "says"),
    [
        ('method = "zupt"', ["--method", "foot"], "zupt"),
        ("[stance]\nthreshold = 3", [], "[parameters"),
        ("[parameters.stance]\nthresh = 3", [], "stance.threshold"),
        ("[reading]\nformt = 'x'", [], 'Did you mean "format"?'),
        ("threshold 3", [], "line 1"),
        ("parameters = 3", [], "under [parameters]"),
        ("[reading]\nunits = 3", [], "under [reading.units]"),
    ],
)
def test_wrong_configuration(content: str, args: list[str], says: str, recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.toml").write_text(content)
    assert says in fails(capsys, 2, "track", "walk.csv", "--config", "mine.toml", *args)


@pytest.mark.parametrize("chunk", ["1", "37", "100000"])
def test_chunks_change_nothing(chunk: str, recording: Path) -> None:
    assert track().equals(track("--chunk", chunk, out="chunks"))


def test_heading_turns_the_path(recording: Path) -> None:
    east, turned = track(), track("--heading", "0", out="north")
    np.testing.assert_allclose(turned["north"], east["east"], atol=1e-6)
    np.testing.assert_allclose(turned["up"], east["up"], atol=1e-6)


def test_quiet_says_nothing(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("walk.csv").write_text(csv({k: v[::50] for k, v in walk().items()}))  # 2 Hz: worth a warning
    track()
    assert capsys.readouterr() == ("", "")
    assert json.loads(Path("out/summary.json").read_text())["warnings"]


def test_output_is_named_after_the_recording(recording: Path) -> None:
    assert main(["track", "walk.csv", "--no-report", "-q"]) == 0
    assert Path("walk/summary.json").is_file()
    Path("walk.csv").rename("bare")
    assert main(["track", "bare", "--no-report", "-q"]) == 0
    assert Path("bare-track/summary.json").is_file()


def test_reference_is_judged(recording: Path, truth: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", "walk.csv", "--reference", "truth.csv", "-o", "out", "--no-report"]) == 0
    assert "aligned by yaw" in capsys.readouterr().out
    found = json.loads(Path("out/evaluation.json").read_text())
    assert found["alignment"] == "yaw"
    assert found["ate_rmse_2d_m"] < 0.1


def test_a_mirrored_reference_and_one_of_another_walk_are_told(recording: Path, truth: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", "walk.csv", "-o", "out", "-q"]) == 0
    path = bematist.io.read_trajectory("out")
    right = bematist.read_reference("truth.csv")
    bent = right.position + np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0]])
    far = replace(right, position=5 * bent, mirrored=True)
    found = judge(path, far)
    assert found is not None and not isinstance(found, str)
    assert "times as long" in noted(path, found).warnings[-1]
    assert ("mirrored" in error_text(found)) == found.alignment.mirrored
    flipped = judge(path, replace(far, position=far.position * [-1, 1, 1]))
    assert flipped is not None and not isinstance(flipped, str) and flipped.alignment.mirrored != found.alignment.mirrored
    Path("other.csv").write_text("time,east,north\n0,0,0\n3,0,30\n6,0,60\n")
    assert main(["track", "walk.csv", "-o", "two", "--reference", "other.csv"]) == 0
    assert "times as long as the reference" in capsys.readouterr().err


def test_without_a_magnetometer_no_rest_is_blamed(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = walk()
    Path("bare.csv").write_text(csv({name: values for name, values in columns.items() if name not in ("mx", "my", "mz")}))
    assert main(["track", "bare.csv", "-m", "maginav", "-o", "bare"]) == 0
    said = capsys.readouterr().err
    assert "there is no sample of it: it is not used" in said


def test_results_never_replace_the_recording(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording.rename("trajectory.csv")
    before = Path("trajectory.csv").read_bytes()
    assert "written over" in fails(capsys, 2, "track", "trajectory.csv", "-o", ".")
    assert Path("trajectory.csv").read_bytes() == before
    assert main(["track", "trajectory.csv", "-q", "--no-report"]) == 0


def test_a_path_that_is_no_number_is_not_handed_out(
    recording: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import bematist.methods

    whole = bematist.methods.track

    def diverges(*args: object, **options: object) -> object:
        found = whole(*args, **options)  # pyright: ignore[reportArgumentType]
        found.position[300:] = np.nan
        return found

    monkeypatch.setattr(bematist.methods, "track", diverges)
    assert "diverged, the position is no number from 3.00 s on" in fails(capsys, 1, "track", "walk.csv")
    assert there() == ["walk.csv"]


def test_no_place_for_text_with_brackets(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Names are shown as they are: rich reads [..] as markup unless told not to."""
    Path("walk.csv").rename("[red]walk.csv")
    assert main(["track", "[red]walk.csv", "--no-report"]) == 0
    assert "[red]walk.csv" in capsys.readouterr().out


# -- the other commands ------------------------------------------------------------------------------------------------


def test_compare(recording: Path, truth: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "walk.csv", "--methods", "foot, zupt", "--reference", "truth.csv", "-o", "out"]) == 0
    said = capsys.readouterr().out
    assert "alignment by yaw" in said and "Truth: truth.csv\n" in said
    rows = json.loads(Path("out/comparison.json").read_text())
    assert [row["method"] for row in rows] == ["foot", "zupt"]
    assert all(row["ate_rmse_2d_m"] < 0.1 and row["alignment"] == "yaw" for row in rows)
    assert pl.read_csv("out/comparison.csv")["distance_m"].to_list() == [row["distance_m"] for row in rows]
    assert Path("out/report.html").is_file()
    for row in rows:
        own = Path("out") / row["method"]
        assert json.loads((own / "summary.json").read_text())["distance_m"] == row["distance_m"]
        assert main(["track", "walk.csv", "--config", str(own / "config.toml"), "-o", "x", "--no-report", "-q"]) == 0
        assert pl.read_parquet("x/trajectory.parquet").equals(pl.read_parquet(own / "trajectory.parquet"))


def test_compare_without_reference_takes_all_methods_for_a_shoe(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from bematist.methods import worn

    assert main(["compare", "walk.csv", "--no-report"]) == 0
    assert "rms" not in capsys.readouterr().out
    assert {p.name for p in Path("walk-compare").iterdir() if p.is_dir()} == set(worn("shoe"))


def test_evaluate(recording: Path, truth: Path, capsys: pytest.CaptureFixture[str]) -> None:
    track()
    assert main(["evaluate", "out", "truth.csv", "--json", "found.json"]) == 0
    assert "yaw" in capsys.readouterr().out
    assert main(["evaluate", "out/trajectory.csv", "truth.csv", "--align", "yaw", "--json", "-"]) == 0
    printed = json.loads(capsys.readouterr().out)
    stored = json.loads(Path("found.json").read_text())
    assert printed["ate_rmse_2d_m"] == pytest.approx(stored["ate_rmse_2d_m"], rel=1e-3)
    assert main(["evaluate", "out", "truth.csv", "--align", "none", "--json", "-"]) == 0
    unaligned = json.loads(capsys.readouterr().out)
    assert unaligned["alignment"] == "none"
    assert unaligned["ate_rmse_2d_m"] > 10 * printed["ate_rmse_2d_m"]
    assert "no such file" in fails(capsys, 1, "evaluate", "out", "nowhere.csv")


def test_methods(capsys: pytest.CaptureFixture[str]) -> None:
    from bematist.methods import METHODS

    assert main(["methods"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in METHODS)
    assert main(["methods", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in found] == list(METHODS)
    assert all(row["paper"] and row["equations"] and row["summary"] for row in found)


def test_info(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "walk.csv"]) == 0
    said = capsys.readouterr().out
    assert "100 Hz" in said
    assert "gyroscope" in said
    assert main(["info", "walk.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["samples"] == 700


def test_stance(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stance", "walk.csv", "-o", "page.html", "--detector", "ared", "--set", "threshold=12"]) == 0
    said = capsys.readouterr().out
    assert "ared, threshold 12" in said
    assert "5 phases" in said
    assert "<html" in Path("page.html").read_text()[:2000]
    assert main(["stance", "walk.csv", "-q", "--set", "stance.threshold=150"]) == 0
    assert Path("walk-stance.html").is_file()


@pytest.mark.parametrize(("suffix", "tolerance"), [("csv", 1e-5), ("parquet", 0)])
def test_convert_keeps_the_recording(suffix: str, tolerance: float, recording: Path) -> None:
    assert main(["convert", "walk.csv", f"copy.{suffix}", "-q"]) == 0
    assert main(["track", f"copy.{suffix}", "--method", "maginav", "-o", "copy", "--no-report", "-q"]) == 0
    copied = pl.read_parquet("copy/trajectory.parquet").to_numpy()
    np.testing.assert_allclose(copied, track("--method", "maginav").to_numpy(), rtol=0, atol=tolerance)


@pytest.mark.parametrize("name", ["x.tum", "x.geojson", "x.gpx", "x.csv", "x.parquet"])
def test_export(name: str, recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    track()
    options = ["--origin", "47.3769,8.5417,408", "--heading", "90"] if name in ("x.gpx", "x.geojson") else []
    assert main(["export", "out", name, *options]) == 0
    content = Path(name).read_bytes()
    if options:
        assert b"47.37" in content
        assert b"8.54" in content
    assert len(content) > 500
    assert set(there()) == {"walk.csv", "out", name}


def test_simulate_track_evaluate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "-o", "sim", "--scenario", "straight", "--set", "length_m=20", "--seed", "3"]) == 0
    assert set(there("sim")) == {"recording.csv", "simulation.json", "truth.csv"}
    assert main(["track", "sim/recording.csv", "-o", "out", "--no-report", "-q"]) == 0
    capsys.readouterr()
    assert main(["evaluate", "out", "sim/truth.csv", "--align", "none", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["ate_rmse_3d_m"] < 1.0


def test_simulate_names_what_there_is_and_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    from bematist.simulate import GAITS, SCENARIOS, SENSORS

    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "--help"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in (*SCENARIOS, *SENSORS, *GAITS))
    assert main(["simulate", "straight", "--length", "10", "-q"]) == 0
    assert sorted(p.name for p in Path("straight").iterdir()) == ["recording.csv", "simulation.json", "truth.csv"]


def test_simulate_in_the_hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from bematist import read

    monkeypatch.chdir(tmp_path)
    changes = '[[0, "texting"], [15, "swinging"]]'
    assert main(["simulate", "straight", "-o", "sim", "--length", "30", "--carry", "bag", "--set", f"carries={changes}", "-q"]) == 0
    facts = json.loads(Path("sim/simulation.json").read_text())
    assert (facts["sensor"]["name"], facts["walker"]["carries"][1][1]["name"]) == ("phone", "swinging")
    steps = pl.read_csv("sim/steps.csv")
    assert len(steps) == facts["steps"]
    assert steps["length_m"].sum() == pytest.approx(30, abs=1e-3)
    assert pl.read_csv("sim/modes.csv").rows()[1:3] == [
        (10.0, pytest.approx(23, abs=3), "walking", "texting"),
        (pytest.approx(23, abs=3), pytest.approx(37, abs=4), "walking", "swinging"),
    ]
    read_back = read("sim/recording.csv")
    assert len(read_back.pressure) > 300
    assert len(read_back.magnetic_time) == pytest.approx(len(read_back) / 2, abs=2)


def test_simulate_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert (
        main(["simulate", "straight", "-o", "sim", "--length", "15", "--gait", "run", "--rate", "100", "--set", "gyro_scale_sd=0.01"]) == 0
    )
    facts = json.loads(Path("sim/simulation.json").read_text())
    assert facts["distance_m"] == pytest.approx(15)
    assert facts["scenario"]["gaits"][0][1]["name"] == "run"
    assert facts["sensor"]["rate_hz"] == 100
    assert facts["errors"]["gyro_matrix"][0][0] != 1
    assert main(["simulate", "still", "-o", "rest", "--duration", "20", "--sensor", "ideal"]) == 0
    capsys.readouterr()
    wrongs = (["campus", "--duration", "9"], "--length"), (["straight", "--gait", "sprint"], "jog"), (["moon"], "campus")
    for wrong, says in (*wrongs, (["straight", "--carry", "nose"], "texting")):
        assert main(["simulate", *wrong, "-o", "not"]) == 2
        assert says in capsys.readouterr().err
    assert not Path("not").exists()


def test_demo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--scenario", "short", "-o", "shown"]) == 0
    said = capsys.readouterr().out
    assert str(tmp_path / "shown" / "report.html") in said.replace("\n", "")
    rows = json.loads(Path("shown/comparison.json").read_text())
    assert [row["method"] for row in rows] == ["foot", "zupt", "maginav"]
    assert rows[0]["ate_rmse_2d_m"] < 1.0
    assert {"recording.csv", "truth.csv", "report.html", "foot", "zupt", "maginav"} <= set(there("shown"))


def test_real_recording_with_its_own_reference(shared_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = shared_data / "foot" / "gsu_gx5" / "SensorConnectData_32.csv"
    assert main(["track", str(path), "-o", str(tmp_path / "out"), "--no-report"]) == 0
    said = capsys.readouterr().out
    assert "against truth" in said and "SensorConnectData_32.mat, found with the recording: surveyed footfalls" in said
    found = json.loads((tmp_path / "out" / "evaluation.json").read_text())
    assert found["ate_rmse_2d_m"] < 0.5 and found["reference_distance_m"] == pytest.approx(80, abs=1)
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["reference"] == str(path.with_suffix(".mat"))


# -- configuration and outputs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "table"),
    [
        ("a=1", {"a": 1}),
        ("a.b = 2.5e5", {"a": {"b": 2.5e5}}),
        ("a.b.c=true", {"a": {"b": {"c": True}}}),
        ("a=shoe", {"a": "shoe"}),
        ("a='two words'", {"a": "two words"}),
        ("a=[1, 2.5, -3]", {"a": [1, 2.5, -3]}),
        ("a=inf", {"a": float("inf")}),
        ("a=none", {"a": "none"}),
    ],
)
def test_assignment(text: str, table: dict[str, object]) -> None:
    assert config.assignment(text) == table


@pytest.mark.parametrize("text", ["a", "=1", "a.=1", ".a=1", "a b=1", "a=", "a=1 2", "a=nan", "a=[1", "a=1\nb=2", "a=two words"])
def test_wrong_assignment(text: str) -> None:
    with pytest.raises(UsageError, match="--set"):
        config.assignment(text)


def test_merge_lays_later_tables_over() -> None:
    first, second = {"a": {"x": 1, "y": 2}, "b": 3}, {"a": {"y": 4}, "c": {"z": 5}}
    assert config.merge(first, second) == {"a": {"x": 1, "y": 4}, "b": 3, "c": {"z": 5}}
    assert first == {"a": {"x": 1, "y": 2}, "b": 3}


def test_parameters_survive_toml() -> None:
    from bematist.methods import METHODS

    for method in METHODS.values():
        text = config.to_toml(method.parameters.model_dump())
        assert METHODS["foot" if method.worn == "shoe" else "hand"].parameters.override(tomllib.loads(text)) == method.parameters


def test_none_takes_a_value_away() -> None:
    from bematist.methods import METHODS

    with_threshold = METHODS["zupt"].parameters.override(config.assignment("stance.threshold=7"))
    assert with_threshold.stance.threshold == 7
    assert with_threshold.override(config.assignment("stance.threshold=none")).stance.threshold is None
    with pytest.raises(UsageError, match="gravity"):
        with_threshold.override({"gravity": "none"})


def test_json_has_no_nan() -> None:
    assert json.loads(to_json({"a": float("nan"), "b": np.array([1.0, np.inf]), "c": (np.float64(2), np.int64(3), None, True)})) == {
        "a": None,
        "b": [1.0, None],
        "c": [2.0, 3, None, True],
    }


def test_results_folder_is_complete_or_absent(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with pytest.raises(DataError), results_folder(folder) as place:
        (place / "x").write_text("x")
        raise DataError("no")
    assert not any(tmp_path.iterdir())
    with results_folder(folder) as place:
        (place / "x").write_text("1")
        assert not folder.exists()
    assert (folder / "x").read_text() == "1"
    with results_folder(folder) as place:
        (place / "sub").mkdir()
        (place / "sub" / "y").write_text("2")
        assert [p.name for p in folder.iterdir() if not p.name.startswith(".")] == ["x"]
    assert sorted(p.name for p in folder.rglob("*")) == ["sub", "x", "y"]


def test_whole_file_keeps_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    path.write_text("old")
    with pytest.raises(DataError), whole_file(path) as place:
        place.write_text("half")
        raise DataError("no")
    assert path.read_text() == "old"
    assert there(tmp_path) == ["x.json"]


def test_the_documentation_names_every_command_and_option() -> None:
    import re

    import typer.main

    from bematist.cli import app, load

    load()
    text = (Path(__file__).parents[1] / "docs" / "command-line.md").read_text("utf-8")
    group = typer.main.get_group(app)
    assert set(group.commands) == set(COMMANDS)
    for name, one in group.commands.items():
        assert f"\n## {name}\n" in text
        options = {o for p in one.params for o in (*p.opts, *p.secondary_opts) if o.startswith("--")}
        missing = [o for o in options if not re.search(rf"{o}\b", text)]
        assert not missing, (name, missing)
    documented = set(re.findall(r"(?<![\w-])(--[a-z][a-z-]+)", text))
    known = {o for one in group.commands.values() for p in one.params for o in (*p.opts, *p.secondary_opts)}
    assert documented <= known | {"--help"}
