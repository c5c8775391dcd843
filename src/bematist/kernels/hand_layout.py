"""Where things stand in the flat arrays of the handheld filter: workspace, parameters, results, diagnostics, detectors."""

from bematist.kernels import hard_iron_layout as hard_iron

# The error state, and with it the columns of P: quaternion 4, gyroscope-quaternion offset 3, accelerometer offset 3,
# reference of the magnetic field 3, reference of the specific force 3.
WIDTH = 16
E_Q, E_BQ, E_BA, E_M, E_F = 0, 4, 7, 10, 13

# workspace S: covariance, three rows for an update, then the state in the order of the error
P, W, X = 0, 256, 304
Q, BQ, BA, MREF, FREF = X + E_Q, X + E_BQ, X + E_BA, X + E_M, X + E_F
# rotation since the last magnetometer sample with its derivative (4x3) to the gyroscope-quaternion offset, and that of the last sample
TURN, TURN_BQ, STEP, STEP_BQ = 320, 324, 336, 340
TURNED = 352  # whether there is a TURN: since the last magnetometer sample something was turned
LAST_M, LAST_M_KNOWN, LAST_F, LAST_F_KNOWN, USED_BQ = 353, 356, 357, 360, 361
TIME, STARTED, RATE, LAST_M_TIME = 364, 365, 366, 369
FAULTS = 370  # of magnetic field and specific force, in a row
ANCHORED = 372  # whether the magnetic field is being compared with what it was where the sensor rests
ROW = 373
# the Earth's field that samples are compared with, and of `hard_iron`
EARTH_E, EARTH_N, EARTH_U, EARTH_NORM, EARTH_INCLINATION = range(384, 389)
IRON = EARTH_INCLINATION + 1
WORKSPACE_SIZE = IRON + hard_iron.SIZE

# parameters prm
(
    G,
    PERIOD,  # nominal sampling period, to which the gyroscope-quaternion offset belongs
    PSD_ANGLE,
    BIAS_WALK,
    BIAS_POWER,  # of dt in the variance of the gyroscope offset's walk: 1, or 2 as printed
    ACCEL_DECAY,
    ACCEL_BIAS_WALK,
    PROJECT,
    CORRECTION,
    REFERENCE,
    GAP_S,
    GAP_RATE,
    GAP_BALLISTIC_S,
    START_E,  # the Earth's field as it was at the start (3)
    START_N,
    START_U,
    DIP_TOLERANCE,
    RATE_E,
    RATE_N,
    RATE_U,
    LEVEL_PSD,
    LEVEL_SPREAD,
    HEADING_PSD,
    HEADING_NORM,
    HEADING_DIP,
    HEADING_SPREAD,
    HEADING_LONGEST_S,  # what a sample stands for at most
    REST_VARIANCE,
) = range(28)
# and for each of the two fields, from MAGNETIC or FORCE on
USE, DETECTOR, DEVIATION, OUTLIER, LIKELIHOOD, LOCAL, EARTH, EARTH_TOLERANCE, VARIANCE, EARTH_VARIANCE, WALK, GRADIENT, LIMIT, PATIENCE = (
    range(14)
)
MAGNETIC = REST_VARIANCE + 1
FORCE = MAGNETIC + PATIENCE + 1
IRON_USE = FORCE + PATIENCE + 1  # of `hard_iron`
PARAMETERS = IRON_USE + hard_iron.PARAMETERS

# values of CORRECTION
NOTHING, KALMAN, REPLACE = 0.0, 1.0, 2.0
# of REFERENCE
FIXED, ESTIMATED = 0.0, 1.0
# of DETECTOR
BY_VARIANCE, BY_LIKELIHOOD = 0.0, 1.0

# a detector: its sizes and counters in `index`, its sums and ring in `memory`
COUNT, PLACE, LENGTH, FIRST, RING = range(5)
INDEX_EACH = 8
MEMORY_HEAD = 16  # of memory: what a missing value is held at (`stance.HELD`), before the detectors
SUM, SQUARES, CHANGES, STATIC, REFERENCE_NORM, IS_EARTH = range(6)
DETECTOR_HEAD = 8
ENTRY = 4  # of the ring: norm, and the field in n

# columns of the result: t q, packed covariance of the attitude
NAV = 11
# columns of the diagnostics; from FIELD_M and FIELD_F on: see FIELD_…
GYRO_BIAS, GYRO_BIAS_SD, ACCEL_BIAS, ACCEL_BIAS_SD, BRIDGED, HEADING_NU = 0, 3, 6, 9, 12, 13
FIELD_M, FIELD_F = 16, 24
STATISTIC, NU, NIS, VERDICT, GRADIENT_NIS = 0, 1, 4, 5, 6
DIAG = 32
IRON_DIAG = DIAG  # where `hard_iron` is in use, its columns follow

# verdicts on a field
NO_SAMPLE, CHANGING, LOCAL_USED, EARTH_USED, FAULT, UNUSED = range(6)
