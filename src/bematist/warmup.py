"""`python -m bematist.warmup`: compile every kernel and module once into the cache, so that the first real run need not wait."""

import compileall
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

import bematist
from bematist import clockfit, steps
from bematist.ahrs import attitude
from bematist.allan.deviation import Stretches, averaging_spans, overlapping_variance
from bematist.calibrate.turning import turned
from bematist.foot import FootIns
from bematist.hand import HandAttitude, HandPdr
from bematist.io import read, write_recording
from bematist.io.trajectory_files import write_csv
from bematist.kernels import hand as attitude_kernel
from bematist.recording import Recording
from bematist.stance import analyse

Array = NDArray[Any]


def still() -> Recording:
    """A second of nothing."""
    rng = np.random.default_rng(0)
    n = 100
    force = np.tile([0.0, 0.0, 9.8], (n, 1)) + rng.normal(0, 0.01, (n, 3))
    force[50] = np.nan  # so that the filling of missing values is compiled too
    return Recording(time=np.arange(n) / 100, specific_force=force, angular_rate=rng.normal(0, 0.001, (n, 3)))


def foot() -> None:
    """The kernels of a path: filter, detector, clock, and the numbers of CSV files, written and read."""
    recording = still()
    with tempfile.TemporaryDirectory() as folder:
        write_csv(FootIns().run(recording), Path(folder) / "trajectory.csv")
        write_recording(recording, Path(folder) / "recording.csv")
        read(Path(folder) / "recording.csv")
    analyse(recording)
    clockfit.uniform(recording.time + np.random.default_rng(1).uniform(0, 0.02, len(recording)))


def attitudes() -> None:
    """The attitude filters."""
    attitude(still())
    HandAttitude().run(still())


class Level:
    """In place of the kernel that a hand's path begins with: the attitude of a device that lies level."""

    def __call__(self, *arguments: Array) -> int:
        *_, columns, _, nav, diagnostics = arguments
        nav[:], diagnostics[:] = 0, 0
        nav[:, :2] = np.column_stack([columns[0], np.ones(columns.shape[1])])
        return len(nav)

    def bind(self, *arguments: Array) -> Callable[[], int]:
        return partial(self, *arguments)


def paths() -> None:
    """The path of a hand after its attitude, which takes as long to compile on the other processor, and the steps alone."""
    with patch.object(attitude_kernel, "run", Level()):
        HandPdr().run(still())
    steps.analyse(still())


def noise() -> None:
    """The Allan deviation."""
    overlapping_variance(still().specific_force[:50, 2].copy(), Stretches((slice(0, 50),), 0.01), averaging_spans(50))


def calibration() -> None:
    """The turns of a calibration."""
    turned(np.ones((5, 3)), np.full(5, 0.01), np.eye(3))


def warm_up() -> None:
    """Run every compiled kernel, on all processors; modules are compiled too, also where the interpreter is told to leave no bytecode."""
    compileall.compile_dir(bematist.__path__[0], quiet=2)
    with ProcessPoolExecutor() as pool:
        for done in [pool.submit(job) for job in (attitudes, paths, foot, noise, calibration)]:
            done.result()


if __name__ == "__main__":
    warm_up()
