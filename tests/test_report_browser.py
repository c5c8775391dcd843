"""The pages in a real browser: nothing fails, everything is drawn, nothing is fetched, zoom and hover reach all plots."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import bematist as bm
import browser
from bematist.allan import allan as identify
from bematist.io import read_floor_plan
from bematist.recording import Recording, Reference
from bematist.report import write_allan_page, write_calibration_page, write_report, write_stance_page
from bematist.simulate import Sensor, simulate
from bematist.stance import StanceParameters, analyse
from report_cases import reference, turned, walk

PANELS = 16
HOSTILE = "</script><script>window.broken=1</script><img src=http://x.invalid/ onerror=window.broken=1>&\"'"

ALL_DRAWN = """[...document.querySelectorAll('.js-plotly-plot')].every(
    (div) => div.querySelectorAll('.scatterlayer .trace path').length > 0)"""
RANGES = "bematist.times.map((own) => own.div._fullLayout.xaxis.range.map(Number))"


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    program = browser.find()
    if program is None:
        pytest.skip(f"no Chromium found (looked for {', '.join(browser.NAMES)}): the pages are not tried in a browser")
    started = browser.Browser(program, tmp_path_factory.mktemp("profile"))
    yield started
    started.close()


def fetched(page: browser.Page) -> list[str]:
    """What the page asked for besides itself; data in addresses is no request."""
    return [url for url in page.requests() if not url.startswith(("file:", "data:", "blob:", "about:"))]


@pytest.fixture(scope="module")
def report(chromium: browser.Browser, tmp_path_factory: pytest.TempPathFactory) -> browser.Page:
    """A page about one walk of two minutes with all diagnostics."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    t = walk(12_000)
    t.velocity[6_001] = [0, 0, 60.0]
    write_report([t], path, reference(t))
    page = browser.Page(chromium)
    page.open(path)
    return page


def test_opens_whole_and_alone(report: browser.Page) -> None:
    assert report.problems() == []
    assert fetched(report) == []
    assert report.run("document.querySelectorAll('.js-plotly-plot').length") == PANELS + 1
    assert report.run(ALL_DRAWN)
    buttons = report.run("[...document.querySelectorAll('.modebar-btn')].map((b) => b.dataset.title)")
    assert len(buttons) > PANELS and not [b for b in buttons if "loud" in b or "hare" in b]


def test_the_check_for_errors_and_requests_can_fail(chromium: browser.Browser, tmp_path: Path) -> None:
    write_report([walk(300)], tmp_path / "bad.html")
    text = (tmp_path / "bad.html").read_text(encoding="utf-8")
    broken = "<script>fetch('http://example.invalid/x').catch(() => {}); nothing.there()</script></body>"
    (tmp_path / "bad.html").write_text(text.replace("</body>", broken), encoding="utf-8")
    page = browser.Page(chromium)
    page.open(tmp_path / "bad.html")
    said = "\n".join(page.problems())
    page.close()
    assert "nothing is not defined" in said and "connect-src" in said


def test_axes_of_the_plan_are_equal(report: browser.Page) -> None:
    metres = report.run(
        "(() => { const { xaxis: x, yaxis: y } = document.getElementById('plot-plan')._fullLayout;"
        " return [x._length / (x.range[1] - x.range[0]), y._length / (y.range[1] - y.range[0])]; })()"
    )
    assert metres[0] == pytest.approx(metres[1], rel=1e-6)


def test_the_time_axes_stand_below_one_another(report: browser.Page) -> None:
    places = report.run("bematist.times.map((o) => [o.div._fullLayout.xaxis._offset, o.div._fullLayout.xaxis._length])")
    assert len(places) == PANELS and all(p == places[0] for p in places)


def test_extremes_are_drawn(report: browser.Page) -> None:
    assert report.run("Math.max(...document.getElementById('plot-speed').data[0].y)") == 60


def test_dragging_in_one_plot_zooms_all(report: browser.Page) -> None:
    whole = report.run(RANGES)
    report.run("document.getElementById('plot-speed').scrollIntoView({ block: 'center' })")
    left, top, width, height = report.run(
        "(() => { const d = document.getElementById('plot-speed'), b = d.getBoundingClientRect(), l = d._fullLayout;"
        " return [b.left + l.xaxis._offset, b.top + l.yaxis._offset, l.xaxis._length, l.yaxis._length]; })()"
    )
    middle = top + height / 2
    report.drag((left + 0.25 * width, middle), (left + 0.5 * width, middle))
    report.until("document.body.dataset.view")
    span = whole[0][1] - whole[0][0]
    zoomed = report.run(RANGES)
    assert len(zoomed) == PANELS
    for start, end in zoomed:
        assert [start, end] == pytest.approx([0.25 * span, 0.5 * span], abs=0.01 * span)
        assert [start, end] == pytest.approx(zoomed[0], abs=1e-3)
    # Detail comes back with the zoom, heights fit what is seen, and the plan shows which part it is.
    assert report.run("document.getElementById('plot-speed')._fullLayout.yaxis.range[1]") < 60
    assert report.run("document.getElementById('plot-plan').data.at(-1).x.length") > 10
    report.run("void Plotly.relayout(document.getElementById('plot-height'), { 'xaxis.autorange': true })")
    report.until("document.body.dataset.view.startsWith('0 ')")
    assert report.run(RANGES) == [pytest.approx(r, abs=1e-3) for r in whole]
    assert report.problems() == []


def test_hovering_marks_the_place_and_the_moment(report: browser.Page) -> None:
    report.run("document.getElementById('plot-speed').scrollIntoView({ block: 'center' })")
    x, y = report.run(
        "(() => { const d = document.getElementById('plot-speed'), b = d.getBoundingClientRect(), l = d._fullLayout;"
        " return [b.left + l.xaxis._offset + l.xaxis._length / 2, b.top + l.yaxis._offset + l.yaxis._length / 2]; })()"
    )
    report.mouse("mouseMoved", x, y)
    report.until("[...document.querySelectorAll('.cursor')].filter((c) => c.style.display === 'block').length === 17")
    # Where the mark stands is where the walk was at that time.
    t, east = report.run(
        "(() => { const d = document.getElementById('plot-speed'), p = document.getElementById('plot-plan');"
        " const time = d._fullLayout.xaxis.p2l(d.querySelector('.cursor').offsetLeft - d._fullLayout.xaxis._offset);"
        " const mark = p.querySelector('.cursor'); const a = p._fullLayout.xaxis;"
        " return [time, a.p2l(parseFloat(mark.style.left) - a._offset)]; })()"
    )
    truth = walk(12_000)
    assert east == pytest.approx(np.interp(t, truth.time, truth.position[:, 0]), abs=0.5)
    label = report.until("document.querySelector('#plot-speed .hoverlayer').textContent")
    assert f"{t:.1f}" in label and "m/s" in label


def test_the_dark_theme_follows_the_reader(report: browser.Page) -> None:
    ink = "document.getElementById('plot-speed')._fullLayout.font.color"
    light = report.run(ink)
    report.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    report.until(f"{ink} !== '{light}'")
    report.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "light"}])
    report.until(f"{ink} === '{light}'")
    assert report.problems() == []


def test_several_methods_on_a_phone_with_hostile_names(chromium: browser.Browser, tmp_path: Path) -> None:
    a = walk(4000)
    hostile = walk(4000, method=HOSTILE, source=HOSTILE, warnings=(HOSTILE,), parameters={HOSTILE: HOSTILE})
    write_report([a, turned(a, 1.0), hostile], tmp_path / "c.html", reference(a))
    page = browser.Page(chromium, 420, 860, phone=True)
    page.open(tmp_path / "c.html")
    assert page.problems() == [] and fetched(page) == []
    assert page.run("window.broken") is None
    assert page.run("document.querySelectorAll('img').length") == 0
    assert page.run("document.querySelectorAll('.js-plotly-plot').length") == PANELS + 1
    assert page.run("document.documentElement.scrollWidth") <= 420
    names = page.run("[...document.querySelectorAll('#plot-speed .legendtext')].map((t) => t.textContent)")
    assert names[:2] == ["maginav", "zupt"] and "window.broken" in names[2]
    paths = page.run("document.getElementById('plot-plan').data.filter((t) => t.meta === 'path').length")
    assert paths == 3 and "ATE RMSE, plan [yaw]" in page.run("document.body.textContent")
    page.close()


def test_trying_a_stance_threshold(chromium: browser.Browser, tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    t = np.arange(12_000) / 200
    swing = ((t / 1.1) % 1 > 0.45)[:, None]
    f = np.array([0, 0, 9.80665]) + rng.normal(0, 0.05, (12_000, 3)) + swing * rng.normal(0, 8, (12_000, 3))
    w = rng.normal(0, 0.02, (12_000, 3)) + swing * rng.normal(0, 3, (12_000, 3))
    r = Recording(time=t, specific_force=f, angular_rate=w, source="foot.csv")
    a = analyse(r, StanceParameters(threshold=80))
    write_stance_page(r, a, tmp_path / "s.html")
    page = browser.Page(chromium)
    page.open(tmp_path / "s.html")
    page.until("document.body.dataset.share")
    assert page.problems() == [] and fetched(page) == []
    assert page.run("document.querySelectorAll('.js-plotly-plot').length") == 4 and page.run(ALL_DRAWN)

    def seen() -> tuple[float, int]:
        return float(page.run("document.body.dataset.share")), int(page.run("document.body.dataset.stances"))

    def expected(stance: np.ndarray) -> tuple[float, int]:
        return 100 * stance.mean(), int((np.diff(stance.astype(int), prepend=0) == 1).sum())

    share, phases = expected(a.stance)
    assert seen() == (pytest.approx(share, abs=0.02), phases)
    limit = float(f"{np.quantile(a.statistic, 0.3):.3g}")
    page.run(f"document.getElementById('threshold').value = '{limit:g}'")
    page.run("document.getElementById('threshold').dispatchEvent(new Event('input'))")
    share, phases = expected(a.statistic < limit)
    page.until(f"Math.abs(document.body.dataset.share - {share}) < 0.05")
    assert abs(seen()[1] - phases) <= 2
    assert page.run("document.getElementById('command').textContent") == f"--set stance.threshold={limit:g}"
    # The verdict is drawn over all three signals.
    page.until("new Set(bematist.times.map((o) => o.div.data[0].x.length)).size === 1")
    page.run("document.getElementById('threshold-reset').click()")
    assert seen()[1] == expected(a.stance)[1]
    page.close()


def test_a_plan_below_the_path_and_waypoints_with_their_errors(chromium: browser.Browser, tmp_path: Path) -> None:
    image = Image.new("RGB", (60, 40), "white")
    image.save(tmp_path / "plan.png")
    (tmp_path / "plan.geojson").write_text('{"type": "Point", "coordinates": [-10, 3]}')
    t = walk(12_000)
    rows = slice(0, None, 1500)
    waypoints = Reference(time=t.time[rows], position=t.position[rows] + [0.5, 0, 0])
    pictured = read_floor_plan(tmp_path / "plan.png", scale=1, origin=(50, 20), rotation_deg=20)
    write_report([t], tmp_path / "a.html", waypoints, floor_plan=pictured, align="none")
    write_report([t, turned(t, 0.4)], tmp_path / "b.html", waypoints, floor_plan=read_floor_plan(tmp_path / "plan.geojson", scale=1))
    page = browser.Page(chromium)
    page.open(tmp_path / "a.html")
    assert page.problems() == [] and fetched(page) == []
    assert page.run("document.querySelectorAll('#plot-plan image').length") == 1
    # The picture's place on the screen is that of its bounds on the axes.
    west, south, east, north = pictured.bounds
    shown = page.run(
        "(() => { const b = document.querySelector('#plot-plan image').getBoundingClientRect(), d = document.getElementById('plot-plan');"
        " const o = d.getBoundingClientRect(), { xaxis: x, yaxis: y } = d._fullLayout;"
        " return [x.p2l(b.left - o.left - x._offset), y.p2l(b.bottom - o.top - y._offset),"
        " x.p2l(b.right - o.left - x._offset), y.p2l(b.top - o.top - y._offset)]; })()"
    )
    assert shown == pytest.approx([west, south, east, north], abs=0.2)
    labels = page.run("[...document.querySelectorAll('#plot-plan .textpoint')].map((t) => t.textContent)")
    assert labels == [str(k + 1) for k in range(8)]
    hover = page.run("document.getElementById('plot-plan').data.find((t) => t.hovertext).hovertext[2]")
    assert hover == f"point 3 of the reference, {waypoints.time[2]:.2f} s<br>0.50 m off"
    page.open(tmp_path / "b.html")
    assert page.problems() == [] and fetched(page) == []
    assert page.run("document.getElementById('plot-plan').data.filter((t) => t.name === 'error at the reference').length") == 2
    page.close()


def noisy(n: int = 6000) -> Recording:
    """A minute of rest of nine axes; its name would like to be a script."""
    rng, time = np.random.default_rng(0), np.arange(n) / 100
    force = np.array([0, 0, 9.8]) + 0.02 * rng.standard_normal((n, 3))
    rate, field = 1e-3 * rng.standard_normal((n, 3)), 0.3 * rng.standard_normal((n, 3))
    return Recording(
        time=time,
        specific_force=force,
        angular_rate=rate,
        magnetic_time=time,
        magnetic_flux_density=field,
        source=HOSTILE,
        warnings=(HOSTILE,),
    )


@pytest.mark.parametrize("dark", [False, True])
def test_the_page_of_noises(chromium: browser.Browser, tmp_path: Path, dark: bool) -> None:
    path = tmp_path / "allan.html"
    write_allan_page(identify(noisy(), quaternion=True), path, 100.0)
    assert "Drag in a plot to zoom. Double-click to see everything again.<" in path.read_text("utf-8")
    assert path.stat().st_size < 6e6
    page = browser.Page(chromium, dark=dark)
    page.open(path)
    assert page.problems() == [] and fetched(page) == []
    assert page.run("window.broken") is None
    assert page.run("document.querySelectorAll('.js-plotly-plot').length") == 8
    assert page.run(ALL_DRAWN)
    deviation = "document.getElementById('plot-gyroscope-deviation')"
    assert page.run(f"[{deviation}._fullLayout.xaxis.type, {deviation}._fullLayout.yaxis.type]") == ["log", "log"]
    # A curve with its band, the white noise and the sum of each axis; the hidden axis takes all of its lines along.
    assert page.run(f"{deviation}.data.filter((t) => t.legendgroup === 'x').length") == 4
    page.run(f"{deviation}.scrollIntoView({{ block: 'center' }})")
    x, y = page.run(
        f"(() => {{ const d = {deviation}, b = d.getBoundingClientRect(), l = d._fullLayout, t = d.data.find((t) => t.name === 'z');"
        " return [b.left + l.xaxis._offset + l.xaxis.d2p(t.x[3]), b.top + l.yaxis._offset + l.yaxis.d2p(t.y[3])]; })()"
    )
    page.mouse("mouseMoved", x - 20, y)
    page.mouse("mouseMoved", x, y)
    page.until(f"!!{deviation}.querySelector('.hoverlayer .hovertext')")
    assert "°/h" in page.run(f"{deviation}.querySelector('.hoverlayer').textContent")
    assert page.problems() == []
    page.close()


def test_the_page_of_a_calibration(chromium: browser.Browser, tmp_path: Path) -> None:
    device = Sensor(
        rate_hz=100.0, magnetometer_rate_hz=25.0, velocity_random_walk=2e-3, angle_random_walk=2e-4, magnetic_noise_density=0.05
    )
    write_calibration_page(bm.calibrate(simulate("tumble", device, tumble_rest_s=2.0)), tmp_path / "sensor.html")
    page = browser.Page(chromium)
    page.open(tmp_path / "sensor.html")
    of_chromium = ("willReadFrequently", "software WebGL", "GPU stall")  # to the maker of plotly, and of the machine
    assert [text for text in page.problems() if not any(known in text for known in of_chromium)] == [] and fetched(page) == []
    assert page.run("document.querySelectorAll('.js-plotly-plot').length") == 5
    assert (tmp_path / "sensor.html").stat().st_size < 6e6
    page.close()
