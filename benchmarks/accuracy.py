"""Every shoe recording at hand, and simulated walks, by every method.

`make accuracy` writes docs/accuracy.md, a picture of each recording, and the table in README.md.

The recordings are looked for at BEMATIST_SHARED, then beside the project; see docs/accuracy.md for what they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pages import DATA as RECORDINGS
from pages import ROOT, fill, required

import bematist as bm
from bematist.methods import worn
from bematist.report import still_path
from bematist.simulate import simulate

PICTURES = ROOT / "docs" / "pictures"
DATA = RECORDINGS / "foot"


@dataclass(frozen=True)
class Walk:
    """A recording: file, what it is, and what was published about it."""

    path: str
    what: str
    published: str = "–"
    aim: str = "–"


WALKS = (
    Walk(
        "gsu_gx5/SensorConnectData_32.csv",
        "walk, 80 m, disturbed field",
        "0.537 m mean, learned detector",
        "zupt ≤ 0.35 m, length within 2 %",
    ),
    Walk("gsu_gx5/SensorConnectData_35.csv", "run, 55 m"),
    Walk("ngimu/short_walk.csv", "walk, closed", "closure 0.082 m", "closure ≤ 0.10 m in plan, ≤ 0.25 m with height"),
    Walk("pyshoe_vicon/2017-11-22-11-22-03.mat", "walk", "0.032 m", "≤ 0.080 m"),
    Walk("pyshoe_vicon/2017-11-22-11-30-14.mat", "walk", "0.093 m", "≤ 0.233 m"),
    Walk("pyshoe_vicon/2017-11-27-11-18-11.mat", "run", "0.136 m"),
    Walk("pyshoe_vicon/2017-12-15-18-01-18.mat", "run", "0.072 m"),
    Walk("pyshoe_vicon/2018-02-09-11-18-04.mat", "slow, low motions, height", "0.049 m"),
    Walk("openshoe/OpenShoe_Matlab_Implementation_Measurement_100521_44_data_inert.txt", "walk, nearly closed", "0.2–1 % claimed"),
)


DRAWN = ("foot", "zupt", "maginav", "15mzha")
"""Methods in the pictures of recordings: all of them would hide one another."""
CAMPUS = ("foot", "zupt", "maginav")
"""Methods in the picture of the campus."""


def drawn(tracks: list[bm.Trajectory]) -> list[bm.Trajectory]:
    return [t for t in tracks if t.method in DRAWN]


def usual(found: dict[str, list[list[float]]]) -> int:
    """The seed whose walk is the most usual one for `zupt`: the plan rms nearest to the median."""
    rms = np.array(found["zupt"])[:, 0]
    return int(np.argmin(np.abs(rms - np.median(rms))))


def number(value: float | None, digits: int = 3) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.{digits}f}"


def row(recording: bm.Recording, method: str) -> tuple[bm.Trajectory, str]:
    """The trajectory and its line of the table."""
    t = bm.track(recording, method)
    closing = t.position[-1] - t.position[0]
    cells = [f"`{method}`", f"{t.distance_m:.1f}"]
    if recording.reference is not None:
        e = bm.evaluate(t, recording.reference, align="yaw").to_dict()
        cells += [number(e["ate_rmse_2d_m"]), number(e["ate_rmse_3d_m"]), number(100 * (e["length_ratio"] - 1), 1)]
        cells += [number(e["end_point_m"])]
    else:
        cells += ["–"] * 4
    cells += [number(float(np.linalg.norm(closing[:2]))), number(float(np.linalg.norm(closing)))]
    cells += [f"{100 * t.stance.mean():.0f}"]
    return t, "| " + " | ".join(cells) + " |"


def section(walk: Walk, measured: dict[tuple[str, str], str]) -> list[str]:
    """The lines about one recording; the plan rms goes into `measured` too."""
    recording = bm.read(DATA / walk.path)
    name = Path(walk.path).stem.replace("OpenShoe_Matlab_Implementation_Measurement_", "openshoe_")
    lines = [f"### {name}: {walk.what}", ""]
    lines += [f"Published: {walk.published}. Aim: {walk.aim}.", ""]
    lines += [
        "| method | distance m | rms plan m | rms 3-D m | length % | end m | start to end, plan m | start to end, 3-D m | stance % |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    tracks = []
    for method in worn("shoe"):
        t, line = row(recording, method)
        tracks.append(t)
        lines.append(line)
        measured[method, walk.path] = line.split(" | ")[2]
    still_path(drawn(tracks), PICTURES / f"{name}.png", reference=recording.reference)
    warnings = list(dict.fromkeys(w for t in tracks for w in t.warnings))
    if recording.reference is not None:
        warnings.append(f"Reference: {recording.reference.note}.")
    lines += ["", *(f"- {w}" for w in warnings), "", f"![{name}](pictures/{name}.png)", ""]
    return lines


SEEDS = 10


def campus() -> tuple[list[str], dict[str, tuple[float, ...]]]:
    """Simulated campus walks: lines for docs/accuracy.md, and by method medians for README.md.

    Plan rms, m; start to end, %; how many times faster than the walk itself.
    """
    found: dict[str, list[list[float]]] = {m: [] for m in worn("shoe")}
    for seed in range(SEEDS):
        print("campus", seed, flush=True)
        walk = simulate("campus", seed=seed)
        tracks = [bm.track(walk, m) for m in worn("shoe")]
        for t in tracks:
            e = bm.evaluate(t, walk.reference, align="origin").to_dict()
            nees = e["nees_position"]["mean"]
            speed = (t.time[-1] - t.time[0]) / t.processing_s
            found[t.method].append(
                [e["ate_rmse_2d_m"], e["ate_rmse_height_m"], e["closure_percent"], e["heading_rmse_deg"], e["end_point_m"], nees, speed]
            )
    lines = [
        f"## Simulated: 1.3 km around a campus in 20 minutes, {SEEDS} seeds",
        "",
        "`bematist simulate campus`: a closed walk past parked cars, facades and manholes with the noise of MAGINAV's sensor "
        "(LSM9DS1, Table 3 with its errata). The truth is exact; only the start is aligned. Median, and in brackets the 90 % quantile, "
        "over the seeds. NEES is of the position; a filter that knows how sure it is has 3.",
        "",
        "| method | rms plan m | rms height m | start to end % | rms heading ° | end m | NEES |",
        "|---|---|---|---|---|---|---|",
    ]
    for method, values in found.items():
        middle, high = np.quantile(values, [0.5, 0.9], 0)
        cells = [f"{m:.2f} ({h:.2f})" for m, h in zip(middle[:-1], high[:-1], strict=True)]
        lines.append(f"| `{method}` | " + " | ".join(cells) + " |")
    seed = usual(found)
    walk = simulate("campus", seed=seed)
    still_path([bm.track(walk, m) for m in CAMPUS], PICTURES / "campus.png", reference=walk.reference)
    lines += ["", f"The walk that is nearest to the median for `zupt`, seed {seed}:", "", "![campus](pictures/campus.png)", ""]
    return lines, {m: tuple(np.median(v, 0)[[0, 2, -1]]) for m, v in found.items()}


def readme(simulated: dict[str, tuple[float, ...]], measured: dict[tuple[str, str], str]) -> None:
    """Write the table of methods into README.md, between its marks."""
    lines = [
        "| method | what it is | campus, simulated: rms, start to end | walk (GSU 32): rms | run (GSU 35): rms | times real time |",
        "|---|---|---|---|---|---|",
    ]
    for m in worn("shoe").values():
        rms, closure, speed = simulated[m.name]
        walk, run = (measured.get((m.name, w.path), "–") for w in WALKS[:2])
        lines.append(f"| `{m.name}` | {m.summary} | {rms:.1f} m, {closure:.2f} % | {walk} m | {run} m | {speed:,.0f} |")
    fill(ROOT / "README.md", "methods", lines)


def main() -> None:
    required("foot")
    PICTURES.mkdir(exist_ok=True)
    lines = [
        "# Accuracy",
        "",
        "Written by `make accuracy`: simulated walks, and every shoe recording that the project is developed on, by every method with its "
        "own fixed parameters. Nothing is tuned per recording.",
        "",
    ]
    simulated_lines, simulated = campus()
    lines += simulated_lines
    lines += [
        "## Recordings",
        "",
        "Errors are after alignment by yaw (one turn about the vertical and one shift, least squares); where the reference's axes are "
        "left-handed it is mirrored first. Length is the path's against the reference's. The runs and the slow motions are reported as "
        "they are. Vicon samples between impossible jumps of the marker are left out (their number is in the warnings).",
        "",
    ]
    measured: dict[tuple[str, str], str] = {}
    for walk in WALKS:
        if (DATA / walk.path).exists():
            print(walk.path, flush=True)
            lines += section(walk, measured)
    (ROOT / "docs" / "accuracy.md").write_text("\n".join(lines).rstrip() + "\n")
    readme(simulated, measured)


if __name__ == "__main__":
    main()
