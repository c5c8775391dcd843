"""Plain NumPy twin of the handheld filter: dense matrices, windows as lists, one sample after the other. Slow on purpose."""

import numpy as np

from bematist.frames import matrix_from_quaternion as rotation
from bematist.frames import multiply, quaternion_from_rotation_vector


def left(q):
    """M(q), MAGYQ eq 5: q ⊗ y = M(q) y."""
    w, x, y, z = q
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


def right(q):
    """C(q), MAGYQ eq 5: x ⊗ q = C(q) x."""
    w, x, y, z = q
    return np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def h1(q, x):
    """MAGYQ eq 38."""
    u, v = q[1:], q[0] * x + np.cross(q[1:], x)
    return 2 * np.column_stack([v, u @ x * np.eye(3) - cross(v)])


def h3(q, x):
    """MAGYQ eq 43."""
    u, v = q[1:], q[0] * x - np.cross(q[1:], x)
    return 2 * np.column_stack([v, u @ x * np.eye(3) + cross(v)])


def sandwich(q, x):
    """q ⊗ x ⊗ q* of a quaternion of any norm."""
    return (left(q) @ right(q * [1, -1, -1, -1]) @ np.concatenate([[0], x]))[1:]


def unit(q):
    return q / np.linalg.norm(q)


def step(w, b, share, dt):
    """q_w of eqs 19 and 30, and its derivative to the gyroscope-quaternion offset (3) of the nominal period."""
    r = quaternion_from_rotation_vector(w * dt) - np.concatenate([[0], share * b])
    q = unit(r)
    return q, -share / np.linalg.norm(r) * (np.eye(4) - np.outer(q, q))[:, 1:]


class Window:
    """A detector of a quasi-static field, MAGYQ eqs 33 and 34."""

    def __init__(self, length, first, p):
        self.length, self.first, self.p = length, first, p
        self.values, self.static = [], False

    def statistic(self, reference):
        norms = np.array([v[0] for v in self.values])
        if self.p["detector"] == "likelihood":
            return (np.diff(norms) ** 2).mean() / (2 * self.p["sd"] ** 2), self.p["likelihood"]
        return np.sqrt(((norms - reference) ** 2).mean()), self.p["deviation"]

    def passes(self, reference):
        value, limit = self.statistic(reference)
        return value < limit and abs(self.values[-1][0] - reference) <= self.p["outlier"]

    def judge(self, norm, in_n):
        """Static now, and begun now."""
        self.values = [*self.values, (norm, in_n)][-self.length :]
        if len(self.values) < self.length:
            return False, False
        if self.static and self.passes(self.norm):
            return True, False
        self.norm = np.mean([v[0] for v in self.values[: self.first]])
        self.mean = np.mean([v[1] for v in self.values[: self.first]], 0)
        self.static = self.passes(self.norm)
        return self.static, self.static


class Filter:
    """The 16-state filter. p: `AttitudeParameters` as a dictionary."""

    def __init__(self, p, q, b, P, period, g, earth, sizes, gap):
        self.p, self.period, self.g, self.earth, self.gap = p, period, g, earth, gap
        self.x = np.concatenate([q, b, np.zeros(9)])
        self.P = np.array(P, float)
        self.windows = [Window(*s, f) for s, f in zip(sizes, (p["magnetic"], p["force"]), strict=True)]
        self.is_earth, self.faults = [False, False], [0, 0]
        self.references = p["reference"] == "estimated"
        self.last_m = self.last_f = self.last_t = None
        self.anchored = False
        self.forget_turn()

    def forget_turn(self):
        self.turn, self.turn_b = np.array([1.0, 0, 0, 0]), np.zeros((4, 3))

    def predict(self, w, dt):
        noise, x = self.p["noise"], self.x
        if self.p["earth_rate"] is not None:
            w = w - rotation(x[:4]).T @ self.p["earth_rate"]
        share = dt / self.period
        qw, D = step(w, x[4:7], share, dt)
        if not self.p["normalise_covariance"]:
            D = -share * np.eye(4)[:, 1:]
        self.qw, self.D, self.b_used = qw, D, x[4:7].copy()
        self.decay = 1 - dt / noise["accel_bias_time_s"]
        Phi = np.eye(16)
        Phi[:4, :4], Phi[:4, 4:7] = right(qw), left(x[:4]) @ D
        Phi[7:10, 7:10] *= self.decay
        x[:4] = unit(left(x[:4]) @ qw)
        x[7:10] *= self.decay
        Q = np.zeros((16, 16))
        Q[:4, :4] = noise["angle_random_walk"] ** 2 * dt / 4 * (np.eye(4) - np.outer(x[:4], x[:4]))
        walk = (noise["gyro_bias_walk"] * self.period / 2) ** 2 * dt
        Q[4:7, 4:7] = np.eye(3) * walk * (dt if noise["bias_scaling"] == "printed" else 1)
        Q[7:10, 7:10] = np.eye(3) * 2 * noise["accel_bias_sd"] ** 2 / noise["accel_bias_time_s"] * dt
        Q[10:13, 10:13] = np.eye(3) * self.p["magnetic"]["walk"] ** 2 * dt
        Q[13:, 13:] = np.eye(3) * self.p["force"]["walk"] ** 2 * dt
        self.P = Phi @ self.P @ Phi.T + Q
        self.turn_b = right(qw) @ self.turn_b + left(self.turn) @ D
        self.turn = left(self.turn) @ qw

    def bridge(self, w, last_w, dt):
        if dt <= self.gap["ballistic_s"]:
            mean = (w + last_w) / 2 - 2 * self.x[4:7] / self.period
            self.x[:4] = unit(multiply(self.x[:4], quaternion_from_rotation_vector(mean * dt)))
        angle = min(self.gap["rate_sd"] * dt, 0.5)
        self.P[:4, :4] += angle**2 / 4 * (np.eye(4) - np.outer(self.x[:4], self.x[:4]))
        for window in self.windows:
            window.values, window.static = [], False
        self.last_m = self.last_f = None
        self.forget_turn()

    def update(self, z, H, R, limit):
        S = H @ self.P @ H.T + R
        nis = z @ np.linalg.solve(S, z)
        if nis > limit:
            return False
        K = self.P @ H.T @ np.linalg.inv(S)
        self.x = self.x + K @ z
        self.P = self.P - K @ S @ K.T
        self.x[:4] = unit(self.x[:4])
        return True

    def directions(self, i, value):
        """Jacobian of q ⊗ x ⊗ q* of field i, value freed of its offset."""
        H = np.zeros((3, 16))
        H[:, :4] = h1(self.x[:4], value)
        if i == 1:
            H[:, 7:10] = -rotation(self.x[:4])
        return H

    def value(self, i, f, m):
        return f - self.x[7:10] if i == 1 else m

    def quasi_static(self, i, f, m, starts):
        """Whether it had anything to compare with."""
        p, window, place = self.p[("magnetic", "force")[i]], self.windows[i], slice(10 + 3 * i, 13 + 3 * i)
        if starts:
            if self.references:
                value = self.value(i, f, m)
                H = self.directions(i, value)
                T = np.eye(16)
                T[place] = H
                self.P = T @ self.P @ T.T
                self.P[place, place] += p["sd"] ** 2 * np.eye(3)
                self.x[place] = rotation(self.x[:4]) @ value
            else:
                self.x[place] = window.mean
        used, local = True, p["local"] and (not starts if self.references else not self.is_earth[i])
        if local:
            value = self.value(i, f, m)
            H = self.directions(i, value)
            if self.references:
                H[:, place] -= np.eye(3)
            z = self.x[place] - rotation(self.x[:4]) @ value
            used &= self.update(z, H, p["sd"] ** 2 * np.eye(3), p["innovation_limit"])
        if self.is_earth[i]:
            value = self.value(i, f, m)
            z = (self.earth, np.array([0, 0, self.g]))[i] - rotation(self.x[:4]) @ value
            used &= self.update(z, self.directions(i, value), p["earth_sd"] ** 2 * np.eye(3), p["innovation_limit"])
        self.faults[i] = 0 if used or starts else self.faults[i] + 1
        if self.faults[i] > p["patience"]:
            window.static = False
        return local or self.is_earth[i]

    def gradient(self, x, y, turn, D, sd, dt, p, force):
        C = rotation(turn)
        H = np.zeros((3, 16))
        H[:, 4:7] = h3(turn, x) @ D
        if force:
            H[:, 7:10] = np.eye(3) - C.T / self.decay
        z = y - C.T @ x - H[:, 4:7] @ (self.x[4:7] - self.b_used)
        R = 2 * sd**2 + x @ x * self.p["noise"]["angle_random_walk"] ** 2 * dt
        self.update(z, H, R * np.eye(3), p["innovation_limit"])

    def heading(self, m, dt):
        motion, e = self.p["motion"], self.earth
        n = rotation(self.x[:4]) @ m
        dip = [-np.arctan2(v[2], np.hypot(v[0], v[1])) for v in (n, e)]
        norm = np.linalg.norm(e)
        off = np.array([np.linalg.norm(m) - norm, norm * (dip[0] - dip[1])])
        if abs(off[0]) > motion["norm_tolerance"] * norm or abs(off[1]) > motion["inclination_tolerance"] * norm:
            return
        h = e[:2] / np.hypot(*e[:2])
        nu = np.arctan2(h[0] * n[1] - h[1] * n[0], h @ n[:2])
        row = np.array([-e[2] / np.hypot(*e[:2]) * h[0], -e[2] / np.hypot(*e[:2]) * h[1], 1])
        H = np.zeros((1, 16))
        H[0, :4] = row @ (-2 * right(self.x[:4])[:, 1:].T)
        density = motion["heading_density"] ** 2 + motion["heading_spread"] ** 2 * (off @ off / 2) / (e[:2] @ e[:2])
        longest = motion["heading_spread"] ** 2 or np.inf
        self.update(np.array([nu]), H, np.array([[density / min(dt, longest)]]), self.p["magnetic"]["innovation_limit"])

    def observe(self, t, f, m, dt):
        p = self.p
        values = [(m, np.isfinite(m).all() and p["magnetic"]["use"]), (f - self.x[7:10], p["force"]["use"])]
        static, starts = [False, False], [False, False]
        for i in (1, 0):
            value, there = values[i]
            if not there:
                continue
            norm, in_n = np.linalg.norm(value), rotation(self.x[:4]) @ value
            static[i], starts[i] = self.windows[i].judge(norm, in_n)
            if starts[i]:
                w, e = self.windows[i], (self.earth, np.array([0, 0, self.g]))[i]
                q = p[("magnetic", "force")[i]]
                self.is_earth[i] = bool(q["earth"] and abs(w.norm - np.linalg.norm(e)) <= q["earth_tolerance"])
                if i == 0 and q["dip_tolerance"] is not None:
                    dip = [-np.arctan2(v[2], np.hypot(v[0], v[1])) for v in (w.mean, e)]
                    self.is_earth[i] &= abs(dip[0] - dip[1]) <= q["dip_tolerance"]
        if static[0] and p["magnetic"]["gradient"] and self.last_m is not None:
            self.gradient(self.last_m, m, self.turn, self.turn_b, p["magnetic"]["sd"], t - self.last_t, p["magnetic"], False)
        if static[1] and p["force"]["gradient"] and self.last_f is not None and dt > 0:
            b = self.x[7:10]
            self.gradient(self.last_f - b / self.decay, f - b, self.qw, self.D, p["force"]["sd"], dt, p["force"], True)
        density = p["motion"]["gravity_density"]
        compared = static[1] and self.quasi_static(1, f, m, starts[1])
        if not compared and p["force"]["use"] and density > 0 and dt > 0:
            value = f - self.x[7:10]
            off = p["motion"]["gravity_spread"] * (np.linalg.norm(value) - self.g)
            z = np.array([0, 0, self.g]) - rotation(self.x[:4]) @ value
            self.update(z, self.directions(1, value), (density**2 + off**2) / dt * np.eye(3), np.inf)
        at_rest = p["motion"]["rest_field_sd"] > 0 and not p["magnetic"]["local"]
        if static[0]:
            if at_rest:
                starts[0] |= static[1] and not self.anchored
                self.p = {**p, "magnetic": p["magnetic"] | {"local": static[1], "sd": p["motion"]["rest_field_sd"]}}
            self.quasi_static(0, f, m, starts[0])
            self.p = p
            self.anchored = static[1]
        elif values[0][1] or not static[1]:
            self.anchored = False
        if values[0][1] and p["motion"]["heading_density"] > 0 and self.last_m is not None:
            self.heading(m, t - self.last_t)
        if p["normalise_covariance"]:
            J = np.eye(16)
            J[:4, :4] -= np.outer(self.x[:4], self.x[:4])
            self.P = J @ self.P @ J.T
        self.last_f = f if p["force"]["use"] else None
        if values[0][1]:
            self.last_m, self.last_t = m, t
            self.forget_turn()

    def run(self, rows):
        """Attitude (N,4), offsets (N,6) and covariance of psi (N,3,3) of rows without missing force or rate."""
        out = []
        for k, row in enumerate(rows):
            t, f, w, m = row[0], row[1:4], row[4:7], row[7:10]
            dt = t - rows[k - 1, 0] if k else 0.0
            if dt > self.gap["s"]:
                self.bridge(w, rows[k - 1, 4:7], dt)
                dt = 0.0
            elif dt > 0:
                self.predict(w, dt)
            self.observe(t, f, m, dt)
            G = -2 * right(self.x[:4])[:, 1:].T
            out.append((self.x[:4].copy(), self.x[4:10].copy(), G @ self.P[:4, :4] @ G.T))
        return tuple(np.array(a) for a in zip(*out, strict=True))
