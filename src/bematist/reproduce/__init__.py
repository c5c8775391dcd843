"""Each paper's tables and figures made anew: `bematist reproduce PAPER`.

A study (`study.Study`) has parts, a part has cases; `run.Run` computes the missing cases on several processes, keeps each as soon as it is
finished (`store`), and writes one report (`page`).
"""

from __future__ import annotations

import importlib
from pathlib import Path

from bematist import config
from bematist.reproduce.study import Study

PAPERS = ("maginav", "li-wang", "magyq")
"""The papers; each is a package of this name, with _ for -, with its `STUDY`."""


def find_study(paper: str) -> Study:
    """The study of a paper; UsageError names the nearest."""
    return importlib.import_module(f"bematist.reproduce.{config.choose('paper', paper, PAPERS).replace('-', '_')}").STUDY


def reproduce(paper: str, folder: str | Path, *, seeds: int | None = None, jobs: int = 1, only: tuple[str, ...] = ()) -> Path:
    """Compute what is missing of a study in `folder`, and write its tables, figures and report.md, whose path is returned.

    Parameters
    ----------
    paper : a name of `PAPERS`.
    seeds : number of simulated walks of each kind; None: the study's own.
    jobs : processes; with more than one, the script that calls needs `if __name__ == "__main__"`.
    only : names of parts; empty: all.

    Raises
    ------
    UsageError
        An unknown paper or part.
    DataError
        A case cannot be computed, or the folder cannot be written.
    """
    from bematist.reproduce.run import Run

    run = Run(find_study(paper), Path(folder), seeds=seeds, only=only)
    run.compute(jobs)
    return run.write()
