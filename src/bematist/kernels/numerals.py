"""Text as numbers: lines of plain decimals, as loggers write them."""

import math

import numpy as np

from bematist.kernels.jit import inlined, kernel

MINUS, PLUS, NEWLINE, RETURN, QUOTE, ZERO, EXPONENT = 45, 43, 10, 13, 34, 48, 101
LOWER = 32
"""The bit that makes a letter small."""
DIGITS = 18
"""Digits that surely fit into an int64."""
EXACT = 1 << 53
"""Up to here every integer is a double."""
POWER = 22
"""Up to here every power of ten is a double."""


@inlined
def byte(text, at):
    """text[at] for at ≥ 0. Of a signed index numba asks at every access whether it counts from the end: a quarter of the time of it all."""
    return int(text[np.uint64(at)])


@inlined
def digits(text, at, end, number):
    """Append the digits from text[at] on to a number; returns where they end, and the number."""
    while at < end:
        digit = byte(text, at) - ZERO
        if digit < 0 or digit > 9:
            break
        number = 10 * number + digit
        at += 1
    return at, number


@inlined
def numeral(text, at, end, point):
    """The decimal at text[at]: where it ends (-1: it is none, or one that takes more care), and its value.

    Digits and power of ten are exact, so that the one product or quotient of both is the double nearest to the decimal (W. D. Clinger, "How
    to read floating point numbers accurately", 1990).
    """
    negative = byte(text, at) == MINUS
    if negative:
        at += 1
    first = at
    at, number = digits(text, at, end, 0)
    count = at - first
    power = 0
    if at < end and byte(text, at) == point:
        first = at + 1
        at, number = digits(text, first, end, number)
        power = first - at
        count -= power
    if count < 1 or count > DIGITS or number > EXACT:
        return -1, 0.0
    if at < end and byte(text, at) | LOWER == EXPONENT:
        at += 1
        below = at < end and byte(text, at) == MINUS
        if at < end and (byte(text, at) == MINUS or byte(text, at) == PLUS):
            at += 1
        first = at
        at, shift = digits(text, at, end, 0)
        if at == first or at - first > 2:
            return -1, 0.0
        power += -shift if below else shift
    if power < -POWER or power > POWER:
        return -1, 0.0
    scale = 1.0
    for _ in range(abs(power)):
        scale *= 10.0
    value = number / scale if power < 0 else number * scale
    return at, -value if negative else value


@kernel
def rows(text, separator, point, comment, column, out):
    """Read text (uint8), lines of as many cells as `column` has entries, into out (C,n); returns how many lines were read.

    Cell i goes to row column[i] of out, or nowhere where that is negative; an empty cell is NaN. Returns -1 where anything is not plain: a
    cell that is no short decimal, a quotation mark, a line that begins with `comment`, another number of cells, more than n lines.
    """
    at, end, line = 0, len(text), 0
    while at < end:
        if line == out.shape[1] or byte(text, at) == comment:
            return -1
        for i in range(len(column)):
            if i > 0:
                if at == end or byte(text, at) != separator:
                    return -1
                at += 1
            if column[i] < 0:
                while at < end and byte(text, at) != separator and byte(text, at) != NEWLINE:
                    if byte(text, at) == QUOTE:
                        return -1
                    at += 1
            elif at == end or byte(text, at) == separator or byte(text, at) == NEWLINE or byte(text, at) == RETURN:
                out[column[i], line] = math.nan
            else:
                at, out[column[i], line] = numeral(text, at, end, point)
                if at < 0:
                    return -1
        if at < end and byte(text, at) == RETURN:
            at += 1
        if at < end and byte(text, at) != NEWLINE:
            return -1
        at += 1
        line += 1
    return line
