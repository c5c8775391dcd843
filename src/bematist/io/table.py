"""Delimited text → columns of numbers, fast when the file is clean and clear about the line when it is not."""

from __future__ import annotations

import csv
import io
import mmap
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.io.head import Head, split_lines
from bematist.io.plain import read_plain

if TYPE_CHECKING:
    import polars as pl

Array = NDArray[np.float64]

NO_VALUE = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "n/a", "na", "null", "NULL", "None", "-"]
_CLOCK_TEXT = ("%m/%d/%Y %H:%M:%S%.f", "%Y/%m/%d %H:%M:%S%.f", "%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%dT%H:%M:%S%.f", "%Y-%m-%dT%H:%M:%S%.fZ")


def split_header(line: str, separator: str | None = None) -> tuple[list[str], str]:
    """Column names of a header line, trimmed and unquoted, and the separator (guessed among tab ; , and blanks)."""
    if separator is None:
        separator = next((s for s in ("\t", ";", ",") if s in line), " ")
    parts = line.split() if separator == " " else line.split(separator)
    names = [p.strip().strip('"').strip() for p in parts]
    while names and not names[-1]:
        names.pop()
    return names, separator


def decimal_comma(head: Head, first: int, separator: str) -> bool:
    """Whether the rows after line `first` write 0,5 for 0.5."""
    rows = head.lines[first + 1 :]
    number, parts = (r'"-?\d+,\d+"', [rows]) if separator == "," else (r"\d,\d", [rows[:19], rows])
    for text in map("\n".join, parts):
        comma, point = re.search(number, text) is not None, re.search(r"\d\.\d", text) is not None
        if comma or point:  # else there are integers only, so far
            return comma and not point
    return False


def read_columns(
    head: Head,
    header_line: int,
    names: Sequence[str],
    wanted: Sequence[str],
    *,
    separator: str = ",",
    comment: str = "#",
    comma: bool | None = None,
    clock: str | None = None,
) -> dict[str, Array]:
    """Columns `wanted` (by name) of the rows after line `header_line` (0-based; -1: the rows begin at once).

    An empty cell is NaN. `clock` names a column that may hold dates; they become UNIX seconds.

    Raises
    ------
    DataError
        Two columns of one name, text where a number should be, a row with too many cells, no row at all.
    """
    for name in wanted:
        if list(names).count(name) > 1:
            raise DataError(f'{head.path}: two columns are called "{name}". Rename one of them.')
    comma = decimal_comma(head, header_line, separator) if comma is None else comma
    layout = head, header_line, names, wanted, separator, comment, comma
    columns = _plain(*layout)
    if columns is None:
        frame = _fast(*layout, clock)
        columns = _slow(*layout, clock) if frame is None else {name: _array(frame.drop_in_place(name)) for name in wanted}
    if not len(columns[wanted[0]]):
        raise DataError(f"{head.path}: there is a header but no row of data. Export the recording again.")
    return columns


def _plain(
    head: Head, first: int, names: Sequence[str], wanted: Sequence[str], separator: str, comment: str, comma: bool
) -> dict[str, Array] | None:
    """The whole table at once, without the table library; None where a cell is no short decimal, or the first column has an empty one."""
    places = [wanted.index(name) if name in wanted else -1 for name in names] + [-1] * _blank_cells(head, first, len(names), separator)
    found = read_plain(head, first + 1, places, separator, comment, "," if comma else ".")
    return None if found is None or np.isnan(found[0]).any() else dict(zip(wanted, found, strict=True))


def _array(column: pl.Series) -> Array:
    """Null becomes NaN. Chunk by chunk: polars would first make one chunk of all."""
    return np.concatenate([chunk.to_numpy() for chunk in column.get_chunks()])


def _fast(
    head: Head,
    first: int,
    names: Sequence[str],
    wanted: Sequence[str],
    separator: str,
    comment: str,
    comma: bool,
    clock: str | None,
) -> pl.DataFrame | None:
    """The whole table at once, or None where a cell is no number."""
    import polars as pl

    blank = _blank_cells(head, first, len(names), separator)
    keys = [f"{i}" for i in range(len(names) + blank)]
    picked = {keys[list(names).index(name)]: name for name in wanted}
    dated = clock is not None and _is_dated(head, first, names, clock, separator)
    schema = {key: pl.Float64 if key in picked and not (dated and picked[key] == clock) else pl.String for key in keys}
    commented = _contains(head, comment)
    frame = None
    if _has_lone_quotes(head):
        return None
    # Looking for words that mean "no value", or for comments, costs half as much again as reading: only where it must be.
    for words in (None, NO_VALUE):
        try:
            frame = pl.read_csv(
                _source(head, separator),
                has_header=False,
                skip_lines=first + 1,
                schema=schema,
                columns=None if len(picked) == len(keys) else [int(key) for key in picked],
                separator="\t" if separator == " " else separator,
                comment_prefix=comment if commented else None,
                null_values=words,
                decimal_comma=comma,
                glob=False,
            ).rename(picked)
            break
        except (pl.exceptions.PolarsError, OSError, ValueError):
            continue
    if frame is None:
        return None
    stamps = frame[wanted[0]]
    if stamps.null_count() or (stamps.dtype.is_float() and stamps.is_nan().any()):  # blank lines
        frame = frame.fill_nan(None).filter(~pl.all_horizontal(pl.all().is_null()))
    if dated and clock is not None:
        moments = _dates(frame[clock])
        if moments.null_count() > frame[clock].null_count():
            return None
        frame = frame.with_columns(moments.alias(clock))
    return frame


def _source(head: Head, separator: str) -> Path | io.BytesIO:
    """What polars reads: the file itself where it can."""
    if head.is_utf8 and separator != " " and head.has_line_feeds:
        return head.path if head.content is None else io.BytesIO(head.content)
    return io.BytesIO(_tidy(head.text(), separator).encode())


def _tidy(text: str, separator: str) -> str:
    """Line feeds at the ends of lines, and runs of blanks as one tab."""
    lines = split_lines(text)
    return "\n".join("\t".join(line.split()) for line in lines) if separator == " " else "\n".join(lines)


def _is_dated(head: Head, first: int, names: Sequence[str], clock: str, separator: str) -> bool:
    for line in head.lines[first + 1 : first + 20]:
        cells = _cells(line, separator)
        if len(cells) == len(names) and (cell := cells[list(names).index(clock)].strip().strip('"')):
            return re.fullmatch(r"[-+0-9.,eE]+", cell) is None
    return False


def _dates(cells: pl.Series) -> pl.Series:
    """UNIX seconds of dates, taken as UTC; null where none of the known forms fits."""
    import polars as pl

    tried = (cells.str.strip_chars().str.to_datetime(form, strict=False, time_unit="ns") for form in _CLOCK_TEXT)
    moments = min(tried, key=lambda found: found.null_count())
    return moments.dt.epoch("ns").cast(pl.Float64) * 1e-9


def _blank_cells(head: Head, first: int, columns: int, separator: str) -> int:
    """Empty cells after the last column: some loggers end each row with a separator."""
    rows = (_cells(line, separator) for line in head.lines[first + 1 : first + 50])
    cells = next((row for row in rows if len(row) >= columns), [])[columns:]
    return len(cells) if not any(c.strip() for c in cells) else 0


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a line; a separator in quotation marks separates nothing."""
    return next(csv.reader([line], delimiter=separator), []) if '"' in line else line.split(separator)


def _has_lone_quotes(head: Head) -> bool:
    """Whether a line holds an odd number of quotation marks: in text such as 5", or in a cell of several lines. polars takes either for the
    beginning of a cell that goes on, and may leave lines out without a word.
    """
    return _contains(head, '"') and any(line.count(b'"') % 2 for line in io.BytesIO(head.data()))


def _contains(head: Head, comment: str) -> bool:
    if head.content is not None or not head.is_utf8:
        return not head.is_utf8 or comment.encode() in head.data()
    with head.path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return content.find(comment.encode()) >= 0


def _slow(
    head: Head,
    first: int,
    names: Sequence[str],
    wanted: Sequence[str],
    separator: str,
    comment: str,
    comma: bool,
    clock: str | None,
) -> dict[str, Array]:
    """Row by row: takes blanks around numbers and dates, and names the line that cannot be read."""
    index = [list(names).index(name) for name in wanted]
    rows: list[list[float]] = []
    nothing = set(NO_VALUE)
    pieces = (piece for line in split_lines(head.text())[first + 1 :] for piece in line.split("\r"))
    lines = ("" if piece.lstrip().startswith(comment) else piece for piece in pieces)
    if separator == " ":
        numbered = enumerate((line.split() for line in lines), first + 2)
    else:
        reader = csv.reader((f"{line}\n" for line in lines), delimiter=separator)
        numbered = ((first + 1 + reader.line_num, cells) for cells in reader)
    for number, cells in _readable(numbered, head.path):
        if not any(c.strip() for c in cells):
            continue
        extra = [c for c in cells[len(names) :] if c.strip()]
        if extra:
            raise DataError(
                f"{head.path}, line {number}: {len(cells)} cells where the header names {len(names)} columns. "
                "Correct the line, or the separator."
            )
        row = []
        for k, i in enumerate(index):
            cell = cells[i].strip().strip('"').strip() if i < len(cells) else ""
            row.append(_number(head, number, wanted[k], cell, comma, nothing, clock))
        rows.append(row)
    table = np.array(rows, float).reshape(len(rows), len(wanted))
    return {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(wanted)}


def _readable(rows: Iterator[tuple[int, list[str]]], path: Path) -> Iterator[tuple[int, list[str]]]:
    try:
        yield from rows
    except csv.Error as error:
        raise DataError(f"{path}: a row cannot be read ({error}). Look for a quotation mark that is never closed.") from None


def _number(head: Head, line: int, name: str, cell: str, comma: bool, nothing: set[str], clock: str | None) -> float:
    if cell in nothing:
        return float("nan")
    try:
        if "_" in cell or not cell.isascii():  # Python would read 4_0 and the digits of other alphabets
            raise ValueError
        return float(cell.replace(",", ".") if comma else cell)
    except ValueError:
        moment = _date(cell) if name == clock else None
        if moment is not None:
            return moment
        what = "a number or a date" if name == clock else "a number"
        raise DataError(
            f'{head.path}, line {line}: "{cell[:40]}" in column "{name}" is not {what}. Correct the line, or leave '
            "the cell empty where there is no sample."
        ) from None


def _date(cell: str) -> float | None:
    import polars as pl

    return _dates(pl.Series([cell]))[0]
