"""Speed, as ratios measured in the same run: `make bench` writes docs/speed.md.

The yardstick is a C++ program of the same filter, built here for this machine when a compiler and its source are at hand (the source is
looked for at BEMATIST_YARDSTICK, then beside the project). Calls are interleaved and timed by the thread's processor time, so that a
busy machine slows both alike.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

import ahrs_speed  # noqa: E402
import hand_speed  # noqa: E402
from ahrs_speed import thread_time  # noqa: E402

import bematist as bm  # noqa: E402
import twin  # noqa: E402
from bematist import stance  # noqa: E402
from bematist.foot import FootIns  # noqa: E402
from bematist.io import write_recording  # noqa: E402
from bematist.kernels import foot as filter_kernel  # noqa: E402
from bematist.kernels import layout  # noqa: E402
from bematist.kernels import stance as stance_kernel  # noqa: E402
from bematist.methods import worn  # noqa: E402
from bematist.simulate import simulate  # noqa: E402

YARDSTICK = Path(os.environ.get("BEMATIST_YARDSTICK", ROOT.parent / "shared" / "yardstick" / "floor.cpp"))
ROUNDS = 15
WINDOW = 9
NATIVE_METHODS = ("foot", "zupt", "maginav", "common-9")


def yardstick() -> ctypes.CDLL | None:
    """The C++ yardstick, compiled for this processor; None without source or compiler."""
    target = Path(tempfile.mkdtemp()) / "floor.so"
    command = ["g++", "-O3", "-march=native", "-ffp-contract=fast", "-shared", "-fPIC", "-o", str(target), str(YARDSTICK)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return ctypes.CDLL(str(target))


class Native:
    """The yardstick's filters and detector over the same samples."""

    def __init__(self, library: ctypes.CDLL, rows: np.ndarray, standing: np.ndarray) -> None:
        self.compiled, self.n = library, len(rows)
        self.accel, self.gyro = np.ascontiguousarray(rows[:, 1:4]), np.ascontiguousarray(rows[:, 4:7])
        self.standing = standing.astype(np.uint8)
        self.parameters = np.array([-9.80665, 1e-6, 1e-4, 0, 1e-9, 1e-11, 1e-4])
        self.p0 = np.repeat([3e-4, 0, 0, 2.5e-3, 1e-6], 3) + 1e-12
        self.x0, self.out, self.P = np.eye(1, 16)[0], np.empty((self.n, 16)), np.empty((15, 15))
        self.T = np.empty(self.n)

    @staticmethod
    def _p(a: np.ndarray) -> ctypes.c_void_p:
        return a.ctypes.data_as(ctypes.c_void_p)

    def filter(self, layout_name: str) -> None:
        arrays = [self.parameters, self.p0, self.x0, self.out, self.P]
        getattr(self.compiled, f"ins_{layout_name}")(
            ctypes.c_int64(self.n), *map(self._p, (self.accel, self.gyro, self.standing)), ctypes.c_double(1 / 238), *map(self._p, arrays)
        )

    def detector(self) -> None:
        scalars = [ctypes.c_double(v) for v in (0.09, 0.00274, 9.80665)]
        self.compiled.shoe_running(ctypes.c_int64(self.n), self._p(self.accel), self._p(self.gyro), WINDOW, *scalars, self._p(self.T))


def filter_call(rows: np.ndarray, method: str) -> Callable[[], float]:
    """Thread time of the whole compiled filter, detector and covariances included, over rows."""
    columns = np.ascontiguousarray(rows.T)
    nav, diagnostics = np.empty((len(rows), layout.NAV)), np.empty((len(rows), layout.DIAG), np.float32)

    def call() -> float:
        ins = FootIns(bm.METHODS[method].parameters)
        ins._start(rows[:2380])
        assert ins._state is not None
        index, memory, S, prm = ins._state
        scratch = stance.scratch(index, len(rows))
        return thread_time(lambda: filter_kernel.run(index, memory, S, prm, columns, stance.NO_FLAGS, False, scratch, nav, diagnostics))

    return call


def detector_call(rows: np.ndarray) -> Callable[[], float]:
    p = bm.METHODS["zupt"].parameters.stance
    statistics_only = np.empty((0, 3))
    columns = np.ascontiguousarray(rows.T)

    def call() -> float:
        index, memory = stance.memory(p, 238.0)
        assert index[stance_kernel.WINDOW] == WINDOW
        scratch = stance.scratch(index, len(rows))
        arguments = (1 / 0.09, 1 / 0.00274, 9.80665, 150.0, 0.01, 5.0, 2.0, scratch, statistics_only)
        return thread_time(lambda: stance_kernel.detect(index, memory, columns, stance.NO_FLAGS, False, *arguments))

    return call


def numpy_loop(rows: np.ndarray, standing: np.ndarray) -> float:
    """Thread time per sample of the same filter written with NumPy matrices."""
    dense = twin.Filter(np.eye(3), np.zeros(3), np.diag(np.repeat([3e-4, 0, 0, 2.5e-3, 1e-6], 3)), np.full(5, 1e-6), 9.80665)

    def loop() -> None:
        for k in range(1, 3000):
            dense.step(rows[k, 1:4], rows[k, 4:7], 1 / 238, 0.01 * standing[k])

    return min(thread_time(loop) for _ in range(3)) / 2999


def step_call(rows: np.ndarray) -> float:
    """Seconds of one-sample calls from Python, each."""
    ins = FootIns(bm.METHODS["zupt"].parameters)
    ins.update(rows[:3000])
    single = [np.ascontiguousarray(rows[k : k + 1]) for k in range(3000, 13_000)]

    def loop() -> None:
        for row in single:
            ins.step(row)

    return min(thread_time(loop) for _ in range(5)) / len(single)


PROBE = """
import os, resource, sys, time
started = time.perf_counter()
os.spawnv(os.P_WAIT, sys.argv[1], sys.argv[1:])
wall, used = time.perf_counter() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_utime + used.ru_stime, wall, used.ru_maxrss / 1024)
"""
"""Measures a command from a process of its own: the peak memory of a process is never less than that of the one which starts it."""


def command(*arguments: str) -> tuple[float, float, float]:
    """Processor seconds, wall seconds and peak MB of the whole command."""
    program = str(Path(sys.executable).parent / "bematist")
    out = subprocess.run([sys.executable, "-c", PROBE, program, *arguments], capture_output=True, text=True, check=True)
    cpu, wall, memory = map(float, out.stdout.split()[-3:])
    return cpu, wall, memory


def whole_command(recording: bm.Recording) -> list[tuple[str, str, str]]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.csv"
        write_recording(recording, path)
        plain = [command("track", str(path), "--method", "zupt", "-o", f"{folder}/a", "--no-report", "--quiet") for _ in range(6)][1:]
        report = [command("track", str(path), "--method", "zupt", "-o", f"{folder}/b", "--quiet") for _ in range(4)][1:]
        phone = Path(folder) / "phone.csv"
        write_recording(simulate("building", "phone", carry="texting", length_m=900), phone)
        hand = [command("track", str(phone), "--method", "hand", "-o", f"{folder}/c", "--no-report", "--quiet") for _ in range(6)][1:]
        hello = [command("--help") for _ in range(4)][1:]
    cpu, wall, memory = np.median(plain, 0)
    of_hand = np.median(hand, 0)
    return [
        ("`bematist track`, 20 minutes of CSV, without report", f"{cpu:.2f} s processor time, {wall:.2f} s wall", "< 2 s processor time"),
        ("its peak memory", f"{memory:.0f} MB", "< 400 MB"),
        ("the same with report", f"{np.median(report, 0)[1]:.2f} s wall", "< 4 s"),
        (
            "`bematist track --method hand`, 10 minutes of a phone, without report",
            f"{of_hand[0]:.2f} s processor time, {of_hand[1]:.2f} s wall",
            "< 1 s processor time",
        ),
        ("`bematist --help`", f"{np.median(hello, 0)[1]:.2f} s wall", "< 0.5 s"),
    ]


def main() -> None:
    recording = simulate("campus", seed=0)
    rows = recording.samples()
    rows = np.concatenate([rows, rows])[:285_600]
    rows[:, 0] = np.arange(len(rows)) / 238
    n = len(rows)
    standing = stance.detect(rows, bm.METHODS["zupt"].parameters.stance, 238.0)[:, 2] > 0
    calls: dict[str, Callable[[], float]] = {m: filter_call(rows, m) for m in worn("shoe")}
    calls["detector"] = detector_call(rows)
    library = yardstick()
    if library is not None:
        native = Native(library, rows, standing)
        calls["native rows"] = lambda: thread_time(lambda: native.filter("row"))
        calls["native blocks"] = lambda: thread_time(lambda: native.filter("blk"))
        calls["native detector"] = lambda: thread_time(native.detector)
    for call in calls.values():
        call()
    times = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            times[name].append(call() / n * 1e9)
    ns = {name: float(np.median(t)) for name, t in times.items()}
    slow = numpy_loop(rows, standing) * 1e9
    table: list[tuple[str, str, str]] = []
    if library is not None:
        best = np.minimum(times["native rows"], times["native blocks"])
        for method in worn("shoe"):
            ratio = float(np.median(np.array(times[method]) / (best + times["native detector"])))
            # What the native filter does not do (AHRS, more updates) has no aim.
            aim = "≤ 1.3" if method in NATIVE_METHODS else "–"
            table.append((f"`{method}`, detector and covariances included, against native C++", f"{ratio:.2f}", aim))
        # On a shared core this one slows more than the native one (medians from 1.1 to 1.7 with the same code): least times beside.
        ratio = float(np.median(np.array(times["detector"]) / times["native detector"]))
        least = min(times["detector"]) / min(times["native detector"])
        table.append(("stance detector alone against native C++", f"{ratio:.2f}; {least:.2f} by the least times", "≤ 1.25"))
    table.append(("the same filter as a NumPy loop, against `zupt`", f"{slow / ns['zupt']:.0f}", "≥ 250"))
    table.append(("one sample from Python (`FootIns.step`)", f"{step_call(rows) * 1e6:.2f} µs", "≤ 3 µs"))
    table += whole_command(recording)
    attitude_table, attitude_ns = ahrs_speed.measure(rows, library)
    hand_table, hand_ns = hand_speed.measure()
    table += attitude_table + hand_table
    lines = [
        "# Speed",
        "",
        "Written by `make bench`. Ratios are medians over interleaved rounds of processor time on one thread,",
        f"{n:,} samples (20 minutes at 238 Hz), {100 * standing.mean():.0f} % of them in stance, on a machine of "
        f"{os.cpu_count()} cores"
        + ("." if library is not None else "; without the C++ yardstick, whose source or compiler was not found."),
        "",
        "| what | measured | aim |",
        "|---|---|---|",
        *(f"| {a} | {b} | {c} |" for a, b, c in table),
        "",
        "Nanoseconds a sample: " + ", ".join(f"{name} {value:.0f}" for name, value in ns.items()) + f", NumPy loop {slow:.0f}.",
        "",
        "Attitude, " + ", ".join(f"{name} {value:.0f}" for name, value in attitude_ns.items()) + ".",
        "",
        "Attitude in the hand, " + ", ".join(f"{name} {value:.0f}" for name, value in hand_ns.items()) + ".",
        "",
    ]
    (ROOT / "docs" / "speed.md").write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
