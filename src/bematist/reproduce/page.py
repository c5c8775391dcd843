"""The report of a study: text, tables (Markdown, and CSV beside it) and figures (PNG in the page, SVG beside it)."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bematist
from bematist.outputs import whole_file

if TYPE_CHECKING:
    import polars as pl
    from matplotlib.figure import Figure

    from bematist.reproduce.study import Claim, Results, Study

Cell = str | float | int | None


class Page:
    """Collects the report of a study in a folder; tables and figures are written at once, `write` writes report.md."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lines: list[str] = []
        for name in ("tables", "figures"):
            (folder / name).mkdir(parents=True, exist_ok=True)

    def opening(self, study: Study, seeds: int, claims: Sequence[Claim]) -> None:
        """Title, what was run, and the claims of the paper one by one."""
        self._lines += [f"# {study.title}", ""]
        self.text(
            f"Paper: {study.paper}.",
            f"Made by `bematist reproduce {study.name} --seeds {seeds}`, bematist {bematist.__version__}.",
            *study.introduction,
        )
        if seeds == 1:
            self.text("One walk of each kind: where medians and quantiles are spoken of, that walk's own number stands.")
        if claims:
            self.heading("The claims, one by one")
            header = ["what the paper says", "print", "here", "verdict", "why"]
            self.table("claims", header, [[c.claim, c.printed, c.found, c.verdict, c.why] for c in claims])

    def heading(self, text: str) -> None:
        self._lines += [f"## {text}", ""]

    def text(self, *paragraphs: str) -> None:
        for paragraph in paragraphs:
            self._lines += [paragraph, ""]

    def table(self, name: str, header: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str = "") -> None:
        """A table in the page, and tables/NAME.md and .csv. Numbers are written with four digits in the page, in full in the CSV."""
        self._csv(name, [dict(zip(header, row, strict=True)) for row in rows])
        self._markdown(name, header, rows, caption)

    def spread(self, name: str, frame: pl.DataFrame, by: Sequence[str], columns: Mapping[str, str], caption: str = "") -> None:
        """A table of medians over the rows of each group, in brackets the 10 % and 90 % quantiles and the worst (the largest in size).

        columns: headers, and the columns of the frame. The CSV has a row for each group and quantity.
        """
        import numpy as np

        cells, long = [], []
        for key, group in frame.group_by(by, maintain_order=True):
            row: list[Cell] = [str(k) for k in key]
            for header, column in columns.items():
                values = group[column].drop_nulls().to_numpy()
                if not len(values):
                    row.append(None)
                    continue
                low, middle, high = np.quantile(values, [0.1, 0.5, 0.9])
                worst = float(values[np.abs(values).argmax()])
                row.append(f"{middle:.3g} ({low:.3g} – {high:.3g}; {worst:.3g})" if len(values) > 1 else f"{middle:.3g}")
                long.append(dict(zip(by, key, strict=True)) | {"quantity": header, "runs": len(values), "median": middle})
                long[-1] |= {"quantile_10": low, "quantile_90": high, "worst": worst}
            cells.append(row)
        self._csv(name, long)
        self._markdown(name, [*by, *columns], cells, caption)

    def raw(self, part: str, results: Results) -> None:
        """Every row of every case: tables/PART-cases.csv."""
        with whole_file(self.folder / f"tables/{part}-cases.csv") as place:
            results.frame.write_csv(place)

    def figure(self, name: str, figure: Figure, caption: str) -> None:
        """A figure in the page: figures/NAME.png and .svg."""
        for kind in ("png", "svg"):
            picture = io.BytesIO()
            figure.savefig(picture, format=kind, dpi=100, metadata={"Date": None} if kind == "svg" else {})
            with whole_file(self.folder / f"figures/{name}.{kind}") as place:
                place.write_bytes(picture.getvalue())
        self._lines += [f"![{caption}](figures/{name}.png)", "", f"*{caption}*", ""]

    def write(self) -> Path:
        """Write report.md; returns its path."""
        self._save("report.md", "\n".join(self._lines).rstrip() + "\n")
        return self.folder / "report.md"

    def _save(self, name: str, text: str) -> None:
        with whole_file(self.folder / name) as place:
            place.write_text(text, "utf-8")

    def _markdown(self, name: str, header: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str) -> None:
        lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
        lines += ["| " + " | ".join(_shown(cell) for cell in row) + " |" for row in rows]
        self._save(f"tables/{name}.md", "\n".join(lines) + "\n")
        self._lines += [*([caption, ""] if caption else []), *lines, ""]

    def _csv(self, name: str, rows: list[dict[str, Any]]) -> None:
        import polars as pl

        with whole_file(self.folder / f"tables/{name}.csv") as place:
            pl.DataFrame(rows, infer_schema_length=None, strict=False).write_csv(place)


def _shown(cell: Cell) -> str:
    if cell is None or (isinstance(cell, float) and not math.isfinite(cell)):
        return "–"
    return cell.replace("|", "\\|") if isinstance(cell, str) else f"{cell:.4g}"
