"""The Allan deviation: how fast, and whether its intervals hold the truth.

python benchmarks/allan.py speed          5 h at 238 Hz, 6 axes, beside allantools on the same averaging times
python benchmarks/allan.py study [SEEDS]  the papers' tables of noises: 5 h of rest of each, simulated, identified by `bm.allan`; 20 seeds
                                          without a number, and then the table of docs/allan.md; what is finished is kept in build/allan
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import allantools
import numpy as np
from allan_study import HOURS, STUDY, lines
from pages import ROOT, fill

from bematist.allan.deviation import Stretches, averaging_spans, overlapping_variance
from bematist.cli.console import progress
from bematist.reproduce.run import Run

RATE_HZ, AXES, ROUNDS = 238.0, 6, 5


def speed() -> dict[str, float]:
    """Seconds of one thread for all axes, least of five rounds, allantools' for as many, and their ratio."""
    n = int(HOURS * 3600 * RATE_HZ)
    values = np.random.default_rng(0).standard_normal((AXES, n))
    pieces, spans, room = Stretches((slice(0, n),), 1 / RATE_HZ), averaging_spans(n), np.empty(n + 1)

    def ours() -> None:
        for axis in range(AXES):
            overlapping_variance(values[axis], pieces, spans, room)

    def theirs() -> None:
        allantools.oadev(values[0], rate=RATE_HZ, data_type="freq", taus=spans / RATE_HZ)

    ours()
    pairs = [(_seconds(ours), AXES * _seconds(theirs)) for _ in range(ROUNDS)]  # one after the other: a busy machine slows both alike
    fast, slow = (min(p[k] for p in pairs) for k in (0, 1))
    return {"seconds": fast, "allantools_seconds": slow, "ratio": float(np.median([b / a for a, b in pairs]))}


def _seconds(call: Callable[[], None]) -> float:
    start = time.thread_time()
    call()
    return time.thread_time() - start


def study(seeds: int) -> None:
    """Simulate and identify what is not kept yet, print the table, and with the study's own number of seeds write it into docs/allan.md."""
    run = Run(STUDY, ROOT / "build" / "allan", seeds=seeds)
    print(
        f"{run.total} rests of {HOURS:g} h, {run.done} kept, about {run.expected_s / 60:.0f} min for the others on one processor",
        flush=True,
    )
    with progress("noise study") as tell:
        run.compute(1, tell)
    results = run.results(STUDY.parts[0])
    assert results is not None
    table = lines(results)
    print("\n".join(table))
    if seeds == STUDY.seeds:
        fill(ROOT / "docs" / "allan.md", "study", table)


if __name__ == "__main__":
    if sys.argv[1:2] == ["study"]:
        study(int(sys.argv[2]) if len(sys.argv) > 2 else STUDY.seeds)
    else:
        print({key: round(value, 4) for key, value in speed().items()})
