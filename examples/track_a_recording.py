"""From a recording to its path, its errors, a report and a map.

    python track_a_recording.py [RECORDING] [FOLDER]

Without a recording a walk is simulated; without a folder the results go into a temporary one.
"""

import sys
import tempfile
from pathlib import Path

import bematist as bm
from bematist.io import export, write_trajectory
from bematist.simulate import simulate

recording = bm.read(sys.argv[1]) if len(sys.argv) > 1 else simulate("short")
folder = Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp(prefix="bematist-"))
folder.mkdir(parents=True, exist_ok=True)

trajectory = bm.track(recording, "foot")
for warning in trajectory.warnings:
    print("warning:", warning)
print(f"{trajectory.distance_m:.1f} m in {recording.duration_s:.0f} s")
print("standard deviation at the end, east north up:", trajectory.position_sd[-1].round(2), "m")

if recording.reference is not None:
    for name, value, unit in bm.evaluate(trajectory, recording.reference, align="yaw").table():
        print(f"{name}: {value if isinstance(value, str) else format(value, '.3g')} {unit}")

write_trajectory(trajectory, folder)
trajectory.report(folder / "report.html", reference=recording.reference)
export(trajectory, folder / "walk.geojson", "geojson", origin=(37.98, 23.78))
print("written:", *sorted(path.name for path in folder.iterdir()))
