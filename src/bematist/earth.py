"""The Earth: gravity. The one place where a value of gravity comes from."""

import math

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall, m/s² (BIPM); the unit `g` of accelerometers."""


def normal_gravity(latitude_rad: float, height_m: float = 0.0) -> float:
    """Normal gravity of the WGS-84 ellipsoid, m/s² (Somigliana's closed form and its second-order height term).

    Source: NIMA TR8350.2 (2000), equations 4-1 and 4-3.
    """
    a, f, m = 6378137.0, 1 / 298.257223563, 0.00344978650684
    s2 = math.sin(latitude_rad) ** 2
    g = 9.7803253359 * (1 + 0.00193185265241 * s2) / math.sqrt(1 - 0.00669437999014 * s2)
    return g * (1 - 2 / a * (1 + f + m - 2 * f * s2) * height_m + 3 / a**2 * height_m**2)
