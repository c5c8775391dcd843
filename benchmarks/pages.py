"""What benchmarks share: where the recordings are, and tables inside pages, between the two comments of their name."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("BEMATIST_SHARED", ROOT.parent / "shared" / "data"))


def required(*folders: str) -> None:
    """End the program where one of the folders of recordings is missing."""
    if not all((DATA / folder).is_dir() for folder in folders):
        names = ", ".join(f"{folder}/" for folder in folders)
        sys.exit(f"The recordings are not at {DATA}: set BEMATIST_SHARED to the folder that holds {names}.")


def fill(page: Path, name: str, lines: Iterable[str]) -> None:
    """Put lines between `<!-- name -->` and `<!-- /name -->` of a page."""
    start, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
    before, rest = page.read_text("utf-8").split(start)
    page.write_text("".join([before, start, *(f"{line}\n" for line in lines), end, rest.split(end)[1]]), "utf-8")
