"""The bead in the lanes. Every function is one that `kernels.lanes.interface` asks for, but for the first two."""

import math
import sys

from kernels.jit import kernel, simd
from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lanes.layout import LANES
from kernels.simd_math import sine_cosine

# Rows of starts; of measures and of counts, in the order in which the model lists them.
ANGLE, ANGLE_RATE, HOOP_RATE, RADIUS, GRAVITY = range(5)
(ANGLE_MIN, ANGLE_MAX, PERIOD, ANGLE_ERROR), (ENDING, STEP_COUNT) = range(4), range(2)
# What a step changes and a block needs back; the present step, what a step reads besides; what a cell remembers.
A, W, TIME, NOW, STEP, HOOP, PULL, HEADING, END = (row * LANES for row in range(9))
A_0, W_0, STEPS, LEAST, GREATEST, FIRST, ERROR, TURNED = (row * LANES for row in range(9, 17))
RETURNED, STEPPING, SIZE = 3 * LANES, 9 * LANES, 17 * LANES


@simd
def acceleration(angle, hoop, pull):
    sine, cosine = sine_cosine(angle)
    return sine * (hoop * cosine - pull)


@simd
def stepped(angle, w, hoop, pull, h):
    k1 = acceleration(angle, hoop, pull)  # Nystroem's method of order 4
    k2 = acceleration(angle + h * (0.5 * w + 0.125 * h * k1), hoop, pull)
    k3 = acceleration(angle + h * (w + 0.5 * h * k2), hoop, pull)
    return angle + h * (w + h * (k1 + 2.0 * k2) / 6.0), w + h * (k1 + 4.0 * k2 + k3) / 6.0


@kernel
def prepared_settings(settings):
    return settings[0], settings[1], settings[2]


@simd
def read_start(cell, lane, starts, run, lanes, measures, counts):
    lanes[A_0 + lane], lanes[W_0 + lane] = starts[ANGLE, cell], starts[ANGLE_RATE, cell]
    lanes[HOOP + lane] = starts[HOOP_RATE, cell] ** 2
    lanes[PULL + lane] = starts[GRAVITY, cell] / starts[RADIUS, cell]
    return True


@kernel
def fill_idle(lane, lanes):
    lanes[A_0 + lane], lanes[W_0 + lane], lanes[HOOP + lane], lanes[PULL + lane] = 0.0, 0.0, 0.0, 1.0


@simd
def prepare(lane, run, lanes):
    own = 0.01 / math.sqrt(lanes[HOOP + lane] + lanes[PULL + lane] + lanes[W_0 + lane] * lanes[W_0 + lane])
    lanes[STEP + lane], lanes[FIRST + lane] = run[1] if run[1] > 0.0 else own, 0.0
    lanes[LEAST + lane] = lanes[GREATEST + lane] = lanes[A_0 + lane]


@simd
def needs_integration(cell, lane, run, lanes, measures, counts):
    return True


@simd
def set_off(lane, run, lanes):
    # the second leg goes backward in time, to the other turning point
    w = -lanes[W_0 + lane] if lanes[FIRST + lane] > 0.0 else lanes[W_0 + lane]
    pulled = acceleration(lanes[A_0 + lane], lanes[HOOP + lane], lanes[PULL + lane])
    lanes[A + lane], lanes[W + lane], lanes[TIME + lane] = lanes[A_0 + lane], w, 0.0
    lanes[NOW + lane], lanes[END + lane] = lanes[STEP + lane], run[0] - 2.0 * lanes[FIRST + lane]
    lanes[HEADING + lane] = math.copysign(1.0, pulled if w == 0.0 else w)


@simd
def advance(lane, run, lanes):
    h, full, heading, end = lanes[NOW + lane], lanes[STEP + lane], lanes[HEADING + lane], lanes[END + lane]
    angle, w = stepped(lanes[A + lane], lanes[W + lane], lanes[HOOP + lane], lanes[PULL + lane], h)
    t = lanes[TIME + lane] + h
    event = (heading * w < 0.0) | (t >= end)
    lanes[A + lane], lanes[W + lane], lanes[TIME + lane] = angle, w, t
    lanes[NOW + lane] = 0.0 if event else full
    return event


@simd
def land(lane, run, lanes):
    angle, w, t = lanes[A + lane], lanes[W + lane], lanes[TIME + lane]
    hoop, pull, angle_0, w_0 = lanes[HOOP + lane], lanes[PULL + lane], lanes[A_0 + lane], lanes[W_0 + lane]
    for _ in range(3):
        h = -w / acceleration(angle, hoop, pull)
        angle, w = stepped(angle, w, hoop, pull, h)
        t += h
    (s, c), (s_0, c_0) = sine_cosine(angle), sine_cosine(angle_0)
    lost = 0.5 * (w - w_0) * (w + w_0) - 0.5 * hoop * (s - s_0) * (s + s_0) - pull * (c - c_0)
    turned = (lanes[HEADING + lane] * lanes[W + lane] < 0.0) & (t <= lanes[END + lane])
    lanes[TURNED + lane], lanes[TIME + lane] = 1.0 if turned else 0.0, t
    lanes[ERROR + lane] = abs(lost / acceleration(angle, hoop, pull)) if turned else math.nan
    lanes[A + lane] = angle if turned else lanes[A + lane]


@simd
def finish_leg(cell, lane, run, lanes, measures, counts):
    angle, turned, before = lanes[A + lane], lanes[TURNED + lane] == 1.0, lanes[FIRST + lane]
    lanes[LEAST + lane] = least = min(lanes[LEAST + lane], angle)
    lanes[GREATEST + lane] = greatest = max(lanes[GREATEST + lane], angle)
    if turned and lanes[W_0 + lane] != 0.0 and before == 0.0:
        lanes[FIRST + lane] = lanes[TIME + lane]
        set_off(lane, run, lanes)
        return True
    measures[ANGLE_MIN, cell], measures[ANGLE_MAX, cell] = least, greatest
    measures[PERIOD, cell] = 2.0 * (before + lanes[TIME + lane]) if turned else math.nan
    measures[ANGLE_ERROR, cell], counts[STEP_COUNT, cell] = lanes[ERROR + lane], int(lanes[STEPS + lane])
    counts[ENDING, cell] = 2 if not turned else 1 if lanes[ERROR + lane] <= run[2] else 3
    return False


LANE_MODEL = LaneModel(
    "bead", sys.modules[__name__], prepared_settings, read_start, fill_idle, prepare, needs_integration, set_off,
    advance, land, finish_leg,
)  # fmt: skip
integrate = bind(LANE_MODEL)
