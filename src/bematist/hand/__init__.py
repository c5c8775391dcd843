"""Attitude of a handheld sensor."""

from bematist.hand.estimator import HandAttitude
from bematist.hand.parameters import GYINT, HAND, MAGYQ, MAGYQ_ESTIMATED, QUEST, HandParameters, hand_parameters

__all__ = ["GYINT", "HAND", "MAGYQ", "MAGYQ_ESTIMATED", "QUEST", "HandAttitude", "HandParameters", "hand_parameters"]
