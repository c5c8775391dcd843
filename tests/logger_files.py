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


# GetSensorData ---------------------------------------------------------------------------------------------------------

GETSENSORDATA = """% LogFile created by the 'GetSensorData' App for Android.
% Date of creation: Tue Nov 14 22:13:20 CET 2023
% Phone used for this logfile:
% Manufacturer:            \tsamsung
% Model:                   \tSM-A520F
% LogFile Data format:
% Accelerometer data: \t'ACCE;AppTimestamp(s);SensorTimestamp(s);Acc_X(m/s^2);Acc_Y(m/s^2);Acc_Z(m/s^2);Accuracy(integer)'
% Magnetometer data:  \t'MAGN;AppTimestamp(s);SensorTimestamp(s);Mag_X(uT);;Mag_Y(uT);Mag_Z(uT);Accuracy(integer)'

"""


def getsensordata_text(zero: dict[str, float], posi: bool = True, jitter_s: float = 0.003) -> str:
    rng = np.random.default_rng(5)
    events: list[tuple[float, str]] = []
    for tag, table, at in (("ACCE", rows(), 1), ("GYRO", rows(LATE_S), 4), ("MAGN", rows(step=2), 7)):
        for row in table:
            app = row[0] + 12.0 + 0.002 + rng.uniform(0, jitter_s)
            values = ";".join(f"{v:.7f}" for v in row[at : at + 3])
            events.append((app, f"{tag};{app:.3f};{row[0] + zero[tag]:.6f};{values};3"))
    for k in range(6):
        app = 12.0 + k
        events.append((app, f"PRES;{app:.3f};{k + zero['ACCE']:.6f};1000.5000;3"))
        events.append((app, f"WIFI;{app:.3f};{k}.0;net;00:11:22:33:44:55;2412;-60"))
        events.append((app, f"GNSS;{app:.3f};{k}.0;50.000000;{8 + 1e-5 * k:.6f};100.000;90.0;4.0;0.7;7;5"))
        if posi:
            events.append((app, f"POSI;{app:.3f};{k};50.0000000;{8 + 2e-5 * k:.7f};1;0"))
        events.append((app, f"IMUX;{app:.3f};{k}.0;{k};0;0;9.8;0;0;0;20;0;-40;0;0;0;1000;25"))
    return GETSENSORDATA + "\n".join(line for _, line in sorted(events)) + "\n"


@variant("getsensordata")
def getsensordata(folder: Path) -> Path:
    path = folder / "logfile_2023_11_14.txt"
    path.write_text(getsensordata_text(dict.fromkeys(("ACCE", "GYRO", "MAGN"), 5000.0)), encoding="utf-8")
    return path


# Xsens -----------------------------------------------------------------------------------------------------------------

MT_OLD = "// Start Time: 0\n// Sample rate: 100.0Hz\n// Scenario: 4.9\n// Firmware Version: 2.5.1\n"
MT_NEW = (
    "// Start Time: Unknown\n// Update Rate: 100.0Hz\n// Filter Profile: human (46.1)\n// Option Flags: AHS Disabled ICC Disabled\n"
    "// Firmware Version: 4.6.0\n"
)
XYZ = [f"{s}_{a}" for s in ("Acc", "Gyr", "Mag") for a in "XYZ"]
FIELD = 45.0


def relative_field(table: np.ndarray) -> np.ndarray:
    return np.column_stack([table[:, 1:7], table[:, 7:] / FIELD])


@variant("xsens")
def xsens_old(folder: Path) -> Path:
    """A counter of 16 bits that begins anew, and the rate in the head."""
    table = rows()
    counter = (65500 + np.arange(len(table))) % 65536
    values = np.column_stack([counter, relative_field(table), np.tile([1.0, 0, 0, 0], (len(table), 1))])
    header = "\t".join(["Counter", *XYZ, "Quat_w", "Quat_x", "Quat_y", "Quat_z"])
    path = folder / "MT_0100_000.txt"
    path.write_text(MT_OLD + table_text(header, numbers(values, "\t")))
    return path


@variant("xsens")
def xsens_new(folder: Path) -> Path:
    """SampleTimeFine in 100 µs that begins anew at 2^32; empty UTC columns; a tab at the end of each line."""
    table = rows()
    fine_ticks = (2**32 - 20000 + np.round(table[:, 0] * 1e4).astype(np.int64)) % 2**32
    more = ["Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3", "Mat[1][1]", "Mat[2][1]", "Roll", "Pitch", "Yaw"]
    header = "\t".join(["PacketCounter", "SampleTimeFine", "Year", "Month", *XYZ, *more])
    lines = [
        "\t".join([f"{i % 65536}", f"{tick}", "", "", *(f"{v:.9g}" for v in row), *["0"] * len(more)]) + "\t"
        for i, (tick, row) in enumerate(zip(fine_ticks, relative_field(table), strict=True))
    ]
    path = folder / "MT_0100_000.txt"
    path.write_text(MT_NEW + table_text(header + "\t", lines))
    return path


@variant("xsens")
def xsens_without_fine_time(folder: Path) -> Path:
    """The column SampleTimeFine is there and empty."""
    table = rows()
    lines = ["\t".join([f"{i}", "", *(f"{v:.9g}" for v in row)]) for i, row in enumerate(relative_field(table))]
    path = folder / "MT_0100_000.txt"
    path.write_text(MT_NEW + table_text("\t".join(["PacketCounter", "SampleTimeFine", *XYZ]), lines))
    return path


DOT_HEAD = """sep=,
DeviceTag:,1
FirmwareVersion:,2.0.0
AppVersion:,2021.0.0
SyncStatus:,Synced
OutputRate:,60Hz
FilterProfile:,General
Measurement Mode:,Custom mode 5
StartTime: ,2025-07-11_20:06:00_086 WEST
(c) Movella Technologies B.V. 2005-2025

"""


def dot(folder: Path, names: list[str], values: np.ndarray) -> Path:
    ticks = (2**32 - 3_000_000 + np.round(rows()[:, 0] * 1e6).astype(np.int64)) % 2**32
    lines = [f"{i},{tick}," + ",".join(f"{v:.12g}" for v in row) for i, (tick, row) in enumerate(zip(ticks, values, strict=True))]
    path = folder / "DOT_1.csv"
    path.write_text(DOT_HEAD + table_text(",".join(["PacketCounter", "SampleTimeFine", *names]), lines))
    return path


@variant("movella-dot")
def dot_rate(folder: Path) -> Path:
    values = relative_field(rows())
    values[:, 3:6] = np.degrees(values[:, 3:6])
    return dot(folder, XYZ, values)


@variant("movella-dot")
def dot_custom(folder: Path) -> Path:
    quaternion = np.tile([1.0, 0, 0, 0], (len(rows()), 1))
    values = np.column_stack([quaternion, np.degrees(rows()[:, 4:7]), rows()[:, 1:4]])
    return dot(folder, ["Quat_W", "Quat_X", "Quat_Y", "Quat_Z", *XYZ[3:6], *XYZ[:3]], values)


@variant("movella-dot")
def dot_delta(folder: Path) -> Path:
    table, dt = rows(), 0.01
    turn = table[:, 4:7] * dt
    half = np.linalg.norm(turn, axis=1, keepdims=True) / 2
    dq = np.column_stack([np.cos(half), 0.5 * np.sinc(half / np.pi) * turn])
    names = ["dq_W", "dq_X", "dq_Y", "dq_Z", "dv[1]", "dv[2]", "dv[3]", *XYZ[6:], "Quat_W", "FreeAcc_X", "FreeAcc_Y", "FreeAcc_Z"]
    values = np.column_stack([dq, table[:, 1:4] * dt, table[:, 7:] / FIELD, np.zeros((len(table), 4))])
    return dot(folder, names, values)


# MetaMotion ------------------------------------------------------------------------------------------------------------


def metamotion_files(clock: str, stem: str, tail: str = "") -> dict[str, str]:
    files = {}
    for name, table, at, unit, factor in (
        ("Accelerometer", rows(), 1, "g", 1 / G),
        ("Gyroscope", rows(LATE_S), 4, "deg/s", np.degrees(1)),
        ("Magnetometer", rows(step=2), 7, "T", 1e-6),
    ):
        header = f"{clock},elapsed (s)," + ",".join(f"{a}-axis ({unit})" for a in "xyz")
        lines = []
        for row in table:
            ms = EPOCH_S * 1000 + round(row[0] * 1000)
            values = ",".join(f"{v:.9g}" for v in row[at : at + 3] * factor)
            lines.append(f"{ms},2023-11-14T15.13.20.000,{row[0]:.3f},{values}")
        files[f"{stem}_{name}{tail}.csv"] = table_text(header, lines)
    return files


@variant("metamotion")
def metamotion_folder(folder: Path) -> Path:
    return folded(folder, metamotion_files("epoch (ms),time (-07:00)", "MetaWear_2023-11-14T15.13.20_C0FFEE", "_100.000Hz_1.4.4"))


@variant("metamotion")
def metamotion_one_file(folder: Path) -> Path:
    """Two recordings in the folder; the file tells which."""
    folded(folder, metamotion_files("epoch (ms),time (-07:00)", "Other_2023-11-15T15.13.20_C0FFEE"))
    return folded(folder, metamotion_files("epoc (ms),timestamp (-0700)", "My_2023-11-14_C0FFEE")) / "My_2023-11-14_C0FFEE_Gyroscope.csv"


# Shimmer ---------------------------------------------------------------------------------------------------------------


def shimmer_text(sep: str, first: str, formatted: bool = False, low_noise: bool = True) -> str:
    table = rows()
    device = "Shimmer_40AC"
    clock = "TimestampSync_FormattedUnix" if formatted else "Timestamp_Unix"
    channels = [clock, *(f"Accel_WR_{a}" for a in "XYZ"), *(f"Gyro_{a}" for a in "XYZ"), *(f"Mag_{a}" for a in "XYZ")]
    units = ["yyyy/mm/dd hh:mm:ss.000" if formatted else "ms", *["m/(s^2)"] * 3, *["deg/s"] * 3, *["local_flux"] * 3]
    values = np.column_stack([table[:, 1:4], np.degrees(table[:, 4:7]), table[:, 7:] / FIELD])
    if low_noise:
        channels += [f"Accel_LN_{a}" for a in "XYZ"]
        units += ["m/(s^2)"] * 3
        values = np.column_stack([values, np.clip(table[:, 1:4], -2, 2)])
    lines = []
    for row, line in zip(table, numbers(values, sep, tail=sep), strict=True):
        stamp = f"2023/11/14 22:13:{20 + row[0]:06.3f}" if formatted else f"{(EPOCH_S + row[0]) * 1000:.16E}"
        lines.append(f"{stamp}{sep}{line}")
    return table_text(first, [sep.join(f"{device}_{c}_CAL" for c in channels) + sep, sep.join(units) + sep, *lines], "\r\n")


@variant("shimmer")
def shimmer_semicolon(folder: Path) -> Path:
    (path := folder / "Session1_Shimmer_40AC_Calibrated_SD.csv").write_text(shimmer_text(";", "sep=;"))
    return path


@variant("shimmer")
def shimmer_tab(folder: Path) -> Path:
    (path := folder / "Session1.csv").write_text(shimmer_text("\t", '"sep=\\t"', low_noise=False))
    return path


@variant("shimmer")
def shimmer_dates(folder: Path) -> Path:
    (path := folder / "Session1.csv").write_text(shimmer_text(",", '"sep=,"', formatted=True))
    return path
