"""From parameters to what the step kernels start from."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bematist.earth import STANDARD_GRAVITY
from bematist.kernels import steps_layout as at
from bematist.steps.parameters import StepParameters, unit

Array = NDArray[np.float64]


def workspace() -> Array:
    """An empty state. It depends on nothing: the detector has no start, and runs on its own grid at any sampling rate."""
    return np.zeros(at.WORKSPACE_SIZE)


def _decay(seconds: float) -> float:
    """What is left after one cell of a window with this time constant."""
    return math.exp(-at.CELL_S / seconds)


def kernel_parameters(p: StepParameters, *, gravity: float = STANDARD_GRAVITY) -> Array:
    """The parameters that the kernels read (`kernels.steps_layout`). gravity in m/s²."""
    d, m = p.detection, p.modes
    prm = np.zeros(at.PARAMETERS)
    values = {
        at.G: gravity,
        at.GAP_S: d.gap_s,
        at.LEVEL_S: d.level_s,
        at.HIGH_PASS_HZ: d.high_pass_hz,
        at.START_HZ: d.start_hz,
        at.SLOWEST_HZ: d.slowest_hz,
        at.FASTEST_HZ: d.fastest_hz,
        at.SELECTIVITY: d.selectivity,
        at.STRIDE_SELECTIVITY: d.stride_selectivity,
        at.CORRELATION_DECAY: _decay(d.correlation_s),
        at.CENTRE_DECAY: _decay(d.follow_s),
        at.SHORT_DECAY: _decay(0.25),
        at.FEATURE_DECAY: _decay(m.window_s),
        at.GRAVITY_DECAY: _decay(m.window_s),
        at.SLOW_DECAY: _decay(2.0),
        at.PERIODIC: d.periodic,
        at.LEAST_FORCE: d.least_force,
        at.FIRST_STEPS: d.first_steps,
        at.IRREGULARITY: d.irregularity,
        at.REFRACTORY: d.refractory,
        at.PAUSE: d.pause,
        at.PEAK_SHARE: d.peak_share,
        at.RINGING: d.ringing,
        at.QUIET_SHARE: d.quiet_share,
        at.STRIDE_RATE: d.stride_rate,
        at.STRIDE_CORRELATION: d.stride_correlation,
        at.SWING_FASTEST_HZ: d.swing_fastest_hz,
        at.SWING_FAST_RATE: d.swing_fast_rate,
        at.STRIDE_PERIODIC: d.stride_periodic,
        at.PERIODIC_RATE: d.periodic_rate,
        at.PERIODIC_MOST: d.periodic_most,
        at.DWELL_S: m.dwell_s,
        at.RUN_HZ: m.run_hz,
        at.RUN_FORCE: m.run_force,
        at.CLIMB_SPEED: m.climb_speed,
        at.CLIMB_LEFT: m.climb_left,
        at.CLIMB_S: m.climb_s,
        at.SWING_RATE: m.swing_rate,
        at.SWING_STRIDE: m.swing_stride,
        at.POCKET_UPRIGHT: m.pocket_upright,
        at.SCREEN_UP: m.screen_up,
        at.PHONE_RATE: m.phone_rate,
        at.PHONE_TOP: m.phone_top,
        at.PHONE_TOP_MOST: m.phone_top_most,
        at.PHONE_SCREEN: m.phone_screen,
    }
    prm[list(values)] = list(values.values())
    prm[at.SCREEN_AXIS : at.SCREEN_AXIS + 3] = unit(m.screen_axis)
    prm[at.TOP_AXIS : at.TOP_AXIS + 3] = unit(m.top_axis)
    return prm
