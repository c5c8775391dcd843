"""`reproduce`: a paper's tables and figures, made anew."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import complain, output, progress, seconds, table

if TYPE_CHECKING:
    from bematist.reproduce.run import Run


@app.command()
def reproduce(
    paper: Annotated[str | None, typer.Argument(help="Name of the paper; without it, the papers are listed.", metavar="[PAPER]")] = None,
    output_folder: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of the results; without it, reproduce-PAPER.", metavar="DIR")
    ] = None,
    seeds: Annotated[int | None, typer.Option("--seeds", help="Number of simulated walks of each kind.", min=1)] = None,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", help="Processes; without it, one for each processor.", min=1)] = None,
    only: Annotated[str | None, typer.Option("--only", help="Parts with commas between; without it, all.", metavar="NAME,…")] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Forget what is stored, and compute everything again.")] = False,
    list_only: Annotated[bool, typer.Option("--list", help="List the papers and their parts.")] = False,
    quiet: options.Quiet = False,
) -> None:
    """Compute a paper's tables and figures anew.

    Over many simulated walks, into a folder with report.md. It can be interrupted: what is finished is kept, and the same command goes on
    from there.
    """
    from bematist.reproduce import PAPERS, find_study
    from bematist.reproduce.run import Run, processors

    if paper is None or list_only:
        _list([paper] if paper else PAPERS)
        return
    study = find_study(paper)
    folder = output_folder or Path(f"reproduce-{paper}")
    names = [name.strip() for name in (only or "").split(",") if name.strip()]
    run = Run(study, folder, seeds=seeds, only=names, fresh=fresh)
    jobs = jobs or processors()
    if not quiet:
        _announce(run, jobs)
    with _kept(run, folder), progress(f"reproducing {paper}", quiet=quiet) as tell:
        run.compute(jobs, tell)
        report = run.write()
    if not quiet:
        output().print(f"{run.total} cases, report in {report}", soft_wrap=True)


def _announce(run: Run, jobs: int) -> None:
    if run.stale:
        complain(f"{run.stale} stored case(s) were made by other code, or are not wanted any more: they are computed again.")
    if run.done < run.total:
        kept = f", {run.done} are there already" if run.done else ""
        complain(f"{run.total} cases{kept}; about {seconds(run.expected_s / jobs)} on {jobs} process(es).")


@contextmanager
def _kept(run: Run, folder: Path) -> Iterator[None]:
    """Interrupted, say what is kept."""
    try:
        yield
    except KeyboardInterrupt:
        complain(f"interrupted; {run.done} of {run.total} cases are kept in {folder / 'cases'}, and the same command goes on from there.")
        raise typer.Exit(130) from None


def _list(papers: list[str] | tuple[str, ...]) -> None:
    from bematist.reproduce import find_study

    rows = []
    for study in map(find_study, papers):
        for part in study.parts:
            cases = part.cases(study.seeds)
            rows.append([study.name, part.name, part.title, str(len(cases)), seconds(part.seconds * len(cases))])
    output().print(table(["paper", "part", "what it is", "cases", "on one processor"], rows, right=(3, 4)))
    output().print("bematist reproduce PAPER [--only PART,PART] [--seeds N] [-o DIR]")
