"""Every method for a shoe on one recording, side by side in a table, a page and a picture.

python compare_methods.py [RECORDING] [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import bematist as bm
from bematist.methods import worn
from bematist.report import still_path, write_report
from bematist.simulate import simulate

recording = bm.read(sys.argv[1]) if len(sys.argv) > 1 else simulate("short")
folder = Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp(prefix="bematist-"))
folder.mkdir(parents=True, exist_ok=True)

trajectories = [bm.track(recording, name) for name in worn("shoe")]
for trajectory in trajectories:
    line = f"{trajectory.method:10} {trajectory.distance_m:8.2f} m"
    if recording.reference is not None:
        found = bm.evaluate(trajectory, recording.reference, align="yaw")
        line += f", rms error in plan {found.ate_plan_m:.2f} m [{found.alignment.kind}], length {found.length_ratio:.4f} of the true one"
    print(line)

write_report(trajectories, folder / "compare.html", reference=recording.reference)
still_path(trajectories, folder / "compare.png", reference=recording.reference)
print("written:", folder / "compare.html", folder / "compare.png")
