"""A still picture of Allan deviations with their intervals, the fitted noises and, beside them, the spectral density."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bematist.allan import AllanResult, SensorAllan, sheet
from bematist.allan.noises import FLICKER_FLOOR
from bematist.report.still import COLORS, picture_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


def still_allan(found: AllanResult, path_png: str | Path) -> None:
    """Draw the curves into a PNG, SVG or PDF file (by its suffix): a row for each sensor, the spectral density on the right.

    Raises
    ------
    UsageError
        A suffix that is no picture.
    DataError
        The file cannot be written.
    """
    from matplotlib.figure import Figure

    from bematist.outputs import whole_file

    path = picture_path(path_png)
    sensors = list(found.sensors.values())
    figure = Figure(figsize=(12, 4.2 * len(sensors)), layout="constrained")
    for row, sensor in zip(figure.subplots(len(sensors), 2, squeeze=False, width_ratios=[1.4, 1]), sensors, strict=True):
        _deviation(row[0], sensor)
        _density(row[1], sensor)
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=120, format=path.suffix[1:].lower())


def _deviation(axes: Axes, sensor: SensorAllan) -> None:
    unit, factor = sheet.curve_unit(sensor.name)
    for k, axis in enumerate(sensor.axes):
        color, fit = COLORS[k], sensor.fits[k]
        axes.plot(sensor.taus, factor * sensor.deviation[:, k], ".-", color=color, markersize=4, linewidth=1.0, label=axis)
        if fit is None:
            continue
        axes.fill_between(sensor.taus, factor * sensor.low[:, k], factor * sensor.high[:, k], color=color, alpha=0.18, linewidth=0)
        fine = np.geomspace(sensor.taus[0], sensor.taus[-1], 300)
        axes.plot(fine, factor * np.sqrt(fit.variance(fine)), "--", color=color, linewidth=1.0)
        _marks(axes, sensor, k, factor, color)
    axes.set(xscale="log", yscale="log", xlabel="averaging time τ (s)", ylabel=f"Allan deviation ({unit})", title=_title(sensor))
    _dress(axes)
    axes.legend(frameon=False, fontsize=9, title="axis", title_fontsize=9)


def _title(sensor: SensorAllan) -> str:
    return f"{sensor.name}, {sensor.samples / sensor.rate_hz / 3600:.3g} h at {sensor.rate_hz:.4g} Hz; band: 95 %, dashed: fitted noises"


def _marks(axes: Axes, sensor: SensorAllan, k: int, factor: float, color: str) -> None:
    """Where each coefficient is read off: N at 1 s, 0.664 B on its flat line, K at 3 s, the Gauss-Markov top at 1.89 T."""
    fit = sensor.fits[k]
    assert fit is not None
    at = {"white": (1.0, 1.0), "flicker": (sensor.lowest(k)[1], FLICKER_FLOOR), "walk": (3.0, 1.0)}
    if fit.correlation:
        at["markov"] = (1.89 * fit.correlation.value, 0.618)
    for noise, (tau, height) in at.items():
        if noise in fit.coefficients:
            y = factor * height * fit.coefficients[noise].value
            axes.plot(tau, y, "o", color=color, markersize=6, markeredgecolor="black", markeredgewidth=0.6)
            axes.annotate(sheet.SYMBOLS[noise], (tau, y), textcoords="offset points", xytext=(5, 5), fontsize=9, color=color)


def _density(axes: Axes, sensor: SensorAllan) -> None:
    unit, factor = sheet.curve_unit(sensor.name)
    frequency = sensor.frequency
    for k in range(len(sensor.axes)):
        fit, color = sensor.fits[k], COLORS[k]
        axes.plot(frequency, factor * np.sqrt(sensor.density[:, k]), color=color, linewidth=0.9)
        if fit is None:
            continue
        fitted = fit.density(frequency, 1 / sensor.rate_hz)
        axes.plot(frequency, factor * np.sqrt(fitted), "--", color=color, linewidth=1.0)
    axes.set(xscale="log", yscale="log", xlabel="frequency (Hz)", ylabel=f"root of the one-sided density ({unit}/√Hz)")
    _dress(axes)


def _dress(axes: Axes) -> None:
    axes.grid(which="major", color="#d5d9de", linewidth=0.6)
    axes.grid(which="minor", color="#eef0f2", linewidth=0.4)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_axisbelow(True)
