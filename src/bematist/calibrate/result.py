"""What a calibration is: for each sensor an offset and a matrix, how sure they are, and what it was made for."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.recording import Recording, Sensing

if TYPE_CHECKING:
    from bematist.calibrate.evidence import Evidence

Array = NDArray[np.float64]

UNITS = {"accelerometer": "m/s^2", "gyroscope": "rad/s", "magnetometer": "uT"}
QUANTITIES = {"accelerometer": "specific_force", "gyroscope": "angular_rate", "magnetometer": "magnetic_flux_density"}


@dataclass(frozen=True, eq=False, kw_only=True)
class SensorCalibration:
    """One sensor: calibrated = matrix · (reading − offset), in the frame that all sensors share.

    Attributes
    ----------
    sensor : accelerometer, gyroscope or magnetometer.
    offset : (3,) in the sensor's unit (`UNITS`).
    matrix : (3,3), dimensionless: scale factors, misalignment, soft iron, and the axes' names where they were wrong.
    covariance : (12,12) of the matrix, row by row, and the offset; zero where a parameter was not free.
    length : what the calibrated vector measures at rest, gravity or the field, in the sensor's unit; NaN for a gyroscope.
    before, after : rms of the error that the calibration removes, as read and calibrated: of an accelerometer off gravity, relative; of a
        magnetometer's length about its mean, relative; of a gyroscope by what the direction after a turn is missed, rad.
    samples, left_out : what the fit used, and what it left out as outliers.
    missing : directions that the data did not cover, such as "-z".
    undetermined : parameters that the data did not tell, which stay at what was known before.
    note : what the calibration cannot say, such as that nothing tied the sensor to the frame of the others.
    """

    sensor: str
    offset: Array
    matrix: Array
    covariance: Array
    length: float
    before: float
    after: float
    samples: int
    left_out: int = 0
    missing: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()
    note: str = ""

    def apply(self, values: Array) -> Array:
        """Calibrated values (n,3) of readings (n,3)."""
        return (values - self.offset) @ self.matrix.T

    @property
    def unit(self) -> str:
        return UNITS[self.sensor]

    @property
    def offset_sd(self) -> Array:
        return np.sqrt(np.diag(self.covariance)[9:])

    @property
    def matrix_sd(self) -> Array:
        return np.sqrt(np.diag(self.covariance)[:9]).reshape(3, 3)


@dataclass(frozen=True, eq=False, kw_only=True)
class Calibration:
    """The sensors of one device, calibrated into one frame: the accelerometer's, where there is one.

    Attributes
    ----------
    sensors : by name; a sensor that is not in it stays as it reads.
    sensing : the device, the axes and the channel that the recordings had.
    source, rate_hz : of the first recording.
    warnings : what is doubtful.
    evidence : what it was found from, for the report; None where the calibration was read from a file.
    """

    sensors: dict[str, SensorCalibration]
    sensing: Sensing = field(default_factory=Sensing)
    source: str = ""
    rate_hz: float = float("nan")
    warnings: tuple[str, ...] = ()
    evidence: Evidence | None = None

    def __getitem__(self, sensor: str) -> SensorCalibration:
        return self.sensors[sensor]

    def apply(self, recording: Recording) -> Recording:
        """The recording as a perfect sensor would have made it.

        Raises
        ------
        DataError
            The recording is not of the device, axes, channel or units that the calibration was made for.
        """
        from bematist.calibrate.fits import check, doubts

        check(self, recording)
        changes = {QUANTITIES[name]: s.apply(getattr(recording, QUANTITIES[name])) for name, s in self.sensors.items()}
        names = ", ".join(self.sensors)
        found = recording.replace(
            **changes,
            sensing=recording.sensing.replace(calibration=self.source or "given"),
            notes=(*recording.notes, f"Calibration: {names} calibrated from {Path(self.source).name or 'a recording'}"),
        )
        return found.replace(warnings=(*found.warnings, *doubts(self, found)))

    def save(self, path: str | Path) -> None:
        """Write the calibration as TOML."""
        from bematist.calibrate.store import save

        save(self, Path(path))

    @staticmethod
    def load(path: str | Path) -> Calibration:
        """Read a calibration from TOML. UsageError where the file is none."""
        from bematist.calibrate.store import load

        return load(Path(path))
