"""Steps of what moves, at the times of a file: as many as keep straight lines between them near its motion."""
import math

import numpy as np

MOST_STEPS = 4096
ROUNDING = 2.0**-22  # of the largest coordinate: what floats and the library's own arithmetic differ by
LEAST_TIME = 2.0**-100  # from here on floats are as far apart as steps must be
LOOKS = (0.13, 0.31, 0.5, 0.71, 0.89)  # between two times of the file
FEWER_LOOKS = (0.29, 0.58)  # between steps that were added


class Shutter:
    """When the file's times are for rays: the only place that says so. All times are the file's own."""

    def __init__(self, begin, end):
        self.begin, self.end = begin, end

    def is_instant(self):
        return not self.begin < self.end

    def ray_time(self, time):
        fraction = (time - self.begin) / (self.end - self.begin)
        return np.float32(fraction if fraction >= LEAST_TIME else 0)

    def inside(self, times):
        """Those between its ends, each once."""
        return sorted({t for t in times if self.begin < t < self.end})


class AskedShutter:
    """What part of the file's time the user asks for: (begin, end) in seconds, or in frames if there is a rate; None: all.

    A camera that moves is kept in `camera_steps` places.
    """

    def __init__(self, ends, frame_rate, camera_steps):
        self.ends, self.frame_rate, self.camera_steps = ends, frame_rate, camera_steps

    def in_time(self, per_second, per_frame):
        """The ends in the file's time, which goes on by so much in a second, and in a frame of the file's own."""
        if self.ends is None:
            return None
        if self.frame_rate is None:
            return tuple(end * per_second for end in self.ends)
        return tuple(end / self.frame_rate * per_second if self.frame_rate else end * per_frame for end in self.ends)


def just_before(time):
    return math.nextafter(time, -math.inf)


def spans(shutter, changes, state_at):
    """(begin, end, state) where state_at(time), which changes only at `changes`, is the same and not None.

    The ends do not belong to them, but for that of the shutter where nothing changes just there.
    """
    found = []
    for time in [shutter.begin, *shutter.inside(changes)]:
        state = state_at(time)
        if found and found[-1][2] == state:
            continue
        if found:
            found[-1][1] = time
        found.append([time, shutter.end, state])
    if not shutter.is_instant() and state_at(shutter.end) != found[-1][2]:
        found[-1][1] = just_before(shutter.end)
    return [tuple(span) for span in found if span[2] is not None]


def distance(a, b):
    """The largest between vertices; 0 where it is what positions round by."""
    with np.errstate(invalid="ignore", over="ignore"):
        off = np.sqrt(np.sum((a - b) ** 2, axis=1))
        off = off[np.isfinite(off)]  # the others are left out of the scene
        largest = np.max(np.abs(b[np.isfinite(b)]), initial=0.0)
    worst = float(np.max(off, initial=0.0))
    return worst if worst > ROUNDING * largest else 0.0


class Motion:
    """Steps of one mesh while it is there: from `begin` to `end`, at `knots` between, and more where it moves in curves.

    positions(time) are doubles. Where it jumps at a knot there are two steps, one float apart.
    """

    def __init__(self, shutter, begin, end, knots, positions, tolerance):
        self.shutter, self.positions = shutter, positions
        self.deviation = 0.0
        self.times, self.steps = [], []
        if shutter.is_instant() or (not knots and self._is_still(begin, end)):
            self._stand(begin, end)
            return
        knots = [begin, *(t for t in sorted(set(knots)) if begin < t < end), end]
        while len(knots) > MOST_STEPS:
            knots = knots[:-1:2] + [end]
        limit = tolerance
        while not self._fill(knots, limit):
            limit *= 4
        if all(np.array_equal(step, self.steps[0], equal_nan=True) for step in self.steps):
            self._stand(begin, end)

    def _is_still(self, begin, end):
        first = self.positions(begin)
        return all(distance(self.positions(begin + f * (end - begin)), first) == 0 for f in (*LOOKS, 1))

    def _is_whole(self, begin, end):
        return begin <= self.shutter.begin and end >= just_before(self.shutter.end)

    def _stand(self, begin, end):
        at_begin = self.positions(begin).astype(np.float32)
        self.times, self.steps = [], [at_begin]
        if not self.shutter.is_instant() and not self._is_whole(begin, end):
            last = self.shutter.ray_time(end)
            if end < just_before(self.shutter.end):
                last = np.nextafter(last, np.float32(-1))
            self.times, self.steps = [self.shutter.ray_time(begin), last], [at_begin, at_begin]
            self._drop_if_short()

    def _drop_if_short(self):
        """No ray time is in it."""
        if not self.times[0] < self.times[-1]:
            self.times, self.steps = [], []

    def _fill(self, knots, limit):
        """False where there would be too many steps."""
        self.times, self.steps, self.deviation = [], [], 0.0
        after = self.positions(knots[0])
        for i, (a, b) in enumerate(zip(knots, knots[1:])):
            self._add(self.shutter.ray_time(a), after)
            # A spare step for each knot that is left, and for jumps there.
            room = MOST_STEPS - len(self.steps) - (len(knots) - i)
            before = self.positions(just_before(b))
            inner = self._curve(a, b, after, before, limit, room)
            if inner is None:
                return False
            for time, step in inner:
                self._add(self.shutter.ray_time(time), step)
            is_end = i + 2 == len(knots)
            last = self.shutter.ray_time(b)
            if is_end and b < self.shutter.end:  # another mesh is there from here on
                self._add(np.nextafter(last, np.float32(-1)) if b < just_before(self.shutter.end) else last, before)
                break
            after = self.positions(b)
            if distance(before, after) > limit:
                self._add(np.nextafter(last, np.float32(-1)), before)
            if is_end:
                self._add(last, after)
        self._drop_if_short()
        return len(self.steps) <= MOST_STEPS

    def _add(self, time, step):
        """Two at one float are one: the later."""
        step = step.astype(np.float32)
        if self.times and time <= self.times[-1]:
            self.steps[-1] = step
            return
        self.times.append(time)
        self.steps.append(step)

    def _curve(self, a, b, first, last, limit, room):
        """Equidistant steps between; None where `room` is not enough."""
        parts, looks, best, best_worst, best_parts = 1, LOOKS, [], math.inf, 1
        while True:
            times = [a + (b - a) * i / parts for i in range(1, parts)]
            inner = [(time, self.positions(time)) for time in times]
            worst = self._worst([(a, first), *inner, (b, last)], looks)
            # A curve's distance from its chord falls with the square of the chord's length. What falls more slowly is what the
            # library rounds by: usd-core turns by 3e-4 at once near the identity, where quaternions are floats.
            is_noise = parts > 8 and worst > best_worst * best_parts / parts
            if worst < best_worst:
                best, best_worst, best_parts = inner, worst, parts
            if worst <= limit or is_noise:
                self.deviation = max(self.deviation, best_worst)
                return best
            if len(inner) >= max(room, 0):
                return None
            guess = math.ceil(1.02 * parts * math.sqrt(worst / limit))
            parts, looks = min(max(parts + 1, guess), max(room, 0) + 1), FEWER_LOOKS

    def _worst(self, steps, looks):
        return max(distance(p0 + f * (p1 - p0), self.positions(t0 + f * (t1 - t0)))
                   for (t0, p0), (t1, p1) in zip(steps, steps[1:]) for f in looks)
