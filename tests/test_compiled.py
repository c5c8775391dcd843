"""Kernels kept as machine code: the same results as numba's, and never code of other sources, other types, or a damaged file."""

import copy
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import TypingError

import bematist as bm
from bematist.cli import console
from bematist.kernels import compiled, jit
from bematist.warmup import still

OWN = sys.platform == "linux" and os.uname().machine == "x86_64"
only_own = pytest.mark.skipif(not OWN, reason="code is kept by numba here")


def weigh(a, b, out):
    total = 0
    for i in range(a.shape[0]):
        out[i] = 2 * a[i] + b
        total += 1
    return total


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return tmp_path / "bematist"


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The kernels that were compiled."""
    names: list[str] = []

    @contextmanager
    def note(name: str):
        names.append(name)
        yield

    monkeypatch.setattr(jit, "announce", note)
    return names


def answer(kernel: jit.Kernel) -> list[float]:
    out = np.zeros(3)
    assert kernel(np.arange(3.0), 0.5, out) == 3
    return out.tolist()


@only_own
def test_code_is_compiled_once_and_kept(folder: Path, said: list[str]):
    first, second = jit.kernel(weigh), jit.kernel(weigh)
    assert answer(first) == answer(first) == answer(second) == [0.5, 2.5, 4.5]
    assert len(said) == 1 and len(list(folder.iterdir())) == 1


@only_own
def test_a_damaged_file_and_one_of_other_sources_are_not_used(folder: Path, said: list[str], monkeypatch: pytest.MonkeyPatch):
    answer(jit.kernel(weigh))
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    for damaged in (b"", whole[:-100], whole[:-1] + bytes([whole[-1] ^ 1]), whole.replace(b"result", b"x", 1)[:40]):
        file.write_bytes(damaged)
        assert compiled._read(file.stem) is None
        assert answer(jit.kernel(weigh)) == [0.5, 2.5, 4.5]
    assert len(said) == 5 and compiled._read(file.stem) is not None
    monkeypatch.setattr(compiled, "STAMP", "0")
    assert compiled._read(file.stem) is None


def test_a_change_in_any_file_that_is_inlined_is_seen():
    assert {"error_state.py", "stance.py", "layout.py", "foot.py", "strapdown.py"} <= {name for name, *_ in jit.sources()}


@only_own
def test_a_folder_that_cannot_be_written_is_no_failure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    (tmp_path / "bematist").write_text("a file where the folder should be")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert answer(jit.kernel(weigh)) == [0.5, 2.5, 4.5]


def test_other_types_and_layouts_are_computed_as_what_they_are(folder: Path):
    kernel, a = jit.kernel(weigh), np.arange(6.0)
    read_only = a.copy()
    read_only.flags.writeable = False
    unaligned = np.frombuffer(b"x" + a.tobytes(), np.float64, offset=1)
    for given in (a, a[::2], a[::-1], a.astype(np.float32), a.astype(np.int64), a.astype(np.uint8), read_only, unaligned, a[:0]):
        for b in (0.5, 2, True, np.float64(0.5), np.int64(2)):
            out = np.zeros(len(given))
            assert kernel(given, b, out) == len(given)
            np.testing.assert_array_equal(out, 2 * given.astype(float) + b)
    with pytest.raises(TypingError):
        kernel(a, "b", np.zeros(6))


def test_a_bound_call_reads_its_arrays_anew(folder: Path):
    a, out = np.arange(3.0), np.zeros(3)
    call = jit.kernel(weigh).bind(a, 0.5, out)
    a[:] = 7
    assert call() == 3 and out.tolist() == [14.5] * 3


def test_a_copy_has_arrays_of_its_own():
    for navigator, rows in (
        (bm.FootIns(), still().samples()),
        (bm.HandPdr(), np.c_[still().samples(), np.full(len(still()), np.nan)]),
    ):
        navigator.update(rows[:60])
        navigator.finish()
        assert navigator.ready
        rows = rows[60:]
        other = copy.deepcopy(navigator)
        ours, theirs = ([np.copy(r) for row in rows if (r := each.step(row[None])) is not None] for each in (navigator, other))
        assert ours[0].tobytes() != ours[-1].tobytes()
        np.testing.assert_array_equal(ours, theirs)


def loaded_by(code: str, **environment: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ | environment)
    return done.stdout.strip()


RUN = "import sys; from bematist.warmup import still; import bematist as bm; t = bm.FootIns().run(still()); print({})"


@only_own
def test_what_was_compiled_runs_without_numba():
    bm.FootIns().run(still())
    assert loaded_by(RUN.format("'numba' in sys.modules")) == "False"


def test_numba_is_asked_where_it_is_told_something():
    told = RUN.format("'numba' in sys.modules, *t.position[-1].tolist()")
    loaded, *position = loaded_by(told, NUMBA_DISABLE_JIT="1").split()
    assert loaded == "True"
    np.testing.assert_allclose(np.array(position, float), bm.FootIns().run(still()).position[-1], atol=1e-9)


@only_own
def test_threads_share_a_kernel(folder: Path):
    from concurrent.futures import ThreadPoolExecutor

    kernel = jit.kernel(weigh)

    def one(k: int) -> bool:
        a, out = np.full(2000, float(k)), np.zeros(2000)
        return all(kernel(a, 0.5, out) == 2000 and bool((out == 2 * k + 0.5).all()) for _ in range(20))

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(one, range(16)))


def test_the_command_line_says_that_it_compiles():
    words: list[str] = []
    before = jit.announce
    with console.compiling_told(words.append):
        with jit.announce("bematist.kernels.foot.run"):
            assert words == ["compiling foot.run for this machine, once"]
        assert words[-1] == ""
    assert jit.announce is before
