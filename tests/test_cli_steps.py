"""`bematist steps`: numbers, page, and what it says to a mistake."""

import json
from pathlib import Path

import numpy as np
import pytest

import bematist as bm
from bematist import steps
from bematist.cli import main
from bematist.io.canonical import write_recording
from bematist.report import write_steps_page
from bematist.simulate import simulate_hand
from test_report import decode, page_of, panel


@pytest.fixture(scope="module")
def made():
    return simulate_hand("straight", sensor="phone", seed=5, length_m=120.0, carries=((0.0, "texting"), (60.0, "swinging")))


def test_command(made, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_recording(made.recording, Path("hand.csv"))
    assert main(["steps", "hand.csv"]) == 0
    said = capsys.readouterr().out
    assert "texting" in said and "swinging" in said and "walk(s)" in said
    assert "<html" in Path("hand-steps.html").read_text()[:2000]
    assert main(["steps", "hand.csv", "-o", "page.html", "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert abs(numbers["steps"] - len(made.steps)) <= 2
    assert sum(numbers["motion"].values()) == pytest.approx(1)
    assert sum(numbers["carrying"].values()) == pytest.approx(1)
    assert Path("page.html").is_file()
    assert main(["steps", "hand.csv", "--json", "--set", "steps.detection.least_force=50"]) == 0
    none = json.loads(capsys.readouterr().out)
    assert none["steps"] == 0 and none["frequency_hz"] is None
    for changes, says in ((["detection.periodik=1"], "detection.periodic"), (["modes.run_hz=-1"], "greater than 0")):
        assert main(["steps", "hand.csv", "--set", *changes]) == 2
        assert says in " ".join(capsys.readouterr().err.split())
    assert main(["steps", "hand.csv", "-o", "hand.csv"]) == 2


def test_page(made, tmp_path):
    found = steps.analyse(made.recording)
    write_steps_page(made.recording, found, tmp_path / "s.html")
    _, data = page_of(tmp_path / "s.html")
    keys = [p["key"] for p in data["panels"]]
    assert keys == ["acceleration", "periodicity", "frequency", "modes", "force", "rotation", "stride", "tilt", "climb"]
    marks = next(t for t in panel(data, "acceleration") if t["name"] == "step")
    np.testing.assert_allclose(decode(marks["x"]), found.event_time, atol=1e-4)
    modes = {t["name"]: decode(t["y"]) for t in panel(data, "modes") if t["name"] in ("motion", "carrying")}
    assert set(modes["carrying"]) == {4, 6}  # texting and swinging, behind the four motions
    still = bm.Recording(
        time=made.recording.time[:500], specific_force=made.recording.specific_force[:500], angular_rate=np.zeros((500, 3))
    )
    write_steps_page(still, steps.analyse(still), tmp_path / "none.html")
    assert "Steps · 0" in (tmp_path / "none.html").read_text(encoding="utf-8")
