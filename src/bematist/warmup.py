"""`python -m bematist.warmup`: compile every kernel once into the cache, so that the first real run need not wait."""

import tempfile
from pathlib import Path

import numpy as np

from bematist import clockfit
from bematist.ahrs import attitude
from bematist.allan.deviation import Stretches, averaging_spans, overlapping_variance
from bematist.foot import FootIns
from bematist.io.trajectory_files import write_csv
from bematist.recording import Recording
from bematist.stance import analyse


def warm_up() -> None:
    """Run every compiled kernel on a second of nothing."""
    rng = np.random.default_rng(0)
    n = 100
    still = np.tile([0.0, 0.0, 9.8], (n, 1)) + rng.normal(0, 0.01, (n, 3))
    still[50] = np.nan  # so that the filling of missing values is compiled too
    recording = Recording(time=np.arange(n) / 100, specific_force=still, angular_rate=rng.normal(0, 0.001, (n, 3)))
    with tempfile.TemporaryDirectory() as folder:
        write_csv(FootIns().run(recording), Path(folder) / "trajectory.csv")
    attitude(recording)
    attitude(recording, "hand")
    analyse(recording)
    overlapping_variance(still[:50, 2].copy(), Stretches((slice(0, 50),), 0.01), averaging_spans(50))
    clockfit.uniform(recording.time + rng.uniform(0, 0.02, n))


if __name__ == "__main__":
    warm_up()
