"""Where a path begins and which way it goes: a trajectory shifted and turned into the frame of a building, a map or a reference."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, FiniteFloat

from bematist.errors import DataError, UsageError
from bematist.frames import multiply, quaternion_from_euler, yaw_from_heading_deg
from bematist.parameters import Parameters
from bematist.recording import Reference
from bematist.trajectory import PACKED, Trajectory

Array = NDArray[np.float64]

FIRST_LEG_M = 20.0
"""Length of a reference from its first fix by which the heading is taken, m."""

SHORTEST_LEG_M = 2.0
"""A reference, or a path, that does not get farther than this on its first leg tells no heading."""


EARLY_S = 1.0
"""A fix at most this much before the first sample, s, counts as at that sample: phones start their sensors one after the other."""


class Placement(Parameters):
    """How a path is laid into its frame once it is tracked: turned about its own start, then shifted."""

    position: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = Field(
        default=None, description="Where the path begins, east, north, up, m; none: at 0, 0, 0, or where the method begins it."
    )
    turn_deg: float = Field(
        default=0.0, allow_inf_nan=False, description="How far the path is turned about the vertical, degrees, counter-clockwise."
    )

    def place(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory in its place. Everything turns together: path, velocities, attitudes, covariances."""
        if self.turn_deg:
            trajectory = replace(turned(trajectory, 90.0 - self.turn_deg), north="given")
        if self.position is None:
            return trajectory
        return replace(trajectory, position=trajectory.position + (np.array(self.position) - trajectory.position[0]))


def turned(trajectory: Trajectory, heading_deg: float) -> Trajectory:
    """The trajectory in true East, North, Up, where its own East axis has this true heading."""
    if not np.isfinite(heading_deg):
        raise UsageError(f"Heading {heading_deg}: give degrees clockwise from North.")
    yaw = float(yaw_from_heading_deg(heading_deg))
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    upper = np.triu_indices(3)
    steps = trajectory.steps
    packed = trajectory.packed_covariance
    blocks = [(R @ packed[:, PACKED + 6 * k] @ R.T)[:, *upper] for k in range(3)]
    return replace(
        trajectory,
        position=trajectory.position @ R.T,
        velocity=trajectory.velocity @ R.T,
        attitude=multiply(quaternion_from_euler(0.0, 0.0, yaw), trajectory.attitude),
        steps=None if steps is None else replace(steps, direction=np.mod(steps.direction + yaw + np.pi, 2 * np.pi) - np.pi),
        packed_covariance=np.concatenate(blocks, axis=1),
    )


def by_reference(trajectory: Trajectory, reference: Reference, *, start: bool, heading: bool) -> Placement:
    """The placement by which a path begins as its reference does: at its first fix, and in the direction of its first 20 m.

    A first fix that comes later than the path's start is where the path is at that time. Without `start` the path is turned only, without
    `heading` it is shifted only.

    Raises
    ------
    DataError
        No fix of the reference lies in the time of the path, or path or reference stay where they are on the first leg.
    """
    from bematist.evaluate.pairing import sample

    p = reference.position
    inside = (reference.time >= trajectory.time[0] - EARLY_S) & (reference.time <= trajectory.time[-1] + 1e-6)
    rows = np.flatnonzero(inside & np.isfinite(p[:, :2]).all(1))
    if not len(rows):
        raise DataError(
            "The reference has no position at a time of the recording, so the path cannot begin with it. Give --start EAST,NORTH and "
            "--heading as numbers, or a reference with times."
        )
    at = np.clip(reference.time[rows], trajectory.time[0], trajectory.time[-1])
    true = np.where(np.isfinite(p[rows]), p[rows], 0.0)
    turn = math.degrees(_turn(sample(trajectory, at)["position"], true)) if heading else 0.0
    if not start:
        return Placement(turn_deg=turn)
    moved = Placement(turn_deg=turn).place(trajectory)
    first = moved.position[0] + true[0] - sample(moved, at[:1])["position"][0]
    return Placement(position=(float(first[0]), float(first[1]), float(first[2])), turn_deg=turn)


def _turn(mine: Array, true: Array) -> float:
    """The turn, rad, that lays the first leg of a path (K,3) over that of its reference, both from the first fix (least squares)."""
    mine, true = mine[:, :2] - mine[0, :2], true[:, :2] - true[0, :2]
    gone = np.concatenate([[0.0], np.linalg.norm(np.diff(true, axis=0), axis=1).cumsum()])
    n = max(2, int(np.searchsorted(gone, FIRST_LEG_M, side="right")))
    a, b = mine[:n], true[:n]
    if min(np.linalg.norm(leg, axis=1).max() for leg in (a, b)) < SHORTEST_LEG_M:
        raise DataError(
            f"On the first {FIRST_LEG_M:g} m of the reference, path or reference get no farther than {SHORTEST_LEG_M:g} m from the first "
            "fix: no heading can be taken from that. Give --heading in degrees."
        )
    return math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
