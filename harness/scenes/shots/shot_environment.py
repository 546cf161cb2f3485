"""The Python environment with the libraries that read shots: made when it is first needed, below build/ or in a cache folder.

Needs nothing but Debian's python3 and python3-venv.
"""
import ctypes
import fcntl
import os
import pathlib
import shutil
import signal
import subprocess
import sys

PACKAGES = ["numpy==2.2.6", "usd-core==26.11", "alembic3d==1.8.12.1"]
NAMES = "usd-core, alembic3d and numpy"


class NoEnvironment(Exception):
    """One sentence for the user."""


def folder():
    """Another for other versions, of packages and of Python."""
    root = pathlib.Path(__file__).resolve().parents[3]
    if (root / "CMakePresets.json").exists():
        home = root / "build"
    else:
        cache = os.environ.get("XDG_CACHE_HOME", "")
        home = pathlib.Path(cache if os.path.isabs(cache) else os.path.expanduser("~/.cache")) / "stbvh"
    versions = "-".join(package.partition("==")[2] for package in PACKAGES)
    return home / f"shots-python{sys.version_info.major}.{sys.version_info.minor}-{versions}"


def is_inside():
    return os.path.realpath(sys.prefix) == os.path.realpath(folder())


def end_with_parent():
    """From here on this process does not outlive who started it."""
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)


def run(command, what):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                          preexec_fn=end_with_parent)
    if done.returncode != 0:
        lines = [line.strip() for line in done.stdout.decode(errors="replace").splitlines() if line.strip()]
        errors = [line for line in lines if line.startswith(("ERROR:", "Error:"))] or lines[-1:] or ["it said nothing"]
        raise NoEnvironment(f"{what}: {errors[0].removeprefix('ERROR: ')}")


def make(target):
    partial = target.with_name(target.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)  # of one that was killed
    print(f"stbvh-ab: making the Python environment that reads shots, once (350 MB): {target}", file=sys.stderr, flush=True)
    try:
        run(["/usr/bin/python3", "-m", "venv", str(partial)],
            "the Python environment that reads shots cannot be made (Debian: apt-get install python3-venv)")
        for number, package in enumerate(PACKAGES, 1):
            print(f"stbvh-ab: {package}, {number} of {len(PACKAGES)}", file=sys.stderr, flush=True)
            run([str(partial / "bin/python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input",
                 "--no-deps", "--only-binary", ":all:", "--retries", "1", "--timeout", "20", package],
                f"reading shots needs {NAMES}, and pip cannot install {package} (is there a network?)")
        os.rename(partial, target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def ensure():
    """Path of its interpreter. Made whole or not at all; a second command waits for the first."""
    target = folder()
    python = target / "bin/python"
    if python.exists():
        return str(python)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with open(target.with_name(target.name + ".lock"), "w", encoding="ascii") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not python.exists():
                make(target)
    except OSError as error:
        raise NoEnvironment(f"the Python environment that reads shots cannot be made: {error}") from error
    return str(python)
