"""`FootIns`: inertial navigation of a shoe-mounted sensor, in batch, in chunks and sample by sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import stance
from bematist.align import initial_alignment
from bematist.estimator import Estimator
from bematist.foot.parameters import FootParameters
from bematist.foot.result import PHONE, judge, trajectory
from bematist.foot.setup import kernel_parameters, workspace
from bematist.hard_iron import extra_columns
from bematist.kernels import foot as filter_kernel
from bematist.kernels import layout as kernel
from bematist.recording import Recording
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]


class FootIns(Estimator[FootParameters, Trajectory]):
    """A shoe-mounted navigator.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in
    pieces of any size and returns the part of the trajectory that is decided, and `finish()` the rest; the pieces are, bit for bit,
    what `run` returns. The first `initial.longest_s` seconds are gathered before the first answer; afterwards an answer is
    `latency_s` late. `step(row)` is `update` for one row with the least overhead.
    """

    least = 2

    def __init__(self, parameters: FootParameters | None = None, *, method: str = "") -> None:
        parameters = parameters or FootParameters()
        super().__init__(parameters, parameters.initial.longest_s, method)
        self._sample = np.empty((self.width, 1))
        self._row, self._row_diagnostics = self._results(1)

    def step(self, row: Array) -> Array | None:
        """`update` for one row (1,10): one result row (29,) valid until the next call, or None.

        The result holds time, position (3), velocity (3), attitude (4) and the packed covariances of `Trajectory`. For speed nothing is
        checked: the time must increase. UsageError before the start is aligned: until `ready`, give the samples to `update`.
        """
        self._begun()
        self._intake.last_time = row[0, 0]
        self._sample[:] = row.T
        n = self._one()
        if n < 0:
            n = self._feed(row, False, self._row, self._row_diagnostics)
        return self._row[0] if n else None

    def _results(self, n: int) -> tuple[Array, NDArray[np.float32]]:
        return np.empty((n, kernel.NAV)), np.empty((n, kernel.DIAG + extra_columns(self.parameters.magnetic.hard_iron)), np.float32)

    def _waiting(self) -> int:
        return self.parameters.stance.latency_samples(self.alignment.rate_hz) if self.alignment is not None else 0

    def _start(self, head: Array) -> None:
        p = self.parameters
        rate_hz = stance.sampling_rate(head[:, 0], p.initial.longest_s)
        gap_s = p.gap.seconds(rate_hz)
        a = initial_alignment(head, p.initial, rate_hz, p.gravity, p.noise.angle_random_walk, gap_s, p.earth_rate)
        self.alignment = a
        index, memory = stance.memory(p.stance, rate_hz)
        prm, warnings = kernel_parameters(p, a, rate_hz, seen=bool(np.isfinite(head[:, 7:10]).any()))
        self.warnings.extend([*a.warnings, *warnings])
        self._state = (index, memory, workspace(p, a, prm, head[0, 0]), prm)
        self._restored()

    def _restored(self) -> None:
        index, memory, S, prm = self._begun()
        room = stance.scratch(index, 1), self._row, self._row_diagnostics
        self._one = filter_kernel.run.bind(index, memory, S, prm, self._sample, stance.NO_FLAGS, False, *room)

    def _feed(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        assert self._state is not None
        index, memory, S, prm = self._state
        columns, flags = stance.filled(memory, rows, prm[kernel.GAP_S])
        return filter_kernel.run(index, memory, S, prm, columns, flags, finish, stance.scratch(index, len(rows)), *results)

    def _suits(self, recording: Recording) -> list[str]:
        return [PHONE] if recording.phone else []

    def _judge(self, recording: Recording, *results: NDArray[Any]) -> list[str]:
        assert self._state is not None
        nav, diagnostics = results
        return judge(nav, diagnostics, self._state[3], self.parameters.magnetic.hard_iron)

    def _result(self, *results: NDArray[Any], **fields: Any) -> Trajectory:
        nav, diagnostics = results
        S = None if self._state is None else self._state[2]
        used = self.parameters.model_dump()
        return trajectory(nav, diagnostics, S, method=self.name, parameters=used, north=self.north, **fields)
