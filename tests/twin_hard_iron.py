"""Plain NumPy twin of `kernels.hard_iron`: dense matrices, H by finite differences of what a block would read, likelihoods summed."""

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal


class Twin:
    """x = (field in the gyroscope's frame, hard iron), after the parameters `HardIronParameters.model_dump()`."""

    def __init__(self, p, start):
        self.p, self.A, self.x, self.P = p, np.eye(3), np.zeros(6), np.diag([0.0] * 3 + [p["prior_sd"] ** 2] * 3)
        self.block, self.last, self.moved, self.angle, self.known = [], start, 0.0, 0.0, False
        self.over = 3 * p["memory_s"]
        self.excess = self.over * p["field_walk"] ** 2
        self.nis, self.log_likelihood = np.nan, 0.0

    def sample(self, t, dt, w, m, moving=True, apart=False):
        """True where a block was closed."""
        closed = bool(self.block) and (apart or t - self.block[0][0] >= self.p["block_s"])
        if closed:
            self.close()
        rate = np.linalg.norm(w)
        self.A = self.A @ Rotation.from_rotvec(w * dt).as_matrix()
        self.angle += rate * dt
        self.moved += dt * moving
        if np.isfinite(m).all():
            self.block.append((t, self.A, np.array(m), rate))
        return closed

    def close(self):
        p, end = self.p, self.block[-1][0]
        turns = [A for _, A, _, _ in self.block]

        def read(x):
            """What a block reads without noise, turned into the gyroscope's frame."""
            return np.mean([A @ (A.T @ x[:3] + x[3:]) for A in turns], axis=0)

        H = np.stack([read(e) - read(0 * e) for e in np.eye(6)], 1)
        y = np.mean([A @ m for _, A, m, _ in self.block], axis=0)
        square = self.x[:3] @ self.x[:3] if self.known else y @ y
        R = p["sd"] ** 2 + square * p["delay_s"] ** 2 * np.mean([r**2 for *_, r in self.block])
        self.nis = np.nan
        if not (self.known and self.measure(H, y, R, square, end)):
            b, P = self.x[3:], self.P[3:, 3:]
            Ab = H[:, 3:]
            self.x[:3] = y - Ab @ b
            self.P = np.block([[Ab @ P @ Ab.T + R * np.eye(3), -Ab @ P], [-(Ab @ P).T, P]])
            self.known = True
        self.P[3:, 3:] += p["walk"] ** 2 * (end - self.last) * np.eye(3)
        self.block, self.last, self.moved, self.angle = [], end, 0.0, 0.0

    def measure(self, H, y, R, square, end):
        p = self.p
        z, S = y - H @ self.x, H @ self.P @ H.T
        still = square * p["turn_error"] ** 2 * self.angle + p["drift"] ** 2 * (end - self.last)
        walk = max(p["field_walk"] ** 2, self.excess / self.over)
        if self.moved > 0:
            expected = np.trace(S) + 3 * (R + still)
            fade = np.exp(-self.moved / p["memory_s"])
            self.excess = self.excess * fade + min(z @ z, p["jump"] / 3 * (expected + 3 * walk * self.moved)) - expected
            self.over = self.over * fade + 3 * self.moved
        self.P[:3, :3] += (still + walk * self.moved) * np.eye(3)
        S = H @ self.P @ H.T + R * np.eye(3)
        self.nis = z @ np.linalg.solve(S, z)
        if self.nis > p["jump"]:
            return False
        self.log_likelihood += multivariate_normal(np.zeros(3), S).logpdf(z)
        K = np.linalg.solve(S, H @ self.P).T
        self.x = self.x + K @ z
        self.P = self.P - K @ S @ K.T
        return True

    @property
    def chi2(self):
        return self.x[3:] @ np.linalg.solve(self.P[3:, 3:], self.x[3:])

    @property
    def ln_evidence(self):
        return 0.5 * (self.chi2 + np.linalg.slogdet(self.P[3:, 3:])[1] - 6 * np.log(self.p["prior_sd"]))
