"""Parquet → table, with damaged files told in words."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from bematist.errors import DataError

if TYPE_CHECKING:
    import polars as pl


def columns_of(path: Path) -> list[str]:
    """Names of the columns of a Parquet file. Raises DataError where it cannot be read."""
    import polars as pl

    with _told(path):
        return list(pl.read_parquet_schema(path))


def read_parquet(path: Path, columns: Sequence[str] | None = None) -> pl.DataFrame:
    """Columns (or all) of a Parquet file. Raises DataError where it cannot be read."""
    import polars as pl

    with _told(path):
        return pl.read_parquet(path, columns=None if columns is None else list(columns), glob=False)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Errors of polars as DataError. On damaged files it panics: no `Exception`, and a page of Rust on stderr."""
    try:
        with _panics_dropped():
            yield
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt | SystemExit | GeneratorExit):
            raise
        reason = "its content is damaged" if _is_panic(error) else (str(error).splitlines() or [""])[0][:120]
        raise DataError(f"{path}: this Parquet file cannot be read ({reason}). It may be cut short or damaged: write it anew.") from None


def _is_panic(error: BaseException) -> bool:
    return type(error).__name__ == "PanicException"


@contextmanager
def _panics_dropped() -> Iterator[None]:
    """What native code writes to stderr meanwhile is kept back, and dropped if it panics."""
    sys.stderr.flush()
    try:
        stderr = os.dup(2)
    except OSError:  # a process without stderr
        yield
        return
    panicked = False
    with tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), 2)
        try:
            yield
        except BaseException as error:
            panicked = _is_panic(error)
            raise
        finally:
            os.dup2(stderr, 2)
            os.close(stderr)
            said.seek(0)
            if not panicked and (text := said.read()):
                os.write(2, text)
