"""Where things stand in the flat arrays of `hard_iron`: its part of the workspace, of the parameters and of the diagnostics."""

# the state, from a place o of the workspace on: covariance 6x6, three rows for an update, estimated error, field, hard iron, turn
P, W, E, X, B, A = 0, 36, 54, 60, 63, 66
# the block being gathered: sums of A y, A and rate², how many, times of its first and last sample
SUM_Y, SUM_A, SUM_RATE, COUNT, BEGAN, ENDED = 70, 73, 82, 83, 84, 85
# since the last block: its time, s in motion, angle turned; whether there was one; the learned walk, excess over time
LAST, MOVED, ANGLE, KNOWN, EXCESS, OVER_S = range(86, 92)
# what is told: chi-square of b against 0, ln B, NIS of the last block, blocks used, fields begun, whether b is taken out
CHI, LN_B, NIS, USED, BEGUN, APPLIED = range(92, 98)
SIZE = 98

# parameters, from a place p on; FROM (3x3): how b enters the reference that samples are compared with
USE, PRIOR, NOISE, DELAY, TURN, DRIFT, WALK, MEMORY_S, JUMP, BLOCK_S, OWN_WALK, EVIDENCE, LEAST, FROM = range(14)
PARAMETERS = FROM + 9
OFF, WATCH, CORRECT = 0.0, 1.0, 2.0

# columns of the diagnostics, from a place d on: b, its standard deviations, and from TOLD on what is told
IRON, IRON_SD, TOLD, COLUMNS = 0, 3, 6, 12
