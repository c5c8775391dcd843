"""Attitude and heading from gyroscope, accelerometer and magnetometer, without a path."""

from bematist.ahrs.estimator import Ahrs
from bematist.ahrs.filters import FILTERS, Filter, attitude, find_filter
from bematist.ahrs.parameters import AhrsParameters, GyroParameters, MadgwickParameters, MahonyParameters
from bematist.attitudes import Attitude

__all__ = [
    "FILTERS",
    "Ahrs",
    "AhrsParameters",
    "Attitude",
    "Filter",
    "GyroParameters",
    "MadgwickParameters",
    "MahonyParameters",
    "attitude",
    "find_filter",
]
