"""Options that several commands share, and what they mean together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from bematist import config
from bematist.errors import UsageError

if TYPE_CHECKING:
    from bematist.clock import Mode
    from bematist.recording import Recording, Reference

CLOCKS = ("auto", "uniform", "stamps")
ALIGNMENTS = ("none", "origin", "yaw", "se3")
READING = ("format", "columns", "axes", "units", "clock", "calibration", "uncalibrated")

RecordingPath = Annotated[Path, typer.Argument(help="File (or folder) of the sensor.", metavar="RECORDING")]
Format = Annotated[str | None, typer.Option("--format", help="Format of the recording; without it the file is recognised.", metavar="NAME")]
Columns = Annotated[
    Path | None,
    typer.Option("--columns", help="TOML file that says which column of a CSV is what.", metavar="MAP.toml"),
]
Axes = Annotated[
    str | None,
    typer.Option("--axes", help='The sensor\'s axes named anew, such as "x,-z,y".', metavar="AXES"),
]
Units = Annotated[
    list[str] | None,
    typer.Option(
        "--units",
        help="Unit of a quantity where the file does not tell, such as specific_force=g or time=ms; may be repeated.",
        metavar="QUANTITY=UNIT",
    ),
]
Clock = Annotated[
    str | None,
    typer.Option(
        "--clock",
        help="auto: decide by evidence; uniform: the stamps are jittered reports of an even clock; stamps: they are true.",
        metavar="auto|uniform|stamps",
    ),
]
Calibration = Annotated[
    Path | None,
    typer.Option("--calibration", help="Calibrate the readings by what `bematist calibrate` wrote.", metavar="SENSOR.toml"),
]
Uncalibrated = Annotated[bool, typer.Option("--uncalibrated", help="Take a phone's raw readings, not those that it calibrates itself.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", help="Change a parameter, such as stance.threshold=2e5; may be repeated.", metavar="NAME=VALUE"),
]
ReferencePath = Annotated[Path | None, typer.Option("--reference", help="The true path, to compare with.", metavar="REFERENCE")]
Align = Annotated[
    str,
    typer.Option("--align", help="How the path is laid over the reference first.", metavar="|".join(ALIGNMENTS)),
]
AlignOrPlaced = Annotated[
    str | None,
    typer.Option(
        "--align", help="How the path is laid over the reference first.  [default: yaw; none with --start]", metavar="|".join(ALIGNMENTS)
    ),
]
Heading = Annotated[
    float | None,
    typer.Option("--heading", help="Heading of the sensor's x axis at the start, degrees clockwise from North.", metavar="DEG"),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]


@dataclass(frozen=True)
class Reading:
    """How a recording is to be read: the options of `bematist.read` that were given."""

    format: str | None = None
    columns: Path | None = None
    axes: str | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    clock: Mode = "auto"
    calibration: Path | None = None
    uncalibrated: bool = False

    @classmethod
    def given(
        cls,
        format: str | None,
        columns: Path | None,
        axes: str | None,
        units: Sequence[str] | None,
        clock: str | None,
        stored: Mapping[str, Any] | None = None,
        *,
        calibration: Path | None = None,
        uncalibrated: bool = False,
    ) -> Reading:
        """From the options, laid over those of a stored configuration."""
        stored = stored or {}
        for key in stored:
            config.choose("reading option", key, READING)
        table = {k: v for k, v in stored.items() if v != config.NONE}
        columns = columns or (Path(table["columns"]) if "columns" in table else None)
        calibration = calibration or (Path(table["calibration"]) if "calibration" in table else None)
        return cls(
            format=format or table.get("format"),
            columns=columns.resolve() if columns else None,
            axes=axes or table.get("axes"),
            units={**table.get("units", {}), **_units(units or [])},
            clock=cast("Mode", config.choose("clock", clock or table.get("clock", "auto"), CLOCKS)),
            calibration=calibration.resolve() if calibration else None,
            uncalibrated=uncalibrated or bool(table.get("uncalibrated", False)),
        )

    def read(self, path: Path) -> Recording:
        """The recording, calibrated where a calibration is given; axes and channel are then those that it was made for, unless told."""
        from bematist.io import read

        axes, uncalibrated, calibration = self.axes, self.uncalibrated, None
        if self.calibration is not None:
            from bematist.calibrate.store import load

            calibration = load(self.calibration)
            axes, uncalibrated = axes or calibration.sensing.axes or None, uncalibrated or calibration.sensing.uncalibrated
        found = read(
            path,
            format=self.format,
            columns=self.columns,
            axes=axes,
            units=dict(self.units) or None,
            clock=self.clock,
            uncalibrated=uncalibrated,
        )
        return found if calibration is None else calibration.apply(found)

    def table(self) -> dict[str, Any]:
        """For `config.toml`."""
        return {
            "format": self.format,
            "columns": str(self.columns) if self.columns else None,
            "axes": self.axes,
            "units": dict(self.units),
            "clock": self.clock,
            "calibration": str(self.calibration) if self.calibration else None,
            "uncalibrated": self.uncalibrated,
        }


def numbers(option: str, text: str, counts: Sequence[int], example: str) -> tuple[float, ...]:
    """Numbers with commas between.

    Raises
    ------
    UsageError
        They are not finite numbers, or not as many as in `counts`.
    """
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) not in counts or not all(math.isfinite(n) for n in found):
        many = " or ".join(map(str, counts))
        raise UsageError(f"{option} {text}: write {many} numbers with commas between, such as {example}.")
    return found


def _units(texts: Sequence[str]) -> dict[str, str]:
    units = {}
    for text in (part for argument in texts for part in argument.split(",")):
        quantity, equals, unit = (part.strip() for part in text.partition("="))
        if not (quantity and equals and unit):
            raise UsageError(f"--units {text}: write it as quantity=unit, such as specific_force=g.")
        units[quantity] = unit
    return units


def read_truth(path: Path | None, recording: Recording) -> Reference | None:
    """The reference that was given, else the one the recording came with, else None."""
    if path is None:
        return recording.reference
    from bematist.io import read_reference

    return read_reference(path, start_ns=recording.start_ns)


def folder_for(recording: Path, wanted: Path | None, suffix: str = "") -> Path:
    """The output folder: the one asked for, else one named after the recording, in the current folder."""
    if wanted is not None:
        return wanted
    name = recording.resolve().stem + suffix
    folder = Path(name)
    taken = folder.exists() and (not folder.is_dir() or folder.resolve() == recording.resolve())
    return Path(f"{name}-track") if taken else folder


def keep(inputs: Iterable[Path | None], outputs: Iterable[Path]) -> None:
    """Refuse to write over what is read.

    Raises
    ------
    UsageError
        An output is one of the inputs.
    """
    outputs = list(outputs)
    for source in inputs:
        if source is not None and source.exists() and any(o.exists() and o.samefile(source) for o in outputs):
            raise UsageError(f"{source}: the result would be written over it. Choose another name with -o.")
