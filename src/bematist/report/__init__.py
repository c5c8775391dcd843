"""Pages and pictures of a result: what a person looks at, and shows."""

from bematist.report.allan_page import write_allan_page
from bematist.report.allan_still import still_allan
from bematist.report.attitude_page import still_attitude, write_attitude_page
from bematist.report.calibration_page import write_calibration_page
from bematist.report.calibration_still import still_calibration
from bematist.report.page import write_report
from bematist.report.stance_page import write_stance_page
from bematist.report.steps_page import write_steps_page
from bematist.report.still import still_path

__all__ = [
    "still_allan",
    "still_attitude",
    "still_calibration",
    "still_path",
    "write_allan_page",
    "write_attitude_page",
    "write_calibration_page",
    "write_report",
    "write_stance_page",
    "write_steps_page",
]
