"""NumPy archives of one sensor: `acc` m/s², `gyr` rad/s, `mag` µT (each (N,3)) at `sampling_rate` Hz, as VQF's example data."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from bematist.errors import DataError
from bematist.io.head import Head
from bematist.io.raw import Raw, evenly

SENSORS = {"specific_force": "acc", "angular_rate": "gyr", "magnetic_flux_density": "mag"}


def sniff(head: Head) -> bool:
    if not head.is_zip:
        return False
    try:
        with zipfile.ZipFile(io.BytesIO(head.data())) as archive:
            return {"acc.npy", "gyr.npy", "sampling_rate.npy"} <= set(archive.namelist())
    except (zipfile.BadZipFile, OSError):
        return False


def read(head: Head) -> Raw:
    try:
        with np.load(io.BytesIO(head.data()), allow_pickle=False) as archive:
            arrays = {q: archive[name] for q, name in SENSORS.items() if name in archive.files}
            raw = evenly(str(head.path), arrays, archive["sampling_rate"])
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise DataError(f"{head.path}: this archive is damaged ({str(error)[:100]}). Save it anew with numpy.savez.") from None
    raw.unit_source = "as VQF's examples have them"
    return raw
