"""Numbers as text: rows of fixed decimals for CSV files."""

from bematist.kernels.jit import inlined, kernel

COMMA, POINT, MINUS, NEWLINE, ZERO = 44, 46, 45, 10, 48
EXACT = 2.0**53
CELL = 20
"""Bytes that a cell takes at most: sixteen digits, sign, point, the separator after it."""


@inlined
def put(out, end, number):
    """The last two digits of number before out[end]; returns what remains of it."""
    rest = number // 100
    two = number - 100 * rest
    ten = (two * 103) >> 10  # two // 10 for two < 100
    out[end - 2] = ZERO + ten
    out[end - 1] = ZERO + two - 10 * ten
    return rest


@kernel
def rows(columns, decimals, out):
    """Columns (C,n) as lines of n cells in out (uint8); returns how many bytes were written.

    Column c has decimals[c] digits after the point, an even number. A NaN is an empty cell. Returns -1 where a number has more digits than
    a double: then out holds no meaning. out needs CELL bytes for every cell.
    """
    at = 0
    for k in range(columns.shape[1]):
        for c in range(columns.shape[0]):
            value = columns[c, k]
            places = decimals[c]
            if value == value:
                scale = 1.0
                for _ in range(places >> 1):
                    scale *= 100.0
                scaled = abs(value) * scale + 0.5
                if not scaled < EXACT:
                    return -1
                number = int(scaled)
                if value < 0 and number > 0:
                    out[at] = MINUS
                    at += 1
                length = 1
                while scaled >= 10 * scale:
                    scale *= 10
                    length += 1
                at += length
                if places > 0:
                    end = at + places + 1
                    for _ in range(places >> 1):
                        number = put(out, end, number)
                        end -= 2
                    out[at] = POINT
                end = at
                while length > 1:
                    number = put(out, end, number)
                    end -= 2
                    length -= 2
                if length > 0:
                    out[end - 1] = ZERO + number
                if places > 0:
                    at += places + 1
            out[at] = COMMA
            at += 1
        out[at - 1] = NEWLINE
    return at
