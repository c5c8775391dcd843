"""The Earth: gravity, magnetic field and rotation. The one place where their values come from."""

from __future__ import annotations

import datetime
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from bematist.errors import UsageError

if TYPE_CHECKING:
    from bematist.parameters import Parameters
    from bematist.recording import Recording

Model = TypeVar("Model", bound="Parameters")

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall, m/s² (BIPM); the unit `g` of accelerometers."""

ROTATION_RATE = 7.292115e-5
"""Angular rate of the Earth, rad/s (NIMA TR8350.2, Table 3.1)."""

FIRST_YEAR, LAST_YEAR = 2010, 2029
"""The years of which there is a World Magnetic Model."""

CAUTION_UT = 6.0
"""Horizontal field, µT, below which the World Magnetic Model calls for caution with a compass."""

_LATITUDES, _LONGITUDES, _HEIGHTS = 90.0, 360.0, (-1e3, 850e3)


def normal_gravity(latitude_rad: float, height_m: float = 0.0) -> float:
    """Normal gravity of the WGS-84 ellipsoid, m/s² (Somigliana's closed form and its second-order height term).

    Source: NIMA TR8350.2 (2000), equations 4-1 and 4-3.
    """
    a, f, m = 6378137.0, 1 / 298.257223563, 0.00344978650684
    s2 = math.sin(latitude_rad) ** 2
    g = 9.7803253359 * (1 + 0.00193185265241 * s2) / math.sqrt(1 - 0.00669437999014 * s2)
    return g * (1 - 2 / a * (1 + f + m - 2 * f * s2) * height_m + 3 / a**2 * height_m**2)


def rotation_rate(latitude_rad: float) -> tuple[float, float, float]:
    """The Earth's angular rate, rad/s, East, North, Up."""
    return 0.0, ROTATION_RATE * math.cos(latitude_rad), ROTATION_RATE * math.sin(latitude_rad)


@dataclass(frozen=True, kw_only=True)
class Field:
    """The Earth's magnetic field by the World Magnetic Model: of the core, without the rock and iron of the place.

    vector: µT, East, North, Up. declination_deg: of its horizontal part, clockwise from true North. inclination_deg: below the horizon.
    declination_sd_deg, inclination_sd_deg, strength_sd_ut: the model's own standard deviations, which count local rock.
    model: its name. date: the day it is for.
    """

    vector: tuple[float, float, float]
    declination_deg: float
    inclination_deg: float
    declination_sd_deg: float
    inclination_sd_deg: float
    strength_sd_ut: float
    model: str
    date: datetime.date

    @property
    def strength_ut(self) -> float:
        """Flux density, µT."""
        return math.hypot(*self.vector)

    @property
    def horizontal_ut(self) -> float:
        """Horizontal flux density, µT: what a compass turns by."""
        return math.hypot(*self.vector[:2])


@dataclass(frozen=True, kw_only=True)
class Earth:
    """What the Earth does at a place: gravity m/s², rotation rad/s (East, North, Up), and on a day the magnetic field.

    field is None where no day is known. source: where the place comes from, for messages.
    """

    latitude_deg: float
    longitude_deg: float
    height_m: float
    gravity: float
    rotation: tuple[float, float, float]
    field: Field | None
    source: str = ""

    def values(self) -> dict[str, Any]:
        """The parameters that it sets, in whichever estimator has them."""
        field = None if self.field is None else {"earth_field": self.field.vector}
        return {"gravity": self.gravity, "earth_rate": self.rotation, **(field or {})}

    def __str__(self) -> str:
        place = f"{self.latitude_deg:.5f}°, {self.longitude_deg:.5f}°, {self.height_m:.0f} m{self.source}"
        if self.field is None:
            return f"{place}: gravity {self.gravity:.5f} m/s²"
        f = self.field
        return (
            f"{place}: gravity {self.gravity:.5f} m/s², declination {f.declination_deg:+.2f}°, inclination {f.inclination_deg:.2f}°, "
            f"{f.strength_ut:.2f} µT ({f.model}, {f.date})"
        )


def earth_at(
    latitude_deg: float,
    longitude_deg: float,
    height_m: float = 0.0,
    date: datetime.date | str | None = None,
    *,
    source: str = "",
) -> Earth:
    """The Earth at a place: WGS-84 latitude and longitude in degrees, height above the ellipsoid in m, and a day (or its text YYYY-MM-DD).

    Heights above the sea differ from those by up to 100 m, which is 0.0003 m/s² of gravity and 0.003 µT.

    Raises
    ------
    UsageError
        There is no such place, the date is no date, or no World Magnetic Model covers it.
    """
    low, high = _HEIGHTS
    if not (abs(latitude_deg) <= _LATITUDES and abs(longitude_deg) <= _LONGITUDES and low <= height_m <= high):
        raise UsageError(
            f"{latitude_deg:g}, {longitude_deg:g}, {height_m:g}: this is no place on Earth. Give latitude (-90 to 90) and longitude in "
            "degrees, and the height in m (-1000 to 850000)."
        )
    latitude = math.radians(latitude_deg)
    return Earth(
        latitude_deg=latitude_deg,
        longitude_deg=longitude_deg,
        height_m=height_m,
        gravity=normal_gravity(latitude, height_m),
        rotation=rotation_rate(latitude),
        field=None if date is None else magnetic_field(latitude_deg, longitude_deg, height_m, as_date(date)),
        source=source,
    )


def as_date(date: datetime.date | str) -> datetime.date:
    """A day from its text YYYY-MM-DD. UsageError where it is none."""
    if isinstance(date, datetime.date):
        return date
    try:
        return datetime.date.fromisoformat(date)
    except ValueError:
        raise UsageError(f'"{date}" is no day: write it as YYYY-MM-DD, such as 2025-07-01.') from None


def magnetic_field(latitude_deg: float, longitude_deg: float, height_m: float, date: datetime.date) -> Field:
    """The Earth's magnetic field at a place on a day, by the World Magnetic Model of its five years.

    Raises
    ------
    UsageError
        No model covers the day: past its end a model is a guess, and is not used.
    """
    if not FIRST_YEAR <= date.year <= LAST_YEAR:
        raise UsageError(
            f"There is no World Magnetic Model for {date}: those at hand cover {FIRST_YEAR}-01-01 to {LAST_YEAR}-12-31. Give the day of "
            "the recording with --date YYYY-MM-DD; for a day outside, give the field itself with --set initial.earth_field=[E,N,U] in µT."
        )
    from pygeomag import GeoMag, calculate_decimal_year

    model = GeoMag(base_year=datetime.datetime(date.year, date.month, date.day))
    found: Any = model.calculate(latitude_deg, longitude_deg, height_m / 1e3, calculate_decimal_year(date))
    sd: Any = found.calculate_uncertainty() if date.year >= 2015 else None  # the model of 2010 states none
    return Field(
        vector=(found.y / 1e3, found.x / 1e3, -found.z / 1e3),
        declination_deg=found.d,
        inclination_deg=found.i,
        declination_sd_deg=sd.d if sd else math.nan,
        inclination_sd_deg=sd.i if sd else math.nan,
        strength_sd_ut=sd.f / 1e3 if sd else math.nan,
        model=model.model,
        date=date,
    )


def earth_of(recording: Recording) -> Earth | None:
    """The Earth at the first satellite fix that came with a recording, on its day; None where it came with none.

    Without a day, or on one that no model covers, without the magnetic field.
    """
    origin = None if recording.reference is None else recording.reference.origin
    if origin is None:
        return None
    latitude, longitude, height = origin
    day = day_of(recording)
    covered = day is not None and FIRST_YEAR <= day.year <= LAST_YEAR
    height = height if math.isfinite(height) else 0.0
    return earth_at(latitude, longitude, height, day if covered else None, source=" (first fix of the recording)")


def on_earth(parameters: Model, recording: Recording, earth: Earth | Literal["recording"] | None) -> Model:
    """Parameters of an estimator with gravity, field and rotation of a place; "recording": of its own, if it tells (`earth_of`)."""
    found = earth_of(recording) if earth == "recording" else earth
    return parameters if found is None else parameters.override(parameters.places(found.values()))


def day_of(recording: Recording) -> datetime.date | None:
    """The day on which a recording began, UTC; None where it does not tell."""
    if recording.start_ns is None:
        return None
    return (datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=recording.start_ns // 1_000_000_000)).date()
