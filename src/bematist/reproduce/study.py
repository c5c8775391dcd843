"""What a study is: parts (a figure or table of a paper), each made of cases that are computed alone and then shown together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import polars as pl

    from bematist.reproduce.page import Page

Settings = Mapping[str, Any]
"""What a case is computed from: names, numbers and lists only, as JSON holds them."""

Row = dict[str, Any]
"""Named numbers and words; NaN becomes None."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a case gave: rows of numbers, and arrays for the figures."""

    rows: Sequence[Row]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Result:
    """A stored case."""

    settings: Settings
    rows: list[Row]
    seconds: float
    file: Path | None = None

    @cached_property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays of the case, read when they are asked for."""
        if self.file is None:
            return {}
        with np.load(self.file) as found:
            return dict(found)


@dataclass(frozen=True, eq=False)
class Results:
    """All cases of a part."""

    cases: list[Result]

    @cached_property
    def frame(self) -> pl.DataFrame:
        """The rows of all cases, each with the plain settings of its case."""
        import polars as pl

        plain = [{k: v for k, v in c.settings.items() if isinstance(v, str | int | float)} for c in self.cases]
        rows = [{**base, **row} for base, c in zip(plain, self.cases, strict=True) for row in c.rows]
        return pl.DataFrame(rows, infer_schema_length=None)

    def where(self, **settings: Any) -> list[Result]:
        """The cases with these settings."""
        return [c for c in self.cases if all(c.settings.get(k) == v for k, v in settings.items())]


@dataclass(frozen=True)
class Part:
    """A figure or table.

    Attributes
    ----------
    name, title : for the command line, and for the report.
    cases : settings of the cases, from the number of seeds.
    compute : one case. A function of a module, so that another process finds it.
    show : draws all results into a page.
    seconds : about how long one case takes.
    alone : computed with nothing else at the same time, because it measures time.
    """

    name: str
    title: str
    cases: Callable[[int], list[Settings]]
    compute: Callable[[Settings], Found]
    show: Callable[[Results, Page], None]
    seconds: float
    alone: bool = False


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper, what was found, and why the two differ where they do."""

    claim: str
    printed: str
    found: str
    verdict: str
    why: str


@dataclass(frozen=True)
class Study:
    """What is reproduced of one paper.

    `claims` answers from the results of the parts that are there, by their names.
    """

    name: str
    title: str
    paper: str
    introduction: Sequence[str]
    parts: tuple[Part, ...]
    claims: Callable[[Mapping[str, Results]], list[Claim]]
    seeds: int = 20


@dataclass(frozen=True)
class Case:
    """A part and the settings of one of its cases."""

    part: Part
    settings: Settings

    def __str__(self) -> str:
        plain = (f"{k} {v}" for k, v in self.settings.items() if isinstance(v, str | int | float))
        return f"{self.part.name}, {', '.join(plain)}"
