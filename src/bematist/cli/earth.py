"""`earth`: gravity, magnetic field and rotation of a place."""

from __future__ import annotations

import datetime
import math
import sys
from typing import Annotated, Any

import typer

from bematist.cli import options, site
from bematist.cli.app import app
from bematist.cli.console import facts, output, warn
from bematist.outputs import to_json


@app.command(context_settings={"ignore_unknown_options": True})  # a place in the south begins with a minus
def earth(
    place: Annotated[str, typer.Argument(help="Degrees, and height in m.", metavar="LAT,LON[,H]")],
    date: Annotated[str | None, typer.Option("--date", help="The day.  [default: today]", metavar="YYYY-MM-DD")] = None,
    json: options.Json = False,
) -> None:
    """Gravity, magnetic field and rotation of a place.

    It is what "bematist track --origin LAT,LON[,H]" uses.
    """
    from bematist.earth import CAUTION_UT, earth_at

    found = earth_at(*site.origin_of(place, "The place"), date=date or datetime.date.today())
    field = found.field
    assert field is not None
    if json:
        values: dict[str, Any] = {
            "latitude_deg": found.latitude_deg,
            "longitude_deg": found.longitude_deg,
            "height_m": found.height_m,
            "date": str(field.date),
            "gravity_m_s2": found.gravity,
            "field_ut": field.vector,
            "strength_ut": field.strength_ut,
            "declination_deg": field.declination_deg,
            "inclination_deg": field.inclination_deg,
            "model": field.model,
            "earth_rate_rad_s": found.rotation,
        }
        sys.stdout.write(to_json(values))
        return
    _, north, up = (math.degrees(r) * 3600 for r in found.rotation)
    e, n, u = field.vector
    output().print(
        facts(
            [
                ("gravity", f"{found.gravity:.5f} m/s² (WGS-84 normal gravity, down)"),
                ("magnetic field", f"{e:.3f}, {n:.3f}, {u:.3f} µT East, North, Up ({field.model}, {field.date})"),
                ("strength", f"{field.strength_ut:.3f} µT ± {field.strength_sd_ut:.2f}, horizontal {field.horizontal_ut:.3f} µT"),
                ("declination", f"{field.declination_deg:+.2f}° ± {field.declination_sd_deg:.2f}, magnetic North clockwise from true"),
                ("inclination", f"{field.inclination_deg:+.2f}° ± {field.inclination_sd_deg:.2f}, below the horizon"),
                ("rotation", f"{north:.3f} °/h about North, {up:.3f} °/h about Up"),
            ]
        )
    )
    if field.horizontal_ut < CAUTION_UT:
        warn([f"The field is nearly upright: with {field.horizontal_ut:.1f} µT of it level, a compass is not to be relied on."])
