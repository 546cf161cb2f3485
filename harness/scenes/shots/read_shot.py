#!/usr/bin/env python3
"""Reads a USD or Alembic file and hands over what is in it (handover.py): stbvh-ab runs this.

Usage: read_shot.py FILE DESCRIPTOR [--shutter A,B [--frame-rate R]] [--deviation E] [--camera-steps N]
DESCRIPTOR is the number of an open file. The shutter is in seconds, or in frames, R to a second (0: as the file has them); the
deviation is a share of the scene's diagonal.
Whatever is wrong is handed over too, so the exit code is 0 but where the process is ended.
"""
import argparse
import mmap
import os
import resource
import signal
import sys

import shot_environment

MOST_SECONDS = 3600  # of the processor: some malformed files keep a library busy for ever
MOST_MEMORY = min(64 << 30, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
ROOM = (1 << 30) + (os.cpu_count() or 1) * (128 << 20)  # address space of the libraries and their threads: with less they crash
NO_MEMORY = "needs more memory than there is"


def options():
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.add_argument("descriptor", type=int)
    parser.add_argument("--shutter", type=lambda text: tuple(float(word) for word in text.split(",")))
    parser.add_argument("--frame-rate", type=float)
    parser.add_argument("--camera-steps", type=int, default=129)
    parser.add_argument("--deviation", type=float, default=1e-6)
    return parser.parse_args()


def enter_environment():
    """Starts again in the environment."""
    python = shot_environment.ensure()
    os.execv(python, [python, "-B", "-E", "-s", *sys.argv])


def limit_process():
    """Libraries crash and print: the one line about it is the program's."""
    for kind, most in ((resource.RLIMIT_CORE, 0), (resource.RLIMIT_CPU, MOST_SECONDS), (resource.RLIMIT_DATA, MOST_MEMORY)):
        own = resource.getrlimit(kind)[1]  # which cannot be raised
        limit = most if own == resource.RLIM_INFINITY else min(most, own)
        resource.setrlimit(kind, (limit, limit))
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nothing, descriptor)


def say_problem(descriptor, text):
    """Without numpy, which may be what is missing."""
    sentence = " ".join(text.split()).encode("utf-8", "replace")
    os.write(descriptor, b"STBVSHT1" + (6).to_bytes(4, "little") + bytes(4) + len(sentence).to_bytes(8, "little") + sentence)


def described(problem):
    """In words of our own where a library says that it got no memory."""
    return NO_MEMORY if "bad_alloc" in str(problem) else str(problem)


def has_room():
    try:
        mmap.mmap(-1, ROOM, mmap.MAP_PRIVATE, mmap.PROT_READ).close()
        return True
    except OSError:
        return False


def read(asked):
    if not has_room():
        say_problem(asked.descriptor, NO_MEMORY)
        return
    try:
        asked.file.encode()
    except UnicodeEncodeError:
        say_problem(asked.descriptor, "has a name that is not UTF-8, which the libraries do not take")
        return
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import handover  # they need the environment
    import shot_steps
    out = handover.Handover(asked.descriptor)
    try:
        if asked.file.lower().endswith(".abc"):
            import alembic_shot as reader
        else:
            import usd_shot as reader
        shutter = shot_steps.AskedShutter(asked.shutter, asked.frame_rate, asked.camera_steps)
        reader.read(asked.file, out, shutter, asked.deviation)
        out.end()
    except handover.ShotProblem as problem:
        out.text(handover.PROBLEM, described(problem))
    except MemoryError:
        out.text(handover.PROBLEM, NO_MEMORY)
    except Exception as error:  # whatever a library throws is one line for the user
        out.text(handover.PROBLEM, described(f"cannot be read: {type(error).__name__}: {str(error).strip()[:400]}"))


def main():
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
    shot_environment.end_with_parent()
    asked = options()
    if not shot_environment.is_inside():
        try:
            enter_environment()
        except shot_environment.NoEnvironment as problem:
            say_problem(asked.descriptor, "cannot be read: " + str(problem))
            return
    limit_process()
    read(asked)


if __name__ == "__main__":
    main()
