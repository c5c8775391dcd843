"""What a walk does to the hand, in the axes of the walker: swing, twist, bounce, footfalls, wander, tremor and gestures."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.ndimage import uniform_filter1d

from bematist.frames import multiply, quaternion_from_rotation_vector
from bematist.simulate.carry import Walker
from bematist.simulate.paces import Route

Array = NDArray[np.float64]

RATE_HZ = 100.0
"""Of the instants through which the splines go."""

_CARRY_S = 1.5
"""How long a hand takes to another place, s."""

_USUAL_HEIGHT_M = 1.75
_FORTH_M = 0.007
"""Amplitude of the body's speeding up and slowing down with each step, m, at 1.3 m/s."""

_TWICE = 0.12
"""Rise and fall twice a step, of that once a step: a foot lands harder than it leaves."""

_AT_REST = 0.2
"""Wander of a standing hand, of that of a walking one."""

_EVERY_S = {"wander": 4.0, "unsteady": 0.09, "tremor": 0.05}
"""Time between the numbers that are drawn, s."""

_GESTURE_S = 2.0


@dataclass(frozen=True, eq=False)
class _Held:
    """How the sensor is held at N instants, columns of `Carry.row`."""

    place: Array
    arm: Array
    swing: Array
    twist: Array
    unsteady: Array
    wander: Array
    tremor: Array
    follow: Array
    jolt: Array
    device: Array


def in_the_hand(route: Route, walker: Walker, time: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Where the sensor is (N,3), m, and how it is turned (N,4), in the axes of the walker, at instants `RATE_HZ` apart."""
    zero = np.zeros(len(time))
    held = _held(route, walker, time)
    phase = 2 * np.pi * smoothed(route.steps.phase_at(time), 0.4)
    step = route.steps.number_at(time)
    # Who stands makes step −1, which is the row appended.
    effort, bounce = smoothed(np.column_stack([np.append(of, 0.0)[step] for of in (route.effort, route.bounce_m)]), 0.8).T
    size = _size(effort)
    swing = held.swing * size * (np.cos(phase / 2) + 0.12 * np.cos(phase))
    turn, shift = _gestures(route, walker, time, rng)
    starts = 2 * np.pi * rng.uniform(size=3)
    turn += held.twist * np.column_stack([size * np.sin(a + b) for a, b in zip((phase / 2, phase, phase / 2), starts, strict=True)])
    turn += held.unsteady * size[:, None] * _noise("unsteady", time, rng)
    turn += held.wander * (_AT_REST + (1 - _AT_REST) * np.minimum(size, 1.0))[:, None] * _noise("wander", time, rng)
    turn += held.tremor * _noise("tremor", time, rng)
    turn[:, 2] += np.radians(walker.misalignment_deg + walker.misalignment_sd_deg * rng.standard_normal())
    arm = quaternion_from_rotation_vector(np.column_stack([zero, -swing, zero]))
    attitude = multiply(multiply(quaternion_from_rotation_vector(turn), arm), held.device)
    place = shift + walker.height_m / _USUAL_HEIGHT_M * (held.place + held.arm * np.column_stack([np.sin(swing), zero, -np.cos(swing)]))
    rise = -bounce / 2 * (1 + walker.limp * np.cos(phase / 2)) * (np.cos(phase) + _TWICE * np.cos(2 * phase + 1.0))
    sway = (_FORTH_M * effort * np.sin(phase + 0.5), walker.sway_side_m * size * np.sin(phase / 2), rise)
    return place + held.follow * np.column_stack(sway) + _jolts(route, walker, held.jolt, time, rng), attitude


def _size(effort: Array) -> Array:
    # Who walks faster turns and shakes the hand more, but not in proportion.
    return 1.5 * effort / (0.5 + effort)


def _held(route: Route, walker: Walker, time: Array) -> _Held:
    rows = np.array([carry.row for _, carry in walker.carries])
    k = np.searchsorted([at for at, _ in walker.carries], route.steps.along_at(time), side="right") - 1
    # Of q and −q the one that is nearer to what was before.
    for before, row in pairwise(rows):
        row[-4:] *= -1.0 if before[-4:] @ row[-4:] < 0 else 1.0
    numbers = smoothed(rows[k], _CARRY_S) if len(rows) > 1 else rows[k]
    place, arm, swing, twist, unsteady, wander, tremor, follow, jolt, device = np.split(numbers, (3, 4, 5, 8, 9, 10, 11, 12, 13), axis=1)
    device = device / np.linalg.norm(device, axis=1, keepdims=True)
    return _Held(place, arm, swing[:, 0], twist, unsteady, wander, tremor, follow, jolt[:, 0], device)


def smoothed(x: Array, seconds: float) -> Array:
    """Values (N,…) `RATE_HZ` apart, averaged over about that long: three running means, so that two derivatives are continuous."""
    width = max(1, round(seconds * RATE_HZ / 3)) | 1
    for _ in range(3):
        x = uniform_filter1d(x, width, axis=0, mode="nearest")
    return x


def _noise(what: str, time: Array, rng: np.random.Generator) -> Array:
    # (N,3) of about unit variance: a cubic spline through numbers that are drawn.
    knots = np.arange(-3, int(time[-1] / _EVERY_S[what]) + 4) * _EVERY_S[what]
    return make_interp_spline(knots, rng.standard_normal((len(knots), 3)), k=3)(time)


def _gestures(route: Route, walker: Walker, time: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    # Turn and shift (N,3), in the pauses of the walk, of a hand that does something else for two seconds.
    turn, shift = np.zeros((len(time), 3)), np.zeros((len(time), 3))
    steps, carries = route.steps, {carry.name: carry for _, carry in walker.carries}
    for k in np.flatnonzero(steps.begin[1:] - steps.time[:-1] > _GESTURE_S + 1):
        carry = carries[str(steps.carry[k])]
        begin, last = steps.time[k] + 0.5, steps.begin[k + 1] - _GESTURE_S - 0.5
        for at in rng.uniform(begin, last, rng.poisson(carry.gestures / 60 * (last - begin))):
            u = np.clip((time - at) / _GESTURE_S, 0, 1)
            bump = (4 * u * (1 - u))[:, None] ** 4
            turn += np.radians(carry.gesture_deg) * rng.standard_normal(3) * bump
            shift += 0.08 * rng.standard_normal(3) * bump
    return turn, shift


def _jolts(route: Route, walker: Walker, size: Array, time: Array, rng: np.random.Generator) -> Array:
    # (N,3): after each footfall the hand rings, up and down, and half as much back and forth.
    steps, out = route.steps, np.zeros((len(time), 3))
    rings = {carry.name: carry.ring_hz for _, carry in walker.carries}
    hz = np.array([rings[str(name)] for name in steps.carry])
    drawn = _size(route.effort) * np.exp(0.3 * np.clip(rng.standard_normal(len(steps)), -2.5, 2.5))
    for ring in np.unique(hz):
        mine = np.flatnonzero(hz == ring)
        first = np.ceil(steps.time[mine] * RATE_HZ).astype(np.int64)
        rows = first[:, None] + np.arange(int(4 / ring * RATE_HZ))
        tau = (rows / RATE_HZ - steps.time[mine, None]) * ring
        # Begins with three derivatives of zero, and is gone after four periods.
        pulse = np.sin(2 * np.pi * tau) * np.exp(-1.2 * tau) * (1 - np.exp(-4 * tau)) ** 3 * np.clip(1 - tau / 4, 0, 1) ** 4
        inside = rows < len(time)
        value = (pulse * drawn[mine, None])[inside] * size[rows[inside]]
        np.add.at(out[:, 2], rows[inside], -value)
        np.add.at(out[:, 0], rows[inside], 0.5 * value)
    return out
