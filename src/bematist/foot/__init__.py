"""Inertial navigation of a shoe-mounted sensor."""

from typing import TYPE_CHECKING

from bematist.foot.parameters import FootParameters, NoiseParameters
from bematist.lazy import lazily

if TYPE_CHECKING:
    from bematist.foot.navigator import FootIns

__all__ = ["FootIns", "FootParameters", "NoiseParameters"]

__getattr__ = lazily(__name__, {"FootIns": "navigator"})
