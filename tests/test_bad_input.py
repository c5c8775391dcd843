"""Broken and strange recordings: each ends in a trajectory with the warning that is due, or in one clear paragraph.

Every case runs the real command in this process. What may not happen: a traceback, a result without one of its files,
a position that is not finite, a file left behind by a command that failed.
"""

import gzip
import json
import math
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from scipy.io import savemat

from bad_walk import Columns, G, csv, walk
from bematist.cli import main
from bematist.trajectory import COLUMNS

FILES = {"trajectory.parquet", "trajectory.csv", "summary.json", "config.toml"}
FORCE, RATE, FIELD = ("fx", "fy", "fz"), ("wx", "wy", "wz"), ("mx", "my", "mz")


@dataclass(frozen=True)
class Case:
    """A recording, the options it is tracked with, and words of the warning or of the error that must be said."""

    name: str
    make: Callable[[Path], Path | None]
    says: str = ""
    ends: int = 0
    options: tuple[str, ...] = ()
    distance_m: tuple[float, float] = (0.0, math.inf)
    file: str = "walk.csv"


def table(change: Callable[[Columns], Columns | None], **options: float) -> Callable[[Path], None]:
    """A recording whose columns are changed in place (or replaced)."""

    def make(path: Path) -> None:
        columns = walk(**options)  # pyright: ignore[reportArgumentType]
        path.write_text(csv(change(columns) or columns))

    return make


def text(change: Callable[[str], str | bytes], **options: float) -> Callable[[Path], None]:
    """A recording whose text is changed."""

    def make(path: Path) -> None:
        changed = change(csv(walk(**options)))  # pyright: ignore[reportArgumentType]
        path.write_bytes(changed if isinstance(changed, bytes) else changed.encode())

    return make


def data(content: bytes) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(content) and None


def put(names: tuple[str, ...], value: float, rows: slice = slice(None)) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        for name in names:
            columns[name][rows] = value

    return change


def scale(names: tuple[str, ...], factor: float) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        for name in names:
            columns[name] *= factor

    return change


def clip(names: tuple[str, ...], limit: float) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        for name in names:
            columns[name].clip(-limit, limit, columns[name])

    return change


def drop(*names: str) -> Callable[[Columns], Columns]:
    return lambda columns: {k: v for k, v in columns.items() if k not in names}


def rows(which: slice) -> Callable[[Columns], Columns]:
    return lambda columns: {k: v[which] for k, v in columns.items()}


def stamps(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Columns], None]:
    def make(columns: Columns) -> None:
        columns["time"] = change(columns["time"].copy())

    return make


def edit(line: int, old: str, new: str) -> Callable[[str], str]:
    def change(content: str) -> str:
        lines = content.split("\n")
        cells = lines[line].split(",")
        lines[line] = new if old == "*" else ",".join([*cells[:3], new, *cells[4:]])
        return "\n".join(lines)

    return change


def late_by(pause: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: t + np.where(t > 3.2, pause, 0.0)


def set_value(index: int, value: float) -> Callable[[np.ndarray], np.ndarray]:
    def change(t: np.ndarray) -> np.ndarray:
        t[index] = value
        return t

    return change


def swap(t: np.ndarray) -> np.ndarray:
    t[[300, 301]] = t[[301, 300]]
    return t


def parquet(cut: float = 1.0, hole: int = 0) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        pl.DataFrame(walk()).write_parquet(path)
        content = path.read_bytes()
        path.write_bytes(content[:100] + content[100 + hole : round(cut * len(content))])

    return make


def alternate(columns: Columns) -> None:
    """Accelerometer and gyroscope in turns: each row holds one of the two."""
    for name in FORCE:
        columns[name][1::2] = np.nan
    for name in RATE:
        columns[name][0::2] = np.nan


def shuffled(columns: Columns) -> Columns:
    return {k: columns[k] for k in ("mz", "wx", "fz", "time", "my", "wy", "fx", "mx", "wz", "fy")}


def repeated(columns: Columns) -> Columns:
    return {k: np.repeat(v, 2) for k, v in columns.items()}


def with_extra(columns: Columns) -> Columns:
    return {"sample": np.arange(len(columns["time"])), **columns, "temperature": 0 * columns["time"] + 21.5}


WALK = (4.5, 5.1)  # 4 strides of 1.2 m
CASES = [
    # -- files that are no recording
    Case("no such file", lambda path: None, "no such file", 1),
    Case("zero bytes", data(b""), "is empty", 1),
    Case("blank lines", data(b"\n\n  \n"), "is empty", 1),
    Case("header only", text(lambda s: s.split("\n")[0] + "\n"), "no row", 1),
    Case("comments only", data(b"# nothing\n# here\n"), "walk.csv", 1),
    Case("a folder", lambda path: path.mkdir(), "folder", 1),
    Case("a link to nowhere", lambda path: path.symlink_to("nowhere.csv"), "no such file", 1),
    Case("a link to itself", lambda path: path.symlink_to(path), "cannot be opened", 1),
    Case("a pipe", lambda path: os.mkfifo(path), "pipe", 1),
    Case("binary junk", data(bytes(np.random.default_rng(1).integers(0, 256, 4000, np.uint8))), "format", 1),
    Case("zeros only", data(bytes(5000)), "walk.csv", 1),
    Case("gzip", lambda path: path.write_bytes(gzip.compress(csv(walk()).encode())) and None, "Unpack", 1),
    Case("a letter", data(b"Dear Sir,\nplease find the recording attached.\n"), "format", 1),
    Case("JSON", data(json.dumps({"fx": [1.0, 2.0]}).encode()), "", 1),
    Case("Parquet cut short", parquet(0.5), "cut short", 1),
    Case("Parquet with a hole", parquet(hole=2000), "damaged", 1),
    Case("Parquet with the wrong suffix", parquet(), distance_m=WALK),
    Case("CSV with the wrong suffix", text(lambda s: s), distance_m=WALK, file="walk.parquet"),
    Case("CSV without suffix", text(lambda s: s), distance_m=WALK, file="walk"),
    Case("no header", text(lambda s: s.split("\n", 1)[1]), "--columns", 1),
    Case("other names", text(lambda s: s.replace("fx,fy,fz", "a,b,c")), "", 1),
    # -- text
    Case("text in a number", text(edit(200, "", "oops")), 'line 201: "oops"', 1),
    Case("a word in the time column", text(edit(200, "*", "noon" + ",0" * 9)), "line 201", 1),
    Case("row cut short", text(edit(200, "*", "1.99,0.1")), "left out"),
    Case("row too long", text(edit(200, "*", "1.99" + ",0" * 14)), "line 201", 1),
    Case("last line cut", text(lambda s: s[:-40]), distance_m=WALK),
    Case("header again in the middle", text(lambda s: edit(200, "*", s.split("\n")[0])(s)), "line 201", 1),
    Case("two columns of one name", text(lambda s: s.replace("mx,my,mz", "fx,fy,fz")), 'called "fx"', 1),
    Case("upper-case header", text(lambda s: s.replace(*[s.split("\n")[0], s.split("\n")[0].upper()])), distance_m=WALK),
    Case("blanks and quotes in the header", text(lambda s: s.replace("time,fx", ' "time" , "fx"')), distance_m=WALK),
    Case("UTF-16", text(lambda s: s.encode("utf-16")), distance_m=WALK),
    Case("byte order mark", text(lambda s: s.encode("utf-8-sig")), distance_m=WALK),
    Case("Windows line ends", text(lambda s: s.replace("\n", "\r\n")), distance_m=WALK),
    Case("semicolons", text(lambda s: s.replace(",", ";")), distance_m=WALK),
    Case("semicolons and decimal commas", text(lambda s: s.replace(",", ";").replace(".", ",")), distance_m=WALK),
    Case("tabs", text(lambda s: s.replace(",", "\t")), distance_m=WALK),
    Case("comments inside", text(lambda s: "# sensor 7\n" + edit(200, "*", "# here it rained")(s)), distance_m=WALK),
    Case("extra columns", table(with_extra), distance_m=WALK),
    Case("columns in another order", table(shuffled), distance_m=WALK),
    Case("a name with blanks", text(lambda s: s), distance_m=WALK, file="my first walk.csv"),
    Case("a name in Greek", text(lambda s: s), distance_m=WALK, file="βηματιστής 歩.csv"),
    Case("a name like an option", text(lambda s: s), distance_m=WALK, file="[bold]-o.csv"),
    # -- sensors
    Case("no accelerometer", table(drop(*FORCE)), "accelerometer", 1),
    Case("no gyroscope", table(drop(*RATE)), "gyroscope", 1),
    Case("one axis missing", table(drop("wy")), "wy", 1),
    Case("no time", table(drop("time")), "time", 1),
    Case("no magnetometer, which the method needs", table(drop(*FIELD)), "magnetometer", options=("--method", "maginav")),
    Case("gyroscope all NaN", table(put(RATE, np.nan)), "gyroscope", 1),
    Case("accelerometer all NaN", table(put(FORCE, np.nan)), "accelerometer", 1),
    Case("magnetometer all NaN", table(put(FIELD, np.nan)), "magnetometer", options=("--method", "maginav")),
    Case("magnetometer zero", table(put(FIELD, 0.0)), "magne", options=("--method", "maginav")),
    Case("magnetometer stuck", table(put(FIELD, 30.0)), "magnetometer never changes", options=("--method", "maginav")),
    Case("magnetometer straight down", table(put(("mx", "my"), 0.0)), "", options=("--method", "maginav")),
    Case("everything NaN", table(put((*FORCE, *RATE, *FIELD), np.nan)), "", 1),
    Case("a run of NaN in all", table(put((*FORCE, *RATE), np.nan, slice(330, 380))), "gap"),
    Case("a run of NaN in one axis", table(put(("fy",), np.nan, slice(330, 335))), "left out"),
    Case("NaN at the start", table(put((*FORCE, *RATE), np.nan, slice(0, 60))), distance_m=WALK),
    Case("NaN at the end", table(put((*FORCE, *RATE), np.nan, slice(640, None))), distance_m=WALK),
    Case("accelerometer and gyroscope in turns", table(alternate, rate_hz=400)),
    Case("infinite values", table(put(FORCE, np.inf, slice(300, 303))), "missing values"),
    Case("huge values", table(put(("fx",), 1e300, slice(300, 303))), "beyond anything"),
    Case("huge angular rate", table(put(("wz",), -1e30, slice(300, 301))), "beyond anything"),
    Case("large but possible for a number", table(put(("wz",), 1e8, slice(300, 301))), ""),
    Case("constant", table(put((*FORCE, *RATE), 1.0)), "never changes"),
    Case("all zero", table(put((*FORCE, *RATE, *FIELD), 0.0)), "no direction of gravity", 1),
    Case("gyroscope zero", table(put(RATE, 0.0)), "gyroscope never changes"),
    Case("saturated accelerometer", table(clip(FORCE, 16.0)), "saturat"),
    Case("saturated gyroscope", table(clip(RATE, 3.0)), "saturat"),
    Case("accelerometer in g", table(scale(FORCE, 1 / G)), "--units specific_force=g"),
    Case("accelerometer in g, told", table(scale(FORCE, 1 / G)), options=("--units", "specific_force=g"), distance_m=WALK),
    Case("gyroscope in degrees", table(scale(RATE, 180 / math.pi)), "angular_rate=deg/s"),
    Case("gyroscope in degrees, told", table(scale(RATE, 57.29578)), options=("--units", "angular_rate=deg/s"), distance_m=WALK),
    Case("magnetometer in gauss", table(scale(FIELD, 0.01)), "magnetic_flux_density=G"),
    Case("upside down", table(scale(("fy", "fz", "wy", "wz", "my", "mz"), -1.0)), distance_m=WALK),
    # -- motion
    Case("starts in motion", table(rows(slice(180, None))), ""),
    Case("never stands", table(rows(slice(160, 200))), "No stance", options=("--method", "zupt")),
    Case("never moves", table(rows(slice(0, 140))), distance_m=(0.0, 0.05)),
    # -- time
    Case("one sample", table(rows(slice(0, 1))), "sample", 1),
    Case("two samples", table(rows(slice(0, 2))), ""),
    Case("three samples", table(rows(slice(0, 3))), ""),
    Case("1 Hz", table(rows(slice(None, None, 100))), "too slow"),
    Case("5 kHz", table(lambda c: None, rate_hz=5000, strides=1, rest_s=0.5), distance_m=(1.0, 1.4)),
    Case("time in ms", table(scale(("time",), 1e3)), "time=ms"),
    Case("time in ms, told", table(scale(("time",), 1e3)), options=("--units", "time=ms"), distance_m=WALK),
    Case("UNIX time", table(stamps(lambda t: t + 1.7e9)), distance_m=WALK),
    Case("negative time", table(stamps(lambda t: t - 1000.0)), distance_m=WALK),
    Case("time backwards throughout", table(stamps(lambda t: -t)), "run backwards", 1),
    Case("clock set back in the middle", table(stamps(late_by(-3.0))), "went back"),
    Case("clock starts anew", table(stamps(lambda t: np.where(t > 3.2, t - 3.2, t))), "went back"),
    Case("time stands still", table(stamps(lambda t: 0 * t)), "never advance", 1),
    Case("time all NaN", table(stamps(lambda t: t * np.nan)), "time", 1),
    Case("a few stamps missing", table(stamps(set_value(300, np.nan))), "left out"),
    Case("one wild stamp", table(stamps(set_value(300, 1e9))), "far from its neighbours"),
    Case("a huge stamp", table(stamps(set_value(300, 1e300))), "left out"),
    Case("an infinite stamp", table(stamps(set_value(300, np.inf))), "left out"),
    Case("two rows exchanged", table(stamps(swap)), ""),
    Case("every row twice", table(repeated), "repeat", distance_m=WALK),
    Case("stamps of 50 ms", table(stamps(lambda t: np.floor(t * 20) / 20)), "", distance_m=WALK),
    Case("a gap of a second", table(stamps(late_by(1.0))), "gap"),
    Case("a gap of a minute", table(stamps(late_by(60.0))), "gap"),
    Case("a leap of ten years", table(stamps(late_by(3.15e8))), "leapt ahead"),
    Case("every fifth sample lost", table(lambda c: {k: np.delete(v, slice(0, None, 5)) for k, v in c.items()}), ""),
    # -- the command
    Case("unknown format", text(lambda s: s), 'no format "canonica"', 2, ("--format", "canonica")),
    Case("wrong format", text(lambda s: s), "", 1, ("--format", "pyshoe")),
    Case("unknown unit", text(lambda s: s), "furlong", 2, ("--units", "specific_force=furlong")),
    Case("unknown quantity", text(lambda s: s), "force", 2, ("--units", "force=g")),
    Case("mirrored axes", text(lambda s: s), "mirror", 2, ("--axes", "x,y,-z")),
    Case("column map missing", text(lambda s: s), "map.toml", 2, ("--columns", "map.toml")),
    Case("reference missing", text(lambda s: s), "no such file", 1, ("--reference", "truth.csv")),
]


def run(case: Case, folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    path = folder / case.file
    case.make(path)
    status = main(["track", str(path), "-o", str(folder / "out"), "--no-report", *case.options])
    return status, capsys.readouterr().err


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_broken_recording(case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    status, said = run(case, tmp_path, capsys)
    assert status == case.ends, said
    assert "Traceback" not in said
    assert "unexpected" not in said
    assert case.says.lower() in said.lower()
    left = {path.name for path in tmp_path.iterdir()} - {case.file}
    if status:
        assert not left
        assert len(said.strip().splitlines()) == 1
        assert len(said) < 1500
    else:
        assert left == {"out"}
        check_results(tmp_path / "out", case, said)


def check_results(folder: Path, case: Case, said: str) -> None:
    assert {path.name for path in folder.iterdir()} >= FILES
    summary = json.loads((folder / "summary.json").read_text())
    frame = pl.read_csv(folder / "trajectory.csv")
    assert tuple(frame.columns) == COLUMNS
    assert len(frame) == summary["samples"] > 1
    assert np.isfinite(frame.to_numpy()).all()
    assert (np.diff(frame["time"]) > 0).all()
    assert (frame.select("sd_east", "sd_north", "sd_up").to_numpy() >= 0).all()
    np.testing.assert_allclose(frame.select("qw", "qx", "qy", "qz").to_numpy() ** 2 @ np.ones(4), 1, atol=1e-6)
    for warning in summary["warnings"]:
        assert " ".join(warning.split()) in said
    if case.says:
        assert any(case.says.lower() in warning.lower() for warning in summary["warnings"])
    least, most = case.distance_m
    assert least <= summary["distance_m"] <= most


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """A copy with a part cut off, lost, zeroed, repeated, or with wrong bytes."""
    at, length = int(rng.integers(len(content))), int(rng.integers(1, 3000))
    match rng.integers(5):
        case 0:
            return content[:at]
        case 1:
            return content[:at] + content[at + length :]
        case 2:
            return content[:at] + bytes(length) + content[at + length :]
        case 3:
            return content[:at] + content[max(0, at - length) :]
    wrong = bytearray(content)
    for k in rng.integers(len(content), size=rng.choice([1, 30])):
        wrong[k] = rng.integers(256)
    return bytes(wrong)


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mat"])
def test_damage_at_random(suffix: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Whatever happens to a file on its way, the answer is a trajectory or a paragraph (libraries in C and Rust included)."""
    columns, path, out = walk(), tmp_path / f"walk.{suffix}", tmp_path / "out"
    if suffix == "csv":
        path.write_text(csv(columns))
    elif suffix == "parquet":
        pl.DataFrame(columns).write_parquet(path)
    else:
        imu = np.column_stack([columns[name] for name in (*FORCE, *RATE)])
        savemat(path, {"imu": imu, "ts": columns["time"], "gt": imu[:, :3]})
    whole, rng = path.read_bytes(), np.random.default_rng(11)
    ends = []
    for _ in range(40):
        path.write_bytes(damaged(whole, rng))
        ends.append(main(["track", str(path), "-o", str(out), "--no-report", "-q"]))
        said = capfd.readouterr().err
        assert "unexpected" not in said
        assert len(said.splitlines()) == (ends[-1] != 0)
        assert {p.name for p in tmp_path.iterdir()} <= {path.name, "out"}
    assert set(ends) == {0, 1}


def test_there_are_enough_cases() -> None:
    assert len({case.name for case in CASES}) == len(CASES) >= 45


# -- outputs -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def good(tmp_path: Path) -> Path:
    path = tmp_path / "walk.csv"
    path.write_text(csv(walk()))
    return path


@pytest.mark.parametrize("place", ["taken", "taken/inside", "taken/inside/deep"])
def test_output_that_cannot_be_written(place: str, good: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The output's name, or a folder on the way to it, is a file (which root cannot write into either)."""
    (tmp_path / "taken").write_text("mine")
    assert main(["track", str(good), "-o", str(tmp_path / place), "--no-report"]) == 1
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert len(said.strip().splitlines()) == 1
    assert (tmp_path / "taken").read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {"taken", "walk.csv"}


def test_disk_full_while_writing(good: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    import bematist.cli.results as results

    def full(*_: object, **__: object) -> str:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(results, "to_json", full)
    assert main(["track", str(good), "-o", str(tmp_path / "new" / "out"), "--no-report"]) == 1
    assert "No space left" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"walk.csv"}


def test_a_failure_leaves_the_old_results_alone(good: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["track", str(good), "-o", str(out), "--no-report", "-q"]) == 0
    (out / "notes.txt").write_text("mine")
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    good.write_text(csv(walk())[:-40] + "oops\n")
    assert main(["track", str(good), "-o", str(out), "--no-report", "-q"]) == 1
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    shutil.copy(good, tmp_path / "copy.csv")
    good.write_text(csv(walk(strides=2)))
    assert main(["track", str(good), "-o", str(out), "--no-report", "-q"]) == 0
    assert set(before) == {path.name for path in out.iterdir()}
    assert (out / "notes.txt").read_text() == "mine"
    assert (out / "trajectory.csv").read_bytes() != before["trajectory.csv"]
    assert capsys.readouterr().out == ""


def test_interrupt_leaves_nothing(good: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    import bematist.cli.results as results

    def interrupted(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(results, "to_json", interrupted)
    assert main(["track", str(good), "-o", str(tmp_path / "out"), "--no-report"]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"walk.csv"}
