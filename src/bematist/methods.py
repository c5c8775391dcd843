"""The table of named methods: each a documented set of parameters of one estimator."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bematist.errors import UsageError
from bematist.foot import FootIns, FootParameters
from bematist.recording import Recording
from bematist.trajectory import Trajectory


@dataclass(frozen=True)
class Method:
    """A method: what it is called, where it comes from, what it is good for, and its parameters."""

    name: str
    summary: str
    paper: str
    equations: str
    parameters: FootParameters


def _foot(**changes: Any) -> FootParameters:
    return FootParameters().override(changes)


METHODS: dict[str, Method] = {
    m.name: m
    for m in (
        Method(
            "foot",
            "The default for a shoe: zero velocity believed by how quiet the stance is, walking and running alike, and heading from the "
            "magnetic field where it is undisturbed.",
            "bematist",
            "MAGINAV 1-7, 14-24; noise following the stance statistic; heading as a measurement",
            _foot(
                stance={"rule": "relative", "window_s": 0.05},
                magnetic={"use": "heading"},
                noise={"angle_random_walk": math.radians(0.2), "velocity_random_walk": 0.1},
            ),
        ),
        Method(
            "zupt",
            "Zero-velocity updates only, one threshold for walking: what most of the field runs.",
            "Papafotis & Sotiriadis 2023 (MAGINAV), Skog et al. 2010",
            "1-3, 6-9, 14-24",
            _foot(),
        ),
        Method(
            "maginav",
            "Zero-velocity updates, and the attitude replaced by TRIAD in stance where the magnetic field is undisturbed: outdoors.",
            "Papafotis & Sotiriadis 2023 (MAGINAV)",
            "1-25 and Table 2, corrected",
            _foot(magnetic={"use": "reset"}),
        ),
    )
}


def find_method(name: str) -> Method:
    """The method of that name; UsageError names the nearest ones."""
    if name not in METHODS:
        near = difflib.get_close_matches(name, METHODS, n=1)
        hint = f"Did you mean {near[0]}?" if near else ""
        raise UsageError(f"There is no method {name!r}. {hint} Known are: {', '.join(METHODS)}.".replace("  ", " "))
    return METHODS[name]


def track(
    recording: Recording,
    method: str = "foot",
    *,
    config: Mapping[str, Any] | None = None,
    chunk: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    **overrides: Any,
) -> Trajectory:
    """The path of a recording by a named method.

    config and overrides change parameters of the method, nested: `track(r, "zupt", stance={"threshold": 200})`; a threshold makes the
    stance rule absolute unless a rule is given with it. chunk feeds that many
    samples at a time (the result is the same to the bit). progress is called with samples done and of all.

    Raises
    ------
    UsageError
        The method or a parameter is unknown.
    DataError
        The recording cannot be processed.
    """
    if not isinstance(recording, Recording):
        raise UsageError(f"track takes a Recording, not {type(recording).__name__}: read the file first, track(read(path)).")
    m = find_method(method)
    parameters = m.parameters.override(_with_rule(config or {})).override(_with_rule(overrides))
    return FootIns(parameters, method=m.name).run(recording, chunk=chunk, progress=progress)


def _with_rule(changes: Mapping[str, Any]) -> Mapping[str, Any]:
    """A threshold belongs to the absolute rule: who gives one means that rule."""
    stance = changes.get("stance")
    if isinstance(stance, Mapping) and stance.get("threshold") is not None and "rule" not in stance:
        return {**changes, "stance": {**stance, "rule": "absolute"}}
    return changes
