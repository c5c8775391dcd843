"""Step events, step frequency, and how a handheld sensor is moved and carried."""

from bematist.steps.analysis import CARRYING, FEATURES, MOTIONS, StepAnalysis, analyse, detect, most, results
from bematist.steps.parameters import DetectionParameters, ModeParameters, StepParameters
from bematist.steps.setup import kernel_parameters, workspace

__all__ = [
    "CARRYING",
    "FEATURES",
    "MOTIONS",
    "DetectionParameters",
    "ModeParameters",
    "StepAnalysis",
    "StepParameters",
    "analyse",
    "detect",
    "kernel_parameters",
    "most",
    "results",
    "workspace",
]
