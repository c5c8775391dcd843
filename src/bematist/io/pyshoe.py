"""PyShoe .mat trials: `imu` (N,6) m/s² and rad/s, `ts` s, `gt` (N,3) Vicon position in a left-handed frame."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.mat import load
from bematist.io.raw import Raw, Stream
from bematist.recording import Reference

Array = NDArray[np.float64]

FARTHEST_M = 1e6
"""A reference position beyond it is a damaged number."""

FASTEST_M_S = 15.0
"""A marker that moves faster between two samples was lost and found, or taken for another; no foot does."""
LOST_S = 1.0
"""Between two such jumps that are no farther apart, the reference is not the foot."""


def sniff(head: Head) -> bool:
    return head.raw[:6] == b"MATLAB"


def read(head: Head) -> Raw:
    mat = load(head.path)
    if "imu" not in mat or "ts" not in mat:
        names = ", ".join(k for k in mat if not k.startswith("_"))
        kind = "It holds surveyed footfalls: give it as the reference, not as the recording." if "GCP_meters" in mat else ""
        raise DataError(
            f"{head.path}: a PyShoe file holds `imu` and `ts`; this one holds {names or 'nothing'}. "
            f"{kind or 'Export the recording as CSV.'}"
        )
    imu, ts = np.asarray(mat["imu"], float), np.asarray(mat["ts"], float).ravel()
    if imu.ndim != 2 or imu.shape[1] != 6 or len(imu) != len(ts):
        raise DataError(f"{head.path}: imu has shape {imu.shape} and ts {ts.shape}; expected (N, 6) and N.")
    streams = {
        "specific_force": Stream(stamps=ts, values=imu[:, :3].copy()),
        "angular_rate": Stream(stamps=ts, values=imu[:, 3:].copy()),
    }
    raw = Raw(
        source=str(head.path),
        streams=streams,
        stated={"time": "s", "specific_force": "m/s^2", "angular_rate": "rad/s"},
        unit_source="as PyShoe writes them",
    )
    raw.reference = reference_of(mat)
    return raw


def reference_of(mat: dict[str, Any]) -> Reference | None:
    if "gt" not in mat or "ts" not in mat:
        return None
    gt, ts = np.asarray(mat["gt"], float), np.asarray(mat["ts"], float).ravel()
    if gt.shape != (len(ts), 3):
        return None
    gt = np.where(np.abs(gt) < FARTHEST_M, gt, np.nan)
    lost = _lost(gt, ts)
    gt[lost] = np.nan
    note = "Vicon position (PyShoe), left-handed room frame"
    if lost.any():
        note += f"; {lost.sum()} of {len(ts)} samples left out between jumps of the marker faster than {FASTEST_M_S:g} m/s"
    return Reference(time=ts, position=gt, mirrored=True, note=note)


def _lost(position: Array, time: Array) -> NDArray[np.bool_]:
    """Samples (N,) that lie between two impossible jumps of positions (N,3) at most `LOST_S` apart."""
    speed = np.linalg.norm(np.diff(position, axis=0), axis=1) / np.maximum(np.diff(time), 1e-6)
    jumps = np.flatnonzero(speed > FASTEST_M_S)
    lost = np.zeros(len(time), bool)
    for first, last in itertools.pairwise(jumps):
        if time[last] - time[first] < LOST_S:
            lost[first + 1 : last + 1] = True
    return lost
