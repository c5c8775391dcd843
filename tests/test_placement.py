"""Where a path begins: shifted, turned, and taken from a reference."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bematist.errors import DataError, UsageError
from bematist.evaluate import evaluate
from bematist.frames import heading_deg_from_yaw
from bematist.placement import Placement, by_reference
from bematist.recording import Reference
from bematist.trajectory import Steps
from report_cases import walk


def moved_reference(angle: float, shift: tuple[float, float, float], first: int = 0) -> Reference:
    t = walk(12_000)
    c, s = math.cos(angle), math.sin(angle)
    p = t.position @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]).T + np.array(shift)
    rows = slice(first, None, 400)
    return Reference(time=t.time[rows], position=p[rows])


def test_everything_turns_and_only_the_position_is_shifted() -> None:
    t = walk(5000)
    placed = t.placed((10.0, -20.0, 3.0), turn_deg=90.0)
    assert placed.position[0] == pytest.approx([10, -20, 3]) and placed.north == "given"
    assert t.placed((10.0, -20.0, 3.0)).north == t.north
    east, north = (t.position - t.position[0])[:, :2].T
    assert placed.position[:, :2] == pytest.approx(np.column_stack([10 - north, -20 + east]), abs=1e-12)
    assert placed.velocity[:, :2] == pytest.approx(t.velocity[:, [1, 0]] * [-1, 1], abs=1e-12)
    assert placed.position_sd == pytest.approx(t.position_sd[:, [1, 0, 2]])
    turn = heading_deg_from_yaw(placed.euler[:, 2]) - heading_deg_from_yaw(t.euler[:, 2])
    assert np.mod(turn, 360) == pytest.approx(270, abs=1e-9)
    assert placed.summary()["start_m"] == pytest.approx([10, -20, 3])
    for same in ("distance_m", "closure_m", "height_change_m"):
        assert placed.summary()[same] == pytest.approx(t.summary()[same])


def test_the_directions_of_steps_turn_with_the_path() -> None:
    one = np.ones(3)
    words = np.array(["walking"] * 3)
    steps = Steps(
        time=one, counted=one, length=one, length_sd=one, frequency=one, direction=0.2 * one, direction_sd=one, motion=words, carrying=words
    )
    turned = replace(walk(500), steps=steps).placed(turn_deg=30.0)
    assert turned.steps is not None and np.degrees(turned.steps.direction - steps.direction) == pytest.approx(30)


def test_nothing_asked_for_is_nothing_done() -> None:
    t = walk(500)
    assert Placement().place(t) is t


@pytest.mark.parametrize("first", [0, 2400])
def test_a_path_begins_as_its_reference_does(first: int) -> None:
    t = walk(12_000)
    reference = moved_reference(2.1, (231.7, 190.2, 4.0), first)
    found = by_reference(t, reference, start=True, heading=True)
    assert math.radians(found.turn_deg) == pytest.approx(2.1)
    assert evaluate(found.place(t), reference, align="none").ate_m < 1e-9
    shifted = by_reference(t, reference, start=True, heading=False)
    assert shifted.turn_deg == 0
    there = np.interp(reference.time[0], t.time, shifted.place(t).position[:, 0])
    assert there == pytest.approx(reference.position[0, 0])
    turned = by_reference(t, reference, start=False, heading=True)
    assert turned.position is None and turned.turn_deg == pytest.approx(found.turn_deg)


def test_a_fix_just_before_the_first_sample_is_the_start() -> None:
    t = walk(12_000)
    reference = moved_reference(0.0, (5.0, 6.0, 0.0))
    reference.time[0] -= 0.3
    assert by_reference(t, reference, start=True, heading=False).position == pytest.approx((5.0, 6.0, 0.0))
    reference.time[0] -= 10
    later = by_reference(t, reference, start=True, heading=False).place(t)
    assert later.position[400] == pytest.approx(reference.position[1])


def test_an_unknown_height_stays_at_zero() -> None:
    reference = moved_reference(0.0, (5.0, 5.0, 0.0))
    reference.position[:, 2] = np.nan
    assert by_reference(walk(12_000), reference, start=True, heading=False).position == pytest.approx((5.0, 5.0, 0.0))


def test_a_reference_that_cannot_tell() -> None:
    t = walk(12_000)
    late = Reference(time=np.array([1e4]), position=np.zeros((1, 3)))
    with pytest.raises(DataError, match="no position at a time"):
        by_reference(t, late, start=True, heading=True)
    footfalls = Reference(time=np.full(3, np.nan), position=np.zeros((3, 3)), footfall=np.arange(3))
    with pytest.raises(DataError, match="no position at a time"):
        by_reference(t, footfalls, start=True, heading=False)
    standing = Reference(time=t.time[:50], position=np.ones((50, 3)))
    with pytest.raises(DataError, match="no heading can be taken"):
        by_reference(t, standing, start=False, heading=True)
    with pytest.raises(UsageError, match="position"):
        t.placed((1.0, float("nan"), 0.0))
