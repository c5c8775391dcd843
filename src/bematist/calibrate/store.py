"""A calibration as TOML: units beside the numbers, what it was made for, and how sure it is."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bematist import __version__, config
from bematist.calibrate.result import UNITS, Calibration, SensorCalibration
from bematist.errors import UsageError
from bematist.outputs import whole_file
from bematist.recording import Sensing

FORMAT = 1
HEADER = """\
# calibrated = matrix * (reading - offset), readings in the unit of the sensor, in the sensor's own axes.
# For bematist track RECORDING --calibration THIS_FILE, and for attitude, compare, info, allan, stance, convert.

"""
Row = tuple[float, float, float]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _Sensor(_Model):
    unit: str
    offset: Row
    offset_sd: Row
    matrix: tuple[Row, Row, Row]
    matrix_sd: tuple[Row, Row, Row]
    length: float | None = None
    error_before: float | None = None
    error_after: float | None = None
    samples: int = 0
    left_out: int = 0
    missing: list[str] = []
    undetermined: list[str] = []
    note: str = ""
    covariance: list[list[float]] = Field(min_length=12, max_length=12)


class _MadeFor(_Model):
    device: str = ""
    axes: str = ""
    uncalibrated: bool = False
    calibration: str = ""
    source: str = ""
    rate_hz: float | None = None


class _File(_Model):
    calibration: int
    version: str = ""
    made_for: _MadeFor = _MadeFor()
    warnings: list[str] = []
    accelerometer: _Sensor | None = None
    gyroscope: _Sensor | None = None
    magnetometer: _Sensor | None = None


def to_table(c: Calibration) -> dict[str, Any]:
    """The calibration as nested tables."""
    made = {**asdict(c.sensing), "source": c.source, **({"rate_hz": c.rate_hz} if math.isfinite(c.rate_hz) else {})}
    table: dict[str, Any] = {"calibration": FORMAT, "version": __version__, "warnings": list(c.warnings), "made_for": made}
    for name, s in c.sensors.items():
        numbers = {"length": s.length, "error_before": s.before, "error_after": s.after}
        table[name] = {
            "unit": s.unit,
            "offset": s.offset.tolist(),
            "offset_sd": s.offset_sd.tolist(),
            "matrix": s.matrix.tolist(),
            "matrix_sd": s.matrix_sd.tolist(),
            **{k: float(v) for k, v in numbers.items() if math.isfinite(v)},
            "samples": s.samples,
            "left_out": s.left_out,
            "missing": list(s.missing),
            "undetermined": list(s.undetermined),
            "note": s.note,
            "covariance": s.covariance.tolist(),
        }
    return table


def save(c: Calibration, path: Path) -> None:
    """Write the file; it stands there whole or not at all."""
    with whole_file(path) as place:
        place.write_text(HEADER + config.to_toml(to_table(c)), "utf-8")


def load(path: Path) -> Calibration:
    """Read a file that `save` wrote, or that was written by hand in its form.

    Raises
    ------
    DataError
        It cannot be opened.
    UsageError
        It is no calibration; the message names the entry.
    """
    try:
        found = _File(**config.read_toml(path))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(p) for p in first["loc"])
        raise UsageError(
            f"{path}: this is no calibration: {where}: {first['msg']}. `bematist calibrate RECORDING -o {path.name}` makes one."
        ) from None
    if found.calibration != FORMAT:
        raise UsageError(f"{path}: the calibration has the form {found.calibration}, and this bematist reads {FORMAT}. Calibrate anew.")
    sensors = {name: _sensor(path, name, s) for name in UNITS if (s := getattr(found, name)) is not None}
    if not sensors:
        raise UsageError(f"{path}: there is no sensor in this calibration. It holds [accelerometer], [gyroscope] or [magnetometer].")
    made = found.made_for
    return Calibration(
        sensors=sensors,
        sensing=Sensing(device=made.device, axes=made.axes, uncalibrated=made.uncalibrated, calibration=made.calibration),
        source=made.source,
        rate_hz=math.nan if made.rate_hz is None else made.rate_hz,
        warnings=tuple(found.warnings),
    )


def _sensor(path: Path, name: str, s: _Sensor) -> SensorCalibration:
    if s.unit != UNITS[name]:
        raise UsageError(
            f'{path}: {name}.unit is "{s.unit}", and readings are calibrated in {UNITS[name]}: write offset and matrix for that unit.'
        )
    numbers = [np.array(x, float) for x in (s.offset, s.matrix, s.covariance)]
    if numbers[2].shape != (12, 12) or not all(np.isfinite(x).all() for x in numbers) or abs(np.linalg.det(numbers[1])) < 1e-6:
        raise UsageError(f"{path}: {name}: offset, matrix (invertible) and covariance (12 by 12) must be finite numbers.")
    return SensorCalibration(
        sensor=name,
        offset=numbers[0],
        matrix=numbers[1],
        covariance=numbers[2],
        length=math.nan if s.length is None else s.length,
        before=math.nan if s.error_before is None else s.error_before,
        after=math.nan if s.error_after is None else s.error_after,
        samples=s.samples,
        left_out=s.left_out,
        missing=tuple(s.missing),
        undetermined=tuple(s.undetermined),
        note=s.note,
    )
