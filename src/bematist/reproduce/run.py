"""Compute the cases of a study that are missing, on several processes, and write the report."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from pathlib import Path

from bematist import config
from bematist.errors import BematistError, DataError, UsageError
from bematist.reproduce.page import Page
from bematist.reproduce.store import Store
from bematist.reproduce.study import Case, Found, Part, Results, Settings, Study

Tell = Callable[[float], None]
"""Called with the share of the work that is done, 0 … 1."""


class Run:
    """A study in a folder.

    Attributes
    ----------
    total, done : number of cases, and how many of them are stored.
    stale : stored cases that were dropped, because another version of the code had made them or because of `fresh`.
    """

    def __init__(self, study: Study, folder: Path, *, seeds: int | None = None, only: Sequence[str] = (), fresh: bool = False) -> None:
        """Look what is in the folder. `only` names parts; fresh drops what is stored of them.

        Raises
        ------
        UsageError
            A part is unknown, or there is no seed.
        DataError
            The folder cannot be used.
        """
        seeds = study.seeds if seeds is None else seeds
        if seeds < 1:
            raise UsageError(f"--seeds {seeds}: at least one seed is needed.")
        names = [config.choose(f"part of {study.name}", name, (p.name for p in study.parts)) for name in only]
        self.study, self.folder, self.seeds = study, folder, seeds
        self.parts = [p for p in study.parts if not names or p.name in names]
        self._cases = {p.name: [Case(p, s) for s in p.cases(seeds)] for p in study.parts}
        self._store = Store(folder / "cases")
        self._store.open(study.parts)
        self.stale = self._store.forget(self.parts, everything=fresh)
        wanted = [case for p in self.parts for case in self._cases[p.name]]
        self._missing = [case for case in wanted if self._store.get(case) is None]
        self.total, self.done = len(wanted), len(wanted) - len(self._missing)

    @property
    def expected_s(self) -> float:
        """About how long the missing cases take on one processor, s."""
        return sum(case.part.seconds for case in self._missing)

    def compute(self, jobs: int = 1, tell: Tell = lambda share: None) -> None:
        """Compute what is missing; every case is stored when it is finished.

        Raises
        ------
        DataError
            A case cannot be computed. What was finished before stays.
        """
        whole, gone = self.expected_s, 0.0
        alone = [case for case in self._missing if case.part.alone]
        rest = [case for case in self._missing if not case.part.alone]
        for finished in (_serial(alone), _parallel(rest, jobs) if min(jobs, len(rest)) > 1 else _serial(rest)):
            with closing(finished):
                for case, found, seconds in finished:
                    self._store.put(case, found, seconds)
                    self.done += 1
                    gone += case.part.seconds
                    tell(gone / whole)
        self._missing = []

    def write(self) -> Path:
        """Write tables, figures and report.md of the parts that are complete; returns the path of the report."""
        found = {p.name: self.results(p) for p in self.study.parts}
        complete = {name: results for name, results in found.items() if results is not None}
        page = Page(self.folder)
        page.opening(self.study, self.seeds, self.study.claims(complete))
        for part in self.study.parts:
            page.heading(part.title)
            if part.name in complete:
                page.raw(part.name, complete[part.name])
                part.show(complete[part.name], page)
            else:
                page.text(f"Not computed yet: `bematist reproduce {self.study.name} --only {part.name}`.")
        return page.write()

    def results(self, part: Part) -> Results | None:
        """All cases of a part; None while one is missing."""
        cases = [self._store.get(case) for case in self._cases[part.name]]
        there = [case for case in cases if case is not None]
        return Results(there) if len(there) == len(cases) else None


def _timed(compute: Callable[[Settings], Found], settings: Settings) -> tuple[Found, float]:
    start = time.perf_counter()
    return compute(settings), time.perf_counter() - start


def _serial(cases: Sequence[Case]) -> Generator[tuple[Case, Found, float]]:
    for case in cases:
        try:
            yield case, *_timed(case.part.compute, case.settings)
        except BematistError as error:
            raise _failed(case, error) from error


def _parallel(cases: Sequence[Case], jobs: int) -> Generator[tuple[Case, Found, float]]:
    # Not forked: a progress bar and a BLAS have threads.
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"))
    try:
        with _interrupts_held():
            waiting = {pool.submit(_timed, case.part.compute, case.settings): case for case in cases}
        while waiting:
            # Woken now and then: a signal that another thread took does not wake this one.
            for future in wait(waiting, 0.5, FIRST_COMPLETED).done:
                case = waiting.pop(future)
                try:
                    yield case, *future.result()
                except BrokenProcessPool:
                    raise DataError("A process of the study was ended from outside: is there enough memory? Try fewer --jobs.") from None
                except BematistError as error:
                    raise _failed(case, error) from error
        pool.shutdown()
    except BaseException:
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        raise


@contextmanager
def _interrupts_held() -> Generator[None]:
    """Ctrl-C goes to every process of the terminal, but only the first shall answer: processes that are started in this block never do."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    old = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, old)


def _failed(case: Case, error: BematistError) -> DataError:
    return DataError(f"{case}: {error} What was finished is kept.")


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
