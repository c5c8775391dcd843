"""Studies: computed once, kept, gone on with, the same on one process and on several; and MAGINAV's parts on a walk of a minute."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from bematist.cli import main
from bematist.errors import DataError, UsageError
from bematist.methods import find_method
from bematist.reproduce import find_study, numbers
from bematist.reproduce.maginav import attitude, consistency, sensitivity, timing, walks
from bematist.reproduce.plots import colored, dots, sheet
from bematist.reproduce.run import Run
from bematist.reproduce.store import Store
from bematist.reproduce.study import Case, Claim, Found, Part, Results, Study

SHORT = {"scenario": "short", "changes": {"length_m": 15.0, "rest_s": 3.0}}


def walk(settings):
    """A short walk by one method."""
    if settings.get("slow"):
        time.sleep(0.3)
    return walks.compute({**SHORT, "methods": {settings["method"]: {}}, "seed": settings["seed"]})


def broken(settings):
    if settings["seed"]:
        raise DataError("This seed is no good.")
    return Found([{"value": math.nan}])


def show(results: Results, page) -> None:
    page.spread(
        "rms", results.frame, ["method"], {"rms m": "rms_m", "nothing": "nothing"} if "nothing" in results.frame else {"rms m": "rms_m"}
    )
    figure, (axes,) = sheet()
    dots(axes, {"zupt": results.frame["rms_m"].to_numpy()}, colored(["zupt"]))
    page.figure("dots", figure, "Dots")


def study(*, slow: bool = False, compute=walk) -> Study:
    def cases(seeds):
        return [{"method": "zupt", "seed": s, "slow": slow} for s in range(seeds)]

    part = Part("tiny", "A tiny part", cases, compute, show, 1.0)
    other = Part("other", "Another", lambda seeds: [{"method": "foot", "seed": 0}], walk, show, 1.0, alone=True)
    return Study(
        "tiny", "A tiny study", "nobody", (), (part, other), lambda found: [Claim("c", "p", f"{len(found)} parts", "v", "w")], seeds=2
    )


def test_a_study_end_to_end(tmp_path: Path):
    run = Run(study(), tmp_path)
    assert (run.done, run.total) == (0, 3)
    shares: list[float] = []
    run.compute(1, shares.append)
    assert shares == pytest.approx([1 / 3, 2 / 3, 1])
    report = run.write()
    text = report.read_text()
    assert "2 parts" in text and "(figures/dots.png)" in text and "| zupt |" in text
    for name in ("tables/rms.md", "tables/rms.csv", "tables/claims.csv", "tables/tiny-cases.csv", "figures/dots.png", "figures/dots.svg"):
        assert (tmp_path / name).stat().st_size > 0, name
    summary = pl.read_csv(tmp_path / "tables/rms.csv").row(0, named=True)
    assert summary["method"] == "foot" and summary["runs"] == 1  # written last, by the second part
    rms = pl.read_csv(tmp_path / "tables/tiny-cases.csv")["rms_m"]
    assert len(rms) == 2 and rms[0] != rms[1] and (rms < 1).all()
    assert not list(tmp_path.rglob(".bematist*"))


def test_only_what_is_missing_is_computed(tmp_path: Path):
    Run(study(), tmp_path).compute()
    assert Run(study(), tmp_path).done == 3
    more = Run(study(), tmp_path, seeds=3)
    assert (more.done, more.total, more.stale) == (3, 4, 0)
    one = Run(study(), tmp_path, only=["other"], fresh=True)
    assert (one.done, one.total, one.stale) == (0, 1, 1)
    assert Run(study(), tmp_path, only=["tiny"]).done == 2


def test_other_settings_and_other_code_are_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    Run(study(), tmp_path).compute()
    assert Run(study(slow=True), tmp_path).done == 1  # the part that did not change
    monkeypatch.setattr("bematist.reproduce.store.code", lambda module: "another version")
    run = Run(study(), tmp_path)
    assert (run.done, run.stale) == (0, 3)
    assert not list((tmp_path / "cases").glob("*.npz"))


def test_a_line_that_was_cut_off_is_computed_again(tmp_path: Path):
    Run(study(), tmp_path).compute()
    file = tmp_path / "cases" / "tiny.jsonl"
    first, second = file.read_text().splitlines(keepends=True)
    file.write_text(first + second[:40])
    run = Run(study(), tmp_path)
    assert run.done == 2
    run.compute()
    assert sorted(file.read_text().splitlines()) == sorted(map(_timeless(file), (first, second)))
    run.write()


def _timeless(file: Path):
    # The lines as they are now, found by their stamps: all but the time it took must be as before.
    now = {json.loads(line)["stamp"]: line for line in file.read_text().splitlines()}

    def same(line: str) -> str:
        before, after = json.loads(line), json.loads(now[json.loads(line)["stamp"]])
        assert {**before, "seconds": 0} == {**after, "seconds": 0}
        return now[before["stamp"]]

    return same


def stored(folder: Path) -> dict[str, tuple[str, dict[str, np.ndarray]]]:
    """Rows and arrays of the cases by their stamps."""
    records = [json.loads(line) for file in (folder / "cases").glob("*.jsonl") for line in file.read_text().splitlines()]
    found = {}
    for r in records:
        with np.load(folder / "cases" / f"{r['part']}-{r['stamp']}.npz") as arrays:
            found[r["stamp"]] = (json.dumps(r["rows"]), dict(arrays))
    return found


def test_processes_give_the_same_bits(tmp_path: Path):
    for jobs in (1, 2):
        Run(study(), tmp_path / str(jobs)).compute(jobs)
    serial, parallel = stored(tmp_path / "1"), stored(tmp_path / "2")
    assert serial.keys() == parallel.keys() and len(serial) == 3
    for stamp, (rows, arrays) in serial.items():
        assert parallel[stamp][0] == rows
        assert all(np.array_equal(parallel[stamp][1][name], a) for name, a in arrays.items())


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_interruption_keeps_what_is_finished(tmp_path: Path, jobs: int):
    def stop(share: float) -> None:
        raise KeyboardInterrupt

    run = Run(study(slow=True), tmp_path, seeds=4, only=["tiny"])
    with pytest.raises(KeyboardInterrupt):
        run.compute(jobs, stop)
    assert run.done == 1
    again = Run(study(slow=True), tmp_path, seeds=4, only=["tiny"])
    assert again.done == 1
    again.compute(jobs)
    assert again.done == 4


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_case_that_fails_is_named_and_the_others_are_kept(tmp_path: Path, jobs: int):
    run = Run(study(compute=broken), tmp_path, only=["tiny"])
    with pytest.raises(DataError, match=r"tiny, .*seed 1.* This seed is no good"):
        run.compute(jobs)
    assert Run(study(compute=broken), tmp_path, only=["tiny"]).done <= 1


def test_numbers_that_are_none_are_left_out(tmp_path: Path):
    store, case = Store(tmp_path), Case(study(compute=broken).parts[0], {"seed": 0})
    store.open([case.part])
    store.put(case, Found([{"value": math.nan}]), 0.1)
    result = store.get(case)
    assert result is not None and result.rows == [{"value": None}] and result.arrays == {}


def test_unknown_names_are_refused(tmp_path: Path):
    with pytest.raises(UsageError, match='Did you mean "maginav"'):
        find_study("maginaw")
    with pytest.raises(UsageError, match='Did you mean "tiny"'):
        Run(study(), tmp_path, only=["tinny"])
    with pytest.raises(UsageError, match="at least one seed"):
        Run(study(), tmp_path, seeds=0)


def test_the_command_lists_and_refuses(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    assert main(["reproduce"]) == 0
    said = capsys.readouterr().out
    assert all(part.name in said for part in find_study("maginav").parts)
    assert main(["reproduce", "maginaw", "-o", str(tmp_path)]) == 2
    assert 'Did you mean "maginav"' in capsys.readouterr().err
    assert main(["reproduce", "maginav", "-o", str(tmp_path), "--only", "walk"]) == 2
    assert 'Did you mean "walks"' in capsys.readouterr().err


def test_ctrl_c_is_one_line_and_130(tmp_path: Path):
    command = [
        sys.executable,
        "-m",
        "bematist",
        "reproduce",
        "maginav",
        "--only",
        "walks",
        "--seeds",
        "2",
        "--jobs",
        "2",
        "-o",
        str(tmp_path),
    ]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stderr is not None
    first = process.stderr.readline()
    assert first.startswith("bematist: 4 cases; about")
    time.sleep(1.0)
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=60)[1].splitlines()
    assert process.returncode == 130, said
    assert len(said) == 1 and said[0].startswith("bematist: interrupted; 0 of 4 cases are kept"), said


# -- MAGINAV ---------------------------------------------------------------------------------------------------------------------------


def tiny(part: Part) -> Part:
    """The part on few and short walks."""
    few = {"rounds": 2, "hours": 0.05, "every_s": 5.0}

    def cases(seeds: int):
        made = []
        for s in part.cases(seeds):
            s = {k: few.get(k, v) for k, v in s.items()}
            if "scenario" in s:
                s |= {"scenario": "short", "changes": {**s["changes"], "length_m": 20.0}}
            made.append(s)
        return made

    return replace(part, cases=cases)


def test_maginav_end_to_end(tmp_path: Path):
    """All parts, tables and figures, on walks of half a minute."""
    whole = find_study("maginav")
    run = Run(replace(whole, parts=tuple(map(tiny, whole.parts))), tmp_path, seeds=2)
    run.compute()
    text = run.write().read_text()
    assert text.count("![") >= 10 and "None" not in text and "nan" not in text
    assert text.count("|---|") >= 6
    pictures = [p for p in (tmp_path / "figures").iterdir() if p.stat().st_size > 300_000]
    assert not pictures


def test_triad_bounds_the_attitude_and_the_gyroscope_does_not():
    found = attitude.compute({"seed": 0, "bias": "bias instability", "hours": 0.5, "every_s": 5.0})
    rows = {r["attitude"]: r for r in found.rows}
    # 8.63 °/h for half an hour, with an angle random walk of 0.017 °/√s · √1800 s = 0.72°
    assert rows["gyroscope"]["roll_last_deg"] == pytest.approx(4.3, abs=2.2)
    # 226 µg/√Hz at 238 Hz over g, and 0.079 µT/√Hz at 80 Hz over the horizontal field, with the tilt's share of tan 53°
    assert rows["TRIAD"]["roll_rms_deg"] == pytest.approx(math.degrees(226e-6 * math.sqrt(238)), rel=0.15)
    yaw = math.degrees(
        math.hypot(0.079 * math.sqrt(80) / (46 * math.cos(math.radians(53))), math.tan(math.radians(53)) * 226e-6 * math.sqrt(238))
    )
    assert rows["TRIAD"]["yaw_rms_deg"] == pytest.approx(yaw, rel=0.15)


def test_undisturbed_means_what_it_says():
    """Between the two walks of a seed nothing differs but the field, which keeps its norm where nothing is there."""
    norm = {}
    for walk_name, changes in walks.WALKS.items():
        recording = walks.simulate_walk(
            "campus", "lsm9ds1", 0, length_m=600.0, magnetic_noise_density=0.0, magnetic_lsb=0.0, **changes
        ).recording
        norm[walk_name] = np.linalg.norm(recording.magnetic_flux_density, axis=1), recording.specific_force
    assert np.ptp(norm["undisturbed"][0]) < 1e-6 and np.ptp(norm["disturbed"][0]) > 5
    assert np.array_equal(norm["undisturbed"][1], norm["disturbed"][1])


def test_closure_and_rms_are_what_they_are_called():
    made = walks.simulate_walk("short", "ideal", 0, length_m=20.0)
    truth = numbers.thinned(made.truth)
    shifted = replace(made.truth, position=made.truth.position + np.linspace(0, 1, len(made.truth))[:, None] * [3.0, 4.0, 12.0])
    e = numbers.judged(shifted, truth)
    found = numbers.walk_numbers(shifted, e)
    assert found["closure_m"] == pytest.approx(5.0, abs=1e-6)
    assert found["height_m"] == pytest.approx(12.0, rel=0.01)
    assert found["rms_m"] == pytest.approx(5 / math.sqrt(3), rel=0.01)
    assert numbers.error_along(e, truth)[-1, 0] == pytest.approx(20.0, rel=0.05)


def test_nees_of_a_known_error():
    made = consistency.simulate_walk("short", "ideal", 0, length_m=20.0)
    n = len(made.truth)
    packed = np.tile([4.0, 0, 0, 1.0, 0, 0.25, 1, 0, 0, 1, 0, 1, 1, 0, 0, 1, 0, 1], (n, 1))
    t = replace(made.truth, position=made.truth.position + np.array([2.0, 1.0, 0.5]), packed_covariance=packed)
    found = consistency.nees_along(t, made.truth, 5)
    assert found[:, 0] == pytest.approx(3.0) and found[:, 1:] == pytest.approx(0.0, abs=1e-12)


def test_every_variant_is_one_the_methods_know():
    for settings in sensitivity.cases(1):
        labels = [(m, c, v) for m, c, v, _ in settings["variants"]]
        assert len(set(labels)) == len(labels)
        for method, choice, _, changes in settings["variants"]:
            shipped = find_method(method).parameters
            assert (shipped.override(changes) == shipped) is (choice == sensitivity.BASELINE)
    assert {m for s in (*walks.cases(1), *timing.cases(1)) for m in s["methods"]} >= {"maginav", "madgwick-zupt", "mahony-zupt"}


def test_one_walk_has_no_quantiles(tmp_path: Path):
    run = Run(study(), tmp_path, seeds=1)
    run.compute(1)
    text = run.write().read_text()
    assert "that walk's own number" in text and " – " not in text.split("| zupt |")[1].split("\n")[0]
