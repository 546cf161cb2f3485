"""From what moves in a file to what is handed over: the same for all kinds of files."""
import bisect

import numpy as np

from handover import ShotProblem
from shot_notes import Notes
from shot_steps import Motion, Shutter, just_before, spans

MOST_MESHES = 1_000_000
MAYAS_VIEWS = ("persp", "front", "side", "top")  # in every file of its, beside the cameras that somebody made
GREY = (0.7, 0.7, 0.7, 0, 0, 0)  # reflectance and emission


class Item:
    """One mesh of a shot, instances apart. What a reader derives from it says:

    - name; moves_without_velocities: whether its faces change and nothing says how its points move;
    - change_times(): when faces and visibility may change; state(time): equal for equal faces, None where it is not seen;
    - faces(time): Faces, wound counterclockwise seen from outside;
    - times(): when its motion may bend; positions(time): in world space, doubles; material(): six numbers.
    """


def find_shutter(asked, items, file_range):
    """All in the file's time: `asked`, or the range that the file names, or else all of its samples."""
    if asked is not None:
        if not asked[0] < asked[1]:
            raise ShotProblem(f"has no time for a shutter from {asked[0]} to {asked[1]}")
        return Shutter(*asked)
    if file_range is not None:
        return Shutter(*file_range)
    times = [time for item in items for time in (*item.times(), *item.change_times())]
    return Shutter(min(times, default=0.0), max(times, default=0.0))


def tried(notes, items, work):
    """What `work` returns for each of `items`; one that it fails for is left out and noted."""
    for item in items:
        try:
            yield item, work(item)
        except MemoryError:
            raise
        except ShotProblem as problem:
            notes.add(f"left out, for it {problem}", item.name)
        except Exception as error:  # whatever a library throws over one primitive
            notes.add(f"left out ({type(error).__name__}: {' '.join(str(error).split())[:200]})", item.name)


def shown_parts(item, shutter):
    """(begin, end, faces) while its faces are the same and it is seen; positions are asked for up to just before the end."""
    parts = [(begin, end, item.faces(begin)) for begin, end, _ in spans(shutter, item.change_times(), item.state)]
    return [part for part in parts if part[2].vertex_count() > 0]


def checked_positions(item, count):
    """Those that faces need: files may have more."""
    def positions(time):
        found = item.positions(time)
        if len(found) < count:
            raise ShotProblem(f"has {len(found)} points, and a face with corner {count - 1}")
        return found[:count]
    return positions


def diagonal(items, shutter):
    """Of what is seen as the shutter opens, in its middle and as it closes; less than that of all times."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)

    def extend(item):
        for time in sorted({shutter.begin, (shutter.begin + shutter.end) / 2, just_before(shutter.end)}):
            if item.state(time) is None:
                continue
            points = item.positions(time)
            points = points[np.all(np.abs(points) < 1.8e18, axis=1)]
            np.minimum(low, points.min(axis=0, initial=np.inf), out=low)
            np.maximum(high, points.max(axis=0, initial=-np.inf), out=high)

    for _ in tried(Notes(), items, extend):  # what is wrong is noted when it is written
        pass
    size = float(np.linalg.norm(high - low)) if np.all(low <= high) else 0.0
    return size if size > 0 else 1.0


def write_items(out, notes, items, shutter, share):
    if len(items) > MOST_MESHES:
        raise ShotProblem(f"has {len(items)} meshes and instances, more than {MOST_MESHES}")
    tolerance = share * diagonal(items, shutter)

    def write(item):
        deviation = 0.0
        times = sorted(set(item.times()))
        parts = shown_parts(item, shutter)
        for begin, end, faces in parts:
            positions = checked_positions(item, faces.vertex_count())
            knots = times[bisect.bisect_right(times, begin):bisect.bisect_left(times, end)]
            motion = Motion(shutter, begin, end, knots, positions, tolerance)
            deviation = max(deviation, motion.deviation)
            if motion.steps:
                out.mesh(item.name, faces, item.material(), motion.times, motion.steps)
        if len(parts) > 1 and item.moves_without_velocities:
            notes.add("stands still between samples, as its faces change and it has no velocities", item.name)
        return deviation

    for item, deviation in tried(notes, items, write):
        if deviation > tolerance:
            share_off = deviation / tolerance * share
            notes.add(f"up to {share_off:.2g} of the diagonal from its motion, and more steps cannot be had or do not help",
                      item.name)


def chosen_first(cameras, path_of):
    """As they are, but Maya's own views come last: three of them see what is there from a hundred units away."""
    def rank(camera):
        name = path_of(camera).rpartition("/")[2].removesuffix("Shape")
        return MAYAS_VIEWS.index(name) + 1 if name in MAYAS_VIEWS else 0

    return sorted(cameras, key=rank)


def write_camera(out, shutter, steps, view_at):
    """In `steps` places. view_at(time): (position, target, up, vertical degrees)."""
    times = [shutter.begin] if shutter.is_instant() else np.linspace(shutter.begin, shutter.end, steps)
    out.camera([[*position, *target, *up, fov] for position, target, up, fov in (view_at(float(t)) for t in times)])
