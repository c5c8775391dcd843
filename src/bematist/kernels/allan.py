"""Second differences of a running sum: all that an overlapping Allan variance needs."""

from bematist.kernels.jit import kernel, summing

BLOCK = 2048
"""Second differences made for one averaging time before the next one's turn: what the averaging times share is still in the cache."""


@kernel
def running_sum(values, mean, out):
    """out (n+1,) = sums of the first 0 … n of values (n,), their mean taken off so that the sums stay small."""
    total = 0.0
    out[0] = 0.0
    for i in range(len(values)):
        total += values[i] - mean
        out[i + 1] = total


@summing
def squared_differences(sums, spans, out):
    """out (k,) += for each span m of (k,): the sum over i of (s[i+2m] - 2 s[i+m] + s[i])², s the running sums (n+1,)."""
    n = len(sums)
    for start in range(0, n, BLOCK):
        for k in range(len(spans)):
            m = spans[k]
            count = min(BLOCK, n - 2 * m - start)
            if count > 0:
                left, middle, right = sums[start : start + count], sums[start + m :], sums[start + 2 * m :]
                total = 0.0
                for j in range(count):
                    e = right[j] - 2.0 * middle[j] + left[j]
                    total += e * e
                out[k] += total
