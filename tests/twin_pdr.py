"""The path of a hand written plainly, with dense matrices and NumPy: what `kernels.pdr` and `kernels.barometer` compute."""

import numpy as np


def step_length(prm, frequency, motion):
    if motion == "stairs":
        return prm["tread"]
    s = max(0.0, prm["height"] * (prm["a"] * frequency + prm["b"]) + prm["c"])
    return s * prm["running_factor"] if motion == "running" else s


def moved(state, s, theta):
    """Position after a step; state: east, north, scale, direction and heading errors, of which the last three are subtracted."""
    e, n, scale, direction, heading = state
    length, angle = s * (1 + scale), theta + direction + heading
    return np.array([e + length * np.cos(angle), n + length * np.sin(angle), scale, direction, heading])


class Path:
    """Position (2,) and error covariance (5,5) of position, scale, direction, heading."""

    def __init__(self, prm):
        self.prm = prm
        self.p = np.zeros(2)
        self.P = np.diag([0.0, 0.0, prm["scale_sd"] ** 2, prm["direction_sd"] ** 2, 0.0])
        self.last = None

    def step(self, t, s, theta, heading_var):
        q = self.prm
        dt = 0.0 if self.last is None else t - self.last
        self.last = t
        keep = np.exp(-dt / q["direction_s"])
        turn = np.exp(-dt / q["heading_s"])
        if self.P[4, 4] > heading_var or (np.isinf(q["heading_s"]) and self.P[4, 4] > 0):
            turn *= np.sqrt(heading_var / self.P[4, 4])
        A = np.diag([1.0, 1.0, 1.0, keep, turn])
        before = self.P.copy()
        self.P = A @ self.P @ A
        self.P[3, 3] = keep**2 * before[3, 3] + (1 - keep**2) * q["direction_sd"] ** 2
        self.P[4, 4] = heading_var
        u, v = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
        F = np.eye(5)
        F[:2, 2] = s * u
        F[:2, 3] = F[:2, 4] = s * v
        self.P = F @ self.P @ F.T
        self.P[:2, :2] += s**2 * (q["sd"] ** 2 * np.outer(u, u) + q["step_sd"] ** 2 * np.outer(v, v))
        self.p = self.p + s * u


def heights(t, pressure, sd, walk, climb, kelvin):
    """Height and its variance after each sample of the barometer, by a filter with the states height and offset."""
    x, P = np.zeros(2), np.diag([0.0, sd**2])
    H = np.array([1.0, 1.0])
    out = [(0.0, 0.0)]
    for k in range(1, len(t)):
        P = P + np.diag([climb**2, walk**2]) * (t[k] - t[k - 1])
        z = kelvin / 0.0065 * (1 - (pressure[k] / pressure[0]) ** (8.31446 * 0.0065 / (0.0289644 * 9.80665)))
        S = H @ P @ H + sd**2
        K = P @ H / S
        x = x + K * (z - H @ x)
        P = P - np.outer(K, H @ P)
        out.append((x[0], P[0, 0]))
    return np.array(out)
