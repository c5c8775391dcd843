"""Plain NumPy twins of ZARU, HDR, MARU and the adaptive threshold: whole histories, dense matrices, textbook formulas."""

import numpy as np
from scipy.spatial.transform import Rotation

import twin


def wrapped(angle):
    return np.angle(np.exp(1j * angle))


def yaw(C, axis):
    return np.arctan2(C[1, axis], C[0, axis])


def yaw_row(C, axis):
    """Jiménez' row with the first column of C, or the second where the body axis is y."""
    x, y, z = C[:, axis]
    return np.array([-z * x, -z * y, x**2 + y**2]) / (x**2 + y**2)


def field_rows(m, T):
    """How the turned-on field errs by an offset that is not subtracted for T seconds."""
    return T * twin.skew(m)


class Constrained(twin.Filter):
    """The dense filter with the constraints of `p` (FootParameters), at a constant rate."""

    def __init__(self, *args, p, rate_hz):
        super().__init__(*args)
        self.p_, self.rate_hz = p, rate_hz
        self.axis = int(abs(self.C[2, 1]) < abs(self.C[2, 0]))
        self.quiet_s = 0.0
        self.stances, self.now, self.since, self.used = [], None, 0.0, False
        self.kept = None
        self.zaru_nis = self.hdr_innovation = self.maru_nis = np.nan

    def constrain(self, w, dt, standing, m):
        self.zaru_nis = self.hdr_innovation = self.maru_nis = np.nan
        if self.p_.zaru.use != "off":
            self.zero_angular_rate(w, dt, standing)
        if self.p_.hdr.use != "off":
            self.heading_reduction(dt, standing)
        if self.p_.maru.use:
            self.magnetic_rate(w, dt, standing, m)

    def rows(self, first, block):
        H = np.zeros((len(block), 15))
        H[:, first : first + 3] = block
        return H

    def zero_angular_rate(self, w, dt, standing):
        z, p = w - self.bg, self.p_.zaru
        self.quiet_s = self.quiet_s + dt if np.linalg.norm(z) <= p.rate else 0.0
        if standing and (p.use == "stance" or self.quiet_s >= p.after_s):
            R = np.eye(3) * p.sd**2 * max(1.0, p.correlation_s * self.rate_hz)
            self.zaru_nis = self.update(self.rows(12, np.eye(3)), z, R)

    def heading_reduction(self, dt, standing):
        """Stances as lists of yaws: `now` is the one that lasts, `stances` holds (length, mean) of those before."""
        p = self.p_.hdr
        if not standing:
            self.since += dt
            return
        angle = yaw(self.C, self.axis)
        if self.now is None or self.since > p.apart_s:
            if self.now is not None and self.length >= p.after_s:
                self.stances.append(self.mean())
            self.now, self.length, self.used = [angle], 0.0, False
        else:
            self.length += self.since + dt
            self.now.append(angle)
        self.since = 0.0
        if len(self.stances) < 2 or self.length < p.after_s:
            return
        if p.use == "stance":
            if self.used:
                return
            self.used = True
            angle = self.mean()
        elif self.length > p.longest_s:
            return
        before = self.stances[-1] + wrapped(self.stances[-2] - self.stances[-1]) / 2
        self.hdr_innovation = z = wrapped(angle - before)
        if abs(z) <= p.tolerance:
            self.update(self.rows(0, yaw_row(self.C, self.axis)[None]), np.array([z]), np.eye(1) * p.sd**2)

    def mean(self):
        return self.now[0] + np.mean(wrapped(np.array(self.now) - self.now[0]))

    def magnetic_rate(self, w, dt, standing, m):
        p = self.p_.maru
        if self.kept is not None:
            m0, bias, T = self.kept
            self.kept = Rotation.from_rotvec(-(w - bias) * dt).as_matrix() @ m0, bias, T + dt
        if not standing:
            self.kept = None
        elif m is not None:
            if self.kept is None:
                self.kept = m, self.bg.copy(), 0.0
            elif self.kept[2] >= p.interval_s:
                self.compare(m, *self.kept)
                self.kept = m, self.bg.copy(), 0.0

    def compare(self, m, turned, bias, T):
        p = self.p_.maru
        if abs(np.linalg.norm(m) - np.linalg.norm(turned)) > p.norm_tolerance * np.linalg.norm(turned):
            return
        H = self.rows(12, field_rows(m, T))
        z, R = turned - m + T * np.cross(m, bias - self.bg), np.eye(3) * 2 * p.sd**2
        self.maru_nis = 3 * (z @ z) / np.trace(H @ self.P @ H.T + R)
        if self.maru_nis <= 3 * p.gate**2:
            self.update(H, z, R)


class Pace:
    """Li & Wang eq 36 with whole histories: the class after each speed."""

    def __init__(self, p, rate_hz):
        self.p, self.n = p, round(p.window_s * rate_hz)
        self.speeds, self.means, self.now = [], [], 1

    def take(self, speed):
        p = self.p
        self.speeds.append(speed)
        if len(self.speeds) < self.n:
            return
        self.means.append(np.mean(self.speeds[-self.n :]))
        v, low = max(self.means[-self.n :]), 1 - p.hysteresis
        up = int(v >= p.walk_speed) + int(v >= p.run_speed)
        down = int(v >= low * p.walk_speed) + int(v >= low * p.run_speed)
        self.now = max(up, min(self.now, down))
