"""Inertial navigation of a shoe-mounted sensor."""

from bematist.foot.navigator import FootIns
from bematist.foot.parameters import FootParameters, NoiseParameters

__all__ = ["FootIns", "FootParameters", "NoiseParameters"]
