"""How near a calibration comes to the Cramér-Rao bound: `python benchmarks/calibration.py [SEEDS]`, sensors simulated in the hand.

For accelerometer and gyroscope: rms error of each kind of parameter over the sensors, over the bound of the same equations at the truth
with the white noise alone, and over what the calibration itself claims.
"""

import sys

import numpy as np

import bematist as bm
from bematist.calibrate.accelerometer import fit_gravity
from bematist.calibrate.gyroscope import Directions, turn_blocks
from bematist.calibrate.rests import find_rests
from bematist.calibrate.solve import placed
from bematist.calibrate.turning import turns_between
from bematist.simulate import Sensor, simulate_walk

DEVICE = Sensor(
    rate_hz=100.0,
    magnetometer_rate_hz=0.0,
    velocity_random_walk=2e-3,
    angle_random_walk=2e-4,
    accel_bias_sd=0.2,
    gyro_bias_sd=0.01,
    accel_scale_sd=0.01,
    accel_misalignment_sd=0.005,
    gyro_scale_sd=0.01,
    gyro_misalignment_sd=0.005,
)
KINDS = {
    "gyroscope scale": [0, 4, 8],
    "gyroscope misalignment": [1, 2, 3, 5, 6, 7],
    "accelerometer scale": [9, 12, 14],
    "accelerometer misalignment": [10, 11, 13],
    "accelerometer offset": [15, 16, 17],
}
UPPER = [0, 1, 2, 4, 5, 8]


def truth(made):
    """The 18 parameters at the truth, in the frame in which the accelerometer's inverse matrix is upper triangular."""
    e = made.errors
    Q, R = np.linalg.qr(np.linalg.inv(e.accel_matrix))
    signs = np.sign(np.diag(R))
    frame = (Q * signs).T
    return np.concatenate([(frame @ np.linalg.inv(e.gyro_matrix)).ravel(), (R.T * signs).T.ravel()[UPPER], e.accel_bias[0]])


def bound(made, p):
    """Covariance (18,18) by the sensor's white noise alone."""
    rests = find_rests([made.recording])
    gravity = fit_gravity(rests, made.scenario.gravity, "bound")
    up = Directions(gravity.up(p[9:])[0], rests.force_variance / made.scenario.gravity**2, gravity.up)
    rest = gravity.block()
    equations = [(placed(rest.model, 9, 18), rest.variance)]
    equations += [(b.model, b.variance) for b in turn_blocks(rests, turns_between(rests, [made.recording]), [up], [])]
    J = np.concatenate([(model(p)[1] / np.sqrt(variance)[:, None, None]).reshape(-1, 18) for model, variance in equations])
    return np.linalg.inv(J.T @ J)


def main(seeds):
    over_bound, over_claim = [], []
    for seed in range(seeds):
        made = simulate_walk("tumble", DEVICE, seed, full_turns=False)
        found = bm.calibrate(made.recording, gravity=made.scenario.gravity)
        p = truth(made)
        a, g = found["accelerometer"], found["gyroscope"]
        off = np.concatenate([g.matrix.ravel(), a.matrix.ravel()[UPPER], a.offset]) - p
        claimed = np.concatenate([g.matrix_sd.ravel(), a.matrix_sd.ravel()[UPPER], a.offset_sd])
        over_bound.append(off / np.sqrt(np.diag(bound(made, p))))
        over_claim.append(off / claimed)
    print(f"{seeds} sensors, 24 rests of 3 s each\n\n| parameter | rms error over the bound | over what is claimed |\n|---|---|---|")
    for kind, k in KINDS.items():
        ratios = [np.sqrt(np.mean(np.square(np.array(z)[:, k]))) for z in (over_bound, over_claim)]
        print(f"| {kind} | {ratios[0]:.2f} | {ratios[1]:.2f} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
