"""How the paths of a page come to lie over one another and over the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError
from bematist.recording import Reference
from bematist.trajectory import Trajectory

if TYPE_CHECKING:
    from bematist.evaluate import Align, Alignment, Evaluation

Array = NDArray[np.float64]

ENOUGH = 5000
"""Rows of a dense reference by which an alignment that is only drawn is fitted."""


@dataclass(frozen=True)
class Overlay:
    """Alignments of the trajectories with the reference, None where there is none; the frame of the page is that of the `anchor`,
    the trajectory that fits the reference best.
    """

    alignments: tuple[Alignment | None, ...]
    anchor: int = 0

    @property
    def frame(self) -> Alignment | None:
        return self.alignments[self.anchor]

    def path(self, k: int, positions: Array, covariances: Array) -> tuple[Array, Array]:
        """Positions (N,3) and covariances (K,3,3) of the k-th trajectory in the frame of the page."""
        own, frame = self.alignments[k], self.frame
        if own is None or frame is None or k == self.anchor:
            return positions, covariances
        R = frame.rotation.T @ own.rotation
        return (own.path(positions) - frame.translation) @ frame.rotation, R @ covariances @ R.T

    def reference(self, reference: Reference | None) -> Reference | None:
        """The reference in the frame of the page; as it stands where nothing could be aligned."""
        if reference is None or self.frame is None:
            return reference
        return replace(reference, position=self.frame.onto_trajectory(reference.position))


def overlay(trajectories: Sequence[Trajectory], reference: Reference | None, evaluations: Sequence[Evaluation | None]) -> Overlay:
    """The overlay that evaluations ask for. A reference is mirrored for all or for none, as the best fitting path has it."""
    known = [k for k, e in enumerate(evaluations) if e is not None and np.isfinite(e.ate_plan_m)]
    if reference is None or not known:
        return Overlay((None,) * len(trajectories))
    anchor = min(known, key=lambda k: e.ate_plan_m if (e := evaluations[k]) else np.inf)
    frame = e.alignment if (e := evaluations[anchor]) else None
    found: list[Alignment | None] = []
    for t, e in zip(trajectories, evaluations, strict=True):
        own = e.alignment if e else None
        if own is not None and frame is not None and own.mirrored != frame.mirrored:
            own = _as_mirrored(t, reference, frame)
        found.append(own)
    return Overlay(tuple(found), anchor)


def _as_mirrored(t: Trajectory, reference: Reference, frame: Alignment) -> Alignment | None:
    """Alignment of a trajectory with the reference mirrored as `frame` has it."""
    from bematist.evaluate import evaluate

    fixed = replace(thinned(reference), mirrored=False)
    fixed = replace(fixed, position=frame.reference(fixed.position))
    return replace(evaluate(t, fixed, align=frame.kind).alignment, mirrored=frame.mirrored)


def thinned(reference: Reference) -> Reference:
    """A reference by which to align: a few thousand instants of a dense one say where it lies."""
    if reference.footfall is not None:
        return reference
    k = slice(None, None, -(-len(reference.time) // ENOUGH) or 1)
    attitude = None if reference.attitude is None else reference.attitude[k]
    return replace(reference, time=reference.time[k], position=reference.position[k], attitude=attitude)


def evaluate_all(trajectories: Sequence[Trajectory], reference: Reference | None, align: Align = "yaw") -> list[Evaluation | None]:
    """Evaluations by one kind of alignment; None without a reference, and where it cannot be compared."""
    if reference is None:
        return [None] * len(trajectories)
    from bematist.evaluate import evaluate

    found: list[Evaluation | None] = []
    for t in trajectories:
        try:
            found.append(evaluate(t, reference, align))
        except DataError:  # a reference of another time: the page then shows it as it stands
            found.append(None)
    return found
