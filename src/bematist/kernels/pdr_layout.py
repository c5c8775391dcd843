"""Where things stand in the flat arrays of the handheld path: workspace, parameters, results, diagnostics, steps."""

# A list of places ends in *_, which takes what is left of 99: nobody counts them.

# The error state, and with it the columns of P: position east and north, relative error of all step lengths, direction of the
# pointing axis against the walking direction, heading of the attitude filter.
WIDTH = 5
E_EAST, E_NORTH, E_SCALE, E_DIRECTION, E_HEADING = range(5)

# workspace W
P = 0
EAST, NORTH, UP, UP_VAR = 25, 26, 27, 28
# the last step: its instant, length, direction, frequency; whether one was counted, and the metres so far
STEP_TIME, LENGTH, DIRECTION_E, DIRECTION_N, FREQUENCY, STEPPED, WALKED = 29, 30, 31, 32, 33, 34, 35
# barometer: pressure at its first sample, time of the last, offset, covariance of height and offset
PRESSURE, PRESSURE_TIME, BARO_KNOWN, OFFSET, P_HEIGHT, P_CROSS, P_OFFSET = 36, 37, 38, 39, 40, 41, 42
# how many attitudes the history holds, and how the device was carried at the last step
COUNT, CARRIED = 44, 45
# height of the steps' peaks, smoothed, and how many steps are in it
SIZE, SIZES = 52, 53
# records of the attitude: time, quaternion, packed covariance; the newest, and the history
R_TIME, R_Q, R_COVARIANCE = 0, 1, 5
SLOT = 11
NOW = 54
RING = NOW + SLOT
SLOTS = 512
SLOT_S = 0.04  # between records of the history, s
WORKSPACE_SIZE = RING + SLOTS * SLOT

# parameters prm
(
    HEIGHT,
    A,
    B,
    C,
    RUNNING_FACTOR,
    TREAD,
    STEP_VAR,
    SCALE_VAR,
    TURN_VAR,
    DIRECTION_VAR,
    DIRECTION_S,
    HEADING_S,
    HEADING_FIXED,  # variance of the heading where the filter tells none, else negative
    SWAY_VAR,
    FLAT_VAR,
    BARO_USE,
    BARO_VAR,
    BARO_WALK,
    CLIMB_PSD,
    TEMPERATURE,
    G,
    GAP_S,
    STEEP,  # sine of the angle from upright within which an axis says nothing
    OFFSET_COS,
    OFFSET_SIN,
    PENDULUM,
    ONSET_VAR,
    *_,
) = range(99)
AXES = ONSET_VAR + 1  # of each way of carrying: the axis ahead (3) and the one to the right (3)
PARAMETERS = AXES + 6 * 5

# columns of the result, as those of the shoe: t p v q, packed covariances of position, velocity, attitude
NAV = 29
# columns of the diagnostics
STEPS, STEP_FREQUENCY, MOTION, CARRYING, PRESSURE_HEIGHT, DIAG = range(6)
# columns of the list of steps
S_TIME, S_COUNTED, S_LENGTH, S_LENGTH_SD, S_FREQUENCY, S_DIRECTION, S_DIRECTION_SD, S_MOTION, S_CARRYING, STEP_ROW = range(10)
