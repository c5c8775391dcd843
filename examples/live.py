"""Live use: samples arrive one by one, positions come out; in the middle the program stops and goes on.

    python live.py [RECORDING]

The samples of a recording (or of a simulated walk) stand for those of a sensor.
"""

import pickle
import sys

import bematist as bm
from bematist.simulate import simulate

recording = bm.read(sys.argv[1]) if len(sys.argv) > 1 else simulate("short")
samples = recording.samples()  # (N,10): time, specific force, angular rate, magnetic flux density or NaN

navigator = bm.FootIns(bm.METHODS["foot"].parameters, method="foot")
next_print = 0.0
path = []
for k in range(len(samples)):
    if navigator.ready:
        row = navigator.step(samples[k : k + 1])  # time, position, velocity, attitude, covariances, or None
        if row is not None:
            path.append(row[:4].copy())  # `row` is overwritten by the next step
    else:
        piece = navigator.update(samples[k : k + 1])  # empty until the start is aligned, then all of it at once
        path += [[t, *p] for t, p in zip(piece.time, piece.position, strict=True)]
    if path and path[-1][0] >= next_print:
        print("at {:5.1f} s: east {:7.2f} m, north {:7.2f} m, up {:6.2f} m".format(*path[-1]))
        next_print = path[-1][0] + 10
    if k == len(samples) // 2:
        navigator = bm.FootIns.restore(pickle.loads(pickle.dumps(navigator.save())))  # as after a restart

rest = navigator.finish()  # what still waited for its window
path += [[t, *p] for t, p in zip(rest.time, rest.position, strict=True)]
print(f"{len(path)} of {len(samples)} samples answered, each {navigator.latency_s:.3f} s late")
