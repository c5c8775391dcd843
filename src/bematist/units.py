"""Factors from the units that loggers write to SI (and µT). Multiply a reading by the factor."""

import math

from bematist.earth import STANDARD_GRAVITY

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
SPECIFIC_FORCE = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": STANDARD_GRAVITY * 1e-3}
ANGULAR_RATE = {"rad/s": 1.0, "deg/s": math.radians(1.0), "mdeg/s": math.radians(1e-3)}
MAGNETIC_FLUX_DENSITY = {"uT": 1.0, "nT": 1e-3, "mT": 1e3, "T": 1e6, "G": 100.0, "mG": 0.1}
PRESSURE = {"Pa": 1.0, "hPa": 100.0, "mbar": 100.0, "kPa": 1000.0, "bar": 1e5}
