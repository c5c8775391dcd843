"""Recordings written from the headers that loggers document: one function a variant, `FILES[name](folder) → what to read`.

All hold the same rocking sensor (`walk_rows`), the gyroscope half a period after the accelerometer where a logger gives every sensor
its own clock.
"""

from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

import numpy as np

from test_io_formats import walk_rows

HZ = 100.0
N = 600
EPOCH_S = 1_700_000_000
LATE_S = 0.004
"""How much later than the accelerometer the gyroscope samples."""

FILES: dict[str, tuple[str, Callable[[Path], Path]]] = {}
"""Variant → format, and the function that writes it."""


def variant(format: str, name: str = ""):
    def add(function: Callable[[Path], Path]):
        FILES[name or function.__name__] = (format, function)
        return function

    return add


@cache
def fine() -> np.ndarray:
    """The motion at 1000 Hz, rows (N,10) time, SI, µT."""
    return walk_rows(N * 10, HZ * 10)


def rows(late_s: float = 0.0, step: int = 1) -> np.ndarray:
    """Rows (N,10) time, SI, µT, sampled `late_s` later."""
    return fine()[round(late_s * HZ * 10) :: 10 * step]


def table(header: str, lines: Iterable[str], eol: str = "\n") -> str:
    return eol.join([header, *lines]) + eol


def numbers(values: np.ndarray, sep: str = ",", fmt: str = "%.9g", tail: str = "") -> list[str]:
    return [sep.join(fmt % v for v in row) + tail for row in values]


# Indoor Location 2.0 ---------------------------------------------------------------------------------------------------

INDOOR_HEAD = """#\tstartTime:1700000000000
#\tSiteID:1\tSiteName:Mall\tFloorId:2\tFloorName:B1
#\tBrand:OPPO\tModel:PBCM10\tAndroidName:8.1.0\tAPILevel:27\t
"""


def indoor_lines(*, calibrated: bool = True, bias=(0.01, -0.02, 0.03)) -> list[str]:
    lines = []
    for i, row in enumerate(rows()):
        ms = EPOCH_S * 1000 + round(row[0] * 1000)
        for tag, at in (("ACCELEROMETER", 1), ("GYROSCOPE", 4), ("MAGNETIC_FIELD", 7)):
            b = np.array(bias) if at > 1 else np.zeros(3)
            if calibrated:
                lines.append("\t".join([f"{ms}", f"TYPE_{tag}", *(f"{v:.8g}" for v in row[at : at + 3]), "3"]))
            values = [*(row[at : at + 3] + b), *b]
            lines.append("\t".join([f"{ms}", f"TYPE_{tag}_UNCALIBRATED", *(f"{v:.8g}" for v in values), "3"]))
        if i % 50 == 0:
            lines.append(f"{ms}\tTYPE_PRESSURE\t1000.5\t3")
            lines.append(f"{ms}\tTYPE_WIFI\tab\tcd\t-60\t5180\t{ms}")
        if i % 200 == 0:
            lines.append(f"{ms}\tTYPE_WAYPOINT\t{100 + 0.01 * i}\t{200 - 0.01 * i}")
    return lines


@variant("indoor-location")
def indoor(folder: Path) -> Path:
    path = folder / "trace.txt"
    path.write_text(INDOOR_HEAD + "\n".join(indoor_lines()) + "\n#\tendTime:1700000006000\n", encoding="utf-8")
    return path


@variant("indoor-location")
def indoor_uncalibrated(folder: Path) -> Path:
    path = folder / "trace.txt"
    path.write_text(INDOOR_HEAD + "\n".join(indoor_lines(calibrated=False)) + "\n", encoding="utf-8")
    return path


# A text file for each sensor -------------------------------------------------------------------------------------------


@variant("text-folder")
def text_folder(folder: Path) -> Path:
    a, g, m = rows(), rows(LATE_S), rows(step=2)
    bias = np.tile([60.0, -70.0, 400.0], (len(m), 1))
    for name, values in {
        "accelerometer.txt": a[:, :4],
        "gyroscope-calibrated.txt": g[:, [0, 4, 5, 6]],
        "magnetometer-calibrated.txt": m[:, [0, 7, 8, 9]],
        "magnetometer.txt": np.column_stack([m[:, 0], m[:, 7:] + bias, bias]),
    }.items():
        (folder / name).write_text("\n".join(numbers(values, " ")) + "\n")
    (folder / "record.properties").write_text("[Device]\nManufacturer = LGE\nModel = Nexus 5\n\n[Time]\nStartTime = 1464685476")
    return folder


@variant("text-folder")
def text_folder_uncalibrated(folder: Path) -> Path:
    a, g = rows(), rows(LATE_S)
    bias = np.tile([0.1, 0.2, -0.3], (len(g), 1))
    (folder / "accelerometer.txt").write_text("\n".join(numbers(a[:, :4], " ")) + "\n")
    both = np.column_stack([g[:, 0], g[:, 4:7] + bias, bias])
    (folder / "gyroscope.txt").write_text("\n".join(numbers(both, " ")) + "\n")
    return folder
