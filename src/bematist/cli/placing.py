"""Where a path begins and on which plan it is drawn: the options of `track` and `compare`, and what they mean together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bematist import config
from bematist.cli.options import ALIGNMENTS, numbers
from bematist.errors import UsageError

if TYPE_CHECKING:
    from bematist.floorplan import FloorPlan
    from bematist.placement import Placement
    from bematist.recording import Reference
    from bematist.trajectory import Trajectory

REFERENCE = "reference"
"""The word for "take it from the reference"."""

Start = Annotated[
    str | None,
    typer.Option(
        "--start",
        help="Where the path begins, m, or reference: at its first point.  [default: 0,0]",
        metavar="EAST,NORTH[,UP]|reference",
    ),
]
Heading = Annotated[
    str | None,
    typer.Option(
        "--heading",
        help="Heading of the sensor's x axis (in a hand: the axis that points ahead) at the start, degrees clockwise from North, or "
        "reference: begin in its direction.",
        metavar="DEG|reference",
    ),
]
Map = Annotated[Path | None, typer.Option("--map", help="Plan of the building to draw the path on: a picture or GeoJSON.", metavar="PLAN")]
MapScale = Annotated[
    float | None, typer.Option("--map-scale", help="Metres of a pixel of the plan, or of a unit of its coordinates.", metavar="M")
]
MapOrigin = Annotated[
    str | None,
    typer.Option(
        "--map-origin",
        help="The point of the plan that is 0, 0 of the path: pixels from its upper left corner, right and down, or LAT,LON.",
        metavar="X,Y",
    ),
]
MapRotation = Annotated[
    float | None, typer.Option("--map-rotation", help="Direction of the plan's up, degrees clockwise from North.", metavar="DEG")
]


@dataclass(frozen=True)
class Placing:
    """How paths are placed, and the plan below them."""

    placement: Placement
    start_from_reference: bool = False
    heading_from_reference: bool = False
    plan: FloorPlan | None = None

    @classmethod
    def given(
        cls,
        start: str | None,
        heading: str | None,
        file: Path | None,
        scale: float | None,
        origin: str | None,
        rotation: float | None,
        stored: Mapping[str, Any] | None = None,
    ) -> Placing:
        """From the options, laid over those of a stored configuration; the plan is read, so that a mistake is told at once.

        Raises
        ------
        UsageError, DataError
            An option does not make sense, or the plan cannot be read.
        """
        from bematist.placement import Placement

        stored = stored or {}
        placement = Placement().override(stored.get("start", {}))
        if start is not None and start != REFERENCE:
            place = numbers("--start", start, (2, 3), "12.5,-3")
            placement = placement.override({"position": (*place, 0.0)[:3]})
        if heading is not None:
            placement = placement.override({"turn_deg": 0.0})
        plan = {"file": None if file is None else str(file), "scale": scale, "rotation_deg": rotation}
        plan["origin"] = None if origin is None else numbers("--map-origin", origin, (2,), "120,840")
        return cls(placement, start == REFERENCE, heading == REFERENCE, _plan(plan, stored.get("map", {})))

    def alignment(self, wanted: str | None) -> str:
        """The alignment that is wanted; without a word, none for a path whose start is given: it is in the frame of the reference then."""
        given = self.start_from_reference or self.placement.position is not None
        return config.choose("alignment", wanted or ("none" if given else "yaw"), ALIGNMENTS)

    def settled(self, trajectory: Trajectory, truth: Reference | None) -> Placing:
        """The same in numbers, taken from the reference where that was asked for.

        Raises
        ------
        UsageError
            There is no reference.
        DataError
            The reference says nothing about the start.
        """
        if not (self.start_from_reference or self.heading_from_reference):
            return self
        if truth is None:
            raise UsageError("--start or --heading reference: there is no reference. Name it with --reference, or give numbers.")
        from bematist.placement import by_reference

        found = by_reference(trajectory, truth, start=self.start_from_reference, heading=self.heading_from_reference)
        position = found.position if self.start_from_reference else self.placement.position
        turn = found.turn_deg if self.heading_from_reference else self.placement.turn_deg
        return replace(
            self,
            placement=self.placement.override({"position": position, "turn_deg": turn}),
            start_from_reference=False,
            heading_from_reference=False,
        )

    def place(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory in its place, with a warning where it does not touch the plan."""
        placed = self.placement.place(trajectory)
        if self.plan is None or self.plan.share_inside(placed.position) > 0:
            return placed
        west, south, east, north = self.plan.bounds
        said = (
            f"No point of the path lies on the plan, which reaches from {west:,.0f} to {east:,.0f} m east and from {south:,.0f} to "
            f"{north:,.0f} m north: check --map-origin, --map-scale and --start."
        )
        return replace(placed, warnings=(*placed.warnings, said))

    def tables(self) -> dict[str, Any]:
        """For `config.toml`: [start] and [map], each where it says something."""
        found: dict[str, Any] = {}
        if self.placement.position is not None or self.placement.turn_deg:
            found["start"] = self.placement.model_dump()
        if self.plan is not None:
            found["map"] = self.plan.parameters.model_dump()
        return found


def heading_deg(text: str | None) -> float | None:
    """The heading as a number; None where there is none, or where the reference tells it."""
    if text is None or text == REFERENCE:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"--heading {text}: give degrees clockwise from North, or the word reference.")
    return value


def _plan(given: dict[str, Any], stored: Mapping[str, Any]) -> FloorPlan | None:
    from bematist.floorplan import FloorPlanParameters

    chosen = {key: value for key, value in given.items() if value is not None}
    if given["file"] is not None:
        stored = {}  # another plan lies elsewhere
    options = {"scale": "--map-scale", "origin": "--map-origin", "rotation_deg": "--map-rotation"}
    parameters = FloorPlanParameters().override({**stored, **chosen}, options)
    if parameters.file is None:
        if chosen:
            raise UsageError("--map-scale, --map-origin and --map-rotation say how a plan lies: name it with --map.")
        return None
    from bematist.io import read_floor_plan

    return read_floor_plan(
        Path(parameters.file).resolve(), scale=parameters.scale, origin=parameters.origin, rotation_deg=parameters.rotation_deg
    )
