"""Step events, step frequency, and how a handheld sensor is moved and carried."""

from typing import TYPE_CHECKING

from bematist.lazy import lazily
from bematist.steps.parameters import DetectionParameters, ModeParameters, StepParameters

if TYPE_CHECKING:
    from bematist.steps.analysis import CARRYING, FEATURES, MOTIONS, StepAnalysis, analyse, detect, most, results
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

_HOME: dict[str, str] = {
    **dict.fromkeys(("CARRYING", "FEATURES", "MOTIONS", "StepAnalysis", "analyse", "detect", "most", "results"), "analysis"),
    **dict.fromkeys(("kernel_parameters", "workspace"), "setup"),
}

__getattr__ = lazily(__name__, _HOME)
