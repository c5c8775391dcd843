"""Speed of the attitude filters, for the page of `benchmarks/run.py`."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable

import ahrs
import imufusion
import numpy as np

import bematist as bm
from bematist.ahrs import Ahrs
from bematist.kernels import attitude as kernel

ROUNDS = 15
LOOP = 20_000
"""Samples of the slow loops over peers."""

CASES = {
    "madgwick, as printed": ("madgwick", {"integration": "first-order"}),
    "madgwick": ("madgwick", {}),
    "mahony, as printed": ("mahony", {"integration": "first-order"}),
    "mahony": ("mahony", {}),
    "gyro": ("gyro", {}),
}


def thread_time(call: Callable[[], object]) -> float:
    start = time.thread_time()
    call()
    return time.thread_time() - start


def native_calls(library: ctypes.CDLL, rows: np.ndarray) -> dict[str, Callable[[], float]]:
    """Thread time of the C++ yardstick's filters, which run every sample with a field."""

    def pointer(a: np.ndarray) -> ctypes.c_void_p:
        return a.ctypes.data_as(ctypes.c_void_p)

    f, w, m = (np.ascontiguousarray(rows[:, c : c + 3]) for c in (1, 4, 7))
    n, out = ctypes.c_int64(len(rows)), np.empty((len(rows), 4))
    shared = [pointer(a) for a in (f, w, m)]
    dt = ctypes.c_double(1 / 238)

    def madgwick() -> float:
        return thread_time(lambda: library.madgwick(n, *shared, dt, ctypes.c_double(0.12), pointer(out)))

    def mahony() -> float:
        return thread_time(lambda: library.mahony(n, *shared, dt, ctypes.c_double(0.74), ctypes.c_double(0.0012), pointer(out)))

    return {"native madgwick": madgwick, "native mahony": mahony}


def own_call(rows: np.ndarray, name: str, changes: dict[str, str]) -> Callable[[], float]:
    columns, out = np.ascontiguousarray(rows.T), np.empty((len(rows), kernel.OUT))

    def call() -> float:
        estimator = Ahrs(bm.FILTERS[name].parameters.override(changes))
        estimator.update(rows[:2400])
        assert estimator._state is not None
        S, prm = estimator._state
        S[kernel.STARTED] = 0
        return thread_time(lambda: kernel.run(S, prm, columns, out))

    return call


def peers(rows: np.ndarray) -> dict[str, float]:
    """Thread time per sample, s, of loops over the packages ahrs and imufusion."""
    f, w, m = rows[:, 1:4].copy(), rows[:, 4:7].copy(), rows[:, 7:10].copy()
    start = np.array([1.0, 0, 0, 0])
    degrees, g = np.degrees(w), f / 9.80665

    def loop(update: Callable[..., np.ndarray], n: int) -> float:
        q = start
        began = time.thread_time()
        for k in range(n):
            q = update(q, w[k], f[k], m[k])
        return (time.thread_time() - began) / n

    def fusion() -> float:
        peer = imufusion.Ahrs()
        began = time.thread_time()
        for k in range(LOOP):
            peer.update(degrees[k], g[k], m[k])
        return (time.thread_time() - began) / LOOP

    return {
        "ahrs madgwick": loop(ahrs.filters.Madgwick(gain=0.12, Dt=1 / 238).updateMARG, LOOP // 10),
        "ahrs mahony": loop(ahrs.filters.Mahony(k_P=0.74, k_I=0.0012, Dt=1 / 238).updateMARG, LOOP // 10),
        "imufusion": min(fusion() for _ in range(3)),
    }


def measure(rows: np.ndarray, library: ctypes.CDLL | None) -> tuple[list[tuple[str, str, str]], dict[str, float]]:
    """Rows of the page and nanoseconds a sample, over sample rows (N,10) whose field is held, so that every step uses it."""
    rows = rows.copy()
    known = np.flatnonzero(np.isfinite(rows[:, 7]))
    rows = rows[known[0] :]
    last = known[np.searchsorted(known, np.arange(known[0], known[0] + len(rows)), side="right") - 1] - known[0]
    rows[:, 7:10] = rows[last, 7:10]
    calls = {name: own_call(rows, *case) for name, case in CASES.items()}
    if library is not None:
        calls |= native_calls(library, rows)
    for call in calls.values():
        call()
    times = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            times[name].append(call() / len(rows) * 1e9)
    ns = {name: float(np.median(t)) for name, t in times.items()}
    slow = {name: 1e9 * t for name, t in peers(rows).items()}
    table = []
    for name, (filter_name, _) in CASES.items():
        if library is not None and filter_name != "gyro":
            ratio = float(np.median(np.array(times[name]) / np.array(times[f"native {filter_name}"])))
            table.append((f"attitude by `{name}`, against native C++", f"{ratio:.2f}", "≤ 1.25"))
    for filter_name in ("madgwick", "mahony"):
        factor = slow[f"ahrs {filter_name}"] / ns[filter_name]
        table.append((f"the package ahrs against `{filter_name}`", f"{factor:,.0f} times its time", "≥ 250"))
    table.append(("a loop over the package imufusion against `madgwick`", f"{slow['imufusion'] / ns['madgwick']:.0f} times its time", "–"))
    return table, ns | slow
