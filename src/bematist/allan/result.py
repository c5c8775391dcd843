"""What `allan` found: curves, noises, and the numbers that the filters take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bematist.allan import sheet
from bematist.allan.fit import Estimate, Fit
from bematist.allan.noises import FLICKER_FLOOR

if TYPE_CHECKING:
    import polars as pl

Array = NDArray[np.float64]

HORIZON_S = 100.0
"""s, see `AllanResult.noise`."""
FILTER_NAMES = (
    ("gyroscope", "angle_random_walk", "gyro_bias_walk"),
    ("accelerometer", "velocity_random_walk", "accel_bias_walk"),
)
"""Sensors, and the filter's names of their white noise and of the walk of their bias."""
FAST_S = 0.5
"""s: what is correlated for less is white to a filter of a person's motion."""


@dataclass(frozen=True, eq=False, repr=False)
class SensorAllan:
    """The Allan deviation of one sensor.

    Attributes
    ----------
    name : accelerometer, gyroscope, magnetometer or quaternion.
    axes : names of its A axes.
    rate_hz, samples : sampling rate, and samples used.
    taus : (M,) averaging times, s.
    deviation : (M,A) overlapping Allan deviation, m/s², rad/s, µT or without unit.
    low, high : (M,A) its 95 % interval: chi-square with the equivalent degrees of freedom.
    edf : (M,A) equivalent degrees of freedom under the fitted noises (Greenhall & Riley 2003, see `covariance`).
    frequency, density : (F,) Hz and (F,A) one-sided spectral density of the longest stretch without a gap, unit²/Hz.
    fits : one for each axis; None where the axis does not vary, and for the quaternion's w, which is not Gaussian.
    """

    name: str
    axes: tuple[str, ...]
    rate_hz: float
    samples: int
    taus: Array
    deviation: Array
    low: Array
    high: Array
    edf: Array
    frequency: Array
    density: Array
    fits: tuple[Fit | None, ...]

    def __repr__(self) -> str:
        return f"SensorAllan({self.name}, {self.samples} samples at {self.rate_hz:.5g} Hz, {len(self.taus)} averaging times)"

    def lowest(self, axis: int) -> tuple[float, float]:
        """Lowest point of the curve: deviation and averaging time, s. Some data sheets call it the bias instability."""
        k = int(np.nanargmin(self.deviation[:, axis]))
        return float(self.deviation[k, axis]), float(self.taus[k])

    def verdicts(self) -> dict[str, str]:
        """Of each axis, how well the noises describe its curve."""
        return {axis: "not fitted" if fit is None else fit.verdict() for axis, fit in zip(self.axes, self.fits, strict=True)}

    def verdict(self) -> str:
        """The verdicts in one line."""
        found = self.verdicts()
        same = set(found.values())
        return same.pop() if len(same) == 1 else "; ".join(f"{axis} {verdict}" for axis, verdict in found.items())

    def white(self) -> float | None:
        """White noise N, root mean square over the axes that the noises describe (`Fit.good`); None where there is none.

        A Gauss-Markov process faster than `FAST_S` is white noise behind a low-pass filter: it counts as 2 s² T.
        """
        squares = []
        for fit in self.fits:
            if fit is not None and fit.good:
                own = fit.coefficients["white"].value ** 2 if "white" in fit.coefficients else 0.0
                fast = 2 * fit.coefficients["markov"].value ** 2 * fit.correlation.value if _fast(fit) and fit.correlation else 0.0
                squares.append(own + fast)
        return float(np.sqrt(np.mean(squares))) if squares else None

    def drift(self, horizon_s: float) -> float | None:
        """The random walk with the same Allan deviation at an averaging time as all that was found besides white noise; None without.

        The mean of the axes that the noises describe (`Fit.good`). A noise that may be none (`Fit.doubtful`) is left out, and an axis where
        nothing else is slow with it.
        """
        slow = []
        for fit in self.fits:
            if fit is not None and fit.good:
                fast = ("white", "quantisation", *(("markov",) if _fast(fit) else ()), *fit.doubtful)
                left = float(fit.variance(np.array([horizon_s]), without=fast)[0])
                if left > 0 or not fit.doubtful:
                    slow.append(left)
        return float(np.sqrt(3 * np.mean(slow) / horizon_s)) if slow and max(slow) > 0 else None


def _fast(fit: Fit) -> bool:
    return fit.correlation is not None and fit.correlation.value < FAST_S


@dataclass(frozen=True, eq=False, repr=False)
class AllanResult:
    """The Allan deviations of a recording.

    Attributes
    ----------
    sensors : by name: accelerometer, gyroscope, magnetometer where there is one, and quaternion where it was asked for.
    start_s, end_s : the rest that was used, s on the recording's clock.
    source, warnings : of the recording, and what was found on the way.
    """

    sensors: Mapping[str, SensorAllan]
    start_s: float
    end_s: float
    source: str = ""
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"AllanResult({self.source or 'arrays'}, {', '.join(self.sensors)}, {self.start_s:.1f} to {self.end_s:.1f} s)"

    def __getitem__(self, name: str) -> SensorAllan:
        return self.sensors[name]

    def to_polars(self) -> pl.DataFrame:
        """The curves, a row for each sensor, axis and averaging time; `fit` is the deviation of the fitted noises."""
        import polars as pl

        frames = []
        for s in self.sensors.values():
            for k, axis in enumerate(s.axes):
                fit = s.fits[k]
                frames.append(
                    pl.DataFrame(
                        {
                            "sensor": [s.name] * len(s.taus),
                            "axis": [axis] * len(s.taus),
                            "tau": s.taus,
                            "deviation": s.deviation[:, k],
                            "low": s.low[:, k],
                            "high": s.high[:, k],
                            "edf": s.edf[:, k],
                            "fit": np.full(len(s.taus), np.nan) if fit is None else np.sqrt(fit.variance(s.taus)),
                        }
                    )
                )
        return pl.concat(frames)

    def coefficients(self) -> list[dict[str, Any]]:
        """One row for each coefficient: sensor, axis, noise, symbol, value, low, high and unit in SI, and as data sheets write it.

        `found` is false for a noise that was not found; its `high` is then the bound below which it may hide.
        """
        return [row for s in self.sensors.values() for k, fit in enumerate(s.fits) if fit is not None for row in _rows(s, k, fit)]

    def noise(self, horizon_s: float = HORIZON_S) -> dict[str, float]:
        """Process noise of the foot filter (`NoiseParameters`): rad/s/√Hz, m/s²/√Hz, rad/s/√s, m/s²/√s, root mean square over the axes.

        The filter knows biases only as random walks. What was found of bias instability, Gauss-Markov, random walk and ramp is turned
        into the random walk with the same Allan deviation at `horizon_s`: the time for which the filter must trust a bias. What the
        recording was too short to show is left out, and axes whose curve the noises do not describe; see `left_out`.
        """
        out: dict[str, float | None] = {}
        for sensor, white, walk in FILTER_NAMES:
            out |= {white: self[sensor].white(), walk: self[sensor].drift(horizon_s)}
        return {name: value for name, value in out.items() if value is not None}

    def left_out(self, horizon_s: float = HORIZON_S) -> list[str]:
        """What `noise` does not hold, and why."""
        out = []
        for sensor, white, walk in FILTER_NAMES:
            s = self[sensor]
            poor = [axis for axis, fit in zip(s.axes, s.fits, strict=True) if fit is None or not fit.good]
            out += [f"{sensor} {axis} is left out: {s.verdicts()[axis]}" for axis in poor]
            out += [
                f"{sensor} {axis}: {sheet.WORDS[noise]} {sheet.SYMBOLS[noise]} is left out: its interval reaches down to 0"
                for axis, fit in zip(s.axes, s.fits, strict=True)
                if fit is not None and fit.good
                for noise in fit.doubtful
            ]
            if len(poor) == len(s.axes):
                out.append(f"{white} and {walk} are left out: no axis is fitted")
            elif s.drift(horizon_s) is None:
                out.append(f"{walk} is left out: no slow noise was found whose interval keeps away from 0")
        return out

    def to_toml(self, horizon_s: float = HORIZON_S) -> str:
        """A configuration for `bematist track --config`: the noise block, and above it as comments what it was made of."""
        from bematist.config import to_toml

        lines = [f"Noise identified by bematist allan: {self.source or 'arrays'}, {self.start_s:.1f} to {self.end_s:.1f} s."]
        lines += [f"{row['sensor']} {row['axis']}: {describe(row)}" for row in self.coefficients() if row["found"]]
        lines += [f"{reason}." for reason in self.left_out(horizon_s)]
        lines.append(f"The bias walks have the Allan deviation of all slow noises at {horizon_s:g} s.")
        lines.append("It is the noise at rest, a floor: in motion errors of scale and alignment come on top, and a shoe needs more.")
        comments = "".join(f"# {line}\n" for line in lines)
        return comments + "\n" + to_toml({"parameters": {"noise": self.noise(horizon_s)}})


def describe(row: Mapping[str, Any]) -> str:
    """A row of `AllanResult.coefficients` in words."""
    value = (
        f"{row['sheet_value']:.4g} {row['sheet_unit']} ({row['value']:.4g} {row['unit']})"
        if row["sheet_unit"]
        else f"{row['value']:.4g} {row['unit']}"
    )
    return f"{row['noise']} {row['symbol']} = {value}"


def _rows(s: SensorAllan, k: int, fit: Fit) -> Iterator[dict[str, Any]]:
    def row(noise: str, symbol: str, unit: str, e: Estimate, units: tuple[tuple[str, float], ...], *, found: bool = True) -> dict[str, Any]:
        name, factor = units[0] if units else ("", float("nan"))
        return {
            "sensor": s.name,
            "axis": s.axes[k],
            "noise": noise,
            "symbol": symbol,
            "found": found,
            "value": e.value,
            "low": e.low,
            "high": e.high,
            "unit": unit,
            "sheet_value": e.value * factor,
            "sheet_low": e.low * factor,
            "sheet_high": e.high * factor,
            "sheet_unit": name,
            "other_units": {other: e.value * f for other, f in units[1:]},
        }

    for noise, symbol in sheet.SYMBOLS.items():
        unit, units = sheet.SI[s.name][noise], sheet.SHEET[s.name][noise]
        if noise in fit.coefficients:
            yield row(sheet.WORDS[noise], symbol, unit, fit.coefficients[noise], units)
            if noise == "markov" and fit.correlation is not None:
                yield row("correlation time", "T", "s", fit.correlation, (("s", 1.0),))
            if noise == "flicker":
                e = fit.coefficients[noise]
                yield row("its floor", "0.664 B", unit, Estimate(*(FLICKER_FLOOR * x for x in (e.value, e.low, e.high))), units)
        elif noise in fit.bounds:
            yield row(sheet.WORDS[noise], symbol, unit, Estimate(float("nan"), 0.0, fit.bounds[noise]), units, found=False)
