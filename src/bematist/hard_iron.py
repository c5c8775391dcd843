"""A magnetometer's hard iron, followed while walking: what the filters of shoe and hand share of it (mathematics: `kernels.hard_iron`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.kernels import hard_iron_layout as at
from bematist.updates import HardIronParameters

Array = NDArray[np.float64]

_USE = {"off": at.OFF, "watch": at.WATCH, "correct": at.CORRECT}


def set_parameters(prm: Array, first: int, p: HardIronParameters, enters: Array) -> None:
    """The parameters of the kernel into prm[first:]; enters (3,3): how hard iron enters the reference that samples are compared with."""
    prm[first + at.USE] = _USE[p.use]
    prm[first + at.PRIOR], prm[first + at.NOISE] = p.prior_sd**2, p.sd**2
    prm[first + at.DELAY], prm[first + at.TURN] = p.delay_s**2, p.turn_error**2
    prm[first + at.DRIFT], prm[first + at.WALK], prm[first + at.MEMORY_S] = p.drift**2, p.field_walk**2, p.memory_s
    prm[first + at.JUMP], prm[first + at.BLOCK_S], prm[first + at.OWN_WALK] = p.jump, p.block_s, p.walk**2
    prm[first + at.EVIDENCE], prm[first + at.LEAST] = p.evidence, p.least
    prm[first + at.FROM : first + at.FROM + 9] = enters.ravel()


def begin(S: Array, first: int, p: HardIronParameters, start: float) -> None:
    """The state before the first sample, at `start` s, into the workspace S[first:]."""
    S[first + at.A] = 1.0
    S[first + at.P : first + at.P + 36].reshape(6, 6)[[3, 4, 5], [3, 4, 5]] = p.prior_sd**2
    S[first + at.LAST] = start
    # What the learned walk begins with weighs as much as it would be remembered.
    S[first + at.OVER_S] = 3 * p.memory_s
    S[first + at.EXCESS] = S[first + at.OVER_S] * p.field_walk**2


def extra_columns(p: HardIronParameters) -> int:
    """Columns of the diagnostics that it needs."""
    return 0 if p.use == "off" else at.COLUMNS


def diagnostics(d: NDArray[np.float32]) -> dict[str, NDArray[Any]]:
    """Its columns of the diagnostics (N,12), or (N,0), by their names."""
    if not d.shape[1]:
        return {}
    told = {c: d[:, at.TOLD + c - at.CHI] for c in range(at.CHI, at.APPLIED + 1)}
    return {
        "hard_iron": d[:, at.IRON : at.IRON + 3],
        "hard_iron_sd": d[:, at.IRON_SD : at.IRON_SD + 3],
        "hard_iron_chi2": told[at.CHI],
        "hard_iron_evidence": told[at.LN_B],
        "hard_iron_nis": told[at.NIS],
        "hard_iron_blocks": told[at.USED],
        "hard_iron_fields": told[at.BEGUN],
        "hard_iron_applied": told[at.APPLIED],
    }


def summary(found: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """What the summary of a result says of it, from the result's diagnostics; nothing where it was not looked for or no row is there."""
    b = found.get("hard_iron")
    if b is None or not len(b):
        return {}
    last = {name: float(found[f"hard_iron_{name}"][-1]) for name in ("evidence", "chi2", "blocks", "fields")}
    nis = found["hard_iron_nis"]
    return {
        "hard_iron": {
            "field_ut": [float(v) for v in b[-1]],
            "sd_ut": [float(v) for v in found["hard_iron_sd"][-1]],
            "ln_evidence": last["evidence"],
            "chi2": last["chi2"],
            "nis_mean": float(np.nanmean(nis)) if np.isfinite(nis).any() else math.nan,
            "blocks": int(last["blocks"]),
            "fields": int(last["fields"]),
            "taken_out": bool((found["hard_iron_applied"] > 0).any()),
        }
    }


def words(said: Mapping[str, Any]) -> str:
    """The entry of a summary, for a person."""
    values = ", ".join(f"{axis} {b:.1f} ± {sd:.1f}" for axis, b, sd in zip("xyz", said["field_ut"], said["sd_ut"], strict=True))
    return f"{values} µT; ln of evidence {said['ln_evidence']:.0f}, {said['blocks']} measurements"


def judge(time: Array, d: NDArray[np.float32], p: HardIronParameters) -> list[str]:
    """A warning where it is found at the end, or was taken out at any time: times (N,), s, and its columns of the diagnostics."""
    named = diagnostics(d)
    if not named or not len(time):
        return []
    said = summary(named)["hard_iron"]
    length = math.hypot(*said["field_ut"])
    applied = named["hard_iron_applied"] > 0
    found = said["ln_evidence"] >= p.evidence and length >= p.least
    if not (found or applied.any()):
        return []
    if not applied.any():
        then = "It was left in the readings (hard_iron.use = watch)."
    else:
        then = f"It was taken out from {time[np.argmax(applied)] - time[0]:.0f} s on"
        then += f", for {100 * applied.mean():.0f} % of the time." if not applied[-1] else "."
    if not found:
        return [f"A field of the magnetometer's own was believed for a while, and at the end is doubtful: {words(said)}. {then}"]
    return [
        f"The magnetometer shows a field of its own of {length:.1f} µT ({words(said)}), hard iron that a calibration takes out: `bematist "
        f"calibrate`. {then}"
    ]
