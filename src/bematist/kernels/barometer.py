"""Height from the pressure: a Kalman filter with two states, the height and what the barometer is off by."""

from bematist.kernels import pdr_layout as at
from bematist.kernels.jit import apart, inlined

LAPSE = 0.0065  # K/m
EXPONENT = 8.31446 * LAPSE / (0.0289644 * 9.80665)  # R L / (M g0): J/mol/K, K/m, kg/mol, m/s²


@inlined
def height_of(pressure, reference, temperature):
    """Height above where the pressure was `reference` (Pa both), at a temperature there in K: the barometric formula, m."""
    return temperature / LAPSE * (1 - (pressure / reference) ** EXPONENT)


@apart
def measure_height(W, prm, t, pressure):
    """A sample of the barometer at t: z = height + offset + noise. Returns the height of the formula above the first sample.

    The offset is the noise of that first sample, and then the weather's walk; the height walks as its wearer may climb.
    """
    if W[at.BARO_KNOWN] == 0:
        W[at.BARO_KNOWN], W[at.PRESSURE], W[at.PRESSURE_TIME] = 1.0, pressure, t
        W[at.OFFSET] = -W[at.UP]
        W[at.P_HEIGHT], W[at.P_CROSS], W[at.P_OFFSET] = W[at.UP_VAR], -W[at.UP_VAR], W[at.UP_VAR] + prm[at.BARO_VAR]
        return W[at.UP]
    dt = t - W[at.PRESSURE_TIME]
    W[at.PRESSURE_TIME] = t
    z = height_of(pressure, W[at.PRESSURE], prm[at.TEMPERATURE])
    p00 = W[at.P_HEIGHT] + prm[at.CLIMB_PSD] * dt
    p01 = W[at.P_CROSS]
    p11 = W[at.P_OFFSET] + prm[at.BARO_WALK] * dt
    nu = z - W[at.UP] - W[at.OFFSET]
    h0, h1 = p00 + p01, p01 + p11
    s = h0 + h1 + prm[at.BARO_VAR]
    W[at.UP] += h0 / s * nu
    W[at.OFFSET] += h1 / s * nu
    W[at.P_HEIGHT] = p00 - h0 * h0 / s
    W[at.P_CROSS] = p01 - h0 * h1 / s
    W[at.P_OFFSET] = p11 - h1 * h1 / s
    return z - W[at.OFFSET]


@inlined
def height_variance(W, prm, t):
    """Variance of the height at t, m²."""
    if W[at.BARO_KNOWN] == 0:
        return W[at.UP_VAR]
    return W[at.P_HEIGHT] + prm[at.CLIMB_PSD] * (t - W[at.PRESSURE_TIME])
