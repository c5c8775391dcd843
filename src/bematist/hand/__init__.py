"""Attitude of a handheld sensor."""

from bematist.hand.estimator import HandAttitude
from bematist.hand.parameters import HandParameters

__all__ = ["HandAttitude", "HandParameters"]
