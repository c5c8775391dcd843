"""Recordings written from the headers that loggers document: one function a variant, `FILES[name](folder) → what to read`.

All hold the same rocking sensor (`walk_rows`), the gyroscope half a period after the accelerometer where a logger gives every sensor
its own clock.
"""

import zipfile
from collections.abc import Callable, Iterable, Mapping
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


def table_text(header: str, lines: Iterable[str], eol: str = "\n") -> str:
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


def zipped(path: Path, files: Mapping[str, str], top: str = "") -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(top + name, text)
    return path


def folded(folder: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


# Sensor Logger ---------------------------------------------------------------------------------------------------------

METADATA = (
    "version,device name,recording epoch time,recording time,recording timezone,platform,appVersion,device id,sensors,sampleRateMs,"
    "standardisation,platform version"
)
G = 9.80665


def sensor_logger_files(platform: str = "android", standardised: str = "false", only: str = "") -> dict[str, str]:
    """What the app writes; `only` names the acceleration that was recorded."""

    def csv(table: np.ndarray, at: int, scale: float = 1.0, names: str = "z,y,x") -> str:
        lines = []
        for row in table:
            values = row[at : at + len(names.split(","))][::-1] * scale
            lines.append(",".join([f"{EPOCH_S * 10**9 + round(row[0] * 1e9)}", f"{row[0]:.9f}", *(f"{v:.9g}" for v in values)]))
        return table_text(f"time,seconds_elapsed,{names}", lines)

    a, g, m = rows(), rows(LATE_S), rows(step=2)
    sign = -1.0 if platform == "ios" and standardised != "true" else 1.0
    slow, fast = a.copy(), a.copy()
    slow[:, 1:4] *= 0.9
    fast[:, 1:4] *= 0.1
    files = {
        "Accelerometer.csv": csv(fast, 1, sign),
        "Gravity.csv": csv(slow, 1, sign),
        "TotalAcceleration.csv": csv(a, 1),
        "AccelerometerUncalibrated.csv": csv(a, 1, sign / (G if sign < 0 else 1)),
    }
    kept = {
        "": ("Accelerometer.csv", "Gravity.csv"),
        "total": ("TotalAcceleration.csv", "Accelerometer.csv"),
        "linear": ("Accelerometer.csv",),
    }
    files = {n: files[n] for n in kept.get(only, ("AccelerometerUncalibrated.csv",))}
    barometer = np.column_stack([a[::100, 0], np.full(6, 1000.5), np.full(6, 0.25)])
    place = (
        "time,seconds_elapsed,bearingAccuracy,speedAccuracy,verticalAccuracy,horizontalAccuracy,speed,bearing,altitude,longitude,latitude"
    )
    fix = [f"{EPOCH_S * 10**9 + k * 10**9},{k},0,0,3,5,1,0,{100 + k},{8 + 1e-5 * k},50" for k in range(5)]
    return files | {
        "Gyroscope.csv": csv(g, 4),
        "Magnetometer.csv": csv(m, 7),
        "MagnetometerUncalibrated.csv": "",
        "Barometer.csv": csv(barometer, 1, names="relativeAltitude,pressure"),
        "Location.csv": table_text(place, fix),
        "Annotation.csv": "time,seconds_elapsed,text,millisecond_press_duration\n",
        "Metadata.csv": table_text(
            METADATA,
            [f"3,My phone,{EPOCH_S}000,2023-11-14_22-13-20,Europe/Berlin,{platform},1.40,ab,Accelerometer|Gravity,10,{standardised},17"],
        ),
    }


@variant("sensor-logger")
def logger_android_zip(folder: Path) -> Path:
    return zipped(folder / "walk.zip", sensor_logger_files(only="total"))


@variant("sensor-logger")
def logger_android_without_total(folder: Path) -> Path:
    return folded(folder, sensor_logger_files())


@variant("sensor-logger")
def logger_android_uncalibrated(folder: Path) -> Path:
    return zipped(folder / "walk.zip", sensor_logger_files(only="raw"))


@variant("sensor-logger")
def logger_ios_zip(folder: Path) -> Path:
    return zipped(folder / "walk.zip", sensor_logger_files("ios"), top="2023-11-14_22-13-20/")


@variant("sensor-logger")
def logger_ios_standardised(folder: Path) -> Path:
    return folded(folder, sensor_logger_files("ios", "true"))


@variant("sensor-logger")
def logger_ios_raw_in_g(folder: Path) -> Path:
    return folded(folder, sensor_logger_files("ios", only="raw"))


@variant("sensor-logger")
def logger_ios_raw_standardised(folder: Path) -> Path:
    return folded(folder, sensor_logger_files("ios", "true", only="raw"))


@variant("sensor-logger")
def logger_one_csv(folder: Path) -> Path:
    return folded(folder, sensor_logger_files("ios")) / "Accelerometer.csv"


# phyphox ---------------------------------------------------------------------------------------------------------------

PHYPHOX = {
    "Accelerometer": ("Acceleration x (m/s^2)", "Acceleration y (m/s^2)", "Acceleration z (m/s^2)", "Absolute acceleration (m/s^2)"),
    "Gyroscope": ("Gyroscope x (rad/s)", "Gyroscope y (rad/s)", "Gyroscope z (rad/s)", "Absolute (rad/s)"),
    "Magnetometer": ("Magnetic Field x (µT)", "Magnetic Field y (µT)", "Magnetic Field z (µT)", "Absolute field (µT)"),
    "Linear Acceleration": ("Linear Acceleration x (m/s^2)", "Linear Acceleration y (m/s^2)", "Linear Acceleration z (m/s^2)"),
    "Gravity": ("Gravity x (m/s^2)", "Gravity y (m/s^2)", "Gravity z (m/s^2)"),
}
GERMAN = {
    "Zeit": "Time",
    "Beschleunigung": "Acceleration",
    "Gyroskop": "Gyroscope",
    "Magnetfeld": "Magnetic Field",
    "Absolutbetrag": "Absolute acceleration",
}
TIME_CSV = (
    '"event","experiment time","system time","system time text"\n"START",0.000000000E0,1700000000.000,"2023-11-14 22:13:20.000 UTC"\n'
)


def phyphox_files(
    sep: str = ",", comma: bool = False, names: Mapping[str, tuple[str, ...]] = PHYPHOX, time: str = "Time"
) -> dict[str, str]:
    a, g, m = rows(), rows(LATE_S), rows(step=2)
    tables = {
        "Accelerometer": a[:, :4],
        "Gyroscope": g[:, [0, 4, 5, 6]],
        "Magnetometer": m[:, [0, 7, 8, 9]],
        "Linear Acceleration": np.column_stack([a[:, 0], a[:, 1:4] * 0.05]),
        "Gravity": np.column_stack([a[:, 0], G * a[:, 1:4] / np.linalg.norm(a[:, 1:4], axis=1, keepdims=True)]),
    }
    files = {}
    for name, columns in names.items():
        values = tables[name]
        if len(columns) == 4:
            values = np.column_stack([values, np.linalg.norm(values[:, 1:], axis=1)])
        lines = [line.replace(".", ",") if comma else line for line in numbers(values, sep, "%.9E")]
        files[f"{name}.csv"] = table_text(sep.join(f'"{n}"' for n in (f"{time} (s)", *columns)), lines)
    return files | {
        "meta/device.csv": '"property","value"\n"version","1.1.15"\n"deviceBrand","google"\n"deviceModel","Pixel 6a"\n',
        "meta/time.csv": TIME_CSV,
    }


def _separated(sep: str, comma: bool):
    return lambda folder: zipped(folder / "experiment.zip", phyphox_files(sep, comma))


for _name, _sep, _comma in (
    ("comma_point", ",", False),
    ("tab_point", "\t", False),
    ("semicolon_point", ";", False),
    ("tab_comma", "\t", True),
    ("semicolon_comma", ";", True),
):
    variant("phyphox", f"phyphox_{_name}")(_separated(_sep, _comma))


def _translated(column: str) -> str:
    return next((column.replace(english, german) for german, english in GERMAN.items() if column.startswith(english)), column)


@variant("phyphox")
def phyphox_german(folder: Path) -> Path:
    names = {k: tuple(_translated(c) for c in v) for k, v in PHYPHOX.items() if k in ("Accelerometer", "Gyroscope", "Magnetometer")}
    return zipped(folder / "Versuch.zip", phyphox_files(";", True, names, "Zeit"))


@variant("phyphox")
def phyphox_without_letters(folder: Path) -> Path:
    """A language that names no x, y, z: the order tells."""
    names = {
        k: tuple(f"{k} {i} ({v[0].split('(')[1]}" for i in range(4)) for k, v in PHYPHOX.items() if k in ("Accelerometer", "Gyroscope")
    }
    return folded(folder, phyphox_files(names=names))


@variant("phyphox")
def phyphox_one_csv(folder: Path) -> Path:
    """An experiment that writes both sensors into one table."""
    a = rows()
    columns = ("Time (s)", *PHYPHOX["Accelerometer"][:3], *PHYPHOX["Gyroscope"][:3])
    path = folder / "Raw Data.csv"
    path.write_text(table_text(",".join(f'"{c}"' for c in columns), numbers(a[:, :7], ",", "%.9E")), encoding="utf-8")
    return path
