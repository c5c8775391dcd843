"""Li & Wang's study: numbers of a course, comparisons, and the whole on short courses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from bematist.methods import METHODS
from bematist.reproduce import find_study
from bematist.reproduce.li_wang import recordings, routes
from bematist.reproduce.li_wang.claims import verdict
from bematist.reproduce.li_wang.figures import trailing
from bematist.reproduce.li_wang.pairs import Compared, compare, sign_test
from bematist.reproduce.li_wang.variants import PAIRS, PAPER, VARIANTS
from bematist.reproduce.run import Run
from bematist.reproduce.study import Part
from bematist.simulate import simulate_walk


def short(part: Part) -> Part:
    """The courses cut to 25 m."""
    return replace(part, cases=lambda seeds: [{**s, "changes": {**s["changes"], "length_m": 25.0}} for s in part.cases(seeds)])


def test_end_to_end_without_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("BEMATIST_SHARED", str(tmp_path / "nothing"))
    whole = find_study("li-wang")
    courses, real = whole.parts
    run = Run(replace(whole, parts=(short(courses), real)), tmp_path, seeds=2)
    run.compute()
    text = run.write().read_text()
    assert "No recording was found" in text and "None" not in text and "nan" not in text
    assert text.count("![") == 11
    claims = pl.read_csv(tmp_path / "tables/claims.csv")
    assert len(claims) == 24 and claims["verdict"].null_count() == 0
    assert not [p for p in (tmp_path / "figures").glob("*.png") if p.stat().st_size > 300_000]


def test_a_real_recording(shared_data: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("BEMATIST_SHARED", str(shared_data))
    case = next(c for c in recordings.cases(1) if c["recording"] == "Vicon 12-15")
    found = recordings.compute({**case, "variants": [v for v in case["variants"] if v[0] in ("15zh", "15zha")]})
    fixed, adaptive = found.rows
    assert (fixed["variant"], adaptive["variant"]) == ("15zh", "15zha")
    # A run: the walking threshold misses stances.
    assert adaptive["rms_m"] < 0.3 < fixed["rms_m"]


def test_numbers_of_a_course():
    made = simulate_walk("short", "ideal", 0, length_m=20.0, rate_hz=100.0)
    n = len(made.truth)
    turned = np.array([np.cos(0.05), 0, 0, np.sin(0.05)])  # 0.1 rad about up
    w, z = made.truth.attitude[:, 0], turned[3]
    x, y, u = made.truth.attitude[:, 1:].T
    attitude = np.column_stack([turned[0] * w - z * u, turned[0] * x - z * y, turned[0] * y + z * x, turned[0] * u + z * w])
    packed = np.zeros((n, 18))
    packed[:, 17] = 0.02**2
    shifted = made.truth.position + np.linspace(0, 1, n)[:, None] * [3.0, 4.0, 12.0]
    t = replace(made.truth, attitude=attitude, position=shifted, packed_covariance=packed)
    found = routes.route_numbers(t, made.truth, made.truth)
    assert found["end_m"] == pytest.approx(5.0)
    assert found["yaw_end_deg"] == pytest.approx(np.degrees(0.1))
    assert found["yaw_sd_deg"] == pytest.approx(np.degrees(0.02))
    assert [found[f"heading_{k}_deg"] for k in (1, 2, 3)] == pytest.approx([np.degrees(0.1)] * 3)
    assert found["missed_percent"] == 0 and found["moving_m_s"] == pytest.approx(0, abs=1e-9)


def test_stances_missed_and_moving():
    truth = simulate_walk("short", "ideal", 0, length_m=20.0, rate_hz=100.0).truth
    true = truth.stance_intervals()
    found = np.zeros(len(truth), np.uint8)
    for a, b in true[::2]:
        found[a:b] = 1
    missed = routes.stance_numbers(found, truth)
    assert missed["missed_percent"] == pytest.approx(100 * (len(true) // 2) / len(true))
    assert routes.stance_numbers(1 - truth.stance, truth)["moving_m_s"] > 1
    assert routes.stance_numbers(np.zeros_like(found), truth) == {"missed_percent": 100, "moving_m_s": None}


def test_sign_test_and_comparison():
    assert sign_test(5, 0) == sign_test(0, 5) == pytest.approx(2 / 32)
    assert sign_test(3, 3) == sign_test(0, 0) == 1
    assert sign_test(8, 1) == pytest.approx(2 * 10 / 512)
    a, b = [1.0, -2.0, 3.0, 4.0], [2.0, 3.0, 3.0, -1.0]
    rows = [{"variant": v, "seed": k, "x": x} for v, values in (("a", a), ("b", b)) for k, x in enumerate(values)]
    found = compare(pl.DataFrame(rows), "a", "b", "x")
    assert found == Compared(median=2.5, other=2.5, better=2, worse=1, runs=4)
    assert compare(pl.DataFrame(rows), "a", "c", "x") is None


def test_verdicts_follow_the_counts():
    better, worse, even = (Compared(1, 1, *k, 20) for k in ((20, 0), (0, 20), (10, 10)))
    assert verdict([better, better]) == "holds"
    assert verdict([worse]) == "does not hold, the opposite does"
    assert verdict([even, even]) == "undecided"
    assert verdict([better, worse, even]) == "holds on 1 of 3 courses, the opposite on 1, undecided on 1"


def test_every_variant_is_one_the_methods_know():
    shown = {name: METHODS[method].parameters.override(changes) for name, (method, changes) in VARIANTS.items()}
    assert all(shown[name] == METHODS[name].parameters for name in PAPER)
    assert len({str(p) for p in shown.values()}) == len(VARIANTS)
    for pair in PAIRS:
        assert pair.changed in VARIANTS and pair.base in VARIANTS


def test_trailing_mean_and_maximum():
    values = np.random.default_rng(0).random(300)
    mean, largest = trailing(values, 100)
    assert mean[250] == pytest.approx(values[151:251].mean()) and mean[9] == pytest.approx(values[:10].mean())
    assert largest[250] == pytest.approx(mean[151:251].max()) and largest[50] == pytest.approx(mean[:51].max())
