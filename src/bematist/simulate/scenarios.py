"""Walks by name."""

from __future__ import annotations

import math
from itertools import pairwise

from bematist.simulate.disturbances import Dipole, Facade, FieldTurn, IndoorField, ParkedCars
from bematist.simulate.gaits import GAITS
from bematist.simulate.parameters import Point, Scenario


def _plan(*corners: tuple[float, float]) -> tuple[Point, ...]:
    return tuple((float(x), float(y), 0.0) for x, y in corners)


# A closed tour between buildings: along an avenue, a zig-zag, a road crossed at right angles, a parking lot, and back.
_CAMPUS = _plan(
    (0, 0), (120, 0), (120, 60), (150, 60), (153, 66), (156, 60), (159, 66), (162, 60), (165, 66), (168, 60), (230, 60),
    (230, 150), (255, 150), (255, 162), (230, 162), (230, 215), (140, 240), (60, 240), (60, 170), (100, 150), (100, 95),
    (40, 80), (-30, 110), (-60, 50), (-60, 0), (0, 0),
)  # fmt: skip
_RETURN = _plan((0, 0), (20, 0), (20, 9), (18, 9), (18, 2), (0, 2), (0, 0))
_RECTANGLE = _plan((0, 0), *[(9, 0), (9, 5), (0, 5), (0, 0)] * 3)
_ELLIPSE = _plan(*((5.5 * math.sin(a), 3.5 * (1 - math.cos(a))) for a in (math.tau * k / 24 for k in range(5 * 24 + 1))))
_MIXED = _plan((0, 0), (9, 0), (9, 6), (1, 6), (1, 1), (8, 1), (8, 5), (0, 5), *[(0, 0), (9, 0), (9, 6), (0, 6)] * 4, (0, 0))
_LAPS = _plan((0, 0), *[(60, 0), (60, 32), (0, 32), (0, 0)] * 3)
_LAP_M = 182.0


def _stairwell(floors: int) -> tuple[tuple[Point, ...], tuple[int, ...]]:
    """Corners and stairs of a walk to the stairwell, up to the highest floor by two flights a floor, down again, and back."""
    half, run, wide = 1.7, 4.2, 1.6
    corners: list[Point] = [(-12.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    for k in range(floors):
        low = 2 * half * k
        corners += [(run, 0.0, low + half), (run, wide, low + half), (0.0, wide, low + 2 * half), (0.0, 0.0, low + 2 * half)]
    top = 2 * half * floors
    corners += [(-8.0, 0.0, top), (-8.0, 1.0, top), (-0.9, 1.0, top), (0.0, wide, top)]
    for k in range(floors - 1, -1, -1):
        low = 2 * half * k
        corners += [(run, wide, low + half), (run, 0.0, low + half), (0.0, 0.0, low)]
        corners += [(0.0, wide, low)] if k else [(-12.0, 0.0, 0.0)]
    return tuple(corners), tuple(i for i, (a, b) in enumerate(pairwise(corners)) if a[2] != b[2])


# Along a parking lot, through a building by its corridors, around it, through it again, and back.
_BUILDING = _plan(
    (0, 0), (110, 0), (110, 60), (150, 60), (150, 100), (120, 100), (120, 130), (175, 130), (175, 70), (215, 70),
    (215, 150), (120, 150), (90, 180), (40, 180), (40, 90), (125, 85), (125, 115), (160, 115), (160, 75), (90, 75), (90, 20),
    (0, 20), (0, 0),
)  # fmt: skip
_STAIRWELL, _FLIGHTS = _stairwell(4)

SCENARIOS: dict[str, Scenario] = {
    "campus": Scenario(
        name="campus",
        waypoints=_CAMPUS,
        length_m=1300.0,
        pauses=((310.0, 12.0), (345.0, 8.0)),
        parked_cars=(ParkedCars(from_m=430.0, to_m=520.0), ParkedCars(from_m=900.0, to_m=950.0)),
        facades=(
            Facade(from_m=200.0, to_m=240.0, away_m=-2.5),
            Facade(from_m=620.0, to_m=690.0, away_m=2.5),
            Facade(from_m=1040.0, to_m=1090.0, away_m=-2.0),
        ),
        dipoles=(Dipole(at_m=150.0), Dipole(at_m=395.0, left_m=0.3), Dipole(at_m=760.0), Dipole(at_m=1180.0, left_m=-0.4)),
        field_turns=(FieldTurn(from_m=560.0, to_m=600.0), FieldTurn(from_m=980.0, to_m=1020.0, angle_deg=-20.0, axis="east")),
    ),
    "short": Scenario(name="short", waypoints=_RETURN, rest_s=10.0, final_rest_s=3.0),
    "straight": Scenario(name="straight", waypoints=_plan((0, 0), (100, 0))),
    "still": Scenario(name="still", waypoints=_plan((0, 0)), rest_s=600.0, final_rest_s=0.0),
    "tumble": Scenario(name="tumble", waypoints=_plan((0, 0)), tumble_rests=24, full_turns=True),
    "stairs": Scenario(name="stairs", waypoints=_STAIRWELL, stairs=_FLIGHTS, corner_radius_m=0.3),
    "building": Scenario(
        name="building",
        waypoints=_BUILDING,
        length_m=1500.0,
        gaits=((0.0, GAITS["brisk"]),),
        pauses=((215.0, 10.0), (800.0, 12.0)),
        parked_cars=(ParkedCars(from_m=40.0, to_m=120.0, away_m=3.5),),
        facades=(Facade(from_m=730.0, to_m=800.0, away_m=-4.0),),
        indoor_fields=(IndoorField(from_m=215.0, to_m=600.0), IndoorField(from_m=930.0, to_m=1210.0)),
    ),
    "rectangle": Scenario(name="rectangle", waypoints=_RECTANGLE),
    "ellipse": Scenario(name="ellipse", waypoints=_ELLIPSE, corner_radius_m=5.0, gaits=((0.0, GAITS["jog"]),)),
    "mixed": Scenario(
        name="mixed",
        waypoints=_MIXED,
        gaits=(
            (0.0, GAITS["walk"]), (40.0, GAITS["slow"]), (50.0, GAITS["jog"]), (95.0, GAITS["slow"]), (105.0, GAITS["walk"]),
            (125.0, GAITS["brisk"]), (145.0, GAITS["walk"]),
        ),
    ),
    "laps": Scenario(
        name="laps",
        waypoints=_LAPS,
        heading_deg=270.0,
        corner_radius_m=3.0,
        length_m=3 * _LAP_M,
        gaits=((0.0, GAITS["walk"]), (_LAP_M, GAITS["jog"]), (2 * _LAP_M, GAITS["walk"])),
    ),
}  # fmt: skip
"""Walks by name; docs/simulation.md says what they are."""
