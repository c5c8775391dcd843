"""Broken and strange files: a recording with a warning, or one clear paragraph. Never a traceback."""

import os

import numpy as np
import pytest

from bematist.errors import BematistError, DataError
from bematist.io import read
from test_io_formats import HEADER, INERTIAL, walk_rows, write


def body(rows) -> str:
    return "\n".join(",".join(f"{v:.9g}" for v in row) for row in rows) + "\n"


GOOD = HEADER + "\n" + body(walk_rows(50))
LINES = GOOD.splitlines()

REFUSED = {
    "empty": (b"", "empty"),
    "blank lines only": (b"\n\n  \n", "empty"),
    "header only": (HEADER.encode() + b"\n", "no row of data"),
    "comments only": (b"# a\n# b\n", "no format"),
    "text in a number": (GOOD.replace(LINES[20], LINES[20].replace(LINES[20].split(",")[2], "abc")).encode(), "line 21"),
    "too many cells": (GOOD.replace(LINES[7], LINES[7] + ",1,2").encode(), "line 8"),
    "no gyroscope": (("time,fx,fy,fz\n" + body(walk_rows(50)[:, :4])).encode(), "no gyroscope"),
    "no accelerometer": (("time,wx,wy,wz\n" + body(walk_rows(50)[:, :4])).encode(), "no accelerometer"),
    "half an accelerometer": (GOOD.replace("fy", "foo").encode(), "lacks the column fy"),
    "no time column": (GOOD.replace("time", "clock").encode(), '"time"'),
    "doubled column": (GOOD.replace("fy", "fx", 1).encode(), "fx|fy"),
    "all values missing": ((HEADER + "\n" + "0.1,,,,,,,,,\n0.2,,,,,,,,,\n").encode(), "no accelerometer"),
    "all times missing": ((HEADER + "\n" + ",0,0,9.8,0,0,0,,,\n" * 5).encode(), "No time stamp"),
    "time stands still": ((HEADER + "\n" + body(walk_rows(50) * np.r_[0, np.ones(9)])).encode(), "never advance"),
    "binary junk": (bytes(np.random.default_rng(0).integers(0, 256, 5000, dtype=np.uint8)), "no format"),
    "cut parquet": (b"PAR1" + b"\x00" * 300, "Parquet"),
    "MATLAB junk": (b"MATLAB 5.0 MAT-file" + b"\x00" * 300, "MATLAB"),
    "another table": (b"a;b\n1;2\n", "no format"),
    "a trajectory": (b"time,east,north,up\n0,1,2,3\n", "no format"),
    "a picture": (b"\x89PNG\r\n\x1a\n" + b"\x00\x01" * 100, "no format"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_one_clear_paragraph(tmp_path, name):
    content, message = REFUSED[name]
    path = tmp_path / "walk.csv"
    path.write_bytes(content)
    with pytest.raises(DataError, match=message) as error:
        read(path)
    text = str(error.value)
    assert "walk.csv" in text and "\n" not in text and len(text) < 900
    assert error.value.exit_code == 1


def test_refused_paths(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read(tmp_path / "none.csv")
    with pytest.raises(DataError, match="the folder is in no format"):
        read(tmp_path)
    (tmp_path / "walks").mkdir()
    for name in "abcde":
        (tmp_path / f"walks/{name}.csv").write_text(GOOD)
    with pytest.raises(DataError, match=r"holds recordings: a\.csv, b\.csv, c\.csv and 2 more"):
        read(tmp_path / "walks")
    (tmp_path / "Inertial.csv").write_text("Timestamp (us),X\n1,2\n")
    with pytest.raises(DataError, match="no accelerometer"):
        read(tmp_path)
    locked = tmp_path / "locked.csv"
    locked.write_text(GOOD)
    locked.chmod(0)
    if os.access(locked, os.R_OK):
        pytest.skip("this user reads every file")
    with pytest.raises(DataError, match="cannot be opened"):
        read(locked)


def test_parquet_cut_short(tmp_path):
    import polars as pl

    path = tmp_path / "a.parquet"
    pl.DataFrame(walk_rows(5000), schema=HEADER.split(",")).write_parquet(path)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(DataError, match="cut short"):
        read(path)
    pl.DataFrame({"time": [0.0], "fx": ["a"], "fy": [0.0], "fz": [0.0]}).write_parquet(path)
    with pytest.raises(DataError):
        read(path)
    pl.DataFrame(walk_rows(5)[:0], schema=HEADER.split(",")).write_parquet(path)
    with pytest.raises(DataError, match="no row"):
        read(path)


def spoil(kind: str) -> np.ndarray:
    rows = walk_rows(1000)
    rng = np.random.default_rng(3)
    if kind == "saturated":
        rows[:, 1] = np.clip(rows[:, 1] + 160 * np.sin(7 * rows[:, 0]) ** 9, -78.4532, 78.4532)
    elif kind == "constant":
        rows[:, 1:] = rows[0, 1:]
    elif kind == "gap of a minute":
        rows[500:, 0] += 60
    elif kind == "1 Hz":
        rows[:, 0] *= 100
    elif kind == "clock back":
        rows[500:, 0] -= 4
    elif kind == "repeated rows":
        rows = rows[np.sort(np.concatenate([np.arange(1000), [5, 6, 7]]))]
    elif kind == "g":
        rows[:, 1:4] /= 9.80665
    elif kind == "one sample":
        rows = rows[:1]
    elif kind == "NaN runs":
        rows[200:260, 1:4] = np.nan
    elif kind == "infinite":
        rows[300, 5] = np.inf
    elif kind == "stray stamp":
        rows[400, 0] = 0
    elif kind == "rows swapped":
        rows[[700, 701]] = rows[[701, 700]]
    elif kind == "gyroscope dead":
        rows[:, 4:7] = 0
    elif kind == "missing stamps":
        rows[rng.integers(10, 900, 5), 0] = np.nan
    return rows


WARNED = {
    "saturated": "saturates: x stays at 8 g",
    "constant": "never changes",
    "gap of a minute": "60",
    "1 Hz": "too slow",
    "clock back": "went back",
    "repeated rows": "3 rows that repeat",
    "g": "specific_force=g",
    "one sample": "one sample",
    "NaN runs": "no accelerometer sample",
    "infinite": "a part missing",
    "stray stamp": "far from its neighbours",
    "rows swapped": "wrong order",
    "gyroscope dead": "gyroscope never changes",
    "missing stamps": "without a time stamp",
}


@pytest.mark.parametrize("kind", WARNED)
def test_processed_with_a_warning(tmp_path, kind):
    r = read(write(tmp_path / "a.csv", HEADER, spoil(kind), fmt="%.9g"))
    assert len(r) >= 1
    assert any(WARNED[kind] in w for w in r.warnings), r.warnings
    assert np.isfinite(r.time).all() and np.all(np.diff(r.time) > 0)


def test_strange_but_good(tmp_path):
    """Read without any warning: no magnetometer, 5 kHz, trailing separators, blanks, a cut last line, magnetometer empty."""
    rows = walk_rows(1000)
    want = rows[:, 1:4]
    path = tmp_path / "a.csv"
    for text in (
        "time,fx,fy,fz,wx,wy,wz\n" + body(rows[:, :7]),
        HEADER + "\n" + body(rows).replace(",", " , "),
        HEADER + ",\n" + body(rows).replace("\n", ",\n"),
        HEADER + "\n" + "\n".join(",".join([*(f"{v:.9g}" for v in row[:7]), "", "", ""]) for row in rows),
        '"' + HEADER.replace(",", '","') + '"\n' + body(rows),
    ):
        path.write_text(text)
        r = read(path)
        np.testing.assert_allclose(r.specific_force, want, rtol=1e-7)
        assert not r.warnings
    path.write_text(HEADER + "\n" + body(rows) + "10.0,0.1,0.2")
    r = read(path)
    assert len(r) in (1000, 1001) and any("part missing" in w for w in r.warnings)
    fast = rows.copy()
    fast[:, 0] /= 50
    fast[:, 4:7] *= 50
    r = read(write(path, HEADER, fast))
    assert r.rate_hz == pytest.approx(5000)


def test_any_cut_of_a_file_is_read_or_refused_in_words(tmp_path):
    """Every prefix of a small file, as a full disk leaves it."""
    rows = walk_rows(12)
    texts = [HEADER + "\n" + body(rows), INERTIAL + "\n" + body(rows[:, :7])]
    path = tmp_path / "a.csv"
    for text in texts:
        for n in range(0, len(text), 7):
            path.write_text(text[:n])
            try:
                assert len(read(path)) >= 1
            except BematistError as error:
                assert "\n" not in str(error)
