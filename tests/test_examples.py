"""Examples and documentation run as they stand: scripts, marked Python blocks, links, and the generated page of parameters."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from bematist.foot import FootParameters
from bematist.io import read, write_recording, write_reference
from bematist.methods import track
from bematist.simulate import simulate
from bematist.stance import DEFAULTS

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
MARKED = re.compile(r"^<!-- run -->\n```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\((?!https?://|mailto:|#)([^)#\s]+)(#[^)\s]*)?\)")


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A folder with walk.csv and truth.csv, as docs/python.md asks for."""
    folder = tmp_path_factory.mktemp("walk")
    recording = simulate("straight", length_m=20)
    write_recording(recording, folder / "walk.csv")
    write_reference(recording.reference, folder / "truth.csv")
    return folder


def blocks(page: Path) -> list[str]:
    return MARKED.findall(page.read_text("utf-8"))


def run_script(path: Path, *arguments: object) -> str:
    done = subprocess.run([sys.executable, path, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert not done.stderr.strip(), done.stderr
    return done.stdout


def test_there_are_examples_and_marked_blocks():
    assert {path.stem for path in EXAMPLES} >= {"track_a_recording", "live", "own_arrays", "compare_methods"}
    found = {page.name: len(blocks(page)) for page in PAGES}
    assert found["python.md"] >= 10
    assert found["live.md"] >= 1
    for page in PAGES:  # no mark without a block that is run
        assert page.read_text("utf-8").count("<!-- run -->") == len(blocks(page)), page.name


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_is_short_and_runs_on_a_recording(path, walk, tmp_path):
    assert len(path.read_text("utf-8").splitlines()) < 40
    out = run_script(path, walk / "walk.csv", *([tmp_path / "out"] if "FOLDER" in path.read_text("utf-8") else []))
    if path.stem == "live":
        assert re.search(r"(\d+) of \1 samples answered", out)
    elif path.stem == "track_a_recording":
        names = {p.name for p in (tmp_path / "out").iterdir()}
        assert names == {"trajectory.csv", "trajectory.parquet", "report.html", "walk.geojson"}
        length = re.search(r"^([\d.]+) m in", out, re.MULTILINE)
        assert length and abs(float(length[1]) - 20) < 0.5
    elif path.stem == "compare_methods":
        assert {p.name for p in (tmp_path / "out").iterdir()} == {"compare.html", "compare.png"}
        assert all(name in out for name in ("foot", "zupt", "maginav"))
    elif path.stem == "own_arrays":
        assert re.search(r"238 Hz, \d+ stances, (19|20)\.\d m", out)


@pytest.mark.parametrize("method", ["foot", "hand"])
def test_the_page_names_every_diagnostic(method, walk):
    found = track(read(walk / "walk.csv"), method).diagnostics
    page = (ROOT / "docs" / "python.md").read_text("utf-8")
    assert not [name for name in found if f"`{name}`" not in page]


def test_an_example_runs_without_a_recording():
    assert re.search(r"(\d+) of \1 samples answered", run_script(ROOT / "examples" / "live.py"))


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.name)
def test_marked_blocks_of_a_page_run_in_order(page, walk, tmp_path, monkeypatch):
    for path in walk.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    monkeypatch.chdir(tmp_path)
    names: dict = {"__name__": "page"}
    for number, block in enumerate(blocks(page), 1):
        exec(compile(block, f"{page.name}, block {number}", "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    missing = [target for target, _ in LINK.findall(text) if not (page.parent / target).exists()]
    assert not missing


def test_the_page_of_parameters_is_up_to_date(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    from parameters_page import page

    assert page() == (ROOT / "docs" / "parameters.md").read_text("utf-8"), "docs/parameters.md is old: make docs"


def leaves(model, prefix=""):
    for name, value in model:
        if hasattr(type(value), "model_fields"):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name


def test_every_parameter_is_explained():
    table = (ROOT / "docs" / "parameters.md").read_text("utf-8")
    prose = "".join((ROOT / "docs" / name).read_text("utf-8") for name in ("foot.md", "stance.md", "hard-iron.md"))
    names = list(leaves(FootParameters()))
    assert len(names) > 30
    assert not [name for name in names if f"| `{name}` |" not in table]
    assert not [name for name in names if f"`{name}`" not in prose]
    assert not [row for row in re.findall(r"^\| `[a-z_.]+` \| (.*?) \|", table, re.MULTILINE) if not row.strip()]


def test_default_thresholds_are_told():
    prose = (ROOT / "docs" / "stance.md").read_text("utf-8")
    assert all(f"`{name}` {d.threshold:g}" in prose for name, d in DEFAULTS.items())


def test_only_marked_blocks_are_taken():
    assert MARKED.findall("<!-- run -->\n```python\n1 / 0\n```\n\n```python\n2\n```\n") == ["1 / 0\n"]
