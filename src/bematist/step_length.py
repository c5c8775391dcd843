"""Calibration of the step length s = h (a f + b) + c (MAGYQ eq 47) by walks whose length is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from bematist.config import choose
from bematist.errors import DataError, UsageError
from bematist.hand.path_parameters import StepLengthParameters
from bematist.methods import find_method, track
from bematist.recording import Recording, Reference
from bematist.trajectory import Steps

Array = NDArray[np.float64]
Model = Literal["scale", "line", "full"]
MODELS = ("auto", "scale", "line", "full")

FIX_SD = 0.3
"""How exactly a known place meets the step of that instant, m: about a third of a step. A reference that is itself worse (GNSS) is taken
for as good; its errors are seen in the residuals only."""

BETWEEN_WALKS = 0.03
"""How much the length of one walker's steps differs from walk to walk (shoes, ground, haste), relative: no calibration tells more."""

CERTAIN = 0.3
"""A model is taken by itself where it gives the growth with the frequency, a, to this share of its published value."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """Pieces of walks between known places.

    columns (K,3): the sums over the steps of each of h f, h and 1, each step counted by its share along the way; length (K,) m;
    count (K,) how many steps.
    """

    columns: Array
    length: Array
    count: Array


@dataclass(frozen=True, eq=False)
class StepLengthCalibration:
    """What was found.

    Attributes
    ----------
    a, b, c : of eq 47.
    covariance : (3,3) of a, b, c; zero for what was not fitted.
    model : scale (the published a, b, c times one factor), line (a and c, b = 0: all that one walker's frequencies can tell), or full.
    factor : length of the fitted steps over that of the published ones, and its standard deviation.
    height : of the walker, m; None where there were several.
    step_sd : scatter of a single step that the residuals tell, relative to its length (NaN with too few stretches).
    stretches, steps, distance_m : how much was walked.
    residual_m : rms of what is left over a stretch.
    warnings : what is suspicious.
    """

    a: float
    b: float
    c: float
    covariance: Array
    model: Model
    factor: float
    factor_sd: float
    height: float | None
    step_sd: float
    stretches: int
    steps: float
    distance_m: float
    residual_m: float
    warnings: tuple[str, ...]

    def parameters(self) -> dict[str, float]:
        """Changes of the group `step_length` of the methods for a hand: eq 47 alone, for it is this walker's own now."""
        own = {"height": self.height} if self.height is not None else {}
        scale_sd = math.hypot(self.factor_sd, BETWEEN_WALKS)
        return {**own, "a": self.a, "b": self.b, "c": self.c, "pendulum": 0.0, "scale_sd": scale_sd}

    def length(self, frequency: float, height: float) -> float:
        """Step length at a step frequency (Hz) of a walker of that height (m), m."""
        return height * (self.a * frequency + self.b) + self.c

    def to_dict(self) -> dict[str, object]:
        """The content of the JSON file."""
        sds = np.sqrt(np.diag(self.covariance))
        return {
            **{name: getattr(self, name) for name in ("a", "b", "c", "model", "factor", "factor_sd", "height", "step_sd")},
            **dict(zip(("a_sd", "b_sd", "c_sd"), map(float, sds), strict=True)),
            "covariance": self.covariance.tolist(),
            **{name: getattr(self, name) for name in ("stretches", "steps", "distance_m", "residual_m")},
            "warnings": list(self.warnings),
        }


def calibrate_steps(
    recordings: Recording | Sequence[Recording],
    references: Reference | Sequence[Reference | None] | None = None,
    *,
    heights: float | Sequence[float] = 1.75,
    distances: float | Sequence[float | None] | None = None,
    model: str = "auto",
    method: str = "hand",
    stretch_s: float = 10.0,
) -> StepLengthCalibration:
    """The parameters a, b, c of the step length, by least squares on walks whose length is known.

    A walk's length is given (`distances`, m along the path), or follows from a reference (waypoints, GNSS, motion capture; None: the one
    that came with the recording). Between fixes of a reference at least `stretch_s` apart, the distance as the crow flies is laid against
    the steps, each with its share in that direction; so bends between fixes do not matter, and neither does the reference's north.

    One walker's steps cannot tell all three: for one height the columns h f, h and 1 have rank 2 (erratum of eq 47). So `full` needs
    walkers of different heights; `line` fits a and c and sets b = 0, which for this height is the same; `scale` multiplies the published
    a, b, c by one factor, which is all that walks at one pace can tell. `auto` takes the richest that tells a to 30 %.

    Parameters
    ----------
    recordings : one or more walks.
    references, heights, distances : one for all, or one for each walk; heights in m.
    model : auto, scale, line or full.
    method : of `METHODS`, for a hand: its steps and headings are used.

    Raises
    ------
    UsageError
        The model or the method is unknown, or there are not as many references, heights or distances as recordings.
    DataError
        No reference and no distance, no steps, or fewer stretches than parameters.
    """
    choose("model", model, MODELS)
    if find_method(method).worn != "hand":
        raise UsageError(f'The method "{method}" is for a shoe and has no step length. Take one for a hand, such as hand.')
    walks = [recordings] if isinstance(recordings, Recording) else list(recordings)
    truths = _each("references", references, len(walks), Reference)
    tall = _each("heights", heights, len(walks), (int, float))
    far = _each("distances", distances, len(walks), (int, float))
    found = []
    for walk, truth, h, d in zip(walks, truths, tall, far, strict=True):
        steps = track(walk, method).steps
        assert steps is not None
        found.append(_stretches(walk, steps, truth or walk.reference, float(h), d, stretch_s))  # pyright: ignore[reportArgumentType]
    joined = Stretches(*(np.concatenate([getattr(s, name) for s in found]) for name in ("columns", "length", "count")))
    one = float(tall[0]) if len(set(tall)) == 1 else None  # pyright: ignore[reportArgumentType]
    return solve(joined, model, one)


def _each(what: str, given: object, n: int, kind: type | tuple[type, ...]) -> list[object]:
    if given is None or isinstance(given, kind):
        return [given] * n
    values = list(cast("Sequence[object]", given))
    if len(values) != n:
        raise UsageError(f"There are {n} recordings and {len(values)} {what}: give one for each, or one for all.")
    return values


def _stretches(walk: Recording, steps: Steps, truth: Reference | None, height: float, distance: float | None, apart_s: float) -> Stretches:
    """The pieces of one walk."""
    name = walk.source or "The recording"
    walking = steps.motion == "walking"
    if walking.sum() < 2:
        raise DataError(f"{name}: no walk was found in it, {len(steps)} steps in all. Look at `bematist steps`.")
    weights = np.column_stack([height * steps.frequency, np.full(len(steps), height), np.ones(len(steps))])
    if distance is not None:
        if not distance > 0:
            raise UsageError(f"The distance {distance} of {name} is not above zero: give metres along the path.")
        # Runs and stairs have lengths of their own.
        left = float(distance) - float(steps.length[~walking].sum())
        if not left > 0:
            raise DataError(f"{name}: the steps that ran or climbed stairs are longer together than the {distance:g} m that are given.")
        return Stretches(weights[walking].sum(0)[None], np.array([left]), np.array([float(walking.sum())]))
    if truth is None:
        raise DataError(f"{name} has no reference and no distance is given: step lengths cannot be calibrated without either.")
    time, place = _fixes(truth, walk, apart_s)
    if len(time) < 2:
        raise DataError(f"{name}: the reference has {len(time)} place(s) with a time within the recording. Two or more make a stretch.")
    # Between two steps of a walk the sums grow evenly; u: the direction of each step.
    u = np.column_stack([np.cos(steps.direction), np.sin(steps.direction)])
    own = np.diff(_at(time, steps, steps.length[:, None] * u), axis=0)
    length, mine = np.linalg.norm(np.diff(place, axis=0), axis=1), np.linalg.norm(own, axis=1)
    ahead = own / np.where(mine > 0, mine, 1.0)[:, None]
    # Sums of w u over a stretch, projected on the direction in which the path went: the derivative of the distance to a, b and c.
    columns = np.stack([(np.diff(_at(time, steps, w[:, None] * u), axis=0) * ahead).sum(1) for w in weights.T], 1)
    count = np.diff(_at(time, steps, np.ones((len(steps), 1))), axis=0)[:, 0]
    running = np.diff(_at(time, steps, (~walking)[:, None].astype(float)), axis=0)[:, 0]
    # Where the path turns back on itself the distance as the crow flies says little; runs and stairs have lengths of their own.
    good = (count >= 3) & (mine > 0.5 * np.diff(_at(time, steps, steps.length[:, None]), axis=0)[:, 0]) & (running == 0)
    return Stretches(columns[good], length[good], count[good])


def _fixes(truth: Reference, walk: Recording, apart_s: float) -> tuple[Array, Array]:
    """Times and plan positions of a reference inside the recording, thinned to at least `apart_s` seconds."""
    p = truth.position[:, :2]
    good = np.isfinite(p).all(1) & np.isfinite(truth.time) & (truth.time >= walk.time[0] - 1.0) & (truth.time <= walk.time[-1] + 1e-6)
    kept: list[int] = []
    for i in np.flatnonzero(good):
        if not kept or truth.time[i] - truth.time[kept[-1]] >= apart_s:
            kept.append(int(i))
    return truth.time[kept], p[kept]


def _at(time: Array, steps: Steps, values: Array) -> Array:
    """Sums over the steps of values (K,m) up to times (T,): in a walk, a step grows over its own duration."""
    start = np.concatenate([[steps.time[0] - 1 / steps.frequency[0]], steps.time])
    sums = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, 0)])
    return np.column_stack([np.interp(time, start, column) for column in sums.T])


def solve(s: Stretches, model: str, height: float | None) -> StepLengthCalibration:
    """Least squares over stretches. DataError where there are fewer of them than parameters, or they cannot tell them apart."""
    published = StepLengthParameters()
    start = np.array([published.a, published.b, published.c])
    if not len(s.length):
        raise DataError("There is no stretch to calibrate with: between fixes of the reference lie fewer than 3 steps, or they turn back.")
    sd = np.sqrt(s.count * (published.sd * s.length / s.count) ** 2 + 2 * FIX_SD**2)
    bases: dict[Model, Array] = {
        "full": np.eye(3),
        "line": np.array([[1.0, 0, 0], [0, 0, 1.0]]).T,
        "scale": start[:, None],
    }
    for name, basis in bases.items():
        # b = 0 stands for no loss of generality with one height only.
        if model not in ("auto", name) or (model == "auto" and name == "line" and height is None):
            continue
        x, covariance = _least_squares(s.columns @ basis, s.length, sd)
        if covariance is None:
            if model == name or name == "scale":
                raise DataError(_RANK[name])
            continue
        x, covariance = basis @ x, basis @ covariance @ basis.T
        residual = s.length - s.columns @ x
        free = len(s.length) - basis.shape[1]
        covariance = covariance * _scatter(residual / sd, free)
        if math.sqrt(covariance[0, 0]) < CERTAIN * published.a or name in (model, "scale"):
            break
    else:
        raise AssertionError("scale is always tried")
    middle = s.columns.sum(0) / s.count.sum()
    factor = float(middle @ x / (middle @ start))
    return StepLengthCalibration(
        *map(float, x),
        covariance=covariance,
        model=name,
        factor=factor,
        factor_sd=math.sqrt(max(0.0, float(middle @ covariance @ middle))) / float(middle @ x),
        height=height,
        step_sd=_step_sd(residual, s) if free >= 3 else math.nan,
        stretches=len(s.length),
        steps=float(s.count.sum()),
        distance_m=float(s.length.sum()),
        residual_m=float(np.sqrt(np.mean(residual**2))),
        warnings=tuple(_doubts(name, model, factor, s)),
    )


def _least_squares(A: Array, y: Array, sd: Array) -> tuple[Array, NDArray[np.floating] | None]:
    """Weighted solution and covariance; None where the columns do not tell the parameters apart."""
    W, z = A / sd[:, None], y / sd
    size = np.linalg.norm(W, axis=0)
    if len(y) < A.shape[1] or not (size > 0).all() or np.linalg.cond(W / size) > 1e6:
        return np.zeros(A.shape[1]), None
    covariance = np.linalg.inv(W.T @ W)
    return covariance @ (W.T @ z), covariance


def _scatter(normalised: Array, free: int) -> float:
    """What the residuals, over their assumed standard deviations, say of the variance: believed from ten degrees of freedom on, and
    with fewer only where it is larger.
    """
    seen = float((normalised**2).sum() / free) if free > 0 else 1.0
    return seen if free >= 10 else max(1.0, seen if free >= 3 else 1.0)


def _step_sd(residual: Array, s: Stretches) -> float:
    """Scatter of one step, relative: what the residuals have beyond the fixes."""
    beyond = max(0.0, float((residual**2 - 2 * FIX_SD**2).sum() / (s.length**2 / s.count).sum()))
    return math.sqrt(beyond)


_RANK: dict[Model, str] = {
    "full": "a, b and c cannot be told apart: one walker's columns h f, h and 1 have rank 2, whatever the pace. Give walks of people of "
    "different heights, or take the model line.",
    "line": "a and c cannot be told apart: the pace was the same on every stretch, or there is only one. Walk at different paces, or take "
    "the model scale.",
    "scale": "There is no step on the stretches whose length is known.",
}


def _doubts(model: Model, wanted: str, factor: float, s: Stretches) -> list[str]:
    found = []
    if model == "line":
        found.append("One walker cannot tell b from c: b = 0 was set, so that a and c are right for this height only.")
    if model == "scale" and wanted == "auto":
        found.append("The pace hardly varied: only the length as a whole was calibrated, by one factor on the published a, b and c.")
    if not 0.75 < factor < 1.33:
        found.append(
            f"The steps are {factor:.2f} times as long as a walker's usually are: is the height right, were steps missed, or is the "
            "reference of another walk?"
        )
    if len(s.length) < 3:
        found.append(f"Only {len(s.length)} stretch(es): the covariance rests on the assumed scatter of steps, not on what was seen.")
    return found
