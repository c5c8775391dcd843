"""Attitude and path of a handheld sensor."""

from typing import TYPE_CHECKING

from bematist.hand.parameters import GYINT, HAND, MAGYQ, MAGYQ_ESTIMATED, QUEST, HandParameters, hand_parameters
from bematist.hand.path_parameters import HandPdrParameters, pdr_parameters
from bematist.lazy import lazily

if TYPE_CHECKING:
    from bematist.hand.estimator import HandAttitude
    from bematist.hand.pdr import HandPdr

__all__ = [
    "GYINT",
    "HAND",
    "MAGYQ",
    "MAGYQ_ESTIMATED",
    "QUEST",
    "HandAttitude",
    "HandParameters",
    "HandPdr",
    "HandPdrParameters",
    "hand_parameters",
    "pdr_parameters",
]

__getattr__ = lazily(__name__, {"HandAttitude": "estimator", "HandPdr": "pdr"})
