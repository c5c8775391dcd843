"""The report without a browser: what is drawn, how much of it, and that all text is harmless."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bematist.errors import DataError, UsageError
from bematist.evaluate import evaluate
from bematist.recording import Recording, Reference
from bematist.report import still_path, write_report, write_stance_page
from bematist.report.decimate import envelope, extreme_indices, path_indices
from bematist.report.overlay import Overlay, evaluate_all, overlay
from bematist.report.panels import continuous, panels
from bematist.report.plan import plan
from bematist.report.subject import subjects
from bematist.report.traces import encode, shading
from bematist.stance import StanceParameters, analyse
from report_cases import reference, turned, walk

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>&\"'"


def page_of(path: Path) -> tuple[str, dict[str, Any]]:
    """The page without plotly.js and its data."""
    text = path.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="page-data">(.*?)</script>', text, re.S)
    assert found
    return text[: text.index("plotly.js v")], json.loads(found[1])


def decode(array: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(array["bdata"]), "<" + array["dtype"])


def panel(data: dict[str, Any], key: str) -> list[dict[str, Any]]:
    return next(p["traces"] for p in data["panels"] if p["key"] == key)


ALL = ["height", "speed", "tilt", "heading", "uncertainty", "stance", "pace", "innovation", "nis", "zaru", "hdr", "field"]
ALL += ["inclination", "maru", "gyro-bias", "accel-bias"]

# ---- decimation ----------------------------------------------------------------------------------------------------------


@given(hnp.arrays(float, st.integers(1, 500), elements=st.floats(-10, 10) | st.just(np.nan)), st.integers(2, 60))
@settings(max_examples=150, deadline=None)
def test_decimation_keeps_extremes_ends_and_order(y: np.ndarray, n: int) -> None:
    k = extreme_indices(y, n)
    assert k[0] == 0 and k[-1] == len(y) - 1 and (np.diff(k) > 0).all()
    assert len(k) <= max(n + 2, 4)
    if np.isfinite(y).any():
        assert np.nanmax(y[k]) == np.nanmax(y) and np.nanmin(y[k]) == np.nanmin(y)


def test_decimation_keeps_one_sample_spikes_and_gaps() -> None:
    y = np.sin(np.arange(100_000) / 3000)
    y[77_777], y[12_345] = 50, -40
    y[30_000:40_000] = np.nan
    k = extreme_indices(y, 2000)
    assert {77_777, 12_345} <= set(k)
    assert np.isnan(y[k][(k >= 31_000) & (k < 39_000)]).all()
    assert (np.isnan(y[k]) & (k >= 31_000)).any()


def test_envelope_covers_the_band() -> None:
    rng = np.random.default_rng(0)
    low = rng.standard_normal(10_001)
    high = low + 1
    k, a, b = envelope(low, high, 100)
    bucket = np.searchsorted(k, np.arange(10_000), "right") - 1
    assert (a[bucket] <= low[:-1]).all() and (b[bucket] >= high[:-1]).all() and len(k) <= 102


def test_path_keeps_its_shape() -> None:
    t = np.linspace(0, 60 * np.pi, 200_000)
    p = np.stack([t * np.cos(t), t * np.sin(t)], -1)
    k = path_indices(p, 3000)
    assert len(k) <= 3000
    # Every point of the path lies near the line that is drawn.
    drawn = np.stack([np.interp(np.arange(len(p)), k, p[k, j]) for j in (0, 1)], -1)
    assert np.linalg.norm(p - drawn, axis=1).max() < 0.01 * np.ptp(p)


def test_path_with_rests_keeps_its_corners() -> None:
    steps = np.cumsum(np.tile([[1.0, 0.0], [0.0, 1.0]], (20, 1)), axis=0)
    p = np.repeat(steps, 30, axis=0)  # a foot that stands for 30 samples after each step
    k = path_indices(p, 50)
    assert len(k) == 40 and (p[k] == steps).all()


def test_path_of_one_place_and_of_nothing() -> None:
    assert len(path_indices(np.zeros((50_000, 2)), 100)) <= 100
    assert len(path_indices(np.full((10, 2), np.nan), 100)) == 0
    assert path_indices([[0.0, 0.0]], 100).tolist() == [0]


def test_time_of_a_long_recording_keeps_its_milliseconds() -> None:
    t = 86_400 + np.arange(1000) / 238
    assert abs(decode(encode(t)) - t).max() < 1e-4
    assert encode(t - 86_400)["dtype"] == "f4"


def test_angles_do_not_jump_and_a_swing_over_the_top_leaves_nothing_behind() -> None:
    turn = np.linspace(350, 370, 100)
    stances = np.array([[0, 10], [90, 100]])
    assert abs(continuous(turn % 360, stances) - turn).max() < 1e-9
    jumpy = np.zeros(100)
    jumpy[40:44] = [100, 179, -179, -90]  # round once, as yaw does where the pitch is upright
    found = continuous(jumpy, stances)
    assert found[90] == 0
    drawn = found[np.isfinite(found)]
    assert 1 <= np.isnan(found).sum() <= 4 and abs(np.diff(found))[np.isfinite(np.diff(found))].max() <= 90 and len(drawn) >= 96


def test_shading_is_the_stance() -> None:
    t = np.arange(10.0)
    trace = shading([[0, 3], [7, 10]], t, "@stance")
    assert decode(trace["x"]).tolist() == [0, 0, 3, 7, 9, 9]
    assert decode(trace["y"]).tolist() == [0, 1, 0, 1, 1, 1]


# ---- which panels there are ------------------------------------------------------------------------------------------------


def test_all_panels_with_all_diagnostics() -> None:
    assert [p.key for p in panels(subjects([walk()]))] == ALL


def test_what_a_handheld_filter_judged_has_its_panels() -> None:
    n = 5000
    verdict = np.where(np.arange(n) % 4 == 0, np.arange(n) // 1000 + 1, 0)
    tried = np.where(verdict == 2, 2.5, np.nan)
    judged = {"magnetic_verdict": verdict, "force_verdict": verdict, "force_nis": tried, "heading_innovation": 0.1 * tried}
    found = {p.key: p for p in panels(subjects([walk(diagnostics=judged)]))}
    assert [k for k in found if k not in ALL] == ["verdict", "field-nis", "earth-heading"]
    assert [t["name"] for t in found["verdict"].traces] == ["magnetic field", "specific force"]
    assert set(decode(found["verdict"].traces[0]["y"])) == {1, 2, 3, 4, 5}
    assert np.allclose(decode(found["earth-heading"].traces[0]["y"]), np.degrees(0.25))
    assert found["field-nis"].traces[0]["name"] == "specific force" and len(found["field-nis"].traces) == 2


def test_no_magnetometer_no_magnetic_panels() -> None:
    keys = [p.key for p in panels(subjects([walk(magnetometer=False)]))]
    assert keys == [k for k in ALL if k not in ("field", "inclination", "maru")]


def test_without_diagnostics_and_covariance_the_path_remains(tmp_path: Path) -> None:
    t = walk(diagnostics={}, packed_covariance=np.full((5000, 18), np.nan), parameters={})
    write_report([t], tmp_path / "r.html")
    text, data = page_of(tmp_path / "r.html")
    assert [p["key"] for p in data["panels"]] == ["height", "speed", "tilt", "heading"]
    assert [x["name"] for x in data["plan"] if "name" in x] == ["path", "stance", "start", "end"]
    assert "Parameters used" not in text


@pytest.mark.parametrize("n", [1, 2, 3, 30])
def test_very_short(tmp_path: Path, n: int) -> None:
    write_report([walk(n) if n > 1 else _first(walk(30))], tmp_path / "r.html")
    assert (tmp_path / "r.html").stat().st_size > 4e6


def _first(t: Any) -> Any:
    rows = {k: v[:1] for k, v in vars(t).items() if isinstance(v, np.ndarray)}
    return walk(30, **rows, diagnostics={k: v[:1] for k, v in t.diagnostics.items() if len(v) > 2})


def test_gate_decisions_are_drawn_apart_and_completely() -> None:
    t = walk(3000)
    traces = {x.get("name"): x for x in next(p for p in panels(subjects([t])) if p.key == "field").traces}
    gate, norm = t.diagnostics["magnetic_gate"], t.diagnostics["magnetic_norm"]
    for code, name in ((1, "refused: norm"), (2, "refused: inclination"), (3, "refused: innovation"), (4, "used")):
        expected = norm[(gate == code) & np.isfinite(norm)]
        assert decode(traces[name]["y"]).tolist() == expected.tolist()
    assert decode(traces["gate"]["y"])[0] == pytest.approx(48 * 1.05)


def test_biases_in_the_units_of_their_axis() -> None:
    found = {p.key: p for p in panels(subjects([walk()]))}
    x = next(t for t in found["gyro-bias"].traces if t.get("name") == "x")
    assert found["gyro-bias"].axis == "bias (°/s)" and decode(x["y"])[0] == pytest.approx(np.degrees(2e-3), rel=1e-5)
    low, high = (decode(t["y"])[0] for t in found["gyro-bias"].traces[:2])
    assert high - low == pytest.approx(6 * np.degrees(1e-4), rel=1e-3)


def test_ellipse_holds_95_percent() -> None:
    t = walk()
    outline = next(x for x in plan(subjects([t]), None, Overlay((None,))) if x.get("name") == "95 % ellipse")
    x, y = decode(outline["x"])[-50:-1], decode(outline["y"])[-50:-1]
    P = t.covariance[-1, :2, :2]
    d = np.stack([x, y], -1) - t.position[-1, :2]
    assert np.einsum("ni,ij,nj->n", d, np.linalg.inv(P), d) == pytest.approx(np.full(49, 5.991), rel=1e-2)


def test_the_time_of_a_point_of_the_path() -> None:
    t = walk(40_000)
    path = next(x for x in plan(subjects([t]), None, Overlay((None,))) if x.get("meta") == "path")
    at = decode(path["customdata"])
    assert (np.diff(at) > 0).all()
    east = np.interp(t.time, at, decode(path["x"]))
    assert abs(east - t.position[:, 0]).max() < 0.1  # metres: the cursor of the page stands where the foot was


# ---- the page --------------------------------------------------------------------------------------------------------------


def test_twenty_minutes_are_small_quick_and_keep_extremes(tmp_path: Path) -> None:
    t = walk(285_600)
    t.velocity[123_456] = [0, 0, 99.0]
    write_report([t], tmp_path / "r.html")
    assert (tmp_path / "r.html").stat().st_size < 10e6
    _, data = page_of(tmp_path / "r.html")
    speed = panel(data, "speed")[0]
    assert decode(speed["y"]).max() == 99 and len(decode(speed["y"])) <= 20_002
    assert decode(speed["x"])[decode(speed["y"]).argmax()] == pytest.approx(t.time[123_456], abs=1e-3)
    stances = decode(panel(data, "stance")[0]["x"])
    assert len(stances) == 2 + 2 * len(t.stance_intervals())


def test_several_methods_small_and_told_apart(tmp_path: Path) -> None:
    a = walk(60_000)
    many = [a, turned(a, 1.0), walk(60_000), turned(a, 2.0)]
    write_report(many, tmp_path / "r.html")
    assert (tmp_path / "r.html").stat().st_size < 10e6
    text, data = page_of(tmp_path / "r.html")
    names = [x["name"] for x in data["plan"] if x.get("meta") == "path"]
    assert names == ["maginav (1)", "zupt (1)", "maginav (2)", "zupt (2)"]
    assert "Methods side by side" in text and all(text.count(n) >= 2 for n in names)
    assert len({x["line"]["color"] for x in panel(data, "speed")}) == 4


def test_reference_is_laid_over_and_its_alignment_named(tmp_path: Path) -> None:
    a = walk()
    b = turned(a, 1.0)
    truth = reference(turned(a, -0.7))
    found = [evaluate(t, truth) for t in (a, b)]
    write_report([a, b], tmp_path / "r.html", truth, found)
    text, data = page_of(tmp_path / "r.html")
    paths = [x for x in data["plan"] if x.get("meta") == "path"]
    first = decode(paths[0]["x"]), decode(paths[0]["y"])
    ref = next(x for x in data["plan"] if x.get("name") == "reference")
    # Turned walks, each aligned with the reference, lie on one another; the best fitting one stays in its own frame.
    assert np.hypot(first[0][0], first[1][0]) == pytest.approx(0, abs=1e-6) or "those of zupt" in text
    for other in (paths[1], ref):
        assert abs(decode(other["x"])[-1] - first[0][-1]) < 0.05 and abs(decode(other["y"])[-1] - first[1][-1]) < 0.05
    assert "The axes are the path&#x27;s own, for nothing tells North" in text
    write_report([walk(north="given")], tmp_path / "given.html")
    assert "clockwise from the path&#x27;s own north" in text
    given = page_of(tmp_path / "given.html")[0]
    assert "Up is North, by the heading that was given" in given and "clockwise from north" in given
    assert "by alignment yaw" in text and "ATE RMSE, plan [yaw]" in text and "Error in plan, rms [yaw]" in text


def test_a_left_handed_reference_is_mirrored_for_all_paths_or_for_none() -> None:
    a = walk()
    bend = np.linspace(0, 2, len(a))[:, None] ** 2
    image = turned(walk(position=a.position * [1, -1, 1] + bend * [0.02, 0.05, 0]), 0.5)
    truth = Reference(time=a.time, position=a.position * [1, -1, 1], mirrored=True)
    found = evaluate_all([image, a], truth)
    assert [e.alignment.mirrored for e in found if e] == [False, True]
    laid = overlay([image, a], truth, found)
    assert laid.anchor == 1 and [x.mirrored for x in laid.alignments if x] == [True, True]
    local = laid.reference(truth)
    assert local and abs(local.position - a.position).max() < 1e-6
    p, _ = laid.path(0, image.position, image.covariance[:1])
    assert np.linalg.det(np.cov((p - p.mean(0))[:, :2].T)) == pytest.approx(np.linalg.det(np.cov(image.position[:, :2].T)), rel=1e-6)


def test_a_reference_of_another_time_is_shown_as_it_stands(tmp_path: Path) -> None:
    truth = Reference(time=np.array([9000.0, 9001.0]), position=np.array([[0.0, 0, 0], [1, 1, 0]]))
    write_report([walk()], tmp_path / "r.html", truth)
    text, data = page_of(tmp_path / "r.html")
    assert "not aligned" in text and any(x.get("name") == "reference" for x in data["plan"])


def test_the_reference_height_begins_with_the_path() -> None:
    t = walk()
    truth = Reference(time=t.time[500:], position=t.position[500:] + np.array([0, 0, 7.0]))
    found = next(p for p in panels(subjects([t]), truth) if p.key == "height")
    ref = next(x for x in found.traces if x.get("name") == "reference")
    assert decode(ref["y"])[0] == pytest.approx(t.position[500, 2], abs=1e-6) and "first instant" in found.note


def test_text_cannot_break_out(tmp_path: Path) -> None:
    t = walk(method=HOSTILE, source=f"/a/{HOSTILE}", warnings=(HOSTILE,), parameters={HOSTILE: {"a": HOSTILE}})
    write_report([t, t], tmp_path / "r.html")
    whole = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "<img" not in whole[: whole.index("plotly.js v")]
    text, _ = page_of(tmp_path / "r.html")
    assert "<script>alert" not in whole and "<img src=x" not in text and "&lt;script&gt;" in text
    tail = whole[whole.index('id="page-data"') :]
    assert "<img" not in tail and tail.count("</script>") == 2


def test_summary_and_warnings_are_on_the_page(tmp_path: Path) -> None:
    t = walk(warnings=("The clock ran backwards twice.",))
    write_report([t], tmp_path / "r.html")
    text, _ = page_of(tmp_path / "r.html")
    shown = re.sub(r"\s", " ", text)
    assert f"{t.distance_m:.1f} m" in shown and "The clock ran backwards twice." in shown
    assert "norm_tolerance" in shown and f"{100 * t.stance.mean():.1f} %" in shown


def test_a_warning_says_which_method_it_is_about(tmp_path: Path) -> None:
    a = walk(warnings=("Both.", "One."))
    write_report([a, walk(warnings=("Both.",), method="zupt")], tmp_path / "r.html")
    text, _ = page_of(tmp_path / "r.html")
    assert "<li>Both.</li>" in text and "<li>maginav: One.</li>" in text


def test_wrong_calls_and_nothing_left_behind(tmp_path: Path) -> None:
    with pytest.raises(UsageError):
        write_report([], tmp_path / "r.html")
    with pytest.raises(UsageError):
        write_report([walk()], tmp_path / "r.html", None, [None, None])
    with pytest.raises(DataError, match="cannot be written"):
        write_report([walk()], tmp_path / "no" / "r.html")
    with pytest.raises(UsageError):
        still_path([walk()], tmp_path / "r.txt")
    assert list(tmp_path.iterdir()) == []


def test_nothing_of_the_page_comes_from_elsewhere(tmp_path: Path) -> None:
    write_report([walk()], tmp_path / "r.html")
    text, _ = page_of(tmp_path / "r.html")
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:)?//", text) and "default-src 'none'" in text


# ---- stance page and still picture -----------------------------------------------------------------------------------------


def recording(n: int = 4000) -> Recording:
    """Standing and swinging in turn, with noise."""
    rng = np.random.default_rng(2)
    t = np.arange(n) / 200
    swing = ((t / 1.1) % 1 > 0.45)[:, None]
    f = np.array([0, 0, 9.80665]) + rng.normal(0, 0.05, (n, 3)) + swing * rng.normal(0, 8, (n, 3))
    w = rng.normal(0, 0.02, (n, 3)) + swing * rng.normal(0, 3, (n, 3))
    return Recording(time=t, specific_force=f, angular_rate=w, source="foot<b>.csv", warnings=("Odd <i>units</i>.",))


def test_stance_page(tmp_path: Path) -> None:
    r = recording()
    a = analyse(r, StanceParameters(rule="relative"))
    write_stance_page(r, a, tmp_path / "s.html")
    assert "all plots follow. Double-click to see everything again.<" in (tmp_path / "s.html").read_text("utf-8")
    text, data = page_of(tmp_path / "s.html")
    assert [p["key"] for p in data["panels"]] == ["statistic", "force", "rate"]
    assert data["stance"]["options"] == "--set stance.rule=absolute"
    assert "foot&lt;b&gt;.csv" in text and "<i>units" not in text
    live = data["stance"]
    steps = np.frombuffer(base64.b64decode(live["statistic"]), "<u2")
    shown = 10 ** (live["low"] + steps * (live["high"] - live["low"]) / live["levels"])
    assert shown == pytest.approx(a.statistic, rel=1e-3)
    assert sum(live["histogram"]["y"]) == pytest.approx(100)


def test_stance_page_of_nothing(tmp_path: Path) -> None:
    r = Recording(time=np.arange(100) / 100, specific_force=np.full((100, 3), np.nan), angular_rate=np.zeros((100, 3)))
    a = analyse(recording(200))
    empty = type(a)(r.time, np.full(100, np.nan), np.full(100, 1.0), np.zeros(100, bool), a.parameters)
    with pytest.raises(DataError, match="no value"):
        write_stance_page(r, empty, tmp_path / "s.html")


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_still_picture(tmp_path: Path, suffix: str) -> None:
    a = walk()
    still_path([a, turned(a, 1.0)], tmp_path / f"p.{suffix}", reference(a))
    content = (tmp_path / f"p.{suffix}").read_bytes()
    assert content.startswith(b"\x89PNG" if suffix == "png" else b"<?xml") and len(content) > 10_000
    assert [p.name for p in tmp_path.iterdir()] == [f"p.{suffix}"]


def test_turns_are_not_added_up_at_the_pole() -> None:
    from bematist.frames import quaternion_from_euler
    from bematist.report.attitude_page import angles_deg

    t = np.arange(2000) * 0.01
    swinging = angles_deg(quaternion_from_euler(0.3 * np.sin(5 * t), np.radians(70) + 0.6 * np.sin(3 * t), 0.5 * np.sin(0.4 * t)))
    assert np.nanmin(swinging["heading"]) >= 0 and np.nanmax(swinging["heading"]) <= 360 and np.nanmax(np.abs(swinging["roll"])) <= 180
    level = angles_deg(quaternion_from_euler(0.0 * t, 0.0 * t, t))
    assert np.ptp(level["heading"]) == pytest.approx(np.degrees(t[-1]))
