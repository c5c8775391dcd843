"""`bematist attitude`, and `evaluate` with attitudes."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import bematist as bm
from bematist.cli import main
from bematist.io import write_recording, write_reference
from test_ahrs import turning


@pytest.fixture
def turned(tmp_path: Path) -> Path:
    recording, true = turning(3000)
    write_recording(recording, tmp_path / "turn.csv")
    none = np.zeros((len(true), 3))
    write_reference(bm.Reference(time=recording.time, position=none, attitude=true), tmp_path / "truth.csv")
    return tmp_path


def test_everything_is_written_and_the_configuration_repeats_it(turned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording, truth, out = str(turned / "turn.csv"), str(turned / "truth.csv"), turned / "out"
    given = ["--filter", "mahony", "--set", "kp=0.5", "--compare", "gyro", "--reference", truth, "-o", str(out)]
    assert main(["attitude", recording, *given]) == 0
    assert {p.name for p in out.iterdir()} == {
        *("attitude.csv", "attitude.parquet", "summary.json", "config.toml", "evaluation.json", "report.html")
    }
    shown = capsys.readouterr().out
    assert "mahony" in shown and "gyro" in shown and "tilt rms" in shown
    summary = json.loads((out / "summary.json").read_text())
    assert summary["filter"] == "mahony" and summary["north"] == "magnetic" and summary["samples"] == 3000
    table = pl.read_csv(out / "attitude.csv")
    assert table.columns[:8] == ["time", "qw", "qx", "qy", "qz", "heading_deg", "roll_deg", "pitch_deg"] and len(table) == 3000
    judged = json.loads((out / "evaluation.json").read_text())
    assert [e["filter"] for e in judged] == ["mahony", "gyro"] and judged[0]["attitude_rmse_deg"] < 1
    assert main(["attitude", recording, "--config", str(out / "config.toml"), "-o", str(turned / "again"), "-q"]) == 0
    assert (turned / "again" / "attitude.csv").read_bytes() == (out / "attitude.csv").read_bytes()
    page = (out / "report.html").read_text()
    assert "Error of the vertical" in page and "<script src" not in page


def test_attitudes_are_evaluated(turned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["attitude", str(turned / "turn.csv"), "-o", str(turned / "out"), "--no-report", "-q"]) == 0
    capsys.readouterr()
    for path in (turned / "out", turned / "out" / "attitude.csv"):
        assert main(["evaluate", str(path), str(turned / "truth.csv"), "--align", "none", "--json", "-"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert 0 < found["attitude_rmse_deg"] < 1 and found["rows"] == 3000 and found["filter"] == "madgwick"
    assert main(["evaluate", str(turned / "out"), str(turned / "truth.csv"), "--align", "se3"]) == 2


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["--filter", "madgwik"], 2, 'Did you mean "madgwick"'),
        (["--set", "kp=1"], 2, "kp"),
        (["--compare", "gyro,nothing"], 2, "nothing"),
        (["--align", "origin"], 2, "origin"),
        (["--reference", "missing.csv"], 1, "missing.csv"),
    ],
)
def test_wrong_use_is_one_paragraph(
    turned: Path, arguments: list[str], status: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["attitude", str(turned / "turn.csv"), "-o", str(turned / "out"), *arguments]) == status
    said = capsys.readouterr().err
    assert words in said and "Traceback" not in said and said.strip().count("\n") == 0
    assert not (turned / "out").exists()


def test_a_recording_with_no_attitude_in_its_reference_is_not_judged(turned: Path) -> None:
    recording, _ = turning(1500)
    write_recording(recording, turned / "short.csv")
    path = turned / "path.csv"
    path.write_text("time,east,north\n1,0,0\n2,1,1\n")
    assert main(["attitude", str(turned / "short.csv"), "-o", str(turned / "a"), "--no-report", "-q"]) == 0
    assert not (turned / "a" / "evaluation.json").exists()
    assert main(["attitude", str(turned / "short.csv"), "-o", str(turned / "b"), "--reference", str(path), "-q"]) == 1


def test_pictures(turned: Path) -> None:
    from bematist.report import still_attitude

    recording, true = turning(1500)
    found = [bm.attitude(recording, name) for name in ("gyro", "mahony")]
    truth = bm.Reference(time=recording.time, position=np.zeros((1500, 3)), attitude=true)
    still_attitude(found, turned / "a.png", truth)
    assert (turned / "a.png").stat().st_size > 20_000
    with pytest.raises(bm.UsageError, match="png"):
        still_attitude(found, turned / "a.doc")
    with pytest.raises(bm.UsageError, match="at least one"):
        still_attitude([], turned / "a.png")
