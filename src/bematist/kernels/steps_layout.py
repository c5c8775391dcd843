"""Where things stand in the flat arrays of the step detector: workspace, parameters, results."""

# A list of places ends in *_, which takes what is left of 99: nobody counts them.

CELL_S = 0.04  # everything but the direction up runs on means over cells of this length, whatever the sampling rate
LAGS = 42  # of the autocorrelation, in cells: up to 1.64 s
RING = 64  # cells kept, a power of two; x and rates stand twice, so that the last RING stand in a row
MAX_NEW = 16  # steps that wait for a walk to be confirmed, and thus the most that are counted at once

# workspace S: what `advance` answers
COUNT, FREQUENCY, MOTION, CARRYING, LAST_EVENT = range(5)
# time and the direction up in b
TIME, STARTED, AGE, ORIGIN, CELLS = 5, 6, 7, 8, 9
UP, GRAVITY = 10, 13
PREVIOUS, SUM = 16, 24  # channels of the sample before, and their integrals over the cell under way
V, WX, WY, WZ = range(4)
CHANNELS = 4
# band-pass filters: two states each
HIGH_PASS, BAND_1, BAND_2 = 32, 34, 36
SLOW_W = 38  # 3: slow part of the angular rate
CENTRE = 41  # frequency of the band pass, Hz
BAND = 42  # 3: band-passed values of the last cells, newest first
DEMAND = 45
PEAK_TIME, PEAK_OPEN = 46, 47
# energies over exponential windows
ENERGY, SHORT, RATE_ENERGY = 49, 50, 51
# periodicity
PERIOD, SCORE, STRIDE = 59, 60, 61
# walking
WALKING_NOW, STEP_PERIOD, STEP_SIZE, PENDING_COUNT, NEW = 63, 64, 65, 66, 67
# modes: candidates and since when
MOTION_NEXT, MOTION_SINCE, CARRYING_NEXT, CARRYING_SINCE = 68, 69, 70, 71
HEIGHT, CLIMB, HEIGHT_TIME, HEIGHT_KNOWN = 72, 73, 74, 75
QUIET = 76  # least short-time energy since the last step
FEATURES = 77
(
    FEATURE_FORCE,
    FEATURE_RATE,
    FEATURE_PERIODICITY,
    FEATURE_DEMAND,
    FEATURE_FREQUENCY,
    FEATURE_STRIDE,
    FEATURE_SCREEN,
    FEATURE_TOP,
    FEATURE_CLIMB,
    FEATURE_BAND,
    FEATURE_ACCELERATION,
    FEATURE_SIZE,  # how many they are
    *_,
) = range(99)
PENDING = 96
EVENT = 3  # of each record
EVENT_TIME, EVENT_FREQUENCY, EVENT_SIZE = range(3)
EVENTS = PENDING + EVENT * MAX_NEW
RINGS = EVENTS + EVENT * MAX_NEW
# rings of x, of the three rates, and of the inverse roots of the energies of both; then the correlations
RING_X, RING_W, SCALE_X, SCALE_W = RINGS, RINGS + 2 * RING, RINGS + 8 * RING, RINGS + 9 * RING
CORRELATION_X = RINGS + 10 * RING
CORRELATION_W = CORRELATION_X + LAGS
WORKSPACE_SIZE = CORRELATION_W + LAGS

# parameters prm
(
    G,
    GAP_S,
    LEVEL_S,
    HIGH_PASS_HZ,
    START_HZ,
    SLOWEST_HZ,
    FASTEST_HZ,
    SELECTIVITY,
    STRIDE_SELECTIVITY,
    CORRELATION_DECAY,
    CENTRE_DECAY,
    SHORT_DECAY,
    FEATURE_DECAY,
    GRAVITY_DECAY,
    SLOW_DECAY,
    PERIODIC,
    LEAST_FORCE,
    FIRST_STEPS,
    IRREGULARITY,
    REFRACTORY,
    PAUSE,
    PEAK_SHARE,
    RINGING,
    QUIET_SHARE,
    STRIDE_RATE,
    STRIDE_CORRELATION,
    DWELL_S,
    RUN_HZ,
    RUN_FORCE,
    CLIMB_SPEED,
    CLIMB_LEFT,
    CLIMB_S,
    SWING_RATE,
    SWING_STRIDE,
    POCKET_UPRIGHT,
    SCREEN_UP,
    PHONE_RATE,
    PHONE_TOP,
    PHONE_TOP_MOST,
    PHONE_SCREEN,
    SWING_FASTEST_HZ,
    SWING_FAST_RATE,
    STRIDE_PERIODIC,
    PERIODIC_RATE,
    PERIODIC_MOST,
    SCREEN_AXIS,  # (3)
    _,
    _,
    TOP_AXIS,  # (3)
    _,
    _,
    PARAMETERS,  # how many they are
    *_,
) = range(99)

STATIC, WALKING, RUNNING, STAIRS = 0.0, 1.0, 2.0, 3.0
TEXTING, PHONING, SWINGING, POCKET, BAG = 0.0, 1.0, 2.0, 3.0, 4.0

# columns of the result, then the features
OUT_COUNT, OUT_TIME, OUT_FREQUENCY, OUT_MOTION, OUT_CARRYING, OUT_FEATURES = range(6)
OUT = OUT_FEATURES + FEATURE_SIZE
# columns of the list of events, after those of EVENT
EVENT_CONFIRMED, EVENT_MOTION, EVENT_CARRYING = EVENT, EVENT + 1, EVENT + 2
EVENT_ROW = EVENT + 3
