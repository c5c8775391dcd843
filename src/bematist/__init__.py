"""bematist: from a recording of a body-worn inertial sensor to the path its wearer walked, and how sure it is.

Conventions, everywhere inside and in every public array:

- Navigation frame `n`: local level **ENU** (x East, y North, z Up). Body frame `b`: the sensor's own right-handed axes.
- Attitude: Hamilton quaternion, scalar first (w, x, y, z), body → navigation: `v_n = C_nb @ v_b`.
- Euler angles z-y-x in rad; `yaw` counter-clockwise from East; `heading_deg` clockwise from North.
- Specific force is what an accelerometer reads, m/s²: a level sensor at rest reads +g on its upward axis.
- Angular rate rad/s, magnetic flux density µT, pressure Pa, time s from the start of the recording.
- measured = true + bias + noise; an error is estimate − reference. The attitude error is a rotation vector in `n`:
  `C_est = exp([psi ×]) C_true`.

References (equation numbers in the docstrings are theirs; where a print is wrong the docstring says so):

- MAGINAV: K. Papafotis, P. P. Sotiriadis, "MAGINAV: Long-Term Accurate Navigation Algorithm Using Inertial and Magnetic Field
  Sensor Fusion", IEEE Access 11, 2023, doi:10.1109/ACCESS.2023.3331656.
- Li & Wang: X. Li, Y. Wang, "Evaluation of AHRS algorithms for foot-mounted inertial-based indoor navigation systems",
  Open Geosciences 11, 2019, doi:10.1515/geo-2019-0005.
- Madgwick: S. O. H. Madgwick, "An efficient orientation filter for inertial and inertial/magnetic sensor arrays", University of
  Bristol, 2010. Mahony: R. Mahony et al., "Nonlinear Complementary Filters on the Special Orthogonal Group", IEEE Trans. Automatic
  Control 53, 2008. The gains that are default: D. Laidig et al., "BROAD - A Benchmark for Robust Inertial Orientation Estimation",
  Data 6, 2021, doi:10.3390/data6070072.
- Skog: I. Skog et al., "Zero-Velocity Detection - An Algorithm Evaluation", IEEE Trans. Biomed. Eng. 57, 2010.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bematist.lazy import lazily

__version__ = "0.1.0"

if TYPE_CHECKING:
    from bematist.ahrs import FILTERS, Ahrs, Attitude, attitude
    from bematist.allan import AllanResult, allan
    from bematist.calibrate import Calibration, calibrate
    from bematist.earth import Earth, earth_at
    from bematist.errors import BematistError, DataError, UsageError
    from bematist.evaluate import evaluate, evaluate_attitude
    from bematist.floorplan import FloorPlan
    from bematist.foot import FootIns, FootParameters
    from bematist.hand import HandPdr, HandPdrParameters
    from bematist.io import read, read_floor_plan, read_reference
    from bematist.methods import METHODS, track
    from bematist.recording import Recording, Reference
    from bematist.step_length import calibrate_steps
    from bematist.synchronise import Shift, sync
    from bematist.trajectory import Steps, Trajectory

_HOME = {
    "FILTERS": "ahrs",
    "Ahrs": "ahrs",
    "Attitude": "ahrs",
    "attitude": "ahrs",
    "AllanResult": "allan",
    "allan": "allan",
    "Calibration": "calibrate",
    "calibrate": "calibrate",
    "Earth": "earth",
    "earth_at": "earth",
    "BematistError": "errors",
    "DataError": "errors",
    "UsageError": "errors",
    "evaluate": "evaluate",
    "evaluate_attitude": "evaluate",
    "FloorPlan": "floorplan",
    "FootIns": "foot",
    "FootParameters": "foot",
    "HandPdr": "hand",
    "HandPdrParameters": "hand",
    "read": "io",
    "read_floor_plan": "io",
    "read_reference": "io",
    "METHODS": "methods",
    "track": "methods",
    "Recording": "recording",
    "Reference": "recording",
    "calibrate_steps": "step_length",
    "Steps": "trajectory",
    "Shift": "synchronise",
    "sync": "synchronise",
    "Trajectory": "trajectory",
}

__all__ = [
    "FILTERS",
    "METHODS",
    "Ahrs",
    "AllanResult",
    "Attitude",
    "BematistError",
    "Calibration",
    "DataError",
    "Earth",
    "FloorPlan",
    "FootIns",
    "FootParameters",
    "HandPdr",
    "HandPdrParameters",
    "Recording",
    "Reference",
    "Shift",
    "Steps",
    "Trajectory",
    "UsageError",
    "allan",
    "attitude",
    "calibrate",
    "calibrate_steps",
    "earth_at",
    "evaluate",
    "evaluate_attitude",
    "read",
    "read_floor_plan",
    "read_reference",
    "sync",
    "track",
]


# So that `bematist --help` need not import numpy, numba and polars.
__getattr__ = lazily(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
