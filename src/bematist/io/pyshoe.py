"""PyShoe .mat trials: `imu` (N,6) m/s² and rad/s, `ts` s, `gt` (N,3) Vicon position in a left-handed frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import Raw, Stream
from bematist.recording import Reference


def load(path: Path, *names: str) -> dict[str, Any]:
    """Variables of a MATLAB file (level 5; not HDF5)."""
    from scipy.io import loadmat

    try:
        return loadmat(path, variable_names=names or None)
    except NotImplementedError:
        raise DataError(f"{path}: MATLAB's v7.3 files are not read. Save it with -v7.") from None
    except Exception as error:
        raise DataError(f"{path}: this MATLAB file cannot be read ({str(error)[:100]}). Save it anew with -v7.") from None


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
    return Reference(time=ts, position=gt, mirrored=True, note="Vicon position (PyShoe), left-handed room frame")
