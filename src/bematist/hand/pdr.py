"""`HandPdr`: the path of a sensor in the hand, step by step, in batch, in chunks and sample by sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import stance, steps
from bematist.estimator import Estimator
from bematist.hand import result
from bematist.hand.path_parameters import HandPdrParameters
from bematist.hand.path_result import judge, trajectory, worn_on_shoe
from bematist.hand.path_result import steps as listed
from bematist.hand.path_setup import kernel_parameters, pointed, workspace
from bematist.hand.setup import initial_state
from bematist.hand.start import start
from bematist.kernels import hand as attitude_kernel
from bematist.kernels import hand_layout
from bematist.kernels import pdr as path_kernel
from bematist.kernels import pdr_layout as kernel
from bematist.recording import SAMPLE_COLUMNS, Recording
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]


class HandPdr(Estimator[HandPdrParameters, Trajectory]):
    """A navigator in the hand: MAGYQ's attitude, steps, step lengths, and their sum (MAGYQ section 7).

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, or (n,11)
    with the pressure, in pieces of any size and returns their part of the trajectory with the steps counted in it, and `finish()` the rest;
    the pieces are, bit for bit, what `run` returns. The first `initial.longest_s` seconds are gathered before the first answer; afterwards
    there is no delay, but a step is counted half a step after its instant, and a walk's first ones when it is recognised.
    `step(row)` is `update` for one row with the least overhead.
    """

    width = len(SAMPLE_COLUMNS) + 1
    least = 2

    def __init__(self, parameters: HandPdrParameters | None = None, *, method: str = "") -> None:
        parameters = parameters or HandPdrParameters()
        super().__init__(parameters, parameters.initial.longest_s, method)
        self._steps: list[Array] = []
        self._room = np.empty((0, kernel.STEP_ROW))
        self._sample = np.empty((self.width, 1))
        self._one = self._results(1)

    def step(self, row: Array) -> Array:
        """`update` for one row (1,11), pressure or NaN in the last column: one result row (29,), valid until the next call.

        The result holds time, position (3), velocity (3), attitude (4) and the packed covariances of `Trajectory`. For speed nothing is
        checked: the time must increase. UsageError before the start is aligned: until `ready`, give the samples to `update`.
        """
        self._begun()
        self._intake.last_time = row[0, 0]
        self._sample[:] = row.T
        if self._turn() < 0:
            self._feed(row, False, *self._one)
            self._steps.clear()
        else:
            self._walk()
        return self._one[2][0]

    def _results(self, n: int) -> tuple[NDArray[Any], ...]:
        return (
            np.empty((n, hand_layout.NAV)),
            result.room(n, self.parameters),
            np.empty((n, kernel.NAV)),
            np.empty((n, kernel.DIAG), np.float32),
        )

    def _start(self, head: Array) -> None:
        p = self.parameters
        rate_hz = stance.sampling_rate(head[:, 0], p.initial.longest_s)
        self.alignment = a = pointed(start(head, p, rate_hz), p)
        state, warnings = initial_state(p, a, head)
        self.warnings.extend([*a.warnings, *warnings])
        own = kernel_parameters(p, p.gap.seconds(rate_hz))
        self._state = (*state, steps.workspace(), steps.kernel_parameters(p.steps, gravity=p.gravity), workspace(p), own)
        self._restored()

    def _restored(self) -> None:
        index, memory, S, prm, *path = self._begun()
        attitude, attitude_diagnostics, nav, diagnostics = self._one
        sample = self._sample, stance.NO_FLAGS
        self._turn = attitude_kernel.run.bind(index, memory, S, prm, *sample, attitude, attitude_diagnostics)
        events = np.empty((steps.most(self._sample[0], self.parameters.steps), kernel.STEP_ROW))
        self._walk = path_kernel.run.bind(*path, *sample, attitude, nav, diagnostics, events)

    def _feed(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        assert self._state is not None
        index, memory, S, prm, detector, detector_prm, W, path_prm = self._state
        attitude, attitude_diagnostics, nav, diagnostics = results
        columns, flags = stance.filled(memory, rows, prm[hand_layout.GAP_S])
        n = attitude_kernel.run(index, memory, S, prm, columns, flags, attitude, attitude_diagnostics)
        events = self._events(rows[:, 0])
        found = path_kernel.run(detector, detector_prm, W, path_prm, columns, flags, attitude, nav, diagnostics, events)
        if found:
            self._steps.append(events[:found].copy())
        return n

    def _events(self, time: Array) -> Array:
        """Room for the steps that may be counted at these times (n,)."""
        most = steps.most(time, self.parameters.steps)
        if len(self._room) < most:
            self._room = np.empty((most, kernel.STEP_ROW))
        return self._room

    def _suits(self, recording: Recording) -> list[str]:
        return worn_on_shoe(recording)

    def _judge(self, recording: Recording, *results: NDArray[Any]) -> list[str]:
        attitude, attitude_diagnostics, nav, diagnostics = results
        of_attitude = result.judge(attitude, attitude_diagnostics, self.parameters, recording.has_magnetometer, "path")
        aimed = None if self.north in ("magnetic", "true") else self.parameters.direction.first
        return [*of_attitude, *judge(nav, diagnostics, aimed)]

    def _result(self, *results: NDArray[Any], **fields: Any) -> Trajectory:
        _, attitude, nav, diagnostics = results
        found = listed(self._steps)
        self._steps.clear()
        return trajectory(
            nav, diagnostics, attitude, steps=found, north=self.north, method=self.name, parameters=self.parameters.model_dump(), **fields
        )
