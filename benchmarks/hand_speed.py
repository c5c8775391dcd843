"""Speed of the handheld filter beside the same filter in C++ (`hand_twin.cpp`), for the page of `benchmarks/run.py`; alone, it prints.

Every sample has all updates of the paper: both fields static, QSF, MARU and AGU. Calls are interleaved and timed by the thread's processor
time, so that a busy machine slows both alike.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
from ahrs_speed import thread_time

from bematist.hand import HAND, MAGYQ, HandAttitude, HandParameters
from bematist.kernels import hand as kernel
from bematist.kernels import hand_layout as at
from bematist.recording import Recording
from bematist.stance import NO_FLAGS

N, RATE_HZ, ROUNDS = 100_000, 100.0, 9


def resting() -> np.ndarray:
    """Sample rows (N,10) of a sensor in the hand that keeps still."""
    rng = np.random.default_rng(0)
    t = np.arange(N) / RATE_HZ
    return Recording(
        time=t,
        specific_force=np.array([0, 0, 9.80665]) + rng.normal(0, 0.01, (N, 3)),
        angular_rate=np.array([0.001, 0.002, -0.003]) + rng.normal(0, 0.001, (N, 3)),
        magnetic_time=t,
        magnetic_flux_density=np.array([0, 20, -45]) + rng.normal(0, 0.05, (N, 3)),
    ).samples()


def compiled(rows: np.ndarray, parameters: HandParameters) -> tuple[Callable[[], float], np.ndarray]:
    """A timed run of the kernel, and where its results go."""
    columns = np.ascontiguousarray(rows.T)
    nav, diagnostics = np.empty((N, at.NAV)), np.empty((N, at.DIAG), np.float32)

    def call() -> float:
        filter = HandAttitude(parameters)
        filter._start(rows[:1000])
        assert filter._state is not None
        state = filter._state
        return thread_time(lambda: kernel.run(*state, columns, NO_FLAGS, nav, diagnostics))

    return call, nav


def native(rows: np.ndarray, parameters: HandParameters) -> tuple[Callable[[], float], np.ndarray]:
    """The same of the C++ twin."""
    target = Path(tempfile.mkdtemp()) / "twin.so"
    source = Path(__file__).with_name("hand_twin.cpp")
    subprocess.run(["g++", "-O3", "-march=native", "-ffp-contract=fast", "-shared", "-fPIC", "-o", str(target), str(source)], check=True)
    run = ctypes.CDLL(str(target)).hand
    filter = HandAttitude(parameters)
    filter._start(rows[:1000])
    assert filter._state is not None
    index, _, S, prm = filter._state
    columns = np.ascontiguousarray(rows.T)
    nav, diagnostics = np.empty((N, at.NAV)), np.empty((N, at.DIAG), np.float32)
    m, f, dt = at.MAGNETIC, at.FORCE, 1 / RATE_HZ
    gyro = prm[at.PSD_ANGLE] * dt
    numbers = [dt, gyro / 4, prm[at.BIAS_WALK] * dt, prm[at.ACCEL_BIAS_WALK] * dt, 1 - prm[at.ACCEL_DECAY] * dt]
    numbers += [prm[m + at.VARIANCE], prm[f + at.VARIANCE]]
    numbers += [2 * prm[m + at.VARIANCE] + (20**2 + 45**2) * gyro, 2 * prm[f + at.VARIANCE] + 9.8**2 * gyro, prm[m + at.LIMIT]]
    numbers += [prm[m + at.DEVIATION], prm[m + at.OUTLIER], prm[f + at.DEVIATION], prm[f + at.OUTLIER]]
    given = [np.array(numbers), S[at.X : at.X + 10].copy(), S[:256].reshape(16, 16)[:10, :10].copy()]
    pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (columns, *given, nav, diagnostics)]
    sizes = [ctypes.c_int64(int(v)) for v in (N, index[at.LENGTH], index[at.FIRST])]

    def call() -> float:
        return thread_time(lambda: run(sizes[0], *pointers[:4], *sizes[1:], *pointers[4:]))

    return call, nav


def measure() -> tuple[list[tuple[str, str, str]], dict[str, float]]:
    """Rows of the page and nanoseconds a sample; without a compiler only the samples a second."""
    rows = resting()
    only_local = {"attitude": {"magnetic": {"earth": False}, "force": {"earth": False}}}
    calls: dict[str, Callable[[], float]] = {}
    calls["magyq"], one = compiled(rows, MAGYQ.override(only_local))
    calls["hand"], _ = compiled(rows, HAND)
    with suppress(OSError, subprocess.CalledProcessError):
        calls["native magyq"], other = native(rows, MAGYQ.override(only_local))
    for call in calls.values():
        call()
    times = np.array([[call() for call in calls.values()] for _ in range(ROUNDS)]) / N * 1e9
    ns = dict(zip(calls, np.median(times, 0).tolist(), strict=True))
    table = []
    if "native magyq" in calls:
        assert np.abs(one[:, 1:5] - other[:, 1:5]).max() < 1e-9  # the same attitudes, or it is no yardstick
        ratio = float(np.median(times[:, 0] / times[:, 2]))
        table.append(("handheld attitude by `magyq`, every update on every sample, against native C++", f"{ratio:.2f}", "≤ 1.3"))
    for name, aim in (("magyq", "≥ 1.5 million"), ("hand", "–")):
        table.append((f"the same by `{name}`", f"{1e3 / ns[name]:.2f} million samples a second", aim))
    return table, ns


def main() -> None:
    table, ns = measure()
    for what, measured, aim in table:
        print(f"{what}: {measured} (aim {aim})")
    print(", ".join(f"{name} {value:.0f} ns a sample" for name, value in ns.items()))


if __name__ == "__main__":
    main()
