"""Parameters of the attitude filters."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from bematist.align import RestParameters
from bematist.earth import STANDARD_GRAVITY
from bematist.kernels import attitude as kernel
from bematist.parameters import Parameters
from bematist.updates import StepParameters


class AhrsParameters(Parameters):
    """What the attitude filters share."""

    kind: ClassVar[float]
    """The filter's number in the kernel."""

    magnetometer: bool = Field(
        default=True,
        description="Whether the magnetic field is used where it was measured: for the heading at the start, and by the filter. Without it "
        "nothing tells the heading but the gyroscope.",
    )
    integration: Literal["exact", "first-order"] = Field(
        default="exact",
        description="How a rate is turned into a rotation. exact: the exponential. first-order: Li & Wang eqs 24 and 29, normalised; what "
        "most implementations do. At 10 rad/s and 100 Hz it turns 0.08 % too little.",
    )
    gravity: float = Field(default=STANDARD_GRAVITY, gt=0, description="Local gravity, m/s²; finds the rest at the start.")
    initial: RestParameters = RestParameters()
    gap: StepParameters = StepParameters()

    @property
    def gains(self) -> tuple[float, float]:
        """Gain of the correction, and of the gyroscope's offset."""
        return 0.0, 0.0


class GyroParameters(AhrsParameters):
    """The gyroscope alone (Li & Wang eq 10): gravity and field serve the start only."""

    kind = kernel.GYRO


class MahonyParameters(AhrsParameters):
    """Mahony's filter: the rate is corrected in proportion to the error and to its integral."""

    kind = kernel.MAHONY

    kp: float = Field(
        default=0.74,
        ge=0,
        description="Proportional gain, 1/s: errors of the tilt fade with the time 1/kp, s. Larger: follows gravity and field "
        "sooner, and accelerations and disturbed fields too. The default is the optimum of Laidig et al. 2021 over their recordings; Li & "
        "Wang use 1.",
    )
    ki: float = Field(
        default=0.0012,
        ge=0,
        description="Integral gain, 1/s²: the gyroscope's offset follows the error. 0: the offset stays what the rest at the start told. "
        "Larger: sooner, and less steady. Li & Wang use 0.",
    )

    @property
    def gains(self) -> tuple[float, float]:
        return self.kp, self.ki


class MadgwickParameters(AhrsParameters):
    """Madgwick's filter: a step of fixed length against the gradient of the misfit."""

    kind = kernel.MADGWICK

    beta: float = Field(
        default=0.12,
        ge=0,
        description="Length of the correction, 1/s: the attitude is turned by at most 2 beta radians a second, however large or small "
        "the error is. Larger: follows gravity and field sooner, with more noise. The default is the optimum of Laidig et al. 2021 over "
        "their recordings; Li & Wang use 0.1.",
    )
    zeta: float = Field(
        default=0.0,
        ge=0,
        description="Gain of the gyroscope's offset, rad/s² (Madgwick 2010): it drifts by at most twice this per second. 0: the offset "
        "stays what the rest at the start told. Larger: follows sooner, and less steady.",
    )

    @property
    def gains(self) -> tuple[float, float]:
        return self.beta, self.zeta
