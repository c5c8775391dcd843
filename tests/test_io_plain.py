"""Plain text by the kernel: the same doubles as Python's, the same table as the library's, and anything else left to the library."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bematist.errors import DataError
from bematist.io import head, table
from bematist.io.plain import read_plain
from bematist.kernels import numerals

numeral = st.from_regex(r"-?([0-9]{1,9}\.?[0-9]{0,9}|\.[0-9]{1,12})([eE][+-]?[0-9]{1,2})?", fullmatch=True)


def parsed(text: str) -> float | None:
    """One cell by the kernel; None where it is left to others."""
    out = np.empty((1, 1))
    found = numerals.rows(np.frombuffer(bytearray(text.encode()), np.uint8), *b",.#", np.array([0]), out)
    return out[0, 0] if found == 1 else None


@settings(max_examples=2000, deadline=None)
@given(numeral)
def test_a_number_is_the_double_that_python_reads(text):
    got = parsed(text)
    digits = text.lower().partition("e")[0].replace(".", "").lstrip("-")
    assert got is None or np.float64(got).tobytes() == np.float64(text).tobytes()
    assert got is not None or "e" in text.lower() or int(digits) > 2**53


@pytest.mark.parametrize("text", ["-0.0", "0", "9007199254740992", "0.1", "1e22", "123456789e-22", "1.", ".5", "-7.45058e-09"])
def test_these_are_read(text):
    assert np.float64(parsed(text)).tobytes() == np.float64(text).tobytes()


@pytest.mark.parametrize(
    "text",
    [
        "9007199254740993",
        "2.2250738585072014",
        "1e23",
        "1e-23",
        "1e",
        "-",
        ".",
        "+1",
        "nan",
        " 1",
        "1 ",
        '"1"',
        "0x1",
        "1.2.3",
        "1e100",
        "#1",
    ],
)
def test_these_are_left_to_the_library(text):
    assert parsed(text) is None
    assert parsed("1" * 19) is None


ROWS = "0,1.5,-2\n0.01,,3e-5\n0.02,7,-0.0\n"
OTHERS = {
    "as it is": ROWS,
    "of another system": ROWS.replace("\n", "\r\n"),
    "no last line end": ROWS[:-1],
    "an empty cell at the end": ROWS[:-5] + "\n",
    "blank line": ROWS.replace("\n", "\n\n", 1),
    "comment": "# made by hand\n" + ROWS,
    "no value in words": ROWS.replace("7", "NaN"),
    "twenty digits": ROWS.replace("1.5", "1.50000000000000000001"),
    "quotation marks": ROWS.replace("7", '"7"'),
    "a row cut short": ROWS + "0.03,1",
    "no time": ROWS + ",1,2\n",
}


@pytest.mark.parametrize("name", OTHERS)
def test_the_table_is_that_of_the_library(tmp_path, monkeypatch, name):
    path = tmp_path / "a.csv"
    path.write_bytes(("time,a,b\n" + OTHERS[name]).encode())
    opened = head.open_head(path)
    got = table.read_columns(opened, 0, ["time", "a", "b"], ["time", "b", "a"])
    with monkeypatch.context() as patch:
        patch.setattr(table, "read_plain", lambda *_: None)
        want = table.read_columns(opened, 0, ["time", "a", "b"], ["time", "b", "a"])
    assert list(got) == list(want)
    for column in want:
        assert got[column].tobytes() == want[column].tobytes(), column


def test_what_is_plain(tmp_path):
    def read(text, places=(0, 1, 2), separator=",", point="."):
        path = tmp_path / "a.csv"
        path.write_bytes(b"time\n" + text.encode())
        return read_plain(head.open_head(path), 1, places, separator, "#", point)

    plain = [name for name, text in OTHERS.items() if read(text) is not None]
    assert plain == ["as it is", "of another system", "no last line end", "an empty cell at the end", "no time"]
    np.testing.assert_array_equal(read("1,word,2\n3,,4\n", (1, -1, 0)), [[2, 4], [1, 3]])
    np.testing.assert_array_equal(read("1,5;2\n3;4,25\n", (0, 1), ";", ","), [[1.5, 3], [2, 4.25]])
    assert read('1,"a,b",2\n', (1, -1, 0)) is None
    assert read("1,2,3,4\n") is None
    assert read("1,2\n") is None
    assert read("") is None


ROWS = "\n".join(f"{k / 100:.2f},{k % 7},{k / 8},{-k / 4}" for k in range(60)) + "\n"


def columns_of(tmp_path, text, **how):
    """Columns b, c and d of a file whose first column is the time."""
    path = tmp_path / "x.csv"
    path.write_bytes(text.encode())
    first = head.open_head(path)
    line, names = first.header()
    split, separator = table.split_header(names)
    return table.read_columns(first, line, split, ["time", "b", "c", "d"], separator=separator, **how)


@pytest.mark.parametrize(
    "text",
    [
        "time,b,c,d\n" + ROWS,
        "# a\x0c# b\ntime,b,c,d\n" + ROWS,
        "# a\u2028# b\ntime,b,c,d\n" + ROWS,
        ("time,b,c,d\n" + ROWS).replace("\n", "\r"),
        ("time,b,c,d\n" + ROWS).replace("\n", "\r\n"),
        "time,b,c,d,label\n" + ROWS.replace("\n", ',5"\n'),
        "time,b,c,d,place,x\n" + ROWS.replace("\n", ',"48,1",\n'),
        "time,b,c,d,place\n" + ROWS.replace("\n", ',"two\nlines"\n'),
        "time;b;c;d\n" + ROWS.replace(",", ";").replace(".", ","),
        "time,b,c,d\n"
        + "".join(",".join(f'"{cell}"' for cell in row.replace(".", ",").split(";")) + "\n" for row in ROWS.replace(",", ";").split()),
    ],
    ids=["plain", "form feed", "U+2028", "CR", "CR LF", "lone quote", "quoted separator", "quoted lines", "German", "quoted German"],
)
def test_the_same_table_however_it_is_written(tmp_path, text):
    found = columns_of(tmp_path, text)
    k = np.arange(60)
    for name, wanted in {"time": k / 100, "b": k % 7, "c": k / 8, "d": -k / 4}.items():
        np.testing.assert_allclose(found[name], wanted, atol=1e-12)


def test_integers_first_and_commas_later(tmp_path):
    rows = "".join(f"{k};0;0;0\n" for k in range(30)) + "30;0,5;1,25;0\n"
    assert columns_of(tmp_path, "time;b;c;d\n" + rows)["c"][-1] == 1.25


@pytest.mark.parametrize("cell", ["4_0.5", "\u0664"])
def test_what_only_python_takes_for_a_number(tmp_path, cell):
    with pytest.raises(DataError, match="not a number"):
        columns_of(tmp_path, "time,b,c,d\n" + ROWS + f"0.60,1,{cell},2\n")
