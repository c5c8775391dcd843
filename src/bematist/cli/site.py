"""Where on Earth, and when: `--origin` and `--date`."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from bematist import config
from bematist.cli.options import numbers
from bematist.errors import UsageError

if TYPE_CHECKING:
    from bematist.earth import Earth
    from bematist.recording import Recording

Origin = Annotated[
    str | None,
    typer.Option("--origin", help="Where on Earth the path starts: degrees, and height in m.", metavar="LAT,LON[,H]"),
]
Date = Annotated[str | None, typer.Option("--date", help="Day of the recording, for the magnetic field.", metavar="YYYY-MM-DD")]


@dataclass(frozen=True)
class Site:
    """Where on Earth, and when; `told`: whether the recording itself may tell, by a satellite fix."""

    origin: tuple[float, ...] | None = None
    date: datetime.date | None = None
    told: bool = True

    @classmethod
    def given(cls, origin: str | None, date: str | None) -> Site:
        """From the options; `--origin none` leaves out what the recording tells."""
        from bematist.earth import as_date

        where = None if origin in (None, config.NONE) else origin_of(origin)
        return cls(where, None if date is None else as_date(date), origin is None)

    def earth(self, recording: Recording) -> Earth | None:
        """The Earth there, on the day that was given or on which the recording began; None where nothing was asked for.

        Raises
        ------
        UsageError
            No day is known and the recording has a magnetometer; or no magnetic model covers the day.
        """
        from bematist.earth import day_of, earth_at, earth_of

        day = self.date or day_of(recording)
        if self.origin is not None:
            if day is None and recording.has_magnetometer:
                raise UsageError(
                    f"{recording.source or 'The recording'} does not tell on which day it was made, and the magnetic field of a place "
                    "changes by the year. Give the day with --date YYYY-MM-DD."
                )
            return earth_at(*self.origin, date=day)
        if self.date is None:
            return None
        told = earth_of(recording) if self.told else None
        if told is None:
            raise UsageError("--date alone says nothing: the recording came without a satellite fix. Give the place with --origin LAT,LON.")
        return earth_at(told.latitude_deg, told.longitude_deg, told.height_m, day)


def origin_of(text: str, option: str = "--origin") -> tuple[float, ...]:
    """Latitude and longitude in degrees and, where it is there, height in m. UsageError, which names the option, where the text is none."""
    found = numbers(option, text, (2, 3), "47.3769,8.5417,408 for latitude,longitude,height")
    if not all(abs(n) <= most for n, most in zip(found, (90, 360, 1e5), strict=False)):
        raise UsageError(f"{option} {text}: write latitude,longitude[,height], in degrees (to ±90, ±360) and m: 47.3769,8.5417,408.")
    return found
