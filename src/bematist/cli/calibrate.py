"""`calibrate`: from a recording of a sensor turned about in the hand to its calibration."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bematist.cli import options
from bematist.cli.app import app
from bematist.cli.console import facts, output, progress, table, warn
from bematist.cli.options import Reading
from bematist.errors import UsageError

if TYPE_CHECKING:
    from bematist.calibrate import Calibration, SensorCalibration


@app.command()
def calibrate(
    recordings: Annotated[list[Path], typer.Argument(help="Files (or folders) of one sensor.", metavar="RECORDING…")],
    out: Annotated[Path, typer.Option("--output", "-o", help="File to write; the report stands beside it.", metavar="SENSOR.toml")] = Path(
        "sensor.toml"
    ),
    gravity: Annotated[float | None, typer.Option("--gravity", help="Gravity there, m/s².  [default: 9.80665]", metavar="G")] = None,
    latitude: Annotated[
        float | None, typer.Option("--latitude", help="Latitude, degrees, in place of gravity.", min=-90, max=90, metavar="DEG")
    ] = None,
    field: Annotated[
        float | None, typer.Option("--field", help="The Earth's flux density there; without it the mean scale stays.", metavar="µT")
    ] = None,
    turn: Annotated[
        list[str] | None,
        typer.Option(
            "--turn", help="A turn of known angle, degrees, between two rests, such as z=360; may be repeated.", metavar="AXIS=DEG"
        ),
    ] = None,
    sensor: Annotated[
        list[str] | None,
        typer.Option("--sensor", help="Only this one: accelerometer, gyroscope or magnetometer; may be repeated.", metavar="NAME"),
    ] = None,
    axes: options.Axes = None,
    units: options.Units = None,
    clock: options.Clock = None,
    columns: options.Columns = None,
    format: options.Format = None,
    uncalibrated: options.Uncalibrated = False,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write SENSOR.html and SENSOR.png.")] = True,
    quiet: options.Quiet = False,
) -> None:
    """Calibrate a sensor from a recording of it in the hand.

    Rest it in nine positions or more, each side up once, and turn it every way in between. Writes SENSOR.toml, which the other commands
    take with --calibration, and a report.
    """
    g = _gravity(gravity, latitude)
    if field is not None and not 1 < field < 1000:
        raise UsageError(f"--field {field}: give the Earth's flux density in µT, 20 to 70.")
    reading = Reading.given(format, columns, axes, units, clock, uncalibrated=uncalibrated)
    files = [out, out.with_suffix(".html"), out.with_suffix(".png")] if report else [out]
    options.keep(recordings, files)
    with progress("reading", quiet=quiet):
        data = [reading.read(path) for path in recordings]
    from bematist.calibrate import calibrate as solve

    with progress("calibrating", quiet=quiet):
        found = solve(data, gravity=g, field=field, turns=turn or (), sensors=sensor or ())
    if report:
        from bematist.report import still_calibration, write_calibration_page

        with progress("writing", quiet=quiet):
            write_calibration_page(found, files[1])
            still_calibration(found, files[2])
    found.save(out)
    if not quiet:
        show(found)
        beside = f", see {files[1]}" if report else ""
        output().print(f"Calibration in {out}{beside}; bematist track … --calibration {out}", soft_wrap=True)
        warn(found.warnings)


def _gravity(gravity: float | None, latitude: float | None) -> float:
    from bematist.earth import STANDARD_GRAVITY, normal_gravity

    if gravity is not None and latitude is not None:
        raise UsageError("Give either --gravity or --latitude.")
    if latitude is not None:
        return normal_gravity(math.radians(latitude))
    if gravity is not None and not 9.7 < gravity < 9.9:
        raise UsageError(f"--gravity {gravity}: on the Earth it is 9.76 to 9.84 m/s².")
    return STANDARD_GRAVITY if gravity is None else gravity


def show(found: Calibration) -> None:
    """Print the calibration and how good it is."""
    from bematist.calibrate.words import counted, error_text, rows, verdict

    name = Path(found.source).name or "recording"
    output().print(f"{name} · {', '.join(found.sensors)}", style="bold", soft_wrap=True)
    header = ["sensor", "parameter", "x", "y", "z", "unit"]
    output().print(table(header, [row for s in found.sensors.values() for row in rows(s)], right=(2, 3, 4)))
    lines = []
    for sensor in found.sensors.values():
        lines += [(sensor.sensor, f"{counted(sensor)}: {error_text(sensor)}; {verdict(sensor)}")]
    if found.evidence is not None and found.evidence.rests.left_out:
        lines.append(("no rests", f"{found.evidence.rests.left_out} more, which turned slowly or swayed"))
    told = found.evidence is not None and found.evidence.turns_told
    lines += [("known turn" if told else "whole turn?", text) for text in _turns(found)]
    if found.evidence is not None and math.isfinite(found.evidence.elevation_deg):
        lines.append(("field", f"{_sensor(found, 'magnetometer').length:.2f} µT, {-found.evidence.elevation_deg:.1f}° below the horizon"))
    output().print(facts(lines))


def _sensor(found: Calibration, name: str) -> SensorCalibration:
    return found.sensors[name]


def _turns(found: Calibration) -> list[str]:
    if found.evidence is None or "gyroscope" not in found.sensors:
        return []
    how = "told" if found.evidence.turns_told else "not told; nearest whole turn"
    return [
        f"about {t.axis}: {t.before:.2f}° as read, {t.after:.2f}° calibrated ({how} {t.angle:.0f}°)" for t in found.evidence.known_turns
    ]
