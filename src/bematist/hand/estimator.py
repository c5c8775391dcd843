"""`HandAttitude`: attitude of a handheld sensor."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import stance
from bematist.attitudes import Attitude
from bematist.estimator import Estimator
from bematist.hand.parameters import HandParameters
from bematist.hand.result import attitude, judge, room
from bematist.hand.setup import initial_state
from bematist.hand.start import start
from bematist.kernels import hand as filter_kernel
from bematist.kernels import hand_layout as kernel
from bematist.recording import Recording

Array = NDArray[np.float64]


class HandAttitude(Estimator[HandParameters, Attitude]):
    """The attitude filter MAGYQ for a sensor in the hand."""

    def __init__(self, parameters: HandParameters | None = None, *, name: str = "") -> None:
        parameters = parameters or HandParameters()
        super().__init__(parameters, parameters.initial.longest_s, name)

    def _results(self, n: int) -> tuple[Array, NDArray[np.float32]]:
        return np.empty((n, kernel.NAV)), room(n, self.parameters)

    def _feed(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        assert self._state is not None
        index, memory, S, prm = self._state
        columns, flags = stance.filled(memory, rows, prm[kernel.GAP_S])
        return filter_kernel.run(index, memory, S, prm, columns, flags, *results)

    def _start(self, head: Array) -> None:
        p = self.parameters
        self.alignment = a = start(head, p, stance.sampling_rate(head[:, 0], p.initial.longest_s))
        self._state, warnings = initial_state(p, a, head)
        self.warnings.extend([*a.warnings, *warnings])

    def _judge(self, recording: Recording, *results: NDArray[Any]) -> list[str]:
        nav, diagnostics = results
        return judge(nav, diagnostics, self.parameters, recording.has_magnetometer)

    def _result(self, *results: NDArray[Any], **fields: Any) -> Attitude:
        nav, diagnostics = results
        return attitude(nav, diagnostics, self.parameters, north=self.north, filter=self.name, **fields)
