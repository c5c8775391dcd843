"""Attitude of a handheld sensor."""

from bematist.hand.estimator import HandAttitude
from bematist.hand.parameters import GYINT, HAND, MAGYQ, QUEST, HandParameters, hand_parameters

__all__ = ["GYINT", "HAND", "MAGYQ", "QUEST", "HandAttitude", "HandParameters", "hand_parameters"]
