"""Steps and modes: what is counted, what is not, and that pieces give the bits of the whole."""

import numpy as np
import pytest

from bematist import stance, steps
from bematist.kernels import stance as stance_kernel
from bematist.kernels import steps as kernel
from bematist.recording import Recording

G = 9.80665


def walk(rate_hz=100.0, pace_hz=1.8, walk_s=30.0, rest_s=5.0, size=2.0, seed=0):
    """A device held flat: rest, walk, rest. Returns the recording and how many periods of the steps the walk has."""
    rng = np.random.default_rng(seed)
    t = np.arange(round((2 * rest_s + walk_s) * rate_hz)) / rate_hz
    on = np.clip(np.minimum(t - rest_s, rest_s + walk_s - t) / 0.2, 0, 1)
    phase = 2 * np.pi * pace_hz * (t - rest_s)
    f = np.stack([0.5 * on * np.sin(phase / 2), 0.5 * on * np.cos(phase), G - size * on * np.cos(phase)], 1)
    w = np.stack([0.2 * on * np.sin(phase), 0 * t, 0.1 * on * np.sin(phase / 2)], 1)
    f += 0.03 * rng.standard_normal(f.shape)
    return Recording(time=t, specific_force=f, angular_rate=w + 0.005 * rng.standard_normal(w.shape)), round(pace_hz * walk_s)


def in_pieces(rows, sizes, parameters=None):
    """Results and events of the kernel fed with pieces of these sizes, again and again."""
    p = parameters or steps.StepParameters()
    S, prm = steps.workspace(), steps.kernel_parameters(p)
    memory = np.zeros(stance_kernel.HEAD_SIZE)
    memory[stance_kernel.HELD : stance_kernel.HELD + 2] = -np.inf
    out, events = steps.results(rows[:, 0], p)
    start = written = piece = 0
    while start < len(rows):
        stop = min(len(rows), start + sizes[piece % len(sizes)])
        columns, flags = stance.filled(memory, rows[start:stop], 0.02)
        written += kernel.run(memory, S, prm, columns, flags, np.empty((3, 0)), np.empty(0), out[start:stop], events[written:])
        start, piece = stop, piece + 1
    return out, events[:written]


@pytest.mark.parametrize("rate_hz", [25.0, 50.0, 100.0, 200.0, 500.0])
@pytest.mark.parametrize("pace_hz", [1.2, 1.8, 2.4])
def test_steps_of_a_regular_walk(rate_hz, pace_hz):
    recording, count = walk(rate_hz, pace_hz)
    found = steps.analyse(recording)
    assert abs(len(found.event_time) - count) <= 1
    assert found.count.sum() == len(found.event_time)
    peaks = 5.0 + (np.arange(count) + 0.5) / pace_hz  # where the vertical acceleration is largest
    inner = found.event_time[4:-2]
    assert np.abs(inner[:, None] - peaks).min(1).max() < 0.03
    assert np.abs(found.event_frequency[8:] - pace_hz).max() < 0.05
    assert np.bincount(found.event_carrying, minlength=5).argmax() == steps.CARRYING.index("texting")
    assert (found.event_confirmed >= found.event_time).all()


def test_pieces_give_the_bits_of_the_whole():
    recording, _ = walk()
    rows = recording.samples()
    rows[700:720, 1] = np.nan
    rows[1500:1510, 4:7] = np.nan
    rows = np.delete(rows, slice(2000, 2100), 0)
    whole = in_pieces(rows, [len(rows)])
    for sizes in ([1], [7, 1, 64], [1000]):
        for a, b in zip(in_pieces(rows, sizes), whole, strict=True):
            np.testing.assert_array_equal(a, b)
    assert len(whole[1]) > 40
