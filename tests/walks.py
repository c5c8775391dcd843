"""Small synthetic recordings for tests of the filter; the simulator proper has its own tests."""

import numpy as np

from bematist.recording import Recording

FIELD = np.array([3.0, 27.0, -36.0])


def shaken(n=3000, rate=200.0, seed=0, magnetometer=True):
    """A sensor that rests, then is shaken and turned with pauses: no walk, but every branch of the filter is run."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) / rate
    moving = (np.sin(2 * np.pi * t / 1.1) > 0) & (t > 2)
    f = np.array([0.5, 1.0, 9.7]) + rng.normal(0, 0.02, (n, 3))
    w = np.array([0.002, -0.003, 0.004]) + rng.normal(0, 0.002, (n, 3))
    f[moving] += 8 * np.sin(40 * t[moving, None] + [0, 1, 2])
    w[moving] += 3 * np.cos(20 * t[moving, None] + [2, 0, 1])
    fields = {}
    if magnetometer:
        tm = np.arange(0.003, t[-1], 1 / 80)
        m = FIELD + rng.normal(0, 0.3, (len(tm), 3))
        m[(tm > 6) & (tm < 8)] *= 1.3
        fields = {"magnetic_time": tm, "magnetic_flux_density": m}
    return Recording(time=t, specific_force=f, angular_rate=w, **fields)
