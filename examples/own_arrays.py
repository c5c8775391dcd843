"""Your own arrays: any sensor whose samples are NumPy arrays, with a magnetometer on its own clock.

    python own_arrays.py [CSV]

The CSV is one of bematist's canonical ones, read here with NumPy alone; without it a walk is simulated.
"""

import sys

import numpy as np

import bematist as bm
from bematist.simulate import simulate

if len(sys.argv) > 1:
    table = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
    t, f, w = table["time"], *(np.stack([table[s + a] for a in "xyz"], 1) for s in "fw")
    m = np.stack([table["m" + a] for a in "xyz"], 1) if "mx" in table.dtype.names else np.full((len(t), 3), np.nan)
    seen = np.isfinite(m).all(1)  # an empty cell is no sample
    tm, m = t[seen], m[seen]
else:
    walk = simulate("short")
    t, f, w, tm, m = walk.time, walk.specific_force, walk.angular_rate, walk.magnetic_time, walk.magnetic_flux_density

# A sensor that reads in g and degrees per second would be brought to SI here: f * 9.80665, np.radians(w).
recording = bm.Recording(
    time=t - t[0],  # s, strictly increasing
    specific_force=f,  # m/s²; a level sensor at rest reads +9.8 upwards
    angular_rate=w,  # rad/s
    magnetic_time=tm - t[0],  # s; leave both out without a magnetometer
    magnetic_flux_density=m,  # µT
    source="my sensor",
)
trajectory = bm.track(recording)
print(f"{recording.rate_hz:.0f} Hz, {len(trajectory.stance_intervals())} stances, {trajectory.distance_m:.1f} m")
print(trajectory.to_polars().tail(3))
