"""Attitude on recordings whose truth is known: tables of docs/attitude.md and docs/hand.md, and pictures (part of `make accuracy`).

The recordings are looked for at BEMATIST_SHARED, then beside the project.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import ahrs
import numpy as np
import vqf
from pages import DATA, ROOT, fill, required

import bematist as bm
from bematist import frames
from bematist.ahrs import Ahrs
from bematist.evaluate.attitude import Align
from bematist.report import still_attitude

TRIALS: dict[str, tuple[str, Align]] = {
    "attitude/broad/12_undisturbed_slow_translation_C.mat": ("BROAD 12: slow translation, undisturbed", "none"),
    "attitude/broad/33_disturbed_attached_magnet_2cm.mat": ("BROAD 33: a magnet 2 cm from the sensor", "none"),
    "hand/nexus5_mocap/Guillaume_Nexus5_NoDist_Texting": ("phone, texting", "frames"),
    "hand/nexus5_mocap/Thibaud_Nexus5_NoDist_Swinging": ("phone, swinging", "frames"),
}
"""Recordings: what they are, and what is taken out of the error. A motion capture knows neither North nor the phone's axes."""
ALIGNED: dict[str, tuple[str, Align]] = {
    path: (words, "frames" if align == "frames" else "yaw")
    for (path, (_, align)), words in zip(
        TRIALS.items(), ("BROAD 12, undisturbed", "BROAD 33, magnet", "phone, texting", "phone, swinging"), strict=True
    )
}
"""The same in the tables of docs/hand.md, which judge how a heading is held and not where its North is."""
DRAWN = {"none": ("`gyro`", "`mahony`", "`madgwick`"), "frames": ("`gyint`", "`magyq-estimated`", "`hand`", "VQF, online")}
BLIND = {"integration": "first-order", "initial": {"gyro_bias_sd": 0.0}}
"""As printed, and without the gyroscope's offset from the rest: what the peers do."""
NWU_FROM_ENU = np.array([np.cos(np.pi / 4), 0, 0, -np.sin(np.pi / 4)])

Found = dict[str, bm.Attitude]


def own(r: bm.Recording) -> Found:
    found = {f"`{name}`": bm.attitude(r, name) for name in bm.FILTERS}
    found["`madgwick` without the field"] = bm.attitude(r, "madgwick", magnetometer=False, initial={"heading_deg": _start_heading(r)})
    found |= {f"`{name}`, as printed": bm.attitude(r, name, **BLIND) for name in ("mahony", "madgwick")}
    return found


def _start_heading(r: bm.Recording) -> float:
    return float(bm.attitude(r, "gyro").heading_deg[0])


def peers(r: bm.Recording) -> Found:
    """vqf, and where every sample has all three sensors the package ahrs, from the same start, and vqf offline."""
    online = {"VQF, online": _vqf(r)}
    if len(r.magnetic_time) != len(r) or not np.isfinite(r.specific_force).all():
        return online
    start = Ahrs(bm.FILTERS["madgwick"].parameters.override(BLIND))
    start.run(r)
    assert start.alignment is not None
    dt, q0 = 1 / r.rate_hz, start.alignment.attitude
    turned = frames.multiply(NWU_FROM_ENU, q0)
    madgwick = _loop(r, ahrs.filters.Madgwick(gain=0.12, Dt=dt).updateMARG, turned)
    mahony = _loop(r, ahrs.filters.Mahony(k_P=0.74, k_I=0.0012, Dt=dt).updateMARG, q0)
    sensors = [np.ascontiguousarray(a) for a in (r.angular_rate, r.specific_force, r.magnetic_flux_density)]
    return {
        "ahrs, Mahony": result(r, mahony),
        "ahrs, Madgwick": result(r, frames.multiply(frames.conjugate(NWU_FROM_ENU), madgwick)),
        **online,
        "VQF, offline": result(r, vqf.offlineVQF(*sensors, dt)["quat9D"]),
    }


def _vqf(r: bm.Recording) -> bm.Attitude:
    """VQF, sample by sample, each sensor at its own rate."""
    rows = r.samples()
    known = np.isfinite(rows[:, 4:7]).all(1)
    period = float(np.median(np.diff(r.magnetic_time))) if len(r.magnetic_time) > 1 else -1.0
    v, found = vqf.VQF(1 / r.rate_hz, -1.0, period), []
    for row in rows[known]:
        v.updateGyr(np.ascontiguousarray(row[4:7]))
        if np.isfinite(row[1:4]).all():
            v.updateAcc(np.ascontiguousarray(row[1:4]))
        if np.isfinite(row[7:10]).all():
            v.updateMag(np.ascontiguousarray(row[7:10]))
        found.append(v.getQuat9D())
    return bm.Attitude(time=r.time[known], attitude=np.array(found), gyro_bias=np.full((len(found), 3), np.nan))


def _loop(r: bm.Recording, update: Callable[..., np.ndarray], q: np.ndarray) -> np.ndarray:
    out = [q]
    for f, w, m in zip(r.specific_force[1:], r.angular_rate[1:], r.magnetic_flux_density[1:], strict=True):
        q = update(q, w, f, m)
        out.append(q)
    return np.array(out)


def result(r: bm.Recording, q: np.ndarray) -> bm.Attitude:
    return bm.Attitude(time=r.time, attitude=q, gyro_bias=np.full((len(r), 3), np.nan))


def judged(path: str, run: Callable[[bm.Recording], bm.Attitude]) -> str:
    """Rms of heading and tilt of a filter on one of `ALIGNED`, deg."""
    r = bm.read(DATA / path)
    assert r.reference is not None
    d = bm.evaluate_attitude(run(r), r.reference, ALIGNED[path][1]).to_dict()
    return f"{d['heading_rmse_deg']:.1f} / {d['tilt_rmse_deg']:.1f}"


def handheld() -> None:
    """The table of docs/hand.md."""
    runs = {f"`{name}`": partial(bm.attitude, filter=name) for name in ("gyint", "quest", "magyq", "magyq-estimated", "hand")}
    lines = ["| | " + " | ".join(words for words, _ in ALIGNED.values()) + " |", "|---" * (len(ALIGNED) + 1) + "|"]
    lines += ["| " + " | ".join([name, *(judged(path, run) for path in ALIGNED)]) + " |" for name, run in {**runs, "VQF": _vqf}.items()]
    fill(ROOT / "docs" / "hand.md", "recorded", lines)
    print("\n".join(lines), flush=True)


def main() -> None:
    required("attitude", "hand")
    handheld()
    columns: list[dict[str, str]] = []
    for path, (words, align) in TRIALS.items():
        print(words, flush=True)
        r = bm.read(DATA / path)
        assert r.reference is not None
        column, drawn = {}, []
        for name, a in {**own(r), **peers(r)}.items():
            e = bm.evaluate_attitude(a, r.reference, align)
            d = e.to_dict()
            column[name] = " / ".join(f"{d[f'{key}_rmse_deg']:.2f}" for key in ("attitude", "heading", "tilt"))
            if name in DRAWN[align]:
                moved = a if align == "none" else bm.Attitude(time=e.time, attitude=e.attitude, gyro_bias=np.empty((0, 3)))
                drawn.append(replace(moved, filter=name.strip("`")))
        columns.append(column)
        still_attitude(drawn, ROOT / f"docs/pictures/{Path(path).stem}.png", r.reference)
    lines = ["| filter | " + " | ".join(words for words, _ in TRIALS.values()) + " |", "|---" * (len(TRIALS) + 1) + "|"]
    lines += ["| " + " | ".join([name, *(c.get(name, "–") for c in columns)]) + " |" for name in columns[0]]
    fill(ROOT / "docs" / "attitude.md", "table", lines)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
