"""Plain NumPy twins of the kernels: dense matrices, textbook formulas, one sample after the other. Slow on purpose."""

import numpy as np
from scipy.spatial.transform import Rotation

import twin_ahrs
from bematist import frames


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def statistic(f, w, window, detector, accel_sd, gyro_sd, g, placement="centred"):
    """Test statistic of every sample from its window, cut at the ends: two loops, as in the papers."""
    ahead = {"centred": window // 2, "forward": window - 1, "causal": 0}[placement]
    out = np.empty(len(f))
    for k in range(len(f)):
        a, r = (x[max(0, k + ahead + 1 - window) : k + ahead + 1] for x in (f, w))
        mean = a.mean(0)
        rate = (r**2).sum(1)
        if detector == "shoe":
            rest = ((a - g * mean / np.linalg.norm(mean)) ** 2).sum(1)
            out[k] = (rest / accel_sd**2 + rate / gyro_sd**2).mean()
        elif detector == "ared":
            out[k] = (rate / gyro_sd**2).mean()
        elif detector == "amvd":
            out[k] = (((a - mean) ** 2).sum(1) / accel_sd**2).mean()
        elif detector == "amag":
            out[k] = ((np.linalg.norm(a, axis=1) - g) ** 2 / accel_sd**2).mean()
        else:
            out[k] = np.sqrt(rate.mean())
    return out


def relative(T, look, floor, ratio, sd):
    """Threshold and zero-velocity standard deviation of the relative rule."""
    base = np.array([max(floor, T[max(0, k - look) : k + look + 1].min()) for k in range(len(T))])
    sds = sd * (base / floor) ** 0.25 * np.maximum(T / base, 0.25)
    return ratio * base, np.where(ratio * base > T, sds, 0.0)


def unit_matrix(q):
    return frames.matrix_from_quaternion(q / np.linalg.norm(q))


def triad(a1, b1, a2, b2):
    """MAGINAV Appendix A: R with a2 = R a1, b2 = R b1."""

    def base(a, b):
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        n = np.cross(a, b)
        return np.stack([a, n, np.cross(a, n)], 1) / np.array([1, np.linalg.norm(n), np.linalg.norm(n)])

    return base(a2, b2) @ base(a1, b1).T


class Filter:
    """The 15-state error-state filter with dense matrices (error order psi, v, p, b_a, b_g)."""

    def __init__(self, C, gyro_bias, P, psd, g, magnetic=None, attitude=None, invariant=False):
        self.start, self.attitude = C, attitude or {"propagation": "common", "integration": "exact", "force_at": "middle"}
        self.invariant, self.predicted = invariant, np.zeros(3)
        self.integral, self.since_field = np.zeros(3), 0.0
        self.C, self.v, self.p = C, np.zeros(3), np.zeros(3)
        self.ba, self.bg, self.P = np.zeros(3), np.array(gyro_bias, float), np.array(P, float)
        self.psd, self.g, self.magnetic = psd, g, magnetic

    def bridge(self, w, last_w, dt, gap):
        """A gap: ballistic and turning on when short, standing when long; position, attitude and velocity in doubt."""
        self.p = self.p + self.v * min(dt, gap["ballistic_s"])
        if dt <= gap["ballistic_s"]:
            self.C = self.C @ Rotation.from_rotvec((w + last_w) / 2 * dt).as_matrix()
        else:
            self.v = np.zeros(3)
        self.P[3:6, :] = self.P[:, 3:6] = 0
        doubt = [min(gap["rate_sd"] * dt, 0.5), gap["speed_sd"], gap["speed_sd"] * dt]
        self.P[:9, :9] += np.diag(np.repeat(np.square(doubt), 3))

    def transition(self, C, f_n, dt):
        Phi = np.eye(15)
        Phi[0:3, 12:15] = C * dt
        Phi[3:6, 0:3] = -skew(f_n) * dt
        Phi[3:6, 9:12] = C * dt
        Phi[6:9, 3:6] = np.eye(3) * dt
        return Phi

    def predict(self, f, w, dt, m=None):
        """New attitude; returns the one at the middle of the interval, and the specific force. m: what draws an AHRS."""
        w, f = w - self.bg, f - self.ba
        q = frames.quaternion_from_matrix(self.C)
        turn, pull = self.pull(q, f, w, dt, m)
        middle = unit_matrix(twin_ahrs.turn(q, turn, 0.5, True) - pull / 2)
        how = self.attitude["integration"]
        if how == "first-order-matrix":
            U, _, Vt = np.linalg.svd(np.eye(3) + skew(turn))
            self.C = unit_matrix(frames.quaternion_from_matrix(self.C @ U @ Vt) - pull)
        else:
            self.C = unit_matrix(twin_ahrs.turn(q, turn, 1.0, how == "exact") - pull)
        return middle, f

    def pull(self, q, f, w, dt, m):
        """Rotation vector of the interval, and what Madgwick takes off the quaternion."""
        a = self.attitude
        if a["propagation"] == "common":
            return w * dt, np.zeros(4)
        north = self.magnetic["field"][:2] / np.linalg.norm(self.magnetic["field"][:2]) if self.magnetic else np.array([1.0, 0.0])
        if a["propagation"] == "madgwick":
            to_north = frames.quaternion_from_rotation_vector([0, 0, -np.arctan2(north[1], north[0])])
            g = twin_ahrs.gradient(frames.multiply(to_north, q), f, m)
            g = g / np.linalg.norm(g) if np.linalg.norm(g) else g
            return w * dt, frames.multiply(frames.conjugate(to_north), g) * a["beta"] * dt
        e = twin_ahrs.error(q, f, None, north) * dt + twin_ahrs.error(q, None, m, north) * min(self.since_field, 0.1)
        self.integral = self.integral + a["ki"] * e
        return w * dt + a["kp"] * e + self.integral * dt, np.zeros(4)

    def integrate(self, middle, f, dt):
        f_n, before = middle @ f, self.v
        v = self.v + (f_n - np.array([0, 0, self.g])) * dt
        self.p = self.p + (self.v + v) * dt / 2
        self.v = v
        Phi = self.transition(middle, f_n, dt)
        if self.invariant:
            # P was last written with the errors about the predicted velocity: dv + v x psi is the same before and after a correction.
            T = np.eye(15)
            T[3:6, :3] = -skew(before - self.predicted)
            Phi[3:6, :3] = (Phi @ T)[3:6, :3]
        self.predicted = self.v
        self.P = Phi @ self.P @ Phi.T + np.diag(np.repeat(self.psd, 3)) * dt

    def update(self, H, z, R, attitude=True, turned=False):
        S = H @ self.P @ H.T + R
        K = self.P @ H.T @ np.linalg.inv(S)
        e = K @ z
        A = np.eye(15) - K @ H
        if turned:
            rest = self.v - e[3:6] - np.cross(self.v, e[:3])
            e[3:6] = self.v - Rotation.from_rotvec(-e[:3]).as_matrix() @ rest
        self.P = A @ self.P @ A.T + K @ R @ K.T
        if attitude:
            self.C = Rotation.from_rotvec(-e[:3]).as_matrix() @ self.C
        self.v, self.p = self.v - e[3:6], self.p - e[6:9]
        self.ba, self.bg = self.ba + e[9:12], self.bg + e[12:15]
        return float(z @ np.linalg.solve(S, z))

    def zero_velocity(self, sd, attitude=True):
        H = np.zeros((3, 15))
        H[:, 3:6] = np.eye(3)
        if self.invariant:
            H[:, :3] = skew(self.v)
        return self.update(H, self.v.copy(), np.eye(3) * sd**2, attitude, turned=self.invariant and attitude)

    def set_attitude(self, raw, m):
        """State 3: TRIAD of what is measured, and psi = A x + noise with x the offset of the accelerometer."""
        field = self.magnetic["field"]
        self.C = triad(raw - self.ba, m, np.array([0, 0, 1.0]), field)
        J = self.triad_jacobian()
        A = J[:, :2] @ self.C[:2] / self.g
        if self.magnetic["triad"] == "printed":
            # MAGINAV eq 11 as printed: C(0) TRIAD(f0, m0, fk, mk), with f0 and m0 = C(0)ᵀ of up and field.
            f0, m0 = self.start.T @ [0, 0, 1.0], self.start.T @ field
            self.C = self.start @ triad(f0, m0, raw - self.ba, m)
        if self.magnetic["covariance"] == "untouched":
            return
        T = np.eye(15)
        T[:3, :3], T[:3, 9:12] = 0, A
        noise = np.diag(np.square([self.magnetic["tilt_sd"], self.magnetic["tilt_sd"], self.magnetic["direction_sd"]]))
        self.P = T @ self.P @ T.T
        self.P[:3, :3] += J @ noise @ J.T

    def triad_jacobian(self):
        """psi over (error of the specific force in n, east and north, over g; direction of the field)."""
        m = self.magnetic["field"]
        h = m[:2] / np.linalg.norm(m[:2])
        slope = m[2] / np.linalg.norm(m[:2])
        return np.array([[0, 1, 0], [-1, 0, 0], [-slope * h[1], slope * h[0], 1]])

    def gate(self, m, C):
        ref = self.magnetic["field"]
        norm = np.linalg.norm(ref)
        if abs(np.linalg.norm(m) - norm) > self.magnetic["norm_tolerance"] * norm:
            return False
        dip = np.arcsin(-(C @ m)[2] / np.linalg.norm(m)) - np.arcsin(-ref[2] / norm)
        return abs(dip) <= self.magnetic["inclination_tolerance"]

    def step(self, f, w, dt, sd, m=None, still=False):
        raw = f
        gyro_only = self.C @ Rotation.from_rotvec((w - self.bg) * dt / 2).as_matrix()
        passed = m is not None and self.magnetic is not None and self.gate(m, gyro_only)
        heard = m is not None and self.magnetic is not None and self.attitude.get("magnetometer", "off") == "all"
        heard = heard or (passed and self.attitude.get("magnetometer", "off") == "gated")
        self.since_field += dt
        middle, f = self.predict(f, w, dt, m if heard else None)
        if heard:
            self.since_field = 0.0
        use = self.magnetic["use"] if self.magnetic else "off"
        usable = passed and use != "off" and sd > 0
        reset = usable and use == "reset" and still
        if reset:
            self.set_attitude(raw, m)
            middle = self.C @ Rotation.from_rotvec((w - self.bg) * dt / 2).as_matrix().T
        if self.attitude["force_at"] == "end":
            middle = self.C
        self.integrate(middle, f, dt)
        self.nis = np.nan
        if sd > 0:
            self.nis = self.zero_velocity(sd, attitude=not reset)
            if reset:
                self.set_attitude(raw, m)
            elif usable:
                self.heading(m)

    def heading(self, m):
        ref = self.magnetic["field"]
        horizontal = np.linalg.norm(ref[:2])
        h, slope = ref[:2] / horizontal, ref[2] / horizontal
        est = self.C @ m
        nu = np.arctan2(h[0] * est[1] - h[1] * est[0], h @ est[:2])
        H = np.zeros((1, 15))
        H[0, :3] = -slope * h[0], -slope * h[1], 1
        R = np.array([[self.magnetic["heading_sd"] ** 2]])
        if nu**2 <= self.magnetic["heading_tolerance"] ** 2 + 4 * float((H @ self.P @ H.T)[0, 0]):
            self.update(H, np.array([nu]), R)
