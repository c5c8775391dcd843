"""Where things stand in the flat arrays of the foot-mounted filter: workspace, parameters, results, diagnostics."""

# A list of places ends in *_, which takes what is left of 99: nobody counts them.

from bematist.kernels import hard_iron_layout as hard_iron

# workspace S
P, M, W, E, Q, V, X, BA, BG = 0, 240, 384, 432, 448, 452, 455, 458, 461
TIME, STARTED, RATE, ROW = 464, 465, 466, 472
INTEGRAL, FIELD_TIME = 483, 486  # of the attitude's propagation: Mahony's integral (3), time of the last magnetometer sample it took
# of `constraints`: s of quiet; the yaws of stances; the field that the next one is compared with
QUIET_S, SWING_S, STANCE_S, YAW_FIRST, YAW_SUM, YAW_COUNT, YAW_LAST, YAW_BEFORE, STANCES, YAW_USED = range(488, 498)
FIELD_AT, FIELD_BIAS, FIELD_S, FIELD_KNOWN = 498, 501, 504, 505
# of `pace`: the threshold in force, the class, and the windows, whose rings follow after the workspace
LIMIT_NOW, CLASS, PLACE, FILLED, SPEEDS, LARGEST = range(506, 512)
PREDICTED = 512  # velocity before the corrections of the last sample (3)
# the undisturbed field that samples are compared with: norm, inclination; E, N, U; its horizontal direction
FIELD_NORM, FIELD_INCLINATION, FIELD_E, FIELD_N, FIELD_U, NORTH_E, NORTH_N = range(515, 522)
IRON = NORTH_N + 1  # of `hard_iron`
WORKSPACE_SIZE = IRON + hard_iron.SIZE

# parameters prm
(
    G,
    PSD_ATTITUDE,
    PSD_VELOCITY,
    PSD_ACCEL_BIAS,
    PSD_GYRO_BIAS,
    WEIGHT_A,
    WEIGHT_G,
    THRESHOLD,
    ZERO_VELOCITY_SD,
    FLOOR,
    RATIO,
    GAP_S,
    GAP_RATE,
    GAP_SPEED,
    GAP_BALLISTIC_S,
    MAGNETIC_USE,
    NORM_TOLERANCE,
    INCLINATION_TOLERANCE,
    START_E,  # the undisturbed field as it was at the start (3)
    START_N,
    START_U,
    TILT_SD,
    DIRECTION_SD,
    HEADING_SD,
    HEADING_TOLERANCE,
    STILL_FRACTION,
    TRIAD_PRINTED,
    KEEP_COVARIANCE,
    START,  # attitude at the start (4)
    _,
    _,
    _,
    PROPAGATION,
    INTEGRATION,
    AT_END,
    LISTEN,
    KP,
    KI,
    BETA,
    ZARU_USE,
    ZARU_RATE,
    ZARU_AFTER_S,
    ZARU_VARIANCE,
    HDR_USE,
    HDR_VARIANCE,
    HDR_TOLERANCE,
    HDR_AFTER_S,
    HDR_LONGEST_S,
    HDR_APART_S,
    HDR_AXIS,
    MARU_USE,
    MARU_VARIANCE,
    MARU_INTERVAL_S,
    MARU_NORM_TOLERANCE,
    MARU_GATE,
    CONSTRAINED,
    PACE_USE,
    PACE_SAMPLES,
    PACE_WALK,
    PACE_RUN,
    PACE_HYSTERESIS,
    PACE_LIMIT,
    _,
    _,
    INVARIANT,
    EARTH_E,  # rotation of the Earth in n, rad/s (3)
    EARTH_N,
    EARTH_U,
    IRON_USE,  # of `hard_iron`: the last
    *_,
) = range(99)
PARAMETERS = IRON_USE + hard_iron.PARAMETERS

COMMON, MAHONY, MADGWICK = 0.0, 1.0, 2.0
EXACT, FIRST_ORDER, FIRST_ORDER_MATRIX = 0.0, 1.0, 2.0
LISTEN_OFF, LISTEN_GATED, LISTEN_ALL = 0.0, 1.0, 2.0

MAGNETIC_OFF, MAGNETIC_RESET, MAGNETIC_HEADING = 0.0, 1.0, 2.0
HDR_OFF, HDR_SAMPLE, HDR_STANCE = 0.0, 1.0, 2.0
SLOW, WALKING, RUNNING = 0.0, 1.0, 2.0

# columns of the result: t p v q, then packed covariances of position, velocity, attitude
NAV = 29
# columns of the diagnostics
(
    STATISTIC,
    LIMIT,
    ZV_SD,
    INNOVATION,
    _,
    _,
    NIS,
    NORM,
    INCLINATION,
    GATE,
    STATE,
    BRIDGED,
    GYRO_BIAS,
    _,
    _,
    GYRO_BIAS_SD,
    _,
    _,
    ACCEL_BIAS,
    _,
    _,
    ACCEL_BIAS_SD,
    _,
    _,
    ZARU_NIS,
    HDR_INNOVATION,
    MARU_NIS,
    PACE,
    DIAG,  # how many they are
    *_,
) = range(99)
IRON_DIAG = DIAG  # where `hard_iron` is in use, its columns follow

# verdicts of the magnetic gates
NO_SAMPLE, NORM_REFUSED, INCLINATION_REFUSED, INNOVATION_REFUSED, USED, PASSED, MOTION_REFUSED = range(7)

LEAST_HORIZONTAL = 0.05
"""A field whose horizontal part is a smaller share of it gives no heading."""

# what a result owes to a gap, after the flags of a row
BRIDGED_OVER = 3.0
