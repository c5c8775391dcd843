"""Calibration of the step length: walks whose parameters are known come back, and what cannot be told is said."""

import dataclasses
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

import bematist as bm
from bematist import step_length
from bematist.cli import main
from bematist.hand.path_parameters import StepLengthParameters
from bematist.io import write_recording
from bematist.simulate import simulate_hand
from bematist.step_length import StepLengthCalibration, Stretches, calibrate_steps, solve

TRUE = np.array([0.16, 0.12, 0.08])
PUBLISHED = StepLengthParameters()


def walk(seed, height, gait="walk", length_m=120.0):
    a, b, c = TRUE
    return simulate_hand(
        "short", "texting", "phone", seed=seed, length_m=length_m, height_m=height, step_a=a, step_b=b, step_c=c, gait=gait
    ).recording


def stretches(seed, heights, frequencies, n=40, steps=15, sd=0.03):
    """Stretches of walkers who keep exactly to eq 47, but for each step's own scatter."""
    rng = np.random.default_rng(seed)
    columns, length = [], []
    for h in heights:
        for _ in range(n):
            f = rng.uniform(*frequencies) + 0.05 * rng.standard_normal(steps)
            s = (h * (TRUE[0] * f + TRUE[1]) + TRUE[2]) * (1 + sd * rng.standard_normal(steps))
            columns.append([h * f.sum(), h * steps, steps])
            length.append(s.sum() + 0.3 * np.sqrt(2) * rng.standard_normal())
    k = len(length)
    return Stretches(np.array(columns, float), np.array(length), np.full(k, float(steps)))


def test_walkers_of_two_heights_tell_all_three():
    errors, biased = [], []
    for seed in range(40):
        found = solve(stretches(seed, (1.55, 1.7, 1.95), (1.3, 2.2)), "full", None)
        e = np.array([found.a, found.b, found.c]) - TRUE
        errors.append(e @ np.linalg.solve(found.covariance, e))
        biased.append(e)
    assert np.mean(errors) == pytest.approx(3, rel=0.5)  # the covariance is that of the errors
    assert np.abs(np.mean(biased, 0)).max() < 0.02


def test_one_walker_cannot():
    s = stretches(0, (1.7,), (1.3, 2.2))
    with pytest.raises(bm.DataError, match="rank 2"):
        solve(s, "full", 1.7)
    found = solve(s, "auto", 1.7)
    assert found.model == "line" and found.b == 0 and any("b = 0" in w for w in found.warnings)
    for f in (1.4, 1.8, 2.1):  # for this walker the line is as good as the three
        assert found.length(f, 1.7) == pytest.approx(1.7 * (TRUE[0] * f + TRUE[1]) + TRUE[2], abs=0.01)


def test_one_pace_tells_the_scale_only():
    s = stretches(0, (1.7,), (1.79, 1.80))
    found = solve(s, "auto", 1.7)
    assert found.model == "scale" and found.a / found.b == pytest.approx(PUBLISHED.a / PUBLISHED.b)
    true = 1.7 * (TRUE[0] * 1.795 + TRUE[1]) + TRUE[2]
    assert found.length(1.795, 1.7) == pytest.approx(true, abs=4 * found.factor_sd * true)
    assert any("pace" in w for w in found.warnings)


@pytest.fixture(scope="module")
def found() -> StepLengthCalibration:
    walks = [walk(seed, h, gait) for seed, (h, gait) in enumerate([(1.58, "slow"), (1.58, "brisk"), (1.92, "slow"), (1.92, "brisk")])]
    return calibrate_steps(walks, heights=[1.58, 1.58, 1.92, 1.92])


def test_simulated_walkers_are_recovered(found):
    """With the detector's own steps and the filter's own directions."""
    assert found.model == "full"
    for f, h in ((1.4, 1.6), (1.8, 1.75), (2.0, 1.9)):
        assert found.length(f, h) == pytest.approx(h * (TRUE[0] * f + TRUE[1]) + TRUE[2], rel=0.03)
    sds = np.sqrt(np.diag(found.covariance))
    assert (np.abs(np.array([found.a, found.b, found.c]) - TRUE) < 4 * sds + 0.02).all()


def test_a_known_distance_gives_the_scale():
    r = walk(5, 1.75)
    calibrated = calibrate_steps(r, distances=120.0, heights=1.75)
    assert calibrated.model == "scale" and calibrated.stretches == 1
    t = bm.track(r, "hand", step_length=calibrated.parameters())
    assert t.distance_m == pytest.approx(120.0, rel=1e-6)
    assert abs(bm.track(r, "hand").distance_m - 120.0) > 5


def test_stairs_and_runs_keep_their_own_lengths(monkeypatch):
    """A known distance is that of all steps; only the walking ones are fitted."""
    r = walk(5, 1.75)
    t = bm.track(r, "hand")
    steps = t.steps
    climbed = np.arange(len(steps)) % 3 == 0
    own = dataclasses.replace(steps, motion=np.where(climbed, "stairs", "walking"), length=np.where(climbed, PUBLISHED.tread, steps.length))
    monkeypatch.setattr(step_length, "track", lambda *_: dataclasses.replace(t, steps=own))
    walked = PUBLISHED.a * 1.75 * steps.frequency + PUBLISHED.b * 1.75 + PUBLISHED.c
    distance = 1.1 * walked[~climbed].sum() + PUBLISHED.tread * climbed.sum()
    found = calibrate_steps(r, distances=distance, heights=1.75)
    assert found.factor == pytest.approx(1.1, rel=1e-9) and found.steps == (~climbed).sum()
    with pytest.raises(bm.DataError, match="stairs"):
        calibrate_steps(r, distances=1.0)


def test_another_walk_of_the_same_walker_is_less_sure_than_the_fit():
    long = solve(Stretches(np.array([[900.0, 875.0, 500.0]]), np.array([350.0]), np.array([500.0])), "scale", 1.75)
    assert long.factor_sd < 0.01 and long.parameters()["scale_sd"] == pytest.approx(np.hypot(long.factor_sd, 0.03))


def test_mistakes_are_told():
    r = walk(5, 1.75)
    with pytest.raises(bm.UsageError, match="2 heights"):
        calibrate_steps(r, heights=[1.7, 1.8])
    with pytest.raises(bm.UsageError, match="for a shoe"):
        calibrate_steps(r, method="foot")
    with pytest.raises(bm.UsageError, match="model"):
        calibrate_steps(r, model="fall")
    with pytest.raises(bm.DataError, match="no reference and no distance"):
        calibrate_steps(r.replace(reference=None))
    with pytest.raises(bm.UsageError, match="above zero"):
        calibrate_steps(r, distances=-3.0)


def test_the_command_and_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    write_recording(walk(5, 1.75), "walk.csv")
    assert main(["step-length", "walk.csv", "--distance", "120", "--height", "1.75", "--json", "-o", "me.toml", "-q"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["model"] == "scale" and shown["a"] == tomllib.loads(Path("me.toml").read_text())["parameters"]["step_length"]["a"]
    assert main(["track", "walk.csv", "-m", "hand", "--config", "me.toml", "-o", "out", "--no-report", "-q"]) == 0
    assert json.loads(Path("out/summary.json").read_text())["distance_m"] == pytest.approx(120, rel=1e-3)
    assert main(["step-length", "walk.csv", "walk.csv", "--distance", "120"]) == 2
    assert main(["step-length", "walk.csv", "-o", "walk.csv"]) == 2
