"""Noise identification: from hours of rest to the noise that a filter believes.

>>> import numpy as np, bematist as bm
>>> rng = np.random.default_rng(0)
>>> time = np.arange(60_000) / 100
>>> still = [0, 0, 9.81] + 0.02 * rng.standard_normal((60_000, 3))
>>> found = bm.allan(bm.Recording(time=time, specific_force=still, angular_rate=0.001 * rng.standard_normal((60_000, 3))))
>>> round(found["gyroscope"].fits[0].coefficients["white"].value, 5)  # 0.001 rad/s per sample at 100 Hz
0.0001
"""

from __future__ import annotations

import sys
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from bematist.allan.covariance import Overlap
from bematist.allan.deviation import Spacing, Stretches, averaging_spans, overlapping_variance, stretches
from bematist.allan.fit import Estimate, Fit, fit_noises
from bematist.allan.rest import find_rest
from bematist.allan.result import AllanResult, SensorAllan
from bematist.allan.spectrum import spectral_density
from bematist.allan.suspect import check_axis, check_units, poorly_fitted
from bematist.errors import DataError
from bematist.frames import quaternion_from_rotation_vector
from bematist.recording import Recording

__all__ = ["AllanResult", "Estimate", "Fit", "SensorAllan", "allan"]

Array = NDArray[np.float64]

LEVEL = 0.95
FEWEST = 100
"""Samples of a sensor in the rest, at least."""
XYZ = ("x", "y", "z")


def allan(
    recording: Recording,
    *,
    start_s: float | None = None,
    end_s: float | None = None,
    spacing: Spacing = "octave",
    quaternion: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> AllanResult:
    """Overlapping Allan deviation of a sensor at rest, the noises it is made of, and how sure they are.

    Parameters
    ----------
    recording : hours of rest; where it moves the longest rest is used, with a warning.
    start_s, end_s : only this part, s on the recording's clock.
    spacing : averaging times by octaves (1, 2, 4, 8 … samples) or three a decade (1, 2, 5, 10 …).
    quaternion : also of the gyroscope quaternion (MAGYQ eqs 18-19, figure 5).
    progress : called with axes done and of all.

    Raises
    ------
    DataError
        There is no rest of 10 s, a sensor has fewer than 100 samples in it, or the units cannot be right.
    UsageError
        The spacing is unknown.
    """
    rest = find_rest(recording, start_s, end_s)
    parts = list(_sensors(recording, rest.start_s, rest.end_s, quaternion=quaternion))
    total, done = sum(len(p[1]) for p in parts), 0
    warnings, sensors = [*recording.warnings, *rest.warnings], {}
    for name, axes, time, column in parts:
        if len(time) < FEWEST:
            raise DataError(
                f"{recording.source or 'The recording'}: the {name} has {len(time)} samples in the rest from {rest.start_s:.1f} to "
                f"{rest.end_s:.1f} s, too few. Record a longer rest."
            )
        pieces = stretches(time)
        if len(pieces.rows) > 1:
            warnings.append(
                f"{name}: {len(pieces.rows) - 1} gaps. Averages do not reach over them: the longest stretch without one is "
                f"{pieces.lengths.max() * pieces.period_s:.1f} s."
            )
        found = []
        overlap = Overlap(averaging_spans(int(pieces.lengths.max()), spacing), pieces.lengths, pieces.period_s)
        for k, axis in enumerate(axes):
            values = column(k)
            said = check_axis(name, axis, values)
            warnings += [said] if said else []
            found.append(_curve(values, pieces, overlap, fitted=(name, axis) != ("quaternion", "w")))
            done += 1
            if progress:
                progress(done, total)
        sensors[name] = _assembled(name, axes, len(time), overlap, found)
        warnings += poorly_fitted(sensors[name])
    warnings += check_units(recording, rest.start_s, rest.end_s, sensors)
    return AllanResult(sensors, rest.start_s, rest.end_s, recording.source, tuple(dict.fromkeys(warnings)))


Column = Callable[[int], Array]


def _sensors(r: Recording, start: float, end: float, *, quaternion: bool) -> Iterator[tuple[str, tuple[str, ...], Array, Column]]:
    """Name, axes, sample times and columns of each sensor in the rest; a column is made when it is asked for."""
    for name, t, values in (
        ("accelerometer", r.time, r.specific_force),
        ("gyroscope", r.time, r.angular_rate),
        ("magnetometer", r.magnetic_time, r.magnetic_flux_density),
    ):
        part = slice(*np.searchsorted(t, [start, end + 1e-9]))
        good = np.asarray(np.isfinite(values[part]).all(1))
        if name == "magnetometer" and not good.any():
            continue
        yield name, XYZ, t[part][good], _column(values[part], good)
        if name == "gyroscope" and quaternion:
            time = t[part][good]
            if len(time) > 1:
                period = float(np.median(np.diff(time)))
                yield (
                    "quaternion",
                    ("w", *XYZ),
                    time,
                    _column(quaternion_from_rotation_vector(values[part][good] * period), np.ones(1, bool)),
                )


def _column(values: Array, good: NDArray[np.bool_]) -> Column:
    if good.all():
        return lambda k: np.ascontiguousarray(values[:, k])
    return lambda k: values[good, k]


@dataclass(frozen=True, eq=False)
class _Curve:
    variance: Array
    fit: Fit | None
    frequency: Array
    density: Array


def _curve(values: Array, pieces: Stretches, overlap: Overlap, *, fitted: bool) -> _Curve:
    """Allan variance and spectral density of an axis, and its noises; none where the axis does not vary.

    Not `fitted` is the first component of the gyroscope quaternion: one less a sum of squares, far from Gaussian (erratum of MAGYQ eq 25).
    """
    variance = overlapping_variance(values, pieces, overlap.spans)
    longest = pieces.rows[int(np.argmax(pieces.lengths))]
    fit = fit_noises(variance, overlap) if fitted and (variance > 0).all() else None
    return _Curve(variance, fit, *spectral_density(values[longest], 1 / pieces.period_s))


def _assembled(name: str, axes: tuple[str, ...], samples: int, overlap: Overlap, found: list[_Curve]) -> SensorAllan:
    variance = np.column_stack([c.variance for c in found])
    edf = np.column_stack([np.full(len(overlap.taus), np.nan) if c.fit is None else c.fit.edf for c in found])
    tail = (1 - LEVEL) / 2
    return SensorAllan(
        name=name,
        axes=axes,
        rate_hz=1 / overlap.period_s,
        samples=samples,
        taus=overlap.taus,
        deviation=np.sqrt(variance),
        low=np.sqrt(variance * edf / _chi_square(1 - tail, edf)),
        high=np.sqrt(variance * edf / _chi_square(tail, edf)),
        edf=edf,
        frequency=found[0].frequency,
        density=np.column_stack([c.density for c in found]),
        fits=tuple(c.fit for c in found),
    )


def _chi_square(level: float, freedom: Array) -> Array:
    """Quantile of the chi-square distribution; scipy.stats would take a second to import."""
    return 2 * gammaincinv(freedom / 2, level)


class _Callable(types.ModuleType):
    # `bematist.allan` is this package once it is imported, and the function `allan` to whoever calls it.
    def __call__(self, *args: Any, **kwargs: Any) -> AllanResult:
        return allan(*args, **kwargs)


sys.modules[__name__].__class__ = _Callable
