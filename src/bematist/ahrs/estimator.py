"""`Ahrs`: the attitude filters gyro, Mahony and Madgwick."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.ahrs.parameters import AhrsParameters, MadgwickParameters
from bematist.align import InitialParameters, by_field, initial_alignment
from bematist.attitudes import Attitude
from bematist.estimator import Estimator
from bematist.intake import gap_warnings
from bematist.kernels import attitude as kernel
from bematist.recording import Recording
from bematist.stance import sampling_rate

Array = NDArray[np.float64]


class Ahrs(Estimator[AhrsParameters, Attitude]):
    """The filters after Li & Wang: gyroscope alone, Mahony, Madgwick."""

    def __init__(self, parameters: AhrsParameters | None = None, *, name: str = "") -> None:
        parameters = parameters or MadgwickParameters()
        super().__init__(parameters, parameters.initial.longest_s, name)

    def _results(self, n: int) -> tuple[Array, Array]:
        return np.empty(n), np.empty((n, kernel.OUT))

    def _feed(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        assert self._state is not None
        times, out = results
        times[: len(rows)] = rows[:, 0]
        if len(rows):
            kernel.run(*self._state, np.ascontiguousarray(rows.T), out[: len(rows)])
        return len(rows)

    def _start(self, head: Array) -> None:
        """Levelled on the mean of a rest, and aimed by the mean field (Li & Wang eqs 16-23, errata: averages, and the levelled field)."""
        p = self.parameters
        rate_hz = sampling_rate(head[:, 0], p.initial.longest_s)
        gap_s = p.gap.seconds(rate_hz)
        initial = InitialParameters.model_validate(p.initial.model_dump())
        if not p.magnetometer:
            head = head.copy()
            head[:, 7:10] = np.nan
        aimed = by_field(initial, head[:, 7:10])
        a = initial_alignment(head, aimed, rate_hz, p.gravity, 0.0, gap_s)
        self.alignment = a = a if aimed is initial or a.field is None else replace(a, north="magnetic")
        self.warnings.extend(a.warnings)
        S = np.zeros(kernel.STATE_SIZE)
        S[kernel.Q : kernel.Q + 4] = a.attitude
        S[kernel.BIAS : kernel.BIAS + 3] = a.gyro_bias
        prm = np.zeros(kernel.PARAMETERS)
        prm[kernel.FILTER], prm[kernel.EXACT] = p.kind, p.integration == "exact"
        prm[kernel.GAIN], prm[kernel.BIAS_GAIN] = p.gains
        prm[kernel.GAP_S], prm[kernel.GAP_BALLISTIC_S] = gap_s, p.gap.ballistic_s
        field = _horizontal(a.field if aimed.heading_deg is not None else aimed.earth_field)
        prm[kernel.MAGNETOMETER] = p.magnetometer and field is not None
        prm[kernel.NORTH_E], prm[kernel.NORTH_N] = field or (0.0, 1.0)
        self._state = (S, prm)

    def _judge(self, recording: Recording, *results: NDArray[Any]) -> list[str]:
        times, out = results
        return _judge(times, out, self.parameters, recording)

    def _result(self, *results: NDArray[Any], **fields: Any) -> Attitude:
        times, out = results
        return Attitude(
            time=times,
            attitude=out[:, :4],
            gyro_bias=out[:, kernel.BIAS_OUT : kernel.BIAS_OUT + 3],
            diagnostics={"bridged": out[:, kernel.FLAG].astype(np.uint8)},
            north=self.north,
            filter=self.name,
            parameters=self.parameters.model_dump(),
            **fields,
        )


def _horizontal(field: Any) -> tuple[float, float] | None:
    """Unit direction East, North of a field (3,) in ENU; None without a horizontal part."""
    if field is None:
        return None
    length = math.hypot(field[0], field[1])
    return (float(field[0] / length), float(field[1] / length)) if length > 0 else None


def _judge(times: Array, out: Array, p: AhrsParameters, recording: Recording) -> list[str]:
    """Warnings about the result."""
    flag = out[:, kernel.FLAG]
    found = gap_warnings(np.diff(times)[flag[1:] == kernel.BRIDGED], "heading")
    for value, words in (
        (kernel.HELD, "had no angular rate: the last one was held"),
        (kernel.MISSING, "had no angular rate for too long: nothing was turned"),
    ):
        if n := int((flag == value).sum()):
            found.append(f"{n} of {len(times)} samples {words}.")
    if p.magnetometer and not recording.has_magnetometer and p.kind != kernel.GYRO:
        found.append("There is no magnetometer: the heading is the gyroscope's alone, and drifts.")
    return found
