"""Reading recordings and references, writing recordings, trajectories and exports.

Each format is one module with `sniff(head)` and `read(head)`; `FORMATS` is the table of them, in the order they are tried.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bematist.errors import DataError, UsageError

if TYPE_CHECKING:
    from bematist.clock import Mode
    from bematist.recording import Recording


@dataclass(frozen=True)
class Format:
    """A readable format: its name, the module that reads it, and what its files look like."""

    name: str
    module: str
    summary: str

    def load(self) -> Any:
        return importlib.import_module(f"bematist.io.{self.module}")


_TABLE = (
    Format("canonical", "canonical", "CSV or Parquet with time,fx,fy,fz,wx,wy,wz,mx,my,mz[,pressure] in SI units and µT"),
    Format("microstrain", "microstrain", "MicroStrain SensorConnect CSV (…:scaledAccelX …)"),
    Format("x-io", "xio", "x-io NGIMU or x-IMU3 CSV (Gyroscope X (deg/s) …), or the folder with sensors.csv or Inertial.csv"),
    Format("openshoe", "openshoe", "OpenShoe inertial text (Header: a_x [g]: …)"),
    Format("xsens", "xsens", "Xsens MT Manager text (PacketCounter SampleTimeFine Acc_X … with tabs)"),
    Format("movella-dot", "movella_dot", "Xsens or Movella DOT CSV (PacketCounter,SampleTimeFine,…)"),
    Format("metamotion", "metamotion", "MetaMotion CSV for each sensor (epoch (ms),time,elapsed (s),x-axis (g) …), a file or the folder"),
    Format("shimmer", "shimmer", "Shimmer Consensys CSV (Shimmer_40AC_Accel_WR_X_CAL …, a line of units)"),
    Format("getsensordata", "getsensordata", "GetSensorData or IPIN log (ACCE;app time;sensor time;x;y;z;accuracy)"),
    Format("indoor-location", "indoor_location", "Indoor Location 2.0 log of an Android phone (unix_ms TYPE_ACCELEROMETER …)"),
    Format("sensor-logger", "sensor_logger", "Sensor Logger zip, folder or a CSV in it (time,seconds_elapsed,z,y,x), Android and iOS"),
    Format("phyphox", "phyphox", "phyphox zip, folder or CSV (Time (s), Acceleration x (m/s^2) …), in any language"),
    Format("text-folder", "text_folder", "folder with accelerometer.txt, gyroscope.txt … of an Android phone, without headers"),
    Format("broad", "broad", "BROAD .mat (imu_acc, imu_gyr, imu_mag, sampling_rate, opt_quat …)"),
    Format("npz", "npz", "NumPy .npz with acc, gyr, mag and sampling_rate, as the examples of VQF"),
    Format("pyshoe", "pyshoe", "PyShoe .mat (imu, ts, gt)"),
)
MOST_LOOKED_AT = 50
"""Of a folder that is no recording, so many files and folders are looked at, to say what is in it."""
FORMATS: dict[str, Format] = {f.name: f for f in _TABLE}
"""Every format that `read` knows, by name."""


def read(
    path: str | Path,
    *,
    format: str | None = None,
    columns: str | Path | None = None,
    axes: str | None = None,
    units: Mapping[str, str] | None = None,
    clock: Mode = "auto",
    uncalibrated: bool = False,
) -> Recording:
    """Read a recording.

    Parameters
    ----------
    path : the file, or the folder of formats that write one.
    format : a name of `FORMATS`; found from the content when not given (the file's suffix does not matter).
    columns : a map.toml that describes any other CSV (see docs/formats.md).
    axes : remap of the sensor axes, such as "x,-z,y": the k-th entry names the old axis that becomes the new k-th.
    units : forces the unit of a quantity (specific_force, angular_rate, magnetic_flux_density, pressure, time).
    clock : "auto" decides by evidence whether the stamps are true; "uniform" fits an even clock; "stamps" keeps them.
    uncalibrated : take the raw readings of a phone that writes them beside those it calibrates.

    Raises
    ------
    DataError
        The file cannot be read, or is in no known format.
    UsageError
        An unknown format, unit, axis or clock.
    """
    from bematist.io.assemble import assemble
    from bematist.io.head import open_head

    head = open_head(path)
    if columns is not None:
        from bematist.io.columns import read_mapped

        return assemble(read_mapped(head, Path(columns)), axes=axes, units=units, clock=clock, uncalibrated=uncalibrated)
    if format is not None and format not in FORMATS:
        raise UsageError(f'There is no format "{format}". Formats: {", ".join(FORMATS)}.')
    chosen = FORMATS[format] if format else sniff(path)
    if format and not chosen.load().sniff(head):
        raise DataError(f"{path}: this does not look like {chosen.name} ({chosen.summary}). Leave the format out to have it found.")
    return assemble(chosen.load().read(head), axes=axes, units=units, clock=clock, uncalibrated=uncalibrated)


def sniff(path: str | Path) -> Format:
    """The format of a file, from its content. Raises DataError, which names the known formats, when there is none."""
    from bematist.io.head import open_head

    head = open_head(path)
    for candidate in FORMATS.values():
        if candidate.load().sniff(head):
            return candidate
    if head.raw[:2] == b"\x1f\x8b" or head.is_zip:
        raise DataError(f"{path}: the file is compressed, and what is in it is in no format that is read so. Unpack it first.")
    if head.is_folder and (inside := _recordings_in(head.path)):
        more = f" and {len(inside) - 3} more" if len(inside) > 3 else ""
        raise DataError(
            f"{path}: the folder is not one recording, but holds recordings: {', '.join(inside[:3])}{more}. Name the one you mean; several "
            "of one sensor are named one after the other where a command takes them, such as `bematist calibrate`."
        )
    what = "the folder" if head.is_folder else "the file" if head.lines else "the file (it is not text)"
    raise DataError(
        f"{path}: {what} is in no format that bematist knows. Known are {', '.join(FORMATS)}; docs/formats.md says what each looks like. "
        "Any other CSV can be read with --columns map.toml."
    )


def _recordings_in(folder: Path) -> list[str]:
    """Names in a folder of what can be read."""
    from bematist.io.head import open_head

    def known(path: Path) -> bool:
        try:
            head = open_head(path)
            return any(candidate.load().sniff(head) for candidate in FORMATS.values())
        except DataError:
            return False

    return [path.name for path in sorted(folder.iterdir())[:MOST_LOOKED_AT] if known(path)]


def __getattr__(name: str) -> Any:
    # Loaded on first use: the reader of a CSV needs neither writers nor references.
    home = {
        "read_floor_plan": "floor_plans",
        "read_reference": "reference",
        "write_reference": "reference",
        "write_recording": "canonical",
        "write_trajectory": "trajectory_files",
        "read_trajectory": "trajectory_files",
        "export": "exports",
        "EXPORTS": "exports",
        "write_attitude": "attitude_files",
        "read_attitude": "attitude_files",
    }
    if name in home:
        return getattr(importlib.import_module(f"bematist.io.{home[name]}"), name)
    raise AttributeError(f"module 'bematist.io' has no attribute {name!r}")
