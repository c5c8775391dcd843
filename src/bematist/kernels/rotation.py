"""Rotations of one sample: scalars and tuples in, tuples out, so that nothing touches memory. Twin of `bematist.frames`."""

import math

from bematist.kernels.jit import inlined


@inlined
def exp_quaternion(x, y, z):
    """Unit quaternion of a rotation vector (rad), exact to rounding: series below 0.5 rad, trigonometric above.

    MAGINAV eq 7, in place of the first-order eqs 8-9 (erratum: those are not orthogonal).
    """
    t2 = 0.25 * (x * x + y * y + z * z)
    if t2 < 0.0625:
        c = 1 - t2 * (1 / 2 - t2 * (1 / 24 - t2 * (1 / 720 - t2 * (1 / 40320 - t2 * (1 / 3628800 - t2 / 479001600)))))
        s = 1 - t2 * (1 / 6 - t2 * (1 / 120 - t2 * (1 / 5040 - t2 * (1 / 362880 - t2 * (1 / 39916800 - t2 / 6227020800)))))
    else:
        t = math.sqrt(t2)
        c = math.cos(t)
        s = math.sin(t) / t
    s *= 0.5
    return c, s * x, s * y, s * z


@inlined
def multiply(a, b, c, d, w, x, y, z):
    """Hamilton product (a, b, c, d) ⊗ (w, x, y, z)."""
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


@inlined
def normalise(w, x, y, z):
    """The quaternion with unit norm."""
    s = 1 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * s, x * s, y * s, z * s


@inlined
def in_body(w, x, y, z, e, n, u):
    """A vector of the navigation frame in the axes of the body with the unit quaternion of C_nb: C_nbᵀ v."""
    C = matrix(w, x, y, z)
    return C[0] * e + C[3] * n + C[6] * u, C[1] * e + C[4] * n + C[7] * u, C[2] * e + C[5] * n + C[8] * u


@inlined
def matrix(w, x, y, z):
    """The nine entries, row by row, of C_nb of a unit quaternion."""
    return (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )
