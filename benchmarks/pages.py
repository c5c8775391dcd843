"""Tables inside pages: what a benchmark prints replaces what stands between the two comments of its name."""

from collections.abc import Iterable
from pathlib import Path


def fill(page: Path, name: str, lines: Iterable[str]) -> None:
    """Put lines between `<!-- name -->` and `<!-- /name -->` of a page."""
    start, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
    before, rest = page.read_text("utf-8").split(start)
    page.write_text("".join([before, start, *(f"{line}\n" for line in lines), end, rest.split(end)[1]]), "utf-8")
