"""What the user sees: paragraphs and progress on stderr, results on stdout."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

Progress = Callable[[float], None]
"""Called with the fraction that is done, 0 … 1."""


def output(*, stderr: bool = False) -> Console:
    """A rich console; not wider than the terminal, and not folded into 80 columns where the output is a file."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr, width=None if stream.isatty() else 160, highlight=False, markup=False, emoji=False)


def complain(text: str, what: str = "bematist") -> None:
    """One paragraph on stderr: folded at words in a terminal, one line elsewhere."""
    import shutil
    import textwrap

    line = f"{what}: {' '.join(text.split())}"
    if sys.stderr.isatty():
        line = textwrap.fill(line, shutil.get_terminal_size().columns, break_long_words=False, break_on_hyphens=False)
    print(line, file=sys.stderr)


def warn(texts: Iterable[str]) -> None:
    """Warnings, a paragraph each, every one once."""
    for text in dict.fromkeys(texts):
        complain(text, "warning")


@contextmanager
def progress(what: str, *, quiet: bool = False) -> Iterator[Progress]:
    """A bar on stderr, in a terminal only; it vanishes when the work is done."""
    if quiet or not sys.stderr.isatty():
        yield lambda fraction: None
        return
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Bar(*columns, console=output(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)  # a moving bar until the first fraction is told
        with compiling_told(lambda words: bar.update(task, description=words or what)):
            yield lambda fraction: bar.update(task, total=1.0, completed=fraction)


@contextmanager
def compiling_told(describe: Callable[[str], object]) -> Iterator[None]:
    """Where a kernel must be compiled meanwhile, the first time on a machine, `describe` it; and nothing ("") when that is done."""
    from bematist.kernels import jit

    @contextmanager
    def announce(kernel: str) -> Iterator[None]:
        describe(f"compiling {kernel.removeprefix('bematist.kernels.')} for this machine, once")
        yield
        describe("")

    before, jit.announce = jit.announce, announce
    try:
        yield
    finally:
        jit.announce = before


def table(
    header: Sequence[str], rows: Iterable[Sequence[str]], *, right: Sequence[int] = (), title: str = "", apart: bool = False
) -> Table:
    """A table without frame; columns whose index is in `right` are aligned to the right, `apart` leaves a line between rows."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    t = Table(box=SIMPLE_HEAD, title=title or None, title_justify="left", title_style="bold", pad_edge=False, show_edge=False)
    t.show_lines = apart
    for k, name in enumerate(header):
        t.add_column(name, justify="right" if k in right else "left", overflow="fold")
    for row in rows:
        t.add_row(*row)
    return t


def facts(rows: Iterable[tuple[str, str]]) -> Table:
    """Names and values in two columns."""
    from rich.table import Table

    t = Table.grid(padding=(0, 2))
    t.add_column(style="cyan", no_wrap=True)
    t.add_column(overflow="fold")
    for name, value in rows:
        t.add_row(name, value)
    return t


def seconds(value: float) -> str:
    """A duration as people say it: 0.21 s, 42 s, 10 min 3 s."""
    if value < 10:
        return f"{value:.2g} s"
    if value < 120:
        return f"{value:.0f} s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes} min {rest} s" if minutes < 120 else f"{minutes // 60} h {minutes % 60} min"
