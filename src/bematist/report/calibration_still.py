"""A still picture of a calibration: where the readings lie on the sphere, and what the length is off before and after."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bematist.calibrate import Calibration
from bematist.errors import DataError
from bematist.report.calibration_spheres import Sphere, spheres
from bematist.report.still import COLORS, dress, picture_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def still_calibration(found: Calibration, path_png: str | Path) -> None:
    """Draw a calibration that was just made into a PNG, SVG or PDF file (by its suffix), a row for each sensor.

    Raises
    ------
    UsageError
        A suffix that is no picture.
    DataError
        The calibration was read from a file, or the picture cannot be written.
    """
    from matplotlib.figure import Figure

    from bematist.outputs import whole_file

    path = picture_path(path_png)
    if found.evidence is None:
        raise DataError("A calibration that was read from a file has no evidence to draw. Calibrate from the recording.")
    drawn = spheres(found)
    turned = "gyroscope" in found.sensors and len(found.evidence.turns) > 0
    figure = Figure(figsize=(11, 3.6 * (len(drawn) + turned)), layout="constrained")
    plots = figure.subplots(max(len(drawn) + turned, 1), 2, squeeze=False, width_ratios=[1.25, 1])
    for row, s in zip(plots, drawn, strict=False):
        _map(row[0], s)
        _errors(row[1], s)
    if turned:
        _turns(plots[-1], found)
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=120, format=path.suffix[1:].lower())


def _map(axes: Axes, s: Sphere) -> None:
    """Directions over the whole sphere, longitude about z and latitude, so that a hole is seen."""
    u = s.after / np.linalg.norm(s.after, axis=1, keepdims=True)
    east, north = np.degrees(np.arctan2(u[:, 1], u[:, 0])), np.degrees(np.arcsin(u[:, 2]))
    size = 14 if len(u) < 200 else 3
    axes.scatter(east[s.kept], north[s.kept], s=size, color=COLORS[0], label="used")
    if (~s.kept).any():
        axes.scatter(east[~s.kept], north[~s.kept], s=size, color=COLORS[1], label="left out")
        axes.legend(frameon=False, fontsize=9)
    for name, place in {"+x": (0, 0), "+y": (90, 0), "-y": (-90, 0), "-x": (180, 0), "+z": (0, 92), "-z": (0, -93)}.items():
        axes.annotate(name, place, color="#555b63", fontsize=9, ha="center", va="center")
    axes.set(xlim=(-185, 185), ylim=(-99, 99), xticks=range(-180, 181, 90), yticks=range(-90, 91, 45))
    axes.set(xlabel="longitude about z (°)", ylabel="latitude (°)", title=f"{s.sensor}: {s.what}")
    dress(axes)


def _errors(axes: Axes, s: Sphere) -> None:
    before, after = (e[s.kept] for e in s.errors)
    edges = np.linspace(min(before.min(), after.min()), max(before.max(), after.max()) + 1e-9, 60)
    for name, error, color in ((f"as read{s.shifted}", before, COLORS[1]), ("calibrated", after, COLORS[0])):
        label = f"{name}: {np.sqrt(np.mean(error**2)):.3g} % rms"
        axes.hist(error, bins=edges.tolist(), color=color, alpha=0.6, label=label)
    axes.set(xlabel="error of the length (%)", ylabel="how often", yscale="log", title=f"{s.sensor}: length")
    axes.legend(frameon=False, fontsize=9)
    dress(axes)


def _turns(row: np.ndarray, found: Calibration) -> None:
    assert found.evidence is not None
    way, before, after = found.evidence.turns.T
    for name, missed, color in (("as read", before, COLORS[1]), ("calibrated", after, COLORS[0])):
        row[0].plot(way, missed, "o", color=color, markersize=5, label=f"{name}: {np.median(missed):.2g}° in the median")
    row[0].set(xlabel="turned between two rests (°)", ylabel="gravity missed by (°)", title="gyroscope: turns between rests")
    row[0].legend(frameon=False, fontsize=9)
    dress(row[0])
    told = found.evidence.known_turns
    at = np.arange(len(told))
    for name, angles, color, offset in (
        ("as read", [t.before for t in told], COLORS[1], -0.18),
        ("calibrated", [t.after for t in told], COLORS[0], 0.18),
    ):
        row[1].bar(at + offset, [a - t.angle for a, t in zip(angles, told, strict=True)], 0.34, color=color, label=name)
    row[1].axhline(0, color="black", linewidth=0.8)
    row[1].set_xticks(at, [f"{t.axis} {t.angle:.0f}°" for t in told])
    row[1].set(
        ylabel="measured less that angle (°)", title="turns that were told" if found.evidence.turns_told else "turns that look whole"
    )
    row[1].set_visible(bool(told))
    dress(row[1])
